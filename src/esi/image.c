/* SPDX-License-Identifier: MIT */
/* The model of a device from its EEPROM image. */
#include "esi/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"
#include "sii/sii.h"
#include "wire/bytes.h"
#include "wire/sii.h"

/* Control bytes of mailbox SyncManagers for an image without category SYNCM. */
enum { CONTROL_OUT = 0x26, CONTROL_IN = 0x22 };

typedef struct image {
    ect_arena_t *arena;
    const uint8_t *bytes;
    size_t size;
    ect_esi_device_t *device;
} image_t;

static const char *string_of(const image_t *image, uint8_t number)
{
    uint8_t length = 0;
    const char *text = number != 0 ? ect_sii_string(image->bytes, image->size, number, &length) : NULL;
    return text != NULL ? ect_arena_copy(image->arena, text, length) : "";
}

static void read_header(const image_t *image)
{
    ect_esi_device_t *device = image->device;
    const uint8_t *w = image->bytes;
    device->vendor_id = ect_load_le32(w + ECT_SII_AT_VENDOR);
    device->product_code = ect_load_le32(w + ECT_SII_AT_PRODUCT);
    device->revision = ect_load_le32(w + ECT_SII_AT_REVISION);
    device->eeprom = (ect_esi_bytes_t){.bytes = w, .length = image->size};
    device->eeprom_size = (ect_load_le16(w + ECT_SII_AT_SIZE) + 1u) * 128u;
    device->config = (ect_esi_bytes_t){.bytes = w, .length = 14};
    device->bootstrap = (ect_esi_bytes_t){.bytes = w + ECT_SII_AT_BOOT_OUT, .length = 8};

    unsigned int protocols = ect_load_le16(w + ECT_SII_AT_PROTOCOLS);
    device->mailbox = (ect_esi_mailbox_t){
        .given = protocols != 0,
        .aoe = (protocols & ECT_MAILBOX_AOE) != 0,
        .eoe = (protocols & ECT_MAILBOX_EOE) != 0,
        .coe = (protocols & ECT_MAILBOX_COE) != 0,
        .foe = (protocols & ECT_MAILBOX_FOE) != 0,
        .soe = (protocols & ECT_MAILBOX_SOE) != 0,
        .voe = (protocols & ECT_MAILBOX_VOE) != 0,
    };
}

static const char *physics_of(const image_t *image, unsigned int ports)
{
    char text[5] = "";
    size_t count = 0;
    for (unsigned int i = 0; i < 4; i++) {
        text[i] = ect_sii_port_letter(ports >> (4 * i));
        count = text[i] != ' ' ? i + 1 : count;
    }
    return ect_arena_copy(image->arena, text, count);
}

static void read_general(const image_t *image)
{
    ect_esi_device_t *device = image->device;
    size_t length = 0;
    const uint8_t *g = ect_sii_category(image->bytes, image->size, ECT_SII_GENERAL, &length);
    if (g == NULL || length < 18)
        return;
    device->group_type = string_of(image, g[0]);
    device->type = string_of(image, g[2]);
    device->name = string_of(image, g[3]);
    device->group_name = string_of(image, g[14]);
    device->physics = physics_of(image, ect_load_le16(g + 16));
    device->ebus_current_ma = (int16_t)ect_load_le16(g + 12);
    device->lrd_lwr = (g[11] & ECT_GENERAL_NO_LRW) != 0;
    device->identification_134 = (g[11] & ECT_GENERAL_ID_AL_STATUS) != 0;
    device->identification_ado.given = (g[11] & ECT_GENERAL_ID_MEMORY) != 0 && length >= 20;
    device->identification_ado.value = device->identification_ado.given ? ect_load_le16(g + 18) : 0;

    ect_esi_mailbox_t *mailbox = &device->mailbox;
    mailbox->data_link_layer = (g[11] & ECT_GENERAL_MAIL_REPEAT) != 0;
    mailbox->soe_channels = g[8];
    mailbox->sdo_info = (g[5] & ECT_COE_SDO_INFO) != 0;
    mailbox->pdo_assign = (g[5] & ECT_COE_PDO_ASSIGN) != 0;
    mailbox->pdo_config = (g[5] & ECT_COE_PDO_CONFIG) != 0;
    mailbox->pdo_upload = (g[5] & ECT_COE_PDO_UPLOAD) != 0;
    mailbox->complete_access = (g[5] & ECT_COE_COMPLETE_ACCESS) != 0;
}

