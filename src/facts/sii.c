/* SPDX-License-Identifier: MIT */
/* Facts of an EEPROM image of any origin. */
#include <inttypes.h>
#include <string.h>

#include "facts/facts.h"
#include "sii/sii.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/sii.h"

typedef struct image {
    ect_facts_t *facts;
    const uint8_t *bytes;
    size_t size;
} image_t;

static void add_string(const image_t *image, ect_fact_kind_t kind, unsigned int index, unsigned int element,
                       uint8_t number)
{
    uint8_t length = 0;
    const char *text = ect_sii_string(image->bytes, image->size, number, &length);
    if (text != NULL)
        ect_facts_add_text(image->facts, kind, index, element, text, length);
    else if (number != 0)
        (void)ect_facts_add(image->facts, kind, index, element, "string %u, which does not exist", number);
}

static const char *text_or_none(uint8_t string)
{
    return string != 0 ? "a text" : "no text";
}

static void add_header(const image_t *image)
{
    ect_facts_t *facts = image->facts;
    const uint8_t *w = image->bytes;
    for (unsigned int word = 0; word < 7; word++) {
        if (word != 4)
            (void)ect_facts_add(facts, ECT_FACT_CONFIG, word, 0, "0x%04X", ect_load_le16(w + 2 * word));
    }
    uint8_t right = ect_sii_checksum(w);
    if (w[ECT_SII_AT_CHECKSUM] == right)
        (void)ect_facts_add(facts, ECT_FACT_CHECKSUM, 0, 0, "right");
    else
        (void)ect_facts_add(facts, ECT_FACT_CHECKSUM, 0, 0, "0x%02X, wrong: words 0 to 6 come to 0x%02X",
                            w[ECT_SII_AT_CHECKSUM], right);
    (void)ect_facts_add(facts, ECT_FACT_VENDOR, 0, 0, "0x%08" PRIX32, ect_load_le32(w + ECT_SII_AT_VENDOR));
    (void)ect_facts_add(facts, ECT_FACT_PRODUCT, 0, 0, "0x%08" PRIX32, ect_load_le32(w + ECT_SII_AT_PRODUCT));
    (void)ect_facts_add(facts, ECT_FACT_REVISION, 0, 0, "0x%08" PRIX32, ect_load_le32(w + ECT_SII_AT_REVISION));
    ect_facts_add_mailbox(facts, ECT_FACT_BOOT_OUT, ect_load_le16(w + ECT_SII_AT_BOOT_OUT),
                          ect_load_le16(w + ECT_SII_AT_BOOT_OUT + 2));
    ect_facts_add_mailbox(facts, ECT_FACT_BOOT_IN, ect_load_le16(w + ECT_SII_AT_BOOT_IN),
                          ect_load_le16(w + ECT_SII_AT_BOOT_IN + 2));
    ect_facts_add_mailbox(facts, ECT_FACT_MAILBOX_OUT, ect_load_le16(w + ECT_SII_AT_MAILBOX_OUT),
                          ect_load_le16(w + ECT_SII_AT_MAILBOX_OUT + 2));
    ect_facts_add_mailbox(facts, ECT_FACT_MAILBOX_IN, ect_load_le16(w + ECT_SII_AT_MAILBOX_IN),
                          ect_load_le16(w + ECT_SII_AT_MAILBOX_IN + 2));
    (void)ect_facts_add(facts, ECT_FACT_EEPROM_SIZE, 0, 0, "%u bytes",
                        (ect_load_le16(w + ECT_SII_AT_SIZE) + 1u) * 128u);
}

