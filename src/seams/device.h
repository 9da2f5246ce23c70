/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Device: one constant description of a product, and the functions that implement its behaviour.
 *
 * This description is the single source of all data that a master can read: the running slave, the SII image, the ESI
 * file and the dictionary document are derived from it. The behaviour works on an instance structure that the caller
 * owns; the description and all data that it points to are constant and shared.
 *
 * A device is independent of the ESC, of the stack and of any clock: process data are the data of its dictionary
 * entries, time is an argument (nanoseconds of any monotonic clock, 64 bit), and all requests to its surroundings go
 * through ::ect_host_t.
 *
 * Context: the functions of one instance run one at a time, must not block, and may not call back into the stack except
 * through ::ect_host_t. They run in mainline; `cyclic`, `outputs`, `inputs`, `inputs_packed` and `inputs_read` also run
 * in the interrupt that calls ::ect_slave_cycle, in a firmware that has one (docs/CONCURRENCY.md). Any function pointer
 * may be NULL: the device then has nothing to do there.
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

/**
 * Flags of byte 11 of the SII category General. ECT_GENERAL_GIVEN is not part of the SII: without it the flags are
 * those of the stack, which are device identification by AL status and, with a mailbox, repetition of lost mails.
 */
enum {
    ECT_GENERAL_SAFEOP = 0x01,      /**< SAFEOP is supported (older images) */
    ECT_GENERAL_NO_LRW = 0x02,      /**< LRW is not supported: masters use LRD and LWR */
    ECT_GENERAL_MAIL_REPEAT = 0x04, /**< mailbox data link layer: a lost mail is repeated (ETG.1000.4) */
    ECT_GENERAL_ID_AL_STATUS = 0x08,
    ECT_GENERAL_ID_MEMORY = 0x10, /**< device identification at ect_device_t::id_address */
    ECT_GENERAL_GIVEN = 0x80,
};

/** Role of an FMMU, as in the SII category FMMU. */
enum { ECT_FMMU_UNUSED = 0, ECT_FMMU_OUTPUTS = 1, ECT_FMMU_INPUTS = 2, ECT_FMMU_MAILBOX_STATE = 3 };

/** Events of ::ect_device_t::cyclic: the master has written outputs; SYNC0 has occurred. */
enum { ECT_CYCLIC_OUTPUTS = 0x01, ECT_CYCLIC_SYNC0 = 0x02 };

/** A deadline that is never reached: ::ect_device_t::tick returns it when only the bus can wake the device. */
#define ECT_NEVER UINT64_MAX

/** @return the earlier of two times. */
static inline uint64_t ect_earlier(uint64_t a_ns, uint64_t b_ns)
{
    return a_ns < b_ns ? a_ns : b_ns;
}

/** @return the later of two times. */
static inline uint64_t ect_later(uint64_t a_ns, uint64_t b_ns)
{
    return a_ns > b_ns ? a_ns : b_ns;
}

/** Identity of a device: SII words 8..15 and object 1018h. */
typedef struct ect_identity {
    uint32_t vendor_id;
    uint32_t product_code;
    uint32_t revision;
    uint32_t serial;
} ect_identity_t;

/** The largest numbers of SyncManagers and FMMUs in any ESC. */
enum { ECT_SMS = 8, ECT_FMMUS = 8 };

/**
 * One SyncManager of the layout; the array index is its number. With a mailbox, SM0 is the mailbox to the slave and SM1
 * the one from the slave. Every other SyncManager, and without a mailbox every SyncManager, may have any role; several
 * may share a role. Outputs and inputs are defined by their assignments, object 1C10h + number: the length of the
 * SyncManager is the sum of the PDOs assigned there.
 */
