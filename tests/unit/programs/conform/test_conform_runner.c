/* SPDX-License-Identifier: MIT */
/* The runner of cases: needs, the known state, the order in which changes are undone, the canary; and the catalogue. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "conform_support.h"

static unsigned int ran;

static void passes(cf_t *c)
{
    (void)c;
    ran++;
}

/* --- needs -------------------------------------------------------------------------------------------------------- */

static void needs(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    ran = 0;
    start_run(&run);
    assert_int_equal(run_one(&run, passes, CF_MAILBOX | CF_DC, &result), CF_SKIPPED);
    assert_string_equal(result.reason, "the slave has no mailbox");
    assert_int_equal(run_one(&run, passes, CF_WRITES_SII, &result), CF_SKIPPED);
    assert_int_equal(run_one(&run, passes, CF_ESI, &result), CF_SKIPPED);
    assert_int_equal(ran, 0);
    assert_int_equal(frames_sent, 0);
    run.c.destructive = true;
    assert_int_equal(run_one(&run, passes, CF_WRITES_SII | CF_APPLICATION | CF_REAL_TIME | CF_FUZZ, &result), CF_PASS);
    run.c.emulated = true;
    assert_int_equal(run_one(&run, passes, CF_REAL_TIME, &result), CF_SKIPPED);
    assert_int_equal(ran, 1);
    for (unsigned int n = 0; n < CF_NEEDS_COUNT; n++) { /* emulation gives a slave nothing */
        const uint32_t need = 1u << n;
        const bool given =
            (need & (CF_APPLICATION | CF_WRITES_SII | CF_ON_REQUEST)) != 0 || need == CF_FUZZ || need == CF_STRESS;
        if (!given && run_one(&run, passes, need, &result) != CF_SKIPPED)
            fail_msg("need 0x%X is not missing", (unsigned int)need);
    }
    end_run(&run);
}

/* --- changes ------------------------------------------------------------------------------------------------------ */

static uint16_t written[8];
static uint8_t states[8]; /* AL status at each write of the EEPROM, and at each download */
static unsigned int writes;

/* The EEPROM: a write command (0x0201) at 0x0502 puts the data at 0x0508 into a word. */
static bool note_writes(cf_datagram_t *d)
{
    const uint16_t ado = (uint16_t)(d->address >> 16);
    const uint8_t *data = d->data;
    if (d->command == CF_FPWR && ado == ECT_REG_SII_CONTROL && d->length == 6 && ect_load_le16(data) == 0x0201 &&
        writes < 8) {
        states[writes] = memory[ECT_REG_AL_STATUS];
        written[writes++] = (uint16_t)(ect_load_le16(data + 2) << 8 | memory[ECT_REG_SII_DATA]);
        ect_store_le16(d->data, 0);
    }
    return true;
}

static void change(cf_t *c, uint16_t word, uint8_t old)
{
    *cf_new_undo(c) = (cf_undo_t){.what = CF_UNDO_SII, .index = word, .size = 2, .data = {old, 0}};
}

static void changes_and_fails(cf_t *c)
{
    change(c, 1, 0x11);
    change(c, 2, 0x22);
    change(c, 1, 0x33);
    cf_fail(c, "in the middle");
}

static void undo_order(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    on_datagram = note_writes;
    writes = 0;
    assert_int_equal(run_one(&run, changes_and_fails, 0, &result), CF_FAIL);
    assert_string_equal(result.reason, "in the middle");
    assert_int_equal(writes, 3); /* the newest change first, so that the oldest value stays */
    assert_int_equal(written[0], 0x0133);
    assert_int_equal(written[1], 0x0222);
    assert_int_equal(written[2], 0x0111);
    assert_int_equal(run.engine.undo_count, 0);
    end_run(&run);
}

static void changes_in_preop(cf_t *c)
{
    cf_put16(c, ECT_REG_AL_CONTROL, CF_PREOP);
    cf_expect(c, "AL status", CF_PREOP, memory[ECT_REG_AL_STATUS]);
    change(c, 1, 0x11);
}

static void eeprom_in_init(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    on_datagram = note_writes;
    writes = 0;
    assert_int_equal(run_one(&run, changes_in_preop, 0, &result), CF_PASS);
    assert_string_equal(result.reason, "");
    assert_int_equal(writes, 1);
    assert_int_equal(states[0], CF_INIT);
    end_run(&run);
}

/* --- a slave with one object, 2000h, of two bytes ----------------------------------------------------------------- */

static uint16_t object;
static uint32_t refusal; /* abort code of downloads; 0: none */
static unsigned int downloads;
static uint8_t uploaded[3]; /* index and sub-index of the last upload */

static bool takes_files;
static uint8_t file_state; /* AL status at the last request of FoE */

