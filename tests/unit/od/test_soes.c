/* SPDX-License-Identifier: MIT */
/*
 * A dictionary without a base: an object list of a SOES application, used by cast. `data` is an address, the list ends
 * with index FFFFh.
 */
#include <string.h>

#include "check/check.h"
#include "seams/standard.h"
#include "sii/sii.h"
#include "support/wire.h"

enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };

/* --- a SOES application ------------------------------------------------------------------------------------------- */

typedef struct objd {
    uint16_t subindex, datatype, bitlength, flags;
    const char *name;
    uint32_t value;
    void *data;
} objd_t;
typedef struct objectlist {
    uint16_t index, objtype;
    uint8_t maxsub, pad1;
    const char *name;
    const objd_t *objdesc;
} objectlist_t;

enum { DTYPE_U8 = 5, DTYPE_U16 = 6, DTYPE_U32 = 7, DTYPE_STRING = 9, DTYPE_BOOL = 1 };
enum { OTYPE_VAR = 7, OTYPE_ARRAY = 8, OTYPE_RECORD = 9 };
enum { ATYPE_RO = 0x07, ATYPE_RW = 0x3F, ATYPE_RXPDO = 0x40, ATYPE_TXPDO = 0x80 };

static struct {
    uint32_t serial;
    uint8_t switches[2];
    uint16_t count;
    uint8_t lamps[2];
    uint16_t set;
    uint32_t gain;
    uint16_t far, farther;
    uint8_t octet;
    char label[64];
} app;

static char name_1008[] = "SOES device";

static const objd_t sdo1000[] = {{0, DTYPE_U32, 32, ATYPE_RO, "Device Type", 0x00000191, NULL}};
static const objd_t sdo1008[] = {{0, DTYPE_STRING, 88, ATYPE_RO, "Device Name", 0, name_1008}};
static const objd_t sdo1018[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 4, NULL},
                                 {1, DTYPE_U32, 32, ATYPE_RO, "Vendor ID", ECTWIN_VENDOR_ID, NULL},
                                 {2, DTYPE_U32, 32, ATYPE_RO, "Product Code", 0x1234, NULL},
                                 {3, DTYPE_U32, 32, ATYPE_RO, "Revision Number", 2, NULL},
                                 {4, DTYPE_U32, 32, ATYPE_RO, "Serial Number", 0, &app.serial}};
static const objd_t sdo1600[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 4, NULL},
                                 {1, DTYPE_U32, 32, ATYPE_RO, "Lamp 1", 0x70000101, NULL},
                                 {2, DTYPE_U32, 32, ATYPE_RO, "Lamp 2", 0x70000201, NULL},
                                 {3, DTYPE_U32, 32, ATYPE_RO, "Padding", 0x00000006, NULL},
                                 {4, DTYPE_U32, 32, ATYPE_RO, "Set value", 0x70010010, NULL}};
static const objd_t sdo1a00[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 5, NULL},
                                 {1, DTYPE_U32, 32, ATYPE_RO, "Switch 1", 0x60000101, NULL},
                                 {2, DTYPE_U32, 32, ATYPE_RO, "Switch 2", 0x60000201, NULL},
                                 {3, DTYPE_U32, 32, ATYPE_RO, "Padding", 0x00000006, NULL},
                                 {4, DTYPE_U32, 32, ATYPE_RO, "Count", 0x60010010, NULL},
                                 {5, DTYPE_U32, 32, ATYPE_RO, "Farther", 0x60100C10, NULL}};
static const objd_t sdo1c00[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 4, NULL},
                                 {1, DTYPE_U8, 8, ATYPE_RO, "SM0", 1, NULL},
                                 {2, DTYPE_U8, 8, ATYPE_RO, "SM1", 2, NULL},
                                 {3, DTYPE_U8, 8, ATYPE_RO, "SM2", 3, NULL},
                                 {4, DTYPE_U8, 8, ATYPE_RO, "SM3", 4, NULL}};
static const objd_t sdo1c12[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 1, NULL},
                                 {1, DTYPE_U16, 16, ATYPE_RO, "PDO", 0x1600, NULL}};
static const objd_t sdo1c13[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 1, NULL},
                                 {1, DTYPE_U16, 16, ATYPE_RO, "PDO", 0x1A00, NULL}};
static const objd_t sdo6000[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 2, NULL},
                                 {1, DTYPE_BOOL, 1, ATYPE_RO | ATYPE_TXPDO, "Switch 1", 0, &app.switches[0]},
                                 {2, DTYPE_BOOL, 1, ATYPE_RO | ATYPE_TXPDO, "Switch 2", 0, &app.switches[1]}};
