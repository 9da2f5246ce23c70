/* SPDX-License-Identifier: MIT */
/* The bytes of a connection to a twin (programs/ectwin-panel/link.h), and the signals that pages plot (trace.h). */
#include "trace.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define OK "{\"ok\":true}\n"

static table_t *table;
static trace_t *trace;

static int begin(void **state)
{
    (void)state;
    table = calloc(1, sizeof *table);
    trace = calloc(1, sizeof *trace);
    return table && trace ? 0 : -1;
}

static int finish(void **state)
{
    (void)state;
    table_clear(table);
    free(table);
    free(trace);
    return 0;
}

static void add_signal(const char *name)
{
    char text[1200];
    (void)snprintf(text, sizeof text, "{\"slave\":1,\"name\":\"%s\"}", name);
    cJSON *line = cJSON_Parse(text);
    assert_true(table_add(table, text, line));
    cJSON_Delete(line);
}

/* --- the connection ----------------------------------------------------------------------------------------------- */

static struct {
    char text[2000];
    unsigned int lines;
} taken;

static void take(void *ctx, const link_request_t *request, const char *text, const cJSON *line, bool last)
{
    const size_t used = strlen(taken.text);
    assert_ptr_equal(ctx, &taken);
    assert_non_null(line);
    (void)snprintf(taken.text + used, sizeof taken.text - used, "%d:%.0f%s %s\n", request->kind, request->id,
                   last ? " last" : "", text);
    taken.lines++;
}

static void requests_wait_up_to_64(void **state)
{
    link_t *link = &trace->link;
    (void)state;
    for (unsigned int n = 0; n < 2 * LINK_WAITING; n++) {
        const link_request_t request = {.kind = LINK_PAGE, .id = n};
        assert_int_equal(link_ask(link, "{}", &request), n < LINK_WAITING);
    }
    assert_int_equal(link->unsent, 3 * LINK_WAITING);
    memset(&taken, 0, sizeof taken);
    for (unsigned int n = 0; n < LINK_WAITING; n++)
        assert_true(link_take(link, OK, strlen(OK), take, &taken));
    assert_false(link_take(link, OK, strlen(OK), take, &taken)); /* of no request */
    assert_int_equal(taken.lines, LINK_WAITING);
    assert_non_null(strstr(taken.text, "7:63 last {\"ok\":true}\n"));
    assert_true(link_ask(link, "{}", &(link_request_t){.kind = LINK_PAGE}));
}

/* Each reply makes room for one request, several times around the ring of those that wait. */
static void order_of_replies(void **state)
{
    link_t *link = &trace->link;
    (void)state;
    for (unsigned int n = 0; n < LINK_WAITING; n++)
        assert_true(link_ask(link, "{}", &(link_request_t){.kind = LINK_PAGE, .id = n}));
    for (unsigned int n = 0; n < 3 * LINK_WAITING; n++) {
        char want[64];
        (void)snprintf(want, sizeof want, "7:%u {\"a\":1}\n7:%u last {\"ok\":true}\n", n, n);
        memset(&taken, 0, sizeof taken);
        assert_true(link_take(link, "{\"a\":1}\n" OK, strlen("{\"a\":1}\n" OK), take, &taken));
        assert_string_equal(taken.text, want);
        link_sent(link, link->unsent);
        assert_true(link_ask(link, "{}", &(link_request_t){.kind = LINK_PAGE, .id = LINK_WAITING + n}));
        assert_false(link_ask(link, "{}", &(link_request_t){.kind = LINK_PAGE}));
    }
}

static void requests_have_16384_bytes(void **state)
{
    static char text[LINK_OUT + 2];
    const link_request_t request = {.kind = LINK_ABOUT};
    link_t *link = &trace->link;
    (void)state;
    memset(text, 'a', sizeof text - 1);
    text[LINK_OUT] = 0;
    assert_false(link_ask(link, text, &request)); /* without room for its line feed */
    text[LINK_OUT - 1] = 0;
    assert_true(link_ask(link, text, &request));
    assert_int_equal(link->unsent, LINK_OUT);
    assert_int_equal(link->out[LINK_OUT - 1], '\n');
    assert_false(link_ask(link, "", &request));
    link_sent(link, LINK_OUT - 3);
    assert_int_equal(link->unsent, 3);
    assert_memory_equal(link->out, "aa\n", 3);
    assert_true(link_ask(link, "b", &request));
    assert_memory_equal(link->out, "aa\nb\n", 5);
    link_sent(link, 5);
    assert_int_equal(link->unsent, 0);
}

/* A change belongs to no request, and is never the last line of a reply. */
static void lines_of_replies_and_changes(void **state)
{
    static const char received[] = "{\"a\":1}\n"
                                   "{\"name\":\"s\",\"value\":2,\"time\":3}\n"
                                   "{\"name\":\"s\",\"value\":2}\n" OK "{\"ok\":false}\n";
    static const char want[] = "1:5 {\"a\":1}\n"
                               "0:0 {\"name\":\"s\",\"value\":2,\"time\":3}\n"
                               "1:5 {\"name\":\"s\",\"value\":2}\n"
                               "1:5 last {\"ok\":true}\n"
                               "2:6 last {\"ok\":false}\n";
    link_t *link = &trace->link;
    (void)state;
    assert_true(link_ask(link, "{}", &(link_request_t){.kind = LINK_ABOUT, .id = 5}));
    assert_true(link_ask(link, "{}", &(link_request_t){.kind = LINK_LIST, .id = 6}));
    memset(&taken, 0, sizeof taken);
    for (size_t n = 0; n < sizeof received - 1; n++) /* byte by byte */
        assert_true(link_take(link, received + n, 1, take, &taken));
    assert_string_equal(taken.text, want);
    assert_int_equal(link->count, 0);
}

