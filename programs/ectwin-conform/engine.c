/* SPDX-License-Identifier: MIT */
/* One case after the other: known state, the case, known state; verdicts; the way out. */
#define _GNU_SOURCE
#include "engine.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* What stays of a case: of one that passed the end, of others enough to see why. */
enum { KEEP_PASSED = 24, KEEP_OTHERS = 120, RESTORE_MS = 40000, LOOK_NS = 200000 };

/* --- the way out of a case ---------------------------------------------------------------------------------------- */

_Noreturn void cf_leave(cf_t *c, cf_verdict_t verdict, const char *reason)
{
    cf_engine_t *e = c->engine;
    snprintf(e->reason, sizeof e->reason, "%s", reason);
    e->verdict = verdict;
    e->frame = cf_record_frame();
    longjmp(e->leave, 1);
}

void cf_check_time(cf_t *c)
{
    char text[80];
    if (cf_interrupted != 0 && c->engine->running)
        cf_leave(c, CF_INTERRUPTED, "interrupted");
    if (cf_now_ns() < c->engine->deadline_ns)
        return;
    snprintf(text, sizeof text, "time limit: not done within %u ms", c->engine->limit_ms);
    cf_leave(c, CF_FAIL, text);
}

void cf_extend(cf_t *c, uint32_t ms)
{
    c->engine->deadline_ns += ms * UINT64_C(1000000);
    c->engine->limit_ms += ms;
}

#define FORMATTED(text, format)                                                                                        \
    char text[CF_REASON];                                                                                              \
    va_list arguments;                                                                                                 \
    va_start(arguments, format);                                                                                       \
    (void)vsnprintf(text, sizeof text, format, arguments);                                                             \
    va_end(arguments)

_Noreturn void cf_fail(cf_t *c, const char *format, ...)
{
    FORMATTED(text, format);
    cf_leave(c, CF_FAIL, text);
}

_Noreturn void cf_skip(cf_t *c, const char *format, ...)
{
    FORMATTED(text, format);
    cf_leave(c, CF_SKIPPED, text);
}

void cf_warn(cf_t *c, const char *format, ...)
{
    FORMATTED(text, format);
    if (c->engine->verdict == CF_WARN)
        return;
    c->engine->verdict = CF_WARN;
    c->engine->frame = cf_record_frame();
    memcpy(c->engine->reason, text, sizeof text);
}

void cf_note(cf_t *c, const char *format, ...)
{
    FORMATTED(text, format);
    if (c->engine->verdict == CF_PASS)
        memcpy(c->engine->reason, text, sizeof text);
}

void cf_step(cf_t *c, const char *format, ...)
{
    FORMATTED(text, format);
    snprintf(c->engine->step, sizeof c->engine->step, "%.*s", (int)sizeof c->engine->step - 1, text);
    cf_record_step(text);
}

void cf_remark(cf_t *c, const char *format, ...)
{
    (void)c;
    FORMATTED(text, format);
    cf_record_step(text);
}

/* --- expectations ------------------------------------------------------------------------------------------------- */

static int digits(uint64_t a, uint64_t b)
{
    uint64_t larger = a > b ? a : b;
    return larger > UINT32_MAX ? 16 : larger > UINT16_MAX ? 8 : larger > UINT8_MAX ? 4 : 2;
}

void cf_expect(cf_t *c, const char *what, uint64_t expected, uint64_t got)
{
    int width = digits(expected, got);
    if (expected != got)
        cf_fail(c, "%s: expected 0x%0*llX, got 0x%0*llX", what, width, (unsigned long long)expected, width,
                (unsigned long long)got);
}

void cf_expect_bits(cf_t *c, const char *what, uint64_t mask, uint64_t expected, uint64_t got)
{
    int width = digits(mask | expected, got);
    if (((expected ^ got) & mask) != 0)
        cf_fail(c, "%s: expected 0x%0*llX in the bits 0x%0*llX, got 0x%0*llX", what, width,
                (unsigned long long)(expected & mask), width, (unsigned long long)mask, width, (unsigned long long)got);
}

