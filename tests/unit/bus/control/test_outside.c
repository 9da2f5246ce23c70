/* SPDX-License-Identifier: MIT */
/* Plants outside the process of the twins (outside.h), over the control socket. */
#define _GNU_SOURCE
#include "support/control_bench.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "bus/control/outside.h"

enum { ROOM = 65536 };

static struct {
    unsigned int count;
    char text[ECT_OUTSIDE_MESSAGE];
} reported;

/* Waits for work of clients, which then pass without time. */
static struct {
    bool fake;
    int result;
    unsigned int count;
} waits;

int __real_poll(struct pollfd *fds, nfds_t count, int ms);
int __wrap_poll(struct pollfd *fds, nfds_t count, int ms);

int __wrap_poll(struct pollfd *fds, nfds_t count, int ms)
{
    if (!waits.fake)
        return __real_poll(fds, count, ms);
    assert_int_equal(ms, 100);
    waits.count++;
    return waits.result;
}

static void on_report(void *ctx, const char *text)
{
    (void)ctx;
    reported.count++;
    (void)snprintf(reported.text, sizeof reported.text, "%s", text);
}

static void open_with_report(bench_t *b, size_t count, ect_stats_t *stats)
{
    memset(&reported, 0, sizeof reported);
    open_bench(b, "fzm1", count);
    stats->start_ns = b->wire.now_ns;
    ect_control_show(b->control, stats, NULL);
    ect_control_report(b->control, on_report, NULL);
}

/* Sends a line and serves it. @return the text received since the last call; valid until the next call */
static const char *say(bench_t *b, int fd, const char *line)
{
    static char got[ROOM];
    send_text(fd, line);
    serve(b);
    receive_text(fd, got, sizeof got);
    return got;
}

/* Advances the time, and begins due steps as the exchange does. @return the text that the client has received */
static const char *pass(bench_t *b, int fd, uint64_t ns)
{
    b->wire.now_ns += ns;
    if (ect_control_step_due(b->control) <= b->wire.now_ns)
        assert_false(ect_control_step(b->control, b->wire.chain, b->wire.now_ns));
    return say(b, fd, "");
}

static int start_plant(bench_t *b, const char *request)
{
    const int fd = connect_client(b);
    set_nonblocking(fd);
    assert_string_equal(say(b, fd, request), OK);
    return fd;
}

static void expect_stats(bench_t *b, const char *part)
{
    expect_part(b, "{\"op\":\"stats\"}\n", part);
}

#define PLANT                                                                                                          \
    "{\"op\":\"plant\",\"name\":\"tank\",\"reads\":[\"data1\",\"busy\"],\"writes\":[\"data2\",\"data3\"],"             \
    "\"period_us\":1000}\n"

static void refused_requests(void **state)
{
    static const struct {
        const char *request, *part;
    } rows[] = {
        {"{\"op\":\"plant\"}\n", "\\\"name\\\" of a plant is a text of 1 to 31"},
        {"{\"op\":\"plant\",\"name\":\"\"}\n", "1 to 31"},
        {"{\"op\":\"plant\",\"name\":\"a2345678901234567890123456789012\"}\n", "1 to 31"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"reads\":[\"datta1\"]}\n", "no signal 'datta1'; did you mean 'data1'?"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"reads\":[\"comment1\"]}\n", "comment1 is a text"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"reads\":[1]}\n", "lists of names"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"writes\":[\"nosuch\"]}\n", "no signal 'nosuch'"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"writes\":[\"comment1\"]}\n", "comment1 is a text"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"writes\":[\"busy\"]}\n", "busy is the twin's own"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"slave\":3,\"reads\":[\"data1\"]}\n", "no such slave"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"period_us\":1000}\n", "reads or sets a signal"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"reads\":[\"data1\"],\"period_us\":99}\n", "from 100 to"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"reads\":[\"data1\"],\"period_us\":4e9}\n", "from 100 to"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"reads\":[\"data1\"],\"period_us\":\"1000\"}\n", "from 100 to"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"reads\":[\"data1\"],\"period_us\":1000,\"wait\":true}\n",
         "needs a virtual clock"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"on\":7}\n", "the name of a signal"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"on\":\"nosuch\"}\n", "no signal 'nosuch'"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"on\":\"comment1\"}\n", "comment1 is a text"},
        {"{\"op\":\"plant\",\"name\":\"t\",\"on\":\"busy\",\"reads\":[\"data1\"],\"timeout_us\":1}\n", "from 100 to"},
        {"{\"op\":\"step\",\"values\":[]}\n", "this connection has no plant"},
    };
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 2, &stats);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_part(&b, rows[i].request, rows[i].part);
    assert_int_equal(reported.count, 0); /* no plant has started */
    assert_true(ect_control_step_due(b.control) == ECT_NEVER);
    close_bench(&b);
}

