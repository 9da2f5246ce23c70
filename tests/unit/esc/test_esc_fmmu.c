/* SPDX-License-Identifier: MIT */
/* FMMUs: windows of logical bits onto physical bits, against a model that moves one bit at a time (data sheet I
 * section 7). */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "esc/route.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { SLAVES = 2, RAM_KB = 8, MEMORY = 0x1000 + RAM_KB * 1024, DATA = 10, READS = 1, WRITES = 2 };

typedef struct rig {
    ect_esc_personality_t personality;
    uint8_t *memory[SLAVES]; /* each in its own allocation, so that a sanitizer detects its end */
    uint8_t sii[16];
    ect_esc_t esc[SLAVES];
    wire_t w;
    uint32_t random;
} rig_t;

static void power_on(rig_t *r, unsigned int i, uint8_t ram_kb)
{
    r->personality.ram_kb = ram_kb;
    free(r->memory[i]);
    r->memory[i] = malloc(0x1000 + ram_kb * 1024u);
    const ect_esc_config_t config = {.personality = &r->personality,
                                     .memory = r->memory[i],
                                     .sii = r->sii,
                                     .sii_size = sizeof r->sii,
                                     .open_ports = 1};
    assert_int_equal(ect_esc_init(&r->esc[i], &config, 1000), 0);
}

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->personality = *ect_esc_personality("et1100");
    ect_store_le16(r->sii + 14, 0x88A4); /* check value disabled */
    for (unsigned int i = 0; i < SLAVES; i++)
        power_on(r, i, RAM_KB);
    r->random = 0x2468ACE1;
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    for (unsigned int i = 0; i < SLAVES; i++)
        free(r->memory[i]);
    free(r);
    return 0;
}

static unsigned int send(rig_t *r, unsigned int slaves, uint8_t command, uint32_t address, void *data, uint16_t length)
{
    wire_build(&r->w, command, (uint16_t)address, (uint16_t)(address >> 16), data, length);
    for (unsigned int i = 0; i < slaves; i++)
        assert_int_equal(ect_esc_process(&r->esc[i], r->w.frame, r->w.frame_length, 1000), ECT_FRAME_FORWARD);
    memcpy(data, wire_datagram(&r->w, 0) + DATA, length);
    if (command >= LRD)
        assert_int_equal(ect_load_le32(wire_datagram(&r->w, 0) + 2), address);
    return wire_wkc(&r->w, 0);
}

typedef struct fmmu {
    uint32_t logical;
    uint16_t length;
    uint8_t start_bit, stop_bit;
    uint16_t physical;
    uint8_t physical_bit, type, active;
} fmmu_t;

static void set_fmmu(rig_t *r, unsigned int slave, unsigned int n, const fmmu_t *f)
{
    uint8_t m[13];
    ect_store_le32(m, f->logical);
    ect_store_le16(m + 4, f->length);
    m[6] = f->start_bit;
    m[7] = f->stop_bit;
    ect_store_le16(m + 8, f->physical);
    m[10] = f->physical_bit;
    m[11] = f->type;
    m[12] = f->active;
    wire_build(&r->w, APWR, 0, (uint16_t)(ECT_REG_FMMU + ECT_FMMU_SIZE * n), m, sizeof m);
    assert_int_equal(ect_esc_process(&r->esc[slave], r->w.frame, r->w.frame_length, 1000), ECT_FRAME_FORWARD);
}

static void fill(rig_t *r, uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        r->random ^= r->random << 13;
        r->random ^= r->random >> 17;
        r->random ^= r->random << 5;
        bytes[i] = (uint8_t)(r->random >> 8);
    }
}

static uint32_t below(rig_t *r, uint32_t limit)
{
    uint8_t bytes[4];
    fill(r, bytes, 4);
    return ect_load_le32(bytes) % limit;
}

static bool bit_of(const uint8_t *bytes, uint64_t bit)
{
    return ((unsigned int)bytes[bit / 8] >> (bit % 8) & 1u) != 0;
}

static void put_bit(uint8_t *bytes, uint64_t bit, bool value)
{
    uint8_t mask = (uint8_t)(1u << (bit % 8));
    bytes[bit / 8] = (uint8_t)(value ? bytes[bit / 8] | mask : bytes[bit / 8] & ~mask);
}

