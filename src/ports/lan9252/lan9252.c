/* SPDX-License-Identifier: MIT */
#include "ports/lan9252/lan9252.h"

#include <string.h>

#include "wire/bytes.h"
#include "wire/registers.h"

/* A transfer: an instruction, an address, words. */
enum { WRITE = 0x02, READ = 0x03, HEAD = 3, WORD = 4 };
enum { NEXT = 0x4000 }; /* in the address: each further word is for the next register */

/* The chip's own registers. A FIFO has one address; each word of a transfer to this address is the next word of the
 * FIFO. */
enum {
    READ_FIFO = 0x000,
    WRITE_FIFO = 0x020,
    ID_REV = 0x050,
    IRQ_CFG = 0x054,
    INT_EN = 0x05C,
    BYTE_TEST = 0x064,
    HW_CFG = 0x074,
    RESET_CTL = 0x1F8,
    CSR_DATA = 0x300, /* a register of the ESC: data, followed by the command */
    CSR_COMMAND = 0x304,
    RAM_READ = 0x308, /* process RAM: address and length, followed by the command */
    RAM_READ_COMMAND = 0x30C,
    RAM_WRITE = 0x310,
    RAM_WRITE_COMMAND = 0x314,
};

enum { FIFO_WORDS = 16, DEFAULT_PATIENCE = 100, DEFAULT_READY_MS = 1000, DEFAULT_CHECK_MS = 50 };

#define BUSY           0x80000000u /* write 1: begin; reads as 1 until the end */
#define CSR_READ       0x40000000u
#define CSR_SIZE(n)    ((uint32_t)(n) << 16)
#define CSR_MEANING    0x4007FFFFu /* direction, size, address; the other bits are undefined */
#define RAM_ABORT      0x40000000u
#define RAM_AVAILABLE  0x00000001u
#define RAM_WORDS(v)   (((v) >> 8) & 0x1F)
#define BYTE_TEST_GOOD 0x87654321u
#define CHIP_ID        0x92520000u
#define CHIP_READY     0x08000000u
#define RESET_ALL      0x00000001u
#define IRQ_ENABLE     0x00000100u
#define IRQ_HIGH       0x00000010u
#define IRQ_DRIVEN     0x00000001u
#define IRQ_SETTINGS   (IRQ_ENABLE | IRQ_HIGH | IRQ_DRIVEN)
#define INT_ESC        0x00000001u
#define LEAVE_SQI      0xFFu /* RSTQIO, in SPI and in SQI mode the same byte: all lines are high */

/* --- words on the SPI --------------------------------------------------------------------------------------------- */

/* Transfers words. `frame` has room for the head and `words` words. */
static int transfer(const ect_lan9252_t *chip, uint8_t instruction, uint16_t address, uint8_t *frame,
                    unsigned int words)
{
    frame[0] = instruction;
    ect_store_be16(frame + 1, address);
    return chip->spi->transfer(chip->spi->ctx, frame, (uint16_t)(HEAD + WORD * words));
}

static int load(const ect_lan9252_t *chip, uint16_t address, uint32_t *value)
{
    uint8_t frame[HEAD + WORD] = {0};
    int result = transfer(chip, READ, address, frame, 1);
    *value = ect_load_le32(frame + HEAD);
    return result;
}

static int store(const ect_lan9252_t *chip, uint16_t address, uint32_t value)
{
    uint8_t frame[HEAD + WORD];
    ect_store_le32(frame + HEAD, value);
    return transfer(chip, WRITE, address, frame, 1);
}

/* Writes a command, and its parameters into the preceding register. */
static int begin(const ect_lan9252_t *chip, uint16_t address, uint32_t about, uint32_t command)
{
    uint8_t frame[HEAD + 2 * WORD];
    ect_store_le32(frame + HEAD, about);
    ect_store_le32(frame + HEAD + WORD, command);
    return transfer(chip, WRITE, address | NEXT, frame, 2);
}

