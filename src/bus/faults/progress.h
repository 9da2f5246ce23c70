/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The progress of a script as signals, `scenario.NAME`, which clients read and watch like the signals of a twin.
 */
#ifndef ECT_BUS_FAULTS_PROGRESS_H
#define ECT_BUS_FAULTS_PROGRESS_H

#include <stdint.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Room for the word of the verdict. */
enum { ECT_PROGRESS_WORD = 12 };

/** The values of the signals. */
typedef struct ect_progress {
    uint32_t line;                          /**< line of the last step that has begun or ended; 0: none */
    char step[ECT_SIGNAL_LONGEST_TEXT + 1]; /**< its text */
    uint32_t steps, over;
    uint32_t expected, met, failed;  /**< expectations */
    char verdict[ECT_PROGRESS_WORD]; /**< "running", "met", "failed", "over" (without expectations) */
} ect_progress_t;

/** The signals of an ect_progress_t, read only; the instance is the structure. */
extern const ect_plant_t ect_progress_plant;

ECT_C_END

#endif
