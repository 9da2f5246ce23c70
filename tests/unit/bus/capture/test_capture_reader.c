/* SPDX-License-Identifier: MIT */
/* Capture files read (src/bus/capture/reader.h): both formats, both byte orders, times of any resolution; and files
 * whose lengths and counts lie. */
#define _GNU_SOURCE
#include "bus/capture/reader.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus/capture/pcapng.h"
#include "seams/random.h"
#include "wire/bytes.h"

enum { ROOM = 65536, FRAME = 60 };

typedef struct file {
    uint8_t bytes[ROOM];
    size_t size;
    bool big; /* numbers are big-endian */
} file_t;

static void put32(file_t *f, uint32_t value)
{
    uint8_t *at = f->bytes + f->size;
    ect_store_le32(at, f->big ? value >> 24 | (value >> 8 & 0xFF00) | (value << 8 & 0xFF0000) | value << 24 : value);
    f->size += 4;
}

/* Two numbers of 16 bits. */
static void put16s(file_t *f, uint16_t first, uint16_t second)
{
    put32(f, f->big ? (uint32_t)first << 16 | second : (uint32_t)second << 16 | first);
}

static void put_section(file_t *f)
{
    put32(f, ECT_PCAPNG_SECTION);
    put32(f, 28);
    put32(f, ECT_PCAPNG_MAGIC);
    put16s(f, 1, 0);
    put32(f, UINT32_MAX);
    put32(f, UINT32_MAX);
    put32(f, 28);
}

/* The head of an interface block of `total` bytes. */
static void begin_interface(file_t *f, uint32_t total, uint16_t link)
{
    put32(f, ECT_PCAPNG_INTERFACE);
    put32(f, total);
    put16s(f, link, 0);
    put32(f, 0);
}

/* @param resolution  256: without the option */
static void put_interface(file_t *f, unsigned int resolution, uint16_t link)
{
    const uint32_t total = resolution < 256 ? 28 : 20;
    begin_interface(f, total, link);
    if (resolution < 256) {
        put16s(f, ECT_PCAPNG_RESOLUTION, 1);
        f->bytes[f->size] = (uint8_t)resolution;
        memset(f->bytes + f->size + 1, 0, 3);
        f->size += 4;
    }
    put32(f, total);
}

static void put_packet(file_t *f, uint32_t interface, uint64_t time, uint32_t captured, uint32_t length)
{
    const uint32_t total = 32 + FRAME;
    put32(f, ECT_PCAPNG_PACKET);
    put32(f, total);
    put32(f, interface);
    put32(f, (uint32_t)(time >> 32));
    put32(f, (uint32_t)time);
    put32(f, captured);
    put32(f, length);
    memset(f->bytes + f->size, 0x5A, FRAME);
    f->size += FRAME;
    put32(f, total);
}

static void put_pcap(file_t *f, uint32_t magic, uint32_t link)
{
    put32(f, magic);
    put16s(f, 2, 4);
    put32(f, 0);
    put32(f, 0);
    put32(f, 65535);
    put32(f, link);
}

static void put_pcap_packet(file_t *f, uint32_t seconds, uint32_t fraction, uint32_t captured)
{
    put32(f, seconds);
    put32(f, fraction);
    put32(f, captured);
    put32(f, captured);
    memset(f->bytes + f->size, 0x5A, FRAME);
    f->size += FRAME;
}

static ect_reader_t open_file(file_t *f)
{
    return (ect_reader_t){.file = fmemopen(f->bytes, f->size, "rb")};
}

static void close_file(ect_reader_t *r)
{
    fclose(r->file);
    ect_reader_free(r);
}

/* Reads to the end. @return the number of packets, the last one in *packet */
static size_t read_all(file_t *f, ect_item_t *packet, char *message)
{
    ect_reader_t r = open_file(f);
    ect_item_t item;
    size_t packets = 0;
    *message = 0;
    while (ect_reader_next(&r, &item) != ECT_ITEM_END) {
        if (item.kind == ECT_ITEM_PACKET) {
            *packet = item;
            packets++;
            for (size_t i = 0; i < item.captured; i++) /* every byte may be read */
                packet->interface ^= (uint32_t)item.bytes[i] & 0;
        }
        if (item.kind == ECT_ITEM_WRONG)
            strcpy(message, r.message);
    }
    assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_END);
    close_file(&r);
    return packets;
}

