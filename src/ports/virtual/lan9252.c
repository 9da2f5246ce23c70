/* SPDX-License-Identifier: MIT */
#include "ports/virtual/lan9252.h"

#include <string.h>

#include "wire/bytes.h"
#include "wire/registers.h"

typedef ect_virtual_lan9252_t chip_t;

enum { FIFO = ECT_VIRTUAL_LAN9252_FIFO, ADDRESS_MASK = 0x3FFF, UP = 0x4000, DOWN = 0x8000 };
#define BUSY         0x80000000u
#define ABORT        0x40000000u
#define CSR_RESERVED 0x3FF80000u /* undefined bits of the command, which read as 1 in this model */
#define IRQ_ENABLE   0x00000100u
#define IRQ_HIGH     0x00000010u
#define IRQ_DRIVEN   0x00000001u

static void mistake(chip_t *c, const char *what)
{
    c->mistakes++;
    c->mistake = what;
}

/* --- reset -------------------------------------------------------------------------------------------------------- */

/* Resets the registers of the chip itself; faults and costs set by the user of the model are unchanged. */
static void clear_registers(chip_t *c)
{
    c->irq_cfg = c->int_en = c->csr_data = c->csr_command = 0;
    c->reading = c->writing = (ect_virtual_fifo_t){0};
    c->csr_left = c->ram_time = 0;
    c->starting = c->ready_after;
    c->sqi = false;
    c->resets = ect_esc_resets(c->esc);
}

static void power_on(chip_t *c)
{
    ect_esc_config_t config = c->esc->config;
    (void)ect_esc_init(c->esc, &config, c->esc->now_ns); /* the same configuration has been accepted before */
    clear_registers(c);
}

/* A reset sequence in 0x0040 or 0x0041 resets the whole chip. */
static void follow_esc(chip_t *c)
{
    if (c->resets != ect_esc_resets(c->esc))
        clear_registers(c);
}

static bool is_ready(const chip_t *c)
{
    return !c->held && !c->never_ready && c->starting == 0;
}

/* --- registers of the ESC ----------------------------------------------------------------------------------------- */

static void begin_csr(chip_t *c, uint32_t command)
{
    uint32_t bytes = (command >> 16) & 7;
    uint16_t address = (uint16_t)command;
    uint8_t word[4] = {0};
    if (c->csr_left > 0) {
        mistake(c, "a command to a register of the ESC while the last one is busy");
        return;
    }
    c->csr_command = command & ~BUSY;
    if ((command & BUSY) == 0)
        return;
    if ((bytes != 1 && bytes != 2 && bytes != 4) || address % bytes != 0 || address >= ECT_RAM) {
        mistake(c, "a register of the ESC with an invalid address or size");
        return;
    }
    ect_store_le32(word, c->csr_data);
    if ((command & ABORT) == 0) { /* this bit is the direction here */
        (void)ect_esc_pdi_write(c->esc, address, word, (uint16_t)bytes);
    } else {
        memset(word, 0xA5, sizeof word); /* bytes that were not requested are undefined */
        (void)ect_esc_pdi_read(c->esc, address, word, (uint16_t)bytes);
        c->csr_data = ect_load_le32(word);
    }
    c->csr_left = c->csr_stuck ? UINT32_MAX : c->csr_lasts;
}

/* --- process RAM -------------------------------------------------------------------------------------------------- */

static void push(ect_virtual_fifo_t *f, uint32_t word)
{
    f->word[(f->first + f->count) % FIFO] = word;
    f->count++;
}

static uint32_t pull(ect_virtual_fifo_t *f)
{
    uint32_t word = f->word[f->first];
    f->first = (f->first + 1) % FIFO;
    f->count--;
    return word;
}

/* @return the bytes of the next word that the ESC moves */
static uint16_t next_bytes(const ect_virtual_fifo_t *f)
{
    uint16_t bytes = (uint16_t)(4 - f->address % 4);
    return bytes < f->left ? bytes : f->left;
}

static void moved(ect_virtual_fifo_t *f, uint16_t bytes)
{
    f->address = (uint16_t)(f->address + bytes);
    f->left = (uint16_t)(f->left - bytes);
    f->busy = f->left > 0;
}

/* Moves a word of the ESC in a direction. @return whether a word was moved */
static bool move_word(chip_t *c)
{
    uint8_t word[4];
    if (c->reading.busy && c->reading.count < FIFO) {
        uint16_t bytes = next_bytes(&c->reading);
        memset(word, 0xA5, sizeof word);
        (void)ect_esc_pdi_read(c->esc, c->reading.address, word + c->reading.address % 4, bytes);
        push(&c->reading, ect_load_le32(word));
        moved(&c->reading, bytes);
        return true;
    }
    if (c->writing.busy && c->writing.count > 0) {
        uint16_t bytes = next_bytes(&c->writing);
        ect_store_le32(word, pull(&c->writing));
        (void)ect_esc_pdi_write(c->esc, c->writing.address, word + c->writing.address % 4, bytes);
        moved(&c->writing, bytes);
        return true;
    }
    return false;
}

