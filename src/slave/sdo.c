/* SPDX-License-Identifier: MIT */
/*
 * The SDO server (ETG.1000.6 §5.6.2): expedited, normal and segmented transfers of single entries and whole objects.
 *
 * One cursor moves through the transferred data, entry by entry, in the packed form of Complete Access; a single entry
 * is an object with one stop. No buffer of the object's size is needed: a segment is filled from, or written to, the
 * dictionary itself. Only a value that arrives in pieces is collected, to be checked as a whole before it is stored.
 */
#include <string.h>

#include "slave/internal.h"

/* Command byte (ETG.1000.6 Table 33 ff.). */
enum {
    SPECIFIER = 0xE0,
    DOWNLOAD_SEGMENT = 0x00,
    DOWNLOAD = 0x20,
    UPLOAD = 0x40,
    UPLOAD_SEGMENT = 0x60,
    ABORT = 0x80,
    COMPLETE = 0x10,
    TOGGLE = 0x10,
    EXPEDITED = 0x02,
    SIZE_SPECIFIED = 0x01,
    LAST_SEGMENT = 0x01,
};

/* Functions that CoE and the accesses of other protocols share are part of each caller: a device without the latter has
 * no code for them. */
#define SHARED static inline __attribute__((always_inline))

enum { INITIATE = 8 /* command, index, sub-index, 4 bytes */, EXPEDITED_ROOM = 4, SEGMENT_MINIMUM = 7 };

/* --- the cursor -------------------------------------------------------------------------------------------------- */

/* The highest sub-index that sub-index 0 declares present: Complete Access transfers nothing beyond it. In a sparse
 * record of a SOES list, sub-index 0 may count the elements instead; then all of them are present. */
static uint8_t present(const ect_slave_t *s, const ect_object_t *object)
{
    if (object->object_code == ECT_OBJECT_VAR || object->entries->subindex != 0)
        return UINT8_MAX;
    uint8_t declared;
    ect_od_read(&s->od, object->entries, 0, &declared, 1);
    return declared < object->max_subindex ? declared : UINT8_MAX;
}

static void cursor_begin(ect_slave_t *s, const ect_entry_t *first)
{
    ECT_ASSERT(s->sdo.object != NULL);
    s->sdo.cursor = (ect_sdo_cursor_t){.entry = first};
}

static bool has_pad(const ect_sdo_t *sdo, const ect_entry_t *entry)
{
    return sdo->complete && entry->subindex == 0 && sdo->object->object_code != ECT_OBJECT_VAR;
}

static void cursor_next(ect_sdo_t *sdo, uint8_t last_subindex)
{
    ect_sdo_cursor_t *c = &sdo->cursor;
    c->pad = has_pad(sdo, c->entry);
    c->offset = 0;
    c->entry = sdo->complete ? ect_od_next(sdo->object, c->entry) : NULL;
    if (c->entry && c->entry->subindex > last_subindex)
        c->entry = NULL;
}

/* Bytes of the packed form, from the first entry to the last present one. */
static uint32_t packed_size(const ect_slave_t *s, const ect_entry_t *first, uint8_t last_subindex)
{
    const ect_sdo_t *sdo = &s->sdo;
    uint32_t bits = 0;
    for (const ect_entry_t *e = first; e && e->subindex <= last_subindex; e = ect_od_next(sdo->object, e)) {
        if (!ect_od_is_bits(e))
            bits = (bits + 7u) & ~7u;
        bits += ect_od_is_bits(e) ? e->bit_length : ect_od_bytes(e) * 8u;
        bits += has_pad(sdo, e) ? 8u : 0u;
    }
    return (bits + 7u) / 8u;
}

static bool readable(const ect_slave_t *s, const ect_entry_t *entry)
{
    return ect_od_check_access(entry, ECT_UPLOAD, s->state) == ECT_OK;
}

/* Inside a whole object, an entry without read access in this state reads as zero. */
static void read_entry(const ect_slave_t *s, const ect_entry_t *entry, uint16_t offset, uint8_t *to, uint16_t length)
{
    if (s->sdo.instead.data)
        memcpy(to, (const uint8_t *)s->sdo.instead.data + offset, length);
    else if (readable(s, entry))
        ect_od_read(&s->od, entry, offset, to, length);
    else
        memset(to, 0, length);
}

