/* SPDX-License-Identifier: MIT */
#include "support/eoedev.h"

#include <string.h>

#include "wire/bytes.h"

enum { FRAGMENT, SET_IP = 2, SET_FILTER = 4, GET_IP = 6, GET_FILTER = 8, HEADER = 4, UNIT = 32, LAST = 1 };
enum { UNSUPPORTED = 0x0002, NO_FILTER = 0x0401, ARP = 42, LEAST = 60 };

/* Flags: MAC and IP; the octets of the IP are in reverse order. */
static const uint8_t parameters[] = {3, 0, 0, 0, 2, 0, 0, 0, 0, 7, 7, 2, 0, 192};
static const uint8_t mac[] = {2, 0, 0, 0, 0, 7}, ip[] = {192, 0, 2, 7};

static eoedev_t *device_of(const ect_slave_t *slave)
{
    return ect_mailbox_instance(slave);
}

static void answer(ect_slave_t *slave, uint8_t type, uint16_t result, const void *data, uint16_t length)
{
    uint8_t *mail = ect_mailbox_build(slave);
    mail[0] = type;
    mail[1] = LAST;
    ect_store_le16(mail + 2, result);
    memcpy(mail + HEADER, data, length);
    ect_mailbox_send(slave, ECT_MAILBOX_TYPE_EOE, (uint16_t)(HEADER + length));
}

/* Replies to an ARP request for its address, and ignores all other frames. */
static void take_frame(eoedev_t *d, ect_slave_t *slave)
{
    const uint8_t *in = d->in;
    if (d->in_length < ARP || ect_load_be16(in + 12) != 0x0806 || in[21] != 1 || memcmp(in + 38, ip, 4) != 0)
        return;
    memset(d->out, 0, LEAST);
    memcpy(d->out, in + 6, 6);
    memcpy(d->out + 6, mac, 6);
    memcpy(d->out + 12, in + 12, 10);
    d->out[21] = 2;
    memcpy(d->out + 22, mac, 6);
    memcpy(d->out + 28, ip, 4);
    memcpy(d->out + 32, in + 22, 10);
    d->out_length = LEAST;
    d->out_sent = 0;
    d->out_number++;
    ect_mailbox_wake(slave);
}

/* Whether a fragment continues where the previous one has ended. */
static bool fits(const eoedev_t *d, uint16_t word)
{
    return d->coming && (word & 0x3F) == d->fragment && word >> 12 == d->number &&
           (word >> 6 & 0x3F) * UNIT == d->in_length;
}

static void take_fragment(eoedev_t *d, ect_slave_t *slave, const uint8_t *data, uint16_t length, bool careless)
{
    const uint16_t word = ect_load_le16(data + 2);
    if ((word & 0x3F) == 0) {
        d->coming = true;
        d->fragment = 0;
        d->in_length = 0;
        d->number = (uint8_t)(word >> 12);
    } else if (!careless && !fits(d, word)) {
        d->coming = false;
    }
    length = (uint16_t)(length - HEADER);
    if (!d->coming || d->in_length + length > EOEDEV_FRAME) {
        d->coming = false;
        return;
    }
    memcpy(d->in + d->in_length, data + HEADER, length);
    d->in_length = (uint16_t)(d->in_length + length);
    d->fragment++;
    if ((data[1] & LAST) == 0)
        return;
    d->coming = careless;
    take_frame(d, slave);
}

static uint16_t request_as(ect_slave_t *slave, const uint8_t *data, uint16_t length, bool careless)
{
    if (length < HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    uint8_t type = data[0] & 0x0F;
    if (type == FRAGMENT)
        take_fragment(device_of(slave), slave, data, length, careless);
    else if (type == GET_IP)
        answer(slave, GET_IP + 1, 0, parameters, sizeof parameters);
    else if (type == SET_IP)
        answer(slave, SET_IP + 1, 0, "", 0);
    else
        answer(slave, (uint8_t)(type + 1), type == GET_FILTER || type == SET_FILTER ? NO_FILTER : UNSUPPORTED, "", 0);
    return ECT_MAILBOX_OK;
}

static uint16_t request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    (void)self;
    return request_as(slave, data, length, false);
}

static uint16_t careless_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    (void)self;
    return request_as(slave, data, length, true);
}

/* In fragments of one unit, so that there are two. */
static bool next(const ect_protocol_t *self, ect_slave_t *slave, bool send)
{
    eoedev_t *d = device_of(slave);
    (void)self;
    if (d->out_sent == d->out_length)
        return false;
    if (!send)
        return true;
    const uint16_t left = (uint16_t)(d->out_length - d->out_sent), size = left < UNIT ? left : UNIT;
    const unsigned int fragment = d->out_sent / UNIT,
                       units = fragment == 0 ? (d->out_length + UNIT - 1u) / UNIT : fragment;
    uint8_t *mail = ect_mailbox_build(slave);
    mail[1] = size == left ? LAST : 0;
    ect_store_le16(mail + 2, (uint16_t)(fragment | units << 6 | (d->out_number & 0xFu) << 12));
    memcpy(mail + HEADER, d->out + d->out_sent, size);
    d->out_sent = (uint16_t)(d->out_sent + size);
    ect_mailbox_send(slave, ECT_MAILBOX_TYPE_EOE, (uint16_t)(HEADER + size));
    return true;
}

static void reset(const ect_protocol_t *self, ect_slave_t *slave)
{
    eoedev_t *d = device_of(slave);
    (void)self;
    d->coming = false;
    d->out_sent = d->out_length = 0;
}

const ect_device_t *eoedev(bool careless)
{
    static const ect_protocol_t entries[2] = {{.type = ECT_MAILBOX_TYPE_EOE,
                                               .states = ECT_IN_PREOP_AND_ABOVE,
                                               .request = request,
                                               .next = next,
                                               .reset = reset},
                                              {.type = ECT_MAILBOX_TYPE_EOE,
                                               .states = ECT_IN_PREOP_AND_ABOVE,
                                               .request = careless_request,
                                               .next = next,
                                               .reset = reset}};
    static const ect_protocol_t *protocols[2][TESTDEV_PROTOCOLS];
    static ect_device_t devices[2];
    ect_device_t *device = &devices[careless];
    *device = testdev_with(&entries[careless], protocols[careless], ECT_MAILBOX_EOE, sizeof(eoedev_t));
    device->name = careless ? "careless" : "network";
    return device;
}
