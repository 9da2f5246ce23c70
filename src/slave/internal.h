/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the files of slave/ know of each other. Nobody else includes this.
 *
 *   slave.c     initialisation and the poll: the order in which things are done
 *   memory.c    how much memory a slave needs
 *   machine.c   AL control, the checks of the transitions, watchdog, drops
 *   al.c        the decision table (pure)
 *   pdo.c       process image: mapping, outputs, inputs
 *   mailbox.c   counters, repeat, error replies, dispatch to the services
 *   coe.c       CoE header, emergencies, dispatch to SDO and SDO information
 *   sdo.c       SDO server
 *   sdo_info.c  SDO information
 *   pdo_config.c diagnosis.c store.c sync.c   object services, linked when a device names them
 */
#ifndef ECT_SLAVE_INTERNAL_H
#define ECT_SLAVE_INTERNAL_H

#include "slave/slave.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* --- PDI: false once an access of this poll has failed; nothing further is tried then -------------------------- */
bool ect_slave_read(ect_slave_t *s, uint16_t address, void *buffer, uint16_t length);
bool ect_slave_write(ect_slave_t *s, uint16_t address, const void *buffer, uint16_t length);

/* --- object services (seams/services.h): every member may be NULL ------------------------------------------------- */
struct ect_service {
    /* Power-on, after the device was initialised. */
    void (*start)(ect_slave_t *s);
    /* A value is about to be stored; a reason refuses it. */
    ect_reason_t (*write)(ect_slave_t *s, uint16_t index, uint8_t subindex, const uint8_t *data, uint16_t size);
    /* It is stored; a whole object by Complete Access: once, as sub-index 0. A reason tells the master that what had to
     * follow from it failed. */
    ect_reason_t (*written)(ect_slave_t *s, uint16_t index, uint8_t subindex);
    /* A transition upwards has passed the other checks; a code refuses it. */
    uint16_t (*check_up)(ect_slave_t *s, uint8_t target);
    /* Events have come in SAFEOP or OP. */
    void (*event)(ect_slave_t *s, uint32_t event);
};

ect_reason_t ect_services_write(ect_slave_t *s, uint16_t index, uint8_t subindex, const uint8_t *data, uint16_t size);
ect_reason_t ect_services_written(ect_slave_t *s, uint16_t index, uint8_t subindex);
uint16_t ect_services_check_up(ect_slave_t *s, uint8_t target);

/* --- machine.c -------------------------------------------------------------------------------------------------- */
void ect_machine_al_control(ect_slave_t *s);
void ect_machine_request(ect_slave_t *s);
void ect_machine_sm_changed(ect_slave_t *s);
void ect_machine_watchdog(ect_slave_t *s);
void ect_machine_pending(ect_slave_t *s);
void ect_machine_drop(ect_slave_t *s, uint8_t state, uint16_t code, ect_error_cause_t cause);
bool ect_machine_report(ect_slave_t *s);
/* SyncManagers are given as masks, a bit each. */
enum { ECT_MAILBOX_SMS = 0x03 };
void ect_machine_sm_off(ect_slave_t *s, unsigned int sms, bool off);
bool ect_machine_flush(ect_slave_t *s);
/* Outputs go to their safe values, if they were live. */
void ect_machine_outputs_off(ect_slave_t *s);

/* --- pdo.c ------------------------------------------------------------------------------------------------------ */
uint16_t ect_pdo_configure(ect_slave_t *s);
/* Runs that the mapping of SyncManager `sm` falls into, where it is a constant one. */
uint16_t ect_pdo_count_runs(const ect_device_t *device, unsigned int sm);
/* The longest that a SyncManager may become. */
static inline uint16_t ect_sm_room(const ect_device_t *device, unsigned int sm)
{
    return device->sm[sm].maximum != 0 ? device->sm[sm].maximum : ect_device_sm_bytes(device, sm);
}
/* The events of SyncManagers. */
static inline uint32_t ect_sm_events(unsigned int sms)
{
    return (uint32_t)sms * ECT_EVENT_SM0;
}
/* Takes the outputs of those SyncManagers that were written. */
void ect_pdo_outputs(ect_slave_t *s, unsigned int sms, bool apply);
bool ect_pdo_inputs(ect_slave_t *s);

