/* SPDX-License-Identifier: MIT */
/* The SII image, byte by byte, of members of a description that few devices use. */
#include <string.h>

#include "sii/sii.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { IMAGE = 1024, GUARD = 16, LARGEST = 32768 };

/* A category of the image that must exist. */
static const uint8_t *data_of(const uint8_t *image, uint16_t category, size_t *length)
{
    const uint8_t *data = ect_sii_category(image, IMAGE, category, length);
    if (!data)
        fail_msg("there is no category %u", category);
    return data;
}

static void write_image(const ect_device_t *device, uint16_t alias, uint8_t *image)
{
    assert_int_equal(ect_sii_write(device, NULL, alias, image, IMAGE), IMAGE);
}

/* --- objects ------------------------------------------------------------------------------------------------------ */

static ect_entry_t word[] = {{0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, NULL, 0, NULL}};
static const ect_entry_t mapping[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_MAP(1, ECT_MAP(0x6000, 0, 16))};
/* Two elements, of which sub-index 0 counts one. */
static const ect_entry_t shorter[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00), ECT_ENTRY_ASSIGN(2, 0x1A01)};
static const ect_entry_t changeable[] = {
    {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW_PREOP, "Count", 1, ECT_OFFSET(testdev_t, record_ro)},
    ECT_ENTRY_ASSIGN(1, 0x1A00)};

static ect_object_t objects[] = {ECT_RECORD(0x1A00, "First", mapping), ECT_RECORD(0x1A01, "Second", mapping),
                                 ECT_ARRAY(0x1C13, "Assignment", shorter), ECT_VAR(0x6000, "Word", word)};

static ect_device_t small_device(void)
{
    ect_device_t device = testdev;
    objects[2] = (ect_object_t)ECT_ARRAY(0x1C13, "Assignment", shorter);
    objects[0].name = "First";
    word[0].name = NULL;
    device.objects = objects;
    device.object_count = sizeof objects / sizeof objects[0];
    device.sii_size = IMAGE;
    return device;
}

/* --- texts -------------------------------------------------------------------------------------------------------- */

/* Neither a missing nor an empty text is a string of the table, even next to a string of one character. */
static void missing_texts(void **state)
{
    static uint8_t image[IMAGE];
    size_t length;
    ect_device_t device = small_device();
    (void)state;
    device.full_name = "F";
    device.type_name = "T";
    device.group_type = NULL;
    device.group_name = "";
    objects[0].name = NULL;
    write_image(&device, 0, image);
    const uint8_t *strings = data_of(image, ECT_SII_STRINGS, &length);
    assert_memory_equal(strings,
                        "\x03\x01"
                        "F\x01"
                        "T\x06Second",
                        12);
    assert_int_equal(length, 12);
    const uint8_t *general = data_of(image, ECT_SII_GENERAL, &length);
    assert_memory_equal(general, "\0\0\2\1", 4);
    assert_int_equal(general[14], 0);
    const uint8_t *pdos = data_of(image, ECT_SII_TXPDO, &length);
    assert_int_equal(length, 2 * 16);
    assert_int_equal(pdos[5], 0);
    assert_memory_equal(pdos + 8, "\x00\x60\x00\x00\x06\x10\x00\x00", 8);
    assert_int_equal(pdos[16 + 5], 3);
}

/* --- General ------------------------------------------------------------------------------------------------------ */