static void values_of_a_step_come_together(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 2, &stats);
    const int fd = start_plant(&b, "{\"op\":\"plant\",\"name\":\"two\",\"slave\":2,\"reads\":[\"data1\"]}\n");
    assert_string_equal(say(&b, fd,
                            "{\"op\":\"plant\",\"reads\":[\"data1\",\"ecat.state\"],\"writes\":[\"data2\",\"data3\"],"
                            "\"period_us\":1000}\n"),
                        OK);
    assert_non_null(strstr(say(&b, fd, PLANT), "this plant runs: its signals are fixed"));
    expect_answer(&b, "{\"op\":\"set\",\"slave\":2,\"name\":\"data1\",\"value\":2.5}\n", OK);
    assert_string_equal(pass(&b, fd, 0), "{\"step\":1,\"time\":0.000000,\"values\":[2.5,0,1]}\n");
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"values\":[-1.5,true]}\n"), "");
    expect_answer(&b, "{\"op\":\"get\",\"pattern\":\"data[23]\"}\n",
                  "{\"slave\":1,\"name\":\"data2\",\"value\":-1.5}\n{\"slave\":1,\"name\":\"data3\",\"value\":1}\n" OK);
    assert_string_equal(pass(&b, fd, MS - 1), "");
    assert_string_equal(pass(&b, fd, 1), "{\"step\":2,\"time\":0.001000,\"values\":[2.5,0,1]}\n");
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"values\":[null,7]}\n"), "");
    expect_answer(&b, "{\"op\":\"get\",\"pattern\":\"data[23]\"}\n",
                  "{\"slave\":1,\"name\":\"data2\",\"value\":-1.5}\n{\"slave\":1,\"name\":\"data3\",\"value\":7}\n" OK);
    assert_int_equal(reported.count, 0);
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void refused_replies_change_nothing(void **state)
{
    static const struct {
        const char *reply, *part;
    } rows[] = {
        {"{\"op\":\"step\",\"values\":[5,1e300]}\n", "data3 takes -999999999..999999999"},
        {"{\"op\":\"step\",\"values\":[5]}\n", "a value for each signal"},
        {"{\"op\":\"step\",\"values\":5}\n", "a value for each signal"},
        {"{\"op\":\"step\",\"values\":[5,\"5\"]}\n", "a number, true, false or null"},
        {"{\"op\":\"step\",\"values\":[5,1e999]}\n", "a number, true, false or null"},
    };
    ect_stats_t stats = {0};
    char part[64];
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    const int fd = start_plant(&b, PLANT);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_non_null(strstr(pass(&b, fd, MS), "\"values\":[0,0]"));
        assert_non_null(strstr(say(&b, fd, rows[i].reply), rows[i].part));
        expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data2\"}\n", "\"value\":0}");
        (void)snprintf(part, sizeof part, "\"refused\":%zu,", i + 1);
        expect_stats(&b, part);
    }
    assert_non_null(strstr(say(&b, fd, "{\"op\":\"step\",\"values\":[5,5]}\n"), "no step of this plant is pending"));
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void a_late_plant_is_reported_once_and_counted(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    const int fd = start_plant(&b, PLANT);
    assert_non_null(strstr(pass(&b, fd, 0), "\"step\":1,"));
    assert_string_equal(pass(&b, fd, MS), "");
    assert_int_equal(reported.count, 1);
    assert_string_equal(reported.text, "plant 'tank' is late: its signals keep their last values");
    assert_string_equal(pass(&b, fd, 3 * MS), ""); /* the twins have not run meanwhile: each period counts */
    expect_stats(&b, "\"steps\":1,\"late\":4,\"refused\":0,");
    b.wire.now_ns += MS / 2;
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"values\":[1,2]}\n"), "");
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data3\"}\n", "\"value\":2}");
    expect_stats(&b, "\"longest_us\":4500}");
    assert_non_null(strstr(pass(&b, fd, MS / 2), "\"step\":2,\"time\":0.005000,"));
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"values\":[1,2]}\n"), "");
    assert_non_null(
        strstr(pass(&b, fd, 10 * MS), "\"step\":3,\"time\":0.015000,")); /* the twins are late, not the plant */
    expect_stats(&b, "\"steps\":3,\"late\":4,");
    assert_int_equal(reported.count, 1);
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void a_plant_that_ends_leaves_its_values(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    int fd = start_plant(&b, PLANT);
    (void)pass(&b, fd, 0);
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"values\":[1,2]}\n"), "");
    expect_part(&b, PLANT, "a plant with this name is connected");
    close(fd);
    fd = connect_client(&b); /* before the twins have detected the end */
    set_nonblocking(fd);
    assert_string_equal(say(&b, fd, PLANT), OK);
    assert_int_equal(reported.count, 1);
    assert_string_equal(reported.text, "plant 'tank' has ended: its signals keep their last values");
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data3\"}\n", "\"value\":2}");
    expect_stats(&b, "{\"plant\":\"tank\",\"connected\":true,\"period_us\":1000,\"steps\":1,");
    close(fd);
    serve(&b);
    expect_stats(&b, "{\"plant\":\"tank\",\"connected\":false,\"period_us\":1000,\"steps\":1,");
    assert_true(ect_control_step_due(b.control) == ECT_NEVER);
    close_bench(&b);
    assert_int_equal(reported.count, 2);
}

