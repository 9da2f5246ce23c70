/* SPDX-License-Identifier: MIT */
/* The log of a run (src/bus/trace.h): the items of the record, in their order, and the comments of both files, through
 * an exchange whose clock is the test's. */
#define _GNU_SOURCE
#include "bus/trace.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bus/capture/reader.h"
#include "bus/exchange.h"
#include "support/testdev.h"
#include "support/wire.h"

#define US       1000ull
#define START_NS (1000 * MS)

enum { TWINS = 2, ITEMS = 2000, INDEX_AT = 17, FILE_ROOM = 1 << 18, NONE = -1 };

typedef struct rig {
    wire_t w;
    ect_scenario_t s;
    ect_exchange_t x;
    uint64_t clock_ns;
    char folder[32], paths[2][48]; /* of the capture, of the record */
    char items[ITEMS];             /* of the record */
    uint8_t bytes[2][FILE_ROOM];
    size_t sizes[2];
} rig_t;

static uint64_t read_clock(void *ctx)
{
    return ((const rig_t *)ctx)->clock_ns;
}

static void send(void *ctx, ect_end_t end, const uint8_t *frame, size_t length)
{
    (void)ctx, (void)end, (void)frame, (void)length;
}

static ect_capture_t *open_file(rig_t *r, unsigned int n, size_t buffer)
{
    char message[ECT_CAPTURE_MESSAGE];
    const ect_capture_config_t config = {.path = r->paths[n], .buffer = buffer, .application = "test"};
    ect_capture_t *capture = ect_capture_open(&config, message);
    if (capture == NULL)
        fail_msg("%s", message);
    return capture;
}

static int setup(void **state)
{
    static const ect_device_t *const devices[TWINS] = {&testdev, &testdev};
    rig_t *r = calloc(1, sizeof *r);
    wire_open(&r->w, devices, TWINS);
    strcpy(r->folder, "/tmp/ectwin-trace-XXXXXX");
    assert_non_null(mkdtemp(r->folder));
    for (unsigned int n = 0; n < 2; n++)
        (void)snprintf(r->paths[n], sizeof r->paths[n], "%s/%u.pcapng", r->folder, n);
    r->clock_ns = START_NS;
    r->s.seed = 7;
    r->x = (ect_exchange_t){.chain = r->w.chain, .scenario = &r->s, .send = send, .clock = read_clock, .ctx = r};
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    ect_exchange_end(&r->x);
    (void)ect_trace_close(r->x.trace, r->clock_ns);
    for (unsigned int n = 0; n < 2; n++)
        (void)unlink(r->paths[n]);
    (void)rmdir(r->folder);
    wire_close(&r->w);
    free(r);
    return 0;
}

static void begin(rig_t *r)
{
    r->x.trace = ect_trace_new(open_file(r, 0, 1 << 16), open_file(r, 1, 1 << 16), TWINS);
    assert_non_null(r->x.trace);
    ect_exchange_start(&r->x);
}

/* --- the files ---------------------------------------------------------------------------------------------------- */

static void add_item(rig_t *r, const ect_item_t *item)
{
    const size_t used = strlen(r->items);
    char *at = r->items + used;
    const size_t room = sizeof r->items - used;
    ect_logged_t logged;
    if (item->kind == ECT_ITEM_PACKET) {
        (void)snprintf(at, room, "%c%u%c%u ", item->direction == ECT_PCAPNG_INBOUND ? '>' : '<', item->interface, ':',
                       item->bytes[INDEX_AT]);
    } else if (item->kind == ECT_ITEM_LOCAL) {
        assert_true(ect_logged_read(item->bytes, item->captured, &logged));
        const int64_t us = logged.time_ns == 0 ? NONE : (int64_t)(logged.time_ns - START_NS) / (int64_t)US;
        (void)snprintf(at, room, "%" PRIu32 "/%" PRIu32 "@%" PRId64 "%s%.*s ", logged.kind, logged.value, us,
                       logged.length > 0 ? "=" : "", (int)logged.length, logged.text);
    }
}

