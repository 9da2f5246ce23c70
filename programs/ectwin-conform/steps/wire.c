/* SPDX-License-Identifier: MIT */
/* Datagrams as steps of a case. */
#define _GNU_SOURCE
#include <string.h>
#include <time.h>

#include "steps/engine.h"

/* A frame returns in microseconds, but a machine under load may delay this process, and an emulated slave even more. */
enum { REPLY_MS = 500, EMULATED_MS = 5000, SILENT_MS = 50 };

static int reply_ms(const cf_t *c)
{
    return c->emulated ? EMULATED_MS : REPLY_MS;
}

void cf_exchange(cf_t *c, cf_datagram_t *d, size_t count)
{
    cf_check_time(c);
    int ms = c->engine->silent ? SILENT_MS : reply_ms(c);
    c->engine->silent = !cf_port_exchange(c->engine->port, d, count, (uint32_t)ms);
    cf_check_time(c); /* Ctrl-C may be the cause */
    if (c->engine->silent)
        cf_fail(c, "no reply: the frame did not return within %d ms", ms);
}

size_t cf_raw_frame(cf_t *c, const void *frame, size_t length, uint8_t *reply)
{
    cf_check_time(c);
    ssize_t replied = cf_port_raw(c->engine->port, frame, length, reply, CF_MAX_FRAME, (uint32_t)reply_ms(c));
    cf_check_time(c);
    if (replied < 0) {
        c->engine->silent = true;
        cf_fail(c, "no reply: a plain datagram after the frame did not return within %d ms", reply_ms(c));
    }
    return (size_t)replied;
}

/* Three tries: SOEM waits 2 ms for a frame, too short for a machine under load. */
bool cf_soem_to_op(cf_t *c, char *what, size_t room)
{
    for (int tries = 0; tries < 3; tries++) {
        cf_check_time(c);
        if (cf_port_soem_to_op(c->engine->port, (uint16_t)(c->facts.position + 1), what, room))
            return true;
    }
    cf_check_time(c);
    return false;
}

bool cf_soem_address(cf_t *c, const uint8_t set[4], uint8_t got[4], char *what, size_t room)
{
    for (int tries = 0; tries < 3; tries++) {
        cf_check_time(c);
        if (cf_port_soem_address(c->engine->port, (uint16_t)(c->facts.position + 1), set, got, what, room))
            return true;
    }
    cf_check_time(c);
    return false;
}

/* --- shorthands --------------------------------------------------------------------------------------------------- */

uint16_t cf_logical(cf_t *c, uint8_t command, uint32_t address, void *data, uint16_t length)
{
    cf_datagram_t d = {.command = command, .address = address, .length = length, .data = data};
    cf_exchange(c, &d, 1);
    return d.wkc;
}

uint16_t cf_command(cf_t *c, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length)
{
    return cf_logical(c, command, CF_AT(adp, ado), data, length);
}

uint16_t cf_read(cf_t *c, uint16_t address, void *data, size_t length)
{
    memset(data, 0, length);
    return cf_command(c, CF_FPRD, c->facts.station, address, data, (uint16_t)length);
}

uint16_t cf_write(cf_t *c, uint16_t address, const void *data, size_t length)
{
    uint8_t copy[CF_MAX_DATA];
    memcpy(copy, data, length);
    return cf_command(c, CF_FPWR, c->facts.station, address, copy, (uint16_t)length);
}

void cf_get(cf_t *c, uint16_t address, void *data, size_t length)
{
    uint16_t wkc = cf_read(c, address, data, length);
    if (wkc != 1)
        cf_fail(c, "reading %zu bytes at 0x%04X: WKC expected 1, got %u", length, address, wkc);
}

void cf_put(cf_t *c, uint16_t address, const void *data, size_t length)
{
    uint16_t wkc = cf_write(c, address, data, length);
    if (wkc != 1)
        cf_fail(c, "writing %zu bytes at 0x%04X: WKC expected 1, got %u", length, address, wkc);
}

uint8_t cf_get8(cf_t *c, uint16_t address)
{
    uint8_t value;
    cf_get(c, address, &value, 1);
    return value;
}

uint16_t cf_get16(cf_t *c, uint16_t address)
{
    uint8_t bytes[2];
    cf_get(c, address, bytes, sizeof bytes);
    return ect_load_le16(bytes);
}

uint32_t cf_get32(cf_t *c, uint16_t address)
{
    uint8_t bytes[4];
    cf_get(c, address, bytes, sizeof bytes);
    return ect_load_le32(bytes);
}

uint64_t cf_get64(cf_t *c, uint16_t address)
{
    uint8_t bytes[8];
    cf_get(c, address, bytes, sizeof bytes);
    return ect_load_le64(bytes);
}

void cf_put8(cf_t *c, uint16_t address, uint8_t value)
{
    cf_put(c, address, &value, 1);
}

void cf_put16(cf_t *c, uint16_t address, uint16_t value)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, value);
    cf_put(c, address, bytes, sizeof bytes);
}

void cf_put32(cf_t *c, uint16_t address, uint32_t value)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    cf_put(c, address, bytes, sizeof bytes);
}

void cf_put64(cf_t *c, uint16_t address, uint64_t value)
{
    uint8_t bytes[8];
    ect_store_le64(bytes, value);
    cf_put(c, address, bytes, sizeof bytes);
}

void cf_sleep_ms(cf_t *c, uint32_t ms)
{
    uint64_t until = cf_now_ns() + ms * UINT64_C(1000000);
    do {
        cf_check_time(c);
        uint64_t now = cf_now_ns();
        uint64_t left = until > now ? until - now : 0;
        const struct timespec pause = {.tv_nsec = (long)(left < 10000000 ? left : 10000000)};
        (void)nanosleep(&pause, NULL);
    } while (cf_now_ns() < until);
}

bool cf_wait_bits(cf_t *c, uint16_t address, uint8_t mask, uint8_t wanted, uint32_t ms, uint8_t *last)
{
    uint64_t until = cf_now_ns() + ms * UINT64_C(1000000);
    uint8_t value;
    for (;;) {
        bool over = cf_now_ns() >= until; /* read before the poll, so that a delayed process polls once more */
        value = cf_get8(c, address);
        if ((value & mask) == wanted || over)
            break;
        cf_poll_pause(c);
    }
    if (last)
        *last = value;
    return (value & mask) == wanted;
}