static void expect_time(file_t *f, uint64_t time_ns)
{
    char message[ECT_READER_MESSAGE];
    ect_item_t packet = {0};
    size_t packets = read_all(f, &packet, message);
    assert_string_equal(message, "");
    assert_int_equal(packets, 1);
    assert_int_equal(packet.captured, FRAME);
    assert_int_equal(packet.length, FRAME);
    assert_true(packet.time_ns == time_ns);
}

static void resolutions(void **state)
{
    static const struct {
        unsigned int resolution;
        uint64_t time, ns;
    } rows[] = {
        {256, 1500000, 1500000000},
        {6, 1500000, 1500000000},
        {9, 0x123456789A, 0x123456789A},
        {3, 1500, 1500000000},
        {0, 2, 2000000000},
        {10, 15000000009, 1500000000},
        {12, 1500000000999, 1500000000},
        {18, 1500000000999999999, 1500000000},
        {0x80 | 0, 2, 2000000000},
        {0x80 | 1, 3, 1500000000},
        {0x80 | 10, 1024 + 512, 1500000000},
        {0x80 | 32, (uint64_t)3 << 31, 1500000000},
        {0x80 | 60, (uint64_t)3 << 59, 1500000000},
        {0x80 | 34, ((uint64_t)1 << 35) - 1, 1999999999},
        {0x80 | 35, ((uint64_t)1 << 36) - 1, 1999999999},
        {0x80 | 60, ((uint64_t)1 << 61) - 1, 1999999999},
    };
    (void)state;
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        file_t f = {.big = i % 2 != 0};
        put_section(&f);
        put_interface(&f, rows[i / 2].resolution, 1);
        put_packet(&f, 0, rows[i / 2].time, FRAME, FRAME);
        expect_time(&f, rows[i / 2].ns);
    }
}

/* Options have lengths of their own, and are filled up to four bytes. */
static void options_before(void **state)
{
    enum { COMMENT = 1 };
    (void)state;
    for (uint32_t length = 0; length <= 9; length++) {
        const uint32_t padded = (length + 3) / 4 * 4, total = 32 + padded;
        file_t f = {0};
        put_section(&f);
        begin_interface(&f, total, 1);
        put16s(&f, COMMENT, (uint16_t)length);
        memset(f.bytes + f.size, ' ', padded);
        f.size += padded;
        put16s(&f, ECT_PCAPNG_RESOLUTION, 1);
        put32(&f, 3); /* milliseconds */
        put32(&f, total);
        put_packet(&f, 0, 1500, FRAME, FRAME);
        expect_time(&f, 1500000000);
    }
}

/* Behind the options are bytes of the previous block, which is longer. */
static void options_end_with_their_block(void **state)
{
    enum { OTHER = 0x0BAD, OPTIONS = 20, COMMENT = 1 };
    file_t f = {0};
    (void)state;
    put_section(&f);
    put32(&f, OTHER);
    put32(&f, 12 + 8 * OPTIONS);
    for (unsigned int i = 0; i < OPTIONS; i++) {
        put16s(&f, ECT_PCAPNG_RESOLUTION, 1);
        put32(&f, 3); /* milliseconds */
    }
    put32(&f, 12 + 8 * OPTIONS);
    begin_interface(&f, 28, 1);
    put16s(&f, COMMENT, 4);
    put32(&f, 0x20202020);
    put32(&f, 28);
    put_packet(&f, 0, 1500000, FRAME, FRAME);
    expect_time(&f, 1500000000); /* microseconds */
}

