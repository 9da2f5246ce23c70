/* SPDX-License-Identifier: MIT */
/* The LAN9252's port against the virtual chip: bytes, costs, faults, and the whole slave behind it. */
#include <stdio.h>
#include <string.h>

#include "ports/lan9252/lan9252.h"
#include "ports/virtual/lan9252.h"
#include "support/testdev.h"
#include "support/wire.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

enum { PATIENCE = 10, RAM = 0x1000, USER_RAM = 0x0F80, INIT = ECT_STATE_INIT, OP = ECT_STATE_OP };

typedef struct board {
    wire_t w;
    ect_virtual_lan9252_t chip;
    ect_spi_t spi;
    ect_lan9252_t port;
    ect_pdi_t pdi;
    ect_slave_t *slave;
    unsigned int fail_at; /* the transfer that fails, counted from 1; 0 none */
    unsigned int transfers;
    unsigned int pauses;
    uint32_t id; /* value of ID_REV; 0: the chip's */
    int miso;    /* each byte on MISO; -1: the chip's */
} board_t;

static int transfer(void *ctx, uint8_t *bytes, uint16_t length)
{
    board_t *b = ctx;
    bool id = bytes[0] == 0x03 && bytes[2] == 0x50;
    assert_in_range(length, 1, 67); /* as seams/spi.h defines */
    if (++b->transfers == b->fail_at)
        return -1;
    int result = ect_virtual_lan9252_transfer(&b->chip, bytes, length);
    if (id && b->id != 0)
        ect_store_le32(bytes + 3, b->id);
    if (b->miso >= 0)
        memset(bytes, b->miso, length);
    return result;
}

static void reset(void *ctx, bool active)
{
    ect_virtual_lan9252_reset(&((board_t *)ctx)->chip, active);
}

static bool line(void *ctx)
{
    return ect_virtual_lan9252_line(&((board_t *)ctx)->chip);
}

static void pause_us(void *ctx, uint32_t us)
{
    board_t *b = ctx;
    b->pauses++;
    ect_virtual_lan9252_pause(&b->chip, us);
}

static void board_open(board_t *b)
{
    memset(b, 0, sizeof *b);
    wire_open_one(&b->w, &testdev);
    b->slave = (ect_slave_t *)(uintptr_t)ect_chain_slave(b->w.chain, 0);
    b->chip.esc = ect_chain_esc(b->w.chain, 0);
    b->spi = (ect_spi_t){.ctx = b, .transfer = transfer, .pause = pause_us};
    b->port = (ect_lan9252_t){.spi = &b->spi, .patience = PATIENCE, .ready_ms = 20};
    b->pdi = ect_lan9252_pdi(&b->port);
    b->miso = -1;
}

static void board_close(board_t *b)
{
    if (b->chip.mistakes != 0 && b->chip.flip_at == 0 && b->chip.flip_one_in == 0)
        fail_msg("%u mistakes of the driver, the last one: %s", b->chip.mistakes, b->chip.mistake);
    wire_close(&b->w);
}

static int read_esc(board_t *b, uint16_t address, void *data, uint16_t length)
{
    return b->pdi.read(b->pdi.ctx, address, data, length);
}

static int write_esc(board_t *b, uint16_t address, const void *data, uint16_t length)
{
    return b->pdi.write(b->pdi.ctx, address, data, length);
}

/* --- bytes -------------------------------------------------------------------------------------------------------- */

/* Reads and writes `length` bytes at `address`, with 8 bytes around them that must stay. */
static void check_bytes(board_t *b, uint16_t address, uint16_t length)
{
    uint8_t *memory = b->chip.esc->memory + address;
    uint8_t want[256], got[256] = {0};
    assert_true(length + 16u <= sizeof want);
    for (unsigned int n = 0; n < length + 16u; n++)
        memory[(int)n - 8] = want[n] = (uint8_t)(37 * n + length);
    assert_int_equal(read_esc(b, address, got, length), 0);
    if (memcmp(got, want + 8, length) != 0)
        fail_msg("read of %u bytes at 0x%04X: others", length, address);
    for (unsigned int n = length; n < sizeof got; n++)
        assert_int_equal(got[n], 0);
    for (unsigned int n = 0; n < length; n++)
        want[8 + n] = got[n] = (uint8_t)~got[n];
    assert_int_equal(write_esc(b, address, got, length), 0);
    if (memcmp(memory - 8, want, length + 16u) != 0)
        fail_msg("write of %u bytes at 0x%04X: others, or more", length, address);
}