static void about(chip_t *c, ect_virtual_fifo_t *f, uint32_t value)
{
    if (f->busy) {
        mistake(c, "address and length of process RAM while it is busy");
        return;
    }
    f->address = (uint16_t)value;
    f->left = (uint16_t)(value >> 16);
}

static void command_ram(chip_t *c, ect_virtual_fifo_t *f, uint32_t command)
{
    if ((command & ABORT) != 0) {
        f->busy = false;
        f->count = 0;
        f->left = 0;
    }
    if ((command & BUSY) == 0)
        return;
    if (f->busy || f->count > 0)
        mistake(c, "process RAM: a command before the last one is done, or its data are read");
    else if (f->left == 0 || f->address < ECT_RAM)
        mistake(c, "process RAM: an invalid address or length");
    else
        f->busy = true;
}

static uint32_t ram_status(const ect_virtual_fifo_t *f, unsigned int words)
{
    return (f->busy ? BUSY : 0) | words << 8 | (words > 0 ? 1u : 0);
}

static uint32_t read_fifo(chip_t *c)
{
    if (c->reading.count > 0)
        return pull(&c->reading);
    mistake(c, "a word from an empty FIFO");
    return 0xDEADBEEF;
}

static void write_fifo(chip_t *c, uint32_t word)
{
    if (c->writing.count < FIFO)
        push(&c->writing, word);
    else
        mistake(c, "a word into a full FIFO");
}

/* --- the registers ------------------------------------------------------------------------------------------------ */

static uint32_t load_ram(chip_t *c, uint16_t address)
{
    if (address < 0x020)
        return read_fifo(c);
    switch (address) {
    case 0x308:
        return (uint32_t)c->reading.left << 16 | c->reading.address;
    case 0x30C:
        return ram_status(&c->reading, c->reading.count);
    case 0x310:
        return (uint32_t)c->writing.left << 16 | c->writing.address;
    case 0x314:
        return ram_status(&c->writing, FIFO - c->writing.count);
    default:
        return 0;
    }
}

static bool interrupts(const chip_t *c)
{
    return is_ready(c) && (c->irq_cfg & IRQ_ENABLE) != 0 && (c->int_en & 1) != 0 && ect_esc_line(c->esc);
}

static uint32_t load(chip_t *c, uint16_t address)
{
    if (!is_ready(c))
        return address == 0x064 && !c->held ? 0x87654321u : 0; /* no other register may be read before */
    switch (address) {
    case 0x050:
        return 0x92520001u;
    case 0x054:
        return c->irq_cfg | (interrupts(c) ? 1u << 12 : 0);
    case 0x058:
        return ect_esc_line(c->esc) ? 1 : 0;
    case 0x05C:
        return c->int_en;
    case 0x064:
        return 0x87654321u;
    case 0x074:
        return 1u << 27;
    case 0x300:
        return c->csr_data;
    case 0x304:
        return c->csr_command | CSR_RESERVED | (c->csr_left > 0 ? BUSY : 0);
    default:
        return load_ram(c, address);
    }
}

static void store_ram(chip_t *c, uint16_t address, uint32_t value)
{
    switch (address) {
    case 0x308:
        about(c, &c->reading, value);
        break;
    case 0x30C:
        command_ram(c, &c->reading, value);
        break;
    case 0x310:
        about(c, &c->writing, value);
        break;
    case 0x314:
        command_ram(c, &c->writing, value);
        break;
    default:
        if (address >= 0x020 && address < 0x040)
            write_fifo(c, value);
        else
            mistake(c, "a word to an address where nothing can be written");
    }
}

static void store(chip_t *c, uint16_t address, uint32_t value)
{
    if (!is_ready(c))
        return;
    switch (address) {
    case 0x054:
        c->irq_cfg = value;
        break;
    case 0x05C:
        c->int_en = value;
        break;
    case 0x1F8:
        if ((value & 0x41) != 0) /* the chip, or the ESC: not distinguished by the model */
            power_on(c);
        break;
    case 0x300:
        c->csr_data = value;
        break;
    case 0x304:
        begin_csr(c, value);
        break;
    default:
        store_ram(c, address, value);
    }
}

/* --- the SPI ------------------------------------------------------------------------------------------------------ */

static bool flips(chip_t *c)
{
    c->bits++;
    if (c->flip_one_in != 0) {
        c->flip_seed = c->flip_seed * 1664525u + 1013904223u;
        if (c->flip_seed / (UINT32_MAX / c->flip_one_in) == 0)
            return true;
    }
    return c->bits == c->flip_at;
}