typedef struct ect_sm {
    uint16_t start;       /**< ESC address */
    uint16_t length;      /**< bytes of a mailbox; process data: 0, the PDOs determine it (::ect_device_sm_bytes) */
    uint16_t minimum;     /**< mailboxes: smallest length that a master may choose; 0: exactly `length` */
    uint16_t maximum;     /**< largest length that a master may choose, or that a changeable mapping may reach; 0: the
                             default length */
    uint8_t control;      /**< control register: 0x26, 0x22, 0x64 (watchdog), 0x20 ... */
    uint8_t type;         /**< ECT_SM_... */
    uint8_t flags;        /**< ECT_SM_FLAG_... */
    uint8_t role;         /**< with ECT_SM_FLAG_VIRTUAL: ECT_SM_...; `type` is ECT_SM_UNUSED then */
    const uint16_t *pdos; /**< with ECT_SM_FLAG_VIRTUAL: indices of its PDOs, 0 at the end; NULL: none */
} ect_sm_t;

/** Shortest length of a mailbox that a master may choose. */
static inline uint16_t ect_sm_shortest_mailbox(const ect_sm_t *sm)
{
    return sm->minimum != 0 ? sm->minimum : sm->length;
}

/**
 * Flags of a SyncManager, as in byte 6 of the SII category SyncM. A virtual SyncManager stands for registers of the
 * controller: the master's FMMUs reach them, and the stack moves no data. Its `length` is that of its PDOs.
 */
enum { ECT_SM_FLAG_FIXED = 0x02, ECT_SM_FLAG_VIRTUAL = 0x04, ECT_SM_FLAG_OP_ONLY = 0x08 };

/** Role of a SyncManager for a master: its type, and of a virtual one its role. */
static inline uint8_t ect_sm_role(const ect_sm_t *sm)
{
    return (sm->flags & ECT_SM_FLAG_VIRTUAL) != 0 ? sm->role : sm->type;
}

/** Properties of a PDO, as in the SII. */
enum { ECT_PDO_MANDATORY = 0x0001, ECT_PDO_FIXED = 0x0010, ECT_PDO_VIRTUAL = 0x0020 };

/**
 * Properties of a PDO that ESI and SII carry and its objects do not. Without this structure a PDO is fixed when its
 * mapping is constant (no entry has memory), and mandatory when both it and the assignment that lists it are fixed.
 */
typedef struct ect_pdo {
    uint16_t index;           /**< of the mapping object */
    uint16_t flags;           /**< ECT_PDO_... */
    const uint16_t *excludes; /**< PDOs that cannot be assigned together with this one, ended by 0; NULL: none */
} ect_pdo_t;

/**
 * A PDO of a SoE drive: SII and ESI have a number other than the index of the mapping object, and IDNs as the indices
 * of the elements.
 */
typedef struct ect_telegram {
    uint16_t index;       /**< of the mapping object */
    uint16_t number;      /**< in SII and ESI */
    const uint16_t *idns; /**< of its elements by default, 0: a gap */
} ect_telegram_t;

/**
 * Parts that an SII image omits if the EEPROM has no room for all, each together with the preceding ones. Only a
 * device with CoE can do without ECT_OMIT_PDOS: its dictionary has the PDOs.
 */
enum { ECT_OMIT_ENTRY_NAMES = 1, ECT_OMIT_PDO_NAMES, ECT_OMIT_MODE_TEXTS, ECT_OMIT_FREE_PDOS, ECT_OMIT_PDOS };

/** A category of the SII that the description contains unchanged (ESI `<Category>`). */
typedef struct ect_category {
    uint16_t number;
    uint16_t length; /**< bytes; an odd length is padded with a zero byte */
    const uint8_t *data;
} ect_category_t;

/** A mailbox of the BOOT state, SII words 0x14..0x17. */
typedef struct ect_boot_mailbox {
    uint16_t start;
    uint16_t length;
} ect_boot_mailbox_t;

/** A mode of the distributed clocks, SII category DC and ESI `<OpMode>`. */
typedef struct ect_dc_mode {
    const char *name;
    const char *description;
    uint16_t assign_activate; /**< 0: free run or SM-synchronous; 0x0300: SYNC0 */
    uint32_t cycle_sync0_ns;  /**< 0: `factor_sync0` times the bus cycle */
    int16_t factor_sync0;     /**< 0: one SYNC0 in each bus cycle; negative: its absolute number in each bus cycle */
    int16_t factor_sync1;     /**< SYNC1 occurs once in this number of SYNC0; 0: no separate SYNC1 */
    int32_t shift_sync0_ns;
    int32_t shift_sync1_ns;
} ect_dc_mode_t;

