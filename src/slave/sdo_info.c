/* SPDX-License-Identifier: MIT */
/*
 * SDO information (ETG.1000.6 §5.6.3): object lists, object and entry descriptions. A list longer than the mailbox is
 * sent in fragments, each after the master has read the one before.
 */
#include <string.h>

#include "slave/internal.h"

enum {
    LIST_REQUEST = 1,
    LIST_RESPONSE = 2,
    OBJECT_REQUEST = 3,
    OBJECT_RESPONSE = 4,
    ENTRY_REQUEST = 5,
    ENTRY_RESPONSE = 6,
    ERROR_RESPONSE = 7,
    INCOMPLETE = 0x80,
};

enum { INFO_HEADER = 4, LIST_TYPES = 5 };

/* Optional fields of an entry description. */
enum { INFO_UNIT = 0x08, INFO_DEFAULT = 0x10, INFO_MINIMUM = 0x20, INFO_MAXIMUM = 0x40 };

/* Room for data behind the information header. */
static uint16_t room(const ect_slave_t *s)
{
    return (uint16_t)(ect_coe_room(s) - INFO_HEADER);
}

static uint8_t *build(ect_slave_t *s, uint8_t opcode)
{
    uint8_t *info = ect_coe_build(s, ECT_COE_MAIL_SDO_INFO);
    info[0] = opcode;
    return info + INFO_HEADER;
}

static void send(ect_slave_t *s, uint16_t data_length)
{
    ECT_ASSERT(data_length <= room(s));
    ect_coe_send(s, (uint16_t)(ECT_COE_HEADER + INFO_HEADER + data_length));
}

static void send_error(ect_slave_t *s, ect_reason_t reason)
{
    ECT_ASSERT(reason != ECT_OK);
    uint8_t *data = build(s, ERROR_RESPONSE);
    ect_store_le32(data, ect_abort_code(reason));
    send(s, 4);
}

/* --- lists ------------------------------------------------------------------------------------------------------- */

static bool in_list(const ect_object_t *object, uint16_t list)
{
    static const uint16_t wanted[LIST_TYPES + 1] = {
        0, 0xFFFF, ECT_ACCESS_RXPDO, ECT_ACCESS_TXPDO, ECT_ACCESS_BACKUP, ECT_ACCESS_SETTING};
    if (list == 1)
        return true;
    for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
        if ((e->access & wanted[list]) != 0)
            return true;
    }
    return false;
}

static uint16_t list_length(const ect_slave_t *s, uint16_t list)
{
    uint16_t count = 0;
    for (uint16_t i = 0; i < s->od.count; i++)
        count = (uint16_t)(count + in_list(&s->od.objects[i], list));
    return count;
}

static void send_lengths(ect_slave_t *s)
{
    uint8_t *data = build(s, LIST_RESPONSE);
    for (uint16_t list = 1; list <= (uint16_t)LIST_TYPES; list++)
        ect_store_le16(data + (size_t)2 * list, list_length(s, list));
    send(s, 2 + 2 * LIST_TYPES);
}

/* Only the first fragment contains the list's type, in place of an index: the list has one element more. */
static void send_fragment(ect_slave_t *s)
{
    ect_sdo_info_t *info = &s->info;
    ECT_ASSERT(info->list >= 1 && info->list <= LIST_TYPES && info->fragments > 0);
    uint8_t *data = build(s, LIST_RESPONSE);
    uint16_t used = 0;
    if (!info->started) {
        ect_store_le16(data, info->list);
        used = 2;
        info->started = true;
    }
    while (info->next < s->od.count && used + 2 <= room(s)) {
        const ect_object_t *object = &s->od.objects[info->next++];
        if (in_list(object, info->list)) {
            ect_store_le16(data + used, object->index);
            used = (uint16_t)(used + 2);
        }
    }
    info->fragments--;
    ect_store_le16(data - 2, info->fragments);
    if (info->fragments > 0)
        data[-INFO_HEADER] |= INCOMPLETE;
    else
        info->list = 0;
    send(s, used);
}

static void start_list(ect_slave_t *s, uint16_t list)
{
    if (list > LIST_TYPES) {
        send_error(s, ECT_REASON_UNSUPPORTED);
        return;
    }
    if (list == 0) {
        send_lengths(s);
        return;
    }
    uint16_t per_fragment = room(s) / 2;
    uint16_t elements = (uint16_t)(list_length(s, list) + 1);
    ect_mailbox_wake(s);
    s->info = (ect_sdo_info_t){.list = list, .fragments = (uint16_t)((elements + per_fragment - 1) / per_fragment)};
    send_fragment(s);
}

/* --- descriptions ------------------------------------------------------------------------------------------------ */

/* The rest of the mail is the name, truncated where the mailbox ends. */
static uint16_t put_name(const ect_slave_t *s, uint8_t *data, uint16_t used, const char *name)
{
    ECT_ASSERT(used <= room(s));
    size_t length = name ? strlen(name) : 0, left = (size_t)(room(s) - used);
    length = length < left ? length : left;
    if (length > 0)
        memcpy(data + used, name, length); /* NOLINT(clang-analyzer-core.NonNullParamChecker): without a name it is 0 */
    return (uint16_t)(used + length);
}

