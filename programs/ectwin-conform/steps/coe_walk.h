/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A walk over all objects, with their descriptions by the information service, for the cases of CoE. Unlike the reader
 * of slaves (steps/reader.h), which repeats a request, the walk ends the case at a description that the standard does
 * not allow; and the case can transfer data at each object.
 */
#ifndef ECTWIN_CONFORM_COE_WALK_H
#define ECTWIN_CONFORM_COE_WALK_H

#include "steps/case.h"

enum { COE_VAR = 7, COE_ARRAY = 8, COE_RECORD = 9, COE_VISIBLE_STRING = 9, COE_UNICODE_STRING = 0x0B };
/** Access rights by state, as in the entry description. */
enum {
    COE_READ_PREOP = 0x01,
    COE_READ_SAFEOP = 0x02,
    COE_READ_OP = 0x04,
    COE_WRITE_PREOP = 0x08,
    COE_WRITE_SAFEOP = 0x10,
    COE_WRITE_OP = 0x20,
};
enum { COE_OBJECTS_MOST = 1024, COE_ENTRIES_MOST = 600, COE_NAME = 64 };
typedef struct coe_object {
    uint16_t index, type;
    uint8_t most;        /**< the last sub-index */
    uint8_t code;        /**< COE_VAR ... */
    char name[COE_NAME]; /**< "": none; may be truncated by the end of the mailbox */
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

#endif
