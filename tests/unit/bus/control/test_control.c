/* SPDX-License-Identifier: MIT */
/* The control socket: requests and their replies (control.h). */
#define _GNU_SOURCE
#include "support/control_bench.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "bus/control/change.h"

#define READY                                                                                                          \
    "{\"slave\":1,\"name\":\"ready\",\"value\":0,\"access\":\"r\",\"range\":\"0..1\",\"meaning\":\"READY\","           \
    "\"field\":\"2200h:1 bit 2\"}\n"

/* --- replies ------------------------------------------------------------------------------------------------------ */

static void requests_get_replies(void **state)
{
    static const struct {
        const char *request, *want;
    } exact[] = {
        {"{\"op\":\"get\",\"pattern\":\"data1\"}\n", "{\"slave\":1,\"name\":\"data1\",\"value\":0}\n" OK},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":\"-1.5\"}\n", OK},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":-2.25}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"data[1]\"}\n", "{\"slave\":1,\"name\":\"data1\",\"value\":-2.25}\n" OK},
        {"{\"op\":\"set\",\"name\":\"run\",\"value\":true}\n", OK},
        {"{\"op\":\"set\",\"name\":\"comment1\",\"value\":\"a \\\"b\\\\ c\"}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"comment1\"}\n",
         "{\"slave\":1,\"name\":\"comment1\",\"value\":\"a \\\"b\\\\ c\"}\n" OK},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":\"010\"}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"scene\"}\n", "{\"slave\":1,\"name\":\"scene\",\"value\":10}\n" OK},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":\"0x0b\"}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"scene\",\"slave\":0}\n",
         "{\"slave\":1,\"name\":\"scene\",\"value\":11}\n{\"slave\":2,\"name\":\"scene\",\"value\":0}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"scene\",\"slave\":2}\n", "{\"slave\":2,\"name\":\"scene\",\"value\":0}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"ecat.state\"}\n", "{\"slave\":1,\"name\":\"ecat.state\",\"value\":1}\n" OK},
        {"{\"op\":\"watch\",\"pattern\":\"gate\"}\n",
         "{\"slave\":1,\"name\":\"gate\",\"value\":0,\"time\":1.000000}\n" OK},
        {"{\"op\":\"list\",\"pattern\":\"ready\"}\n", READY OK},
    };
    static const struct {
        const char *request, *part;
    } refused[] = {
        {"\n", "{\"ok\":false,\"message\":\"a request is"},
        {"nonsense\n", "a request is"},
        {"[1,2]\n", "a request is"},
        {"{\"op\":\"format\"}\n", "a request is"},
        {"{\"op\":7}\n", "a request is"},
        {"{\"op\":\"get\",\"slave\":3}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":1.5}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":\"1\"}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":-1}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":\"alias:9\"}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":\"alias:0\"}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":\"alias:65536\"}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":\"alias:5x\"}\n", "no such slave"},
        {"{\"op\":\"set\",\"slave\":0,\"name\":\"scene\",\"value\":1}\n", "no such slave"},
        {"{\"op\":\"get\",\"pattern\":\"nosuch*\"}\n",
         "no signal of slave 1 matches 'nosuch*': 'ectwin list-signals -n 1' lists them; -n chooses one of 2 slaves"},
        {"{\"op\":\"get\",\"slave\":0,\"pattern\":\"nosuch*\"}\n", "no signal matches 'nosuch*': "},
        {"{\"op\":\"get\",\"pattern\":5}\n", "a text of at most 127"},
        {"{\"op\":\"set\",\"name\":\"nosuch\",\"value\":1}\n",
         "slave 1 has no signal 'nosuch': 'ectwin list-signals DEVICE' lists those of a device; -n chooses the slave"},
        {"{\"op\":\"set\",\"name\":\"datta1\",\"value\":1}\n", "no signal 'datta1'; did you mean 'data1'?"},
        {"{\"op\":\"set\",\"name\":\"ecat.plug_ni\",\"value\":1}\n", "did you mean 'ecat.plug_in'?"},
        {"{\"op\":\"set\",\"name\":\"x\",\"value\":1}\n", "lists those of a device"},
        {"{\"op\":\"set\",\"name\":\"scene\"}\n", "a value is"},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":[1]}\n", "a value is"},
        {"{\"op\":\"set\"}\n", "takes"},
        {"{\"op\":\"set\",\"values\":{}}\n", "takes"},
        {"{\"op\":\"set\",\"name\":\"busy\",\"value\":1}\n", "the twin's own"},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":1e300}\n", "takes 0.."},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":\"\\u001b[31m\"}\n", "\\u001b"},
        {"{\"op\":\"list\",\"pattern\":\"data1\"}\n", "\"access\":\"rw\",\"range\":\"-999999999..999999999\""},
    };
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 2);
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; i++)
        expect_answer(&b, exact[i].request, exact[i].want);
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
        expect_part(&b, refused[i].request, refused[i].part);
    close_bench(&b);
}

