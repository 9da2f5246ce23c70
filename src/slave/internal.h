/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the files of slave/ know of each other. Nobody else includes this.
 *
 * From the lowest to the highest; each knows only those above it in this list (tests/check/order.py):
 *
 *   al.c         the decision table (pure)
 *   access.c     the PDI
 *   services.c   the object services that the device names
 *   host.c       what the device asks for: notes that are acted on later
 *   syncman.c    SyncManagers: as described? on or off?
 *   pdo.c        process image: mapping, outputs, inputs
 *   cycle.c      the cyclic exchange, from an interrupt or from the poll
 *   mailbox.c    counters, repeat, error replies, dispatch to the protocols that the device names
 *   coe.c        the CoE header
 *   sdo.c sdo_info.c emergency.c foe.c           protocols, linked when a device names them
 *   pdo_config.c diagnosis.c store.c sync.c      object services, likewise
 *   machine.c    AL control, the checks of the transitions, watchdog, drops
 *   slave.c      initialisation and the poll: the order in which things are done
 *   memory.c     how much memory a slave needs
 *   indicator.c  lamps
 */
#ifndef ECT_SLAVE_INTERNAL_H
#define ECT_SLAVE_INTERNAL_H

#include "slave/service.h"
#include "slave/slave.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* --- access.c: false once an access of this poll has failed; nothing further is tried then ---------------------- */
bool ect_slave_read(ect_slave_t *s, unsigned int address, void *buffer, unsigned int length);
bool ect_slave_write(ect_slave_t *s, unsigned int address, const void *buffer, unsigned int length);
/* The AL event word; begins anew after a failure. */
bool ect_slave_read_event(ect_slave_t *s, uint32_t *event);

/* --- services.c: the object services that the device names (slave/service.h) -------------------------------------- */
void ect_services_start(ect_slave_t *s);
ect_reason_t ect_services_write(ect_slave_t *s, const ect_download_t *d);
ect_reason_t ect_services_written(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete);
uint16_t ect_services_check_up(ect_slave_t *s, uint8_t target);
void ect_services_event(ect_slave_t *s, uint32_t event);
/* The data structure of a service: where the entry `index`:1 has its value; NULL: the device has no such object. */
static inline void *ect_services_data(const ect_slave_t *s, uint16_t index)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *entry = NULL;
    return ect_od_lookup(&s->od, index, 1, &object, &entry) == ECT_OK ? ect_od_data(&s->od, entry) : NULL;
}

/* --- host.c ----------------------------------------------------------------------------------------------------- */
/* What ect_host_t offers, for object services too. */
void ect_host_drop(void *slave, uint8_t state, uint16_t al_status_code);
void ect_host_emergency(void *slave, uint16_t code, uint8_t error_register, const uint8_t data[5]);
/* Fills in the table that the device is given. */
void ect_host_init(ect_slave_t *s);

/* --- syncman.c -------------------------------------------------------------------------------------------------- */
/* SyncManagers are given as masks, a bit each. */
enum { ECT_SM_BLOCK = ECT_SMS * ECT_SM_SIZE, ECT_MAILBOX_SMS = 0x03 };

static inline uint16_t ect_sm_longest_mailbox(const ect_device_t *device, unsigned int sm)
{
    return device->sm[sm].maximum != 0 ? device->sm[sm].maximum : device->sm[sm].length;
}
/* The longest that a SyncManager may become; for process data without a maximum it adds up all PDOs of its default. */
uint16_t ect_sm_room(const ect_device_t *device, unsigned int sm);
/* The events of SyncManagers. */
static inline uint32_t ect_sm_events(unsigned int sms)
{
    return (uint32_t)sms * ECT_EVENT_SM0;
}
/* Reads all SyncManagers at once, which also acknowledges that they changed. */
bool ect_sm_read(ect_slave_t *s, uint8_t block[ECT_SM_BLOCK]);
/* The mailbox SyncManagers are as described, for BOOT or for the other states. */
bool ect_sm_mailbox_good(const ect_device_t *device, const uint8_t *block, bool boot);
/* Those of the process data have exactly the mapped bytes, or are off: 0, or the AL status code. */
uint16_t ect_sm_check_process(const ect_slave_t *s, const uint8_t *block);
/* Those with process data. */
unsigned int ect_sm_process(const ect_device_t *device);
/* Take note which SyncManagers are to be on or off from our side, and how SM1 answers the repeat toggle ... */
void ect_sm_disable(ect_slave_t *s, unsigned int sms);
void ect_sm_enable(ect_slave_t *s, unsigned int sms);
void ect_sm_acknowledge_repeat(ect_slave_t *s, bool toggle);
/* ... and this writes it. */
bool ect_sm_flush(ect_slave_t *s);

