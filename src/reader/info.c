/* SPDX-License-Identifier: MIT */
/* SDO information: the list of objects, and their descriptions (ETG.1000.6 clause 5.6.3). */
#include <string.h>

#include "reader/internal.h"
#include "wire/bytes.h"

enum { LIST = 1, OBJECT = 3, ENTRY = 5, FAILED = 7, OPCODE = 0x7F, INCOMPLETE = 0x80, INFO_HEADER = 4, ECHO_MOST = 3 };
enum { UNIT = 0x08, PRESET = 0x10, MINIMUM = 0x20, MAXIMUM = 0x40, ALL_INFO = 0x7F };
enum { OBJECT_NAME = 6, ENTRY_DETAILS = 10, LIST_BYTES = 2 + 2 * 0x10000 };

/* A reply repeats the first bytes of the request; a further fragment does not. */
typedef struct question {
    uint8_t opcode;
    uint8_t request[4];
    uint8_t length;
    uint8_t echo;
    bool first;
    size_t bytes; /* of the reply, in r->data as far as they fit */
    bool cut;     /* the reply fills the mailbox: its name may be truncated */
} question_t;

static bool is_reply(uint8_t service, const uint8_t *data, size_t length, const void *wanted)
{
    const question_t *q = wanted;
    if (service != COE_INFO || length < INFO_HEADER)
        return false;
    if ((data[0] & OPCODE) == FAILED)
        return true;
    if ((data[0] & OPCODE) != q->opcode + 1)
        return false;
    return !q->first ||
           (length >= (size_t)INFO_HEADER + q->echo && memcmp(data + INFO_HEADER, q->request, q->echo) == 0);
}

static ect_reader_result_t send_request(ect_reader_t *r, const question_t *q)
{
    uint8_t message[INFO_HEADER + sizeof q->request] = {q->opcode};
    memcpy(message + INFO_HEADER, q->request, q->length);
    return reader_send_coe(r, COE_INFO, message, (uint16_t)(INFO_HEADER + q->length));
}

/* One fragment. */
static ect_reader_result_t receive(ect_reader_t *r, question_t *q, const uint8_t **data, size_t *length, bool *more)
{
    if (reader_receive_coe(r, is_reply, q, data, length) != ECT_READER_OK)
        return r->result;
    *more = ((*data)[0] & INCOMPLETE) != 0;
    q->cut = q->first && MAIL_HEADER + COE_HEADER + *length >= r->in_size;
    const bool failed = ((*data)[0] & OPCODE) == FAILED;
    *data += INFO_HEADER;
    *length -= INFO_HEADER;
    if (failed) {
        r->code = *length >= 4 ? ect_load_le32(*data) : 0;
        return reader_report(r, ECT_READER_ABORTED, "no such description: SDO information error 0x%08X",
                             (unsigned int)r->code);
    }
    if (*more && *length == 0)
        return reader_report(r, ECT_READER_WRONG, "SDO information in endless fragments");
    q->first = false;
    return ECT_READER_OK;
}

/* --- list --------------------------------------------------------------------------------------------------------- */

bool reader_is_listed(const ect_reader_t *r, unsigned int index)
{
    return ((unsigned int)r->objects[index / 8] >> index % 8 & 1u) != 0;
}

static void mark(ect_reader_t *r, const uint8_t *indices, size_t length)
{
    for (size_t at = 0; at + 2 <= length; at += 2) {
        const uint16_t index = ect_load_le16(indices + at);
        r->objects[index / 8] |= (uint8_t)(1u << index % 8);
    }
}

static ect_reader_result_t list_once(ect_reader_t *r, void *what)
{
    question_t *q = what;
    bool more = true;
    size_t bytes = 0;
    memset(r->objects, 0, sizeof r->objects);
    q->first = true;
    if (send_request(r, q) != ECT_READER_OK)
        return r->result;
    while (more) {
        const uint8_t *data;
        size_t length;
        const size_t skip = bytes == 0 ? q->echo : 0;
        if (receive(r, q, &data, &length, &more) != ECT_READER_OK)
            return r->result;
        bytes += length;
        if (bytes > LIST_BYTES)
            return reader_report(r, ECT_READER_WRONG, "a list of more objects than there are indices");
        mark(r, data + skip, length - skip);
    }
    return reader_good(r);
}

