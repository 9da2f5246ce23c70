/* SPDX-License-Identifier: MIT */
/* Scenarios: milestones, ends of faults, signals, expectations and their verdict (bus/faults/scenario.h). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/catalogue.h"
#include "bus/chain/settings.h"
#include "bus/exchange.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { TWINS = 2, ROOM = 256 };

typedef struct rig {
    wire_t w;
    ect_scenario_t s;
    ect_exchange_t x;
    uint64_t begin_ns;
    unsigned int judged;
    char message[ECT_STEP_MESSAGE];
    char refused[512];
} rig_t;

static uint64_t read_clock(void *ctx)
{
    const rig_t *r = ctx;
    return r->w.now_ns;
}

static void send(void *ctx, ect_end_t end, const uint8_t *frame, size_t length)
{
    (void)ctx;
    (void)end;
    (void)frame;
    (void)length;
}

/* The chain of the raw master runs by the exchange: devices, then steps. */
static void run(wire_t *w)
{
    rig_t *r = (rig_t *)(void *)w;
    (void)ect_exchange_touch(&r->x);
    (void)ect_exchange_run(&r->x);
}

static void note_judged(void *ctx, const ect_scenario_step_t *step)
{
    rig_t *r = ctx;
    (void)step;
    r->judged++;
}

static void note_refused(void *ctx, const char *fault, const char *why)
{
    rig_t *r = ctx;
    snprintf(r->refused, sizeof r->refused, "%s: %s", fault, why);
}

static void open_rig(void **state, const ect_device_t *device, const ect_plant_t *plant)
{
    rig_t *r = calloc(1, sizeof *r);
    ect_twin_config_t twins[TWINS];
    for (unsigned int i = 0; i < TWINS; i++)
        twins[i] = ect_twin_default(device, plant);
    wire_open_twins(&r->w, twins, TWINS);
    for (unsigned int i = 0; i < TWINS; i++)
        wire_configure_mailbox(&r->w, i);
    r->s = (ect_scenario_t){.seed = 7, .refused = note_refused, .judged = note_judged, .ctx = r};
    r->x = (ect_exchange_t){.chain = r->w.chain, .scenario = &r->s, .send = send, .clock = read_clock, .ctx = r};
    r->w.poll = run;
    *state = r;
}

static int setup(void **state)
{
    const ect_product_t *product = ect_catalogue_find("fzm1");
    open_rig(state, product->device, product->plant);
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    ect_exchange_end(&r->x);
    wire_close(&r->w);
    free(r);
    return 0;
}

static void read_line(rig_t *r, const char *line)
{
    if (!ect_scenario_read(&r->s, line, r->message))
        fail_msg("'%s': %s", line, r->message);
}

static void start(rig_t *r, const char *const *lines)
{
    for (; *lines; lines++)
        read_line(r, *lines);
    assert_null(ect_scenario_check(&r->s, r->w.chain, r->message));
    r->begin_ns = r->w.now_ns;
    ect_exchange_start(&r->x);
    (void)ect_exchange_run(&r->x);
}
#define START(r, ...) start(r, (const char *const[]){__VA_ARGS__, NULL})

/* Advances the time to each time at which the exchange is due. */
static void advance(rig_t *r, uint64_t ns)
{
    uint64_t end_ns = r->w.now_ns + ns;
    while (r->w.now_ns < end_ns) {
        uint64_t next_ns = ect_exchange_run(&r->x);
        r->w.now_ns = next_ns > r->w.now_ns && next_ns < end_ns ? next_ns : end_ns;
    }
    (void)ect_exchange_run(&r->x);
}

/* The frame that was built. */
static void send_built(rig_t *r)
{
    const ect_packet_time_t time = {.now_ns = r->w.now_ns};
    ect_exchange_frame(&r->x, ECT_END_IN, r->w.frame, r->w.frame_length, &time);
    (void)ect_exchange_run(&r->x);
}

/* A frame with process data, without a slave that takes part. */
static void cycle(rig_t *r)
{
    wire_build(&r->w, LRW, 0, 0x7FFF, "\0", 1);
    send_built(r);
}

static void read_signal(rig_t *r, size_t position, const char *name, char *text)
{
    ect_signal_ref_t ref;
    assert_true(ect_chain_signal(r->w.chain, position, name, &ref));
    ect_signal_read(&ref, text);
}

static void expect_signal(rig_t *r, size_t position, const char *name, const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    read_signal(r, position, name, text);
    assert_string_equal(text, want);
}

static uint32_t upload_identity(rig_t *r, size_t position)
{
    uint8_t data[8];
    size_t size = sizeof data;
    return wire_sdo_upload(&r->w, position, 0x1018, 1, false, data, &size);
}

static size_t set_count(rig_t *r)
{
    char text[ECT_FAULT_TEXT];
    size_t count = 0;
    while (ect_scenario_show(&r->s, r->w.chain, count, text))
        count++;
    return count;
}

/* --- milestones --------------------------------------------------------------------------------------------------- */

static void cycles(void **state)
{
    rig_t *r = *state;
    START(r, "drop 0% after 3 cycles");
    for (unsigned int i = 0; i < 3; i++) {
        assert_int_equal(set_count(r), 0);
        cycle(r);
        (void)wire_read8(&r->w, 0, 0x0130); /* no process data */
    }
    assert_int_equal(set_count(r), 1);
}

/* Cycles, like times, are counted from the previous milestone on. */
static void cycles_after_a_milestone(void **state)
{
    rig_t *r = *state;
    START(r, "drop 0% at slave 2 PREOP after 2 cycles after 3 cycles", "hang slave 1 at slave 2 PREOP for 4 cycles");
    for (unsigned int i = 0; i < 7; i++)
        cycle(r);
    wire_go(&r->w, 1, 2);
    for (unsigned int i = 0; i < 5; i++) {
        assert_int_equal(set_count(r), 0);
        assert_int_equal(r->s.steps_left, i < 4 ? 2 : 1);
        cycle(r);
    }
    assert_int_equal(set_count(r), 1);
    assert_int_equal(r->s.steps_left, 0);
}

/* A frame counts once, whichever of its datagrams has process data. */
static void frames_with_process_data(void **state)
{
    static const struct {
        uint8_t commands[2];
        bool counts;
    } rows[] = {{{NOP}, false},     {{APRD}, false},    {{APWR}, false},    {{APRW}, false},    {{FPRD}, false},
                {{FPWR}, false},    {{FPRW}, false},    {{BRD}, false},     {{BWR}, false},     {{BRW}, false},
                {{LRD}, true},      {{LWR}, true},      {{LRW}, true},      {{ARMW}, false},    {{FRMW}, false},
                {{BRD, LRD}, true}, {{LRW, BRD}, true}, {{LRD, LWR}, true}, {{BRD, BRD}, false}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        teardown(state);
        setup(state);
        rig_t *r = *state;
        START(r, "drop 0% after 2 cycles");
        for (unsigned int sent = 1; sent <= 2; sent++) {
            wire_build(&r->w, rows[i].commands[0], 0, 0x7FFF, "\0", 1);
            if (rows[i].commands[1] != NOP)
                wire_append(&r->w, rows[i].commands[1], 0, 0x7FFF, "\0", 1);
            send_built(r);
            const bool reached = set_count(r) == 1;
            if (reached != (rows[i].counts && sent == 2))
                fail_msg("commands %u and %u: after %u frames the step is %s", rows[i].commands[0], rows[i].commands[1],
                         sent, reached ? "over" : "waiting");
        }
    }
}

