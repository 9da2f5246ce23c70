/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The last events of a chain: changes of AL states and AL status codes, and CoE emergencies. Internal to bus/control.
 *
 * Events have numbers from 1 on; the last ECT_EVENTS are kept. Context: the thread of the chain.
 */
#ifndef ECT_BUS_CONTROL_EVENTS_H
#define ECT_BUS_CONTROL_EVENTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/control/line.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Events that are kept. */
enum { ECT_EVENTS = 256 };

typedef struct ect_events ect_events_t;

/** Starts recording; the present state of the chain is not an event. @return NULL: not enough memory */
ect_events_t *ect_events_new(const ect_chain_t *chain);
/** Frees the events. NULL: no effect */
void ect_events_free(ect_events_t *events);

/** Records the difference between a twin and its state at the last call. Cost: two comparisons without a difference. */
void ect_events_look(ect_events_t *events, const ect_chain_t *chain, size_t position, uint64_t now_ns);

/**
 * Writes the first kept event after a number, in the form of docs/CONTROL.md.
 * @param[in,out] number  of the previous event, 0 at the beginning; set to that of the written event
 * @param start_ns        start of the bus
 * @return false: no such event; nothing has changed
 */
bool ect_events_next(const ect_events_t *events, const ect_chain_t *chain, uint64_t *number, uint64_t start_ns,
                     ect_line_t *line);

ECT_C_END

#endif
