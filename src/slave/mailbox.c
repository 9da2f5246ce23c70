/* SPDX-License-Identifier: MIT */
/*
 * The mailbox: one request at a time from SM0, one mail at a time into SM1. Two mails are kept, the newest and the
 * one before it, because a master may notice the loss of a mail when the next one is already in SM1.
 */
#include <string.h>

#include "slave/internal.h"

uint16_t ect_mailbox_sm_room(const ect_device_t *device, unsigned int sm)
{
    uint16_t boot = sm == 0 ? device->boot_out.length : device->boot_in.length;
    uint16_t room = ect_sm_longest_mailbox(device, sm);
    return room > boot ? room : boot;
}

/* A request up to this length is read in one access: the header and the smallest SDO. */
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
    ect_mailbox_wake(s); /* a mail may have waited for this */
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

/* Work that is not done yet, bits of ect_mailbox_t::open. */
enum {
    TO_WRITE = 1,     /* `shown` must be written to SM1 */
    IN_BUFFER = 2,    /* `shown` is in SM1, unread as far as known */
    NEWEST_WAITS = 4, /* after a repeat: `newest` must follow `shown` */
    REPEAT_DUE = 8,   /* the master requests the last mail again */
    ACK_DUE = 16,     /* ... and gets the acknowledge once that mail is in SM1 */
    MAIL_OPEN = TO_WRITE | IN_BUFFER | NEWEST_WAITS,
};

static bool is(const ect_mailbox_t *m, unsigned int open)
{
    return (m->open & open) != 0;
}

static bool may_build(const ect_mailbox_t *m)
{
    return !is(m, MAIL_OPEN);
}