/* --- pdo.c ------------------------------------------------------------------------------------------------------ */
/* Lays the images out: 0, or the AL status code that says which cannot be. */
uint16_t ect_pdo_configure(ect_slave_t *s);
/* Runs that the mapping of SyncManager `sm` falls into, where it is a constant one. */
uint16_t ect_pdo_count_runs(const ect_device_t *device, unsigned int sm);
/* Outputs that were written and whose SyncManagers raise no event. */
unsigned int ect_pdo_written(ect_slave_t *s);
/* Takes the outputs of those SyncManagers that were written. */
void ect_pdo_outputs(ect_slave_t *s, unsigned int sms, bool apply);
bool ect_pdo_inputs(ect_slave_t *s);

/* --- cycle.c: the cyclic exchange, and how mainline keeps it out while it works ----------------------------------- */
void ect_cycle_outputs(ect_slave_t *s, uint32_t event);
void ect_cycle_inputs(ect_slave_t *s);
/* Mainline holds while it works on what the exchange, or a function of the device, touches too. */
void ect_cycle_hold(ect_slave_t *s);
/* Between two steps: an exchange that came meanwhile is made up for. */
void ect_cycle_yield(ect_slave_t *s);
/* The same, and lets it in from now on. */
void ect_cycle_release(ect_slave_t *s);

/* --- mailbox.c (and seams/mailbox.h) ------------------------------------------------------------------------------ */
enum { ECT_MAILBOX_HEADER = 6 };

/* The room that a mailbox SyncManager may need, in PREOP or in BOOT. */
uint16_t ect_mailbox_sm_room(const ect_device_t *device, unsigned int sm);
/* Takes the layout that the master chose; the mailbox runs from ect_mailbox_start on. */
void ect_mailbox_configure(ect_slave_t *s, const uint8_t *sm_registers);
void ect_mailbox_start(ect_slave_t *s);
static inline void ect_mailbox_stop(ect_slave_t *s)
{
    s->mailbox.running = false;
}
void ect_mailbox_poll(ect_slave_t *s, uint32_t event);
/* Something waits until the master has fetched the mail that stands in SM1. */
bool ect_mailbox_waits(ect_slave_t *s);
/* What the SyncManagers show while the mailbox runs: the repeat toggle, and whether our mail still stands there.
 * Returns whether they are still those that it was started with. */
bool ect_mailbox_look(ect_slave_t *s, const uint8_t *sm_registers);

/* --- coe.c ------------------------------------------------------------------------------------------------------ */
enum {
    ECT_COE_HEADER = 2,
    ECT_COE_MAIL_EMERGENCY = 1,
    ECT_COE_MAIL_SDO_REQUEST = 2,
    ECT_COE_MAIL_SDO_RESPONSE = 3,
    ECT_COE_MAIL_SDO_INFO = 8,
    ECT_SDO_LENGTH = 10, /* of the smallest SDO mail: CoE header and 8 bytes */
};

/* Whether a mail is one of this kind: 0, or the detail of the error. */
uint16_t ect_coe_expect(const uint8_t *data, uint16_t length, uint8_t kind);
/* Begins a CoE mail of a kind; returns where its payload starts. */
uint8_t *ect_coe_build(ect_slave_t *s, uint8_t kind);
/* Bytes of payload that a CoE mail has room for. */
uint16_t ect_coe_room(const ect_slave_t *s);
/* Sends it: `length` counts the CoE header too. */
void ect_coe_send(ect_slave_t *s, uint16_t length);

/* --- machine.c -------------------------------------------------------------------------------------------------- */
void ect_machine_al_control(ect_slave_t *s);
void ect_machine_request(ect_slave_t *s);
void ect_machine_sm_changed(ect_slave_t *s);
void ect_machine_watchdog(ect_slave_t *s);
void ect_machine_pending(ect_slave_t *s);
void ect_machine_drop(ect_slave_t *s, uint8_t state, uint16_t code, ect_error_cause_t cause);
bool ect_machine_report(ect_slave_t *s);

#endif
