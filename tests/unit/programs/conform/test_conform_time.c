/* SPDX-License-Identifier: MIT */
/* The time limit of a case, on a clock that the test sets. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "conform_support.h"

uint64_t __wrap_cf_now_ns(void);

enum { LIMIT_MS = 2000, MORE_MS = 500 };

static uint64_t now_ns, took_ns;
static uint32_t more_ms;

uint64_t __wrap_cf_now_ns(void)
{
    return now_ns;
}

/* A case that checks its time once, after took_ns. */
static void takes_time(cf_t *c)
{
    if (more_ms != 0)
        cf_extend(c, more_ms);
    now_ns += took_ns;
    cf_check_time(c);
}

static cf_result_t run_limited(uint64_t ns)
{
    static const cf_case_t entry = {"CF-900", "A case of a test", 'R', 0, LIMIT_MS, takes_time};
    static const cf_section_t section = {'Z', "Tests", &entry, 1};
    cf_run_t run;
    cf_result_t result;
    took_ns = ns;
    start_run(&run);
    cf_run_case(&run, &section, &entry, &result);
    cf_evidence_free(&result.evidence);
    end_run(&run);
    return result;
}

/* The limit is reached at its last nanosecond; an extension moves it. */
static void limit(void **state)
{
    static const struct {
        uint32_t more;
        uint64_t ns;
        cf_verdict_t verdict;
        const char *reason;
    } rows[] = {
        {0, 0, CF_PASS, ""},
        {0, LIMIT_MS * UINT64_C(1000000) - 1, CF_PASS, ""},
        {0, LIMIT_MS * UINT64_C(1000000), CF_FAIL, "time limit: not finished within 2000 ms"},
        {MORE_MS, (LIMIT_MS + MORE_MS) * UINT64_C(1000000) - 1, CF_PASS, ""},
        {MORE_MS, (LIMIT_MS + MORE_MS) * UINT64_C(1000000), CF_FAIL, "time limit: not finished within 2500 ms"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        more_ms = rows[i].more;
        cf_result_t result = run_limited(rows[i].ns);
        assert_int_equal(result.verdict, rows[i].verdict);
        assert_string_equal(result.reason, rows[i].reason);
        assert_int_equal(result.duration_ns, rows[i].ns);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A case fails when its time limit is reached, not before", limit, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
