/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SoE, servo drive profile over EtherCAT: the parameters (IDNs) of up to eight drives, and their process data.
 *
 * A device that offers SoE has a constant `ect_soe_t`, lists its `protocol` member among its protocols
 * (::ect_device_t::protocols) and ::ect_service_soe among its services; otherwise nothing of SoE is linked. Each drive
 * has a constant table of IDNs, ascending, with values in the device's instance. The protocol itself handles elements,
 * fragments, protection, limits, error codes, the states of procedure commands and the lists of process data.
 *
 *     typedef struct axis {
 *         ect_standard_t standard;
 *         ect_soe_state_t soe;
 *         uint8_t buffer[256];
 *         uint16_t cycle_us;                              // S-0-0002
 *         ECT_SOE_LIST_MEMORY(24) at;                     // S-0-0016
 *         ect_soe_command_t reset;                        // S-0-0099
 *     } axis_t;
 *     static const ect_soe_idn_t idns[] = {
 *         {.idn = ECT_SOE_S(2), .attribute = ECT_SOE_16 | ECT_SOE_UNSIGNED | ECT_SOE_LOCK_SAFEOP | ECT_SOE_LOCK_OP,
 *          .flags = ECT_SOE_MINIMUM | ECT_SOE_MAXIMUM | ECT_SOE_CHECK_SAFEOP, .name = "Communication cycle time",
 *          .unit = "us", .minimum = 250, .maximum = 8000, .initial = 2000, .offset = offsetof(axis_t, cycle_us)},
 *         {.idn = ECT_SOE_S(16), .attribute = ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_IDNS | ECT_SOE_LOCK_SAFEOP |
 *                                             ECT_SOE_LOCK_OP,
 *          .name = "Configuration list AT", .size = 24, .offset = offsetof(axis_t, at)},
 *         {.idn = ECT_SOE_S(17), .attribute = ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_IDNS | ECT_SOE_READ_ONLY,
 *          .name = "IDN list of all operation data"},
 *         {.idn = ECT_SOE_S(99), .attribute = ECT_SOE_16 | ECT_SOE_COMMAND, .name = "Reset class 1 diagnostic",
 *          .offset = offsetof(axis_t, reset)},
 *     };
 *     static const ect_soe_drive_t drives[] = {{.idns = idns, .count = 4, .at = 0x1A00, .mdt = 0x1600}};
 *     static const ect_soe_t servo = {.protocol = ECT_SOE_PROTOCOL, .offset = offsetof(axis_t, soe),
 *                                     .buffer = offsetof(axis_t, buffer), .buffer_size = 256,
 *                                     .drives = drives, .drive_count = 1};
 *
 * In the description, `mailbox_protocols` contains ECT_MAILBOX_SOE and `soe_channels` is the number of drives; both
 * mailboxes have at least ::ECT_SOE_MAILBOX_LEAST bytes. The device calls ::ect_soe_set_defaults in its `init`.
 *
 * **Values.** A number lies in the instance in the byte order of the host, as in the dictionary, so an IDN and an entry
 * of the dictionary may share memory. A list or text lies there as ECT_SOE_LIST_MEMORY: its present length, then its
 * bytes as on the wire. A procedure command has an ::ect_soe_command_t. Without memory (`offset` 0) the value is
 * constant.
 *
 * **Writes** are checked in this order: drive (800A), IDN (1001), elements (800C, 800B, x004), read only (7004), AL
 * state (7005), process data (700A: an IDN of the MDT in SAFEOP and OP), length (7002, 7003), limits (7006, 7007), the
 * rules of the standard IDNs below, and the device (its own code). A value is stored entirely or not at all.
 *
 * | IDN, where the table has it | treatment by the stack |
 * |---|---|
 * | S-0-0015 | 7 (application telegram) only, else 7008 |
 * | S-0-0016, S-0-0024 | IDNs with ECT_SOE_IN_AT, ECT_SOE_IN_MDT only, else 7008; process data follow |
 * | S-0-0017 | made from the table: all IDNs |
 * | S-0-0187, S-0-0188 | made from the table: IDNs with ECT_SOE_IN_AT, with ECT_SOE_IN_MDT |
 * | S-0-0021, S-0-0022 | IDNs refused by the last check of the transition to SAFEOP, to OP |
 * | S-0-0127, S-0-0128 | commands: the check for SAFEOP, in PREOP; for OP, in SAFEOP; else 7012 |
 *
 * **Process data.** The assignments 1C12h and 1C13h of the dictionary name one mapping object for each drive, in the
 * order of the drives (ect_soe_drive_t::mdt, `at`). Its first element is constant and maps S-0-0134 or S-0-0135. The
 * others have memory; the stack writes to them, and to the count, what S-0-0024 or S-0-0016 lists
 * (ect_soe_idn_t::mapping). The lengths that the transition to SAFEOP expects follow, codes 0x001D and 0x001E.
 *
 * **Transitions.** On the way to SAFEOP and OP, each IDN with ECT_SOE_CHECK_SAFEOP or ECT_SOE_CHECK_OP must be within
 * its limits and accepted by ect_soe_t::valid; otherwise the transition is refused with 0x0026 (inconsistent settings).
 *
 * **Commands.** Writing 3 starts a command, and its data state is 7 until the device calls ::ect_soe_finish; writing 0
 * clears or cancels it; the other values are only stored. The write is confirmed at once.
 *
 * Mailbox errors: 6 for a mail of fewer than 4 bytes, 4 for an operation other than read and write requests.
 *
 * Context: all functions run in mainline, as those of `ect_protocol_t`, and must not block.
 *
 * Clauses: ETG.1000.6 (SoE), IEC 61800-7-204.
 */
