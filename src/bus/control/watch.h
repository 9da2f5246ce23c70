/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The signals watched by a connection, and the last reported values.
 *
 * There are two modes. "In rounds": at intervals all watched values are compared with the reported ones, a few at a
 * time, and differences are reported; a value that changes and returns between two rounds is not reported. "Every
 * change": after each poll of the devices, changes are recorded with their time, at the cost of one comparison for each
 * signal, and written when no frame waits. In both modes, a signal with a turn (ect_signal_t) precedes the changed
 * values that its own change may have replaced.
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

/** Limit of signals watched by a connection. */
enum { ECT_WATCH_MOST = 4096 };

typedef struct ect_watch ect_watch_t;

/** Makes a watch without signals, to be freed with ::ect_watch_free. @return NULL: out of memory */
ect_watch_t *ect_watch_new(void);
void ect_watch_free(ect_watch_t *watch);

/**
 * Watches one more signal, from its present value on. No effect if the signal is already watched.
 * @param slave  position in the chain, from 0
 * @return false: ECT_WATCH_MOST signals are already watched
 */
bool ect_watch_add(ect_watch_t *watch, const ect_signal_ref_t *ref, size_t slave);

/** @return the number of watched signals. */
size_t ect_watch_count(const ect_watch_t *watch);

/**
 * Lists the twins with a watched lamp (bus/chain/lamps.h), whose lamps must be updated before a comparison.
 * @param[out] slaves  positions in the chain, from 0; valid until the next ::ect_watch_add. @return their number
 */
size_t ect_watch_lamps(const ect_watch_t *watch, const size_t **slaves);

/** Switches to the mode "every change". */
void ect_watch_every(ect_watch_t *watch);
bool ect_watch_is_every(const ect_watch_t *watch);

/** Records changes. Only in the mode "every change". Cost: one comparison for each watched signal. */
void ect_watch_record(ect_watch_t *watch, uint64_t now_ns);

/** Begins a round, unless one is under way. */
void ect_watch_round(ect_watch_t *watch);

/** @return whether there may be changes to write */
bool ect_watch_pending(const ect_watch_t *watch);

/** @return whether changes were lost because the buffer was full */
bool ect_watch_lost(const ect_watch_t *watch);

/**
 * Writes the next change. @param[in,out] budget  number of allowed comparisons
 * @return false: none found; with `budget` above 0, no change is pending
 */
bool ect_watch_next(ect_watch_t *watch, unsigned int *budget, uint64_t now_ns, ect_line_t *line);

/** Writes the members "slave", "twin" (if the twin has a name), "name" and "value". @param value  ect_signal_size()
 * bytes */
void ect_watch_describe(ect_line_t *line, const ect_signal_ref_t *ref, size_t slave, const void *value);

ECT_C_END

#endif
