/* SPDX-License-Identifier: MIT */
/* The newest frames in memory (src/bus/capture/recent.h). */
#define _POSIX_C_SOURCE 200809L
#include "bus/capture/recent.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus/capture/reader.h"
#include "wire/bytes.h"

enum { PACKETS = 6, BODY_TIME = 12, BODY_FRAME = 28 };

/* The whole file, read in pieces of `piece` bytes; the caller frees it. */
static uint8_t *file_of(const ect_recent_t *r, size_t piece)
{
    const size_t size = ect_recent_size(r);
    uint8_t *file = malloc(size);
    assert_non_null(file);
    for (size_t at = 0; at < size; at += piece)
        ect_recent_read(r, at, file + at, size - at < piece ? size - at : piece);
    return file;
}

/* Checks that a file consists of a section, two interfaces and packets with rising numbers. @return their count */
static size_t check(const uint8_t *file, size_t size, uint32_t *first, uint32_t *last)
{
    static const uint32_t head[] = {ECT_PCAPNG_SECTION, ECT_PCAPNG_INTERFACE, ECT_PCAPNG_INTERFACE};
    size_t at = 0, blocks = 0, packets = 0;
    while (at < size) {
        const uint32_t length = ect_load_le32(file + at + 4);
        assert_true(length >= 12 && at + length <= size);
        assert_int_equal(ect_load_le32(file + at + length - 4), length);
        assert_int_equal(ect_load_le32(file + at), blocks < 3 ? head[blocks] : ECT_PCAPNG_PACKET);
        if (blocks++ >= 3) {
            const uint32_t number = ect_load_le32(file + at + BODY_FRAME);
            assert_true(packets == 0 || number == *last + 1);
            *first = packets == 0 ? number : *first;
            *last = number;
            packets++;
        }
        at += length;
    }
    assert_int_equal(at, size);
    return packets;
}

static void add(ect_recent_t *r, uint32_t number, size_t length)
{
    uint8_t frame[ECT_PCAPNG_FRAME_MOST + 100] = {0};
    ect_store_le32(frame, number);
    ect_recent_add(r, number % 2, number % 2 == 0 ? ECT_PCAPNG_INBOUND : ECT_PCAPNG_OUTBOUND, number * 1000u, frame,
                   length);
}

/* The packets of a file, from a number on, each as it was added by add(). `length` returns the length of a number. */
static void expect_packets(uint8_t *file, size_t size, uint32_t number, uint64_t offset_ns, size_t (*length)(uint32_t))
{
    ect_reader_t reader = {.file = fmemopen(file, size, "rb")};
    ect_item_t item;
    ect_item_kind_t kind;
    assert_non_null(reader.file);
    while ((kind = ect_reader_next(&reader, &item)) != ECT_ITEM_END) {
        assert_int_not_equal(kind, ECT_ITEM_WRONG);
        if (kind != ECT_ITEM_PACKET)
            continue;
        const size_t wanted = length(number);
        assert_int_equal(item.interface, number % 2);
        assert_int_equal(item.direction, number % 2 == 0 ? ECT_PCAPNG_INBOUND : ECT_PCAPNG_OUTBOUND);
        assert_true(item.time_ns == offset_ns + number * 1000ull);
        assert_int_equal(item.length, wanted);
        assert_int_equal(item.captured, wanted < ECT_PCAPNG_FRAME_MOST ? wanted : ECT_PCAPNG_FRAME_MOST);
        assert_int_equal(ect_load_le32(item.bytes), number);
        number++;
    }
    (void)fclose(reader.file);
    ect_reader_free(&reader);
}

static size_t rising(uint32_t number)
{
    return 60 + number;
}