/* Each counter has a different value; with one reply more or less, a quantile is in another step. */
static void statistics_are_in_the_reply(void **state)
{
    static const ect_stats_t stats = {.start_ns = 400 * MS,
                                      .frames = 11,
                                      .answered = 12,
                                      .in_kernel = 23,
                                      .unanswered = 13,
                                      .queue_lost = 24,
                                      .stale = 14,
                                      .circling = 15,
                                      .dropped = 16,
                                      .delayed = 17,
                                      .captured = 21,
                                      .uncaptured = 22,
                                      .answers = {[1] = 499, [2] = 1, [3] = 489, [6] = 1, [9] = 10},
                                      .longest_answer_ns = 1999999999,
                                      .polls = 19,
                                      .late_polls = 20,
                                      .latest_poll_ns = 2100000000};
    static ect_scenario_t scenario;
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    expect_part(&b, "{\"op\":\"stats\"}\n", "{\"ok\":false,\"message\":\"nothing is counted here\"}");
    expect_part(&b, "{\"op\":\"fault\"}\n", "{\"ok\":false,\"message\":\"no faults can be set here\"}");
    ect_control_show(b.control, &stats, &scenario);
    b.wire.now_ns = 2150 * MS;
    expect_answer(
        &b, "{\"op\":\"stats\"}\n",
        "{\"frames\":11,\"answered\":12,\"in_kernel\":23,\"unanswered\":13,\"queue_lost\":24,\"stale\":14,\"circling\":"
        "15,\"dropped\":16,"
        "\"delayed\":17,\"captured\":21,\"uncaptured\":22,\"p50_us\":5,\"p99_us\":100,\"longest_us\":1999999,\"polls\":"
        "19,\"late_polls\":20,"
        "\"latest_poll_us\":2100000,\"time\":1.750000}\n"
        "{\"answers\":[0,499,1,489,0,0,1,0,0,10,0,0,0,0,0,0,0,0,0,0],\"edges_us\":[1,2,5,10,20,50,100,200,500,"
        "1000,2000,5000,10000,20000,50000,100000,200000,500000,1000000]}\n" OK);
    close_bench(&b);
}

/* With a script the reply contains its progress and the present verdict. */
static void statistics_of_a_scenario(void **state)
{
    static const ect_stats_t stats = {.start_ns = 400 * MS};
    static ect_scenario_t scenario = {.step_count = 9, .steps_left = 2, .verdict = {.all = 6, .met = 4, .failed = 1}};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    ect_control_show(b.control, &stats, &scenario);
    expect_part(&b, "{\"op\":\"stats\"}\n",
                "\"latest_poll_us\":0,\"steps\":9,\"steps_over\":7,\"expected\":6,\"met\":4,\"failed\":1,\"time\":");
    close_bench(&b);
}

/* With --in-kernel the reply contains the hook, the times and the histogram of the replies in the kernel. */
static void statistics_of_the_kernel(void **state)
{
    static const ect_stats_t stats = {.hook = "native",
                                      .plans = 7,
                                      .in_kernel = 4,
                                      .kernel_answers = {[0] = 99, [1] = 1, [3] = 1},
                                      .longest_kernel_ns = 8999};
    static ect_scenario_t scenario;
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    ect_control_show(b.control, &stats, &scenario);
    expect_part(&b, "{\"op\":\"stats\"}\n",
                "\"hook\":\"native\",\"plans\":7,\"kernel_p50_us\":1,\"kernel_p99_us\":2,\"kernel_longest_us\":8,");
    expect_part(&b, "{\"op\":\"stats\"}\n",
                "0],\"kernel_answers\":[99,1,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0],\"edges_us\":[1,");
    close_bench(&b);
}

static void about_the_twins(void **state)
{
    static const ect_about_t named = {.name = "bench",
                                      .devices = "fzm1,fzm1",
                                      .panel = "2,1",
                                      .ifaces = {[ECT_END_IN] = "ecat0", [ECT_END_OUT] = "ecat1"}};
    static const ect_about_t plain = {.devices = "fzm1"};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 2);
    expect_part(&b, "{\"op\":\"about\"}\n", "{\"ok\":false,\"message\":\"this chain has no description\"}");
    ect_control_describe(b.control, &named);
    expect_answer(&b, "{\"op\":\"about\"}\n",
                  "{\"name\":\"bench\",\"devices\":\"fzm1,fzm1\",\"panel\":\"2,1\",\"iface\":\"ecat0\",\"iface2\":"
                  "\"ecat1\",\"slaves\":2,"
                  "\"lowest\":1,\"highest\":1,\"errors\":0}\n" OK);
    ect_control_describe(b.control, &plain);
    expect_answer(&b, "{\"op\":\"set\",\"slave\":2,\"name\":\"ecat.plug_in\",\"value\":0}\n", OK);
    expect_answer(&b, "{\"op\":\"about\"}\n",
                  "{\"devices\":\"fzm1\",\"slaves\":2,\"lowest\":1,\"highest\":1,\"errors\":0}\n" OK);
    close_bench(&b);
}

