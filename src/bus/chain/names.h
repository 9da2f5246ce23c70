/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Names of twins: "gripper" in `gripper.data1` and in the fault `hang slave gripper`.
 *
 * A name begins with a letter a to z, followed by letters, digits, _ and -, so no name is a number. Names are unique.
 * Context: any. Cost: linear in the characters of a name; ::ect_names_new is linear in the twins.
 */
#ifndef ECT_BUS_CHAIN_NAMES_H
#define ECT_BUS_CHAIN_NAMES_H

#include <stdbool.h>
#include <stddef.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Room for a name, terminator included. */
enum { ECT_NAME_ROOM = 32 };

typedef struct ect_names ect_names_t;

/** @param count  twins of the bus. @return a list in which no twin has a name; NULL: no memory */
ect_names_t *ect_names_new(size_t count);

/** Frees the list. NULL: no effect */
void ect_names_free(ect_names_t *names);

/** @return the length of the name at the beginning of a text; 0: none, or longer than ECT_NAME_ROOM - 1 */
size_t ect_name_begins(const char *text);

/**
 * Names a twin without a name.
 * @param position  0..count - 1
 * @param name      a valid name (::ect_name_begins); copied
 * @return false: another twin has the name; no effect
 */
bool ect_names_add(ect_names_t *names, size_t position, const char *name);

/** @param names  NULL: none @return the number of the twin with this name, from 1; 0: none */
size_t ect_names_find(const ect_names_t *names, const char *name, size_t length);

/** @param names  NULL: none @return the name of the twin at a position; NULL: none */
const char *ect_names_at(const ect_names_t *names, size_t position);

ECT_C_END

#endif