static uint16_t entry_size(const ect_slave_t *s, const ect_entry_t *entry)
{
    if (s->sdo.instead.data)
        return s->sdo.instead.size;
    return s->sdo.complete ? ect_od_bytes(entry) : ect_od_upload_size(&s->od, entry);
}

/* Collects bit entries until a byte is full. @return whether a byte was stored */
static bool gather_bits(const ect_slave_t *s, ect_sdo_cursor_t *c, uint8_t *to)
{
    uint8_t value = 0;
    read_entry(s, c->entry, 0, &value, 1);
    c->byte |= (uint32_t)value << c->bits;
    c->bits += c->entry->bit_length;
    if (c->bits < 8)
        return false;
    *to = (uint8_t)c->byte;
    c->byte >>= 8;
    c->bits -= 8;
    return true;
}

static bool flush_bits(ect_sdo_cursor_t *c, uint8_t *to)
{
    if (c->bits == 0)
        return false;
    *to = (uint8_t)c->byte;
    c->byte = 0;
    c->bits = 0;
    return true;
}

/* Bytes of the entry at the cursor, as many as fit. @return their number */
static uint16_t read_piece(const ect_slave_t *s, ect_sdo_cursor_t *c, uint8_t *to, uint16_t room)
{
    uint16_t size = entry_size(s, c->entry);
    ECT_ASSERT(room > 0);
    uint16_t left = size > c->offset ? (uint16_t)(size - c->offset) : 0;
    uint16_t piece = left < room ? left : room;
    read_entry(s, c->entry, c->offset, to, piece);
    c->offset = (uint16_t)(c->offset + piece);
    return piece;
}

/* One step of an upload: at most `room` (1 or more) bytes, possibly none. @return their number */
static uint16_t read_step(ect_slave_t *s, uint8_t *to, uint16_t room, uint8_t last_subindex)
{
    ect_sdo_cursor_t *c = &s->sdo.cursor;
    ECT_ASSERT(room > 0 && c->bits < 8);
    if (c->pad) {
        *to = 0;
        c->pad = false;
        return 1;
    }
    if (!c->entry) {
        (void)flush_bits(c,
                         to); /* then zeros: the object has become shorter meanwhile, but the announced size remains */
        return room;
    }
    bool bits = s->sdo.complete && ect_od_is_bits(c->entry);
    if (!bits && flush_bits(c, to))
        return 1;
    uint16_t done = bits ? gather_bits(s, c, to) : read_piece(s, c, to, room);
    if (bits || c->offset >= entry_size(s, c->entry))
        cursor_next(&s->sdo, last_subindex);
    return done;
}

/* Fills `to`, which is all 0, with the next `length` bytes; at most as many as are left. */
static void cursor_read(ect_slave_t *s, uint8_t *to, uint16_t length, uint8_t last_subindex)
{
    const uint8_t *end = to + length;
    while (to < end)
        to += read_step(s, to, (uint16_t)(end - to), last_subindex);
}

/* --- replies ----------------------------------------------------------------------------------------------------- */

static void send_abort(ect_slave_t *s, uint16_t index, uint8_t subindex, ect_reason_t reason)
{
    ECT_ASSERT(reason != ECT_OK);
    s->sdo.state = ECT_SDO_IDLE;
    uint8_t *reply = ect_coe_build(s, ECT_COE_MAIL_SDO_REQUEST);
    reply[0] = ABORT;
    ect_store_le16(reply + 1, index);
    reply[3] = subindex;
    ect_store_le32(reply + 4, ect_abort_code(reason));
    ect_coe_send(s, ECT_SDO_LENGTH);
}

static uint8_t *build_response(ect_slave_t *s, uint8_t command)
{
    uint8_t *reply = ect_coe_build(s, ECT_COE_MAIL_SDO_RESPONSE);
    reply[0] = command;
    return reply;
}

static uint8_t *build_initiate(ect_slave_t *s, unsigned int command)
{
    const ect_sdo_t *sdo = &s->sdo;
    ECT_ASSERT(sdo->object != NULL);
    uint8_t *reply = build_response(s, (uint8_t)(command | (sdo->complete ? (unsigned int)COMPLETE : 0u)));
    ect_store_le16(reply + 1, sdo->object->index);
    reply[3] = sdo->subindex;
    return reply;
}

