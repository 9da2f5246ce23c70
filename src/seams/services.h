/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Object services: standard objects with behaviour, which a device names and the stack provides.
 *
 * A description lists the services that its objects need; a service that no description lists is not linked. The data
 * of a service lie in the device's instance, in the structure defined here, and the dictionary entries of its objects
 * point into it.
 */
#ifndef ECT_SEAMS_SERVICES_H
#define ECT_SEAMS_SERVICES_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** A service of the stack; opaque to devices. */
typedef struct ect_service ect_service_t;

/**
 * Changeable 16xxh, 1Axxh, 1C12h, 1C13h (CF-074): a master may write entries only while sub-index 0 is 0, and the count
 * last. Every mapped object must exist, be mappable in that direction at its full length, and fit the SyncManager;
 * every assigned PDO must exist and occur once. The entries have ECT_ACCESS_RW_PREOP. With Complete Access, the whole
 * object is checked first.
 */
extern const ect_service_t ect_service_pdo_config;

/** 10F3h Diagnosis history (ETG.1020 §16) over ::ect_diagnosis_t. */
extern const ect_service_t ect_service_diagnosis;

/** 1010h Store and 1011h Restore (CiA 301) of all entries with ECT_ACCESS_BACKUP, through ect_host_t::storage. */
extern const ect_service_t ect_service_store;

/** 1C32h, 1C33h, 10F1h (ETG.1020 §13) over ::ect_sync_data_t: checks of mode and cycle on the way to SAFEOP, and missed
 * events. Too many successive missed events end OP with 0x001A, a SYNC0 that no longer occurs with 0x002C. */
extern const ect_service_t ect_service_sync;

/** Calls ::ect_device_t::cyclic, which needs this service. It has no objects. It recognises outputs by the events of
 * their SyncManagers. */
extern const ect_service_t ect_service_rhythm;

/* --- 10F3h ------------------------------------------------------------------------------------------------------- */

enum {
    ECT_DIAGNOSIS_MESSAGES = 8, /**< capacity of the history */
    ECT_DIAGNOSIS_BYTES = 24,   /**< length of a message: 16, and two parameters of 16 bits with their types */
};

/** Type of a message. */
enum { ECT_DIAGNOSIS_INFO = 0, ECT_DIAGNOSIS_WARNING = 1, ECT_DIAGNOSIS_ERROR = 2 };

/** Bits of 10F3h:5. */
enum {
    ECT_DIAGNOSIS_EMERGENCY = 0x0001, /**< send an emergency for each message */
    ECT_DIAGNOSIS_NO_INFO = 0x0002,   /**< do not record messages of this type */
    ECT_DIAGNOSIS_NO_WARNING = 0x0004,
    ECT_DIAGNOSIS_NO_ERROR = 0x0008,
    ECT_DIAGNOSIS_ACKNOWLEDGE = 0x0010, /**< when full: keep the old messages (else: overwrite the oldest) */
    ECT_DIAGNOSIS_LOST = 0x0020,        /**< read only: messages were overwritten unacknowledged, or not recorded */
};

/** Data of 10F3h; the entry of sub-index 1 must point to `maximum`. */
typedef struct ect_diagnosis {
    uint8_t maximum;      /**< :1 */
    uint8_t newest;       /**< :2 sub-index of the newest message, 0: none */
    uint8_t acknowledged; /**< :3 sub-index of the newest message that the master has acknowledged */
    uint8_t available;    /**< :4 there are unacknowledged messages */
    uint16_t flags;       /**< :5 ECT_DIAGNOSIS_... */
    uint8_t messages[ECT_DIAGNOSIS_MESSAGES][ECT_DIAGNOSIS_BYTES]; /**< :6 and following */
} ect_diagnosis_t;

/** Entries of 10F3h for an instance type with a member of type ect_diagnosis_t. */
#define ECT_ENTRIES_DIAGNOSIS(t, m)                                                                                    \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(5 + ECT_DIAGNOSIS_MESSAGES),                                                                   \
        ECT_ENTRY(1, UNSIGNED8, 8, ECT_ACCESS_RO, "Maximum messages", ECT_DIAGNOSIS_MESSAGES, t, m.maximum),           \
        ECT_ENTRY(2, UNSIGNED8, 8, ECT_ACCESS_RO, "Newest message", 0, t, m.newest),                                   \
        ECT_ENTRY(3, UNSIGNED8, 8, ECT_ACCESS_RW, "Newest acknowledged message", 0, t, m.acknowledged),                \
        ECT_ENTRY(4, BOOLEAN, 1, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "New messages available", 0, t, m.available),       \
        ECT_ENTRY(5, UNSIGNED16, 16, ECT_ACCESS_RW, "Flags", 0, t, m.flags),                                           \
        ECT_ENTRY_DIAGNOSIS(t, m, 0),                                                                                  \
        ECT_ENTRY_DIAGNOSIS(t, m, 1),                                                                                  \
        ECT_ENTRY_DIAGNOSIS(t, m, 2),                                                                                  \
        ECT_ENTRY_DIAGNOSIS(t, m, 3),                                                                                  \
        ECT_ENTRY_DIAGNOSIS(t, m, 4),                                                                                  \
        ECT_ENTRY_DIAGNOSIS(t, m, 5),                                                                                  \
        ECT_ENTRY_DIAGNOSIS(t, m, 6),                                                                                  \
        ECT_ENTRY_DIAGNOSIS(t, m, 7),                                                                                  \
    }