static void one_after_the_other(void **state)
{
    rig_t *r = *state;
    START(r, "at slave 2 PREOP after 100ms at slave 2 INIT drop 0%");
    wire_go(&r->w, 1, 2);
    assert_int_equal(wire_al(&r->w, 1, 1, NULL), 1);
    advance(r, 99 * MS);
    assert_int_equal(set_count(r), 0);
    advance(r, MS);
    assert_int_equal(set_count(r), 1);
}

static void transfers(void **state)
{
    rig_t *r = *state;
    START(r, "at the 3rd upload of 1018h:1 abort 0x1018 0x08000020 slave 2");
    wire_go(&r->w, 0, 2);
    wire_go(&r->w, 1, 2);
    for (unsigned int i = 0; i < 3; i++) {
        assert_int_equal(upload_identity(r, 0), 0); /* of another slave */
        assert_int_equal(upload_identity(r, 1), 0);
    }
    assert_int_equal(upload_identity(r, 1), 0x08000020);
    assert_int_equal(upload_identity(r, 0), 0);
}

static void transfers_of_any(void **state)
{
    rig_t *r = *state;
    START(r, "at the 2nd upload of 0x1018 drop 0%");
    wire_go(&r->w, 0, 2);
    wire_go(&r->w, 1, 2);
    assert_int_equal(upload_identity(r, 0), 0);
    assert_int_equal(set_count(r), 0);
    assert_int_equal(upload_identity(r, 1), 0);
    assert_int_equal(set_count(r), 1);
}

static void ends(void **state)
{
    rig_t *r = *state;
    START(r, "drop 0% while slave 2 in PREOP", "counter 0 for 50ms", "corrupt 0% until 80ms",
          "truncate 1 0% until slave 2 INIT again", "al never to OP slave 2 for 20ms");
    assert_int_equal(set_count(r), 4);
    wire_go(&r->w, 1, 2);
    assert_int_equal(set_count(r), 5);
    advance(r, 20 * MS);
    assert_int_equal(set_count(r), 4);
    assert_int_equal(wire_al(&r->w, 1, 1, NULL), 1); /* two of them */
    assert_int_equal(set_count(r), 2);
    wire_go(&r->w, 1, 2); /* ... one each time */
    assert_int_equal(set_count(r), 3);
    advance(r, 29 * MS);
    assert_int_equal(set_count(r), 3);
    advance(r, MS);
    assert_int_equal(set_count(r), 2);
    advance(r, 30 * MS);
    assert_int_equal(set_count(r), 1);
}

/* The lines of a script that does the same from now on, in succession. */
static void expect_left(const rig_t *r, const char *want)
{
    char all[8 * ECT_STEP_LINE] = "", text[ECT_STEP_LINE];
    for (size_t i = 0; ect_scenario_left(&r->s, r->w.chain, i, text); i++) {
        strcat(all, text);
        strcat(all, "; ");
    }
    assert_string_equal(all, want);
}

static void is_left(void **state)
{
    rig_t *r = *state;
    ect_fault_t fault;
    START(r, "drop 0%", "counter 0 for 50ms", "at 60ms corrupt 0%", "at 70ms hang slave 2",
          "expect ecat.state=1 for 80ms");
    expect_left(
        r, "drop 0%; counter 0 for 50ms; at 60ms corrupt 0%; at 70ms hang slave 2; expect ecat.state=1 for 80ms; ");
    assert_true(ect_fault_parse("al never slave 2", &fault, r->message));
    assert_true(ect_scenario_set(&r->s, r->w.chain, &fault, r->w.now_ns, r->message));
    advance(r, 60 * MS);
    expect_left(r, "drop 0%; corrupt 0%; al never slave 2; at 70ms hang slave 2; expect ecat.state=1 for 80ms; ");
    advance(r, 20 * MS);
    expect_left(r, "drop 0%; corrupt 0%; al never slave 2; ");
}

/* Each function handles the last one, and none behind it. */
static void the_most_steps(void **state)
{
    char text[ECT_STEP_LINE];
    rig_t *r = *state;
    for (unsigned int n = 1; n < ECT_SCENARIO_STEPS; n++)
        read_line(r, n % 2 == 0 ? "at 10ms drop 0% for 10ms" : "expect ecat.state=2 within 30ms");
    START(r, "expect slave 2 ecat.state=1 for 10ms");
    assert_int_equal(r->s.step_count, ECT_SCENARIO_STEPS);
    assert_int_equal(ect_scenario_highest_slave(&r->s), 2);
    assert_true(ect_scenario_left(&r->s, r->w.chain, ECT_SCENARIO_STEPS - 1, text));
    assert_string_equal(text, "expect slave 2 ecat.state=1 for 10ms");
    assert_false(ect_scenario_left(&r->s, r->w.chain, ECT_SCENARIO_STEPS, text));
    advance(r, 20 * MS);
    assert_true(r->s.steps[ECT_SCENARIO_STEPS - 1].met);
    assert_int_equal(r->s.steps_left, ECT_SCENARIO_STEPS / 2);
    assert_int_equal(ect_scenario_end(&r->s).failed, ECT_SCENARIO_STEPS / 2);
    assert_int_equal(r->s.steps_left, 0);
}

static void the_longest_line_is_left(void **state)
{
    static const char fault[] = "hang slave 2";
    char line[ECT_STEP_LINE], want[ECT_STEP_LINE + 8];
    rig_t *r = *state;
    snprintf(line, sizeof line, "%-*s%s", (int)(sizeof line - sizeof fault), "at 70ms", fault);
    assert_int_equal(strlen(line), ECT_STEP_LINE - 1);
    snprintf(want, sizeof want, "%s; ", line);
    START(r, line);
    expect_left(r, want);
}

static void hangs_for_a_time(void **state)
{
    rig_t *r = *state;
    START(r, "hang slave 2 for 100ms");
    assert_int_equal(wire_al(&r->w, 1, 2, NULL), 1);
    advance(r, 100 * MS);
    assert_int_equal(wire_read8(&r->w, 1, 0x0130), 2);
}

/* A read of the EEPROM of slave 2, or its status without an end of the command, or with an error. */
static uint32_t read_eeprom(rig_t *r)
{
    static const uint8_t command[] = {0x00, 0x01, 0x08, 0x00, 0x00, 0x00};
    uint8_t data[4] = {0};
    uint8_t idle[2] = {0};
    assert_int_equal(wire_write(&r->w, 1, 0x0502, idle, sizeof idle), 1); /* clears an error */
    assert_int_equal(wire_write(&r->w, 1, 0x0502, command, sizeof command), 1);
    advance(r, 5 * MS);
    const uint16_t status = wire_read16(&r->w, 1, 0x0502) & 0xA000;
    assert_int_equal(wire_read(&r->w, 1, 0x0508, data, sizeof data), 1);
    return status != 0 ? status : ect_load_le32(data);
}