/* --- addressing -------------------------------------------------------------------------------------------------- */

/* A whole object: one accessible entry is enough, but no entry may have variable length. */
static ect_reason_t open_complete(const ect_slave_t *s, ect_direction_t direction, const ect_entry_t **first)
{
    const ect_object_t *object = s->sdo.object;
    ect_reason_t verdict = ECT_REASON_UNSUPPORTED;
    bool allowed = false;
    if (s->sdo.subindex > 1)
        return ECT_REASON_UNSUPPORTED;
    for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
        if (ect_od_is_string(e) || e->bit_length == 0)
            return ECT_REASON_VARIABLE_LENGTH;
        ect_reason_t reason = ect_od_check_access(e, direction, s->state);
        allowed |= reason == ECT_OK;
        if (verdict != ECT_REASON_STATE)
            verdict = reason;
    }
    if (!allowed)
        return verdict;
    *first = object->entries;
    if (s->sdo.subindex == 1 && object->entries->subindex == 0)
        *first = ect_od_next(object, object->entries);
    return *first ? ECT_OK : ECT_REASON_NO_SUBINDEX;
}

/* Opens a transfer with the address of an initiate request; ends the transfer under way, if any. */
static ect_reason_t open_transfer(ect_slave_t *s, const uint8_t *request, ect_direction_t direction,
                                  const ect_entry_t **first)
{
    uint16_t index = ect_load_le16(request + 1);
    ect_sdo_t *sdo = &s->sdo;
    const ect_device_t *device = s->config.device;
    *sdo = (ect_sdo_t){.state = ECT_SDO_IDLE, .subindex = request[3], .complete = (request[0] & COMPLETE) != 0};
    ect_slave_requested(s, index);
    ect_reason_t reason =
        device->sdo_request ? device->sdo_request(s->config.instance, index, sdo->subindex) : (ect_reason_t)ECT_OK;
    if (reason != ECT_OK)
        return reason;
    sdo->object = ect_od_find(&s->od, index);
    if (!sdo->object)
        return ECT_REASON_NO_OBJECT;
    if (sdo->complete) {
        if ((device->coe_details & ECT_COE_COMPLETE_ACCESS) == 0)
            return ECT_REASON_UNSUPPORTED;
        return open_complete(s, direction, first);
    }
    *first = ect_od_entry(sdo->object, sdo->subindex);
    if (!*first)
        return ECT_REASON_NO_SUBINDEX;
    return ect_od_check_access(*first, direction, s->state);
}

/* --- upload ------------------------------------------------------------------------------------------------------ */

static uint8_t last_of(const ect_slave_t *s)
{
    return s->sdo.complete ? present(s, s->sdo.object) : s->sdo.subindex;
}

/* The device may refuse, or supply other bytes. */
SHARED ect_reason_t call_sdo_read(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    ect_sdo_t *sdo = &s->sdo;
    if (!device->sdo_read)
        return ECT_OK;
    return device->sdo_read(s->config.instance, sdo->object->index,
                            sdo->complete ? (uint16_t)ECT_WHOLE_OBJECT : sdo->subindex,
                            sdo->complete ? NULL : &sdo->instead);
}

static void send_expedited(ect_slave_t *s, uint8_t last_subindex)
{
    ECT_ASSERT(s->sdo.size > 0 && s->sdo.size <= EXPEDITED_ROOM);
    unsigned int unused = EXPEDITED_ROOM - (unsigned int)s->sdo.size;
    uint8_t *reply = build_initiate(s, UPLOAD | EXPEDITED | SIZE_SPECIFIED | (unused << 2));
    cursor_read(s, reply + 4, (uint16_t)s->sdo.size, last_subindex);
    ect_coe_send(s, ECT_SDO_LENGTH);
}

/* Opens an upload; the cursor is then at its first byte, `last` the last sub-index. */
SHARED ect_reason_t open_upload(ect_slave_t *s, const uint8_t *request, uint8_t *last)
{
    ect_sdo_t *sdo = &s->sdo;
    const ect_entry_t *first = NULL;
    ect_reason_t reason = open_transfer(s, request, ECT_UPLOAD, &first);
    if (reason == ECT_OK)
        reason = call_sdo_read(s);
    if (reason != ECT_OK)
        return reason;
    *last = last_of(s);
    sdo->size = sdo->complete ? packed_size(s, first, *last) : entry_size(s, first);
    cursor_begin(s, first->subindex <= *last ? first : NULL);
    return ECT_OK;
}

