/* SPDX-License-Identifier: MIT */
/* What a run keeps beside the chain: late answers, counters, frames that go round (src/bus). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus/chain/stats.h"
#include "bus/faults/late.h"
#include "bus/net/endless.h"
#include "wire/bytes.h"

#define MS 1000000ull
#define US 1000ull

/* --- late answers ------------------------------------------------------------------------------------------------- */

static void assert_leaves(ect_late_t *late, uint64_t due_ns, uint8_t content)
{
    assert_true(ect_late_due(late) == due_ns);
    assert_null(ect_late_take(late, due_ns - 1));
    ect_late_frame_t *frame = ect_late_take(late, due_ns);
    assert_non_null(frame);
    assert_int_equal(frame->length, 60u + content);
    assert_int_equal(frame->frame[0], content);
    free(frame);
}

static void late_answers(void **state)
{
    /* When each is added, how late it is to be, and when it leaves: its own time, or when those before it have left. */
    static const struct {
        uint64_t came_ns, late_ns, leaves_ns;
    } frames[] = {
        {0, 3 * MS, 3 * MS},      {1 * MS, 3 * MS, 4 * MS}, {2 * MS, 0, 4 * MS},
        {2 * MS, 3 * MS, 5 * MS}, {9 * MS, 0, 9 * MS},
    };
    enum { COUNT = sizeof frames / sizeof frames[0] };
    ect_late_t late = {0};
    uint8_t content[128] = {0};
    (void)state;
    assert_true(ect_late_due(&late) == UINT64_MAX);
    for (uint8_t i = 0; i < COUNT; i++) {
        content[0] = i;
        assert_true(ect_late_add(&late, content, 60u + i, frames[i].came_ns + frames[i].late_ns));
    }
    for (uint8_t i = 0; i < COUNT; i++)
        assert_leaves(&late, frames[i].leaves_ns, i);
    assert_true(ect_late_due(&late) == UINT64_MAX);
    assert_null(ect_late_take(&late, UINT64_MAX));
    content[0] = 7; /* what has left holds up nobody */
    assert_true(ect_late_add(&late, content, 67, 1 * MS));
    assert_leaves(&late, 1 * MS, 7);
}

static void most_late_answers(void **state)
{
    ect_late_t late = {0};
    (void)state;
    for (unsigned int i = 0; i < ECT_LATE_MOST; i++)
        assert_true(ect_late_add(&late, (const uint8_t *)"x", 1, 5));
    assert_false(ect_late_add(&late, (const uint8_t *)"x", 1, 5));
    ect_late_clear(&late);
    assert_true(ect_late_due(&late) == UINT64_MAX);
    assert_true(ect_late_add(&late, (const uint8_t *)"x", 1, 5));
    ect_late_clear(&late);
}

/* --- counters ----------------------------------------------------------------------------------------------------- */

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

/* --- frames that go round ----------------------------------------------------------------------------------------- */

enum { FRAME = 60, BRD = 7, FPRD = 4, LRW = 12 };

static void build(uint8_t frame[FRAME], uint8_t command, uint8_t index, uint16_t position, uint16_t counter)
{
    memset(frame, 0, FRAME);
    frame[6] = 0x03;
    ect_store_be16(frame + 12, 0x88A4);
    ect_store_le16(frame + 14, 0x100E);
    frame[16] = command;
    frame[17] = index;
    ect_store_le16(frame + 18, position);
    ect_store_le16(frame + 20, 0x0130);
    ect_store_le16(frame + 22, 2);
    ect_store_le16(frame + 28, counter);
}

/* Frames that go round, and what each end adds to them. */
typedef struct round {
    const char *what;
    uint8_t command;
    uint16_t step, count;
    bool tagged;
} round_t;

/* @return its length */
static size_t build_round(uint8_t frame[FRAME + 4], const round_t *round, uint16_t position, uint16_t counter)
{
    build(frame, round->command, 5, position, counter);
    if (!round->tagged)
        return FRAME;
    memmove(frame + 16, frame + 12, FRAME - 12);
    ect_store_be16(frame + 12, 0x8100);
    return FRAME + 4;
}