/* Closes the trace and reads its files. */
static ect_trace_lacks_t end(rig_t *r)
{
    const ect_trace_lacks_t lacks = ect_trace_close(r->x.trace, r->clock_ns);
    r->x.trace = NULL;
    for (unsigned int n = 0; n < 2; n++) {
        FILE *file = fopen(r->paths[n], "rb");
        r->sizes[n] = file ? fread(r->bytes[n], 1, FILE_ROOM, file) : 0;
        if (file)
            (void)fclose(file);
    }
    FILE *file = fopen(r->paths[1], "rb");
    ect_reader_t reader = {.file = file};
    ect_item_t item;
    while (file && ect_reader_next(&reader, &item) != ECT_ITEM_END) {
        assert_int_not_equal(item.kind, ECT_ITEM_WRONG);
        add_item(r, &item);
    }
    ect_reader_free(&reader);
    if (file)
        (void)fclose(file);
    return lacks;
}

/* Expects these items in the record. */
static void expect_items(rig_t *r, const char *want)
{
    const ect_trace_lacks_t lacks = end(r);
    assert_true(lacks.capture == 0 && lacks.record == 0 && !lacks.record_is_slow);
    assert_string_equal(r->items, want);
}

static bool has(const rig_t *r, unsigned int n, const char *text)
{
    return memmem(r->bytes[n], r->sizes[n], text, strlen(text)) != NULL;
}

static void expect_comment(const rig_t *r, const char *text)
{
    if (!has(r, 0, text) || !has(r, 1, text))
        fail_msg("'%s' is in the capture: %d, in the record: %d", text, has(r, 0, text), has(r, 1, text));
}

/* --- a run -------------------------------------------------------------------------------------------------------- */

static void set_fault(rig_t *r, const char *text)
{
    char message[ECT_FAULT_MESSAGE];
    ect_fault_t fault;
    if (!ect_fault_parse(text, &fault, message) || !ect_scenario_set(&r->s, r->w.chain, &fault, r->clock_ns, message))
        fail_msg("'%s': %s", text, message);
}

static void pass(rig_t *r, ect_end_t in, uint8_t index)
{
    const ect_packet_time_t time = {.now_ns = r->clock_ns};
    wire_build(&r->w, BRD, 0, 0x0130, "\0", 1);
    r->w.frame[INDEX_AT] = index;
    ect_exchange_frame(&r->x, in, r->w.frame, r->w.frame_length, &time);
}

static void run_at(rig_t *r, uint64_t us)
{
    r->clock_ns = START_NS + us * US;
    (void)ect_exchange_run(&r->x);
}

static void a_run_that_changes_nothing_is_no_item(void **state)
{
    rig_t *r = *state;
    begin(r);
    run_at(r, 1); /* the first one is */
    run_at(r, 2);
    run_at(r, 3);
    pass(r, ECT_END_IN, 5); /* behind a frame the devices run at the time of the reply */
    run_at(r, 4);
    run_at(r, 5);
    assert_true(ect_exchange_touch(&r->x) != 0);
    run_at(r, 6);
    run_at(r, 7);
    expect_items(r, "2/0@1 >0:5 <0:5 2/1@3 4/0@5 2/0@6 ");
}

static void a_run_is_an_item_from_the_deadline_of_the_devices_on(void **state)
{
    rig_t *r = *state;
    begin(r);
    run_at(r, 1);
    r->x.deadline_ns = START_NS + 5 * US;
    run_at(r, 4);
    r->x.deadline_ns = START_NS + 5 * US;
    run_at(r, 5);
    r->x.deadline_ns = START_NS + 5 * US;
    run_at(r, 6);
    expect_items(r, "2/0@1 2/0@5 2/0@6 ");
}

