/* SPDX-License-Identifier: MIT */
/* The status word 6041h: bits 10, 12 and 13 of the manual, or of CiA 402-2 (`status_bits=402`). */
#include "devices/pmctendo/instance.h"

static uint16_t bit(bool on, uint16_t mask)
{
    return on ? mask : 0;
}

static uint16_t manual_bits(const pmctendo_t *u)
{
    const ect_402_homing_t *homing = &u->axis.homing;
    return (uint16_t)(bit(ect_402_reached(&u->axis), ECT_402_STATUS_TARGET) |
                      bit(homing->active, PMC_STATUS_REFERENCING) | bit(homing->error, PMC_STATUS_REFERENCE_ERROR));
}

uint16_t pmc_status(const pmctendo_t *u)
{
    const ect_402_axis_t *a = &u->axis;
    bool stop = !a->level[PMC_PSTOP] || !a->level[PMC_NSTOP];
    uint16_t mode = u->plant.status_bits == PMC_STATUS_402 ? ect_402_mode_bits(a) : manual_bits(u);
    return (uint16_t)(ect_402_status(a->state, &a->inputs) | bit(u->plant.power, ECT_402_STATUS_VOLTAGE) |
                      bit(u->warnings != 0, ECT_402_STATUS_WARNING) | bit(a->live, ECT_402_STATUS_REMOTE) |
                      bit(ect_402_limit_acts(a) || stop, ECT_402_STATUS_LIMIT) |
                      bit(ect_402_task_active(a), PMC_STATUS_TASK) | mode);
}