static void reply_to(const uint8_t *mail)
{
    uint8_t *reply = memory + 0x1080;
    memset(reply, 0, 128);
    if ((mail[5] & 0x0F) == CF_MBX_FOE) {
        file_state = memory[ECT_REG_AL_STATUS];
        ect_store_le16(reply, 6);
        reply[5] = 0x10 | CF_MBX_FOE;
        reply[6] = takes_files ? CF_FOE_ACK : CF_FOE_ERROR;
        ect_store_le32(reply + 8, !takes_files ? 0x8002 : mail[6] == CF_FOE_DATA ? ect_load_le32(mail + 8) : 0);
        memory[CF_SM(1) + ECT_SM_STATUS] = ECT_SM_STATUS_FULL;
        return;
    }
    ect_store_le16(reply, 10);
    reply[5] = 0x13;
    ect_store_le16(reply + 6, CF_COE_RESPONSE << 12);
    memcpy(reply + 9, mail + 9, 3);
    if (mail[8] == 0x40) {
        reply[8] = 0x4B;
        memcpy(uploaded, mail + 9, sizeof uploaded);
        ect_store_le16(reply + 12, object);
    } else if (refusal != 0) {
        ect_store_le16(reply + 6, CF_COE_REQUEST << 12);
        reply[8] = 0x80;
        ect_store_le32(reply + 12, refusal);
    } else {
        reply[8] = 0x60;
        object = ect_load_le16(mail + 12);
        states[downloads % 8] = memory[ECT_REG_AL_STATUS];
        written[downloads++ % 8] = object;
    }
    memory[CF_SM(1) + ECT_SM_STATUS] = ECT_SM_STATUS_FULL;
}

static bool has_object(cf_datagram_t *d)
{
    const uint16_t ado = (uint16_t)(d->address >> 16);
    if (d->command == CF_FPWR && ado == 0x1000)
        reply_to(d->data);
    else if (d->command == CF_FPRD && ado == 0x1080)
        memory[CF_SM(1) + ECT_SM_STATUS] = 0;
    return true;
}

static void start_with_object(cf_run_t *run)
{
    start_run(run);
    run->c.facts.has |= CF_MAILBOX | CF_COE;
    run->c.mailbox = (cf_mailbox_t){0x1000, 128, 0x1080, 128};
    on_datagram = has_object;
    object = 0x1111;
    refusal = 0;
    downloads = 0;
    takes_files = false;
}

static void put(cf_t *c, uint16_t value)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, value);
    cf_expect(c, "abort code", refusal, cf_change(c, 0x2000, 0, bytes, sizeof bytes));
}

static void changes_object(cf_t *c)
{
    cf_go(c, CF_PREOP);
    put(c, 0x2222);
    put(c, 0x3333);
    put(c, 0x4444);
}

static void undo_objects(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    assert_int_equal(run_one(&run, changes_object, CF_COE, &result), CF_PASS);
    assert_int_equal(downloads, 6); /* three changes, and back in the reverse order */
    assert_int_equal(written[3], 0x3333);
    assert_int_equal(written[4], 0x2222);
    assert_int_equal(written[5], 0x1111);
    assert_int_equal(object, 0x1111);
    for (unsigned int i = 0; i < downloads; i++)
        assert_int_equal(states[i], CF_PREOP); /* restored from INIT on, where a mailbox is off */
    assert_int_equal(memory[ECT_REG_AL_STATUS], CF_INIT);
    end_run(&run);
}

static void changes_file(cf_t *c)
{
    cf_go(c, CF_PREOP);
    cf_keep_file(c, "abc", 3);
}

static void file_taken_back(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    takes_files = true;
    run.c.file = "parameters";
    assert_int_equal(run_one(&run, changes_file, CF_COE, &result), CF_PASS);
    assert_string_equal(result.reason, "");
    assert_int_equal(file_state, CF_PREOP);
    end_run(&run);
}

/* A file that the slave refuses to take back fails the case. */
static void undo_file(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    run.c.file = "parameters";
    assert_int_equal(run_one(&run, changes_file, CF_COE, &result), CF_FAIL);
    assert_string_equal(result.reason, "the slave cannot be restored: restoring the file: error 0x00008002");
    end_run(&run);
}

static void changes_once(cf_t *c)
{
    cf_go(c, CF_PREOP);
    put(c, 0x2222);
    refusal = 0x08000022;
}

static void changes_nothing(cf_t *c)
{
    cf_go(c, CF_PREOP);
    refusal = 0x06010002;
    put(c, 0x2222);
}

/* An old value that the slave refuses fails the case; a change that it refuses is none. */
static void undo_refused(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    assert_int_equal(run_one(&run, changes_once, CF_COE, &result), CF_FAIL);
    assert_string_equal(result.reason, "the slave cannot be restored: restoring 2000h:00: abort 0x08000022");
    refusal = 0;
    assert_int_equal(run_one(&run, changes_nothing, CF_COE, &result), CF_PASS);
    assert_int_equal(run.engine.undo_count, 0);
    end_run(&run);
}

