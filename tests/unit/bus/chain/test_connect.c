/* SPDX-License-Identifier: MIT */
/* Signals of twins that set signals of twins: values, limits, delays and loops, on the virtual clock. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/connect.h"
#include "devices/pmctendo/pmctendo.h"
#include "support/wire.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
enum { TWINS = 3 };

static wire_t w;

static int setup(void **state)
{
    ect_twin_config_t twins[TWINS];
    (void)state;
    for (unsigned int i = 0; i < TWINS; i++)
        twins[i] = ect_twin_default(&ect_pmctendo_dd5, &ect_pmctendo_dd5_plant);
    memset(&w, 0, sizeof w);
    wire_open_twins(&w, twins, TWINS);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

static ect_signal_ref_t signal_of(size_t position, const char *name)
{
    ect_signal_ref_t ref = {0};
    if (!ect_chain_signal(w.chain, position, name, &ref))
        fail_msg("twin %zu has no signal %s", position, name);
    return ref;
}

static void set(size_t position, const char *name, const char *value)
{
    char message[ECT_SIGNAL_MESSAGE];
    ect_signal_ref_t ref = signal_of(position, name);
    assert_true(ect_signal_write(&ref, value, w.now_ns, message));
    ect_chain_wake(w.chain, position);
    wire_poll(&w);
}

static void expect(size_t position, const char *name, const char *value)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    ect_signal_ref_t ref = signal_of(position, name);
    ect_signal_read(&ref, text);
    assert_string_equal(text, value);
}

static ect_connection_t from_to(size_t from, const char *source, size_t to, const char *target)
{
    return (ect_connection_t){
        .from = from, .to = to, .source = signal_of(from, source), .target = signal_of(to, target), .factor = 1};
}

static void connect(const ect_connection_t *list, size_t count)
{
    for (size_t i = 0; i < count; i++)
        assert_true(ect_connection_fits(&list[i]));
    assert_int_equal(ect_connections_loop(list, count), count);
    assert_true(ect_chain_connect(w.chain, list, count));
    wire_poll(&w);
}

static void count_calls(void *ctx, size_t position)
{
    unsigned int *calls = ctx;
    assert_true(position == 1 || position == 2);
    ++*calls;
}

static void through_twins(void **state)
{
    ect_connection_t list[] = {from_to(1, "analog", 2, "load"), from_to(0, "analog", 1, "analog")};
    (void)state;
    list[0].factor = 0.001;
    list[0].offset = 1;
    connect(list, COUNT(list));
    expect(2, "load", "1");
    set(0, "analog", "2000");
    expect(1, "analog", "2000");
    expect(2, "load", "3");
}

/* The target keeps what it has been set to meanwhile, unless the result is another. */
static void the_same_result_sets_nothing(void **state)
{
    ect_connection_t list[] = {from_to(0, "analog", 1, "analog")};
    (void)state;
    list[0].factor = 0.01;
    set(1, "analog", "9");
    connect(list, COUNT(list)); /* 0, for the first time */
    expect(1, "analog", "0");
    set(1, "analog", "7");
    set(0, "analog", "40");
    expect(1, "analog", "7");
    set(0, "analog", "100");
    expect(1, "analog", "1");
    set(1, "analog", "7");
    set(0, "analog", "149");
    expect(1, "analog", "7");
    set(0, "analog", "150");
    expect(1, "analog", "2");
}

/* Each connection has the value of its own source, with its fraction. */
static void real_values(void **state)
{
    const ect_connection_t list[] = {from_to(0, "load", 1, "load"), from_to(0, "friction", 1, "friction"),
                                     from_to(0, "brake", 1, "brake")};
    (void)state;
    connect(list, COUNT(list));
    set(0, "load", "-7.25");
    expect(1, "load", "-7.25");
    expect(1, "friction", "0.05");
    set(0, "friction", "2.5");
    set(0, "brake", "1e-07");
    expect(1, "load", "-7.25");
    expect(1, "friction", "2.5");
    expect(1, "brake", "1e-07");
}

static void at_the_limits(void **state)
{
    ect_connection_t list[] = {from_to(0, "analog", 1, "analog"), from_to(0, "analog", 1, "di1"),
                               from_to(0, "di1", 2, "di2")};
    (void)state;
    list[0].factor = 1e12;
    list[1].offset = -1000;
    list[2].invert = true;
    connect(list, COUNT(list));
    set(0, "analog", "-5");
    expect(1, "analog", "-32768");
    expect(1, "di1", "0");
    expect(2, "di2", "1");
    set(0, "analog", "1001");
    expect(1, "analog", "32767");
    expect(1, "di1", "1");
    set(0, "di1", "1");
    expect(2, "di2", "0");
}