/* The model: bit by bit through one FMMU. @return whether a bit was moved */
static bool model(const fmmu_t *f, uint32_t logical, uint16_t length, uint8_t *data, uint8_t *memory, uint32_t size,
                  bool write)
{
    bool any = false;
    if (f->active == 0 || f->length == 0 || (f->type & (write ? WRITES : READS)) == 0)
        return false;
    uint64_t first = (uint64_t)f->logical * 8 + f->start_bit;
    uint64_t last = ((uint64_t)f->logical + f->length - 1) * 8 + f->stop_bit;
    for (uint64_t bit = first; bit <= last; bit++) {
        uint64_t physical = (uint64_t)f->physical * 8 + f->physical_bit + (bit - first);
        if (bit < (uint64_t)logical * 8 || bit >= ((uint64_t)logical + length) * 8 || physical >= size * 8ull)
            continue;
        uint64_t at = bit - (uint64_t)logical * 8;
        if (write)
            put_bit(memory, physical, bit_of(data, at));
        else
            put_bit(data, at, bit_of(memory, physical));
        any = true;
    }
    return any;
}

/* One datagram through one FMMU of slave 0, compared with the model in all its bytes. */
static void compare(rig_t *r, const fmmu_t *f, uint8_t command, uint32_t logical, uint16_t length)
{
    static uint8_t want_memory[MEMORY];
    uint8_t sent[1486], want[1486], got[1486];
    fill(r, sent, length);
    memcpy(want, sent, length);
    memcpy(got, sent, length);
    memcpy(want_memory, r->memory[0], MEMORY);
    bool reads = command != LWR && model(f, logical, length, want, want_memory, MEMORY, false);
    bool writes = command != LRD && model(f, logical, length, sent, want_memory, MEMORY, true);
    unsigned int gain = (reads ? 1u : 0u) + (writes ? (command == LRW ? 2u : 1u) : 0u);
    unsigned int wkc = send(r, 1, command, logical, got, length);
    for (unsigned int i = 0; i < length && memcmp(want, got, length) != 0; i++) {
        if (want[i] != got[i])
            fail_msg("FMMU 0x%X+%u bits %u..%u to 0x%04X.%u type %u, command %u at 0x%X+%u: data byte %u expected "
                     "0x%02X, got 0x%02X",
                     f->logical, f->length, f->start_bit, f->stop_bit, f->physical, f->physical_bit, f->type, command,
                     logical, length, i, want[i], got[i]);
    }
    if (wkc != gain || memcmp(want_memory, r->memory[0], MEMORY) != 0)
        fail_msg("FMMU 0x%X+%u bits %u..%u to 0x%04X.%u type %u, command %u at 0x%X+%u: expected WKC %u, got %u, "
                 "memory equal %d",
                 f->logical, f->length, f->start_bit, f->stop_bit, f->physical, f->physical_bit, f->type, command,
                 logical, length, gain, wkc, memcmp(want_memory, r->memory[0], MEMORY) == 0);
}

/* All overlaps of a datagram of 1 to 3 bytes with a window of whole bytes. */
static void whole_bytes(void **state)
{
    rig_t *r = *state;
    for (uint8_t type = 0; type < 4; type++) {
        for (uint16_t length = 0; length < 4; length++) {
            const fmmu_t f = {0x10000, length, 0, 7, 0x1100, 0, type, 1};
            set_fmmu(r, 0, 0, &f);
            for (uint8_t command = LRD; command <= LRW; command++) {
                for (uint32_t logical = 0x10000 - 4; logical < 0x10000 + 5; logical++) {
                    for (uint16_t n = 0; n < 6; n++)
                        compare(r, &f, command, logical, n);
                }
            }
        }
    }
}

/* Every start bit, stop bit and physical bit of windows of 1 to 3 bytes; writes only where bits are written. */
static void all_bits(void **state)
{
    rig_t *r = *state;
    fmmu_t f = {0x20000, 0, 0, 0, 0x0F00, 0, 3, 1};
    for (unsigned int bits = 0; bits < 512; bits++) {
        f.start_bit = bits & 7;
        f.stop_bit = (bits >> 3) & 7;
        f.physical_bit = (uint8_t)(bits >> 6);
        for (f.length = 1; f.length <= 3; f.length++) {
            if (f.length == 1 && f.stop_bit < f.start_bit)
                continue;
            f.type = 3;
            f.physical = 0x0F00;
            set_fmmu(r, 0, 0, &f);
            fill(r, r->memory[0] + 0x0F00, 4);
            for (uint32_t at = 0x20000 - 1; at < 0x20000 + 3; at++) {
                compare(r, &f, LRD, at, 2);
                compare(r, &f, LWR, at, 4);
                compare(r, &f, LRW, at, 3);
            }
            f.type = READS;
            f.physical = 0x1233;
            set_fmmu(r, 0, 0, &f);
            fill(r, r->memory[0] + 0x1230, 16);
            compare(r, &f, LRD, 0x20000, 3);
            compare(r, &f, LRW, 0x1FFFF, 6);
        }
    }
}