/* Kept values are restored after a failure too, in PREOP and in the reverse order. */
static void put_number_back(cf_t *c, const uint8_t *data, size_t size)
{
    cf_expect_range(c, "bytes that were kept", 2, 2, size);
    cf_expect(c, "AL status while a value is restored", CF_PREOP, memory[ECT_REG_AL_STATUS]);
    written[downloads++ % 8] = ect_load_le16(data);
}

static void keeps_and_fails(cf_t *c)
{
    cf_go(c, CF_PREOP);
    cf_keep(c, put_number_back, "\x11\x11", 2);
    cf_keep(c, put_number_back, "\x22\x22", 2);
    cf_fail(c, "midway");
}

static void undo_kept(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    assert_int_equal(run_one(&run, keeps_and_fails, CF_COE, &result), CF_FAIL);
    assert_string_equal(result.reason, "midway");
    assert_int_equal(downloads, 2);
    assert_int_equal(written[0], 0x2222);
    assert_int_equal(written[1], 0x1111);
    end_run(&run);
}

/* The canary of a slave with CoE is an upload. */
static void starts_in_init(cf_t *c)
{
    cf_expect(c, "AL status at the start of a case", CF_INIT, memory[ECT_REG_AL_STATUS]);
    cf_expect_range(c, "mail counter at the start of a case", 0, 0, c->mail_counter);
}

static void canary_leaves_init(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(run_one(&run, starts_in_init, 0, &result), CF_PASS);
        assert_string_equal(result.reason, "");
    }
    end_run(&run);
}

static void canary_reads_the_vendor(void **state)
{
    static const uint8_t vendor[] = {0x18, 0x10, 1};
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    memset(uploaded, 0, sizeof uploaded);
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    assert_memory_equal(uploaded, vendor, sizeof vendor);
    end_run(&run);
}

static void silent_mailbox(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    on_datagram = NULL; /* INIT and PREOP still work, but no mail is replied to */
    assert_int_equal(run_one(&run, passes, 0, &result), CF_UNJUDGED);
    assert_string_equal(result.reason,
                        "not judged since CF-900: a reply of mailbox type 3: expected within 2000 ms, got none");
    end_run(&run);
}

/* Without CoE it is a mail of an unknown protocol, and its error. */
static unsigned int errors_sent;

static bool replies_error(cf_datagram_t *d)
{
    const uint16_t ado = (uint16_t)(d->address >> 16);
    if (d->command == CF_FPWR && ado == 0x1000) {
        static const uint8_t error[] = {4, 0, 0, 0, 0, 0x10, 1, 0, 2, 0};
        memcpy(memory + 0x1080, error, sizeof error);
        memory[CF_SM(1) + ECT_SM_STATUS] = ECT_SM_STATUS_FULL;
        errors_sent++;
    } else if (d->command == CF_FPRD && ado == 0x1080) {
        memory[CF_SM(1) + ECT_SM_STATUS] = 0;
    }
    return true;
}

static void canary_without_coe(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_with_object(&run);
    run.c.facts.has &= ~(uint32_t)CF_COE;
    on_datagram = replies_error;
    errors_sent = 0;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    assert_int_equal(errors_sent, 1);
    assert_int_equal(run.canary, CF_CANARY_ABLE);
    on_datagram = NULL;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_UNJUDGED);
    end_run(&run);
}

/* --- evidence ----------------------------------------------------------------------------------------------------- */

static uint32_t warned_at;

static void warns_early(cf_t *c)
{
    cf_step(c, "a step");
    (void)cf_get8(c, 0);
    warned_at = cf_record_frame();
    cf_warn(c, "unusual");
    (void)cf_get8(c, 0);
}

static void fails_plainly(cf_t *c)
{
    (void)cf_get8(c, 0);
    cf_fail(c, "plainly");
}

/* Runs a function as a case and keeps its evidence. */
static cf_result_t run_whole(cf_run_t *run, void (*function)(cf_t *c))
{
    static cf_case_t entry = {"CF-900", "A case of a test", 'R', 0, 0, NULL};
    static const cf_section_t section = {'Z', "Tests", &entry, 1};
    cf_result_t result;
    entry.run = function;
    cf_run_case(run, &section, &entry, &result);
    return result;
}

