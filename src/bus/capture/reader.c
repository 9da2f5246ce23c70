/* SPDX-License-Identifier: MIT */
#include "bus/capture/reader.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "bus/capture/pcapng.h"
#include "wire/bytes.h"

enum { SIMPLE_PACKET = 3, LINKTYPE_ETHERNET = 1, TSRESOL_BINARY = 0x80, MICROSECONDS = 6 };
enum { BLOCK_HEAD = 8, PCAP_HEAD = 24, PCAP_PACKET = 16 };

#define PCAP_MICROSECONDS 0xA1B2C3D4u
#define PCAP_NANOSECONDS  0xA1B23C4Du
#define NS_PER_S          1000000000ull

static uint16_t get16(const ect_reader_t *r, const uint8_t *at)
{
    return r->swapped ? ect_load_be16(at) : ect_load_le16(at);
}

static uint32_t get32(const ect_reader_t *r, const uint8_t *at)
{
    uint32_t value = ect_load_le32(at);
    return r->swapped ? value >> 24 | (value >> 8 & 0xFF00) | (value << 8 & 0xFF0000) | value << 24 : value;
}

__attribute__((format(printf, 2, 3))) static ect_item_kind_t wrong(ect_reader_t *r, const char *format, ...)
{
    char text[ECT_READER_MESSAGE - 64];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text, sizeof text, format, values);
    va_end(values);
    snprintf(r->message, sizeof r->message, "%s, at byte %" PRIu64, text, r->at);
    r->state = ECT_READER_OVER;
    return ECT_ITEM_WRONG;
}

static bool take(const ect_reader_t *r, void *to, size_t length)
{
    return fread(to, 1, length, r->file) == length;
}

/* --- pcapng ------------------------------------------------------------------------------------------------------- */

/* Finds an option in `length` bytes. @return the value, *size bytes; NULL: none */
static const uint8_t *find_option(const ect_reader_t *r, const uint8_t *at, size_t length, uint16_t code, size_t *size)
{
    while (length >= 4) {
        const size_t its = get16(r, at + 2);
        const size_t padded = 4 + (its + 3) / 4 * 4;
        if (get16(r, at) == 0 || its > length - 4)
            return NULL;
        if (get16(r, at) == code) {
            *size = its;
            return at + 4;
        }
        at += padded; /* within them: a block has a multiple of four bytes */
        length -= padded;
    }
    return NULL;
}

/* @return false: times of this resolution do not fit 64 bits in nanoseconds */
static bool take_interface(ect_reader_t *r, const uint8_t *body, size_t length)
{
    enum { FINEST = 18, FINEST_BINARY = 60 };
    size_t size = 0;
    ect_reader_interface_t i = {.ethernet = get16(r, body) == LINKTYPE_ETHERNET, .exponent = MICROSECONDS};
    const uint8_t *resolution = find_option(r, body + 8, length - 8, ECT_PCAPNG_RESOLUTION, &size);
    if (resolution && size == 1) {
        i.binary = (*resolution & TSRESOL_BINARY) != 0;
        i.exponent = *resolution & 0x7F;
    }
    r->interfaces[r->interface_count++] = i;
    return i.exponent <= (i.binary ? FINEST_BINARY : FINEST);
}

static uint64_t power_of_ten(unsigned int exponent)
{
    uint64_t power = 1;
    while (exponent-- > 0)
        power *= 10;
    return power;
}

/* Fractions of a nanosecond are truncated; values beyond 64 bits wrap. */
static uint64_t nanoseconds(const ect_reader_interface_t *i, uint64_t time)
{
    if (i->binary) {
        uint64_t fraction = time & (((uint64_t)1 << i->exponent) - 1);
        unsigned int shift = i->exponent > 34 ? i->exponent - 34u : 0;
        return (time >> i->exponent) * NS_PER_S + ((fraction >> shift) * NS_PER_S >> (i->exponent - shift));
    }
    if (i->exponent >= 9)
        return time / power_of_ten(i->exponent - 9u);
    return time * power_of_ten(9u - i->exponent);
}

