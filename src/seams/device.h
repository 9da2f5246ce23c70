/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Device: one constant description of a product, and the few functions that are its behaviour.
 *
 * Everything that a master can learn about a device comes from this description: the running slave, the SII image,
 * the ESI file and the dictionary document are all read from it, and nothing is written twice. The behaviour works on
 * an instance structure that the caller owns; the description and all it points to is constant and shared.
 *
 * A device knows neither the ESC nor the stack nor a clock: process data reaches it through the data of its
 * dictionary entries, time is an argument (nanoseconds of any monotonic clock, 64 bit), and what it wants from its
 * surroundings it asks of ::ect_host_t.
 *
 * All functions run in mainline, one at a time for an instance, must not block, and may not call back into the stack
 * except through ::ect_host_t. Any function pointer may be NULL: the device then has nothing to do there.
 */
#ifndef ECT_SEAMS_DEVICE_H
#define ECT_SEAMS_DEVICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "od/od.h"
#include "seams/al_status.h"
#include "seams/services.h"
#include "seams/storage.h"

/** AL states (ETG.1000.6 §6.4.1). */
enum {
    ECT_STATE_INIT = 0x01,
    ECT_STATE_PREOP = 0x02,
    ECT_STATE_BOOT = 0x03,
    ECT_STATE_SAFEOP = 0x04,
    ECT_STATE_OP = 0x08,
};

/** Mailbox protocols, as in SII word 0x1C. */
enum {
    ECT_MAILBOX_AOE = 0x01,
    ECT_MAILBOX_EOE = 0x02,
    ECT_MAILBOX_COE = 0x04,
    ECT_MAILBOX_FOE = 0x08,
    ECT_MAILBOX_SOE = 0x10,
    ECT_MAILBOX_VOE = 0x20,
};

/** CoE details, as in byte 5 of the SII category General. */
enum {
    ECT_COE_SDO = 0x01,
    ECT_COE_SDO_INFO = 0x02,
    ECT_COE_PDO_ASSIGN = 0x04,
    ECT_COE_PDO_CONFIG = 0x08,
    ECT_COE_PDO_UPLOAD = 0x10,
    ECT_COE_COMPLETE_ACCESS = 0x20,
};

/** Role of a SyncManager, as in 1C00h and the SII category SyncM. */
enum {
    ECT_SM_UNUSED = 0,
    ECT_SM_MAILBOX_OUT = 1,
    ECT_SM_MAILBOX_IN = 2,
    ECT_SM_OUTPUTS = 3,
    ECT_SM_INPUTS = 4,
};

/** Role of an FMMU, as in the SII category FMMU. */
enum { ECT_FMMU_UNUSED = 0, ECT_FMMU_OUTPUTS = 1, ECT_FMMU_INPUTS = 2, ECT_FMMU_MAILBOX_STATE = 3 };

/** A deadline that never comes: what ::ect_device_t::tick returns when only the bus can wake the device. */
#define ECT_NEVER UINT64_MAX

/** Who the device says it is: SII words 8..15 and object 1018h. */
typedef struct ect_identity {
    uint32_t vendor_id;
    uint32_t product_code;
    uint32_t revision;
    uint32_t serial;
} ect_identity_t;

/** One SyncManager of the layout. SM0/SM1 are the mailboxes, SM2 outputs, SM3 inputs; the array index is the number. */
typedef struct ect_sm {
    uint16_t start;   /**< ESC address */
    uint16_t length;  /**< bytes; for process data 0: the sum of the assigned PDOs */
    uint16_t minimum; /**< mailboxes: smallest length a master may choose; 0: exactly `length` */
    uint16_t maximum; /**< mailboxes: largest one, and the room that the stack's buffers must have */
    uint8_t control;  /**< control register: 0x26, 0x22, 0x64 (watchdog), 0x20 ... */
    uint8_t type;     /**< ECT_SM_... */
} ect_sm_t;

