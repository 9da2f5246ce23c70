/* SPDX-License-Identifier: MIT */
/* The SII image of every device, read by an independent parser, and the reader on damaged images (spec G). */
#include "sii/sii.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/every.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { SOEM_CACHE = 4096, MOST_CATEGORIES = 32 };

/* --- the parser --------------------------------------------------------------------------------------------------- */

typedef struct category {
    unsigned int type;
    const uint8_t *data;
    size_t length;
} category_t;

typedef struct image {
    const ect_device_t *device;
    uint8_t bytes[8192];
    size_t size;
    category_t categories[MOST_CATEGORIES];
    size_t count;
    size_t end; /* position of the end marker */
} image_t;

static unsigned int word(const image_t *image, unsigned int n)
{
    return (unsigned int)(image->bytes[2 * n] | image->bytes[2 * n + 1] << 8);
}

static uint32_t two_words(const image_t *image, unsigned int n)
{
    return word(image, n) | (uint32_t)word(image, n + 1) << 16;
}

static void parse(image_t *image, const ect_device_t *device, const ect_identity_t *identity, uint16_t alias)
{
    memset(image, 0, sizeof *image);
    image->device = device;
    int32_t size = ect_sii_write(device, identity, alias, image->bytes, sizeof image->bytes);
    if (size != device->sii_size)
        fail_msg("%s: expected an image of %u bytes, got %d", device->name, device->sii_size, size);
    image->size = (size_t)size;
    size_t at = 0x80;
    while (word(image, (unsigned int)(at / 2)) != 0xFFFF) {
        category_t *c = &image->categories[image->count++];
        assert_true(image->count < MOST_CATEGORIES && at + 4 <= image->size);
        c->type = word(image, (unsigned int)(at / 2));
        c->length = 2 * (size_t)word(image, (unsigned int)(at / 2 + 1));
        c->data = image->bytes + at + 4;
        at += 4 + c->length;
        assert_true(at + 2 <= image->size);
    }
    image->end = at;
}

static const category_t *category(const image_t *image, unsigned int type)
{
    const category_t *found = NULL;
    for (size_t i = 0; i < image->count; i++) {
        if (image->categories[i].type == type) {
            assert_null(found); /* once only */
            found = &image->categories[i];
        }
    }
    return found;
}

/* The text of a string index, "" for 0. */
static const char *string(const image_t *image, unsigned int index, char *text)
{
    const category_t *c = category(image, 10);
    assert_non_null(c);
    text[0] = 0;
    if (index == 0)
        return text;
    if (index > c->data[0])
        fail_msg("%s: string %u of %u", image->device->name, index, c->data[0]);
    const uint8_t *s = c->data + 1;
    while (--index > 0)
        s += 1 + s[0];
    assert_true(s + 1 + s[0] <= c->data + c->length);
    memcpy(text, s + 1, s[0]);
    text[s[0]] = 0;
    return text;
}

static void expect_text(const image_t *image, const char *what, unsigned int index, const char *want)
{
    char text[256];
    if (strcmp(string(image, index, text), want ? want : "") != 0)
        fail_msg("%s: %s: expected \"%s\", got \"%s\"", image->device->name, what, want ? want : "", text);
}

static void for_every_device(void (*check)(const image_t *))
{
    static image_t image;
    for (size_t i = 0; every_device(i); i++) {
        parse(&image, every_device(i), NULL, 0);
        check(&image);
    }
}

/* --- header ------------------------------------------------------------------------------------------------------- */

/* Bit by bit, from the words of G.2: polynomial x^8 + x^2 + x + 1, start 0xFF, most significant bit first. */
static uint8_t checksum(const uint8_t *bytes)
{
    uint8_t crc = 0xFF;
    for (int bit = 0; bit < 14 * 8; bit++) {
        int in = (bytes[bit / 8] >> (7 - bit % 8)) & 1;
        int out = crc >> 7;
        crc = (uint8_t)((crc << 1) ^ ((in ^ out) != 0 ? 0x07 : 0));
    }
    return crc;
}

static void checksums(void **state)
{
    static const uint8_t ek1100[14] = {0x00, 0x0D}, el2004[14] = {0x04, 0x01, 0, 0, 0, 0, 0x0F};
    uint8_t bytes[14];
    uint32_t random = 1;
    (void)state;
    assert_int_equal(ect_sii_checksum(ek1100), 0x46);
    assert_int_equal(ect_sii_checksum(el2004), 0xD8);
    for (int n = 0; n < 1000; n++) {
        for (size_t i = 0; i < sizeof bytes; i++)
            bytes[i] = (uint8_t)((random = random * 1664525u + 1013904223u) >> 24);
        assert_int_equal(ect_sii_checksum(bytes), checksum(bytes));
    }
}

