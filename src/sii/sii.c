/* SPDX-License-Identifier: MIT */
#include "sii/sii.h"

#include <stdbool.h>
#include <string.h>

#include "wire/bytes.h"
#include "wire/crc.h"
#include "wire/sii.h"

enum { LONGEST_STRING = 255 };

/* --- writing: a pen that ends at the end of the EEPROM ------------------------------------------------------------ */

typedef struct pen {
    const ect_device_t *device;
    uint8_t *image;
    size_t size;
    size_t at;
    size_t category;   /* start of the present category */
    size_t strings;    /* data of the string category */
    unsigned int omit; /* ECT_OMIT_...: omitted for lack of room */
    bool overflow;
} pen_t;

static void put8(pen_t *p, unsigned int value)
{
    if (p->at < p->size)
        p->image[p->at++] = (uint8_t)value;
    else
        p->overflow = true;
}

static void put16(pen_t *p, unsigned int value)
{
    put8(p, value & 0xFF);
    put8(p, value >> 8);
}

static void put32(pen_t *p, uint32_t value)
{
    put16(p, value & 0xFFFF);
    put16(p, value >> 16);
}

static void begin(pen_t *p, uint16_t category)
{
    p->category = p->at;
    put16(p, category);
    put16(p, 0);
}

static void end(pen_t *p, uint8_t filler)
{
    if ((p->at - p->category) % 2 != 0)
        put8(p, filler);
    if (!p->overflow)
        ect_store_le16(p->image + p->category + 2, (uint16_t)((p->at - p->category - 4) / 2));
}

/* Index of a string in the table; 0: not there. */
static uint8_t string_index(const pen_t *p, const char *text)
{
    size_t length = text && !p->overflow ? strlen(text) : 0;
    if (length == 0)
        return 0;
    const uint8_t *table = p->image + p->strings;
    const uint8_t *s = table + 1;
    for (unsigned int i = 1; i <= table[0]; i++, s += 1 + s[0]) {
        if (s[0] == length && memcmp(s + 1, text, length) == 0)
            return (uint8_t)i;
    }
    return 0;
}

static void intern(pen_t *p, const char *text)
{
    size_t length = text ? strlen(text) : 0;
    if (length == 0 || p->overflow || string_index(p, text) != 0)
        return;
    uint8_t *count = p->image + p->strings;
    if (*count == UINT8_MAX || length > LONGEST_STRING || p->at + 1 + length > p->size) {
        p->overflow = true;
        return;
    }
    put8(p, (unsigned int)length);
    memcpy(p->image + p->at, text, length);
    p->at += length;
    (*count)++;
}

/* --- PDOs -------------------------------------------------------------------------------------------------------- */

static bool is_pdo(const ect_object_t *object, bool outputs)
{
    return outputs ? ect_od_is_rxpdo(object->index) : ect_od_is_txpdo(object->index);
}

uint8_t ect_sii_pdo_sm(const ect_device_t *device, uint16_t pdo)
{
    ect_od_t od = ect_device_od(device, NULL);
    for (unsigned int sm = 0; sm < device->sm_count; sm++) {
        for (const uint16_t *of = device->sm[sm].pdos; of && *of != 0; of++) {
            if (*of == pdo)
                return (uint8_t)sm;
        }
        const ect_object_t *assignment = ect_od_find(&od, (uint16_t)(ECT_OD_ASSIGNMENT + sm));
        for (uint32_t i = 1; ect_device_sm_is_process(device, sm) && i <= ect_od_element(assignment, 0); i++) {
            if (ect_od_element(assignment, i) == pdo)
                return (uint8_t)sm;
        }
    }
    return 0xFF;
}

static const ect_telegram_t *telegram_of(const ect_device_t *device, uint16_t pdo)
{
    for (unsigned int i = 0; i < device->telegram_count; i++) {
        if (device->telegrams[i].index == pdo)
            return &device->telegrams[i];
    }
    return NULL;
}

uint16_t ect_sii_pdo_number(const ect_device_t *device, uint16_t pdo)
{
    const ect_telegram_t *telegram = telegram_of(device, pdo);
    return telegram ? telegram->number : pdo;
}

uint32_t ect_sii_pdo_element(const ect_device_t *device, const ect_object_t *pdo, uint32_t n)
{
    const ect_telegram_t *telegram = telegram_of(device, pdo->index);
    const uint32_t mapping = ect_od_element(pdo, n);
    return telegram ? (uint32_t)telegram->idns[n - 1] << 16 | (mapping & 0xFF) : mapping;
}

/* Whether no entry is in memory, so that the object cannot change. */
static bool is_constant(const ect_object_t *object)
{
    for (const ect_entry_t *e = object ? object->entries : NULL; e; e = ect_od_next(object, e)) {
        if (e->data)
            return false;
    }
    return true;
}

