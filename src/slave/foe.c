/* SPDX-License-Identifier: MIT */
/* File access over EtherCAT (ETG.1000.6 §5.8): one file at a time, one packet at a time. */
#include "seams/foe.h"

#include <string.h>

#include "slave/internal.h"

enum { READ = 1, WRITE, DATA, ACK, ERROR, BUSY };
enum { HEADER = 6, NUMBER = 2 };
enum { IDLE, READING, WRITING };
enum { MS = 1000000, RETRY_NS = MS, TIMEOUT_MS = 10000 };

static const ect_foe_t *entry_of(const ect_protocol_t *self)
{
    return (const ect_foe_t *)(const void *)self;
}

static ect_foe_transfer_t *transfer_of(const ect_foe_t *foe, const ect_slave_t *s)
{
    return (ect_foe_transfer_t *)(void *)((uint8_t *)s->config.instance + foe->offset);
}

/* --- replies ------------------------------------------------------------------------------------------------------ */

static void send_number(ect_slave_t *s, uint8_t operation, uint32_t number)
{
    uint8_t *mail = ect_mailbox_build(s);
    mail[0] = operation;
    ect_store_le32(mail + NUMBER, number);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_FOE, HEADER);
}

/* Writes an error into a mail that is already built. */
static void send_error_in(ect_slave_t *s, uint8_t *mail, uint32_t code, const char *text)
{
    uint16_t room = (uint16_t)(ect_mailbox_room(s) - HEADER);
    uint16_t length = 0;
    memset(mail, 0, ect_mailbox_room(s));
    mail[0] = ERROR;
    ect_store_le32(mail + NUMBER, code);
    for (; text && text[length] != '\0' && length < room; length++)
        mail[HEADER + length] = (uint8_t)text[length];
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_FOE, (uint16_t)(HEADER + length));
}

static void send_error(ect_slave_t *s, uint32_t code, const char *text)
{
    send_error_in(s, ect_mailbox_build(s), code, text);
}

/* --- the file ----------------------------------------------------------------------------------------------------- */

static void end(const ect_foe_t *foe, ect_slave_t *s, bool whole)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    bool open = t->doing != IDLE;
    *t = (ect_foe_transfer_t){.doing = IDLE};
    if (open && foe->close)
        foe->close(foe, s->config.instance, whole);
}

/* The device itself has closed the file. */
static void forget(const ect_foe_t *foe, const ect_slave_t *s)
{
    *transfer_of(foe, s) = (ect_foe_transfer_t){.doing = IDLE};
}

static void wait_for_device(const ect_foe_t *foe, ect_slave_t *s)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    ECT_ASSERT(foe->ready && t->doing != IDLE);
    t->pending = true;
    t->busy_sent = false;
    t->pending_ns = s->now_ns;
}

/* The packet at `offset`, with its number; built again when it is repeated. */
static void send_packet(const ect_foe_t *foe, ect_slave_t *s)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    const uint16_t room = (uint16_t)(ect_mailbox_room(s) - HEADER);
    const char *text = NULL;
    uint16_t length = room;
    uint8_t *mail = ect_mailbox_build(s);
    uint32_t code = foe->read(foe, s->config.instance, t->offset, mail + HEADER, &length, &text);
    if (code == ECT_FOE_LATER) {
        wait_for_device(foe, s);
        return;
    }
    if (code != ECT_FOE_OK) {
        forget(foe, s);
        send_error_in(s, mail, code, text);
        return;
    }
    ECT_ASSERT(length <= room);
    t->length = length;
    mail[0] = DATA;
    ect_store_le32(mail + NUMBER, t->packet);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_FOE, (uint16_t)(HEADER + length));
}

/* The write or the open has succeeded: the master may continue. */
static void acknowledge(const ect_foe_t *foe, ect_slave_t *s)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    const uint32_t number = t->packet;
    send_number(s, ACK, number);
    if (!t->finished)
        return;
    end(foe, s, true);
    t->packet = number; /* for the case that the last acknowledge is lost */
    t->finished = true;
}

