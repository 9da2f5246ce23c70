/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Notices frames that go round for ever: the other end of the wire answers EtherCAT frames too, so each answer of ours
 * comes back as a new frame. No real chain can be wired like that; two programs on one wire can.
 *
 * A frame is taken for an answer of ours when its first datagram begins where one of the last answers ended: same
 * command, index, address and length, position and working counter not smaller. A master sends such a frame now and
 * then; a circle makes thousands a second. No clock in here. Cost: a few comparisons a frame.
 */
#ifndef ECT_BUS_NET_ENDLESS_H
#define ECT_BUS_NET_ENDLESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_ENDLESS_REMEMBERED = 8, ECT_ENDLESS_MOST = 200 };

/** So many frames (ECT_ENDLESS_MOST) of the kind within this time are a circle. */
#define ECT_ENDLESS_WINDOW_NS 100000000ull

/** What is known of one end. All zero: nothing yet. */
typedef struct ect_endless {
    struct ect_endless_mark {
        uint64_t datagram; /* command, index, offset or high address, length; and a bit that says that this is in use */
        uint16_t position;
        uint16_t working_counter;
        uint8_t source;
    } sent[ECT_ENDLESS_REMEMBERED];
    unsigned int next;
    unsigned int seen; /**< frames of the kind in this window */
    uint64_t window_ns;
} ect_endless_t;

/** Remembers an answer that leaves at this end. */
void ect_endless_sent(ect_endless_t *circle, const uint8_t *frame, size_t length);

/** Looks at a frame that came in at this end. @return true: it circles, do not answer it */
bool ect_endless_received(ect_endless_t *circle, const uint8_t *frame, size_t length, uint64_t now_ns);

ECT_C_END

#endif
