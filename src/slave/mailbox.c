/* SPDX-License-Identifier: MIT */
/*
 * The mailbox: one request at a time out of SM0, one mail at a time into SM1. Two mails are kept, the newest and the
 * one before it, because a master may find out that it lost a mail when the next one already stands in SM1.
 */
#include <string.h>

#include "slave/internal.h"

uint16_t ect_mailbox_sm_room(const ect_device_t *device, unsigned int sm)
{
    uint16_t boot = sm == 0 ? device->boot_out.length : device->boot_in.length;
    uint16_t room = ect_sm_longest_mailbox(device, sm);
    return room > boot ? room : boot;
}

/* A request is looked at in one access when it is no longer than this: the header and the smallest SDO. */
enum { NO_REPLY = 0xFF, SM1 = 1 << 1, SHORT_MAIL = 16 };

void ect_mailbox_configure(ect_slave_t *s, const uint8_t *sm_registers)
{
    ECT_ASSERT(!s->mailbox.running);
    const uint8_t *sm1 = sm_registers + ECT_SM_SIZE;
    uint8_t *memory = s->config.mailbox;
    uint16_t out_room = ect_mailbox_sm_room(s->config.device, 0);
    uint16_t in_room = ect_mailbox_sm_room(s->config.device, 1);
    ECT_ASSERT(memory && s->config.device->mailbox_protocols != 0);
    s->mailbox = (ect_mailbox_t){
        .out_start = ect_load_le16(sm_registers + ECT_SM_START),
        .in_start = ect_load_le16(sm1 + ECT_SM_START),
        .out_size = ect_load_le16(sm_registers + ECT_SM_LENGTH),
        .in_size = ect_load_le16(sm1 + ECT_SM_LENGTH),
        .in_used = ect_load_le16(sm1 + ECT_SM_LENGTH),
        .request = memory,
        .mail = {memory + out_room, memory + out_room + in_room},
        .reply = NO_REPLY,
        .toggle = (sm1[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_REPEAT) != 0,
    };
    s->sm_repeat_ack = s->mailbox.toggle;
    ECT_ASSERT(s->mailbox.out_size > ECT_MAILBOX_HEADER && s->mailbox.out_size <= out_room);
    ECT_ASSERT(s->mailbox.in_size > ECT_MAILBOX_HEADER && s->mailbox.in_size <= in_room);
}

/* The protocols that the device names. */
#define FOR_EACH_PROTOCOL(s, p) for (const ect_protocol_t *const *p = (s)->config.device->protocols; p && *p; p++)

void ect_mailbox_start(ect_slave_t *s)
{
    ECT_ASSERT(s->mailbox.request && !s->mailbox.running);
    s->mailbox.running = true;
    ect_mailbox_wake(s); /* something may have been waiting for this */
    FOR_EACH_PROTOCOL(s, p)
    {
        if ((*p)->reset)
            (*p)->reset(*p, s);
    }
}

/* --- sending ----------------------------------------------------------------------------------------------------- */

void *ect_mailbox_instance(const ect_slave_t *s)
{
    return s->config.instance;
}

uint16_t ect_mailbox_room(const ect_slave_t *s)
{
    ECT_ASSERT(s->mailbox.in_size > ECT_MAILBOX_HEADER);
    return (uint16_t)(s->mailbox.in_size - ECT_MAILBOX_HEADER);
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
    ECT_ASSERT(m->running && may_build(m));
    if (m->reply == build_slot(m))
        m->reply = NO_REPLY;
    memset(mail, 0, m->in_size);
    return mail + ECT_MAILBOX_HEADER;
}

/* Bytes of a mail that are used: its header says so, and may say too much. */
static uint16_t used_bytes(const uint8_t *mail, uint16_t size)
{
    uint32_t used = ECT_MAILBOX_HEADER + (uint32_t)ect_load_le16(mail);
    return (uint16_t)(used < size ? used : size);
}

/* What is used of the mail, or was of the one that stood there, so that nothing of that is left; and the last byte, with
 * which the mailbox is full. The toggle is answered when the mail stands there. */
static void write_shown(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    ECT_ASSERT(m->to_write && m->shown < m->mails);
    const uint8_t *mail = m->mail[m->shown];
    uint16_t used = used_bytes(mail, m->in_size);
    uint16_t bytes = used > m->in_used ? used : m->in_used;
    uint16_t last = (uint16_t)(m->in_size - 1);
    m->in_used = m->in_size; /* should it fail, anything may stand there */
    if (!ect_slave_write(s, m->in_start, mail, bytes))
        return;
    if (bytes <= last && !ect_slave_write(s, (uint16_t)(m->in_start + last), mail + last, 1))
        return;
    m->in_used = used;
    m->to_write = false;
    m->in_buffer = true;
}

static void acknowledge_repeat(ect_slave_t *s)
{
    ECT_ASSERT(s->mailbox.ack_due && s->sm_repeat_ack != s->mailbox.toggle);
    s->mailbox.ack_due = false;
    ect_sm_acknowledge_repeat(s, s->mailbox.toggle);
    (void)ect_sm_flush(s);
}

static void show(ect_slave_t *s, uint8_t slot)
{
    ECT_ASSERT(slot < s->mailbox.mails && !s->mailbox.in_buffer);
    s->mailbox.shown = slot;
    s->mailbox.repeated = false;
    s->mailbox.to_write = true;
    write_shown(s);
}

void ect_mailbox_send(ect_slave_t *s, uint8_t type, uint16_t length)
{
    ect_mailbox_t *m = &s->mailbox;
    uint8_t slot = build_slot(m);
    ECT_ASSERT(m->running && may_build(m));
    ECT_ASSERT(type <= 0x0F && length > 0 && length <= ect_mailbox_room(s));
    uint8_t *mail = m->mail[slot];
    m->reply_counter = (uint8_t)(m->reply_counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | (m->reply_counter << 4));
    m->newest = slot;
    m->mails = m->mails < 2 ? (uint8_t)(m->mails + 1) : 2;
    show(s, slot);
}

static void send_error(ect_slave_t *s, uint16_t detail)
{
    ECT_ASSERT(detail >= ECT_MAILBOX_ERROR_SYNTAX && detail <= ECT_MAILBOX_ERROR_SIZE);
    uint8_t *data = ect_mailbox_build(s);
    ect_store_le16(data, 1);
    ect_store_le16(data + 2, detail);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_ERROR, 4);
}

