/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Working counters of the recurring datagrams of a bus, as received by the master, counted on request.
 *
 * This file uses no clock. Context: the thread of the runner. Cost of a frame: a comparison; while counting, for each
 * datagram a search among ECT_DATAGRAMS.
 */
#ifndef ECT_BUS_CHAIN_DATAGRAMS_H
#define ECT_BUS_CHAIN_DATAGRAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_DATAGRAMS = 8 };

/** A datagram that the master repeats: broadcast read, system time (ARMW, FRMW) or logical command. */
typedef struct ect_datagram {
    uint8_t command;
    uint32_t address; /**< logical, or offset << 16 | position or station address; of a broadcast only the offset */
    uint16_t length;  /**< bytes of data */
    uint16_t counter; /**< working counter of the last reply */
    uint16_t highest; /**< of all replies */
    uint64_t replies;
    uint64_t lower;   /**< of these, with a working counter below the highest previous one */
    uint64_t seen_ns; /**< time of the last reply */
} ect_datagram_t;

/** Zeroed: nothing is counted. */
typedef struct ect_datagrams {
    uint64_t until_ns; /**< end of counting */
    size_t count;
    ect_datagram_t all[ECT_DATAGRAMS];
} ect_datagrams_t;

/** Counts until a time; starts from zero if the previous count has ended. */
void ect_datagrams_want(ect_datagrams_t *datagrams, uint64_t now_ns, uint64_t until_ns);

/** Counts the datagrams of a reply that leaves; the most recent ECT_DATAGRAMS are kept. */
void ect_datagrams_count(ect_datagrams_t *datagrams, const uint8_t *frame, size_t length, uint64_t now_ns);

/** @return the name of a counted command; NULL: another command */
const char *ect_datagrams_name(uint8_t command);

ECT_C_END

#endif
