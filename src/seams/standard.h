/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The standard objects that every device shares: where their data live, and their entry tables.
 *
 * The instance structure of a device begins with ::ect_standard_t. The stack keeps what is in it up to date; the
 * device lists those of the objects that it offers and copies the identity into it when it is initialised. The entry
 * tables below are offsets into that beginning, so they fit any device that follows the rule.
 *
 * Clauses: ETG.1000.6 §5.6.7, ETG.1020 (1001h, 1018h, 1C00h).
 */
#ifndef ECT_SEAMS_STANDARD_H
#define ECT_SEAMS_STANDARD_H

#include "seams/device.h"

/** Vendor id of all twins: we are none of the companies, so a placeholder of ours; a build may choose its own. */
#ifndef ECTWIN_VENDOR_ID
#define ECTWIN_VENDOR_ID 0x00000E57u
#endif
#ifndef ECTWIN_VENDOR_NAME
#define ECTWIN_VENDOR_NAME "ectwin"
#endif

/** What every instance begins with. */
typedef struct ect_standard {
    const ect_device_t *device; /**< the description, set before init; also keeps offset 0 free of entries */
    ect_identity_t identity;    /**< 1018h */
    uint8_t error_register;     /**< 1001h, kept by the stack */
} ect_standard_t;

#define ECT_STANDARD(member) ECT_OFFSET(ect_standard_t, member)

/** A constant of a VAR object. */
#define ECT_ENTRY_CONST(type, bits, access, name, value)                                                               \
    {                                                                                                                  \
        0, type, bits, access, name, value, NULL                                                                       \
    }

/** An element of an object list: one value, or a record or array whose `entries` is the array itself, sub-index 0
 * first. */
#define ECT_VAR(index, name, entries)                                                                                  \
    {                                                                                                                  \
        index, ECT_OBJECT_VAR, 0, 0, name, entries                                                                     \
    }
#define ECT_RECORD(index, name, entries)                                                                               \
    {                                                                                                                  \
        index, ECT_OBJECT_RECORD, sizeof(entries) / sizeof((entries)[0]) - 1, 0, name, entries                         \
    }
#define ECT_ARRAY(index, name, entries)                                                                                \
    {                                                                                                                  \
        index, ECT_OBJECT_ARRAY, sizeof(entries) / sizeof((entries)[0]) - 1, 0, name, entries                          \
    }

/** A constant text of a VAR object; `text` must be a literal or an array. */
#define ECT_ENTRY_TEXT(name, text)                                                                                     \
    {                                                                                                                  \
        0, ECT_TYPE_VISIBLE_STRING, 8 * (sizeof(text) - 1), ECT_ACCESS_RO | ECT_ACCESS_SHARED, name, 0,                \
            (void *)(uintptr_t)(text)                                                                                  \
    }

/** Sub-index 0: the number of entries. */
#define ECT_ENTRY_COUNT(count)                                                                                         \
    {                                                                                                                  \
        0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Number of entries", count, NULL                                      \
    }

/** One constant 32-bit element, e.g. of a fixed mapping. */
#define ECT_ENTRY_MAP(subindex, value)                                                                                 \
    {                                                                                                                  \
        subindex, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Mapped object", value, NULL                                 \
    }

/** A mapping value: index, sub-index, length in bits (1..255). */
#define ECT_MAP(index, subindex, bits) (((uint32_t)(index) << 16) | ((uint32_t)(subindex) << 8) | (uint32_t)(bits))

/** 1018h Identity. */
#define ECT_ENTRIES_IDENTITY                                                                                           \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(4),                                                                                            \
            {1, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Vendor ID", 0, ECT_STANDARD(identity.vendor_id)},             \
            {2, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Product code", 0, ECT_STANDARD(identity.product_code)},       \
            {3, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Revision number", 0, ECT_STANDARD(identity.revision)},        \
            {4, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Serial number", 0, ECT_STANDARD(identity.serial)},            \
    }

/** 1C00h SyncManager communication types of the usual layout: mailbox out, mailbox in, outputs, inputs. */
#define ECT_ENTRIES_SM_TYPES                                                                                           \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(4), {1, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "SM0 type", ECT_SM_MAILBOX_OUT, NULL},           \
            {2, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "SM1 type", ECT_SM_MAILBOX_IN, NULL},                            \
            {3, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "SM2 type", ECT_SM_OUTPUTS, NULL},                               \
            {4, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "SM3 type", ECT_SM_INPUTS, NULL},                                \
    }

/** A fixed element of 1C12h / 1C13h. */
#define ECT_ENTRY_ASSIGN(subindex, pdo)                                                                                \
    {                                                                                                                  \
        subindex, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "Assigned PDO", pdo, NULL                                    \
    }

#endif