static void check_header(const image_t *image)
{
    const ect_device_t *d = image->device;
    assert_memory_equal(image->bytes, d->esc_config, 8);
    assert_memory_equal(image->bytes + 10, d->esc_config + 10, 4);
    assert_int_equal(word(image, 4), 0);
    assert_int_equal(word(image, 7), checksum(image->bytes));
    assert_int_equal(two_words(image, 8), d->identity.vendor_id);
    assert_int_equal(two_words(image, 0xA), d->identity.product_code);
    assert_int_equal(two_words(image, 0xC), d->identity.revision);
    assert_int_equal(two_words(image, 0xE), d->identity.serial);
    static const ect_sm_t none[2];
    const ect_sm_t *sm = mailbox_sms_of(d) != 0 ? d->sm : none;
    const unsigned int mailbox[] = {d->boot_out.start, d->boot_out.length, d->boot_in.start,
                                    d->boot_in.length, sm[0].start,        sm[0].length,
                                    sm[1].start,       sm[1].length,       d->mailbox_protocols};
    for (unsigned int n = 0; n < 9; n++) {
        if (word(image, 0x14 + n) != mailbox[n])
            fail_msg("%s: word %02X: expected %04X, got %04X", d->name, 0x14 + n, mailbox[n], word(image, 0x14 + n));
    }
    for (unsigned int n = 0x10; n < 0x3E; n++)
        assert_true((n >= 0x14 && n <= 0x1C) || word(image, n) == 0);
    assert_int_equal((word(image, 0x3E) + 1) * 128, image->size);
    assert_int_equal(word(image, 0x3F), 1);
    assert_true(image->size <= SOEM_CACHE);
}

static void headers(void **state)
{
    (void)state;
    for_every_device(check_header);
}

static void identity_and_alias(void **state)
{
    static image_t image;
    const ect_identity_t identity = {0x11223344, 0x55667788, 0x99AABBCC, 0xDDEEFF00};
    (void)state;
    parse(&image, &testdev, &identity, 0xBEEF);
    assert_int_equal(two_words(&image, 8), identity.vendor_id);
    assert_int_equal(two_words(&image, 0xA), identity.product_code);
    assert_int_equal(two_words(&image, 0xC), identity.revision);
    assert_int_equal(two_words(&image, 0xE), identity.serial);
    assert_int_equal(word(&image, 4), 0xBEEF);
    assert_int_equal(word(&image, 7), checksum(image.bytes));
    assert_int_equal(category(&image, 30)->data[11],
                     0x0C); /* lost mails are repeated; identified by the AL status only */
}

/* --- categories --------------------------------------------------------------------------------------------------- */

static void check_order(const image_t *image)
{
    static const unsigned int known[] = {10, 30, 40, 41, 50, 51, 60};
    size_t k = 0;
    for (size_t i = 0; i < image->count; i++) {
        while (k < 7 && known[k] != image->categories[i].type)
            k++;
        if (k == 7)
            fail_msg("%s: category %u is unknown or out of order", image->device->name, image->categories[i].type);
    }
    for (unsigned int i = 0; i < 4; i++)
        assert_non_null(category(image, known[i]));
    assert_int_equal(category(image, 60) != NULL, image->device->dc_mode_count > 0);
    for (size_t at = image->end; at < image->size; at++)
        assert_int_equal(image->bytes[at], 0xFF);
}

static void order(void **state)
{
    (void)state;
    for_every_device(check_order);
}

static void check_strings(const image_t *image)
{
    const category_t *c = category(image, 10);
    char text[256], other[256];
    size_t used = 1;
    for (unsigned int n = 1; n <= c->data[0]; n++) {
        used += 1 + strlen(string(image, n, text));
        assert_true(strlen(text) > 0);
        for (unsigned int m = 1; m < n; m++)
            assert_string_not_equal(string(image, m, other), text);
    }
    assert_int_equal(c->length, (used + 1) / 2 * 2);
    if (used % 2 != 0)
        assert_int_equal(c->data[used], 0);
    expect_text(image, "string 1", 1, image->device->full_name ? image->device->full_name : image->device->type_name);
}

static void strings(void **state)
{
    (void)state;
    for_every_device(check_strings);
}