static void a_frame_that_is_too_long_is_a_request_without_a_reply(void **state)
{
    rig_t *r = *state;
    uint8_t frame[ECT_EXCHANGE_FRAME + 10] = {[INDEX_AT] = 9};
    begin(r);
    ect_exchange_long_frame(&r->x, ECT_END_OUT, frame, sizeof frame, r->clock_ns);
    assert_int_equal(r->x.stats.captured, 1);
    expect_items(r, ">1:9 ");
}

/* With faults the release of kept frames reads the clock too: the time of a run is an item of its own. */
static void with_a_fault_each_decision_has_its_time(void **state)
{
    rig_t *r = *state;
    begin(r);
    set_fault(r, "delay 10us wire 1");
    run_at(r, 1);
    pass(r, ECT_END_IN, 5);
    run_at(r, 2);
    run_at(r, 20);
    expect_items(r, "2/0@-1 3/0@1 >0:5 3/0@1 2/0@-1 3/0@2 3/0@2 2/0@-1 3/0@20 <0:5 3/0@20 ");
}

static void a_change_of_a_cable_is_an_item_and_a_comment(void **state)
{
    rig_t *r = *state;
    begin(r);
    ect_exchange_link(&r->x, ECT_END_IN, true); /* as it is */
    ect_exchange_link(&r->x, ECT_END_OUT, false);
    ect_exchange_link(&r->x, ECT_END_IN, false);
    ect_exchange_link(&r->x, ECT_END_IN, false);
    ect_exchange_link(&r->x, ECT_END_OUT, true);
    pass(r, ECT_END_OUT, 1);
    const ect_trace_lacks_t lacks = end(r);
    assert_true(lacks.capture == 0 && lacks.record == 0 && !lacks.record_is_slow);
    assert_string_equal(r->items, "6/0@-1 6/257@-1 >1:1 <1:1 ");
    expect_comment(r, "cable at the input of the chain: pulled");
    expect_comment(r, "cable at the output of the chain: plugged in");
    assert_false(has(r, 0, "cable at the input of the chain: plugged in"));
    assert_false(has(r, 0, "cable at the output of the chain: pulled"));
}

static void a_request_of_a_client_is_an_item_and_a_comment(void **state)
{
    char request[500], comment[400];
    rig_t *r = *state;
    begin(r);
    ect_exchange_request(&r->x, "set 1.x=1", 9);
    ect_exchange_power_cycle(&r->x);
    memset(request, 'x', sizeof request);
    ect_exchange_request(&r->x, request, sizeof request);
    pass(r, ECT_END_IN, 1);
    (void)end(r);
    const char *items = strstr(r->items, "5/0@");
    assert_ptr_equal(items, r->items);
    assert_non_null(strstr(items, "=set 1.x=1 4/0@0 7/0@0 5/0@0=xxx"));
    assert_non_null(memmem(r->bytes[1], r->sizes[1], request, sizeof request));
    expect_comment(r, "request: set 1.x=1");
    (void)snprintf(comment, sizeof comment, "request: %.300s", request);
    assert_true(has(r, 0, comment));
    assert_false(has(r, 0, "x1=") || memmem(r->bytes[0], r->sizes[0], request, 301) != NULL);
}

/* --- comments ----------------------------------------------------------------------------------------------------- */

static void each_effect_of_a_fault_is_a_comment_of_the_frame(void **state)
{
    static const struct {
        const char *fault, *comment; /* NULL: none about a fault */
    } rows[] = {
        {"truncate 20", "fault: the request is changed"},
        {"duplicate", "fault: the reply leaves twice"},
        {"reorder", "fault: the reply leaves after the next one"},
        {"delay 7us", "fault: the reply leaves 7 us late"},
        {"counter -1", "fault: working counter -1"},
        {"counter 2", "fault: working counter +2"},
        {"drop wire 1", "fault: the frame is lost on a wire"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(setup(state), 0);
        rig_t *r = *state;
        begin(r);
        set_fault(r, rows[i].fault);
        r->s.done = NULL; /* nor that it is set */
        pass(r, ECT_END_IN, 1);
        pass(r, ECT_END_IN, 2);
        (void)end(r);
        expect_comment(r, rows[i].comment);
        for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
            if (strcmp(rows[k].comment, rows[i].comment) != 0 && has(r, 0, rows[k].comment))
                fail_msg("%s: '%s' too", rows[i].fault, rows[k].comment);
        }
        teardown(state);
    }
}

