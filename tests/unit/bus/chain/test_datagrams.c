/* SPDX-License-Identifier: MIT */
/* Working counters of recurring datagrams (src/bus/chain/datagrams.h). */
#define _GNU_SOURCE
#include "bus/chain/datagrams.h"

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "support/wire.h"

enum { ROOM = 64 };

/* A returned frame of one datagram. @return its length */
static size_t build(uint8_t *frame, uint8_t command, uint32_t address, uint16_t bytes, uint16_t counter)
{
    memset(frame, 0, ROOM);
    ect_store_be16(frame + 12, 0x88A4);
    ect_store_le16(frame + 14, (uint16_t)(0x1000 | (12 + bytes)));
    frame[16] = command;
    ect_store_le32(frame + 18, address);
    ect_store_le16(frame + 22, bytes);
    ect_store_le16(frame + 26 + bytes, counter);
    return 28u + bytes;
}

static void count(ect_datagrams_t *d, uint8_t command, uint32_t address, uint16_t counter, uint64_t now_ns)
{
    uint8_t frame[ROOM];
    ect_datagrams_count(d, frame, build(frame, command, address, 4, counter), now_ns);
}

static void while_wanted(void **state)
{
    ect_datagrams_t d = {0};
    (void)state;
    count(&d, LRW, 0, 3, 0);
    assert_int_equal(d.count, 0);
    ect_datagrams_want(&d, 100, 200);
    count(&d, LRW, 0, 3, 199);
    count(&d, LRW, 0, 3, 200);
    assert_int_equal(d.all[0].replies, 1);
    ect_datagrams_want(&d, 199, 300); /* in time: it goes on */
    count(&d, LRW, 0, 3, 299);
    assert_int_equal(d.all[0].replies, 2);
    assert_true(d.all[0].seen_ns == 299);
    ect_datagrams_want(&d, 300, 400); /* too late: from zero */
    assert_int_equal(d.count, 0);
}

static void lower_counters(void **state)
{
    static const uint16_t counters[] = {3, 6, 3, 6, 0};
    ect_datagrams_t d = {0};
    (void)state;
    ect_datagrams_want(&d, 0, UINT64_MAX);
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++)
        count(&d, LRD, 0x10000, counters[i], i);
    assert_int_equal(d.count, 1);
    assert_int_equal(d.all[0].counter, 0);
    assert_int_equal(d.all[0].highest, 6);
    assert_int_equal(d.all[0].lower, 2); /* the first 3 was the highest by then */
    assert_int_equal(d.all[0].replies, 5);
}

static void counted_commands(void **state)
{
    static const struct {
        uint8_t command;
        uint32_t address, want;
        const char *name;
    } rows[] = {{LRD, 0x12345678, 0x12345678, "LRD"},
                {LWR, 1, 1, "LWR"},
                {LRW, 2, 2, "LRW"},
                {BRD, 0x01300002, 0x01300000, "BRD"},
                {ARMW, 0x09100003, 0x09100000, "ARMW"},
                {FRMW, 0x09101001, 0x09101001, "FRMW"},
                {NOP, 0, 0, NULL},
                {FPRD, 0, 0, NULL},
                {APWR, 0, 0, NULL},
                {BWR, 0, 0, NULL},
                {15, 0, 0, NULL},
                {255, 0, 0, NULL}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_datagrams_t d = {0};
        const char *name = ect_datagrams_name(rows[i].command);
        ect_datagrams_want(&d, 0, UINT64_MAX);
        count(&d, rows[i].command, rows[i].address, 1, 0);
        assert_int_equal(d.count, rows[i].name != NULL);
        assert_int_equal(name != NULL, rows[i].name != NULL);
        if (!name)
            continue;
        assert_string_equal(name, rows[i].name);
        assert_int_equal(d.all[0].address, rows[i].want);
        assert_int_equal(d.all[0].length, 4);
    }
}

