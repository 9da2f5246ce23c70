/* SPDX-License-Identifier: MIT */
/* Flash as storage: each unit programmed once, whole and aligned; records survive a power cut at any moment. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ports/flash/flash.h"
#include "seams/record.h"

enum { AREA = 1024, FIRST = 0x8000, SECOND = 0xC000, MAGIC = 0x31544553 };
static const uint8_t units[] = {0, 1, 2, 4, 8, 16, 32}; /* 0: 1 */

/* --- a flash that refuses what a real one would ------------------------------------------------------------------- */

typedef struct chip {
    uint8_t memory[2][AREA];
    bool programmed[2][AREA];
    unsigned int unit;
    unsigned int work; /* erases and units programmed */
    unsigned int reads;
    unsigned int cut_at; /* the power fails in this one, counted from 1; 0 never */
    bool dead;
} chip_t;

static unsigned int area_of(uint32_t address)
{
    return address >= SECOND ? 1 : 0;
}

static uint32_t offset_of(uint32_t address, uint32_t length)
{
    uint32_t offset = address - (address >= SECOND ? SECOND : FIRST);
    assert_true(offset + length <= AREA);
    return offset;
}

static bool power_fails(chip_t *c)
{
    c->work++;
    c->dead |= c->work == c->cut_at;
    return c->dead;
}

static int flash_read(void *ctx, uint32_t address, void *buffer, uint32_t length)
{
    chip_t *c = ctx;
    c->reads++;
    memcpy(buffer, c->memory[area_of(address)] + offset_of(address, length), length);
    return c->dead ? -1 : 0;
}

static int flash_erase(void *ctx, uint32_t address, uint32_t length)
{
    chip_t *c = ctx;
    unsigned int area = area_of(address);
    bool whole = !c->dead;
    assert_int_equal(length, AREA);
    assert_int_equal(offset_of(address, length), 0);
    if (power_fails(c))
        length /= 2; /* the rest is as before */
    if (whole) {
        memset(c->memory[area], 0xFF, length);
        memset(c->programmed[area], 0, length);
    }
    return c->dead ? -1 : 0;
}

static int flash_program(void *ctx, uint32_t address, const void *data, uint32_t length)
{
    chip_t *c = ctx;
    unsigned int area = area_of(address);
    uint32_t at = offset_of(address, length);
    assert_true(length == c->unit && address % c->unit == 0);
    if (c->dead)
        return -1;
    for (uint32_t n = 0; n < length; n++) {
        assert_false(c->programmed[area][at + n]);
        c->programmed[area][at + n] = true;
        c->memory[area][at + n] = ((const uint8_t *)data)[n];
    }
    if (power_fails(c))
        c->memory[area][at + length - 1] = 0x5A; /* cut off in its middle */
    return c->dead ? -1 : 0;
}

static ect_flash_t flash_of(chip_t *c, uint8_t unit)
{
    c->unit = unit != 0 ? unit : 1;
    return (ect_flash_t){.area = {FIRST, SECOND},
                         .area_size = AREA,
                         .unit = unit,
                         .read = flash_read,
                         .erase = flash_erase,
                         .program = flash_program,
                         .ctx = c};
}

/* --- records on it ------------------------------------------------------------------------------------------------ */

/* A record of 200 bytes in pieces of uneven sizes. */
static bool save(const ect_storage_t *medium, uint8_t value)
{
    static const uint8_t pieces[] = {5, 1, 32, 7, 13, 2, 32, 32, 9, 32, 3, 32};
    ect_record_t newest, r;
    uint8_t data[32];
    memset(data, value, sizeof data);
    if (ect_record_find(medium, MAGIC, &newest) < 0 || !ect_record_begin(&r, &newest))
        return false;
    for (size_t n = 0; n < sizeof pieces; n++) {
        if (!ect_record_put(&r, data, pieces[n]))
            return false;
    }
    return ect_record_commit(&r, MAGIC);
}

/* The value of the newest record, 0 there is none. */
static uint8_t saved(const ect_storage_t *medium)
{
    ect_record_t r;
    uint8_t data[200];
    if (ect_record_find(medium, MAGIC, &r) <= 0)
        return 0;
    assert_int_equal(r.length, sizeof data);
    assert_true(ect_record_get(&r, 0, data, sizeof data));
    for (size_t n = 1; n < sizeof data; n++)
        assert_int_equal(data[n], data[0]);
    return data[0];
}