static void a_client_that_does_not_read_is_late(void **state)
{
    enum { LINES = 4000 };
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    const int fd = start_plant(&b, PLANT);
    (void)pass(&b, fd, 0);
    for (unsigned int i = 0; i < LINES && reported.count == 0; i++) {
        send_text(fd, "{\"op\":\"step\",\"values\":[1,2]}\n{\"op\":\"get\"}\n");
        serve(&b);
        b.wire.now_ns += MS;
        (void)ect_control_step(b.control, b.wire.chain, b.wire.now_ns);
    }
    assert_string_equal(reported.text, "plant 'tank' is late: its signals keep their last values");
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void limits_of_plants_and_signals(void **state)
{
    static char request[ECT_OUTSIDE_VALUES * 16];
    ect_stats_t stats = {0};
    int fds[ECT_OUTSIDE_PLANTS];
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    for (unsigned int i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        (void)snprintf(request, sizeof request,
                       "{\"op\":\"plant\",\"name\":\"p%u\",\"reads\":[\"data1\"],\"period_us\":1000}\n", i);
        fds[i] = start_plant(&b, request);
    }
    expect_part(&b, PLANT, "four plants are connected, which is the limit");
    close(fds[1]);
    serve(&b);
    const int fd = start_plant(&b, "{\"op\":\"plant\",\"name\":\"many\"}\n"); /* replaces the plant that has ended */
    for (unsigned int writes = 0; writes < 2; writes++) {
        size_t used = (size_t)snprintf(request, sizeof request, "{\"op\":\"plant\",\"%s\":[\"data1\"",
                                       writes ? "writes" : "reads");
        for (unsigned int i = 1; i < ECT_OUTSIDE_VALUES; i++)
            used += (size_t)snprintf(request + used, sizeof request - used, ",\"data1\"");
        (void)snprintf(request + used, sizeof request - used, "]}\n");
        assert_string_equal(say(&b, fd, request), OK);
        const char *got =
            say(&b, fd,
                writes ? "{\"op\":\"plant\",\"writes\":[\"data2\"]}\n" : "{\"op\":\"plant\",\"reads\":[\"data2\"]}\n");
        assert_non_null(strstr(got, writes ? "a plant sets at most 128" : "a plant reads at most 128"));
    }
    assert_string_equal(say(&b, fd, "{\"op\":\"plant\",\"period_us\":2000000000}\n"), OK);
    const char *got = pass(&b, fd, 0);
    assert_int_equal(count_of(got, "{\"values\":[0,"), ECT_OUTSIDE_VALUES / ECT_OUTSIDE_VALUES_IN_LINE - 1);
    assert_int_equal(count_of(got, "0,") + count_of(got, "0]"), 1 + ECT_OUTSIDE_VALUES); /* and the time of the step */
    for (unsigned int i = 0; i < ECT_OUTSIDE_PLANTS; i++) {
        if (i != 1)
            close(fds[i]);
    }
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void without_memory_a_plant_is_refused(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    refuses_memory = true;
    expect_answer(&b, PLANT, "{\"ok\":false,\"message\":\"not enough memory\"}\n");
    refuses_memory = false;
    const int fd = start_plant(&b, PLANT);
    (void)pass(&b, fd, 0);
    refuses_memory = true;
    const char *got = say(&b, fd, "{\"op\":\"step\",\"values\":[1,2]}\n");
    refuses_memory = false;
    assert_string_equal(got, "{\"ok\":false,\"message\":\"not enough memory\"}\n");
    close(fd);
    serve(&b);
    close_bench(&b);
}

static struct {
    unsigned int count;
    char request[2][128];
} observed;

static void on_change(void *ctx, const char *request, size_t length)
{
    (void)ctx;
    if (observed.count < 2)
        (void)snprintf(observed.request[observed.count], sizeof observed.request[0], "%.*s", (int)length, request);
    observed.count++;
}

static void observers_get_replies_as_settings_of_each_twin(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    memset(&observed, 0, sizeof observed);
    open_with_report(&b, 3, &stats);
    ect_control_observe(b.control, on_change, NULL);
    const int fd = start_plant(&b, "{\"op\":\"plant\",\"name\":\"p\",\"slave\":3,\"writes\":[\"data1\",\"data4\"]}\n");
    assert_string_equal(say(&b, fd, "{\"op\":\"plant\",\"writes\":[\"data2\"],\"period_us\":1000}\n"), OK);
    assert_string_equal(pass(&b, fd, 0), "{\"step\":1,\"time\":0.000000,\"values\":[]}\n");
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"values\":[1,null,3]}\n"), "");
    assert_int_equal(observed.count, 2);
    assert_string_equal(observed.request[0], "{\"op\":\"set\",\"slave\":1,\"values\":{\"data2\":3}}");
    assert_string_equal(observed.request[1], "{\"op\":\"set\",\"slave\":3,\"values\":{\"data1\":1}}");
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void values_of_a_plant_that_fit_are_rounded_and_limited(void **state)
{
    static const struct {
        const char *sent, *judgement, *data3;
    } rows[] = {
        {"[0.6,0.6]", "1", "0.6"},       {"[-0.5,-0.25]", "-1", "-0.25"},         {"[0.49,2]", "0", "2"},
        {"[7,1e300]", "1", "999999999"}, {"[-1e300,-1e300]", "-1", "-999999999"}, {"[true,false]", "1", "0"},
        {"[null,5]", "1", "5"},
    };
    ect_stats_t stats = {0};
    char text[128];
    bench_t b;
    (void)state;
    memset(&observed, 0, sizeof observed);
    open_with_report(&b, 1, &stats);
    ect_control_observe(b.control, on_change, NULL);
    const int fd = start_plant(&b, "{\"op\":\"plant\",\"name\":\"t\",\"writes\":[\"judgement\",\"data3\"],"
                                   "\"period_us\":1000,\"fit\":true}\n");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_non_null(strstr(pass(&b, fd, MS), "\"values\":[]"));
        (void)snprintf(text, sizeof text, "{\"op\":\"step\",\"values\":%s}\n", rows[i].sent);
        assert_string_equal(say(&b, fd, text), "");
        (void)snprintf(text, sizeof text, "\"value\":%s}\n", rows[i].judgement);
        expect_part(&b, "{\"op\":\"get\",\"pattern\":\"judgement\"}\n", text);
        (void)snprintf(text, sizeof text, "\"value\":%s}\n", rows[i].data3);
        expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data3\"}\n", text);
    }
    expect_stats(&b, "\"refused\":0,");
    assert_string_equal(observed.request[0], "{\"op\":\"set\",\"slave\":1,\"values\":{\"judgement\":1,\"data3\":0.6}}");
    close(fd);
    serve(&b);
    close_bench(&b);
}

