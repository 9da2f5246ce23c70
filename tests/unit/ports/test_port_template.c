/* SPDX-License-Identifier: MIT */
/* The template of a port: a window onto a software ESC, behind it as on a board the whole slave. */
#include <stdio.h>
#include <string.h>

#include "ports/template/template.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { PATIENCE = 5, RAM = 0x1000, PARTS = 64 };

/* A chip with the window of template.h. It notes each access, and refuses those that it could not do. */
typedef struct chip {
    ect_pdi_t esc;
    uint32_t data;
    unsigned int busy_for;  /* reads of COMMAND until an access is done */
    unsigned int remaining; /* ... of the present one */
    unsigned int waits;     /* reads of COMMAND that were busy */
    unsigned int parts;
    struct {
        uint16_t address;
        uint8_t bytes;
    } part[PARTS];
} chip_t;

static void access_esc(chip_t *c, uint32_t value)
{
    uint8_t bytes[4] = {0};
    uint16_t address = (uint16_t)value;
    uint8_t n = (value >> 16) & 7;
    assert_true(n == 1 || n == 2 || n == 4);
    assert_int_equal(address % n, 0);
    if (c->parts < PARTS) {
        c->part[c->parts].address = address;
        c->part[c->parts].bytes = n;
    }
    c->parts++;
    if ((value & ECT_WINDOW_READ) != 0) {
        assert_int_equal(c->esc.read(c->esc.ctx, address, bytes, n), 0);
        c->data = ect_load_le32(bytes) | (n < 4 ? 0xA5000000u : 0); /* the other bytes are undefined */
    } else {
        ect_store_le32(bytes, c->data);
        assert_int_equal(c->esc.write(c->esc.ctx, address, bytes, n), 0);
    }
}

static uint32_t load(void *ctx, unsigned int reg)
{
    chip_t *c = ctx;
    if (reg == ECT_WINDOW_DATA) {
        assert_int_equal(c->remaining, 0);
        return c->data;
    }
    if (c->remaining == 0)
        return 0;
    c->waits++;
    c->remaining--;
    return ECT_WINDOW_BEGIN;
}

static void store(void *ctx, unsigned int reg, uint32_t value)
{
    chip_t *c = ctx;
    assert_int_equal(c->remaining, 0); /* a chip that is busy takes nothing */
    if (reg == ECT_WINDOW_DATA) {
        c->data = value;
        return;
    }
    assert_true((value & ECT_WINDOW_BEGIN) != 0);
    access_esc(c, value);
    c->remaining = c->busy_for;
}

typedef struct board {
    wire_t w;
    chip_t chip;
    ect_window_t window;
    ect_pdi_t pdi;
    ect_slave_t *slave;
} board_t;

static void board_open(board_t *b)
{
    memset(b, 0, sizeof *b);
    wire_open_one(&b->w, &testdev);
    b->slave = (ect_slave_t *)(uintptr_t)ect_chain_slave(b->w.chain, 0);
    b->chip.esc = *b->slave->config.pdi;
    b->chip.busy_for = 2;
    b->window = (ect_window_t){.ctx = &b->chip, .load = load, .store = store, .patience = PATIENCE};
    b->pdi = ect_template_pdi(&b->window);
}

/* --- bytes and parts ---------------------------------------------------------------------------------------------- */

static void check_parts(const chip_t *c, uint16_t address, uint16_t length)
{
    uint32_t at = address;
    for (unsigned int n = 0; n < c->parts; n++) {
        assert_int_equal(c->part[n].address, at);
        at += c->part[n].bytes;
    }
    assert_int_equal(at, address + length);
}

static void every_address_and_length(void **state)
{
    board_t b;
    uint8_t *ram;
    (void)state;
    board_open(&b);
    ram = ect_chain_esc(b.w.chain, 0)->memory + RAM;
    for (uint16_t offset = 0; offset < 8; offset++) {
        for (uint16_t length = 1; length < 40; length++) {
            uint8_t want[64], got[64] = {0};
            for (unsigned int n = 0; n < sizeof want; n++)
                ram[n] = want[n] = (uint8_t)(37 * n + length);
            b.chip.parts = 0;
            assert_int_equal(b.pdi.read(b.pdi.ctx, (uint16_t)(RAM + offset), got, length), 0);
            assert_memory_equal(got, want + offset, length);
            check_parts(&b.chip, (uint16_t)(RAM + offset), length);
            b.chip.parts = 0;
            for (unsigned int n = 0; n < length; n++)
                want[offset + n] = got[n] = (uint8_t)~got[n];
            assert_int_equal(b.pdi.write(b.pdi.ctx, (uint16_t)(RAM + offset), got, length), 0);
            assert_memory_equal(ram, want, sizeof want);
            check_parts(&b.chip, (uint16_t)(RAM + offset), length);
        }
    }
    wire_close(&b.w);
}

