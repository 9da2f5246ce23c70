/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Faults of the wire, by lot from a seed: frames lost on the way in, on the way back, or late.
 */
#ifndef ECT_BUS_FAULTS_H
#define ECT_BUS_FAULTS_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_faults {
    uint32_t seed;         /**< of the lot; the same seed gives the same row of verdicts */
    uint8_t drop_percent;  /**< 0..100: half of them before the slaves see the frame, half on the way back */
    uint8_t delay_percent; /**< 0..100: answers that come late */
    uint32_t delay_us;     /**< how late */
} ect_faults_t;

typedef enum ect_verdict {
    ECT_VERDICT_PASS,
    ECT_VERDICT_LOSE_REQUEST,
    ECT_VERDICT_LOSE_ANSWER,
    ECT_VERDICT_DELAY,
} ect_verdict_t;

/** Draws the verdict for the next frame and moves the seed on. Without faults always ECT_VERDICT_PASS. */
ect_verdict_t ect_faults_draw(ect_faults_t *faults);

ECT_C_END

#endif