/* What comes is what left, with what the other end added. @return after how many rounds it is noticed, 0 never */
static unsigned int go_round(ect_endless_t *circle, const round_t *what, uint64_t pause_ns)
{
    uint8_t frame[FRAME + 4];
    uint16_t position = 0;
    uint16_t counter = 0;
    for (unsigned int round = 1; round < 2000; round++) {
        size_t length = build_round(frame, what, position, counter);
        if (ect_endless_received(circle, frame, length, round * pause_ns))
            return round;
        position = (uint16_t)(position + what->step);
        counter = (uint16_t)(counter + what->count);
        length = build_round(frame, what, position, counter);
        ect_endless_sent(circle, frame, length);
        position = (uint16_t)(position + what->step);
        counter = (uint16_t)(counter + what->count);
    }
    return 0;
}

static void circling_frames(void **state)
{
    static const round_t cases[] = {
        {"a broadcast that both ends count", BRD, 3, 3, false}, {"one for a slave that answers", FPRD, 0, 1, false},
        {"one that nobody answers", FPRD, 0, 0, false},         {"process data", LRW, 0, 3, false},
        {"process data, with a VLAN tag", LRW, 0, 3, true},
    };
    (void)state;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        ect_endless_t circle = {0};
        unsigned int round = go_round(&circle, &cases[c], 30 * US);
        if (round != ECT_ENDLESS_MOST + 2) /* the first one comes from the master */
            fail_msg("%s: expected to be noticed in round %d, got %u", cases[c].what, ECT_ENDLESS_MOST + 2, round);
        ect_endless_t slow = {0};
        assert_int_equal(go_round(&slow, &cases[c], 1 * MS), 0);
    }
}

/* A master asks the same again and again, as fast as it can: each time from the beginning. */
static void no_circle(void **state)
{
    ect_endless_t circle = {0};
    uint8_t frame[FRAME];
    (void)state;
    for (unsigned int i = 0; i < 5000; i++) {
        build(frame, BRD, 5, 0, 0);
        assert_false(ect_endless_received(&circle, frame, FRAME, i * 30 * US));
        build(frame, BRD, 5, 2, 2);
        ect_endless_sent(&circle, frame, FRAME);
        build(frame, FPRD, 5, 0x1001, 0); /* nobody answers, but the source address has been marked on the way */
        frame[6] = 0x01;
        assert_false(ect_endless_received(&circle, frame, FRAME, i * 30 * US));
        frame[6] = 0x03;
        ect_endless_sent(&circle, frame, FRAME);
    }
}

/* Too short, cut in its datagram, of another type: neither remembered nor taken for one. */
static void not_to_be_read(void **state)
{
    ect_endless_t circle = {0};
    uint8_t frame[FRAME];
    (void)state;
    build(frame, BRD, 5, 2, 2);
    for (unsigned int i = 0; i < 3 * ECT_ENDLESS_MOST; i++) {
        size_t length = i % (16 + 10 + 2 + 2); /* one byte less than the datagram takes, at most */
        ect_endless_sent(&circle, frame, length);
        assert_false(ect_endless_received(&circle, frame, length, 0));
    }
    frame[12] = 0x08;
    for (unsigned int i = 0; i < 3 * ECT_ENDLESS_MOST; i++) {
        ect_endless_sent(&circle, frame, FRAME);
        assert_false(ect_endless_received(&circle, frame, FRAME, 0));
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"each late answer leaves at its own time, and none overtakes another", late_answers, NULL, NULL, NULL},
        {"more late answers than the limit are lost", most_late_answers, NULL, NULL, NULL},
        {"answer times fall into their steps", answer_times, NULL, NULL, NULL},
        {"quantiles of the answer times", quantiles, NULL, NULL, NULL},
        {"runs of the devices that are late count", late_polls, NULL, NULL, NULL},
        {"a frame that goes round is noticed, a slow one is a master's", circling_frames, NULL, NULL, NULL},
        {"a master that repeats itself is no circle", no_circle, NULL, NULL, NULL},
        {"what is no datagram is no circle", not_to_be_read, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Run", tests, NULL, NULL);
}
