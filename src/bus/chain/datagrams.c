/* SPDX-License-Identifier: MIT */
#include "bus/chain/datagrams.h"

#include "wire/bytes.h"

enum { AT_TYPE = 12, VLAN = 0x8100, ETHERCAT = 0x88A4, IPV4 = 0x0800, TAG = 4, IP_AND_UDP = 28 };
enum { COMMANDS = 1, LENGTH = 0x07FF, MORE = 0x8000, HEADER = 10, TRAILER = 2 };
enum { BRD = 7, LRD = 10, LWR = 11, LRW = 12, ARMW = 13, FRMW = 14 };

const char *ect_datagrams_name(uint8_t command)
{
    static const char *const names[] = {
        [BRD] = "BRD", [LRD] = "LRD", [LWR] = "LWR", [LRW] = "LRW", [ARMW] = "ARMW", [FRMW] = "FRMW"};
    return command < sizeof names / sizeof names[0] ? names[command] : NULL;
}

void ect_datagrams_want(ect_datagrams_t *d, uint64_t now_ns, uint64_t until_ns)
{
    if (now_ns >= d->until_ns)
        d->count = 0;
    d->until_ns = until_ns;
}

/* @return the place of a datagram; a new datagram may replace the least recent one */
static ect_datagram_t *find(ect_datagrams_t *d, uint8_t command, uint32_t address, uint16_t length)
{
    ect_datagram_t *place = &d->all[0];
    for (size_t i = 0; i < d->count; i++) {
        ect_datagram_t *one = &d->all[i];
        if (one->command == command && one->address == address && one->length == length)
            return one;
        place = one->seen_ns < place->seen_ns ? one : place;
    }
    if (d->count < ECT_DATAGRAMS)
        place = &d->all[d->count++];
    *place = (ect_datagram_t){.command = command, .address = address, .length = length};
    return place;
}

static void count(ect_datagram_t *datagram, uint16_t counter, uint64_t now_ns)
{
    datagram->replies++;
    datagram->lower += counter < datagram->highest;
    datagram->highest = counter > datagram->highest ? counter : datagram->highest;
    datagram->counter = counter;
    datagram->seen_ns = now_ns;
}

/* @return the offset of the first datagram; `length`: none */
static size_t first_datagram(const uint8_t *frame, size_t length)
{
    size_t at = AT_TYPE;
    if (length >= at + 2 && ect_load_be16(frame + at) == VLAN)
        at += TAG;
    if (length < at + 4)
        return length;
    const uint16_t type = ect_load_be16(frame + at);
    at += type == IPV4 ? 2u + IP_AND_UDP : 2u;
    const bool is_ours = type == ETHERCAT || type == IPV4;
    return is_ours && at + 2 <= length && ect_load_le16(frame + at) >> 12 == COMMANDS ? at + 2 : length;
}

void ect_datagrams_count(ect_datagrams_t *d, const uint8_t *frame, size_t length, uint64_t now_ns)
{
    bool more = now_ns < d->until_ns;
    for (size_t at = more ? first_datagram(frame, length) : length; more && at + HEADER + TRAILER <= length;) {
        const uint8_t *header = frame + at;
        const size_t bytes = ect_load_le16(header + 6) & LENGTH;
        more = (ect_load_le16(header + 6) & MORE) != 0;
        at += HEADER + bytes + TRAILER;
        if (at > length)
            return;
        /* each slave adds to the position of a broadcast and of ARMW */
        const uint32_t address =
            ect_load_le32(header + 2) & (header[0] == BRD || header[0] == ARMW ? 0xFFFF0000u : ~0u);
        if (ect_datagrams_name(header[0]))
            count(find(d, header[0], address, (uint16_t)bytes), ect_load_le16(frame + at - TRAILER), now_ns);
    }
}
