/* SPDX-License-Identifier: MIT */
/* Ethernet over EtherCAT (ETG.1000.6 §5.7): one frame at a time in each direction, one fragment at a time. */
#include "seams/eoe.h"

#include <string.h>

#include "slave/internal.h"

enum {
    FRAGMENT = 0,
    TIME_STAMP = 1,
    SET_IP = 2,
    SET_IP_DONE = 3,
    SET_FILTER = 4,
    SET_FILTER_DONE = 5,
    GET_IP = 6,
    GET_IP_DONE = 7,
    GET_FILTER = 8,
    GET_FILTER_DONE = 9,
};
enum { HEADER = 4, UNIT = 32, LAST = 0x01, STAMPED = 0x02, SIX_BITS = 0x3F };
enum { FLAGS = 4, FULL_LAYOUT = 62, MAC = 6, ADDRESS = 4, TAG = 4 };

static const ect_eoe_t *entry_of(const ect_protocol_t *self)
{
    return (const ect_eoe_t *)(const void *)self;
}

static ect_eoe_state_t *state_of(const ect_eoe_t *eoe, const ect_slave_t *s)
{
    return (ect_eoe_state_t *)(void *)((uint8_t *)s->config.instance + eoe->offset);
}

static bool has_port(const ect_eoe_t *eoe, unsigned int port)
{
    return port <= (eoe->ports > 1 ? eoe->ports : 1u);
}

static bool is_good_length(const uint8_t *frame, unsigned int length)
{
    if (length < ECT_EOE_FRAME_LEAST || length > ECT_EOE_FRAME)
        return false;
    return length <= ECT_EOE_FRAME - TAG || ect_load_be16(frame + 12) == 0x8100;
}

/* --- a frame of the master ---------------------------------------------------------------------------------------- */

static void drop(ect_eoe_state_t *e)
{
    e->in_open = false;
    e->dropped++;
}

static void deliver(const ect_eoe_t *eoe, ect_slave_t *s, uint8_t port, unsigned int length)
{
    ect_eoe_state_t *e = state_of(eoe, s);
    e->in_open = false;
    if (!is_good_length(e->in, length) || !has_port(eoe, port) ||
        !eoe->received(eoe, s->config.instance, port, e->in, (uint16_t)length))
        e->dropped++;
    else
        e->received++;
    ect_mailbox_wake(s); /* the device may have a reply */
}

/* Whether a fragment continues the frame; fragment 0 opens one. */
static bool continues(ect_eoe_state_t *e, unsigned int word)
{
    unsigned int fragment = word & SIX_BITS;
    unsigned int units = word >> 6 & SIX_BITS;
    unsigned int number = word >> 12;
    if (fragment == 0) {
        e->dropped += e->in_open;
        e->in_open = true;
        e->in_length = 0;
        e->in_limit = (uint16_t)(units * UNIT);
        e->in_fragment = 0;
        e->in_number = (uint8_t)number;
        return true;
    }
    return fragment == e->in_fragment && number == e->in_number && units * UNIT == e->in_length;
}

static void take_fragment(const ect_eoe_t *eoe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    ect_eoe_state_t *e = state_of(eoe, s);
    unsigned int word = ect_load_le16(data + 2);
    bool last = (data[1] & LAST) != 0;
    unsigned int stamp = last && (data[1] & STAMPED) != 0 ? ECT_EOE_STAMP : 0;
    unsigned int bytes = length - HEADER;
    if (!e->in_open && (word & SIX_BITS) != 0)
        return; /* the rest of a frame that was dropped */
    unsigned int limit = sizeof e->in;
    bool good = continues(e, word);
    limit = e->in_limit < limit ? e->in_limit : limit;
    if (!good || bytes > limit - e->in_length || bytes < stamp || (!last && (bytes == 0 || bytes % UNIT != 0))) {
        drop(e);
        return;
    }
    ECT_ASSERT(e->in_open && e->in_length + bytes <= sizeof e->in);
    memcpy(e->in + e->in_length, data + HEADER, bytes);
    e->in_length = (uint16_t)(e->in_length + bytes);
    e->in_fragment++;
    if (last)
        deliver(eoe, s, data[0] >> 4, e->in_length - stamp);
}

