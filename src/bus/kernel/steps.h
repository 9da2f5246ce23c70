/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The steps of a plan (bus/kernel/plan.h), and the interpreter that carries them out, in user space and in the kernel.
 *
 * A file that runs plans defines, before it includes this header, how the interpreter reaches a frame:
 *
 *     #define ECT_STEPS_FRAME                            type of a frame
 *     #define ECT_STEPS_LOAD(frame, at, to, length)      copies bytes of the frame to `to`; 0: done
 *     #define ECT_STEPS_STORE(frame, at, from, length)   copies bytes to the frame; 0: done
 *
 * Without these definitions this header has the types only. Freestanding; every loop and every access has a constant
 * bound, which the kernel's verifier checks.
 */
#ifndef ECT_BUS_KERNEL_STEPS_H
#define ECT_BUS_KERNEL_STEPS_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/bytes.h"

/**
 * Limits: plans of a chain, steps of a plan, bytes of a frame with a plan, bytes of its input images and of the room
 * after them.
 */
enum { ECT_PLANS = 128, ECT_PLAN_STEPS = 64, ECT_PLAN_FRAME = 1514, ECT_PLAN_IMAGE = 4096 };

/** A plan is in one of this many successive places, from ::ect_plan_place on. */
enum { ECT_PLAN_PROBES = 16 };

/** The kinds of steps. `at` is an offset in the frame. */
typedef enum ect_plan_kind {
    ECT_PLAN_DO_HEADER, /**< the 8 bytes at `at` must be `wide`, except the second: command, addresses, length */
    ECT_PLAN_DO_OR,     /**< ORs `value` to `length` bytes, 1 or 2 */
    ECT_PLAN_DO_ADD,    /**< adds `value` to 2 bytes */
    ECT_PLAN_DO_COPY,   /**< copies `length` bytes of the image from `value` on */
    ECT_PLAN_DO_TIME,   /**< stores `length` bytes, 4 to 8, of the time of arrival plus `wide` */
} ect_plan_kind_t;

typedef struct ect_plan_step {
    uint16_t kind; /**< ::ect_plan_kind_t */
    uint16_t at;
    uint16_t length;
    uint16_t value;
    uint64_t wide;
} ect_plan_step_t;

/** The plan of one layout. */
typedef struct ect_plan {
    uint64_t key;         /**< ::ect_plan_key of its frames; 0: this place was never used */
    uint32_t step_count;  /**< steps in use, those of the headers first; 0: no plan */
    uint32_t shortest;    /**< bytes of a frame up to and including its last working counter */
    uint32_t source_bits; /**< ORed to the first byte of the source address */
    uint8_t type[4];      /**< EtherType and EtherCAT header */
    ect_plan_step_t steps[ECT_PLAN_STEPS];
    uint8_t image[ECT_PLAN_IMAGE];
} ect_plan_t;

/**
 * Plans by place. A search begins at ::ect_plan_place and ends at the first plan with the key, or at a place without a
 * key.
 */
typedef struct ect_plan_table {
    ect_plan_t plans[ECT_PLANS];
} ect_plan_table_t;

/** Offsets in a frame: source address, EtherType, first datagram, and the end of its first 8 bytes. */
enum { ECT_PLAN_SOURCE = 6, ECT_PLAN_TYPE = 12, ECT_PLAN_FIRST = 16, ECT_PLAN_HEAD = 24 };

/** The key of a plan, never 0, by the first ECT_PLAN_HEAD bytes of the frame: command, address and length of the first
 * datagram. */
static inline uint64_t ect_plan_key(const uint8_t *head)
{
    return (ect_load_le64(head + ECT_PLAN_FIRST) & ~0xFF00ull) | 0x0100;
}

/** The first place where a plan with this key may be, 0..ECT_PLANS - 1. */
static inline uint32_t ect_plan_place(uint64_t key)
{
    return (uint32_t)(key * 0x9E3779B97F4A7C15ull >> 57);
}

#endif

#if defined(ECT_STEPS_FRAME) && !defined(ECT_STEPS_INTERPRETER)
#define ECT_STEPS_INTERPRETER

/* A datagram header without the index, which may differ in each frame. */
static inline uint64_t ect_step_header(const uint8_t *bytes)
{
    return ect_load_le64(bytes) & ~0xFF00ull;
}