/* A fast chip, one whose FIFO is not filled or emptied as fast as the SPI goes, and a slow one. */
static const struct {
    uint32_t csr_lasts, word_lasts;
} speeds[] = {{0, 0}, {5, 5}, {20, 11}};

static void every_address_and_length(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT(speeds); s++) {
        board_t b;
        board_open(&b);
        b.port.patience = 40;
        b.chip.csr_lasts = speeds[s].csr_lasts;
        b.chip.word_lasts = speeds[s].word_lasts;
        for (uint16_t offset = 8; offset < 16; offset++) {
            for (uint16_t length = 1; length < 80; length++)
                check_bytes(&b, (uint16_t)(RAM + offset), length);
            for (uint16_t length = 1; length < 20; length++)
                check_bytes(&b, (uint16_t)(USER_RAM + offset), length);
        }
        check_bytes(&b, RAM + 0x100, 240);
        check_bytes(&b, RAM + 0x203, 129);
        board_close(&b);
    }
}

/* User RAM ends where process RAM begins. */
static void across_the_border(void **state)
{
    board_t b;
    (void)state;
    board_open(&b);
    for (uint16_t before = 1; before < 8; before++) {
        for (uint16_t behind = 1; behind < 8; behind++)
            check_bytes(&b, (uint16_t)(RAM - before), (uint16_t)(before + behind));
    }
    board_close(&b);
}

/* --- cost --------------------------------------------------------------------------------------------------------- */

static void cost(void **state)
{
    static const struct {
        bool write;
        uint16_t address, length;
        unsigned int transfers, bytes;
    } rows[] = {
        {false, 0x0220, 4, 3, 21},       {false, 0x0120, 2, 3, 21},       {false, 0x0805, 1, 3, 21},
        {false, 0x0800, 32, 24, 168},    {true, 0x0130, 2, 2, 18},        {true, 0x0807, 1, 2, 18},
        {false, 0x1000, 1, 3, 25},       {false, 0x1000, 64, 3, 21 + 64}, {false, 0x1003, 2, 3, 29},
        {false, 0x1000, 68, 5, 85 + 14}, {true, 0x1000, 1, 4, 32},        {true, 0x1000, 64, 4, 28 + 64},
        {true, 0x1002, 4, 4, 36},        {true, 0x1000, 68, 6, 92 + 14},  {true, 0x1000, 192, 8, 28 + 192 + 20},
    };
    board_t b;
    (void)state;
    board_open(&b);
    for (size_t n = 0; n < COUNT(rows); n++) {
        uint8_t bytes[256] = {0};
        b.chip.transfers = b.chip.bytes = 0;
        if (rows[n].write)
            assert_int_equal(write_esc(&b, rows[n].address, bytes, rows[n].length), 0);
        else
            assert_int_equal(read_esc(&b, rows[n].address, bytes, rows[n].length), 0);
        if (b.chip.transfers != rows[n].transfers || b.chip.bytes != rows[n].bytes)
            fail_msg("row %zu, 0x%04X: expected %u transfers of %u bytes, got %u of %u", n, rows[n].address,
                     rows[n].transfers, rows[n].bytes, b.chip.transfers, b.chip.bytes);
    }
    board_close(&b);
}

/* --- the start ---------------------------------------------------------------------------------------------------- */

static void late_and_ready(void **state)
{
    board_t b;
    (void)state;
    for (unsigned int pin = 0; pin <= 1; pin++) {
        board_open(&b);
        b.spi.reset = pin != 0 ? reset : NULL;
        b.chip.ready_after = 10 * 2500; /* 10 ms */
        assert_true(ect_lan9252_reset(&b.port));
        assert_int_equal(ect_lan9252_start(&b.port), ECT_LAN9252_READY);
        assert_in_range(b.pauses, 8, 12);
        board_close(&b);
    }
}