/* Outside 0x0F00..0x0F03 a write of bits writes whole bytes; the value of the adjacent bits is undefined. */
static void bits_written_to_ram(void **state)
{
    rig_t *r = *state;
    for (unsigned int bits = 0; bits < 512; bits++) {
        const fmmu_t f = {0x400, 3, bits & 7, (bits >> 3) & 7, 0x1101, (uint8_t)(bits >> 6), WRITES, 1};
        unsigned int count = 17u + f.stop_bit - f.start_bit;
        uint8_t data[3], sent[3];
        fill(r, sent, 3);
        memcpy(data, sent, 3);
        memset(r->memory[0] + 0x1100, 0x99, 6);
        set_fmmu(r, 0, 0, &f);
        assert_int_equal(send(r, 1, LWR, 0x400, data, 3), 1);
        assert_memory_equal(data, sent, 3);
        for (unsigned int i = 0; i < count; i++) {
            if (bit_of(r->memory[0] + 0x1101, f.physical_bit + i) != bit_of(sent, f.start_bit + i))
                fail_msg("window from bit %u to bit %u at physical bit %u: bit %u was not written", f.start_bit,
                         f.stop_bit, f.physical_bit, i);
        }
        unsigned int behind = (f.physical_bit + count + 7) / 8;
        if (r->memory[0][0x1100] != 0x99 || r->memory[0][0x1101 + behind] != 0x99)
            fail_msg("window from bit %u to bit %u at physical bit %u: bytes outside were changed", f.start_bit,
                     f.stop_bit, f.physical_bit);
    }
}

/* A window of bits that is longer than one piece: all its bits, and no adjacent byte. */
static void many_bits_written_to_ram(void **state)
{
    rig_t *r = *state;
    static const uint8_t fills[] = {0xFF, 0x00};
    for (unsigned int row = 0; row < 2 * 8; row++) {
        const uint8_t start_bit = (uint8_t)(row / 2), physical_bit = (uint8_t)(7 - row / 2);
        const fmmu_t f = {0x400, 300, start_bit, 6, 0x1101, physical_bit, WRITES, 1};
        unsigned int count = 299u * 8 + 7 - start_bit;
        uint8_t data[300];
        memset(data, fills[row % 2], sizeof data);
        memset(r->memory[0] + 0x1100, 0x99, 310);
        set_fmmu(r, 0, 0, &f);
        assert_int_equal(send(r, 1, LWR, 0x400, data, sizeof data), 1);
        for (unsigned int i = 0; i < count; i++) {
            if (bit_of(r->memory[0] + 0x1101, physical_bit + i) != (fills[row % 2] != 0))
                fail_msg("%u bits from bit %u to physical bit %u: bit %u was not written", count, start_bit,
                         physical_bit, i);
        }
        if (r->memory[0][0x1100] != 0x99 || r->memory[0][0x1101 + (physical_bit + count + 7) / 8] != 0x99)
            fail_msg("%u bits from bit %u to physical bit %u: bytes outside were changed", count, start_bit,
                     physical_bit);
    }
}

static void documented_example(void **state)
{
    rig_t *r = *state;
    const fmmu_t f = {0x10011, 3, 3, 0, 0x0F01, 1, WRITES, 1};
    uint8_t data[3] = {0xFF, 0xFF, 0xFF};
    set_fmmu(r, 0, 0, &f);
    assert_int_equal(send(r, 1, LWR, 0x10011, data, 3), 1);
    assert_memory_equal(r->memory[0] + 0x0F00, "\x00\xFE\x7F\x00", 4); /* 14 bits, 0x0F01.1 to 0x0F02.6 */
}

static void random_windows(void **state)
{
    rig_t *r = *state;
    for (unsigned int i = 0; i < 20000; i++) {
        bool bits = below(r, 2) == 0;
        fmmu_t f = {.logical = 0x1000 + below(r, 64),
                    .length = (uint16_t)(1 + below(r, i % 8 == 0 ? 400 : 20)),
                    .physical = (uint16_t)(0x1000 + below(r, 0x1E00)),
                    .stop_bit = 7,
                    .active = below(r, 16) != 0};
        f.type = (uint8_t)below(r, 4);
        if (bits) { /* bit-wise writes only where the chip supports them */
            f.start_bit = (uint8_t)below(r, 8);
            f.physical_bit = (uint8_t)below(r, 8);
            f.stop_bit = (uint8_t)(f.length == 1 ? f.start_bit + below(r, 8u - f.start_bit) : below(r, 8));
            f.type &= READS;
        }
        set_fmmu(r, 0, 0, &f);
        fill(r, r->memory[0] + 0x1000, 64);
        fill(r, r->memory[0] + f.physical, 128);
        uint16_t length = (uint16_t)(1 + below(r, i % 8 == 0 ? 500 : 40));
        compare(r, &f, (uint8_t)(LRD + below(r, 3)), 0x1000 + below(r, 80), length);
    }
}