/* Adds the reserved words and the version as one fact. */
static void add_reserved(const image_t *image)
{
    enum { DELAYS = 0x20, DELAYS_END = ECT_SII_AT_BOOT_OUT, RESERVED = 0x3A, RESERVED_END = ECT_SII_AT_SIZE };
    uint8_t words[DELAYS_END - DELAYS + RESERVED_END - RESERVED + 3];
    const uint8_t *w = image->bytes;
    size_t used = 0;
    memcpy(words, w + DELAYS, DELAYS_END - DELAYS);
    used += DELAYS_END - DELAYS;
    memcpy(words + used, w + RESERVED, RESERVED_END - RESERVED);
    used += RESERVED_END - RESERVED;
    words[used++] = w[15];
    memcpy(words + used, w + ECT_SII_AT_VERSION, 2);
    ECT_ASSERT(used + 2 == sizeof words);
    (void)ect_facts_add(image->facts, ECT_FACT_WORDS, 0, 0, "sum %08" PRIX32, ect_facts_sum(words, sizeof words));
}

/* Adds a category. Bytes after the last whole element give no fact. */
static void add_category(const image_t *image, uint16_t type, size_t bytes)
{
    const size_t rest = type == ECT_SII_DC ? bytes % 24 : type == ECT_SII_SYNCM ? bytes % 8 : 0;
    if (rest == 0)
        (void)ect_facts_add(image->facts, ECT_FACT_CATEGORY, type, 0, "there");
    else
        (void)ect_facts_add(image->facts, ECT_FACT_CATEGORY, type, 0, "there, with %zu bytes at its end", rest);
}

/* Adds the categories in the order of the image. */
static void add_categories(const image_t *image)
{
    size_t at = ECT_SII_CATEGORIES;
    while (at + 4 <= image->size) {
        const uint16_t type = ect_load_le16(image->bytes + at);
        const size_t bytes = (size_t)ect_load_le16(image->bytes + at + 2) * 2;
        if (type == ECT_SII_END) {
            (void)ect_facts_add(image->facts, ECT_FACT_CATEGORY, type, 0, "the end");
            break;
        }
        if (bytes > image->size - at - 4)
            break;
        const uint8_t *data = image->bytes + at + 4;
        if (type == ECT_SII_STRINGS || type == ECT_SII_GENERAL || type == ECT_SII_FMMU || type == ECT_SII_SYNCM ||
            type == ECT_SII_TXPDO || type == ECT_SII_RXPDO || type == ECT_SII_DC)
            add_category(image, type, bytes);
        else
            (void)ect_facts_add(image->facts, ECT_FACT_CATEGORY, type, 0, "%zu bytes, sum %08" PRIX32, bytes,
                                ect_facts_sum(data, bytes));
        at += 4 + bytes;
    }
    image->facts->complete[ECT_FACT_CATEGORY] = true;
}

/* Adds the other bytes of General: picture, reserved bytes, details of protocols, flags, addresses of the id.
 * Strings count only by their existence, because the number depends on the tool that wrote the image. */
static void add_general_bytes(const image_t *image, const uint8_t *g, size_t length)
{
    static const uint32_t texts = 1u << 0 | 1u << 2 | 1u << 3 | 1u << 14, read = 1u << 5 | 1u << 12 | 1u << 13;
    for (unsigned int i = 0; i < length && i < 256; i++) {
        if (i < 32 && (texts >> i & 1u) != 0)
            (void)ect_facts_add(image->facts, ECT_FACT_GENERAL, i, 0, "%s", text_or_none(g[i]));
        else if (i >= 32 || (read >> i & 1u) == 0)
            (void)ect_facts_add(image->facts, ECT_FACT_GENERAL, i, 0, "0x%02X", g[i]);
    }
}

static void add_general(const image_t *image)
{
    size_t length = 0;
    const uint8_t *g = ect_sii_category(image->bytes, image->size, ECT_SII_GENERAL, &length);
    if (g == NULL || length < 18)
        return;
    add_string(image, ECT_FACT_GROUP, 0, 0, g[0]);
    add_string(image, ECT_FACT_TYPE, 0, 0, g[2]);
    add_string(image, ECT_FACT_NAME, 0, 0, g[3]);
    ect_facts_add_protocols(image->facts, ect_load_le16(image->bytes + ECT_SII_AT_PROTOCOLS), g[5]);
    (void)ect_facts_add(image->facts, ECT_FACT_EBUS, 0, 0, "%d mA", (int16_t)ect_load_le16(g + 12));
    add_string(image, ECT_FACT_GROUP_NAME, 0, 0, g[14]);
    char ports[5] = "";
    for (unsigned int i = 0; i < 4; i++)
        ports[i] = ect_sii_port_letter((unsigned int)ect_load_le16(g + 16) >> (4 * i));
    ect_facts_add_text(image->facts, ECT_FACT_PORTS, 0, 0, ports, 4);
    add_general_bytes(image, g, length);
}