/** An SDO that a master writes at transitions, ESI `<InitCmd>`. */
typedef struct ect_init_command {
    const char *transitions; /**< "PS", or several of IP PS SO SP OP OS, separated by a blank */
    uint16_t index;
    uint8_t subindex;
    bool complete;       /**< by Complete Access */
    bool adapts;         /**< the configuration tool replaces the data, e.g. a cycle time by that of the bus */
    bool disabled;       /**< stored and not sent: `<Disabled>` of a network file */
    bool upload;         /**< the master reads, as some network files specify; no data */
    uint16_t size;       /**< bytes of `data`, at least 1 */
    const uint8_t *data; /**< wire form */
    const char *comment; /**< or NULL */
} ect_init_command_t;

/** Operations of SoE, of ::ect_init_mail_t. */
enum { ECT_INIT_READS = 1, ECT_INIT_WRITES = 3 };

/** A mail of AoE, EoE or SoE that a master sends at transitions, ESI `<InitCmd>` of these protocols. */
typedef struct ect_init_mail {
    const char *transitions; /**< as ect_init_command_t::transitions */
    const char *comment;     /**< or NULL */
    uint8_t protocol;        /**< ECT_MAILBOX_TYPE_AOE, _EOE or _SOE (seams/mailbox.h) */
    uint8_t type;  /**< of EoE: that of the mail, 2 sets the IP parameters; of SoE: ECT_INIT_READS, ECT_INIT_WRITES */
    uint8_t drive; /**< of SoE, 0 to 7 */
    uint8_t elements; /**< of SoE: bit 6 is the value */
    uint16_t idn;     /**< of SoE */
    bool disabled;    /**< as ect_init_command_t::disabled */
    uint16_t size;
    const uint8_t *data; /**< begins after the header of the mailbox, for EoE and SoE after that of the protocol */
} ect_init_mail_t;

/** Longest time that the device takes for a transition or a mail, milliseconds (ESI `<Timeout>`); 0: the master's
 * default. */
typedef struct ect_timeouts {
    uint16_t preop_ms;
    uint16_t safeop_op_ms;
    uint16_t back_to_init_ms;
    uint16_t back_to_safeop_ms;
    uint16_t mailbox_request_ms;  /**< until the mailbox accepts a request */
    uint16_t mailbox_response_ms; /**< until the reply is available */
} ect_timeouts_t;

/**
 * Memory for later descriptions of the same device (ect_host_t::describe), where these need more. All 0: no later
 * description.
 */
typedef struct ect_growth {
    uint16_t image; /**< bytes of the longest process image */
    uint16_t runs;  /**< entries of PDOs that can be assigned together */
    uint16_t value; /**< bytes of the longest value that a master may write */
} ect_growth_t;

/** Synchronisation abilities, 1C32h/1C33h. All zero: free run only. */
typedef struct ect_sync {
    uint16_t supported;           /**< 1C32h:4: bit 0 free run, bit 1 SM event, bit 2 DC SYNC0 */
    uint32_t minimum_cycle_ns;    /**< 1C32h:5; 0 no lower bound */
    const uint32_t *dc_cycles_ns; /**< the SYNC0 cycles that are accepted; NULL: every cycle from minimum_cycle_ns */
    uint8_t dc_cycle_count;
    bool asynchronous; /**< runs at its own rate: outputs missing at a SYNC0 are counted and do not end OP */
} ect_sync_t;

struct ect_device;

/**
 * Requests of a device to its surroundings. The stack passes the structure to ::ect_device_t::init; it is valid as long
 * as the instance. Each call is cheap: it records the request, and the stack acts at its next poll.
 */
