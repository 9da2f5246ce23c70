/* SPDX-License-Identifier: MIT */
/* The request `events` of the control protocol (bus/control/events.h), and the words of codes (text/). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/control_bench.h"
#include "text/al_status.h"
#include "text/emergency.h"
#include "wire/registers.h"

static const ect_stats_t stats = {.start_ns = 1000 * MS};

static void open_followed(bench_t *b, const char *device, size_t count)
{
    static ect_scenario_t scenario;
    open_bench(b, device, count);
    scenario = (ect_scenario_t){0};
    ect_control_show(b->control, &stats, &scenario);
    ect_control_follow(b->control, b->wire.chain);
    b->wire.now_ns = 1500 * MS;
}

/* Executes a fault, and polls the twins. */
static void provoke(bench_t *b, const char *fault)
{
    char request[128];
    snprintf(request, sizeof request, "{\"op\":\"fault\",\"fault\":\"%s\"}\n", fault);
    expect_answer(b, request, OK);
    wire_poll(&b->wire);
}

static void nothing_is_recorded(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    expect_part(&b, "{\"op\":\"events\"}\n", "{\"ok\":false,\"message\":\"no events are recorded here\"}");
    refuses_memory = true;
    ect_control_follow(b.control, b.wire.chain);
    refuses_memory = false;
    expect_part(&b, "{\"op\":\"events\"}\n", "no events are recorded here");
    wire_poll(&b.wire);
    close_bench(&b);
}

static void states_and_emergencies(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    ect_names_t *names = ect_names_new(2);
    uint16_t code = 0;
    bench_t b;
    (void)state;
    open_followed(&b, "vr-bu-ect-map7", 2);
    assert_true(names && ect_names_add(names, 1, "unit"));
    assert_true(ect_chain_set_names(b.wire.chain, names, message));
    expect_answer(&b, "{\"op\":\"events\"}\n", OK);
    wire_go(&b.wire, 0, ECT_STATE_PREOP);
    expect_part(&b, "{\"op\":\"events\"}\n",
                "{\"number\":1,\"slave\":1,\"event\":\"state\",\"state\":2,\"code\":0,\"text\":\"PREOP\",\"time\":0.5");
    (void)wire_al(&b.wire, 0, 7, &code);
    expect_part(&b, "{\"op\":\"events\",\"after\":1}\n",
                "{\"number\":2,\"slave\":1,\"event\":\"state\",\"state\":2,\"code\":18,\"text\":\"PREOP + error, AL "
                "status code 0x0012: unknown state requested\"");
    provoke(&b, "emergency 0x5530 slave 2 register 33 data 0102030405");
    expect_part(&b, "{\"op\":\"events\",\"after\":2}\n",
                "{\"number\":3,\"slave\":2,\"twin\":\"unit\",\"event\":\"emergency\",\"code\":21808,\"register\":33,"
                "\"data\":\"0102030405\",\"text\":\"emergency 0x5530: device hardware\"");
    expect_answer(&b, "{\"op\":\"set\",\"slave\":2,\"name\":\"bu.enabled\",\"value\":0}\n", OK);
    wire_poll(&b.wire);
    expect_part(&b, "{\"op\":\"events\",\"after\":3}\n",
                "{\"number\":4,\"slave\":2,\"twin\":\"unit\",\"event\":\"state\",\"state\":0,\"code\":0,\"text\":\"off "
                "the bus\"");
    expect_answer(&b, "{\"op\":\"events\",\"after\":4}\n", OK);
    expect_answer(&b, "{\"op\":\"events\",\"after\":99}\n", OK);
    close_bench(&b);
    ect_names_free(names);
}

static void a_code_without_a_name(void **state)
{
    bench_t b;
    (void)state;
    open_followed(&b, "fzm1", 1);
    wire_go(&b.wire, 0, ECT_STATE_PREOP);
    provoke(&b, "to INIT 0x8001 slave 1");
    expect_part(&b, "{\"op\":\"events\",\"after\":1}\n", "\"text\":\"INIT + error, AL status code 0x8001\"");
    close_bench(&b);
}

