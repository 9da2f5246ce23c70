/* SPDX-License-Identifier: MIT */
#include "bus/capture/recent.h"

#include <stdlib.h>
#include <string.h>

#include "wire/assert.h"
#include "wire/bytes.h"

static void add_head(ect_recent_t *r, const uint8_t *block, size_t length)
{
    ECT_ASSERT(r->head_length + length <= sizeof r->head);
    memcpy(r->head + r->head_length, block, length);
    r->head_length += length;
}

bool ect_recent_start(ect_recent_t *r, const char *const names[2], uint64_t offset_ns)
{
    uint8_t block[ECT_PCAPNG_ROOM];
    if (!r->bytes)
        r->bytes = malloc(ECT_RECENT_BYTES);
    if (!r->bytes)
        return false;
    r->head_length = 0;
    r->first = r->end = 0;
    r->offset_ns = offset_ns;
    add_head(r, block, ect_pcapng_section(block, "ectwin"));
    add_head(r, block, ect_pcapng_interface(block, names[0]));
    add_head(r, block, ect_pcapng_interface(block, names[1]));
    r->serial++;
    r->on = true;
    return true;
}

void ect_recent_stop(ect_recent_t *r)
{
    r->on = false;
}

/* Copies bytes of the ring, which may wrap in between. */
static void copy_out(const ect_recent_t *r, uint64_t from, uint8_t *to, size_t length)
{
    const size_t at = (size_t)(from % ECT_RECENT_BYTES);
    const size_t first = length < ECT_RECENT_BYTES - at ? length : ECT_RECENT_BYTES - at;
    memcpy(to, r->bytes + at, first);
    memcpy(to + first, r->bytes, length - first);
}

static void copy_in(ect_recent_t *r, const uint8_t *block, size_t length)
{
    const size_t at = (size_t)(r->end % ECT_RECENT_BYTES);
    const size_t first = length < ECT_RECENT_BYTES - at ? length : ECT_RECENT_BYTES - at;
    memcpy(r->bytes + at, block, first);
    memcpy(r->bytes, block + first, length - first);
    r->end += length;
}

/* The length of a block is in its bytes 4 to 7. */
static void drop_oldest(ect_recent_t *r)
{
    uint8_t length[4];
    copy_out(r, r->first + 4, length, sizeof length);
    r->first += ect_load_le32(length);
    ECT_ASSERT(r->first <= r->end);
}

void ect_recent_add(ect_recent_t *r, uint32_t end, ect_pcapng_direction_t direction, uint64_t time_ns,
                    const uint8_t *frame, size_t length)
{
    uint8_t block[ECT_PCAPNG_ROOM];
    const ect_pcapng_packet_t packet = {
        .interface = end,
        .direction = direction,
        .time_ns = time_ns + r->offset_ns,
        .frame = frame,
        .captured = length < ECT_PCAPNG_FRAME_MOST ? (uint32_t)length : (uint32_t)ECT_PCAPNG_FRAME_MOST,
        .length = (uint32_t)length,
    };
    if (!r->on)
        return;
    const size_t size = ect_pcapng_packet(block, &packet);
    while (r->end - r->first + size > ECT_RECENT_BYTES)
        drop_oldest(r);
    copy_in(r, block, size);
}

size_t ect_recent_size(const ect_recent_t *r)
{
    return r->head_length + (size_t)(r->end - r->first);
}

void ect_recent_read(const ect_recent_t *r, size_t offset, uint8_t *to, size_t length)
{
    ECT_ASSERT(length <= ect_recent_size(r) && offset <= ect_recent_size(r) - length);
    if (offset < r->head_length) {
        const size_t head = length < r->head_length - offset ? length : r->head_length - offset;
        memcpy(to, r->head + offset, head);
        to += head;
        offset += head;
        length -= head;
    }
    if (length > 0)
        copy_out(r, r->first + (offset - r->head_length), to, length);
}

void ect_recent_free(ect_recent_t *r)
{
    free(r->bytes);
    *r = (ect_recent_t){0};
}