static void check_general(const image_t *image)
{
    const category_t *c = category(image, 30);
    const ect_device_t *d = image->device;
    assert_int_equal(c->length, 32);
    expect_text(image, "group", c->data[0], d->group_type);
    expect_text(image, "image", c->data[1], "");
    expect_text(image, "order", c->data[2], d->type_name);
    expect_text(image, "name", c->data[3], d->full_name ? d->full_name : d->type_name);
    expect_text(image, "group name", c->data[14], d->group_name);
    assert_int_equal(c->data[4], 0);
    assert_int_equal(c->data[15], 0);
    assert_int_equal(c->data[5], d->coe_details);
    assert_int_equal(c->data[6], (d->mailbox_protocols & 0x08) != 0);
    assert_int_equal(c->data[7], (d->mailbox_protocols & 0x02) != 0);
    for (int i = 8; i < 11; i++)
        assert_int_equal(c->data[i], 0);
    assert_int_equal(c->data[11], d->mailbox_protocols != 0 ? 0x0C : 0x08); /* as its ESI: DataLinkLayer, Reg134 */
    assert_int_equal((int16_t)ect_load_le16(c->data + 12), d->ebus_ma);
    unsigned int ports = 0;
    for (size_t i = 0; i < strlen(d->physics); i++)
        ports |= (d->physics[i] == 'Y' ? 1u : d->physics[i] == 'K' ? 3u : d->physics[i] == 'H' ? 4u : 0u) << (4 * i);
    assert_int_equal(c->data[16] | c->data[17] << 8, ports);
    for (int i = 18; i < 32; i++)
        assert_int_equal(c->data[i], 0);
}

static void general(void **state)
{
    (void)state;
    for_every_device(check_general);
}

static void check_fmmus_and_sms(const image_t *image)
{
    const category_t *fmmu = category(image, 40), *sm = category(image, 41);
    const ect_device_t *d = image->device;
    assert_int_equal(fmmu->length, (d->fmmu_count + 1u) / 2 * 2);
    for (size_t i = 0; i < fmmu->length; i++)
        assert_int_equal(fmmu->data[i], i < d->fmmu_count ? d->fmmu[i] : 0xFF);
    assert_int_equal(sm->length, 8u * d->sm_count);
    for (size_t i = 0; i < d->sm_count; i++) {
        const ect_sm_t *s = &d->sm[i];
        uint16_t length = ect_device_sm_bytes(d, (unsigned int)i);
        uint8_t want[8] = {(uint8_t)s->start, (uint8_t)(s->start >> 8),
                           (uint8_t)length,   (uint8_t)(length >> 8),
                           s->control,        0,
                           length > 0,        s->type};
        if (memcmp(sm->data + 8 * i, want, 8) != 0)
            fail_msg("%s: SM%zu of the SII is not the description's", d->name, i);
    }
    const ect_esc_personality_t *esc = ect_esc_personality(d->esc);
    assert_true(d->fmmu_count <= esc->fmmu_count && d->sm_count <= esc->sm_count);
}

static void fmmus_and_sms(void **state)
{
    (void)state;
    for_every_device(check_fmmus_and_sms);
}

/* --- PDOs: compared with the mapping objects as read by SDO ------------------------------------------------------- */

static uint32_t number(wire_t *w, uint16_t index, unsigned int subindex)
{
    uint8_t data[8] = {0};
    size_t size = sizeof data;
    const ect_od_t od = ect_device_od(wire_device(w, 0), NULL);
    if (!has_coe(wire_device(w, 0)))
        return ect_od_element(ect_od_find(&od, index), subindex); /* no other source */
    uint32_t code = wire_sdo_upload(w, 0, index, (uint8_t)subindex, false, data, &size);
    if (code != 0)
        fail_msg("%04Xh:%u: abort %08X", index, subindex, code);
    return ect_load_le32(data);
}

static const ect_entry_t *entry_of(const ect_device_t *device, uint32_t mapping)
{
    const ect_od_t od = {.objects = device->objects, .count = device->object_count};
    const ect_object_t *object;
    const ect_entry_t *entry = NULL;
    (void)ect_od_lookup(&od, (uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8), &object, &entry);
    return entry;
}

/* One PDO. @return its bits */
static uint32_t check_pdo(const image_t *image, wire_t *w, const uint8_t *pdo, const char *name)
{
    uint16_t index = ect_load_le16(pdo);
    uint32_t bits = 0;
    assert_int_equal(pdo[2], number(w, index, 0));
    assert_int_equal(pdo[4], 0);
    expect_text(image, "PDO", pdo[5], name);
    const ect_od_t od = ect_device_od(image->device, NULL);
    bool changes = ect_od_find(&od, index)->entries->data != NULL;
    bool chosen = pdo[3] < ECT_SMS && ect_od_find(&od, (uint16_t)(0x1C10 + pdo[3]))->entries->data != NULL;
    bool mandatory = pdo[3] < ECT_SMS && !chosen; /* ... and fixed */
    assert_int_equal(ect_load_le16(pdo + 6), changes ? 0 : mandatory ? 0x0011 : 0x0010);
    for (unsigned int n = 1; n <= pdo[2]; n++) {
        const uint8_t *e = pdo + 8 * n;
        uint32_t mapping = number(w, index, n);
        const ect_entry_t *entry = mapping >> 16 != 0 ? entry_of(image->device, mapping) : NULL;
        assert_int_equal(ect_load_le16(e), mapping >> 16);
        assert_int_equal(e[2], (mapping >> 8) & 0xFF);
        expect_text(image, "PDO entry", e[3], entry ? entry->name : "");
        assert_int_equal(e[4], entry ? entry->data_type : 0);
        assert_int_equal(e[5], mapping & 0xFF);
        assert_int_equal(ect_load_le16(e + 6), 0);
        assert_true(e[5] > 0 && (!entry || entry->bit_length == e[5]));
        bits += e[5];
    }
    return bits;
}