static void a_fault_that_is_set_is_a_comment(void **state)
{
    rig_t *r = *state;
    begin(r);
    set_fault(r, "drop 50% wire 1");
    pass(r, ECT_END_IN, 1);
    (void)end(r);
    expect_comment(r, "fault: drop 50% wire 1");
}

static void a_frame_has_the_comments_of_its_effects_and_no_other(void **state)
{
    static const ect_frame_effects_t none = {.delay_us = 0}, late = {.delay_us = 1};
    static const ect_frame_effects_t request = {.lose_request = true}, reply = {.lose_reply = true};
    rig_t *r = *state;
    begin(r);
    ect_trace_effects(r->x.trace, &none, false);
    pass(r, ECT_END_IN, 1);
    assert_int_equal(r->x.stats.captured, 2);
    assert_int_equal(r->x.stats.uncaptured, 0);
    (void)end(r);
    assert_false(has(r, 0, "fault") || has(r, 1, "fault"));

    (void)teardown(state);
    (void)setup(state);
    r = *state;
    begin(r);
    ect_trace_effects(r->x.trace, &reply, false);
    ect_trace_effects(r->x.trace, &late, false);
    pass(r, ECT_END_IN, 1);
    (void)end(r);
    expect_comment(r, "fault: the reply is lost");
    expect_comment(r, "fault: the reply leaves 1 us late");
    assert_false(has(r, 0, "the request"));

    (void)teardown(state);
    (void)setup(state);
    r = *state;
    begin(r);
    ect_trace_effects(r->x.trace, &request, false);
    pass(r, ECT_END_IN, 1);
    (void)end(r);
    expect_comment(r, "fault: the request is lost");
    assert_false(has(r, 0, "the request is changed") || has(r, 0, "the reply"));
}

static void a_change_of_an_AL_state_or_code_is_one_comment(void **state)
{
    rig_t *r = *state;
    uint16_t code;
    begin(r);
    ect_trace_states(r->x.trace, r->w.chain);
    pass(r, ECT_END_IN, 1);
    wire_configure_mailbox(&r->w, 1);
    (void)wire_al(&r->w, 1, ECT_STATE_PREOP, &code);
    ect_trace_states(r->x.trace, r->w.chain);
    ect_trace_states(r->x.trace, r->w.chain);
    pass(r, ECT_END_IN, 2);
    (void)wire_al(&r->w, 0, ECT_STATE_OP, &code);
    ect_trace_states(r->x.trace, r->w.chain);
    pass(r, ECT_END_IN, 3);
    (void)end(r);
    expect_comment(r, "slave 2: PREOP");
    expect_comment(r, "slave 1: INIT, AL status code 0x0011");
    assert_false(has(r, 0, "slave 1: PREOP") || has(r, 0, "slave 1: INIT\n") || has(r, 0, "slave 2: PREOP\n"));
    assert_false(has(r, 0, "slave 2: PREOP, AL"));
}

static void a_run_of_the_devices_notes_their_states(void **state)
{
    rig_t *r = *state;
    uint16_t code;
    begin(r);
    run_at(r, 1);
    wire_configure_mailbox(&r->w, 1);
    (void)wire_al(&r->w, 1, ECT_STATE_PREOP, &code);
    run_at(r, 2);
    pass(r, ECT_END_IN, 1);
    (void)end(r);
    expect_comment(r, "slave 2: PREOP");
    assert_false(has(r, 0, "slave 1: "));
}