static void limits_of_addresses(void **state)
{
    rig_t *r = *state;
    static const fmmu_t rows[] = {
        {0x00000000, 2, 0, 7, 0x1000, 0, 3, 1},     {0xFFFFFFFE, 2, 0, 7, 0x1000, 0, 3, 1},
        {0xFFFFFFFF, 1, 3, 5, 0x0F00, 2, 3, 1},     {0xFFFFFFFF, 0xFFFF, 0, 7, 0x1000, 0, 3, 1},
        {0xFFFFFFFF, 4, 1, 6, 0x0F00, 2, READS, 1}, {0x100, 0xFFFF, 0, 7, 0x1000, 0, 3, 1},
        {0x100, 8, 0, 7, MEMORY - 1, 0, 3, 1},      {0x100, 8, 0, 7, MEMORY, 0, 3, 1},
        {0x100, 8, 0, 7, 0xFFFF, 0, 3, 1},          {0x100, 1, 0, 7, 0xFFFF, 0, 3, 1},
        {0x100, 2, 1, 6, 0xFFFF, 3, READS, 1},      {0x100, 3, 1, 6, MEMORY, 3, READS, 1},
        {0x100, 300, 1, 6, 0xFFF0, 3, READS, 1},    {0x100, 300, 1, 6, MEMORY - 1, 3, READS, 1},
        {0x100, 1, 5, 2, 0x1000, 0, 3, 1},          {0x100, 8, 0, 7, 0x1000, 0, 0, 1},
        {0x100, 8, 0, 7, 0x1000, 0, 3, 0},          {0x100, 0, 0, 7, 0x1000, 0, 3, 1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        set_fmmu(r, 0, 0, &rows[i]);
        for (uint8_t command = LRD; command <= LRW; command++) {
            compare(r, &rows[i], command, rows[i].logical, 1);
            compare(r, &rows[i], command, rows[i].logical, 8);
            compare(r, &rows[i], command, rows[i].logical, 1486);
            compare(r, &rows[i], command, rows[i].logical - 4, 8);
            compare(r, &rows[i], command, rows[i].logical + 2, 4);
            compare(r, &rows[i], command, 0, 8);
            compare(r, &rows[i], command, 0xFFFFFFF8, 16);
        }
    }
}

/* 60 KB of RAM end at 0xFFFF: the part of a window before that still works. */
static void to_the_last_address(void **state)
{
    rig_t *r = *state;
    static const fmmu_t rows[] = {{0x100, 4, 0, 7, 0xFFFE, 0, 3, 1}, {0x100, 4, 1, 6, 0xFFFE, 0, READS, 1}};
    for (size_t i = 0; i < 2; i++) {
        uint8_t data[4] = {0};
        power_on(r, 0, 60);
        set_fmmu(r, 0, 0, &rows[i]);
        memset(r->memory[0] + 0xFFFE, 0xFF, 2);
        unsigned int wkc = send(r, 1, LRD, 0x100, data, 4);
        if (wkc != 1 || data[1] != 0xFF)
            fail_msg("row %zu: two bytes exist behind the FMMU: expected WKC 1 and 0xFF, got WKC %u and 0x%02X", i, wkc,
                     data[1]);
    }
}

static void several_fmmus(void **state)
{
    rig_t *r = *state;
    uint8_t data[16];
    for (unsigned int n = 0; n < 4; n++) {
        const fmmu_t f = {0x100 + 4 * n, 4, 0, 7, (uint16_t)(0x1100 + 16 * n), 0, (uint8_t)(1 + n % 2), 1};
        set_fmmu(r, 0, n, &f);
        memset(r->memory[0] + f.physical, 0xA0 + (int)n, 4);
    }
    memset(data, 0x11, sizeof data);
    assert_int_equal(send(r, 1, LRW, 0x100, data, 16), 3); /* once per direction, however many FMMUs */
    assert_memory_equal(data, "\xA0\xA0\xA0\xA0\x11\x11\x11\x11\xA2\xA2\xA2\xA2\x11\x11\x11\x11", 16);
    assert_memory_equal(r->memory[0] + 0x1110, "\x11\x11\x11\x11", 4);
    assert_memory_equal(r->memory[0] + 0x1130, "\x11\x11\x11\x11", 4);
    assert_int_equal(send(r, 1, LRD, 0x100, data, 16), 1);
    assert_int_equal(send(r, 1, LWR, 0x100, data, 16), 1);
    assert_int_equal(send(r, 1, LRD, 0x100, data, 4), 1); /* ends where the next one begins */
    /* One FMMU by two datagrams. */
    wire_build(&r->w, LRD, 0x100, 0, data, 2);
    wire_append(&r->w, LRD, 0x102, 0, data, 2);
    assert_int_equal(ect_esc_process(&r->esc[0], r->w.frame, r->w.frame_length, 1000), ECT_FRAME_FORWARD);
    assert_int_equal(wire_wkc(&r->w, 0) + wire_wkc(&r->w, 1), 2);
}

static void same_byte_twice_read(void **state)
{
    rig_t *r = *state;
    static const fmmu_t low = {0x100, 2, 0, 7, 0x1100, 0, READS, 1}, high = {0x101, 2, 0, 7, 0x1200, 0, READS, 1};
    uint8_t data[3] = {0};
    memset(r->memory[0] + 0x1100, 0x11, 2);
    memset(r->memory[0] + 0x1200, 0x22, 2);
    for (unsigned int swapped = 0; swapped < 2; swapped++) {
        set_fmmu(r, 0, swapped == 0 ? 2 : 5, &low);
        set_fmmu(r, 0, swapped == 0 ? 5 : 2, &high);
        assert_int_equal(send(r, 1, LRD, 0x100, data, 3), 1);
        assert_memory_equal(data, swapped == 0 ? "\x11\x11\x22" : "\x11\x22\x22", 3);
    }
}

static void same_byte_twice_written(void **state)
{
    rig_t *r = *state;
    static const fmmu_t low = {0x100, 2, 0, 7, 0x1100, 0, WRITES, 1}, high = {0x101, 2, 0, 7, 0x1200, 0, WRITES, 1};
    uint8_t data[3] = {0x51, 0x52, 0x53};
    set_fmmu(r, 0, 2, &low);
    set_fmmu(r, 0, 5, &high);
    assert_int_equal(send(r, 1, LWR, 0x100, data, 3), 1);
    assert_memory_equal(r->memory[0] + 0x1100, "\x51\x52", 2);
    if (memcmp(r->memory[0] + 0x1200, "\x00\x53", 2) != 0)
        fail_msg("logical byte 0x101 is FMMU 2's: FMMU 5 is expected to write 00 53, wrote %02X %02X",
                 r->memory[0][0x1200], r->memory[0][0x1201]);
}

/* A transfer of an FMMU counts, even if another FMMU maps the bits without memory. */
static void beside_nothing(void **state)
{
    static const struct {
        fmmu_t first, second;
    } rows[] = {{{0x100, 2, 0, 7, MEMORY, 0, READS, 1}, {0x100, 4, 0, 7, 0x1200, 0, READS, 1}},
                {{0x102, 2, 0, 7, MEMORY, 0, READS, 1}, {0x100, 4, 0, 7, 0x1200, 0, READS, 1}},
                {{0x101, 2, 0, 7, MEMORY, 0, READS, 1}, {0x100, 4, 0, 7, 0x1200, 0, READS, 1}}};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[4] = {0};
        set_fmmu(r, 0, 0, &rows[i].first);
        set_fmmu(r, 0, 1, &rows[i].second);
        assert_int_equal(send(r, 1, LRD, 0x100, data, 4), 1);
    }
}

