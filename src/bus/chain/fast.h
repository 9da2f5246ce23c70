/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The fast path of a frame through a long line of controllers: only controllers that take part in it process it.
 * Internal to bus/chain.
 *
 * A line stores the registers of each controller that determine the path of frames (esc/route.h). A frame is parsed
 * once. The controllers that take part in a datagram get the datagram in the order of the wire; the effect of all other
 * controllers on the frame (events, working counter, auto increment) is added in one step. The result equals the
 * reference path: ::ect_esc_pass for each controller, then ::ect_esc_end_of_frame for all. A frame for which this is
 * not certain is not taken, and the caller uses the reference path.
 *
 * Not taken are malformed EtherCAT frames, EtherCAT in UDP, read-write commands, and the frame after one that has
 * enabled writes or continued a reset sequence, because these last for one frame.
 *
 * The reference clock's time (ARMW, FRMW of 0x0910) goes to all controllers, and changes no reply. The line only
 * records this time; each controller takes it at its next access, at the latest in ::ect_fast_settle.
 *
 * This file uses no clock. Context: the thread of the chain. Cost of a frame: its datagrams, and for each the
 * controllers that take part. A broadcast read of AL status (0x0130) involves no controller unless a status is new; the
 * reference clock's time involves only that clock. The first frame after a change of routing (esc/route.h), such as a
 * station address or an FMMU, also costs a pass over all controllers.
 */
#ifndef ECT_BUS_CHAIN_FAST_H
#define ECT_BUS_CHAIN_FAST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/steady.h"
#include "esc/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_fast ect_fast_t;

/** Makes a line of `count` controllers (1..65535), to be set by ::ect_fast_put. @return NULL: out of memory */
ect_fast_t *ect_fast_new(size_t count);
void ect_fast_free(ect_fast_t *fast);

/** Sets the controller at a position, from 0, for the first time or after a reset. It must outlive the line. */
void ect_fast_put(ect_fast_t *fast, size_t position, ect_esc_t *esc);

/**
 * Announces that a controller was accessed in another way: by a slow frame, its slave, a cable. Cost: a comparison
 * without a change.
 */
void ect_fast_refresh(ect_fast_t *fast, size_t position);

/** The end of a frame's path. */
typedef enum ect_fast_result {
    ECT_FAST_NOT_TAKEN, /**< nothing has changed; the caller passes the frame */
    ECT_FAST_BACK,      /**< the frame returns at the beginning of the line */
    ECT_FAST_OUT,       /**< the frame leaves at the end */
} ect_fast_result_t;

/** Passes a frame that enters at port 0 of the first controller. */
ect_fast_result_t ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns);

/** Whether the frames of the next calls of ::ect_fast_pass have their replies already (::ect_chain_pass_replied). */
void ect_fast_set_unread(ect_fast_t *fast, bool unread);

/**
 * @param set  one bit for each controller (bus/chain/bits.h)
 * @return whether a controller of the set takes part in a frame; true, too, for a frame with other datagrams than LRD,
 * LWR, LRW, and BRD of an AL status that is not new
 */
bool ect_fast_meets(ect_fast_t *fast, const uint8_t *frame, size_t length, const uint64_t *set);

/**
 * Delivers recorded system times to all controllers. Due before any access to a controller other than ::ect_fast_pass,
 * and before its time advances; when eight times are recorded, the line delivers them itself. ::ect_fast_touched then
 * lists the controllers whose deadline may have changed. Cost: none without recorded times, else each controller with
 * clocks.
 */
void ect_fast_settle(ect_fast_t *fast);

/**
 * @return the number of controllers that a frame reaches, up to the first closed port; 0: not a line, frames are not
 * taken.
 */
size_t ect_fast_reach(ect_fast_t *fast);

/** @return the controllers that took part in the last frame taken, each once. @param[out] count  their number */
const uint32_t *ect_fast_touched(const ect_fast_t *fast, size_t *count);

/**
 * ::ect_chain_steady, as far as the line decides it; each controller must be up to date. Cost: a check of each
 * controller.
 */
bool ect_fast_steady(ect_fast_t *fast, ect_chain_steady_t *steady);

/** ::ect_chain_visit_mapped, for a line with a reach. */
bool ect_fast_visit_mapped(ect_fast_t *fast, uint32_t first, uint16_t length, unsigned int direction,
                           ect_chain_visit_t visit, void *ctx);

/** ::ect_chain_time_source, for a line with a reach. */
const ect_esc_t *ect_fast_time_source(ect_fast_t *fast, const uint8_t *datagram, bool *takes);

ECT_C_END

#endif
