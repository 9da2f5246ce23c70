/* SPDX-License-Identifier: MIT */
#include "support/soedev.h"

/* --- the objects that process data map ---------------------------------------------------------------------------- */

#define AT(member) ECT_OFFSET(soedev_t, member)
#define WORD(subindex, value)                                                                                          \
    {subindex, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Control word or status word", value, NULL}
#define MAP(subindex, value, member)                                                                                   \
    {subindex, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW_PREOP, "Mapped", value, AT(member)}
#define MAPPING(n, kind, word, first, second)                                                                          \
    {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW_PREOP, "Count", 3, AT(drive[n].kind##_count)},                           \
     WORD(1, word),                                                                                                    \
     MAP(2, first, drive[n].kind##_map[0]),                                                                            \
     MAP(3, second, drive[n].kind##_map[1]),                                                                           \
     MAP(4, 0, drive[n].kind##_map[2]),                                                                                \
     MAP(5, 0, drive[n].kind##_map[3]),                                                                                \
     MAP(6, 0, drive[n].kind##_map[4]),                                                                                \
     MAP(7, 0, drive[n].kind##_map[5]),                                                                                \
     MAP(8, 0, drive[n].kind##_map[6]),                                                                                \
     MAP(9, 0, drive[n].kind##_map[7]),                                                                                \
     MAP(10, 0, drive[n].kind##_map[8]),                                                                               \
     MAP(11, 0, drive[n].kind##_map[9]),                                                                               \
     MAP(12, 0, drive[n].kind##_map[10]),                                                                              \
     MAP(13, 0, drive[n].kind##_map[11])}
#define OUTPUT(subindex, kind, bits, name, n, member)                                                                  \
    ECT_ENTRY(subindex, kind, bits, ECT_ACCESS_RW | ECT_ACCESS_RXPDO, name, 0, soedev_t, drive[n].member)
#define INPUT(subindex, kind, bits, name, n, member)                                                                   \
    ECT_ENTRY(subindex, kind, bits, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, name, 0, soedev_t, drive[n].member)
#define OUTPUTS(n)                                                                                                     \
    {ECT_ENTRY_COUNT(4), OUTPUT(1, UNSIGNED16, 16, "Control word", n, control),                                        \
     OUTPUT(2, INTEGER32, 32, "Velocity command", n, velocity_set),                                                    \
     OUTPUT(3, INTEGER32, 32, "Position command", n, position_set), OUTPUT(4, UNSIGNED16, 16, "Limit", n, limit)}
#define INPUTS(n)                                                                                                      \
    {ECT_ENTRY_COUNT(4), INPUT(1, UNSIGNED16, 16, "Status word", n, status),                                           \
     INPUT(2, INTEGER32, 32, "Velocity feedback", n, velocity),                                                        \
     INPUT(3, INTEGER32, 32, "Position feedback", n, position), INPUT(4, INTEGER16, 16, "Torque", n, torque)}

static const ect_entry_t e1600[] =
    MAPPING(0, mdt, ECT_MAP(0x7000, 1, 16), ECT_MAP(0x7000, 2, 32), ECT_MAP(0x7000, 3, 32));
static const ect_entry_t e1601[] =
    MAPPING(1, mdt, ECT_MAP(0x7010, 1, 16), ECT_MAP(0x7010, 2, 32), ECT_MAP(0x7010, 3, 32));
static const ect_entry_t e1a00[] =
    MAPPING(0, at, ECT_MAP(0x6000, 1, 16), ECT_MAP(0x6000, 2, 32), ECT_MAP(0x6000, 3, 32));
static const ect_entry_t e1a01[] =
    MAPPING(1, at, ECT_MAP(0x6010, 1, 16), ECT_MAP(0x6010, 2, 32), ECT_MAP(0x6010, 3, 32));
static const ect_entry_t e1c12[] = {ECT_ENTRY_COUNT(2), ECT_ENTRY_ASSIGN(1, 0x1600), ECT_ENTRY_ASSIGN(2, 0x1601)};
static const ect_entry_t e1c13[] = {ECT_ENTRY_COUNT(2), ECT_ENTRY_ASSIGN(1, 0x1A00), ECT_ENTRY_ASSIGN(2, 0x1A01)};
static const ect_entry_t e6000[] = INPUTS(0), e6010[] = INPUTS(1), e7000[] = OUTPUTS(0), e7010[] = OUTPUTS(1);

static const ect_object_t objects[] = {
    ECT_RECORD(0x1600, "MDT 0", e1600), ECT_RECORD(0x1601, "MDT 1", e1601),   ECT_RECORD(0x1A00, "AT 0", e1a00),
    ECT_RECORD(0x1A01, "AT 1", e1a01),  ECT_ARRAY(0x1C12, "SM2 PDOs", e1c12), ECT_ARRAY(0x1C13, "SM3 PDOs", e1c13),
    ECT_RECORD(0x6000, "AT 0", e6000),  ECT_RECORD(0x6010, "AT 1", e6010),    ECT_RECORD(0x7000, "MDT 0", e7000),
    ECT_RECORD(0x7010, "MDT 1", e7010),
};

/* --- the IDNs ----------------------------------------------------------------------------------------------------- */

#define LOCKED     (ECT_SOE_LOCK_SAFEOP | ECT_SOE_LOCK_OP)
#define LIMITED    (ECT_SOE_MINIMUM | ECT_SOE_MAXIMUM | ECT_SOE_DEFAULT)
#define IDNS       (1u | ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_IDNS)
#define NUMBER(n)  (1u | ECT_SOE_##n | ECT_SOE_UNSIGNED)
#define SIGNED(n)  (1u | ECT_SOE_##n | ECT_SOE_SIGNED)
#define COMMAND    (1u | ECT_SOE_16 | ECT_SOE_COMMAND)
#define OF(member) offsetof(soedev_t, member)

/* A reply that takes three mails. */
static const char long_text[SOEDEV_TEXT] = "A text that does not fit one mail";

static const uint8_t at_default[] = {40, 0, 51, 0}, mdt_default[] = {36, 0, 47, 0};

#define DRIVE(n)                                                                                                       \
    {                                                                                                                  \
        {.idn = ECT_SOE_S(1),                                                                                          \
         .flags = LIMITED | ECT_SOE_CHECK_SAFEOP,                                                                      \
         .attribute = NUMBER(16) | LOCKED,                                                                             \
         .name = "NC cycle time",                                                                                      \
         .unit = "us",                                                                                                 \
         .minimum = 250,                                                                                               \
         .maximum = 8000,                                                                                              \
         .initial = 2000,                                                                                              \
         .offset = OF(drive[n].cycle_us)},                                                                             \
        {.idn = ECT_SOE_S(11),                                                                                         \
         .attribute = 1u | ECT_SOE_16 | ECT_SOE_BINARY | ECT_SOE_READ_ONLY,                                            \
         .name = "Class 1 diagnostic",                                                                                 \
         .initial = 0x8001},                                                                                           \
        {.idn = ECT_SOE_S(15),                                                                                         \
         .attribute = 1u | ECT_SOE_16 | LOCKED,                                                                        \
         .name = "Telegram type",                                                                                      \
         .initial = 7,                                                                                                 \
         .offset = OF(drive[n].telegram)},                                                                             \
        {.idn = ECT_SOE_S(16),                                                                                         \
         .attribute = IDNS | LOCKED,                                                                                   \
         .name = "AT list",                                                                                            \
         .content = at_default,                                                                                        \
         .used = 4,                                                                                                    \
         .size = SOEDEV_CHOICE,                                                                                        \
         .offset = OF(drive[n].at)},                                                                                   \
        {.idn = ECT_SOE_S(17), .attribute = IDNS | ECT_SOE_READ_ONLY, .name = "All IDNs"},                             \
        {.idn = ECT_SOE_S(21),                                                                                         \
         .attribute = IDNS | ECT_SOE_READ_ONLY,                                                                        \
         .name = "Invalid for SAFEOP",                                                                                 \
         .size = 6,                                                                                                    \
         .offset = OF(drive[n].not_safeop)},                                                                           \
        {.idn = ECT_SOE_S(22),                                                                                         \
         .attribute = IDNS | ECT_SOE_READ_ONLY,                                                                        \
         .name = "Invalid for OP",                                                                                     \
         .size = 4,                                                                                                    \
         .offset = OF(drive[n].not_op)},                                                                               \
        {.idn = ECT_SOE_S(24),                                                                                         \
         .attribute = IDNS | LOCKED,                                                                                   \
         .name = "MDT list",                                                                                           \
         .content = mdt_default,                                                                                       \
         .used = 4,                                                                                                    \
         .size = SOEDEV_CHOICE,                                                                                        \
         .offset = OF(drive[n].mdt)},                                                                                  \
        {.idn = ECT_SOE_S(32),                                                                                         \
         .flags = ECT_SOE_CHECK_OP | ECT_SOE_MAXIMUM,                                                                  \
         .attribute = NUMBER(16),                                                                                      \
         .name = "Primary mode",                                                                                       \
         .maximum = 11,                                                                                                \
         .initial = 11,                                                                                                \
         .offset = OF(drive[n].mode)},                                                                                 \
        {.idn = ECT_SOE_S(36),                                                                                         \
         .flags = ECT_SOE_IN_MDT,                                                                                      \
         .attribute = SIGNED(32) | LOCKED,                                                                             \
         .name = "Velocity set",                                                                                       \
         .unit = "mm/min",                                                                                             \
         .initial = 65536,                                                                                             \
         .mapping = ECT_MAP(0x7000 + 0x10 * (n), 2, 32),                                                               \
         .offset = OF(drive[n].velocity_set)},                                                                         \
        {.idn = ECT_SOE_S(40),                                                                                         \
         .flags = ECT_SOE_IN_AT,                                                                                       \
         .attribute = SIGNED(32) | ECT_SOE_READ_ONLY,                                                                  \
         .name = "Velocity",                                                                                           \
         .mapping = ECT_MAP(0x6000 + 0x10 * (n), 2, 32),                                                               \
         .offset = OF(drive[n].velocity)},                                                                             \
        {.idn = ECT_SOE_S(47),                                                                                         \
         .flags = ECT_SOE_IN_MDT,                                                                                      \
         .attribute = SIGNED(32),                                                                                      \
         .name = "Position set",                                                                                       \
         .mapping = ECT_MAP(0x7000 + 0x10 * (n), 3, 32),                                                               \
         .offset = OF(drive[n].position_set)},                                                                         \
        {.idn = ECT_SOE_S(51),                                                                                         \
         .flags = ECT_SOE_IN_AT,                                                                                       \
         .attribute = SIGNED(32) | ECT_SOE_READ_ONLY,                                                                  \
         .name = "Position",                                                                                           \
         .mapping = ECT_MAP(0x6000 + 0x10 * (n), 3, 32),                                                               \
         .offset = OF(drive[n].position)},                                                                             \
        {.idn = ECT_SOE_S(84),                                                                                         \
         .flags = ECT_SOE_IN_AT,                                                                                       \
         .attribute = SIGNED(16) | ECT_SOE_READ_ONLY,                                                                  \
         .name = "Torque",                                                                                             \
         .mapping = ECT_MAP(0x6000 + 0x10 * (n), 4, 16),                                                               \
         .offset = OF(drive[n].torque)},                                                                               \
        {.idn = ECT_SOE_S(99), .attribute = COMMAND, .name = "Reset", .offset = OF(drive[n].reset)},                   \
        {.idn = ECT_SOE_S(127),                                                                                        \
         .attribute = COMMAND,                                                                                         \
         .name = "Check for SAFEOP",                                                                                   \
         .offset = OF(drive[n].check_safeop)},                                                                         \
        {.idn = ECT_SOE_S(128), .attribute = COMMAND, .name = "Check for OP", .offset = OF(drive[n].check_op)},        \
        {.idn = ECT_SOE_S(134), .attribute = 1u | ECT_SOE_16, .name = "Control word", .offset = OF(drive[n].control)}, \
        {.idn = ECT_SOE_S(135),                                                                                        \
         .attribute = 1u | ECT_SOE_16 | ECT_SOE_READ_ONLY,                                                             \
         .name = "Status word",                                                                                        \
         .offset = OF(drive[n].status)},                                                                               \
        {.idn = ECT_SOE_S(148), .attribute = COMMAND, .name = "Homing", .offset = OF(drive[n].slow)},                  \
        {.idn = ECT_SOE_S(187), .attribute = IDNS | ECT_SOE_READ_ONLY, .name = "Choice for the AT"},                   \
        {.idn = ECT_SOE_S(188), .attribute = IDNS | ECT_SOE_READ_ONLY, .name = "Choice for the MDT"},                  \
        {.idn = ECT_SOE_P(1),                                                                                          \
         .flags = LIMITED | ECT_SOE_IN_MDT,                                                                            \
         .attribute = NUMBER(16),                                                                                      \
         .minimum = 10,                                                                                                \
         .maximum = 60000,                                                                                             \
         .initial = 100,                                                                                               \
         .mapping = ECT_MAP(0x7000 + 0x10 * (n), 4, 16),                                                               \
         .offset = OF(drive[n].limit)},                                                                                \
        {.idn = ECT_SOE_P(2),                                                                                          \
         .flags = LIMITED,                                                                                             \
         .attribute = SIGNED(8),                                                                                       \
         .name = "Signed",                                                                                             \
         .unit = "",                                                                                                   \
         .minimum = -10,                                                                                               \
         .maximum = 10,                                                                                                \
         .initial = 0xFD,                                                                                              \
         .offset = OF(drive[n].signed8)},                                                                              \
        {.idn = ECT_SOE_P(3),                                                                                          \
         .flags = LIMITED,                                                                                             \
         .attribute = NUMBER(64),                                                                                      \
         .name = "Long",                                                                                               \
         .minimum = 1,                                                                                                 \
         .maximum = INT64_MIN,                                                                                         \
         .initial = 1ull << 40,                                                                                        \
         .offset = OF(drive[n].number64)},                                                                             \
        {.idn = ECT_SOE_P(4),                                                                                          \
         .flags = LIMITED,                                                                                             \
         .attribute = 1u | ECT_SOE_32 | ECT_SOE_FLOAT,                                                                 \
         .name = "Gain",                                                                                               \
         .minimum = 0xBFC00000,                                                                                        \
         .maximum = 0x40200000,                                                                                        \
         .initial = 0x3F800000,                                                                                        \
         .offset = OF(drive[n].gain)},                                                                                 \
        {.idn = ECT_SOE_P(5),                                                                                          \
         .attribute = 1u | ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_TEXT,                                                    \
         .name = "Text",                                                                                               \
         .content = "text",                                                                                            \
         .used = 4,                                                                                                    \
         .size = 20,                                                                                                   \
         .offset = OF(drive[n].text)},                                                                                 \
        {.idn = ECT_SOE_P(6),                                                                                          \
         .attribute = NUMBER(16) | ECT_SOE_LOCK_OP,                                                                    \
         .name = "Not in OP",                                                                                          \
         .offset = OF(drive[n].locked)},                                                                               \
        {.idn = ECT_SOE_P(7),                                                                                          \
         .attribute = 1u | ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_UNSIGNED,                                               \
         .name = "Wide",                                                                                               \
         .size = 16,                                                                                                   \
         .offset = OF(drive[n].wide)},                                                                                 \
        {.idn = ECT_SOE_P(8),                                                                                          \
         .attribute = 1u | ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_TEXT,                                                    \
         .name = "Version",                                                                                            \
         .content = "1.0",                                                                                             \
         .used = 3},                                                                                                   \
        {.idn = ECT_SOE_P(9),                                                                                          \
         .attribute = NUMBER(16) | ECT_SOE_LOCK_PREOP,                                                                 \
         .name = "Not in PREOP",                                                                                       \
         .offset = OF(drive[n].locked)},                                                                               \
        {.idn = ECT_SOE_P(10),                                                                                         \
         .attribute = 1u | ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_TEXT | ECT_SOE_READ_ONLY,                                \
         .name = "Long text",                                                                                          \
         .content = long_text,                                                                                         \
         .used = SOEDEV_TEXT},                                                                                         \
    }

static const ect_soe_idn_t idns_0[] = DRIVE(0), idns_1[] = DRIVE(1);

/* S-0-0016 of a drive without process data lists any IDN with ECT_SOE_IN_AT, as often as it likes. */
static const ect_soe_idn_t idns_2[] = {
    {.idn = ECT_SOE_S(16), .attribute = IDNS, .name = "AT list", .size = SOEDEV_LONG, .offset = OF(long_list)},
    {.idn = ECT_SOE_S(21), .attribute = IDNS | ECT_SOE_READ_ONLY, .name = "Invalid for SAFEOP"},
    {.idn = ECT_SOE_S(32),
     .flags = ECT_SOE_CHECK_SAFEOP | ECT_SOE_MAXIMUM,
     .attribute = NUMBER(16) | LOCKED,
     .name = "Primary mode",
     .maximum = 11,
     .offset = OF(mode)},
    {.idn = ECT_SOE_S(51), .flags = ECT_SOE_IN_AT, .attribute = SIGNED(32), .name = "Position"},
    {.idn = ECT_SOE_S(99), .attribute = COMMAND, .offset = OF(plain)},
};

#define COUNT(table) (sizeof(table) / sizeof(table)[0])

static const ect_soe_drive_t drives[] = {
    {.idns = idns_0, .count = COUNT(idns_0), .mdt = 0x1600, .at = 0x1A00, .command_change = true},
    {.idns = idns_1, .count = COUNT(idns_1), .mdt = 0x1601, .at = 0x1A01},
    {.idns = idns_2, .count = COUNT(idns_2)},
};

/* --- the device --------------------------------------------------------------------------------------------------- */

static void note(soedev_t *d, uint8_t drive, const ect_soe_idn_t *idn, unsigned int *calls)
{
    ++*calls;
    d->last_idn = idn->idn;
    d->last_drive = drive;
}

static uint16_t read_value(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn)
{
    soedev_t *d = instance;
    (void)soe;
    note(d, drive, idn, &d->reads);
    return d->read_code;
}

static uint16_t check_value(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn,
                            const uint8_t *data, uint16_t size)
{
    const soedev_t *d = instance;
    (void)soe;
    (void)drive;
    (void)idn;
    (void)data;
    (void)size;
    return d->write_code;
}

static void value_written(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn,
                          uint64_t now_ns)
{
    soedev_t *d = instance;
    (void)soe;
    note(d, drive, idn, &d->written);
    d->last_ns = now_ns;
}

static uint16_t execute(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn, bool start,
                        uint64_t now_ns)
{
    soedev_t *d = instance;
    note(d, drive, idn, start ? &d->commands : &d->cancels);
    d->last_ns = now_ns;
    if (start && d->command_code == ECT_SOE_OK && d->ends_at_once)
        ect_soe_finish(soe, instance, drive, idn->idn, true);
    return d->command_code;
}

static bool is_valid(const ect_soe_t *soe, void *instance, uint8_t drive, const ect_soe_idn_t *idn, uint8_t target)
{
    const soedev_t *d = instance;
    (void)soe;
    (void)idn;
    (void)target;
    return !(d->refuses_state && drive == 1);
}

const ect_soe_t soedev_soe = {.protocol = ECT_SOE_PROTOCOL,
                              .offset = OF(soe),
                              .buffer = OF(buffer),
                              .buffer_size = SOEDEV_BUFFER,
                              .drive_count = SOEDEV_DRIVES,
                              .drives = drives,
                              .notifies = false,
                              .read = read_value,
                              .write = check_value,
                              .written = value_written,
                              .command = execute,
                              .valid = is_valid};
const ect_soe_t soedev_quiet = {.protocol = ECT_SOE_PROTOCOL,
                                .offset = OF(soe),
                                .buffer = OF(buffer),
                                .buffer_size = SOEDEV_BUFFER,
                                .drive_count = 1,
                                .drives = &drives[2],
                                .notifies = true};

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    (void)host;
    (void)now_ns;
    ect_soe_set_defaults(&soedev_soe, instance);
}

static void inputs(void *instance, uint64_t now_ns)
{
    soedev_t *d = instance;
    (void)now_ns;
    for (unsigned int n = 0; n < 2; n++) {
        d->drive[n].velocity = d->drive[n].velocity_set;
        d->drive[n].position = d->drive[n].position_set;
    }
}

static const ect_protocol_t *const protocols[] = {&soedev_soe.protocol, NULL};
static const ect_service_t *const services[] = {&ect_service_soe, NULL};

const ect_device_t soedev = {
    .name = "soedev",
    .summary = "A device with three SoE drives",
    .vendor_name = ECTWIN_VENDOR_NAME,
    .type_name = "ectwin SoE device",
    .group_type = "TEST",
    .group_name = "Test devices",
    .identity = {.vendor_id = 0xE57, .product_code = 0x50E, .revision = 1, .serial = 1},
    .esc = "et1100",
    .esc_config = {0x08, 0x00},
    .sii_size = 2048,
    .sm = {{.start = 0x1800, .length = SOEDEV_MAILBOX, .minimum = 24, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1A00, .length = SOEDEV_MAILBOX, .minimum = 24, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1000, .maximum = 64, .control = 0x24, .type = ECT_SM_OUTPUTS},
           {.start = 0x1100, .maximum = 64, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS},
    .fmmu_count = 2,
    .mailbox_protocols = ECT_MAILBOX_SOE,
    .protocols = protocols,
    .soe_channels = SOEDEV_DRIVES,
    .physics = "YY",
    .timeouts = {.preop_ms = 3000, .safeop_op_ms = 5000, .back_to_init_ms = 1000, .back_to_safeop_ms = 200},
    .objects = objects,
    .object_count = COUNT(objects),
    .services = services,
    .instance_size = sizeof(soedev_t),
    .init = init,
    .inputs = inputs,
};