/* SyncManager that lists a PDO; 0xFF: none. */
static uint8_t sm_of(wire_t *w, uint16_t pdo)
{
    const ect_device_t *d = wire_device(w, 0);
    for (uint8_t n = 0; n < d->sm_count; n++) {
        bool process = (process_sms_of(d) >> n & 1) != 0;
        for (unsigned int k = 1; process && k <= number(w, (uint16_t)(0x1C10 + n), 0); k++) {
            if (number(w, (uint16_t)(0x1C10 + n), k) == pdo)
                return n;
        }
    }
    return 0xFF;
}

static void check_pdos(const image_t *image)
{
    const ect_device_t *d = image->device;
    const ect_od_t od = ect_device_od(d, NULL);
    uint32_t bits[ECT_SMS] = {0};
    wire_t w;
    wire_open_one(&w, d);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (unsigned int direction = 0; direction < 2; direction++) {
        const category_t *c = category(image, direction == 0 ? 51 : 50);
        size_t at = 0;
        for (uint16_t index = direction == 0 ? 0x1600 : 0x1A00; index % 0x200 != 0x1FF; index++) {
            const ect_object_t *object = ect_od_find(&od, index);
            if (!object)
                continue;
            assert_non_null(c);
            const uint8_t *pdo = c->data + at;
            assert_int_equal(ect_load_le16(pdo), index);
            assert_int_equal(pdo[3], sm_of(&w, index));
            uint32_t length = check_pdo(image, &w, pdo, object->name);
            if (pdo[3] < ECT_SMS)
                bits[pdo[3]] += length;
            at += 8u + 8u * pdo[2];
        }
        assert_int_equal(at, c ? c->length : 0);
    }
    for (unsigned int n = 0; n < d->sm_count; n++) {
        if ((process_sms_of(d) >> n & 1) != 0)
            assert_int_equal((bits[n] + 7) / 8, ect_load_le16(category(image, 41)->data + (size_t)8 * n + 2));
    }
    wire_close(&w);
}

static void pdos(void **state)
{
    (void)state;
    for_every_device(check_pdos);
}

/* --- a device with everything ----------------------------------------------------------------------------------- */

static const ect_dc_mode_t modes[] = {{.name = "FreeRun", .description = "No sync"},
                                      {.name = "DC",
                                       .description = "SYNC0",
                                       .assign_activate = 0x0300,
                                       .cycle_sync0_ns = 1000000,
                                       .factor_sync0 = -2,
                                       .factor_sync1 = 3,
                                       .shift_sync0_ns = -5000,
                                       .shift_sync1_ns = 70000}};

static ect_device_t rich_device(void)
{
    static const ect_entry_t spare[] = {ECT_ENTRY_COUNT(2), ECT_ENTRY_MAP(1, ECT_MAP(0x6000, 1, 16)),
                                        ECT_ENTRY_MAP(2, ECT_MAP(0x6666, 1, 8))};
    static const ect_entry_t free_entries[] = {
        {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW_PREOP, "Count", 1, ECT_OFFSET(testdev_t, record_ro)},
        {1, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW_PREOP, "Mapped object", ECT_MAP(0x6000, 1, 16),
         ECT_OFFSET(testdev_t, u32)}};
    static const ect_entry_t assign[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};
    static const ect_pdo_t properties[] = {{.index = 0x1A02, .flags = ECT_PDO_VIRTUAL | ECT_PDO_MANDATORY}};
    static ect_object_t objects[5];
    ect_device_t device = testdev;
    objects[0] = (ect_object_t)ECT_RECORD(0x1A00, "Inputs", free_entries);
    objects[1] = (ect_object_t)ECT_RECORD(0x1A01, "Spare inputs", spare);
    objects[2] = (ect_object_t)ECT_RECORD(0x1A02, "Inputs with properties", spare);
    objects[3] = (ect_object_t)ECT_ARRAY(0x1C13, "Assignment", assign);
    objects[4] = *ect_od_find(&(ect_od_t){.objects = testdev.objects, .count = testdev.object_count}, 0x6000);
    device.objects = objects;
    device.object_count = 5;
    device.pdos = properties;
    device.pdo_count = 1;
    device.full_name = "A device with everything";
    device.group_type = "G"; /* the shortest possible string, twice */
    device.group_name = "G";
    device.ebus_ma = -130;
    device.mailbox_protocols = 0x0E;
    device.coe_details = 0x0F;
    device.boot_out = (ect_boot_mailbox_t){0x1000, 0x100};
    device.boot_in = (ect_boot_mailbox_t){0x1100, 0x180};
    device.physics = "YK H";
    device.fmmu_count = 2;
    device.dc_modes = modes;
    device.dc_mode_count = 2;
    return device;
}