/* Reads a command register until it is not busy. @return -1: busy to the end */
static int wait(const ect_lan9252_t *chip, uint16_t address, uint32_t *value)
{
    for (unsigned int n = chip->patience != 0 ? chip->patience : DEFAULT_PATIENCE; n > 0; n--) {
        if (load(chip, address, value) < 0)
            return -1;
        if ((*value & BUSY) == 0)
            return 0;
    }
    return -1;
}

/* --- registers of the ESC ----------------------------------------------------------------------------------------- */

/* Compares a completed command with the sent one: a completed command reads back as received, which reveals damage. */
static int csr(const ect_lan9252_t *chip, uint32_t command)
{
    uint32_t done;
    return wait(chip, CSR_COMMAND, &done) == 0 && (done & CSR_MEANING) == command ? 0 : -1;
}

static int read_csr(const ect_lan9252_t *chip, uint16_t address, uint8_t *to, unsigned int bytes)
{
    uint8_t word[WORD];
    uint32_t value;
    uint32_t command = CSR_READ | CSR_SIZE(bytes) | address;
    if (store(chip, CSR_COMMAND, BUSY | command) < 0 || csr(chip, command) < 0 || load(chip, CSR_DATA, &value) < 0)
        return -1;
    ect_store_le32(word, value);
    memcpy(to, word, bytes);
    return 0;
}

static int write_csr(const ect_lan9252_t *chip, uint16_t address, const uint8_t *from, unsigned int bytes)
{
    uint8_t word[WORD] = {0};
    uint32_t command = CSR_SIZE(bytes) | address;
    memcpy(word, from, bytes);
    return begin(chip, CSR_DATA, ect_load_le32(word), BUSY | command) < 0 ? -1 : csr(chip, command);
}

/* --- process RAM -------------------------------------------------------------------------------------------------- */

/* Waits until a FIFO has words, or room for words. @return their number, at most `wanted`; -1: none in time */
static int available(const ect_lan9252_t *chip, uint16_t command, unsigned int wanted)
{
    for (unsigned int n = chip->patience != 0 ? chip->patience : DEFAULT_PATIENCE; n > 0; n--) {
        uint32_t value;
        if (load(chip, command, &value) < 0)
            return -1;
        if ((value & RAM_AVAILABLE) == 0)
            continue;
        unsigned int words = RAM_WORDS(value);
        if (words == 0 || words > FIFO_WORDS)
            return -1; /* not a valid status */
        return (int)(words < wanted ? words : wanted);
    }
    return -1;
}

/* The words of an access: the FIFO has the words of the memory, so an access may begin inside the first one. */
typedef struct piece {
    unsigned int skip;  /* bytes of the next word before the access */
    unsigned int words; /* remaining bytes */
    uint32_t left;      /* bytes */
} piece_t;

static piece_t whole(uint32_t address, uint32_t length)
{
    unsigned int skip = address % WORD;
    return (piece_t){.skip = skip, .words = (skip + length + WORD - 1) / WORD, .left = length};
}

/* @return the bytes of the access in a number of words; the next words begin with their first byte */
static uint32_t take(piece_t *p, unsigned int words)
{
    uint32_t bytes = WORD * words - p->skip;
    bytes = bytes < p->left ? bytes : p->left;
    p->skip = 0;
    p->words -= words;
    p->left -= bytes;
    return bytes;
}

static int read_ram(const ect_lan9252_t *chip, uint16_t address, uint8_t *to, uint16_t length)
{
    if (begin(chip, RAM_READ, (uint32_t)length << 16 | address, BUSY) < 0)
        return -1;
    for (piece_t p = whole(address, length); p.words > 0;) {
        uint8_t frame[HEAD + WORD * FIFO_WORDS] = {0};
        const uint8_t *from = frame + HEAD + p.skip;
        int words = available(chip, RAM_READ_COMMAND, p.words);
        if (words < 0 || transfer(chip, READ, READ_FIFO, frame, (unsigned int)words) < 0)
            return -1;
        uint32_t bytes = take(&p, (unsigned int)words);
        memcpy(to, from, bytes);
        to += bytes;
    }
    return 0;
}

