/* SPDX-License-Identifier: MIT */
#include "bus/faults.h"

#include "seams/random.h"

ect_verdict_t ect_faults_draw(ect_faults_t *faults)
{
    if (faults->drop_percent == 0 && faults->delay_percent == 0)
        return ECT_VERDICT_PASS;
    uint32_t lot = ect_random_next(&faults->seed) % 200u;
    uint32_t dropped = 2u * faults->drop_percent;
    if (lot < dropped)
        return lot % 2 == 0 ? ECT_VERDICT_LOSE_REQUEST : ECT_VERDICT_LOSE_ANSWER;
    return lot < dropped + 2u * faults->delay_percent ? ECT_VERDICT_DELAY : ECT_VERDICT_PASS;
}