static void names_of_twins(void **state)
{
    static const struct {
        const char *request, *want;
    } rows[] = {
        {"{\"op\":\"set\",\"values\":{\"a.data1\":1,\"b.data1\":2,\"data2\":3}}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"b.data1\"}\n",
         "{\"slave\":2,\"twin\":\"b\",\"name\":\"data1\",\"value\":2}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"b.data1\",\"slave\":1}\n",
         "{\"slave\":2,\"twin\":\"b\",\"name\":\"data1\",\"value\":2}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"data[12]\",\"slave\":\"a\"}\n",
         "{\"slave\":1,\"twin\":\"a\",\"name\":\"data1\",\"value\":1}\n"
         "{\"slave\":1,\"twin\":\"a\",\"name\":\"data2\",\"value\":3}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"[ab].data1\",\"slave\":0}\n",
         "{\"slave\":1,\"twin\":\"a\",\"name\":\"data1\",\"value\":1}\n"
         "{\"slave\":2,\"twin\":\"b\",\"name\":\"data1\",\"value\":2}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"data1\",\"slave\":3}\n", "{\"slave\":3,\"name\":\"data1\",\"value\":0}\n" OK},
        {"{\"op\":\"fault\",\"fault\":\"al never slave b\"}\n", OK},
        {"{\"op\":\"fault\"}\n", "{\"fault\":\"al never slave b\"}\n" OK},
        {"{\"op\":\"script\"}\n", "{\"line\":\"al never slave b\"}\n" OK},
        {"{\"op\":\"script\",\"offset\":1}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"data1\",\"slave\":\"c\"}\n",
         "{\"ok\":false,\"message\":\"there is no such slave in this chain\"}\n"},
        {"{\"op\":\"get\",\"pattern\":\"b.nosuch\"}\n",
         "{\"ok\":false,\"message\":\"no signal of slave 2 matches 'nosuch': 'ectwin list-signals -n 2' lists them; -n "
         "chooses one of 3 slaves\"}\n"},
        {"{\"op\":\"wave\",\"name\":\"b.scene\",\"shape\":\"ramp\",\"low\":1,\"high\":2,\"period\":3}\n", OK},
        {"{\"op\":\"waves\"}\n",
         "{\"slave\":2,\"twin\":\"b\",\"name\":\"scene\",\"shape\":\"ramp\",\"low\":1,\"high\":2,"
         "\"period\":3}\n" OK},
        {"{\"op\":\"set\",\"name\":\"b.data1\",\"value\":7,\"at\":5}\n", OK},
        {"{\"op\":\"set\",\"name\":\"b.nosuch\",\"value\":7,\"at\":5}\n",
         "{\"ok\":false,\"message\":\"slave 1 has no signal 'b.nosuch' that can be set: 'ectwin list-signals -n 1' "
         "lists "
         "them\"}\n"},
    };
    static const ect_stats_t stats = {.start_ns = 400 * MS};
    static ect_scenario_t scenario;
    bench_t b;
    char message[ECT_SIGNAL_MESSAGE];
    ect_names_t *names = ect_names_new(3);
    (void)state;
    open_bench(&b, "fzm1", 3);
    ect_control_show(b.control, &stats, &scenario);
    assert_true(names && ect_names_add(names, 0, "a") && ect_names_add(names, 1, "b"));
    assert_true(ect_chain_set_names(b.wire.chain, names, message));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_answer(&b, rows[i].request, rows[i].want);
    close_bench(&b);
    ect_names_free(names);
}