/* Waits until the chip has written the last byte to its memory, because that byte may close a buffer. */
static int write_ram(const ect_lan9252_t *chip, uint16_t address, const uint8_t *from, uint16_t length)
{
    uint32_t done;
    if (begin(chip, RAM_WRITE, (uint32_t)length << 16 | address, BUSY) < 0)
        return -1;
    for (piece_t p = whole(address, length); p.words > 0;) {
        uint8_t frame[HEAD + WORD * FIFO_WORDS] = {0};
        uint8_t *to = frame + HEAD + p.skip;
        int words = available(chip, RAM_WRITE_COMMAND, p.words);
        if (words < 0)
            return -1;
        uint32_t bytes = take(&p, (unsigned int)words);
        memcpy(to, from, bytes);
        from += bytes;
        if (transfer(chip, WRITE, WRITE_FIFO, frame, (unsigned int)words) < 0)
            return -1;
    }
    return wait(chip, RAM_WRITE_COMMAND, &done);
}

/* --- the seam ----------------------------------------------------------------------------------------------------- */

/* Ends the remains of a failed access in the chip. */
static int settle(ect_lan9252_t *chip)
{
    uint32_t status;
    if (!chip->abandoned)
        return 0;
    if (store(chip, RAM_READ_COMMAND, RAM_ABORT) < 0 || store(chip, RAM_WRITE_COMMAND, RAM_ABORT) < 0 ||
        wait(chip, RAM_READ_COMMAND, &status) < 0 || wait(chip, RAM_WRITE_COMMAND, &status) < 0 ||
        wait(chip, CSR_COMMAND, &status) < 0)
        return -1;
    chip->abandoned = false;
    return 0;
}

/* @return the bytes of an access in one command: for a register the widest aligned access, for process RAM all */
static uint16_t part(uint32_t address, uint32_t left)
{
    return (uint16_t)(address >= ECT_RAM ? left : ect_pdi_part(address, left, WORD));
}

/* Reads to `to`, or writes from `from`; the other pointer is NULL. */
static int access_parts(ect_lan9252_t *chip, uint16_t address, uint8_t *to, const uint8_t *from, uint16_t length)
{
    int result = settle(chip);
    for (uint32_t done = 0, bytes; done < length && result == 0; done += bytes) {
        uint16_t at = (uint16_t)(address + done);
        bytes = part(at, length - done);
        if (at >= ECT_RAM)
            result =
                to ? read_ram(chip, at, to + done, (uint16_t)bytes) : write_ram(chip, at, from + done, (uint16_t)bytes);
        else
            result = to ? read_csr(chip, at, to + done, bytes) : write_csr(chip, at, from + done, bytes);
    }
    chip->abandoned = result < 0;
    return result;
}

static int read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    return access_parts(ctx, address, buffer, NULL, length);
}

static int write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    return access_parts(ctx, address, NULL, buffer, length);
}

static int al_event(void *ctx, uint32_t *event)
{
    const ect_lan9252_t *chip = ctx;
    return ect_pdi_line_event(chip->spi->line(chip->spi->ctx), read, ctx, event);
}

ect_pdi_t ect_lan9252_pdi(ect_lan9252_t *chip)
{
    return (ect_pdi_t){.ctx = chip, .read = read, .write = write, .al_event = chip->spi->line ? al_event : NULL};
}

/* --- the start ---------------------------------------------------------------------------------------------------- */

bool ect_lan9252_reset(const ect_lan9252_t *chip)
{
    const ect_spi_t *spi = chip->spi;
    if (!spi->reset)
        return store(chip, RESET_CTL, RESET_ALL) >= 0;
    spi->reset(spi->ctx, true);
    spi->pause(spi->ctx, 1000); /* the chip needs 200 us */
    spi->reset(spi->ctx, false);
    return true;
}

/* Ends SQI mode, which an earlier program may have left on, and in which the chip accepts no other instruction of SPI.
 */