/* AL control as an event of the ESC, let through by the mask or not. */
static void set_event(board_t *b, bool event)
{
    uint8_t control[2] = {INIT, 0};
    uint32_t mask = event ? ECT_EVENT_AL_CONTROL : 0;
    uint8_t wire[4];
    ect_store_le32(wire, mask);
    (void)ect_esc_pdi_write(b->chip.esc, ECT_REG_AL_EVENT_MASK, wire, sizeof wire);
    b->w.manual_poll = true;
    if (event)
        assert_int_equal(wire_write(&b->w, 0, ECT_REG_AL_CONTROL, control, sizeof control), 1);
}

static void expect_pin_follows_event(board_t *b)
{
    set_event(b, false);
    assert_false(line(b));
    set_event(b, true);
    assert_true(line(b));
}

static void interrupt_pin(void **state)
{
    static const struct {
        bool high, driven;
        uint32_t value;
    } rows[] = {{false, false, 0x100}, {false, true, 0x101}, {true, false, 0x111}, {true, true, 0x111}};
    (void)state;
    for (size_t n = 0; n < COUNT(rows); n++) {
        board_t b;
        board_open(&b);
        b.chip.active_high = rows[n].high;
        b.port.interrupt_high = rows[n].high;
        b.port.interrupt_driven = rows[n].driven;
        assert_int_equal(ect_lan9252_start(&b.port), ECT_LAN9252_READY);
        assert_int_equal(b.chip.irq_cfg, rows[n].value);
        assert_int_equal(b.chip.int_en, 1);
        expect_pin_follows_event(&b);
        board_close(&b);
    }
}

/* Open drain ignores the polarity; a driven pin of the other polarity is active while there is no event. */
static void pin_of_the_virtual_chip(void **state)
{
    static const struct {
        uint32_t value;
        bool active_high, idle, event;
    } rows[] = {{0x100, false, false, true}, {0x110, false, false, true}, {0x101, false, false, true},
                {0x111, false, true, false}, {0x100, true, false, false}, {0x110, true, false, false},
                {0x101, true, true, false},  {0x111, true, false, true},  {0x011, false, false, false},
                {0x001, true, false, false}};
    (void)state;
    for (size_t n = 0; n < COUNT(rows); n++) {
        board_t b;
        board_open(&b);
        b.chip.irq_cfg = rows[n].value;
        b.chip.int_en = 1;
        b.chip.active_high = rows[n].active_high;
        set_event(&b, false);
        bool idle = line(&b);
        set_event(&b, true);
        if (idle != rows[n].idle || line(&b) != rows[n].event)
            fail_msg("row %zu: without and with an event: expected %d %d, got %d %d", n, rows[n].idle, rows[n].event,
                     idle, line(&b));
        board_close(&b);
    }
}

static void no_chip_low(board_t *b)
{
    b->miso = 0x00;
}

static void no_chip_high(board_t *b)
{
    b->miso = 0xFF;
}

static void other_chip(board_t *b)
{
    b->id = 0x93300001;
}

static void never_ready(board_t *b)
{
    b->chip.never_ready = true;
}

static void first_fails(board_t *b)
{
    b->fail_at = 1;
    b->port.ready_ms = 0;
}

static void held_in_reset(board_t *b)
{
    reset(b, true);
}

static void stuck_core(board_t *b)
{
    b->chip.csr_stuck = true;
}

static void no_eeprom(board_t *b)
{
    ect_esc_config_t config = b->chip.esc->config;
    config.sii = NULL;
    config.sii_size = 0;
    assert_int_equal(ect_esc_init(b->chip.esc, &config, b->w.now_ns), 0);
}

