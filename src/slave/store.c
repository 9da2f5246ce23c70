/* SPDX-License-Identifier: MIT */
/*
 * Store and restore, 1010h and 1011h. A record is a header and, for each entry with ECT_ACCESS_BACKUP, its address, its
 * size and its wire form. The data go first, into the bank that does not hold the newest record; the header, with the
 * check value over the data, makes them valid. Restoring the defaults stores a record without entries.
 */
#include <string.h>

#include "slave/internal.h"
#include "wire/crc.h"

enum { INDEX_STORE = 0x1010, INDEX_RESTORE = 0x1011 };
enum { HEADER = 16, ENTRY_HEADER = 5, PIECE = 32 };
#define MAGIC 0x50435445u /* "ETCP" */

typedef struct record {
    uint32_t sequence;
    uint32_t length; /* of the data */
    uint32_t check;
} record_t;

/* The check value covers sequence number and length too. */
static uint32_t check_start(uint32_t sequence, uint32_t length)
{
    uint8_t bytes[8];
    ect_store_le32(bytes, sequence);
    ect_store_le32(bytes + 4, length);
    return ect_crc32(0xFFFFFFFF, bytes, sizeof bytes);
}

static bool data_good(const ect_storage_t *m, unsigned int bank, const record_t *r)
{
    uint8_t piece[PIECE];
    uint32_t crc = check_start(r->sequence, r->length);
    for (uint32_t at = 0; at < r->length; at += PIECE) {
        uint32_t size = r->length - at < PIECE ? r->length - at : PIECE;
        if (m->read(m->ctx, bank, HEADER + at, piece, size) < 0)
            return false;
        crc = ect_crc32(crc, piece, size);
    }
    return crc == r->check;
}

static bool read_header(const ect_storage_t *m, unsigned int bank, record_t *r)
{
    uint8_t header[HEADER];
    if (m->bank_size < HEADER || m->read(m->ctx, bank, 0, header, HEADER) < 0 || ect_load_le32(header) != MAGIC)
        return false;
    r->sequence = ect_load_le32(header + 4);
    r->length = ect_load_le32(header + 8);
    r->check = ect_load_le32(header + 12);
    return r->length <= m->bank_size - HEADER && data_good(m, bank, r);
}

/* The bank with the newest valid record, or -1. */
static int newest(const ect_storage_t *m, record_t *r)
{
    record_t found[2];
    bool valid[2] = {read_header(m, 0, &found[0]), read_header(m, 1, &found[1])};
    if (!valid[0] && !valid[1])
        return -1;
    int bank = valid[1] && (!valid[0] || (int32_t)(found[1].sequence - found[0].sequence) > 0) ? 1 : 0;
    *r = found[bank];
    return bank;
}

/* --- writing ----------------------------------------------------------------------------------------------------- */

typedef struct writer {
    const ect_storage_t *medium;
    unsigned int bank;
    uint32_t at;
    uint32_t crc;
} writer_t;

static bool put(writer_t *w, const uint8_t *data, uint32_t length)
{
    if (w->medium->write(w->medium->ctx, w->bank, w->at, data, length) < 0)
        return false;
    w->crc = ect_crc32(w->crc, data, length);
    w->at += length;
    return true;
}

static bool put_entry(const ect_slave_t *s, writer_t *w, uint16_t index, const ect_entry_t *entry)
{
    uint8_t piece[PIECE];
    uint16_t size = ect_od_bytes(entry);
    ect_store_le16(piece, index);
    piece[2] = (uint8_t)entry->subindex;
    ect_store_le16(piece + 3, size);
    if (!put(w, piece, ENTRY_HEADER))
        return false;
    for (uint16_t at = 0; at < size; at = (uint16_t)(at + PIECE)) {
        uint16_t part = size - at < PIECE ? (uint16_t)(size - at) : PIECE;
        ect_od_read(&s->od, entry, at, piece, part);
        if (!put(w, piece, part))
            return false;
    }
    return true;
}

/* Puts all entries, or with `w` NULL only adds up how long they are. */
static bool walk(const ect_slave_t *s, writer_t *w, uint32_t *length)
{
    *length = 0;
    for (uint16_t i = 0; i < s->od.count; i++) {
        const ect_object_t *object = &s->od.objects[i];
        for (const ect_entry_t *entry = object->entries; entry; entry = ect_od_next(object, entry)) {
            if ((entry->access & ECT_ACCESS_BACKUP) == 0)
                continue;
            *length += ENTRY_HEADER + (uint32_t)ect_od_bytes(entry);
            if (w && !put_entry(s, w, object->index, entry))
                return false;
        }
    }
    return true;
}