static void words_of_the_start(void **state)
{
    static const ect_about_t about = {.words = "/m\0--seed=7\0fzm1", .words_length = 17};
    static const ect_about_t none = {.devices = "fzm1"};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    expect_part(&b, "{\"op\":\"script\"}\n", "no faults can be set here");
    ect_control_describe(b.control, &none);
    expect_part(&b, "{\"op\":\"words\"}\n", "this chain has no command line");
    ect_control_describe(b.control, &about);
    expect_answer(&b, "{\"op\":\"words\"}\n",
                  "{\"size\":17,\"offset\":0,\"data\":\"2f6d002d2d736565643d3700667a6d3100\"}\n" OK);
    expect_answer(&b, "{\"op\":\"words\",\"offset\":16}\n", "{\"size\":17,\"offset\":16,\"data\":\"00\"}\n" OK);
    expect_answer(&b, "{\"op\":\"words\",\"offset\":17}\n", "{\"size\":17,\"offset\":17,\"data\":\"\"}\n" OK);
    expect_part(&b, "{\"op\":\"words\",\"offset\":18}\n", "a number from 0 to the size of the data");
    expect_part(&b, "{\"op\":\"words\",\"offset\":\"0\"}\n", "a number from 0 to the size of the data");
    close_bench(&b);
}

/* The states of all three units after each step: a unit off the bus counts as state 0, and without its error. */
static void states_of_the_twins(void **state)
{
    static const struct {
        const char *title;
        size_t twin; /* changes to the state `to`, or executes `request` */
        uint8_t to;
        const char *request;
        const char *want;
    } rows[] = {
        {"all in INIT", 0, ECT_STATE_INIT, NULL, "\"lowest\":1,\"highest\":1,\"errors\":0}\n"},
        {"the second higher", 1, ECT_STATE_SAFEOP, NULL, "\"lowest\":1,\"highest\":4,\"errors\":0}\n"},
        {"the third as well", 2, ECT_STATE_PREOP, NULL, "\"lowest\":1,\"highest\":4,\"errors\":0}\n"},
        {"none left in INIT", 0, ECT_STATE_PREOP, NULL, "\"lowest\":2,\"highest\":4,\"errors\":0}\n"},
        {"the second refuses", 1, 7, NULL, "\"lowest\":2,\"highest\":4,\"errors\":1}\n"},
        {"the third refuses", 2, 7, NULL, "\"lowest\":2,\"highest\":4,\"errors\":2}\n"},
        {"the third off the bus", 2, 0, "{\"op\":\"set\",\"slave\":3,\"name\":\"bu.enabled\",\"value\":0}\n",
         "\"lowest\":0,\"highest\":4,\"errors\":1}\n"},
    };
    static const ect_about_t about = {.devices = "units"};
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 3);
    ect_control_describe(b.control, &about);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint16_t code = 0;
        if (rows[i].request)
            expect_answer(&b, rows[i].request, OK);
        else if (rows[i].to == 7)
            (void)wire_al(&b.wire, rows[i].twin, rows[i].to, &code);
        else
            wire_go(&b.wire, rows[i].twin, rows[i].to);
        assert_int_equal(code != 0, rows[i].to == 7);
        wire_poll(&b.wire);
        expect_part(&b, "{\"op\":\"about\"}\n", rows[i].want);
    }
    close_bench(&b);
}

static void faults_by_request(void **state)
{
    static const struct {
        const char *request, *want;
    } rows[] = {
        {"{\"op\":\"fault\"}\n", OK},
        {"{\"op\":\"fault\",\"fault\":5}\n", "{\"ok\":false,\"message\":\"\\\"fault\\\" is a text, as in "
                                             "{\\\"op\\\":\\\"fault\\\",\\\"fault\\\":\\\"drop 5%\\\"}\"}\n"},
        {"{\"op\":\"fault\",\"fault\":\"drop 5%\"}\n", OK},
        {"{\"op\":\"fault\",\"fault\":\"delay 7us every 2\"}\n", OK},
        {"{\"op\":\"fault\",\"fault\":\"hang slave 1\"}\n", OK},
        {"{\"op\":\"fault\"}\n", "{\"fault\":\"drop 5%\"}\n{\"fault\":\"delay 7us every 2\"}\n" OK},
        {"{\"op\":\"fault\",\"fault\":\"hang slave 2\"}\n",
         "{\"ok\":false,\"message\":\"there is no slave 2: the chain has 1\"}\n"},
        {"{\"op\":\"fault\",\"fault\":\"off\"}\n", OK},
        {"{\"op\":\"fault\"}\n", OK},
    };
    static ect_stats_t stats;
    static ect_scenario_t scenario;
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    ect_control_show(b.control, &stats, &scenario);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_answer(&b, rows[i].request, rows[i].want);
    close_bench(&b);
}

