/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The object dictionary: the data that a slave offers by SDO and PDO, as constant tables over caller-owned memory.
 *
 * An object list is an array of ::ect_object_t sorted by index, each with its entries sorted by sub-index. The two
 * descriptors have the layout of SOES's `_objectlist` and `_objd`, so that a list written for SOES is used by cast.
 * `data` of an entry is an address; in a list with a base (::ect_od_t::base) it is an offset into that instance, so
 * one table in flash serves one instance in a firmware and a thousand in a process.
 *
 * Ownership: the list, its entries, its names and the second table are constant and belong to the device; the instance
 * belongs to the caller. No function allocates, blocks or keeps a pointer. A returned pointer points into the list or
 * the instance and is valid as long as they are. Pointer arguments must not be NULL unless the text allows it.
 *
 * Context: any that owns the instance data; the stack calls from mainline, and from the cyclic exchange for process
 * data (docs/CONCURRENCY.md). Functions over a list alone are pure.
 *
 * Cost: finding an object or a detail takes log2(n) + 1 comparisons, finding an entry of an object as many steps as its
 * position, a transfer as many as its bytes. No function accesses the PDI.
 *
 * Errors: a mistake of the master is an ::ect_reason_t and becomes an abort code; a slice beyond an entry is a mistake
 * of the caller and is asserted. With any result other than ECT_OK, neither the instance nor a result has been written,
 * except where the text states it.
 *
 * Clauses: ETG.1000.6 §5.6 (CoE), ETG.1020 (data types, object codes), CiA 301 (abort codes).
 */
#ifndef ECT_OD_OD_H
#define ECT_OD_OD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Object codes (ETG.1000.6 §5.6.3.6.1). */
enum { ECT_OBJECT_DOMAIN = 2, ECT_OBJECT_VAR = 7, ECT_OBJECT_ARRAY = 8, ECT_OBJECT_RECORD = 9 };

/** Data types (ETG.1020). BOOLEAN and BITn occupy one byte of instance data each and n bits on the wire. */
enum {
    ECT_TYPE_NONE = 0x0000,
    ECT_TYPE_BOOLEAN = 0x0001,
    ECT_TYPE_INTEGER8 = 0x0002,
    ECT_TYPE_INTEGER16 = 0x0003,
    ECT_TYPE_INTEGER32 = 0x0004,
    ECT_TYPE_UNSIGNED8 = 0x0005,
    ECT_TYPE_UNSIGNED16 = 0x0006,
    ECT_TYPE_UNSIGNED32 = 0x0007,
    ECT_TYPE_REAL32 = 0x0008,
    ECT_TYPE_VISIBLE_STRING = 0x0009,
    ECT_TYPE_OCTET_STRING = 0x000A,
    ECT_TYPE_REAL64 = 0x0011,
    ECT_TYPE_INTEGER64 = 0x0015,
    ECT_TYPE_UNSIGNED64 = 0x001B,
    ECT_TYPE_PDO_MAPPING = 0x0021,
    ECT_TYPE_IDENTITY = 0x0023,
    ECT_TYPE_SM_SYNC = 0x0029,
    ECT_TYPE_RECORD = 0x002A,
    ECT_TYPE_BITARR8 = 0x002D,
    ECT_TYPE_BITARR16 = 0x002E,
    ECT_TYPE_BITARR32 = 0x002F,
    ECT_TYPE_BIT1 = 0x0030,
    ECT_TYPE_BIT8 = 0x0037,
};

/** Access bits of an entry (ETG.1000.6 §5.6.3.6.3); these are the bits that SDO information reports. */
enum {
    ECT_ACCESS_R_PREOP = 0x0001,
    ECT_ACCESS_R_SAFEOP = 0x0002,
    ECT_ACCESS_R_OP = 0x0004,
    ECT_ACCESS_W_PREOP = 0x0008,
    ECT_ACCESS_W_SAFEOP = 0x0010,
    ECT_ACCESS_W_OP = 0x0020,
    ECT_ACCESS_RXPDO = 0x0040,
    ECT_ACCESS_TXPDO = 0x0080,
    ECT_ACCESS_BACKUP = 0x0100,
    ECT_ACCESS_SETTING = 0x0200,
    ECT_ACCESS_RO = 0x0007,
    ECT_ACCESS_WO = 0x0038,
    ECT_ACCESS_RW = 0x003F,
    ECT_ACCESS_RW_PREOP = 0x000F,
    ECT_ACCESS_WIRE = 0x0FFF, /**< the bits that SDO information reports; the higher ones are internal */
    /** `data` is an offset into the list's description (::ect_od_t::description): a read-only constant. For a text it
     * is the offset of the pointer to the text. */
    ECT_ACCESS_DESCRIPTION = 0x2000,
    /** A write is a command that hooks execute; nothing is stored, and the entry reads as `value`. */
    ECT_ACCESS_COMMAND = 0x4000,
    /** `data` is an address even in a list with a base: a constant that all instances share. */
    ECT_ACCESS_SHARED = 0x8000,
};