uint16_t ect_sii_pdo_flags(const ect_device_t *device, const ect_object_t *pdo)
{
    uint8_t sm = ect_sii_pdo_sm(device, pdo->index);
    ect_od_t od = ect_device_od(device, NULL);
    for (unsigned int i = 0; i < device->pdo_count; i++) {
        if (device->pdos[i].index == pdo->index)
            return device->pdos[i].flags;
    }
    if (!is_constant(pdo))
        return 0;
    bool mandatory = sm != 0xFF && is_constant(ect_od_find(&od, (uint16_t)(ECT_OD_ASSIGNMENT + sm)));
    return mandatory ? ECT_PDO_FIXED | ECT_PDO_MANDATORY : ECT_PDO_FIXED;
}

static void intern_entries(pen_t *p, const ect_object_t *pdo)
{
    ect_od_t od = ect_device_od(p->device, NULL);
    for (uint32_t n = 1; n <= ect_od_element(pdo, 0); n++) {
        const ect_entry_t *entry = ect_od_mapped(&od, ect_od_element(pdo, n));
        bool table_full = !p->overflow && p->image[p->strings] == UINT8_MAX;
        if (entry && entry->name && strlen(entry->name) <= LONGEST_STRING && !table_full)
            intern(p, entry->name);
    }
}

/* The names of all PDOs first, because they are few. */
static void intern_pdos(pen_t *p)
{
    const ect_device_t *device = p->device;
    for (unsigned int round = p->omit; round < ECT_OMIT_PDO_NAMES; round++) {
        for (uint16_t i = 0; i < device->object_count; i++) {
            const ect_object_t *object = &device->objects[i];
            if (!is_pdo(object, true) && !is_pdo(object, false))
                continue;
            if (round == p->omit)
                intern(p, object->name);
            else
                intern_entries(p, object);
        }
    }
}

static void put_pdo_entry(pen_t *p, uint32_t mapping, uint32_t written)
{
    ect_od_t od = ect_device_od(p->device, NULL);
    const ect_entry_t *entry = ect_od_mapped(&od, mapping);
    put16(p, written >> 16);
    put8(p, (mapping >> 8) & 0xFF);
    put8(p, entry ? string_index(p, entry->name) : 0);
    put8(p, entry ? entry->data_type & 0xFFu : 0);
    put8(p, mapping & 0xFF);
    put16(p, 0);
}

static void put_pdos(pen_t *p, bool outputs)
{
    const ect_device_t *device = p->device;
    bool any = false;
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        uint8_t sm = ect_sii_pdo_sm(device, object->index);
        if (!is_pdo(object, outputs) || p->omit >= ECT_OMIT_PDOS || (p->omit >= ECT_OMIT_FREE_PDOS && sm == 0xFF))
            continue;
        if (!any)
            begin(p, outputs ? ECT_SII_RXPDO : ECT_SII_TXPDO);
        any = true;
        put16(p, ect_sii_pdo_number(device, object->index));
        put8(p, ect_od_element(object, 0));
        put8(p, sm);
        put8(p, 0);
        put8(p, string_index(p, object->name));
        put16(p, ect_sii_pdo_flags(device, object));
        for (uint32_t n = 1; n <= ect_od_element(object, 0); n++)
            put_pdo_entry(p, ect_od_element(object, n), ect_sii_pdo_element(device, object, n));
    }
    if (any)
        end(p, 0);
}

/* --- the other parts --------------------------------------------------------------------------------------------- */

static const ect_sm_t *find_sm(const ect_device_t *device, uint8_t type)
{
    static const ect_sm_t none = {0};
    for (unsigned int i = 0; i < device->sm_count; i++) {
        if (device->sm[i].type == type)
            return &device->sm[i];
    }
    return &none;
}

/* Fields that an installation may override. */
static void put_identity(uint8_t *w, const ect_identity_t *identity, uint16_t alias)
{
    ect_store_le16(w + ECT_SII_AT_ALIAS, alias);
    w[ECT_SII_AT_CHECKSUM] = ect_sii_checksum(w);
    ect_store_le32(w + ECT_SII_AT_VENDOR, identity->vendor_id);
    ect_store_le32(w + ECT_SII_AT_PRODUCT, identity->product_code);
    ect_store_le32(w + ECT_SII_AT_REVISION, identity->revision);
    ect_store_le32(w + ECT_SII_AT_SERIAL, identity->serial);
}

