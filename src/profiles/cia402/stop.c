/* SPDX-License-Identifier: MIT */
/* Option codes 605Ah to 605Eh: the ramp of each kind of stop, and its time. */
#include "profiles/cia402/axis.h"

enum { OFF_AT_ONCE = 0, SLOW_RAMP = 1, QUICK_RAMP = 2, STAYS = 4, RAMP_TOLERANCE_NS = 200000000 };
#define AT_THE_LIMIT            1e12                  /* counts/s2: limited only by the torque */
#define LONGEST_AT_THE_LIMIT_NS UINT64_C(10000000000) /* with an unknown load */

static double slow_ramp(const ect_402_axis_t *a)
{
    return a->homing.active || a->mode == ECT_402_HM ? a->home_acceleration : ect_402_deceleration(a);
}

static double ramp(const ect_402_axis_t *a, int option)
{
    switch (option > STAYS ? option - STAYS : option) {
    case SLOW_RAMP:
        return slow_ramp(a);
    case QUICK_RAMP:
        return a->quick_deceleration;
    default: /* current or voltage limit */
        return AT_THE_LIMIT;
    }
}

double ect_402_stop_deceleration(const ect_402_axis_t *a)
{
    if (ect_402_halted(a))
        return ramp(a, a->halt_option);
    if (a->action == ECT_402_RAMP)
        return slow_ramp(a);
    return ramp(a, a->state == ECT_402_QUICK_STOP ? a->quick_option : a->fault_option);
}

void ect_402_stop_begin(ect_402_axis_t *a)
{
    double deceleration = ect_402_stop_deceleration(a);
    double ramp_ns = 1.5e9 * ect_402_size(a->plant->speed) / deceleration;
    uint64_t ns = deceleration < AT_THE_LIMIT ? RAMP_TOLERANCE_NS + (uint64_t)ramp_ns : LONGEST_AT_THE_LIMIT_NS;
    a->stop_until_ns = a->time_ns + ns;
}

bool ect_402_stop_in_time(const ect_402_axis_t *a)
{
    return a->action != ECT_402_STOP || a->time_ns < a->stop_until_ns || ect_402_standing(a);
}

bool ect_402_stop_waits(const ect_402_axis_t *a)
{
    ect_402_command_t command = ect_402_command(a->set.control, a->live);
    if (a->state == ECT_402_QUICK_STOP)
        return a->quick_option != OFF_AT_ONCE;
    if (a->state != ECT_402_OPERATION_ENABLED)
        return true;
    return command == ECT_402_SHUTDOWN ? a->shutdown_option != OFF_AT_ONCE : a->disable_option != OFF_AT_ONCE;
}

bool ect_402_stop_stays(const ect_402_axis_t *a)
{
    return a->quick_option > STAYS;
}

bool ect_402_stop_known(uint16_t index, int option)
{
    switch (index) {
    case 0x605A:
        return option >= OFF_AT_ONCE && option <= 2 * STAYS;
    case 0x605B:
    case 0x605C:
        return option == OFF_AT_ONCE || option == SLOW_RAMP;
    case 0x605D:
        return option >= SLOW_RAMP && option <= STAYS;
    default: /* 605Eh */
        return option >= OFF_AT_ONCE && option <= STAYS;
    }
}
