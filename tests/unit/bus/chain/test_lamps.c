/* SPDX-License-Identifier: MIT */
/* The EtherCAT lamps of a twin and its AL state, as signals (bus/chain/lamps.h). */
#include "bus/chain/lamps.h"

#include <string.h>

#include "bus/chain/signals.h"
#include "slave/indicator.h"
#include "support/wire.h"

enum { SIGNALS = 6 };

typedef struct view {
    const char *run, *err, *in, *out, *state, *code;
} view_t;

static void expect(const char *title, ect_lamps_t *lamps, const view_t *want)
{
    static const char *const names[SIGNALS] = {"ecat.run",      "ecat.err",   "ecat.link_in",
                                               "ecat.link_out", "ecat.state", "ecat.code"};
    const char *const texts[SIGNALS] = {want->run, want->err, want->in, want->out, want->state, want->code};
    for (size_t i = 0; i < SIGNALS; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_ref_t ref;
        assert_true(ect_signal_find(&ect_lamps_plant, lamps, names[i], &ref));
        ect_signal_read(&ref, text);
        if (strcmp(text, texts[i]) != 0)
            fail_msg("%s: expected %s '%s', got '%s'", title, names[i], texts[i], text);
    }
}

typedef struct scene {
    ect_slave_t slave;
    bool in, out;
    uint64_t frame_ns;
} scene_t;

/* From each row to each other row, on one structure: no part of the previous row stays. */
static void each_change(void **state)
{
    static const uint64_t now_ns = 1000 * MS;
    static const struct {
        const char *title;
        scene_t scene;
        view_t want;
    } rows[] = {
        {"INIT without links", {.slave = {.state = 1}}, {"off", "off", "off", "off", "1", "0"}},
        {"PREOP", {.slave = {.state = 2}}, {"blinking", "off", "off", "off", "2", "0"}},
        {"BOOT", {.slave = {.state = 3}}, {"flickering", "off", "off", "off", "3", "0"}},
        {"SAFEOP", {.slave = {.state = 4}}, {"single flash", "off", "off", "off", "4", "0"}},
        {"OP", {.slave = {.state = 8}}, {"on", "off", "off", "off", "8", "0"}},
        {"link at the input", {.slave = {.state = 1}, .in = true}, {"off", "off", "on", "off", "1", "0"}},
        {"link at the output", {.slave = {.state = 1}, .out = true}, {"off", "off", "off", "on", "1", "0"}},
        {"link at both", {.slave = {.state = 1}, .in = true, .out = true}, {"off", "off", "on", "on", "1", "0"}},
        {"traffic",
         {.slave = {.state = 1}, .in = true, .frame_ns = 1000 * MS},
         {"off", "off", "flickering", "off", "1", "0"}},
        {"traffic at the output",
         {.slave = {.state = 1}, .out = true, .frame_ns = 1000 * MS - ECT_INDICATOR_TRAFFIC_NS + 1},
         {"off", "off", "off", "flickering", "1", "0"}},
        {"traffic of the past",
         {.slave = {.state = 1}, .in = true, .frame_ns = 1000 * MS - ECT_INDICATOR_TRAFFIC_NS},
         {"off", "off", "on", "off", "1", "0"}},
        {"traffic without a link",
         {.slave = {.state = 1}, .frame_ns = 1000 * MS},
         {"off", "off", "off", "off", "1", "0"}},
        {"AL status code", {.slave = {.state = 1, .code = 0x8123}}, {"off", "off", "off", "off", "1", "33059"}},
        {"refused request",
         {.slave = {.state = 2, .code = 0x001D, .cause = ECT_CAUSE_REQUEST}},
         {"blinking", "blinking", "off", "off", "2", "29"}},
        {"lost state",
         {.slave = {.state = 2, .code = 0x001D, .cause = ECT_CAUSE_LOCAL}},
         {"blinking", "single flash", "off", "off", "2", "29"}},
        {"watchdog",
         {.slave = {.state = 4, .code = 0x001B, .cause = ECT_CAUSE_WATCHDOG}},
         {"single flash", "double flash", "off", "off", "4", "27"}},
        {"off the bus",
         {.slave = {.state = 8, .code = 0x1B, .off_bus = true}, .in = true, .out = true, .frame_ns = 1000 * MS},
         {"off", "off", "off", "off", "0", "0"}},
    };
    ect_lamps_t lamps = {0};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0] * (sizeof rows / sizeof rows[0]); i++) {
        const size_t order[] = {i / (sizeof rows / sizeof rows[0]), i % (sizeof rows / sizeof rows[0])};
        for (size_t k = 0; k < 2; k++) {
            const scene_t *s = &rows[order[k]].scene;
            ect_lamps_update(&lamps, &s->slave, s->in, s->out, s->frame_ns, now_ns);
            expect(rows[order[k]].title, &lamps, &rows[order[k]].want);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"each change of state, code, cause, links and traffic shows at once, whatever was shown before", each_change,
         NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("lamps", tests, NULL, NULL);
}