/* The place of a mistake is that of its block. */
static void place_of_a_mistake(void **state)
{
    char message[ECT_READER_MESSAGE];
    ect_item_t packet;
    file_t f = {0};
    (void)state;
    put_section(&f);
    put_interface(&f, 256, 1);
    put_packet(&f, 0, 1, FRAME, FRAME);
    put_packet(&f, 0, 2, FRAME, FRAME);
    put32(&f, ECT_PCAPNG_PACKET);
    put32(&f, 13);
    put32(&f, 0);
    assert_int_equal(read_all(&f, &packet, message), 2);
    assert_string_equal(message, "a block of 13 bytes, at byte 232");
}

/* A packet with an option behind its bytes. */
static void put_optioned(file_t *f, uint16_t code, uint16_t size, uint32_t value)
{
    const uint32_t total = 32 + FRAME + 12;
    put32(f, ECT_PCAPNG_PACKET);
    put32(f, total);
    put32(f, 0);
    put32(f, 0);
    put32(f, 1);
    put32(f, FRAME - 2); /* two bytes of padding */
    put32(f, 1500);
    memset(f->bytes + f->size, 0x5A, FRAME);
    f->size += FRAME;
    put16s(f, code, size);
    put32(f, value);
    put32(f, 0);
    put32(f, total);
}

/* Options that end with their block, without an end of their own. */
static void last_option(void **state)
{
    file_t f = {.size = 0};
    char message[ECT_READER_MESSAGE];
    ect_item_t packet = {0};
    (void)state;
    put_section(&f);
    put_interface(&f, 9, 1);
    put32(&f, ECT_PCAPNG_PACKET);
    put32(&f, 40);
    for (unsigned int i = 0; i < 5; i++)
        put32(&f, 0);
    put16s(&f, ECT_PCAPNG_FLAGS, 4);
    put32(&f, 2);
    put32(&f, 40);
    assert_int_equal(read_all(&f, &packet, message), 1);
    assert_string_equal(message, "");
    assert_int_equal(packet.direction, ECT_PCAPNG_OUTBOUND);
}

/* The two lowest bits of the flags; other options, and flags of another size, have no direction. */
static void directions(void **state)
{
    static const struct {
        uint16_t code, size;
        uint32_t value;
        unsigned int direction;
    } rows[] = {
        {ECT_PCAPNG_FLAGS, 4, 0, 0},
        {ECT_PCAPNG_FLAGS, 4, 1, ECT_PCAPNG_INBOUND},
        {ECT_PCAPNG_FLAGS, 4, 2, ECT_PCAPNG_OUTBOUND},
        {ECT_PCAPNG_FLAGS, 4, 0xFFFFFFFE, ECT_PCAPNG_OUTBOUND},
        {ECT_PCAPNG_FLAGS, 4, 0xFFFFFFFC, 0},
        {ECT_PCAPNG_FLAGS, 3, 1, 0},
        {ECT_PCAPNG_FLAGS, 2, 1, 0},
        {ECT_PCAPNG_FLAGS, 9, 1, 0}, /* beyond the block */
        {ECT_PCAPNG_FLAGS + 1, 4, 1, 0},
        {ECT_PCAPNG_FLAGS - 1, 4, 1, 0},
    };
    (void)state;
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        file_t f = {.big = i % 2 != 0};
        char message[ECT_READER_MESSAGE];
        ect_item_t packet = {0};
        put_section(&f);
        put_interface(&f, 9, 1);
        put_optioned(&f, rows[i / 2].code, rows[i / 2].size, rows[i / 2].value);
        assert_int_equal(read_all(&f, &packet, message), 1);
        assert_string_equal(message, "");
        assert_int_equal(packet.captured, FRAME - 2);
        assert_int_equal(packet.length, 1500);
        if (packet.direction != rows[i / 2].direction)
            fail_msg("option %u of %u bytes, %08X: expected direction %u, got %u", rows[i / 2].code, rows[i / 2].size,
                     (unsigned int)rows[i / 2].value, rows[i / 2].direction, packet.direction);
    }
}