static void frames_of_verdicts(void **state)
{
    cf_run_t run;
    (void)state;
    start_run(&run);
    cf_result_t warned = run_whole(&run, warns_early);
    assert_int_equal(warned.verdict, CF_WARN);
    assert_int_equal(warned.frame, warned_at);
    assert_int_equal(warned.evidence.first_frame, 1);
    assert_int_equal(warned.evidence.last_frame, warned_at + 1);
    assert_string_equal(warned.step, "a step");
    cf_result_t failed = run_whole(&run, fails_plainly);
    assert_string_equal(failed.reason, "plainly");
    assert_string_equal(failed.step, ""); /* not that of the case before */
    assert_true(failed.evidence.first_frame > warned.evidence.last_frame);
    assert_int_equal(failed.frame, failed.evidence.last_frame);
    cf_result_t passed = run_whole(&run, passes);
    assert_string_equal(passed.reason, "");
    assert_true(passed.evidence.first_frame > failed.evidence.last_frame);
    assert_true(passed.evidence.count <= 24);
    cf_evidence_free(&warned.evidence);
    cf_evidence_free(&failed.evidence);
    cf_evidence_free(&passed.evidence);
    end_run(&run);
}

static void many_frames(cf_t *c)
{
    for (unsigned int i = 0; i < 200; i++)
        (void)cf_get8(c, (uint16_t)(i % 2 == 0 ? 0 : 4)); /* in turn, so that no poll is folded */
}

static void many_frames_and_a_failure(cf_t *c)
{
    many_frames(c);
    cf_fail(c, "plainly");
}

static void many_frames_and_a_warning(cf_t *c)
{
    many_frames(c);
    cf_warn(c, "unusual");
}

/* A pass keeps its last items, another verdict enough of them to find the cause. */
static void items_kept(void **state)
{
    static const struct {
        void (*function)(cf_t *c);
        cf_verdict_t verdict;
        size_t count;
    } rows[] = {{many_frames, CF_PASS, 24},
                {many_frames_and_a_warning, CF_WARN, 120},
                {many_frames_and_a_failure, CF_FAIL, 120}};
    cf_run_t run;
    (void)state;
    start_run(&run);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        cf_result_t result = run_whole(&run, rows[i].function);
        assert_int_equal(result.verdict, rows[i].verdict);
        assert_int_equal(result.evidence.count, rows[i].count);
        cf_evidence_free(&result.evidence);
        assert_null(result.evidence.items);
        assert_int_equal(result.evidence.count, 0);
    }
    end_run(&run);
}

/* @return the place behind the text; the test fails if it is not between from and end */
static const char *behind(const char *from, const char *end, const char *text)
{
    const size_t length = strlen(text);
    for (; from + length <= end; from++) {
        if (memcmp(from, text, length) == 0)
            return from + length;
    }
    fail_msg("the capture has no '%s', or not there", text);
    return end;
}

static void comments_of_the_capture(void **state)
{
    char *bytes = NULL;
    size_t size = 0;
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    cf_record_close();
    FILE *file = open_memstream(&bytes, &size);
    cf_record_open(file);
    assert_int_equal(run_one(&run, fails_plainly, 0, &result), CF_FAIL);
    end_run(&run);
    fclose(file);
    const char *end = bytes + size;
    (void)behind(behind(bytes, end, "CF-900 A case of a test"), end, "CF-900 afterwards: back to INIT");
    free(bytes);
}

/* --- limits ------------------------------------------------------------------------------------------------------- */

static void waits_for_ever(cf_t *c)
{
    cf_extend(c, 5);
    cf_check_time(c);
    for (;;)
        cf_sleep_ms(c, 1);
}

static void time_limit(void **state)
{
    const cf_case_t entry = {"CF-900", "A case of a test", 'R', 0, 20, waits_for_ever};
    const cf_section_t section = {'Z', "Tests", &entry, 1};
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    cf_run_case(&run, &section, &entry, &result);
    assert_int_equal(result.verdict, CF_FAIL);
    assert_string_equal(result.reason, "time limit: not finished within 25 ms");
    assert_in_range(result.duration_ns, 25000000, UINT64_C(60000000000));
    cf_evidence_free(&result.evidence);
    end_run(&run);
}

static unsigned int checks, depth;

static void check_memory(cf_t *c, void *ctx)
{
    checks++;
    depth++;
    *(unsigned int *)ctx += 1;
    cf_expect_range(c, "depth of the calls", 1, 1, depth);
    if (checks < 3)
        cf_poll_pause(c); /* waits in turn: not called again */
    memory[0x0F00] = checks >= 5;
    depth--;
}

static void polls(cf_t *c)
{
    unsigned int count = 0;
    uint8_t last;
    checks = depth = 0;
    memory[0x0F00] = 0;
    cf_while_waiting(c, check_memory, &count);
    cf_expect_that(c, cf_wait_bits(c, 0x0F00, 1, 1, 1000, &last) && last == 1, "waited in vain");
    cf_expect_range(c, "calls", 5, 5, count);
    cf_while_waiting(c, NULL, NULL);
    cf_expect_that(c, !cf_wait_bits(c, 0x0F00, 2, 2, 1, NULL), "came");
    cf_expect_range(c, "calls", 5, 5, checks);
}

