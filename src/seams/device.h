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
 * All functions run one at a time for an instance, must not block, and may not call back into the stack except through
 * ::ect_host_t. They run in mainline; `cyclic`, `outputs`, `inputs`, `inputs_packed` and `inputs_read` also in the
 * interrupt of ::ect_slave_cycle, where a firmware has one (docs/CONCURRENCY.md). Any function pointer may be NULL: the
 * device then has nothing to do there.
 */
#ifndef ECT_SEAMS_DEVICE_H
#define ECT_SEAMS_DEVICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "od/od.h"
#include "od/pdo.h"
#include "seams/al_status.h"
#include "seams/mailbox.h"
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

/** What ::ect_device_t::cyclic tells: the master has written outputs, SYNC0 has come. */
enum { ECT_CYCLIC_OUTPUTS = 0x01, ECT_CYCLIC_SYNC0 = 0x02 };

/** A deadline that never comes: what ::ect_device_t::tick returns when only the bus can wake the device. */
#define ECT_NEVER UINT64_MAX

/** The one of two times that comes first, or last. */
static inline uint64_t ect_earlier(uint64_t a_ns, uint64_t b_ns)
{
    return a_ns < b_ns ? a_ns : b_ns;
}

static inline uint64_t ect_later(uint64_t a_ns, uint64_t b_ns)
{
    return a_ns > b_ns ? a_ns : b_ns;
}

/** Who the device says it is: SII words 8..15 and object 1018h. */
typedef struct ect_identity {
    uint32_t vendor_id;
    uint32_t product_code;
    uint32_t revision;
    uint32_t serial;
} ect_identity_t;

/** The most that any ESC has. */
enum { ECT_SMS = 8, ECT_FMMUS = 8 };

/**
 * One SyncManager of the layout; the array index is its number. With a mailbox, SM0 is the one to and SM1 the one from
 * the slave; all others, without a mailbox all, may have any role, several the same. What outputs and inputs hold is
 * said by their assignments, object 1C10h + number: their length is the sum of the PDOs assigned there.
 */
typedef struct ect_sm {
    uint16_t start;   /**< ESC address */
    uint16_t length;  /**< bytes of a mailbox; process data: 0, for their PDOs say it (::ect_device_sm_bytes) */
    uint16_t minimum; /**< mailboxes: smallest length a master may choose; 0: exactly `length` */
    uint16_t maximum; /**< largest one that a master may choose, or that a mapping that can be changed may come to; 0:
                         none larger than by default */
    uint8_t control;  /**< control register: 0x26, 0x22, 0x64 (watchdog), 0x20 ... */
    uint8_t type;     /**< ECT_SM_... */
} ect_sm_t;

/** Properties of a PDO, as in the SII. */
enum { ECT_PDO_MANDATORY = 0x0001, ECT_PDO_FIXED = 0x0010, ECT_PDO_VIRTUAL = 0x0020 };

/**
 * What ESI and SII say of a PDO and its objects do not. Without it, a PDO is fixed when its mapping is constant (no
 * entry has memory), and mandatory when it is fixed and so is the assignment that it stands in.
 */
typedef struct ect_pdo {
    uint16_t index;           /**< of the mapping object */
    uint16_t flags;           /**< ECT_PDO_... */
    const uint16_t *excludes; /**< PDOs that cannot be assigned together with it, 0 at the end; NULL: none */
} ect_pdo_t;

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
    uint32_t cycle_sync0_ns;  /**< 0: `factor_sync0` times the bus cycle */
    int16_t factor_sync0;     /**< 0: once; negative: so many SYNC0 in a bus cycle */
    int16_t factor_sync1;     /**< SYNC1 every so many SYNC0; 0: no SYNC1 of its own */
    int32_t shift_sync0_ns;
    int32_t shift_sync1_ns;
} ect_dc_mode_t;

/** How long the device may take for a transition or a mail, milliseconds (ESI `<Timeout>`); 0: the master's default. */
typedef struct ect_timeouts {
    uint16_t preop_ms;
    uint16_t safeop_op_ms;
    uint16_t back_to_init_ms;
    uint16_t back_to_safeop_ms;
    uint16_t mailbox_request_ms;  /**< until a request can be put into its mailbox */
    uint16_t mailbox_response_ms; /**< until the reply is there */
} ect_timeouts_t;

/** Synchronisation abilities, 1C32h/1C33h. All zero: free run only. */
typedef struct ect_sync {
    uint16_t supported;           /**< 1C32h:4: bit 0 free run, bit 1 SM event, bit 2 DC SYNC0 */
    uint32_t minimum_cycle_ns;    /**< 1C32h:5; 0 no lower bound */
    const uint32_t *dc_cycles_ns; /**< the SYNC0 cycles that are accepted, or NULL: all from minimum_cycle_ns */
    uint8_t dc_cycle_count;
    bool asynchronous; /**< works by its own time: outputs that SYNC0 finds missing are counted, and do not end OP */
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

    /**
     * Stores all entries with ECT_ACCESS_BACKUP, as a master's write of "save" to 1010h:1 does, at the end of the
     * present poll. From the exchange too. What the memory then says is told to nobody. NULL unless the description
     * names ect_service_store.
     */
    void (*store)(void *ctx);

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

    /** ect_device_t::buffer_size bytes, zero at power-on, or NULL when this installation has no such memory. */
    void *buffer;
} ect_host_t;

