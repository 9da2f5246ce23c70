/* SPDX-License-Identifier: MIT */
/*
 * FMMUs: a window of logical bits onto physical bits. Whole bytes need one access; a window that starts or ends inside
 * a byte goes through a small buffer, in pieces, with a mask of the bits that belong to it.
 */
#include <string.h>

#include "esc/internal.h"
#include "esc/route.h"

enum { PIECE = 64 };

/* The overlap of one active FMMU with one datagram, in bits. */
typedef struct window {
    uint32_t first_bit;    /* of the overlap, from the datagram's first data bit */
    uint32_t bit_count;    /* of the overlap */
    uint32_t physical_bit; /* start of the overlap, from ESC address 0 */
} window_t;

static bool overlap(const uint8_t *fmmu, uint32_t logical, uint16_t length, window_t *window)
{
    uint16_t bytes = ect_load_le16(fmmu + ECT_FMMU_LENGTH);
    if (bytes == 0)
        return false;
    uint64_t start = (uint64_t)ect_load_le32(fmmu + ECT_FMMU_LOGICAL) * 8u;
    uint64_t end = start + (bytes - 1u) * 8ull + fmmu[ECT_FMMU_STOP_BIT] + 1u;
    start += fmmu[ECT_FMMU_START_BIT];
    uint64_t frame_start = (uint64_t)logical * 8u;
    uint64_t frame_end = frame_start + length * 8ull;
    uint64_t first = start > frame_start ? start : frame_start;
    uint64_t last = end < frame_end ? end : frame_end;
    if (first >= last)
        return false;
    window->first_bit = (uint32_t)(first - frame_start);
    window->bit_count = (uint32_t)(last - first);
    window->physical_bit =
        ect_load_le16(fmmu + ECT_FMMU_PHYSICAL) * 8u + fmmu[ECT_FMMU_PHYSICAL_BIT] + (uint32_t)(first - start);
    return true;
}

/* Bytes of a window from `first` on that are inside the address space. */
static uint32_t inside(uint32_t first, uint32_t bytes)
{
    if (first >= ECT_ESC_ADDRESS_SPACE)
        return 0;
    return bytes < ECT_ESC_ADDRESS_SPACE - first ? bytes : ECT_ESC_ADDRESS_SPACE - first;
}

/* Transfers a piece of at most PIECE physical bytes. */
static bool move_bits(ect_esc_t *esc, uint8_t *data, const window_t *w, bool write)
{
    static const uint8_t ones[PIECE] = {
        0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
        0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
        0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
        0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
    };
    uint8_t buffer[PIECE] = {0};
    uint8_t mask[PIECE] = {0};
    uint32_t shift = w->physical_bit % 8;
    ECT_ASSERT(w->bit_count > 0 && shift + w->bit_count <= PIECE * 8);
    uint32_t first = w->physical_bit / 8;
    uint32_t bytes = inside(first, (shift + w->bit_count + 7) / 8);
    if (bytes == 0)
        return false;
    ect_access_t access = {.side = ECT_SIDE_ECAT, .write = write, .data = buffer, .mask = NULL};
    ect_copy_bits(buffer, shift, data, w->first_bit, w->bit_count); /* unreadable bits keep the value of the frame */
    if (write) {
        ect_copy_bits(mask, shift, ones, 0, w->bit_count);
        access.mask = mask;
    }
    if (!ect_esc_access(esc, &access, (uint16_t)first, (uint16_t)bytes))
        return false;
    if (!write)
        ect_copy_bits(data, w->first_bit, buffer, shift, w->bit_count);
    return true;
}

static bool move(ect_esc_t *esc, uint8_t *data, window_t w, bool write)
{
    if (w.first_bit % 8 == 0 && w.bit_count % 8 == 0 && w.physical_bit % 8 == 0) {
        uint32_t first = w.physical_bit / 8;
        uint32_t bytes = inside(first, w.bit_count / 8);
        if (bytes == 0)
            return false;
        ect_access_t access = {.side = ECT_SIDE_ECAT, .write = write, .data = data + w.first_bit / 8};
        return ect_esc_access(esc, &access, (uint16_t)first, (uint16_t)bytes);
    }
    bool any = false;
    while (w.bit_count > 0) {
        window_t piece = w;
        uint32_t room = PIECE * 8u - w.physical_bit % 8;
        if (piece.bit_count > room)
            piece.bit_count = room;
        any |= move_bits(esc, data, &piece, write);
        w.first_bit += piece.bit_count;
        w.physical_bit += piece.bit_count;
        w.bit_count -= piece.bit_count;
    }
    return any;
}