#ifndef ECT_SEAMS_SOE_H
#define ECT_SEAMS_SOE_H

#include <stddef.h>

#include "seams/device.h"
#include "seams/mailbox.h"

enum {
    ECT_SOE_MAILBOX_LEAST = 24, /**< headers, two length words and the longest number, so that fragments are useful */
    ECT_SOE_DRIVES = 8,
    ECT_SOE_EMERGENCIES = 4, /**< capacity for emergencies that wait for the mailbox; a power of two */
};

/** Numbers of IDNs: S-0-n and P-0-n, 0..4095. */
#define ECT_SOE_S(n) ((uint16_t)(n))
#define ECT_SOE_P(n) ((uint16_t)(0x8000u | (n)))

/** Bits of an attribute. Bits 0 to 15 are the factor for display. */
#define ECT_SOE_8           0x00000000u
#define ECT_SOE_16          0x00010000u
#define ECT_SOE_32          0x00020000u
#define ECT_SOE_64          0x00030000u
#define ECT_SOE_LIST        0x00040000u /**< of values of this width; a text is a list of 8 bits */
#define ECT_SOE_COMMAND     0x00080000u
#define ECT_SOE_BINARY      0x00000000u
#define ECT_SOE_UNSIGNED    0x00100000u
#define ECT_SOE_SIGNED      0x00200000u
#define ECT_SOE_HEXADECIMAL 0x00300000u
#define ECT_SOE_TEXT        0x00400000u
#define ECT_SOE_IDNS        0x00500000u
#define ECT_SOE_FLOAT       0x00600000u
#define ECT_SOE_KIND        0x00700000u /**< the bits of the seven above */
#define ECT_SOE_DECIMALS(n) ((uint32_t)(n) << 24)
#define ECT_SOE_LOCK_PREOP  0x10000000u /**< cannot be written in this state */
#define ECT_SOE_LOCK_SAFEOP 0x20000000u
#define ECT_SOE_LOCK_OP     0x40000000u
#define ECT_SOE_READ_ONLY   0x70000000u

/** Bytes of a value, or of an element of a list. */
static inline uint16_t ect_soe_width(uint32_t attribute)
{
    return (uint16_t)(1u << (attribute >> 16 & 3u));
}