static void widest_parts(void **state)
{
    static const struct {
        uint16_t address, length;
        unsigned int parts;
    } rows[] = {{0x1000, 64, 16}, {0x1000, 3, 2}, {0x1001, 7, 3}, {0x1001, 6, 4}, {0x1002, 2, 1}, {0x0120, 2, 1}};
    board_t b;
    (void)state;
    board_open(&b);
    for (unsigned int n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        uint8_t bytes[64];
        b.chip.parts = 0;
        assert_int_equal(b.pdi.read(b.pdi.ctx, rows[n].address, bytes, rows[n].length), 0);
        assert_int_equal(b.chip.parts, rows[n].parts);
    }
    wire_close(&b.w);
}

/* --- a chip that is not ready ------------------------------------------------------------------------------------- */

static void patience_ends(void **state)
{
    board_t b;
    uint8_t bytes[4] = {1, 2, 3, 4};
    (void)state;
    for (int writing = 0; writing <= 1; writing++) {
        board_open(&b);
        b.chip.busy_for = PATIENCE - 1;
        assert_int_equal(b.pdi.read(b.pdi.ctx, RAM, bytes, 4), 0);
        b.chip.busy_for = 3 * PATIENCE;
        b.chip.waits = 0;
        for (unsigned int n = 1; n <= 3; n++) { /* one that is abandoned, and two that are not started */
            int result = writing != 0 ? b.pdi.write(b.pdi.ctx, RAM, bytes, 4) : b.pdi.read(b.pdi.ctx, RAM, bytes, 4);
            assert_int_equal(result, -1);
            assert_int_equal(b.chip.waits, n * PATIENCE);
        }
        b.chip.busy_for = 0;
        assert_int_equal(b.pdi.read(b.pdi.ctx, RAM, bytes, 4), 0);
        wire_close(&b.w);
    }
}

/* --- the whole slave behind it ------------------------------------------------------------------------------------ */

static void start(board_t *b)
{
    ect_slave_config_t config = b->slave->config;
    config.pdi = &b->pdi;
    memset(config.instance, 0, config.device->instance_size);
    assert_int_equal(ect_slave_init(b->slave, &config, b->w.now_ns), 0);
}

static void boot_to_op(void **state)
{
    board_t b;
    uint8_t data[20];
    size_t size = sizeof data;
    (void)state;
    board_open(&b);
    start(&b);
    wire_go(&b.w, 0, ECT_STATE_OP);
    assert_int_equal(wire_outputs(&b.w, 0, 0xFF), 1);
    assert_int_equal(testdev_of(&b.w, 0)->out_u16, 0xFFFF);
    assert_int_equal(wire_sdo_upload(&b.w, 0, 0x1018, 2, false, data, &size), 0);
    assert_int_equal(ect_load_le32(data), testdev.identity.product_code);
    assert_true(b.chip.parts > 50); /* it went through the window */
    wire_close(&b.w);
}

static void a_chip_that_hangs(void **state)
{
    board_t b;
    (void)state;
    board_open(&b);
    start(&b);
    wire_go(&b.w, 0, ECT_STATE_PREOP);
    b.chip.busy_for = 1000;
    uint32_t errors = b.slave->pdi_errors;
    (void)wire_al(&b.w, 0, ECT_STATE_INIT, NULL);
    assert_true(b.slave->pdi_errors > errors);
    b.chip.busy_for = b.chip.remaining = 0;
    wire_advance(&b.w, 10 * MS);
    assert_int_equal(wire_read8(&b.w, 0, ECT_REG_AL_STATUS), ECT_STATE_INIT);
    wire_close(&b.w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"reads and writes any bytes, each once, in ascending order", every_address_and_length, NULL, NULL, NULL},
        {"an access has as few parts as alignment allows", widest_parts, NULL, NULL, NULL},
        {"an access to a chip that does not become ready is abandoned, and the chip is polled before the next access",
         patience_ends, NULL, NULL, NULL},
        {"behind the window a slave reaches OP, exchanges process data and replies to SDOs", boot_to_op, NULL, NULL,
         NULL},
        {"a chip that hangs for a while costs no state", a_chip_that_hangs, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("port_template", tests, NULL, NULL);
}
