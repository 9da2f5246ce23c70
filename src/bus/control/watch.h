/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What one connection watches, and what it was told of it last.
 *
 * Two ways. By rounds: now and then all watched values are compared with what was told, a few at a time, and those that
 * differ are told; a value that came back in between is no change. Or every change: after each poll of the devices the
 * changes are noted with their time (a comparison each, nothing is written yet) and told when no frame waits.
 *
 * Context: the thread of the chain. The memory of the twins must outlive the watch.
 */
#ifndef ECT_BUS_CONTROL_WATCH_H
#define ECT_BUS_CONTROL_WATCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/signals.h"
#include "bus/control/line.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Signals that one connection can watch. */
enum { ECT_WATCH_MOST = 4096 };

typedef struct ect_watch ect_watch_t;

/** @return a watch without signals, to be freed with ::ect_watch_free; NULL: no memory. Cost: nothing until it is used.
 */
ect_watch_t *ect_watch_new(void);
void ect_watch_free(ect_watch_t *watch);

/**
 * Watches one more signal from its present value on. One that is watched already stays as it is.
 * @param slave  its place in the chain, from 0
 * @return false: there are ECT_WATCH_MOST already
 */
bool ect_watch_add(ect_watch_t *watch, const ect_signal_ref_t *ref, size_t slave);

/** How many signals are watched. */
size_t ect_watch_count(const ect_watch_t *watch);

/**
 * The twins of which a lamp is watched (bus/chain/lamps.h), whose values are made when somebody asks for them.
 * @param[out] slaves  their places in the chain, from 0; until the next ::ect_watch_add. @return how many
 */
size_t ect_watch_lamps(const ect_watch_t *watch, const size_t **slaves);

/** From now on every change is noted. */
void ect_watch_every(ect_watch_t *watch);
bool ect_watch_is_every(const ect_watch_t *watch);

/** Notes what has changed. Cost: a comparison for each signal. Only for those who want every change. */
void ect_watch_note(ect_watch_t *watch, uint64_t now_ns);

/** Begins a round, unless the last one is not over. */
void ect_watch_round(ect_watch_t *watch);

/** Whether there may be something to tell. */
bool ect_watch_pending(const ect_watch_t *watch);

/** More changes were noted than there is room for: some are lost. */
bool ect_watch_lost(const ect_watch_t *watch);

/**
 * Writes the next change. @param[in,out] budget  comparisons that may still be made
 * @return whether there was one; if not and the budget is not used up, nothing is pending any more
 */
bool ect_watch_next(ect_watch_t *watch, unsigned int *budget, uint64_t now_ns, ect_line_t *line);

/** Writes the members "slave", "name" and "value" of a signal. @param value  ect_signal_size() bytes */
void ect_watch_describe(ect_line_t *line, const ect_signal_ref_t *ref, size_t slave, const void *value);

ECT_C_END

#endif