static const objd_t sdo6001[] = {{0, DTYPE_U16, 16, ATYPE_RO | ATYPE_TXPDO, "Count", 0, &app.count}};
/* Sparse; sub-index 0 gives the highest sub-index in one, the number of elements in the other. */
static const objd_t sdo6010[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 12, NULL},
                                 {11, DTYPE_U16, 16, ATYPE_RO | ATYPE_TXPDO, "Far", 0x0B0B, &app.far},
                                 {12, DTYPE_U16, 16, ATYPE_RO | ATYPE_TXPDO, "Farther", 0x0C0C, &app.farther}};
static const objd_t sdo8002[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 2, NULL},
                                 {4, DTYPE_U16, 16, ATYPE_RO, "Constant", 0x0404, NULL},
                                 {255, DTYPE_U8, 8, ATYPE_RW, "Octet", 0xFF, &app.octet}};
static const objd_t sdo7000[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 2, NULL},
                                 {1, DTYPE_BOOL, 1, ATYPE_RO | ATYPE_RXPDO, "Lamp 1", 0, &app.lamps[0]},
                                 {2, DTYPE_BOOL, 1, ATYPE_RO | ATYPE_RXPDO, "Lamp 2", 0, &app.lamps[1]}};
static const objd_t sdo7001[] = {{0, DTYPE_U16, 16, ATYPE_RO | ATYPE_RXPDO, "Set value", 0, &app.set}};
static const objd_t sdo8000[] = {{0, DTYPE_U8, 8, ATYPE_RO, "Max SubIndex", 5, NULL},
                                 {2, DTYPE_U32, 32, ATYPE_RW, "Gain", 1000, &app.gain},
                                 {5, DTYPE_U16, 16, ATYPE_RO, "Constant", 77, NULL}};
static const objd_t sdo8001[] = {{0, DTYPE_STRING, 512, ATYPE_RW, "Label", 0, app.label}};

static const objectlist_t sdo_objects[] = {{0x1000, OTYPE_VAR, 0, 0, "Device Type", sdo1000},
                                           {0x1008, OTYPE_VAR, 0, 0, "Device Name", sdo1008},
                                           {0x1018, OTYPE_RECORD, 4, 0, "Identity", sdo1018},
                                           {0x1600, OTYPE_RECORD, 4, 0, "Outputs", sdo1600},
                                           {0x1A00, OTYPE_RECORD, 5, 0, "Inputs", sdo1a00},
                                           {0x1C00, OTYPE_ARRAY, 4, 0, "SM types", sdo1c00},
                                           {0x1C12, OTYPE_ARRAY, 1, 0, "SM2 PDOs", sdo1c12},
                                           {0x1C13, OTYPE_ARRAY, 1, 0, "SM3 PDOs", sdo1c13},
                                           {0x6000, OTYPE_ARRAY, 2, 0, "Switches", sdo6000},
                                           {0x6001, OTYPE_VAR, 0, 0, "Count", sdo6001},
                                           {0x6010, OTYPE_RECORD, 2, 0, "Sparse", sdo6010},
                                           {0x7000, OTYPE_ARRAY, 2, 0, "Lamps", sdo7000},
                                           {0x7001, OTYPE_VAR, 0, 0, "Set value", sdo7001},
                                           {0x8000, OTYPE_RECORD, 2, 0, "Settings", sdo8000},
                                           {0x8001, OTYPE_VAR, 0, 0, "Label", sdo8001},
                                           {0x8002, OTYPE_RECORD, 2, 0, "Sparse, counted", sdo8002},
                                           {0xFFFF, 0xFF, 0xFF, 0xFF, NULL, NULL}};

/* --- the device --------------------------------------------------------------------------------------------------- */

static void inputs(void *instance, uint64_t now_ns)
{
    (void)instance;
    (void)now_ns;
    app.count++;
    app.switches[0] = app.lamps[1];
    app.switches[1] = app.lamps[0];
}

static const ect_protocol_t *const protocols[] = {&ect_protocol_sdo, &ect_protocol_sdo_info, NULL};

