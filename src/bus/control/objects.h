/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Requests of the control protocol to the object dictionary of a twin (docs/CONTROL.md): `objects`, `read`, `write`.
 * Internal to bus/control.
 *
 * Context: the thread of the chain, between polls.
 */
#ifndef ECT_BUS_CONTROL_OBJECTS_H
#define ECT_BUS_CONTROL_OBJECTS_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/control/line.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Limit of bytes of a value in a line and in a request. */
enum { ECT_OBJECT_BYTES = 200 };

/** An entry of a dictionary. */
typedef struct ect_object_place {
    uint32_t index;
    uint32_t subindex;
} ect_object_place_t;

/** Reads a member, a number from 0 to `maximum`; a missing member is 0. @return whether the member is valid */
bool ect_object_number(const cJSON *request, const char *member, uint32_t maximum, uint32_t *value);

/** @return the name of a data type of the dictionary; "OTHER": a type without a name. */
const char *ect_object_type(uint16_t type);

/**
 * Adds to a line "data", the first ECT_OBJECT_BYTES bytes, and for numbers and texts "value".
 * @param bytes  `size` bytes in wire form; a text is followed by a zero byte
 */
void ect_object_put_value(ect_line_t *line, uint16_t data_type, const uint8_t *bytes, size_t size);

/** Reads the members "index" and "sub" (default 0). @return the reason of a refusal; NULL: *place is set */
const char *ect_object_place(const cJSON *request, ect_object_place_t *place);

/**
 * Writes the first entry at or after a place. Cost: log2 of the objects.
 * @param slave          from 1
 * @param[in,out] place  set to the place after the entry
 * @return false: no further entry
 */
bool ect_objects_next(const ect_od_t *od, size_t slave, ect_object_place_t *place, ect_line_t *line);

/**
 * Reads an entry.
 * @param number        of the slave, from 1
 * @param[out] message  ECT_SIGNAL_MESSAGE bytes, for a reason
 * @return the reason of a refusal; NULL: *line is complete
 */
const char *ect_object_read(ect_chain_t *chain, size_t number, const cJSON *request, ect_line_t *line, char *message);

/** Writes an entry. @param[out] message  as ::ect_object_read @return the reason of a refusal; NULL: done */
const char *ect_object_write(ect_chain_t *chain, size_t number, const cJSON *request, char *message);

ECT_C_END

#endif