static void waiting(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, polls, 0, &result), CF_PASS);
    assert_string_equal(result.reason, "");
    end_run(&run);
}

static void waits_only(cf_t *c)
{
    cf_expect_that(c, !cf_wait_bits(c, 0x0F00, 2, 2, 1, NULL), "came");
}

static void leaves_a_function(cf_t *c)
{
    static unsigned int count;
    cf_while_waiting(c, check_memory, &count);
}

static void function_of_another_case(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, leaves_a_function, 0, &result), CF_PASS);
    checks = 0;
    assert_int_equal(run_one(&run, waits_only, 0, &result), CF_PASS);
    assert_int_equal(checks, 0);
    end_run(&run);
}

static void interrupts(cf_t *c)
{
    cf_put16(c, ECT_REG_AL_CONTROL, CF_PREOP);
    cf_interrupted = 1;
    cf_get8(c, 0);
}

/* Ctrl-C leaves the case and still restores the slave. */
static void interrupted(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, interrupts, 0, &result), CF_INTERRUPTED);
    assert_string_equal(result.reason, "interrupted");
    assert_int_equal(memory[ECT_REG_AL_STATUS], CF_INIT);
    cf_interrupted = 0;
    end_run(&run);
}

static bool interrupts_run(cf_datagram_t *d)
{
    (void)d;
    cf_interrupted = 1;
    return true;
}

/* Ctrl-C also leaves the canary, and the preparation of a slave that is judged case by case. */
static void interrupted_preparation(void **state)
{
    static const struct {
        cf_canary_t canary;
        const char *since;
    } rows[] = {{CF_CANARY_ABLE, NULL}, {CF_CANARY_ABLE, "CF-016"}, {CF_CANARY_UNABLE, NULL}};
    cf_run_t run;
    cf_result_t result;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        start_run(&run);
        run.canary = rows[i].canary;
        run.since = rows[i].since;
        on_datagram = interrupts_run;
        ran = 0;
        cf_verdict_t verdict = run_one(&run, passes, 0, &result);
        cf_interrupted = 0;
        assert_int_equal(verdict, CF_INTERRUPTED);
        assert_int_equal(ran, 0);
        end_run(&run);
    }
}

static void uses_rooms(cf_t *c)
{
    uint8_t *first = cf_room(c, 0), *second = cf_room(c, 1);
    first[0] = 1;
    first[CF_FILE_MOST - 1] = 2;
    second[CF_FILE_MOST - 1] = 3;
    cf_expect_that(c, first == cf_room(c, 0) && first[0] == 1 && first != second, "another room");
}

static void measures_too_much(cf_t *c)
{
    static const char names[CF_SERIES_MOST + 1][3] = {"a", "b", "c", "d", "e", "f", "g", "h", "i",
                                                      "j", "k", "l", "m", "n", "o", "p", "q"};
    for (unsigned int i = 0; i < CF_VALUES_MOST + 5; i++)
        cf_measure(c, names[0], i);
    for (unsigned int i = 0; i <= CF_SERIES_MOST; i++)
        cf_measure(c, names[i], 1);
}

static size_t kept;

static void put_nothing_back(cf_t *c, const uint8_t *data, size_t size)
{
    (void)c;
    (void)data;
    (void)size;
}

static void keeps_much(cf_t *c)
{
    static const uint8_t data[CF_CHANGE_MOST + 1];
    cf_keep(c, put_nothing_back, data, kept);
}

static void longest_value_kept(void **state)
{
    char reason[100];
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    kept = CF_CHANGE_MOST;
    assert_int_equal(run_one(&run, keeps_much, 0, &result), CF_PASS);
    assert_string_equal(result.reason, "");
    kept = CF_CHANGE_MOST + 1;
    assert_int_equal(run_one(&run, keeps_much, 0, &result), CF_FAIL);
    snprintf(reason, sizeof reason, "a value to restore: expected at most %d bytes, got %zu", (int)CF_CHANGE_MOST,
             kept);
    assert_string_equal(result.reason, reason);
    end_run(&run);
}

static void names_a_long_step(cf_t *c)
{
    char text[CF_STEP + 10];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = 0;
    cf_step(c, "%s", text);
}

static void longest_step(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, names_a_long_step, 0, &result), CF_PASS);
    assert_int_equal(strlen(result.step), CF_STEP - 1);
    end_run(&run);
}

static void engine_limits(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, uses_rooms, 0, &result), CF_PASS);
    assert_int_equal(run_one(&run, measures_too_much, 0, &result), CF_FAIL);
    assert_string_equal(result.reason, "more than 16 histograms");
    assert_int_equal(run.engine.series[0].count, CF_VALUES_MOST);
    assert_int_equal(run.engine.series[1].count, 1);
    end_run(&run);
}