/* The FMMUs that matter to a passing frame (esc/route.h): those that transfer data. */
static void route_of_fmmus(void **state)
{
    static const struct {
        fmmu_t f;
        uint8_t windows;
    } rows[] = {{{0x100, 4, 0, 7, 0x1000, 0, WRITES, 1}, 1}, {{0x100, 4, 0, 7, 0x0F00, 0, WRITES, 1}, 1},
                {{0x100, 4, 0, 7, 0x0F00, 0, READS, 1}, 1},  {{0x100, 4, 0, 7, 0x0FFF, 0, 3, 1}, 1},
                {{0x100, 0, 0, 7, 0x1000, 0, 3, 1}, 0},      {{0x100, 4, 0, 7, 0x1000, 0, 0, 1}, 0},
                {{0x100, 4, 0, 7, 0x1000, 0, 3, 0}, 0}};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esc_route_t route;
        set_fmmu(r, 0, 0, &rows[i].f);
        ect_esc_route(&r->esc[0], &route);
        if (route.window_count != rows[i].windows)
            fail_msg("row %zu: expected %u windows, got %u", i, rows[i].windows, route.window_count);
    }
    ect_esc_route_t route;
    uint8_t data[2] = {0x12, 0};
    ect_esc_route(&r->esc[0], &route);
    assert_false(route.al_status_new);
    for (unsigned int i = 0; i < 2; i++) { /* the first raises an event, the second finds it set */
        uint32_t routing = ect_esc_routing(&r->esc[0]);
        ect_esc_pdi_write(&r->esc[0], 0x0130, data, 2);
        assert_int_not_equal(ect_esc_routing(&r->esc[0]), routing);
    }
    ect_esc_route(&r->esc[0], &route);
    assert_true(route.al_status_new);
    assert_int_equal(route.al_status, 0x12);
    assert_int_equal(send(r, 1, APRD, 0x01300000, data, 2), 1);
    ect_esc_route(&r->esc[0], &route);
    assert_false(route.al_status_new);
}

