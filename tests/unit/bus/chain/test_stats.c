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
        assert_int_equal(ect_stats_quantile_us(&stats, 500), ect_stats_edge_us(cases[c].step));
    }
}

static void quantiles(void **state)
{
    ect_stats_t stats = {0};
    (void)state;
    assert_int_equal(ect_stats_quantile_us(&stats, 500), 0);
    for (unsigned int i = 0; i < 1000; i++)
        ect_stats_answer(&stats, i < 900 ? 15 * US : i < 990 ? 70 * US : 3 * MS);
    assert_int_equal(ect_stats_quantile_us(&stats, 0), 20);
    assert_int_equal(ect_stats_quantile_us(&stats, 900), 20);
    assert_int_equal(ect_stats_quantile_us(&stats, 901), 100);
    assert_int_equal(ect_stats_quantile_us(&stats, 990), 100);
    assert_int_equal(ect_stats_quantile_us(&stats, 991), 5000);
    assert_int_equal(ect_stats_quantile_us(&stats, 1000), 5000);
    assert_true(stats.longest_answer_ns == 3 * MS);
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
        {"answer times fall into their steps", answer_times, NULL, NULL, NULL},
        {"quantiles of the answer times", quantiles, NULL, NULL, NULL},
        {"runs of the devices that are late count", late_polls, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Counters", tests, NULL, NULL);
}