static bool put_all(const ect_slave_t *s, writer_t *w)
{
    uint32_t length;
    return walk(s, w, &length);
}

static uint32_t length_of_all(const ect_slave_t *s)
{
    uint32_t length;
    (void)walk(s, NULL, &length);
    return length;
}

static ect_reason_t store(const ect_slave_t *s, bool with_entries)
{
    const ect_storage_t *m = s->config.storage;
    record_t last = {0};
    if (!m || m->bank_size < HEADER)
        return ECT_REASON_STORE;
    int bank = newest(m, &last);
    uint32_t length = with_entries ? length_of_all(s) : 0;
    writer_t w = {.medium = m, .bank = bank == 0 ? 1 : 0, .at = HEADER, .crc = check_start(last.sequence + 1, length)};
    if (length > m->bank_size - HEADER || m->erase(m->ctx, w.bank) < 0 || (with_entries && !put_all(s, &w)))
        return ECT_REASON_HARDWARE;
    uint8_t header[HEADER];
    ect_store_le32(header, MAGIC);
    ect_store_le32(header + 4, last.sequence + 1);
    ect_store_le32(header + 8, length);
    ect_store_le32(header + 12, w.crc);
    return m->write(m->ctx, w.bank, 0, header, HEADER) < 0 ? ECT_REASON_HARDWARE : ECT_OK;
}

/* --- reading ----------------------------------------------------------------------------------------------------- */

/* A number comes in one piece of at most 8 bytes, everything else in pieces. */
static void load_entry(const ect_slave_t *s, unsigned int bank, uint32_t at, const ect_entry_t *entry)
{
    const ect_storage_t *m = s->config.storage;
    uint8_t piece[PIECE];
    uint16_t size = ect_od_bytes(entry);
    for (uint16_t done = 0; done < size; done = (uint16_t)(done + PIECE)) {
        uint16_t part = size - done < PIECE ? (uint16_t)(size - done) : PIECE;
        if (m->read(m->ctx, bank, at + done, piece, part) < 0)
            return;
        (void)ect_od_write(&s->od, entry, done, piece, part);
    }
}

/* Entries that this firmware does not know, or knows at another size, are passed over. */
static void load(ect_slave_t *s)
{
    const ect_storage_t *m = s->config.storage;
    record_t r;
    int bank = m ? newest(m, &r) : -1;
    if (bank < 0)
        return;
    uint32_t at = HEADER;
    while (at + ENTRY_HEADER <= HEADER + r.length) {
        uint8_t header[ENTRY_HEADER];
        const ect_object_t *object = NULL;
        const ect_entry_t *entry = NULL;
        if (m->read(m->ctx, (unsigned int)bank, at, header, sizeof header) < 0)
            return;
        at += ENTRY_HEADER;
        uint16_t size = ect_load_le16(header + 3);
        bool known = ect_od_lookup(&s->od, ect_load_le16(header), header[2], &object, &entry) == ECT_OK;
        if (size > HEADER + r.length - at)
            return;
        if (known && (entry->access & ECT_ACCESS_BACKUP) != 0 && size == ect_od_bytes(entry))
            load_entry(s, (unsigned int)bank, at, entry);
        at += size;
    }
}

static ect_reason_t write_command(ect_slave_t *s, uint16_t index, uint8_t subindex, const uint8_t *data, uint16_t size)
{
    uint32_t wanted = index == INDEX_STORE ? ECT_STORE_SIGNATURE : ECT_LOAD_SIGNATURE;
    (void)s;
    if ((index != INDEX_STORE && index != INDEX_RESTORE) || subindex == 0)
        return ECT_OK;
    return size == 4 && ect_load_le32(data) == wanted ? ECT_OK : ECT_REASON_STORE;
}

static ect_reason_t written_command(ect_slave_t *s, uint16_t index, uint8_t subindex)
{
    (void)subindex;
    if (index != INDEX_STORE && index != INDEX_RESTORE)
        return ECT_OK;
    return store(s, index == INDEX_STORE);
}

const ect_service_t ect_service_store = {.start = load, .write = write_command, .written = written_command};