static void every_line_is_json(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
    send_text(fd, "{\"op\":\"list\"}\n{\"op\":\"get\"}\n{\"op\":\"watch\"}\n");
    unsigned int lines = 0;
    for (unsigned int i = 0; i < 100; i++) {
        serve(&b);
        receive_text(fd, got, sizeof got);
        for (char *line = strtok(got, "\n"); line; line = strtok(NULL, "\n"), lines++) {
            cJSON *json = cJSON_Parse(line);
            if (!cJSON_IsObject(json))
                fail_msg("no JSON: %s", line);
            cJSON_Delete(json);
        }
    }
    assert_true(lines > 3 * 200);
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* The controller sends a set of periodic data; each byte is one higher than the previous byte. */
static void send_periodic(bench_t *b, uint16_t size)
{
    uint8_t out[228] = {0};
    wire_go(&b->wire, 0, ECT_STATE_OP);
    for (unsigned int at = 0; at < size; at += 200) {
        out[0]++;
        ect_store_be16(out + 24, size);
        out[26] = (uint8_t)(at / 200);
        for (unsigned int i = 0; i < 200; i++)
            out[28 + i] = (uint8_t)(at + i);
        assert_int_equal(wire_write(&b->wire, 0, 0x1000, out, sizeof out), 1);
    }
}

/* Periodic data exceed a signal and a line. */
static void periodic_data_in_pieces(void **state)
{
    static const struct {
        const char *request, *want;
    } exact[] = {
        {"{\"op\":\"data\",\"offset\":447}\n",
         "{\"slave\":1,\"serial\":1,\"size\":450,\"offset\":447,\"data\":\"bfc0c1\"}\n" OK},
        {"{\"op\":\"data\",\"offset\":450,\"slave\":1}\n",
         "{\"slave\":1,\"serial\":1,\"size\":450,\"offset\":450,\"data\":\"\"}\n" OK},
    };
    static const struct {
        const char *request, *part;
    } parts[] = {
        {"{\"op\":\"data\"}\n", "\"offset\":0,\"data\":\"00010203"},
        {"{\"op\":\"data\"}\n", "8c8d8e8f\"}\n" OK}, /* byte 399 */
        {"{\"op\":\"data\",\"offset\":451}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"offset\":-1}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"offset\":1e300}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"offset\":\"0\"}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"slave\":0}\n", "no such slave"},
        {"{\"op\":\"data\",\"slave\":2}\n", "no such slave"},
    };
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    expect_part(&b, "{\"op\":\"data\"}\n", "{\"slave\":1,\"serial\":0,\"size\":0,\"offset\":0,\"data\":\"\"}\n" OK);
    send_periodic(&b, 450);
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; i++)
        expect_answer(&b, exact[i].request, exact[i].want);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        expect_part(&b, parts[i].request, parts[i].part);
    close_bench(&b);
    open_bench(&b, "vr-bu-ect-map3", 1);
    expect_part(&b, "{\"op\":\"data\"}\n", "has no data for this request");
    close_bench(&b);
    open_bench(&b, "fzm1", 1);
    expect_part(&b, "{\"op\":\"data\"}\n", "has no data for this request");
    close_bench(&b);
}

/* The replay of a record executes these requests without a connection. */
static void changes_without_a_connection(void **state)
{
    static const struct {
        const char *request, *why; /* NULL: executed */
    } rows[] = {
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":1}", NULL},
        {"{\"op\":\"set\",\"slave\":2,\"name\":\"data1\",\"value\":1}", NULL},
        {"{\"op\":\"set\",\"slave\":0,\"name\":\"data1\",\"value\":1}", "there is no such slave in this chain"},
        {"{\"op\":\"set\",\"slave\":3,\"name\":\"data1\",\"value\":1}", "there is no such slave in this chain"},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":null}", "a value is a text, a number, true or false"},
        {"{\"op\":\"set\",\"name\":7,\"value\":1}",
         "\"set\" takes {\"name\":...,\"value\":...} or {\"values\":{NAME:VALUE,...}}"},
        {"{\"op\":\"fault\",\"fault\":\"drop 5%\"}", "no faults can be set here"},
    };
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 2);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE];
        cJSON *request = cJSON_Parse(rows[i].request);
        const char *why = ect_change_apply(b.wire.chain, NULL, request, b.wire.now_ns, message);
        if ((why == NULL) != (rows[i].why == NULL) || (why && strcmp(why, rows[i].why) != 0))
            fail_msg("%s: expected '%s', got '%s'", rows[i].request, rows[i].why, why);
        cJSON_Delete(request);
    }
    close_bench(&b);
}

