/* SPDX-License-Identifier: MIT */
/*
 * The effects of a frame that wait for its end (data sheet I §3, §14.1): writes to registers, with a copy of their
 * data because later datagrams and controllers change the frame, and accesses to the last byte of a buffer. Buffers
 * change hands in any order among themselves, so a set has them; they are in the list only if a write follows them.
 */
#include <string.h>

#include "esc/internal.h"

enum { HEADER = 4, LATCHES = 0x8000, MASKED = 0x4000, LENGTH = 0x1FFF };

static uint8_t *append(ect_esc_t *esc, uint16_t address, unsigned int flags, uint32_t size)
{
    uint8_t *to = esc->postponed + esc->postponed_length;
    ECT_ASSERT(esc->postponed_length + size <= sizeof esc->postponed);
    ect_store_le16(to, address);
    ect_store_le16(to + 2, (uint16_t)flags);
    esc->postponed_length = (uint16_t)(esc->postponed_length + size);
    return to + HEADER;
}

/* The buffers that the frame has left so far change hands before the next write takes effect. */
static void list_buffers(ect_esc_t *esc)
{
    unsigned int set = esc->closing & ~(unsigned int)esc->listed;
    if (set != 0)
        (void)append(esc, (uint16_t)set, 0, HEADER);
    esc->listed = (uint8_t)(esc->listed | set);
}

void ect_esc_unlist(ect_esc_t *esc, unsigned int n)
{
    ect_postponed_t next;
    uint16_t at = 0, begin = 0;
    for (; ect_esc_next_postponed(esc, &at, &next); begin = at) {
        if (next.length == 0)
            ect_store_le16(esc->postponed + begin, (uint16_t)(next.address & ~(1u << n)));
    }
    esc->listed = (uint8_t)(esc->listed & ~(1u << n));
}

bool ect_esc_postpone_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint32_t size = HEADER + length * (access->mask ? 2u : 1u);
    ECT_ASSERT(length > 0 && length <= ECT_REG_USER_RAM);
    if (esc->postponed_length + HEADER + size > sizeof esc->postponed)
        return false;
    unsigned int flags =
        length | (access->latches ? (unsigned int)LATCHES : 0u) | (access->mask ? (unsigned int)MASKED : 0u);
    list_buffers(esc);
    uint8_t *to = append(esc, address, flags, size);
    esc->per_frame |= ECT_FRAME_COMMITS;
    memcpy(to, access->data, length);
    if (access->mask)
        memcpy(to + length, access->mask, length);
    return true;
}

bool ect_esc_next_postponed(ect_esc_t *esc, uint16_t *at, ect_postponed_t *next)
{
    uint8_t *from = esc->postponed + *at;
    ECT_ASSERT(*at <= esc->postponed_length);
    if (*at == esc->postponed_length)
        return false;
    unsigned int flags = ect_load_le16(from + 2);
    next->address = ect_load_le16(from);
    next->length = (uint16_t)(flags & LENGTH);
    next->access = (ect_access_t){.side = ECT_SIDE_ECAT,
                                  .stage = ECT_STAGE_COMMITS,
                                  .write = true,
                                  .latches = (flags & LATCHES) != 0,
                                  .data = from + HEADER,
                                  .mask = (flags & MASKED) != 0 ? from + HEADER + next->length : NULL};
    *at = (uint16_t)(*at + HEADER + next->length * ((flags & MASKED) != 0 ? 2 : 1));
    return true;
}