static void record_after_record(void **state)
{
    (void)state;
    for (size_t u = 0; u < sizeof units; u++) {
        chip_t *c = calloc(1, sizeof *c);
        ect_flash_t flash = flash_of(c, units[u]);
        const ect_storage_t medium = ect_flash_storage(&flash);
        assert_int_equal(medium.bank_size, AREA - (units[u] > 16 ? units[u] - 16 : 0));
        assert_int_equal(saved(&medium), 0);
        for (uint8_t value = 1; value < 20; value++) {
            assert_true(save(&medium, value));
            assert_int_equal(saved(&medium), value);
            ect_flash_t after = flash_of(c, units[u]); /* the power was off */
            const ect_storage_t again = ect_flash_storage(&after);
            assert_int_equal(saved(&again), value);
        }
        free(c);
    }
}

static void power_cuts(void **state)
{
    (void)state;
    for (size_t u = 0; u < sizeof units; u++) {
        bool finished = false;
        for (unsigned int k = 1; !finished; k++) {
            chip_t *c = calloc(1, sizeof *c);
            ect_flash_t flash = flash_of(c, units[u]);
            ect_storage_t medium = ect_flash_storage(&flash);
            assert_true(save(&medium, 1) && save(&medium, 2));
            c->work = 0;
            c->cut_at = k;
            finished = save(&medium, 3);
            c->dead = false;
            c->cut_at = 0;
            flash = flash_of(c, units[u]);
            medium = ect_flash_storage(&flash);
            uint8_t value = saved(&medium);
            if (value != 3 && (finished || value != 2))
                fail_msg("unit %u, power cut at work %u: the record is %u", units[u], k, value);
            assert_true(save(&medium, 4));
            assert_int_equal(saved(&medium), 4);
            free(c);
        }
    }
}

/* Bytes that are only gathered, over what is in the flash already. */
static void read_back_at_once(void **state)
{
    (void)state;
    for (size_t u = 0; u < sizeof units; u++) {
        chip_t *c = calloc(1, sizeof *c);
        ect_flash_t flash = flash_of(c, units[u]);
        const ect_storage_t m = ect_flash_storage(&flash);
        uint8_t got[70];
        assert_int_equal(m.erase(m.ctx, 0), 0);
        for (uint8_t n = 0; n < 50; n++) {
            assert_int_equal(m.write(m.ctx, 0, 16u + n, &n, 1), 0);
            assert_int_equal(m.read(m.ctx, 0, 10, got, sizeof got), 0);
            for (unsigned int i = 6; i < sizeof got; i++)
                assert_int_equal(got[i], i <= 6u + n ? i - 6 : 0xFF);
            got[1] = 0x77;
            assert_int_equal(m.read(m.ctx, 0, 15u + n, got, 1), 0); /* the byte before, and no more */
            assert_int_equal(got[0], n > 0 ? n - 1 : c->memory[0][15]);
            assert_int_equal(got[1], 0x77);
        }
        assert_int_equal(m.flush(m.ctx, 0, true), 0);
        assert_int_equal(m.flush(m.ctx, 0, true), 0);
        assert_int_equal(m.read(m.ctx, 0, 16, got, 50), 0);
        for (unsigned int i = 0; i < 50; i++)
            assert_int_equal(got[i], i);
        c->reads = 0;
        assert_int_equal(m.read(m.ctx, 0, 0, got, 16), 0);
        assert_int_equal(m.read(m.ctx, 0, 16, got, 50), 0);
        assert_int_equal(c->reads, 2); /* one of the header, one of what is behind it */
        assert_int_equal(m.read(m.ctx, 0, 0, got, 0), 0);
        c->dead = true;
        assert_int_equal(m.read(m.ctx, 0, 0, got, 16), -1);
        assert_int_equal(m.read(m.ctx, 0, 0, got, 17), -1);
        assert_int_equal(m.read(m.ctx, 0, 16, got, 1), -1);
        assert_int_equal(m.write(m.ctx, 0, 128, got, c->unit), -1);
        free(c);
    }
}

/* Into a unit that is programmed already, or may be. */
static void refused(void **state)
{
    chip_t *c = calloc(1, sizeof *c);
    ect_flash_t flash = flash_of(c, 8);
    const ect_storage_t m = ect_flash_storage(&flash);
    (void)state;
    assert_int_equal(m.erase(m.ctx, 1), 0);
    assert_int_equal(m.write(m.ctx, 1, 16, "abc", 3), 0);
    assert_int_equal(m.flush(m.ctx, 1, true), 0);
    assert_int_equal(m.write(m.ctx, 1, 19, "d", 1), -1);
    assert_int_equal(m.write(m.ctx, 1, 24, "e", 1), 0);
    c->dead = true;
    assert_int_equal(m.flush(m.ctx, 1, true), -1);
    assert_int_equal(m.erase(m.ctx, 1), -1);
    free(c);
}