static void eeprom_for_a_time(void **state)
{
    static const char *const lines[] = {"eeprom busy slave 2 for 100ms", "eeprom nack slave 2 for 100ms",
                                        "eeprom flip 3 slave 2 for 100ms"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        teardown(state);
        setup(state);
        rig_t *r = *state;
        const uint32_t good = read_eeprom(r);
        const uint32_t wanted[] = {0x8000, 0x2000, good ^ 0x00080008};
        START(r, lines[i]);
        const uint32_t got = read_eeprom(r);
        if (got != wanted[i])
            fail_msg("%s: expected 0x%X, got 0x%X", lines[i], wanted[i], got);
        advance(r, 100 * MS);
        assert_int_equal(read_eeprom(r), good);
    }
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static void sets(void **state)
{
    rig_t *r = *state;
    START(r, "at 100ms set 2:ecat.latch0=1 ecat.latch1=1", "set ecat.drift=500 for 50ms");
    expect_signal(r, 0, "ecat.drift", "500");
    advance(r, 50 * MS);
    expect_signal(r, 0, "ecat.drift", "0");
    expect_signal(r, 1, "ecat.latch0", "0");
    advance(r, 50 * MS);
    expect_signal(r, 1, "ecat.latch0", "1");
    expect_signal(r, 1, "ecat.latch1", "1");
    expect_signal(r, 0, "ecat.latch0", "0");
    assert_string_equal(r->refused, "");
}

/* A device with a text behind its instance, which is longer than the words of a script. */
static void sets_a_text_again(void **state)
{
    static const char *const before[] = {"", "width of the part", "!\"=,;\\ until 5s",
                                         ("a text of 100 characters with spaces, longer than sixty, is set again as it "
                                          "was, up to its last ...#")};
    static ect_device_t device;
    static ect_signal_t signal;
    static ect_signal_group_t group;
    static ect_plant_t plant;
    rig_t *r;
    device = *ect_catalogue_find("fzm1")->device;
    signal = (ect_signal_t){
        .name = "text", .meaning = "a text", .type = ECT_SIGNAL_TEXT, .access = ECT_SIGNAL_WRITE, .maximum = 100};
    group = (ect_signal_group_t){.offset = (unsigned int)device.instance_size, .signal_count = 1, .signals = &signal};
    plant = (ect_plant_t){.signal_groups = &group, .signal_group_count = 1};
    device.instance_size += 101;
    for (size_t i = 0; i < sizeof before / sizeof before[0]; i++) {
        const ect_setting_t setting = {"text", before[i]};
        teardown(state);
        open_rig(state, &device, &plant);
        r = *state;
        assert_true(ect_settings_apply(r->w.chain, 1, &setting, 1, r->w.now_ns, r->message));
        START(r, "at 10ms set 2:text=x until 20ms");
        advance(r, 19 * MS);
        expect_signal(r, 1, "text", "x");
        advance(r, MS);
        expect_signal(r, 1, "text", before[i]);
        assert_string_equal(r->refused, "");
    }
}

/* The devices run at the time of a step, and before the next frame. */
static void in_its_cycle(void **state)
{
    rig_t *r = *state;
    START(r, "at 10ms set 2:ecat.plug_in=0");
    uint64_t due_ns = r->begin_ns + 10 * MS;
    uint8_t status[2] = {0};
    for (r->w.now_ns = due_ns - 3; r->w.now_ns < due_ns + 3; r->w.now_ns++) {
        (void)ect_exchange_run(&r->x);
        int answered = wire_send(&r->w, BRD, 0, 0x0130, status, 2);
        assert_int_equal(answered, r->w.now_ns < due_ns ? 2 : 1);
    }
}

/* A recording: each row applies from the first frame at or after its time on, and to no frame before. */
static void table_in_its_cycle(void **state)
{
    static const char *const names[] = {"ecat.plug_in", "ecat.drift"};
    static const char *const rows[][2] = {{"1", "0"}, {"0", ""}, {"1", "7"}};
    static const uint64_t times_ns[] = {0, 10 * MS, 10 * MS + 5};
    rig_t *r = *state;
    uint8_t status[2] = {0};
    ect_table_t *table = ect_table_new(2, names, 2);
    for (unsigned int i = 0; i < 3; i++)
        assert_true(ect_table_add(table, times_ns[i], rows[i]));
    assert_true(ect_table_check(table, r->w.chain, r->message));
    r->s.tables = table;
    START(r, "drop 0%");
    uint64_t due_ns = r->begin_ns + 10 * MS;
    for (r->w.now_ns = due_ns - 3; r->w.now_ns < due_ns + 10; r->w.now_ns++) {
        (void)ect_exchange_run(&r->x);
        bool plugged = r->w.now_ns < due_ns || r->w.now_ns >= due_ns + 5;
        assert_int_equal(wire_send(&r->w, BRD, 0, 0x0130, status, 2), plugged ? 2 : 1);
        expect_signal(r, 1, "ecat.drift", r->w.now_ns < due_ns + 5 ? "0" : "7");
    }
    assert_true(ect_table_due(table) == ECT_NEVER);
    assert_true(r->s.tables_over);
    assert_string_equal(r->refused, "");
    r->s.tables = NULL;
    ect_table_free(table);
}

/* After a late call a tick plays the rows of one time, so that the values of each have an effect. */
static void late_table(void **state)
{
    static const char *const name = "ecat.drift";
    static const char *const values[] = {"5", "6", "7"};
    rig_t *r = *state;
    ect_table_t *table = ect_table_new(1, &name, 1);
    for (unsigned int i = 0; i < 3; i++)
        assert_true(ect_table_add(table, (i + 1) * MS, &values[i]));
    r->s.tables = table;
    START(r, "drop 0%");
    r->w.now_ns = r->begin_ns + 10 * MS;
    for (unsigned int i = 0; i < 3; i++) {
        uint64_t next_ns = ect_scenario_tick(&r->s, r->w.chain, r->w.now_ns);
        expect_signal(r, 0, "ecat.drift", values[i]);
        assert_true(next_ns == (i < 2 ? r->begin_ns + (i + 2) * MS : ECT_NEVER));
    }
    r->s.tables = NULL;
    ect_table_free(table);
}

static void refused_row(void **state)
{
    static const char *const name = "ecat.latch0";
    static const char *const values[] = {"2", "1"};
    rig_t *r = *state;
    ect_table_t *table = ect_table_new(1, &name, 1);
    for (unsigned int i = 0; i < 2; i++)
        assert_true(ect_table_add(table, (i + 1) * MS, &values[i]));
    r->s.tables = table;
    START(r, "drop 0%");
    (void)ect_scenario_tick(&r->s, r->w.chain, r->begin_ns + MS);
    assert_string_equal(r->refused, "row of a table: ecat.latch0 takes 0..1, not '2'");
    (void)ect_scenario_tick(&r->s, r->w.chain, r->begin_ns + 2 * MS);
    expect_signal(r, 0, "ecat.latch0", "1");
    r->s.tables = NULL;
    ect_table_free(table);
}

static void expect_progress(rig_t *r, const char *line, const char *step, const char *over, const char *verdict)
{
    expect_signal(r, 0, "scenario.line", line);
    expect_signal(r, 0, "scenario.step", step);
    expect_signal(r, 0, "scenario.over", over);
    expect_signal(r, 0, "scenario.verdict", verdict);
}

/* The signals of a script follow its steps; a run without a script, and the second twin, have none. */
static void progress(void **state)
{
    rig_t *r = *state;
    ect_signal_ref_t ref;
    ect_chain_cursor_t cursor = {0};
    unsigned int found = 0;
    char message[ECT_SIGNAL_MESSAGE];
    assert_false(ect_chain_signal(r->w.chain, 0, "scenario.line", &ref));
    r->s.line = 3;
    read_line(r, "at 100ms set data1=5 until 200ms # a comment");
    r->s.line = 5;
    START(r, "expect data1=5 within 150ms");
    expect_progress(r, "5", "expect data1=5 within 150ms", "0", "running");
    expect_signal(r, 0, "scenario.steps", "2");
    expect_signal(r, 0, "scenario.expected", "1");
    advance(r, 100 * MS);
    expect_progress(r, "5", "expect data1=5 within 150ms", "1", "met");
    expect_signal(r, 0, "scenario.met", "1");
    advance(r, 300 * MS);
    expect_progress(r, "3", "at 100ms set data1=5 until 200ms", "2", "met");
    expect_signal(r, 0, "scenario.failed", "0");
    assert_false(ect_chain_signal(r->w.chain, 1, "scenario.line", &ref));
    while (ect_chain_next_signal(r->w.chain, 0, &cursor, &ref))
        found += strncmp(ref.name, "scenario.", 9) == 0;
    assert_int_equal(found, 8);
    assert_true(ect_chain_signal(r->w.chain, 0, "scenario.line", &ref));
    assert_false(ect_signal_check(&ref, "1", message));
}

static void verdicts_as_a_signal(void **state)
{
    static const struct {
        const char *line, *verdict, *at_the_end;
    } rows[] = {
        {"expect data1=1", "failed", "failed"},
        {"expect data1=0", "met", "met"},
        {"set data1=1", "over", "over"},
        {"at 5s expect data1=0", "running", "failed"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        teardown(state);
        setup(state);
        rig_t *r = *state;
        START(r, rows[i].line);
        advance(r, 10 * MS);
        expect_signal(r, 0, "scenario.verdict", rows[i].verdict);
        (void)ect_scenario_end(&r->s);
        expect_signal(r, 0, "scenario.verdict", rows[i].at_the_end);
    }
}

/* A table that begins again, and one with rows between its rows: the value at each millisecond. */
static void loops_and_lines(void **state)
{
    enum { ROWS = 4, TIMES = 10 };
    static const struct {
        const char *title;
        unsigned int at[ROWS]; /* ms */
        const char *values[ROWS];
        size_t count;
        uint64_t every_ns;
        bool loop;
        const char *wanted[TIMES]; /* at 0 ms, 1 ms, ...; the drift of the start is 0 */
    } rows[] = {
        {"once", {1, 3}, {"5", "7"}, 2, 0, false, {"0", "5", "5", "7", "7", "7", "7", "7", "7", "7"}},
        {"a loop", {0, 1, 3}, {"5", "7", ""}, 3, 0, true, {"5", "7", "7", "5", "7", "7", "5", "7", "7", "5"}},
        {"a loop that begins late", {1, 2}, {"5", "7"}, 2, 0, true, {"0", "5", "7", "5", "7", "5", "7", "5", "7", "5"}},
        {"a line", {1, 5}, {"10", "50"}, 2, MS, false, {"0", "10", "20", "30", "40", "50", "50", "50", "50", "50"}},
        {"up and down", {0, 2, 4}, {"0", "6", "0"}, 3, MS, true, {"0", "3", "6", "3", "0", "3", "6", "3", "0", "3"}},
        {"whole between whole numbers",
         {0, 3},
         {"0", "1"},
         2,
         MS,
         false,
         {"0", "0", "1", "1", "1", "1", "1", "1", "1", "1"}},
        {"over an empty cell",
         {0, 1, 4},
         {"0", "", "8"},
         3,
         MS,
         false,
         {"0", "2", "4", "6", "8", "8", "8", "8", "8", "8"}},
        {"a step longer than the distance",
         {0, 4},
         {"2", "8"},
         2,
         9 * MS,
         false,
         {"2", "2", "2", "2", "8", "8", "8", "8", "8", "8"}},
        {"no value before or behind",
         {0, 2, 4, 6},
         {"", "2", "4", ""},
         4,
         MS,
         false,
         {"0", "0", "2", "3", "4", "4", "4", "4", "4", "4"}},
    };
    static const char *const name = "ecat.drift";
    rig_t *r = *state;
    START(r, "drop 0%");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_table_t *table = ect_table_new(1, &name, 1);
        for (size_t n = 0; n < rows[i].count; n++)
            assert_true(ect_table_add(table, rows[i].at[n] * MS, &rows[i].values[n]));
        if (rows[i].every_ns > 0)
            assert_null(ect_table_refine(table, rows[i].every_ns));
        if (rows[i].loop)
            assert_true(ect_table_loop(table));
        const ect_setting_t zero = {name, "0"};
        assert_true(ect_settings_apply(r->w.chain, 0, &zero, 1, r->w.now_ns, r->message));
        for (uint64_t ms = 0; ms < TIMES; ms++) {
            char text[ECT_SIGNAL_TEXT_ROOM];
            ect_signal_ref_t ref;
            while (ect_table_due(table) <= ms * MS)
                assert_true(ect_table_play(table, r->w.chain, r->w.now_ns, r->message));
            assert_true(ect_chain_signal(r->w.chain, 0, name, &ref));
            ect_signal_read(&ref, text);
            if (strcmp(text, rows[i].wanted[ms]) != 0)
                fail_msg("%s: expected %s at %u ms, got %s", rows[i].title, rows[i].wanted[ms], (unsigned int)ms, text);
        }
        assert_int_equal(ect_table_due(table) == ECT_NEVER, !rows[i].loop);
        ect_table_free(table);
    }
}

static void conditions(void **state)
{
    static const struct {
        const char *condition, *value;
        bool met;
    } rows[] = {
        {"x=5", "5", true},     {"x=5", "5.0", true},    {"x=5", "6", false},    {"x=5", "5 mm", false},
        {"x!=5", "5", false},   {"x!=5", "4", true},     {"x!=5", "6", true},    {"x<5", "4.9", true},
        {"x<5", "5", false},    {"x<5", "6", false},     {"x>5", "5.1", true},   {"x>5", "5", false},
        {"x>5", "4", false},    {"x>5", "six", false},   {"x>5", "", false},     {"x<-1", "-2", true},
        {"x=abc", "abc", true}, {"x=abc", "ABC", false}, {"x!=abc", "ab", true}, {"x!=abc", "abc", false},
        {"x=", "", true},       {"x=", "1", false},
    };
    static const char *const none[] = {"", "x", "=5", "x!5", "x<abc", "x>", "x>5 mm"};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_condition_t c;
        assert_true(ect_condition_read(rows[i].condition, &c));
        assert_string_equal(c.name, "x");
        if (ect_condition_met(&c, rows[i].value) != rows[i].met)
            fail_msg("%s is %s for '%s'", rows[i].condition, rows[i].met ? "not met" : "met", rows[i].value);
    }
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++) {
        ect_condition_t c;
        if (ect_condition_read(none[i], &c))
            fail_msg("'%s' is a condition", none[i]);
    }
    for (size_t length = ECT_STEP_ACTION - 1; length <= ECT_STEP_ACTION; length++) {
        char name[ECT_STEP_ACTION + 1] = "", text[ECT_STEP_ACTION + 3];
        ect_condition_t c;
        memset(name, 'n', length);
        (void)snprintf(text, sizeof text, "%.*s=1", (int)length, name);
        assert_int_equal(ect_condition_read(text, &c), length < ECT_STEP_ACTION);
    }
}

