/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Deadlines: one time for each of many members, and the earliest of all.
 *
 * This file uses no clock. Context: one thread. Cost: log2(count) steps for a change, constant for the earliest.
 */
#ifndef ECT_BUS_CHAIN_DEADLINES_H
#define ECT_BUS_CHAIN_DEADLINES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_deadlines ect_deadlines_t;

/** Makes deadlines of `count` (1..UINT32_MAX) members, all UINT64_MAX (never). @return NULL: out of memory */
ect_deadlines_t *ect_deadlines_new(size_t count);
void ect_deadlines_free(ect_deadlines_t *deadlines);

/** Sets the time of a member; UINT64_MAX: never. */
void ect_deadlines_set(ect_deadlines_t *deadlines, size_t member, uint64_t time_ns);

/** @return the time of a member. */
uint64_t ect_deadlines_of(const ect_deadlines_t *deadlines, size_t member);

/** @return the earliest of all times. @param[out] member  the member with that time; not NULL */
uint64_t ect_deadlines_first(const ect_deadlines_t *deadlines, size_t *member);

ECT_C_END

#endif
