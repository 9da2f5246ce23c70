/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The state of a slave. It is defined here so that a caller can allocate a slave and read the few members that are
 * marked "public"; all others are private to the stack and may change.
 */
#ifndef ECT_SLAVE_STATE_H
#define ECT_SLAVE_STATE_H

#include "slave/config.h"

/* The structures below begin with their smallest members, which are used most: without a longer encoding, a Thumb
 * instruction reaches only the first 32 bytes of a structure, 62 for 16 bits, 124 for 32. A slave therefore begins
 * with its most used bytes, followed by those of the mailbox. */

/** Mailbox of a slave. Private. */
typedef struct ect_mailbox {
    bool running;
    uint8_t open;            /* work that is not done yet, bits of mailbox.c */
    bool repeated;           /* `shown` is in SM1 because of a repeat request */
    bool toggle;             /* the repeat toggle as the master set it last, and as the slave acknowledges it */
    uint8_t newest;          /* index of the `mail` that was built last */
    uint8_t shown;           /* index of the one that is, or was last, in SM1 */
    uint8_t mails;           /* number of valid mails: 0..2; one: `newest` */
    uint8_t reply;           /* index of the reply to the last request, 0xFF: none */
    bool request_waits;      /* a request has arrived and is not handled yet */
    bool announced;          /* a protocol may have a mail since all were called until they had none */
    uint8_t request_counter; /* of the last request, 0: none yet */
    uint8_t reply_counter;   /* of the last mail sent */
    uint16_t out_start;      /* SM0 */
    uint16_t out_size;
    uint16_t in_start; /* SM1 */
    uint16_t in_size;
    uint8_t *request;
    uint8_t *mail[2];
} ect_mailbox_t;

/** Position in the packed form of an object (Complete Access) or of one entry. Private. */
typedef struct ect_sdo_cursor {
    const ect_entry_t *entry; /* NULL: at the end */
    uint32_t bits;            /* bits gathered in `byte` */
    uint32_t byte;
    uint16_t offset; /* inside the entry, bytes */
    bool pad;        /* the next byte is the pad byte after sub-index 0 */
} ect_sdo_cursor_t;

/** The one SDO transfer that can be under way. Private. */
typedef struct ect_sdo {
    uint8_t state; /* 0 idle, 1 uploading, 2 downloading */
    uint8_t subindex;
    bool complete;
    uint8_t toggle;
    const ect_object_t *object;
    uint32_t size;
    uint32_t done;
    ect_sdo_cursor_t cursor;
    ect_span_t instead; /* bytes supplied by the device in place of the entry */
} ect_sdo_t;

enum { ECT_SDO_IDLE, ECT_SDO_UPLOADING, ECT_SDO_DOWNLOADING };

/** The SDO information list under way. Private. */
typedef struct ect_sdo_info {
    uint16_t list;      /* 1..5, 0: none */
    uint16_t next;      /* position in the object list */
    uint16_t fragments; /* still to send */
    bool started;       /* the first fragment has been sent */
} ect_sdo_info_t;

enum { ECT_EMERGENCY_QUEUE = 8 /* a power of two */ };

typedef struct ect_emergency {
    uint16_t code;
    uint8_t error_register;
    uint8_t data[5];
} ect_emergency_t;

/** The mapped process data of a SyncManager. Private. */
typedef struct ect_sm_image {
    uint16_t bytes;
    uint16_t first_run;
    uint16_t runs;
} ect_sm_image_t;

/** One slave. Allocate it anywhere, initialise it with ::ect_slave_init. Members are private unless marked public. */
typedef struct ect_slave {
    uint8_t state;        /**< public, read only: AL state, 1 2 3 4 8 */
    uint8_t outputs;      /* SyncManagers with outputs, one bit each; set on the way to SAFEOP */
    bool failed;          /* a PDI access of this poll, or of this exchange, failed */
    uint8_t pending;      /* target state of a delayed transition, 0: none */
    uint8_t sm_due;       /* SyncManagers whose PDI control register must be written */
    bool status_dirty;    /* AL status must be written */
    bool outputs_live;    /* the device gets the outputs */
    uint8_t inputs;       /* SyncManagers with inputs */
    uint8_t outputs_seen; /* subset of `outputs` that the master has written since SAFEOP */
    bool inputs_due;
    bool inputs_held; /* ect_slave_hold_inputs() */
    bool error;       /**< public, read only: error flag of AL status */
    bool pending_done;
    uint8_t sm_off;     /* SyncManagers that are to be off from the PDI side, one bit each */
    bool sm_repeat_ack; /* the repeat bit in SM1's PDI control */
    bool ident;         /* the status code holds the identification value */
    volatile bool held; /* mainline is in a step */
    ect_mailbox_t mailbox;
    uint8_t cause;          /**< public, read only: ect_error_cause_t */
    bool pending_device;    /* the device delays the transition; otherwise it waits for outputs */
    bool request_due;       /* AL control must be executed: new, or its PDI accesses failed */
    uint8_t drop_state;     /* state requested by the device, 0: none */
    bool restart;           /**< public, read only: the device requests a power cycle, see ::ect_host_t::restart */
    bool off_bus;           /**< public, read only: the device requests to be off the bus */
    uint8_t outputs_silent; /* subset of `outputs` that raise no event when they are written */
    bool woken;             /* the device's own time is due, regardless of tick_ns */
    volatile bool missed;   /* an exchange was held */
    uint8_t emergency_put;  /**< public, read only: counter modulo 256 of emergencies queued by the device */
    uint8_t emergency_got;  /* ... and of those sent */
    uint8_t sync0_runs;     /* the synchronisation service monitors SYNC0 or outputs */
    uint16_t line;          /* AL event mask as written last, lower half: no ESC has more than 8 SyncManagers */
    uint16_t code;          /**< public, read only: AL status code */
    uint16_t request;       /* AL control as read last */
    uint16_t pending_result;
    uint16_t drop_code;
    uint32_t due;  /* AL events whose registers must be read */
    ect_sdo_t sdo; /* here short instructions of a Cortex-M reach it: 64 bytes of text less */
    ect_slave_config_t config;
    uint64_t now_ns;
    uint64_t tick_ns;
    void (*later)(struct ect_slave *s); /* action of a service at the end of a poll; NULL: none */
    ect_sm_image_t image[ECT_SMS];
    uint64_t pending_until_ns;
    ect_od_t od;
    ect_sdo_info_t info;
    ect_host_t host;
    uint32_t pdi_errors;                            /**< public, read only: failed PDI accesses */
    uint32_t emergencies_lost;                      /**< public, read only */
    ect_emergency_t emergency[ECT_EMERGENCY_QUEUE]; /**< public, read only: emergency N is at N % ECT_EMERGENCY_QUEUE */
} ect_slave_t;

#endif
