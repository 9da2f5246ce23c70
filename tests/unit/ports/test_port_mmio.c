/* SPDX-License-Identifier: MIT */
/* An ESC mapped into memory: which bytes are touched, how, and the whole slave behind buses of three widths. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ports/mmio/cost.h"
#include "ports/mmio/mmio.h"
#include "support/testdev.h"
#include "support/wire.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

enum { RAM = 0x1000, PARTS = 128 };
static const uint8_t widths[] = {1, 2, 4};

/* --- the processor's own accesses, to memory ---------------------------------------------------------------------- */

/* The memory has exactly the range of the access: a wider access leaves the memory, which the address sanitizer
 * reports. */
static void direct(void **state)
{
    static const uint8_t configured[] = {0, 1, 2, 4}; /* 0: the widest */
    (void)state;
    for (size_t w = 0; w < COUNT(configured); w++) {
        for (uint16_t offset = 0; offset < 8; offset++) {
            for (uint16_t length = 1; length < 40; length++) {
                uint8_t want[40], got[40] = {0};
                uint8_t *exact = malloc(offset + length); /* aligned for anything, and no room behind it */
                assert_non_null(exact);
                ect_mmio_t esc = {.base = exact, .width = configured[w]};
                ect_pdi_t pdi = ect_mmio_pdi(&esc);
                for (unsigned int n = 0; n < length; n++)
                    exact[offset + n] = want[n] = (uint8_t)(37 * n + length);
                assert_int_equal(pdi.read(pdi.ctx, offset, got, length), 0);
                assert_memory_equal(got, want, length);
                memset(exact, 0xEE, offset + length);
                assert_int_equal(pdi.write(pdi.ctx, offset, want, length), 0);
                assert_memory_equal(exact + offset, want, length);
                for (unsigned int n = 0; n < offset; n++)
                    assert_int_equal(exact[n], 0xEE);
                free(exact);
            }
        }
    }
}

/* Against the memory of the software ESC, registers and process RAM as they lie there. */
static void software_esc_memory(void **state)
{
    wire_t w;
    (void)state;
    wire_open_one(&w, &testdev);
    for (size_t n = 0; n < COUNT(widths); n++) {
        ect_esc_t *chip = ect_chain_esc(w.chain, 0);
        ect_mmio_t esc = {.base = chip->memory, .width = widths[n]};
        ect_pdi_t pdi = ect_mmio_pdi(&esc);
        uint8_t type[10];
        assert_true(ect_mmio_ready(&esc));
        assert_int_equal(pdi.read(pdi.ctx, ECT_REG_TYPE, type, sizeof type), 0);
        assert_memory_equal(type, chip->memory, sizeof type);
        assert_int_equal(pdi.write(pdi.ctx, RAM + 3, "ectwin", 6), 0);
        assert_memory_equal(chip->memory + RAM + 3, "ectwin", 6);
    }
    wire_close(&w);
}

static void not_ready(void **state)
{
    static const struct {
        uint8_t type, status;
        bool ready;
    } rows[] = {{0x11, 0x01, true}, {0x11, 0x00, false}, {0x00, 0x00, false}, {0xFF, 0xFF, false}, {0xC0, 0x31, true}};
    (void)state;
    for (size_t n = 0; n < COUNT(rows); n++) {
        uint8_t memory[0x200] = {0};
        ect_mmio_t esc = {.base = memory, .width = 2};
        memory[ECT_REG_TYPE] = rows[n].type;
        memory[ECT_REG_DL_STATUS] = rows[n].status;
        assert_int_equal(ect_mmio_ready(&esc), rows[n].ready);
    }
}

/* --- a bus that is watched ---------------------------------------------------------------------------------------- */

typedef struct board {
    wire_t w;
    ect_pdi_t real;
    ect_mmio_t esc;
    ect_pdi_t pdi;
    ect_slave_t *slave;
    unsigned int parts;
    struct {
        uint16_t address;
        uint8_t bytes;
    } part[PARTS];
    bool broken;
} board_t;

static void note(board_t *b, uint16_t address, unsigned int bytes)
{
    assert_true(bytes == 1 || bytes == 2 || bytes == 4);
    assert_true(bytes <= b->esc.width && address % bytes == 0);
    if (b->parts < PARTS) {
        b->part[b->parts].address = address;
        b->part[b->parts].bytes = (uint8_t)bytes;
    }
    b->parts++;
}

static int load(void *ctx, uint16_t address, unsigned int bytes, uint32_t *value)
{
    board_t *b = ctx;
    uint8_t word[4] = {0xA5, 0xA5, 0xA5, 0xA5}; /* the other bytes are undefined */
    note(b, address, bytes);
    assert_int_equal(b->real.read(b->real.ctx, address, word, (uint16_t)bytes), 0);
    *value = ect_load_le32(word);
    return b->broken ? -1 : 0;
}

static int store(void *ctx, uint16_t address, unsigned int bytes, uint32_t value)
{
    board_t *b = ctx;
    uint8_t word[4];
    note(b, address, bytes);
    ect_store_le32(word, value);
    if (!b->broken)
        assert_int_equal(b->real.write(b->real.ctx, address, word, (uint16_t)bytes), 0);
    return b->broken ? -1 : 0;
}

