/* SPDX-License-Identifier: MIT */
#include "support/terminal.h"

#include <string.h>

#define BIT(sub, access, name, member)                                                                                 \
    {sub, ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RO | (access), name, 0, ECT_OFFSET(terminal_t, member)}
#define OUT(n)        BIT(n, ECT_ACCESS_RXPDO, "Output " #n, out[n - 1])
#define IN(n)         BIT(n, ECT_ACCESS_TXPDO, "Input " #n, in[n - 1])
#define MAP(n, index) ECT_ENTRY_MAP(n, ECT_MAP(index, n, 1))
#define EIGHT(F)      F(1), F(2), F(3), F(4), F(5), F(6), F(7), F(8)
#define MAP_EIGHT(index)                                                                                               \
    MAP(1, index), MAP(2, index), MAP(3, index), MAP(4, index), MAP(5, index), MAP(6, index), MAP(7, index),           \
        MAP(8, index)

static const ect_entry_t outputs_7000[] = {ECT_ENTRY_COUNT(8), EIGHT(OUT)};
static const ect_entry_t inputs_6000[] = {ECT_ENTRY_COUNT(8), EIGHT(IN)};
static const ect_entry_t count_6010[] = {
    {0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Count", 0, ECT_OFFSET(terminal_t, count)}};
static const ect_entry_t map_1600[] = {ECT_ENTRY_COUNT(8), MAP_EIGHT(0x7000)};
static const ect_entry_t map_1a00[] = {ECT_ENTRY_COUNT(8), MAP_EIGHT(0x6000)};
static const ect_entry_t map_1a01[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_MAP(1, ECT_MAP(0x6010, 0, 16))};
static const ect_entry_t assign_sm0[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t assign_sm1[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};
static const ect_entry_t assign_sm2[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A01)};

static const ect_object_t objects[] = {
    ECT_RECORD(0x1600, "Outputs", map_1600),         ECT_RECORD(0x1A00, "Inputs", map_1a00),
    ECT_RECORD(0x1A01, "Counter", map_1a01),         ECT_ARRAY(0x1C10, "SM0 assignment", assign_sm0),
    ECT_ARRAY(0x1C11, "SM1 assignment", assign_sm1), ECT_ARRAY(0x1C12, "SM2 assignment", assign_sm2),
    ECT_ARRAY(0x6000, "Inputs", inputs_6000),        ECT_VAR(0x6010, "Counter", count_6010),
    ECT_ARRAY(0x7000, "Outputs", outputs_7000),
};

static void outputs(void *instance, uint64_t now_ns)
{
    terminal_t *t = instance;
    (void)now_ns;
    memcpy(t->in, t->out, sizeof t->in);
    t->count++;
    t->safe = false;
}

static void safe_outputs(void *instance, uint64_t now_ns)
{
    terminal_t *t = instance;
    (void)now_ns;
    memset(t->out, 0, sizeof t->out);
    t->safe = true;
}

const ect_device_t terminal = {
    .name = "terminal",
    .summary = "A digital terminal without a mailbox",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "TERM-8",
    .full_name = "8 digital outputs and inputs",
    .group_type = "TEST",
    .group_name = "Test devices",
    .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = 0x7E58, .revision = 1, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x04, 0x00},
    .sii_size = 1024,
    .sm = {{.start = 0x1000, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1100, .control = 0x20, .type = ECT_SM_INPUTS},
           {.start = 0x1200, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 3,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_INPUTS},
    .fmmu_count = 3,
    .physics = "KK",
    .ebus_ma = 110,
    .timeouts = {.preop_ms = 2000, .safeop_op_ms = 2000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .instance_size = sizeof(terminal_t),
    .outputs = outputs,
    .safe_outputs = safe_outputs,
};