static void upload(ect_slave_t *s, const uint8_t *request)
{
    ect_sdo_t *sdo = &s->sdo;
    uint8_t last = 0;
    ect_reason_t reason = open_upload(s, request, &last);
    if (reason != ECT_OK) {
        send_abort(s, ect_load_le16(request + 1), request[3], reason);
        return;
    }
    if (sdo->size > 0 && sdo->size <= EXPEDITED_ROOM) {
        send_expedited(s, last);
        return;
    }
    uint16_t room = (uint16_t)(ect_coe_room(s) - INITIATE);
    uint16_t piece = sdo->size < room ? (uint16_t)sdo->size : room;
    uint8_t *reply = build_initiate(s, UPLOAD | SIZE_SPECIFIED);
    ect_store_le32(reply + 4, sdo->size);
    cursor_read(s, reply + INITIATE, piece, last);
    sdo->done = piece;
    sdo->state = sdo->done < sdo->size ? ECT_SDO_UPLOADING : ECT_SDO_IDLE;
    ect_coe_send(s, (uint16_t)(ECT_SDO_LENGTH + piece));
}

/* A segment must belong to a transfer in this direction, and its toggle bit must alternate. */
static bool segment_expected(ect_slave_t *s, const uint8_t *request, uint8_t state)
{
    ect_sdo_t *sdo = &s->sdo;
    ECT_ASSERT(sdo->state <= ECT_SDO_DOWNLOADING);
    bool active = sdo->state != ECT_SDO_IDLE;
    if (sdo->state == state && (request[0] & TOGGLE) == sdo->toggle) {
        sdo->toggle ^= TOGGLE;
        return true;
    }
    send_abort(s, active ? sdo->object->index : 0, active ? sdo->subindex : 0,
               sdo->state == state ? ECT_REASON_TOGGLE : ECT_REASON_COMMAND);
    return false;
}

static void upload_segment(ect_slave_t *s, const uint8_t *request)
{
    ect_sdo_t *sdo = &s->sdo;
    if (!segment_expected(s, request, ECT_SDO_UPLOADING))
        return;
    uint16_t room = (uint16_t)(ect_coe_room(s) - 1);
    uint32_t left = sdo->size - sdo->done;
    ECT_ASSERT(sdo->object && sdo->done < sdo->size);
    uint16_t piece = left < room ? (uint16_t)left : room;
    unsigned int command = request[0] & TOGGLE;
    command |= piece == left ? (unsigned int)LAST_SEGMENT : 0u;
    command |= piece < SEGMENT_MINIMUM ? (SEGMENT_MINIMUM - (unsigned int)piece) << 1 : 0u;
    uint8_t *reply = build_response(s, (uint8_t)command);
    cursor_read(s, reply + 1, piece, last_of(s));
    sdo->done += piece;
    if (piece == left)
        sdo->state = ECT_SDO_IDLE;
    uint16_t payload = piece < SEGMENT_MINIMUM ? SEGMENT_MINIMUM : piece;
    ect_coe_send(s, (uint16_t)(ECT_COE_HEADER + 1 + payload));
}

/* --- download ---------------------------------------------------------------------------------------------------- */

static bool writable(const ect_slave_t *s, const ect_entry_t *entry)
{
    return ect_od_check_access(entry, ECT_DOWNLOAD, s->state) == ECT_OK;
}

/* Checks limits, then calls services and device. */
static ect_reason_t check_value(ect_slave_t *s, const ect_entry_t *entry, const uint8_t *data, uint16_t size)
{
    const ect_device_t *device = s->config.device;
    uint16_t index = s->sdo.object->index;
    if (size == ect_od_bytes(entry)) {
        ect_reason_t reason = ect_od_check_limit(&s->od, index, entry, data);
        if (reason != ECT_OK)
            return reason;
    }
    const ect_download_t download = {index, (uint8_t)entry->subindex, s->sdo.complete, data, size};
    ect_reason_t reason = ect_services_write(s, &download);
    if (reason != ECT_OK || !device->sdo_write)
        return reason;
    return device->sdo_write(s->config.instance, index, (uint8_t)entry->subindex, data, size);
}

