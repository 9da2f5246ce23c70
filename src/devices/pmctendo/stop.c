/* SPDX-License-Identifier: MIT */
/* Option codes 605Ah to 605Eh: the ramp of each kind of stop, and its time. */
#include "devices/pmctendo/instance.h"

enum { OFF_AT_ONCE = 0, SLOW_RAMP = 1, QUICK_RAMP = 2, STAYS = 4, RAMP_TOLERANCE_NS = 200000000 };
#define AT_THE_LIMIT 1e12 /* counts/s2: as fast as the torque limit lets it */

static double slow_ramp(const pmctendo_t *u)
{
    return u->homing.active ? u->home_acceleration : pmc_deceleration(u);
}

static double ramp(const pmctendo_t *u, int option)
{
    switch (option > STAYS ? option - STAYS : option) {
    case SLOW_RAMP:
        return slow_ramp(u);
    case QUICK_RAMP:
        return u->quick_deceleration;
    default: /* current or voltage limit */
        return AT_THE_LIMIT;
    }
}

double pmc_stop_deceleration(const pmctendo_t *u)
{
    if (pmc_halted(u))
        return ramp(u, u->halt_option);
    if (u->action == ECT_402_RAMP)
        return slow_ramp(u);
    return ramp(u, u->state == ECT_402_QUICK_STOP ? u->quick_option : u->fault_option);
}

void pmc_stop_begin(pmctendo_t *u)
{
    double ramp_ns = 1.5e9 * pmc_size(u->plant.speed) / pmc_stop_deceleration(u);
    u->stop_until_ns = u->time_ns + RAMP_TOLERANCE_NS + (uint64_t)ramp_ns;
}

bool pmc_stop_in_time(const pmctendo_t *u)
{
    return u->action != ECT_402_STOP || u->time_ns < u->stop_until_ns || pmc_standing(u);
}

bool pmc_stop_waits(const pmctendo_t *u)
{
    ect_402_command_t command = ect_402_command(u->set.control, u->live);
    if (u->state == ECT_402_QUICK_STOP)
        return u->quick_option != OFF_AT_ONCE;
    if (u->state != ECT_402_OPERATION_ENABLED)
        return true;
    return command == ECT_402_SHUTDOWN ? u->shutdown_option != OFF_AT_ONCE : u->disable_option != OFF_AT_ONCE;
}

bool pmc_stop_stays(const pmctendo_t *u)
{
    return u->quick_option > STAYS;
}

bool pmc_stop_known(uint16_t index, int option)
{
    switch (index) {
    case 0x605A:
        return option >= OFF_AT_ONCE && option <= STAYS + QUICK_RAMP && option % STAYS <= QUICK_RAMP && option != STAYS;
    case 0x605B:
    case 0x605C:
        return option == OFF_AT_ONCE || option == SLOW_RAMP;
    case 0x605D:
        return option >= SLOW_RAMP && option <= STAYS;
    default: /* 605Eh */
        return option >= OFF_AT_ONCE && option <= STAYS;
    }
}
