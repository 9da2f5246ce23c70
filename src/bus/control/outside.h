/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Plants outside this process: programs that read and set signals of the twins once in each period (docs/PLANTS.md).
 * Internal to bus/control.
 *
 * A plant is a client that has named the signals that it reads and sets. At each period the twins send the values that
 * it reads, all of one time; its reply sets the others, all or none. A plant whose reply has not come by the next
 * period is late: the signals keep their values, the period is counted, and the plant gets its next step one period
 * after the reply. A plant with a signal `on` has a
 * step at each change of this signal in place of each period, and a timeout: a later reply is dropped. The first delay
 * and the end of a plant are reported, once each. Nothing here waits or reads a clock.
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
    bool may_wait; /**< the clock is virtual: plants may ask for its standstill during their steps */
    /** Gets a line for the user: a plant is late, or has ended; NULL: none. */
    void (*report)(void *ctx, const char *text);
    void *ctx;
} ect_outsides_t;

/** Frees all plants, without a report. */
void ect_outsides_clear(ect_outsides_t *all);

/**
 * Executes a request `plant`: adds signals to the plant of a client, and with a period starts it.
 * @param owner         the client; only compared
 * @param slave         of signals without the name of a twin, from 1
 * @param[out] message  ECT_SIGNAL_MESSAGE bytes, for a reason
 * @return the reason of a refusal, one line: nothing has changed; NULL: done
 */
const char *ect_outside_request(ect_outsides_t *all, const void *owner, const ect_chain_t *chain, size_t slave,
                                const cJSON *request, uint64_t now_ns, char *message);

/** The plant of a client that has been started. @return NULL: none */
ect_outside_t *ect_outside_of(const ect_outsides_t *all, const void *owner);

/** A started plant with a name. @return NULL: none */
ect_outside_t *ect_outside_named(const ect_outsides_t *all, const char *name);

/** The plant of a client, if a step is due at a time, or the signal has changed that begins its steps. @return NULL: it
 * is not */
ect_outside_t *ect_outside_due(const ect_outsides_t *all, const void *owner, uint64_t now_ns);

/** Whether a plant that waits for a change of a signal is to begin a step. Cost: one comparison for each such plant. */
bool ect_outsides_triggered(const ect_outsides_t *all);

/** Time of the next step of any plant; ECT_NEVER: none. */
uint64_t ect_outsides_due(const ect_outsides_t *all);

/**
 * Begins a step of a plant that is due, or counts the period as late if the previous step is pending.
 * @return whether the lines of ::ect_outside_line are to be sent
 */
bool ect_outside_begin(ect_outsides_t *all, ect_outside_t *plant, const ect_chain_t *chain, uint64_t now_ns);

/** Counts the period of a plant that is due as late without a step, because its client does not read. */
void ect_outside_skip(ect_outsides_t *all, ect_outside_t *plant, uint64_t now_ns);

/**
 * Writes a line of the step that has begun: at most 5 lines.
 * @param number      of the line, from 0
 * @param elapsed_ns  time since the start of the bus, for line 0
 * @return false: there is no such line
 */
bool ect_outside_line(const ect_outside_t *plant, unsigned int number, uint64_t elapsed_ns, ect_line_t *line);

/** Whether the clock stands still until the reply to the present step. */
bool ect_outside_waits(const ect_outside_t *plant);

/** Ends the wait for a plant without a reply, for good: the clock does not stand still for it again. */
void ect_outside_give_up(ect_outsides_t *all, ect_outside_t *plant);

/**
 * Sets the values of a reply, a request `step`.
 * @param[out] message  ECT_SIGNAL_MESSAGE bytes, for a reason
 * @return the reason of a refusal, one line: no signal has changed; NULL: done
 */
const char *ect_outside_reply(ect_outside_t *plant, ect_chain_t *chain, const cJSON *request, uint64_t now_ns,
                              char *message);

/**
 * The change of a reply as a request `set`, for observers.
 * @param[in,out] position  of a twin in the chain, from 0; then of the next one
 * @return the request, to be deleted by the caller; NULL: no signal of this twin or of a later one is set
 */
cJSON *ect_outside_as_set(const ect_outside_t *plant, const cJSON *request, size_t *position);

/** Ends the plant of a client that has gone. Its signals keep their values, its counters remain. */
void ect_outside_left(ect_outsides_t *all, const void *owner);

/** Writes the counters of a plant. @return false: there is no plant with this number, from 0 */
bool ect_outside_count(const ect_outsides_t *all, size_t number, ect_line_t *line);

ECT_C_END

#endif