static void requests_that_change(void **state)
{
    static const struct {
        const char *op;
        bool changes;
    } rows[] = {
        {"set", true},   {"fault", true},  {"write", true},    {"wave", true},  {"get", false},
        {"list", false}, {"watch", false}, {"data", false},    {"read", false}, {"waves", false},
        {"step", false}, {"plant", false}, {"capture", false}, {"", false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (ect_change_is(rows[i].op) != rows[i].changes)
            fail_msg("'%s': expected %d, got %d", rows[i].op, rows[i].changes, !rows[i].changes);
    }
}

/* --- all or nothing ----------------------------------------------------------------------------------------------- */

static void all_or_nothing(void **state)
{
    static const struct {
        const char *request, *part;
    } cases[] = {
        /* Each of the two signals limits the other: initially 5 ms and 10 ms. */
        {"{\"op\":\"set\",\"values\":{\"output_period\":40,\"output_time\":30}}\n", OK},
        {"{\"op\":\"set\",\"values\":{\"output_time\":300,\"output_period\":400}}\n", OK},
        {"{\"op\":\"set\",\"values\":{\"output_period\":30,\"output_time\":20}}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"output_[pt]*\"}\n",
         "\"value\":30}\n{\"slave\":1,\"name\":\"output_time\",\"value\":20}"},
        {"{\"op\":\"set\",\"values\":{\"data1\":7,\"output_time\":30}}\n",
         "output_time: the output time must be shorter"},
        {"{\"op\":\"set\",\"values\":{\"data1\":7,\"nosuch\":30}}\n", "no signal 'nosuch'"},
        {"{\"op\":\"set\",\"values\":{\"data1\":7,\"output_time\":\"x\"}}\n", "takes 10..10000"},
        {"{\"op\":\"set\",\"values\":{\"row_add\":1,\"busy\":1}}\n", "the twin's own"},
        {"{\"op\":\"set\",\"values\":{\"row_add\":1,\"restart\":1,\"output_time\":31}}\n", "must be shorter"},
        {"{\"op\":\"get\",\"pattern\":\"data1\"}\n", "\"value\":0}"},
        {"{\"op\":\"get\",\"pattern\":\"rows\"}\n", "\"value\":0}"},
        {"{\"op\":\"set\",\"values\":{\"row1\":5,\"row_add\":1,\"units\":4,\"output_unit\":3}}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"rows\"}\n", "\"value\":1}"},
        {"{\"op\":\"set\",\"values\":{\"output_unit\":6,\"units\":7}}\n", OK},
        {"{\"op\":\"set\",\"values\":{\"units\":2,\"data1\":1,\"output_unit\":1}}\n", OK},
    };
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        expect_part(&b, cases[i].request, cases[i].part);
    assert_false(ect_chain_slave(b.wire.chain, 0)->off_bus); /* the restart was undone */
    close_bench(&b);
}

static void most_signals_of_one_set(void **state)
{
    char request[ECT_ENDPOINT_REQUEST];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (unsigned int count = ECT_ENDPOINT_VALUES; count <= ECT_ENDPOINT_VALUES + 1; count++) {
        size_t used = (size_t)snprintf(request, sizeof request, "{\"op\":\"set\",\"values\":{");
        for (unsigned int i = 0; i < count; i++)
            used +=
                (size_t)snprintf(request + used, sizeof request - used, "%s\"ru1.encoder\":%u", i > 0 ? "," : "", i);
        snprintf(request + used, sizeof request - used, "}}\n");
        expect_part(&b, request, count == ECT_ENDPOINT_VALUES ? OK : "at most 128 signals");
    }
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"ru1.encoder\"}\n", "\"value\":127}");
    close_bench(&b);
}

/* --- at a time of the bus ----------------------------------------------------------------------------------------- */

static char refusal[256];

static void on_refused(void *ctx, const char *step, const char *why)
{
    (void)ctx;
    snprintf(refusal, sizeof refusal, "%s: %s", step, why);
}

static void expect_data1(bench_t *b, const char *value)
{
    char want[80];
    snprintf(want, sizeof want, "{\"slave\":1,\"name\":\"data1\",\"value\":%s}\n" OK, value);
    expect_answer(b, "{\"op\":\"get\",\"pattern\":\"data1\"}\n", want);
}