static void everything(void **state)
{
    static image_t image;
    ect_device_t device = rich_device();
    (void)state;
    parse(&image, &device, NULL, 0);
    check_header(&image);
    check_order(&image);
    check_strings(&image);
    check_general(&image);
    check_fmmus_and_sms(&image);
    const category_t *dc = category(&image, 60), *tx = category(&image, 50);
    assert_int_equal(dc->length, 48);
    for (size_t i = 0; i < 2; i++) {
        uint8_t want[24] = {0};
        ect_store_le32(want, modes[i].cycle_sync0_ns);
        ect_store_le32(want + 4, (uint32_t)modes[i].shift_sync0_ns);
        ect_store_le32(want + 8, (uint32_t)modes[i].shift_sync1_ns);
        ect_store_le16(want + 12, (uint16_t)modes[i].factor_sync1);
        ect_store_le16(want + 14, modes[i].assign_activate);
        ect_store_le16(want + 16, (uint16_t)modes[i].factor_sync0);
        want[18] = dc->data[24 * i + 18];
        want[19] = dc->data[24 * i + 19];
        assert_memory_equal(dc->data + 24 * i, want, 24);
        expect_text(&image, "DC mode", want[18], modes[i].name);
        expect_text(&image, "DC description", want[19], modes[i].description);
    }
    assert_null(category(&image, 51));
    assert_int_equal(tx->length, 16 + 2 * 24);
    assert_int_equal(tx->data[3], 3);
    assert_int_equal(ect_load_le16(tx->data + 6), 0); /* a changeable mapping: not fixed */
    const uint8_t *spare = tx->data + 16, *virtual_one = spare + 24;
    assert_int_equal(spare[3], 0xFF); /* not assigned: fixed, not mandatory */
    assert_int_equal(ect_load_le16(spare + 6), 0x0010);
    expect_text(&image, "missing entry", spare[16 + 3], "");
    assert_int_equal(ect_load_le16(virtual_one + 6), 0x0021); /* from the description */
}

/* As in an ESI that contains the EEPROM's content: only the identity may be changed. */
static void image_brought_along(void **state)
{
    static uint8_t original[2048], got[2048];
    static const ect_identity_t identity = {1, 2, 3, 4};
    ect_device_t device = testdev;
    (void)state;
    for (size_t i = 0; i < sizeof original; i++)
        original[i] = (uint8_t)(i * 7);
    device.sii = original;
    assert_int_equal(ect_sii_write(&device, &identity, 0x1234, got, sizeof got), 2048);
    for (size_t i = 0; i < sizeof got; i++) {
        bool renewed = i == 8 || i == 9 || i == 14 || (i >= 16 && i < 32);
        if (!renewed && got[i] != original[i])
            fail_msg("byte %zu: expected %02X, got %02X", i, original[i], got[i]);
    }
    assert_int_equal(ect_load_le16(got + 8), 0x1234);
    assert_int_equal(got[14], checksum(got));
    for (unsigned int i = 0; i < 4; i++)
        assert_int_equal(ect_load_le32(got + 16 + (size_t)4 * i), i + 1);
}

/* --- what does not fit -------------------------------------------------------------------------------------------- */

static void too_small(void **state)
{
    static const size_t sizes[] = {0, 1, 127, 128, 1024, 2047};
    uint8_t image[2048];
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
        assert_int_equal(ect_sii_write(&testdev, NULL, 0, image, sizes[i]), -1);
    assert_int_equal(ect_sii_write(&testdev, NULL, 0, image, 2048), 2048);
    ect_device_t device = testdev;
    device.sii_size = 0;
    assert_true(ect_sii_write(&device, NULL, 0, image, sizeof image) < 0);
}

/* Every EEPROM from 256 bytes on, in memory of exactly that size: the whole image, or the one without the names of PDO
 * entries, or a refusal. */
static void every_eeprom_size(void **state)
{
    static image_t image, short_image;
    ect_device_t device = rich_device();
    (void)state;
    parse(&image, &device, NULL, 0);
    device.sii_size = (uint16_t)image.end;
    parse(&short_image, &device, NULL, 0);
    assert_true(short_image.end < image.end);
    for (uint16_t size = 256; size <= 1024; size = (uint16_t)(size + 2)) {
        uint8_t *block = malloc(size);
        assert_non_null(block);
        device.sii_size = size;
        int32_t got = ect_sii_write(&device, NULL, 0, block, size);
        const image_t *fits = size >= image.end + 2 ? &image : &short_image;
        int32_t want = size >= fits->end + 2 ? size : -2;
        if (got != want || (got > 0 && memcmp(block + 0x80, fits->bytes + 0x80, fits->end + 2 - 0x80) != 0))
            fail_msg("an image of %zu bytes in an EEPROM of %u: expected %d, got %d, or another content", fits->end + 2,
                     size, want, got);
        free(block);
    }
}

