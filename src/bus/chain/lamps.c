/* SPDX-License-Identifier: MIT */
#include "bus/chain/lamps.h"

#include <string.h>

#include "slave/indicator.h"
#include "wire/assert.h"

enum { RUN, ERR, IN, OUT };

#define R(member, name, kind, minimum, maximum, meaning)                                                               \
    ECT_SIGNAL(ect_lamps_t, member, name, kind, READ, minimum, maximum, NULL, meaning)
#define LAMP(lamp, name, meaning) R(text[lamp], name, TEXT, 0, ECT_LAMP_TEXT - 1, meaning)

static const ect_signal_t signals[] = {
    LAMP(RUN, "run", "RUN lamp: off, blinking, single flash, on: INIT, PREOP, SAFEOP, OP"),
    LAMP(ERR, "err", "ERR lamp: blinking a refused request, single flash a lost state, double flash watchdog"),
    LAMP(IN, "link_in", "Link/Activity of the input: off, on, flickering"),
    LAMP(OUT, "link_out", "Link/Activity of the output"),
    R(al_state, "state", U8, 0, 8, "AL state: 1 INIT, 2 PREOP, 3 BOOT, 4 SAFEOP, 8 OP, 0 off the bus"),
    R(al_code, "code", U16, 0, 65535, "AL status code, 0 no error"),
};

static const ect_signal_group_t groups[] = {
    {.prefix = "ecat", .signal_count = sizeof signals / sizeof signals[0], .signals = signals}};

const ect_plant_t ect_lamps_plant = {.signal_groups = groups, .signal_group_count = 1};

static void show(ect_lamps_t *lamps, unsigned int lamp, ect_pattern_t pattern)
{
    const char *name = ect_pattern_name(pattern);
    ECT_ASSERT(strlen(name) < ECT_LAMP_TEXT);
    memset(lamps->text[lamp], 0, ECT_LAMP_TEXT);
    memcpy(lamps->text[lamp], name, strlen(name));
}

/* @return the state that determines the lamps; never 0 */
static uint64_t seen_of(const ect_slave_t *slave, bool in_link, bool out_link, bool traffic)
{
    return 1u | (uint64_t)in_link << 4 | (uint64_t)slave->off_bus << 1 | (uint64_t)out_link << 2 |
           (uint64_t)traffic << 3 | (uint64_t)slave->state << 8 | (uint64_t)slave->cause << 16 |
           (uint64_t)slave->code << 24;
}

void ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link, uint64_t last_frame_ns,
                      uint64_t now_ns)
{
    ect_pattern_t link = ect_indicator_link(true, last_frame_ns, now_ns);
    bool traffic = link == ECT_PATTERN_FLICKERING;
    uint64_t seen = seen_of(slave, in_link, out_link, traffic);
    if (seen != lamps->seen) {
        bool on = !slave->off_bus;
        lamps->seen = seen;
        lamps->al_state = on ? slave->state : 0;
        lamps->al_code = on ? slave->code : 0;
        show(lamps, RUN, on ? ect_indicator_run(slave) : ECT_PATTERN_OFF);
        show(lamps, ERR, on ? ect_indicator_err(slave, false) : ECT_PATTERN_OFF);
        show(lamps, IN, on && in_link ? link : ECT_PATTERN_OFF);
        show(lamps, OUT, on && out_link ? link : ECT_PATTERN_OFF);
    }
}
