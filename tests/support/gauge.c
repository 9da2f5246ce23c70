/* SPDX-License-Identifier: MIT */
#include "support/gauge.h"

#include <string.h>

#define VALUE(n) ECT_ENTRY(n, INTEGER32, 32, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Value " #n, 0, gauge_t, value[n - 1])
#define CHOOSE(n, initial)                                                                                             \
    ECT_ENTRY(n, BOOLEAN, 1, ECT_ACCESS_RW_PREOP, "Send value " #n, initial, gauge_t, chosen[n - 1])
#define MAPPED(n, initial) ECT_ENTRY(n, UNSIGNED32, 32, ECT_ACCESS_RO, "Mapped object", initial, gauge_t, mapped[n - 1])

static const ect_entry_t map_1a00[] = {
    ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_RO, "Number of entries", 2, gauge_t, mapped_count),
    MAPPED(1, ECT_MAP(0x6000, 1, 32)),
    MAPPED(2, ECT_MAP(0x6000, 2, 32)),
    MAPPED(3, 0),
    MAPPED(4, 0),
};
static const ect_entry_t assign_inputs[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};
static const ect_entry_t choice[] = {ECT_ENTRY_COUNT(4), CHOOSE(1, 1), CHOOSE(2, 1), CHOOSE(3, 0), CHOOSE(4, 0)};
static const ect_entry_t values[] = {ECT_ENTRY_COUNT(4), VALUE(1), VALUE(2), VALUE(3), VALUE(4)};

static const ect_object_t objects[] = {
    ECT_OBJECT_DEVICE_TYPE,
    ECT_OBJECT_ERROR_REGISTER,
    ECT_OBJECT_DEVICE_NAME,
    ECT_OBJECT_HARDWARE_VERSION,
    ECT_OBJECT_SOFTWARE_VERSION,
    ECT_OBJECT_IDENTITY,
    ECT_RECORD(0x1A00, "Values mapping", map_1a00),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C13, "SM3 assignment", assign_inputs),
    ECT_ARRAY(0x21B0, "Digital interfaces", choice),
    ECT_ARRAY(0x6000, "Values", values),
};

static void map_choice(gauge_t *g)
{
    g->mapped_count = 0;
    memset(g->mapped, 0, sizeof g->mapped);
    for (uint8_t n = 0; n < GAUGE_VALUES; n++) {
        if (g->chosen[n])
            g->mapped[g->mapped_count++] = ECT_MAP(0x6000, n + 1, 32);
    }
}

static void inputs(void *instance, uint64_t now_ns)
{
    gauge_t *g = instance;
    (void)now_ns;
    for (int32_t n = 0; n < GAUGE_VALUES; n++)
        g->value[n] += n + 1;
}

static void sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    (void)subindex;
    (void)now_ns;
    if (index == 0x21B0)
        map_choice(instance);
}

static const ect_protocol_t *const protocols[] = {&ect_protocol_sdo, &ect_protocol_sdo_info, NULL};

const ect_device_t gauge = {
    .name = "gauge",
    .summary = "A sensor without outputs",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "GAUGE",
    .group_type = "TEST",
    .group_name = "Test devices",
    .hardware_version = "1",
    .software_version = "1",
    .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = 0x7E59, .revision = 1, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x08, 0x00},
    .sii_size = 1024,
    .sm = {{.start = 0x1000, .length = 64, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = 64, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1100, .control = 0x24, .type = ECT_SM_UNUSED},
           {.start = 0x1200, .maximum = 4 * GAUGE_VALUES, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
    .fmmu_count = 2,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_PDO_UPLOAD | ECT_COE_COMPLETE_ACCESS,
    .physics = "YY",
    .timeouts = {.preop_ms = 2000, .safeop_op_ms = 2000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .instance_size = sizeof(gauge_t),
    .inputs = inputs,
    .sdo_written = sdo_written,
};