/** Bits of ::ect_soe_idn_t::flags. */
enum {
    ECT_SOE_MINIMUM = 0x01, /**< has this element; numbers only */
    ECT_SOE_MAXIMUM = 0x02,
    ECT_SOE_DEFAULT = 0x04,
    ECT_SOE_IN_MDT = 0x08,       /**< may be in S-0-0024 */
    ECT_SOE_IN_AT = 0x10,        /**< may be in S-0-0016 */
    ECT_SOE_CHECK_SAFEOP = 0x20, /**< must be valid for SAFEOP */
    ECT_SOE_CHECK_OP = 0x40,     /**< must be valid for OP */
};

/** Elements of an IDN, as on the wire. */
enum {
    ECT_SOE_ELEMENT_STATE = 0x01,
    ECT_SOE_ELEMENT_NAME = 0x02,
    ECT_SOE_ELEMENT_ATTRIBUTE = 0x04,
    ECT_SOE_ELEMENT_UNIT = 0x08,
    ECT_SOE_ELEMENT_MINIMUM = 0x10,
    ECT_SOE_ELEMENT_MAXIMUM = 0x20,
    ECT_SOE_ELEMENT_VALUE = 0x40,
    ECT_SOE_ELEMENT_DEFAULT = 0x80,
};

/** Error codes of replies: the number of the element << 12, and the cause. */
enum {
    ECT_SOE_OK = 0x0000,
    ECT_SOE_NO_IDN = 0x1001,
    ECT_SOE_NO_STATE_WRITE = 0x1009,
    ECT_SOE_NO_NAME = 0x2001,
    ECT_SOE_NAME_READ_ONLY = 0x2004,
    ECT_SOE_ATTRIBUTE_READ_ONLY = 0x3004,
    ECT_SOE_NO_UNIT = 0x4001,
    ECT_SOE_UNIT_READ_ONLY = 0x4004,
    ECT_SOE_NO_MINIMUM = 0x5001,
    ECT_SOE_MINIMUM_READ_ONLY = 0x5004,
    ECT_SOE_NO_MAXIMUM = 0x6001,
    ECT_SOE_MAXIMUM_READ_ONLY = 0x6004,
    ECT_SOE_TOO_SHORT = 0x7002,
    ECT_SOE_TOO_LONG = 0x7003,
    ECT_SOE_VALUE_READ_ONLY = 0x7004,
    ECT_SOE_LOCKED_BY_STATE = 0x7005,
    ECT_SOE_TOO_LOW = 0x7006,
    ECT_SOE_TOO_HIGH = 0x7007,
    ECT_SOE_INVALID = 0x7008,
    ECT_SOE_PASSWORD = 0x7009,
    ECT_SOE_CYCLIC = 0x700A,
    ECT_SOE_LOCKED = 0x700C, /**< by other settings */
    ECT_SOE_COMMAND_ACTIVE = 0x7010,
    ECT_SOE_COMMAND_GOES_ON = 0x7011, /**< cannot be cancelled */
    ECT_SOE_COMMAND_NOT_NOW = 0x7012,
    ECT_SOE_COMMAND_NEVER = 0x7013,
    ECT_SOE_NO_STATE = 0x7014,
    ECT_SOE_NO_DEFAULT = 0x8001,
    ECT_SOE_DEFAULT_READ_ONLY = 0x8004,
    ECT_SOE_NO_DRIVE = 0x800A,
    ECT_SOE_GENERAL = 0x800B,
    ECT_SOE_NO_ELEMENT = 0x800C,
};

/** Data states of a procedure command. */
enum {
    ECT_SOE_COMMAND_CLEARED = 0x0000,
    ECT_SOE_COMMAND_SET = 0x0001,
    ECT_SOE_COMMAND_DONE = 0x0003,
    ECT_SOE_COMMAND_INTERRUPTED = 0x0005, /**< a device may set it */
    ECT_SOE_COMMAND_RUNS = 0x0007,
    ECT_SOE_COMMAND_ERROR = 0x000F,
};

/** Memory of a procedure command, zero at power-on. */
typedef struct ect_soe_command {
    uint16_t value; /**< as written last */
    uint16_t state; /**< ECT_SOE_COMMAND_... */
} ect_soe_command_t;

/** Memory of a list or text of at most `bytes` bytes. */
#define ECT_SOE_LIST_MEMORY(bytes)                                                                                     \
    struct {                                                                                                           \
        uint16_t used; /* bytes */                                                                                     \
        uint8_t data[bytes];                                                                                           \
    }

