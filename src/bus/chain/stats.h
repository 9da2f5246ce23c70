/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a run has done so far: frames, how long answers took, what came too late. Plain counters; nothing here reads a
 * clock. Context: the thread of the runner. Cost: one addition and a short search a frame.
 */
#ifndef ECT_BUS_CHAIN_STATS_H
#define ECT_BUS_CHAIN_STATS_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Steps of the histogram: 1, 2, 5, 10, … µs; the last step is everything above 1 s. */
enum { ECT_STATS_STEPS = 20 };

/** Counters since the start. All zero: nothing has happened yet. */
typedef struct ect_stats {
    uint64_t start_ns;   /**< when the run began */
    uint64_t frames;     /**< that came, at either end */
    uint64_t answered;   /**< that went back, or out at the other end */
    uint64_t unanswered; /**< no EtherCAT, malformed, or without a way back */
    uint64_t stale;      /**< not looked at: they had waited for more than 5 ms and newer ones had come */
    uint64_t circling;   /**< our own answers that came back for ever, and were destroyed */
    uint64_t dropped;    /**< lost on purpose (--drop) */
    uint64_t delayed;    /**< late on purpose (--delay); not in the histogram */
    /** Answers by their time, from the arrival at the interface (ect_packet_time_t) to the end of the sending call. */
    uint64_t answers[ECT_STATS_STEPS];
    uint64_t longest_answer_ns;
    uint64_t polls;      /**< times that the devices ran */
    uint64_t late_polls; /**< of these, more than ECT_STATS_LATE_NS after the time that a device had asked for */
    uint64_t latest_poll_ns;
} ect_stats_t;

/** A device that runs later than this has been noticed by its master. */
enum { ECT_STATS_LATE_NS = 1000000 };

/** Counts an answer that took so long. */
void ect_stats_answer(ect_stats_t *stats, uint64_t took_ns);

/** Counts a run of the devices, `late_ns` after it was due (0: in time, or brought about by a frame). */
void ect_stats_poll(ect_stats_t *stats, uint64_t late_ns);

/** Upper edge of a step, microseconds; step ECT_STATS_STEPS - 1 has none and answers 0. */
uint32_t ect_stats_edge_us(size_t step);

/**
 * @param per_mille  0..1000
 * @return the upper edge, in µs, of the step below which that share of the answers lies; 0: none, or it is in the last
 */
uint32_t ect_stats_quantile_us(const ect_stats_t *stats, unsigned int per_mille);

ECT_C_END

#endif
