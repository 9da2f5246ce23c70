/* SPDX-License-Identifier: MIT */
/* Twins of EEPROM images: the content of an image becomes a device, and the twin's EEPROM is the image. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus/chain/catalogue.h"
#include "esi/image.h"
#include "esi/twin.h"
#include "sii/sii.h"
#include "wire/bytes.h"

enum { IMAGE = 0x8000, TEXT = 400 };

typedef struct image {
    uint8_t bytes[IMAGE];
    size_t size;
} image_t;

typedef struct made {
    ect_esi_t *esi;
    const ect_esi_device_t *model;
    ect_esi_twin_t *twin;
} made_t;

static made_t make(const image_t *image)
{
    char why[TEXT] = "";
    made_t m = {.esi = ect_esi_of_image("image", image->bytes, image->size, why, sizeof why)};
    m.model = m.esi != NULL ? ect_esi_select(m.esi, "", why, sizeof why) : NULL;
    m.twin = m.model != NULL ? ect_esi_twin_of(m.esi, m.model, NULL, 0, why, sizeof why) : NULL;
    if (m.twin == NULL)
        fail_msg("no twin: %s", why);
    return m;
}

static void drop(made_t *m)
{
    ect_esi_twin_free(m->twin);
    ect_esi_close(m->esi);
}

/* --- images written manually
 * ----------------------------------------------------------------------------------------------- */

static void begin(image_t *image, uint16_t protocols)
{
    memset(image, 0xFF, sizeof *image);
    memset(image->bytes, 0, ECT_SII_CATEGORIES);
    ect_store_le32(image->bytes + 0x10, 0xE57);
    ect_store_le32(image->bytes + 0x14, 0x1234);
    ect_store_le32(image->bytes + 0x30, 0x00801000);
    ect_store_le32(image->bytes + 0x34, 0x00801080);
    ect_store_le16(image->bytes + 0x38, protocols);
    ect_store_le16(image->bytes + 0x7C, 15); /* 2048 bytes */
    image->bytes[14] = ect_sii_checksum(image->bytes);
    image->size = ECT_SII_CATEGORIES;
}

static void add(image_t *image, uint16_t category, const uint8_t *data, size_t length)
{
    ect_store_le16(image->bytes + image->size, category);
    ect_store_le16(image->bytes + image->size + 2, (uint16_t)(length / 2));
    memcpy(image->bytes + image->size + 4, data, length);
    image->size += 4 + length;
}

static void end(image_t *image)
{
    image->size += 2; /* FFFFh: no further category */
}

/* Ends an image and reads it. @param[out] device  its device @return for ect_esi_close */
static ect_esi_t *read_back(image_t *image, const ect_esi_device_t **device)
{
    char why[TEXT];
    end(image);
    ect_esi_t *esi = ect_esi_of_image("image", image->bytes, image->size, why, sizeof why);
    *device = ect_esi_select(esi, "", why, sizeof why);
    return esi;
}

#define SM(start, length, control, type)                                                                               \
    (start) & 0xFF, (start) >> 8, (length) & 0xFF, (length) >> 8, (control), 0, 1, (type)
#define PDO(index, entries, sm)            (index) & 0xFF, (index) >> 8, (entries), (sm), 0, 0, 0, 0
#define ENTRY(index, subindex, type, bits) (index) & 0xFF, (index) >> 8, (subindex), 0, (type), (bits), 0, 0

/* --- cases -------------------------------------------------------------------------------------------------------- */