/* The device has completed the pending operation, or starts the next piece. */
static void go_on(const ect_foe_t *foe, ect_slave_t *s)
{
    if (transfer_of(foe, s)->doing == READING)
        send_packet(foe, s);
    else
        acknowledge(foe, s);
}

/* Handles the result of a function of the device. */
static void handle_result(const ect_foe_t *foe, ect_slave_t *s, uint32_t code, const char *text)
{
    if (code == ECT_FOE_LATER) {
        wait_for_device(foe, s);
    } else if (code == ECT_FOE_OK) {
        go_on(foe, s);
    } else {
        forget(foe, s);
        send_error(s, code, text);
    }
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

static uint32_t refusal(const ect_foe_t *foe, const ect_slave_t *s, bool write, uint16_t name_length)
{
    const uint16_t states = write ? foe->write_states : foe->read_states;
    if ((write ? foe->write == NULL : foe->read == NULL) || states == 0)
        return ECT_FOE_ACCESS;
    if ((states & ECT_IN(s->state)) == 0)
        return s->state == ECT_STATE_BOOT               ? ECT_FOE_NOT_IN_BOOT
               : (states & ECT_IN(ECT_STATE_BOOT)) != 0 ? ECT_FOE_BOOT_ONLY
                                                        : ECT_FOE_ILLEGAL;
    return name_length == 0 ? ECT_FOE_NOT_FOUND : ECT_FOE_OK;
}

static void open_file(const ect_foe_t *foe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    const bool write = data[0] == WRITE;
    const ect_foe_file_t file = {.name = (const char *)data + HEADER,
                                 .length = (uint16_t)(length - HEADER),
                                 .password = ect_load_le32(data + NUMBER),
                                 .write = write,
                                 .state = s->state};
    const char *text = NULL;
    end(foe, s, false); /* a master that opens a file has given up the previous one */
    uint32_t code = refusal(foe, s, write, file.length);
    if (code == ECT_FOE_OK)
        code = foe->open(foe, s->config.instance, &file, &text);
    if (code == ECT_FOE_OK || code == ECT_FOE_LATER)
        *transfer_of(foe, s) =
            (ect_foe_transfer_t){.doing = write ? WRITING : READING, .packet = write ? 0 : 1, .activity_ns = s->now_ns};
    handle_result(foe, s, code, text);
}

static void refuse(const ect_foe_t *foe, ect_slave_t *s, uint32_t code)
{
    end(foe, s, false);
    send_error(s, code, NULL);
}

static void take_packet(const ect_foe_t *foe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    const char *text = NULL;
    if (length > UINT32_MAX - t->offset) {
        refuse(foe, s, ECT_FOE_DISK_FULL);
        return;
    }
    t->packet++;
    t->finished = length < s->mailbox.out_size - ECT_MAILBOX_HEADER - HEADER;
    uint32_t code = foe->write(foe, s->config.instance, t->offset, data, length, t->finished, &text);
    t->offset += length;
    handle_result(foe, s, code, text);
}

static void data_came(const ect_foe_t *foe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    const uint32_t number = ect_load_le32(data + NUMBER);
    const bool again = number == t->packet && number != 0;
    if (t->doing != WRITING && !(again && t->finished))
        refuse(foe, s, ECT_FOE_ILLEGAL);
    else if (again && t->pending)
        wait_for_device(
            foe, s); /* after BUSY the master repeats the packet: its acknowledge follows when the device is ready */
    else if (again)
        send_number(s, ACK, number); /* the acknowledge was lost */
    else if (number == t->packet + 1 && !t->pending)
        take_packet(foe, s, data + HEADER, (uint16_t)(length - HEADER));
    else
        refuse(foe, s, ECT_FOE_PACKET_NUMBER);
}

static void ack_came(const ect_foe_t *foe, ect_slave_t *s, uint32_t number)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    const uint16_t full = (uint16_t)(ect_mailbox_room(s) - HEADER);
    if (t->doing != READING) {
        refuse(foe, s, ECT_FOE_ILLEGAL);
    } else if (number + 1 == t->packet && number != 0 && !t->pending) {
        send_packet(foe, s); /* the packet was lost */
    } else if (number != t->packet || t->pending) {
        refuse(foe, s, ECT_FOE_PACKET_NUMBER);
    } else if (t->length < full) {
        end(foe, s, true);
    } else if (t->length > UINT32_MAX - t->offset) {
        refuse(foe, s, ECT_FOE_PROGRAM_ERROR);
    } else {
        t->offset += t->length;
        t->packet++;
        send_packet(foe, s);
    }
}