/* @return whether a frame of `length` bytes has the layout of a plan. */
static inline bool ect_steps_match(const ect_plan_t *plan, ECT_STEPS_FRAME frame, uint32_t length, const uint8_t *head)
{
    uint8_t header[8];
    if (plan->step_count == 0 || plan->step_count > ECT_PLAN_STEPS || length < plan->shortest ||
        ect_load_le32(head + ECT_PLAN_TYPE) != ect_load_le32(plan->type))
        return false;
    for (uint32_t i = 0; i < ECT_PLAN_STEPS && i < plan->step_count; i++) {
        const ect_plan_step_t *step = &plan->steps[i];
        if (step->kind != ECT_PLAN_DO_HEADER)
            return true;
        if (ECT_STEPS_LOAD(frame, step->at, header, 8) != 0 || ect_step_header(header) != step->wide)
            return false;
    }
    return true;
}

static inline bool ect_step_or(const ect_plan_step_t *step, ECT_STEPS_FRAME frame)
{
    uint8_t bytes[2];
    if (step->length == 1) {
        if (ECT_STEPS_LOAD(frame, step->at, bytes, 1) != 0)
            return false;
        bytes[0] = (uint8_t)(bytes[0] | step->value);
        return ECT_STEPS_STORE(frame, step->at, bytes, 1) == 0;
    }
    if (ECT_STEPS_LOAD(frame, step->at, bytes, 2) != 0)
        return false;
    ect_store_le16(bytes, (uint16_t)(ect_load_le16(bytes) | step->value));
    return ECT_STEPS_STORE(frame, step->at, bytes, 2) == 0;
}

static inline bool ect_step_add(const ect_plan_step_t *step, ECT_STEPS_FRAME frame)
{
    uint8_t bytes[2];
    if (ECT_STEPS_LOAD(frame, step->at, bytes, 2) != 0)
        return false;
    ect_store_le16(bytes, (uint16_t)(ect_load_le16(bytes) + step->value));
    return ECT_STEPS_STORE(frame, step->at, bytes, 2) == 0;
}

static inline bool ect_step_copy(const ect_plan_t *plan, const ect_plan_step_t *step, ECT_STEPS_FRAME frame)
{
    uint32_t from = step->value, length = step->length;
    if (from > ECT_PLAN_IMAGE - 2048 || length == 0 || length > ECT_PLAN_FRAME)
        return false;
    return ECT_STEPS_STORE(frame, step->at, plan->image + from, length) == 0;
}

static inline bool ect_step_time(const ect_plan_step_t *step, ECT_STEPS_FRAME frame, uint64_t now_ns)
{
    uint32_t length = step->length;
    uint8_t bytes[8];
    ect_store_le64(bytes, now_ns + step->wide);
    if (length < 4 || length > 8)
        return false;
    return ECT_STEPS_STORE(frame, step->at, bytes, length) == 0;
}

static inline bool ect_step_run(const ect_plan_t *plan, const ect_plan_step_t *step, ECT_STEPS_FRAME frame,
                                uint64_t now_ns)
{
    switch (step->kind) {
    case ECT_PLAN_DO_HEADER:
        return true;
    case ECT_PLAN_DO_OR:
        return ect_step_or(step, frame);
    case ECT_PLAN_DO_ADD:
        return ect_step_add(step, frame);
    case ECT_PLAN_DO_COPY:
        return ect_step_copy(plan, step, frame);
    default:
        return ect_step_time(step, frame, now_ns);
    }
}

/* Turns a frame that matches into its reply. @return false: a step was out of bounds; the frame is damaged */
static inline bool ect_steps_run(const ect_plan_t *plan, ECT_STEPS_FRAME frame, const uint8_t *head, uint64_t now_ns)
{
    uint8_t source = (uint8_t)(head[ECT_PLAN_SOURCE] | plan->source_bits);
    if (ECT_STEPS_STORE(frame, ECT_PLAN_SOURCE, &source, 1) != 0)
        return false;
    for (uint32_t i = 0; i < ECT_PLAN_STEPS && i < plan->step_count; i++) {
        if (!ect_step_run(plan, &plan->steps[i], frame, now_ns))
            return false;
    }
    return true;
}

#endif