/* A write at another place programs the gathered bytes first, however few, and fails with them. */
static void a_write_elsewhere(void **state)
{
    (void)state;
    for (unsigned int gathered = 1; gathered < 8; gathered++) {
        chip_t *c = calloc(1, sizeof *c);
        ect_flash_t flash = flash_of(c, 8);
        const ect_storage_t m = ect_flash_storage(&flash);
        uint8_t got[16];
        assert_int_equal(m.erase(m.ctx, 0), 0);
        assert_int_equal(m.write(m.ctx, 0, 16, "abcdefg", gathered), 0);
        assert_int_equal(m.write(m.ctx, 0, 32, "z", 1), 0);
        assert_int_equal(m.flush(m.ctx, 0, true), 0);
        assert_int_equal(m.read(m.ctx, 0, 16, got, sizeof got), 0);
        for (unsigned int n = 0; n < sizeof got; n++)
            assert_int_equal(got[n], n < gathered ? 'a' + n : 0xFF);
        assert_int_equal(m.read(m.ctx, 0, 32, got, 2), 0);
        assert_memory_equal(got, "z\xFF", 2);
        assert_int_equal(m.write(m.ctx, 0, 40, "abcdefg", gathered), 0);
        c->dead = true;
        assert_int_equal(m.write(m.ctx, 0, 64, "z", 1), -1);
        free(c);
    }
}

/* Bytes that wait for the rest of their unit are lost with the bank. */
static void erased_bank(void **state)
{
    chip_t *c = calloc(1, sizeof *c);
    ect_flash_t flash = flash_of(c, 8);
    const ect_storage_t m = ect_flash_storage(&flash);
    uint8_t got[4];
    (void)state;
    assert_int_equal(m.erase(m.ctx, 0), 0);
    assert_int_equal(m.write(m.ctx, 0, 16, "abc", 3), 0);
    assert_int_equal(m.erase(m.ctx, 0), 0);
    assert_int_equal(m.flush(m.ctx, 0, true), 0);
    assert_int_equal(m.read(m.ctx, 0, 16, got, sizeof got), 0);
    assert_memory_equal(got, "\xFF\xFF\xFF\xFF", sizeof got);
    free(c);
}

/* The last byte of a bank is the last one of its area, the first behind the header is behind the header's units. */
static void whole_area(void **state)
{
    (void)state;
    for (size_t u = 0; u < sizeof units; u++) {
        chip_t *c = calloc(1, sizeof *c);
        ect_flash_t flash = flash_of(c, units[u]);
        const ect_storage_t m = ect_flash_storage(&flash);
        assert_int_equal(m.erase(m.ctx, 1), 0);
        assert_int_equal(m.write(m.ctx, 1, 16, "A", 1), 0);
        assert_int_equal(m.flush(m.ctx, 1, true), 0);
        assert_int_equal(c->memory[1][c->unit > 16 ? c->unit : 16], 'A');
        assert_int_equal(m.write(m.ctx, 1, m.bank_size - c->unit, "ZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZZ", c->unit), 0);
        assert_int_equal(c->memory[1][AREA - 1], 'Z');
        free(c);
    }
}

static void memory_instead(void **state)
{
    static uint8_t memory[2 * AREA];
    ect_flash_t flash = {.area = {0, AREA}, .area_size = AREA, .memory = memory};
    const ect_storage_t medium = ect_flash_storage(&flash);
    (void)state;
    assert_int_equal(saved(&medium), 0);
    for (uint8_t value = 1; value < 5; value++) {
        assert_true(save(&medium, value));
        assert_int_equal(saved(&medium), value);
    }
    memset(memory, 0x5A, sizeof memory);
    assert_int_equal(medium.erase(medium.ctx, 1), 0);
    for (size_t n = 0; n < sizeof memory; n++)
        assert_int_equal(memory[n], n < AREA ? 0x5A : 0xFF);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"record after record, with units of 1 to 32 bytes, each programmed once", record_after_record, NULL, NULL,
         NULL},
        {"a power cut in any erase or unit leaves the record before, or the new one", power_cuts, NULL, NULL, NULL},
        {"Written data are read back at once", read_back_at_once, NULL, NULL, NULL},
        {"a write into a unit that may be programmed is refused, and a flash that fails is reported", refused, NULL,
         NULL, NULL},
        {"a write elsewhere programs the gathered bytes first", a_write_elsewhere, NULL, NULL, NULL},
        {"an erase drops bytes that wait for the rest of their unit", erased_bank, NULL, NULL, NULL},
        {"a bank ends with its area, and the header has whole units", whole_area, NULL, NULL, NULL},
        {"without a driver, memory", memory_instead, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("port_flash", tests, NULL, NULL);
}