void cf_expect_range(cf_t *c, const char *what, uint64_t minimum, uint64_t maximum, uint64_t got)
{
    if (got >= minimum && got <= maximum)
        return;
    if (minimum == maximum)
        cf_fail(c, "%s: expected %llu, got %llu", what, (unsigned long long)minimum, (unsigned long long)got);
    cf_fail(c, "%s: expected %llu..%llu, got %llu", what, (unsigned long long)minimum, (unsigned long long)maximum,
            (unsigned long long)got);
}

void cf_expect_wkc(cf_t *c, const char *what, unsigned int expected, unsigned int got)
{
    if (expected != got)
        cf_fail(c, "WKC of %s: expected %u, got %u", what, expected, got);
}

void cf_expect_bytes(cf_t *c, const char *what, const void *expected, const void *got, size_t length)
{
    const uint8_t *e = expected, *g = got;
    for (size_t i = 0; i < length; i++) {
        if (e[i] != g[i])
            cf_fail(c, "%s: byte %zu of %zu: expected 0x%02X, got 0x%02X", what, i, length, e[i], g[i]);
    }
}

void cf_expect_that(cf_t *c, bool holds, const char *format, ...)
{
    if (holds)
        return;
    FORMATTED(text, format);
    cf_leave(c, CF_FAIL, text);
}

/* --- while it runs ------------------------------------------------------------------------------------------------ */

/* xorshift64* */
uint32_t cf_random(cf_t *c, uint32_t limit)
{
    c->random ^= c->random >> 12;
    c->random ^= c->random << 25;
    c->random ^= c->random >> 27;
    return (uint32_t)((c->random * UINT64_C(2685821657736338717)) >> 32) % limit;
}

void cf_while_waiting(cf_t *c, void (*look)(cf_t *c, void *ctx), void *ctx)
{
    c->engine->look = look;
    c->engine->look_ctx = ctx;
}

/* The function may use waiting steps itself. */
void cf_between_looks(cf_t *c)
{
    cf_engine_t *e = c->engine;
    const struct timespec pause = {.tv_nsec = LOOK_NS};
    if (!e->look || e->looking) {
        (void)nanosleep(&pause, NULL);
        return;
    }
    e->looking = true;
    e->look(c, e->look_ctx);
    e->looking = false;
}

void cf_measure(cf_t *c, const char *series, uint64_t ns)
{
    cf_engine_t *e = c->engine;
    size_t n = 0;
    while (n < e->series_count && strcmp(e->series[n].name, series) != 0)
        n++;
    if (n == CF_SERIES_MOST)
        cf_fail(c, "more than %d histograms", (int)CF_SERIES_MOST);
    cf_series_t *s = &e->series[n];
    if (n == e->series_count) {
        *s = (cf_series_t){.name = series, .values_ns = calloc(CF_VALUES_MOST, sizeof s->values_ns[0])};
        if (!s->values_ns)
            cf_fail(c, "out of memory");
        e->series_count++;
    }
    if (s->count < CF_VALUES_MOST)
        s->values_ns[s->count++] = ns;
}

/* --- one case ----------------------------------------------------------------------------------------------------- */

static void arm(cf_engine_t *e, uint32_t ms, bool running)
{
    e->limit_ms = ms;
    e->deadline_ns = cf_now_ns() + ms * UINT64_C(1000000);
    e->running = running;
}

/* Runs a step of the engine or a case. @return whether it came to its end */
static bool guarded(cf_t *c, void (*run)(cf_t *c), uint32_t ms, bool running)
{
    cf_engine_t *e = c->engine;
    arm(e, ms, running);
    e->verdict = CF_PASS;
    e->reason[0] = 0;
    e->looking = false;
    c->random = e->seed;
    cf_while_waiting(c, NULL, NULL);
    if (setjmp(e->leave) != 0) {
        e->running = false;
        return false;
    }
    run(c);
    e->running = false;
    return true;
}

static void append(cf_evidence_t *to, cf_evidence_t *more)
{
    cf_item_t *items = realloc(to->items, (to->count + more->count + 1) * sizeof items[0]);
    if (!items)
        abort();
    memcpy(items + to->count, more->items, more->count * sizeof items[0]);
    to->items = items;
    to->count += more->count;
    to->last_frame = more->last_frame != 0 ? more->last_frame : to->last_frame;
    free(more->items);
}