static void refused_starts(void **state)
{
    static const struct {
        const char *what;
        void (*set)(board_t *b);
        int result;
    } rows[] = {
        {"no response, the line is low", no_chip_low, ECT_LAN9252_SILENT},
        {"no response, the line is high", no_chip_high, ECT_LAN9252_SILENT},
        {"held in reset", held_in_reset, ECT_LAN9252_SILENT},
        {"another chip", other_chip, ECT_LAN9252_STRANGER},
        {"never ready", never_ready, ECT_LAN9252_NOT_READY},
        {"a transfer that fails is tried again", first_fails, ECT_LAN9252_READY},
        {"a core that stays busy", stuck_core, ECT_LAN9252_SPI},
        {"no EEPROM", no_eeprom, ECT_LAN9252_NO_EEPROM},
    };
    (void)state;
    for (size_t n = 0; n < COUNT(rows); n++) {
        board_t b;
        board_open(&b);
        rows[n].set(&b);
        int result = ect_lan9252_start(&b.port);
        if (result != rows[n].result || b.pauses > 20)
            fail_msg("%s: expected %d after at most 20 ms, got %d after %u", rows[n].what, rows[n].result, result,
                     b.pauses);
        board_close(&b);
    }
}

/* --- a chip that does not do it ----------------------------------------------------------------------------------- */

static void stuck(void **state)
{
    static const struct {
        const char *what;
        bool ram, write;
        uint16_t address;
        unsigned int transfers; /* until the timeout */
    } rows[] = {
        {"register, read", false, false, 0x0120, 1 + PATIENCE},
        {"register, write", false, true, 0x0130, 1 + PATIENCE},
        {"process RAM, read", true, false, RAM, 1 + PATIENCE},
        {"process RAM, write", true, true, RAM, 1 + 2 + PATIENCE},
    };
    (void)state;
    for (size_t n = 0; n < COUNT(rows); n++) {
        board_t b;
        uint8_t bytes[32] = {1, 2, 3};
        board_open(&b);
        b.chip.csr_stuck = !rows[n].ram;
        b.chip.ram_stuck = rows[n].ram;
        int result = rows[n].write ? write_esc(&b, rows[n].address, bytes, 2) : read_esc(&b, rows[n].address, bytes, 2);
        if (result != -1 || b.transfers != rows[n].transfers)
            fail_msg("%s: expected -1 after %u transfers, got %d after %u", rows[n].what, rows[n].transfers, result,
                     b.transfers);
        b.transfers = 0;
        if (!rows[n].ram)
            assert_int_equal(read_esc(&b, RAM, bytes, 2), -1); /* still busy: the abandoned access is awaited */
        assert_true(b.transfers <= 5 + 3 * PATIENCE);
        b.chip.csr_stuck = b.chip.ram_stuck = false;
        b.chip.csr_left = 0;
        check_bytes(&b, RAM + 16, 20);
        check_bytes(&b, USER_RAM + 16, 7);
        board_close(&b);
    }
}

/* At whichever transfer the SPI fails: the access reports it, and the next one is right. */
static void failing_transfers(void **state)
{
    static const uint16_t addresses[] = {USER_RAM + 16, RAM + 16};
    (void)state;
    for (size_t a = 0; a < COUNT(addresses); a++) {
        for (unsigned int write = 0; write <= 1; write++) {
            unsigned int k = 1;
            for (int result = -1; result < 0; k++) {
                board_t b;
                uint8_t bytes[150] = {0};
                board_open(&b);
                b.chip.word_lasts = 7;
                b.port.patience = 60;
                b.fail_at = k;
                uint16_t length = addresses[a] >= RAM ? sizeof bytes : 9;
                result =
                    write != 0 ? write_esc(&b, addresses[a], bytes, length) : read_esc(&b, addresses[a], bytes, length);
                b.fail_at = 0;
                check_bytes(&b, RAM + 16, 20);
                check_bytes(&b, USER_RAM + 16, 7);
                board_close(&b);
            }
            assert_true(k > 5);
        }
    }
}