/* --- mailbox.c -------------------------------------------------------------------------------------------------- */
enum {
    ECT_MAILBOX_HEADER = 6,
    ECT_MAILBOX_TYPE_ERROR = 0,
    ECT_MAILBOX_TYPE_COE = 3,

    ECT_MAILBOX_ERROR_SYNTAX = 1,
    ECT_MAILBOX_ERROR_PROTOCOL = 2,
    ECT_MAILBOX_ERROR_CHANNEL = 3,
    ECT_MAILBOX_ERROR_SERVICE = 4,
    ECT_MAILBOX_ERROR_HEADER = 5,
    ECT_MAILBOX_ERROR_TOO_SHORT = 6,
    ECT_MAILBOX_ERROR_SIZE = 8,
};

/* The room that a mailbox SyncManager may need, in PREOP or in BOOT. */
uint16_t ect_mailbox_room(const ect_device_t *device, unsigned int sm);
/* Takes the layout that the master chose; the mailbox runs from ect_mailbox_start on. */
void ect_mailbox_configure(ect_slave_t *s, const uint8_t *sm_registers);
void ect_mailbox_start(ect_slave_t *s);
static inline void ect_mailbox_stop(ect_slave_t *s)
{
    s->mailbox.running = false;
}
void ect_mailbox_poll(ect_slave_t *s, uint32_t event);
/* What the SyncManagers show while the mailbox runs: the repeat toggle, and whether our mail still stands there. */
void ect_mailbox_look(ect_slave_t *s, const uint8_t *sm_registers);
/* Where the next mail is built, zeroed, `in_size` bytes; only while a service handles a request or sends. */
uint8_t *ect_mailbox_build(ect_slave_t *s);
/* Sends what was built: `length` bytes follow the header. */
void ect_mailbox_send(ect_slave_t *s, uint8_t type, uint16_t length);
void ect_mailbox_error(ect_slave_t *s, uint16_t detail);

/* --- coe.c ------------------------------------------------------------------------------------------------------ */
enum {
    ECT_COE_HEADER = 2,
    ECT_COE_SERVICE_EMERGENCY = 1,
    ECT_COE_SERVICE_SDO_REQUEST = 2,
    ECT_COE_SERVICE_SDO_RESPONSE = 3,
    ECT_COE_SERVICE_SDO_INFO = 8,
    ECT_SDO_LENGTH = 10, /* of the smallest SDO mail: CoE header and 8 bytes */
};

static inline void ect_coe_start(ect_slave_t *s)
{
    s->sdo.state = ECT_SDO_IDLE;
    s->info.list = 0;
}
void ect_coe_request(ect_slave_t *s, const uint8_t *payload, uint16_t length);
static inline bool ect_coe_has_emergency(const ect_slave_t *s)
{
    return s->emergency_count > 0;
}
void ect_coe_send_emergency(ect_slave_t *s);
void ect_coe_emergency(void *slave, uint16_t code, uint8_t error_register, const uint8_t data[5]);
/* Begins a CoE mail of a service; returns where its payload starts. */
uint8_t *ect_coe_build(ect_slave_t *s, uint8_t service);
/* Sends it: `length` counts the CoE header too. */
void ect_coe_send(ect_slave_t *s, uint16_t length);

/* --- sdo.c, sdo_info.c: `request` begins behind the CoE header -------------------------------------------------- */
void ect_sdo_request(ect_slave_t *s, const uint8_t *request, uint16_t length);
void ect_sdo_info_request(ect_slave_t *s, const uint8_t *request, uint16_t length);
/* A list is under way: its next fragment may be sent. */
static inline bool ect_sdo_info_has_more(const ect_slave_t *s)
{
    return s->info.list != 0;
}
void ect_sdo_info_fragment(ect_slave_t *s);

#endif