/** A mailbox of the BOOT state, SII words 0x14..0x17. */
typedef struct ect_boot_mailbox {
    uint16_t start;
    uint16_t length;
} ect_boot_mailbox_t;

/** A mode of the distributed clocks, SII category DC and ESI `<OpMode>`. */
typedef struct ect_dc_mode {
    const char *name;
    const char *description;
    uint16_t assign_activate; /**< 0 free run or SM-synchronous, 0x0300 SYNC0 */
    uint32_t cycle_sync0_ns;  /**< 0: the bus cycle */
} ect_dc_mode_t;

/** How long the device may take for a transition, milliseconds (ESI `<Timeout>`). */
typedef struct ect_timeouts {
    uint16_t preop_ms;
    uint16_t safeop_op_ms;
    uint16_t back_to_init_ms;
    uint16_t back_to_safeop_ms;
} ect_timeouts_t;

/** Synchronisation abilities, 1C32h/1C33h. All zero: free run only. */
typedef struct ect_sync {
    uint16_t supported;           /**< 1C32h:4: bit 0 free run, bit 1 SM event, bit 2 DC SYNC0 */
    uint32_t minimum_cycle_ns;    /**< 1C32h:5; 0 no lower bound */
    const uint32_t *dc_cycles_ns; /**< the SYNC0 cycles that are accepted, or NULL: all from minimum_cycle_ns */
    uint8_t dc_cycle_count;
} ect_sync_t;

/**
 * What a device may ask of its surroundings. Given to ::ect_device_t::init, valid as long as the instance. Calls are
 * cheap: they take note, the stack acts at its next poll.
 */
typedef struct ect_host {
    void *ctx;

    /** Queues a CoE emergency (ETG.1000.6 §5.6.4). Lost, and counted, when the queue is full. data: 5 bytes, copied. */
    void (*emergency)(void *ctx, uint16_t error_code, uint8_t error_register, const uint8_t data[5]);

    /**
     * Leaves the present AL state on the device's own account: to `state`, which must be a lower one, with error
     * flag and AL status code (ETG.1000.6 §6.4.1.4). Ignored when the slave is not above that state.
     */
    void (*drop)(void *ctx, uint8_t state, uint16_t al_status_code);

    /** Finishes a transition that ::ect_device_t::state_change delayed; 0, or the code with which it failed. */
    void (*transition_done)(void *ctx, uint16_t al_status_code);

    /**
     * Adds a message to the diagnosis history 10F3h: ECT_DIAGNOSIS_INFO/WARNING/ERROR, diagnosis code, text id of the
     * device's texts, two parameters of 16 bits. NULL unless the description names ect_service_diagnosis.
     */
    void (*diagnose)(void *ctx, uint8_t type, uint32_t code, uint16_t text_id, const uint16_t parameters[2]);

    /** Takes the slave off the bus, as if its ports were unplugged, or puts it back. */
    void (*off_bus)(void *ctx, bool off);

    /**
     * Wants a power cycle, of controller, stack and device. Whoever drives the slave does it after the present poll (a
     * firmware resets its processor): the instance is zeroed but for what stands outside (plant.h), and initialised
     * anew.
     */
    void (*restart)(void *ctx);

    /** Non-volatile memory, or NULL when this installation has none. */
    const ect_storage_t *storage;
} ect_host_t;

/** Returned by ::ect_device_t::state_change to delay the answer until ::ect_host_t::transition_done. */
#define ECT_AL_PENDING 0xFFFFu

