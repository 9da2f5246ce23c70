/* SPDX-License-Identifier: MIT */
/* The end of a case: verdicts, sentences of the evidence, the time limit. */
#define _GNU_SOURCE
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "steps/engine.h"

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
    snprintf(text, sizeof text, "time limit: not finished within %u ms", c->engine->limit_ms);
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

void cf_expect_that(cf_t *c, bool holds, const char *format, ...)
{
    if (holds)
        return;
    FORMATTED(text, format);
    cf_leave(c, CF_FAIL, text);
}
