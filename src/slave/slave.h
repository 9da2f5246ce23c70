/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The slave stack: everything that an EtherCAT slave's software does between an ESC and a device.
 *
 * One ::ect_slave_t drives one device behind one PDI. It owns no memory: the caller hands in buffers whose sizes
 * follow from the description (::ect_slave_memory), and keeps them, the description and the PDI alive as long as the
 * slave. Nothing allocates, blocks beyond the PDI's own accesses, or reads a clock.
 *
 * Use: ::ect_slave_init once, then ::ect_slave_poll whenever the ESC signals an event or the time that the last call
 * returned has come. Polling more often costs one PDI access and changes nothing.
 *
 * Context: mainline, one call at a time for an instance; instances are independent.
 *
 * PDI accesses: idle poll 1; a cyclic exchange (outputs in, inputs out) 3; an expedited SDO 5 over two polls; a
 * state change 4..9.
 *
 * When the PDI fails, the present step is abandoned and taken up again at the next poll; ::ect_slave_t::pdi_errors
 * counts. AL status never claims a state whose preconditions were not established.
 *
 * Clauses: ETG.1000.6 §5 (CoE), §6 (state machine); ETG.1000.4 §5.6 (mailbox).
 */
#ifndef ECT_SLAVE_SLAVE_H
#define ECT_SLAVE_SLAVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "od/od.h"
#include "seams/device.h"
#include "seams/pdi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Where an error in AL status comes from; what the ERR indicator shows (ETG.1300). */
typedef enum ect_error_cause {
    ECT_CAUSE_NONE,
    ECT_CAUSE_REQUEST,  /**< a request of the master was refused: invalid configuration */
    ECT_CAUSE_LOCAL,    /**< the slave left the state on its own account */
    ECT_CAUSE_WATCHDOG, /**< the process-data watchdog made it */
} ect_error_cause_t;

/** A piece of a process image that is contiguous in it and in the instance. Private. */
typedef struct ect_pdo_run {
    const ect_entry_t *entry; /**< copied through the dictionary, or NULL: plain bytes at `data` */
    uint8_t *data;
    uint16_t first_bit;
    uint16_t bits;
} ect_pdo_run_t;

/** The process data of a SyncManager, as they are mapped. Private. */
typedef struct ect_sm_image {
    uint16_t bytes;
    uint16_t first_run;
    uint16_t runs;
} ect_sm_image_t;

/** How much memory a device needs; see ::ect_slave_config_t for what each is for. */
typedef struct ect_slave_memory {
    size_t instance;     /**< bytes, aligned as by malloc */
    size_t mailbox;      /**< bytes */
    size_t process_data; /**< bytes */
    size_t runs;         /**< elements of ect_pdo_run_t */
    size_t staging;      /**< bytes */
    size_t buffer;       /**< bytes */
} ect_slave_memory_t;

/**
 * Computes it from the description; where a master may change the mapping, for whatever it may come to. Pure.
 */
ect_slave_memory_t ect_slave_memory(const ect_device_t *device);

/** What a slave is made of. Checked once by ::ect_slave_init. */
typedef struct ect_slave_config {
    const ect_device_t *device;
    const ect_pdi_t *pdi;
    const ect_identity_t *identity; /**< NULL: the description's */
    const ect_storage_t *storage;   /**< NULL: none */
    void *instance;                 /**< ect_slave_memory().instance bytes; the stack zeroes them at power-on ... */
    size_t outside_offset;          /**< ... but for these: what stands outside the device (plant.h) ... */
    size_t outside_size;            /**< ... so many bytes; 0: nothing */
    uint8_t *mailbox;               /**< ... mailbox bytes: one request, two replies; NULL without a mailbox */
    uint8_t *process_data;          /**< ... process_data bytes; NULL without process data */
    uint16_t process_size;          /**< how many there are */
    ect_pdo_run_t *runs;            /**< ... runs elements */
    uint16_t run_count;             /**< how many there are */
    uint8_t *staging; /**< ... staging bytes: where an SDO value that comes in pieces is collected until it is whole */
    uint16_t staging_size; /**< how many there are; a longer value is refused as out of memory */
    void *
        buffer; /**< ... buffer bytes, zeroed like the instance: what ect_host_t::buffer gives the device; NULL: none */
    uint16_t device_id; /**< explicit device identification (AL control bit 5); 0: not offered */
    uint16_t switches;  /**< setting of the address switches: becomes the configured station alias (0x0012)
                             and takes the place of `device_id`; 0: the alias is that of the SII */
    /**
     * What the interrupt line of the ESC is for. false: for everything that the stack deals with, each event while
     * there is something to do about it. true: for process data and SYNC0 alone, and drives ::ect_slave_cycle; mainline
     * then learns of the others by reading the register, whatever ect_pdi_t::al_event says.
     */
    bool line_for_cycle;
} ect_slave_config_t;

/* The structures below begin with their smallest members: those are used most, and a Thumb instruction reaches only the
 * first 32 bytes of a structure, 62 for 16 bits, 124 for 32, without a longer encoding. */