static void a_power_cycle_leads_to_INIT(void **state)
{
    rig_t *r = *state;
    begin(r);
    wire_go(&r->w, 0, ECT_STATE_PREOP);
    assert_int_equal(ect_chain_slave(r->w.chain, 0)->state, ECT_STATE_PREOP);
    ect_exchange_power_cycle(&r->x);
    assert_int_equal(ect_chain_slave(r->w.chain, 0)->state, ECT_STATE_INIT);
    expect_items(r, "4/0@0 7/0@0 ");
}

static void a_twin_that_leaves_the_bus_is_a_comment(void **state)
{
    rig_t *r = *state;
    begin(r);
    ect_slave_t *slave = (ect_slave_t *)(uintptr_t)ect_chain_slave(r->w.chain, 1);
    slave->off_bus = true;
    slave->code = 0x11;
    ect_trace_states(r->x.trace, r->w.chain);
    pass(r, ECT_END_IN, 1);
    (void)end(r);
    expect_comment(r, "slave 2: off the bus");
    assert_false(has(r, 0, "slave 1: ") || has(r, 0, "off the bus, AL"));
}

/* --- files that lack something ------------------------------------------------------------------------------------ */

static void a_trace_needs_neither_file(void **state)
{
    rig_t *r = *state;
    r->x.trace = ect_trace_new(NULL, NULL, TWINS);
    assert_non_null(r->x.trace);
    ect_trace_start(r->x.trace);
    ect_exchange_start(&r->x);
    ect_trace_note(r->x.trace, "a note");
    pass(r, ECT_END_IN, 1);
    run_at(r, 1);
    assert_int_equal(r->x.stats.captured, 2);
    const ect_trace_lacks_t lacks = ect_trace_close(r->x.trace, r->clock_ns);
    r->x.trace = NULL;
    assert_true(lacks.capture == 0 && lacks.record == 0 && !lacks.record_is_slow);
    const ect_trace_lacks_t none = ect_trace_close(NULL, 0);
    assert_true(none.capture == 0 && none.record == 0 && !none.record_is_slow);
}

static unsigned int count_of_threads(void)
{
    unsigned int count = 0;
    DIR *tasks = opendir("/proc/self/task");
    assert_non_null(tasks);
    for (const struct dirent *entry = readdir(tasks); entry; entry = readdir(tasks))
        count += entry->d_name[0] != '.';
    assert_int_equal(closedir(tasks), 0);
    return count;
}

static void a_start_begins_a_thread_for_each_file(void **state)
{
    rig_t *r = *state;
    begin(r);
    const unsigned int before = count_of_threads();
    ect_trace_start(r->x.trace);
    assert_int_equal(count_of_threads(), before + 2);
    pass(r, ECT_END_IN, 1);
    expect_items(r, ">0:1 <0:1 ");
}

static long size_of(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const long size = ftell(file);
    assert_int_equal(fclose(file), 0);
    return size;
}

static void a_flush_writes_to_both_files(void **state)
{
    rig_t *r = *state;
    long before[2];
    begin(r);
    for (unsigned int n = 0; n < 2; n++)
        before[n] = size_of(r->paths[n]);
    pass(r, ECT_END_IN, 1);
    ect_trace_flush(r->x.trace);
    for (unsigned int n = 0; n < 2; n++)
        assert_true(size_of(r->paths[n]) > before[n] + (long)r->w.frame_length);
}