static ect_item_kind_t take_packet(ect_reader_t *r, const uint8_t *body, size_t length, ect_item_t *item)
{
    enum { HEAD = 20 };
    if (length < HEAD)
        return wrong(r, "a packet of %zu bytes", length);
    size_t size = 0;
    *item = (ect_item_t){.kind = ECT_ITEM_PACKET, .number = ++r->packets, .interface = get32(r, body)};
    item->captured = get32(r, body + 12);
    item->length = get32(r, body + 16);
    item->bytes = body + HEAD;
    if (item->interface >= r->interface_count)
        return wrong(r, "a packet of interface %u, which the file does not describe", item->interface);
    if (item->captured > length - HEAD || item->captured > item->length)
        return wrong(r, "a packet of %zu bytes in a block with %zu", item->captured, length - HEAD);
    if (!r->interfaces[item->interface].ethernet)
        return wrong(r, "a packet that is not of Ethernet");
    item->time_ns =
        nanoseconds(&r->interfaces[item->interface], (uint64_t)get32(r, body + 4) << 32 | get32(r, body + 8));
    size_t used = HEAD + (item->captured + 3) / 4 * 4;
    const uint8_t *flags = used < length ? find_option(r, body + used, length - used, ECT_PCAPNG_FLAGS, &size) : NULL;
    item->direction = flags && size == 4 ? get32(r, flags) & 3u : 0;
    return ECT_ITEM_PACKET;
}

static ect_item_kind_t take_section(ect_reader_t *r, size_t length)
{
    if (length < 16)
        return wrong(r, "a section header of %zu bytes", length);
    r->interface_count = 0;
    return ECT_ITEM_SECTION;
}

/* @return ECT_ITEM_END: the block is skipped */
static ect_item_kind_t take_block(ect_reader_t *r, uint32_t type, const uint8_t *body, size_t length, ect_item_t *item)
{
    switch (type) {
    case ECT_PCAPNG_SECTION:
        return take_section(r, length);
    case ECT_PCAPNG_INTERFACE:
        if (length < 8 || r->interface_count == ECT_READER_INTERFACES)
            return wrong(r,
                         length < 8 ? "an interface of %zu bytes" : "more interfaces than are read, in a block of %zu",
                         length);
        return take_interface(r, body, length) ? ECT_ITEM_END : wrong(r, "times that are too fine");
    case ECT_PCAPNG_PACKET:
        return take_packet(r, body, length, item);
    case SIMPLE_PACKET:
        return wrong(r, "a packet without a time");
    case ECT_PCAPNG_LOCAL:
        *item = (ect_item_t){.kind = ECT_ITEM_LOCAL, .bytes = body, .captured = length};
        return ECT_ITEM_LOCAL;
    default:
        return ECT_ITEM_END;
    }
}

/* Reads the byte order from the section header. @param head  type and length of the block @return the mistake; NULL:
 * none */
static const char *find_byte_order(ect_reader_t *r, const uint8_t *head)
{
    uint8_t magic[4];
    if (ect_load_le32(head) != ECT_PCAPNG_SECTION)
        return NULL;
    if (!take(r, magic, sizeof magic) || fseek(r->file, -4, SEEK_CUR) != 0)
        return "the file ends within a block";
    r->swapped = ect_load_le32(magic) != ECT_PCAPNG_MAGIC;
    return get32(r, magic) == ECT_PCAPNG_MAGIC ? NULL : "a section of an unknown byte order";
}

static ect_item_kind_t next_of_pcapng(ect_reader_t *r, ect_item_t *item)
{
    for (;;) {
        uint8_t head[BLOCK_HEAD];
        size_t got = fread(head, 1, sizeof head, r->file);
        if (got == 0)
            return ECT_ITEM_END;
        const char *mistake = got < sizeof head ? "the file ends within a block" : find_byte_order(r, head);
        if (mistake != NULL)
            return wrong(r, "%s", mistake);
        uint32_t total = get32(r, head + 4);
        if (total < 12 || total % 4 != 0 || total - BLOCK_HEAD > ECT_READER_BLOCK)
            return wrong(r, "a block of %" PRIu32 " bytes", total);
        if (!take(r, r->block, total - BLOCK_HEAD))
            return wrong(r, "the file ends within a block");
        if (get32(r, r->block + total - 12) != total)
            return wrong(r, "a block with two different lengths");
        ect_item_kind_t kind = take_block(r, get32(r, head), r->block, total - 12, item);
        r->at += total;
        if (kind != ECT_ITEM_END)
            return kind;
    }
}