static uint8_t over_the_wire(chip_t *c, uint8_t byte)
{
    for (unsigned int bit = 0; bit < 8; bit++)
        byte ^= (uint8_t)((unsigned int)flips(c) << bit);
    return byte;
}

/* Advances the time by a byte. */
static void pass_time(chip_t *c)
{
    c->starting -= c->starting > 0 ? 1u : 0;
    c->csr_left -= c->csr_left > 0 && c->csr_left != UINT32_MAX ? 1u : 0;
    c->ram_time++;
    while (!c->ram_stuck && c->ram_time >= c->word_lasts && is_ready(c) && move_word(c))
        c->ram_time = 0;
}

/* The state of a transfer. */
typedef struct spi {
    uint8_t instruction;
    uint16_t address; /* with the bits of its direction */
    uint8_t word[4];
    unsigned int head; /* bytes before the data */
} spi_t;

static void next_address(spi_t *t)
{
    uint16_t step = (t->address & UP) != 0 ? 4 : (t->address & DOWN) != 0 ? (uint16_t)-4 : 0;
    t->address = (uint16_t)((t->address & ~ADDRESS_MASK) | ((t->address + step) & ADDRESS_MASK));
}

/* Transfers data byte number n in both directions. */
static uint8_t data(chip_t *c, spi_t *t, unsigned int n, uint8_t in)
{
    bool reads = t->instruction != 0x02;
    uint16_t address = t->address & ADDRESS_MASK & ~3u;
    uint8_t out = 0;
    if (reads && n % 4 == 0)
        ect_store_le32(t->word, load(c, address));
    if (reads)
        out = t->word[n % 4];
    else
        t->word[n % 4] = in;
    if (n % 4 == 3) {
        if (!reads)
            store(c, address, ect_load_le32(t->word));
        next_address(t);
    }
    return out;
}

static void head(chip_t *c, spi_t *t, unsigned int n, uint8_t in)
{
    if (n == 0) {
        t->instruction = in;
        t->head = in == 0x0B ? 4 : 3;
        if (in != 0x02 && in != 0x03 && in != 0x0B)
            mistake(c, "an unknown instruction");
    } else if (n < 3) {
        t->address = (uint16_t)(t->address << 8 | in);
    }
}

/*
 * Executes EQIO and RSTQIO, instructions without an address. In SQI mode the chip interprets two bits of a single data
 * line as two nibbles whose other lines are pulled up, so RSTQIO is the only instruction that a host on SPI can send.
 */
static int in_one_byte(chip_t *c, uint8_t *bytes, uint16_t length)
{
    uint8_t instruction = bytes[0];
    memset(bytes, 0xFF, length);
    if (instruction == 0xFF && length == 1)
        c->sqi = false;
    else if (instruction == 0x38 && length == 1)
        c->sqi = true;
    else if (length == 1)
        mistake(c, "an unknown instruction of one byte");
    return 0;
}

int ect_virtual_lan9252_transfer(void *chip, uint8_t *bytes, uint16_t length)
{
    chip_t *c = chip;
    spi_t t = {0};
    follow_esc(c);
    c->transfers++;
    c->bytes += length;
    if (c->sqi || length == 1)
        return in_one_byte(c, bytes, length);
    for (unsigned int n = 0; n < length; n++) {
        uint8_t out = 0;
        uint8_t in = over_the_wire(c, bytes[n]);
        pass_time(c);
        if (n < 3 || n < t.head)
            head(c, &t, n, in);
        else if (t.instruction == 0x02 || t.instruction == 0x03 || t.instruction == 0x0B)
            out = data(c, &t, n - t.head, in);
        bytes[n] = over_the_wire(c, out);
    }
    if (length < t.head + 4u || (length - t.head) % 4 != 0)
        mistake(c, "a transfer that is not of whole words");
    return 0;
}

void ect_virtual_lan9252_reset(void *chip, bool active)
{
    chip_t *c = chip;
    if (c->held && !active)
        power_on(c);
    c->held = active;
}

void ect_virtual_lan9252_pause(void *chip, uint32_t us)
{
    for (uint64_t bytes = us * 5ull / 2; bytes > 0; bytes--)
        pass_time(chip);
}

/* Polarity applies to a driven pin only. An open drain is low or released; the board pulls a released pin to its
 * inactive level. */
bool ect_virtual_lan9252_line(void *chip)
{
    chip_t *c = chip;
    follow_esc(c);
    bool active = interrupts(c);
    bool driven = is_ready(c) && (c->irq_cfg & (IRQ_ENABLE | IRQ_DRIVEN)) == (IRQ_ENABLE | IRQ_DRIVEN);
    bool high = driven && (c->irq_cfg & IRQ_HIGH) != 0 ? active : !active;
    return (driven || active) && high == c->active_high;
}