static void general(void **state)
{
    static const struct {
        uint8_t protocols, flags;
        uint16_t alias;
        uint8_t want;
    } rows[] = {{4, 0, 0, 0x0C},    {4, 0, 5, 0x0C},    {0, 0, 0, 0x08},    {0, 0, 5, 0x08},
                {4, 0x80, 0, 0x00}, {4, 0x80, 5, 0x08}, {4, 0x93, 0, 0x13}, {4, 0x93, 5, 0x1B}};
    static uint8_t image[IMAGE];
    size_t length;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = small_device();
        device.mailbox_protocols = rows[i].protocols;
        device.general_flags = rows[i].flags;
        device.soe_channels = 3;
        device.id_address = 0x1234;
        device.physics =
            rows[i].alias == 0 ? "HKYYY" : "HK\0Y"; /* no more than four ports, and no more than there are */
        write_image(&device, rows[i].alias, image);
        const uint8_t *data = data_of(image, ECT_SII_GENERAL, &length);
        assert_int_equal(length, 32);
        assert_memory_equal(data + 8, "\3\0\0", 3);
        if (data[11] != rows[i].want)
            fail_msg("row %zu: expected flags %02X, got %02X", i, rows[i].want, data[11]);
        assert_int_equal(ect_load_le16(data + 16), rows[i].alias == 0 ? 0x1134 : 0x0034);
        assert_int_equal(ect_load_le16(data + 18), 0x1234);
        assert_memory_equal(data + 20, "\0\0\0\0\0\0\0\0\0\0\0\0", 12);
        assert_int_equal(ect_load_le16(image + 0x38), rows[i].protocols);
    }
}

/* --- header ------------------------------------------------------------------------------------------------------- */

/* The mailboxes are those among the SyncManagers of the device, whatever their numbers. */
static void mailboxes(void **state)
{
    static const struct {
        uint8_t first, second, count;
        uint8_t want[8];
    } rows[] = {
        {ECT_SM_MAILBOX_OUT, ECT_SM_MAILBOX_IN, 2, {0x00, 0x10, 0x50, 0x00, 0x00, 0x11, 0x60, 0x00}},
        {ECT_SM_MAILBOX_IN, ECT_SM_MAILBOX_OUT, 2, {0x00, 0x11, 0x60, 0x00, 0x00, 0x10, 0x50, 0x00}},
        {ECT_SM_MAILBOX_OUT, ECT_SM_MAILBOX_IN, 1, {0x00, 0x10, 0x50, 0x00, 0x00, 0x00, 0x00, 0x00}},
        {ECT_SM_MAILBOX_OUT, ECT_SM_MAILBOX_IN, 0, {0}},
    };
    static uint8_t image[IMAGE];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = small_device();
        device.sm[0] = (ect_sm_t){.start = 0x1000, .length = 0x50, .control = 0x26, .type = rows[i].first};
        device.sm[1] = (ect_sm_t){.start = 0x1100, .length = 0x60, .control = 0x22, .type = rows[i].second};
        device.sm_count = rows[i].count;
        device.boot_out = (ect_boot_mailbox_t){0x1234, 0x0056};
        device.boot_in = (ect_boot_mailbox_t){0x1378, 0x009A};
        write_image(&device, 0x0BCD, image);
        assert_int_equal(ect_load_le16(image + 8), 0x0BCD);
        assert_memory_equal(image + 0x20, "\0\0\0\0\0\0\0\0\x34\x12\x56\0\x78\x13\x9A\0", 16);
        assert_memory_equal(image + 0x30, rows[i].want, 8);
        for (size_t at = 0x3A; at < 0x7C; at++)
            assert_int_equal(image[at], 0);
    }
}

/* --- clocks ------------------------------------------------------------------------------------------------------- */

/* Every byte of every number differs. */
static void clocks(void **state)
{
    static const ect_dc_mode_t mode = {.name = "A",
                                       .description = "B",
                                       .assign_activate = 0x0103,
                                       .cycle_sync0_ns = 0x04050607,
                                       .factor_sync0 = 0x0809,
                                       .factor_sync1 = 0x0A0B,
                                       .shift_sync0_ns = 0x0C0D0E0F,
                                       .shift_sync1_ns = 0x11131517};
    static const uint8_t want[] = {0x07, 0x06, 0x05, 0x04, 0x0F, 0x0E, 0x0D, 0x0C, 0x17, 0x15, 0x13, 0x11,
                                   0x0B, 0x0A, 0x03, 0x01, 0x09, 0x08, 5,    6,    0,    0,    0,    0};
    static uint8_t image[IMAGE];
    size_t length;
    ect_device_t device = small_device();
    (void)state;
    device.full_name = "F";
    device.type_name = "T";
    device.group_type = "G";
    device.group_name = "N";
    device.dc_modes = &mode;
    device.dc_mode_count = 1;
    write_image(&device, 0, image);
    const uint8_t *data = data_of(image, ECT_SII_DC, &length);
    assert_int_equal(length, sizeof want);
    assert_memory_equal(data, want, sizeof want);
}