static void loser_is_not_read(void **state)
{
    rig_t *r = *state;
    static const uint8_t sm[8] = {0x00, 0x12, 2, 0, 0x02, 0, 1, 0};
    static const fmmu_t first = {0x100, 2, 0, 7, 0x1100, 0, READS, 1}, mailbox = {0x100, 2, 0, 7, 0x1200, 0, READS, 1};
    uint8_t data[8];
    memcpy(data, sm, 8);
    assert_int_equal(send(r, 1, APWR, 0x08000000, data, 8), 1);
    ect_esc_pdi_write(&r->esc[0], 0x1200, "\x77\x77", 2);
    set_fmmu(r, 0, 0, &first);
    set_fmmu(r, 0, 1, &mailbox);
    assert_int_equal(send(r, 1, LRD, 0x100, data, 2), 1);
    if ((r->memory[0][0x0805] & ECT_SM_STATUS_FULL) == 0)
        fail_msg("FMMU 0 serves the bytes: the mailbox behind FMMU 1 must not be emptied, status 0x%02X",
                 r->memory[0][0x0805]);
}

static void sm_rules_apply(void **state)
{
    rig_t *r = *state;
    static const fmmu_t out = {0x100, 4, 0, 7, 0x1200, 0, WRITES, 1}, in = {0x104, 4, 0, 7, 0x1300, 0, READS, 1};
    uint8_t sm[16] = {0x00, 0x12, 4, 0, 0x64, 0, 1, 0, 0x00, 0x13, 4, 0, 0x20, 0, 1, 0};
    uint8_t data[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    assert_int_equal(send(r, 1, APWR, 0x08000000, sm, 16), 1);
    set_fmmu(r, 0, 0, &out);
    set_fmmu(r, 0, 1, &in);
    assert_int_equal(send(r, 1, LRW, 0x100, data, 8), 2); /* no inputs written so far */
    assert_memory_equal(data, "\1\2\3\4\5\6\7\10", 8);
    ect_esc_pdi_write(&r->esc[0], 0x1300, "ABCD", 4);
    assert_int_equal(send(r, 1, LRW, 0x100, data, 8), 3);
    assert_memory_equal(data, "\1\2\3\4ABCD", 8);
    uint8_t got[4] = {0};
    ect_esc_pdi_read(&r->esc[0], 0x1200, got, 4);
    assert_memory_equal(got, "\1\2\3\4", 4);
    /* The halves in two datagrams; the second half alone is refused. */
    assert_int_equal(send(r, 1, LWR, 0x102, data + 2, 2), 0);
    assert_int_equal(send(r, 1, LWR, 0x100, data, 2), 1);
    assert_int_equal(send(r, 1, LWR, 0x102, data + 2, 2), 1);
    assert_int_equal(send(r, 1, LRD, 0x106, data, 2), 0);
}

/* A long window that is not aligned to bytes, over a SyncManager: pieces inside, one access outside. */
static void long_unaligned_window(void **state)
{
    rig_t *r = *state;
    static const fmmu_t f = {0x100, 301, 3, 2, 0x1200, 0, READS, 1};
    uint8_t sm[8] = {0x00, 0x12, 0x2C, 0x01, 0x02, 0, 1, 0};
    uint8_t mail[300], data[301] = {0}, want[301] = {0};
    fill(r, mail, sizeof mail);
    assert_int_equal(send(r, 1, APWR, 0x08000000, sm, 8), 1);
    set_fmmu(r, 0, 0, &f);
    assert_int_equal(send(r, 1, LRD, 0x100, data, 301), 0);
    ect_esc_pdi_write(&r->esc[0], 0x1200, mail, 300);
    assert_int_equal(send(r, 1, LRD, 0x100, data, 301), 1);
    for (unsigned int bit = 0; bit < 2400; bit++)
        put_bit(want, bit + 3, bit_of(mail, bit));
    assert_memory_equal(data, want, 301);
    assert_int_equal(r->memory[0][0x0805] & ECT_SM_STATUS_FULL, 0);
}

/* Unreadable bits keep their value in the frame, in a window of bits as in one of bytes. */
static void unreadable_part(void **state)
{
    rig_t *r = *state;
    static const fmmu_t rows[] = {{0x100, 4, 0, 7, 0x11FE, 0, READS, 1},
                                  {0x100, 4, 0, 6, 0x11FE, 0, READS, 1},
                                  {0x100, 4, 0, 7, MEMORY - 2, 0, READS, 1},
                                  {0x100, 4, 0, 6, MEMORY - 2, 0, READS, 1}};
    uint8_t sm[8] = {0x00, 0x12, 8, 0, 0x02, 0, 1, 0};
    assert_int_equal(send(r, 1, APWR, 0x08000000, sm, 8), 1); /* an empty mailbox from 0x1200 */
    memset(r->memory[0] + 0x11FE, 0x55, 2);
    memset(r->memory[0] + MEMORY - 2, 0x55, 2);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[4] = {0xFF, 0xFF, 0xFF, 0xFF};
        set_fmmu(r, 0, 0, &rows[i]);
        assert_int_equal(send(r, 1, LRD, 0x100, data, 4), 1);
        if (memcmp(data, "\x55\x55\xFF\xFF", 4) != 0)
            fail_msg("row %zu (stop bit %u to 0x%04X): expected 55 55 FF FF, got %02X %02X %02X %02X", i,
                     rows[i].stop_bit, rows[i].physical, data[0], data[1], data[2], data[3]);
    }
}