static void set_at_a_time(void **state)
{
    static const struct {
        const char *request, *part;
    } refused[] = {
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":\"soon\"}\n", "a time of the bus"},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":-1}\n", "a time of the bus"},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":1e10}\n", "a time of the bus"},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":1.5}\n", "1.5 s is over: the bus is at 2.000000 s"},
        {"{\"op\":\"set\",\"name\":\"nosuch\",\"value\":1,\"at\":3}\n", "no signal 'nosuch' that can be set"},
        {"{\"op\":\"set\",\"name\":\"ready\",\"value\":1,\"at\":3}\n", "no signal 'ready' that can be set"},
        {"{\"op\":\"set\",\"at\":3}\n", "takes {"},
    };
    ect_scenario_t scenario = {.seed = 1, .refused = on_refused};
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    uint64_t start_ns = b.wire.now_ns;
    expect_part(&b, "{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":3}\n", "needs a bus that runs");
    stats.start_ns = start_ns;
    ect_control_show(b.control, &stats, &scenario);
    b.wire.now_ns += 2000000000u;
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
        expect_part(&b, refused[i].request, refused[i].part);
    ect_control_act(b.control, b.wire.chain, UINT64_MAX - 1);
    assert_true(ect_control_planned(b.control) == ECT_NEVER);

    expect_answer(&b, "{\"op\":\"set\",\"name\":\"data1\",\"value\":2,\"at\":4}\n", OK);
    expect_answer(&b, "{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":3.5}\n", OK);
    expect_answer(&b, "{\"op\":\"set\",\"values\":{\"data1\":3},\"at\":4}\n", OK);
    expect_answer(&b, "{\"op\":\"set\",\"name\":\"scene\",\"value\":\"x\",\"at\":5}\n", OK);
    ect_control_act(b.control, b.wire.chain, start_ns + 3499999999u);
    assert_true(ect_control_planned(b.control) == start_ns + 3500000000u);
    expect_data1(&b, "0");
    ect_control_act(b.control, b.wire.chain, start_ns + 3500000000u);
    assert_true(ect_control_planned(b.control) == start_ns + 4000000000u);
    expect_data1(&b, "1");
    ect_control_act(b.control, b.wire.chain, start_ns + 4000000000u);
    assert_true(ect_control_planned(b.control) == start_ns + 5000000000u);
    expect_data1(&b, "3"); /* requests for the same time are executed in their order */
    assert_string_equal(refusal, "");
    ect_control_act(b.control, b.wire.chain, start_ns + 5000000000u);
    assert_true(ect_control_planned(b.control) == ECT_NEVER);
    assert_non_null(strstr(refusal, "\"scene\""));
    close_bench(&b);
}

/* The list of faults is written in one step of the loop, so its length is limited. */
static void most_faults_of_a_list(void **state)
{
    enum { TWINS = 9, OF_A_TWIN = 8, LISTED = 64 };
    static char got[ANSWER_ROOM];
    ect_scenario_t scenario = {.seed = 1};
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", TWINS);
    ect_control_show(b.control, &stats, &scenario);
    for (unsigned int i = 0; i < TWINS * OF_A_TWIN; i++) {
        char request[80];
        snprintf(request, sizeof request, "{\"op\":\"fault\",\"fault\":\"al never slave %u\"}\n", i / OF_A_TWIN + 1);
        expect_answer(&b, request, OK);
    }
    int fd = connect_client(&b);
    set_nonblocking(fd);
    send_text(fd, "{\"op\":\"fault\"}\n");
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_int_equal(count_of(got, "\"al never slave"), LISTED);
    close(fd);
    serve(&b);
    close_bench(&b);
}

static struct {
    unsigned int count;
    char request[128];
} observed;

static void on_change(void *ctx, const char *request, size_t length)
{
    (void)ctx;
    observed.count++;
    snprintf(observed.request, sizeof observed.request, "%.*s", (int)length, request);
}

/* A bus without a scenario, and a bus whose scenario has no function for refusals. */
static void observed_at_a_time(void **state)
{
    (void)state;
    for (unsigned int i = 0; i < 2; i++) {
        ect_scenario_t scenario = {.seed = 1};
        ect_stats_t stats = {0};
        bench_t b;
        open_bench(&b, "fzm1", 1);
        stats.start_ns = b.wire.now_ns;
        ect_control_show(b.control, &stats, i == 0 ? NULL : &scenario);
        ect_control_observe(b.control, on_change, NULL);
        observed.count = 0;
        expect_answer(&b, "{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":3}\n", OK);
        expect_answer(&b, "{\"op\":\"set\",\"name\":\"scene\",\"value\":\"x\",\"at\":4}\n", OK);
        assert_int_equal(observed.count, 0);
        ect_control_act(b.control, b.wire.chain, stats.start_ns + 3000000000u);
        assert_int_equal(observed.count, 1);
        assert_string_equal(observed.request, "{\"op\":\"set\",\"name\":\"data1\",\"value\":1}");
        ect_control_act(b.control, b.wire.chain, stats.start_ns + 4000000000u);
        assert_int_equal(observed.count, 2);
        expect_data1(&b, "1");
        close_bench(&b);
    }
}

static void without_memory(void **state)
{
    char message[ECT_ENDPOINT_MESSAGE] = "";
    bench_t b;
    (void)state;
    refuses_memory = true;
    const ect_control_t *control = ect_control_open(NULL, message);
    refuses_memory = false;
    assert_null(control);
    assert_string_equal(message, "no control socket: not enough memory");
    open_bench(&b, "fzm1", 1);
    refuses_memory = true;
    expect_answer(&b, "{\"op\":\"watch\"}\n", "{\"ok\":false,\"message\":\"not enough memory\"}\n");
    refuses_memory = false;
    close_bench(&b);
}