/* Overwrites the older mail, and with it possibly the reply kept for a repeated request. */
static uint8_t build_slot(const ect_mailbox_t *m)
{
    return m->newest ^ 1;
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

/* Bytes in use of a buffer whose last byte is transferred separately. The length in the header may be too large. */
static unsigned int end_of(const uint8_t *mail, unsigned int last)
{
    unsigned int end = ECT_MAILBOX_HEADER + (unsigned int)ect_load_le16(mail);
    return end < last ? end : last;
}

/* Writes the bytes in use of both mails, so that nothing of the other one remains in SM1, and the last byte, which
 * fills it. The first mail writes all bytes, because the content is unknown. The toggle is acknowledged with the mail.
 */
static void write_shown(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    ECT_ASSERT(is(m, TO_WRITE) && m->mails > (m->shown != m->newest));
    const uint8_t *mail = m->mail[m->shown];
    unsigned int last = m->in_size - 1u;
    unsigned int other = m->mails == 2 ? end_of(m->mail[m->shown ^ 1], last) : last;
    unsigned int end = end_of(mail, last);
    (void)ect_slave_write(s, m->in_start, mail, end > other ? end : other);
    if (ect_slave_write(s, m->in_start + last, mail + last, 1)) /* no access if the one before failed */
        m->open ^= TO_WRITE | IN_BUFFER;
}

static void acknowledge_repeat(ect_slave_t *s)
{
    ECT_ASSERT(is(&s->mailbox, ACK_DUE) && s->sm_repeat_ack != s->mailbox.toggle);
    s->mailbox.open ^= ACK_DUE;
    ect_sm_acknowledge_repeat(s, s->mailbox.toggle);
    (void)ect_sm_flush(s);
}

static void show(ect_slave_t *s, uint8_t slot)
{
    ECT_ASSERT(s->mailbox.mails > (slot != s->mailbox.newest) && !is(&s->mailbox, IN_BUFFER));
    s->mailbox.shown = slot;
    s->mailbox.repeated = false;
    s->mailbox.open |= TO_WRITE;
    write_shown(s);
}

void ect_mailbox_send(ect_slave_t *s, uint8_t type, uint16_t length)
{
    ect_mailbox_t *m = &s->mailbox;
    uint8_t slot = build_slot(m);
    ECT_ASSERT(m->running && may_build(m));
    ECT_ASSERT(type <= 0x0F && length > 0 && length <= ect_mailbox_room(s));
    uint8_t *mail = m->mail[slot];
    m->reply_counter = m->reply_counter == 7 ? 1 : (uint8_t)(m->reply_counter + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | (m->reply_counter << 4));
    if (s->config.device->mail)
        s->config.device->mail(s->config.instance, mail, m->in_size);
    m->newest = slot;
    m->mails = m->mails < 2 ? (uint8_t)(m->mails + 1) : 2;
    show(s, slot);
}

static void send_error(ect_slave_t *s, uint16_t detail)
{
    ECT_ASSERT(detail >= ECT_MAILBOX_ERROR_SYNTAX && detail <= ECT_MAILBOX_ERROR_SIZE);
    uint8_t *data = ect_mailbox_build(s);
    data[0] = 1; /* in words of 16 bits */
    data[2] = (uint8_t)detail;
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

/* Passes the request to the entries of its type, until one accepts it. */
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

/* Reads the bytes in use, and the last byte, which empties SM0. Most requests need only the first access. */
static bool read_request(ect_slave_t *s)
{
    const ect_mailbox_t *m = &s->mailbox;
    unsigned int last = m->out_size - 1u;
    unsigned int first = last < SHORT_MAIL ? last : SHORT_MAIL;
    (void)ect_slave_read(s, m->out_start, m->request, first);
    unsigned int end = end_of(m->request, last);
    if (end > first)
        (void)ect_slave_read(s, m->out_start + first, m->request + first, end - first);
    return ect_slave_read(s, m->out_start + last, m->request + last, 1); /* no access if one before failed */
}

static void handle_request(ect_slave_t *s)
{
    ECT_ASSERT(may_build(&s->mailbox));
    ect_mailbox_t *m = &s->mailbox;
    if (!read_request(s)) {
        s->due |= ECT_EVENT_SM_CHANGED; /* reading the first byte has cleared its event */
        return;
    }
    ect_cycle_yield(s); /* a long access has ended, and that of the reply follows */
    uint8_t counter = (m->request[5] >> 4) & 7u;
    if (counter != 0 && counter == m->request_counter) { /* a repetition: not executed again */
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

/* SM1 is empty again. A request that waits now was sent before that, as far as known; if it is a repetition, no reply
 * is lost. */
static void note_fetched(ect_mailbox_t *m)
{
    if (m->request_waits && is(m, IN_BUFFER))
        m->reply = NO_REPLY;
    m->open &= (uint8_t)~IN_BUFFER;
}

/* --- repeat ------------------------------------------------------------------------------------------------------ */

/* The running mailbox is the one that the master configured: another length is refused, even a permitted one. */
static bool is_unchanged(const ect_slave_t *s, const uint8_t *sm_registers)
{
    return ect_sm_mailbox_good(s->config.device, sm_registers, s->state == ECT_STATE_BOOT) &&
           ect_load_le16(sm_registers + ECT_SM_LENGTH) == s->mailbox.out_size &&
           ect_load_le16(sm_registers + ECT_SM_SIZE + ECT_SM_LENGTH) == s->mailbox.in_size;
}

bool ect_mailbox_check(ect_slave_t *s, const uint8_t *sm_registers)
{
    ECT_ASSERT(s->mailbox.running);
    ect_mailbox_t *m = &s->mailbox;
    const uint8_t *sm1 = sm_registers + ECT_SM_SIZE;
    bool toggle = (sm1[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_REPEAT) != 0;
    m->request_waits = (sm_registers[ECT_SM_STATUS] & ECT_SM_STATUS_FULL) != 0;
    if ((sm1[ECT_SM_STATUS] & ECT_SM_STATUS_FULL) == 0)
        note_fetched(m); /* or lost, when the master disabled and enabled SM1 */
    if (toggle != m->toggle) {
        m->toggle = toggle;
        m->open |= REPEAT_DUE | ACK_DUE;
        s->sm_repeat_ack = !toggle; /* not before the mail is in SM1 */
    }
    return is_unchanged(s, sm_registers);
}

/* The lost mail precedes the one in SM1, which follows it again. Disabling and enabling SM1 empties it. */
static bool repeat_lost(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    ECT_ASSERT(m->mails == 2 && is(m, IN_BUFFER));
    ect_sm_disable(s, SM1);
    (void)ect_sm_flush(s);
    ect_sm_enable(s, SM1);
    if (!ect_sm_flush(s)) /* no access if the one before failed */
        return false;
    m->open ^= IN_BUFFER | NEWEST_WAITS | TO_WRITE;
    m->shown = m->newest ^ 1;
    return true;
}

static void repeat(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    ECT_ASSERT(is(m, REPEAT_DUE));
    if (m->mails > 0 && !is(m, IN_BUFFER))
        m->open |= TO_WRITE;
    else if (is(m, IN_BUFFER) && !m->repeated && m->shown == m->newest && m->mails == 2 && !repeat_lost(s))
        return;
    m->repeated = true;
    m->open ^= REPEAT_DUE;
}

/* --- the poll ---------------------------------------------------------------------------------------------------- */

/* Outstanding repeats come first: the mailbox may be free after them. */
static void go_on(ect_slave_t *s)
{
    ect_mailbox_t *m = &s->mailbox;
    if (is(m, REPEAT_DUE))
        repeat(s);
    if (is(m, TO_WRITE))
        write_shown(s);
    if ((m->open & (ACK_DUE | TO_WRITE | REPEAT_DUE)) == ACK_DUE && !s->failed)
        acknowledge_repeat(s);
    if ((m->open & MAIL_OPEN) == NEWEST_WAITS) {
        m->open ^= NEWEST_WAITS;
        show(s, m->newest);
    }
}

/* Calls `next` of the protocols, to send a mail or only to report one: those without requests before a waiting request
 * is handled, the others after it. */
static bool send_own(ect_slave_t *s, bool takes_requests, bool send)
{
    ECT_ASSERT(!send || may_build(&s->mailbox));
    FOR_EACH_PROTOCOL(s, p)
    {
        if ((*p)->next && ((*p)->request != NULL) == takes_requests && is_in_state(*p, s) && (*p)->next(*p, s, send))
            return true;
    }
    return false;
}

void ect_mailbox_poll(ect_slave_t *s, uint32_t event)
{
    ect_mailbox_t *m = &s->mailbox;
    ECT_ASSERT(m->running);
    if ((event & ECT_EVENT_SM0) != 0)
        m->request_waits = true;
    if ((event & ECT_EVENT_SM1) != 0)
        note_fetched(m);
    go_on(s);
    const bool announced = m->announced;
    if (announced) {
        m->announced = false; /* an announcement after this point counts again, also from an interrupt */
        if (may_build(m))
            (void)send_own(s, false, true);
    }
    bool more = announced;
    if (m->request_waits && may_build(m)) {
        m->request_waits = false;
        handle_request(s);
    }
    if (may_build(m))
        more = (announced || m->announced) && send_own(s, true, true);
    if (more)
        m->announced = true;
}

void ect_mailbox_wake(ect_slave_t *s)
{
    s->mailbox.announced = true;
}

bool ect_mailbox_waits(ect_slave_t *s)
{
    const ect_mailbox_t *m = &s->mailbox;
    return !may_build(m) &&
           (m->request_waits || is(m, NEWEST_WAITS) || send_own(s, false, false) || send_own(s, true, false));
}