static bool line(void *ctx)
{
    return ect_esc_line(((board_t *)ctx)->real.ctx);
}

static void board_open(board_t *b, uint8_t width)
{
    memset(b, 0, sizeof *b);
    wire_open_one(&b->w, &testdev);
    b->slave = (ect_slave_t *)(uintptr_t)ect_chain_slave(b->w.chain, 0);
    b->real = *b->slave->config.pdi;
    b->esc = (ect_mmio_t){.width = width, .load = load, .store = store, .ctx = b};
    b->pdi = ect_mmio_pdi(&b->esc);
}

static void start(board_t *b)
{
    ect_slave_config_t config = b->slave->config;
    config.pdi = &b->pdi;
    memset(config.instance, 0, config.device->instance_size);
    assert_int_equal(ect_slave_init(b->slave, &config, b->w.now_ns), 0);
}

static void parts(void **state)
{
    static const struct {
        uint8_t width;
        uint16_t address, length;
        unsigned int parts;
    } rows[] = {{4, 0x1000, 64, 16}, {4, 0x1000, 3, 2},   {4, 0x1000, 7, 3}, {4, 0x1001, 7, 3}, {4, 0x1002, 4, 2},
                {4, 0x0120, 2, 1},   {2, 0x1000, 64, 32}, {2, 0x1001, 3, 2}, {2, 0x1001, 4, 3}, {1, 0x1000, 5, 5}};
    (void)state;
    for (size_t n = 0; n < COUNT(rows); n++) {
        board_t b;
        uint8_t bytes[64];
        board_open(&b, rows[n].width);
        for (unsigned int write = 0; write <= 1; write++) {
            uint32_t at = rows[n].address;
            b.parts = 0;
            if (write != 0)
                assert_int_equal(b.pdi.write(b.pdi.ctx, rows[n].address, bytes, rows[n].length), 0);
            else
                assert_int_equal(b.pdi.read(b.pdi.ctx, rows[n].address, bytes, rows[n].length), 0);
            assert_int_equal(b.parts, rows[n].parts);
            assert_int_equal(ect_mmio_cost(rows[n].address, rows[n].length, rows[n].width), rows[n].parts);
            for (unsigned int i = 0; i < b.parts; i++) {
                assert_int_equal(b.part[i].address, at);
                at += b.part[i].bytes;
            }
            assert_int_equal(at, rows[n].address + rows[n].length);
        }
        wire_close(&b.w);
    }
}

static void boot_to_op(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(widths); n++) {
        for (unsigned int with_line = 0; with_line <= 1; with_line++) {
            board_t b;
            uint8_t data[20];
            size_t size = sizeof data;
            board_open(&b, widths[n]);
            b.esc.line = with_line != 0 ? line : NULL;
            b.pdi = ect_mmio_pdi(&b.esc);
            start(&b);
            wire_go(&b.w, 0, ECT_STATE_OP);
            assert_int_equal(wire_outputs(&b.w, 0, 0xFF), 1);
            assert_int_equal(testdev_of(&b.w, 0)->out_u16, 0xFFFF);
            assert_int_equal(wire_sdo_upload(&b.w, 0, 0x1018, 2, false, data, &size), 0);
            assert_int_equal(ect_load_le32(data), testdev.identity.product_code);
            wire_poll(&b.w);
            b.parts = 0;
            (void)ect_slave_poll(b.slave, b.w.now_ns);
            assert_int_equal(b.parts, with_line != 0 ? 0 : 4 / widths[n]);
            wire_close(&b.w);
        }
    }
}

static void a_bus_that_fails(void **state)
{
    board_t b;
    uint8_t byte = 0;
    (void)state;
    board_open(&b, 2);
    start(&b);
    wire_go(&b.w, 0, ECT_STATE_PREOP);
    b.broken = true;
    assert_int_equal(b.pdi.read(b.pdi.ctx, ECT_REG_TYPE, &byte, 1), -1);
    assert_int_equal(b.pdi.write(b.pdi.ctx, RAM, &byte, 1), -1);
    assert_false(ect_mmio_ready(&b.esc));
    (void)wire_al(&b.w, 0, ECT_STATE_INIT, NULL);
    assert_true(b.slave->pdi_errors > 0);
    b.broken = false;
    wire_advance(&b.w, 10 * MS);
    assert_int_equal(wire_read8(&b.w, 0, ECT_REG_AL_STATUS), ECT_STATE_INIT);
    wire_close(&b.w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"any bytes at any address, on 8, 16 and 32 bits, and no others", direct, NULL, NULL, NULL},
        {"the memory of the software ESC, as it lies there", software_esc_memory, NULL, NULL, NULL},
        {"ready: a type that can be, and the EEPROM loaded", not_ready, NULL, NULL, NULL},
        {"PDI budget: an access has as few parts as width and alignment allow, in ascending order", parts, NULL, NULL,
         NULL},
        {"on 8, 16 and 32 bits a slave reaches OP; with the pin an idle poll costs nothing", boot_to_op, NULL, NULL,
         NULL},
        {"a bus that fails for a while costs no state", a_bus_that_fails, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("port_mmio", tests, NULL, NULL);
}