/* Each step of the start fails once, with a message and an error; no descriptor remains open. */
static void failing_starts(void **state)
{
    static const struct {
        const char *folder;
        bool events, descriptors;
        const char *message;
        int error;
    } rows[] = {
        {"/nonexistent", true, true,
         "no control socket in '/nonexistent/ectwin': No such file or directory; XDG_RUNTIME_DIR can name another "
         "place",
         ENOENT},
        {"/tmp", true, false, "no control socket: no descriptor is free", EMFILE},
        {"", false, true, "no control socket: No space left on device", ENOSPC},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_ENDPOINT_MESSAGE] = "", folder[] = "/tmp/test-ectwin-XXXXXX", path[64];
        struct rlimit before;
        assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
        const struct rlimit none = {.rlim_cur = 3, .rlim_max = before.rlim_max};
        assert_non_null(mkdtemp(folder));
        (void)snprintf(path, sizeof path, "%s/ectwin", folder);
        setenv("XDG_RUNTIME_DIR", rows[i].folder[0] != 0 ? rows[i].folder : folder, 1);
        const int next = dup(STDOUT_FILENO);
        (void)close(next);
        refuses_events = !rows[i].events;
        if (!rows[i].descriptors)
            assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
        errno = 0;
        const ect_control_t *control = ect_control_open(NULL, message);
        const int error = errno;
        refuses_events = false;
        assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
        assert_null(control);
        assert_string_equal(message, rows[i].message);
        assert_int_equal(error, rows[i].error);
        const int after = dup(STDOUT_FILENO);
        (void)close(after);
        assert_int_equal(after, next);
        (void)rmdir(path);
        assert_int_equal(rmdir(folder), 0);
    }
}

static void most_requests_that_wait(void **state)
{
    ect_scenario_t scenario = {.seed = 1};
    ect_stats_t stats = {0};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    stats.start_ns = b.wire.now_ns;
    ect_control_show(b.control, &stats, &scenario);
    for (unsigned int i = 0; i <= 64; i++)
        expect_part(&b, "{\"op\":\"set\",\"name\":\"data1\",\"value\":1,\"at\":3}\n",
                    i < 64 ? OK : "64 requests wait for their time already");
    close_bench(&b);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Each request gets a reply, a refused one with the reason", requests_get_replies, NULL, NULL, NULL},
        {"The reply to stats contains the hook, the plans and the times of replies in the kernel",
         statistics_of_the_kernel, NULL, NULL, NULL},
        {"The reply to stats contains each counter and each step of the histogram", statistics_are_in_the_reply, NULL,
         NULL, NULL},
        {"The name of a twin selects the twin in requests", names_of_twins, NULL, NULL, NULL},
        {"The command line of the start is read in pieces", words_of_the_start, NULL, NULL, NULL},
        {"The reply to about contains name, devices, interfaces and AL states", about_the_twins, NULL, NULL, NULL},
        {"The reply to about contains the lowest and highest AL state of all twins, and the number of errors",
         states_of_the_twins, NULL, NULL, NULL},
        {"Requests set, list and end faults", faults_by_request, NULL, NULL, NULL},
        {"Every line of a reply is JSON", every_line_is_json, NULL, NULL, NULL},
        {"Data that exceed a signal are read in pieces", periodic_data_in_pieces, NULL, NULL, NULL},
        {"A control socket that cannot be opened has a message, and no descriptor remains open", failing_starts, NULL,
         NULL, NULL},
        {"The reply to stats contains the progress of a script", statistics_of_a_scenario, NULL, NULL, NULL},
        {"Without a connection, requests that change the chain are executed or refused", changes_without_a_connection,
         NULL, NULL, NULL},
        {"Only set, fault, write and wave change the chain", requests_that_change, NULL, NULL, NULL},
        {"Several signals are set in any order, all of them or none", all_or_nothing, NULL, NULL, NULL},
        {"A request sets at most 128 signals", most_signals_of_one_set, NULL, NULL, NULL},
        {"Signals are set at a time of the bus; a past time is refused", set_at_a_time, NULL, NULL, NULL},
        {"An observer gets a request with a time when the request is executed, without the time", observed_at_a_time,
         NULL, NULL, NULL},
        {"Without memory no control socket is opened, and watch is refused", without_memory, NULL, NULL, NULL},
        {"A list of faults has at most 64 lines", most_faults_of_a_list, NULL, NULL, NULL},
        {"At most 64 requests with a time are pending", most_requests_that_wait, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket: requests", tests, NULL, NULL);
}