/* A resolution has one byte; another size, and an option behind the end of the options, mean microseconds. */
static void no_resolution(void **state)
{
    static const struct {
        uint16_t first, size;
    } rows[] = {{0, 0}, {ECT_PCAPNG_RESOLUTION, 0}, {ECT_PCAPNG_RESOLUTION, 2}, {ECT_PCAPNG_RESOLUTION, 4}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint32_t padded = (rows[i].size + 3u) / 4 * 4, total = 20 + 4 + padded + 8;
        file_t f = {0};
        put_section(&f);
        begin_interface(&f, total, 1);
        put16s(&f, rows[i].first, rows[i].size);
        if (padded > 0)
            put32(&f, 3);
        put16s(&f, ECT_PCAPNG_RESOLUTION, 1);
        put32(&f, 3);
        put32(&f, total);
        put_packet(&f, 0, 1500000, FRAME, FRAME);
        expect_time(&f, 1500000000);
    }
}

/* The last interface that is read, packets of which less is in the file, and a block between them. */
static void each_item(void **state)
{
    enum { LAST = ECT_READER_INTERFACES - 1, OTHER = 0x0BAD };
    file_t f = {.size = 0};
    ect_item_t item;
    (void)state;
    put_section(&f);
    for (unsigned int i = 0; i <= LAST; i++)
        put_interface(&f, i == LAST ? 9 : 3, i == LAST ? 1 : 113);
    put_packet(&f, LAST, 7, 14, 1514);
    put32(&f, OTHER);
    put32(&f, 12);
    put32(&f, 12);
    f.size += ect_pcapng_local(f.bytes + f.size, "0123456789", 10);
    put_packet(&f, LAST, 8, 0, 0);
    ect_reader_t r = open_file(&f);
    assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_SECTION);
    assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_PACKET);
    assert_true(item.number == 1 && item.interface == LAST && item.time_ns == 7);
    assert_true(item.captured == 14 && item.length == 1514 && item.bytes[13] == 0x5A);
    assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_LOCAL);
    assert_int_equal(item.captured, 12);
    assert_memory_equal(item.bytes, "0123456789\0\0", 12);
    assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_PACKET);
    assert_true(item.number == 2 && item.time_ns == 8 && item.captured == 0 && item.length == 0);
    assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_END);
    close_file(&r);
}

static void each_packet_of_pcap(void **state)
{
    (void)state;
    for (unsigned int i = 0; i < 2; i++) {
        file_t f = {.big = i != 0};
        ect_item_t item;
        put_pcap(&f, 0xA1B23C4D, 0xF0000001); /* of Ethernet, with a length of the check sequence */
        put_pcap_packet(&f, 7, 5, FRAME);
        put32(&f, UINT32_MAX);
        put32(&f, 999999999);
        put32(&f, 4);
        put32(&f, 1514);
        put32(&f, 0x01010101);
        put32(&f, 0);
        put32(&f, 0);
        put32(&f, 61);
        put32(&f, 60);
        ect_reader_t r = open_file(&f);
        assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_SECTION);
        assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_PACKET);
        assert_true(item.number == 1 && item.time_ns == 7000000005 && item.captured == FRAME && item.length == FRAME);
        assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_PACKET);
        assert_true(item.number == 2 && item.time_ns == 4294967295999999999 && item.interface == 0);
        assert_true(item.captured == 4 && item.length == 1514 && item.bytes[3] == 1 && item.direction == 0);
        assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_WRONG);
        assert_string_equal(r.message, "a packet of 61 bytes, at byte 120");
        close_file(&r);
    }
}

static void old_format(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        file_t f = {.big = i % 2 != 0};
        put_pcap(&f, i < 2 ? 0xA1B2C3D4 : 0xA1B23C4D, 1);
        put_pcap_packet(&f, 7, 5, FRAME);
        expect_time(&f, i < 2 ? 7000005000 : 7000000005);
    }
}

static void sections_anew(void **state)
{
    file_t f = {.size = 0};
    char message[ECT_READER_MESSAGE];
    ect_item_t packet;
    (void)state;
    put_section(&f);
    put_interface(&f, 9, 1);
    put_packet(&f, 0, 1, FRAME, FRAME);
    f.big = true;
    put_section(&f);
    put_interface(&f, 9, 1);
    put_packet(&f, 0, 2, FRAME, FRAME);
    assert_int_equal(read_all(&f, &packet, message), 2);
    assert_int_equal(packet.time_ns, 2);
    assert_int_equal(packet.number, 2);
    put_section(&f);
    put_packet(&f, 0, 3, FRAME, FRAME);
    assert_int_equal(read_all(&f, &packet, message), 2);
    assert_non_null(strstr(message, "a packet of interface 0, which the file does not describe"));
}