static ect_reason_t written(ect_slave_t *s, const ect_entry_t *entry)
{
    const ect_device_t *device = s->config.device;
    uint16_t index = s->sdo.object->index;
    if (device->sdo_written)
        device->sdo_written(s->config.instance, index, (uint8_t)entry->subindex, s->now_ns);
    ect_slave_wake(s);
    return s->sdo.complete ? ECT_OK : ect_services_written(s, index, (uint8_t)entry->subindex, false);
}

static ect_reason_t whole_written(ect_slave_t *s)
{
    ECT_ASSERT(s->sdo.object != NULL);
    return s->sdo.complete ? ect_services_written(s, s->sdo.object->index, 0, true) : ECT_OK;
}

static ect_reason_t store_value(ect_slave_t *s, const ect_entry_t *entry, const uint8_t *data, uint16_t size,
                                bool only_check)
{
    if (!writable(s,
                  entry)) /* skipped inside a whole object; alone, the state has changed since the initiate request */
        return s->sdo.complete ? ECT_OK : ECT_REASON_STATE;
    ect_reason_t reason = check_value(s, entry, data, size);
    if (reason != ECT_OK || only_check)
        return reason;
    if ((entry->access & ECT_ACCESS_COMMAND) == 0)
        reason = ect_od_write(&s->od, entry, 0, data, size);
    return reason == ECT_OK ? written(s, entry) : reason;
}

/* Takes bits of bit entries from the byte in the cursor. */
static ect_reason_t take_bits(ect_slave_t *s, bool only_check)
{
    ect_sdo_cursor_t *c = &s->sdo.cursor;
    uint8_t value = (uint8_t)(c->byte & ((1u << c->entry->bit_length) - 1u));
    c->byte >>= c->entry->bit_length;
    c->bits -= c->entry->bit_length;
    ect_reason_t reason = store_value(s, c->entry, &value, 1, only_check);
    cursor_next(&s->sdo, UINT8_MAX);
    return reason;
}

/* One step of a download into the entry at the cursor; consumes at least a byte, or finishes bit entries. */
static ect_reason_t download_step(ect_slave_t *s, const uint8_t **from, const uint8_t *end, bool only_check)
{
    ect_sdo_t *sdo = &s->sdo;
    ect_sdo_cursor_t *c = &sdo->cursor;
    const ect_entry_t *entry = c->entry;
    ECT_ASSERT(entry && *from < end);
    const uint8_t *value = *from;
    uint16_t total = sdo->complete ? ect_od_bytes(entry) : (uint16_t)sdo->size;
    uint16_t left = (uint16_t)(total - c->offset);
    uint16_t piece = left < end - *from ? left : (uint16_t)(end - *from);
    if (piece < total && writable(s, entry)) {
        if (total > s->config.staging_size)
            return ECT_REASON_MEMORY;
        memcpy(s->config.staging + c->offset, value, piece);
        value = s->config.staging;
    }
    *from += piece;
    c->offset = (uint16_t)(c->offset + piece);
    if (piece < left)
        return ECT_OK;
    cursor_next(sdo, UINT8_MAX);
    return store_value(s, entry, value, total, only_check);
}

/* Whether the byte in the cursor contains all bits of the next bit entry. */
static bool has_bits(const ect_sdo_cursor_t *c)
{
    return c->entry && c->bits > 0 && c->bits >= c->entry->bit_length;
}

/* One step of a download: at least a byte, or a bit entry out of the byte in the cursor. */
static ect_reason_t write_step(ect_slave_t *s, const uint8_t **from, const uint8_t *end, bool only_check)
{
    ect_sdo_cursor_t *c = &s->sdo.cursor;
    if (c->pad) {
        (*from)++;
        c->pad = false;
        return ECT_OK;
    }
    if (!c->entry)
        return ECT_REASON_TOO_LONG;
    if (!s->sdo.complete || !ect_od_is_bits(c->entry)) {
        c->bits = c->byte = 0;
        return download_step(s, from, end, only_check);
    }
    if (has_bits(c))
        return take_bits(s, only_check);
    c->byte |= (uint32_t)*(*from)++ << c->bits;
    c->bits += 8;
    return ECT_OK;
}