/* The value of a row after a quarter of the time between two cells: a number between numbers, whole between whole
 * numbers; else no value.
 */
static void between_two_cells(void **state)
{
    static const struct {
        const char *from, *to, *want; /* NULL: no value */
    } rows[] = {{"0", "8", "2"},      {"8", "0", "6"},      {"0", "1", "0"},       {"-8", "-4", "-7"},
                {"0.0", "1", "0.25"}, {"0", "1.0", "0.25"}, {"0e0", "1", "0.25"},  {"0", "1E0", "0.25"},
                {"0.5", "0.5", NULL}, {"3", "3", NULL},     {"a", "1", NULL},      {"0", "a", NULL},
                {"0 ", "1", NULL},    {"0", "1 mm", NULL},  {"inf", "1", NULL},    {"0", "nan", NULL},
                {"", "1", NULL},      {"0", "", NULL},      {"0", "1e6", "250000"}};
    static const char *const name = "ecat.drift";
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_table_t *table = ect_table_new(1, &name, 1);
        assert_true(ect_table_add(table, 4 * MS, &rows[i].from) && ect_table_add(table, 8 * MS, &rows[i].to));
        assert_null(ect_table_refine(table, MS));
        assert_int_equal(table->count, 5);
        assert_true(table->rows[1]->due_ns == 5 * MS);
        const char *got = table->rows[1]->values[0];
        if ((got == NULL) != (rows[i].want == NULL) || (got && strcmp(got, rows[i].want) != 0))
            fail_msg("from '%s' to '%s': expected %s, got %s", rows[i].from, rows[i].to,
                     rows[i].want ? rows[i].want : "no value", got ? got : "no value");
        ect_table_free(table);
    }
}

