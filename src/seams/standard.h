/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The standard objects that all devices share: the place of their data, and their entry tables.
 *
 * The instance structure of a device begins with ::ect_standard_t, which the stack keeps up to date. A device lists the
 * objects that it offers by the macros ECT_OBJECT_... below. Their content follows from the description and from
 * ::ect_standard_t, so a device repeats none of it.
 *
 * Clauses: ETG.1000.6 §5.6.7, ETG.1020 (1001h, 1018h, 1C00h).
 */
#ifndef ECT_SEAMS_STANDARD_H
#define ECT_SEAMS_STANDARD_H

#include "seams/device.h"

/** Vendor id of all twins: a placeholder, because the project is not a vendor. A build may define another one. */
#ifndef ECTWIN_VENDOR_ID
#define ECTWIN_VENDOR_ID 0x00000E57u
#endif
#ifndef ECTWIN_VENDOR_NAME
#define ECTWIN_VENDOR_NAME "ectwin"
#endif

/** The first member of every instance. */
typedef struct ect_standard {
    const ect_device_t *device; /**< the description, set before init; also keeps offset 0 free of entries */
    ect_identity_t identity;    /**< 1018h, set before init */
    uint8_t error_register;     /**< 1001h, kept by the stack */
} ect_standard_t;

/** `data` of an entry whose value is a member of ::ect_standard_t. */
#define ECT_STANDARD(member) ECT_OFFSET(ect_standard_t, member)

/** A constant of a VAR object. */
#define ECT_ENTRY_CONST(type, bits, access, name, value) {0, type, bits, access, name, value, NULL}

/** Position of the last element of an array. */
#define ECT_LAST(entries) (sizeof(entries) / sizeof((entries)[0]) - 1)

/** Elements of an object list: a single value, and a record or array whose `entries` is the array itself, with
 * sub-index 0 first and without gaps. */
