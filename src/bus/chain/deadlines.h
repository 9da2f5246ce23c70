/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Who wants to run when: one time for each of many, and the earliest of all at hand.
 *
 * No clock in here. Context: one thread. Cost: a change takes about log2(count) steps, the earliest one none.
 */
#ifndef ECT_BUS_CHAIN_DEADLINES_H
#define ECT_BUS_CHAIN_DEADLINES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_deadlines ect_deadlines_t;

/** Room for `count` (1..UINT32_MAX) members, none of which wants to run (UINT64_MAX). @return NULL: no memory */
ect_deadlines_t *ect_deadlines_new(size_t count);
void ect_deadlines_free(ect_deadlines_t *deadlines);

/** Sets the time of a member; UINT64_MAX: never. */
void ect_deadlines_set(ect_deadlines_t *deadlines, size_t member, uint64_t time_ns);

/** The time of a member. */
uint64_t ect_deadlines_of(const ect_deadlines_t *deadlines, size_t member);

/** The earliest of all times, and in *member (not NULL) whose it is. */
uint64_t ect_deadlines_first(const ect_deadlines_t *deadlines, size_t *member);

ECT_C_END

#endif