ect_reader_result_t ect_reader_list(ect_reader_t *r, size_t *count)
{
    question_t q = {.opcode = LIST, .request = {1}, .length = 2, .echo = 2};
    *count = 0;
    if (ect_reader_preop(r) != ECT_READER_OK)
        return r->result;
    const ect_reader_result_t result = reader_repeat(r, list_once, &q);
    for (unsigned int index = 0; result == ECT_READER_OK && index < 0x10000; index++)
        *count += reader_is_listed(r, index);
    return result;
}

/* --- descriptions ------------------------------------------------------------------------------------------------- */

static ect_reader_result_t describe_once(ect_reader_t *r, void *what)
{
    question_t *q = what;
    bool more = true;
    q->first = true;
    q->bytes = 0;
    if (send_request(r, q) != ECT_READER_OK)
        return r->result;
    while (more) {
        const uint8_t *data;
        size_t length;
        if (receive(r, q, &data, &length, &more) != ECT_READER_OK)
            return r->result;
        if (length > sizeof r->data - q->bytes)
            return reader_report(r, ECT_READER_WRONG, "a description of more than %zu bytes", sizeof r->data);
        memcpy(r->data + q->bytes, data, length);
        q->bytes += length;
    }
    return reader_good(r);
}

static ect_reader_result_t describe(ect_reader_t *r, question_t *q, size_t least)
{
    if (ect_reader_preop(r) != ECT_READER_OK)
        return r->result;
    const ect_reader_result_t result = reader_repeat(r, describe_once, q);
    if (result == ECT_READER_OK && q->bytes < least)
        return reader_report(r, ECT_READER_WRONG, "a description of %zu bytes, at least %zu are due", q->bytes, least);
    return result;
}

static ect_reader_bytes_t name_at(const ect_reader_t *r, const question_t *q, size_t at)
{
    if (q->cut || at >= q->bytes)
        return (ect_reader_bytes_t){0};
    return (ect_reader_bytes_t){.data = r->data + at, .length = q->bytes - at};
}

ect_reader_result_t ect_reader_object(ect_reader_t *r, uint16_t index, ect_reader_object_t *object)
{
    question_t q = {.opcode = OBJECT, .request = {(uint8_t)index, (uint8_t)(index >> 8)}, .length = 2, .echo = 2};
    if (describe(r, &q, OBJECT_NAME) != ECT_READER_OK)
        return r->result;
    *object = (ect_reader_object_t){.index = index,
                                    .described = true,
                                    .type = ect_load_le16(r->data + 2),
                                    .most = r->data[4],
                                    .code = r->data[5],
                                    .name = name_at(r, &q, OBJECT_NAME)};
    return ECT_READER_OK;
}

/* The details come in the order of their bits; a detail that the mail cuts off is missing. */
static size_t take_details(const ect_reader_t *r, const question_t *q, ect_reader_entry_t *entry)
{
    const size_t bytes = ((size_t)entry->bits + 7) / 8;
    const struct {
        uint8_t bit;
        size_t size;
        ect_reader_bytes_t *to;
    } details[] = {{UNIT, 2, &entry->unit},
                   {PRESET, bytes, &entry->preset},
                   {MINIMUM, bytes, &entry->minimum},
                   {MAXIMUM, bytes, &entry->maximum}};
    size_t at = ENTRY_DETAILS;
    for (size_t i = 0; i < sizeof details / sizeof details[0]; i++) {
        if ((r->data[3] & details[i].bit) == 0 || details[i].size > q->bytes - at)
            continue;
        *details[i].to = (ect_reader_bytes_t){.data = r->data + at, .length = details[i].size};
        at += details[i].size;
    }
    return at;
}

ect_reader_result_t ect_reader_entry(ect_reader_t *r, uint16_t index, uint8_t subindex, ect_reader_entry_t *entry)
{
    question_t q = {.opcode = ENTRY,
                    .request = {(uint8_t)index, (uint8_t)(index >> 8), subindex, ALL_INFO},
                    .length = 4,
                    .echo = ECHO_MOST};
    if (describe(r, &q, ENTRY_DETAILS) != ECT_READER_OK)
        return r->result;
    *entry = (ect_reader_entry_t){.subindex = subindex,
                                  .type = ect_load_le16(r->data + 4),
                                  .bits = ect_load_le16(r->data + 6),
                                  .access = ect_load_le16(r->data + 8)};
    entry->name = name_at(r, &q, take_details(r, &q, entry));
    return ECT_READER_OK;
}