typedef struct ect_host {
    void *ctx;

    /**
     * Queues a CoE emergency (ETG.1000.6 §5.6.4). When the queue is full, the emergency is lost and counted.
     * `data`: 5 bytes, copied.
     */
    void (*emergency)(void *ctx, uint16_t error_code, uint8_t error_register, const uint8_t data[5]);

    /**
     * Leaves the present AL state at the device's own initiative, for `state`, which must be a lower one, with error
     * flag and AL status code (ETG.1000.6 §6.4.1.4). Ignored unless the slave is above that state.
     */
    void (*drop)(void *ctx, uint8_t state, uint16_t al_status_code);

    /** Completes a transition that ::ect_device_t::state_change delayed: 0, or the AL status code that refuses it. */
    void (*transition_done)(void *ctx, uint16_t al_status_code);

    /**
     * Replaces the description of the device, whose dictionary has changed: a module was inserted. Below SAFEOP only.
     * The new description equals the old one in identity, layout of the SyncManagers, mailbox and `instance_size`, and
     * needs no more memory than the first one announces (ect_device_t::growth). It outlives the slave. The instance is
     * unchanged, except ect_standard_t::device: the device sets the data of new entries.
     */
    void (*describe)(void *ctx, const struct ect_device *device);

    /**
     * Adds a message to the diagnosis history 10F3h: ECT_DIAGNOSIS_INFO/WARNING/ERROR, diagnosis code, text id of one
     * of the device's texts, two parameters of 16 bits. NULL unless the description names ect_service_diagnosis.
     */
    void (*diagnose)(void *ctx, uint8_t type, uint32_t code, uint16_t text_id, const uint16_t parameters[2]);

    /**
     * Stores all entries with ECT_ACCESS_BACKUP at the end of the present poll, as a master's write of "save" to
     * 1010h:1 does. May be called from the cyclic exchange too. The result is not reported. NULL unless the description
     * names ect_service_store.
     */
    void (*store)(void *ctx);

    /** Takes the slave off the bus, as if its ports were unplugged, or connects it again. */
    void (*off_bus)(void *ctx, bool off);

    /**
     * Requests a power cycle of controller, stack and device. The program that drives the slave executes it after the
     * present poll (a firmware resets its processor): the instance is zeroed, except for the bytes that belong to the
     * outside (plant.h), and initialised again.
     */
    void (*restart)(void *ctx);

    /** Non-volatile memory, or NULL when this installation has none. */
    const ect_storage_t *storage;

    /** ect_device_t::buffer_size bytes, zero at power-on, or NULL when this installation has no such memory. */
    void *buffer;
} ect_host_t;

/** Bytes of another owner; the structure only refers to them. */
typedef struct ect_span {
    const void *data;
    uint16_t size;
} ect_span_t;

/** In place of a sub-index: all sub-indices, by Complete Access. */
enum { ECT_WHOLE_OBJECT = 0x100 };

/** Result of ::ect_device_t::state_change that delays the reply until ::ect_host_t::transition_done. */
#define ECT_AL_PENDING 0xFFFFu

/**
 * The description of a product. A member that is 0 or NULL has the meaning that its line gives for it; without one, the
 * product does not have the feature. The description is constant and shared by all twins of the product; a description
 * made at run time must outlive them. `ect_device_check` (check/check.h) validates a description and names the first
 * error in one line.
 */
