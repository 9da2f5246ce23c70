/* SPDX-License-Identifier: MIT */
/* The virtual LAN9252 word by word: what each register reads as, the time that an access lasts, and the mistakes that
 * it counts. */
#include <stdio.h>
#include <string.h>

#include "ports/virtual/lan9252.h"
#include "ports/virtual/virtual.h"
#include "support/testdev.h"
#include "support/wire.h"

#define COUNT(a)                (sizeof(a) / sizeof((a)[0]))
#define RAM_OF(address, length) ((uint32_t)(length) << 16 | (address))
#define BUSY                    0x80000000u
#define READS                   0x40000000u
#define ABORTS                  0x40000000u

enum {
    READ = 0x03,
    FAST_READ = 0x0B,
    WRITE = 0x02,
    UP = 0x4000,
    DOWN = 0x8000,
    FIFO = 0x000,
    WRITE_FIFO = 0x020,
    CSR_DATA = 0x300,
    CSR_COMMAND = 0x304,
    READ_ADDRESS = 0x308,
    READ_COMMAND = 0x30C,
    WRITE_ADDRESS = 0x310,
    WRITE_COMMAND = 0x314,
    RAM = 0x1000,
};

typedef struct bench {
    wire_t w;
    ect_virtual_lan9252_t chip;
} bench_t;

static int setup(void **state)
{
    static bench_t b;
    memset(&b, 0, sizeof b);
    wire_open_one(&b.w, &testdev);
    b.chip.esc = ect_chain_esc(b.w.chain, 0);
    ect_virtual_lan9252_reset(&b.chip, true);
    ect_virtual_lan9252_reset(&b.chip, false);
    *state = &b;
    return 0;
}

static int teardown(void **state)
{
    wire_close(&((bench_t *)*state)->w);
    return 0;
}

/* One transfer of `count` words; with FAST READ a byte follows the address. */
static void transfer(bench_t *b, uint8_t instruction, uint16_t address, uint32_t *words, unsigned int count)
{
    uint8_t bytes[80] = {instruction, (uint8_t)(address >> 8), (uint8_t)address, 0x5A};
    const unsigned int head = instruction == FAST_READ ? 4 : 3;
    for (unsigned int n = 0; n < count; n++)
        ect_store_le32(bytes + head + 4 * n, words[n]);
    assert_int_equal(ect_virtual_lan9252_transfer(&b->chip, bytes, (uint16_t)(head + 4 * count)), 0);
    const unsigned int silent = instruction == WRITE ? head + 4 * count : head; /* MISO is low without data */
    for (unsigned int n = 0; n < silent; n++)
        assert_int_equal(bytes[n], 0);
    for (unsigned int n = 0; n < count && instruction != WRITE; n++)
        words[n] = ect_load_le32(bytes + head + 4 * n);
}

static uint32_t read32(bench_t *b, uint16_t address)
{
    uint32_t word = 0;
    transfer(b, READ, address, &word, 1);
    return word;
}

static void write32(bench_t *b, uint16_t address, uint32_t word)
{
    transfer(b, WRITE, address, &word, 1);
}

/* --- registers ---------------------------------------------------------------------------------------------------- */

static void each_register(void **state)
{
    static const struct {
        uint16_t address;
        uint32_t value;
    } rows[] = {
        {0x050, 0x92520001}, {0x054, 0x00001111}, {0x058, 1},          {0x05C, 0x00000003}, {0x064, 0x87654321},
        {0x074, 0x08000000}, {0x300, 0x12345678}, {0x304, 0x7FFC1000}, {0x308, 0x00081000}, {0x30C, 0},
        {0x310, 0x00042000}, {0x314, 0x00001001}, {0x040, 0},          {0x048, 0},          {0x04C, 0},
        {0x060, 0},          {0x070, 0},          {0x078, 0},          {0x1F8, 0},          {0x2FC, 0},
        {0x318, 0},          {0x31C, 0},
    };
    bench_t *b = *state;
    write32(b, 0x054, 0x0111);
    write32(b, 0x05C, 3);
    write32(b, CSR_DATA, 0x12345678);
    write32(b, CSR_COMMAND, 0x40041000); /* no access: not busy */
    write32(b, READ_ADDRESS, RAM_OF(0x1000, 8));
    write32(b, WRITE_ADDRESS, RAM_OF(0x2000, 4));
    ect_store_le32(b->chip.esc->memory + ECT_REG_AL_EVENT_MASK, 1);
    ect_store_le32(b->chip.esc->memory + ECT_REG_AL_EVENT, 1);
    for (size_t n = 0; n < COUNT(rows); n++) {
        const uint32_t got = read32(b, rows[n].address);
        if (got != rows[n].value)
            fail_msg("0x%03X: expected 0x%08X, got 0x%08X", rows[n].address, (unsigned int)rows[n].value,
                     (unsigned int)got);
    }
    assert_int_equal(b->chip.mistakes, 0);
    write32(b, 0x05C, 2); /* the interrupt is off: the status bit and the event remain */
    assert_int_equal(read32(b, 0x054), 0x0111);
    assert_int_equal(read32(b, 0x058), 1);
}