#define CAMERA                                                                                                         \
    "{\"op\":\"plant\",\"name\":\"cam\",\"reads\":[\"scene\"],\"writes\":[\"data1\",\"judgement\"],"                   \
    "\"on\":\"exposures\",\"timeout_us\":4000}\n"

/* Begins a measurement, and polls the devices. @return the text that the client receives */
static const char *trigger(bench_t *b, int fd)
{
    expect_answer(b, "{\"op\":\"set\",\"name\":\"trigger\",\"value\":1}\n", OK);
    (void)ect_chain_poll(b->wire.chain, b->wire.now_ns);
    assert_true(ect_control_wants_step(b->control, b->wire.now_ns));
    assert_false(ect_control_step(b->control, b->wire.chain, b->wire.now_ns));
    assert_false(ect_control_wants_step(b->control, b->wire.now_ns));
    return say(b, fd, "");
}

static void a_step_at_each_change_of_a_signal(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    (void)ect_chain_poll(b.wire.chain, b.wire.now_ns);
    const int fd = start_plant(&b, CAMERA);
    assert_false(ect_control_wants_step(b.control, b.wire.now_ns));
    assert_true(ect_control_step_due(b.control) == ECT_NEVER);
    assert_string_equal(trigger(&b, fd), "{\"step\":1,\"time\":0.000000,\"values\":[0]}\n");
    assert_true(ect_control_step_due(b.control) == b.wire.now_ns + 4 * MS);
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"step\":1,\"values\":[2.5,-1]}\n"), "");
    assert_true(ect_control_step_due(b.control) == ECT_NEVER);
    assert_string_equal(pass(&b, fd, 100 * MS), "");
    (void)ect_chain_poll(b.wire.chain, b.wire.now_ns);
    (void)ect_chain_poll(b.wire.chain, b.wire.now_ns + 20 * MS);
    b.wire.now_ns += 20 * MS;
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"result1\"}\n", "\"value\":2.5}");
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"or\"}\n", "\"value\":1}");

    assert_non_null(strstr(trigger(&b, fd), "\"step\":2,"));
    assert_string_equal(pass(&b, fd, 4 * MS), ""); /* the timeout */
    assert_string_equal(reported.text, "plant 'cam' is late: its signals keep their last values");
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"step\":2,\"values\":[7,1]}\n"), "");
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data1\"}\n", "\"value\":2.5}");
    expect_stats(&b, "\"steps\":2,\"late\":1,\"refused\":0,");
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void the_next_change_ends_a_step(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    (void)ect_chain_poll(b.wire.chain, b.wire.now_ns);
    const int fd = start_plant(&b, "{\"op\":\"plant\",\"name\":\"p\",\"reads\":[\"data1\"],\"writes\":[\"data2\"],"
                                   "\"on\":\"data1\",\"timeout_us\":4000}\n");
    for (unsigned int i = 1; i <= 2; i++) {
        char text[96];
        (void)snprintf(text, sizeof text, "{\"op\":\"set\",\"name\":\"data1\",\"value\":%u}\n", i);
        expect_answer(&b, text, OK);
        assert_false(ect_control_step(b.control, b.wire.chain, b.wire.now_ns));
        (void)snprintf(text, sizeof text, "\"step\":%u,\"time\":0.000000,\"values\":[%u]", i, i);
        assert_non_null(strstr(say(&b, fd, ""), text));
    }
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"step\":1,\"values\":[1]}\n"),
                        ""); /* the reply to the first step is dropped */
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data2\"}\n", "\"value\":0}");
    assert_string_equal(say(&b, fd, "{\"op\":\"step\",\"step\":2,\"values\":[2]}\n"), "");
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data2\"}\n", "\"value\":2}");
    expect_stats(&b, "\"steps\":2,\"late\":1,");
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* A daemon's standard input may be closed: the connection of a plant then gets descriptor 0. */
static void a_plant_at_descriptor_0(void **state)
{
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    const int fd = connect_client(&b), input = dup(STDIN_FILENO);
    set_nonblocking(fd);
    (void)close(STDIN_FILENO);
    assert_string_equal(say(&b, fd, PLANT), OK);
    const bool used = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    assert_string_equal(pass(&b, fd, 0), "{\"step\":1,\"time\":0.000000,\"values\":[0,0]}\n");
    close(fd);
    serve(&b);
    const bool closed = fcntl(STDIN_FILENO, F_GETFD) < 0;
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        (void)close(input);
    }
    assert_true(used && closed);
    close_bench(&b);
}

