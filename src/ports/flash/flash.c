/* SPDX-License-Identifier: MIT */
#include "ports/flash/flash.h"

#include <stddef.h>
#include <string.h>

#include "seams/record.h"

/* A record's header begins a bank, and is written after the rest of the record is programmed. */
enum { HEADER = ECT_RECORD_HEADER, ERASED = 0xFF };

static uint32_t unit_of(const ect_flash_t *f)
{
    return f->unit != 0 ? f->unit : 1;
}

static uint32_t header_room(const ect_flash_t *f)
{
    return unit_of(f) > HEADER ? unit_of(f) : HEADER;
}

/* Address of a byte of a bank in the flash. */
static uint32_t place(const ect_flash_t *f, unsigned int bank, uint32_t offset)
{
    return f->area[bank] + (offset < HEADER ? offset : offset - HEADER + header_room(f));
}

/* --- the driver, or memory ---------------------------------------------------------------------------------------- */

static int read_flash(const ect_flash_t *f, uint32_t address, void *buffer, uint32_t length)
{
    if (f->read)
        return f->read(f->ctx, address, buffer, length);
    memcpy(buffer, f->memory + address, length);
    return 0;
}

static int program(ect_flash_t *f)
{
    f->gathered_bytes = 0;
    if (f->program)
        return f->program(f->ctx, f->gathered_at, f->gathered, unit_of(f));
    memcpy(f->memory + f->gathered_at, f->gathered, unit_of(f));
    return 0;
}

/* --- the seam ----------------------------------------------------------------------------------------------------- */

/* Gathered bytes count as written. */
static void read_gathered(const ect_flash_t *f, uint32_t address, uint8_t *buffer, uint32_t length)
{
    for (uint32_t n = 0; n < f->gathered_bytes; n++) {
        uint32_t at = f->gathered_at + n - address;
        if (at < length)
            buffer[at] = f->gathered[n];
    }
}

static int read_piece(const ect_flash_t *f, uint32_t address, uint8_t *buffer, uint32_t length)
{
    if (length == 0)
        return 0;
    if (read_flash(f, address, buffer, length) < 0)
        return -1;
    read_gathered(f, address, buffer, length);
    return 0;
}

static int bank_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    const ect_flash_t *f = ctx;
    uint8_t *to = buffer;
    uint32_t first = offset >= HEADER ? 0 : HEADER - offset; /* bytes of the header */
    first = first < length ? first : length;
    if (read_piece(f, place(f, bank, offset), to, first) < 0)
        return -1;
    return read_piece(f, place(f, bank, offset + first), to + first, length - first);
}

static int bank_erase(void *ctx, unsigned int bank)
{
    ect_flash_t *f = ctx;
    f->gathered_bytes = 0;
    if (f->erase)
        return f->erase(f->ctx, f->area[bank], f->area_size);
    memset(f->memory + f->area[bank], ERASED, f->area_size);
    return 0;
}

/* The rest of a unit keeps the value of erased flash. */
static int bank_flush(void *ctx, unsigned int bank, bool wait)
{
    ect_flash_t *f = ctx;
    (void)bank;
    (void)wait;
    if (f->gathered_bytes == 0)
        return 0;
    memset(f->gathered + f->gathered_bytes, ERASED, unit_of(f) - f->gathered_bytes);
    return program(f);
}

static int gather(ect_flash_t *f, uint32_t address, uint8_t byte)
{
    if (f->gathered_bytes > 0 && address != f->gathered_at + f->gathered_bytes && bank_flush(f, 0, true) < 0)
        return -1;
    if (f->gathered_bytes == 0) {
        if (address % unit_of(f) != 0)
            return -1; /* a write into a unit that may be programmed already */
        f->gathered_at = address;
    }
    f->gathered[f->gathered_bytes++] = byte;
    return f->gathered_bytes == unit_of(f) ? program(f) : 0;
}

static int bank_write(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length)
{
    ect_flash_t *f = ctx;
    const uint8_t *from = data;
    for (uint32_t n = 0; n < length; n++) {
        if (gather(f, place(f, bank, offset + n), from[n]) < 0)
            return -1;
    }
    return 0;
}

ect_storage_t ect_flash_storage(ect_flash_t *flash)
{
    return (ect_storage_t){.ctx = flash,
                           .bank_size = flash->area_size - (header_room(flash) - HEADER),
                           .read = bank_read,
                           .erase = bank_erase,
                           .write = bank_write,
                           .flush = bank_flush};
}