#define ECT_ENTRY_DIAGNOSIS(t, m, n)                                                                                   \
    ECT_ENTRY(6 + (n), OCTET_STRING, 8 * ECT_DIAGNOSIS_BYTES, ECT_ACCESS_RO, "Diagnosis message", 0, t, m.messages[n])

/* --- 1C32h, 1C33h, 10F1h ----------------------------------------------------------------------------------------- */

/** Synchronisation types, 1C32h:1. */
enum { ECT_SYNC_FREE_RUN = 0, ECT_SYNC_SM = 1, ECT_SYNC_DC_SYNC0 = 2 };

/** Data of 1C32h, 1C33h and 10F1h. The entry 1C32h:1, or 1C33h:1 of a device without outputs, must point to `type`. */
typedef struct ect_sync_data {
    uint16_t type;           /**< 1C32h:1, 1C33h:1 */
    uint32_t cycle_ns;       /**< :2 */
    uint16_t supported;      /**< :4 */
    uint32_t minimum_ns;     /**< :5 */
    uint16_t sm_missed;      /**< :11 SYNC0 without new outputs; never counts in a device without outputs */
    uint16_t cycle_exceeded; /**< :12 second write of outputs within one SYNC0 cycle */
    uint8_t sync_error;      /**< :32 the last cycle had an error */
    uint32_t error_reaction; /**< 10F1h:1 */
    uint16_t error_limit;    /**< 10F1h:2 tolerated successive missed events, one more is a sync error; 0: no limit */
    uint16_t errors;         /**< successive missed events; no object */
    uint8_t outputs_new;     /**< outputs were written since the last SYNC0; no object */
    uint8_t dc;              /**< SYNC0 is active, regardless of `type`; no object */
    uint8_t sync0;           /**< previous level of the SYNC0 event; no object */
    uint64_t sync0_ns;       /**< time of the last SYNC0; 0: none since SAFEOP; no object */
} ect_sync_data_t;

/** Entries of 1C32h or 1C33h for an instance type with a member of type ect_sync_data_t. */
#define ECT_ENTRIES_SYNC(t, m)                                                                                         \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(32),                                                                                           \
        ECT_ENTRY(1, UNSIGNED16, 16, ECT_ACCESS_RW_PREOP, "Synchronization type", 0, t, m.type),                       \
        ECT_ENTRY(2, UNSIGNED32, 32, ECT_ACCESS_RO, "Cycle time", 0, t, m.cycle_ns),                                   \
        ECT_ENTRY(4, UNSIGNED16, 16, ECT_ACCESS_RO, "Synchronization types supported", 0, t, m.supported),             \
        ECT_ENTRY(5, UNSIGNED32, 32, ECT_ACCESS_RO, "Minimum cycle time", 0, t, m.minimum_ns),                         \
        {6, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Calc and copy time", 0, NULL},                                    \
        ECT_ENTRY(11, UNSIGNED16, 16, ECT_ACCESS_RO, "SM event missed", 0, t, m.sm_missed),                            \
        ECT_ENTRY(12, UNSIGNED16, 16, ECT_ACCESS_RO, "Cycle time too small", 0, t, m.cycle_exceeded),                  \
        ECT_ENTRY(32, BOOLEAN, 1, ECT_ACCESS_RO, "Sync error", 0, t, m.sync_error),                                    \
    }

/** Entries of 10F1h. */
#define ECT_ENTRIES_ERROR_SETTINGS(t, m)                                                                               \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(2),                                                                                            \
        ECT_ENTRY(1, UNSIGNED32, 32, ECT_ACCESS_RW, "Local error reaction", 1, t, m.error_reaction),                   \
        ECT_ENTRY(2, UNSIGNED16, 16, ECT_ACCESS_RW, "Sync error counter limit", 4, t, m.error_limit),                  \
    }

/* --- 1010h, 1011h ------------------------------------------------------------------------------------------------ */

/** Values to write: "save" and "load" (CiA 301). */
#define ECT_STORE_SIGNATURE 0x65766173u
#define ECT_LOAD_SIGNATURE  0x64616F6Cu

/** Entries of 1010h (save) or 1011h (load): sub-index 1 reads as 1, "on command". */
#define ECT_ENTRIES_STORE(name)                                                                                        \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(1),                                                                                            \
        {1, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW | ECT_ACCESS_COMMAND, name, 1, NULL},                               \
    }

ECT_C_END

#endif