static void a_few_frames(void **state)
{
    static const char *const names[2] = {"ecat0", NULL};
    static const size_t pieces[] = {1, 7, 400, 100000};
    ect_recent_t r = {0};
    uint32_t first = 0, last = 0;
    (void)state;
    add(&r, 1, 60); /* no capture */
    assert_int_equal(ect_recent_size(&r), 0);
    ect_recent_read(&r, 0, (uint8_t[1]){0}, 0);
    assert_true(ect_recent_start(&r, names, 5000000000ull));
    for (uint32_t i = 1; i <= PACKETS; i++)
        add(&r, i, 60 + i);
    ect_recent_stop(&r);
    add(&r, 99, 60);
    for (size_t i = 0; i < sizeof pieces / sizeof pieces[0]; i++) {
        uint8_t *file = file_of(&r, pieces[i]);
        assert_int_equal(check(file, ect_recent_size(&r), &first, &last), PACKETS);
        assert_int_equal(first, 1);
        const uint8_t *packet = file + r.head_length;
        assert_true(((uint64_t)ect_load_le32(packet + BODY_TIME) << 32 | ect_load_le32(packet + BODY_TIME + 4)) ==
                    5000001000ull);
        expect_packets(file, ect_recent_size(&r), 1, 5000000000ull, rising);
        free(file);
    }
    const uint32_t serial = r.serial;
    const size_t head = r.head_length;
    assert_true(ect_recent_start(&r, names, 0)); /* from nothing */
    assert_int_equal(r.serial, serial + 1);
    assert_int_equal(ect_recent_size(&r), head);
    ect_recent_free(&r);
    assert_int_equal(ect_recent_size(&r), 0);
}

enum { FRAMES = 2 * ECT_RECENT_BYTES / 800 };

static size_t varied(uint32_t number)
{
    return number < FRAMES ? 60 + number * 37 % 1454 : ECT_PCAPNG_FRAME_MOST + 100;
}

/* Twice as much as there is room for, of different lengths: the ring wraps within blocks. */
static void the_newest(void **state)
{
    static const char *const names[2] = {NULL, NULL};
    ect_recent_t r = {0};
    uint32_t first = 0, last = 0;
    (void)state;
    assert_true(ect_recent_start(&r, names, 0));
    for (uint32_t i = 0; i < FRAMES; i++) {
        add(&r, i, varied(i));
        assert_true(ect_recent_size(&r) <= r.head_length + ECT_RECENT_BYTES);
    }
    add(&r, FRAMES, varied(FRAMES)); /* cut */
    assert_true(ect_recent_size(&r) > ECT_RECENT_BYTES - 2 * ECT_PCAPNG_ROOM);
    uint8_t *file = file_of(&r, 4096);
    assert_true(check(file, ect_recent_size(&r), &first, &last) > 1000);
    assert_int_equal(last, FRAMES);
    assert_true(first > 0);
    expect_packets(file, ect_recent_size(&r), first, 0, varied);
    free(file);
    ect_recent_free(&r);
}

/* Blocks of 128 bytes fill the ring exactly. */
static void a_full_ring(void **state)
{
    static const char *const names[2] = {NULL, NULL};
    enum { BLOCK = 128, FRAME = 84, FIT = ECT_RECENT_BYTES / BLOCK };
    ect_recent_t r = {0};
    (void)state;
    assert_true(ect_recent_start(&r, names, 0));
    for (uint32_t i = 0; i < FIT + 2; i++) {
        uint32_t first = 0, last = 0;
        add(&r, i, FRAME);
        assert_int_equal(ect_recent_size(&r), r.head_length + (i < FIT ? i + 1 : FIT) * BLOCK);
        if (i + 1 < FIT)
            continue;
        uint8_t *file = file_of(&r, 100000);
        assert_int_equal(check(file, ect_recent_size(&r), &first, &last), FIT);
        assert_int_equal(first, i + 1 - FIT);
        free(file);
    }
    ect_recent_free(&r);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A capture is a pcapng file, in pieces of any size", a_few_frames, NULL, NULL, NULL},
        {"The newest 4 MiB of frames are kept, each whole", the_newest, NULL, NULL, NULL},
        {"Frames that fill the room exactly are all kept", a_full_ring, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Capture: the newest frames", tests, NULL, NULL);
}
