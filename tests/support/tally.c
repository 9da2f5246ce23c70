/* SPDX-License-Identifier: MIT */
#include "support/tally.h"

#define WORD(n, access, name, member)                                                                                  \
    ECT_ENTRY(n, UNSIGNED32, 32, ECT_ACCESS_RO | (access), name " " #n, 0, tally_t, member[(n) - 1])
#define OUT(n)     WORD(n, ECT_ACCESS_RXPDO, "Output", out)
#define IN(n)      WORD(n, ECT_ACCESS_TXPDO, "Input", in)
#define MAP_OUT(n) ECT_ENTRY_MAP(n, ECT_MAP(0x7000, n, 32))
#define MAP_IN(n)  ECT_ENTRY_MAP(n, ECT_MAP(0x6000, n, 32))
#define ALL(F)                                                                                                         \
    F(1), F(2), F(3), F(4), F(5), F(6), F(7), F(8), F(9), F(10), F(11), F(12), F(13), F(14), F(15), F(16), F(17),      \
        F(18), F(19), F(20), F(21), F(22), F(23), F(24), F(25), F(26), F(27), F(28), F(29), F(30), F(31), F(32)

static const ect_entry_t outputs_7000[] = {ECT_ENTRY_COUNT(TALLY_WORDS), ALL(OUT)};
static const ect_entry_t inputs_6000[] = {ECT_ENTRY_COUNT(TALLY_WORDS), ALL(IN)};
static const ect_entry_t map_1600[] = {ECT_ENTRY_COUNT(TALLY_WORDS), ALL(MAP_OUT)};
static const ect_entry_t map_1a00[] = {ECT_ENTRY_COUNT(TALLY_WORDS), ALL(MAP_IN)};
static const ect_entry_t assign_outputs[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t assign_inputs[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};

static const ect_object_t objects[] = {
    ECT_RECORD(0x1600, "Outputs", map_1600),
    ECT_RECORD(0x1A00, "Inputs", map_1a00),
    ECT_ARRAY(0x1C10, "SM0 assignment", assign_outputs),
    ECT_ARRAY(0x1C11, "SM1 assignment", assign_inputs),
    ECT_ARRAY(0x6000, "Inputs", inputs_6000),
    ECT_ARRAY(0x7000, "Outputs", outputs_7000),
};

static void show(tally_t *t, uint32_t value)
{
    for (unsigned int i = 0; i < TALLY_WORDS; i++)
        t->in[i] = value;
}

/* The inputs are still those of the outputs before. */
static void outputs(void *instance, uint64_t now_ns)
{
    tally_t *t = instance;
    bool whole = true;
    (void)now_ns;
    for (unsigned int i = 1; i < TALLY_WORDS; i++)
        whole = whole && t->out[i] == t->out[0];
    bool next = t->out[0] == 0 || t->out[0] == t->in[0] + 1;
    if (t->in[0] != TALLY_BROKEN)
        show(t, whole && next ? t->out[0] : TALLY_BROKEN);
}

static void safe_outputs(void *instance, uint64_t now_ns)
{
    tally_t *t = instance;
    (void)now_ns;
    if (t->in[0] != TALLY_BROKEN)
        show(t, 0);
}

const ect_device_t tally = {
    .name = "tally",
    .summary = "Images whose words are all equal",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "TALLY",
    .group_type = "TEST",
    .group_name = "Test devices",
    .identity = {.vendor_id = ECTWIN_VENDOR_ID, .product_code = 0x7E5F, .revision = 1, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x04, 0x00},
    .sii_size = 2048,
    .sm = {{.start = 0x1000, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1200, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 2,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS},
    .fmmu_count = 2,
    .physics = "KK",
    .timeouts = {.preop_ms = 2000, .safeop_op_ms = 2000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .instance_size = sizeof(tally_t),
    .outputs = outputs,
    .safe_outputs = safe_outputs,
};
