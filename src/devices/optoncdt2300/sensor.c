/* SPDX-License-Identifier: MIT */
/* The sensor's time: when records are taken. */
#include <string.h>

#include "devices/optoncdt2300/instance.h"

/* Shortest time between two updates of process data, at any measuring rate: no master reads faster. */
enum { RENEWAL_NS = 250000, IDLE_NS = 10000000 };

static const struct {
    uint32_t hz, period_ns;
} rates[OPTO_RATES] = {{1500, 666667}, {2500, 400000}, {5000, 200000}, {10000, 100000},
                       {20000, 50000}, {30000, 33333}, {49140, 20350}};

bool opto_is_rate(uint32_t hz)
{
    for (unsigned int i = 0; i < OPTO_RATES; i++) {
        if (rates[i].hz == hz)
            return true;
    }
    return false;
}

static uint64_t period_ns(const opto_t *u)
{
    if (u->synchronised)
        return u->sync.cycle_ns;
    unsigned int i = 0;
    while (i < OPTO_RATES - 1 && rates[i].hz != u->rate_hz)
        i++;
    return rates[i].period_ns;
}

/* SYNC0 triggers records from its first pulse on; without SYNC0 records follow at the sensor's own rate. */
static void follow_sync0(opto_t *u)
{
    bool runs = u->al_state == ECT_STATE_OP && u->sync.dc != 0 && u->sync.sync0_ns != 0;
    if (runs == u->synchronised)
        return;
    uint64_t last_ns = u->next_ns - period_ns(u);
    u->synchronised = runs;
    u->next_ns = runs ? u->sync.sync0_ns : last_ns + period_ns(u);
    if (u->next_ns <= last_ns)
        u->next_ns += ((last_ns - u->next_ns) / period_ns(u) + 1) * period_ns(u);
}

/* Counts records that no later exchange can contain, and does not take them. */
static void skip(opto_t *u, uint64_t now_ns)
{
    uint64_t due = u->next_ns <= now_ns ? (now_ns - u->next_ns) / period_ns(u) + 1 : 0;
    uint64_t skipped = due > OPTO_MOST_RECORDS ? due - OPTO_MOST_RECORDS : 0;
    u->taken += skipped;
    u->oldest = skipped > 0 ? u->taken : u->oldest;
    u->next_ns += skipped * period_ns(u);
}

static const char *reason_of(int32_t distance)
{
    switch (distance) {
    case OPTO_LASER_OFF:
        return "the laser is off";
    case OPTO_TOO_WIDE:
        return "the peak is too wide";
    case OPTO_NOT_EVALUATED:
        return "the measurement cannot be evaluated";
    case OPTO_NOT_CALCULATED:
        return "the measurement cannot be calculated";
    case OPTO_BEHIND_RANGE:
        return "the peak is behind the measuring range";
    case OPTO_BEFORE_RANGE:
        return "the peak is before the measuring range";
    case OPTO_NO_PEAK:
        return "no peak";
    default:
        return "";
    }
}

static void publish(opto_t *u)
{
    u->synchronised_level = u->synchronised;
    for (unsigned int n = 0; n < OPTO_SURFACES; n++) {
        const char *reason = reason_of(u->record.value[n == 0 ? OPTO_DISTANCE_1 : OPTO_DISTANCE_2]);
        memcpy(u->why[n], reason, strlen(reason) + 1);
    }
}

void opto_advance(opto_t *u, uint64_t now_ns)
{
    follow_sync0(u);
    skip(u, now_ns);
    for (; u->next_ns <= now_ns; u->next_ns += period_ns(u)) {
        opto_take_record(u, u->next_ns, period_ns(u));
        opto_keep(u);
    }
    publish(u);
}

void opto_new_rate(opto_t *u, uint64_t now_ns)
{
    if (!u->synchronised)
        u->next_ns = now_ns + period_ns(u);
}

/* --- from the stack ----------------------------------------------------------------------------------------------- */

void opto_init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    opto_t *u = instance;
    u->host = host;
    u->start_ns = now_ns;
    u->next_ns = now_ns; /* the first record is due at once */
    if (!u->plant.known)
        opto_default_plant(&u->plant);
    u->user = u->plant.default_user;
    u->range = (float)u->plant.range;
    opto_advance(u, now_ns);
}

uint16_t opto_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    opto_t *u = instance;
    (void)from;
    u->al_state = to;
    opto_advance(u, now_ns);
    return 0;
}

uint64_t opto_tick(void *instance, uint64_t now_ns)
{
    opto_t *u = instance;
    opto_advance(u, now_ns);
    if (u->al_state < ECT_STATE_SAFEOP)
        return now_ns + IDLE_NS;
    uint64_t soonest_ns = now_ns + RENEWAL_NS;
    uint64_t behind_ns = soonest_ns > u->next_ns ? soonest_ns - u->next_ns : 0;
    return u->next_ns + (behind_ns + period_ns(u) - 1) / period_ns(u) * period_ns(u);
}
