/* SPDX-License-Identifier: MIT */
/* A strict CoE client: whole SDO transfers and the information service. The first violation of the protocol ends the
 * case; a client that repeats requests, as reader/ does, would hide violations. */
#include <string.h>

#include "steps/engine.h"

enum { COE_HEADER = 2, SDO_HEADER = 8, MAIL_HEADER = 6, SEGMENT_HEADER = 3 };
enum { COMMAND = 2, INDEX = 3, SUB = 5, VALUE = 6 }; /* offsets in a CoE mail */
enum {
    ABORT = 0x80,
    UPLOAD = 0x40,
    DOWNLOAD = 0x20,
    COMPLETE = 0x10,
    EXPEDITED = 0x02,
    SIZE_GIVEN = 0x01,
    SEGMENT_UPLOAD = 0x60,
    TOGGLE = 0x10,
    LAST = 0x01,
};
enum { INFO_HEADER = 4, INFO_ERROR = 7, INFO_LIST = 1, INCOMPLETE = 0x80 };

void cf_send_coe(cf_t *c, uint8_t service, const void *data, uint16_t length)
{
    uint8_t mail[CF_MAX_MAIL];
    ect_store_le16(mail, (uint16_t)(service << 12));
    memcpy(mail + COE_HEADER, data, length);
    cf_send_mail(c, CF_MBX_COE, mail, (uint16_t)(length + COE_HEADER));
}

static void put_header(uint8_t *at, uint8_t command, uint16_t index, uint8_t sub, uint32_t value)
{
    at[0] = command;
    ect_store_le16(at + 1, index);
    at[3] = sub;
    ect_store_le32(at + 4, value);
}

void cf_send_sdo(cf_t *c, uint8_t command, uint16_t index, uint8_t sub, uint32_t value)
{
    uint8_t request[SDO_HEADER];
    put_header(request, command, index, sub, value);
    cf_send_coe(c, CF_COE_REQUEST, request, sizeof request);
}

void cf_receive_coe(cf_t *c, cf_mail_t *mail)
{
    cf_receive(c, CF_MBX_COE, mail);
    cf_expect_that(c, mail->length >= COE_HEADER + SDO_HEADER, "length of a CoE reply: expected at least %d, got %u",
                   COE_HEADER + SDO_HEADER, mail->length);
}

static bool is_abort(const cf_mail_t *mail)
{
    return mail->data[COMMAND] == ABORT;
}

/* An abort has service 2 (SDO request) and the object of the request. */
static uint32_t abort_code(cf_t *c, const cf_mail_t *mail, uint16_t index, uint8_t sub)
{
    cf_expect(c, "CoE service of an abort", CF_COE_REQUEST, ect_load_le16(mail->data) >> 12);
    cf_expect(c, "index of an abort", index, ect_load_le16(mail->data + INDEX));
    cf_expect(c, "sub-index of an abort", sub, mail->data[SUB]);
    return ect_load_le32(mail->data + VALUE);
}

void cf_expect_abort(cf_t *c, uint16_t index, uint8_t sub, uint32_t code)
{
    cf_mail_t mail;
    cf_receive_coe(c, &mail);
    cf_expect_that(c, mail.data[COMMAND] == ABORT, "SDO command: expected 0x80 (abort 0x%08X), got 0x%02X", code,
                   mail.data[COMMAND]);
    cf_expect_range(c, "length of an abort", COE_HEADER + SDO_HEADER, COE_HEADER + SDO_HEADER, mail.length);
    uint32_t got = abort_code(c, &mail, index, sub);
    cf_expect_that(c, got == code, "abort code for %04Xh:%02X: expected 0x%08X, got 0x%08X", index, sub, code, got);
}

/* A response has service 3; the response to an initiate also has the object. */
static void check_reply(cf_t *c, const cf_mail_t *mail)
{
    cf_expect(c, "CoE service of a reply", CF_COE_RESPONSE, ect_load_le16(mail->data) >> 12);
}

static void check_object(cf_t *c, const cf_mail_t *mail, uint16_t index, uint8_t sub)
{
    cf_expect(c, "index of the reply", index, ect_load_le16(mail->data + INDEX));
    cf_expect(c, "sub-index of the reply", sub, mail->data[SUB]);
}

/* --- upload ------------------------------------------------------------------------------------------------------- */

typedef struct transfer {
    uint16_t index;
    uint8_t sub;
    uint8_t *data;
    size_t room, total, done;
} transfer_t;

static void take(cf_t *c, transfer_t *t, const uint8_t *bytes, size_t length)
{
    cf_expect_that(c, t->done + length <= t->room, "upload of %04Xh:%02X: expected at most %zu bytes, got %zu",
                   t->index, t->sub, t->room, t->done + length);
    memcpy(t->data + t->done, bytes, length);
    t->done += length;
}