static const ect_device_t device = {
    .name = "soes",
    .summary = "An object list of SOES",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "SOES device",
    .group_type = "TEST",
    .group_name = "Test devices",
    .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = 0x1234, .revision = 2, .serial = 0},
    .esc = "et1100",
    .esc_config = {0x08},
    .sii_size = 1024,
    .sm = {{.start = 0x1000, .length = 128, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = 128, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1100, .control = 0x24, .type = ECT_SM_OUTPUTS},
           {.start = 0x1180, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS},
    .fmmu_count = 2,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_COMPLETE_ACCESS,
    .physics = "YY",
    .timeouts = {.preop_ms = 3000, .safeop_op_ms = 3000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},
    .objects = (const ect_object_t *)(const void *)sdo_objects,
    .object_count = sizeof sdo_objects / sizeof sdo_objects[0] - 1,
    .addresses = true,
    .instance_size = sizeof(ect_standard_t),
    .inputs = inputs,
};

static void open_in(wire_t *w, uint8_t state)
{
    memset(&app, 0, sizeof app);
    app.serial = 0xABCD;
    wire_open_one(w, &device);
    wire_go(w, 0, state);
}

static void expect_upload(wire_t *w, uint16_t index, uint8_t subindex, bool complete, const void *want, size_t length)
{
    uint8_t got[256];
    size_t size = sizeof got;
    uint32_t code = wire_sdo_upload(w, 0, index, subindex, complete, got, &size);
    if (code != 0 || size != length || memcmp(got, want, length) != 0)
        fail_msg("%04Xh:%u: abort %08X, %zu bytes, or not as expected", index, subindex, code, size);
}

static void described(void **state)
{
    char text[ECT_CHECK_TEXT];
    (void)state;
    if (!ect_device_check(&device, text, sizeof text))
        fail_msg("%s", text);
}

static void process_data(void **state)
{
    uint8_t out[3] = {0x01, 0x34, 0x12}, in[5];
    wire_t w;
    (void)state;
    open_in(&w, OP);
    assert_int_equal(wire_write(&w, 0, 0x1100, out, sizeof out), 1);
    assert_int_equal(app.lamps[0], 1);
    assert_int_equal(app.lamps[1], 0);
    assert_int_equal(app.set, 0x1234);
    assert_int_equal(wire_read(&w, 0, 0x1180, in, sizeof in), 1);
    assert_int_equal(in[0], 0x02);
    assert_int_equal(ect_load_le16(in + 1) + 1, app.count); /* renewed after this read */
    assert_int_equal(ect_load_le16(in + 3), 0x0C0C);        /* 6010:12, the last of a sparse record */
    wire_close(&w);
}

/* The last entry of each sparse record: read, written, given its default, part of the whole object. */
static void sparse_records(void **state)
{
    static const uint8_t far[] = {12, 0, 0x0B, 0x0B, 0x0C, 0x0C}, counted[] = {2, 0, 0x04, 0x04, 0xFF};
    uint8_t data[8];
    size_t size = sizeof data;
    wire_t w;
    (void)state;
    open_in(&w, PREOP);
    expect_upload(&w, 0x6010, 12, false, "\x0C\x0C", 2);
    expect_upload(&w, 0x6010, 0, true, far, sizeof far);
    expect_upload(&w, 0x6010, 1, true, far + 2, sizeof far - 2);
    assert_int_equal(wire_sdo_upload(&w, 0, 0x6010, 10, false, data, &size), 0x06090011);
    assert_int_equal(wire_sdo_upload(&w, 0, 0x6010, 13, false, data, &size), 0x06090011);
    expect_upload(&w, 0x8002, 255, false, "\xFF", 1);
    expect_upload(&w, 0x8002, 0, true, counted, sizeof counted);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8002, 255, false, "\x07", 1), 0);
    assert_int_equal(app.octet, 7);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8002, 1, true, "\0\0\x09", 3), 0);
    assert_int_equal(app.octet, 9);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8002, 1, true, "\0\0\x09\0", 4), 0x06070012);
    wire_close(&w);
}

/* The highest sub-index, as SDO information gives it, and each entry up to it. */
static void sparse_descriptions(void **state)
{
    uint8_t object[] = {0x00, 0x80, 3, 0, 0, 0, 0x10, 0x60}, entry[] = {0x00, 0x80, 5, 0, 0, 0, 0x10, 0x60, 0, 7};
    uint8_t reply[128] = {0};
    wire_t w;
    (void)state;
    open_in(&w, PREOP);
    assert_true(wire_coe(&w, 0, object, sizeof object, reply, sizeof reply) > 12);
    assert_int_equal(reply[10], 12);
    for (uint8_t sub = 0; sub <= 12; sub++) {
        entry[8] = sub;
        assert_true(wire_coe(&w, 0, entry, sizeof entry, reply, sizeof reply) >= 16);
        assert_int_equal(reply[2], 6);
        assert_int_equal(ect_load_le16(reply + 12), sub == 0 ? 8 : sub >= 11 ? 16 : 0); /* its bits; 0: a gap */
    }
    entry[8] = 13;
    assert_true(wire_coe(&w, 0, entry, sizeof entry, reply, sizeof reply) > 0);
    assert_int_equal(reply[2], 7);
    object[6] = 0x02;
    object[7] = 0x80;
    assert_true(wire_coe(&w, 0, object, sizeof object, reply, sizeof reply) > 12);
    assert_int_equal(reply[10], 255);
    wire_close(&w);
}