/** Mailbox of a slave. Private. */
typedef struct ect_mailbox {
    bool running;
    bool to_write;           /* `shown` has yet to be written to SM1 */
    bool in_buffer;          /* `shown` stands in SM1, unread as far as we know */
    bool repeated;           /* `shown` stands there because of a repeat */
    bool newest_waits;       /* after a repeat: `newest` must follow `shown` */
    bool repeat_due;         /* the master wants the last mail again */
    bool ack_due;            /* ... and it is to be acknowledged once that mail stands in SM1 */
    bool toggle;             /* the repeat toggle as the master set it last, and as we acknowledge it */
    uint8_t newest;          /* which of `mail` was built last */
    uint8_t shown;           /* which of them is, or was last, in SM1 */
    uint8_t mails;           /* how many of them hold a mail: 0..2 */
    uint8_t reply;           /* which holds the reply to the last request, 0xFF none */
    bool request_waits;      /* a request came and could not be looked at yet */
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

/** One slave. Allocate it anywhere, initialise with ::ect_slave_init; members are private unless said otherwise. */
typedef struct ect_slave {
    uint8_t state;       /**< public, read only: AL state, 1 2 3 4 8 */
    bool error;          /**< public, read only: error flag of AL status */
    uint8_t cause;       /**< public, read only: ect_error_cause_t */
    bool status_dirty;   /* AL status has to be written */
    bool ident;          /* identification value stands in the status code */
    uint8_t pending;     /* state that a delayed transition leads to, 0: none */
    bool pending_device; /* the device delays it; else it waits for outputs */
    bool pending_done;
    bool request_due;     /* AL control has yet to be carried out: new, or its PDI accesses failed */
    uint8_t drop_state;   /* wanted by the device, 0: none */
    bool restart;         /**< public, read only: the device wants a power cycle: see ::ect_host_t::restart */
    bool off_bus;         /**< public, read only: the device wants to be off the bus */
    uint8_t sm_off;       /* SyncManagers that are to be off from the PDI side, a bit each */
    uint8_t sm_due;       /* those whose PDI control register has yet to be written */
    uint8_t outputs;      /* SyncManagers with outputs, a bit each; set on the way to SAFEOP */
    uint8_t inputs;       /* those with inputs */
    uint8_t outputs_seen; /* those of `outputs` that the master has written since SAFEOP */
    bool outputs_live;    /* they are being handed to the device */
    bool inputs_due;
    bool woken;            /* the device's own time is due, whatever tick_ns says */
    volatile bool held;    /* mainline is in a step */
    bool failed;           /* a PDI access of this poll, or of this exchange, failed */
    volatile bool missed;  /* an exchange came meanwhile */
    uint8_t emergency_put; /* counts modulo 256: queued, by the device */
    uint8_t emergency_got; /* ... and sent */
    bool sm_repeat_ack;    /* the repeat bit that SM1's PDI control shows */
    uint16_t line;    /* AL event mask as written last, without its upper half: no ESC has more than 8 SyncManagers */
    uint16_t code;    /**< public, read only: AL status code */
    uint16_t request; /* AL control as read last */
    uint16_t pending_result;
    uint16_t drop_code;
    uint32_t due; /* AL events whose registers have yet to be read */
    ect_sdo_t sdo;
    ect_slave_config_t config;
    ect_mailbox_t mailbox;
    uint64_t now_ns;
    ect_od_t od;
    ect_sm_image_t image[ECT_SMS];
    ect_sdo_info_t info;
    uint64_t tick_ns;
    uint64_t pending_until_ns;
    ect_host_t host;
    uint32_t pdi_errors;       /**< public, read only: failed PDI accesses */
    uint32_t emergencies_lost; /**< public, read only */
    ect_emergency_t emergency[ECT_EMERGENCY_QUEUE];
} ect_slave_t;

/**
 * Power-on: initialises the device, switches all SyncManagers off from the PDI side, reports INIT.
 * The description must be one that `ect_device_check` (check/check.h) accepts.
 * @return 0 · -1 device or PDI missing · -2 a buffer missing that ::ect_slave_memory asks for · -3 the PDI failed.
 *         Unless 0, the slave must not be used.
 */
int ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns);

/** The device's own time is due at the next poll, whatever it said last: something about it was changed from outside.
 */
static inline void ect_slave_wake(ect_slave_t *slave)
{
    slave->woken = true;
}

/**
 * Does what is to be done: AL control, SyncManager changes, watchdog, process data, one mailbox request, the device's
 * own time.
 * @return when to call again even without an event (> now_ns), ECT_NEVER when only the bus can bring work.
 */
uint64_t ect_slave_poll(ect_slave_t *slave, uint64_t now_ns);

/** As ::ect_slave_poll but for process data, which ::ect_slave_cycle exchanges. */
uint64_t ect_slave_mainline(ect_slave_t *slave, uint64_t now_ns);

/** Outputs in, inputs out. May interrupt everything but itself. */
void ect_slave_cycle(ect_slave_t *slave, uint64_t now_ns);
ECT_C_END

#endif
