/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Interface between the files of slave/. No file outside slave/ includes this header.
 *
 * The files from the lowest to the highest; each knows only those above it in this list (tests/check/order.py):
 *
 *   al.c         the decision table (pure)
 *   access.c     the PDI
 *   services.c   the object services that the device names
 *   host.c       requests of the device: recorded, executed later
 *   syncman.c    SyncManagers: comparison with the description, on and off
 *   pdo.c        process image: mapping, outputs, inputs
 *   rhythm.c     the rhythm of the bus, for the device
 *   cycle.c      the cyclic exchange, from an interrupt or from the poll
 *   mailbox.c    counters, repeat, error replies, dispatch to the protocols that the device names
 *   coe.c        the CoE header
 *   sdo.c sdo_info.c emergency.c foe.c eoe.c soe.c aoe.c     protocols, linked when a device names them
 *   local.c      the dictionary, for the program that runs the slave
 *   pdo_config.c diagnosis.c store.c sync.c      object services, likewise
 *   machine.c    AL control, the checks of the transitions, watchdog, drops
 *   slave.c      initialisation and the poll: the sequence of all steps
 *   memory.c     memory that a slave needs
 *   indicator.c  LEDs
 */
#ifndef ECT_SLAVE_INTERNAL_H
#define ECT_SLAVE_INTERNAL_H

#include "slave/service.h"
#include "slave/slave.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* --- access.c: false after a failed access of this poll, without a further access -----------------------------------
 */
bool ect_slave_read(ect_slave_t *s, unsigned int address, void *buffer, unsigned int length);
bool ect_slave_write(ect_slave_t *s, unsigned int address, const void *buffer, unsigned int length);
/* The AL event word; the first access after a failure clears the failure. */
bool ect_slave_read_event(ect_slave_t *s, uint32_t *event);

/* --- services.c: the object services that the device names (slave/service.h) -------------------------------------- */
void ect_services_start(ect_slave_t *s);
ect_reason_t ect_services_write(ect_slave_t *s, const ect_download_t *d);
ect_reason_t ect_services_written(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete);
uint16_t ect_services_check_up(ect_slave_t *s, uint8_t target);
void ect_services_event(ect_slave_t *s, uint32_t event);
/* The data structure of a service: the memory of entry `index`:1; NULL: the device has no such object. */
static inline void *ect_services_data(const ect_slave_t *s, uint16_t index)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *entry = NULL;
    return ect_od_lookup(&s->od, index, 1, &object, &entry) == ECT_OK ? ect_od_data(&s->od, entry) : NULL;
}

/* --- host.c ----------------------------------------------------------------------------------------------------- */
/* The functions of ect_host_t, which object services use too. */
void ect_host_drop(void *slave, uint8_t state, uint16_t al_status_code);
void ect_host_emergency(void *slave, uint16_t code, uint8_t error_register, const uint8_t data[5]);
/* A request of the master is about to be executed; the device may replace its description. */
static inline void ect_slave_requested(ect_slave_t *s, uint16_t index)
{
    if (s->config.device->requested)
        s->config.device->requested(s->config.instance, index);
}
/* Fills in the table that the device gets. */
void ect_host_init(ect_slave_t *s);

/* --- syncman.c -------------------------------------------------------------------------------------------------- */
/* SyncManagers are given as masks, one bit each. */
enum { ECT_SM_BLOCK = ECT_SMS * ECT_SM_SIZE, ECT_MAILBOX_SMS = 0x03 };

static inline uint16_t ect_sm_longest_mailbox(const ect_device_t *device, unsigned int sm)
{
    return device->sm[sm].maximum != 0 ? device->sm[sm].maximum : device->sm[sm].length;
}
/* Greatest length of a SyncManager; for process data without a maximum the sum of all PDOs of its default. */
uint16_t ect_sm_room(const ect_device_t *device, unsigned int sm);
/* The events of SyncManagers. */
static inline uint32_t ect_sm_events(unsigned int sms)
{
    return (uint32_t)sms * ECT_EVENT_SM0;
}
/* Reads all SyncManagers at once, which also acknowledges their change. */
bool ect_sm_read(ect_slave_t *s, uint8_t block[ECT_SM_BLOCK]);
/* Whether the mailbox SyncManagers are as described, for BOOT or for the other states. */
bool ect_sm_mailbox_good(const ect_device_t *device, const uint8_t *block, bool boot);
/* Checks that the process-data SyncManagers have exactly the mapped bytes, or are off. @return 0, or the AL status
 * code */
uint16_t ect_sm_check_process(const ect_slave_t *s, const uint8_t *block);
/* The SyncManagers with process data. */
unsigned int ect_sm_process(const ect_device_t *device);
/* Records which SyncManagers are to be on or off from the PDI side, and the acknowledge of SM1's repeat toggle ... */
void ect_sm_disable(ect_slave_t *s, unsigned int sms);
void ect_sm_enable(ect_slave_t *s, unsigned int sms);
void ect_sm_acknowledge_repeat(ect_slave_t *s, bool toggle);
/* ... and this writes both to the ESC. */
bool ect_sm_flush(ect_slave_t *s);