/* Before the next access an abandoned one is settled: two aborts, and a wait for each of three commands. */
static void failing_settlement(void **state)
{
    enum { SETTLEMENT = 5 };
    (void)state;
    for (unsigned int k = 1; k <= SETTLEMENT; k++) {
        board_t b;
        uint8_t byte = 0;
        board_open(&b);
        b.fail_at = 1;
        assert_int_equal(read_esc(&b, USER_RAM, &byte, 1), -1);
        b.fail_at = 1 + k;
        assert_int_equal(read_esc(&b, USER_RAM, &byte, 1), -1);
        if (b.transfers != 1 + k)
            fail_msg("transfer %u of the settlement fails: expected no further one, got %u", k, b.transfers - 1 - k);
        b.fail_at = 0;
        check_bytes(&b, USER_RAM + 16, 4);
        b.transfers = 0;
        assert_int_equal(read_esc(&b, USER_RAM, &byte, 1), 0);
        assert_int_equal(b.transfers, 3); /* without a settlement */
        board_close(&b);
    }
}

/* 16 bits of each byte, there and back. One is let pass: without the bit that starts it, a command reads as if it had
 * been executed. */
static void damaged_command(void **state)
{
    enum { START_BIT = 6 * 16 + 7 };
    (void)state;
    for (unsigned int bit = 0; bit < 7 * 16; bit++) {
        if (bit == START_BIT)
            continue;
        board_t b;
        uint8_t data[4] = {0};
        uint8_t want[4];
        board_open(&b);
        b.chip.flip_at = bit + 1;
        memcpy(want, b.chip.esc->memory, 4);
        int result = read_esc(&b, 0x0000, data, 4);
        if (result == 0 && memcmp(data, want, 4) != 0)
            fail_msg("bit %u of byte %u flips on the way %s: a read of other data that succeeds", bit % 8, bit / 16,
                     bit % 16 < 8 ? "out" : "back");
        board_close(&b);
    }
}

/* --- the whole slave behind it ------------------------------------------------------------------------------------ */

static void start(board_t *b)
{
    ect_slave_config_t config = b->slave->config;
    assert_int_equal(ect_lan9252_start(&b->port), ECT_LAN9252_READY);
    b->pdi = ect_lan9252_pdi(&b->port);
    config.pdi = &b->pdi;
    memset(config.instance, 0, config.device->instance_size);
    assert_int_equal(ect_slave_init(b->slave, &config, b->w.now_ns), 0);
}

static void exchange(board_t *b)
{
    uint8_t data[20];
    size_t size = sizeof data;
    wire_go(&b->w, 0, OP);
    for (unsigned int n = 1; n < 20; n++) {
        assert_int_equal(wire_outputs(&b->w, 0, (uint8_t)n), 1);
        assert_int_equal(testdev_of(&b->w, 0)->out_u16, 0x0101 * n);
    }
    assert_int_equal(wire_sdo_upload(&b->w, 0, 0x1018, 2, false, data, &size), 0);
    assert_int_equal(ect_load_le32(data), testdev.identity.product_code);
}

static void boot_to_op(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT(speeds); s++) {
        for (unsigned int with_line = 0; with_line <= 1; with_line++) {
            board_t b;
            board_open(&b);
            b.port.patience = 40;
            b.chip.csr_lasts = speeds[s].csr_lasts;
            b.chip.word_lasts = speeds[s].word_lasts;
            b.spi.line = with_line != 0 ? line : NULL;
            start(&b);
            exchange(&b);
            assert_int_equal(b.slave->pdi_errors, 0);
            wire_poll(&b.w);
            b.chip.transfers = 0;
            wire_poll(&b.w);
            assert_int_equal(b.chip.transfers, 0); /* no event, so no poll reads the chip */
            (void)ect_slave_poll(b.slave, b.w.now_ns);
            assert_int_equal(b.chip.transfers > 0, with_line == 0);
            board_close(&b);
        }
    }
}

static void reset_and_again(void **state)
{
    board_t b;
    (void)state;
    board_open(&b);
    b.spi.reset = reset;
    start(&b);
    exchange(&b);
    b.chip.ready_after = 5000;
    assert_true(ect_lan9252_reset(&b.port));
    uint8_t byte;
    assert_int_equal(read_esc(&b, 0x0130, &byte, 1), -1); /* not ready: no access can be trusted */
    start(&b);
    wire_assign_stations(&b.w);
    assert_int_equal(wire_read8(&b.w, 0, ECT_REG_AL_STATUS), INIT);
    exchange(&b);
    board_close(&b);
}