/* --- a stopped clock ---------------------------------------------------------------------------------------------- */

/* A plant in a thread: replies to each step before number `until`, and then closes its connection. */
typedef struct replies {
    int fd;
    unsigned int until;
} replies_t;

static void *reply_to_steps(void *ctx)
{
    const replies_t *r = ctx;
    char text[256];
    for (unsigned int i = 1; i < r->until; i++) {
        const ssize_t got = read(r->fd, text, sizeof text - 1); /* a step is one send */
        char reply[64];
        (void)snprintf(reply, sizeof reply, "{\"op\":\"step\",\"values\":[%u,0]}\n", i);
        if (got <= 0 || write(r->fd, reply, strlen(reply)) < 0)
            break;
    }
    (void)!read(r->fd, text, sizeof text - 1);
    close(r->fd);
    return NULL;
}

static void a_virtual_clock_waits_for_a_plant_and_not_for_one_that_has_ended(void **state)
{
    enum { STEPS = 20 };
    ect_stats_t stats = {0};
    pthread_t thread;
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    ect_control_let_wait(b.control);
    assert_true(ect_control_step_due(b.control) == ECT_NEVER);
    replies_t replies = {.fd = connect_client(&b), .until = STEPS};
    send_text(replies.fd, "{\"op\":\"plant\",\"name\":\"tank\",\"reads\":[\"data1\"],\"writes\":[\"data2\",\"data3\"],"
                          "\"period_us\":1000,\"wait\":true}\n");
    assert_true(ect_control_await_plant(b.control, b.wire.chain, "tank", b.wire.now_ns));
    char text[64] = "";
    assert_int_equal(read(replies.fd, text, sizeof text - 1), strlen(OK));
    assert_int_equal(pthread_create(&thread, NULL, reply_to_steps, &replies), 0);
    for (unsigned int i = 1; i < STEPS; i++) {
        char value[32];
        assert_true(ect_control_step(b.control, b.wire.chain, b.wire.now_ns));
        (void)snprintf(value, sizeof value, "\"value\":%u}", i);
        expect_part(&b, "{\"op\":\"get\",\"pattern\":\"data2\"}\n", value);
        b.wire.now_ns += MS;
    }
    assert_true(ect_control_step(b.control, b.wire.chain, b.wire.now_ns));
    assert_string_equal(reported.text, "plant 'tank' has ended: its signals keep their last values");
    assert_int_equal(pthread_join(thread, NULL), 0);
    close_bench(&b);
}

