/* SPDX-License-Identifier: MIT */
/* The control socket: watched signals (control.h, watch.h). */
#define _GNU_SOURCE
#include "support/control_bench.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "bus/chain/settings.h"
#include "bus/control/watch.h"

/* --- watching ----------------------------------------------------------------------------------------------------- */

static void set_encoder(bench_t *b, unsigned int value)
{
    ect_signal_ref_t ref;
    char text[16], message[ECT_SIGNAL_MESSAGE];
    snprintf(text, sizeof text, "%u", value);
    assert_true(ect_chain_signal(b->wire.chain, 0, "ru1.encoder", &ref));
    assert_true(ect_signal_write(&ref, text, b->wire.now_ns, message));
}

static void changes_every_10_ms(void **state)
{
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
    send_text(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\"}\n");
    serve(&b);
    receive_text(fd, got, sizeof got);
    uint64_t round = ect_control_due(b.control);
    assert_true(round > b.wire.now_ns && round <= b.wire.now_ns + 10 * MS);
    set_encoder(&b, 5);
    set_encoder(&b, 6);
    b.wire.now_ns = round - 1;
    assert_int_equal(serve(&b), 0);
    b.wire.now_ns = round;
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_string_equal(got, "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":6,\"time\":1.010000}\n");
    set_encoder(&b, 7);
    set_encoder(&b, 6); /* the previous value before the next round: no change */
    b.wire.now_ns += 10 * MS;
    serve(&b);
    assert_int_equal(receive_text(fd, got, sizeof got), 0);
    close(fd);
    serve(&b);
    assert_true(ect_control_due(b.control) == ECT_NEVER); /* no rounds without a client that watches */
    close_bench(&b);
}

