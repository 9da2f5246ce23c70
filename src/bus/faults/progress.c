/* SPDX-License-Identifier: MIT */
#include "bus/faults/progress.h"

#define COUNTER(member, name, meaning) ECT_SIGNAL(ect_progress_t, member, name, U32, READ, 0, INT32_MAX, NULL, meaning)

static const ect_signal_t signals[] = {
    COUNTER(line, "line", "Line of the last step that has begun or ended; 0: none"),
    ECT_SIGNAL(ect_progress_t, step, "step", TEXT, READ, 0, ECT_SIGNAL_LONGEST_TEXT, NULL, "Text of this step"),
    COUNTER(steps, "steps", "Steps of the script"),
    COUNTER(over, "over", "Steps that are over"),
    COUNTER(expected, "expected", "Expectations of the script"),
    COUNTER(met, "met", "Expectations that are met"),
    COUNTER(failed, "failed", "Expectations that have failed"),
    ECT_SIGNAL(ect_progress_t, verdict, "verdict", TEXT, READ, 0, ECT_PROGRESS_WORD - 1, NULL,
               "running, met, failed; over: the script has no expectations"),
};

static const ect_signal_group_t groups[] = {
    {.prefix = "scenario", .signal_count = sizeof signals / sizeof signals[0], .signals = signals}};

const ect_plant_t ect_progress_plant = {.signal_groups = groups, .signal_group_count = 1};
