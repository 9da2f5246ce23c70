/* SPDX-License-Identifier: MIT */
#include <stdarg.h>

#include "reader/internal.h"

ect_reader_result_t reader_report(ect_reader_t *r, ect_reader_result_t result, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(r->text, sizeof r->text, format, arguments);
    va_end(arguments);
    r->result = result;
    return result;
}

ect_reader_result_t reader_good(ect_reader_t *r)
{
    r->text[0] = '\0';
    r->result = ECT_READER_OK;
    return ECT_READER_OK;
}

uint64_t reader_now(const ect_reader_t *r)
{
    return r->link->now(r->link->ctx);
}

static const char by_user[] = "stopped by the user";

bool reader_is_stopped(ect_reader_t *r)
{
    if (r->config.stopped == NULL || !r->config.stopped(r->config.progress_ctx))
        return false;
    (void)reader_report(r, ECT_READER_STOPPED, by_user);
    return true;
}

bool reader_is_over(ect_reader_t *r)
{
    if (reader_is_stopped(r))
        return true;
    if (reader_now(r) < r->limit_ns)
        return false;
    (void)reader_report(r, ECT_READER_STOPPED, "not finished within %u ms", r->config.limit_ms);
    return true;
}

bool reader_progress(ect_reader_t *r, const char *what, unsigned int done, unsigned int all)
{
    if (reader_is_over(r))
        return false;
    if (r->config.progress == NULL || r->config.progress(r->config.progress_ctx, what, done, all))
        return true;
    (void)reader_report(r, ECT_READER_STOPPED, by_user);
    return false;
}

void reader_pause(const ect_reader_t *r, unsigned int polls)
{
    const uint64_t pause_ns = polls < 8 ? 20000 : polls < 16 ? 200000 : NS_PER_MS;
    r->link->wait(r->link->ctx, reader_now(r) + pause_ns);
}