/* --- the address -------------------------------------------------------------------------------------------------- */

static void reply(ect_slave_t *s, const uint8_t *request, uint8_t type, uint16_t result)
{
    uint8_t *mail = ect_mailbox_build(s);
    mail[0] = (uint8_t)(type | (request[0] & 0xF0));
    mail[1] = LAST;
    ect_store_le16(mail + 2, result);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_EOE, HEADER);
}

/* The fields of an address in the order of the mail and of their flags. */
typedef struct field {
    uint8_t offset; /* in ect_eoe_address_t */
    uint8_t size;
    bool reversed; /* the last octet of an IP address comes first */
} field_t;

static const field_t fields[] = {
    {offsetof(ect_eoe_address_t, mac), MAC, false},       {offsetof(ect_eoe_address_t, ip), ADDRESS, true},
    {offsetof(ect_eoe_address_t, subnet), ADDRESS, true}, {offsetof(ect_eoe_address_t, gateway), ADDRESS, true},
    {offsetof(ect_eoe_address_t, dns), ADDRESS, true},    {offsetof(ect_eoe_address_t, name), ECT_EOE_NAME, false},
};
enum { FIELDS = sizeof fields / sizeof fields[0], NAME_FIELD = FIELDS - 1 };

static void copy_field(uint8_t *to, const uint8_t *from, const field_t *field, unsigned int size)
{
    for (unsigned int i = 0; i < size; i++)
        to[i] = from[field->reversed ? size - 1 - i : i];
}

/* Reads the flagged fields: at fixed places (IgH, TwinCAT) when the mail has room for all, else packed (SOEM, SOES).
 * @return false: a field reaches beyond the mail */
static bool read_address(ect_eoe_address_t *address, const uint8_t *data, unsigned int length)
{
    if (length < HEADER + FLAGS)
        return false;
    const bool fixed = length >= FULL_LAYOUT;
    const uint8_t flags = data[HEADER];
    unsigned int at = HEADER + FLAGS;
    for (unsigned int i = 0; i < FIELDS; i++) {
        unsigned int size = fields[i].size;
        bool flagged = (flags >> i & 1) != 0;
        if (flagged && i == NAME_FIELD && at < length && length - at < size)
            size = length - at; /* may be cut short */
        if (flagged && (at > length || size > length - at))
            return false;
        if (flagged) {
            uint8_t *to = (uint8_t *)address + fields[i].offset;
            memset(to, 0, fields[i].size);
            copy_field(to, data + at, &fields[i], size);
            address->known |= (uint8_t)(1u << i);
        }
        at += flagged || fixed ? size : 0;
    }
    return true;
}

static uint16_t set_address(const ect_eoe_t *eoe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    ect_eoe_state_t *e = state_of(eoe, s);
    ect_eoe_address_t wanted = e->address;
    if (!read_address(&wanted, data, length))
        return ECT_EOE_UNSPECIFIED;
    if ((data[HEADER] & SIX_BITS) == ECT_EOE_HAS_MAC && !eoe->dhcp)
        return ECT_EOE_NO_DHCP;
    uint16_t result = eoe->set ? eoe->set(eoe, s->config.instance, data[0] >> 4, &wanted) : ECT_EOE_OK;
    if (result == ECT_EOE_OK)
        e->address = wanted;
    return result;
}

/* Writes the fields in succession, as SOEM reads them; a name for which the mailbox has no room is omitted. */
static void send_address(const ect_eoe_t *eoe, ect_slave_t *s, const uint8_t *request)
{
    const ect_eoe_address_t *address = &state_of(eoe, s)->address;
    uint16_t room = ect_mailbox_room(s);
    uint16_t at = HEADER + FLAGS;
    if (eoe->load)
        eoe->load(eoe, s->config.instance, request[0] >> 4);
    uint8_t *mail = ect_mailbox_build(s);
    mail[0] = (uint8_t)(GET_IP_DONE | (request[0] & 0xF0));
    mail[1] = LAST;
    for (unsigned int i = 0; i < FIELDS; i++) {
        if ((address->known >> i & 1) == 0 || fields[i].size > room - at)
            continue;
        copy_field(mail + at, (const uint8_t *)address + fields[i].offset, &fields[i], fields[i].size);
        at = (uint16_t)(at + fields[i].size);
        mail[HEADER] |= (uint8_t)(1u << i);
    }
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_EOE, at);
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