/* The full bits of both slaves' input mailboxes side by side in one logical byte. */
static void mailbox_state(void **state)
{
    rig_t *r = *state;
    for (unsigned int s = 0; s < SLAVES; s++) {
        static const uint8_t sm[8] = {0x00, 0x11, 4, 0, 0x22, 0, 1, 0};
        const fmmu_t f = {0x09000000, 1, (uint8_t)(2 + s), (uint8_t)(2 + s), 0x080D, 3, READS, 1};
        uint8_t data[8];
        memcpy(data, sm, sizeof data);
        wire_build(&r->w, APWR, 0, 0x0808, data, 8);
        assert_int_equal(ect_esc_process(&r->esc[s], r->w.frame, r->w.frame_length, 1000), ECT_FRAME_FORWARD);
        set_fmmu(r, s, 2, &f);
    }
    for (unsigned int full = 0; full < 4; full++) {
        for (unsigned int s = 0; s < SLAVES; s++) {
            uint8_t mail[4] = {1, 2, 3, 4};
            if ((full >> s & 1) != 0) {
                ect_esc_pdi_write(&r->esc[s], 0x1100, mail, 4);
            } else {
                wire_build(&r->w, APRD, 0, 0x1100, mail, 4);
                assert_int_equal(ect_esc_process(&r->esc[s], r->w.frame, r->w.frame_length, 1000), ECT_FRAME_FORWARD);
            }
        }
        for (unsigned int before = 0; before < 256; before++) {
            uint8_t data = (uint8_t)before;
            assert_int_equal(send(r, SLAVES, LRD, 0x09000000, &data, 1), 2);
            if (data != ((before & 0xF3) | full << 2))
                fail_msg("full bits %u, byte sent 0x%02X: came back as 0x%02X", full, before, data);
        }
    }
}

/* Two slaves share a logical byte for digital outputs, bit by bit. */
static void shared_output_byte(void **state)
{
    rig_t *r = *state;
    static const fmmu_t f[SLAVES] = {{0x200, 1, 0, 3, 0x0F00, 0, WRITES, 1}, {0x200, 1, 4, 7, 0x0F00, 2, WRITES, 1}};
    for (unsigned int s = 0; s < SLAVES; s++)
        set_fmmu(r, s, 0, &f[s]);
    for (unsigned int value = 0; value < 256; value++) {
        uint8_t data = (uint8_t)value;
        r->memory[0][0x0F00] = 0xA0;
        r->memory[1][0x0F00] = 0x81;
        assert_int_equal(send(r, SLAVES, LWR, 0x200, &data, 1), 2);
        assert_int_equal(data, value);
        assert_int_equal(r->memory[0][0x0F00], 0xA0 | (value & 0x0F));
        assert_int_equal(r->memory[1][0x0F00], 0x81 | (value >> 4) << 2);
    }
}

/* SOEM's layout: all outputs, then all inputs; and the interleaved one: each slave's outputs and inputs in turn. */
static void two_slaves_in_one_lrw(void **state)
{
    rig_t *r = *state;
    static const uint32_t layouts[2][SLAVES][2] = {{{0, 4}, {2, 6}}, {{0, 2}, {4, 6}}};
    for (unsigned int layout = 0; layout < 2; layout++) {
        uint8_t data[8], want[8];
        for (unsigned int i = 0; i < 8; i++)
            want[i] = data[i] = (uint8_t)(0x90 + i);
        for (unsigned int s = 0; s < SLAVES; s++) {
            const fmmu_t out = {layouts[layout][s][0], 2, 0, 7, 0x1100, 0, WRITES, 1};
            const fmmu_t in = {layouts[layout][s][1], 2, 0, 7, 0x1200, 0, READS, 1};
            set_fmmu(r, s, 0, &out);
            set_fmmu(r, s, 1, &in);
            r->memory[s][0x1200] = want[in.logical] = (uint8_t)(0x10 + s);
            r->memory[s][0x1201] = want[in.logical + 1] = (uint8_t)(0x20 + s);
        }
        assert_int_equal(send(r, SLAVES, LRW, 0, data, 8), 6);
        assert_memory_equal(data, want, 8);
        for (unsigned int s = 0; s < SLAVES; s++)
            assert_int_equal(r->memory[s][0x1100], 0x90 + layouts[layout][s][0]);
    }
}

