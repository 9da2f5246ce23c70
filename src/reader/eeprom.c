/* SPDX-License-Identifier: MIT */
/* The EEPROM over the registers of the slave information interface (ETG.1000.4 clause 6.4). */
#include <string.h>

#include "reader/internal.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { BUSY = 0x8000, NO_ACK = 0x2000, REFUSED = 0x4000, READ = 0x0100, READS_8 = 0x0040 };
enum {
    BUSY_MS = 1000,
    ATTEMPTS = 10,
    POLLS = 100000,
    HEADER = ECT_READER_HEADER,
    SIZE_AT = 0x7C,
    UNIT = 128,
    BLOCK = 1024
};
enum { CATEGORY_HEADER = 4, CATEGORIES_END = 0xFFFF };
enum { BY_PDI = 0x01, TAKE_AWAY = 0x02, IN_USE = 0x01 };

/* Takes the interface from the PDI: by force, if the PDI has not finished with it. */
static ect_reader_result_t take(ect_reader_t *r)
{
    static const uint8_t by_force = TAKE_AWAY;
    static const uint8_t to_master = 0;
    uint8_t owner[2];
    if (reader_get(r, ECT_REG_SII_CONFIG, owner, sizeof owner) != ECT_READER_OK)
        return r->result;
    if ((owner[0] & BY_PDI) == 0 && (owner[1] & IN_USE) == 0)
        return ECT_READER_OK;
    if ((owner[1] & IN_USE) != 0 && r->config.changes != ECT_READER_CHANGES_ALL)
        return reader_report(r, ECT_READER_DECLINED, "the PDI is using the EEPROM: try again later");
    r->sii_of_pdi = r->sii_of_pdi || (owner[0] & BY_PDI) != 0;
    if ((owner[1] & IN_USE) != 0 && reader_put(r, ECT_REG_SII_CONFIG, &by_force, 1) != ECT_READER_OK)
        return r->result;
    return reader_put(r, ECT_REG_SII_CONFIG, &to_master, 1);
}

static ect_reader_result_t wait_ready(ect_reader_t *r, uint16_t *control)
{
    const uint64_t until = reader_now(r) + BUSY_MS * NS_PER_MS;
    for (unsigned int polls = 0; polls < POLLS; polls++) {
        const bool late = reader_now(r) >= until;
        uint8_t bytes[2];
        if (reader_is_over(r) || reader_get(r, ECT_REG_SII_CONTROL, bytes, sizeof bytes) != ECT_READER_OK)
            return r->result;
        *control = ect_load_le16(bytes);
        if ((*control & BUSY) == 0)
            return ECT_READER_OK;
        if (late)
            break;
        reader_pause(r, polls);
    }
    return reader_report(r, ECT_READER_SILENT, "the EEPROM interface stays busy for more than %d ms", (int)BUSY_MS);
}

static ect_reader_result_t command(ect_reader_t *r, uint32_t word, uint16_t *control)
{
    uint8_t bytes[6] = {0};
    if (wait_ready(r, control) != ECT_READER_OK)
        return r->result;
    if ((*control & (NO_ACK | REFUSED)) != 0 && reader_put(r, ECT_REG_SII_CONTROL, bytes, 2) != ECT_READER_OK)
        return r->result;
    ect_store_le16(bytes, READ);
    ect_store_le32(bytes + 2, word);
    if (reader_put(r, ECT_REG_SII_CONTROL, bytes, sizeof bytes) != ECT_READER_OK)
        return r->result;
    return wait_ready(r, control);
}

/* 4 or 8 bytes, as the ESC reads them. */
static ect_reader_result_t read_some(ect_reader_t *r, size_t at, uint8_t data[8], size_t *length)
{
    uint16_t control = 0;
    for (unsigned int attempt = 0; attempt < ATTEMPTS; attempt++) {
        if (command(r, (uint32_t)(at / 2), &control) != ECT_READER_OK)
            return r->result;
        *length = (control & READS_8) != 0 ? 8 : 4;
        if ((control & NO_ACK) == 0)
            return reader_get(r, ECT_REG_SII_DATA, data, (uint16_t)*length);
        reader_pause(r, POLLS); /* an EEPROM that is still writing does not acknowledge */
    }
    return reader_report(r, ECT_READER_WRONG, "the EEPROM does not acknowledge a read of word 0x%04X",
                         (unsigned int)(at / 2));
}

static size_t announced(const uint8_t *image)
{
    return ((size_t)ect_load_le16(image + SIZE_AT) + 1) * UNIT;
}

/* Continues from *read to `wanted`, a multiple of 4. */
static ect_reader_result_t read_until(ect_reader_t *r, uint8_t *image, size_t wanted, size_t *read)
{
    while (*read < wanted) {
        uint8_t data[8];
        size_t length = 0;
        if (*read % BLOCK == 0 && !reader_progress(r, "EEPROM", (unsigned int)*read, (unsigned int)wanted))
            return r->result;
        if (read_some(r, *read, data, &length) != ECT_READER_OK)
            return r->result;
        length = length < wanted - *read ? length : wanted - *read;
        memcpy(image + *read, data, length);
        *read += length;
    }
    return reader_good(r);
}

ect_reader_result_t ect_reader_sii(ect_reader_t *r, uint8_t *image, size_t size, size_t *read)
{
    ECT_ASSERT(size % 4 == 0 && size <= ECT_READER_SII);
    *read = 0;
    if (take(r) != ECT_READER_OK || read_until(r, image, size != 0 ? size : HEADER, read) != ECT_READER_OK)
        return r->result;
    return size != 0 || announced(image) > ECT_READER_SII ? r->result : read_until(r, image, announced(image), read);
}

ect_reader_result_t ect_reader_sii_content(ect_reader_t *r, uint8_t *image, size_t *read)
{
    memcpy(image, r->header, HEADER);
    *read = HEADER;
    if (take(r) != ECT_READER_OK)
        return r->result;
    const size_t all = announced(image) < ECT_READER_SII ? announced(image) : ECT_READER_SII;
    for (size_t at = HEADER; at + CATEGORY_HEADER <= all;
         at += CATEGORY_HEADER + 2 * (size_t)ect_load_le16(image + at + 2)) {
        const size_t end = (at + CATEGORY_HEADER + 3) / 4 * 4;
        if (read_until(r, image, end < all ? end : all, read) != ECT_READER_OK)
            return r->result;
        if (ect_load_le16(image + at) == CATEGORIES_END)
            return ECT_READER_OK;
    }
    return read_until(r, image, all, read);
}
