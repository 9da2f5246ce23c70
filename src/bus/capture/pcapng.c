/* SPDX-License-Identifier: MIT */
#include "bus/capture/pcapng.h"

#include <string.h>

#include "wire/assert.h"
#include "wire/bytes.h"

enum { HEAD = 8, TAIL = 4, LINKTYPE_ETHERNET = 1, NANOSECONDS = 9 };

static uint8_t *put32(uint8_t *at, uint32_t value)
{
    ect_store_le32(at, value);
    return at + 4;
}

/* Pads to a multiple of four bytes, the alignment of all parts of a block. */
static uint8_t *put_bytes(uint8_t *at, const void *bytes, size_t length)
{
    size_t padded = (length + 3) / 4 * 4;
    memset(at, 0, padded);
    if (length > 0)
        memcpy(at, bytes, length);
    return at + padded;
}

static uint8_t *put_option(uint8_t *at, uint16_t code, const void *value, size_t length)
{
    ECT_ASSERT(length <= UINT16_MAX);
    ect_store_le16(at, code);
    ect_store_le16(at + 2, (uint16_t)length);
    return put_bytes(at + 4, value, length);
}

/* Truncates a long text between two characters of UTF-8. */
static size_t text_length(const char *text, size_t most)
{
    size_t length = strlen(text);
    if (length <= most)
        return length;
    length = most;
    while (length > 0 && ((unsigned char)text[length] & 0xC0) == 0x80)
        length--;
    return length;
}

static uint8_t *put_text(uint8_t *at, uint16_t code, const char *text, size_t most)
{
    return text && *text ? put_option(at, code, text, text_length(text, most)) : at;
}

static size_t end_block(uint8_t *block, uint32_t type, const uint8_t *at)
{
    uint32_t total = (uint32_t)(at - block) + TAIL;
    ect_store_le32(block, type);
    ect_store_le32(block + 4, total);
    ect_store_le32(block + total - TAIL, total);
    return total;
}

static size_t end_options(uint8_t *block, uint32_t type, uint8_t *at)
{
    return end_block(block, type, put_option(at, 0, NULL, 0));
}

size_t ect_pcapng_section(uint8_t *to, const char *application)
{
    uint8_t *at = put32(to + HEAD, ECT_PCAPNG_MAGIC);
    at = put32(at, 1);          /* version 1.0 */
    at = put32(at, UINT32_MAX); /* length of the section: unknown */
    at = put32(at, UINT32_MAX);
    if (!application)
        return end_block(to, ECT_PCAPNG_SECTION, at);
    at = put_text(at, ECT_PCAPNG_APPLICATION, application, ECT_PCAPNG_TEXT_MOST);
    return end_options(to, ECT_PCAPNG_SECTION, at);
}

size_t ect_pcapng_interface(uint8_t *to, const char *name)
{
    const uint8_t resolution = NANOSECONDS;
    uint8_t *at = put32(to + HEAD, LINKTYPE_ETHERNET);
    at = put32(at, 0); /* snapshot length: unlimited */
    at = put_text(at, ECT_PCAPNG_NAME, name, ECT_PCAPNG_TEXT_MOST);
    at = put_option(at, ECT_PCAPNG_RESOLUTION, &resolution, 1);
    return end_options(to, ECT_PCAPNG_INTERFACE, at);
}

size_t ect_pcapng_packet(uint8_t *to, const ect_pcapng_packet_t *packet)
{
    uint8_t number[8];
    ECT_ASSERT(packet->captured <= ECT_PCAPNG_FRAME_MOST && packet->captured <= packet->length);
    uint8_t *at = put32(to + HEAD, packet->interface);
    at = put32(at, (uint32_t)(packet->time_ns >> 32));
    at = put32(at, (uint32_t)packet->time_ns);
    at = put32(at, packet->captured);
    at = put32(at, packet->length);
    at = put_bytes(at, packet->frame, packet->captured);
    ect_store_le32(number, packet->direction);
    at = put_option(at, ECT_PCAPNG_FLAGS, number, 4);
    ect_store_le64(number, packet->dropped);
    if (packet->dropped > 0)
        at = put_option(at, ECT_PCAPNG_DROPPED, number, 8);
    at = put_text(at, ECT_PCAPNG_COMMENT, packet->comment, ECT_PCAPNG_COMMENT_MOST);
    return end_options(to, ECT_PCAPNG_PACKET, at);
}

size_t ect_pcapng_statistics(uint8_t *to, uint64_t time_ns, const char *comment)
{
    uint8_t *at = put32(to + HEAD, 0);
    at = put32(at, (uint32_t)(time_ns >> 32));
    at = put32(at, (uint32_t)time_ns);
    at = put_text(at, ECT_PCAPNG_COMMENT, comment, ECT_PCAPNG_COMMENT_MOST);
    return end_options(to, ECT_PCAPNG_STATISTICS, at);
}

size_t ect_pcapng_local(uint8_t *to, const void *data, size_t length)
{
    return end_block(to, ECT_PCAPNG_LOCAL, put_bytes(to + HEAD, data, length));
}