/* --- PDOs --------------------------------------------------------------------------------------------------------- */

static uint16_t flags_of(const ect_device_t *device, unsigned int object)
{
    return ect_sii_pdo_flags(device, &objects[object]);
}

static void assignments(void **state)
{
    static const ect_pdo_t properties[] = {{.index = 0x1A05, .flags = 0x0001}, {.index = 0x1A01, .flags = 0x0020}};
    ect_device_t device = small_device();
    (void)state;
    assert_int_equal(ect_sii_pdo_sm(&device, 0x1A00), 3);
    assert_int_equal(ect_sii_pdo_sm(&device, 0x1A01), 0xFF); /* listed, and not counted */
    assert_int_equal(flags_of(&device, 0), ECT_PDO_FIXED | ECT_PDO_MANDATORY);
    assert_int_equal(flags_of(&device, 1), ECT_PDO_FIXED);
    objects[2] = (ect_object_t)ECT_ARRAY(0x1C13, "Assignment", changeable);
    assert_int_equal(flags_of(&device, 0), ECT_PDO_FIXED);
    device.pdos = properties;
    device.pdo_count = 2;
    assert_int_equal(flags_of(&device, 0), ECT_PDO_FIXED);
    assert_int_equal(flags_of(&device, 1), ECT_PDO_VIRTUAL);
    device.pdo_count = 1;
    assert_int_equal(flags_of(&device, 1), ECT_PDO_FIXED);
    device.sm[3].type = ECT_SM_UNUSED; /* its assignment assigns nothing */
    assert_int_equal(ect_sii_pdo_sm(&device, 0x1A00), 0xFF);
}

static void virtual_sync_managers(void **state)
{
    static const uint16_t none[] = {0}, both[] = {0x1A00, 0x1A01, 0, 0x1A02};
    static uint8_t image[IMAGE];
    size_t length;
    ect_device_t device = small_device();
    (void)state;
    device.object_count = 2;
    device.sm[2] = (ect_sm_t){.start = 0x0990, .flags = ECT_SM_FLAG_VIRTUAL, .role = ECT_SM_OUTPUTS, .pdos = none};
    device.sm[3] = (ect_sm_t){
        .start = 0x09AE, .control = 0x20, .flags = ECT_SM_FLAG_VIRTUAL | 8, .role = ECT_SM_INPUTS, .pdos = both};
    assert_int_equal(ect_sii_pdo_sm(&device, 0x1A00), 3);
    assert_int_equal(ect_sii_pdo_sm(&device, 0x1A01), 3);
    assert_int_equal(ect_sii_pdo_sm(&device, 0x1A02), 0xFF); /* behind the end of the list */
    assert_int_equal(ect_sii_pdo_sm(&device, 0), 0xFF);
    write_image(&device, 0, image);
    const uint8_t *sm = data_of(image, ECT_SII_SYNCM, &length);
    assert_int_equal(length, 4 * 8);
    assert_memory_equal(sm + 16, "\x90\x09\x00\x00\x00\x00\x04\x03", 8);
    assert_memory_equal(sm + 24, "\xAE\x09\x00\x00\x20\x00", 6);
    assert_int_equal(sm[24 + 6] & ~1, 0x0C);
    assert_int_equal(sm[24 + 7], 4);
    device.sm_count = 3; /* SM3 of the description is not one of the device */
    assert_int_equal(ect_sii_pdo_sm(&device, 0x1A00), 0xFF);
}

/* --- the end of the EEPROM ---------------------------------------------------------------------------------------- */

/* Refused or not, no byte behind the EEPROM is written. */
static void no_byte_behind(void **state)
{
    static uint8_t image[IMAGE + GUARD];
    ect_device_t device = small_device();
    (void)state;
    for (uint16_t size = 128; size <= 512; size++) {
        device.sii_size = size;
        memset(image, 0xA5, sizeof image);
        (void)ect_sii_write(&device, NULL, 0, image, size);
        for (size_t i = size; i < size + (size_t)GUARD; i++) {
            if (image[i] != 0xA5)
                fail_msg("an EEPROM of %u bytes: byte %zu is written", size, i);
        }
    }
}