/* --- pcap --------------------------------------------------------------------------------------------------------- */

static ect_item_kind_t next_of_pcap(ect_reader_t *r, ect_item_t *item)
{
    uint8_t head[PCAP_PACKET];
    size_t got = fread(head, 1, sizeof head, r->file);
    if (got == 0)
        return ECT_ITEM_END;
    if (got < sizeof head)
        return wrong(r, "the file ends within a packet");
    uint32_t captured = get32(r, head + 8);
    if (captured > ECT_READER_BLOCK || captured > get32(r, head + 12))
        return wrong(r, "a packet of %" PRIu32 " bytes", captured);
    if (!take(r, r->block, captured))
        return wrong(r, "the file ends within a packet");
    *item =
        (ect_item_t){.kind = ECT_ITEM_PACKET,
                     .number = ++r->packets,
                     .time_ns = get32(r, head) * NS_PER_S + (uint64_t)get32(r, head + 4) * (r->nanoseconds ? 1 : 1000),
                     .bytes = r->block,
                     .captured = captured,
                     .length = get32(r, head + 12)};
    r->at += PCAP_PACKET + (uint64_t)captured;
    return ECT_ITEM_PACKET;
}

static bool is_pcap(ect_reader_t *r, const uint8_t *magic)
{
    for (int swapped = 0; swapped < 2; swapped++) {
        r->swapped = swapped != 0;
        r->nanoseconds = get32(r, magic) == PCAP_NANOSECONDS;
        if (r->nanoseconds || get32(r, magic) == PCAP_MICROSECONDS)
            return true;
    }
    return false;
}

static ect_item_kind_t begin_pcap(ect_reader_t *r)
{
    uint8_t rest[PCAP_HEAD - 4];
    if (!take(r, rest, sizeof rest))
        return wrong(r, "the file ends within its header");
    if ((get32(r, rest + 16) & 0x0FFFFFFFu) != LINKTYPE_ETHERNET)
        return wrong(r, "packets that are not of Ethernet");
    r->at = PCAP_HEAD;
    r->state = ECT_READER_PCAP;
    return ECT_ITEM_SECTION;
}

static ect_item_kind_t begin(ect_reader_t *r, ect_item_t *item)
{
    uint8_t magic[4];
    r->block = malloc(ECT_READER_BLOCK);
    if (!r->block)
        return wrong(r, "not enough memory");
    if (!take(r, magic, sizeof magic))
        return wrong(r, "no capture: the file is too short");
    if (is_pcap(r, magic))
        return begin_pcap(r);
    if (ect_load_le32(magic) != ECT_PCAPNG_SECTION || fseek(r->file, -4, SEEK_CUR) != 0)
        return wrong(r, "no capture: neither pcapng nor pcap");
    r->state = ECT_READER_PCAPNG;
    return next_of_pcapng(r, item);
}

ect_item_kind_t ect_reader_next(ect_reader_t *r, ect_item_t *item)
{
    *item = (ect_item_t){.kind = ECT_ITEM_END};
    switch (r->state) {
    case ECT_READER_NEW:
        item->kind = begin(r, item);
        break;
    case ECT_READER_PCAPNG:
        item->kind = next_of_pcapng(r, item);
        break;
    case ECT_READER_PCAP:
        item->kind = next_of_pcap(r, item);
        break;
    default:
        break;
    }
    if (item->kind == ECT_ITEM_END)
        r->state = ECT_READER_OVER;
    return item->kind;
}

void ect_reader_free(ect_reader_t *r)
{
    free(r->block);
    r->block = NULL;
}
