/* SPDX-License-Identifier: MIT */
/* Frames that circulate between two interfaces (src/bus/net/endless.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "bus/net/endless.h"
#include "wire/bytes.h"

#define MS 1000000ull
#define US 1000ull

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

/* Frames that circulate, and the counts that each end adds. */
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

/* Passes a frame back and forth; both ends add to it. @return rounds until it is noticed, 0 never */
static unsigned int circulate(ect_endless_t *endless, const round_t *what, uint64_t pause_ns)
{
    uint8_t frame[FRAME + 4];
    uint16_t position = 0;
    uint16_t counter = 0;
    for (unsigned int round = 1; round < 2000; round++) {
        size_t length = build_round(frame, what, position, counter);
        if (ect_endless_received(endless, frame, length, round * pause_ns))
            return round;
        position = (uint16_t)(position + what->step);
        counter = (uint16_t)(counter + what->count);
        length = build_round(frame, what, position, counter);
        ect_endless_sent(endless, frame, length);
        position = (uint16_t)(position + what->step);
        counter = (uint16_t)(counter + what->count);
    }
    return 0;
}

static void circulating_frames(void **state)
{
    static const round_t cases[] = {
        {"a broadcast that both ends count", BRD, 3, 3, false},  {"one for a slave that replies", FPRD, 0, 1, false},
        {"one without a slave that replies", FPRD, 0, 0, false}, {"process data", LRW, 0, 3, false},
        {"process data, with a VLAN tag", LRW, 0, 3, true},
    };
    (void)state;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        ect_endless_t endless = {0};
        unsigned int round = circulate(&endless, &cases[c], 30 * US);
        if (round != ECT_ENDLESS_MOST + 2) /* the first one comes from the master */
            fail_msg("%s: expected to be noticed in round %d, got %u", cases[c].what, ECT_ENDLESS_MOST + 2, round);
        ect_endless_t slow = {0};
        assert_int_equal(circulate(&slow, &cases[c], 1 * MS), 0);
    }
}

/* A master repeats a request as fast as it can: each time from the beginning. */
static void no_loop(void **state)
{
    ect_endless_t endless = {0};
    uint8_t frame[FRAME];
    (void)state;
    for (unsigned int i = 0; i < 5000; i++) {
        build(frame, BRD, 5, 0, 0);
        assert_false(ect_endless_received(&endless, frame, FRAME, i * 30 * US));
        build(frame, BRD, 5, 2, 2);
        ect_endless_sent(&endless, frame, FRAME);
        build(frame, FPRD, 5, 0x1001, 0); /* no slave replies, but the source address has been marked on the way */
        frame[6] = 0x01;
        assert_false(ect_endless_received(&endless, frame, FRAME, i * 30 * US));
        frame[6] = 0x03;
        ect_endless_sent(&endless, frame, FRAME);
    }
}

/* Each field of the first datagram counts, but its data; the position may wrap, and the others may not differ at all.
 */