/* An image whose names of entries do not fit is written again without them: nothing remains of the first attempt. */
static void second_attempt(void **state)
{
    static uint8_t image[IMAGE];
    ect_device_t device = small_device();
    unsigned int shortened = 0;
    (void)state;
    word[0].name = "The name of an entry, which is longer than all other texts of the image together";
    write_image(&device, 0, image);
    uint8_t strings_of_all = image[ECT_SII_CATEGORIES + 4];
    for (uint16_t size = 256; size <= 512; size = (uint16_t)(size + 2)) {
        size_t at = ECT_SII_CATEGORIES;
        device.sii_size = size;
        if (ect_sii_write(&device, NULL, 0, image, size) < 0)
            continue;
        shortened += image[ECT_SII_CATEGORIES + 4] < strings_of_all;
        while (ect_load_le16(image + at) != ECT_SII_END)
            at += 4 + 2u * ect_load_le16(image + at + 2);
        for (; at < size; at++) {
            if (image[at] != 0xFF)
                fail_msg("an EEPROM of %u bytes: byte %zu behind the image is %02X", size, at, image[at]);
        }
    }
    assert_true(shortened > 1);
}

/* A buffer longer than the EEPROM is erased up to its end. */
static void longer_buffer(void **state)
{
    static uint8_t image[IMAGE + GUARD];
    ect_device_t device = small_device();
    (void)state;
    memset(image, 0, sizeof image);
    assert_int_equal(ect_sii_write(&device, NULL, 0, image, sizeof image), IMAGE);
    for (size_t i = IMAGE; i < sizeof image; i++)
        assert_int_equal(image[i], 0xFF);
    assert_int_equal(ect_load_le16(image + 0x7C), IMAGE / 128 - 1);
    assert_int_equal(ect_load_le16(image + 0x7E), 1);
    static uint8_t largest[LARGEST];
    device.sii_size = LARGEST;
    assert_int_equal(ect_sii_write(&device, NULL, 0, largest, sizeof largest), LARGEST);
    assert_int_equal(ect_load_le16(largest + 0x7C), LARGEST / 128 - 1);
}

/* A category whose header ends with the image has no data, and exists. */
static void empty_category(void **state)
{
    uint8_t image[ECT_SII_CATEGORIES + 4] = {0};
    size_t length = 1;
    (void)state;
    ect_store_le16(image + ECT_SII_CATEGORIES, ECT_SII_FMMU);
    assert_ptr_equal(ect_sii_category(image, sizeof image, ECT_SII_FMMU, &length), image + sizeof image);
    assert_int_equal(length, 0);
    assert_null(ect_sii_category(image, sizeof image - 1, ECT_SII_FMMU, &length));
    assert_null(ect_sii_category(image, sizeof image, ECT_SII_SYNCM, &length));
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-064: a text that is missing or empty is no string of the table", missing_texts, NULL, NULL, NULL},
        {"CF-060: every byte of the category General", general, NULL, NULL, NULL},
        {"CF-060: the header names the mailboxes of the device and of BOOT", mailboxes, NULL, NULL, NULL},
        {"CF-062: every byte of a DC mode", clocks, NULL, NULL, NULL},
        {"CF-061: a PDO is assigned by counted elements only; its flags follow its objects or its own row", assignments,
         NULL, NULL, NULL},
        {"CF-061: the list of a virtual SyncManager assigns its PDOs", virtual_sync_managers, NULL, NULL, NULL},
        {"CF-060: no byte behind the EEPROM is written, at every size", no_byte_behind, NULL, NULL, NULL},
        {"CF-064: an image written without the names of entries has no remains of them", second_attempt, NULL, NULL,
         NULL},
        {"CF-060: an empty category at the end of an image is found", empty_category, NULL, NULL, NULL},
        {"CF-060: a buffer longer than the EEPROM reads as erased behind it", longer_buffer, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SII, rare members", tests, NULL, NULL);
}