static void put_header(pen_t *p, const ect_identity_t *identity, uint16_t alias)
{
    const ect_device_t *device = p->device;
    uint8_t *w = p->image;
    const ect_sm_t *out = find_sm(device, ECT_SM_MAILBOX_OUT);
    const ect_sm_t *in = find_sm(device, ECT_SM_MAILBOX_IN);
    memset(w, 0, ECT_SII_CATEGORIES);
    memcpy(w, device->esc_config, sizeof device->esc_config);
    put_identity(w, identity, alias);
    ect_store_le16(w + ECT_SII_AT_BOOT_OUT, device->boot_out.start);
    ect_store_le16(w + ECT_SII_AT_BOOT_OUT + 2, device->boot_out.length);
    ect_store_le16(w + ECT_SII_AT_BOOT_IN, device->boot_in.start);
    ect_store_le16(w + ECT_SII_AT_BOOT_IN + 2, device->boot_in.length);
    ect_store_le16(w + ECT_SII_AT_MAILBOX_OUT, out->start);
    ect_store_le16(w + ECT_SII_AT_MAILBOX_OUT + 2, out->length);
    ect_store_le16(w + ECT_SII_AT_MAILBOX_IN, in->start);
    ect_store_le16(w + ECT_SII_AT_MAILBOX_IN + 2, in->length);
    ect_store_le16(w + ECT_SII_AT_PROTOCOLS, device->mailbox_protocols);
    ect_store_le16(w + ECT_SII_AT_SIZE, (uint16_t)(device->sii_size / 128 - 1)); /* KBit - 1 */
    ect_store_le16(w + ECT_SII_AT_VERSION, 1);
    p->at = ECT_SII_CATEGORIES;
}

static const char *name_of(const ect_device_t *device)
{
    return device->full_name ? device->full_name : device->type_name;
}

/* The device's name is string 1, because some masters use string 1 as the name without reading the index. */
static void put_strings(pen_t *p)
{
    const ect_device_t *device = p->device;
    begin(p, ECT_SII_STRINGS);
    p->strings = p->at;
    put8(p, 0);
    intern(p, name_of(device));
    intern(p, device->type_name);
    intern(p, device->group_type);
    intern(p, device->group_name);
    for (unsigned int i = 0; p->omit < ECT_OMIT_MODE_TEXTS && i < device->dc_mode_count; i++) {
        intern(p, device->dc_modes[i].name);
        intern(p, device->dc_modes[i].description);
    }
    intern_pdos(p); /* last: the names of entries may not fit */
    end(p, 0);
}

static unsigned int port(char letter)
{
    return letter == 'Y' ? 1u : letter == 'K' ? 3u : letter == 'H' ? 4u : 0u;
}

/* Port types of the physics letters, four bits for each port: MII, EBUS, fast hot connect. */
static unsigned int ports(const char *physics)
{
    unsigned int value = 0;
    for (unsigned int i = 0; i < 4 && physics[i] != 0; i++)
        value |= port(physics[i]) << (4 * i);
    return value;
}

static void put_general(pen_t *p, uint16_t alias)
{
    const ect_device_t *device = p->device;
    unsigned int flags = ect_device_general_flags(device);
    begin(p, ECT_SII_GENERAL);
    put8(p, string_index(p, device->group_type));
    put8(p, 0);
    put8(p, string_index(p, device->type_name));
    put8(p, string_index(p, name_of(device)));
    put8(p, 0);
    put8(p, device->coe_details);
    put8(p, (device->mailbox_protocols & ECT_MAILBOX_FOE) != 0);
    put8(p, (device->mailbox_protocols & ECT_MAILBOX_EOE) != 0);
    put8(p, device->soe_channels);
    put16(p, 0); /* DS402 channels, SysmanClass */
    put8(p, alias != 0 ? flags | ECT_GENERAL_ID_AL_STATUS : flags);
    put16(p, (uint16_t)device->ebus_ma);
    put8(p, string_index(p, device->group_name));
    put8(p, 0);
    put16(p, ports(device->physics));
    put16(p, device->id_address);
    for (int i = 0; i < 12; i++)
        put8(p, 0);
    end(p, 0);
}

static void put_fmmus(pen_t *p)
{
    begin(p, ECT_SII_FMMU);
    for (unsigned int i = 0; i < p->device->fmmu_count; i++)
        put8(p, p->device->fmmu[i]);
    end(p, 0xFF);
}

static void put_sms(pen_t *p)
{
    begin(p, ECT_SII_SYNCM);
    for (unsigned int i = 0; i < p->device->sm_count; i++) {
        const ect_sm_t *sm = &p->device->sm[i];
        uint16_t bytes = ect_device_sm_bytes(p->device, i);
        put16(p, sm->start);
        put16(p, bytes);
        put8(p, sm->control);
        put8(p, 0);
        put8(p, (bytes > 0 ? 1u : 0u) | sm->flags);
        put8(p, ect_sm_role(sm));
    }
    end(p, 0);
}