/* --- requests ---------------------------------------------------------------------------------------------------- */

/* ECT_MAILBOX_OK, or the detail of the error reply. */
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
    return (mail[4] & 0x3F) != 0 ? ECT_MAILBOX_ERROR_CHANNEL : ECT_MAILBOX_OK;
}

static bool is_in_state(const ect_protocol_t *p, const ect_slave_t *s)
{
    return (p->states & ECT_IN(s->state)) != 0;
}

/* Hands the request to the entries of its type, until one wants it. */
static uint16_t dispatch(ect_slave_t *s)
{
    const uint8_t *mail = s->mailbox.request;
    uint16_t error = header_error(&s->mailbox);
    if (error != ECT_MAILBOX_OK)
        return error;
    error = ECT_MAILBOX_ERROR_PROTOCOL;
    FOR_EACH_PROTOCOL(s, p)
    {
        if ((*p)->type != (mail[5] & 0x0F) || !is_in_state(*p, s) || !(*p)->request)
            continue;
        error = (*p)->request(*p, s, mail + ECT_MAILBOX_HEADER, ect_load_le16(mail));
        if (error != ECT_MAILBOX_ERROR_SERVICE)
            break;
    }
    return error;
}

/* A request that could not be read to its end: its event went with its first byte. It is read anew, unless it is gone
 * all the same. */
static bool is_left(ect_slave_t *s)
{
    uint8_t status;
    if (!s->mailbox.reading || !ect_slave_read(s, ECT_REG_SM + ECT_SM_STATUS, &status, 1))
        return false;
    s->mailbox.reading = (status & ECT_SM_STATUS_FULL) != 0;
    return s->mailbox.reading;
}

/* What is used of it, and its last byte, with which the mailbox is empty. */
static bool read_request(ect_slave_t *s)
{
    const ect_mailbox_t *m = &s->mailbox;
    uint16_t last = (uint16_t)(m->out_size - 1);
    uint16_t bytes = m->out_size < SHORT_MAIL ? m->out_size : SHORT_MAIL;
    if (!ect_slave_read(s, m->out_start, m->request, bytes))
        return false;
    uint16_t used = used_bytes(m->request, m->out_size);
    if (used > bytes) {
        if (!ect_slave_read(s, (uint16_t)(m->out_start + bytes), m->request + bytes, (uint16_t)(used - bytes)))
            return false;
        bytes = used;
    }
    return bytes > last || ect_slave_read(s, (uint16_t)(m->out_start + last), m->request + last, 1);
}

static void handle_request(ect_slave_t *s)
{
    ECT_ASSERT(may_build(&s->mailbox));
    ect_mailbox_t *m = &s->mailbox;
    m->reading = true;
    if (!read_request(s))
        return;
    m->reading = false;
    ect_cycle_yield(s); /* a long access is behind us, and the answer's is to come */
    uint8_t counter = (m->request[5] >> 4) & 7u;
    if (counter != 0 && counter == m->request_counter) { /* a repetition: not carried out again */
        if (m->reply != NO_REPLY)
            show(s, m->reply);
        return;
    }
    m->request_counter = counter;
    uint8_t before = m->reply_counter;
    uint16_t error = dispatch(s);
    ECT_ASSERT(error == ECT_MAILBOX_OK || m->reply_counter == before);
    if (error != ECT_MAILBOX_OK)
        send_error(s, error);
    m->reply = m->reply_counter != before ? m->newest : NO_REPLY;
}