static void addresses_of_several_words(void **state)
{
    bench_t *b = *state;
    uint32_t up[3] = {0}, down[3] = {0}, same[2] = {0}, fast[2] = {0};
    transfer(b, READ, UP | 0x05C, up, 3);
    assert_true(up[0] == 0 && up[1] == 0 && up[2] == 0x87654321);
    transfer(b, READ, DOWN | 0x064, down, 3);
    assert_true(down[0] == 0x87654321 && down[1] == 0 && down[2] == 0);
    transfer(b, READ, 0x064, same, 2);
    assert_true(same[0] == 0x87654321 && same[1] == 0x87654321);
    transfer(b, FAST_READ, UP | 0x060, fast, 2);
    assert_true(fast[0] == 0 && fast[1] == 0x87654321);
    uint32_t words[2] = {0x11223344, 0x00001000};
    transfer(b, WRITE, UP | CSR_DATA, words, 2);
    assert_int_equal(read32(b, CSR_DATA), 0x11223344);
    assert_int_equal(read32(b, CSR_COMMAND), 0x3FF81000);
    assert_int_equal(b->chip.mistakes, 0);
    assert_int_equal(read32(b, 0x067), 0x87654321); /* the lowest two bits do not belong to the address */
}

static void before_ready(void **state)
{
    bench_t *b = *state;
    b->chip.starting = 15; /* bytes */
    assert_int_equal(read32(b, 0x050), 0);
    assert_int_equal(read32(b, 0x064), 0x87654321); /* the last of the bytes is in this transfer */
    write32(b, CSR_DATA, 5);                        /* is ready by then */
    assert_int_equal(read32(b, CSR_DATA), 5);
    b->chip.never_ready = true;
    write32(b, CSR_DATA, 7);
    assert_int_equal(read32(b, CSR_DATA), 0);
    assert_int_equal(read32(b, 0x064), 0x87654321);
    b->chip.never_ready = false;
    assert_int_equal(read32(b, CSR_DATA), 5);
    ect_virtual_lan9252_reset(&b->chip, true);
    assert_int_equal(read32(b, 0x064), 0);
    ect_virtual_lan9252_reset(&b->chip, false);
    assert_int_equal(read32(b, CSR_DATA), 0);
}

static void reset_by_register(void **state)
{
    static const struct {
        uint32_t value;
        bool resets;
    } rows[] = {{0x40, true}, {0x01, true}, {0x41, true}, {0x3E, false}, {0x80, false}, {0, false}};
    for (size_t n = 0; n < COUNT(rows); n++) {
        bench_t *b = *state;
        write32(b, CSR_DATA, 5);
        b->chip.ready_after = 0;
        write32(b, 0x1F8, rows[n].value);
        assert_int_equal(read32(b, CSR_DATA), rows[n].resets ? 0 : 5);
    }
}

/* --- accesses of the ESC ------------------------------------------------------------------------------------------ */

static void registers_of_the_esc(void **state)
{
    static const struct {
        uint32_t bytes;
        uint32_t value;
    } rows[] = {{1, 0xA5A5A544}, {2, 0xA5A53344}, {4, 0x11223344}};
    bench_t *b = *state;
    for (size_t n = 0; n < COUNT(rows); n++) {
        memset(b->chip.esc->memory + 0x0F80, 0, 8);
        write32(b, CSR_DATA, 0x11223344);
        write32(b, CSR_COMMAND, BUSY | rows[n].bytes << 16 | 0x0F80);
        write32(b, CSR_DATA, 0);
        write32(b, CSR_COMMAND, BUSY | READS | rows[n].bytes << 16 | 0x0F80);
        assert_int_equal(read32(b, CSR_DATA), rows[n].value);
        for (unsigned int i = 0; i < 8; i++)
            assert_int_equal(b->chip.esc->memory[0x0F80 + i] != 0, i < rows[n].bytes);
    }
    assert_int_equal(b->chip.mistakes, 0);
}