/* --- pdo.c ------------------------------------------------------------------------------------------------------ */
/* Lays the images out. @return 0, or the AL status code of the direction that is impossible */
uint16_t ect_pdo_configure(ect_slave_t *s);
/* Number of runs of the mapping of SyncManager `sm`, which must be constant. */
uint16_t ect_pdo_count_runs(const ect_device_t *device, unsigned int sm);
/* @return written outputs whose SyncManagers raise no event. */
unsigned int ect_pdo_written(ect_slave_t *s);
/* Takes the outputs of the written SyncManagers. */
void ect_pdo_outputs(ect_slave_t *s, unsigned int sms, bool apply);
bool ect_pdo_inputs(ect_slave_t *s);

/* --- cycle.c: the cyclic exchange, and how mainline keeps it out while it works ----------------------------------- */
void ect_cycle_outputs(ect_slave_t *s, uint32_t event);
void ect_cycle_inputs(ect_slave_t *s);
/* Mainline holds the exchange while it works on data that the exchange, or a function of the device, uses too. */
void ect_cycle_hold(ect_slave_t *s);
/* Executes a held exchange; called between two steps. */
void ect_cycle_yield(ect_slave_t *s);
/* Executes a held exchange, and permits the exchange from now on. */
void ect_cycle_release(ect_slave_t *s);

/* --- mailbox.c (and seams/mailbox.h) ------------------------------------------------------------------------------ */
enum { ECT_MAILBOX_HEADER = 6 };

/* Room that a mailbox SyncManager may need, in PREOP or in BOOT, bytes. */
uint16_t ect_mailbox_sm_room(const ect_device_t *device, unsigned int sm);
/* Takes over the layout that the master chose; ect_mailbox_start then starts the mailbox. */
void ect_mailbox_configure(ect_slave_t *s, const uint8_t *sm_registers);
void ect_mailbox_start(ect_slave_t *s);
static inline void ect_mailbox_stop(ect_slave_t *s)
{
    s->mailbox.running = false;
}
void ect_mailbox_poll(ect_slave_t *s, uint32_t event);
/* Whether a mail waits until the master has fetched the one in SM1. */
bool ect_mailbox_waits(ect_slave_t *s);
/* Reads from the SyncManagers the repeat toggle, and whether SM1 still holds our mail. @return whether their layout is
 * still that of the start */
bool ect_mailbox_check(ect_slave_t *s, const uint8_t *sm_registers);

/* --- coe.c ------------------------------------------------------------------------------------------------------ */
enum {
    ECT_COE_HEADER = 2,
    ECT_COE_MAIL_EMERGENCY = 1,
    ECT_COE_MAIL_SDO_REQUEST = 2,
    ECT_COE_MAIL_SDO_RESPONSE = 3,
    ECT_COE_MAIL_SDO_INFO = 8,
    ECT_SDO_LENGTH = 10, /* of the smallest SDO mail: CoE header and 8 bytes */
};

/* @return 0: the mail is of this kind; else the detail of the mailbox error. */
uint16_t ect_coe_expect(const uint8_t *data, uint16_t length, uint8_t kind);
/* Starts a CoE mail of a kind. @return its payload */
uint8_t *ect_coe_build(ect_slave_t *s, uint8_t kind);
/* Room for payload in a CoE mail, bytes. */
uint16_t ect_coe_room(const ect_slave_t *s);
/* Sends the mail: `length` includes the CoE header. */
void ect_coe_send(ect_slave_t *s, uint16_t length);

/* --- sdo.c: the dictionary in one piece, for aoe.c and local.c; a transfer of CoE under way continues ------------ */
enum { ECT_SDO_COMPLETE = 0x0100 /* Complete Access, in a place: index << 16, sub-index in bits 0..7 */ };
/* Reads the first `*length` bytes of an entry or object to `to`, which is all 0. @return ECT_OK, and `*length`: all its
 * bytes */
ect_reason_t ect_sdo_read_all(ect_slave_t *s, uint32_t place, uint8_t *to, uint32_t *length);
/* Writes one; not while a download in segments is under way. */
ect_reason_t ect_sdo_write_all(ect_slave_t *s, uint32_t place, const uint8_t *data, uint16_t length);

/* --- machine.c -------------------------------------------------------------------------------------------------- */
void ect_machine_al_control(ect_slave_t *s);
void ect_machine_request(ect_slave_t *s);
void ect_machine_sm_changed(ect_slave_t *s);
void ect_machine_watchdog(ect_slave_t *s);
void ect_machine_pending(ect_slave_t *s);
void ect_machine_drop(ect_slave_t *s, uint8_t state, uint16_t code, ect_error_cause_t cause);
bool ect_machine_report(ect_slave_t *s);

#endif