cf_undo_t *cf_new_undo(cf_t *c)
{
    cf_engine_t *e = c->engine;
    if (e->undo_count == CF_UNDO_MOST)
        cf_fail(c, "this case changes more than %d values", (int)CF_UNDO_MOST);
    return &e->undo[e->undo_count++];
}

static void undo_one(cf_t *c, const cf_undo_t *u)
{
    if (u->what == CF_UNDO_SII) {
        cf_sii_write_word(c, u->index, ect_load_le16(u->data));
    } else if (u->what == CF_UNDO_FILE) {
        cf_go(c, u->state);
        uint32_t code = cf_write_file(c, c->password, u->file, u->size);
        if (code != 0)
            cf_fail(c, "putting back the file: error 0x%08X", code);
    } else {
        cf_go(c, CF_PREOP);
        uint32_t code = cf_download(c, u->index, u->sub, false, u->data, u->size);
        if (code != 0)
            cf_fail(c, "putting back %04Xh:%02X: abort 0x%08X", u->index, u->sub, code);
    }
}

/* Also of those that could not be put back. */
static void forget_changes(cf_engine_t *e)
{
    for (size_t i = 0; i < CF_UNDO_MOST; i++) {
        free(e->undo[i].file);
        e->undo[i].file = NULL;
    }
    e->undo_count = 0;
}

static void put_back(cf_t *c)
{
    cf_engine_t *e = c->engine;
    cf_put_plug_back(c);
    cf_known_state(c);
    while (e->undo_count > 0)
        undo_one(c, &e->undo[--e->undo_count]);
    cf_known_state(c);
}

/* Brings the slave back; what is wrong with that is the case's failure, unless it has one already. */
static void restore(cf_t *c, cf_result_t *result)
{
    cf_engine_t *e = c->engine;
    cf_record_begin(result->entry->id, "afterwards: back to INIT");
    bool back = guarded(c, put_back, RESTORE_MS, false);
    forget_changes(e);
    e->lame = !back;
    cf_evidence_t evidence = cf_record_end(KEEP_OTHERS);
    if (back || result->verdict == CF_INTERRUPTED || result->verdict == CF_FAIL) {
        cf_evidence_free(&evidence);
        return;
    }
    snprintf(result->reason, sizeof result->reason, "afterwards the slave is not as before: %.300s", e->reason);
    result->verdict = CF_FAIL;
    result->frame = e->frame;
    append(&result->evidence, &evidence);
}

static uint32_t missing(const cf_t *c, const cf_case_t *entry)
{
    uint32_t has =
        c->facts.has | (c->destructive ? CF_WRITES_SII : 0) | (c->esi ? CF_ESI : 0) | (c->emulated ? 0 : CF_REAL_TIME);
    return entry->needs & ~(has | CF_ON_REQUEST);
}

/* @return whether there is something to restore: a slave that was not ready for the case has been tried already */
static bool judge(cf_t *c, cf_result_t *result)
{
    cf_engine_t *e = c->engine;
    const cf_case_t *entry = result->entry;
    cf_record_begin(entry->id, entry->title);
    e->step[0] = 0;
    bool ready = guarded(c, cf_known_state, RESTORE_MS, true);
    if (ready) {
        cf_step(c, "the case begins");
        e->step[0] = 0;
        (void)guarded(c, entry->run, entry->limit_ms != 0 ? entry->limit_ms : CF_LIMIT_MS, true);
    }
    result->verdict = e->verdict;
    result->frame = e->frame;
    memcpy(result->reason, e->reason, sizeof result->reason);
    memcpy(result->step, e->step, sizeof result->step);
    result->evidence = cf_record_end(e->verdict == CF_PASS || e->verdict == CF_SKIPPED ? KEEP_PASSED : KEEP_OTHERS);
    return ready || e->verdict == CF_INTERRUPTED;
}

void cf_run_case(cf_run_t *run, const cf_section_t *section, const cf_case_t *entry, cf_result_t *result)
{
    uint64_t start = cf_now_ns();
    *result = (cf_result_t){.section = section, .entry = entry};
    uint32_t lacks = missing(&run->c, entry);
    if (lacks != 0) {
        result->verdict = CF_SKIPPED;
        snprintf(result->reason, sizeof result->reason, "%s", cf_need_text(lacks));
        return;
    }
    if (judge(&run->c, result))
        restore(&run->c, result);
    result->duration_ns = cf_now_ns() - start;
}