/* The three frames of the reset sequence (data sheet II, 2.3). */
static void reset_by_master(board_t *b)
{
    for (const char *at = "RES"; *at != 0; at++)
        (void)wire_write8(&b->w, 0, ECT_REG_RESET_ECAT, (uint8_t)*at);
}

static void brown_out(board_t *b)
{
    reset(b, true);
    reset(b, false);
}

/* The main loop of a board with the pin: one turn each millisecond, for so long. @return turns until the port reports
 * the reset, or 0 */
static unsigned int turns_until_lost(board_t *b, unsigned int turns)
{
    for (unsigned int n = 1; n <= turns; n++) {
        wire_advance(&b->w, MS);
        if (!ect_lan9252_check(&b->port, b->w.now_ns))
            return n;
    }
    return 0;
}

static void lost_settings(void **state)
{
    static void (*const causes[])(board_t *) = {reset_by_master, brown_out};
    static const uint16_t intervals_ms[] = {0, 10, 100};
    (void)state;
    for (size_t n = 0; n < COUNT(causes) * COUNT(intervals_ms); n++) {
        uint16_t interval_ms = intervals_ms[n / COUNT(causes)];
        board_t b;
        board_open(&b);
        b.spi.line = line;
        b.port.check_ms = interval_ms;
        start(&b);
        exchange(&b);
        assert_int_equal(turns_until_lost(&b, 300), 0);
        causes[n % COUNT(causes)](&b);
        assert_in_range(turns_until_lost(&b, 300), 1, interval_ms != 0 ? interval_ms : 50);
        start(&b);
        wire_assign_stations(&b.w);
        assert_int_equal(wire_read8(&b.w, 0, ECT_REG_AL_STATUS), INIT);
        exchange(&b);
        assert_int_equal(turns_until_lost(&b, 300), 0);
        board_close(&b);
    }
}

/* One transfer of 15 bytes each interval, none between; a failed or damaged one is no reset. */
static void cost_of_check(void **state)
{
    board_t b;
    (void)state;
    board_open(&b);
    start(&b);
    assert_true(ect_lan9252_check(&b.port, b.w.now_ns));
    b.chip.transfers = b.chip.bytes = 0;
    for (unsigned int n = 1; n <= 100; n++)
        assert_true(ect_lan9252_check(&b.port, b.w.now_ns + n * MS));
    assert_int_equal(b.chip.transfers, 2);
    assert_int_equal(b.chip.bytes, 2 * 15);
    b.fail_at = b.transfers + 1;
    assert_true(ect_lan9252_check(&b.port, b.w.now_ns + 200 * MS));
    b.chip.flip_at = b.chip.bits + 3 * 16 + 2;
    assert_true(ect_lan9252_check(&b.port, b.w.now_ns + 300 * MS));
    board_close(&b);
}

/* A boot loader that uses quad SPI may end without RSTQIO. */
static void left_in_sqi(void **state)
{
    board_t b;
    (void)state;
    board_open(&b);
    b.chip.sqi = true;
    start(&b);
    assert_false(b.chip.sqi);
    exchange(&b);
    board_close(&b);
}

static void hangs_for_a_while(void **state)
{
    board_t b;
    (void)state;
    board_open(&b);
    start(&b);
    exchange(&b);
    uint32_t errors = b.slave->pdi_errors;
    b.chip.csr_stuck = true;
    (void)wire_al(&b.w, 0, INIT, NULL);
    assert_true(b.slave->pdi_errors > errors);
    b.chip.csr_stuck = false;
    b.chip.csr_left = 0;
    wire_advance(&b.w, 10 * MS);
    assert_int_equal(wire_read8(&b.w, 0, ECT_REG_AL_STATUS), INIT);
    exchange(&b);
    board_close(&b);
}

