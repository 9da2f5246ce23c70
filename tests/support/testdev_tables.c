/* SPDX-License-Identifier: MIT */
#include "support/testdev.h"

#include <assert.h>

#define AT(member) ECT_OFFSET(testdev_t, member)
#define RW         ECT_ACCESS_RW

static const ect_entry_t e1000[] = {ECT_ENTRY_CONST(ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Device type", 0x12345678)};
static const ect_entry_t e1001[] = {
    {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Error register", 0, ECT_STANDARD(error_register)}};
static const ect_entry_t e1008[] = {ECT_ENTRY_TEXT("Device name", "ectwin test device")};
static const ect_entry_t e1600[] = {ECT_ENTRY_COUNT(3), ECT_ENTRY_MAP(1, ECT_MAP(0x7000, 1, 1)),
                                    ECT_ENTRY_MAP(2, ECT_MAP(0, 0, 7)), ECT_ENTRY_MAP(3, ECT_MAP(0x7000, 2, 16))};
static const ect_entry_t e1a00[] = {ECT_ENTRY_COUNT(3), ECT_ENTRY_MAP(1, ECT_MAP(0x6000, 1, 16)),
                                    ECT_ENTRY_MAP(2, ECT_MAP(0x6000, 2, 3)), ECT_ENTRY_MAP(3, ECT_MAP(0, 0, 5))};
static const ect_entry_t e1c12[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t e1c13[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};
static const ect_entry_t e2000[] = {{0, ECT_TYPE_UNSIGNED32, 32, RW | ECT_ACCESS_BACKUP, "U32", 0x11223344, AT(u32)}};
static const ect_entry_t e2001[] = {{0, ECT_TYPE_VISIBLE_STRING, 160, RW, "Text", 0, AT(text)}};
static const ect_entry_t e2002[] = {{0, ECT_TYPE_OCTET_STRING, 8000, RW, "Octets", 0, AT(octets)}};
static const ect_entry_t e2003[] = {{0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_WO, "Write only", 0, AT(write_only)}};
static const ect_entry_t e2004[] = {
    {0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW_PREOP | ECT_ACCESS_SETTING, "PREOP only", 7, AT(preop_only)}};
static const ect_entry_t e2005[] = {{0, ECT_TYPE_INTEGER16, 16, RW, "Limited", 5, AT(limited)}};
static const ect_entry_t e2006[] = {
    ECT_ENTRY_COUNT(6),
    {1, ECT_TYPE_BOOLEAN, 1, RW, "Bool", 0, AT(record_bool)},
    {2, ECT_TYPE_BIT1 + 2, 3, RW, "Three bits", 0, AT(record_bit3)},
    {3, ECT_TYPE_BIT1 + 4, 5, RW, "Five bits", 0, AT(record_bit5)},
    {4, ECT_TYPE_UNSIGNED16, 16, RW, "U16", 0, AT(record_u16)},
    {5, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Read only", 0, AT(record_ro)},
    {6, ECT_TYPE_UNSIGNED32, 32, RW, "U32", 0, AT(record_u32)},
};
static const ect_entry_t e2007[] = {
    ECT_ENTRY_COUNT(4),
    {1, ECT_TYPE_UNSIGNED16, 16, RW, "Element", 0, AT(array[0])},
    {2, ECT_TYPE_UNSIGNED16, 16, RW, "Element", 0, AT(array[1])},
    {3, ECT_TYPE_UNSIGNED16, 16, RW, "Element", 0, AT(array[2])},
    {4, ECT_TYPE_UNSIGNED16, 16, RW, "Element", 0, AT(array[3])},
};
static const ect_entry_t e2008[] = {
    ECT_ENTRY_COUNT(5),
    {1, ECT_TYPE_UNSIGNED8, 8, RW, "One", 0, AT(sparse[0])},
    {3, ECT_TYPE_UNSIGNED8, 8, RW, "Three", 0, AT(sparse[1])},
    {5, ECT_TYPE_UNSIGNED8, 8, RW, "Five", 0, AT(sparse[2])},
};
static const ect_entry_t e2009[] = {{0, ECT_TYPE_UNSIGNED64, 64, RW, "U64", 0, AT(u64)}};
static const ect_entry_t e6000[] = {
    ECT_ENTRY_COUNT(2),
    {1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Input word", 0, AT(in_u16)},
    {2, ECT_TYPE_BIT1 + 2, 3, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Input bits", 0, AT(in_bits)},
};
static const ect_entry_t e7000[] = {
    ECT_ENTRY_COUNT(2),
    {1, ECT_TYPE_BOOLEAN, 1, RW | ECT_ACCESS_RXPDO, "Output bit", 0, AT(out_bool)},
    {2, ECT_TYPE_UNSIGNED16, 16, RW | ECT_ACCESS_RXPDO, "Output word", 0, AT(out_u16)},
};

static const ect_object_t objects[] = {
    ECT_VAR(0x1000, "Device type", e1000),
    ECT_VAR(0x1001, "Error register", e1001),
    ECT_VAR(0x1008, "Device name", e1008),
    ECT_OBJECT_IDENTITY,
    ECT_RECORD(0x1600, "Outputs", e1600),
    ECT_RECORD(0x1A00, "Inputs", e1a00),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", e1c12),
    ECT_ARRAY(0x1C13, "SM3 assignment", e1c13),
    ECT_VAR(0x2000, "U32", e2000),
    ECT_VAR(0x2001, "Text", e2001),
    ECT_VAR(0x2002, "Octets", e2002),
    ECT_VAR(0x2003, "Write only", e2003),
    ECT_VAR(0x2004, "PREOP only", e2004),
    ECT_VAR(0x2005, "Limited", e2005),
    ECT_RECORD(0x2006, "Record with bits", e2006),
    ECT_ARRAY(0x2007, "Array", e2007),
    ECT_SPARSE(0x2008, RECORD, 5, "Sparse record", e2008),
    ECT_VAR(0x2009, "U64", e2009),
    ECT_RECORD(0x6000, "Inputs", e6000),
    ECT_RECORD(0x7000, "Outputs", e7000),
};

static const ect_detail_t details[] = {{.index = 0x2005, .subindex = 0, .unit = 0x2D, .minimum = -100, .maximum = 200}};

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    testdev_t *t = instance;
    (void)now_ns;
    t->host = host;
    t->inits++;
}

static uint16_t state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    testdev_t *t = instance;
    (void)now_ns;
    t->from = from;
    t->to = to;
    return to > from ? t->state_change_answer : 0;
}

static void outputs(void *instance, uint64_t now_ns)
{
    (void)now_ns;
    ((testdev_t *)instance)->outputs_calls++;
}

static void safe_outputs(void *instance, uint64_t now_ns)
{
    testdev_t *t = instance;
    (void)now_ns;
    t->out_bool = 0;
    t->out_u16 = 0;
    t->safe_calls++;
}

static void inputs(void *instance, uint64_t now_ns)
{
    (void)now_ns;
    ((testdev_t *)instance)->inputs_calls++;
}

static uint64_t tick(void *instance, uint64_t now_ns)
{
    testdev_t *t = instance;
    t->ticks++;
    return t->tick_period_ns != 0 ? now_ns + t->tick_period_ns : ECT_NEVER;
}

static ect_reason_t sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    (void)index;
    (void)subindex;
    (void)data;
    (void)size;
    return ((testdev_t *)instance)->write_answer;
}

static void sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    testdev_t *t = instance;
    (void)now_ns;
    t->written++;
    t->written_index = index;
    t->written_subindex = subindex;
}

static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &ect_protocol_sdo_info,
                                                  NULL};

const ect_device_t testdev = {
    .name = "testdev",
    .summary = "A device for tests",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "ectwin test device",
    .group_type = "TEST",
    .group_name = "Test devices",
    .hardware_version = "1",
    .software_version = "1",
    .identity = {.vendor_id = 0xE57, .product_code = 0x7E57, .revision = 0x00010002, .serial = 42},
    .esc = "et1100",
    .esc_config = {0x08, 0x00},
    .sii_size = 2048,
    .sm = {{.start = 0x1000, .length = 128, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = 128, .minimum = 34, .maximum = 256, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1200, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1300, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
    .fmmu_count = 3,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_PDO_UPLOAD | ECT_COE_COMPLETE_ACCESS,
    .physics = "YY",
    .timeouts = {.preop_ms = 3000, .safeop_op_ms = 5000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .details = details,
    .detail_count = sizeof details / sizeof details[0],
    .instance_size = sizeof(testdev_t),
    .init = init,
    .state_change = state_change,
    .outputs = outputs,
    .safe_outputs = safe_outputs,
    .inputs = inputs,
    .tick = tick,
    .sdo_write = sdo_write,
    .sdo_written = sdo_written,
};

ect_device_t testdev_with(const ect_protocol_t *protocol, const ect_protocol_t *list[TESTDEV_PROTOCOLS],
                          uint8_t mailbox, size_t instance_size)
{
    ect_device_t device = testdev;
    size_t count = 0;
    for (; testdev.protocols[count]; count++)
        list[count] = testdev.protocols[count];
    assert(count + 1 < TESTDEV_PROTOCOLS);
    list[count] = protocol;
    list[count + 1] = NULL;
    device.protocols = list;
    device.mailbox_protocols |= mailbox;
    device.instance_size = instance_size;
    return device;
}
