/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Plants outside this process: programs that read and set signals of the twins once in each period (docs/PLANTS.md).
 * Internal to bus/control.
 *
 * A plant is a client that has named the signals to be read and set. In each period the twins send the values to be
 * read, all of one time; the reply sets the others, all or none. A plant whose reply has not arrived by the next period
 * is late: the signals keep their values, the period is counted, and the plant gets its next step one period after the
 * reply. A plant with a signal `on` has a step at each change of this signal instead, and a timeout: a later reply is
 * dropped. The first delay and the end of a plant are reported, once each. No function waits or reads a clock.
 *
 * Context: the thread of the chain, between polls.
 */
#ifndef ECT_BUS_CONTROL_OUTSIDE_H
#define ECT_BUS_CONTROL_OUTSIDE_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/control/line.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_OUTSIDE_PLANTS = 4,          /**< most plants at a time */
    ECT_OUTSIDE_VALUES = 128,        /**< most signals that a plant reads, and most that it sets */
    ECT_OUTSIDE_VALUES_IN_LINE = 32, /**< values in a line of a step */
    ECT_OUTSIDE_NAME = 32,           /**< room for a name, terminator included */
    ECT_OUTSIDE_MESSAGE = 160,       /**< room for a report */
    ECT_OUTSIDE_PERIOD_LEAST_US = 100,
    ECT_OUTSIDE_PERIOD_MOST_US = 2000000000,
};

typedef struct ect_outside ect_outside_t;

/** The plants of a chain. Zeroed: none. */
typedef struct ect_outsides {
    ect_outside_t *plant[ECT_OUTSIDE_PLANTS];
    bool may_wait; /**< the clock is virtual: plants may request its stop during their steps */
    /** Gets a line for the user when a plant is late, or has ended; NULL: none. */
    void (*report)(void *ctx, const char *text);
    void *ctx;
} ect_outsides_t;

/** Frees all plants, without a report. */
void ect_outsides_clear(ect_outsides_t *all);

/**
 * Executes a request `plant`: adds signals to the plant of a client, and starts the plant if the request has a period.
 * @param owner         the client; only compared
 * @param slave         of signals without the name of a twin, from 1
 * @param[out] message  ECT_SIGNAL_MESSAGE bytes, for a reason
 * @return the reason of a refusal, one line: nothing has changed; NULL: done
 */
const char *ect_outside_request(ect_outsides_t *all, const void *owner, const ect_chain_t *chain, size_t slave,
                                const cJSON *request, uint64_t now_ns, char *message);

/** @return the started plant of a client; NULL: none */
ect_outside_t *ect_outside_of(const ect_outsides_t *all, const void *owner);

/** @return the started plant with a name; NULL: none */
ect_outside_t *ect_outside_named(const ect_outsides_t *all, const char *name);

/**
 * @return the plant of a client if a step is due, by time or by a change of the signal that begins its steps; NULL: no
 * step is due
 */
ect_outside_t *ect_outside_due(const ect_outsides_t *all, const void *owner, uint64_t now_ns);

/**
 * @return whether a plant that waits for a change of a signal has a due step. Cost: one comparison for each such plant.
 */
bool ect_outsides_triggered(const ect_outsides_t *all);

/** @return the time of the next step of any plant; ECT_NEVER: none. */
uint64_t ect_outsides_due(const ect_outsides_t *all);

/**
 * Begins a step of a plant that is due, or counts the period as late if the previous step is pending.
 * @return true: send the lines of ::ect_outside_line
 */
bool ect_outside_begin(ect_outsides_t *all, ect_outside_t *plant, const ect_chain_t *chain, uint64_t now_ns);

/** Counts the period of a due plant as late, without a step, because its client does not read. */
void ect_outside_skip(ect_outsides_t *all, ect_outside_t *plant, uint64_t now_ns);

/**
 * Writes a line of the present step, which has at most 5 lines.
 * @param number      of the line, from 0
 * @param elapsed_ns  time since the start of the bus, for line 0
 * @return false: no such line
 */
bool ect_outside_line(const ect_outside_t *plant, unsigned int number, uint64_t elapsed_ns, ect_line_t *line);

/** @return whether the clock is stopped until the reply to the present step. */
bool ect_outside_waits(const ect_outside_t *plant);

/** Ends the wait for a plant without a reply: the clock is never stopped for this plant again. */
void ect_outside_give_up(ect_outsides_t *all, ect_outside_t *plant);

/**
 * Sets the values of a reply, a request `step`.
 * @param[out] message  ECT_SIGNAL_MESSAGE bytes, for a reason
 * @return the reason of a refusal, one line: no signal has changed; NULL: done
 */
const char *ect_outside_reply(ect_outside_t *plant, ect_chain_t *chain, const cJSON *request, uint64_t now_ns,
                              char *message);

/**
 * Converts a reply to a request `set`, for observers.
 * @param[in,out] position  of a twin in the chain, from 0; set to that of the next one
 * @return the request, to be deleted by the caller; NULL: no signal of this twin or of a later one is set
 */
cJSON *ect_outside_as_set(const ect_outside_t *plant, const cJSON *request, size_t *position);

/** Ends the plant of a closed client. The signals keep their values; the counters remain. */
void ect_outside_left(ect_outsides_t *all, const void *owner);

/** Writes the counters of a plant. @return false: no plant with this number, from 0 */
bool ect_outside_count(const ect_outsides_t *all, size_t number, ect_line_t *line);

ECT_C_END

#endif