typedef struct lie {
    const char *message;
    size_t at; /* of a number in the file of one packet below */
    uint32_t value;
    size_t cut; /* bytes that the file lacks at its end */
} lie_t;

/* Offsets: section 0, interface 28, packet 56. */
static void lies(void **state)
{
    static const lie_t rows[] = {
        {"no capture: the file is too short", 0, ECT_PCAPNG_SECTION, 145},
        {"no capture: neither pcapng nor pcap", 0, 0x12345678, 0},
        {"a section of an unknown byte order", 8, 0x11111111, 0},
        {"a block of 0 bytes", 60, 0, 0},
        {"a block of 13 bytes", 60, 13, 0},
        {"a block of 4294967292 bytes", 60, 0xFFFFFFFC, 0},
        {"a block of 2147483648 bytes", 32, 0x80000000, 0},
        {"the file ends within a block", 60, 96, 0},
        {"the file ends within a block", 0, ECT_PCAPNG_SECTION, 1},
        {"the file ends within a block", 0, ECT_PCAPNG_SECTION, 90},
        {"the file ends within a block", 0, ECT_PCAPNG_SECTION, 136},
        {"the file ends within a block", 0, ECT_PCAPNG_SECTION, 137},
        {"the file ends within a block", 0, ECT_PCAPNG_SECTION, 140},
        {"the file ends within a block", 0, ECT_PCAPNG_SECTION, 141},
        {"the file ends within a block", 0, ECT_PCAPNG_SECTION, 144},
        {"a block with two different lengths", 60, 88, 0},
        {"a block with two different lengths", 4, 12, 0},
        {"a packet of interface 1, which the file does not describe", 64, 1, 0},
        {"a packet of interface 4294967295, which the file does not describe", 64, UINT32_MAX, 0},
        {"a packet of 61 bytes in a block with 60", 68 + 8, 61, 0},
        {"a packet of 4294967295 bytes in a block with 60", 76, UINT32_MAX, 0},
        {"a packet of 60 bytes in a block with 60", 80, 59, 0},
        {"a packet that is not of Ethernet", 36, 113, 0},
        {"times that are too fine", 48, 19, 0},
        {"times that are too fine", 48, 0x80 | 61, 0},
        {"a packet without a time", 56, 3, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        file_t f = {.size = 0};
        char message[ECT_READER_MESSAGE];
        ect_item_t packet;
        put_section(&f);
        put_interface(&f, 9, 1);
        put_packet(&f, 0, 1, FRAME, FRAME);
        ect_store_le32(f.bytes + rows[i].at, rows[i].value);
        f.size -= rows[i].cut;
        assert_int_equal(read_all(&f, &packet, message), 0);
        if (strncmp(message, rows[i].message, strlen(rows[i].message)) != 0)
            fail_msg("row %zu: expected '%s', got '%s'", i, rows[i].message, message);
    }
}

/* A block of a type with a body of some bytes; a section begins with the mark of its byte order. */
static void short_blocks(void **state)
{
    static const struct {
        uint32_t type, least; /* bytes of a whole body */
        const char *message;
    } rows[] = {{ECT_PCAPNG_SECTION, 16, "a section header of %u bytes"},
                {ECT_PCAPNG_INTERFACE, 8, "an interface of %u bytes"},
                {ECT_PCAPNG_PACKET, 20, "a packet of %u bytes"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (uint32_t length = i == 0 ? 4 : 0; length <= rows[i].least; length += 4) {
            char message[ECT_READER_MESSAGE], want[ECT_READER_MESSAGE];
            ect_item_t packet;
            file_t f = {.size = 0};
            put_section(&f);
            put_interface(&f, 9, 1);
            put32(&f, rows[i].type);
            put32(&f, 12 + length);
            for (uint32_t at = 0; at < length; at += 4)
                put32(&f, i == 0 && at == 0 ? ECT_PCAPNG_MAGIC : i == 1 ? 1 : 0);
            put32(&f, 12 + length);
            snprintf(want, sizeof want, rows[i].message, (unsigned int)length);
            const size_t packets = read_all(&f, &packet, message);
            assert_int_equal(packets, length == rows[i].least && i == 2);
            if (length < rows[i].least)
                assert_memory_equal(message, want, strlen(want));
            else
                assert_string_equal(message, "");
        }
    }
}

static void old_lies(void **state)
{
    static const lie_t rows[] = {
        {"packets that are not of Ethernet", 20, 113, 0},
        {"a packet of 4294967295 bytes", 32, UINT32_MAX, 0},
        {"a packet of 61 bytes", 32, 61, 0},
        {"the file ends within a packet", 0, 0xA1B2C3D4, 1},
        {"the file ends within a packet", 0, 0xA1B2C3D4, 70},
        {"the file ends within its header", 0, 0xA1B2C3D4, 77},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        file_t f = {.size = 0};
        char message[ECT_READER_MESSAGE];
        ect_item_t packet;
        put_pcap(&f, 0xA1B2C3D4, 1);
        put_pcap_packet(&f, 7, 5, FRAME);
        ect_store_le32(f.bytes + rows[i].at, rows[i].value);
        f.size -= rows[i].cut;
        assert_int_equal(read_all(&f, &packet, message), 0);
        if (strncmp(message, rows[i].message, strlen(rows[i].message)) != 0)
            fail_msg("row %zu: expected '%s', got '%s'", i, rows[i].message, message);
    }
}

static void many_interfaces(void **state)
{
    file_t f = {.size = 0};
    char message[ECT_READER_MESSAGE];
    ect_item_t packet;
    (void)state;
    put_section(&f);
    for (int i = 0; i <= ECT_READER_INTERFACES; i++)
        put_interface(&f, 9, 1);
    assert_int_equal(read_all(&f, &packet, message), 0);
    assert_non_null(strstr(message, "more interfaces than are read"));
}

/* A head and a body of zeros. */
typedef struct large {
    uint8_t bytes[ECT_READER_BLOCK + 100];
    size_t size;
} large_t;

static void expect_large(large_t *l, ect_item_kind_t kind, const char *message)
{
    ect_reader_t r = {.file = fmemopen(l->bytes, l->size, "rb")};
    ect_item_t item;
    assert_int_equal(ect_reader_next(&r, &item), ECT_ITEM_SECTION);
    assert_int_equal(ect_reader_next(&r, &item), kind);
    assert_string_equal(r.message, message);
    if (kind != ECT_ITEM_WRONG)
        assert_int_equal(item.bytes[item.captured - 1], 0);
    close_file(&r);
}

static void largest_blocks(void **state)
{
    large_t *l = malloc(sizeof *l);
    (void)state;
    for (uint32_t more = 0; more <= 4; more += 4) {
        file_t f = {.size = 0};
        const uint32_t total = ECT_READER_BLOCK + 8 + more;
        put_section(&f);
        put32(&f, ECT_PCAPNG_LOCAL);
        put32(&f, total);
        *l = (large_t){.size = f.size - 8 + total};
        memcpy(l->bytes, f.bytes, f.size);
        ect_store_le32(l->bytes + l->size - 4, total);
        expect_large(l, more == 0 ? ECT_ITEM_LOCAL : ECT_ITEM_WRONG,
                     more == 0 ? "" : "a block of 1048588 bytes, at byte 28");
    }
    for (uint32_t more = 0; more <= 1; more++) {
        file_t f = {.size = 0};
        put_pcap(&f, 0xA1B2C3D4, 1);
        put32(&f, 0);
        put32(&f, 0);
        put32(&f, ECT_READER_BLOCK + more);
        put32(&f, ECT_READER_BLOCK + more);
        *l = (large_t){.size = f.size + ECT_READER_BLOCK + more};
        memcpy(l->bytes, f.bytes, f.size);
        expect_large(l, more == 0 ? ECT_ITEM_PACKET : ECT_ITEM_WRONG,
                     more == 0 ? "" : "a packet of 1048577 bytes, at byte 24");
    }
    free(l);
}

/* The reader goes back in a file of pcapng alone. */
static void pipes(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        file_t f = {.size = 0};
        int ends[2];
        ect_item_t item;
        if (i == 0) {
            put_pcap(&f, 0xA1B2C3D4, 1);
            put_pcap_packet(&f, 7, 5, FRAME);
        } else {
            put_section(&f);
        }
        assert_int_equal(pipe(ends), 0);
        assert_int_equal(write(ends[1], f.bytes, f.size), f.size);
        (void)close(ends[1]);
        ect_reader_t r = {.file = fdopen(ends[0], "rb")};
        assert_int_equal(ect_reader_next(&r, &item), i == 0 ? ECT_ITEM_SECTION : ECT_ITEM_WRONG);
        assert_string_equal(r.message, i == 0 ? "" : "no capture: neither pcapng nor pcap, at byte 0");
        assert_int_equal(ect_reader_next(&r, &item), i == 0 ? ECT_ITEM_PACKET : ECT_ITEM_END);
        close_file(&r);
    }
}

static void random_damage(void **state)
{
    enum { RUNS = 20000 };
    uint32_t seed = 1;
    (void)state;
    for (int run = 0; run < RUNS; run++) {
        file_t f = {.big = run % 3 == 0};
        char message[ECT_READER_MESSAGE];
        ect_item_t packet;
        if (run % 2 == 0) {
            put_section(&f);
            put_interface(&f, 9, 1);
            put_packet(&f, 0, 1, FRAME, FRAME);
            f.size += ect_pcapng_local(f.bytes + f.size, "0123456789", 10);
            put_packet(&f, 0, 2, FRAME, FRAME);
        } else {
            put_pcap(&f, 0xA1B2C3D4, 1);
            put_pcap_packet(&f, 7, 5, FRAME);
            put_pcap_packet(&f, 8, 5, FRAME);
        }
        for (uint32_t n = ect_random_next(&seed) % 6; n > 0; n--)
            f.bytes[ect_random_next(&seed) % f.size] ^= (uint8_t)(1u << ect_random_next(&seed) % 8);
        f.size -= ect_random_next(&seed) % 40;
        assert_in_range(read_all(&f, &packet, message), 0, 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"times of any resolution are nanoseconds, in both byte orders", resolutions, NULL, NULL, NULL},
        {"a mistake is reported with the first byte of its block", place_of_a_mistake, NULL, NULL, NULL},
        {"a resolution is found behind an option of any length", options_before, NULL, NULL, NULL},
        {"the options of an interface end with its block", options_end_with_their_block, NULL, NULL, NULL},
        {"pcap in microseconds and nanoseconds, in both byte orders", old_format, NULL, NULL, NULL},
        {"the direction is in the flags of a packet", directions, NULL, NULL, NULL},
        {"options end with their block", last_option, NULL, NULL, NULL},
        {"a resolution of another size than a byte, or behind the last option", no_resolution, NULL, NULL, NULL},
        {"packets and local data have numbers, times and both lengths", each_item, NULL, NULL, NULL},
        {"packets of pcap have numbers, times and both lengths; a mistake has its byte", each_packet_of_pcap, NULL,
         NULL, NULL},
        {"each section has interfaces and a byte order of its own", sections_anew, NULL, NULL, NULL},
        {"Attack: lengths and counts of pcapng that lie", lies, NULL, NULL, NULL},
        {"Attack: blocks of pcapng that are too short", short_blocks, NULL, NULL, NULL},
        {"Attack: lengths of pcap that lie", old_lies, NULL, NULL, NULL},
        {"Attack: interfaces without end", many_interfaces, NULL, NULL, NULL},
        {"Attack: blocks and packets of more than 1 MiB", largest_blocks, NULL, NULL, NULL},
        {"a pipe gives a file of pcap, and none of pcapng", pipes, NULL, NULL, NULL},
        {"Attack: damage at random", random_damage, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("capture_reader", tests, NULL, NULL);
}
