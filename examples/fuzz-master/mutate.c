/* SPDX-License-Identifier: MIT */
/* A mutator of libFuzzer for records (wire.h): adds, changes, repeats and removes complete records, with values at the
 * limits of sizes, and with places that a master reads. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { HEAD = 2, RECORD = 8, ADD_WEIGHT = 3 };

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned int seed);

static unsigned int next(unsigned int *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

static unsigned int below(unsigned int *seed, unsigned int limit)
{
    return next(seed) % limit;
}

static unsigned int value_of(unsigned int *seed)
{
    static const uint16_t limits[] = {0,    1,    2,    3,    4,    7,    8,      10,     16,     31,    32,
                                      63,   64,   127,  128,  255,  256,  511,    512,    1023,   1024,  1485,
                                      1486, 1500, 2047, 2048, 4095, 4096, 0x7FFF, 0x8000, 0xFFFE, 0xFFFF};
    return below(seed, 4) == 0 ? next(seed) & 0xFFFF : limits[below(seed, sizeof limits / sizeof limits[0])];
}

/* Selects the word, register, mail or reply that a record of a kind changes. */
static unsigned int place_of(unsigned int kind, unsigned int *seed)
{
    static const uint16_t registers[] = {0x000, 0x004, 0x005, 0x008, 0x012, 0x110, 0x111, 0x130, 0x131, 0x134, 0x502,
                                         0x503, 0x508, 0x805, 0x80D, 0x80E, 0x900, 0x904, 0x908, 0x910, 0x918, 0x92C};
    switch (kind) {
    case 0:
        return below(seed, 3) == 0 ? below(seed, 0x40) : 0x40 + below(seed, 0x300);
    case 1:
        return registers[below(seed, sizeof registers / sizeof registers[0])];
    case 2:
    case 3:
        return below(seed, 40);
    default:
        return 1 + below(seed, 300);
    }
}

/* Selects an offset: in a mail mostly in its headers, in a frame mostly in the first datagram; for a register the
 * number of the read. */
static unsigned int offset_of(unsigned int kind, unsigned int *seed)
{
    return below(seed, 8) == 0 ? next(seed) & 0x7FF : below(seed, kind == 4 ? 64 : kind == 1 ? 8 : 24);
}

static void put(uint8_t *p, unsigned int value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
}

static void make_record(uint8_t *p, unsigned int *seed)
{
    unsigned int kind = below(seed, 5);
    p[0] = (uint8_t)kind;
    p[1] = (uint8_t)below(seed, kind == 0 ? 2 : 8);
    put(p + 2, place_of(kind, seed));
    put(p + 4, offset_of(kind, seed));
    put(p + 6, value_of(seed));
}

static void change_record(uint8_t *p, unsigned int *seed)
{
    switch (below(seed, 5)) {
    case 0:
        p[1] = (uint8_t)below(seed, 8);
        return;
    case 1:
        put(p + 2, place_of(p[0] % 5, seed));
        return;
    case 2:
        put(p + 4, offset_of(p[0] % 5, seed));
        return;
    case 3:
        put(p + 6, value_of(seed));
        return;
    default:
        put(p + 2, (unsigned int)(p[2] | p[3] << 8) + (below(seed, 2) == 0 ? 1 : 0xFFFF));
    }
}

static size_t insert(uint8_t *data, size_t size, size_t at, const uint8_t *record)
{
    memmove(data + at + RECORD, data + at, size - at);
    memcpy(data + at, record, RECORD);
    return size + RECORD;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned int seed)
{
    uint8_t record[RECORD];
    unsigned int random = seed;
    if (size < HEAD || below(&random, 16) == 0)
        return LLVMFuzzerMutate(data, size, room);
    size_t count = (size - HEAD) / RECORD;
    uint8_t *chosen = data + HEAD + (count > 0 ? below(&random, (unsigned int)count) : 0) * RECORD;
    unsigned int action = below(&random, ADD_WEIGHT + 5);
    if ((action < ADD_WEIGHT || count == 0) && size + RECORD <= room) {
        make_record(record, &random);
        return insert(data, size, HEAD + below(&random, (unsigned int)count + 1) * RECORD, record);
    }
    if (action == ADD_WEIGHT && size + RECORD <= room) {
        memcpy(record, chosen, RECORD);
        return insert(data, size, (size_t)(chosen - data), record);
    }
    if (action == ADD_WEIGHT + 1 && count > 0) {
        memmove(chosen, chosen + RECORD, size - (size_t)(chosen - data) - RECORD);
        return size - RECORD;
    }
    if (action == ADD_WEIGHT + 2)
        data[below(&random, HEAD)] ^= (uint8_t)(1u << below(&random, 8));
    else if (count > 0)
        change_record(chosen, &random);
    return size;
}
