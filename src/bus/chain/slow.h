/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The delays of a microcontroller, between the slave stack and the software ESC of a twin. Internal to bus/chain.
 *
 * The stack runs in one call, at one time. The delays are in its PDI: events are hidden until the slave would process
 * them. With a board, each access takes the time of its bytes, writes reach the ESC when the board would have completed
 * them, and the next poll begins after the end of the last access. Reads take place at the beginning of a poll: a
 * mailbox is empty earlier than on the board, by the time of its bytes.
 *
 * This file uses no clock and no heap. Context: the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_SLOW_H
#define ECT_BUS_CHAIN_SLOW_H

#include "bus/chain/slow_config.h"
#include "esc/esc.h"
#include "seams/pdi.h"

ECT_C_BEGIN

/** Limit of bytes of the pending writes to the ESC; a write beyond it reaches the ESC at once, with all earlier ones.
 */
enum { ECT_SLOW_QUEUE = 8192 };

/** An event hidden from the slave. */
typedef struct ect_hidden {
    bool waits;
    bool shown; /* the event is due: the slave may read or ignore it, such as the event of a mail in INIT */
    uint64_t due_ns;
} ect_hidden_t;

/** Private. */
typedef struct ect_slow {
    ect_slow_config_t config;
    ect_esc_t *esc;
    uint32_t random;
    uint64_t now_ns;   /* of the poll; with a board: of its present access */
    uint64_t start_ns; /* begin of the poll caused by an event; 0: none is due */
    uint64_t busy_ns;  /* end of the last access */
    bool polling;
    bool cycled; /* the device's own code has run in this poll */
    ect_hidden_t al, mailbox;
    uint8_t al_control[2];     /* read from the ESC, until the stack reads it */
    ect_esc_arrival_t arrival; /* without jitter */
    uint16_t first, used;      /* of `queue` */
    uint8_t queue[ECT_SLOW_QUEUE];
} ect_slow_t;

/** Power-on at `now_ns`. The ESC must be initialised, and outlive its use. */
void ect_slow_init(ect_slow_t *slow, const ect_slow_config_t *config, ect_esc_t *esc, uint64_t now_ns);

/** @return the PDI of a slave with these delays @param slow  may be initialised later */
ect_pdi_t ect_slow_pdi(ect_slow_t *slow);

/** Executes due writes to the ESC, whose time is `now_ns`, and selects the random receive times of the next frame.
 */
void ect_slow_run(ect_slow_t *slow, uint64_t now_ns);

/** @return whether a due poll of the slave begins now; on true, ::ect_slow_end must follow the poll */
bool ect_slow_begins(ect_slow_t *slow, uint64_t now_ns);

/** Ends a poll. @param slave_ns  deadline of the slave @return the deadline, hidden events included */
uint64_t ect_slow_end(ect_slow_t *slow, uint64_t slave_ns);

/** @return the time of the next call of ::ect_slow_run, given the deadline of the slave */
uint64_t ect_slow_next(const ect_slow_t *slow, uint64_t slave_ns);

/**
 * Removes the jitter of receive times (`true`) before the delays of the chain are computed; else stores the new delays.
 */
void ect_slow_delays(ect_slow_t *slow, bool before);

ECT_C_END

#endif
