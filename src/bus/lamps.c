/* SPDX-License-Identifier: MIT */
#include "bus/lamps.h"

#include <string.h>

#include "slave/indicator.h"

enum { RUN, ERR, IN, OUT, LAMPS };

#define R(member, name, kind, minimum, maximum, meaning)                                                               \
    {                                                                                                                  \
        name, meaning, NULL, ECT_SIGNAL_##kind, ECT_SIGNAL_READ, offsetof(ect_lamps_t, member), minimum, maximum       \
    }
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

const ect_device_t ect_lamps_device = {.name = "ecat", .signal_groups = groups, .signal_group_count = 1};

static void show(ect_lamps_t *lamps, unsigned int lamp, ect_pattern_t pattern)
{
    const char *name = ect_pattern_name(pattern);
    if (lamps->shown[lamp] == pattern && lamps->text[lamp][0] != 0)
        return;
    lamps->shown[lamp] = (uint8_t)pattern;
    memset(lamps->text[lamp], 0, ECT_LAMP_TEXT);
    memcpy(lamps->text[lamp], name, strlen(name));
}

uint64_t ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool out_link, uint64_t last_frame_ns,
                          uint64_t now_ns)
{
    bool on = !slave->off_bus;
    lamps->al_state = on ? slave->state : 0;
    lamps->al_code = on ? slave->code : 0;
    show(lamps, RUN, on ? ect_indicator_run(slave) : ECT_PATTERN_OFF);
    show(lamps, ERR, on ? ect_indicator_err(slave, false) : ECT_PATTERN_OFF);
    show(lamps, IN, ect_indicator_link(on, last_frame_ns, now_ns));
    show(lamps, OUT, ect_indicator_link(on && out_link, last_frame_ns, now_ns));
    return lamps->shown[IN] == ECT_PATTERN_FLICKERING ? last_frame_ns + ECT_INDICATOR_TRAFFIC_NS : ECT_NEVER;
}
