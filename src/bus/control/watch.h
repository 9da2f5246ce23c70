/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The signals that one connection watches, and the values reported last.
 *
 * There are two modes. In rounds: at intervals all watched values are compared with the reported ones, a few at a time,
 * and differing ones are reported; a value that returned in between is no change. Every change: after each poll of the
 * devices changes are recorded with their time, at a comparison each, and written when no frame waits. In both, a
 * signal with a turn (ect_signal_t) precedes the changed values that its own change may have replaced.
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

/** Most signals that one connection watches. */
enum { ECT_WATCH_MOST = 4096 };

typedef struct ect_watch ect_watch_t;

/** Makes a watch without signals, to be freed with ::ect_watch_free. @return NULL: out of memory */
ect_watch_t *ect_watch_new(void);
void ect_watch_free(ect_watch_t *watch);

/**
 * Watches one more signal, from its present value on. No effect for a signal that is watched already.
 * @param slave  position in the chain, from 0
 * @return false: ECT_WATCH_MOST are watched already
 */
bool ect_watch_add(ect_watch_t *watch, const ect_signal_ref_t *ref, size_t slave);

/** The number of signals that are watched. */
size_t ect_watch_count(const ect_watch_t *watch);

/**
 * The twins of which a lamp is watched (bus/chain/lamps.h): their lamps need an update before a comparison.
 * @param[out] slaves  positions in the chain, from 0; valid until the next ::ect_watch_add. @return their number
 */
size_t ect_watch_lamps(const ect_watch_t *watch, const size_t **slaves);

/** Switches to the mode "every change". */
void ect_watch_every(ect_watch_t *watch);
bool ect_watch_is_every(const ect_watch_t *watch);

/** Records changes. Only in the mode "every change". Cost: a comparison a signal. */
void ect_watch_record(ect_watch_t *watch, uint64_t now_ns);

/** Begins a round, unless one is under way. */
void ect_watch_round(ect_watch_t *watch);

/** @return whether there may be changes to write */
bool ect_watch_pending(const ect_watch_t *watch);

/** @return whether changes were lost, since more were recorded than there is room for */
bool ect_watch_lost(const ect_watch_t *watch);

/**
 * Writes the next change. @param[in,out] budget  comparisons left
 * @return false: none found; if the budget is not used up, nothing is pending
 */
bool ect_watch_next(ect_watch_t *watch, unsigned int *budget, uint64_t now_ns, ect_line_t *line);

/** Writes the members "slave", "twin" (where it has a name), "name" and "value" of a signal. @param value
 * ect_signal_size() bytes */
void ect_watch_describe(ect_line_t *line, const ect_signal_ref_t *ref, size_t slave, const void *value);

ECT_C_END

#endif
