/* SPDX-License-Identifier: MIT */
/* The requests `pdos`, `wires`, `counters`, `waves` and `capture` of the control protocol (bus/control/pdos.h,
 * docs/CONTROL.md). */
#include "bus/control/pdos.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/control_bench.h"
#include "support/terminal.h"
#include "support/testdev.h"

enum { LINES = 8 /* most lines of a reply */ };

static const char *next(wire_t *w, uint32_t *place)
{
    static ect_line_t line;
    if (!ect_pdos_next(ect_chain_slave(w->chain, 0), 1, place, &line))
        return "";
    line.text[line.length - 1] = 0;
    return line.text;
}

/* Eight bits out, eight bits in and a number, in the order of the SyncManagers. */
static void entries_of_a_terminal(void **state)
{
    static const char *const want[] = {
        [0] = "{\"slave\":1,\"place\":257,\"direction\":\"outputs\",\"sm\":0,\"pdo\":5632,\"pdo_name\":\"Outputs\",",
        [7] = "{\"slave\":1,\"place\":264,\"direction\":\"outputs\",\"sm\":0,\"pdo\":5632,\"pdo_name\":\"Outputs\",",
        [8] = "{\"slave\":1,\"place\":65793,\"direction\":\"inputs\",\"sm\":1,\"pdo\":6656,\"pdo_name\":\"Inputs\",",
        [16] = "{\"slave\":1,\"place\":131329,\"direction\":\"inputs\",\"sm\":2,\"pdo\":6657,\"pdo_name\":\"Counter\",",
    };
    uint32_t place = 0;
    wire_t w;
    (void)state;
    wire_open_one(&w, &terminal);
    terminal_t *device = ect_chain_slave(w.chain, 0)->config.instance;
    device->out[7] = 1;
    device->count = 0x1234;
    for (size_t i = 0; i < sizeof want / sizeof want[0]; i++) {
        const char *line = next(&w, &place);
        if (want[i])
            assert_int_equal(strncmp(line, want[i], strlen(want[i])), 0);
        assert_int_equal(strstr(line, "\"value\":1}") != NULL, i == 7);
        assert_int_equal(strstr(line, "\"bits\":16,") && strstr(line, "\"data\":\"3412\",\"value\":4660}"), i == 16);
    }
    assert_string_equal(next(&w, &place), "");
    assert_string_equal(next(&w, &place), "");
    place = 131330; /* after the last entry */
    assert_string_equal(next(&w, &place), "");
    wire_close(&w);
}

