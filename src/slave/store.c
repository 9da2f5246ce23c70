/* SPDX-License-Identifier: MIT */
/*
 * Store and restore, 1010h and 1011h. The data of the record contain, for each entry with ECT_ACCESS_BACKUP, its
 * address, its size and its wire form. Restoring the defaults stores a record without entries.
 */
#include "seams/record.h"
#include "slave/internal.h"

enum { INDEX_STORE = 0x1010, INDEX_RESTORE = 0x1011 };
enum { ENTRY_HEADER = 5, PIECE = 32 };
#define MAGIC 0x50435445u /* "ETCP" */

/* --- writing ----------------------------------------------------------------------------------------------------- */

static bool put_entry(ect_slave_t *s, ect_record_t *r, uint16_t index, const ect_entry_t *entry)
{
    uint8_t piece[PIECE];
    uint16_t size = ect_od_bytes(entry);
    ect_store_le16(piece, index);
    piece[2] = (uint8_t)entry->subindex;
    ect_store_le16(piece + 3, size);
    if (!ect_record_put(r, piece, ENTRY_HEADER))
        return false;
    for (uint16_t at = 0; at < size; at = (uint16_t)(at + PIECE)) {
        uint16_t part = size - at < PIECE ? (uint16_t)(size - at) : PIECE;
        ect_cycle_hold(s);
        ect_od_read(&s->od, entry, at, piece, part);
        ect_cycle_release(s);
        if (!ect_record_put(r, piece, part))
            return false;
    }
    return true;
}

static bool put_all(ect_slave_t *s, ect_record_t *r)
{
    for (uint16_t i = 0; i < s->od.count; i++) {
        const ect_object_t *object = &s->od.objects[i];
        for (const ect_entry_t *entry = object->entries; entry; entry = ect_od_next(object, entry)) {
            if ((entry->access & ECT_ACCESS_BACKUP) != 0 && !put_entry(s, r, object->index, entry))
                return false;
        }
    }
    return true;
}

static ect_reason_t store(ect_slave_t *s, bool with_entries)
{
    const ect_storage_t *m = s->config.storage;
    ect_record_t newest, r;
    if (!m || m->bank_size < ECT_RECORD_HEADER)
        return ECT_REASON_STORE;
    if (ect_record_find(m, MAGIC, &newest) < 0 || !ect_record_begin(&r, &newest) || (with_entries && !put_all(s, &r)) ||
        !ect_record_commit(&r, MAGIC))
        return ECT_REASON_HARDWARE;
    return ECT_OK;
}

/* --- reading ----------------------------------------------------------------------------------------------------- */

/* A number is read in one piece of at most 8 bytes, any other type in pieces. */
static void load_entry(const ect_slave_t *s, const ect_record_t *r, uint32_t at, const ect_entry_t *entry)
{
    uint8_t piece[PIECE];
    uint16_t size = ect_od_bytes(entry);
    for (uint16_t done = 0; done < size; done = (uint16_t)(done + PIECE)) {
        uint16_t part = size - done < PIECE ? (uint16_t)(size - done) : PIECE;
        if (!ect_record_get(r, at + done, piece, part))
            return;
        (void)ect_od_write(&s->od, entry, done, piece, part);
    }
}

/* Skips entries that this firmware does not have, or has with another size. */
static void load(ect_slave_t *s)
{
    ect_record_t r;
    uint32_t at = 0;
    if (!s->config.storage || ect_record_find(s->config.storage, MAGIC, &r) <= 0)
        return;
    while (at + ENTRY_HEADER <= r.length) {
        uint8_t header[ENTRY_HEADER];
        const ect_object_t *object = NULL;
        const ect_entry_t *entry = NULL;
        if (!ect_record_get(&r, at, header, sizeof header))
            return;
        at += ENTRY_HEADER;
        uint16_t size = ect_load_le16(header + 3);
        bool known = ect_od_lookup(&s->od, ect_load_le16(header), header[2], &object, &entry) == ECT_OK;
        if (size > r.length - at)
            return;
        if (known && (entry->access & ECT_ACCESS_BACKUP) != 0 && size == ect_od_bytes(entry))
            load_entry(s, &r, at, entry);
        at += size;
    }
}

static bool is_command(uint16_t index)
{
    return index == INDEX_STORE || index == INDEX_RESTORE;
}

static ect_reason_t write_command(ect_slave_t *s, const ect_download_t *d)
{
    uint32_t wanted = d->index == INDEX_STORE ? ECT_STORE_SIGNATURE : ECT_LOAD_SIGNATURE;
    (void)s;
    if (!is_command(d->index) || d->subindex == 0)
        return ECT_OK;
    return d->size == 4 && ect_load_le32(d->data) == wanted ? ECT_OK : ECT_REASON_STORE;
}

/* The medium may be slow: process data continue meanwhile. */
static ect_reason_t store_meanwhile(ect_slave_t *s, bool with_entries)
{
    ect_cycle_release(s);
    ect_reason_t reason = store(s, with_entries);
    ect_cycle_hold(s);
    return reason;
}

static ect_reason_t written_command(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete)
{
    (void)subindex;
    (void)complete;
    if (!is_command(index))
        return ECT_OK;
    return store_meanwhile(s, index == INDEX_STORE);
}

static void store_now(ect_slave_t *s)
{
    (void)store_meanwhile(s, true);
}

/* The device may request this anywhere, possibly in an interrupt. */
static void store_later(void *slave)
{
    ((ect_slave_t *)slave)->later = store_now;
}

static void start(ect_slave_t *s)
{
    s->host.store = store_later;
    load(s);
}

const ect_service_t ect_service_store = {.start = start, .write = write_command, .written = written_command};
