/* SPDX-License-Identifier: MIT */
/* Differences of two frames, and the slaves that a datagram addresses. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "esc/route.h"
#include "replay_file.h"
#include "wire/bytes.h"

size_t replay_datagram(const uint8_t *frame, size_t length, size_t at)
{
    enum { HEADER = ECT_DATAGRAM_DATA };
    if (at > length || length - at < HEADER)
        return 0;
    size_t size = ect_datagram_size(frame + at);
    return size <= length - at ? size : 0;
}

static size_t count_datagrams(const uint8_t *frame, size_t length)
{
    size_t count = 0, size;
    for (size_t at = REPLAY_HEADS; (size = replay_datagram(frame, length, at)) > 0; at += size) {
        count++;
        if (!ect_datagram_follows(frame + at))
            break;
    }
    return count;
}

replay_difference_t replay_compare(const uint8_t *expected, size_t expected_length, const uint8_t *got,
                                   size_t got_length)
{
    const size_t least = expected_length < got_length ? expected_length : got_length;
    const replay_difference_t outside = {0};
    size_t number = 0, size;
    if (least < REPLAY_HEADS || memcmp(expected, got, REPLAY_HEADS) != 0)
        return outside;
    for (size_t at = REPLAY_HEADS; (size = replay_datagram(expected, least, at)) > 0; at += size) {
        number++;
        if (memcmp(expected + at, got + at, size) != 0)
            return (replay_difference_t){.number = number,
                                         .count = count_datagrams(expected, expected_length),
                                         .at = at,
                                         .length = ect_datagram_length(expected + at)};
        if (!ect_datagram_follows(expected + at))
            break;
    }
    return outside;
}

bool replay_is_logical(const uint8_t *d)
{
    return d[0] >= ECT_LRD && d[0] <= ECT_LRW;
}

static bool maps(const ect_esc_route_t *route, const uint8_t *d)
{
    const uint64_t first = ect_load_le32(d + ECT_DATAGRAM_ADP), length = ect_datagram_length(d);
    for (unsigned int i = 0; i < route->window_count; i++) {
        const ect_esc_window_t *w = &route->windows[i];
        if (first < (uint64_t)w->first + w->length && w->first < first + length)
            return true;
    }
    return false;
}

static bool reaches(ect_chain_t *chain, size_t position, const uint8_t *d)
{
    const uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADP);
    ect_esc_route_t route;
    ect_esc_route(ect_chain_esc(chain, position), &route);
    switch (d[0]) {
    case ECT_APRD:
    case ECT_APWR:
    case ECT_APRW:
    case ECT_ARMW:
        return (uint16_t)(0u - address) == position;
    case ECT_FPRD:
    case ECT_FPWR:
    case ECT_FPRW:
    case ECT_FRMW:
        return route.station == address || route.alias == address;
    default:
        return replay_is_logical(d) && maps(&route, d);
    }
}

size_t replay_slave(ect_chain_t *chain, const uint8_t *datagram)
{
    size_t i = 0;
    while (i < ect_chain_count(chain) && !reaches(chain, i, datagram))
        i++;
    return i;
}

static bool is_broadcast(const uint8_t *d)
{
    return d[0] >= ECT_BRD && d[0] <= ECT_BRW;
}

__attribute__((format(printf, 3, 4))) static void add(char *text, size_t room, const char *format, ...)
{
    size_t used = strlen(text);
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text + used, room - used, format, values);
    va_end(values);
}

void replay_slaves(ect_chain_t *chain, const uint8_t *datagram, char *text, size_t room)
{
    enum { NAMED = 8 };
    size_t found = 0;
    snprintf(text, room, "%s", is_broadcast(datagram) ? "all slaves" : "");
    for (size_t i = 0; i < ect_chain_count(chain) && !is_broadcast(datagram) && found < NAMED; i++) {
        if (reaches(chain, i, datagram))
            add(text, room, "%s%zu", found++ == 0 ? "slave " : ", ", i + 1);
    }
    if (*text == 0)
        snprintf(text, room, "no slave");
    else if (replay_is_logical(datagram))
        add(text, room, " by FMMU");
}
