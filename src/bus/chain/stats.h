/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Counters of a run: frames, response times, late runs of the devices. This file uses no clock. Context: the thread of
 * the runner. Cost: one addition and a short search for each frame.
 */
#ifndef ECT_BUS_CHAIN_STATS_H
#define ECT_BUS_CHAIN_STATS_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Steps of the histogram: 1, 2, 5, 10, … µs; the last step counts all times above 1 s. */
enum { ECT_STATS_STEPS = 20 };

/** Counters since the start; initially zero. */
typedef struct ect_stats {
    uint64_t start_ns;   /**< start of the run */
    uint64_t frames;     /**< received, at either end */
    uint64_t answered;   /**< sent back, or sent out at the other end */
    uint64_t in_kernel;  /**< of these, in the kernel (bus/kernel); in a histogram of their own */
    uint64_t unanswered; /**< not EtherCAT, malformed, or without a way back */
    uint64_t queue_lost; /**< lost in the full queue of the interface; not in `frames` */
    uint64_t stale;      /**< discarded after a wait of more than 5 ms while newer ones arrived */
    uint64_t circling;   /**< circulating replies of this program, which were destroyed */
    uint64_t dropped;    /**< lost by a fault (--drop) */
    uint64_t delayed;    /**< delayed by a fault (--delay); not in the histogram */
    uint64_t captured;   /**< frames in the capture (--pcap) */
    uint64_t uncaptured; /**< frames missing in the capture: the disk was too slow, or is full */
    /** Replies by response time: from arrival at the interface (ect_packet_time_t) to the end of the sending call. */
    uint64_t answers[ECT_STATS_STEPS];
    uint64_t longest_answer_ns;
    const char *hook; /**< hook of the replies in the kernel: "native" or "generic" XDP; NULL: none */
    uint64_t plans;   /**< frame layouts with a plan at the last sleep of the loop */
    uint64_t kernel_answers[ECT_STATS_STEPS]; /**< replies in the kernel, by the time of its program */
    uint64_t longest_kernel_ns;
    uint64_t polls;      /**< runs of the devices */
    uint64_t late_polls; /**< of these, more than ECT_STATS_LATE_NS after the deadline of a device */
    uint64_t latest_poll_ns;
} ect_stats_t;

/** A device that runs later than this may affect a master. */
enum { ECT_STATS_LATE_NS = 1000000 };

/** Counts a reply with this response time. */
void ect_stats_answer(ect_stats_t *stats, uint64_t took_ns);

/** Counts a reply in the kernel, with the time of its program. */
void ect_stats_kernel_answer(ect_stats_t *stats, uint64_t took_ns);

/** Counts a run of the devices, `late_ns` after its deadline (0: in time, or caused by a frame). */
void ect_stats_poll(ect_stats_t *stats, uint64_t late_ns);

/** @return the upper edge of a step, microseconds; 0 for step ECT_STATS_STEPS - 1, which has none. */
uint32_t ect_stats_edge_us(size_t step);

/**
 * Computes a quantile of response times. @param counts  replies by step. @param per_mille  0..1000
 * @return the upper edge, in µs, of the step that contains the quantile; 0: no replies, or the last step
 */
uint32_t ect_stats_quantile_us(const uint64_t counts[ECT_STATS_STEPS], unsigned int per_mille);

ECT_C_END

#endif