/* @return 0, or the code of an abort */
static uint32_t upload_segments(cf_t *c, transfer_t *t)
{
    cf_mail_t mail;
    uint8_t toggle = 0;
    bool last = false;
    while (!last) {
        cf_send_sdo(c, SEGMENT_UPLOAD | toggle, 0, 0, 0);
        cf_receive_coe(c, &mail);
        uint8_t command = mail.data[COMMAND];
        if (is_abort(&mail))
            return abort_code(c, &mail, t->index, t->sub);
        check_reply(c, &mail);
        cf_expect_bits(c, "command and toggle of a segment", 0xF0, toggle, command);
        size_t length = mail.length - SEGMENT_HEADER;
        if (mail.length == COE_HEADER + SDO_HEADER)
            length -= (size_t)(command >> 1 & 7);
        cf_expect_that(c, length > 0 || t->done == t->total, "a segment of %04Xh:%02X is empty", t->index, t->sub);
        take(c, t, mail.data + SEGMENT_HEADER, length);
        last = (command & LAST) != 0;
        toggle ^= TOGGLE;
    }
    return 0;
}

static void check_expedited(cf_t *c, uint8_t command)
{
    cf_expect_bits(c, "complete-access bit and reserved bit of an expedited reply", 0xE0, UPLOAD, command);
    cf_expect_bits(c, "size bit of an expedited upload", SIZE_GIVEN, SIZE_GIVEN, command);
}

uint32_t cf_upload(cf_t *c, uint16_t index, uint8_t sub, bool complete, void *data, size_t *size)
{
    cf_mail_t mail;
    transfer_t t = {.index = index, .sub = sub, .data = data, .room = *size};
    cf_send_sdo(c, complete ? UPLOAD | COMPLETE : UPLOAD, index, sub, 0);
    cf_receive_coe(c, &mail);
    if (is_abort(&mail))
        return abort_code(c, &mail, index, sub);
    check_reply(c, &mail);
    check_object(c, &mail, index, sub);
    uint8_t command = mail.data[COMMAND];
    cf_expect_bits(c, "command of an upload response", 0xE0, UPLOAD, command);
    uint32_t code = 0;
    if ((command & EXPEDITED) != 0) {
        check_expedited(c, command);
        take(c, &t, mail.data + VALUE, 4u - (command >> 2 & 3u));
    } else {
        t.total = ect_load_le32(mail.data + VALUE);
        size_t here = (size_t)mail.length - COE_HEADER - SDO_HEADER;
        take(c, &t, mail.data + COE_HEADER + SDO_HEADER, here < t.total ? here : t.total);
        code = t.done < t.total ? upload_segments(c, &t) : 0;
        cf_expect_that(c, code != 0 || t.done == t.total, "upload of %04Xh:%02X: expected %zu bytes, got %zu", index,
                       sub, t.total, t.done);
    }
    *size = t.done;
    return code;
}

/* --- download ----------------------------------------------------------------------------------------------------- */

static uint32_t download_segments(cf_t *c, const transfer_t *t, size_t done)
{
    const size_t most = (size_t)c->mailbox.out_size - MAIL_HEADER - SEGMENT_HEADER;
    uint8_t toggle = 0;
    while (done < t->total) {
        uint8_t request[CF_MAX_MAIL] = {0};
        cf_mail_t mail;
        size_t part = t->total - done < most ? t->total - done : most;
        request[0] = (uint8_t)(toggle | (done + part == t->total ? LAST : 0));
        if (part < 7)
            request[0] |= (uint8_t)((7 - part) << 1);
        memcpy(request + 1, t->data + done, part);
        cf_send_coe(c, CF_COE_REQUEST, request, (uint16_t)(part < 7 ? SDO_HEADER : part + 1));
        cf_receive_coe(c, &mail);
        if (is_abort(&mail))
            return abort_code(c, &mail, t->index, t->sub);
        check_reply(c, &mail);
        cf_expect(c, "command of a download segment's reply", DOWNLOAD | toggle, mail.data[COMMAND]);
        toggle ^= TOGGLE;
        done += part;
    }
    return 0;
}