static void a_plant_without_a_reply_is_given_up(void **state)
{
    ect_outsides_t all = {.may_wait = true, .report = on_report};
    char message[ECT_SIGNAL_MESSAGE];
    const int owner = 0;
    ect_stats_t stats = {0};
    ect_line_t line;
    bench_t b;
    (void)state;
    open_with_report(&b, 1, &stats);
    cJSON *request = cJSON_Parse("{\"name\":\"p\",\"reads\":[\"data1\"],\"period_us\":1000,\"wait\":true}");
    assert_null(ect_outside_request(&all, &owner, b.wire.chain, 1, request, b.wire.now_ns, message));
    cJSON_Delete(request);
    assert_null(ect_outside_named(&all, "q"));
    ect_outside_t *plant = ect_outside_named(&all, "p");
    assert_true(ect_outside_begin(&all, plant, b.wire.chain, b.wire.now_ns));
    assert_true(ect_outside_waits(plant));
    ect_outside_give_up(&all, plant);
    assert_false(ect_outside_waits(plant));
    assert_string_equal(reported.text, "plant 'p' is late: its signals keep their last values");
    assert_false(ect_outside_count(&all, ECT_OUTSIDE_PLANTS, &line));
    request = cJSON_Parse("{\"name\":\"r\",\"reads\":[\"data1\"],\"on\":\"data1\",\"timeout_us\":1000,\"wait\":true}");
    const int other = 1;
    assert_null(ect_outside_request(&all, &other, b.wire.chain, 1, request, b.wire.now_ns, message));
    cJSON_Delete(request);
    plant = ect_outside_named(&all, "r");
    expect_answer(&b, "{\"op\":\"set\",\"name\":\"data1\",\"value\":1}\n", OK);
    assert_true(ect_outside_begin(&all, plant, b.wire.chain, b.wire.now_ns));
    ect_outside_give_up(&all, plant);
    assert_null(ect_outside_due(&all, &other, UINT64_MAX - 1));
    expect_answer(&b, "{\"op\":\"set\",\"name\":\"data1\",\"value\":2}\n", OK);
    assert_ptr_equal(ect_outside_due(&all, &other, b.wire.now_ns), plant);
    ect_outside_skip(&all, plant, b.wire.now_ns); /* the change has no further step */
    assert_null(ect_outside_due(&all, &other, UINT64_MAX - 1));
    ect_outsides_clear(&all);
    close_bench(&b);
}