/* --- SyncManagers, FMMUs, clocks ---------------------------------------------------------------------------------- */

static const char *role_of(unsigned int type)
{
    static const char *const roles[] = {"", "MBoxOut", "MBoxIn", "Outputs", "Inputs"};
    return type < sizeof roles / sizeof roles[0] ? roles[type] : "";
}

static void add_mailbox_sm(const image_t *image, ect_esi_sm_t *sm, unsigned int type, size_t at, uint8_t control)
{
    sm->type = role_of(type);
    sm->start = ect_load_le16(image->bytes + at);
    sm->size = (ect_esi_number_t){.given = true, .value = ect_load_le16(image->bytes + at + 2)};
    sm->maximum = (uint16_t)sm->size.value;
    sm->control = control;
}

static void read_sms(const image_t *image)
{
    size_t length = 0;
    const uint8_t *from = ect_sii_category(image->bytes, image->size, ECT_SII_SYNCM, &length);
    size_t count = from != NULL ? length / 8 : 0;
    ect_esi_sm_t *sms = ect_arena_alloc(image->arena, (count + 2) * sizeof *sms);
    for (size_t i = 0; i < count; i++, from += 8) {
        ect_esi_sm_t *sm = &sms[i];
        sm->type = role_of(from[7]);
        sm->start = ect_load_le16(from);
        sm->maximum = ect_load_le16(from + 2); /* first: GCC 12 at -O3 drops a size written before it is read */
        sm->size.given = true;
        sm->size.value = sm->maximum;
        sm->control = from[4];
        sm->flags = from[6] & (ECT_SM_FLAG_FIXED | ECT_SM_FLAG_VIRTUAL | ECT_SM_FLAG_OP_ONLY);
        sm->virtual_sm = (from[6] & ECT_SM_FLAG_VIRTUAL) != 0;
    }
    if (count == 0 && image->device->mailbox.given) {
        add_mailbox_sm(image, &sms[0], ECT_SM_MAILBOX_OUT, ECT_SII_AT_MAILBOX_OUT, CONTROL_OUT);
        add_mailbox_sm(image, &sms[1], ECT_SM_MAILBOX_IN, ECT_SII_AT_MAILBOX_IN, CONTROL_IN);
        count = 2;
    }
    image->device->sms = sms;
    image->device->sm_count = count;
}

static void read_fmmus(const image_t *image)
{
    static const char *const roles[] = {"", "Outputs", "Inputs", "MBoxState"};
    size_t length = 0;
    const uint8_t *from = ect_sii_category(image->bytes, image->size, ECT_SII_FMMU, &length);
    if (from == NULL)
        return;
    const char **fmmus = ect_arena_alloc(image->arena, (length + 1) * sizeof *fmmus);
    for (size_t i = 0; i < length; i++) {
        fmmus[i] = from[i] < sizeof roles / sizeof roles[0] ? roles[from[i]] : "";
        if (from[i] != 0xFF) /* filler at the end of a category */
            image->device->fmmu_count = i + 1;
    }
    image->device->fmmus = fmmus;
}

static void read_clocks(const image_t *image)
{
    enum { MODE = 24 };
    size_t length = 0;
    const uint8_t *from = ect_sii_category(image->bytes, image->size, ECT_SII_DC, &length);
    size_t count = from != NULL ? length / MODE : 0;
    ect_esi_dc_t *dcs = ect_arena_alloc(image->arena, (count + 1) * sizeof *dcs);
    for (size_t i = 0; i < count; i++, from += MODE) {
        dcs[i] = (ect_esi_dc_t){
            .name = string_of(image, from[18]),
            .description = string_of(image, from[19]),
            .assign_activate = ect_load_le16(from + 14),
            .cycle_sync0_ns = ect_load_le32(from),
            .shift_sync0_ns = (int32_t)ect_load_le32(from + 4),
            .shift_sync1_ns = (int32_t)ect_load_le32(from + 8),
            .sync1_factor = (int16_t)ect_load_le16(from + 12),
            .sync0_factor = (int16_t)ect_load_le16(from + 16),
        };
    }
    image->device->dcs = dcs;
    image->device->dc_count = count;
}

/* --- PDOs --------------------------------------------------------------------------------------------------------- */

static const char *type_name(const image_t *image, uint16_t code, uint16_t bits)
{
    char text[40];
    const char *name = code != ECT_TYPE_NONE && bits > 0 ? ect_esi_type_name(code, bits, text, sizeof text) : "";
    return ect_arena_copy(image->arena, name, strlen(name));
}