/* Halves are rounded away from zero; the sum is rounded once. */
static void rounded(void **state)
{
    static const struct {
        double factor, offset;
        const char *from, *to;
    } rows[] = {{0.5, 0, "3", "2"},  {0.5, 0, "-3", "-2"}, {0.5, 0, "1", "1"},   {0.5, 0, "-1", "-1"},
                {0.25, 0, "1", "0"}, {0.25, 0, "-1", "0"}, {1, 0.5, "2", "3"},   {1, -0.5, "-2", "-3"},
                {-1, 10, "4", "6"},  {1, 0.25, "2", "2"},  {2, -1, "-7", "-15"}, {0, 5, "9", "5"}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ect_connection_t list[] = {from_to(0, "analog", 1, "analog")};
        list[0].factor = rows[i].factor;
        list[0].offset = rows[i].offset;
        set(0, "analog", rows[i].from);
        connect(list, COUNT(list));
        expect(1, "analog", rows[i].to);
    }
}

/* The earliest value of all delays is the time of the next call; without a delay there is none. */
static void next_time(void **state)
{
    ect_connection_t list[] = {from_to(0, "analog", 1, "analog"), from_to(0, "di1", 2, "di1"),
                               from_to(0, "di2", 2, "di2")};
    (void)state;
    list[0].delay_ns = 30 * MS;
    list[1].delay_ns = 20 * MS;
    ect_connections_t *connections = ect_connections_new(list, COUNT(list));
    assert_non_null(connections);
    assert_true(ect_connections_next(connections) == ECT_NEVER);
    unsigned int calls = 0;
    (void)ect_connections_run(connections, 100 * MS, count_calls, &calls);
    assert_true(ect_connections_next(connections) == 120 * MS);
    (void)ect_connections_run(connections, 119 * MS, count_calls, &calls);
    assert_true(ect_connections_next(connections) == 120 * MS);
    calls = 0;
    assert_true(ect_connections_run(connections, 120 * MS, count_calls, &calls));
    assert_int_equal(calls, 1);
    assert_true(ect_connections_next(connections) == 130 * MS);
    assert_true(ect_connections_run(connections, 130 * MS, count_calls, &calls));
    assert_int_equal(calls, 2);
    assert_true(ect_connections_next(connections) == ECT_NEVER);
    assert_false(ect_connections_run(connections, 200 * MS, count_calls, &calls));
    assert_int_equal(calls, 2);
    ect_connections_free(connections);
    ect_connections_free(NULL);
}

static void later(void **state)
{
    ect_connection_t list[] = {from_to(0, "analog", 1, "analog")};
    (void)state;
    list[0].delay_ns = 10 * MS;
    connect(list, COUNT(list));
    wire_advance(&w, 20 * MS);
    set(0, "analog", "100");
    wire_advance(&w, 3 * MS);
    set(0, "analog", "200");
    wire_advance(&w, 7 * MS - 1);
    expect(1, "analog", "0");
    wire_advance(&w, 1);
    expect(1, "analog", "100");
    wire_advance(&w, 3 * MS - 1);
    expect(1, "analog", "100");
    wire_advance(&w, 1);
    expect(1, "analog", "200");
}

/* Values that are due together set the target if any of their results is another one. */
static void due_together(void **state)
{
    static const struct {
        const char *first, *second;
        bool sets;
        const char *target;
    } rows[] = {{"200", "300", true, "3"},
                {"200", "240", true, "2"}, /* the second one gives the same result */
                {"40", "200", true, "2"},  /* the first one gives the result before */
                {"40", "30", false, "0"}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ect_connection_t list[] = {from_to(0, "analog", 1, "analog")};
        unsigned int calls = 0;
        set(0, "analog", "0");
        list[0].delay_ns = 10 * MS;
        list[0].factor = 0.01;
        ect_connections_t *connections = ect_connections_new(list, COUNT(list));
        assert_non_null(connections);
        (void)ect_connections_run(connections, 0, count_calls, &calls);
        assert_true(ect_connections_run(connections, 10 * MS, count_calls, &calls)); /* 0 */
        set(0, "analog", rows[i].first);
        (void)ect_connections_run(connections, 20 * MS, count_calls, &calls);
        set(0, "analog", rows[i].second);
        (void)ect_connections_run(connections, 21 * MS, count_calls, &calls);
        calls = 0;
        const bool sets = ect_connections_run(connections, 31 * MS, count_calls, &calls);
        if (sets != rows[i].sets || calls != (rows[i].sets ? 1u : 0u))
            fail_msg("%s, then %s: expected that it sets: %d, got %d with %u calls", rows[i].first, rows[i].second,
                     rows[i].sets, sets, calls);
        expect(1, "analog", rows[i].target);
        ect_connections_free(connections);
    }
}