static void the_longest_line(void **state)
{
    static char text[LINK_LINE + 1];
    link_t *link = &trace->link;
    (void)state;
    memset(text, ' ', sizeof text);
    memcpy(text, "{}", 2);
    for (size_t length = LINK_LINE - 2; length <= LINK_LINE; length++) {
        trace_restart(trace);
        assert_true(link_ask(link, "{}", &(link_request_t){.kind = LINK_ABOUT}));
        text[length - 1] = '\n';
        memset(&taken, 0, sizeof taken);
        assert_int_equal(link_take(link, text, length, take, &taken), length < LINK_LINE);
        assert_int_equal(taken.lines, length < LINK_LINE);
        text[length - 1] = ' ';
    }
}

/* --- sets of signals ---------------------------------------------------------------------------------------------- */

static void sets_of_signals(void **state)
{
    static const size_t first[] = {0, 7, 8, 4095}, second[] = {8};
    trace_set_t one = {0}, other = {0}, none = {0};
    (void)state;
    for (size_t n = 0; n < sizeof first / sizeof first[0]; n++) {
        trace_set_add(&one, first[n]);
        trace_set_add(&one, first[n]);
        assert_int_equal(one.count, n + 1);
    }
    for (size_t signal = 0; signal < TABLE_SIGNALS; signal++) {
        const bool want = signal == 0 || signal == 7 || signal == 8 || signal == 4095;
        if (trace_set_has(&one, signal) != want)
            fail_msg("signal %zu: expected %d, got %d", signal, want, !want);
    }
    trace_set_add(&other, second[0]);
    trace_set_unite(&none, &other);
    assert_true(none.count == 1 && trace_set_has(&none, 8));
    trace_set_unite(&other, &one);
    assert_int_equal(other.count, 4);
    assert_memory_equal(other.bits, one.bits, sizeof one.bits);
    trace_set_unite(&other, &(trace_set_t){0});
    assert_int_equal(other.count, 4);
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

/* A name with a wildcard is skipped, and so is one without room in a request; those behind them are requested. */
static void names_that_are_requested(void **state)
{
    enum { ROOM = 511 - (int)sizeof "{\"op\":\"watch\",\"slave\":1,\"pattern\":\"\",\"every\":true}" + 1 };
    char longest[ROOM + 2];
    trace_set_t wanted = {0};
    (void)state;
    memset(longest, 'n', sizeof longest);
    longest[ROOM + 1] = 0;
    add_signal("a*");
    add_signal(longest); /* one character too long */
    longest[ROOM] = 0;
    add_signal(longest);
    add_signal("b");
    for (size_t signal = 0; signal <= 4; signal++) /* and one that the table does not have */
        trace_set_add(&wanted, signal);
    trace_want(trace, table, &wanted);
    assert_int_equal(trace->link.count, 2);
    assert_int_equal(trace->watched.count, 4); /* those that are skipped are not tried again */
    assert_int_equal(trace->link.unsent,
                     512 + strlen("{\"op\":\"watch\",\"slave\":1,\"pattern\":\"b\",\"every\":true}\n"));
    assert_non_null(strstr(trace->link.out, "\"pattern\":\"b\""));
    trace_want(trace, table, &wanted);
    assert_int_equal(trace->link.count, 2);
    trace_restart(trace);
    assert_true(trace->link.count == 0 && trace->link.unsent == 0 && trace->watched.count == 0);
    trace_want(trace, table, &(trace_set_t){0});
    assert_int_equal(trace->link.count, 0);
}

/* As many as a connection watches, in portions of the requests that may wait. */
static void at_most_128_signals(void **state)
{
    trace_set_t wanted = {0};
    (void)state;
    for (unsigned int n = 0; n < TRACE_SIGNALS + 3; n++) {
        char name[16];
        (void)snprintf(name, sizeof name, "s%u", n);
        add_signal(name);
        trace_set_add(&wanted, n);
    }
    for (unsigned int portion = 0; portion < 4; portion++) {
        trace_want(trace, table, &wanted);
        assert_int_equal(trace->watched.count, portion == 0 ? LINK_WAITING : TRACE_SIGNALS);
        link_sent(&trace->link, trace->link.unsent);
        for (; trace->link.count > 0;)
            assert_true(trace_take(trace, table, OK, strlen(OK)));
    }
}

int main(int argc, char **argv)
{
#define TEST(title, function) {title, function, begin, finish, NULL}
    const struct CMUnitTest tests[] = {
        TEST("SEC: a connection has 64 requests without a reply at most", requests_wait_up_to_64),
        TEST("Replies are in the order of the requests", order_of_replies),
        TEST("SEC: 16384 bytes of requests wait at most, and leave in their order", requests_have_16384_bytes),
        TEST("Lines of a reply belong to its request, changes to none", lines_of_replies_and_changes),
        TEST("SEC: a line of 4095 bytes is taken, a longer one ends the connection", the_longest_line),
        TEST("A set has the signals that were added, each once", sets_of_signals),
        TEST("A signal is requested by its name, unless that has a wildcard or no room", names_that_are_requested),
        TEST("SEC: a connection watches 128 signals at most", at_most_128_signals),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Panel: connections and traces", tests, NULL, NULL);
}
