/* SPDX-License-Identifier: MIT */
/*
 * The mailbox: one request at a time out of SM0, one mail at a time into SM1. Two mails are kept, the newest and the
 * one before it, because a master may find out that it lost a mail when the next one already stands in SM1.
 */
#include <string.h>

#include "slave/internal.h"

uint16_t ect_mailbox_room(const ect_device_t *device, unsigned int sm)
{
    uint16_t boot = sm == 0 ? device->boot_out.length : device->boot_in.length;
    uint16_t room = 0;
    if (device->sm_count >= 2 && device->mailbox_protocols != 0)
        room = ect_sm_room(device, sm);
    return room > boot ? room : boot;
}

enum { NO_REPLY = 0xFF };

void ect_mailbox_configure(ect_slave_t *s, const uint8_t *sm_registers)
{
    const uint8_t *sm1 = sm_registers + ECT_SM_SIZE;
    uint8_t *memory = s->config.mailbox;
    uint16_t out_room = ect_mailbox_room(s->config.device, 0);
    uint16_t in_room = ect_mailbox_room(s->config.device, 1);
    s->mailbox = (ect_mailbox_t){
        .out_start = ect_load_le16(sm_registers + ECT_SM_START),
        .in_start = ect_load_le16(sm1 + ECT_SM_START),
        .out_size = ect_load_le16(sm_registers + ECT_SM_LENGTH),
        .in_size = ect_load_le16(sm1 + ECT_SM_LENGTH),
        .request = memory,
        .mail = {memory + out_room, memory + out_room + in_room},
        .reply = NO_REPLY,
        .toggle = (sm1[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_REPEAT) != 0,
    };
}

void ect_mailbox_start(ect_slave_t *s)
{
    s->mailbox.running = true;
    ect_coe_start(s);
}

static bool may_build(const ect_mailbox_t *m)
{
    return !m->in_buffer && !m->to_write && !m->newest_waits;
}

/* The mail that is overwritten is the older one; with it may go the reply kept for a repeated request. */
static uint8_t build_slot(const ect_mailbox_t *m)
{
    return m->mails == 0 ? 0 : m->newest ^ 1;
}

uint8_t *ect_mailbox_build(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    uint8_t *mail = m->mail[build_slot(m)];
    if (m->reply == build_slot(m))
        m->reply = NO_REPLY;
    memset(mail, 0, m->in_size);
    return mail;
}

/* SM1 as a whole, so that nothing of an older mail is left in it; the toggle is answered when the mail stands there. */
static void write_shown(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    if (!ect_slave_write(s, m->in_start, m->mail[m->shown], m->in_size))
        return;
    m->to_write = false;
    m->in_buffer = true;
}

static void acknowledge_repeat(ect_slave_t *s)
{
    s->mailbox.ack_due = false;
    ect_machine_sm_off(s, 1u << 1, false);
    (void)ect_machine_flush(s);
}

static void show(ect_slave_t *s, uint8_t slot)
{
    s->mailbox.shown = slot;
    s->mailbox.repeated = false;
    s->mailbox.to_write = true;
    write_shown(s);
}

void ect_mailbox_send(ect_slave_t *s, uint8_t type, uint16_t length)
{
    ect_mailbox_t *m = &s->mailbox;
    uint8_t slot = build_slot(m);
    uint8_t *mail = m->mail[slot];
    m->reply_counter = (uint8_t)(m->reply_counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | (m->reply_counter << 4));
    m->newest = slot;
    m->mails = m->mails < 2 ? (uint8_t)(m->mails + 1) : 2;
    show(s, slot);
}

void ect_mailbox_error(ect_slave_t *s, uint16_t detail)
{
    uint8_t *mail = ect_mailbox_build(s);
    ect_store_le16(mail + ECT_MAILBOX_HEADER, 1);
    ect_store_le16(mail + ECT_MAILBOX_HEADER + 2, detail);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_ERROR, 4);
}

/* --- requests ---------------------------------------------------------------------------------------------------- */

/* 0, or the detail of the error reply. */
static uint16_t header_error(const ect_mailbox_t *m)
{
    const uint8_t *mail = m->request;
    uint16_t length = ect_load_le16(mail);
    if (length > m->out_size - ECT_MAILBOX_HEADER)
        return ECT_MAILBOX_ERROR_SIZE;
    if (length == 0)
        return ECT_MAILBOX_ERROR_HEADER;
    if ((mail[5] & 0x80) != 0)
        return ECT_MAILBOX_ERROR_SYNTAX;
    return (mail[4] & 0x3F) != 0 ? ECT_MAILBOX_ERROR_CHANNEL : 0;
}