static void string_table_overflow(void **state)
{
    static char names[260][8], longest[257];
    static ect_entry_t entries[130];
    static ect_object_t objects[130];
    static uint8_t image[32768];
    (void)state;
    entries[0] = (ect_entry_t){0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Count", 0, NULL};
    for (uint16_t i = 0; i < 260; i++)
        (void)sprintf(names[i], "N%u", i);
    static ect_object_t many[260];
    for (uint16_t i = 0; i < 260; i++)
        many[i] = (ect_object_t){(uint16_t)(0x1A00 + i), ECT_OBJECT_RECORD, 0, 0, names[i], entries};
    ect_device_t device = testdev;
    device.sii_size = 32768;
    device.objects = many;
    device.object_count = 252; /* 255 with the three names of the device */
    assert_int_equal(ect_sii_write(&device, NULL, 0, image, sizeof image), 32768);
    device.object_count = 253;
    assert_int_equal(ect_sii_write(&device, NULL, 0, image, sizeof image), -2);
    memset(longest, 'x', 256);
    objects[0] = (ect_object_t){0x1A00, ECT_OBJECT_RECORD, 0, 0, longest, entries};
    device.objects = objects;
    device.object_count = 1;
    assert_int_equal(ect_sii_write(&device, NULL, 0, image, sizeof image), -2);
    longest[255] = 0;
    assert_int_equal(ect_sii_write(&device, NULL, 0, image, sizeof image), 32768);
}

static void long_names_of_entries(void **state)
{
    static const struct {
        size_t length;
        bool there;
    } rows[] = {{0, false}, {1, true}, {254, true}, {255, true}, {256, false}};
    static const ect_entry_t mapping[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_MAP(1, ECT_MAP(0x6000, 0, 16))};
    static char name[257];
    static const ect_entry_t word[] = {{0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, name, 0, NULL}};
    static const ect_object_t objects[] = {ECT_RECORD(0x1A00, "Inputs", mapping), ECT_VAR(0x6000, "Word", word)};
    static image_t image;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = testdev;
        device.objects = objects;
        device.object_count = 2;
        memset(name, 0, sizeof name);
        memset(name, 'x', rows[i].length);
        parse(&image, &device, NULL, 0);
        unsigned int index = category(&image, 50)->data[8 + 3];
        if ((index != 0) != rows[i].there)
            fail_msg("a name of %zu characters: expected string %s, got %u", rows[i].length,
                     rows[i].there ? "that is not 0" : "0", index);
        expect_text(&image, "entry", index, rows[i].there ? name : "");
    }
}

/* No room, not even for the string category's header. */
static void eeprom_of_128_bytes(void **state)
{
    ect_device_t device = testdev;
    uint8_t *block = malloc(128);
    (void)state;
    assert_non_null(block);
    device.sii_size = 128;
    assert_int_equal(ect_sii_write(&device, NULL, 0, block, 128), -2);
    free(block);
}

/* --- reading damaged images --------------------------------------------------------------------------------------- */

/* Reads every category and string of an image in memory of exactly its size. */
static void read_all(const uint8_t *image, size_t size)
{
    static const uint16_t types[] = {0, 10, 20, 30, 40, 41, 43, 50, 51, 60, 0xFFFF};
    uint8_t *block = malloc(size > 0 ? size : 1);
    assert_non_null(block);
    memcpy(block, image, size);
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        size_t length = 0;
        const uint8_t *data = ect_sii_category(block, size, types[i], &length);
        if (data && (data < block || length > size - (size_t)(data - block)))
            fail_msg("category %u of an image of %zu bytes leaves it", types[i], size);
    }
    for (unsigned int i = 0; i <= 255; i++) {
        uint8_t length = 0;
        const char *text = ect_sii_string(block, size, (uint8_t)i, &length);
        if (text && ((const uint8_t *)text < block || length > size - (size_t)((const uint8_t *)text - block)))
            fail_msg("string %u of an image of %zu bytes leaves it", i, size);
    }
    free(block);
}

