/* SPDX-License-Identifier: MIT */
/* The judgements of ectwin-conform: each expectation holds for the expected value alone and names both values. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "conform_support.h"

static uint64_t wanted, actual, mask, least, most;

static void equal(cf_t *c)
{
    cf_expect(c, "a value", wanted, actual);
}

static void bits(cf_t *c)
{
    cf_expect_bits(c, "bits", mask, wanted, actual);
}

static void range(cf_t *c)
{
    cf_expect_range(c, "a count", least, most, actual);
}

static void wkc(cf_t *c)
{
    cf_expect_wkc(c, "a read", (unsigned int)wanted, (unsigned int)actual);
}

static void bytes(cf_t *c)
{
    cf_expect_bytes(c, "bytes", "abc", actual == 0 ? "abc" : actual == 3 ? "Xbc" : "abX", actual == 2 ? 2 : 3);
}

static void that(cf_t *c)
{
    cf_expect_that(c, actual != 0, "a sentence with %d", 7);
}

static void expect_pass(void (*function)(cf_t *c))
{
    cf_run_t run;
    cf_result_t result;
    start_run(&run);
    assert_int_equal(run_one(&run, function, 0, &result), CF_PASS);
    assert_string_equal(result.reason, "");
    end_run(&run);
}

static void expect_fail(void (*function)(cf_t *c), const char *reason)
{
    cf_run_t run;
    cf_result_t result;
    start_run(&run);
    assert_int_equal(run_one(&run, function, 0, &result), CF_FAIL);
    assert_string_equal(result.reason, reason);
    end_run(&run);
}

static void values(void **state)
{
    (void)state;
    wanted = actual = 0x16;
    expect_pass(equal);
    actual = 0x17;
    expect_fail(equal, "a value: expected 0x16, got 0x17");
    actual = 0x100;
    expect_fail(equal, "a value: expected 0x0016, got 0x0100");
    wanted = 0x10000;
    expect_fail(equal, "a value: expected 0x00010000, got 0x00000100");
    wanted = UINT64_C(0x100000000);
    expect_fail(equal, "a value: expected 0x0000000100000000, got 0x0000000000000100");
    wanted = 0xFF;
    actual = 0xFFFF;
    expect_fail(equal, "a value: expected 0x00FF, got 0xFFFF");
    actual = UINT32_MAX;
    expect_fail(equal, "a value: expected 0x000000FF, got 0xFFFFFFFF");
}

static void masked(void **state)
{
    (void)state;
    mask = 0x0C;
    wanted = 0x08;
    actual = 0xFB;
    expect_pass(bits);
    actual = 0xFF;
    expect_fail(bits, "bits: expected 0x08 in the bits 0x0C, got 0xFF");
    wanted = 0x18; /* a bit outside of the mask is not printed as expected */
    actual = 0x04;
    expect_fail(bits, "bits: expected 0x08 in the bits 0x0C, got 0x04");
    mask = 0x0F; /* the longest of the three numbers gives the digits, even beyond the mask */
    wanted = 0x100;
    actual = 0x01;
    expect_fail(bits, "bits: expected 0x0000 in the bits 0x000F, got 0x0001");
    mask = 0x0C;
    wanted = 0x08;
    actual = 0x10004;
    expect_fail(bits, "bits: expected 0x00000008 in the bits 0x0000000C, got 0x00010004");
}

static void ranges(void **state)
{
    (void)state;
    least = 4;
    most = 6;
    for (actual = 4; actual <= 6; actual++)
        expect_pass(range);
    expect_fail(range, "a count: expected 4..6, got 7");
    actual = 3;
    expect_fail(range, "a count: expected 4..6, got 3");
    most = 4;
    expect_fail(range, "a count: expected 4, got 3");
    actual = 5;
    expect_fail(range, "a count: expected 4, got 5");
}