static void read_entry(const image_t *image, const uint8_t *from, ect_esi_entry_t *entry)
{
    entry->index = ect_load_le16(from);
    entry->subindex = from[2];
    entry->bits = from[5];
    entry->name = string_of(image, from[3]);
    entry->type = entry->index != 0 ? type_name(image, from[4], entry->bits) : "";
}

static void read_pdo(const image_t *image, const uint8_t *from, bool tx, ect_esi_pdo_t *pdo)
{
    unsigned int flags = ect_load_le16(from + 6);
    size_t count = from[2];
    ect_esi_entry_t *entries = ect_arena_alloc(image->arena, (count + 1) * sizeof *entries);
    for (size_t i = 0; i < count; i++)
        read_entry(image, from + 8 + 8 * i, &entries[i]);
    *pdo = (ect_esi_pdo_t){
        .index = ect_load_le16(from),
        .name = string_of(image, from[5]),
        .tx = tx,
        .fixed = (flags & ECT_PDO_FIXED) != 0,
        .mandatory = (flags & ECT_PDO_MANDATORY) != 0,
        .virtual_pdo = (flags & ECT_PDO_VIRTUAL) != 0,
        .sm = from[3] != 0xFF ? from[3] : -1,
        .samples = 1,
        .entries = entries,
        .entry_count = count,
    };
}

static void read_pdos(const image_t *image, uint16_t category)
{
    size_t length = 0;
    const uint8_t *from = ect_sii_category(image->bytes, image->size, category, &length);
    while (from != NULL && length >= 8) {
        size_t bytes = 8 + 8 * (size_t)from[2];
        if (ect_load_le16(from) == 0 || bytes > length)
            return;
        read_pdo(image, from, category == ECT_SII_TXPDO, ect_esi_append_pdo(image->arena, image->device));
        from += bytes;
        length -= bytes;
    }
}

static uint32_t bits_of(const ect_esi_pdo_t *pdo)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < pdo->entry_count; i++)
        bits += pdo->entries[i].bits;
    return bits;
}

/* An image may give a SyncManager for each possible PDO: the first ones that fit the SyncManager's length are assigned.
 */
static void assign(const image_t *image, int n)
{
    ect_esi_pdo_t *pdos = (ect_esi_pdo_t *)(uintptr_t)image->device->pdos; /* ours */
    const uint32_t room = (uint32_t)image->device->sms[n].size.value * 8;
    uint32_t used = 0;
    for (size_t i = 0; room > 0 && i < image->device->pdo_count; i++) {
        if (pdos[i].sm != n)
            continue;
        if (used + bits_of(&pdos[i]) > room)
            pdos[i].sm = -1;
        else
            used += bits_of(&pdos[i]);
    }
}

/* ------------------------------------------------------------------------------------------------------------------ */

static void read_device(ect_esi_t *esi, const uint8_t *bytes, size_t size)
{
    uint8_t *copy = ect_arena_alloc(&esi->arena, size);
    ect_esi_device_t *device = esi->device;
    const image_t image = {.arena = &esi->arena, .bytes = copy, .size = size, .device = device};
    memcpy(copy, bytes, size);
    read_header(&image);
    read_general(&image);
    read_sms(&image);
    read_fmmus(&image);
    read_pdos(&image, ECT_SII_RXPDO);
    read_pdos(&image, ECT_SII_TXPDO);
    for (int i = 0; i < (int)device->sm_count; i++)
        assign(&image, i);
    read_clocks(&image);
}

ect_esi_t *ect_esi_of_image(const char *name, const uint8_t *image, size_t size, char *text, size_t room)
{
    if (size < ECT_SII_CATEGORIES) {
        (void)snprintf(text, room, "%s: not an EEPROM image: %zu bytes, its header alone has %d", name, size,
                       (int)ECT_SII_CATEGORIES);
        return NULL;
    }
    const uint32_t vendor = ect_load_le32(image + ECT_SII_AT_VENDOR),
                   product = ect_load_le32(image + ECT_SII_AT_PRODUCT);
    if ((vendor == 0 && product == 0) || (vendor == UINT32_MAX && product == UINT32_MAX)) {
        (void)snprintf(text, room, "%s: an empty EEPROM image: it has neither vendor id nor product code", name);
        return NULL;
    }
    ect_esi_t *esi = ect_esi_single_begin(name, text, room);
    if (esi == NULL)
        return NULL;
    read_device(esi, image, size);
    ect_esi_single_end(esi, "EEPROM");
    return esi;
}