static void answer(const ect_eoe_t *eoe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    const uint8_t type = data[0] & 0x0F;
    const bool good = has_port(eoe, data[0] >> 4);
    switch (type) {
    case TIME_STAMP:
    case SET_IP_DONE:
    case SET_FILTER_DONE:
    case GET_IP_DONE:
    case GET_FILTER_DONE: /* replies to requests that the slave does not send */
        break;
    case SET_IP:
        reply(s, data, SET_IP_DONE, good ? set_address(eoe, s, data, length) : ECT_EOE_UNSPECIFIED);
        break;
    case GET_IP:
        if (good)
            send_address(eoe, s, data);
        else
            reply(s, data, GET_IP_DONE, ECT_EOE_UNSPECIFIED);
        break;
    case SET_FILTER:
    case GET_FILTER:
        reply(s, data, (uint8_t)(type + 1), good ? ECT_EOE_NO_FILTER : ECT_EOE_UNSPECIFIED);
        break;
    default:
        reply(s, data, type, ECT_EOE_UNSUPPORTED_TYPE);
        break;
    }
}

uint16_t ect_eoe_request(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    if (length < HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    if ((data[0] & 0x0F) == FRAGMENT)
        take_fragment(entry_of(self), s, data, length);
    else
        answer(entry_of(self), s, data, length);
    return ECT_MAILBOX_OK;
}

/* --- a frame of the device ---------------------------------------------------------------------------------------- */

/* Fetches the next frame of the device. @return false: none */
static bool fetch(const ect_eoe_t *eoe, ect_slave_t *s)
{
    ect_eoe_state_t *e = state_of(eoe, s);
    for (;;) {
        uint8_t port = 0;
        uint16_t length = eoe->fetch(eoe, s->config.instance, e->out, &port);
        if (length == 0)
            return false;
        if (!is_good_length(e->out, length) || !has_port(eoe, port)) {
            e->dropped++;
            continue;
        }
        e->out_length = length;
        e->out_sent = 0;
        e->out_fragment = 0;
        e->out_number = (e->out_number + 1) & 0x0F;
        e->out_port = port;
        return true;
    }
}

static void send_fragment(ect_eoe_state_t *e, ect_slave_t *s)
{
    unsigned int room = ect_mailbox_room(s) - HEADER;
    unsigned int rest = e->out_length - e->out_sent;
    bool last = rest <= room;
    unsigned int bytes = last ? rest : room / UNIT * UNIT;
    unsigned int units = e->out_fragment == 0 ? (e->out_length + UNIT - 1u) / UNIT : e->out_sent / UNIT;
    ECT_ASSERT(bytes > 0 && e->out_fragment <= SIX_BITS && units <= SIX_BITS);
    uint8_t *mail = ect_mailbox_build(s);
    mail[0] = (uint8_t)(FRAGMENT | e->out_port << 4);
    mail[1] = last ? LAST : 0;
    ect_store_le16(mail + 2, (uint16_t)(e->out_fragment | units << 6 | (unsigned int)e->out_number << 12));
    memcpy(mail + HEADER, e->out + e->out_sent, bytes);
    e->out_sent = (uint16_t)(e->out_sent + bytes);
    e->out_fragment++;
    e->sent += last;
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_EOE, (uint16_t)(HEADER + bytes));
}

bool ect_eoe_next(const ect_protocol_t *self, ect_slave_t *s, bool send)
{
    const ect_eoe_t *eoe = entry_of(self);
    ect_eoe_state_t *e = state_of(eoe, s);
    if (e->out_sent == e->out_length && !fetch(eoe, s))
        return false;
    if (send)
        send_fragment(e, s);
    return true;
}

void ect_eoe_reset(const ect_protocol_t *self, ect_slave_t *s)
{
    const ect_eoe_t *eoe = entry_of(self);
    ect_eoe_state_t *e = state_of(eoe, s);
    e->in_open = false;
    e->out_sent = e->out_length = 0;
    if (eoe->reset)
        eoe->reset(eoe, s->config.instance);
}