/* The most columns: each intermediate row has a value of each. */
static void most_columns(void **state)
{
    const char *names[ECT_TABLE_COLUMNS], *low[ECT_TABLE_COLUMNS], *high[ECT_TABLE_COLUMNS];
    (void)state;
    for (size_t i = 0; i < ECT_TABLE_COLUMNS; i++) {
        names[i] = "ecat.drift";
        low[i] = "2";
        high[i] = "4";
    }
    ect_table_t *table = ect_table_new(1, names, ECT_TABLE_COLUMNS);
    assert_true(ect_table_add(table, 0, low) && ect_table_add(table, 2 * MS, high));
    assert_null(ect_table_refine(table, MS));
    assert_int_equal(table->count, 3);
    for (size_t i = 0; i < ECT_TABLE_COLUMNS; i++)
        assert_string_equal(table->rows[1]->values[i], "3");
    ect_table_free(table);
}

/* A table with neither time nor end, and one that would fill the memory. */
static void tables_without_measure(void **state)
{
    static const char *const name = "ecat.drift";
    static const char *const values[] = {"1", "2"};
    (void)state;
    ect_table_t *table = ect_table_new(1, &name, 1);
    assert_false(ect_table_loop(table));
    assert_null(ect_table_refine(table, 1));
    assert_true(ect_table_add(table, 0, &values[0]));
    assert_false(ect_table_loop(table));
    assert_true(ect_table_add(table, 3600ull * 1000 * MS, &values[1]));
    assert_true(ect_table_loop(table));
    assert_string_equal(ect_table_refine(table, MS),
                        "the table would have more than 1000000 rows: choose a longer 'every'");
    ect_table_free(table);
}

static void wrong_tables(void **state)
{
    static const struct {
        uint16_t slave;
        const char *name, *value, *why;
    } rows[] = {
        {0, "ecat.drift", "1", "there is no slave 0: the chain has 2"},
        {1, "ecat.drift", "1", NULL},
        {2, "ecat.drift", "1", NULL},
        {3, "ecat.drift", "1", "there is no slave 3: the chain has 2"},
        {2, "bogus", "1", "slave 2 has no signal 'bogus'"},
        {1, "ecat.latch0", "2", "ecat.latch0 takes 0..1"},
        {1, "ecat.state", "2", "it can be read and watched, not set"},
        {1, "ecat.state", "", NULL},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_table_t *table = ect_table_new(rows[i].slave, &rows[i].name, 1);
        assert_true(ect_table_add(table, 0, &rows[i].value));
        if (ect_table_check(table, r->w.chain, r->message) != !rows[i].why ||
            (rows[i].why && !strstr(r->message, rows[i].why)))
            fail_msg("%s=%s: got '%s'", rows[i].name, rows[i].value, r->message);
        ect_table_free(table);
    }
}

static void wrong_names(void **state)
{
    static const struct {
        const char *line, *why;
    } rows[] = {
        {"set bogus=1", "slave 1 has no signal 'bogus'"},
        {"set 2:bogus=1", "slave 2 has no signal 'bogus'"},
        {"set ecat.latch0=2", "ecat.latch0 takes 0..1"},
        {"set ecat.state=2", "it can be read and watched, not set"},
        {"expect bogus=1", "no signal 'bogus'"},
        {"set 3:ecat.latch0=1", "there is no slave 3"},
        {"expect ecat.state=1 slave 3", "there is no slave 3"},
        {"at slave 3 OP drop", "there is no slave 3"},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        const size_t before = i % 2;
        r->s = (ect_scenario_t){.seed = 1};
        if (before > 0)
            read_line(r, "drop 0%");
        read_line(r, rows[i / 2].line);
        if (ect_scenario_check(&r->s, r->w.chain, r->message) != &r->s.steps[before] ||
            !strstr(r->message, rows[i / 2].why))
            fail_msg("'%s': expected '...%s...', got '%s'", rows[i / 2].line, rows[i / 2].why, r->message);
    }
}

