/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Plans: replies to recurring frames, compiled from the chain, so that the kernel can send them (bus/kernel/kernel.h).
 *
 * The chain remains the only definition of the effects of a frame. A plan is a list of steps that turns a frame of one
 * layout (the same datagrams with the same addresses and lengths) into the reply of the chain: bits of ECAT events and
 * AL status, input images, the system time, working counters. A frame that a plan has replied to passes the chain
 * later, with its time of arrival; all other effects take place then: outputs, watchdogs, events, clocks.
 *
 * A plan is based on the state of the chain at the time of its making, and stays valid only while nothing but frames
 * with plans passes the chain. There is one rule of invalidation, with "no plan" as the default: each caller of the
 * chain first voids all plans (::ect_planner_void), passes the frames that plans have replied to, and finally makes the
 * plans again (::ect_planner_make).
 *
 * ::ect_planner_make renews a plan if its bases are unchanged: the sums of the line with the version of its tables
 * (::ect_chain_steady_t), and ::ect_esc_routing of each ESC that takes part. These cover FMMUs, SyncManagers, AL
 * states, ports, EEPROM and addresses. A renewal copies the newest input images and reads the clock.
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

/** Limit of ESCs in a plan that can be renewed; a plan with more ESCs is made again each time. */
enum { ECT_PLAN_BASES = 128 };

/** An ESC that a plan is based on, with its input image in the plan. */
typedef struct ect_plan_base {
    const ect_esc_t *esc;
    uint32_t routing;  /**< ::ect_esc_routing */
    uint16_t image;    /**< place in the image of the plan */
    uint16_t position; /**< of the ESC in the chain */
    uint8_t sm;        /**< SyncManager of the input image; ECT_ESC_MAX_SM: none */
    bool copied;       /**< the newest image is in the plan */
} ect_plan_base_t;

/** A base among those of all plans. */
typedef struct ect_plan_place {
    uint8_t plan, base;
} ect_plan_place_t;

/** A received frame, as a sample of its layout, and the bases of its plan. */
typedef struct ect_plan_sample {
    uint16_t length; /**< 0: none */
    uint8_t frame[ECT_PLAN_FRAME];
    /* Private. */
    uint32_t step_count;    /* of the plan; 0: the plan must be made */
    uint32_t base_count;    /* above ECT_PLAN_BASES: the plan cannot be renewed */
    const ect_esc_t *clock; /* NULL: none */
    ect_plan_base_t bases[ECT_PLAN_BASES];
} ect_plan_sample_t;

/** The plans of a chain, and samples of their frames; zeroed: no plan. */
typedef struct ect_planner {
    ect_plan_table_t *table;  /**< memory of the plans, zeroed; set by the caller, outlives the planner */
    ect_plan_place_t *places; /**< one for each slave, zeroed; set by the caller, as `table`; NULL: no
                                   ::ect_planner_ran */
    bool outputs_changed;   /**< the outputs of a frame differ from those of the previous frame; reset by the caller */
    uint64_t made, renewed; /**< plans so far, for statistics */
    /* Private. */
    ect_chain_steady_t steady;       /* of all plans */
    uint64_t known[ECT_PLANS / 64u]; /* one bit for each place: it has a sample */
    ect_plan_sample_t samples[ECT_PLANS];
} ect_planner_t;

/**
 * Takes a frame, before it passes the chain, as the sample of a layout for which the next ::ect_planner_make tries to
 * make a plan. The layout replaces an earlier one with the same ::ect_plan_key, or any layout if no place is unused.
 * Frames with datagrams other than those above have no effect.
 */
void ect_planner_see(ect_planner_t *planner, const uint8_t *frame, size_t length);

/** Makes all plans void. */
void ect_planner_void(ect_planner_t *planner);

/**
 * Makes, or renews, a plan for each layout of ::ect_planner_see for which the reply is certain.
 * @param chain  the same in each call
 * @return the number of plans
 *
 * Cost: a check of each ESC of the chain, and for each layout of the ESCs that take part; a renewal costs about a
 * tenth.
 */
unsigned int ect_planner_make(ect_planner_t *planner, ect_chain_t *chain);

/**
 * Copies the newest input image of a slave that has just run into its plan, which ::ect_planner_make does otherwise,
 * when the image may have left the processor's cache. Until the next call of ::ect_planner_make only a further run may
 * access the slave's ESC, and is followed by this call. Plans are void.
 */
void ect_planner_ran(ect_planner_t *planner, size_t position);

/** Finds the plan of a frame's layout. @param head  at least ECT_PLAN_HEAD bytes. @return NULL: none */
const ect_plan_t *ect_plan_find(const ect_plan_table_t *table, const uint8_t *head);

/**
 * Replies to a frame by its plan.
 * @param[in,out] frame  changed only if there is a plan
 * @param now_ns         time of arrival
 * @return false: no plan; the frame must pass the chain
 */
bool ect_plan_reply(const ect_plan_table_t *table, uint8_t *frame, size_t length, uint64_t now_ns);

ECT_C_END

#endif