/** The description of a product. */
typedef struct ect_device {
    /* --- who it is ------------------------------------------------------------------------------------------- */
    const char *name;       /**< command-line name: lower case, digits, hyphen */
    const char *summary;    /**< one line for `ectwin list` */
    const char *type_name;  /**< 1008h, ESI `<Type>` and SII name; at most 40 characters */
    const char *group_type; /**< ESI and SII group */
    const char *group_name;
    const char *hardware_version; /**< 1009h */
    const char *software_version; /**< 100Ah */
    ect_identity_t identity;      /**< default; an installation may override it */

    /* --- the controller and its layout ----------------------------------------------------------------------- */
    const char *esc;        /**< personality of the ESC: "np40", "et1100", "lan9252" */
    uint8_t esc_config[14]; /**< SII words 0..6, ESI ConfigData */
    uint16_t sii_size;      /**< bytes of the EEPROM: a multiple of 128 */
    ect_sm_t sm[4];
    uint8_t sm_count;
    uint8_t fmmu[4]; /**< ECT_FMMU_... */
    uint8_t fmmu_count;
    ect_boot_mailbox_t boot_out; /**< length 0: no BOOT state */
    ect_boot_mailbox_t boot_in;
    uint8_t mailbox_protocols; /**< ECT_MAILBOX_... */
    uint8_t coe_details;       /**< ECT_COE_... */
    const char *physics;       /**< ESI `Physics`, a letter a port: "YY" */
    const ect_dc_mode_t *dc_modes;
    uint8_t dc_mode_count;
    ect_sync_t sync;
    ect_timeouts_t timeouts;

    /* --- what it offers -------------------------------------------------------------------------------------- */
    const ect_object_t *objects;
    uint16_t object_count;
    const ect_limit_t *limits;
    uint16_t limit_count;
    const ect_service_t *const *services; /**< NULL-terminated list of the object services it needs; NULL: none */

    /* --- how it behaves -------------------------------------------------------------------------------------- */
    size_t instance_size; /**< bytes of instance memory that the caller provides, aligned as by malloc */
    uint16_t pdo_runs;    /**< contiguous pieces that its largest process image falls into, both directions */

    /**
     * Power-on: brings instance memory, zeroed but for what outlasts it (plant.h), to its start values.
     * @param identity, host  valid as long as the instance; the device keeps the pointers or copies the values
     */
    void (*init)(void *instance, const ect_identity_t *identity, const ect_host_t *host, uint64_t now_ns);

    /**
     * A transition upwards is about to be confirmed, or one downwards has happened. A transition upwards may be asked
     * about more than once, when the PDI failed on the way.
     * @return 0 · ECT_AL_PENDING · an AL status code that refuses it (upwards only; ignored downwards)
     */
    uint16_t (*state_change)(void *instance, uint8_t from, uint8_t to, uint64_t now_ns);

    /** Output data of the dictionary was renewed by the master. Only in OP. */
    void (*outputs)(void *instance, uint64_t now_ns);

    /** Outputs must go to their safe values: OP was left, whatever the cause. */
    void (*safe_outputs)(void *instance, uint64_t now_ns);

    /** Input data of the dictionary is about to be sent: bring it up to date. SAFEOP and OP. */
    void (*inputs)(void *instance, uint64_t now_ns);

    /**
     * The device's own time. Called once after init, then at or after the time that the last call returned, and soon
     * after outputs, a lower state, an SDO write or a signal was told to the device.
     * @return when to call again (> now_ns), or ECT_NEVER.
     */
    uint64_t (*tick)(void *instance, uint64_t now_ns);

    /** A master is about to read an object by SDO: bring data that is kept for such readers up to date. */
    void (*sdo_read)(void *instance, uint16_t index);

    /**
     * A master wants to write an entry; rights, length and limits are fine already. Nothing is stored yet.
     * @param data  `size` bytes in wire form, or NULL: a long value that comes in pieces and is stored as they come
     * @return ECT_OK to let it be stored, or the reason to refuse.
     */
    ect_reason_t (*sdo_write)(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);

    /** An entry was written and is stored. */
    void (*sdo_written)(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns);

    /** AL status got its error flag, with this code; or lost it (code 0). */
    void (*al_error)(void *instance, uint8_t state, uint16_t code, uint64_t now_ns);
} ect_device_t;

#endif
