/* SPDX-License-Identifier: MIT */
/* Runs one case between two known states. */
#include "runner.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "catalogue.h"

/* Items of evidence to keep: KEEP_PASSED for a pass, KEEP_OTHERS, enough to find the cause, for another verdict. */
enum { KEEP_PASSED = 24, KEEP_OTHERS = 120, RESTORE_MS = 40000, AGAIN_MS = 1500, UNKNOWN_PROTOCOL = 9 };

static void arm(cf_engine_t *e, uint32_t ms, bool running)
{
    e->limit_ms = ms;
    e->deadline_ns = cf_now_ns() + ms * UINT64_C(1000000);
    e->running = running;
}

/* Runs a preparation or a case. @return whether it returned by itself */
static bool guarded(cf_t *c, void (*run)(cf_t *c), uint32_t ms, bool running)
{
    cf_engine_t *e = c->engine;
    arm(e, ms, running);
    e->verdict = CF_PASS;
    e->reason[0] = 0;
    e->in_idle = false;
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

/* Restores the slave. If this fails, the case fails, unless it has already failed. */
static void restore(cf_t *c, cf_result_t *result)
{
    cf_engine_t *e = c->engine;
    cf_record_begin(result->entry->id, "afterwards: back to INIT");
    bool back = guarded(c, cf_put_back, RESTORE_MS, false);
    cf_forget_changes(e);
    e->stuck = !back;
    cf_evidence_t evidence = cf_record_end(KEEP_OTHERS);
    if (back || result->verdict == CF_INTERRUPTED || result->verdict == CF_FAIL) {
        cf_evidence_free(&evidence);
        return;
    }
    snprintf(result->reason, sizeof result->reason, "the slave cannot be restored: %.300s", e->reason);
    result->verdict = CF_FAIL;
    result->frame = e->frame;
    append(&result->evidence, &evidence);
}

static uint32_t missing(const cf_t *c, const cf_case_t *entry)
{
    uint32_t has = c->facts.has | (c->destructive ? CF_WRITES_SII : 0) | (c->esi ? CF_ESI : 0) |
                   (c->emulated ? 0 : CF_REAL_TIME) | (c->move.distance > 0 ? CF_MOVE : 0);
    return entry->needs & ~(has | CF_ON_REQUEST);
}

/* The minimum for a case: INIT, PREOP, one mail and its reply. */
static void canary(cf_t *c)
{
    uint32_t code;
    cf_mail_t mail;
    cf_known_state(c);
    if ((c->facts.has & CF_MAILBOX) == 0)
        return;
    cf_go(c, CF_PREOP);
    if ((c->facts.has & CF_COE) != 0) {
        (void)cf_object_exists(c, 0x1018, 1, &code);
    } else {
        cf_send_mail(c, UNKNOWN_PROTOCOL, "", 0);
        cf_receive(c, CF_MBX_ERROR, &mail);
    }
    cf_known_state(c);
}

/* Tries twice, because a busy machine may lose a frame. With --power a slave that fails both tries is switched off and
 * on. A slave that failed before the previous case gets one short try. */
static bool canary_passes(cf_run_t *run)
{
    cf_t *c = &run->c;
    if (run->since)
        return guarded(c, canary, AGAIN_MS, true);
    for (int tries = 0; tries < 2; tries++) {
        if (guarded(c, canary, RESTORE_MS, true))
            return true;
        if (c->engine->verdict == CF_INTERRUPTED)
            return false;
    }
    return c->power && guarded(c, cf_power_cycle, RESTORE_MS, true) && guarded(c, canary, RESTORE_MS, true);
}

/* A slave that has passed the canary once must pass it before each case; any other slave is judged case by case. */
static bool prepare(cf_run_t *run)
{
    cf_engine_t *e = run->c.engine;
    if (run->canary != CF_CANARY_UNABLE && canary_passes(run)) {
        run->canary = CF_CANARY_ABLE;
        run->since = NULL;
        return true;
    }
    if (run->canary != CF_CANARY_ABLE && e->verdict != CF_INTERRUPTED) {
        run->canary = CF_CANARY_UNABLE;
        return guarded(&run->c, cf_known_state, RESTORE_MS, true);
    }
    if (e->verdict == CF_INTERRUPTED)
        return false;
    if (!run->since) {
        run->since = run->last ? run->last : "the start";
        memcpy(run->why, e->reason, sizeof run->why);
    }
    snprintf(e->reason, sizeof e->reason, "not judged since %s: %.350s", run->since, run->why);
    e->verdict = CF_UNJUDGED;
    return false;
}

/* @return whether the slave must be restored; false: the preparation failed */
static bool judge(cf_run_t *run, cf_result_t *result)
{
    cf_t *c = &run->c;
    cf_engine_t *e = c->engine;
    const cf_case_t *entry = result->entry;
    cf_record_begin(entry->id, entry->title);
    e->step[0] = 0;
    bool ready = prepare(run);
    if (ready) {
        cf_step(c, CF_CASE_BEGINS);
        e->step[0] = 0;
        (void)guarded(c, entry->run, entry->limit_ms != 0 ? entry->limit_ms : CF_LIMIT_MS, true);
        run->last = entry->id;
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
    if (judge(run, result))
        restore(&run->c, result);
    result->duration_ns = cf_now_ns() - start;
}