/* The services of the mailbox: what stands here is linked, everything else is answered as unsupported. */
typedef struct service {
    uint8_t type;
    uint8_t protocol;
    void (*request)(ect_slave_t *s, const uint8_t *payload, uint16_t length);
} service_t;

static const service_t services[] = {
    {ECT_MAILBOX_TYPE_COE, ECT_MAILBOX_COE, ect_coe_request},
};

static void dispatch(ect_slave_t *s)
{
    const uint8_t *mail = s->mailbox.request;
    uint16_t error = header_error(&s->mailbox);
    if (error != 0) {
        ect_mailbox_error(s, error);
        return;
    }
    for (size_t i = 0; i < sizeof services / sizeof services[0]; i++) {
        bool in_state = s->state != ECT_STATE_BOOT; /* there only FoE is at home */
        bool offered = (s->config.device->mailbox_protocols & services[i].protocol) != 0;
        if (in_state && offered && services[i].type == (mail[5] & 0x0F)) {
            services[i].request(s, mail + ECT_MAILBOX_HEADER, ect_load_le16(mail));
            return;
        }
    }
    ect_mailbox_error(s, ECT_MAILBOX_ERROR_PROTOCOL);
}

static void handle_request(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    if (!ect_slave_read(s, m->out_start, m->request, m->out_size))
        return;
    uint8_t counter = (m->request[5] >> 4) & 7u;
    if (counter != 0 && counter == m->request_counter) { /* a repetition: not carried out again */
        if (m->reply != NO_REPLY)
            show(s, m->reply);
        return;
    }
    m->request_counter = counter;
    uint8_t before = m->reply_counter;
    dispatch(s);
    m->reply = m->reply_counter != before ? m->newest : NO_REPLY;
}

/* --- repeat ------------------------------------------------------------------------------------------------------ */

void ect_mailbox_look(ect_slave_t *s, const uint8_t *sm_registers)
{
    ect_mailbox_t *m = &s->mailbox;
    const uint8_t *sm1 = sm_registers + ECT_SM_SIZE;
    bool toggle = (sm1[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_REPEAT) != 0;
    if ((sm1[ECT_SM_STATUS] & ECT_SM_STATUS_FULL) == 0)
        m->in_buffer = false; /* fetched, or lost when the master switched SM1 off and on */
    if (toggle == m->toggle)
        return;
    m->toggle = toggle;
    m->repeat_due = true;
    m->ack_due = true;
}

/* The mail that was lost is the one before that which stands in SM1; this one follows it. Off and on empties SM1. */
static bool bring_back(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    ect_machine_sm_off(s, 1u << 1, true);
    if (!ect_machine_flush(s))
        return false;
    ect_machine_sm_off(s, 1u << 1, false);
    if (!ect_machine_flush(s))
        return false;
    m->in_buffer = false;
    m->newest_waits = true;
    m->shown = m->newest ^ 1;
    m->to_write = true;
    return true;
}

static void repeat(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    if (m->mails > 0 && !m->in_buffer)
        m->to_write = true;
    else if (m->in_buffer && !m->repeated && m->shown == m->newest && m->mails == 2 && !bring_back(s))
        return;
    m->repeated = true;
    m->repeat_due = false;
}

/* --- the poll ---------------------------------------------------------------------------------------------------- */

void ect_mailbox_poll(ect_slave_t *s, uint32_t event)
{
    ect_mailbox_t *m = &s->mailbox;
    if ((event & ECT_EVENT_SM1) != 0)
        m->in_buffer = false;
    if ((event & ECT_EVENT_SM0) != 0 && m->in_buffer)
        m->reply = NO_REPLY; /* sent before the reply was fetched: should it be a repetition, the reply is not lost */
    if (m->repeat_due)
        repeat(s);
    if (m->to_write)
        write_shown(s);
    if (m->ack_due && !m->to_write && !m->repeat_due && !s->failed)
        acknowledge_repeat(s);
    if (m->newest_waits && !m->in_buffer && !m->to_write) {
        m->newest_waits = false;
        show(s, m->newest);
    }
    if (may_build(m) && ect_coe_has_emergency(s))
        ect_coe_send_emergency(s);
    else if (may_build(m) && (event & ECT_EVENT_SM0) != 0)
        handle_request(s);
    if (may_build(m) && ect_sdo_info_has_more(s))
        ect_sdo_info_fragment(s);
}
