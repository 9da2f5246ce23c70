/* SPDX-License-Identifier: MIT */
/* SDO upload: expedited, normal, segmented (ETG.1000.6 clause 5.6.2.2 and 5.6.2.3). */
#include <string.h>

#include "reader/internal.h"
#include "wire/bytes.h"

enum { UPLOAD = 0x40, COMPLETE = 0x10, SEGMENT = 0x60, TOGGLE = 0x10, ABORT = 0x80 };
enum { REPLY_UPLOAD = 2, REPLY_SEGMENT = 0, EXPEDITED = 0x02, SIZE_GIVEN = 0x01, LAST = 0x01 };
enum { SDO_HEADER = 4, SDO_REQUEST = 8, SHORT_SEGMENT = 7 };
#define ABORT_TOGGLE    UINT32_C(0x05030000)
#define ABORT_NO_MEMORY UINT32_C(0x05040005)
#define ABORT_GENERAL   UINT32_C(0x08000000)

typedef struct transfer {
    uint16_t index;
    uint8_t subindex;
    bool complete;
    uint8_t *data;
    size_t room;
    size_t size; /* announced */
    size_t done;
    uint8_t reply; /* expected reply, REPLY_... */
} transfer_t;

static bool is_of_object(const transfer_t *t, const uint8_t *data)
{
    return ect_load_le16(data + 1) == t->index && (t->complete || data[3] == t->subindex);
}

static bool is_reply(uint8_t service, const uint8_t *data, size_t length, const void *wanted)
{
    const transfer_t *t = wanted;
    if (length >= SDO_REQUEST && data[0] == ABORT)
        return (service == COE_REQUEST || service == COE_RESPONSE) && is_of_object(t, data);
    if (service != COE_RESPONSE || length < 1 || data[0] >> 5 != t->reply)
        return false;
    return t->reply == REPLY_SEGMENT || (length >= SDO_REQUEST && is_of_object(t, data));
}

static ect_reader_result_t send(ect_reader_t *r, const transfer_t *t, uint8_t command, uint32_t value)
{
    uint8_t request[SDO_REQUEST] = {command};
    ect_store_le16(request + 1, t->index);
    request[3] = t->subindex;
    ect_store_le32(request + SDO_HEADER, value);
    return reader_send_coe(r, COE_REQUEST, request, sizeof request);
}

/* Ends the transfer at the slave too, which would otherwise wait for the next segment request. */
static ect_reader_result_t give_up(ect_reader_t *r, const transfer_t *t, uint32_t code, ect_reader_result_t result,
                                   const char *why)
{
    if (send(r, t, ABORT, code) == ECT_READER_LOST)
        return r->result;
    return reader_report(r, result, "%04X:%02X: %s", t->index, t->subindex, why);
}

static ect_reader_result_t receive(ect_reader_t *r, const transfer_t *t, const uint8_t **data, size_t *length)
{
    if (reader_receive_coe(r, is_reply, t, data, length) != ECT_READER_OK)
        return r->result;
    if ((*data)[0] != ABORT)
        return ECT_READER_OK;
    r->code = ect_load_le32(*data + SDO_HEADER);
    return reader_report(r, ECT_READER_ABORTED, "%04X:%02X: the slave aborts with 0x%08X", t->index, t->subindex,
                         (unsigned int)r->code);
}

static ect_reader_result_t take_segment(ect_reader_t *r, transfer_t *t, unsigned int toggle, bool *more)
{
    const uint8_t *data;
    size_t length;
    if (send(r, t, (uint8_t)(SEGMENT | toggle), 0) != ECT_READER_OK || receive(r, t, &data, &length) != ECT_READER_OK)
        return r->result;
    size_t bytes = length - 1;
    if (bytes == SHORT_SEGMENT)
        bytes -= data[0] >> 1 & 7;
    *more = (data[0] & LAST) == 0;
    if ((data[0] & TOGGLE) != toggle)
        return give_up(r, t, ABORT_TOGGLE, ECT_READER_WRONG, "a segment with the wrong toggle bit");
    if (bytes > t->size - t->done)
        return give_up(r, t, ABORT_GENERAL, ECT_READER_WRONG, "more bytes in the segments than announced");
    memcpy(t->data + t->done, data + 1, bytes);
    t->done += bytes;
    if (*more && (bytes == 0 || t->done == t->size))
        return give_up(r, t, ABORT_GENERAL, ECT_READER_WRONG, "endless segments");
    return ECT_READER_OK;
}

static ect_reader_result_t take_segments(ect_reader_t *r, transfer_t *t)
{
    unsigned int toggle = 0;
    t->reply = REPLY_SEGMENT;
    for (bool more = true; more; toggle ^= TOGGLE) {
        if (take_segment(r, t, toggle, &more) != ECT_READER_OK)
            return r->result;
    }
    return reader_good(r);
}

static ect_reader_result_t take_expedited(ect_reader_t *r, transfer_t *t, const uint8_t *data)
{
    const size_t bytes = (data[0] & SIZE_GIVEN) != 0 ? 4u - (data[0] >> 2 & 3) : 4u;
    t->size = bytes;
    if (bytes > t->room)
        return reader_report(r, ECT_READER_TOO_LONG, "%04X:%02X: its %zu bytes exceed %zu", t->index, t->subindex,
                             bytes, t->room);
    memcpy(t->data, data + SDO_HEADER, bytes);
    t->done = bytes;
    return reader_good(r);
}

static ect_reader_result_t upload_once(ect_reader_t *r, void *what)
{
    transfer_t *t = what;
    const uint8_t *data;
    size_t length;
    t->size = t->done = 0;
    t->reply = REPLY_UPLOAD;
    if (send(r, t, (uint8_t)(t->complete ? UPLOAD | COMPLETE : UPLOAD), 0) != ECT_READER_OK ||
        receive(r, t, &data, &length) != ECT_READER_OK)
        return r->result;
    if ((data[0] & EXPEDITED) != 0)
        return take_expedited(r, t, data);
    t->size = ect_load_le32(data + SDO_HEADER);
    if (t->size > t->room)
        return give_up(r, t, ABORT_NO_MEMORY, ECT_READER_TOO_LONG, "longer than the buffer");
    const size_t here = length - SDO_REQUEST < t->size ? length - SDO_REQUEST : t->size;
    memcpy(t->data, data + SDO_REQUEST, here);
    t->done = here;
    return t->done < t->size ? take_segments(r, t) : reader_good(r);
}

ect_reader_result_t ect_reader_upload(ect_reader_t *r, uint16_t index, uint8_t subindex, bool complete, void *data,
                                      size_t *size)
{
    transfer_t t = {.index = index, .subindex = subindex, .complete = complete, .data = data, .room = *size};
    *size = 0;
    if (ect_reader_preop(r) != ECT_READER_OK)
        return r->result;
    const ect_reader_result_t result = reader_repeat(r, upload_once, &t);
    *size = result == ECT_READER_TOO_LONG ? t.size : t.done;
    return result;
}