/* A master that tries for a while, whatever it meets on the way. */
static void up_and_down(board_t *b)
{
    static const uint8_t states[] = {INIT, ECT_STATE_PREOP, ECT_STATE_SAFEOP, OP};
    for (size_t n = 0; n < COUNT(states); n++) {
        if (states[n] == ECT_STATE_PREOP)
            wire_configure_mailbox(&b->w, 0);
        if (states[n] == ECT_STATE_SAFEOP)
            wire_configure_process_data(&b->w, 0);
        (void)wire_al(&b->w, 0, states[n] | ECT_AL_ACKNOWLEDGE, NULL);
        (void)wire_outputs(&b->w, 0, 0x55);
        wire_advance(&b->w, 2 * MS);
    }
}

/* Wherever one bit flips, or many anywhere: every access ends, and on a whole wire again the slave is as good as new.
 */
static void flipped_bits(void **state)
{
    enum { STEP = 211 };
    (void)state;
    uint64_t last = 1;
    for (uint64_t at = 1; at <= last; at += STEP) {
        board_t b;
        board_open(&b);
        start(&b);
        uint64_t begin = b.chip.bits;
        b.chip.flip_at = begin + at;
        b.w.mail_counter = 0;
        up_and_down(&b);
        last = b.chip.bits - begin;
        start(&b);
        assert_int_equal(wire_al(&b.w, 0, INIT | ECT_AL_ACKNOWLEDGE, NULL), INIT);
        exchange(&b);
        board_close(&b);
    }
    assert_true(last > 10000);
}

static void many_flipped_bits(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 20; seed++) {
        board_t b;
        board_open(&b);
        start(&b);
        b.chip.flip_seed = seed;
        b.chip.flip_one_in = 3000;
        for (unsigned int n = 0; n < 10; n++)
            up_and_down(&b);
        assert_true(b.slave->pdi_errors > 0);
        b.chip.flip_one_in = 0;
        b.chip.flip_at = 1; /* it did flip */
        start(&b);
        assert_int_equal(wire_al(&b.w, 0, INIT | ECT_AL_ACKNOWLEDGE, NULL), INIT);
        exchange(&b);
        board_close(&b);
    }
}

int main(void)
{
#define T(title, function) {title, function, NULL, NULL, NULL}
    const struct CMUnitTest tests[] = {
        T("reads and writes any bytes of process RAM and registers, and no others, however fast the chip is",
          every_address_and_length),
        T("an access across the border of registers and process RAM", across_the_border),
        T("transfers and bytes on the SPI are those that the header names", cost),
        T("a chip that is late after a reset, by pin or by register, is waited for", late_and_ready),
        T("the interrupt pin: polarity and kind as configured, driven where it is active high", interrupt_pin),
        T("the virtual chip's interrupt pin obeys polarity and kind", pin_of_the_virtual_chip),
        T("a start that cannot be: the result names the cause, in bounded time", refused_starts),
        T("an access to a chip that stays busy is abandoned after `patience` reads, and completed before the next "
          "access",
          stuck),
        T("at whichever transfer the SPI fails, the access reports it, and the next one is right", failing_transfers),
        T("an abandoned access that cannot be settled is settled before a later one", failing_settlement),
        T("a command that arrives damaged is detected, except a command that lost its start bit", damaged_command),
        T("a slave reaches OP, exchanges process data and replies to SDOs; with the pin an idle poll costs nothing",
          boot_to_op),
        T("a reset by the pin is a power cycle", reset_and_again),
        T("with the pin, a reset by the master or a brown-out is noticed within check_ms, and the slave starts again",
          lost_settings),
        T("a check costs one transfer an interval; a failed or damaged transfer is no reset", cost_of_check),
        T("a chip that an earlier program left in SQI mode starts", left_in_sqi),
        T("a chip that hangs for a while costs no state", hangs_for_a_while),
        T("one flipped bit, anywhere on the way to OP: bounded, and as good as new afterwards", flipped_bits),
        T("flipped bits by the hundred: bounded, and as good as new afterwards", many_flipped_bits),
    };
    return cmocka_run_group_tests_name("port_lan9252", tests, NULL, NULL);
}