/* An empty PDO, a gap, a text, a partly mapped number, an entry without a name, a PDO that does not exist. */
static const ect_entry_t values_6000[] = {
    {0, ECT_TYPE_VISIBLE_STRING, 64, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Text", 0, ECT_OFFSET(terminal_t, out)}};
static const ect_entry_t values_6001[] = {
    {0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, NULL, 0, ECT_OFFSET(terminal_t, count)}};
static const ect_entry_t empty_1a00[] = {ECT_ENTRY_COUNT(0)};
static const ect_entry_t odd_1a01[] = {
    ECT_ENTRY_COUNT(4), ECT_ENTRY_MAP(1, ECT_MAP(0, 0, 7)), ECT_ENTRY_MAP(2, ECT_MAP(0x6000, 0, 64)),
    ECT_ENTRY_MAP(3, ECT_MAP(0x6001, 0, 4)), ECT_ENTRY_MAP(4, ECT_MAP(0x6002, 1, 8))};
static const ect_entry_t odd_assigned[] = {ECT_ENTRY_COUNT(3), ECT_ENTRY_ASSIGN(1, 0x1A00), ECT_ENTRY_ASSIGN(2, 0x1A05),
                                           ECT_ENTRY_ASSIGN(3, 0x1A01)};
static const ect_object_t odd_objects[] = {ECT_RECORD(0x1A00, "Empty", empty_1a00), ECT_RECORD(0x1A01, NULL, odd_1a01),
                                           ECT_ARRAY(0x1C11, "Assignment", odd_assigned),
                                           ECT_VAR(0x6000, "Text", values_6000), ECT_VAR(0x6001, NULL, values_6001)};

static void unusual_mappings(void **state)
{
    static const char *const want[] = {
        "\"pdo\":6657,\"index\":0,\"sub\":0,\"bits\":7}",
        "\"name\":\"Text\",\"type\":\"VISIBLE_STRING\",\"data\":\"4869000000000000\",\"value\":\"Hi\"}",
        "\"bits\":4,\"type\":\"UNSIGNED16\",\"data\":\"0500\",\"value\":5}",
        "\"index\":24578,\"sub\":1,\"bits\":8}",
    };
    ect_device_t odd = terminal;
    uint32_t place = 0;
    wire_t w;
    (void)state;
    odd.objects = odd_objects;
    odd.object_count = sizeof odd_objects / sizeof odd_objects[0];
    wire_open_one(&w, &odd);
    terminal_t *device = ect_chain_slave(w.chain, 0)->config.instance;
    memcpy(device->out, "Hi", 2);
    device->count = 5;
    for (size_t i = 0; i < sizeof want / sizeof want[0]; i++) {
        const char *line = next(&w, &place);
        if (!strstr(line, want[i]))
            fail_msg("%s\n%s", line, want[i]);
    }
    assert_string_equal(next(&w, &place), "");
    wire_close(&w);
}

static void by_the_socket(void **state)
{
    static const struct {
        const char *request, *want;
    } rows[] = {
        {"{\"op\":\"pdos\",\"slave\":2}\n", "{\"slave\":2,\"place\":131329,\"direction\":\"outputs\",\"sm\":2,"},
        {"{\"op\":\"pdos\",\"place\":16777215}\n", OK},
        {"{\"op\":\"pdos\",\"place\":16777216}\n", "\\\"place\\\" is that of a line, plus 1"},
        {"{\"op\":\"pdos\",\"slave\":0}\n", "there is no such slave in this chain"},
        {"{\"op\":\"wires\"}\n", "{\"slave\":1,\"up\":0,\"port\":0}\n{\"slave\":2,\"up\":1,\"port\":1}\n"},
        {"{\"op\":\"wires\",\"slave\":10}\n", "{\"slave\":10,\"up\":9,\"port\":1}\n" OK},
        {"{\"op\":\"counters\"}\n", "no working counters are counted here"},
    };
    char text[4096];
    bench_t b;
    (void)state;
    open_bench(&b, "pmctendo-dd5", 10);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_part(&b, rows[i].request, rows[i].want);
    int client = connect_client(&b);
    set_nonblocking(client);
    send_text(client, "{\"op\":\"wires\"}\n{\"op\":\"pdos\"}\n");
    serve(&b);
    (void)receive_text(client, text, sizeof text);
    assert_int_equal(count_of(text, "\"up\""), LINES);
    assert_true(count_of(text, "\"place\"") <= LINES);
    close(client);
    close_bench(&b);
}

static void counters(void **state)
{
    ect_datagrams_t datagrams = {0};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 2);
    ect_control_count(b.control, &datagrams);
    expect_answer(&b, "{\"op\":\"counters\"}\n", OK);
    assert_true(datagrams.until_ns == b.wire.now_ns + 5000 * MS);
    (void)wire_send(&b.wire, BRD, 0, 0x0130, (uint8_t[2]){0}, 2);
    ect_datagrams_count(&datagrams, b.wire.frame, b.wire.frame_length, b.wire.now_ns);
    expect_part(
        &b, "{\"op\":\"counters\"}\n",
        "{\"command\":\"BRD\",\"address\":19922944,\"length\":2,\"counter\":2,\"highest\":2,\"replies\":1,\"lower\":0,"
        "\"time\":");
    close_bench(&b);
}

static void waves(void **state)
{
#define WAVE(rest) "{\"op\":\"wave\",\"name\":\"scene\"," rest "}\n"
    static const struct {
        const char *request, *want;
    } rows[] = {
        {"{\"op\":\"waves\"}\n", OK},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":4.5,\"period\":2.5"), OK},
        {"{\"op\":\"waves\"}\n",
         "{\"slave\":1,\"name\":\"scene\",\"shape\":\"sine\",\"low\":1,\"high\":4.5,\"period\":2.5}\n" OK},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":1000,\"period\":1"), "scene"},
        {WAVE("\"shape\":\"saw\",\"low\":1,\"high\":4,\"period\":1"), "\\\"wave\\\" takes \\\"name\\\""},
        {WAVE("\"low\":1,\"high\":4,\"period\":1"), "takes"},
        {WAVE("\"shape\":\"sine\",\"high\":4,\"period\":1"), "takes"},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"period\":1"), "takes"},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":4"), "takes"},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":4,\"period\":-1"), "takes"},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":4,\"period\":2e6"), "takes"},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":4,\"period\":1000001"), "takes"},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":4,\"period\":0"), "a period of 0.01 s or more"},
        {WAVE("\"shape\":\"sine\",\"low\":1,\"high\":4,\"period\":1e6"), OK},
        {"{\"op\":\"wave\",\"shape\":\"sine\",\"low\":1,\"high\":4,\"period\":1}\n", "takes"},
        {WAVE("\"slave\":2,\"shape\":\"off\""), "no wave sets 'scene'"},
        {WAVE("\"shape\":\"off\""), OK},
        {"{\"op\":\"waves\"}\n", OK},
        {"{\"op\":\"wave\",\"shape\":\"off\"}\n", OK},
    };
    static ect_scenario_t scenario;
    static const ect_stats_t stats;
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 2);
    expect_part(&b, "{\"op\":\"waves\"}\n", "no waves can be set here");
    expect_part(&b, WAVE("\"shape\":\"off\""), "no waves can be set here");
    ect_control_show(b.control, &stats, &scenario);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_part(&b, rows[i].request, rows[i].want);
    close_bench(&b);
}