/** One IDN. Constant. A member that is 0 or NULL has the meaning that its line gives. */
typedef struct ect_soe_idn {
    uint16_t idn;       /**< ECT_SOE_S(n), ECT_SOE_P(n) */
    uint8_t flags;      /**< ECT_SOE_MINIMUM … ECT_SOE_CHECK_OP */
    uint32_t attribute; /**< as on the wire */
    const char *name;   /**< NULL: the element is missing */
    const char *unit;   /**< NULL: the element is missing */
    int64_t minimum;    /**< numbers: inclusive; of a float its bits */
    int64_t maximum;
    uint64_t initial;    /**< numbers: the default, or the value without memory; the bits of the number */
    const void *content; /**< lists: the default, or the value without memory, as on the wire; NULL: empty */
    uint16_t used;       /**< bytes of `content` */
    uint16_t size;       /**< lists: capacity in bytes; 0: `used` */
    uint32_t mapping;    /**< with ECT_SOE_IN_AT, ECT_SOE_IN_MDT: the element of a mapping object that stands for it:
                            ECT_MAP(index, subindex, bits) of an entry of the dictionary */
    size_t offset;       /**< of the memory in the instance, aligned; 0: constant */
} ect_soe_idn_t;

/** One drive. */
typedef struct ect_soe_drive {
    const ect_soe_idn_t *idns; /**< ascending */
    uint16_t count;
    uint16_t mdt;        /**< index of the mapping object of its MDT; 0: none, S-0-0024 changes no process data */
    uint16_t at;         /**< of its AT; 0: none */
    bool command_change; /**< the stack sets bit 5 of S-0-0135 (command change): 1 while a command has ended and is not
                            cleared */
} ect_soe_drive_t;

/** A waiting emergency. Private. */
typedef struct ect_soe_emergency {
    uint16_t code;
    uint8_t drive;
    uint8_t error_register;
    uint8_t data[5];
} ect_soe_emergency_t;

/** State of SoE, in the device's instance, zero at power-on. Private, except the first two members. */
typedef struct ect_soe_state {
    uint32_t emergencies_lost; /**< the queue was full; wraps */
    bool notifies;             /**< the device may set it: notifications as with ect_soe_t::notifies */

    ect_slave_t *slave; /* NULL until the mailbox has started */
    uint16_t length;    /* bytes in the buffer: of a reply, or of a write so far */
    uint16_t sent;      /* of a reply */
    uint16_t idn;
    uint8_t phase;    /* of the buffer */
    uint8_t head;     /* operation and drive */
    uint8_t elements; /* of the request */
    bool too_long;    /* a write does not fit the buffer */
    uint8_t emergency_put, emergency_got;
    uint8_t notices; /* drives with a command whose end is not reported, one bit each */
    uint16_t notice[ECT_SOE_DRIVES];
    ect_soe_emergency_t emergency[ECT_SOE_EMERGENCIES];
} ect_soe_state_t;

/** SoE of a device. Each function gets the entry, which may be the first member of a larger constant structure, and the
 * device's instance. Any function may be NULL. */
typedef struct ect_soe ect_soe_t;
struct ect_soe {
    ect_protocol_t protocol; /**< ECT_SOE_PROTOCOL; the first member */
    size_t offset;           /**< of an ::ect_soe_state_t in the instance, aligned */
    size_t buffer;           /**< of the bytes for a reply or write under way, in the instance */
    uint16_t buffer_size;    /**< at least ect_soe_longest() */
    uint8_t drive_count;     /**< 1..ECT_SOE_DRIVES */
    const ect_soe_drive_t *drives;
    bool notifies; /**< sends a notification when a command has ended. Not every master expects unrequested mails of SoE
                    */

    /**
     * Called when a master reads a value: the device updates its memory. Not for values made by the stack.
     * @return ECT_SOE_OK, or the code for the master
     */
    uint16_t (*read)(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn);