/** Bytes of somebody else's. */
typedef struct ect_span {
    const void *data;
    uint16_t size;
} ect_span_t;

/** In place of a sub-index: all of them, by Complete Access. */
enum { ECT_WHOLE_OBJECT = 0x100 };

/** Returned by ::ect_device_t::state_change to delay the answer until ::ect_host_t::transition_done. */
#define ECT_AL_PENDING 0xFFFFu

/**
 * The description of a product. A member that is left out, 0 or NULL, means what its line says, else nothing. Constant
 * and shared by all twins of the product; a description made at run time lives as long as they do.
 * `ect_device_check` (check/check.h) says in a line what is wrong with one.
 */
typedef struct ect_device {
    /* --- who it is ------------------------------------------------------------------------------------------- */
    const char *name;        /**< command-line name: lower case, digits, hyphen */
    const char *summary;     /**< one line for `ectwin list` */
    const char *vendor_name; /**< ESI `<Vendor>` */
    const char *type_name;   /**< 1008h, ESI `<Type>`, SII order code; at most 40 characters */
    const char *full_name;   /**< ESI `<Name>`, SII name; NULL: `type_name` */
    const char *group_type;  /**< ESI and SII group */
    const char *group_name;
    uint32_t device_type;         /**< 1000h */
    const char *hardware_version; /**< 1009h */
    const char *software_version; /**< 100Ah */
    ect_identity_t identity;      /**< default; an installation may override it */

    /* --- the controller and its layout ----------------------------------------------------------------------- */
    const char *esc;        /**< personality of the ESC: "np40", "et1100" … (esc/personality.h) */
    uint8_t esc_config[14]; /**< SII words 0..6, ESI ConfigData */
    uint16_t sii_size;      /**< bytes of the EEPROM: a multiple of 128 */
    const uint8_t *sii;     /**< the EEPROM's content, `sii_size` bytes; NULL: written from this description */
    ect_sm_t sm[ECT_SMS];
    uint8_t sm_count;
    uint8_t fmmu[ECT_FMMUS]; /**< ECT_FMMU_... */
    uint8_t fmmu_count;
    ect_boot_mailbox_t boot_out; /**< length 0: no BOOT state */
    ect_boot_mailbox_t boot_in;
    uint8_t mailbox_protocols;              /**< ECT_MAILBOX_...: what the SII says; 0: no mailbox */
    const ect_protocol_t *const *protocols; /**< those that are served, NULL at the end (mailbox.h); NULL: none */
    uint8_t coe_details;                    /**< ECT_COE_... */
    const char *physics;                    /**< ESI `Physics`, a letter a port: "YY" */
    int16_t ebus_ma;                        /**< what it takes from the E-bus, negative: what it feeds */
    const ect_dc_mode_t *dc_modes;
    uint8_t dc_mode_count;
    ect_sync_t sync;
    ect_timeouts_t timeouts;

    /* --- what it offers -------------------------------------------------------------------------------------- */
    const ect_object_t *objects;
    uint16_t object_count;
    bool addresses; /**< `data` of entries are addresses, as in a SOES list: for one instance, one twin, only */
    const ect_detail_t *details; /**< units, limits, long defaults of entries */
    uint16_t detail_count;
    const ect_pdo_t *pdos; /**< of those PDOs for which the rule of ::ect_pdo_t does not do, in any order */
    uint8_t pdo_count;
    const ect_service_t *const *services; /**< NULL-terminated list of the object services it needs; NULL: none */

    /* --- how it behaves -------------------------------------------------------------------------------------- */
    size_t instance_size; /**< bytes of instance memory that the caller provides, aligned as by malloc */
    size_t buffer_size;   /**< bytes that it can make use of and do without (::ect_host_t::buffer); 0: none */
    const void *context;  /**< the device's own: what its functions need beside the instance, which leads here */

    /**
     * Power-on: brings instance memory to its start values. It is zero but for what outlasts power (plant.h), for the
     * description and the identity in its ::ect_standard_t, and for its entries, which have their defaults.
     * @param host  valid as long as the instance
     */
    void (*init)(void *instance, const ect_host_t *host, uint64_t now_ns);

    /**
     * A transition upwards is about to be confirmed, or one downwards has happened. A transition upwards may be asked
     * about more than once, when the PDI failed on the way.
     * @return 0 · ECT_AL_PENDING · an AL status code that refuses it (upwards only; ignored downwards)
     */
    uint16_t (*state_change)(void *instance, uint8_t from, uint8_t to, uint64_t now_ns);

    /**
     * The rhythm of the bus, SAFEOP and OP: `events` is a set of ECT_CYCLIC_... that have come since the last call.
     * Outputs tell the rhythm in SAFEOP too, where they are not taken over. Before `outputs`; `tick` follows. The
     * description names ect_service_rhythm, which calls it.
     */
    void (*cyclic)(void *instance, uint8_t events, uint64_t now_ns);

    /** Output data of the dictionary was renewed by the master. Only in OP. */
    void (*outputs)(void *instance, uint64_t now_ns);

    /** Outputs must go to their safe values: OP was left, whatever the cause. */
    void (*safe_outputs)(void *instance, uint64_t now_ns);

    /** Input data of the dictionary is about to be sent: bring it up to date. SAFEOP and OP. */
    void (*inputs)(void *instance, uint64_t now_ns);

    /**
     * After `inputs`: the input data of SyncManager `sm` are packed as they will be sent, and may be changed. For what
     * entries alone cannot say: PDOs that map the same ones and are samples of them (oversampling).
     * @param image  `size` bytes, in wire form
     */
    void (*inputs_packed)(void *instance, unsigned int sm, uint8_t *image, uint16_t size);

    /** The master has read the input data since the last call. SAFEOP and OP. */
    void (*inputs_read)(void *instance, uint64_t now_ns);

    /**
     * The device's own time. Called once after init, then at or after the time that the last call returned, soon after
     * outputs, a lower state, an SDO write or a signal was told to the device, and at times in between.
     * @return when to call again (> now_ns), or ECT_NEVER.
     */
    uint64_t (*tick)(void *instance, uint64_t now_ns);

    /**
     * A master's request for an SDO upload or download has come, and nothing of it is checked yet.
     * @return ECT_OK to go on with it, or the reason to refuse it.
     */
    ect_reason_t (*sdo_request)(void *instance, uint16_t index, uint8_t subindex);

    /**
     * A master wants to read an entry by SDO, or a whole object (ECT_WHOLE_OBJECT); its rights are fine already. Data
     * that is kept for such readers is to be brought up to date.
     * @param[in,out] instead  empty; set, its bytes are sent in place of the entry's (wire form), and must stay as they
     * are until the next read, or the end of this one. NULL for a whole object.
     * @return ECT_OK, or the reason to refuse.
     */
    ect_reason_t (*sdo_read)(void *instance, uint16_t index, uint16_t subindex, ect_span_t *instead);

    /**
     * A master wants to write an entry; rights, length and limits are fine already. Nothing of it is stored yet,
     * however long it is and in however many pieces it came. A question, which may be asked more than once: what
     * follows from the value belongs to `sdo_written`.
     * @param data  `size` bytes in wire form
     * @return ECT_OK to let it be stored, or the reason to refuse.
     */
    ect_reason_t (*sdo_write)(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);

    /** An entry was written and is stored. */
    void (*sdo_written)(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns);

    /**
     * AL status got its error flag, with this code; or lost it (code 0).
     * @return the code that the master reads: `code`, or where the product is known to differ from the standard, its
     *         own; 0 in the place of 0 alone
     */
    uint16_t (*al_error)(void *instance, uint8_t state, uint16_t code, uint64_t now_ns);

    /* --- where the product is known to differ from the standard ---------------------------------------------- */

    /**
     * A mail to the master stands ready, as the standard wants it: `size` bytes, the whole mailbox, header first. What
     * is changed here is what the master gets, also when it asks for it once more.
     */
    void (*mail)(void *instance, uint8_t *mail, uint16_t size);
} ect_device_t;

