/* SPDX-License-Identifier: MIT */
#include "bus/chain/stats.h"
#include "wire/assert.h"

static const uint32_t edges_us[ECT_STATS_STEPS - 1] = {
    1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000, 100000, 200000, 500000, 1000000};

static void count(uint64_t counts[ECT_STATS_STEPS], uint64_t *longest_ns, uint64_t took_ns)
{
    size_t step = 0;
    while (step + 1 < ECT_STATS_STEPS && took_ns >= 1000ull * edges_us[step])
        step++;
    ECT_ASSERT(step < ECT_STATS_STEPS);
    counts[step]++;
    *longest_ns = took_ns > *longest_ns ? took_ns : *longest_ns;
}

void ect_stats_answer(ect_stats_t *stats, uint64_t took_ns)
{
    stats->answered++;
    count(stats->answers, &stats->longest_answer_ns, took_ns);
}

void ect_stats_kernel_answer(ect_stats_t *stats, uint64_t took_ns)
{
    stats->answered++;
    stats->in_kernel++;
    count(stats->kernel_answers, &stats->longest_kernel_ns, took_ns);
}

void ect_stats_poll(ect_stats_t *stats, uint64_t late_ns)
{
    stats->polls++;
    stats->late_polls += late_ns > ECT_STATS_LATE_NS ? 1 : 0;
    stats->latest_poll_ns = late_ns > stats->latest_poll_ns ? late_ns : stats->latest_poll_ns;
}

uint32_t ect_stats_edge_us(size_t step)
{
    return step + 1 < ECT_STATS_STEPS ? edges_us[step] : 0;
}

uint32_t ect_stats_quantile_us(const uint64_t counts[ECT_STATS_STEPS], unsigned int per_mille)
{
    ECT_ASSERT(per_mille <= 1000);
    uint64_t all = 0;
    uint64_t below = 0;
    for (size_t step = 0; step < ECT_STATS_STEPS; step++)
        all += counts[step];
    for (size_t step = 0; step < ECT_STATS_STEPS; step++) {
        below += counts[step];
        if (below > 0 && below * 1000u >= all * per_mille)
            return ect_stats_edge_us(step);
    }
    return 0;
}