typedef struct ect_device {
    /* --- identity -------------------------------------------------------------------------------------------- */
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
    uint8_t sii_omit;   /**< the last part that an image may omit for lack of room: ECT_OMIT_...; 0: names of entries */
    const uint8_t *sii; /**< content of the EEPROM, `sii_size` bytes; NULL: written from this description */
    const ect_category_t *categories; /**< written after those that follow from the description */
    uint8_t category_count;
    ect_sm_t sm[ECT_SMS];
    uint8_t sm_count;
    uint8_t fmmu[ECT_FMMUS]; /**< ECT_FMMU_... */
    uint8_t fmmu_count;
    ect_boot_mailbox_t boot_out; /**< length 0: no BOOT state */
    ect_boot_mailbox_t boot_in;
    uint8_t mailbox_protocols; /**< ECT_MAILBOX_..., as the SII lists them; 0: no mailbox */
    const ect_protocol_t *const
        *protocols;        /**< protocols that the stack serves, ended by NULL (mailbox.h); NULL: none */
    uint8_t coe_details;   /**< ECT_COE_... */
    uint8_t general_flags; /**< ECT_GENERAL_...; 0: those of the stack */
    uint8_t soe_channels;  /**< SII General: drives accessible by SoE */
    uint16_t id_address;   /**< ECT_GENERAL_ID_MEMORY: ESC address of the identification, else 0 */
    const char *physics;   /**< ESI `Physics`, one letter for each port: "YY" */
    int16_t ebus_ma;       /**< current drawn from the E-bus, mA; negative: current fed into it */
    const ect_dc_mode_t *dc_modes;
    uint8_t dc_mode_count;
    const ect_init_command_t *init_commands;
    uint8_t init_command_count;
    uint8_t init_mail_count;
    const ect_init_mail_t *init_mails;
    ect_sync_t sync;
    ect_timeouts_t timeouts;

    /* --- dictionary and services ----------------------------------------------------------------------------- */
    const ect_object_t *objects;
    uint16_t object_count;
    bool addresses; /**< `data` of entries are addresses, as in a SOES list: one instance, hence one twin, only */
    const ect_detail_t *details; /**< units, limits, long defaults of entries */
    uint16_t detail_count;
    const ect_pdo_t *pdos; /**< PDOs whose properties differ from the default rule (::ect_pdo_t), in any order */
    uint8_t pdo_count;
    const ect_telegram_t *telegrams; /**< PDOs of SoE drives */
    uint8_t telegram_count;
    const ect_service_t *const *services; /**< object services that the device needs, ended by NULL; NULL: none */

    /* --- behaviour ------------------------------------------------------------------------------------------- */
    size_t instance_size; /**< bytes of instance memory that the caller provides, aligned as by malloc */
    ect_growth_t growth;  /**< memory for later descriptions */
    size_t buffer_size;   /**< bytes of optional memory that the device can use (::ect_host_t::buffer); 0: none */
    const void *context;  /**< private to the device; its functions reach it through the instance */

    /**
     * Power-on: sets the instance to its start values. On entry the instance is zero, except for the bytes that outlast
     * a power cycle (plant.h), the description and the identity in its ::ect_standard_t, and the data of its entries,
     * which have their defaults.
     * @param host  valid as long as the instance
     */
    void (*init)(void *instance, const ect_host_t *host, uint64_t now_ns);

    /**
     * A transition upwards is about to be confirmed, or a transition downwards has happened. The stack may call this
     * more than once for one transition upwards, when a PDI access failed on the way.
     * @return 0 · ECT_AL_PENDING · an AL status code that refuses the transition (upwards only; ignored downwards)
     */
    uint16_t (*state_change)(void *instance, uint8_t from, uint8_t to, uint64_t now_ns);

    /**
     * The rhythm of the bus, in SAFEOP and OP. `events` is the set of ECT_CYCLIC_... that have occurred since the last
     * call. In SAFEOP too, writes of outputs count as events, although the values are not used. The call precedes
     * `outputs`; `tick` follows. Only devices whose description names ect_service_rhythm get this call.
     */
    void (*cyclic)(void *instance, uint8_t events, uint64_t now_ns);

    /** Called when the master has written new output data to the dictionary. OP only. */
    void (*outputs)(void *instance, uint64_t now_ns);

    /** Sets the outputs to their safe values: the slave has left OP, whatever the cause. */
    void (*safe_outputs)(void *instance, uint64_t now_ns);

    /** Updates the input data in the dictionary before the stack sends them. SAFEOP and OP. */
    void (*inputs)(void *instance, uint64_t now_ns);

    /**
     * Changes the packed input data of SyncManager `sm`, after `inputs` and before the stack sends them. Entries alone
     * cannot express some data: PDOs that map the same entries and are successive samples of them (oversampling).
     * @param image  `size` bytes, in wire form
     */
    void (*inputs_packed)(void *instance, unsigned int sm, uint8_t *image, uint16_t size);

    /** Called when the master has read the input data since the last call. SAFEOP and OP. */
    void (*inputs_read)(void *instance, uint64_t now_ns);

    /**
     * Advances the device's own time. The stack calls this once after init, then at or after the returned time, soon
     * after outputs, a lower state, an SDO write or a change of a signal, and at times in between.
     * @return the time of the next call (> now_ns), or ECT_NEVER
     */
    uint64_t (*tick)(void *instance, uint64_t now_ns);

    /**
     * Called before a request of the master is executed: a change of the AL state (index 0), SDO information (index 0),
     * an SDO. The device may replace its description here.
     */
    void (*requested)(void *instance, uint16_t index);

    /**
     * Called when a request for an SDO upload or download has arrived, before any check by the stack.
     * @return ECT_OK to continue, or the reason to refuse the request
     */
    ect_reason_t (*sdo_request)(void *instance, uint16_t index, uint8_t subindex);

    /**
     * A master reads an entry by SDO, or a whole object (ECT_WHOLE_OBJECT); the access rights are already checked. The
     * device updates the data of the entry.
     * @param[in,out] instead  empty on entry. When the device sets it, the stack sends these bytes (wire form) in place
     * of the entry's; they must not change until the next read, or until the transfer has ended. NULL for a whole
     * object.
     * @return ECT_OK, or the reason to refuse the read
     */
    ect_reason_t (*sdo_read)(void *instance, uint16_t index, uint16_t subindex, ect_span_t *instead);

    /**
     * Checks a value that a master wants to write; rights, length and limits are already checked. The value is
     * complete, however many segments carried it, and not stored yet. The stack may call this more than once for one
     * value, so the effects of the value belong into `sdo_written`.
     * @param data  `size` bytes in wire form
     * @return ECT_OK to store the value, or the reason to refuse it
     */
    ect_reason_t (*sdo_write)(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);

    /** An entry has been written, and its value is stored. */
    void (*sdo_written)(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns);

    /**
     * Called when AL status gets its error flag, with this code, or loses it (code 0).
     * @return the code that the master reads: `code`, or the product's own where the product is known to differ from
     * the standard; 0 if and only if `code` is 0
     */
    uint16_t (*al_error)(void *instance, uint8_t state, uint16_t code, uint64_t now_ns);

    /* --- where the product is known to differ from the standard ---------------------------------------------- */

    /**
     * Changes a mail to the master that the stack has built according to the standard: `size` bytes, the whole mailbox,
     * header first. The master reads the changed mail, also when it requests a repetition.
     */
    void (*mail)(void *instance, uint8_t *mail, uint16_t size);
} ect_device_t;