static void add_layout(const image_t *image)
{
    size_t length = 0;
    const uint8_t *fmmus = ect_sii_category(image->bytes, image->size, ECT_SII_FMMU, &length);
    if (fmmus != NULL)
        ect_facts_add_fmmus(image->facts, fmmus, length);
    const uint8_t *sms = ect_sii_category(image->bytes, image->size, ECT_SII_SYNCM, &length);
    for (unsigned int i = 0; sms != NULL && i < length / 8; i++) {
        const uint8_t *sm = sms + 8 * (size_t)i;
        uint16_t bytes = ect_load_le16(sm + 2);
        ect_facts_add_sm(image->facts, i, sm[7]);
        (void)ect_facts_add(image->facts, ECT_FACT_SM_START, i, 0, "0x%04X", ect_load_le16(sm));
        (void)ect_facts_add(image->facts, ECT_FACT_SM_CONTROL, i, 0, "0x%02X", sm[4]);
        (void)ect_facts_add(image->facts, ECT_FACT_SM_BITS, i, 0, "status 0x%02X, flags 0x%02X", sm[5], sm[6] & 0xFEu);
        if (sm[7] == ECT_SM_UNUSED)
            continue;
        (void)ect_facts_add(image->facts, ECT_FACT_SM_LENGTH, i, 0, "%u bytes", bytes);
        if (bytes > 0)
            (void)ect_facts_add(image->facts, ECT_FACT_SM_ENABLED, i, 0, "%s", (sm[6] & 1u) != 0 ? "yes" : "no");
    }
    image->facts->complete[ECT_FACT_SM] = sms != NULL;
}

static void add_pdo_entries(const image_t *image, uint16_t pdo, const uint8_t *entries, unsigned int count)
{
    for (unsigned int n = 1; n <= count; n++, entries += 8) {
        ect_facts_add_mapping(image->facts, pdo, n, ect_load_le16(entries),
                              ect_load_le16(entries) != 0 ? entries[2] : 0, entries[5]);
        add_string(image, ECT_FACT_PDO_ENTRY_NAME, pdo, n, entries[3]);
        if (entries[4] != 0)
            (void)ect_facts_add(image->facts, ECT_FACT_PDO_ENTRY_TYPE, pdo, n, "0x%02X", entries[4]);
        (void)ect_facts_add(image->facts, ECT_FACT_PDO_ENTRY_BITS, pdo, n, "%s, %s, 0x%04X", text_or_none(entries[3]),
                            entries[4] != 0 ? "a type" : "no type", ect_load_le16(entries + 6));
    }
}