static void access_of_the_esc_lasts(void **state)
{
    bench_t *b = *state;
    b->chip.csr_lasts = 12;
    write32(b, CSR_COMMAND, BUSY | READS | 1u << 16 | 0x0F80);
    assert_int_equal(read32(b, CSR_COMMAND) & BUSY, BUSY); /* after the 4th byte of 7 */
    assert_int_equal(read32(b, CSR_COMMAND) & BUSY, BUSY); /* after the 11th */
    assert_int_equal(read32(b, CSR_COMMAND) & BUSY, 0);
    write32(b, CSR_COMMAND, BUSY | READS | 1u << 16 | 0x0F80);
    ect_virtual_lan9252_pause(&b->chip, 3); /* 7 bytes of 0.4 us */
    assert_int_equal(read32(b, CSR_COMMAND) & BUSY, BUSY);
    assert_int_equal(read32(b, CSR_COMMAND) & BUSY, 0);
    b->chip.csr_stuck = true;
    write32(b, CSR_COMMAND, BUSY | READS | 1u << 16 | 0x0F80);
    ect_virtual_lan9252_pause(&b->chip, 1000);
    assert_int_equal(read32(b, CSR_COMMAND) & BUSY, BUSY);
}

static void process_ram(void **state)
{
    static const struct {
        uint16_t address, length;
        uint32_t words[3];
        unsigned int count;
    } rows[] = {
        {RAM, 4, {0x04030201}, 1},
        {RAM + 1, 2, {0xA50302A5}, 1},
        {RAM, 5, {0x04030201, 0xA5A5A505}, 2},
        {RAM + 3, 6, {0x04A5A5A5, 0x08070605, 0xA5A5A509}, 3},
    };
    bench_t *b = *state;
    for (uint8_t n = 0; n < 16; n++)
        b->chip.esc->memory[RAM + n] = (uint8_t)(n + 1);
    for (size_t n = 0; n < COUNT(rows); n++) {
        write32(b, READ_ADDRESS, RAM_OF(rows[n].address, rows[n].length));
        write32(b, READ_COMMAND, BUSY);
        ect_virtual_lan9252_pause(&b->chip, 10);
        assert_int_equal(read32(b, READ_COMMAND), rows[n].count << 8 | 1u);
        for (unsigned int i = 0; i < rows[n].count; i++)
            assert_int_equal(read32(b, FIFO), rows[n].words[i]);
        assert_int_equal(read32(b, READ_COMMAND), 0);
        assert_int_equal(read32(b, READ_ADDRESS), RAM_OF(rows[n].address + rows[n].length, 0));
    }
    write32(b, WRITE_ADDRESS, RAM_OF(RAM + 17, 4));
    write32(b, WRITE_COMMAND, BUSY);
    assert_int_equal(read32(b, WRITE_COMMAND), BUSY | 16u << 8 | 1u);
    write32(b, WRITE_FIFO, 0x33221100);
    write32(b, WRITE_FIFO + 0x1C, 0x77665544);
    ect_virtual_lan9252_pause(&b->chip, 10);
    assert_int_equal(read32(b, WRITE_COMMAND), 16u << 8 | 1u);
    assert_memory_equal(b->chip.esc->memory + RAM + 16, "\0\x11\x22\x33\x44\0", 6);
    assert_int_equal(b->chip.mistakes, 0);
}

static void each_word_lasts(void **state)
{
    bench_t *b = *state;
    b->chip.word_lasts = 25; /* bytes: 10 us */
    write32(b, READ_ADDRESS, RAM_OF(RAM, 12));
    write32(b, READ_COMMAND, BUSY);
    b->chip.ram_time = 0;
    for (unsigned int words = 1; words <= 3; words++) {
        ect_virtual_lan9252_pause(&b->chip, 9);
        assert_int_equal(b->chip.reading.count, words - 1);
        ect_virtual_lan9252_pause(&b->chip, 2);
        assert_int_equal(b->chip.reading.count, words);
        ect_virtual_lan9252_pause(&b->chip, 0);
        b->chip.ram_time = 0;
    }
    assert_false(b->chip.reading.busy);
    b->chip.ram_stuck = true;
    for (unsigned int n = 0; n < 3; n++)
        (void)read32(b, FIFO);
    write32(b, READ_ADDRESS, RAM_OF(RAM, 4));
    write32(b, READ_COMMAND, BUSY);
    ect_virtual_lan9252_pause(&b->chip, 100);
    assert_int_equal(b->chip.reading.count, 0);
    write32(b, READ_COMMAND, ABORTS);
    assert_int_equal(read32(b, READ_COMMAND), 0);
    assert_int_equal(read32(b, READ_ADDRESS), RAM_OF(RAM, 0));
    assert_int_equal(b->chip.mistakes, 0);
}