/** Its object list over an instance; NULL: only the list is looked at. */
static inline ect_od_t ect_device_od(const ect_device_t *device, void *instance)
{
    return (ect_od_t){.objects = device->objects,
                      .count = device->object_count,
                      .details = device->details,
                      .detail_count = device->detail_count,
                      .base = device->addresses ? NULL : instance,
                      .description = device};
}

/** Whether SyncManager n carries process data. */
static inline bool ect_device_sm_is_process(const ect_device_t *device, unsigned int n)
{
    return n < device->sm_count && (device->sm[n].type == ECT_SM_OUTPUTS || device->sm[n].type == ECT_SM_INPUTS);
}

/** Bytes of SyncManager n as a master finds it by default: a mailbox's length, or what the assigned PDOs come to. */
static inline uint16_t ect_device_sm_bytes(const ect_device_t *device, unsigned int n)
{
    ect_od_t od = ect_device_od(device, NULL);
    if (n >= device->sm_count)
        return 0;
    return ect_device_sm_is_process(device, n) ? (uint16_t)((ect_od_sm_bits(&od, n) + 7) / 8) : device->sm[n].length;
}

/** Bytes that its SyncManagers of a type (ECT_SM_OUTPUTS, ECT_SM_INPUTS) hold together by default. */
static inline uint16_t ect_device_bytes(const ect_device_t *device, uint8_t type)
{
    unsigned int bytes = 0;
    for (unsigned int n = 0; n < device->sm_count; n++)
        bytes += device->sm[n].type == type ? ect_device_sm_bytes(device, n) : 0u;
    return (uint16_t)bytes;
}

#endif