static int leave_sqi(const ect_lan9252_t *chip)
{
    uint8_t instruction = LEAVE_SQI;
    return chip->spi->transfer(chip->spi->ctx, &instruction, 1) < 0 ? ECT_LAN9252_SPI : ECT_LAN9252_SILENT;
}

/* ECT_LAN9252_READY, or the present obstacle. */
static int check_chip(ect_lan9252_t *chip)
{
    uint32_t order, id, state;
    if (load(chip, BYTE_TEST, &order) < 0 || load(chip, ID_REV, &id) < 0 || load(chip, HW_CFG, &state) < 0)
        return ECT_LAN9252_SPI;
    if (order != BYTE_TEST_GOOD)
        return leave_sqi(chip);
    if ((state & CHIP_READY) == 0)
        return ECT_LAN9252_NOT_READY;
    return (id & 0xFFFF0000u) == CHIP_ID ? ECT_LAN9252_READY : ECT_LAN9252_STRANGER;
}

static int check_esc(ect_lan9252_t *chip)
{
    uint8_t status;
    if (read(chip, ECT_REG_DL_STATUS, &status, 1) < 0)
        return ECT_LAN9252_SPI;
    return (status & 1u) != 0 ? ECT_LAN9252_READY : ECT_LAN9252_NO_EEPROM;
}

/* Drives an active-high pin, because the chip ignores the polarity of an open drain, which is always active low. */
static uint32_t interrupt_pin(const ect_lan9252_t *chip)
{
    return IRQ_ENABLE | (chip->interrupt_high ? IRQ_HIGH | IRQ_DRIVEN : chip->interrupt_driven ? IRQ_DRIVEN : 0);
}

static int set_interrupt(const ect_lan9252_t *chip)
{
    return store(chip, IRQ_CFG, interrupt_pin(chip)) < 0 || store(chip, INT_EN, INT_ESC) < 0 ? ECT_LAN9252_SPI
                                                                                             : ECT_LAN9252_READY;
}

/* Repeats a check each millisecond until it passes. @return its last result */
static int await_ready(ect_lan9252_t *chip, int (*check)(ect_lan9252_t *chip))
{
    unsigned int patience_ms = chip->ready_ms != 0 ? chip->ready_ms : DEFAULT_READY_MS;
    int result = check(chip);
    for (; result != ECT_LAN9252_READY && patience_ms > 0; patience_ms--) {
        chip->spi->pause(chip->spi->ctx, 1000);
        result = check(chip);
    }
    return result;
}

int ect_lan9252_start(ect_lan9252_t *chip)
{
    int result = await_ready(chip, check_chip);
    if (result != ECT_LAN9252_READY)
        return result;
    chip->abandoned = true; /* by an earlier program */
    result = await_ready(chip, check_esc);
    return result == ECT_LAN9252_READY ? set_interrupt(chip) : result;
}

/* --- a chip that was reset ---------------------------------------------------------------------------------------- */

/* IRQ_CFG, INT_STS and INT_EN, in one transfer. A failed transfer is no sign of a reset.
 */
static bool has_settings(const ect_lan9252_t *chip)
{
    uint8_t frame[HEAD + 3 * WORD] = {0};
    if (transfer(chip, READ, IRQ_CFG | NEXT, frame, 3) < 0)
        return true;
    return (ect_load_le32(frame + HEAD) & IRQ_SETTINGS) == interrupt_pin(chip) &&
           (ect_load_le32(frame + HEAD + 2 * WORD) & INT_ESC) != 0;
}

bool ect_lan9252_check(ect_lan9252_t *chip, uint64_t now_ns)
{
    uint64_t interval_ns = (chip->check_ms != 0 ? chip->check_ms : DEFAULT_CHECK_MS) * UINT64_C(1000000);
    if (now_ns < chip->check_ns)
        return true;
    chip->check_ns = now_ns + interval_ns;
    if (has_settings(chip))
        return true;
    return has_settings(chip); /* one damaged transfer is no reset */
}