/* Each watched signal has a last value of its own. */
static void a_change_is_reported_once(void **state)
{
    static const char *const watches[] = {"ru1.buttons", "bu.state", "ru1.encoder"};
    char got[1024], request[96];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
    for (size_t i = 0; i < sizeof watches / sizeof watches[0]; i++) {
        snprintf(request, sizeof request, "{\"op\":\"watch\",\"pattern\":\"%s\"}\n", watches[i]);
        send_text(fd, request);
        serve(&b);
    }
    receive_text(fd, got, sizeof got);
    set_encoder(&b, 5);
    for (unsigned int n = 0; n < 3; n++) {
        b.wire.now_ns += 10 * MS;
        serve(&b);
        receive_text(fd, got, sizeof got);
        assert_int_equal(count_of(got, "ru1.encoder"), n == 0 ? 1 : 0);
    }
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* A change of any byte of a value is reported, for each size. */
static void every_byte_of_a_value(void **state)
{
    static const struct {
        const char *device, *name;
        size_t size;
    } rows[] = {{"vr-bu-ect-map7", "ru1.encoder", 1},
                {"fzm1", "output_time", 2},
                {"vr-bu-ect-map7", "bu.command_lifetime", 4},
                {"fzm1", "data1", 8}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        unsigned int budget = 1000;
        ect_signal_ref_t ref;
        ect_line_t line;
        bench_t b;
        open_bench(&b, rows[i].device, 1);
        ect_watch_t *watch = ect_watch_new();
        assert_true(ect_chain_signal(b.wire.chain, 0, rows[i].name, &ref));
        if (ect_signal_size(ref.signal) != rows[i].size)
            fail_msg("%s has %zu bytes", rows[i].name, ect_signal_size(ref.signal));
        assert_true(ect_watch_add(watch, &ref, 0));
        for (size_t at = 0; at < rows[i].size; at++) {
            ref.value[at] ^= 1;
            ect_watch_round(watch);
            assert_true(ect_watch_next(watch, &budget, b.wire.now_ns, &line));
            ect_watch_round(watch);
            assert_false(ect_watch_next(watch, &budget, b.wire.now_ns, &line));
        }
        ect_watch_free(watch);
        close_bench(&b);
    }
}

static void every_change(void **state)
{
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
    send_text(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\",\"every\":true}\n");
    serve(&b);
    receive_text(fd, got, sizeof got);
    for (unsigned int i = 1; i <= 3; i++) {
        b.wire.now_ns += 7000;
        set_encoder(&b, i % 2);
        ect_control_record(b.control, b.wire.chain, b.wire.now_ns);
    }
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_string_equal(got, "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":1,\"time\":1.000007}\n"
                             "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":0,\"time\":1.000014}\n"
                             "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":1,\"time\":1.000021}\n");
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void set_of_fzm1(bench_t *b, const char *name, const char *value)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    const ect_setting_t setting = {name, value};
    if (!ect_settings_apply(b->wire.chain, 0, &setting, 1, b->wire.now_ns, message))
        fail_msg("%s", message);
}

/* The list of changes can be played in its order, regardless of the order of the watches. */
static void choices_come_first(void **state)
{
    static const struct {
        const char *watch, *set[2]; /* name and value; data1 is 5 in the first scene */
        const char *names[4];       /* of the reply */
    } rows[] = {
        {"{\"op\":\"watch\",\"pattern\":\"[ds][ac][te][an]*\"%s}\n", {"scene", "3"}, {"scene", "data1"}},
        {"{\"op\":\"watch\",\"pattern\":\"data1\"%s}\n{\"op\":\"watch\",\"pattern\":\"scene\"%s}\n",
         {"scene", "3"},
         {"scene", "data1"}},
        {"{\"op\":\"watch\",\"pattern\":\"data1\"%s}\n{\"op\":\"watch\",\"pattern\":\"scene*\"%s}\n",
         {"scene_group", "2"},
         {"scene_group", "data1"}},
        {"{\"op\":\"watch\",\"pattern\":\"data1\"%s}\n{\"op\":\"watch\",\"pattern\":\"scene*\"%s}\n",
         {"data1", "6"},
         {"data1"}},
    };
    (void)state;
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        const char *every = i % 2 != 0 ? ",\"every\":true" : "";
        char got[4096], request[256];
        bench_t b;
        open_bench(&b, "fzm1", 2);
        set_of_fzm1(&b, "data1", "5");
        int fd = connect_client(&b);
        set_nonblocking(fd);
        snprintf(request, sizeof request, rows[i / 2].watch, every, every);
        send_text(fd, request);
        serve(&b);
        receive_text(fd, got, sizeof got);
        set_of_fzm1(&b, rows[i / 2].set[0], rows[i / 2].set[1]);
        ect_control_record(b.control, b.wire.chain, b.wire.now_ns);
        b.wire.now_ns += 10 * MS;
        serve(&b);
        receive_text(fd, got, sizeof got);
        const char *at = got;
        for (size_t n = 0; rows[i / 2].names[n]; n++) {
            char want[64];
            snprintf(want, sizeof want, "{\"slave\":1,\"name\":\"%s\",", rows[i / 2].names[n]);
            if (strncmp(at, want, strlen(want)) != 0)
                fail_msg("row %zu%s: expected %s as change %zu of %s", i / 2, every, want, n + 1, got);
            at = strchr(at, '\n') + 1;
        }
        assert_string_equal(at, "");
        close(fd);
        serve(&b);
        close_bench(&b);
    }
}

