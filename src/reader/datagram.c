/* SPDX-License-Identifier: MIT */
/* One datagram for each frame: the slave limits the speed of the reader, not the wire. */
#include <string.h>

#include "reader/internal.h"
#include "wire/assert.h"
#include "wire/bytes.h"

enum { ETHERNET = 14, FRAME_HEADER = 2, DATAGRAM = 10, WKC = 2, SHORTEST = 60 };
enum { AT_TYPE = 12, AT_DATAGRAM = ETHERNET + FRAME_HEADER, AT_DATA = AT_DATAGRAM + DATAGRAM };
enum { ETHERTYPE = 0x88A4, COMMANDS = 0x1000, TYPES = 0xF000, LENGTH = 0x07FF, FRAMES_SKIPPED = 1000 };

uint16_t reader_load16(const uint8_t *bytes)
{
    return ect_load_le16(bytes);
}

/* Command and address: by position, or by the configured station address. */
static void put_slave(const ect_reader_t *r, uint8_t *d, uint8_t command)
{
    const bool configured = command != BRD && r->config.station != 0;
    const uint16_t position = command == BRD ? 0 : (uint16_t)(0u - r->config.position);
    d[0] = !configured ? command : command == APRD ? FPRD : FPWR;
    ect_store_le16(d + 2, configured ? r->config.station : position);
}

static size_t build(ect_reader_t *r, uint8_t command, uint16_t address, const uint8_t *data, uint16_t length)
{
    static const uint8_t header[AT_TYPE] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0x00, 0x00, 0x00, 0x00, 0x01};
    const size_t used = AT_DATA + (size_t)length + WKC;
    uint8_t *d = r->frame + AT_DATAGRAM;
    memset(r->frame, 0, used < SHORTEST ? SHORTEST : used);
    memcpy(r->frame, header, sizeof header);
    ect_store_be16(r->frame + AT_TYPE, ETHERTYPE);
    ect_store_le16(r->frame + ETHERNET, (uint16_t)(COMMANDS | (DATAGRAM + length + WKC)));
    put_slave(r, d, command);
    d[1] = r->index;
    ect_store_le16(d + 4, address);
    ect_store_le16(d + 6, length);
    memcpy(d + DATAGRAM, data, length);
    return used < SHORTEST ? SHORTEST : used;
}

/* @return whether a frame is the reply: slaves change only the address, the data and the working counter */
static bool is_reply(const ect_reader_t *r, size_t length)
{
    const uint8_t *sent = r->frame + AT_DATAGRAM, *d = r->reply + AT_DATAGRAM;
    const uint16_t bytes = ect_load_le16(sent + 6);
    return length >= AT_DATA + (size_t)bytes + WKC && length <= sizeof r->reply &&
           ect_load_be16(r->reply + AT_TYPE) == ETHERTYPE && d[0] == sent[0] && d[1] == sent[1] &&
           memcmp(d + 4, sent + 4, 2) == 0 && (ect_load_le16(d + 6) & LENGTH) == bytes;
}

/* All tries of a request have the same index: on a busy machine, the late reply to an earlier try is the reply. */
static bool try_once(ect_reader_t *r, uint8_t command, uint16_t address, uint8_t *data, uint16_t length, uint16_t *wkc)
{
    ECT_ASSERT(length <= ECT_READER_MAIL);
    const uint64_t until = reader_now(r) + r->config.frame_ms * NS_PER_MS;
    r->link->send(r->link->ctx, r->frame, build(r, command, address, data, length));
    for (unsigned int frames = 0; frames < FRAMES_SKIPPED; frames++) {
        const size_t got = r->link->receive(r->link->ctx, r->reply, sizeof r->reply, until);
        if (got == 0)
            return false;
        if (!is_reply(r, got))
            continue; /* a reply to an earlier request, or a frame of another master */
        memcpy(data, r->reply + AT_DATA, length);
        *wkc = ect_load_le16(r->reply + AT_DATA + length);
        return true;
    }
    return false;
}

bool reader_ask(ect_reader_t *r, uint8_t command, uint16_t address, uint8_t *data, uint16_t length, uint16_t *wkc)
{
    bool came = false;
    r->index++;
    for (unsigned int tries = 0; tries < r->config.tries && !came && !reader_is_over(r); tries++)
        came = try_once(r, command, address, data, length, wkc);
    return came;
}

bool ect_reader_hears_master(const ect_reader_link_t *link, uint32_t ms)
{
    uint8_t frame[ECT_READER_FRAME];
    const uint64_t until = link->now(link->ctx) + ms * NS_PER_MS;
    for (size_t got = 1; got > 0 && link->now(link->ctx) < until;) {
        got = link->receive(link->ctx, frame, sizeof frame, until);
        if (got >= AT_DATA + WKC && ect_load_be16(frame + AT_TYPE) == ETHERTYPE &&
            (ect_load_le16(frame + ETHERNET) & TYPES) == COMMANDS)
            return true;
    }
    return false;
}

static ect_reader_result_t repeat(ect_reader_t *r, uint8_t command, uint16_t address, uint8_t *data, uint16_t length)
{
    uint16_t wkc = 0;
    bool came = false;
    r->index++;
    for (unsigned int tries = 0; tries < r->config.tries; tries++) {
        if (reader_is_over(r))
            return ECT_READER_STOPPED;
        came = try_once(r, command, address, data, length, &wkc);
        if (came && wkc == 1)
            return reader_good(r);
    }
    return reader_report(r, ECT_READER_LOST,
                         came ? "the slave does not process frames any more (0x%04X)" : "no frame returns (0x%04X)",
                         address);
}

ect_reader_result_t reader_get(ect_reader_t *r, uint16_t address, uint8_t *data, uint16_t length)
{
    memset(data, 0, length);
    return repeat(r, APRD, address, data, length);
}

ect_reader_result_t ect_reader_registers(ect_reader_t *r, uint16_t address, void *data, uint16_t length)
{
    ECT_ASSERT(length > 0 && length <= ECT_READER_MAIL);
    return reader_get(r, address, data, length);
}

ect_reader_result_t reader_put(ect_reader_t *r, uint16_t address, const uint8_t *data, uint16_t length)
{
    uint8_t copy[16];
    ECT_ASSERT(length <= sizeof copy);
    memcpy(copy, data, length);
    return repeat(r, APWR, address, copy, length);
}
