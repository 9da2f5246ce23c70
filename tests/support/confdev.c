/* SPDX-License-Identifier: MIT */
#include "support/confdev.h"

#define AT(member)                 ECT_OFFSET(confdev_t, member)
#define CONFIG                     ECT_ACCESS_RW_PREOP
#define BACKED_UP                  (ECT_ACCESS_RW | ECT_ACCESS_BACKUP)
#define COUNT(value, member)       {0, ECT_TYPE_UNSIGNED8, 8, CONFIG, "Number of entries", value, AT(member)}
#define MAP(sub, value, member)    {sub, ECT_TYPE_UNSIGNED32, 32, CONFIG, "Mapped object", value, AT(member)}
#define ASSIGN(sub, value, member) {sub, ECT_TYPE_UNSIGNED16, 16, CONFIG, "Assigned PDO", value, AT(member)}
#define MAPPING(n, count, v1, v2)                                                                                      \
    {                                                                                                                  \
        COUNT(count, count_##n), MAP(1, v1, map_##n[0]), MAP(2, v2, map_##n[1]),                                       \
        MAP(3, 0, map_##n[2]),   MAP(4, 0, map_##n[3]),                                                                \
    }

static const ect_entry_t e1000[] = {ECT_ENTRY_CONST(ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Device type", 0)};
static const ect_entry_t e1001[] = {
    {0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Error register", 0, ECT_STANDARD(error_register)}};
static const ect_entry_t e1010[] = ECT_ENTRIES_STORE("Save all");
static const ect_entry_t e1011[] = ECT_ENTRIES_STORE("Restore all");
static const ect_entry_t e10f1[] = ECT_ENTRIES_ERROR_SETTINGS(confdev_t, sync);
static const ect_entry_t e10f3[] = ECT_ENTRIES_DIAGNOSIS(confdev_t, diagnosis);
static const ect_entry_t e1600[] = MAPPING(1600, 1, ECT_MAP(0x7000, 1, 8), 0);
static const ect_entry_t e1601[] = MAPPING(1601, 0, 0, 0);
static const ect_entry_t e1a00[] = MAPPING(1a00, 2, ECT_MAP(0x6000, 1, 8), ECT_MAP(0x6000, 2, 16));
static const ect_entry_t e1a01[] = MAPPING(1a01, 0, 0, 0);
static const ect_entry_t e1c12[] = {COUNT(1, count_1c12), ASSIGN(1, 0x1600, assign_1c12[0]),
                                    ASSIGN(2, 0, assign_1c12[1])};
static const ect_entry_t e1c13[] = {COUNT(1, count_1c13), ASSIGN(1, 0x1A00, assign_1c13[0]),
                                    ASSIGN(2, 0, assign_1c13[1])};
static const ect_entry_t e1c32[] = ECT_ENTRIES_SYNC(confdev_t, sync);
static const ect_entry_t e2100[] = {{0, ECT_TYPE_UNSIGNED32, 32, BACKED_UP, "Stored", 100, AT(stored)}};
static const ect_entry_t e2101[] = {{0, ECT_TYPE_OCTET_STRING, 320, BACKED_UP, "Stored octets", 0, AT(stored_octets)}};
static const ect_entry_t e6000[] = {
    ECT_ENTRY_COUNT(4),
    {1, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Byte", 0, AT(in_u8)},
    {2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Word", 0, AT(in_u16)},
    {3, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Double word", 0, AT(in_u32)},
    {4, ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Bit", 0, AT(in_bool)},
};
static const ect_entry_t e7000[] = {
    ECT_ENTRY_COUNT(4),
    {1, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, "Byte", 0, AT(out_u8)},
    {2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, "Word", 0, AT(out_u16)},
    {3, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, "Double word", 0, AT(out_u32)},
    {4, ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, "Bit", 0, AT(out_bool)},
};

static const ect_object_t objects[] = {
    ECT_VAR(0x1000, "Device type", e1000),
    ECT_VAR(0x1001, "Error register", e1001),
    ECT_ARRAY(0x1010, "Store parameters", e1010),
    ECT_ARRAY(0x1011, "Restore parameters", e1011),
    ECT_OBJECT_IDENTITY,
    ECT_RECORD(0x10F1, "Error settings", e10f1),
    ECT_RECORD(0x10F3, "Diagnosis history", e10f3),
    ECT_RECORD(0x1600, "RxPDO 1", e1600),
    ECT_RECORD(0x1601, "RxPDO 2", e1601),
    ECT_RECORD(0x1A00, "TxPDO 1", e1a00),
    ECT_RECORD(0x1A01, "TxPDO 2", e1a01),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", e1c12),
    ECT_ARRAY(0x1C13, "SM3 assignment", e1c13),
    ECT_SPARSE(0x1C32, RECORD, 32, "SM2 synchronisation", e1c32),
    ECT_SPARSE(0x1C33, RECORD, 32, "SM3 synchronisation", e1c32),
    ECT_VAR(0x2100, "Stored", e2100),
    ECT_VAR(0x2101, "Stored octets", e2101),
    ECT_RECORD(0x6000, "Inputs", e6000),
    ECT_RECORD(0x7000, "Outputs", e7000),
};

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    confdev_t *c = instance;
    (void)now_ns;
    c->host = host;
    c->in_u8 = 0x11;
    c->in_u16 = 0x2233;
    c->in_u32 = 0x44556677;
    c->in_bool = 1;
}

static const ect_service_t *const services[] = {&ect_service_pdo_config, &ect_service_diagnosis, &ect_service_store,
                                                &ect_service_sync, NULL};
static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &ect_protocol_sdo_info,
                                                  NULL};
static const uint32_t cycles[] = {1000000, 2000000};
static const ect_dc_mode_t dc_modes[] = {{.name = "DC", .description = "DC SYNC0", .assign_activate = 0x0300}};

const ect_device_t confdev = {
    .name = "confdev",
    .summary = "A device with every object service",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "ectwin services device",
    .group_type = "TEST",
    .group_name = "Test devices",
    .hardware_version = "1",
    .software_version = "1",
    .identity = {.vendor_id = 0xE57, .product_code = 0xC0F, .revision = 1, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x08, 0x00},
    .sii_size = 2048,
    .sm = {{.start = 0x1000, .length = 128, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = 128, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1200, .maximum = 16, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1300, .maximum = 16, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS},
    .fmmu_count = 2,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_PDO_ASSIGN | ECT_COE_PDO_CONFIG | ECT_COE_COMPLETE_ACCESS,
    .physics = "YY",
    .dc_modes = dc_modes,
    .dc_mode_count = 1,
    .sync = {.supported = 0x0007, .minimum_cycle_ns = 1000000, .dc_cycles_ns = cycles, .dc_cycle_count = 2},
    .timeouts = {.preop_ms = 3000, .safeop_op_ms = 5000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .instance_size = sizeof(confdev_t),
    .services = services,
    .init = init,
};