static uint64_t deadline_ns;
static uint32_t limit_ms;

static void notes_its_deadline(cf_t *c)
{
    deadline_ns = c->engine->deadline_ns;
    limit_ms = c->engine->limit_ms;
}

static void deadline_of_a_case(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    uint64_t before_ns = cf_now_ns();
    assert_int_equal(run_one(&run, notes_its_deadline, 0, &result), CF_PASS);
    assert_true(limit_ms >= 1000);
    assert_true(deadline_ns >= before_ns + limit_ms * 1000000ull);
    assert_true(deadline_ns <= cf_now_ns() + limit_ms * 1000000ull);
    end_run(&run);
}

/* After its end an engine holds nothing, may end again, and may run again. */
static void engine_ends_twice(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, uses_rooms, 0, &result), CF_PASS);
    for (unsigned int round = 0; round < 2; round++) {
        assert_int_equal(run_one(&run, measures_too_much, 0, &result), CF_FAIL);
        run.engine.undo[0].file = malloc(1);
        run.engine.undo[CF_UNDO_MOST - 1].file = malloc(1);
        run.engine.undo_count = CF_UNDO_MOST;
        cf_engine_free(&run.engine);
        assert_int_equal(run.engine.series_count, 0);
        assert_int_equal(run.engine.undo_count, 0);
        assert_null(run.engine.undo[0].file);
        assert_null(run.engine.undo[CF_UNDO_MOST - 1].file);
        for (size_t i = 0; i < sizeof run.engine.room / sizeof run.engine.room[0]; i++)
            assert_null(run.engine.room[i]);
    }
    end_run(&run);
}

static void changes_too_much(cf_t *c)
{
    for (int i = 0; i <= CF_UNDO_MOST; i++)
        change(c, 1, (uint8_t)i);
}

static void too_many_changes(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    on_datagram = note_writes;
    writes = 0;
    assert_int_equal(run_one(&run, changes_too_much, 0, &result), CF_FAIL);
    assert_string_equal(result.reason, "this case changes more than 64 values");
    end_run(&run);
}

/* --- the canary --------------------------------------------------------------------------------------------------- */

static bool dead;

static bool dies(cf_datagram_t *d)
{
    (void)d;
    return !dead;
}

static void kills(cf_t *c)
{
    cf_step(c, "a step");
    dead = true;
    cf_get8(c, 0);
}

/* Only the slave's software has stopped: it accepts no more requests. */
static bool stuck;

static bool sticks(cf_datagram_t *d)
{
    if (stuck && d->command == CF_FPWR && d->address >> 16 == ECT_REG_AL_CONTROL)
        ((uint8_t *)d->data)[0] = CF_OP;
    return true;
}

static void canary(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    on_datagram = dies;
    dead = false;
    ran = 0;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    assert_false(run.engine.running);
    assert_int_equal(run_one(&run, kills, 0, &result), CF_FAIL);
    run.last = "CF-016";
    for (int i = 0; i < 2; i++) {
        assert_int_equal(run_one(&run, passes, 0, &result), CF_UNJUDGED);
        assert_false(run.engine.running);     /* Ctrl-C has no case to leave */
        assert_string_equal(result.step, ""); /* not that of the case before */
        assert_string_equal(result.reason, "not judged since CF-016: no reply: the frame did not return within 50 ms");
    }
    assert_int_equal(ran, 1);
    dead = false; /* it is back: judged again */
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    assert_null(run.since);
    end_run(&run);
}

/* The command of --power has revived it when a slave without a station address is searched. */
static bool interrupt_then;

static bool revives(cf_datagram_t *d)
{
    if (d->command == CF_APRD && d->address >> 16 == ECT_REG_STATION_ADDRESS) {
        dead = false;
        cf_interrupted = interrupt_then;
        memset(memory + ECT_REG_STATION_ADDRESS, 0, 2);
    }
    return !dead;
}

static void power_cycle(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    run.c.power = "true";
    on_datagram = revives;
    dead = interrupt_then = false;
    ran = 0;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    dead = true;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    assert_string_equal(result.reason, "");
    assert_int_equal(ran, 2);
    dead = interrupt_then = true;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_INTERRUPTED);
    cf_interrupted = 0;
    assert_int_equal(ran, 2);
    dead = true;
    interrupt_then = false;
    run.c.power = "false";
    assert_int_equal(run_one(&run, passes, 0, &result), CF_UNJUDGED);
    assert_string_equal(result.reason, "not judged since CF-900: --power 'false': expected exit code 0, got 1");
    end_run(&run);
}

/* One lost frame of a busy machine is no verdict; a second one is. */
static unsigned int lose;