/* --- repeat ------------------------------------------------------------------------------------------------------ */

/* The mailbox that runs is the one that the master configured: not another length, though it were allowed. */
static bool is_unchanged(const ect_slave_t *s, const uint8_t *sm_registers)
{
    return ect_sm_mailbox_good(s->config.device, sm_registers, s->state == ECT_STATE_BOOT) &&
           ect_load_le16(sm_registers + ECT_SM_LENGTH) == s->mailbox.out_size &&
           ect_load_le16(sm_registers + ECT_SM_SIZE + ECT_SM_LENGTH) == s->mailbox.in_size;
}

bool ect_mailbox_look(ect_slave_t *s, const uint8_t *sm_registers)
{
    ECT_ASSERT(s->mailbox.running);
    ect_mailbox_t *m = &s->mailbox;
    const uint8_t *sm1 = sm_registers + ECT_SM_SIZE;
    bool toggle = (sm1[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_REPEAT) != 0;
    if ((sm1[ECT_SM_STATUS] & ECT_SM_STATUS_FULL) == 0)
        m->in_buffer = false; /* fetched, or lost when the master switched SM1 off and on */
    m->in_used = m->in_size;  /* and then wrote there */
    if (toggle != m->toggle) {
        m->toggle = toggle;
        m->repeat_due = true;
        m->ack_due = true;
        s->sm_repeat_ack = !toggle; /* not before the mail stands there */
    }
    return is_unchanged(s, sm_registers);
}

/* The mail that was lost is the one before that which stands in SM1; this one follows it. Off and on empties SM1. */
static bool bring_back(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    ECT_ASSERT(m->mails == 2 && m->in_buffer);
    ect_sm_disable(s, SM1);
    if (!ect_sm_flush(s))
        return false;
    ect_sm_enable(s, SM1);
    if (!ect_sm_flush(s))
        return false;
    m->in_buffer = false;
    m->newest_waits = true;
    m->shown = m->newest ^ 1;
    m->to_write = true;
    return true;
}

static void repeat(ect_slave_t *s)
{
    ECT_ASSERT(s->mailbox.repeat_due);
    ect_mailbox_t *m = &s->mailbox;
    if (m->mails > 0 && !m->in_buffer)
        m->to_write = true;
    else if (m->in_buffer && !m->repeated && m->shown == m->newest && m->mails == 2 && !bring_back(s))
        return;
    m->repeated = true;
    m->repeat_due = false;
}

/* --- the poll ---------------------------------------------------------------------------------------------------- */

/* What is left of repeats comes first: then the mailbox may be free. */
static void go_on(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
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
}

/* Lets the protocols have a mail of their own: those without requests before a request is answered, the others after.
 */
static bool speak(ect_slave_t *s, bool takes_requests, bool send)
{
    FOR_EACH_PROTOCOL(s, p)
    {
        if ((*p)->next && ((*p)->request != NULL) == takes_requests && is_in_state(*p, s) && (*p)->next(*p, s, send))
            return true;
    }
    return false;
}

static bool has_news(const ect_mailbox_t *m)
{
    return may_build(m) && m->heard != m->wakes;
}

void ect_mailbox_poll(ect_slave_t *s, uint32_t event)
{
    ect_mailbox_t *m = &s->mailbox;
    ECT_ASSERT(m->running);
    bool requested = (event & ECT_EVENT_SM0) != 0 || is_left(s);
    if ((event & ECT_EVENT_SM1) != 0)
        m->in_buffer = false;
    if (requested && m->in_buffer)
        m->reply = NO_REPLY; /* sent before the reply was fetched: should it be a repetition, the reply is not lost */
    go_on(s);
    uint8_t wakes = m->wakes;
    if (has_news(m))
        (void)speak(s, false, true);
    if (requested && may_build(m)) {
        requested = false;
        handle_request(s);
    }
    if (has_news(m) && !speak(s, true, true))
        m->heard = wakes; /* nobody has anything more, unless woken since */
    m->request_waits = requested;
}

void ect_mailbox_wake(ect_slave_t *s)
{
    s->mailbox.wakes++;
}

bool ect_mailbox_waits(ect_slave_t *s)
{
    const ect_mailbox_t *m = &s->mailbox;
    return !may_build(m) && (m->request_waits || m->newest_waits || speak(s, false, false) || speak(s, true, false));
}