static void reading_whole_images(void **state)
{
    static image_t image;
    ect_device_t device = rich_device();
    char text[256];
    uint8_t n = 0;
    size_t length = 0;
    (void)state;
    parse(&image, &device, NULL, 0);
    for (size_t i = 0; i < image.count; i++) {
        const category_t *c = &image.categories[i];
        assert_ptr_equal(ect_sii_category(image.bytes, image.size, (uint16_t)c->type, &length), c->data);
        assert_int_equal(length, c->length);
    }
    assert_null(ect_sii_category(image.bytes, image.size, 20, &length));
    assert_null(ect_sii_category(image.bytes, image.size, ECT_SII_END, &length));
    unsigned int count = category(&image, 10)->data[0];
    for (unsigned int i = 1; i <= count; i++) {
        const char *got = ect_sii_string(image.bytes, image.size, (uint8_t)i, &n);
        assert_non_null(got);
        assert_int_equal(n, strlen(string(&image, i, text)));
        assert_memory_equal(got, text, n);
    }
    assert_null(ect_sii_string(image.bytes, image.size, 0, &n));
    assert_null(ect_sii_string(image.bytes, image.size, (uint8_t)(count + 1), &n));
    assert_null(ect_sii_string(image.bytes, image.size, 255, &n));
}

static void truncated_images(void **state)
{
    static image_t image;
    ect_device_t device = rich_device();
    (void)state;
    parse(&image, &device, NULL, 0);
    for (size_t size = 0; size <= image.size; size++) {
        size_t length = 0;
        read_all(image.bytes, size);
        for (size_t i = 0; i < image.count; i++) {
            const category_t *c = &image.categories[i];
            bool there = (size_t)(c->data - image.bytes) + c->length <= size;
            const uint8_t *got = ect_sii_category(image.bytes, size, (uint16_t)c->type, &length);
            if ((got != NULL) != there)
                fail_msg("category %u in the first %zu bytes: expected %d", c->type, size, there);
        }
    }
}

static void damaged_images(void **state)
{
    static image_t image;
    static uint8_t bytes[2048];
    ect_device_t device = rich_device();
    uint32_t random = 7;
    (void)state;
    parse(&image, &device, NULL, 0);
    for (int n = 0; n < 3000; n++) {
        memcpy(bytes, image.bytes, sizeof bytes);
        for (int hits = 0; hits < 1 + n % 5; hits++) {
            random = random * 1664525u + 1013904223u;
            size_t at = 0x80 + (random >> 8) % (image.end - 0x80);
            bytes[at] = n % 3 == 0 ? 0xFF : n % 3 == 1 ? 0 : (uint8_t)(random >> 16);
        }
        read_all(bytes, n % 2 == 0 ? sizeof bytes : image.end - (size_t)n % 64);
    }
}