static bool loses(cf_datagram_t *d)
{
    (void)d;
    return lose == 0 || lose-- == 0;
}

static void lost_frames(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    on_datagram = loses;
    lose = 0;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    lose = 1;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    lose = 2;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_UNJUDGED);
    assert_int_equal(lose, 0);
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    end_run(&run);
}

/* A slave that never passes the canary is judged case by case from the start. */
static void never_able(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    on_datagram = dies;
    dead = true;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_FAIL);
    assert_int_equal(run_one(&run, passes, 0, &result), CF_FAIL);
    assert_null(run.since);
    end_run(&run);
}

static void leaves_stuck(cf_t *c)
{
    stuck = true;
    cf_put16(c, ECT_REG_AL_CONTROL, CF_OP);
    c->engine->stuck = true; /* not waited for as long */
}

/* A case that passes and leaves the slave in another state fails; the next ones are not judged. */
static void not_as_before(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    on_datagram = sticks;
    stuck = false;
    assert_int_equal(run_one(&run, leaves_stuck, 0, &result), CF_FAIL);
    assert_non_null(strstr(result.reason, "the slave cannot be restored: back to INIT"));
    assert_true(run.engine.stuck); /* INIT gets a shorter timeout until the slave is back */
    assert_int_equal(run_one(&run, passes, 0, &result), CF_UNJUDGED);
    assert_non_null(strstr(result.reason, "not judged since CF-900: back to INIT"));
    stuck = false;
    assert_int_equal(run_one(&run, passes, 0, &result), CF_PASS);
    assert_false(run.engine.stuck);
    end_run(&run);
}

/* A failure after the case adds the frames of the way back. */
static void evidence_of_the_way_back(void **state)
{
    cf_run_t run;
    (void)state;
    start_run(&run);
    on_datagram = sticks;
    stuck = false;
    cf_result_t failed = run_whole(&run, leaves_stuck);
    stuck = false;
    assert_int_equal(failed.verdict, CF_FAIL);
    assert_int_equal(failed.frame, failed.evidence.last_frame);
    assert_int_equal(failed.evidence.last_frame, cf_record_frame());
    assert_true(failed.evidence.count > 20);
    for (size_t i = 1; i < failed.evidence.count; i++)
        assert_true(failed.evidence.items[i].frame >= failed.evidence.items[i - 1].frame);
    assert_true(cf_evidence_start(&failed.evidence) > 0);
    cf_evidence_free(&failed.evidence);
    end_run(&run);
}

/* --- the catalogue ------------------------------------------------------------------------------------------------ */

static const cf_case_t *find(const char *id, unsigned int *count)
{
    const cf_case_t *found = NULL;
    *count = 0;
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        for (size_t i = 0; i < cf_catalogue[s]->count; i++) {
            if (strcmp(cf_catalogue[s]->cases[i].id, id) == 0) {
                found = &cf_catalogue[s]->cases[i];
                ++*count;
            }
        }
    }
    return found;
}

static void ids(void **state)
{
    (void)state;
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        const cf_section_t *section = cf_catalogue[s];
        assert_true(s == 0 || section->letter >= cf_catalogue[s - 1]->letter);
        for (size_t i = 0; i < section->count; i++) {
            unsigned int count;
            const cf_case_t *entry = find(section->cases[i].id, &count);
            assert_int_equal(count, 1);
            assert_ptr_equal(entry, &section->cases[i]);
            assert_true(strncmp(entry->id, "CF-", 3) == 0 || (entry->needs & CF_ON_REQUEST) != 0);
            assert_non_null(strchr("FRST", entry->class));
            assert_true(entry->title[0] != 0 && entry->title[strlen(entry->title) - 1] != '.');
        }
    }
}

static void need_texts(void **state)
{
    (void)state;
    for (unsigned int n = 0; n < CF_NEEDS_COUNT; n++)
        assert_true(strlen(cf_need_text(1u << n)) > 10);
    assert_string_equal(cf_need_text(CF_COE | CF_FOE), "the slave has no CoE"); /* the first that is missing */
    assert_string_equal(cf_need_text(CF_STRESS), "");
}

/* --- a case without frames: CF-060 -------------------------------------------------------------------------------- */