static void uploads(void **state)
{
    static const uint8_t identity[] = {4, 0, 0x57, 0x0E, 0, 0, 0x34, 0x12, 0, 0, 2, 0, 0, 0, 0xCD, 0xAB, 0, 0};
    wire_t w;
    (void)state;
    open_in(&w, PREOP);
    expect_upload(&w, 0x1000, 0, false, "\x91\x01\0\0", 4);
    expect_upload(&w, 0x1008, 0, false, "SOES device", 11);
    expect_upload(&w, 0x1018, 4, false, "\xCD\xAB\0\0", 4);
    expect_upload(&w, 0x1018, 0, true, identity, sizeof identity);
    expect_upload(&w, 0x8000, 2, false, "\xE8\x03\0\0", 4); /* the default, set at power-on */
    expect_upload(&w, 0x8000, 5, false, "\x4D\0", 2);
    uint8_t data[8];
    size_t size = sizeof data;
    assert_int_equal(wire_sdo_upload(&w, 0, 0x8000, 3, false, data, &size), 0x06090011);
    size = sizeof data;
    assert_int_equal(wire_sdo_upload(&w, 0, 0xFFFF, 0, false, data, &size), 0x06020000);
    wire_close(&w);
}

static void downloads(void **state)
{
    char label[64], got[64] = "";
    size_t size = sizeof got;
    wire_t w;
    (void)state;
    open_in(&w, PREOP);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8000, 2, false, "\1\2\3\4", 4), 0);
    assert_int_equal(app.gain, 0x04030201);
    memset(label, 'x', sizeof label);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8001, 0, false, label, 60), 0);
    assert_int_equal(strlen(app.label), 60);
    assert_int_equal(wire_sdo_upload(&w, 0, 0x8001, 0, false, got, &size), 0);
    assert_int_equal(size, 60);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8000, 5, false, "\1\2", 2), 0x06010002);
    wire_close(&w);
}

static void information(void **state)
{
    static const uint8_t request[] = {0x00, 0x80, 1, 0, 0, 0, 1, 0};
    uint8_t reply[128] = {0};
    wire_t w;
    (void)state;
    open_in(&w, PREOP);
    assert_true(wire_coe(&w, 0, request, sizeof request, reply, sizeof reply) > 0);
    for (uint16_t i = 0; i < device.object_count; i++)
        assert_int_equal(ect_load_le16(reply + 8 + (size_t)2 * i), sdo_objects[i].index);
    wire_close(&w);
}

static void image(void **state)
{
    static uint8_t sii[1024];
    size_t length;
    (void)state;
    assert_int_equal(ect_sii_write(&device, NULL, 0, sii, sizeof sii), sizeof sii);
    const uint8_t *sm = ect_sii_category(sii, sizeof sii, ECT_SII_SYNCM, &length);
    const uint8_t *pdo = ect_sii_category(sii, sizeof sii, ECT_SII_RXPDO, &length);
    assert_non_null(sm);
    assert_non_null(pdo);
    assert_int_equal(ect_load_le16(sm + 16 + 2), 3);
    assert_int_equal(ect_load_le16(sm + 24 + 2), 5);
    assert_int_equal(pdo[2], 4);
    assert_int_equal(length, 8 + 4 * 8);
}

int main(int argc, char **argv)
{
#define T(title, test) {title, test, NULL, NULL, NULL}
    const struct CMUnitTest tests[] = {
        T("a SOES object list is a good description", described),
        T("CF-037: its process data go to and come from its addresses", process_data),
        T("CF-067 CF-068: its entries are read, constants, gaps and whole objects", uploads),
        T("CF-067 CF-068: a sparse record of SOES ends with the entry at position `maxsub`", sparse_records),
        T("CF-076: a sparse record of SOES is described up to its last sub-index", sparse_descriptions),
        T("CF-069 CF-070: its entries are written, in one mail and in segments", downloads),
        T("CF-076: its objects are listed up to its end", information),
        T("CF-061: its PDOs are in the SII", image),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SOES object lists", tests, NULL, NULL);
}
