/* SPDX-License-Identifier: MIT */
/* A complete slave, which returns 16 bits of outputs as inputs, inverted. */
#include "ectwin.h"
#include "seams/standard.h"

typedef struct mirror {
    ect_standard_t standard;
    uint16_t out, in;
} mirror_t;

static const ect_entry_t rxpdo[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_MAP(1, ECT_MAP(0x7000, 1, 16))};
static const ect_entry_t txpdo[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_MAP(1, ECT_MAP(0x6000, 1, 16))};
static const ect_entry_t sm2[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t sm3[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};
static const ect_entry_t inputs[] = {
    ECT_ENTRY_COUNT(1), ECT_ENTRY(1, UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "In", 0, mirror_t, in)};
static const ect_entry_t outputs[] = {
    ECT_ENTRY_COUNT(1), ECT_ENTRY(1, UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, "Out", 0, mirror_t, out)};

static const ect_object_t objects[] = {ECT_OBJECT_DEVICE_TYPE,
                                       ECT_OBJECT_DEVICE_NAME,
                                       ECT_OBJECT_HARDWARE_VERSION,
                                       ECT_OBJECT_SOFTWARE_VERSION,
                                       ECT_OBJECT_IDENTITY,
                                       ECT_RECORD(0x1600, "RxPDO", rxpdo),
                                       ECT_RECORD(0x1A00, "TxPDO", txpdo),
                                       ECT_OBJECT_SM_TYPES(4),
                                       ECT_ARRAY(0x1C12, "SM2", sm2),
                                       ECT_ARRAY(0x1C13, "SM3", sm3),
                                       ECT_RECORD(0x6000, "Inputs", inputs),
                                       ECT_RECORD(0x7000, "Outputs", outputs)};

static void reflect(void *instance, uint64_t now_ns)
{
    mirror_t *m = instance;
    (void)now_ns;
    m->in = (uint16_t)~m->out;
}

static const ect_protocol_t *const protocols[] = {&ect_protocol_sdo, &ect_protocol_sdo_info, NULL};
static const ect_device_t mirror = {
    .name = "mirror",
    .summary = "16 bits, returned inverted",
    .vendor_name = "Example",
    .type_name = "MIRROR",
    .group_type = "EXAMPLES",
    .group_name = "Examples",
    .hardware_version = "1",
    .software_version = "1",
    .identity = {.vendor_id = 0x00000E57, .product_code = 0x1234, .revision = 1, .serial = 1},
    .esc = "lan9252",
    .sii_size = 2048,
    .physics = "YY",
    .sm = {{.start = 0x1000, .length = 128, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = 128, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1100, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1180, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
    .fmmu_count = 3,
    .general_flags = ECT_GENERAL_GIVEN | ECT_GENERAL_MAIL_REPEAT, /* no address switches, no identification */
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_COMPLETE_ACCESS,
    .timeouts = {.preop_ms = 2000, .safeop_op_ms = 2000},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .instance_size = sizeof(mirror_t),
    .outputs = reflect,
};

int main(int argc, char **argv)
{
    static const ect_product_t products[] = {{&mirror, NULL}};
    return ectwin_main(argc, argv, products, 1);
}