    /**
     * Checks a value for a write of a master; all other checks are done. Not for commands.
     * @param data  `size` bytes as on the wire; of a list without its two length words
     * @return ECT_SOE_OK to store the value, or the code for the master
     */
    uint16_t (*write)(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn,
                      const uint8_t *data, uint16_t size);

    /** Called after a value has been written and stored. Not for commands. */
    void (*written)(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn, uint64_t now_ns);

    /**
     * Called when a master starts or cancels a command. A started command ends with ::ect_soe_finish, which may be
     * called within this function. NULL: a command ends at once, without an error.
     * @param start  false: a running command is to be cancelled
     * @return ECT_SOE_OK, or the code for the master: ECT_SOE_COMMAND_NOT_NOW, ECT_SOE_COMMAND_GOES_ON …
     */
    uint16_t (*command)(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn, bool start,
                        uint64_t now_ns);

    /** Returns whether an IDN with ECT_SOE_CHECK_..., within its limits, is valid for the AL state `target`. */
    bool (*valid)(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn, uint8_t target);
};

/** The service that checks SoE on the way to SAFEOP and OP; required for a device with SoE. */
extern const ect_service_t ect_service_soe;

ECT_C_BEGIN

/** Whether both mailboxes of a description have room for SoE, whatever length a master chooses. */
static inline bool ect_soe_fits(const ect_device_t *device)
{
    return ect_sm_shortest_mailbox(&device->sm[0]) >= ECT_SOE_MAILBOX_LEAST &&
           ect_sm_shortest_mailbox(&device->sm[1]) >= ECT_SOE_MAILBOX_LEAST;
}

/** Whether a drive's value of an IDN is made by the stack from the table: S-0-0017, S-0-0187, S-0-0188. */
static inline bool ect_soe_is_made(const ect_soe_idn_t *idn)
{
    return idn->idn == ECT_SOE_S(17) || idn->idn == ECT_SOE_S(187) || idn->idn == ECT_SOE_S(188);
}

/** The IDN of a drive, or NULL. Cost: log2(n) + 1 comparisons. */
const ect_soe_idn_t *ect_soe_find(const ect_soe_drive_t *drive, uint16_t idn);

/** Bytes that the longest reply needs, all elements of an IDN together, and hence ect_soe_t::buffer_size at least.
 * Pure. Visits all tables. */
uint32_t ect_soe_longest(const ect_soe_t *soe);

/** Sets all values with memory to their defaults: for the `init` of the device. */
void ect_soe_set_defaults(const ect_soe_t *soe, void *instance);

/**
 * Ends a running command: its data state becomes ECT_SOE_COMMAND_DONE or ECT_SOE_COMMAND_ERROR. Ignored unless it runs.
 * @param drive  0..drive_count - 1
 * @param idn    a command of that drive
 */
void ect_soe_finish(const ect_soe_t *soe, void *instance, uint8_t drive, uint16_t idn, bool success);

/**
 * Queues an emergency, which is sent when the mailbox is free; a full queue counts it as lost. Not every master expects
 * it. `data`: 5 bytes, copied.
 */
void ect_soe_emergency(const ect_soe_t *soe, void *instance, uint8_t drive, uint16_t code, uint8_t error_register,
                       const uint8_t data[5]);

/** Handles a request, for ECT_SOE_PROTOCOL only. */
uint16_t ect_soe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);
/** Sends the rest of a reply, a notification or an emergency, for ECT_SOE_PROTOCOL only. */
bool ect_soe_next(const ect_protocol_t *self, ect_slave_t *slave, bool send);
/** Drops replies and writes that are not complete, for ECT_SOE_PROTOCOL only. */
void ect_soe_reset(const ect_protocol_t *self, ect_slave_t *slave);

ECT_C_END

/** Served in PREOP, SAFEOP and OP; in BOOT its mails are refused as unsupported. */
#define ECT_SOE_PROTOCOL                                                                                               \
    {.type = ECT_MAILBOX_TYPE_SOE,                                                                                     \
     .states = ECT_IN_PREOP_AND_ABOVE,                                                                                 \
     .request = ect_soe_request,                                                                                       \
     .next = ect_soe_next,                                                                                             \
     .reset = ect_soe_reset}

#endif