static void put_dc(pen_t *p)
{
    const ect_device_t *device = p->device;
    if (device->dc_mode_count == 0)
        return;
    begin(p, ECT_SII_DC);
    for (unsigned int i = 0; i < device->dc_mode_count; i++) {
        const ect_dc_mode_t *mode = &device->dc_modes[i];
        put32(p, mode->cycle_sync0_ns);
        put32(p, (uint32_t)mode->shift_sync0_ns);
        put32(p, (uint32_t)mode->shift_sync1_ns);
        put16(p, (uint16_t)mode->factor_sync1);
        put16(p, mode->assign_activate);
        put16(p, (uint16_t)mode->factor_sync0);
        put8(p, string_index(p, mode->name));
        put8(p, string_index(p, mode->description));
        put32(p, 0);
    }
    end(p, 0);
}

static void put_categories(pen_t *p)
{
    for (unsigned int i = 0; i < p->device->category_count; i++) {
        const ect_category_t *category = &p->device->categories[i];
        begin(p, category->number);
        for (unsigned int k = 0; k < category->length; k++)
            put8(p, category->data[k]);
        end(p, 0);
    }
}

/* @return whether everything fits */
static bool write_image(const ect_device_t *device, const ect_identity_t *identity, uint16_t alias, uint8_t *image,
                        unsigned int omit)
{
    pen_t pen = {.device = device, .image = image, .size = device->sii_size, .omit = omit};
    memset(image, 0xFF, device->sii_size);
    put_header(&pen, identity, alias);
    put_strings(&pen);
    put_general(&pen, alias);
    put_fmmus(&pen);
    put_sms(&pen);
    put_pdos(&pen, false);
    put_pdos(&pen, true);
    put_dc(&pen);
    put_categories(&pen);
    put16(&pen, ECT_SII_END);
    return !pen.overflow;
}

/* Writes the image with the fewest omissions. @return as ect_sii_omission */
static int write_fitting(const ect_device_t *device, const ect_identity_t *identity, uint16_t alias, uint8_t *image)
{
    int most = device->sii_omit != 0 ? device->sii_omit : ECT_OMIT_ENTRY_NAMES;
    if (most >= ECT_OMIT_PDOS && (device->mailbox_protocols & ECT_MAILBOX_COE) == 0)
        most = ECT_OMIT_FREE_PDOS;
    for (int omit = 0; omit <= most; omit++) {
        if (write_image(device, identity, alias, image, (unsigned int)omit))
            return omit;
    }
    return -1;
}

int ect_sii_omission(const ect_device_t *device, uint8_t *scratch)
{
    return write_fitting(device, &device->identity, 0, scratch);
}

int32_t ect_sii_write(const ect_device_t *device, const ect_identity_t *identity, uint16_t alias, uint8_t *image,
                      size_t size)
{
    if (size < device->sii_size || device->sii_size < ECT_SII_CATEGORIES)
        return -1;
    memset(image, 0xFF, size);
    identity = identity ? identity : &device->identity;
    if (device->sii) {
        memcpy(image, device->sii, device->sii_size);
        put_identity(image, identity, alias);
        return device->sii_size;
    }
    return write_fitting(device, identity, alias, image) >= 0 ? device->sii_size : -2;
}

/* --- reading ----------------------------------------------------------------------------------------------------- */

uint8_t ect_sii_checksum(const uint8_t *image)
{
    return ect_crc_sii(image);
}

const uint8_t *ect_sii_category(const uint8_t *image, size_t size, uint16_t category, size_t *length)
{
    size_t at = ECT_SII_CATEGORIES;
    while (at + 4 <= size) {
        uint16_t type = ect_load_le16(image + at);
        size_t bytes = (size_t)ect_load_le16(image + at + 2) * 2;
        if (type == ECT_SII_END || bytes > size - at - 4)
            return NULL;
        if (type == category) {
            *length = bytes;
            return image + at + 4;
        }
        at += 4 + bytes;
    }
    return NULL;
}

const char *ect_sii_string(const uint8_t *image, size_t size, uint8_t index, uint8_t *length)
{
    size_t room = 0;
    const uint8_t *table = ect_sii_category(image, size, ECT_SII_STRINGS, &room);
    if (!table || room == 0 || index == 0 || index > table[0])
        return NULL;
    size_t at = 1;
    for (unsigned int i = 1; i < index && at < room; i++)
        at += 1u + table[at];
    if (at >= room || table[at] > room - at - 1)
        return NULL;
    *length = table[at];
    return (const char *)table + at + 1;
}
