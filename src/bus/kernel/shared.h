/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Memory that the program in the kernel (answer.bpf.c) and the twins' process share, beside the plans.
 */
#ifndef ECT_BUS_KERNEL_SHARED_H
#define ECT_BUS_KERNEL_SHARED_H

#include <stdint.h>

#include "bus/kernel/pace.h"
#include "bus/kernel/steps.h"
#include "bus/kernel/turn.h"

/**
 * Limit of frames that the kernel holds for the program: a quarter of a second at 4 kHz, 22 cycles of a thousand twins.
 * Further frames wait for the program.
 */
enum { ECT_HELD_FRAMES = 1024, ECT_HELD_ROOM = 1520 };

/** A frame that a plan has replied to, as received. */
typedef struct ect_held {
    uint64_t time_ns; /**< of arrival, CLOCK_MONOTONIC */
    uint32_t length;
    uint32_t took_ns; /**< from arrival to the end of the reply's last step */
    uint8_t frame[ECT_HELD_ROOM];
} ect_held_t;

typedef struct ect_shared {
    ect_turn_t turn;
    uint64_t held;               /**< frames held; this member and all below: owned by the side that has the turn */
    uint64_t reacting;           /**< 1: for ::ect_pace_is_close; set when the program gives the turn away */
    uint64_t last_ns[ECT_PLANS]; /**< arrival of the last frame of a plan, by place */
} ect_shared_t;

#endif