static window_t part(const window_t *w, uint32_t first_bit, uint32_t end_bit)
{
    ECT_ASSERT(first_bit >= w->first_bit && first_bit < end_bit && end_bit <= w->first_bit + w->bit_count);
    return (window_t){.first_bit = first_bit,
                      .bit_count = end_bit - first_bit,
                      .physical_bit = w->physical_bit + (first_bit - w->first_bit)};
}

/* Finds the next part of a window that none of the first `taken` windows claims. */
static bool move_unclaimed(ect_esc_t *esc, uint8_t *data, const window_t *w, bool write, const window_t *taken,
                           unsigned int count)
{
    ECT_ASSERT(w->bit_count > 0 && count < ECT_ESC_MAX_FMMU);
    uint32_t at = w->first_bit;
    uint32_t end = at + w->bit_count;
    bool any = false;
    while (at < end) {
        uint32_t free_end = end;
        uint32_t claimed_end = at;
        for (unsigned int i = 0; i < count; i++) {
            uint32_t taken_end = taken[i].first_bit + taken[i].bit_count;
            if (taken[i].first_bit > at)
                free_end = taken[i].first_bit < free_end ? taken[i].first_bit : free_end;
            else if (taken_end > claimed_end)
                claimed_end = taken_end;
        }
        if (claimed_end == at)
            any |= move(esc, data, part(w, at, free_end), write);
        at = claimed_end == at ? free_end : claimed_end;
    }
    return any;
}

/* One direction through all FMMUs. When two FMMUs map a bit, the lower number wins (data sheet I §7). */
static bool pass_bits(ect_esc_t *esc, uint32_t logical, uint8_t *data, uint16_t length, bool write)
{
    window_t taken[ECT_ESC_MAX_FMMU];
    unsigned int count = 0;
    bool any = false;
    unsigned int active = write ? esc->fmmu_writes : esc->fmmu_reads;
    for (unsigned int n = 0; active >> n != 0; n++) {
        if ((active >> n & 1u) == 0 || !overlap(ect_esc_fmmu_registers(esc, n), logical, length, &taken[count]))
            continue;
        any |= count == 0 ? move(esc, data, taken[0], write)
                          : move_unclaimed(esc, data, &taken[count], write, taken, count);
        count++;
    }
    return any;
}

/* Reads come first, as bits 0 to 7 of a set, then writes. */
unsigned int ect_esc_fmmu_bytes(ect_esc_t *esc, uint32_t logical, uint8_t *data, uint16_t length, unsigned int part)
{
    unsigned int set = ((part & ECT_PART_READ) != 0 ? esc->fmmu_reads : 0u) |
                       ((part & ECT_PART_WRITE) != 0 ? esc->fmmu_writes : 0u) << ECT_ESC_MAX_FMMU;
    const bool unread = (part & ECT_PART_UNREAD) != 0;
    uint64_t frame_end = (uint64_t)logical + length;
    unsigned int done = 0;
    ECT_ASSERT(length <= ECT_ESC_MAX_FRAME && esc->fmmus_plain);
    while (set != 0) {
        unsigned int n = ect_esc_take(&set);
        bool writes = n >= ECT_ESC_MAX_FMMU;
        const uint8_t *fmmu = ect_esc_fmmu_registers(esc, n % ECT_ESC_MAX_FMMU);
        uint64_t start = ect_load_le32(fmmu + ECT_FMMU_LOGICAL);
        uint64_t first = start > logical ? start : logical;
        uint64_t end = start + ect_load_le16(fmmu + ECT_FMMU_LENGTH);
        end = end < frame_end ? end : frame_end;
        if (first >= end)
            continue;
        ect_access_t access = {
            .side = ECT_SIDE_ECAT, .write = writes, .unread = unread, .data = data + (first - logical)};
        uint32_t physical = ect_load_le16(fmmu + ECT_FMMU_PHYSICAL) + (uint32_t)(first - start);
        if (ect_esc_access(esc, &access, (uint16_t)physical, (uint16_t)(end - first)))
            done |= writes ? ECT_PART_WRITE : ECT_PART_READ;
    }
    return done;
}

unsigned int ect_esc_fmmu_bits(ect_esc_t *esc, uint32_t logical, uint8_t *data, uint16_t length, unsigned int part)
{
    const bool read = (part & ECT_PART_READ) != 0, write = (part & ECT_PART_WRITE) != 0;
    unsigned int done = 0;
    ECT_ASSERT(length <= ECT_ESC_MAX_FRAME);
    uint8_t *incoming = data;
    if (read && write) { /* the data read may overwrite data that are yet to be written */
        incoming = esc->scratch;
        memcpy(incoming, data, length);
    }
    if (read && pass_bits(esc, logical, data, length, false))
        done |= ECT_PART_READ;
    if (write && pass_bits(esc, logical, incoming, length, true))
        done |= ECT_PART_WRITE;
    return done;
}