/* --- mistakes ----------------------------------------------------------------------------------------------------- */

static void busy_register(bench_t *b)
{
    b->chip.csr_lasts = 100;
    write32(b, CSR_COMMAND, BUSY | READS | 1u << 16);
    write32(b, CSR_COMMAND, BUSY | READS | 1u << 16);
}

static void three_bytes(bench_t *b)
{
    write32(b, CSR_COMMAND, BUSY | READS | 3u << 16);
}

static void no_bytes(bench_t *b)
{
    write32(b, CSR_COMMAND, BUSY | READS);
}

static void odd_register(bench_t *b)
{
    write32(b, CSR_COMMAND, BUSY | READS | 4u << 16 | 0x0F82);
}

static void register_in_ram(bench_t *b)
{
    write32(b, CSR_COMMAND, BUSY | READS | 1u << 16 | RAM);
}

static void ram_while_busy(bench_t *b)
{
    b->chip.ram_stuck = true;
    write32(b, READ_ADDRESS, RAM_OF(RAM, 4));
    write32(b, READ_COMMAND, BUSY);
    write32(b, READ_ADDRESS, RAM_OF(RAM, 8));
}

static void ram_twice(bench_t *b)
{
    b->chip.ram_stuck = true;
    write32(b, WRITE_ADDRESS, RAM_OF(RAM, 4));
    write32(b, WRITE_COMMAND, BUSY);
    write32(b, WRITE_COMMAND, BUSY);
}

static void ram_unread(bench_t *b)
{
    write32(b, READ_ADDRESS, RAM_OF(RAM, 4));
    write32(b, READ_COMMAND, BUSY);
    ect_virtual_lan9252_pause(&b->chip, 10);
    write32(b, READ_ADDRESS, RAM_OF(RAM, 4));
    write32(b, READ_COMMAND, BUSY);
}

static void ram_of_no_length(bench_t *b)
{
    write32(b, READ_ADDRESS, RAM_OF(RAM, 0));
    write32(b, READ_COMMAND, BUSY);
}

static void ram_in_registers(bench_t *b)
{
    write32(b, READ_ADDRESS, RAM_OF(RAM - 1, 4));
    write32(b, READ_COMMAND, BUSY);
}

static void empty_fifo(bench_t *b)
{
    assert_int_equal(read32(b, 0x01C), 0xDEADBEEF);
}

static void full_fifo(bench_t *b)
{
    for (unsigned int n = 0; n < 16; n++)
        write32(b, WRITE_FIFO, n);
    assert_int_equal(b->chip.mistakes, 0);
    write32(b, WRITE_FIFO, 16);
}

static void nowhere(bench_t *b)
{
    write32(b, 0x040, 0);
}

static void into_the_read_fifo(bench_t *b)
{
    write32(b, 0x01C, 0);
}

static void instruction(bench_t *b)
{
    uint32_t word = 0;
    transfer(b, 0x05, 0x064, &word, 1);
    assert_int_equal(word, 0);
}

static void half_a_word(bench_t *b)
{
    uint8_t bytes[5] = {READ, 0, 0x64};
    (void)ect_virtual_lan9252_transfer(&b->chip, bytes, sizeof bytes);
}

static void no_word(bench_t *b)
{
    uint8_t bytes[3] = {READ, 0, 0x64};
    (void)ect_virtual_lan9252_transfer(&b->chip, bytes, sizeof bytes);
}

static void one_byte(bench_t *b)
{
    uint8_t byte = 0x03;
    (void)ect_virtual_lan9252_transfer(&b->chip, &byte, 1);
}