/* Datagrams differ by command, address and length; one may have no data. */
static void different_datagrams(void **state)
{
    static const struct {
        uint8_t command;
        uint32_t address;
        uint16_t bytes;
        size_t count; /* of datagrams, after this one */
    } rows[] = {{LRW, 0, 4, 1}, {LRW, 0, 4, 1}, {LRD, 0, 4, 2}, {LRW, 1, 4, 3}, {LRW, 0, 5, 4}, {LRW, 0, 0, 5},
                {LRW, 0, 0, 5}, {LRW, 0, 4, 5}, {LRD, 0, 4, 5}, {LRW, 1, 4, 5}, {LRW, 0, 5, 5}};
    ect_datagrams_t d = {0};
    (void)state;
    ect_datagrams_want(&d, 0, UINT64_MAX);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[ROOM];
        const size_t length = build(frame, rows[i].command, rows[i].address, rows[i].bytes, 1);
        ect_datagrams_count(&d, frame, length, i);
        if (d.count != rows[i].count)
            fail_msg("row %zu: expected %zu datagrams, got %zu", i, rows[i].count, d.count);
    }
    assert_int_equal(d.all[0].replies, 3);
}

/* The newest ones are kept. */
static void many_datagrams(void **state)
{
    ect_datagrams_t d = {0};
    uint32_t seen = 0;
    (void)state;
    ect_datagrams_want(&d, 0, UINT64_MAX);
    for (uint32_t i = 0; i < ECT_DATAGRAMS + 3; i++)
        count(&d, LRW, i, 1, 10 + i);
    assert_int_equal(d.count, ECT_DATAGRAMS);
    for (size_t i = 0; i < d.count; i++)
        seen |= 1u << d.all[i].address;
    assert_int_equal(seen, 0xFFu << 3);
}

/* Two datagrams, in each form of a frame, and truncated at each byte: behind the last one is no memory. */
static void frames(void **state)
{
    static const struct {
        uint16_t type;
        size_t before; /* bytes between the type, or the tag, and the EtherCAT header */
        bool tag;
    } rows[] = {{0x88A4, 0, false}, {0x88A4, 0, true}, {0x0800, 28, false}, {0x0800, 28, true}, {0x0806, 0, false}};
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    uint8_t *pages = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    (void)state;
    assert_true(pages != MAP_FAILED);
    assert_int_equal(mprotect(pages + page, page, PROT_NONE), 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[128] = {0};
        size_t at = 12;
        if (rows[i].tag) {
            ect_store_be16(frame + at, 0x8100);
            at += 4;
        }
        ect_store_be16(frame + at, rows[i].type);
        at += 2 + rows[i].before;
        ect_store_le16(frame + at, 0x1000 | 26);
        at += 2;
        frame[at] = LRW;
        ect_store_le16(frame + at + 6, 0x8000 | 2);
        ect_store_le16(frame + at + 12, 9);
        frame[at + 14] = BRD;
        ect_store_le16(frame + at + 24, 2);
        const size_t first = at + 14, both = at + 26;
        for (size_t length = 0; length <= both; length++) {
            ect_datagrams_t d = {0};
            ect_datagrams_want(&d, 0, UINT64_MAX);
            memcpy(pages + page - length, frame, length);
            ect_datagrams_count(&d, pages + page - length, length, 0);
            assert_int_equal(d.count, rows[i].type == 0x0806 ? 0 : (length >= first) + (length >= both));
            assert_int_equal(d.all[0].counter, d.count > 0 ? 9 : 0);
        }
    }
    assert_int_equal(munmap(pages, 2 * page), 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Datagrams are counted until a time, and after it from zero", while_wanted, NULL, NULL, NULL},
        {"The highest working counter, and the replies below it", lower_counters, NULL, NULL, NULL},
        {"Broadcast reads, system times and logical commands are counted", counted_commands, NULL, NULL, NULL},
        {"Datagrams with another command, address or length are counted apart", different_datagrams, NULL, NULL, NULL},
        {"The newest of many datagrams are kept", many_datagrams, NULL, NULL, NULL},
        {"Tags, UDP and cut frames", frames, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Chain: working counters", tests, NULL, NULL);
}