static void add_pdos(const image_t *image, uint16_t category)
{
    size_t length = 0;
    const uint8_t *pdo = ect_sii_category(image->bytes, image->size, category, &length);
    while (pdo != NULL && length >= 8) {
        uint16_t index = ect_load_le16(pdo);
        size_t bytes = 8 + 8 * (size_t)pdo[2];
        if (index == 0 || bytes > length)
            return;
        uint16_t flags = ect_load_le16(pdo + 6);
        (void)ect_facts_add(image->facts, ECT_FACT_PDO, index, 0, "%s",
                            category == ECT_SII_RXPDO ? "outputs" : "inputs");
        (void)(pdo[3] == 0xFF ? ect_facts_add(image->facts, ECT_FACT_PDO_SM, index, 0, "none")
                              : ect_facts_add(image->facts, ECT_FACT_PDO_SM, index, 0, "%u", pdo[3]));
        add_string(image, ECT_FACT_PDO_NAME, index, 0, pdo[5]);
        (void)ect_facts_add(image->facts, ECT_FACT_PDO_FIXED, index, 0, "%s",
                            (flags & ECT_PDO_FIXED) != 0 ? "yes" : "no");
        (void)ect_facts_add(image->facts, ECT_FACT_PDO_MANDATORY, index, 0, "%s",
                            (flags & ECT_PDO_MANDATORY) != 0 ? "yes" : "no");
        (void)ect_facts_add(image->facts, ECT_FACT_PDO_BITS, index, 0, "%s, synchronization %u, flags 0x%04X",
                            text_or_none(pdo[5]), pdo[4], flags & ~(unsigned int)(ECT_PDO_FIXED | ECT_PDO_MANDATORY));
        add_pdo_entries(image, index, pdo + 8, pdo[2]);
        pdo += bytes;
        length -= bytes;
    }
}

static void add_clocks(const image_t *image)
{
    size_t length = 0;
    const uint8_t *dc = ect_sii_category(image->bytes, image->size, ECT_SII_DC, &length);
    for (unsigned int i = 0; dc != NULL && i < length / 24; i++, dc += 24) {
        size_t before = image->facts->count;
        add_string(image, ECT_FACT_DC, i, 0, dc[18]);
        if (image->facts->count == before)
            (void)ect_facts_add(image->facts, ECT_FACT_DC, i, 0, NULL);
        (void)ect_facts_add(image->facts, ECT_FACT_DC_ACTIVATE, i, 0, "0x%04X", ect_load_le16(dc + 14));
        (void)ect_facts_add(image->facts, ECT_FACT_DC_SYNC0, i, 0, "%" PRIu32 " ns, factor %d, shift %" PRId32 " ns",
                            ect_load_le32(dc), (int16_t)ect_load_le16(dc + 16), (int32_t)ect_load_le32(dc + 4));
        uint8_t description = 0;
        const char *text = ect_sii_string(image->bytes, image->size, dc[19], &description);
        (void)ect_facts_add(image->facts, ECT_FACT_DC_TEXT, i, 0, "%s, \"%.*s\", 0x%08" PRIX32, text_or_none(dc[18]),
                            (int)description, text != NULL ? text : "", ect_load_le32(dc + 20));
        (void)ect_facts_add(image->facts, ECT_FACT_DC_SYNC1, i, 0, "factor %d, shift %" PRId32 " ns",
                            (int16_t)ect_load_le16(dc + 12), (int32_t)ect_load_le32(dc + 8));
    }
}

void ect_facts_of_sii(ect_facts_t *facts, const uint8_t *bytes, size_t size)
{
    image_t image = {.facts = facts, .bytes = bytes, .size = size};
    ECT_ASSERT(bytes != NULL || size == 0);
    if (size < ECT_SII_CATEGORIES) {
        (void)ect_facts_add(facts, ECT_FACT_EEPROM_SIZE, 0, 0, "%zu bytes, less than its header", size);
        return;
    }
    add_header(&image);
    add_reserved(&image);
    add_categories(&image);
    add_general(&image);
    add_layout(&image);
    add_pdos(&image, ECT_SII_TXPDO);
    add_pdos(&image, ECT_SII_RXPDO);
    size_t length = 0; /* without categories of PDOs, the dictionary of a slave with CoE contains the PDOs */
    bool coe = (ect_load_le16(bytes + ECT_SII_AT_PROTOCOLS) & ECT_MAILBOX_COE) != 0;
    facts->complete[ECT_FACT_PDO] = !coe || ect_sii_category(bytes, size, ECT_SII_TXPDO, &length) != NULL ||
                                    ect_sii_category(bytes, size, ECT_SII_RXPDO, &length) != NULL;
    facts->complete[ECT_FACT_PDO_ENTRY] = facts->complete[ECT_FACT_PDO];
    add_clocks(&image);
    facts->complete[ECT_FACT_DC] = true;
}