/* A step of a plant without a reply, and a wait for a plant that does not connect, on a machine without other work, and
 * on one whose clients always have work. */
static void a_wait_for_a_plant_has_an_end(void **state)
{
    static const struct {
        int result; /* of each wait */
        unsigned int reply, connection;
    } rows[] = {{0, 100, 200}, {1, 100000, 100000}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_stats_t stats = {0};
        bench_t b;
        open_with_report(&b, 1, &stats);
        ect_control_let_wait(b.control);
        const int fd =
            start_plant(&b, "{\"op\":\"plant\",\"name\":\"tank\",\"reads\":[\"data1\"],\"writes\":[\"data2\"],"
                            "\"period_us\":1000,\"wait\":true}\n");
        waits.fake = true;
        waits.result = rows[i].result;
        waits.count = 0;
        assert_true(ect_control_step(b.control, b.wire.chain, b.wire.now_ns + MS));
        assert_int_equal(waits.count, rows[i].reply);
        assert_string_equal(reported.text, "plant 'tank' is late: its signals keep their last values");
        waits.count = 0;
        assert_false(ect_control_await_plant(b.control, b.wire.chain, "pump", b.wire.now_ns));
        assert_int_equal(waits.count, rows[i].connection);
        waits.count = 0;
        assert_true(ect_control_await_plant(b.control, b.wire.chain, "tank", b.wire.now_ns));
        assert_int_equal(waits.count, 0);
        waits.fake = false;
        close(fd);
        close_bench(&b);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"An invalid request of a plant is refused in one line, before the plant starts", refused_requests, NULL, NULL,
         NULL},
        {"A plant gets the values of one time in each period; a reply sets all values except null",
         values_of_a_step_come_together, NULL, NULL, NULL},
        {"A reply with a refused value changes no signal, and is counted", refused_replies_change_nothing, NULL, NULL,
         NULL},
        {"Periods without a reply are counted; the first is reported; the signals keep their values",
         a_late_plant_is_reported_once_and_counted, NULL, NULL, NULL},
        {"The end of a plant is reported once; signals and counters remain, and the name is free",
         a_plant_that_ends_leaves_its_values, NULL, NULL, NULL},
        {"A plant whose client does not read is late", a_client_that_does_not_read_is_late, NULL, NULL, NULL},
        {"At most four plants are connected; each reads and sets at most 128 signals", limits_of_plants_and_signals,
         NULL, NULL, NULL},
        {"Without memory a plant and a reply of a plant are refused", without_memory_a_plant_is_refused, NULL, NULL,
         NULL},
        {"An observer gets the reply of a plant as a request set for each twin",
         observers_get_replies_as_settings_of_each_twin, NULL, NULL, NULL},
        {"With `fit`, values are rounded and limited like those of connections, also for observers",
         values_of_a_plant_that_fit_are_rounded_and_limited, NULL, NULL, NULL},
        {"FZM1: with `on`, a step begins with each image input; a reply after the timeout is dropped",
         a_step_at_each_change_of_a_signal, NULL, NULL, NULL},
        {"With `on`, the next change ends a step without a reply", the_next_change_ends_a_step, NULL, NULL, NULL},
        {"A virtual clock stops until a plant replies or ends",
         a_virtual_clock_waits_for_a_plant_and_not_for_one_that_has_ended, NULL, NULL, NULL},
        {"A plant whose connection has descriptor 0 gets its steps, and its end closes the descriptor",
         a_plant_at_descriptor_0, NULL, NULL, NULL},
        {"A plant that never replies is late, and the clock is not stopped for it again",
         a_plant_without_a_reply_is_given_up, NULL, NULL, NULL},
        {"A clock waits 10 s for a reply and 20 s for a plant, or for 100000 pieces of other work",
         a_wait_for_a_plant_has_an_end, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket: plants", tests, NULL, NULL);
}