/* The capture has the frames that fit; the record ends at the first item that does not. */
static void a_record_whose_buffer_is_full_ends_with_a_last_item(void **state)
{
    rig_t *r = *state;
    const size_t small = 4 * ECT_PCAPNG_ROOM;
    size_t buffer = 1;
    while (buffer < small)
        buffer *= 2;
    r->x.trace = ect_trace_new(open_file(r, 0, buffer), open_file(r, 1, buffer), TWINS);
    ect_exchange_start(&r->x);
    unsigned int frames = 0;
    for (; r->x.stats.uncaptured == 0 && frames < 10000; frames++)
        pass(r, ECT_END_IN, 1);
    assert_true(frames > 2 && frames < 10000);
    ect_trace_flush(r->x.trace);
    ect_trace_log(r->x.trace, ECT_LOGGED_TOUCH, 77, START_NS, NULL, 0); /* too late for the record */
    const uint64_t captured = r->x.stats.captured;
    pass(r, ECT_END_IN, 2);
    assert_int_equal(r->x.stats.captured, captured + 2);
    r->clock_ns += 9 * US;
    const ect_trace_lacks_t lacks = end(r);
    assert_true(lacks.record_is_slow && lacks.capture == 0 && lacks.record == 0);
    assert_null(strstr(r->items, "4/77"));
    assert_null(strstr(r->items, ":2"));
    const char *last = strstr(r->items, "8/0@9 ");
    assert_true(last == NULL ? strlen(r->items) == sizeof r->items - 1 : last[6] == '\0');
}

static void an_item_of_any_length_is_in_the_record(void **state)
{
    static const size_t lengths[] = {0, 1, 239, 240, 241, 256, 1000};
    rig_t *r = *state;
    char text[1000];
    for (size_t i = 0; i < sizeof text; i++)
        text[i] = (char)('a' + i % 26);
    begin(r);
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++)
        ect_trace_log(r->x.trace, ECT_LOGGED_CONTENT, (uint32_t)lengths[i], 0, text, lengths[i]);
    (void)end(r);
    const char *at = r->items;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0] - 1; i++) {
        char want[400];
        (void)snprintf(want, sizeof want, "9/%zu@-1%s%.*s ", lengths[i], lengths[i] > 0 ? "=" : "", (int)lengths[i],
                       text);
        assert_memory_equal(at, want, strlen(want));
        at += strlen(want);
    }
    assert_non_null(memmem(r->bytes[1], r->sizes[1], text, sizeof text));
    assert_null(memmem(r->bytes[0], r->sizes[0], text, 26));
}

#define TEST(title, function)  {title, function, setup, teardown, NULL}
#define TABLE(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("a run that changes nothing is no item of the record", a_run_that_changes_nothing_is_no_item),
        TEST("a run is an item from the deadline of the devices on",
             a_run_is_an_item_from_the_deadline_of_the_devices_on),
        TEST("a frame that is too long is a request without a reply",
             a_frame_that_is_too_long_is_a_request_without_a_reply),
        TEST("with a fault each reading of the clock is an item", with_a_fault_each_decision_has_its_time),
        TEST("a change of a cable is an item and a comment", a_change_of_a_cable_is_an_item_and_a_comment),
        TEST("a request of a client is an item and a comment, a power cycle is one",
             a_request_of_a_client_is_an_item_and_a_comment),
        TABLE("each effect of a fault is a comment of its frame", each_effect_of_a_fault_is_a_comment_of_the_frame),
        TEST("a fault that is set is a comment", a_fault_that_is_set_is_a_comment),
        TEST("a frame has the comments of its effects and no other",
             a_frame_has_the_comments_of_its_effects_and_no_other),
        TEST("a change of an AL state or code is one comment", a_change_of_an_AL_state_or_code_is_one_comment),
        TEST("a change of an AL state is noted when the devices run", a_run_of_the_devices_notes_their_states),
        TEST("a power cycle leads to INIT, and is an item", a_power_cycle_leads_to_INIT),
        TEST("a twin that leaves the bus is a comment", a_twin_that_leaves_the_bus_is_a_comment),
        TEST("a trace needs neither file", a_trace_needs_neither_file),
        TEST("a start begins a thread for the capture and one for the record", a_start_begins_a_thread_for_each_file),
        TEST("a flush writes to the capture and to the record", a_flush_writes_to_both_files),
        TEST("a record whose buffer is full ends there, with a last item",
             a_record_whose_buffer_is_full_ends_with_a_last_item),
        TEST("an item of any length is in the record, and in it alone", an_item_of_any_length_is_in_the_record),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Trace", tests, NULL, NULL);
}
