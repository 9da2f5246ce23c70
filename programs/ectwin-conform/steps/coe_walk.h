/* SPDX-License-Identifier: MIT */
/** @file For the cases of CoE: a walk over all objects, with their descriptions by the information service. */
#ifndef ECTWIN_CONFORM_COE_WALK_H
#define ECTWIN_CONFORM_COE_WALK_H

#include "steps/case.h"

enum { COE_VAR = 7, COE_ARRAY = 8, COE_RECORD = 9, COE_VISIBLE_STRING = 9, COE_UNICODE_STRING = 0x0B };
/** Rights by state, as the service has them. */
enum {
    COE_READ_PREOP = 0x01,
    COE_READ_SAFEOP = 0x02,
    COE_READ_OP = 0x04,
    COE_WRITE_PREOP = 0x08,
    COE_WRITE_SAFEOP = 0x10,
    COE_WRITE_OP = 0x20,
};
enum { COE_OBJECTS_MOST = 1024, COE_ENTRIES_MOST = 600, COE_NAME = 64, COE_ANSWER = 512 };
/** Optional fields of the description of an entry (ETG.1000.6), and the length of its fixed fields. */
enum {
    COE_INFO_UNIT = 0x08,
    COE_INFO_DEFAULT = 0x10,
    COE_INFO_MINIMUM = 0x20,
    COE_INFO_MAXIMUM = 0x40,
    COE_INFO_ALL = 0x7F
};
enum { COE_ENTRY_BYTES = 10 };

typedef struct coe_object {
    uint16_t index, type;
    uint8_t most;        /**< the last sub-index */
    uint8_t code;        /**< COE_VAR ... */
    char name[COE_NAME]; /**< "" none, or possibly cut off by the end of the mailbox */
} coe_object_t;

typedef struct coe_entry {
    uint16_t type, bits, access;
} coe_entry_t;

/**
 * Calls a function for each object of the slave; without the information service, for 1000h and 1018h. In PREOP.
 * @return number of objects
 */
unsigned int coe_walk(cf_t *c, void (*visit)(cf_t *c, const coe_object_t *object));
/** @return false: the slave has no such entry, or no information service */
bool coe_entry(cf_t *c, const coe_object_t *object, uint8_t sub, coe_entry_t *entry);
/**
 * The whole description of an entry.
 * @param value_info  COE_INFO_...: optional fields to request
 * @param[out] answer  COE_ANSWER bytes: index, sub-index, fields present (at 3), type, length, rights, then these
 * fields
 * @return bytes, at least COE_ENTRY_BYTES; -1: the slave has no such entry
 */
int coe_describe_entry(cf_t *c, uint16_t index, uint8_t sub, uint8_t value_info, uint8_t *answer);
/** @return whether a reply of that many bytes fills the mailbox: a name at its end may be cut off */
bool coe_is_full(const cf_t *c, int bytes);

#endif
