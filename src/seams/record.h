/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Record: a format for data in an ::ect_storage_t such that a power failure at any moment leaves the previous record.
 *
 * A bank holds one record: a header of 16 bytes (magic number, sequence number, length, CRC-32 over data, sequence and
 * length) and its data. A new record is written to the bank without the newest record. Its header is written last, when
 * the data are safe, and makes the record valid. The user of a record chooses the magic number, which identifies the
 * meaning of the data.
 *
 * Reading: ::ect_record_find, then ::ect_record_get at any offset.
 * Writing: ::ect_record_find, ::ect_record_begin, ::ect_record_put until all data are written, ::ect_record_commit.
 * Code that must not wait for the medium writes one part at a time and, in place of the commit, repeats
 * ::ect_record_flush until it reports completion, calls ::ect_record_seal, and repeats ::ect_record_flush again.
 *
 * Context: that of the storage. All functions only use the memory of their arguments.
 */
#ifndef ECT_SEAMS_RECORD_H
#define ECT_SEAMS_RECORD_H

#include <stdbool.h>

#include "seams/storage.h"
#include "wire/bytes.h"
#include "wire/crc.h"

enum { ECT_RECORD_HEADER = 16, ECT_RECORD_PIECE = 32 };

/** A record found, or under construction. Owned by the caller. */
typedef struct ect_record {
    const ect_storage_t *medium;
    uint32_t sequence;
    uint32_t length; /**< of the data, bytes; writing: bytes so far */
    uint32_t check;  /**< writing: of the data so far */
    unsigned int bank;
} ect_record_t;

/** Check value of a whole record; `data_crc` is the ::ect_crc32 of its data, started with 0xFFFFFFFF. */
static inline uint32_t ect_record_check(uint32_t data_crc, uint32_t sequence, uint32_t length)
{
    uint8_t bytes[8];
    ect_store_le32(bytes, sequence);
    ect_store_le32(bytes + 4, length);
    return ect_crc32(data_crc, bytes, sizeof bytes);
}

/** Reads data of a record that was found; offset + length <= r->length. @return false: the medium failed */
static inline bool ect_record_get(const ect_record_t *r, uint32_t offset, void *data, uint32_t length)
{
    return r->medium->read(r->medium->ctx, r->bank, ECT_RECORD_HEADER + offset, data, length) >= 0;
}

/** Checks the data of a record against its check value. @return 1: equal · 0: different · -1: the medium failed */
static inline int ect_record_data_good(const ect_record_t *r)
{
    uint8_t piece[ECT_RECORD_PIECE];
    uint32_t crc = 0xFFFFFFFF;
    for (uint32_t at = 0; at < r->length; at += ECT_RECORD_PIECE) {
        uint32_t size = r->length - at < ECT_RECORD_PIECE ? r->length - at : (uint32_t)ECT_RECORD_PIECE;
        if (!ect_record_get(r, at, piece, size))
            return -1;
        crc = ect_crc32(crc, piece, size);
    }
    return ect_record_check(crc, r->sequence, r->length) == r->check;
}

/** Reads the header in a bank. @return 1 · 0: no record with this magic number · -1: the medium failed */
static inline int ect_record_header(const ect_storage_t *m, unsigned int bank, uint32_t magic, ect_record_t *r)
{
    uint8_t header[ECT_RECORD_HEADER];
    if (m->read(m->ctx, bank, 0, header, ECT_RECORD_HEADER) < 0)
        return -1;
    *r = (ect_record_t){.medium = m,
                        .sequence = ect_load_le32(header + 4),
                        .length = ect_load_le32(header + 8),
                        .check = ect_load_le32(header + 12),
                        .bank = bank};
    return ect_load_le32(header) == magic && r->length <= m->bank_size - ECT_RECORD_HEADER;
}

/**
 * Finds the newest valid record. A failure of the medium does not count as a missing record.
 * @param m       the medium
 * @param magic   identifies the kind of record
 * @param[out] r  the record; without a record its `bank` is the one that the first record does not use
 * @return 1 found · 0 none · -1 the medium failed, or a bank is too small for a header
 */
static inline int ect_record_find(const ect_storage_t *m, uint32_t magic, ect_record_t *r)
{
    ect_record_t found[2];
    int valid[2];
    if (m->bank_size < ECT_RECORD_HEADER)
        return -1;
    for (unsigned int bank = 0; bank < 2; bank++) {
        valid[bank] = ect_record_header(m, bank, magic, &found[bank]);
        if (valid[bank] < 0)
            return -1;
    }
    unsigned int newer = valid[1] && (!valid[0] || (int32_t)(found[1].sequence - found[0].sequence) > 0) ? 1 : 0;
    for (unsigned int i = 0; i < 2; i++) {
        unsigned int bank = i == 0 ? newer : newer ^ 1u;
        int good = valid[bank] ? ect_record_data_good(&found[bank]) : 0;
        *r = found[bank];
        if (good != 0)
            return good;
    }
    *r = (ect_record_t){.medium = m, .bank = 1};
    return 0;
}

/**
 * Starts a record in the bank other than that of `newest`, which ect_record_find has set.
 * @return false: the medium failed
 */
static inline bool ect_record_begin(ect_record_t *r, const ect_record_t *newest)
{
    const ect_storage_t *m = newest->medium;
    *r = (ect_record_t){.medium = m, .sequence = newest->sequence + 1, .check = 0xFFFFFFFF, .bank = newest->bank ^ 1u};
    return m->erase(m->ctx, r->bank) >= 0;
}

/** Writes the next piece of data. @return false: the bank is full, or the medium failed */
static inline bool ect_record_put(ect_record_t *r, const void *data, uint32_t length)
{
    const ect_storage_t *m = r->medium;
    uint32_t at = ECT_RECORD_HEADER + r->length;
    if (length > m->bank_size - at || m->write(m->ctx, r->bank, at, data, length) < 0)
        return false;
    r->check = ect_crc32(r->check, (const uint8_t *)data, length);
    r->length += length;
    return true;
}

/** Makes the previously written data or header safe. @return as ect_storage_t::flush */
static inline int ect_record_flush(const ect_record_t *r, bool wait)
{
    return r->medium->flush ? r->medium->flush(r->medium->ctx, r->bank, wait) : 0;
}

/** Makes the record, whose data are safe, the newest one. @return false: the medium failed */
static inline bool ect_record_seal(const ect_record_t *r, uint32_t magic)
{
    uint8_t header[ECT_RECORD_HEADER];
    ect_store_le32(header, magic);
    ect_store_le32(header + 4, r->sequence);
    ect_store_le32(header + 8, r->length);
    ect_store_le32(header + 12, ect_record_check(r->check, r->sequence, r->length));
    return r->medium->write(r->medium->ctx, r->bank, 0, header, ECT_RECORD_HEADER) >= 0;
}

/** Makes the record the newest one, and waits until it is safe. @return whether it is safe */
static inline bool ect_record_commit(const ect_record_t *r, uint32_t magic)
{
    return ect_record_flush(r, true) == 0 && ect_record_seal(r, magic) && ect_record_flush(r, true) == 0;
}

#endif