static uint16_t object_type(const ect_object_t *object)
{
    if (object->object_code != ECT_OBJECT_RECORD)
        return ect_od_last(object)->data_type;
    uint16_t index = object->index;
    if (index == 0x1018)
        return ECT_TYPE_IDENTITY;
    if (index == 0x1C32 || index == 0x1C33)
        return ECT_TYPE_SM_SYNC;
    return (index >= 0x1600 && index < 0x1C00) ? ECT_TYPE_PDO_MAPPING : ECT_TYPE_RECORD;
}

static void describe_object(ect_slave_t *s, uint16_t index)
{
    const ect_object_t *object = ect_od_find(&s->od, index);
    if (!object) {
        send_error(s, ECT_REASON_NO_OBJECT);
        return;
    }
    uint8_t *data = build(s, OBJECT_RESPONSE);
    ect_store_le16(data, index);
    ect_store_le16(data + 2, object_type(object));
    data[4] = (uint8_t)ect_od_last(object)->subindex;
    data[5] = (uint8_t)object->object_code;
    send(s, put_name(s, data, 6, object->name));
}

/* An entry description under construction: the optional fields, in their order, if requested and if they fit. */
typedef struct description {
    uint8_t *data;
    uint16_t used;
    uint16_t room;
    uint8_t wanted;
    uint8_t given;
} description_t;

static void put_field(description_t *d, uint8_t bit, int64_t value, uint16_t size)
{
    uint8_t wire[8];
    if ((d->wanted & bit) == 0 || d->used + size > d->room)
        return;
    ect_store_le64(wire, (uint64_t)value);
    memcpy(d->data + d->used, wire, size);
    d->used = (uint16_t)(d->used + size);
    d->given |= bit;
}

/* Only numbers have them. */
static void put_details(const ect_slave_t *s, description_t *d, uint16_t index, const ect_entry_t *entry)
{
    uint16_t size = ect_od_bytes(entry);
    const ect_detail_t *detail = ect_od_detail(&s->od, index, (uint8_t)entry->subindex);
    if (detail && detail->unit != 0)
        put_field(d, INFO_UNIT, detail->unit, 2);
    if (size == 0 || size > 8 || ect_od_is_string(entry))
        return;
    int64_t initial = entry->value;
    if (detail && detail->initial) {
        uint8_t wire[8] = {0};
        memcpy(wire, detail->initial, size);
        initial = (int64_t)ect_load_le64(wire);
    }
    put_field(d, INFO_DEFAULT, initial, size);
    if (detail && detail->minimum != detail->maximum) {
        put_field(d, INFO_MINIMUM, detail->minimum, size);
        put_field(d, INFO_MAXIMUM, detail->maximum, size);
    }
}

/* A gap, a sub-index below the last one without an entry, gets an empty description, so that a scan of the object
 * continues. */
static void describe_entry(ect_slave_t *s, const uint8_t *request)
{
    static const ect_entry_t gap;
    uint16_t index = ect_load_le16(request);
    const ect_object_t *object;
    const ect_entry_t *entry;
    ect_reason_t reason = ect_od_lookup(&s->od, index, request[2], &object, &entry);
    if (reason == ECT_REASON_NO_SUBINDEX && request[2] < ect_od_last(object)->subindex) {
        reason = ECT_OK;
        entry = &gap;
    }
    if (reason != ECT_OK) {
        send_error(s, reason);
        return;
    }
    uint8_t *data = build(s, ENTRY_RESPONSE);
    description_t d = {.data = data, .used = 10, .room = room(s), .wanted = request[3], .given = request[3] & 0x07};
    put_details(s, &d, index, entry);
    memcpy(data, request, 3);
    data[3] = d.given;
    ect_store_le16(data + 4, entry->data_type);
    ect_store_le16(data + 6, ect_od_bits(&s->od, entry));
    ect_store_le16(data + 8, entry->access & ECT_ACCESS_WIRE);
    send(s, put_name(s, data, d.used, entry->name));
}

static uint16_t request(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *mail, uint16_t length)
{
    static const uint8_t shortest[] = {[LIST_REQUEST] = 2, [OBJECT_REQUEST] = 2, [ENTRY_REQUEST] = 4};
    uint16_t error = ect_coe_expect(mail, length, ECT_COE_MAIL_SDO_INFO);
    (void)self;
    if (error != ECT_MAILBOX_OK)
        return error;
    const uint8_t *info = mail + ECT_COE_HEADER;
    const uint8_t *data = info + INFO_HEADER;
    uint8_t opcode = length > ECT_COE_HEADER ? info[0] & 0x7F : 0;
    s->info.list = 0; /* a new request ends the list under way */
    ect_slave_requested(s, 0);
    if (opcode >= sizeof shortest || shortest[opcode] == 0)
        send_error(s, ECT_REASON_COMMAND);
    else if (length < ECT_COE_HEADER + INFO_HEADER + shortest[opcode])
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    else if (opcode == LIST_REQUEST)
        start_list(s, ect_load_le16(data));
    else if (opcode == OBJECT_REQUEST)
        describe_object(s, ect_load_le16(data));
    else
        describe_entry(s, data);
    return ECT_MAILBOX_OK;
}

static bool next(const ect_protocol_t *self, ect_slave_t *s, bool send)
{
    (void)self;
    if (s->info.list == 0)
        return false;
    if (send)
        send_fragment(s);
    return true;
}

static void reset(const ect_protocol_t *self, ect_slave_t *s)
{
    (void)self;
    s->info.list = 0;
}

const ect_protocol_t ect_protocol_sdo_info = {
    .type = ECT_MAILBOX_TYPE_COE, .states = ECT_IN_PREOP_AND_ABOVE, .request = request, .next = next, .reset = reset};
