/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The way of a frame through a long line of controllers, without a look at those that it does not concern.
 *
 * A line knows of each controller what decides on the way of frames (esc/route.h). A frame is parsed once; each of its
 * datagrams goes, in the order of the wire, to the controllers that take part in it, and what the others would have
 * done to it (events, working counter, auto increment) is added at once. The result is the one that ::ect_esc_process
 * for one controller after the other has; frames of which that is not plain to see are not taken, and their caller does
 * just that.
 *
 * Not taken are: what is no well-formed EtherCAT frame, EtherCAT in UDP, read-write commands, writes that could close a
 * port (0x0000..0x010F but the addresses, or an FMMU on registers), an FMMU that is written and logical access in one
 * frame; and the frame after one that has enabled writes or gone on with a reset sequence, for they last for a frame.
 *
 * The reference clock's time (ARMW, FRMW of 0x0910) is told to all and only written down for them: what they do with it
 * changes no answer, so it is done when they are looked at, or in ::ect_fast_settle.
 *
 * No clock in here. Context: the thread of the chain. Cost of a frame: its datagrams, and for each the controllers that
 * take part; a broadcast read of AL status (0x0130) concerns none unless a status is new, and the reference clock's
 * time only that clock. The first frame after a station address, FMMU or the like has changed also costs a look at all
 * controllers.
 */
#ifndef ECT_BUS_CHAIN_FAST_H
#define ECT_BUS_CHAIN_FAST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "esc/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_fast ect_fast_t;

/** A line of `count` controllers (1..65535), yet to be named by ::ect_fast_put. @return NULL: no memory */
ect_fast_t *ect_fast_new(size_t count);
void ect_fast_free(ect_fast_t *fast);

/** The controller at a position, from 0: for the first time, or after a reset. It must outlive the line. */
void ect_fast_put(ect_fast_t *fast, size_t position, ect_esc_t *esc);

/** Somebody else has touched the controller: a frame on another way, its slave, a cable. Cheap if that changed nothing.
 */
void ect_fast_look(ect_fast_t *fast, size_t position);

/** What became of a frame. */
typedef enum ect_fast_result {
    ECT_FAST_NOT_TAKEN, /**< nothing has happened */
    ECT_FAST_BACK,      /**< it comes back at the beginning of the line */
    ECT_FAST_OUT,       /**< it leaves at the end */
} ect_fast_result_t;

/** Lets a frame pass from port 0 of the first controller on. */
ect_fast_result_t ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns);

/**
 * Lets all controllers take what was told to them. Due before anybody else than ::ect_fast_pass looks at a controller
 * or lets its time go on, and, for there is room for eight tellings, now and then. ::ect_fast_touched then says who
 * wants to run at another time than before. Cost: nothing where nothing was told, else each controller with clocks.
 */
void ect_fast_settle(ect_fast_t *fast);

/** How many controllers a frame reaches: those before the first closed port; 0: not a line, frames are not taken. */
size_t ect_fast_reach(ect_fast_t *fast);

/** The controllers that took part in the last frame that was taken, each once. @param[out] count  how many */
const uint32_t *ect_fast_touched(const ect_fast_t *fast, size_t *count);

ECT_C_END

#endif