#define ECT_VAR(index, name, entries)    {index, ECT_OBJECT_VAR, 0, 0, name, entries}
#define ECT_RECORD(index, name, entries) ECT_SPARSE(index, RECORD, ECT_LAST(entries), name, entries)
#define ECT_ARRAY(index, name, entries)  ECT_SPARSE(index, ARRAY, ECT_LAST(entries), name, entries)
/** A record or array with gaps between its sub-indices: `max_subindex` is the sub-index of its last element. */
#define ECT_SPARSE(index, code, max_subindex, name, entries)                                                           \
    {index, ECT_OBJECT_##code, max_subindex, ECT_LAST(entries), name, entries}

/** A constant text of a VAR object; `text` must be a literal or an array. */
#define ECT_ENTRY_TEXT(name, text)                                                                                     \
    {0, ECT_TYPE_VISIBLE_STRING,  8 * (sizeof(text) - 1), ECT_ACCESS_RO | ECT_ACCESS_SHARED, name,                     \
     0, (void *)(uintptr_t)(text)}

/** Sub-index 0: the number of elements. */
#define ECT_ENTRY_COUNT(count) {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Number of entries", count, NULL}

/** One constant 32-bit element, e.g. of a fixed mapping. */
#define ECT_ENTRY_MAP(subindex, value) {subindex, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Mapped object", value, NULL}

/** A mapping value: index, sub-index, length in bits (1..255). */
#define ECT_MAP(index, subindex, bits) (((uint32_t)(index) << 16) | ((uint32_t)(subindex) << 8) | (uint32_t)(bits))

/* --- objects of every device -------------------------------------------------------------------------------------- */

enum { ECT_TEXT_BITS = 8 * 40 /* the longest text of a description */ };

/** An entry whose value is a member of the description. */
#define ECT_ENTRY_DESCRIBED(subindex, kind, bits, name, member)                                                        \
    {subindex, ECT_TYPE_##kind, bits, ECT_ACCESS_RO | ECT_ACCESS_DESCRIPTION, name, 0, ECT_OFFSET(ect_device_t, member)}

static const ect_entry_t ect_entries_1000[] = {ECT_ENTRY_DESCRIBED(0, UNSIGNED32, 32, "Device type", device_type)};
static const ect_entry_t ect_entries_1001[] = {
    {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Error register", 0, ECT_STANDARD(error_register)}};
static const ect_entry_t ect_entries_1008[] = {
    ECT_ENTRY_DESCRIBED(0, VISIBLE_STRING, ECT_TEXT_BITS, "Device name", type_name)};
static const ect_entry_t ect_entries_1009[] = {
    ECT_ENTRY_DESCRIBED(0, VISIBLE_STRING, ECT_TEXT_BITS, "Hardware version", hardware_version)};
static const ect_entry_t ect_entries_100a[] = {
    ECT_ENTRY_DESCRIBED(0, VISIBLE_STRING, ECT_TEXT_BITS, "Software version", software_version)};
static const ect_entry_t ect_entries_1018[] = {
    ECT_ENTRY_COUNT(4),
    {1, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Vendor ID", 0, ECT_STANDARD(identity.vendor_id)},
    {2, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Product code", 0, ECT_STANDARD(identity.product_code)},
    {3, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Revision number", 0, ECT_STANDARD(identity.revision)},
    {4, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Serial number", 0, ECT_STANDARD(identity.serial)},
};
static const ect_entry_t ect_entries_1c00[] = {
    ECT_ENTRY_DESCRIBED(0, UNSIGNED8, 8, "Number of entries", sm_count),
    ECT_ENTRY_DESCRIBED(1, UNSIGNED8, 8, "SM0 type", sm[0].type),
    ECT_ENTRY_DESCRIBED(2, UNSIGNED8, 8, "SM1 type", sm[1].type),
    ECT_ENTRY_DESCRIBED(3, UNSIGNED8, 8, "SM2 type", sm[2].type),
    ECT_ENTRY_DESCRIBED(4, UNSIGNED8, 8, "SM3 type", sm[3].type),
    ECT_ENTRY_DESCRIBED(5, UNSIGNED8, 8, "SM4 type", sm[4].type),
    ECT_ENTRY_DESCRIBED(6, UNSIGNED8, 8, "SM5 type", sm[5].type),
    ECT_ENTRY_DESCRIBED(7, UNSIGNED8, 8, "SM6 type", sm[6].type),
    ECT_ENTRY_DESCRIBED(8, UNSIGNED8, 8, "SM7 type", sm[7].type),
};

/** Elements of an object list: 1000h device type, 1008h name, 1009h and 100Ah versions, all from the description. */
#define ECT_OBJECT_DEVICE_TYPE      ECT_VAR(0x1000, "Device type", ect_entries_1000)
#define ECT_OBJECT_ERROR_REGISTER   ECT_VAR(0x1001, "Error register", ect_entries_1001)
#define ECT_OBJECT_DEVICE_NAME      ECT_VAR(0x1008, "Device name", ect_entries_1008)
#define ECT_OBJECT_HARDWARE_VERSION ECT_VAR(0x1009, "Hardware version", ect_entries_1009)
#define ECT_OBJECT_SOFTWARE_VERSION ECT_VAR(0x100A, "Software version", ect_entries_100a)
/** 1018h: the identity of the installation (::ect_standard_t). */
#define ECT_OBJECT_IDENTITY ECT_RECORD(0x1018, "Identity", ect_entries_1018)
/** 1C00h for the `count` SyncManagers of the description. */
#define ECT_OBJECT_SM_TYPES(count) {0x1C00, ECT_OBJECT_ARRAY, count, count, "SyncManager type", ect_entries_1c00}

/** A fixed element of 1C12h / 1C13h. */
#define ECT_ENTRY_ASSIGN(subindex, pdo) {subindex, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "Assigned PDO", pdo, NULL}

#endif