/* Read and write of the same bits: the read returns the previous value. */
static void read_before_write(void **state)
{
    rig_t *r = *state;
    static const fmmu_t f = {0x300, 2, 0, 7, 0x1100, 0, 3, 1};
    uint8_t data[2] = {0x11, 0x22};
    set_fmmu(r, 0, 7, &f);
    assert_int_equal(send(r, 1, LRW, 0x300, data, 2), 3);
    assert_memory_equal(data, "\0\0", 2);
    assert_memory_equal(r->memory[0] + 0x1100, "\x11\x22", 2);
}

static void twins_in_op(void **state)
{
    (void)state;
    const ect_device_t *devices[] = {&testdev, &testdev};
    wire_t w;
    wire_open(&w, devices, 2);
    for (unsigned int s = 0; s < 2; s++) {
        wire_set_fmmu(&w, s, 0, 3 * s, 3, 0, 7, 0x1200, 0, WRITES);
        wire_set_fmmu(&w, s, 1, 6 + 3 * s, 3, 0, 7, 0x1300, 0, READS);
        wire_go(&w, s, 8);
        testdev_of(&w, s)->in_u16 = (uint16_t)(0x4321 + s);
    }
    uint8_t data[12] = {1, 0x34, 0x12, 0, 0x78, 0x56};
    for (unsigned int cycle = 0; cycle < 3; cycle++) {
        assert_int_equal(wire_logical(&w, LRW, 0, data, 12), 6);
        wire_advance(&w, MS);
    }
    assert_int_equal(testdev_of(&w, 0)->out_u16, 0x1234);
    assert_int_equal(testdev_of(&w, 1)->out_u16, 0x5678);
    assert_int_equal(ect_load_le16(data + 6), 0x4321);
    assert_int_equal(ect_load_le16(data + 9), 0x4322);
    wire_close(&w);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-028: every overlap of a datagram and a window of bytes: data, memory and WKC as mapped", whole_bytes),
        TEST("CF-029: every start, stop and physical bit of windows of 1 to 3 bytes", all_bits),
        TEST("CF-029: bits are written to RAM, bytes outside the window are unchanged", bits_written_to_ram),
        TEST("CF-029: 2400 bits are written to RAM, bytes outside the window are unchanged", many_bits_written_to_ram),
        TEST("CF-029: the data sheet's example maps 14 bits", documented_example),
        TEST("CF-028 CF-029 CF-031: random windows and datagrams follow the bit-by-bit model", random_windows),
        TEST("CF-031: windows at the ends of both address spaces, of length 0, off or of no direction",
             limits_of_addresses),
        TEST("CF-031: a window over the last physical address maps the part before it", to_the_last_address),
        TEST("CF-028: several FMMUs in one datagram count once per direction; one FMMU by two datagrams",
             several_fmmus),
        TEST("CF-031: two FMMUs read the same logical byte: the lowest number serves it", same_byte_twice_read),
        TEST("CF-031: two FMMUs write the same logical byte: only the lowest number writes", same_byte_twice_written),
        TEST("CF-031: an FMMU that loses a byte to a lower one does not access its own mapped byte", loser_is_not_read),
        TEST("CF-031: an FMMU counts even if another one has the bits and no memory", beside_nothing),
        TEST("CF-028: the route lists the FMMUs that transfer data, and reports a new AL status", route_of_fmmus),
        TEST("CF-019 CF-028: behind an FMMU the SyncManager's rules hold", sm_rules_apply),
        TEST("CF-017 CF-029: a window that is not aligned reads a long mailbox from first to last byte",
             long_unaligned_window),
        TEST("CF-031: bits that cannot be read return as sent", unreadable_part),
        TEST("CF-020 CF-030: the mailbox state FMMU; two slaves share a byte without disturbing each other",
             mailbox_state),
        TEST("CF-029 CF-030: two slaves share a byte of digital outputs", shared_output_byte),
        TEST("CF-005 CF-032: one LRW over two slaves, outputs first or interleaved: each counts 3",
             two_slaves_in_one_lrw),
        TEST("CF-005: LRW reads before it writes", read_before_write),
        TEST("CF-032: two twins in OP exchange process data by one LRW", twins_in_op),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC FMMUs", tests, NULL, NULL);
}