static void crowded(void **state)
{
    ect_connection_t list[] = {from_to(0, "analog", 1, "analog")};
    (void)state;
    list[0].delay_ns = 10 * MS;
    connect(list, COUNT(list));
    for (int n = 1; n <= 2 * ECT_CONNECTION_VALUES; n++) {
        char text[12];
        (void)snprintf(text, sizeof text, "%d", n);
        set(0, "analog", text);
    }
    wire_advance(&w, 20 * MS);
    expect(1, "analog", "2048");
}

static void oscillator(void **state)
{
    ect_connection_t list[] = {from_to(0, "di1", 0, "di1")};
    unsigned int changes = 0;
    (void)state;
    assert_int_equal(ect_connections_loop(list, 1), 0);
    list[0].invert = true;
    list[0].delay_ns = 10 * MS;
    connect(list, COUNT(list));
    uint8_t before = *list[0].source.value;
    for (unsigned int ms = 0; ms < 105; ms++) {
        wire_advance(&w, MS);
        changes += *list[0].source.value != before;
        before = *list[0].source.value;
    }
    assert_int_equal(changes, 10);
}

static void loops(void **state)
{
    ect_connection_t list[] = {from_to(0, "analog", 1, "analog"), from_to(1, "analog", 2, "analog"),
                               from_to(0, "di1", 2, "di1"), from_to(2, "di2", 0, "di2")};
    (void)state;
    assert_int_equal(ect_connections_loop(list, 3), 3);
    assert_int_equal(ect_connections_loop(list, 4), 3);
    list[3].delay_ns = 1;
    assert_int_equal(ect_connections_loop(list, 4), 4);
}

/* A search along each path would take 2^59 paths. */
static void many_paths(void **state)
{
    enum { STAGES = 60 };
    ect_connection_t list[2 * STAGES + 1];
    (void)state;
    for (size_t i = 0; i < COUNT(list); i++) {
        list[i] = from_to(0, "analog", 1, "analog");
        list[i].from = STAGES - 1 - i / 2; /* the last stage is first in the list */
        list[i].to = STAGES - i / 2;
    }
    list[2 * STAGES].from = STAGES;
    list[2 * STAGES].to = 0;
    assert_int_equal(ect_connections_loop(list, 2 * STAGES), 2 * STAGES);
    assert_int_equal(ect_connections_loop(list, COUNT(list)), 2 * STAGES);
}

static void misfits(void **state)
{
    (void)state;
    ect_connection_t text = from_to(0, "state", 1, "analog");
    ect_connection_t output = from_to(0, "analog", 1, "torque");
    assert_false(ect_connection_fits(&text));
    assert_false(ect_connection_fits(&output));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"a value passes through twins in one poll, with factor and offset", through_twins, setup, teardown, NULL},
        {"a result that is the same again sets nothing", the_same_result_sets_nothing, setup, teardown, NULL},
        {"a signal with a fraction sets one", real_values, setup, teardown, NULL},
        {"values stop at the limits of the target; inversion", at_the_limits, setup, teardown, NULL},
        {"a value is rounded to the nearest integer, a half away from zero", rounded, setup, teardown, NULL},
        {"the time of the next value of all connections, and the twins whose signals are set", next_time, setup,
         teardown, NULL},
        {"a delay is exact, and keeps each value", later, setup, teardown, NULL},
        {"values that are due together set a target once", due_together, setup, teardown, NULL},
        {"a delay with too many values keeps the newest", crowded, setup, teardown, NULL},
        {"a loop with a delay is an oscillator", oscillator, setup, teardown, NULL},
        {"a loop without a delay is found", loops, setup, teardown, NULL},
        {"two connections between each twin and the next of 60 are checked at once", many_paths, setup, teardown, NULL},
        {"texts and outputs are no ends of a connection", misfits, setup, teardown, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