/**
 * One entry (sub-index). Same members, order and types as SOES `_objd`.
 *
 * data == NULL (offset 0 in a list with a base): the entry has no memory and reads as `value`.
 */
typedef struct ect_entry {
    uint16_t subindex;   /**< 0..255, ascending in the object's table */
    uint16_t data_type;  /**< ECT_TYPE_... */
    uint16_t bit_length; /**< on the wire; strings: 8 × their capacity; 0: only the device's hook knows the length */
    uint16_t access;     /**< ECT_ACCESS_... */
    const char *name;    /**< may be NULL; zero-terminated, shared */
    uint32_t value;      /**< default, unless ect_detail_t::initial overrides it; value of an entry without memory */
    void *data;          /**< address, or offset into the instance (ECT_OFFSET) */
} ect_entry_t;

/**
 * One object (index). Same members, order and types as SOES `_objectlist`. In a list of SOES `last` is padding and 0,
 * and `max_subindex` is the position of the last element, whatever its sub-index. Sub-index and position differ only in
 * a record with gaps; ::ect_od_last finds the last element in both kinds of list.
 */
typedef struct ect_object {
    uint16_t index;       /**< ascending in the list */
    uint16_t object_code; /**< ECT_OBJECT_... */
    uint8_t max_subindex; /**< sub-index of the last element of `entries`, or with `last` 0 its position; 0 for a VAR */
    uint8_t last;         /**< position of the last element: the number of entries, minus one; 0 in a list of SOES */
    const char *name;     /**< zero-terminated, shared */
    const ect_entry_t *entries;
} ect_object_t;

/** Properties of an entry that SOES's descriptor lacks: a second table beside the list, sorted by index and sub-index.
 */
typedef struct ect_detail {
    uint16_t index;
    uint8_t subindex;
    uint16_t unit;   /**< ETG.1004, prefix and numerator as SDO information has them; 0: none */
    uint8_t per;     /**< ETG.1004, denominator; 0: none */
    int64_t minimum; /**< inclusive; minimum == maximum: no limits */
    int64_t maximum; /**< inclusive */
    const void
        *initial; /**< default longer than 32 bits: ect_od_bytes() of wire form, texts zero-terminated; or NULL */
} ect_detail_t;

/** An element of the second table: unit and limits of a number. */
#define ECT_LIMITS(index, subindex, unit, minimum, maximum) ECT_LIMITS_PER(index, subindex, unit, 0, minimum, maximum)
/** An element of the second table with a denominator of the unit. */
#define ECT_LIMITS_PER(index, subindex, unit, per, minimum, maximum)                                                   \
    {index, subindex, unit, per, minimum, maximum, NULL}

/** An object list together with an instance. A small value that may be copied freely. */
typedef struct ect_od {
    const ect_object_t *objects;
    uint16_t count;
    const ect_detail_t *details; /**< may be NULL */
    uint16_t detail_count;
    void *base;              /**< the instance that `data` offsets refer to; NULL: `data` are addresses */
    const void *description; /**< base of the offsets with ECT_ACCESS_DESCRIPTION; NULL: no entry has this bit */
} ect_od_t;

/** `data` of an entry in a list with a base. The first member of an instance cannot be an entry (offset 0 = none). */
#define ECT_OFFSET(type, member) ((void *)offsetof(type, member))