static void assert_same_layout(const ect_device_t *expected, const ect_device_t *got)
{
    assert_memory_equal(&expected->identity, &got->identity, sizeof got->identity);
    assert_string_equal(expected->type_name, got->type_name);
    assert_int_equal(expected->sm_count, got->sm_count);
    for (unsigned int n = 0; n < got->sm_count; n++) {
        assert_int_equal(expected->sm[n].start, got->sm[n].start);
        assert_int_equal(expected->sm[n].type, got->sm[n].type);
        assert_int_equal(expected->sm[n].control, got->sm[n].control);
        assert_int_equal(ect_device_sm_bytes(expected, n), ect_device_sm_bytes(got, n));
    }
    assert_int_equal(expected->fmmu_count, got->fmmu_count);
    assert_memory_equal(expected->fmmu, got->fmmu, got->fmmu_count);
    assert_int_equal(expected->mailbox_protocols, got->mailbox_protocols);
    assert_int_equal(expected->coe_details, got->coe_details);
    assert_int_equal(expected->dc_mode_count, got->dc_mode_count);
    assert_int_equal(expected->boot_out.start, got->boot_out.start);
}

static void each_device_of_the_catalogue_comes_back_from_its_image(void **state)
{
    const ect_product_t *product;
    (void)state;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        image_t image;
        const ect_device_t *device = product->device;
        print_message("%s\n", device->name);
        assert_int_equal(ect_sii_write(device, NULL, 0, image.bytes, sizeof image.bytes), device->sii_size);
        image.size = device->sii_size;
        made_t m = make(&image);
        const ect_device_t *twin = ect_esi_twin_product(m.twin)->device;
        uint8_t again[IMAGE];
        assert_same_layout(device, twin);
        assert_int_equal(ect_sii_write(twin, NULL, 0, again, sizeof again), device->sii_size);
        assert_memory_equal(again, image.bytes, device->sii_size);
        drop(&m);
    }
}

/* An image as probes write it ends behind the mark of the last category; the header has the size of the EEPROM. */
static void the_eeprom_has_the_size_of_its_header(void **state)
{
    image_t image;
    (void)state;
    begin(&image, 0);
    end(&image);
    made_t m = make(&image);
    const ect_device_t *twin = ect_esi_twin_product(m.twin)->device;
    assert_int_equal(twin->sii_size, 2048);
    assert_int_equal(twin->sii[image.size], 0xFF);
    assert_string_equal(twin->type_name, "0x00001234");
    drop(&m);
}

static void mailboxes_of_the_header_serve_without_a_category_of_sync_managers(void **state)
{
    image_t image;
    (void)state;
    begin(&image, ECT_MAILBOX_COE);
    end(&image);
    made_t m = make(&image);
    const ect_device_t *twin = ect_esi_twin_product(m.twin)->device;
    assert_int_equal(twin->sm_count, 2);
    assert_int_equal(twin->sm[0].type, ECT_SM_MAILBOX_OUT);
    assert_int_equal(twin->sm[0].start, 0x1000);
    assert_int_equal(twin->sm[0].length, 0x80);
    assert_int_equal(twin->sm[1].type, ECT_SM_MAILBOX_IN);
    assert_int_equal(twin->sm[1].start, 0x1080);
    assert_int_equal(m.model->sms[0].maximum, 0x80);
    assert_int_equal(m.model->sms[1].maximum, 0x80);
    drop(&m);
}

/* ETG.2010, category General: a field or a bit alone. */
static void each_field_of_general_is_read(void **state)
{
    static const struct {
        const char *what;
        size_t at;
        uint8_t value;
    } rows[] = {{"LRD and LWR alone", 11, 0x02},
                {"mailbox data link layer", 11, 0x04},
                {"identification in AL status", 11, 0x08},
                {"identification in memory", 11, 0x10},
                {"channels of SoE", 8, 3},
                {"SDO information", 5, 0x02},
                {"PDO assignment", 5, 0x04},
                {"PDO configuration", 5, 0x08},
                {"PDO upload", 5, 0x10},
                {"Complete Access", 5, 0x20},
                {"E-bus current", 12, 90},
                {"E-bus current that is fed in, high byte", 13, 0xFE}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t general[20] = {[18] = 0x34, [19] = 0x12};
        image_t image;
        general[rows[i].at] = rows[i].value;
        begin(&image, ECT_MAILBOX_COE);
        add(&image, ECT_SII_GENERAL, general, sizeof general);
        const ect_esi_device_t *d;
        ect_esi_t *esi = read_back(&image, &d);
        const int64_t got[] = {d->lrd_lwr,
                               d->mailbox.data_link_layer,
                               d->identification_134,
                               d->identification_ado.given && d->identification_ado.value == 0x1234,
                               d->mailbox.soe_channels == 3,
                               d->mailbox.sdo_info,
                               d->mailbox.pdo_assign,
                               d->mailbox.pdo_config,
                               d->mailbox.pdo_upload,
                               d->mailbox.complete_access,
                               d->ebus_current_ma == 90,
                               d->ebus_current_ma == -512};
        for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
            if (got[k] != (k == i))
                fail_msg("%s: %s %s", rows[i].what, rows[k].what, k == i ? "is not there" : "is there, too");
        }
        ect_esi_close(esi);
    }
}