uint16_t ect_foe_request(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    const ect_foe_t *foe = entry_of(self);
    ECT_ASSERT(foe->open && (foe->read || foe->write));
    if (length < HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    transfer_of(foe, s)->activity_ns = s->now_ns;
    switch (data[0]) {
    case READ:
    case WRITE:
        open_file(foe, s, data, length);
        break;
    case DATA:
        data_came(foe, s, data, length);
        break;
    case ACK:
        ack_came(foe, s, ect_load_le32(data + NUMBER));
        break;
    case ERROR: /* the master gives up and expects no reply */
        end(foe, s, false);
        break;
    default:
        refuse(foe, s, ECT_FOE_ILLEGAL);
        break;
    }
    ect_mailbox_wake(s);
    return ECT_MAILBOX_OK;
}

/* --- time --------------------------------------------------------------------------------------------------------- */

static uint64_t deadline(const ect_foe_t *foe, const ect_foe_transfer_t *t)
{
    return t->activity_ns + (foe->timeout_ms != 0 ? foe->timeout_ms : TIMEOUT_MS) * (uint64_t)MS;
}

static bool busy_due(const ect_foe_t *foe, const ect_foe_transfer_t *t, uint64_t now_ns)
{
    return foe->busy_ms != 0 && t->doing == WRITING && !t->busy_sent &&
           now_ns - t->pending_ns >= foe->busy_ms * (uint64_t)MS;
}

/* The device has not completed an operation in time. @return whether a mail was sent */
static bool finish_pending(const ect_foe_t *foe, ect_slave_t *s)
{
    ect_foe_transfer_t *t = transfer_of(foe, s);
    const char *text = NULL;
    uint32_t code = foe->ready(foe, s->config.instance, &text);
    if (code == ECT_FOE_LATER && !busy_due(foe, t, s->now_ns))
        return false;
    t->activity_ns = s->now_ns;
    if (code == ECT_FOE_LATER) {
        t->busy_sent = true; /* a repeated packet gets another one */
        send_number(s, BUSY, 0);
        return true;
    }
    t->pending = false;
    handle_result(foe, s, code, text);
    return !t->pending;
}

/* The mailbox calls this as long as a transfer is under way, and polls in time. */
bool ect_foe_next(const ect_protocol_t *self, ect_slave_t *s, bool send)
{
    const ect_foe_t *foe = entry_of(self);
    ect_foe_transfer_t *t = transfer_of(foe, s);
    bool sent = false;
    if (t->doing == IDLE)
        return false;
    if (s->now_ns >= deadline(foe, t)) {
        bool waiting = t->pending && send;
        end(foe, s, false);
        if (waiting)
            send_error(s, ECT_FOE_UNDEFINED, "time-out");
        return waiting;
    }
    if (t->pending && send)
        sent = finish_pending(foe, s);
    ect_mailbox_wake(s);
    uint64_t again_ns = t->pending ? s->now_ns + RETRY_NS : deadline(foe, t);
    if (t->doing != IDLE && again_ns < s->tick_ns)
        s->tick_ns = again_ns;
    return sent;
}

void ect_foe_reset(const ect_protocol_t *self, ect_slave_t *s)
{
    end(entry_of(self), s, false);
}