static void capture(void **state)
{
    uint8_t frame[60] = {0};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    ect_recent_t *recent = ect_control_recent(b.control);
    expect_part(&b, "{\"op\":\"capture\"}\n", "there is no capture");
    expect_answer(&b, "{\"op\":\"capture\",\"on\":true,\"time\":1000000000.5}\n", OK);
    assert_true(recent->on);
    assert_true(recent->offset_ns + b.wire.now_ns == 1000000000500000000ull);
    expect_part(&b, "{\"op\":\"capture\",\"offset\":0}\n", "the capture runs");
    for (size_t i = 0; i < 100; i++)
        ect_recent_add(recent, 0, ECT_PCAPNG_INBOUND, 0, frame, sizeof frame);
    expect_answer(&b, "{\"op\":\"capture\",\"on\":false}\n", OK);
    expect_part(&b, "{\"op\":\"capture\"}\n", "{\"serial\":1,\"size\":10");
    expect_part(&b, "{\"op\":\"capture\"}\n", ",\"offset\":2800,\"data\":\"");
    expect_part(&b, "{\"op\":\"capture\",\"offset\":99999}\n", "\\\"offset\\\" is a number from 0 to the size");
    expect_answer(&b, "{\"op\":\"capture\",\"on\":true,\"time\":-1}\n", OK);
    assert_true(recent->offset_ns == 0);
    assert_int_equal(recent->serial, 2);
    close_bench(&b);
}

/* A junction with two branches. */
static void wires_of_a_tree(void **state)
{
    ect_twin_config_t twins[4];
    unsigned int port;
    wire_t w;
    (void)state;
    for (size_t i = 0; i < 4; i++)
        twins[i] = ect_twin_default(&testdev, NULL);
    twins[1].up_port = 3;
    twins[3].up_port = 1;
    twins[1].up = twins[3].up = 0;
    wire_open_twins(&w, twins, 4);
    static const size_t up[] = {0, 1, 2, 1}, ports[] = {0, 3, 1, 1};
    for (size_t i = 0; i < 4; i++) {
        assert_int_equal(ect_chain_wire(w.chain, i, &port), up[i]);
        assert_int_equal(port, ports[i]);
    }
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Entries of PDOs are listed by SyncManager, with names and values", entries_of_a_terminal, NULL, NULL, NULL},
        {"Gaps and texts are listed; empty and unknown PDOs have no line", unusual_mappings, NULL, NULL, NULL},
        {"The control socket lists process data and wires, at most eight lines in a reply", by_the_socket, NULL, NULL,
         NULL},
        {"Working counters are counted for 5 s after each request", counters, NULL, NULL, NULL},
        {"The control socket begins, lists and ends waves", waves, NULL, NULL, NULL},
        {"The control socket begins and ends a capture, and reads it in pieces", capture, NULL, NULL, NULL},
        {"The wires of a tree lead to the ports of its junction", wires_of_a_tree, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket: the requests of the panel", tests, NULL, NULL);
}