/* Writes `length` bytes to the dictionary, or only checks them. */
static ect_reason_t cursor_write(ect_slave_t *s, const uint8_t *from, uint16_t length, bool only_check)
{
    const uint8_t *end = from + length;
    ect_reason_t reason = ECT_OK;
    while (reason == ECT_OK && (from < end || has_bits(&s->sdo.cursor)))
        reason = write_step(s, &from, end, only_check);
    return reason;
}

/* The announced length of a download must fit; a whole object may be shorter, by whole entries. */
SHARED ect_reason_t check_size(ect_slave_t *s, const ect_entry_t *first)
{
    ect_sdo_t *sdo = &s->sdo;
    uint32_t room = sdo->complete ? packed_size(s, first, UINT8_MAX) : (uint32_t)ect_od_bytes(first);
    if (sdo->size > room)
        return ECT_REASON_TOO_LONG;
    bool may_be_short = sdo->complete || ect_od_is_string(first);
    return sdo->size < room && (!may_be_short || sdo->size == 0) ? ECT_REASON_TOO_SHORT : ECT_OK;
}

SHARED ect_reason_t store_whole(ect_slave_t *s, const ect_entry_t *first, const uint8_t *data)
{
    uint16_t size = (uint16_t)s->sdo.size;
    cursor_begin(s, first);
    ect_reason_t reason = cursor_write(s, data, size, true);
    if (reason == ECT_OK && s->sdo.cursor.offset != 0)
        reason = ECT_REASON_TOO_SHORT; /* ends inside an entry */
    if (reason != ECT_OK)
        return reason;
    cursor_begin(s, first);
    reason = cursor_write(s, data, size, false);
    return reason == ECT_OK ? whole_written(s) : reason;
}

static void finish_download(ect_slave_t *s, ect_reason_t reason, bool initiate, unsigned int command)
{
    ECT_ASSERT(s->sdo.object != NULL);
    if (reason != ECT_OK) {
        send_abort(s, s->sdo.object->index, s->sdo.subindex, reason);
        return;
    }
    if (initiate)
        (void)build_initiate(s, command);
    else
        (void)build_response(s, (uint8_t)command);
    ect_coe_send(s, ECT_SDO_LENGTH);
}

static void download(ect_slave_t *s, const uint8_t *request, uint16_t length)
{
    ect_sdo_t *sdo = &s->sdo;
    const ect_entry_t *first = NULL;
    ect_reason_t reason = open_transfer(s, request, ECT_DOWNLOAD, &first);
    if (reason != ECT_OK) {
        send_abort(s, ect_load_le16(request + 1), request[3], reason);
        return;
    }
    const uint8_t *data = request + INITIATE;
    uint16_t available = (uint16_t)(length - INITIATE);
    sdo->size = ect_load_le32(request + 4);
    if ((request[0] & EXPEDITED) != 0) {
        data = request + 4;
        available = EXPEDITED_ROOM;
        sdo->size = EXPEDITED_ROOM - ((request[0] >> 2) & 3u);
        if ((request[0] & SIZE_SPECIFIED) == 0 && ect_od_bytes(first) < EXPEDITED_ROOM)
            sdo->size = ect_od_bytes(first);
    }
    reason = check_size(s, first);
    if (reason == ECT_OK && available >= sdo->size) {
        reason = store_whole(s, first, data);
    } else if (reason == ECT_OK) {
        sdo->state = ECT_SDO_DOWNLOADING;
        cursor_begin(s, first);
        reason = cursor_write(s, data, available, false);
        sdo->done = available;
    }
    finish_download(s, reason, true, UPLOAD_SEGMENT);
}

/* A segment must not exceed the remaining length, and the last one must contain all of it. */
static ect_reason_t check_segment(const ect_sdo_t *sdo, uint16_t available, bool last)
{
    ECT_ASSERT(sdo->object && sdo->done <= sdo->size);
    uint32_t left = sdo->size - sdo->done;
    if (available > left)
        return ECT_REASON_TOO_LONG;
    return last && available < left ? ECT_REASON_TOO_SHORT : ECT_OK;
}