/** An entry whose value lies in `member` of the instance type: ECT_ENTRY(1, UNSIGNED8, 8, ECT_ACCESS_RO, ...). */
#define ECT_ENTRY(subindex, kind, bits, access, name, value, type, member)                                             \
    {subindex, ECT_TYPE_##kind, bits, access, name, value, ECT_OFFSET(type, member)}

/**
 * Reason to refuse a request to the dictionary; each has one abort code (::ect_abort_code). Hooks of a device return
 * these, or any abort code itself, which is a number above 0xFFFF. The order is internal; the codes are those of CiA
 * 301 and ETG.1000.6 Table 41.
 */
typedef uint32_t ect_reason_t;

/** Every reason: R(NAME, abort code). NAME stands for ECT_REASON_NAME. */
#define ECT_REASONS(R)                                                                                                 \
    R(TOGGLE, 0x05030000)                                                                                              \
    R(TIMEOUT, 0x05040000)                                                                                             \
    R(COMMAND, 0x05040001)                                                                                             \
    R(MEMORY, 0x05040005)                                                                                              \
    R(UNSUPPORTED, 0x06010000)                                                                                         \
    R(WRITE_ONLY, 0x06010001)                                                                                          \
    R(READ_ONLY, 0x06010002)                                                                                           \
    R(SUBINDEX0, 0x06010003)       /* sub-index 0 must be 0 first */                                                   \
    R(VARIABLE_LENGTH, 0x06010004) /* no Complete Access to objects of variable length */                              \
    R(MAILBOX_SIZE, 0x06010005)                                                                                        \
    R(MAPPED, 0x06010006)                                                                                              \
    R(NO_OBJECT, 0x06020000)                                                                                           \
    R(NOT_MAPPABLE, 0x06040041)                                                                                        \
    R(PDO_LENGTH, 0x06040042)                                                                                          \
    R(INCOMPATIBLE, 0x06040043)                                                                                        \
    R(INTERNAL, 0x06040047)                                                                                            \
    R(HARDWARE, 0x06060000)                                                                                            \
    R(LENGTH, 0x06070010)                                                                                              \
    R(TOO_LONG, 0x06070012)                                                                                            \
    R(TOO_SHORT, 0x06070013)                                                                                           \
    R(NO_SUBINDEX, 0x06090011)                                                                                         \
    R(RANGE, 0x06090030)                                                                                               \
    R(TOO_HIGH, 0x06090031)                                                                                            \
    R(TOO_LOW, 0x06090032)                                                                                             \
    R(MODULES, 0x06090033)                                                                                             \
    R(MIN_MAX, 0x06090036)                                                                                             \
    R(RESOURCE, 0x060A0023)                                                                                            \
    R(GENERAL, 0x08000000)                                                                                             \
    R(STORE, 0x08000020)                                                                                               \
    R(LOCAL_CONTROL, 0x08000021)                                                                                       \
    R(STATE, 0x08000022)                                                                                               \
    R(NO_DICTIONARY, 0x08000023)                                                                                       \
    R(NO_DATA, 0x08000024)

#define ECT_REASON_ROW(name, code) ECT_REASON_##name,
enum { ECT_OK = 0, ECT_REASONS(ECT_REASON_ROW) ECT_REASON_COUNT };
#undef ECT_REASON_ROW

/**
 * The SDO abort code of a reason (ETG.1000.6 Table 41, Q179 §1-1).
 * @param reason  ECT_REASON_TOGGLE..ECT_REASON_COUNT-1, or an abort code itself (above 0xFFFF); any other value counts
 * as ECT_REASON_GENERAL
 * @return the 32-bit code, e.g. 0x06020000
 */
uint32_t ect_abort_code(ect_reason_t reason);

/**
 * Finds an object.
 * @param od     the list; its instance is not used
 * @param index  0..0xFFFF
 * @return the object, or NULL when the list has no such index
 */
const ect_object_t *ect_od_find(const ect_od_t *od, uint16_t index);

/**
 * Finds an entry of an object; gaps between sub-indices are allowed.
 * @param object    of any list
 * @param subindex  0..255
 * @return the entry, or NULL when the object has no such sub-index
 */
const ect_entry_t *ect_od_entry(const ect_object_t *object, uint8_t subindex);

/** The last entry of an object, in a list of either kind. Its sub-index is the highest of the object. */
static inline const ect_entry_t *ect_od_last(const ect_object_t *object)
{
    return object->entries + (object->last != 0 ? object->last : object->max_subindex);
}

/** The next entry in the object's table, or NULL after the last. */
static inline const ect_entry_t *ect_od_next(const ect_object_t *object, const ect_entry_t *entry)
{
    return entry < ect_od_last(object) ? entry + 1 : NULL;
}

/**
 * Finds an entry by index and sub-index (ETG.1000.6 §5.6.2).
 * @param od               the list; its instance is not used
 * @param index, subindex  0..0xFFFF, 0..255
 * @param[out] object      NULL when the list has no such index
 * @param[out] entry       NULL when there is no such entry
 * @return ECT_OK · ECT_REASON_NO_OBJECT · ECT_REASON_NO_SUBINDEX
 */
ect_reason_t ect_od_lookup(const ect_od_t *od, uint16_t index, uint8_t subindex, const ect_object_t **object,
                           const ect_entry_t **entry);

/** Direction of an access, from the view of the master. */
typedef enum ect_direction { ECT_UPLOAD, ECT_DOWNLOAD } ect_direction_t;

/**
 * Checks the access rights of an entry in an AL state.
 * @param entry      of any object
 * @param direction  of the access
 * @param al_state   2 PREOP, 4 SAFEOP, 8 OP; every other state allows no access
 * @return ECT_OK · ECT_REASON_WRITE_ONLY / ECT_REASON_READ_ONLY (in no state) · ECT_REASON_STATE (not in this state)
 */
ect_reason_t ect_od_check_access(const ect_entry_t *entry, ect_direction_t direction, uint8_t al_state);

/** Bytes of an entry on the wire in a transfer of its own: bit_length rounded up. */
static inline uint16_t ect_od_bytes(const ect_entry_t *entry)
{
    return (uint16_t)((entry->bit_length + 7u) / 8u);
}

/** True for BOOLEAN and BIT1..BIT8: types that Complete Access and PDOs pack bit by bit. */
bool ect_od_is_bits(const ect_entry_t *entry);

/** True for VISIBLE_STRING: an upload transfers only the characters before the terminator. */
static inline bool ect_od_is_string(const ect_entry_t *entry)
{
    return entry->data_type == ECT_TYPE_VISIBLE_STRING;
}

/**
 * The memory of an entry's value: in the instance, in the description, or at the entry's own address.
 * @return NULL: the entry has no memory and reads as `value`
 */
void *ect_od_data(const ect_od_t *od, const ect_entry_t *entry);

/** Length of an entry in bits, as SDO information reports it: `bit_length`, or the length of a text of the description.
 */
uint16_t ect_od_bits(const ect_od_t *od, const ect_entry_t *entry);

/** Bytes that an upload of this entry transfers now: ect_od_bytes(entry), or the present length of a string. */
uint16_t ect_od_upload_size(const ect_od_t *od, const ect_entry_t *entry);

/**
 * Copies a slice of an entry's wire form (little-endian) to a buffer. Does not check access rights.
 * @param od, entry       an entry of this list
 * @param offset, length  bytes; offset + length <= ect_od_bytes(entry) (asserted)
 * @param[out] buffer     `length` bytes, the caller's; the unused bits of a BOOLEAN or BITn are 0
 */
void ect_od_read(const ect_od_t *od, const ect_entry_t *entry, uint16_t offset, void *buffer, uint16_t length);

/**
 * Writes a slice of an entry's wire form into the instance. Does not check access rights and limits. Numbers of 2, 4
 * and 8 bytes must be written in one piece (asserted), strings and octets in any pieces. A string is terminated when a
 * piece ends before the end of its memory.
 * @param od, entry       an entry of this list
 * @param offset, length  bytes; offset + length <= ect_od_bytes(entry) (asserted)
 * @param buffer          `length` bytes, only read
 * @return ECT_OK · ECT_REASON_READ_ONLY: the entry has no memory of its own, and nothing has changed
 */
ect_reason_t ect_od_write(const ect_od_t *od, const ect_entry_t *entry, uint16_t offset, const void *buffer,
                          uint16_t length);

/**
 * Sets all entries with memory in the instance to their defaults. The memory must be zero on entry, because a default
 * of 0 is not written. Entries that share memory should have the same default; the last one takes effect.
 */
void ect_od_set_defaults(const ect_od_t *od);

/** The row of an entry in the second table, or NULL. */
const ect_detail_t *ect_od_detail(const ect_od_t *od, uint16_t index, uint8_t subindex);

/**
 * Checks a new value, in wire form, against the limits in the second table.
 * @param od, index, entry  an entry of this list
 * @param bytes             ect_od_bytes(entry) bytes, little-endian
 * @return ECT_OK (also without limits, and for entries that are no integers) · ECT_REASON_TOO_HIGH · ECT_REASON_TOO_LOW
 */
ect_reason_t ect_od_check_limit(const ect_od_t *od, uint16_t index, const ect_entry_t *entry, const void *bytes);

/**
 * Reads an entry of at most 32 bits as a number, zero-extended: for the stack's own use of 1C1xh, 16xxh and 1Axxh.
 * @param od               the list and its instance
 * @param index, subindex  0..0xFFFF, 0..255
 * @param[out] value       unchanged unless ECT_OK
 * @return ECT_OK · ECT_REASON_NO_OBJECT · ECT_REASON_NO_SUBINDEX
 */
ect_reason_t ect_od_number(const ect_od_t *od, uint16_t index, uint8_t subindex, uint32_t *value);

ECT_C_END

#endif