/* --- expectations ------------------------------------------------------------------------------------------------- */

/* Slave 2 is in PREOP from 100 ms to 200 ms. */
static void expectations(void **state)
{
    static const struct {
        const char *line;
        bool met;
        const char *why;
    } rows[] = {
        {"expect 2:ecat.state=1", true, ""},
        {"expect 2:ecat.state=2", false, "ecat.state is 1"},
        {"expect ecat.run=off slave 2", true, ""},
        {"expect 2:ecat.run!=off", false, "ecat.run is off"},
        {"at 150ms expect 2:ecat.state>1", true, ""},
        {"at 150ms expect 2:ecat.state<2", false, "ecat.state is 2"},
        {"expect 2:ecat.state=2 within 101ms", true, ""},
        {"expect 2:ecat.state=2 within 99ms", false, "ecat.state is 1"},
        {"expect 2:ecat.state=4 within 250ms", false, "ecat.state is 1"},
        {"expect 2:ecat.state=1 for 99ms", true, ""},
        {"expect 2:ecat.state=1 for 101ms", false, "ecat.state is 2"},
        {"expect 2:ecat.state=2 while in PREOP", true, ""},
        {"expect 2:ecat.state=2 while in INIT", false, "ecat.state is 1"},
        {"at slave 2 PREOP expect 2:ecat.state=1 within 101ms", true, ""},
        {"at slave 2 PREOP expect 2:ecat.state=1 within 99ms", false, "ecat.state is 2"},
        {"at slave 2 OP expect 2:ecat.state=8", false, "the run ended before its milestone"},
        {"expect 2:ecat.state=4 within 10s", false, "the run ended before"},
        {"at 150ms expect 2:ecat.state=2 within 1 cycles", true, ""},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        teardown(state);
        setup(state);
        r = *state;
        START(r, rows[i].line);
        advance(r, 100 * MS);
        assert_int_equal(wire_al(&r->w, 1, 2, NULL), 2);
        advance(r, 50 * MS);
        cycle(r);
        advance(r, 50 * MS);
        assert_int_equal(wire_al(&r->w, 1, 1, NULL), 1);
        advance(r, 100 * MS);
        ect_verdict_t verdict = ect_scenario_end(&r->s);
        const ect_scenario_step_t *step = &r->s.steps[0];
        if (verdict.all != 1 || verdict.met != rows[i].met || verdict.failed == verdict.met || r->judged != 1 ||
            step->met != rows[i].met || strcmp(step->why, rows[i].why) != 0)
            fail_msg("'%s': met %d, '%s'", rows[i].line, step->met, step->why);
    }
}

static void expectations_at_the_end(void **state)
{
    static const char ended[] = "the run ended before";
    static const struct {
        bool over, met;
        const char *why;
    } rows[] = {{true, true, ""},
                {false, false, ended},
                {true, false, "ecat.state is 1"},
                {false, false, "the run ended before its milestone"},
                {false, false, ended}};
    rig_t *r = *state;
    START(r, "expect 2:ecat.state=1", "expect 2:ecat.state=4 within 10s", "expect 2:ecat.state=2",
          "at slave 2 OP expect 2:ecat.state=8", "expect 2:ecat.state=8 within 20s");
    advance(r, 10 * MS);
    assert_int_equal(r->s.verdict.met + r->s.verdict.failed, 2);
    const ect_verdict_t verdict = ect_scenario_end(&r->s);
    assert_int_equal(verdict.all, 5);
    assert_int_equal(verdict.met, 1);
    assert_int_equal(verdict.failed, 4);
    assert_int_equal(r->judged, 5);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(r->s.steps[i].met, rows[i].met);
        assert_string_equal(r->s.steps[i].why, rows[i].why);
    }
}

/* --- refusals while it runs --------------------------------------------------------------------------------------- */

static const ect_signal_t levels[] = {ECT_SIGNAL(testdev_t, array[0], "level", U16, WRITE, 0, 1000, NULL, "")};
static const ect_signal_group_t level_group = {.signal_count = 1, .signals = levels};

static const char *refuse_7(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                            uint64_t now_ns)
{
    (void)instance;
    (void)signal;
    (void)number;
    (void)now_ns;
    return *(const uint16_t *)value == 7 ? "is never 7" : NULL;
}

static const ect_plant_t never_7 = {.signal_groups = &level_group, .signal_group_count = 1, .signal_write = refuse_7};

#define ABORTS_4                                                                                                       \
    "abort 0x3000 0x08000020 slave 1", "abort 0x3000 0x08000020 slave 1", "abort 0x3000 0x08000020 slave 1",           \
        "abort 0x3000 0x08000020 slave 1"

static void refused_steps(void **state)
{
    static const struct {
        const char *lines[10];
        const char *refused;
        uint16_t level; /* before; at the end the same */
    } rows[] = {
        {{"at 10ms set level=7"}, "at 10ms set level=7: level: is never 7", 5},
        {{"at 10ms set level=8 until 20ms"}, "at 10ms set level=8 until 20ms: level: is never 7", 7},
        {{"at 10ms to PREOP slave 1"},
         "to PREOP slave 1: slave 1: it is in that state already, or below: it can leave its state downwards only",
         5},
        {{ABORTS_4, ABORTS_4, "at the 1st upload of 0x2000 set level=8"},
         "at the 1st upload of 0x2000 set level=8: 8 faults above the wire are set already: 'off' ends them",
         5},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        teardown(state);
        open_rig(state, &testdev, &never_7);
        rig_t *r = *state;
        testdev_of(&r->w, 0)->array[0] = rows[i].level;
        start(r, rows[i].lines);
        advance(r, 50 * MS);
        assert_string_equal(r->refused, rows[i].refused);
        assert_int_equal(testdev_of(&r->w, 0)->array[0], i == 1 ? 8 : rows[i].level);
    }
}

/* The seed of the scenario is that of a share of transfers too. */
static void shares_of_transfers(void **state)
{
    enum { RUNS = 3, DOWNLOADS = 64 };
    static const uint32_t seeds[RUNS] = {7, 7, 8};
    uint64_t refused[RUNS] = {0};
    for (unsigned int run_number = 0; run_number < RUNS; run_number++) {
        teardown(state);
        open_rig(state, &testdev, NULL);
        rig_t *r = *state;
        r->s.seed = seeds[run_number];
        START(r, "abort 0x2000 0x08000020 50% slave 1");
        wire_go(&r->w, 0, 2);
        for (unsigned int n = 0; n < DOWNLOADS; n++) {
            const uint32_t code = wire_sdo_download(&r->w, 0, 0x2000, 0, false, (const uint8_t[4]){1}, 4);
            assert_true(code == 0 || code == 0x08000020);
            refused[run_number] |= (uint64_t)(code != 0) << n;
        }
    }
    assert_true(refused[0] == refused[1] && refused[0] != refused[2]);
    assert_true(refused[0] != 0 && refused[0] != UINT64_MAX);
}

