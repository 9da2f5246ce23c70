/* SPDX-License-Identifier: MIT */
#include "heater.h"

#include "seams/mailbox.h"
#include "wire/bytes.h"

enum { TICK_NS = 10000000, EMERGENCY_OVER = 0x0000, EMERGENCY_TEMPERATURE = 0x4000, ERROR_TEMPERATURE = 0x08 };

/* --- the dictionary ----------------------------------------------------------------------------------------------- */

static const ect_entry_t outputs_mapping[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_MAP(1, ECT_MAP(0x7000, 1, 16))};
static const ect_entry_t inputs_mapping[] = {ECT_ENTRY_COUNT(2), ECT_ENTRY_MAP(1, ECT_MAP(0x6000, 1, 16)),
                                             ECT_ENTRY_MAP(2, ECT_MAP(0x6000, 2, 8))};
static const ect_entry_t outputs_assignment[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t inputs_assignment[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};

static const ect_entry_t inputs_6000[] = {
    ECT_ENTRY_COUNT(2),
    ECT_ENTRY(1, INTEGER16, 16, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Temperature", 0, heater_t, temperature),
    ECT_ENTRY(2, UNSIGNED8, 8, ECT_ACCESS_RO | ECT_ACCESS_TXPDO, "Power", 0, heater_t, power),
};
static const ect_entry_t outputs_7000[] = {
    ECT_ENTRY_COUNT(1),
    ECT_ENTRY(1, INTEGER16, 16, ECT_ACCESS_RO | ECT_ACCESS_RXPDO, "Set point", 0, heater_t, set_point),
};
static const ect_entry_t settings_8000[] = {
    ECT_ENTRY_COUNT(1),
    ECT_ENTRY(1, INTEGER16, 16, ECT_ACCESS_RW, "Highest temperature", 2000, heater_t, highest),
};

static const ect_object_t objects[] = {
    ECT_OBJECT_DEVICE_TYPE,
    ECT_OBJECT_ERROR_REGISTER,
    ECT_OBJECT_DEVICE_NAME,
    ECT_OBJECT_HARDWARE_VERSION,
    ECT_OBJECT_SOFTWARE_VERSION,
    ECT_OBJECT_IDENTITY,
    ECT_RECORD(0x1600, "Outputs mapping", outputs_mapping),
    ECT_RECORD(0x1A00, "Inputs mapping", inputs_mapping),
    ECT_OBJECT_SM_TYPES(4),
    ECT_ARRAY(0x1C12, "SM2 assignment", outputs_assignment),
    ECT_ARRAY(0x1C13, "SM3 assignment", inputs_assignment),
    ECT_RECORD(0x6000, "Inputs", inputs_6000),
    ECT_RECORD(0x7000, "Outputs", outputs_7000),
    ECT_RECORD(0x8000, "Settings", settings_8000),
};
static const ect_detail_t details[] = {ECT_LIMITS(0x8000, 1, 0, 0, 3000)};

/* --- the behaviour ------------------------------------------------------------------------------------------------ */

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    heater_t *h = instance;
    (void)now_ns;
    h->host = host;
    h->peak = INT16_MIN;
}

static void outputs(void *instance, uint64_t now_ns)
{
    heater_t *h = instance;
    (void)now_ns;
    h->live = true;
}

static void safe_outputs(void *instance, uint64_t now_ns)
{
    heater_t *h = instance;
    (void)now_ns;
    h->live = false;
    h->set_point = 0;
}

/* Reports a broken sensor, and its repair, by an emergency. */
static void watch_sensor(heater_t *h)
{
    static const uint8_t nothing[5] = {0};
    if (h->broken && !h->reported)
        h->host->emergency(h->host->ctx, EMERGENCY_TEMPERATURE, ERROR_TEMPERATURE, nothing);
    if (!h->broken && h->reported)
        h->host->emergency(h->host->ctx, EMERGENCY_OVER, 0, nothing);
    h->reported = h->broken;
}

static uint64_t tick(void *instance, uint64_t now_ns)
{
    heater_t *h = instance;
    int goal = h->set_point < h->highest ? h->set_point : h->highest;
    int missing = goal - h->sensed;
    watch_sensor(h);
    h->temperature = h->broken ? INT16_MAX : h->sensed;
    h->peak = !h->broken && h->sensed > h->peak ? h->sensed : h->peak;
    if (!h->live || h->broken || missing < 0)
        missing = 0;
    h->power = (uint8_t)(missing < 100 ? missing : 100);
    return now_ns + TICK_NS;
}

/* --- a mailbox protocol of the vendor ----------------------------------------------------------------------------- */

enum { VENDOR = 4, HEADER = VENDOR + 2, PEAK = 2 };

/* @return bytes of the data after the header, -1: the service does not exist */
static int serve(heater_t *h, uint16_t service, uint8_t *data)
{
    switch (service) {
    case HEATER_READ_PEAK:
        ect_store_le16(data, (uint16_t)h->peak);
        return PEAK;
    case HEATER_CLEAR_PEAK:
        h->peak = h->sensed;
        return 0;
    default:
        return -1;
    }
}

/* Each request gets one mail: its reply, or the mailbox error that the result selects. */
static uint16_t request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    uint8_t content[PEAK];
    if (length < HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    if (ect_load_le32(data) != HEATER_VENDOR)
        return ECT_MAILBOX_ERROR_SERVICE;
    const uint16_t service = ect_load_le16(data + VENDOR);
    const int size = serve(ect_mailbox_instance(slave), service, content);
    if (size < 0)
        return ECT_MAILBOX_ERROR_SERVICE;
    uint8_t *reply = ect_mailbox_build(slave);
    ect_store_le32(reply, HEATER_VENDOR);
    ect_store_le16(reply + VENDOR, service);
    for (int i = 0; i < size; i++)
        reply[HEADER + i] = content[i];
    ect_mailbox_send(slave, self->type, (uint16_t)(HEADER + size));
    return ECT_MAILBOX_OK;
}

static const ect_protocol_t voe = {.type = ECT_MAILBOX_TYPE_VOE, .states = ECT_IN_PREOP_AND_ABOVE, .request = request};

/* --- the description ---------------------------------------------------------------------------------------------- */

static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &ect_protocol_sdo_info,
                                                  &voe, NULL};

const ect_device_t heater = {
    .name = "heater",
    .summary = "A heater with one sensor",
    .vendor_name = "Example",
    .type_name = "HEATER-1",
    .group_type = "HEATERS",
    .group_name = "Heaters",
    .hardware_version = "1",
    .software_version = "1.0.0",
    .identity = {.vendor_id = HEATER_VENDOR, .product_code = 0x4EA7, .revision = 0x00010000, .serial = 1},
    .esc = "lan9252",
    .sii_size = 2048,
    .sm = {{.start = 0x1000, .length = 128, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = 128, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = 0x1100, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = 0x1180, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .fmmu = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE},
    .fmmu_count = 3,
    .mailbox_protocols = ECT_MAILBOX_COE | ECT_MAILBOX_VOE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_COMPLETE_ACCESS,
    .physics = "YY",
    .general_flags = ECT_GENERAL_GIVEN | ECT_GENERAL_MAIL_REPEAT, /* no address switches, no identification */
    .timeouts = {.preop_ms = 2000, .safeop_op_ms = 2000},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .details = details,
    .detail_count = sizeof details / sizeof details[0],
    .instance_size = sizeof(heater_t),
    .init = init,
    .outputs = outputs,
    .safe_outputs = safe_outputs,
    .tick = tick,
};