/* Only the lamps of twins with a watched lamp are updated, because their computation has a cost. */
static void watched_lamps(void **state)
{
    static const struct {
        const char *watch;
        unsigned int updates; /* of the lamps of a twin, for each comparison */
        const char *reply;
    } rows[] = {
        {"{\"op\":\"watch\",\"slave\":2,\"pattern\":\"ecat.state\",\"every\":true}\n", 1,
         "{\"slave\":2,\"name\":\"ecat.state\",\"value\":2,"},
        {"{\"op\":\"watch\",\"slave\":2,\"pattern\":\"ecat.state\"}\n", 1,
         "{\"slave\":2,\"name\":\"ecat.state\",\"value\":2,"},
        {"{\"op\":\"watch\",\"slave\":0,\"pattern\":\"ru1.encoder\",\"every\":true}\n", 0, ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char got[1024];
        bench_t b;
        open_bench(&b, "vr-bu-ect-map7", 3);
        int fd = connect_client(&b);
        set_nonblocking(fd);
        send_text(fd, rows[i].watch);
        serve(&b);
        receive_text(fd, got, sizeof got);
        wire_go(&b.wire, 1, 2);
        work.lamps = 0;
        ect_control_record(b.control, b.wire.chain, b.wire.now_ns);
        b.wire.now_ns += 10 * MS;
        unsigned int updates = work.lamps;
        while (wants_to_be_served(&b)) {
            serve_once(&b);
            updates += work.lamps;
        }
        receive_text(fd, got, sizeof got);
        if (strncmp(got, rows[i].reply, strlen(rows[i].reply)) != 0 || updates != rows[i].updates)
            fail_msg("%s: expected %s and %u updates of lamps, got %s and %u", rows[i].watch, rows[i].reply,
                     rows[i].updates, got, updates);
        close(fd);
        serve(&b);
        close_bench(&b);
    }
}

/* An added signal is watched from the next round on, and begins no round. */
static void no_round_begins(void **state)
{
    static const char *const names[] = {"ru1.encoder", "ru2.encoder"};
    unsigned int budget = 100;
    ect_signal_ref_t refs[2];
    ect_line_t line;
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    ect_watch_t *watch = ect_watch_new();
    assert_non_null(watch);
    for (size_t i = 0; i < 2; i++) {
        assert_true(ect_chain_signal(b.wire.chain, 0, names[i], &refs[i]));
        assert_true(ect_watch_add(watch, &refs[i], 0));
        assert_int_equal(ect_watch_count(watch), i + 1);
        assert_false(ect_watch_pending(watch));
        *refs[i].value = 1;
        assert_false(ect_watch_next(watch, &budget, b.wire.now_ns, &line));
    }
    ect_watch_round(watch);
    assert_true(ect_watch_pending(watch));
    for (size_t i = 0; i < 2; i++)
        assert_true(ect_watch_next(watch, &budget, b.wire.now_ns, &line));
    assert_false(ect_watch_next(watch, &budget, b.wire.now_ns, &line));
    assert_false(ect_watch_pending(watch));
    ect_watch_free(watch);
    close_bench(&b);
}

/* Each of a thousand equal requests gets a reply; a change is reported once. */
static void a_repeated_watch_is_one(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
    for (unsigned int i = 0; i < 1000; i++) {
        send_text(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.*\"}\n");
        serve(&b);
        receive_text(fd, got, sizeof got);
        assert_int_equal(count_of(got, OK), 1);
    }
    set_encoder(&b, 9);
    b.wire.now_ns += 10 * MS;
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_int_equal(count_of(got, "\n"), 1);
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void most_signals_that_are_watched(void **state)
{
    static char got[ANSWER_ROOM];
    enum { TWINS = 16 };
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", TWINS);
    int fds[2];
    for (size_t i = 0; i < 2; i++) {
        fds[i] = connect_client(&b);
        set_nonblocking(fds[i]);
        send_text(fds[i],
                  i == 0 ? "{\"op\":\"watch\",\"slave\":0}\n" : "{\"op\":\"watch\",\"slave\":0,\"every\":true}\n");
        size_t used = 0;
        for (unsigned int n = 0; n < 1000; n++) {
            serve(&b);
            used += receive_text(fds[i], got + used, sizeof got - used);
        }
        assert_int_equal(count_of(got, "\n"), ECT_WATCH_MOST + 1);
        assert_non_null(strstr(got, i == 0 ? "a connection watches at most 4096 signals" : "4096"));
    }
    expect_part(&b, "{\"op\":\"watch\",\"every\":true}\n", "too many signals are watched at every change");
    expect_part(&b, "{\"op\":\"watch\",\"pattern\":\"bu.state\",\"every\":true}\n",
                "too many signals are watched at every change");
    /* A request with `every` for signals that are already watched adds none. */
    send_text(fds[0], "{\"op\":\"watch\",\"pattern\":\"bu.state\",\"every\":true}\n");
    serve(&b);
    receive_text(fds[0], got, sizeof got);
    assert_non_null(strstr(got, "too many signals are watched at every change"));
    for (size_t i = 0; i < 2; i++)
        close(fds[i]);
    serve(&b);
    close_bench(&b);
}

/* Two connections together watch as many signals with `every` as are allowed. */
static void most_signals_of_all_connections(void **state)
{
    static char got[ANSWER_ROOM];
    static const char *const requests[] = {"{\"op\":\"watch\",\"slave\":1,\"every\":true}\n",
                                           "{\"op\":\"watch\",\"slave\":0,\"every\":true}\n"};
    size_t lines[2] = {0};
    int fds[2];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 16);
    for (size_t i = 0; i < 2; i++) {
        size_t used = 0;
        fds[i] = connect_client(&b);
        set_nonblocking(fds[i]);
        send_text(fds[i], requests[i]);
        for (unsigned int n = 0; n < 1000; n++) {
            serve(&b);
            used += receive_text(fds[i], got + used, sizeof got - used);
        }
        lines[i] = count_of(got, "\"slave\":");
    }
    assert_true(lines[0] > 200);
    assert_int_equal(lines[0] + lines[1], ECT_CONTROL_EVERY);
    assert_non_null(strstr(got, "too many signals are watched at every change, 4096 in all"));
    for (size_t i = 0; i < 2; i++)
        close(fds[i]);
    serve(&b);
    close_bench(&b);
}

/* The client gets a line that reports the loss, and the connection ends. */
static void a_slow_watcher_of_every_change_is_disconnected(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
    send_text(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\",\"every\":true}\n");
    serve(&b);
    for (unsigned int i = 1; i < 100000; i++) {
        set_encoder(&b, i % 256);
        ect_control_record(b.control, b.wire.chain, b.wire.now_ns + i);
        if (i % 100 == 0)
            serve(&b);
    }
    size_t used = 0;
    for (unsigned int n = 0; n < 1000; n++) {
        serve(&b);
        used += receive_text(fd, got + used, sizeof got - used);
    }
    assert_non_null(strstr(got, "changes were lost"));
    assert_int_equal(read(fd, got, 1), 0);
    close(fd);
    close_bench(&b);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Watch: every 10 ms, each changed value is one line", changes_every_10_ms, NULL, NULL, NULL},
        {"Watch: a change is reported once, regardless of other watched signals", a_change_is_reported_once, NULL, NULL,
         NULL},
        {"Watch: an added signal begins no round", no_round_begins, NULL, NULL, NULL},
        {"Watch: a change of any byte of a value is reported", every_byte_of_a_value, NULL, NULL, NULL},
        {"Watch: with every, each change is reported with its time", every_change, NULL, NULL, NULL},
        {"Watch: the number of a scene is reported before the values that change with it", choices_come_first, NULL,
         NULL, NULL},
        {"Watch: the lamps of a twin are updated if one of them is watched", watched_lamps, NULL, NULL, NULL},
        {"Attack: a signal of 1000 equal watches is watched once", a_repeated_watch_is_one, NULL, NULL, NULL},
        {"Attack: a connection watches at most 4096 signals", most_signals_that_are_watched, NULL, NULL, NULL},
        {"Attack: all connections together watch at most 4096 signals with every", most_signals_of_all_connections,
         NULL, NULL, NULL},
        {"Attack: a client that watches with every and does not read is disconnected",
         a_slow_watcher_of_every_change_is_disconnected, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket: watching", tests, NULL, NULL);
}