static void download_segment(ect_slave_t *s, const uint8_t *request, uint16_t length)
{
    ect_sdo_t *sdo = &s->sdo;
    if (!segment_expected(s, request, ECT_SDO_DOWNLOADING))
        return;
    uint16_t available = (uint16_t)(length - 1);
    if (available == SEGMENT_MINIMUM)
        available = (uint16_t)(available - ((request[0] >> 1) & 7u));
    bool last = (request[0] & LAST_SEGMENT) != 0;
    ect_reason_t reason = check_segment(sdo, available, last);
    if (reason == ECT_OK)
        reason = cursor_write(s, request + 1, available, false);
    if (reason == ECT_OK && last)
        reason = sdo->cursor.offset != 0 ? ECT_REASON_TOO_SHORT : whole_written(s);
    sdo->done += available;
    finish_download(s, reason, false, DOWNLOAD | (request[0] & (unsigned int)TOGGLE));
    if (last)
        sdo->state = ECT_SDO_IDLE;
}

/* --- accesses in one piece, of other protocols -------------------------------------------------------------------- */

/* The address of an initiate request. */
static void address_of(uint32_t place, uint8_t request[4])
{
    request[0] = (place & ECT_SDO_COMPLETE) != 0 ? COMPLETE : 0;
    ect_store_le16(request + 1, (uint16_t)(place >> 16));
    request[3] = (uint8_t)place;
}

ect_reason_t ect_sdo_read_all(ect_slave_t *s, uint32_t place, uint8_t *to, uint32_t *length)
{
    const ect_sdo_t under_way = s->sdo;
    uint8_t request[4];
    uint8_t last = 0;
    address_of(place, request);
    ect_reason_t reason = open_upload(s, request, &last);
    if (reason == ECT_OK) {
        const uint32_t size = s->sdo.size;
        cursor_read(s, to, (uint16_t)(size < *length ? size : *length), last);
        *length = size;
    }
    s->sdo = under_way;
    return reason;
}

ect_reason_t ect_sdo_write_all(ect_slave_t *s, uint32_t place, const uint8_t *data, uint16_t length)
{
    const ect_sdo_t under_way = s->sdo;
    const ect_entry_t *first = NULL;
    uint8_t request[4];
    ECT_ASSERT(under_way.state != ECT_SDO_DOWNLOADING);
    address_of(place, request);
    ect_reason_t reason = open_transfer(s, request, ECT_DOWNLOAD, &first);
    s->sdo.size = length;
    if (reason == ECT_OK)
        reason = check_size(s, first);
    if (reason == ECT_OK)
        reason = store_whole(s, first, data);
    s->sdo = under_way;
    return reason;
}

/* --- entry ------------------------------------------------------------------------------------------------------- */

static uint16_t request(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *mail, uint16_t length)
{
    uint16_t error = ect_coe_expect(mail, length, ECT_COE_MAIL_SDO_REQUEST);
    (void)self;
    if (error != ECT_MAILBOX_OK)
        return error;
    if (length < ECT_SDO_LENGTH)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    const uint8_t *sdo = mail + ECT_COE_HEADER;
    length = (uint16_t)(length - ECT_COE_HEADER);
    switch (sdo[0] & SPECIFIER) {
    case DOWNLOAD_SEGMENT:
        download_segment(s, sdo, length);
        break;
    case DOWNLOAD:
        download(s, sdo, length);
        break;
    case UPLOAD:
        upload(s, sdo);
        break;
    case UPLOAD_SEGMENT:
        upload_segment(s, sdo);
        break;
    case ABORT:
        s->sdo.state = ECT_SDO_IDLE; /* the master gives up: no reply */
        break;
    default:
        send_abort(s, ect_load_le16(sdo + 1), sdo[3], ECT_REASON_COMMAND);
        break;
    }
    return ECT_MAILBOX_OK;
}

static void reset(const ect_protocol_t *self, ect_slave_t *s)
{
    (void)self;
    s->sdo.state = ECT_SDO_IDLE;
}

const ect_protocol_t ect_protocol_sdo = {
    .type = ECT_MAILBOX_TYPE_COE, .states = ECT_IN_PREOP_AND_ABOVE, .request = request, .reset = reset};