/* A SyncManager category: SM0 and SM1 mailboxes, SM2 outputs, SM3 inputs. */
static void lay_out(cf_run_t *run, uint8_t *sii, uint16_t inputs_at)
{
    static const uint8_t entries[] = {
        0x00, 0x10, 0x80, 0x00, 0x26, 0, 1, 1, /* 0x1000, 128 bytes */
        0x80, 0x10, 0x80, 0x00, 0x22, 0, 1, 2, /* 0x1080, 128 bytes */
        0x00, 0x11, 0x10, 0x00, 0x64, 0, 1, 3, /* 0x1100, 16 bytes, three buffers: to 0x112F */
        0x00, 0x00, 0x08, 0x00, 0x20, 0, 1, 4, /* inputs, 8 bytes */
    };
    static const cf_sm_t sms[] = {
        {0x1000, 128, 0x26, 1, 1}, {0x1080, 128, 0x22, 1, 2}, {0x1100, 16, 0x64, 1, 3}, {0, 8, 0x20, 1, 4}};
    uint8_t *at = sii + 0x80;
    ect_store_le16(at, 30); /* General, 32 bytes */
    ect_store_le16(at + 2, 16);
    at += 4 + 32;
    ect_store_le16(at, 41);
    ect_store_le16(at + 2, sizeof entries / 2);
    memcpy(at + 4, entries, sizeof entries);
    ect_store_le16(at + 4 + 24, inputs_at);
    ect_store_le16(at + 4 + sizeof entries, 0xFFFF);
    memcpy(run->c.facts.sm, sms, sizeof sms);
    run->c.facts.sm[3].start = inputs_at;
    run->c.facts.sm_count = 4;
    run->c.facts.sms = 8;
    run->c.facts.fmmus = 8;
    run->c.facts.sii = sii;
    run->c.facts.sii_size = 0x80 + 4 + 32 + 4 + sizeof entries + 2;
    run->c.facts.has |= CF_SII;
}

static cf_verdict_t judge_layout(uint16_t inputs_at, cf_result_t *result)
{
    static uint8_t sii[512];
    cf_run_t run;
    unsigned int count;
    const cf_case_t *entry = find("CF-060", &count);
    start_run(&run);
    memset(sii, 0, sizeof sii);
    lay_out(&run, sii, inputs_at);
    cf_verdict_t verdict = run_one(&run, entry->run, entry->needs, result);
    end_run(&run);
    return verdict;
}

static void three_buffers(void **state)
{
    cf_result_t result;
    (void)state;
    (void)judge_layout(0x1130, &result);
    assert_string_equal(result.reason, "");
    assert_string_equal(result.reason, "");
    assert_int_equal(judge_layout(0x112F, &result), CF_FAIL); /* in the third buffer of SM2 */
    assert_string_equal(result.reason,
                        "SM2 and SM3: expected not to overlap, three buffers included, got 0x1100+48 and 0x112F+24");
    assert_int_equal(judge_layout(0x2FE8, &result), CF_PASS); /* 24 bytes to the end of the RAM, 0x3000 */
    assert_int_equal(judge_layout(0x2FE9, &result), CF_FAIL); /* two buffers would fit */
    assert_string_equal(result.reason, "SM3: expected within the RAM up to 0x3000, got 0x2FE9 and 24 bytes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(needs),
        cmocka_unit_test(undo_order),
        {"A value of CF_CHANGE_MOST bytes can be kept", longest_value_kept, NULL, NULL, NULL},
        {"A step has at most CF_STEP - 1 bytes", longest_step, NULL, NULL, NULL},
        {"A file is taken back, in the state in which it was read", file_taken_back, NULL, NULL, NULL},
        {"A slave that fails the canary is switched off and on with --power", power_cycle, NULL, NULL, NULL},
        {"A case ends the function that it has named for waits", function_of_another_case, NULL, NULL, NULL},
        {"The capture names a case, and the way back", comments_of_the_capture, NULL, NULL, NULL},
        {"The EEPROM gets its old values in INIT", eeprom_in_init, NULL, NULL, NULL},
        {"The canary uploads the vendor ID, 1018h:1", canary_reads_the_vendor, NULL, NULL, NULL},
        {"Ctrl-C leaves the preparation of a case", interrupted_preparation, NULL, NULL, NULL},
        cmocka_unit_test(too_many_changes),
        cmocka_unit_test(canary),
        cmocka_unit_test(never_able),
        cmocka_unit_test(not_as_before),
        cmocka_unit_test(undo_objects),
        cmocka_unit_test(undo_refused),
        cmocka_unit_test(undo_file),
        cmocka_unit_test(items_kept),
        cmocka_unit_test(undo_kept),
        cmocka_unit_test(silent_mailbox),
        cmocka_unit_test(lost_frames),
        cmocka_unit_test(canary_leaves_init),
        cmocka_unit_test(time_limit),
        cmocka_unit_test(canary_without_coe),
        cmocka_unit_test(frames_of_verdicts),
        cmocka_unit_test(evidence_of_the_way_back),
        cmocka_unit_test(waiting),
        cmocka_unit_test(interrupted),
        cmocka_unit_test(engine_limits),
        cmocka_unit_test(deadline_of_a_case),
        cmocka_unit_test(engine_ends_twice),
        cmocka_unit_test(ids),
        cmocka_unit_test(need_texts),
        cmocka_unit_test(three_buffers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