/** The object list of a device over an instance; with NULL, only the list itself may be used. */
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

/** Length of SyncManager n by default, bytes: that of the mailbox, or the sum of the assigned PDOs. */
static inline uint16_t ect_device_sm_bytes(const ect_device_t *device, unsigned int n)
{
    ect_od_t od = ect_device_od(device, NULL);
    if (n >= device->sm_count)
        return 0;
    return ect_device_sm_is_process(device, n) ? (uint16_t)((ect_od_sm_bits(&od, n) + 7) / 8) : device->sm[n].length;
}

/** Flags of the SII category General: ECT_GENERAL_... without ECT_GENERAL_GIVEN. */
static inline uint8_t ect_device_general_flags(const ect_device_t *device)
{
    if ((device->general_flags & ECT_GENERAL_GIVEN) != 0)
        return device->general_flags & (uint8_t)~ECT_GENERAL_GIVEN;
    return (uint8_t)(ECT_GENERAL_ID_AL_STATUS | (device->mailbox_protocols != 0 ? ECT_GENERAL_MAIL_REPEAT : 0));
}

/** Sum of the default lengths of all SyncManagers of a type (ECT_SM_OUTPUTS, ECT_SM_INPUTS), bytes. */
static inline uint16_t ect_device_bytes(const ect_device_t *device, uint8_t type)
{
    unsigned int bytes = 0;
    for (unsigned int n = 0; n < device->sm_count; n++)
        bytes += device->sm[n].type == type ? ect_device_sm_bytes(device, n) : 0u;
    return (uint16_t)bytes;
}

#endif
