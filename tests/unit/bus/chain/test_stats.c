/* SPDX-License-Identifier: MIT */
/* Counters of a run (src/bus/chain/stats.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "bus/chain/stats.h"

#define MS 1000000ull
#define US 1000ull

static void answer_times(void **state)
{
    static const struct {
        uint64_t took_ns;
        size_t step;
    } cases[] = {{0, 0},       {999, 0},          {1 * US, 1},     {1999, 1},       {2 * US, 2},     {49999, 5},
                 {50 * US, 6}, {999999 * US, 18}, {1000 * MS, 19}, {5000 * MS, 19}, {UINT64_MAX, 19}};
    (void)state;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        ect_stats_t stats = {0};
        ect_stats_answer(&stats, cases[c].took_ns);
        for (size_t step = 0; step < ECT_STATS_STEPS; step++)
            assert_int_equal(stats.answers[step], step == cases[c].step ? 1 : 0);
        assert_true(stats.longest_answer_ns == cases[c].took_ns);
        assert_int_equal(stats.answered, 1);
        assert_int_equal(ect_stats_quantile_us(stats.answers, 500), ect_stats_edge_us(cases[c].step));
    }
}

static void quantiles(void **state)
{
    ect_stats_t stats = {0};
    (void)state;
    assert_int_equal(ect_stats_quantile_us(stats.answers, 500), 0);
    for (unsigned int i = 0; i < 1000; i++)
        ect_stats_answer(&stats, i < 900 ? 15 * US : i < 990 ? 70 * US : 3 * MS);
    assert_int_equal(ect_stats_quantile_us(stats.answers, 0), 20);
    assert_int_equal(ect_stats_quantile_us(stats.answers, 900), 20);
    assert_int_equal(ect_stats_quantile_us(stats.answers, 901), 100);
    assert_int_equal(ect_stats_quantile_us(stats.answers, 990), 100);
    assert_int_equal(ect_stats_quantile_us(stats.answers, 991), 5000);
    assert_int_equal(ect_stats_quantile_us(stats.answers, 1000), 5000);
    assert_true(stats.longest_answer_ns == 3 * MS);
}

static void edges(void **state)
{
    static const uint32_t want[ECT_STATS_STEPS] = {
        1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000, 100000, 200000, 500000, 1000000, 0};
    (void)state;
    for (size_t step = 0; step < ECT_STATS_STEPS; step++) {
        ect_stats_t below = {0}, at = {0};
        assert_int_equal(ect_stats_edge_us(step), want[step]);
        if (want[step] == 0)
            continue;
        ect_stats_answer(&below, want[step] * US - 1);
        ect_stats_answer(&at, want[step] * US);
        assert_int_equal(below.answers[step], 1);
        assert_int_equal(at.answers[step + 1], 1);
    }
    assert_int_equal(ect_stats_edge_us(ECT_STATS_STEPS), 0);
    assert_int_equal(ect_stats_edge_us(SIZE_MAX - 1), 0);
}

/* Counts whose quantiles depend only on their sums, up to the last class, which has no edge. */
static void quantile_borders(void **state)
{
    static const struct {
        uint64_t first, second, last; /* replies of 0, 1 and of more than a million microseconds */
        unsigned int per_mille;
        uint32_t want;
    } rows[] = {
        {1, 1, 0, 500, 1},
        {1, 1, 0, 501, 2},
        {1, 1, 0, 0, 1},
        {0, 1, 0, 0, 2},
        {0, 0, 1, 0, 0},
        {0, 0, 1, 1000, 0},
        {1, 0, 1, 500, 1},
        {1, 0, 1, 501, 0},
        {999, 1, 0, 999, 1},
        {999, 1, 0, 1000, 2},
        {1, 999, 0, 1, 1},
        {1, 999, 0, 2, 2},
        {1u << 31, 1u << 31, 1, 499, 1},
        {1u << 31, 1u << 31, 1, 501, 2},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_stats_t stats = {0};
        stats.answers[0] = rows[i].first;
        stats.answers[1] = rows[i].second;
        stats.answers[ECT_STATS_STEPS - 1] = rows[i].last;
        assert_int_equal(ect_stats_quantile_us(stats.answers, rows[i].per_mille), rows[i].want);
    }
}

/* The longest and the latest are kept when shorter ones follow. */
static void longest(void **state)
{
    static const uint64_t took_ns[] = {5, 9, 7, 9, 1};
    static const uint64_t want_ns[] = {5, 9, 9, 9, 9};
    ect_stats_t stats = {0};
    (void)state;
    for (size_t i = 0; i < sizeof took_ns / sizeof took_ns[0]; i++) {
        ect_stats_answer(&stats, took_ns[i]);
        ect_stats_poll(&stats, took_ns[i]);
        assert_true(stats.longest_answer_ns == want_ns[i]);
        assert_true(stats.latest_poll_ns == want_ns[i]);
        assert_int_equal(stats.answered, i + 1);
        assert_int_equal(stats.polls, i + 1);
    }
}

/* Replies of plans are replies too, with classes and a longest time of their own. */
static void in_the_kernel(void **state)
{
    ect_stats_t stats = {0};
    (void)state;
    ect_stats_answer(&stats, 7 * US);
    ect_stats_kernel_answer(&stats, 3 * US);
    ect_stats_kernel_answer(&stats, 2 * US);
    assert_int_equal(stats.answered, 3);
    assert_int_equal(stats.in_kernel, 2);
    assert_true(stats.longest_answer_ns == 7 * US);
    assert_true(stats.longest_kernel_ns == 3 * US);
    for (size_t step = 0; step < ECT_STATS_STEPS; step++) {
        const uint32_t edge_us = ect_stats_edge_us(step);
        assert_int_equal(stats.answers[step], edge_us == 10);
        assert_int_equal(stats.kernel_answers[step], edge_us == 5 ? 2 : 0);
    }
}

static void late_polls(void **state)
{
    ect_stats_t stats = {0};
    (void)state;
    ect_stats_poll(&stats, 0);
    ect_stats_poll(&stats, ECT_STATS_LATE_NS);
    assert_int_equal(stats.late_polls, 0);
    ect_stats_poll(&stats, ECT_STATS_LATE_NS + 1);
    assert_int_equal(stats.late_polls, 1);
    assert_int_equal(stats.polls, 3);
    assert_true(stats.latest_poll_ns == ECT_STATS_LATE_NS + 1);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"response times are counted in their classes", answer_times, NULL, NULL, NULL},
        {"quantiles of the response times", quantiles, NULL, NULL, NULL},
        {"each class ends before its edge, and the last one has none", edges, NULL, NULL, NULL},
        {"quantiles at the borders of the classes", quantile_borders, NULL, NULL, NULL},
        {"the longest reply and the latest run are kept", longest, NULL, NULL, NULL},
        {"replies in the kernel are counted apart", in_the_kernel, NULL, NULL, NULL},
        {"late runs of the devices are counted", late_polls, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Counters", tests, NULL, NULL);
}
