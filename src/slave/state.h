/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a slave consists of. Here only so that a caller can allocate one and look at the few members that say "public";
 * all others are the stack's and may change.
 */
#ifndef ECT_SLAVE_STATE_H
#define ECT_SLAVE_STATE_H

#include "slave/config.h"

/* The structures below begin with their smallest members: those are used most, and a Thumb instruction reaches only the
 * first 32 bytes of a structure, 62 for 16 bits, 124 for 32, without a longer encoding. So a slave begins with the
 * bytes that it uses most, and then has those of the mailbox. */

/** Mailbox of a slave. Private. */
typedef struct ect_mailbox {
    bool running;
    uint8_t open;            /* what is not done yet, bits of mailbox.c */
    bool repeated;           /* `shown` stands there because of a repeat */
    bool toggle;             /* the repeat toggle as the master set it last, and as we acknowledge it */
    uint8_t newest;          /* which of `mail` was built last */
    uint8_t shown;           /* which of them is, or was last, in SM1 */
    uint8_t mails;           /* how many of them hold a mail: 0..2; one: `newest` does */
    uint8_t reply;           /* which holds the reply to the last request, 0xFF none */
    bool request_waits;      /* a request came and could not be looked at yet */
    uint8_t wakes;           /* counts modulo 256: a protocol has a mail of its own */
    uint8_t heard;           /* ... up to here all have been asked until they had none */
    uint8_t request_counter; /* of the last request, 0: none yet */
    uint8_t reply_counter;   /* of our last mail */
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
    bool pad;        /* the pad byte after sub-index 0 comes next */
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
    ect_span_t instead; /* what the device supplies in place of the entry */
} ect_sdo_t;

enum { ECT_SDO_IDLE, ECT_SDO_UPLOADING, ECT_SDO_DOWNLOADING };

/** The SDO information list under way. Private. */
typedef struct ect_sdo_info {
    uint16_t list;      /* 1..5, 0: none */
    uint16_t next;      /* position in the object list */
    uint16_t fragments; /* still to send */
    bool started;       /* the first one is out */
} ect_sdo_info_t;

enum { ECT_EMERGENCY_QUEUE = 8 /* a power of two */ };

typedef struct ect_emergency {
    uint16_t code;
    uint8_t error_register;
    uint8_t data[5];
} ect_emergency_t;

/** The process data of a SyncManager, as they are mapped. Private. */
typedef struct ect_sm_image {
    uint16_t bytes;
    uint16_t first_run;
    uint16_t runs;
} ect_sm_image_t;

/** One slave. Allocate it anywhere, initialise with ::ect_slave_init; members are private unless said otherwise. */
typedef struct ect_slave {
    uint8_t state;        /**< public, read only: AL state, 1 2 3 4 8 */
    uint8_t outputs;      /* SyncManagers with outputs, a bit each; set on the way to SAFEOP */
    bool failed;          /* a PDI access of this poll, or of this exchange, failed */
    uint8_t pending;      /* state that a delayed transition leads to, 0: none */
    uint8_t sm_due;       /* those whose PDI control register has yet to be written */
    bool status_dirty;    /* AL status has to be written */
    bool outputs_live;    /* they are being handed to the device */
    uint8_t inputs;       /* those with inputs */
    uint8_t outputs_seen; /* those of `outputs` that the master has written since SAFEOP */
    bool inputs_due;
    bool error; /**< public, read only: error flag of AL status */
    bool pending_done;
    uint8_t sm_off;     /* SyncManagers that are to be off from the PDI side, a bit each */
    bool sm_repeat_ack; /* the repeat bit that SM1's PDI control shows */
    bool ident;         /* identification value stands in the status code */
    volatile bool held; /* mainline is in a step */
    ect_mailbox_t mailbox;
    uint8_t cause;          /**< public, read only: ect_error_cause_t */
    bool pending_device;    /* the device delays it; else it waits for outputs */
    bool request_due;       /* AL control has yet to be carried out: new, or its PDI accesses failed */
    uint8_t drop_state;     /* wanted by the device, 0: none */
    bool restart;           /**< public, read only: the device wants a power cycle: see ::ect_host_t::restart */
    bool off_bus;           /**< public, read only: the device wants to be off the bus */
    uint8_t outputs_silent; /* those of `outputs` that raise no event when they are written */
    bool woken;             /* the device's own time is due, whatever tick_ns says */
    volatile bool missed;   /* an exchange came meanwhile */
    uint8_t emergency_put;  /* counts modulo 256: queued, by the device */
    uint8_t emergency_got;  /* ... and sent */
    uint8_t sync0_runs;     /* the object service of the synchronisation has something to watch */
    uint16_t line;    /* AL event mask as written last, without its upper half: no ESC has more than 8 SyncManagers */
    uint16_t code;    /**< public, read only: AL status code */
    uint16_t request; /* AL control as read last */
    uint16_t pending_result;
    uint16_t drop_code;
    uint32_t due; /* AL events whose registers have yet to be read */
    ect_sdo_t sdo;
    ect_slave_config_t config;
    uint64_t now_ns;
    ect_od_t od;
    ect_sm_image_t image[ECT_SMS];
    ect_sdo_info_t info;
    uint64_t tick_ns;
    uint64_t pending_until_ns;
    void (*later)(struct ect_slave *s); /* what a service wants done at the end of a poll; NULL: nothing */
    ect_host_t host;
    uint32_t pdi_errors;       /**< public, read only: failed PDI accesses */
    uint32_t emergencies_lost; /**< public, read only */
    ect_emergency_t emergency[ECT_EMERGENCY_QUEUE];
} ect_slave_t;

#endif