/* Signals of 45, 45 and more characters. */
static void the_most_signals_of_a_line(void **state)
{
    rig_t *r = *state;
    for (unsigned int length = 100; length < 150; length++) {
        char line[200], message[ECT_STEP_MESSAGE];
        ect_step_t step;
        const int used = snprintf(line, sizeof line, "set %043d=1 %043d=1 ", 1, 2);
        memset(line + used, 'n', length - 92);
        strcpy(line + used + length - 92 - 2, "=1");
        for (char *c = line + 4; c < line + used; c++)
            *c = *c == '0' ? 'n' : *c;
        if (ect_step_read(line, NULL, &step, message) != (length < 128))
            fail_msg("%u characters: %s", length, message);
        if (length >= 128)
            assert_non_null(strstr(message, "the signals of a line have at most 127 characters, not 'n"));
        else
            assert_string_equal(step.text, line + 4);
    }
    (void)r;
}

static void printed(void **state)
{
    rig_t *r = *state;
    char text[512];
    read_line(r, "name A slave that stays in INIT");
    r->s.line = 7;
    START(r, "expect 2:ecat.state=1  # a comment", "expect 2:ecat.state=2");
    (void)ect_scenario_print(&r->s.steps[0], text, sizeof text);
    assert_string_equal(text, "line 7: 'expect 2:ecat.state=1' is met");
    r->s.steps[1].line = 0;
    (void)ect_scenario_print(&r->s.steps[1], text, sizeof text);
    assert_string_equal(text, "'expect 2:ecat.state=2' has failed: ecat.state is 1");
    (void)ect_scenario_print_verdict(&r->s, text, sizeof text);
    assert_string_equal(text, "'A slave that stays in INIT': 1 of 2 expectations are met");
}

static void refused_lines(void **state)
{
    static const struct {
        const char *line, *why;
    } rows[] = {
        {"at 5x drop", "expected 'at 2.5s'"},
        {"at the 3rd drop", "expected 'at 2.5s'"},
        {"at the 3rd upload drop", "expected 'at 2.5s'"},
        {"at the third upload of 0x1018 drop", "expected 'at 2.5s'"},
        {"after drop", "expected 'after 100ms'"},
        {"after 10 frames drop", "expected 'after 100ms'"},
        {"while drop", "expected 'while in PREOP'"},
        {"drop while in OP again", "expected 'while in PREOP'"},
        {"drop until", "expected 'until 5s'"},
        {"drop for", "expected 'for 100ms'"},
        {"expect ecat.state=1 within", "expected 'within 200ms'"},
        {"drop for 1s until 5s", "a line has one end"},
        {"drop while in OP at 5s", "'while' is the last milestone"},
        {"at 1s at 2s at 3s at 4s at 5s drop", "at most 4 milestones"},
        {"reset slave 1 until 5s", "need a fault that lasts"},
        {"emergency 0x5530 slave 1 while in OP", "need a fault that lasts"},
        {"set", "expected 'set NAME=VALUE'"},
        {"set ru1.on", "expected 'set NAME=VALUE'"},
        {"set ru1.on>1", "expected 'set NAME=VALUE'"},
        {"set a=1 b=2 for 1s", "expected one signal"},
        {"set a=1 2:b=2", "all signals of a line belong to one slave: write a line for each slave"},
        {"expect", "expected 'expect NAME=VALUE'"},
        {"expect a=1 b=2", "expected one signal"},
        {"expect a<b", "expected 'expect NAME=VALUE'"},
        {"until 5s", "expected drop"},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        r->message[0] = 0;
        if (ect_scenario_read(&r->s, rows[i].line, r->message) || !strstr(r->message, rows[i].why))
            fail_msg("'%s': expected it refused with '...%s...', got '%s'", rows[i].line, rows[i].why, r->message);
    }
    assert_int_equal(r->s.step_count, 0);
}

/* Each number of a line at both ends of its range. */
static void numbers(void **state)
{
    static const struct {
        const char *line;
        bool good;
        uint64_t value; /* of its milestone or its end */
    } rows[] = {
        {"drop after 0 cycles", false, 0},
        {"drop after 1 cycle", true, 1},
        {"drop after 1000000000 cycles", true, 1000000000},
        {"drop after 1000000001 cycles", false, 0},
        {"drop within 1 cycles", true, 1},
        {"drop for 0 cycles", false, 0},
        {"drop at 2.5s", true, 2500 * MS},
        {"drop at 3ms", true, 3 * MS},
        {"drop at 7us", true, 7000},
        {"drop at 0.0004us", true, 0},
        {"drop at 0.0006us", true, 1},
        {"drop at 1.0006us", true, 1001},
        {"drop for 0s", true, 0},
        {"drop for 999999999s", true, 999999999ull * 1000 * MS},
        {"drop for 1000000000s", false, 0},
        {"drop for 999999999000ms", true, 999999999000 * MS},
        {"drop for 1000000000000ms", false, 0},
        {"drop for 999999999000000us", true, 999999999000000 * 1000},
        {"drop for 1000000000000000us", false, 0},
        {"drop for -1us", false, 0},
        {"drop for s", false, 0},
        {"drop for 5", false, 0},
        {"drop at frame 0", true, 0},
        {"drop at the 0th upload of 0x1018", false, 0},
        {"drop at the 1000000000th upload of 0x1018", true, 1000000000},
        {"drop at the 1000000001st upload of 0x1018", false, 0},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_step_t step;
        const bool good = ect_step_read(rows[i].line, NULL, &step, r->message);
        const uint64_t value = !good ? 0 : step.when_count > 0 ? step.when[0].value : step.until.value;
        if (good != rows[i].good || value != rows[i].value)
            fail_msg("'%s': expected %s with %llu, got %s with %llu", rows[i].line,
                     rows[i].good ? "a step" : "a refusal", (unsigned long long)rows[i].value,
                     good ? "a step" : "a refusal", (unsigned long long)value);
    }
}

/* A fault that is over at once has no end. */
static void faults_with_an_end(void **state)
{
    static const struct {
        const char *fault;
        bool lasts;
    } rows[] = {
        {"drop", true},
        {"damage wire 1", true},
        {"delay 1us", true},
        {"duplicate", true},
        {"reorder", true},
        {"truncate 1", true},
        {"corrupt", true},
        {"counter 1", true},
        {"off", false},
        {"hang slave 1", true},
        {"resume slave 1", false},
        {"reset slave 1", false},
        {"identity slave 1", false},
        {"lose-event slave 1", false},
        {"eeprom busy slave 1", true},
        {"eeprom nack slave 1", true},
        {"eeprom flip 1 slave 1", true},
        {"eeprom ok slave 1", false},
        {"clock 1ns slave 1", false},
        {"pdi-error slave 1", false},
        {"to PREOP slave 1", false},
        {"init slave 1", false},
        {"emergency 0x5530 slave 1", false},
        {"al 0x001B slave 1", false},
        {"al refuse 0x001B slave 1", true},
        {"al never slave 1", true},
        {"abort 0x1C12 0x06040043 slave 1", true},
        {"mail toggle slave 1", true},
        {"mail lost slave 1", true},
        {"pdo-size 1 slave 1", true},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char line[ECT_STEP_LINE], want[ECT_STEP_MESSAGE] = "", message[ECT_STEP_MESSAGE] = "";
        ect_step_t step;
        snprintf(line, sizeof line, "%s for 1s", rows[i].fault);
        if (!rows[i].lasts)
            snprintf(want, sizeof want, "'while', 'until' and 'for' need a fault that lasts, not '%s'", rows[i].fault);
        if (ect_step_read(line, NULL, &step, message) != rows[i].lasts || strcmp(message, want) != 0)
            fail_msg("'%s': expected '%s', got '%s'", line, want, message);
        assert_true(ect_step_read(rows[i].fault, NULL, &step, r->message));
    }
}