/* A string table whose lengths, count and category length are inconsistent. */
static void damaged_string_tables(void **state)
{
    static const struct {
        const char *what;
        uint8_t table[8];
        uint8_t words;
        uint8_t good; /* strings that are still readable */
    } rows[] = {
        {"sound", {2, 2, 'a', 'b', 1, 'c'}, 3, 2},
        {"empty", {0}, 0, 0},
        {"more than are counted", {1, 2, 'a', 'b', 1, 'c'}, 3, 1},
        {"no strings", {0, 0}, 1, 0},
        {"count too large", {9, 2, 'a', 'b', 1, 'c'}, 3, 2},
        {"second one too long", {2, 2, 'a', 'b', 2, 'c'}, 3, 1},
        {"first one beyond the end", {2, 9, 'a', 'b', 1, 'c'}, 3, 0},
        {"only the count", {3, 1, 'a', 0}, 1, 0},
        {"ends before the second", {2, 2, 'a', 'b'}, 2, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t image[0x80 + 4 + 8] = {0};
        size_t size = 0x84 + 2u * rows[i].words;
        image[0x80] = 10;
        image[0x82] = rows[i].words;
        memcpy(image + 0x84, rows[i].table, 8);
        read_all(image, size);
        for (unsigned int n = 1; n <= 4; n++) {
            uint8_t length;
            bool there = ect_sii_string(image, size, (uint8_t)n, &length) != NULL;
            if (there != (n <= rows[i].good))
                fail_msg("string table \"%s\": string %u is %sthere", rows[i].what, n, there ? "" : "not ");
        }
    }
}

/* --- over the bus ------------------------------------------------------------------------------------------------- */

static void check_over_the_bus(const image_t *image)
{
    wire_t w;
    wire_open_one(&w, image->device);
    assert_int_equal(wire_read16(&w, 0, 0x0140), word(image, 0));
    assert_int_equal(wire_read16(&w, 0, 0x0012), word(image, 4));
    for (unsigned int n = 0; n < image->size / 2; n += 2) {
        uint8_t command[6] = {0x00, 0x01}, data[4];
        ect_store_le32(command + 2, n);
        assert_int_equal(wire_write(&w, 0, 0x0502, command, sizeof command), 1);
        while ((wire_read16(&w, 0, 0x0502) & 0x8000) != 0)
            wire_advance(&w, MS);
        assert_int_equal(wire_read(&w, 0, 0x0508, data, 4), 1);
        if (memcmp(data, image->bytes + 2 * n, 4) != 0)
            fail_msg("%s: words %03X and %03X read over the bus are not the image's", image->device->name, n, n + 1);
    }
    wire_close(&w);
}

static void over_the_bus(void **state)
{
    (void)state;
    for_every_device(check_over_the_bus);
}

static void check_protocols(const image_t *image)
{
    if (mailbox_sms_of(image->device) == 0)
        return;
    static const struct {
        uint8_t type, bit;
    } protocols[] = {{1, 0x01}, {2, 0x02}, {3, 0x04}, {4, 0x08}, {5, 0x10}, {15, 0x20}};
    wire_t w;
    wire_open_one(&w, image->device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (uint8_t i = 0; i < 6; i++) {
        uint8_t mail[16] = {10, 0, 0, 0, 0, (uint8_t)(protocols[i].type | (i + 1) << 4), 0, 0x20, 0x40, 0, 0x10};
        uint8_t reply[300];
        bool offered = (word(image, 0x1C) & protocols[i].bit) != 0;
        assert_int_equal(wire_mail_send(&w, 0, mail, sizeof mail), 1);
        int length = wire_mail_receive(&w, 0, reply, sizeof reply);
        uint8_t type = reply[5] & 0x0F;
        if (offered ? type != protocols[i].type
                    : length != 4 || type != 0 || ect_load_le16(reply + 6) != 1 || ect_load_le16(reply + 8) != 2)
            fail_msg("%s: protocol %u is %soffered, the reply has type %u", image->device->name, protocols[i].type,
                     offered ? "" : "not ", type);
    }
    wire_close(&w);
}

static void protocols_answer(void **state)
{
    (void)state;
    for_every_device(check_protocols);
}

static void check_identity_object(const image_t *image)
{
    if (!has_coe(image->device))
        return;
    wire_t w;
    wire_open_one(&w, image->device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (unsigned int n = 0; n < 4; n++)
        assert_int_equal(number(&w, 0x1018, n + 1), two_words(image, 8 + 2 * n));
    wire_close(&w);
}

static void identity_object(void **state)
{
    (void)state;
    for_every_device(check_identity_object);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-054: the checksum of two real images and of 1000 random ones", checksums, NULL, NULL, NULL},
        {"CF-054 CF-057: words 00 to 3F: configuration, checksum, identity, mailboxes, size; it fits SOEM's cache",
         headers, NULL, NULL, NULL},
        {"CF-057 CF-054: an installation's own identity and alias are in the image, the checksum with them",
         identity_and_alias, NULL, NULL, NULL},
        {"CF-060: the categories come once and in order, then the end marker and FFh", order, NULL, NULL, NULL},
        {"CF-064: the string table is whole, without doubles, the device's name first", strings, NULL, NULL, NULL},
        {"CF-060 CF-064: General has 32 bytes: names, CoE details, protocols, ports", general, NULL, NULL, NULL},
        {"CF-060: FMMUs and SyncManagers as described and as many as the ESC has", fmmus_and_sms, NULL, NULL, NULL},
        {"CF-061 CF-064: PDOs equal the mapping objects entry by entry, their sum is the SyncManager's length", pdos,
         NULL, NULL, NULL},
        {"CF-057: identity words equal 1018h", identity_object, NULL, NULL, NULL},
        {"CF-058: each advertised protocol replies, each other one gets mailbox error 2", protocols_answer, NULL, NULL,
         NULL},
        {"CF-054 CF-066: the image read over the bus, PDI control and alias register equal it", over_the_bus, NULL,
         NULL, NULL},
        {"CF-060 CF-061 CF-062: a device with everything: bootstrap, DC modes, FoE and EoE, a PDO not assigned",
         everything, NULL, NULL, NULL},
        {"CF-057: an image that the description brings along keeps all but identity, alias and checksum",
         image_brought_along, NULL, NULL, NULL},
        {"CF-060: a buffer that is too small is refused", too_small, NULL, NULL, NULL},
        {"CF-060: an EEPROM that is too small is refused, at every size", every_eeprom_size, NULL, NULL, NULL},
        {"CF-064: more than 255 strings, or one of more than 255 characters, are refused", string_table_overflow, NULL,
         NULL, NULL},
        {"CF-064: the name of an entry is omitted only if it is empty or has more than 255 characters",
         long_names_of_entries, NULL, NULL, NULL},
        {"CF-060 CF-064: every category and string of an image is found again", reading_whole_images, NULL, NULL, NULL},
        {"CF-060: truncated at every byte, an image is read up to its end only", truncated_images, NULL, NULL, NULL},
        {"CF-060: 3000 damaged images are never read beyond their end", damaged_images, NULL, NULL, NULL},
        {"CF-064: damaged string tables give the strings that are whole", damaged_string_tables, NULL, NULL, NULL},
        {"CF-060: an EEPROM of 128 bytes is refused without reading beyond it", eeprom_of_128_bytes, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SII", tests, NULL, NULL);
}