static void others(void **state)
{
    (void)state;
    wanted = actual = 3;
    expect_pass(wkc);
    actual = 1;
    expect_fail(wkc, "WKC of a read: expected 3, got 1");
    actual = 0;
    expect_pass(bytes);
    actual = 1;
    expect_fail(bytes, "bytes: byte 2 of 3: expected 0x63, got 0x58");
    actual = 3;
    expect_fail(bytes, "bytes: byte 0 of 3: expected 0x61, got 0x58");
    actual = 2;
    expect_pass(bytes);
    expect_pass(that);
    actual = 0;
    expect_fail(that, "a sentence with 7");
}

/* --- random numbers ----------------------------------------------------------------------------------------------- */

static uint32_t seen[16], order[4], limit;

static void draw(cf_t *c)
{
    memset(seen, 0, sizeof seen);
    for (int i = 0; i < 4000; i++) {
        uint32_t value = cf_random(c, limit);
        if (i < 4)
            order[i] = value;
        cf_expect_that(c, value < limit, "%u", value);
        seen[value % 16]++;
    }
}

static void random_range(void **state)
{
    uint32_t first[4];
    (void)state;
    limit = 16;
    expect_pass(draw);
    memcpy(first, order, sizeof first);
    for (size_t i = 0; i < 16; i++)
        assert_in_range(seen[i], 150, 350); /* 250 of 4000, each value */
    expect_pass(draw);
    assert_memory_equal(first, order, sizeof first); /* every case starts with the seed */
    limit = 1;
    expect_pass(draw);
    assert_int_equal(seen[0], 4000);
    limit = 3;
    expect_pass(draw);
    assert_true(seen[0] > 0 && seen[1] > 0 && seen[2] > 0 && seen[3] == 0);
}

static void another_seed(void **state)
{
    cf_run_t run;
    cf_result_t result;
    uint32_t first[4];
    (void)state;
    limit = UINT32_MAX;
    expect_pass(draw);
    memcpy(first, order, sizeof first);
    start_run(&run);
    run.engine.seed = 2;
    assert_int_equal(run_one(&run, draw, 0, &result), CF_PASS);
    assert_memory_not_equal(first, order, sizeof first);
    end_run(&run);
}

/* --- sentences ---------------------------------------------------------------------------------------------------- */

static void warns_twice(cf_t *c)
{
    cf_note(c, "a note");
    cf_warn(c, "the first");
    cf_warn(c, "the second");
    cf_note(c, "a later note");
}

static void notes_twice(cf_t *c)
{
    cf_note(c, "the first");
    cf_note(c, "the %s", "last");
}

static void warns_and_fails(cf_t *c)
{
    cf_step(c, "step %d", 1);
    cf_warn(c, "a warning");
    cf_remark(c, "no step");
    cf_fail(c, "a failure");
}

static void skips(cf_t *c)
{
    cf_skip(c, "no reason");
}

static void sentences(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, warns_twice, 0, &result), CF_WARN);
    assert_string_equal(result.reason, "the first");
    assert_int_equal(run_one(&run, notes_twice, 0, &result), CF_PASS);
    assert_string_equal(result.reason, "the last");
    assert_int_equal(run_one(&run, warns_and_fails, 0, &result), CF_FAIL);
    assert_string_equal(result.reason, "a failure");
    assert_string_equal(result.step, "step 1");
    assert_int_equal(run_one(&run, skips, 0, &result), CF_SKIPPED);
    assert_string_equal(result.reason, "no reason");
    end_run(&run);
}

/* A seed that a report names repeats the run with every later version. */
static void the_sequence_of_a_seed_is_fixed(void **state)
{
    static const uint32_t expected[] = {177355, 512552, 485455, 648416, 277360, 212811};
    cf_t c = {.random = 1};
    (void)state;
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++)
        assert_int_equal(cf_random(&c, 1000000), expected[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"The random sequence of a seed is fixed", the_sequence_of_a_seed_is_fixed, NULL, NULL, NULL},
        cmocka_unit_test(values),
        cmocka_unit_test(masked),
        cmocka_unit_test(ranges),
        cmocka_unit_test(others),
        cmocka_unit_test(random_range),
        cmocka_unit_test(another_seed),
        cmocka_unit_test(sentences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