static void one_field_differs(void **state)
{
    static const struct {
        const char *field;
        size_t at;
        uint8_t value;
        bool circles;
    } rows[] = {
        {"none", 26, 0, true},
        {"the source", 6, 0x07, false},
        {"the command", 16, LRW, false},
        {"the index", 17, 6, false},
        {"the position, more", 18, 0xFF, true},
        {"the position, less", 18, 0xFD, false},
        {"the position, half of the range more", 19, 0x90, false},
        {"the position, less than that", 19, 0x8F, true},
        {"the offset", 20, 0x31, false},
        {"the high byte of the offset", 21, 0x02, false},
        {"the length", 22, 3, false},
        {"a bit beside the length", 23, 0x80, true},
        {"the interrupt field", 24, 1, true},
        {"the data", 26, 0x55, true},
        {"the working counter, more", 29, 4, true},
        {"the working counter, less", 28, 1, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_endless_t endless = {0};
        uint8_t frame[FRAME];
        bool noticed = false;
        for (unsigned int n = 0; n <= ECT_ENDLESS_MOST; n++) {
            build(frame, FPRD, 5, 0x10FE, 0x0302);
            ect_endless_sent(&endless, frame, FRAME);
            frame[rows[i].at] = rows[i].value;
            noticed = ect_endless_received(&endless, frame, FRAME, 5 * MS);
        }
        if (noticed != rows[i].circles)
            fail_msg("%s differs: expected %d, got %d", rows[i].field, rows[i].circles, noticed);
    }
}

/* The last eight replies count; a window is 100 ms, and the 201st frame in it is one too many. */
static void bounds(void **state)
{
    static const struct {
        unsigned int others; /* replies after the one that circulates */
        unsigned int frames;
        uint64_t last_ns; /* when the last of them comes */
        bool circles;
    } rows[] = {
        {0, ECT_ENDLESS_MOST, 0, false},
        {0, ECT_ENDLESS_MOST + 1, 0, true},
        {ECT_ENDLESS_REMEMBERED - 1, ECT_ENDLESS_MOST + 1, 0, true},
        {ECT_ENDLESS_REMEMBERED, ECT_ENDLESS_MOST + 1, 0, false},
        {0, ECT_ENDLESS_MOST + 1, ECT_ENDLESS_WINDOW_NS - 1, true},
        {0, ECT_ENDLESS_MOST + 1, ECT_ENDLESS_WINDOW_NS, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint64_t begin_ns = 7 * ECT_ENDLESS_WINDOW_NS;
        ect_endless_t endless = {0};
        uint8_t frame[FRAME];
        bool noticed = false;
        build(frame, FPRD, 5, 0x1001, 1);
        ect_endless_sent(&endless, frame, FRAME);
        for (unsigned int n = 0; n < rows[i].others; n++) {
            build(frame, BRD, (uint8_t)(6 + n), 0, 0);
            ect_endless_sent(&endless, frame, FRAME);
        }
        build(frame, FPRD, 5, 0x1001, 1);
        for (unsigned int n = 1; n <= rows[i].frames; n++)
            noticed =
                ect_endless_received(&endless, frame, FRAME, begin_ns + (n == rows[i].frames ? rows[i].last_ns : 0));
        if (noticed != rows[i].circles)
            fail_msg("row %zu: expected %d, got %d", i, rows[i].circles, noticed);
    }
}

/* Too short, cut in its datagram, of another type: neither stored nor counted as one. */
static void not_to_be_read(void **state)
{
    ect_endless_t endless = {0};
    uint8_t frame[FRAME];
    (void)state;
    build(frame, BRD, 5, 2, 2);
    for (unsigned int i = 0; i < 3 * ECT_ENDLESS_MOST; i++) {
        size_t length = i % (16 + 10 + 2 + 2); /* one byte less than the datagram takes, at most */
        ect_endless_sent(&endless, frame, length);
        assert_false(ect_endless_received(&endless, frame, length, 0));
    }
    uint8_t udp[FRAME + 28] = {0}; /* the same behind headers of IP and UDP: one byte less than its datagram takes */
    memcpy(udp, frame, 14);
    udp[12] = 0x08;
    udp[13] = 0x00;
    memcpy(udp + 14 + 28, frame + 14, FRAME - 14);
    for (unsigned int i = 0; i < 3 * ECT_ENDLESS_MOST; i++) {
        ect_endless_sent(&endless, udp, 28 + 16 + 10 + 2 + 1);
        assert_false(ect_endless_received(&endless, udp, 28 + 16 + 10 + 2 + 1, 0));
    }
    frame[12] = 0x08;
    for (unsigned int i = 0; i < 3 * ECT_ENDLESS_MOST; i++) {
        ect_endless_sent(&endless, frame, FRAME);
        assert_false(ect_endless_received(&endless, frame, FRAME, 0));
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a frame that circulates is noticed, a slow one is a master's", circulating_frames, NULL, NULL, NULL},
        {"a master that repeats itself is no loop", no_loop, NULL, NULL, NULL},
        {"a frame circulates when its first datagram continues a reply", one_field_differs, NULL, NULL, NULL},
        {"eight replies are remembered, and 200 frames in 100 ms are no loop", bounds, NULL, NULL, NULL},
        {"A frame without a datagram is no circulating frame", not_to_be_read, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Endless frames", tests, NULL, NULL);
}