static void mistakes(void **state)
{
    static const struct {
        void (*make)(bench_t *b);
        const char *mistake;
    } rows[] = {
        {busy_register, "a command to a register of the ESC while the last one is busy"},
        {three_bytes, "a register of the ESC with an invalid address or size"},
        {no_bytes, "a register of the ESC with an invalid address or size"},
        {odd_register, "a register of the ESC with an invalid address or size"},
        {register_in_ram, "a register of the ESC with an invalid address or size"},
        {ram_while_busy, "address and length of process RAM while it is busy"},
        {ram_twice, "process RAM: a command before the last one is done, or its data are read"},
        {ram_unread, "process RAM: a command before the last one is done, or its data are read"},
        {ram_of_no_length, "process RAM: an invalid address or length"},
        {ram_in_registers, "process RAM: an invalid address or length"},
        {empty_fifo, "a word from an empty FIFO"},
        {full_fifo, "a word into a full FIFO"},
        {nowhere, "a word to an address where nothing can be written"},
        {into_the_read_fifo, "a word to an address where nothing can be written"},
        {instruction, "an unknown instruction"},
        {half_a_word, "a transfer that is not of whole words"},
        {no_word, "a transfer that is not of whole words"},
        {one_byte, "an unknown instruction of one byte"},
    };
    for (size_t n = 0; n < COUNT(rows); n++) {
        assert_int_equal(setup(state), 0);
        bench_t *b = *state;
        rows[n].make(b);
        if (b->chip.mistakes != 1 || strcmp(b->chip.mistake, rows[n].mistake) != 0)
            fail_msg("row %zu: %u mistakes, the last one: %s", n, b->chip.mistakes,
                     b->chip.mistakes != 0 ? b->chip.mistake : "none");
        (void)teardown(state);
    }
}

static void quad_spi(void **state)
{
    bench_t *b = *state;
    uint8_t enter = 0x38, leave = 0xFF, bytes[7] = {READ, 0, 0x64}, two[2] = {0xFF, 0xFF};
    (void)ect_virtual_lan9252_transfer(&b->chip, &enter, 1);
    assert_true(b->chip.sqi && enter == 0xFF);
    (void)ect_virtual_lan9252_transfer(&b->chip, bytes, sizeof bytes);
    assert_memory_equal(bytes, "\xFF\xFF\xFF\xFF\xFF\xFF\xFF", sizeof bytes);
    (void)ect_virtual_lan9252_transfer(&b->chip, two, sizeof two);
    assert_true(b->chip.sqi);
    (void)ect_virtual_lan9252_transfer(&b->chip, &leave, 1);
    assert_false(b->chip.sqi);
    assert_int_equal(read32(b, 0x064), 0x87654321);
    assert_int_equal(b->chip.mistakes, 0);
    assert_int_equal(b->chip.transfers, 5);
    assert_int_equal(b->chip.bytes, 1 + 7 + 2 + 1 + 7);
}

/* --- the software ESC behind the seam ----------------------------------------------------------------------------- */

static void event_word(void **state)
{
    bench_t *b = *state;
    ect_pdi_t direct = ect_virtual_pdi(b->chip.esc), line = ect_virtual_line_pdi(b->chip.esc);
    uint32_t event = 0;
    ect_store_le32(b->chip.esc->memory + ECT_REG_AL_EVENT, 0x11);
    assert_int_equal(direct.al_event(direct.ctx, &event), 0);
    assert_int_equal(event, 0x11);
    ect_store_le32(b->chip.esc->memory + ECT_REG_AL_EVENT_MASK, 0x10);
    assert_int_equal(line.al_event(line.ctx, &event), 0);
    assert_int_equal(event, 0x11);
    ect_store_le32(b->chip.esc->memory + ECT_REG_AL_EVENT_MASK, 0x20);
    assert_int_equal(line.al_event(line.ctx, &event), 0);
    assert_int_equal(event, 0); /* the line is inactive: nothing is read */
}

#define TEST(title, function)  {title, function, setup, teardown, NULL}
#define TABLE(title, function) {title, function, NULL, NULL, NULL}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("each register reads as the data sheet has it", each_register),
        TEST("an address stays, goes up or goes down from word to word", addresses_of_several_words),
        TEST("before the chip is ready BYTE_TEST alone is read", before_ready),
        TEST("RESET_CTL resets the chip by its bits 0 and 6", reset_by_register),
        TEST("registers of the ESC in 1, 2 and 4 bytes", registers_of_the_esc),
        TEST("an access of the ESC is busy for its time", access_of_the_esc_lasts),
        TEST("process RAM at any address and length", process_ram),
        TEST("each word of process RAM takes its time", each_word_lasts),
        TABLE("each mistake of a driver is counted", mistakes),
        TEST("in SQI mode RSTQIO alone is taken", quad_spi),
        TEST("the event word of the software ESC is read, with its line only while it is active", event_word),
    };
    return cmocka_run_group_tests_name("port_virtual", tests, NULL, NULL);
}