enum { STEP_TEXT = 768 };

/* The meaning of a step, each member of it. */
static void describe(const ect_step_t *step, char *text)
{
    char fault[ECT_FAULT_TEXT] = "";
    int used = snprintf(text, STEP_TEXT, "%u milestones%s%s, action %d of slave %u '%s'", step->when_count,
                        step->repeats ? ", repeats" : "", step->holds ? ", holds" : "", (int)step->action, step->slave,
                        step->text);
    for (unsigned int i = 0; i <= ECT_STEP_MILESTONES; i++) {
        const ect_milestone_t *m = i < ECT_STEP_MILESTONES ? &step->when[i] : &step->until;
        used += snprintf(text + used, STEP_TEXT - (size_t)used, "; %s %d %llu slave %u, SDO %d %04x %d:%u %d",
                         m == &step->until ? "until" : "when", (int)m->kind, (unsigned long long)m->value, m->slave,
                         m->object.named, m->object.index, m->object.has_sub, m->object.sub, (int)m->object.transfer);
    }
    if (step->action == ECT_ACTION_FAULT)
        ect_fault_print(&step->fault, fault);
    used += snprintf(text + used, STEP_TEXT - (size_t)used, "; fault '%s'", fault);
    assert_true(used < STEP_TEXT);
}

static void any_order(void **state)
{
    static const char *const rows[][2] = {
        {"at 2.5s hang slave 2", "hang slave 2 at 2.5s"},
        {"drop 5% while in PREOP", "while in PREOP drop 5%"},
        {"drop 5% while slave 1 in PREOP", "while PREOP drop 5%"},
        {"hang slave 2 until slave 2 in OP again", "until OP again slave 2 hang"},
        {"expect 2:ecat.state=4 within 200ms", "within 0.2s expect ecat.state=4 slave 2"},
        {"set 2:a=1 b=2 at 1s", "at 1000ms set slave 2 a=1 b=2"},
        {"hang slave arm until 5s", "hang slave 2 until 5s"},
        {"off at slave arm OP", "at slave 2 in OP off"},
        {"hang slave 2 at PREOP at SAFEOP at OP", "at slave 2 PREOP at slave 2 SAFEOP at slave 2 OP hang slave 2"},
        {"off at PREOP at SAFEOP", "off at slave 1 PREOP at slave 1 SAFEOP"},
        {"drop wire 2 while OP", "drop wire 2 while slave 1 in OP"},
        {"expect 2:a=1 at the 2nd upload of 0x1018 for 1s", "at the 2nd upload of 1018h for 1000ms expect slave 2 a=1"},
        {"set arm.a=1 arm:b=2 at slave arm OP", "set 2:a=1 b=2 at slave 2 OP"},
        {"expect arm.ecat.state=4", "expect ecat.state=4 slave arm"},
        {"expect arm.ecat.state=4", "expect slave 2 ecat.state=4"},
    };
    rig_t *r = *state;
    ect_names_t *names = ect_names_new(2);
    assert_true(names && ect_names_add(names, 1, "arm"));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char meaning[2][STEP_TEXT];
        for (unsigned int n = 0; n < 2; n++) {
            ect_step_t step;
            if (!ect_step_read(rows[i][n], names, &step, r->message))
                fail_msg("'%s': %s", rows[i][n], r->message);
            describe(&step, meaning[n]);
        }
        if (strcmp(meaning[0], meaning[1]) != 0)
            fail_msg("'%s' and '%s' differ:\n%s\n%s", rows[i][0], rows[i][1], meaning[0], meaning[1]);
    }
    ect_names_free(names);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("a step waits for frames with process data", cycles),
        TEST("cycles are counted from the previous milestone on", cycles_after_a_milestone),
        TEST("frames with a logical address are those with process data", frames_with_process_data),
        TEST("milestones are reached one after the other", one_after_the_other),
        TEST("a step waits for SDO transfers of the slave that it names", transfers),
        TEST("a step without a slave waits for SDO transfers of any", transfers_of_any),
        TEST("faults end after a time, at a time, in a state, and come again with it", ends),
        TEST("a saved script has faults that last and steps that are not over", is_left),
        TEST("a script of 256 steps", the_most_steps),
        TEST("a line of 255 characters is left whole", the_longest_line_is_left),
        TEST("a slave hangs for a time", hangs_for_a_time),
        TEST("CF-055: an EEPROM is busy, does not reply, or has a wrong bit for a time", eeprom_for_a_time),
        TEST("a step sets signals; their end sets the value from before", sets),
        TEST("the end of a step sets a text with spaces, of any length, again", sets_a_text_again),
        TEST("a signal that is set takes effect for the first frame from its time on", in_its_cycle),
        TEST("a row of a table takes effect for the first frame from its time on", table_in_its_cycle),
        TEST("rows of a table that are late are played one time after the other", late_table),
        TEST("signals of the bus show line, step and counts of a script", progress),
        TEST("the verdict is running, met, failed or over", verdicts_as_a_signal),
        TEST("a table begins again at the time of its last row; rows between rows are on the line", loops_and_lines),
        TEST("a condition compares numbers as numbers, other values as texts", conditions),
        TEST("a row between two cells has a number between their numbers", between_two_cells),
        TEST("a table may have the most columns, and a value of each between two rows", most_columns),
        TEST("a loop without a time, and more than a million rows, are refused", tables_without_measure),
        TEST("signals, values and slaves of a table are checked before the run", wrong_tables),
        TEST("signals, values and slaves that there are not are found before the run", wrong_names),
        TEST("expectations are met or failed", expectations),
        TEST("a row that its twin refuses is reported with the reason, and later rows are played", refused_row),
        TEST("a step that its twin refuses is reported with the reason", refused_steps),
        TEST("a share of transfers follows from the seed of the scenario", shares_of_transfers),
        TEST("the signals of a line have at most 127 characters", the_most_signals_of_a_line),
        TEST("at the end of a run each expectation that is not judged has failed", expectations_at_the_end),
        TEST("each expectation and the verdict have one line", printed),
        TEST("a line that makes no sense is refused with the expected words", refused_lines),
        TEST("numbers of a line are taken within their ranges", numbers),
        TEST("a fault with an end is one that lasts", faults_with_an_end),
        TEST("the words of a line may have any order", any_order),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
