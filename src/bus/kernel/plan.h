/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Plans: replies to recurring frames, compiled from the chain, so that the kernel can give them (bus/kernel/kernel.h).
 *
 * The chain remains the only definition of the effects of a frame. A plan is a list of steps that turns a frame of one
 * layout (the same datagrams with the same addresses and lengths) into the reply that the chain would give: bits of
 * ECAT events and AL status, input images, the system time, working counters. A frame that a plan has replied to passes
 * the chain later, with the time of its arrival, and there all else happens: outputs, watchdogs, events, clocks.
 *
 * A plan rests on the chain as it is when the plan is made, so it holds only as long as nothing but frames with plans
 * happens to the chain. There is one rule of invalidation, with "no plan" as the default: each caller of the chain
 * first voids all plans (::ect_planner_void), passes the frames that plans have replied to, and makes the plans again
 * at the end (::ect_planner_make).
 *
 * There a plan is renewed instead of made if its bases are unchanged: the sums of the line with the version of its
 * tables (::ect_chain_steady_t), and ::ect_esc_routing of each ESC that takes part. FMMUs, SyncManagers, AL states,
 * ports, EEPROM and addresses need no list of their own. A renewal copies the newest input images and reads the clock.
 *
 * Plans are made for untagged EtherCAT frames of at most ECT_PLAN_FRAME bytes with the datagrams NOP, LRD, LWR, LRW
 * (esc/cyclic.h states which images), BRD of AL status, and ARMW and FRMW of the system time of one reference clock
 * that runs at the rate of the host's.
 *
 * Context: one thread. No heap, no clock.
 */
#ifndef ECT_BUS_KERNEL_PLAN_H
#define ECT_BUS_KERNEL_PLAN_H

#include "bus/chain/chain.h"
#include "bus/chain/steady.h"
#include "bus/kernel/steps.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** ESCs of a plan at most; a plan with more is never renewed. */
enum { ECT_PLAN_BASES = 128 };

/** An ESC that a plan rests on, with an input image in the plan. */
typedef struct ect_plan_base {
    const ect_esc_t *esc;
    uint32_t routing; /**< ::ect_esc_routing */
    uint16_t image;   /**< place in the image of the plan */
    uint8_t sm;       /**< SyncManager of the input image; ECT_ESC_MAX_SM: none */
} ect_plan_base_t;

/** A received frame, as an example of its layout, and all that its plan rests on. */
typedef struct ect_plan_sample {
    uint16_t length; /**< 0: none */
    uint8_t frame[ECT_PLAN_FRAME];
    /* Private. */
    uint32_t step_count;    /* of the plan; 0: it has to be made */
    uint32_t base_count;    /* above ECT_PLAN_BASES: it cannot be renewed */
    const ect_esc_t *clock; /* NULL: none */
    ect_plan_base_t bases[ECT_PLAN_BASES];
} ect_plan_sample_t;

/** Plans of a chain and the frames that they are made for; zeroed: none. */
typedef struct ect_planner {
    ect_plan_table_t *table; /**< where the plans are, zeroed; set by the caller, outlives the planner */
    bool outputs_changed;    /**< a frame had other outputs than the one before; the caller resets it */
    uint64_t made, renewed;  /**< plans so far, for statistics */
    /* Private. */
    ect_chain_steady_t steady; /* of all plans */
    ect_plan_sample_t samples[ECT_PLANS];
} ect_planner_t;

/**
 * Shows a frame that is about to pass the chain; the next ::ect_planner_make tries to make a plan for its layout, in
 * the place of an earlier layout with the same ::ect_plan_key, or of any layout if places are short. Frames with other
 * datagrams than those above have no effect.
 */
void ect_planner_see(ect_planner_t *planner, const uint8_t *frame, size_t length);

/** Makes all plans void. */
void ect_planner_void(ect_planner_t *planner);

/**
 * Makes a plan for each layout seen, where the reply is certain, or renews it.
 * @param chain  the same in each call
 * @return the number of plans
 *
 * Cost: a check of each ESC of the chain, and for each layout of the ESCs that take part; a renewal costs about a
 * tenth.
 */
unsigned int ect_planner_make(ect_planner_t *planner, ect_chain_t *chain);

/** Finds the place of a frame's layout. @param head  at least ECT_PLAN_HEAD bytes. @return NULL: it has none */
const ect_plan_t *ect_plan_find(const ect_plan_table_t *table, const uint8_t *head);

/**
 * Replies to a frame by its plan.
 * @param[in,out] frame  changed only if there is a plan
 * @param now_ns         time of arrival
 * @return false: no plan; the frame has to pass the chain
 */
bool ect_plan_reply(const ect_plan_table_t *table, uint8_t *frame, size_t length, uint64_t now_ns);

ECT_C_END

#endif
