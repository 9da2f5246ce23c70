/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Detects frames that circulate endlessly: if a program at the other end of the wire replies to EtherCAT frames too,
 * each reply returns as a new frame. Two such programs on one wire cause the loop; a real chain cannot.
 *
 * A frame counts as a reply of this end if its first datagram continues one of the last replies: same command, index,
 * address and length, position and working counter not smaller. A master occasionally sends such a frame; a loop
 * produces thousands per second. This file uses no clock. Context: the thread of the runner. Cost: a few comparisons
 * for each frame.
 */
#ifndef ECT_BUS_NET_ENDLESS_H
#define ECT_BUS_NET_ENDLESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_ENDLESS_REMEMBERED = 8, ECT_ENDLESS_MOST = 200 };

/** A loop is ECT_ENDLESS_MOST such frames within ECT_ENDLESS_WINDOW_NS. */
#define ECT_ENDLESS_WINDOW_NS 100000000ull

/** The last replies of one end; zeroed: none. */
typedef struct ect_endless {
    struct ect_endless_mark {
        uint64_t
            datagram; /* command, index, offset or high address, length, and a bit that marks the element as used */
        uint16_t position;
        uint16_t working_counter;
        uint8_t source;
    } sent[ECT_ENDLESS_REMEMBERED];
    unsigned int next;
    unsigned int seen; /**< such frames in this window */
    uint64_t window_ns;
} ect_endless_t;

/** Records a reply sent at this end. */
void ect_endless_sent(ect_endless_t *endless, const uint8_t *frame, size_t length);

/** Checks a frame received at this end. @return true: the frame circulates, do not reply */
bool ect_endless_received(ect_endless_t *endless, const uint8_t *frame, size_t length, uint64_t now_ns);

ECT_C_END

#endif