/* ETG.2010, category General: numbers of strings in bytes 0, 2, 3 and 14; 0 and a number behind the last: no text. */
static void each_text_of_general_is_read(void **state)
{
    static const uint8_t strings[] = {4, 1, 'G', 2, 'T', 'y', 2, 'N', 'a', 3, 'G', 'r', 'p', 0};
    static const struct {
        uint8_t group_type, type, name, group_name;
        const char *texts;
    } rows[] = {{1, 2, 3, 4, "G,Ty,Na,Grp"}, {4, 3, 2, 1, "Grp,Na,Ty,G"}, {1, 1, 1, 0, "G,G,G,"},
                {0, 2, 5, 4, ",Ty,,Grp"},    {5, 2, 0, 3, ",Ty,,Na"},     {2, 2, 4, 5, "Ty,Ty,Grp,"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint8_t general[20] = {rows[i].group_type, [2] = rows[i].type, rows[i].name, [14] = rows[i].group_name};
        image_t image;
        char got[TEXT];
        begin(&image, 0);
        add(&image, ECT_SII_STRINGS, strings, sizeof strings);
        add(&image, ECT_SII_GENERAL, general, sizeof general);
        const ect_esi_device_t *d;
        ect_esi_t *esi = read_back(&image, &d);
        snprintf(got, sizeof got, "%s,%s,%s,%s", d->group_type, d->type, d->name, d->group_name);
        if (strcmp(got, rows[i].texts) != 0)
            fail_msg("row %zu: expected %s, got %s", i, rows[i].texts, got);
        ect_esi_close(esi);
    }
}

/* ETG.2010, category DC: name and description of a mode; category PDO: name, and the texts of its entries. */
static void texts_of_modes_and_pdos_are_read(void **state)
{
    static const uint8_t strings[] = {4, 1, 'M', 1, 'D', 1, 'P', 1, 'E', 0};
    const uint8_t modes[24] = {[18] = 1, [19] = 2};
    const uint8_t pdos[16] = {0x00, 0x1A, 1, 0xFF, 0, 3, 0, 0, 0x00, 0x60, 1, 4, ECT_TYPE_UNSIGNED8, 8};
    image_t image;
    (void)state;
    begin(&image, 0);
    add(&image, ECT_SII_STRINGS, strings, sizeof strings);
    add(&image, ECT_SII_TXPDO, pdos, sizeof pdos);
    add(&image, ECT_SII_DC, modes, sizeof modes);
    const ect_esi_device_t *d;
    ect_esi_t *esi = read_back(&image, &d);
    assert_string_equal(d->dcs[0].name, "M");
    assert_string_equal(d->dcs[0].description, "D");
    assert_string_equal(d->pdos[0].name, "P");
    assert_string_equal(d->pdos[0].entries[0].name, "E");
    ect_esi_close(esi);
}

/* ETG.2010, category PDO, flags: mandatory, fixed, virtual. */
static void each_flag_of_a_pdo_is_read(void **state)
{
    (void)state;
    for (unsigned int bit = 0; bit < 16; bit++) {
        const uint8_t pdo[] = {0x00, 0x1A, 0, 0xFF, 0, 0, (uint8_t)(1u << bit), (uint8_t)(1u << bit >> 8)};
        image_t image;
        begin(&image, 0);
        add(&image, ECT_SII_TXPDO, pdo, sizeof pdo);
        const ect_esi_device_t *device;
        ect_esi_t *esi = read_back(&image, &device);
        const ect_esi_pdo_t *p = &device->pdos[0];
        assert_int_equal(p->mandatory, bit == 0);
        assert_int_equal(p->fixed, bit == 4);
        assert_int_equal(p->virtual_pdo, bit == 5);
        ect_esi_close(esi);
    }
}

/* ETG.2010, category SyncM, byte 6: enabled, fixed content, virtual, OpOnly. */
static void each_flag_of_a_sync_manager_is_read(void **state)
{
    (void)state;
    for (unsigned int flags = 0; flags < 16; flags++) {
        const uint8_t sms[] = {0x00, 0x10, 4, 0, 0x20, 0, (uint8_t)flags, ECT_SM_INPUTS};
        image_t image;
        begin(&image, 0);
        add(&image, ECT_SII_SYNCM, sms, sizeof sms);
        const ect_esi_device_t *device;
        ect_esi_t *esi = read_back(&image, &device);
        const ect_esi_sm_t *sm = &device->sms[0];
        assert_int_equal(sm->flags, flags & 14);
        assert_int_equal(sm->virtual_sm, (flags & 4) != 0);
        ect_esi_close(esi);
    }
}

/* ETG.2010, category SyncM: 0 not used, 1 and 2 mailbox, 3 and 4 process data; other values are reserved. */
static void each_type_of_a_sync_manager_has_its_name(void **state)
{
    static const struct {
        uint8_t type;
        const char *name;
    } rows[] = {{0, ""}, {1, "MBoxOut"}, {2, "MBoxIn"}, {3, "Outputs"}, {4, "Inputs"}, {5, ""}, {255, ""}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint8_t sms[] = {SM(0x1000, 128, 0x26, rows[i].type)};
        image_t image;
        begin(&image, 0);
        add(&image, ECT_SII_SYNCM, sms, sizeof sms);
        const ect_esi_device_t *model;
        ect_esi_t *esi = read_back(&image, &model);
        assert_int_equal(model->sm_count, 1);
        assert_string_equal(model->sms[0].type, rows[i].name);
        ect_esi_close(esi);
    }
}

/* ETG.2010, category FMMU: 1 outputs, 2 inputs, 3 state of SyncManagers; other values are reserved. */
static void each_type_of_an_fmmu_has_its_name(void **state)
{
    static const uint8_t types[] = {0, 1, 2, 3, 4, 5, 254, 255, 2, 255};
    static const char *const names[] = {"", "Outputs", "Inputs", "MBoxState", "", "", "", "", "Inputs"};
    image_t image;
    (void)state;
    begin(&image, 0);
    add(&image, ECT_SII_FMMU, types, sizeof types);
    const ect_esi_device_t *model;
    ect_esi_t *esi = read_back(&image, &model);
    assert_int_equal(model->fmmu_count, sizeof names / sizeof names[0]);
    for (size_t i = 0; i < model->fmmu_count; i++)
        assert_string_equal(model->fmmus[i], names[i]);
    ect_esi_close(esi);
}

/* Categories of any number of elements; an element that is not whole is none. */
static void each_element_of_a_category_is_read(void **state)
{
    enum { MOST = 16, SM = 8, MODE = 24 };
    (void)state;
    for (size_t count = 0; count <= MOST; count++) {
        for (size_t more = 0; more < SM; more += 2) {
            uint8_t sms[(MOST + 1) * SM] = {0}, modes[(MOST + 1) * MODE] = {0}, fmmus[MOST + 2];
            image_t image;
            char why[TEXT];
            for (size_t i = 0; i <= MOST; i++) {
                ect_store_le16(sms + SM * i, (uint16_t)(0x1000 + 0x100 * i));
                ect_store_le16(sms + SM * i + 2, (uint16_t)(100 + i));
                sms[SM * i + 4] = (uint8_t)(0x20 + i);
                sms[SM * i + 7] = ECT_SM_INPUTS;
                ect_store_le32(modes + MODE * i, (uint32_t)(1000000 + i));
                ect_store_le32(modes + MODE * i + 4, (uint32_t)(-1 - (int)i));
                ect_store_le32(modes + MODE * i + 8, (uint32_t)(-101 - (int)i));
                ect_store_le16(modes + MODE * i + 12, (uint16_t)(-201 - (int)i));
                ect_store_le16(modes + MODE * i + 14, (uint16_t)(0x300 + i));
                ect_store_le16(modes + MODE * i + 16, (uint16_t)(-301 - (int)i));
            }
            memset(fmmus, 0xFF, sizeof fmmus);
            for (size_t i = 0; i < count; i++)
                fmmus[i] = (uint8_t)(1 + i % 3);
            begin(&image, 0);
            add(&image, ECT_SII_SYNCM, sms, SM * count + more);
            add(&image, ECT_SII_FMMU, fmmus, (count + 1) / 2 * 2);
            add(&image, ECT_SII_DC, modes, MODE * count + more);
            end(&image);
            ect_esi_t *esi = ect_esi_of_image("image", image.bytes, image.size, why, sizeof why);
            assert_non_null(esi);
            const ect_esi_device_t *model = ect_esi_select(esi, "", why, sizeof why);
            assert_int_equal(model->sm_count, count);
            assert_int_equal(model->fmmu_count, count);
            assert_int_equal(model->dc_count, count);
            for (size_t i = 0; i < count; i++) {
                static const char *const roles[] = {"Outputs", "Inputs", "MBoxState"};
                const ect_esi_sm_t *sm = &model->sms[i];
                const ect_esi_dc_t *dc = &model->dcs[i];
                assert_true(sm->size.given);
                assert_true(sm->start == 0x1000 + 0x100 * i && sm->size.value == (int64_t)(100 + i));
                assert_true(sm->maximum == 100 + i && sm->control == 0x20 + i && strcmp(sm->type, "Inputs") == 0);
                assert_string_equal(model->fmmus[i], roles[i % 3]);
                assert_true(dc->cycle_sync0_ns == 1000000 + (int64_t)i && dc->assign_activate == 0x300 + i);
                assert_true(dc->shift_sync0_ns == -1 - (int)i && dc->shift_sync1_ns == -101 - (int)i);
                assert_true(dc->sync1_factor == -201 - (int)i && dc->sync0_factor == -301 - (int)i);
            }
            ect_esi_close(esi);
        }
    }
}

/* ETG.2010 has 0xFF for a PDO that is not assigned; many images name a SyncManager for each PDO that it can have. */
static void of_more_pdos_than_a_sync_manager_holds_the_first_that_fit_are_assigned(void **state)
{
    static const uint8_t sms[] = {SM(0x1000, 3, 0x64, ECT_SM_OUTPUTS), SM(0x1100, 2, 0x20, ECT_SM_INPUTS)};
    static const uint8_t rx[] = {PDO(0x1600, 1, 0), ENTRY(0x7000, 1, ECT_TYPE_UNSIGNED16, 16),
                                 PDO(0x1601, 1, 0), ENTRY(0x7001, 1, ECT_TYPE_UNSIGNED32, 32),
                                 PDO(0x1602, 1, 0), ENTRY(0x7002, 1, ECT_TYPE_UNSIGNED8, 8)};
    static const uint8_t tx[] = {PDO(0x1A00, 1, 1), ENTRY(0x6000, 1, ECT_TYPE_UNSIGNED16, 16), PDO(0x1A01, 1, 0xFF),
                                 ENTRY(0x6001, 1, ECT_TYPE_UNSIGNED8, 8)};
    static const int assigned[] = {0, -1, 0, 1, -1};
    image_t image;
    (void)state;
    begin(&image, 0);
    add(&image, ECT_SII_SYNCM, sms, sizeof sms);
    add(&image, ECT_SII_TXPDO, tx, sizeof tx);
    add(&image, ECT_SII_RXPDO, rx, sizeof rx);
    end(&image);
    made_t m = make(&image);
    assert_int_equal(m.model->pdo_count, sizeof assigned / sizeof assigned[0]);
    for (size_t i = 0; i < m.model->pdo_count; i++)
        assert_int_equal(m.model->pdos[i].sm, assigned[i]);
    const ect_esi_entry_t *second = &m.model->pdos[1].entries[0];
    assert_int_equal(second->index, 0x7001);
    assert_int_equal(second->subindex, 1);
    assert_int_equal(second->bits, 32);
    assert_string_equal(second->type, "UDINT");
    const ect_device_t *twin = ect_esi_twin_product(m.twin)->device;
    assert_int_equal(ect_device_bytes(twin, ECT_SM_OUTPUTS), 3);
    assert_int_equal(ect_device_bytes(twin, ECT_SM_INPUTS), 2);
    drop(&m);
}

static void process_data_without_pdos_are_bytes(void **state)
{
    static const uint8_t sms[] = {SM(0x1000, 3, 0x64, ECT_SM_OUTPUTS), SM(0x1100, 300, 0x20, ECT_SM_INPUTS)};
    image_t image;
    (void)state;
    begin(&image, 0);
    add(&image, ECT_SII_SYNCM, sms, sizeof sms);
    end(&image);
    made_t m = make(&image);
    const ect_device_t *twin = ect_esi_twin_product(m.twin)->device;
    assert_int_equal(ect_device_bytes(twin, ECT_SM_OUTPUTS), 3);
    assert_int_equal(ect_device_bytes(twin, ECT_SM_INPUTS), 300);
    assert_int_equal(m.model->pdo_count, 3); /* a mapping has at most 254 entries */
    assert_int_equal(m.model->pdos[2].entries[0].index, 0x6001);
    assert_string_equal(m.model->pdos[2].entries[45].name, "Byte 299");
    drop(&m);
}

/* A PDO truncated by its category, and everything after a PDO without an index, are omitted. */
static void pdos_are_read_as_far_as_they_are_whole(void **state)
{
    static const uint8_t rx[] = {PDO(0x1600, 3, 0xFF), ENTRY(0x7000, 1, 0, 16),
                                 ENTRY(0, 0, 0, 8),    ENTRY(0x7000, 2, ECT_TYPE_UNSIGNED8, 0),
                                 PDO(0x1601, 2, 0xFF), ENTRY(0x7000, 1, 0, 16)};
    static const uint8_t tx[] = {PDO(0x1A00, 0, 0xFF), PDO(0, 0, 0xFF), PDO(0x1A01, 0, 0xFF)};
    image_t image;
    (void)state;
    begin(&image, 0);
    add(&image, ECT_SII_RXPDO, rx, sizeof rx);
    add(&image, ECT_SII_TXPDO, tx, sizeof tx);
    end(&image);
    made_t m = make(&image);
    assert_int_equal(m.model->pdo_count, 2);
    assert_int_equal(m.model->pdos[0].index, 0x1600);
    assert_int_equal(m.model->pdos[0].entry_count, 3);
    assert_string_equal(m.model->pdos[0].entries[0].type, ""); /* the image names none */
    assert_string_equal(m.model->pdos[0].entries[2].type, ""); /* without bits */
    assert_int_equal(m.model->pdos[0].entries[1].index, 0);
    assert_int_equal(m.model->pdos[1].index, 0x1A00);
    drop(&m);
}

/* Versions of General: without the address of the identification, and too short for anything. */
static void a_short_general_has_what_fits(void **state)
{
    static const uint8_t general[18] = {[11] = ECT_GENERAL_ID_MEMORY | ECT_GENERAL_NO_LRW, [16] = 0x11};
    (void)state;
    for (size_t length = 16; length <= sizeof general; length += 2) {
        image_t image;
        begin(&image, 0);
        add(&image, ECT_SII_GENERAL, general, length);
        end(&image);
        made_t m = make(&image);
        assert_int_equal(m.model->lrd_lwr, length >= 18);
        assert_string_equal(m.model->physics, length >= 18 ? "YY" : "");
        assert_false(m.model->identification_ado.given);
        drop(&m);
    }
}

static void one_of_vendor_id_and_product_code_is_enough(void **state)
{
    static const uint32_t rows[][2] = {{0, 5}, {5, 0}, {UINT32_MAX, 5}, {5, UINT32_MAX}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        image_t image;
        begin(&image, 0);
        ect_store_le32(image.bytes + 0x10, rows[i][0]);
        ect_store_le32(image.bytes + 0x14, rows[i][1]);
        end(&image);
        made_t m = make(&image);
        assert_int_equal(m.model->vendor_id, rows[i][0]);
        assert_int_equal(m.model->product_code, rows[i][1]);
        drop(&m);
    }
}

static void wrong_images_have_one_line(void **state)
{
    static const struct {
        size_t size;
        uint8_t fill;
        const char *line;
    } rows[] = {
        {0, 0, "image: not an EEPROM image: 0 bytes, its header alone has 128"},
        {127, 0x55, "image: not an EEPROM image: 127 bytes, its header alone has 128"},
        {128, 0, "image: an empty EEPROM image: it has neither vendor id nor product code"},
        {2048, 0xFF, "image: an empty EEPROM image: it has neither vendor id nor product code"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t bytes[2048];
        char why[TEXT];
        memset(bytes, rows[i].fill, sizeof bytes);
        assert_null(ect_esi_of_image("image", bytes, rows[i].size, why, sizeof why));
        assert_string_equal(why, rows[i].line);
    }
}

/* The image ends anywhere: complete parts are used, and no byte behind it is read (sanitizer). */
static void an_image_may_end_at_any_byte(void **state)
{
    const ect_device_t *device = ect_catalogue_find("fzm1")->device;
    static uint8_t whole[IMAGE];
    (void)state;
    assert_int_equal(ect_sii_write(device, NULL, 0, whole, sizeof whole), device->sii_size);
    for (size_t size = ECT_SII_CATEGORIES; size < device->sii_size && size < 2048; size++) {
        char why[TEXT];
        uint8_t *cut = malloc(size);
        memcpy(cut, whole, size);
        ect_esi_t *esi = ect_esi_of_image("image", cut, size, why, sizeof why);
        assert_non_null(esi);
        const ect_esi_device_t *model = ect_esi_select(esi, "", why, sizeof why);
        ect_esi_twin_t *twin = ect_esi_twin_of(esi, model, NULL, 0, why, sizeof why);
        assert_int_equal(model->vendor_id, device->identity.vendor_id);
        ect_esi_twin_free(twin);
        ect_esi_close(esi);
        free(cut);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_device_of_the_catalogue_comes_back_from_its_image),
        cmocka_unit_test(the_eeprom_has_the_size_of_its_header),
        cmocka_unit_test(mailboxes_of_the_header_serve_without_a_category_of_sync_managers),
        cmocka_unit_test(each_field_of_general_is_read),
        cmocka_unit_test(each_text_of_general_is_read),
        cmocka_unit_test(texts_of_modes_and_pdos_are_read),
        cmocka_unit_test(each_flag_of_a_pdo_is_read),
        cmocka_unit_test(each_type_of_a_sync_manager_has_its_name),
        cmocka_unit_test(each_type_of_an_fmmu_has_its_name),
        cmocka_unit_test(each_flag_of_a_sync_manager_is_read),
        cmocka_unit_test(each_element_of_a_category_is_read),
        cmocka_unit_test(of_more_pdos_than_a_sync_manager_holds_the_first_that_fit_are_assigned),
        cmocka_unit_test(process_data_without_pdos_are_bytes),
        cmocka_unit_test(pdos_are_read_as_far_as_they_are_whole),
        cmocka_unit_test(a_short_general_has_what_fits),
        cmocka_unit_test(one_of_vendor_id_and_product_code_is_enough),
        cmocka_unit_test(wrong_images_have_one_line),
        cmocka_unit_test(an_image_may_end_at_any_byte),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