/* The slave's counter of emergencies restarts at zero. */
static void a_restart(void **state)
{
    bench_t b;
    (void)state;
    open_followed(&b, "fzm1", 1);
    for (int i = 0; i < 3; i++)
        provoke(&b, "emergency 0x1000 slave 1");
    provoke(&b, "reset slave 1");
    provoke(&b, "emergency 0x2310 slave 1");
    expect_part(&b, "{\"op\":\"events\",\"after\":3}\n", "\"code\":8976,");
    close_bench(&b);
}

static void many_events(void **state)
{
    static char text[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_followed(&b, "fzm1", 1);
    for (int i = 0; i < ECT_EMERGENCY_QUEUE; i++)
        provoke(&b, "emergency 0x8130 slave 1");
    for (int i = 0; i < 150; i++) {
        wire_go(&b.wire, 0, ECT_STATE_PREOP);
        wire_go(&b.wire, 0, ECT_STATE_INIT);
    }
    int fd = connect_client(&b);
    set_nonblocking(fd);
    send_text(fd, "{\"op\":\"events\"}\n{\"op\":\"events\",\"after\":300}\n");
    (void)serve(&b);
    (void)receive_text(fd, text, sizeof text);
    assert_int_equal(count_of(text, "\"ok\":true"), 2);
    assert_int_equal(count_of(text, "\"number\""), 16);
    assert_non_null(strstr(text, "{\"number\":53,")); /* 308 events, of which 256 are kept */
    assert_null(strstr(text, "{\"number\":52,"));
    assert_non_null(strstr(text, "{\"number\":308,"));
    (void)close(fd);
    (void)serve(&b);
    close_bench(&b);
}

static void refused(void **state)
{
    static const char *const requests[] = {"{\"op\":\"events\",\"after\":-1}\n",
                                           "{\"op\":\"events\",\"after\":\"1\"}\n",
                                           "{\"op\":\"events\",\"after\":1e300}\n"};
    bench_t b;
    (void)state;
    open_followed(&b, "fzm1", 1);
    for (size_t i = 0; i < sizeof requests / sizeof *requests; i++)
        expect_part(&b, requests[i], "\\\"after\\\" is the number of an event");
    close_bench(&b);
}

static void words(void **state)
{
    static const struct {
        uint16_t code;
        const char *text;
    } rows[] = {{0x0000, "error reset or no error"},
                {0x1000, "generic error"},
                {0x2111, "current at the input"},
                {0x2410, "current"},
                {0x3210, "voltage inside the device"},
                {0x4210, "device temperature"},
                {0x5530, "device hardware"},
                {0x6320, "data set"},
                {0x8130, "communication"},
                {0x8611, "monitoring"},
                {0xA001, "state machine"},
                {0xFF01, "device-specific error"},
                {0xB000, "unknown error"},
                {0x1100, "unknown error"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        assert_string_equal(ect_emergency_text(rows[i].code), rows[i].text);
    assert_string_equal(ect_al_status_text(0x001B), "process data watchdog");
    assert_string_equal(ect_al_status_text(0), "no error");
    assert_null(ect_al_status_text(0x8000));
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Without a chain or memory for events the request is refused", nothing_is_recorded, NULL, NULL, NULL},
        {"Changes of AL states and emergencies are events, in order, with texts", states_and_emergencies, NULL, NULL,
         NULL},
        {"An AL status code without a name is written as a number", a_code_without_a_name, NULL, NULL, NULL},
        {"The emergency after a restart of the slave is an event", a_restart, NULL, NULL, NULL},
        {"The last 256 events are kept, and a reply has at most 8 events", many_events, NULL, NULL, NULL},
        {"A request for events after an invalid number is refused", refused, NULL, NULL, NULL},
        {"Each class of emergencies has a text (CiA 301)", words, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket: events", tests, NULL, NULL);
}