uint32_t cf_download(cf_t *c, uint16_t index, uint8_t sub, bool complete, const void *data, size_t size)
{
    uint8_t request[CF_MAX_MAIL] = {0};
    cf_mail_t mail;
    const size_t most = (size_t)c->mailbox.out_size - MAIL_HEADER - COE_HEADER - SDO_HEADER;
    const uint8_t base = complete ? DOWNLOAD | COMPLETE : DOWNLOAD;
    size_t here = 0;
    if (size >= 1 && size <= 4) {
        put_header(request, (uint8_t)(base | EXPEDITED | SIZE_GIVEN | (4 - size) << 2), index, sub, 0);
        memcpy(request + 4, data, size);
    } else {
        put_header(request, base | SIZE_GIVEN, index, sub, (uint32_t)size);
        here = size < most ? size : most;
        memcpy(request + SDO_HEADER, data, here);
    }
    cf_send_coe(c, CF_COE_REQUEST, request, (uint16_t)(SDO_HEADER + here));
    cf_receive_coe(c, &mail);
    if (is_abort(&mail))
        return abort_code(c, &mail, index, sub);
    check_reply(c, &mail);
    check_object(c, &mail, index, sub);
    cf_expect_bits(c, "command of a download's reply", 0xE0, 0x60, mail.data[COMMAND]);
    const transfer_t t = {.index = index, .sub = sub, .data = (uint8_t *)(uintptr_t)data, .total = size};
    return size > 4 && here < size ? download_segments(c, &t, here) : 0;
}

uint32_t cf_change(cf_t *c, uint16_t index, uint8_t sub, const void *data, size_t size)
{
    cf_undo_t old = {.index = index, .sub = sub};
    size_t old_size = sizeof old.data;
    uint32_t code = cf_upload(c, index, sub, false, old.data, &old_size);
    if (code != 0)
        return code;
    old.size = (uint8_t)old_size;
    code = cf_download(c, index, sub, false, data, size);
    if (code == 0)
        *cf_new_undo(c) = old;
    return code;
}

uint64_t cf_upload_number(cf_t *c, uint16_t index, uint8_t sub)
{
    uint8_t bytes[8] = {0};
    size_t size = sizeof bytes;
    uint32_t code = cf_upload(c, index, sub, false, bytes, &size);
    cf_expect_that(c, code == 0, "upload of %04Xh:%02X: expected data, got abort 0x%08X", index, sub, code);
    return ect_load_le64(bytes);
}

bool cf_object_exists(cf_t *c, uint16_t index, uint8_t sub, uint32_t *code)
{
    static uint8_t data[65536]; /* discarded */
    size_t size = sizeof data;
    *code = cf_upload(c, index, sub, false, data, &size);
    return *code == 0;
}

/* --- information -------------------------------------------------------------------------------------------------- */

int cf_info(cf_t *c, uint8_t opcode, const void *request, uint16_t request_length, void *data, size_t room,
            uint32_t *code)
{
    uint8_t mail_out[64] = {opcode};
    cf_mail_t mail;
    size_t done = 0;
    unsigned int left = 0;
    bool first = true, more = true;
    memcpy(mail_out + INFO_HEADER, request, request_length);
    cf_send_coe(c, CF_COE_INFO, mail_out, (uint16_t)(INFO_HEADER + request_length));
    while (more) {
        cf_receive(c, CF_MBX_COE, &mail);
        cf_expect_that(c, mail.length >= COE_HEADER + INFO_HEADER, "an information reply of %u bytes", mail.length);
        cf_expect(c, "CoE service of an information reply", CF_COE_INFO, ect_load_le16(mail.data) >> 12);
        uint8_t got = mail.data[COE_HEADER] & 0x7F;
        const uint8_t *body = mail.data + COE_HEADER + INFO_HEADER;
        size_t length = (size_t)mail.length - COE_HEADER - INFO_HEADER;
        if (got == INFO_ERROR) {
            *code = length >= 4 ? ect_load_le32(body) : 0;
            return -1;
        }
        cf_expect(c, "opcode of an information reply", opcode + 1u, got);
        unsigned int now_left = ect_load_le16(mail.data + COE_HEADER + 2);
        if (!first)
            cf_expect_range(c, "fragments left", left - 1, left - 1, now_left);
        more = (mail.data[COE_HEADER] & INCOMPLETE) != 0;
        cf_expect_that(c, more == (now_left != 0), "the incomplete bit is %d with %u fragments left", more, now_left);
        cf_expect_that(c, done + length <= room, "an information reply of more than %zu bytes", room);
        memcpy((uint8_t *)data + done, body, length);
        done += length;
        left = now_left;
        first = false;
    }
    *code = 0;
    return (int)done;
}

size_t cf_object_list(cf_t *c, uint16_t type, uint16_t *indices, size_t room)
{
    static uint8_t data[2 + 2 * 65536];
    uint8_t request[2];
    uint32_t code;
    ect_store_le16(request, type);
    int bytes = cf_info(c, INFO_LIST, request, sizeof request, data, sizeof data, &code);
    cf_expect_that(c, bytes >= 2, "list %u: expected indices, got an info error 0x%08X", type, code);
    cf_expect(c, "type of the list", type, ect_load_le16(data));
    size_t count = (size_t)(bytes - 2) / 2;
    for (size_t i = 0; i < count && i < room; i++)
        indices[i] = ect_load_le16(data + 2 + 2 * i);
    return count < room ? count : room;
}
