/* SPDX-License-Identifier: MIT */
/* Object services: changeable PDOs, diagnosis history, store and restore, synchronisation. */
#include <inttypes.h>
#include <string.h>

#include "ports/virtual/virtual.h"
#include "seams/record.h"
#include "sii/sii.h"
#include "support/confdev.h"
#include "support/wire.h"

/* --- a twin whose storage and registers the test can access ------------------------------------------------------- */

enum { BANK = 256, NEVER = -1 };

static struct {
    uint8_t bank[2][BANK];
    int writes_left; /* storage operations until the power failure; NEVER */
    int reads_left;  /* for a medium that fails */
} medium;

static bool powered(void)
{
    if (medium.writes_left == 0)
        return false;
    medium.writes_left -= medium.writes_left > 0 ? 1 : 0;
    return true;
}

static int medium_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    (void)ctx;
    assert_true(bank < 2 && offset + length <= BANK);
    memcpy(buffer, medium.bank[bank] + offset, length);
    return 0;
}

static int medium_erase(void *ctx, unsigned int bank)
{
    (void)ctx;
    if (!powered())
        return -1;
    memset(medium.bank[bank], 0xFF, BANK);
    return 0;
}

/* An interrupted write leaves its first half. */
static int medium_write(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length)
{
    (void)ctx;
    assert_true(bank < 2 && offset + length <= BANK);
    bool whole = powered();
    memcpy(medium.bank[bank] + offset, data, whole ? length : length / 2);
    return whole ? 0 : -1;
}

static const ect_storage_t storage = {
    .bank_size = BANK, .read = medium_read, .erase = medium_erase, .write = medium_write};

static struct {
    ect_esc_t esc;
    uint8_t memory[ECT_ESC_MEMORY_SIZE(8)];
    uint8_t sii[2048];
    ect_pdi_t pdi;
    ect_slave_t slave;
    confdev_t device;
    uint8_t mailbox[128 * 3];
    uint8_t process_data[16];
    ect_pdo_run_t runs[16];
    uint8_t activation;   /* value of 0x0981 */
    uint32_t cycle_ns;    /* value of 0x09A0 */
    uint32_t extra_event; /* raised in the AL event word once */
    uint64_t now_ns;
    uint8_t counter;
    uint16_t failing;         /* reads of this address fail */
    ect_device_t description; /* confdev, or a variant of it */
    ect_storage_t storage;
} t;

static int pdi_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    int result = ect_esc_pdi_read(ctx, address, buffer, length);
    if (t.failing != 0 && address == t.failing)
        return -1;
    if (address == ECT_REG_DC_ACTIVATION)
        *(uint8_t *)buffer = t.activation;
    if (address == ECT_REG_DC_SYNC0_CYCLE)
        ect_store_le32(buffer, t.cycle_ns);
    return result;
}

static int al_event(void *ctx, uint32_t *event)
{
    *event = ect_esc_al_event(ctx) | t.extra_event;
    t.extra_event = 0;
    return 0;
}

static void power_on_device(const ect_device_t *device, const ect_storage_t *medium_or_null)
{
    ect_device_t description = *device;
    memset(&t, 0, sizeof t);
    t.description = description;
    assert_true(ect_sii_write(&confdev, NULL, 0, t.sii, sizeof t.sii) > 0);
    const ect_esc_config_t esc = {
        .personality = ect_esc_personality("et1100"), .memory = t.memory, .sii = t.sii, .sii_size = sizeof t.sii};
    t.now_ns = 1000 * MS;
    assert_int_equal(ect_esc_init(&t.esc, &esc, t.now_ns), 0);
    t.pdi = (ect_pdi_t){.ctx = &t.esc, .read = pdi_read, .write = ect_esc_pdi_write, .al_event = al_event};
    const ect_slave_config_t slave = {.device = &t.description,
                                      .pdi = &t.pdi,
                                      .storage = medium_or_null,
                                      .instance = &t.device,
                                      .mailbox = t.mailbox,
                                      .process_data = t.process_data,
                                      .process_size = sizeof t.process_data,
                                      .runs = t.runs,
                                      .run_count = (uint16_t)(sizeof t.runs / sizeof t.runs[0])};
    assert_int_equal(ect_slave_init(&t.slave, &slave, t.now_ns), 0);
}

static void power_on(bool with_storage)
{
    power_on_device(&confdev, with_storage ? &storage : NULL);
}

static void poll(void)
{
    t.now_ns += MS / 10;
    (void)ect_esc_tick(&t.esc, t.now_ns);
    (void)ect_slave_poll(&t.slave, t.now_ns);
}

/* One FPRD/FPWR to station address 0. */
static unsigned int datagram(uint8_t command, uint16_t address, void *data, uint16_t length)
{
    uint8_t frame[600] = {[12] = 0x88, [13] = 0xA4};
    ect_store_le16(frame + 14, (uint16_t)(0x1000 | (length + 12)));
    frame[16] = command;
    ect_store_le16(frame + 20, address);
    ect_store_le16(frame + 22, length);
    memcpy(frame + 26, data, length);
    assert_int_equal(ect_esc_process(&t.esc, frame, 28u + length, t.now_ns), ECT_FRAME_FORWARD);
    memcpy(data, frame + 26, length);
    poll();
    return frame[26 + length];
}

static void set_sm(unsigned int n, uint16_t length)
{
    const ect_sm_t *sm = &confdev.sm[n];
    uint8_t off = 0;
    uint8_t registers[8] = {0};
    datagram(FPWR, (uint16_t)(ECT_REG_SM + 8 * n + 6), &off, 1);
    ect_store_le16(registers, sm->start);
    ect_store_le16(registers + 2, length);
    registers[4] = t.description.sm[n].control;
    registers[6] = length > 0 ? 1 : 0;
    datagram(FPWR, (uint16_t)(ECT_REG_SM + 8 * n), registers, 8);
}

static uint8_t request(uint8_t state)
{
    uint8_t control[2] = {state | ECT_AL_ACKNOWLEDGE, 0};
    datagram(FPWR, ECT_REG_AL_CONTROL, control, 2);
    return (uint8_t)(t.slave.state | (t.slave.error ? ECT_AL_ERROR : 0));
}

static void to_preop(void)
{
    set_sm(0, 128);
    set_sm(1, 128);
    assert_int_equal(request(ECT_STATE_PREOP), ECT_STATE_PREOP);
}

static void to_op(uint16_t output_bytes, uint16_t input_bytes)
{
    uint8_t zeros[16] = {0};
    set_sm(2, output_bytes);
    set_sm(3, input_bytes);
    assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_SAFEOP);
    if (output_bytes > 0)
        assert_int_equal(datagram(FPWR, confdev.sm[2].start, zeros, output_bytes), 1);
    assert_int_equal(request(ECT_STATE_OP), ECT_STATE_OP);
}

static uint32_t exchange(const uint8_t *payload, uint16_t length, uint8_t *answer)
{
    uint8_t mail[128] = {0};
    t.counter = (uint8_t)(t.counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(3 | (t.counter << 4));
    memcpy(mail + 6, payload, length);
    assert_int_equal(datagram(FPWR, 0x1000, mail, 128), 1);
    assert_int_equal(datagram(FPRD, 0x1080, mail, 128), 1);
    memcpy(answer, mail + 6, 122);
    return answer[2] == 0x80 ? ect_load_le32(answer + 6) : 0;
}

static uint32_t write_sdo(uint16_t index, uint8_t subindex, bool complete, const void *data, uint8_t size)
{
    uint8_t request_bytes[122] = {0, 0x20, (uint8_t)(0x21 | (complete ? 0x10 : 0))};
    uint8_t answer[122];
    ect_store_le16(request_bytes + 3, index);
    request_bytes[5] = subindex;
    ect_store_le32(request_bytes + 6, size);
    memcpy(request_bytes + 10, data, size);
    return exchange(request_bytes, (uint16_t)(10 + size), answer);
}

static uint32_t write_number(uint16_t index, uint8_t subindex, uint32_t value, uint8_t size)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    return write_sdo(index, subindex, false, bytes, size);
}

static uint32_t read_number(uint16_t index, uint8_t subindex)
{
    uint8_t request_bytes[10] = {0, 0x20, 0x40};
    uint8_t answer[122];
    ect_store_le16(request_bytes + 3, index);
    request_bytes[5] = subindex;
    assert_int_equal(exchange(request_bytes, 10, answer), 0);
    return ect_load_le32(answer + 6);
}

/* --- changeable PDOs --------------------------------------------------------------------------------------------- */

/* The procedure: assignment and mapping to 0, new entries, counts. Leaves 1600h = u16, gap of 7, bool; 1601h = u32. */
static void remap_outputs(void)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t value;
        uint8_t size;
    } steps[] = {
        {0x1C12, 0, 0, 1},
        {0x1600, 0, 0, 1},
        {0x1600, 1, ECT_MAP(0x7000, 2, 16), 4},
        {0x1600, 2, ECT_MAP(0, 0, 7), 4},
        {0x1600, 3, ECT_MAP(0x7000, 4, 1), 4},
        {0x1600, 0, 3, 1},
        {0x1601, 1, ECT_MAP(0x7000, 3, 32), 4},
        {0x1601, 0, 1, 1},
        {0x1C12, 1, 0x1601, 2},
        {0x1C12, 2, 0x1600, 2},
        {0x1C12, 0, 2, 1},
    };
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++)
        assert_int_equal(write_number(steps[i].index, steps[i].subindex, steps[i].value, steps[i].size), 0);
}

static void remap_changes_image(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    remap_outputs();
    set_sm(2, 1);
    set_sm(3, 3);
    assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_PREOP | ECT_AL_ERROR);
    assert_int_equal(t.slave.code, ECT_AL_OUTPUT_SM);
    assert_int_equal(request(ECT_STATE_PREOP), ECT_STATE_PREOP);
    to_op(7, 3);
    uint8_t image[7] = {0x78, 0x56, 0x34, 0x12, 0xCD, 0xAB, 0x80};
    assert_int_equal(datagram(FPWR, confdev.sm[2].start, image, 7), 1);
    assert_int_equal(t.device.out_u32, 0x12345678);
    assert_int_equal(t.device.out_u16, 0xABCD);
    assert_int_equal(t.device.out_bool, 1);
}

static void remap_by_complete_access(void **state)
{
    (void)state;
    static const uint8_t mapping[] = {2, 0, 0x20, 3, 0, 0x60, 0x08, 1, 0, 0x60};
    power_on(false);
    to_preop();
    assert_int_equal(write_sdo(0x1A00, 0, true, mapping, sizeof mapping), 0);
    assert_int_equal(read_number(0x1A00, 1), ECT_MAP(0x6000, 3, 32));
    to_op(1, 5);
    uint8_t image[5];
    assert_int_equal(datagram(FPRD, confdev.sm[3].start, image, 5), 1);
    assert_memory_equal(image, "\x77\x66\x55\x44\x11", 5);
}

static const struct {
    const char *what;
    uint16_t index;
    uint8_t subindex;
    uint32_t value;
    uint8_t size;
    uint32_t abort_code;
} refused[] = {
    {"entry while the count is not 0", 0x1600, 1, ECT_MAP(0x7000, 1, 8), 4, 0x06010003},
    {"PDO while the count is not 0", 0x1C12, 1, 0x1601, 2, 0x06010003},
    {"count above the room", 0x1600, 0, 5, 1, 0x06090031},
    {"unknown object", 0x1601, 1, ECT_MAP(0x5555, 1, 8), 4, 0x06020000},
    {"unknown sub-index", 0x1601, 1, ECT_MAP(0x7000, 9, 8), 4, 0x06090011},
    {"object of the other direction", 0x1601, 1, ECT_MAP(0x6000, 1, 8), 4, 0x06040041},
    {"object that is not mappable", 0x1601, 1, ECT_MAP(0x2100, 0, 32), 4, 0x06040041},
    {"wrong length", 0x1601, 1, ECT_MAP(0x7000, 2, 8), 4, 0x06040041},
    {"count over an entry never written is a gap of no bits", 0x1601, 0, 1, 1, 0},
};

static void refused_mappings(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        uint32_t got = write_number(refused[i].index, refused[i].subindex, refused[i].value, refused[i].size);
        if (got != refused[i].abort_code)
            fail_msg("%s: expected 0x%08X, got 0x%08X", refused[i].what, refused[i].abort_code, got);
    }
    assert_int_equal(read_number(0x1600, 1) & 0xFFFFFFFF, ECT_MAP(0x7000, 1, 8));
    assert_int_equal(read_number(0x1C12, 1) & 0xFFFF, 0x1600);
}

static void refused_assignments(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    assert_int_equal(write_number(0x1C12, 0, 0, 1), 0);
    assert_int_equal(write_number(0x1C12, 1, 0x1A00, 2), 0x06040041);
    assert_int_equal(write_number(0x1C12, 1, 0x1700, 2), 0x06020000);
    assert_int_equal(write_number(0x1C12, 1, 0x1600, 2), 0);
    assert_int_equal(write_number(0x1C12, 2, 0x1600, 2), 0);
    assert_int_equal(write_number(0x1C12, 0, 2, 1), 0x06040043); /* the same PDO twice */
    assert_int_equal(read_number(0x1C12, 0) & 0xFF, 0);
}

static void too_long_mapping(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    assert_int_equal(write_number(0x1600, 0, 0, 1), 0);
    for (uint8_t sub = 1; sub <= 4; sub++)
        assert_int_equal(write_number(0x1600, sub, ECT_MAP(0, 0, 255), 4), 0);
    assert_int_equal(write_number(0x1600, 0, 1, 1), 0x06040042); /* 255 bits, room is 128 */
    assert_int_equal(read_number(0x1600, 0) & 0xFF, 0);
    static const uint8_t whole[] = {2, 0, 255, 0, 0, 0, 255, 0, 0, 0};
    assert_int_equal(write_sdo(0x1601, 0, true, whole, sizeof whole), 0x06040042);
    assert_int_equal(read_number(0x1601, 0) & 0xFF, 0);
}

static void only_in_preop(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    to_op(1, 3);
    assert_int_equal(write_number(0x1C12, 0, 0, 1), 0x08000022);
    assert_int_equal(write_number(0x1600, 0, 0, 1), 0x08000022);
}

/* --- diagnosis history ------------------------------------------------------------------------------------------- */

static void diagnose(uint8_t type, uint32_t code, uint16_t text)
{
    const uint16_t parameters[2] = {0x1111, 0x2222};
    t.device.host->diagnose(t.device.host->ctx, type, code, text, parameters);
}

static void diagnosis_message(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    assert_int_equal(read_number(0x10F3, 1) & 0xFF, ECT_DIAGNOSIS_MESSAGES);
    assert_int_equal(read_number(0x10F3, 4) & 0xFF, 0);
    diagnose(ECT_DIAGNOSIS_WARNING, 0x12345678, 0x0042);
    assert_int_equal(read_number(0x10F3, 2) & 0xFF, 6);
    assert_int_equal(read_number(0x10F3, 4) & 0xFF, 1);
    const uint8_t *m = t.device.diagnosis.messages[0];
    assert_int_equal(ect_load_le32(m), 0x12345678);
    assert_int_equal(ect_load_le16(m + 4), 0x0211); /* two parameters, local time, warning */
    assert_int_equal(ect_load_le16(m + 6), 0x0042);
    assert_true(ect_load_le64(m + 8) > 1000 * MS);
    assert_memory_equal(m + 16, "\x06\x00\x11\x11\x06\x00\x22\x22", 8);
    assert_int_equal(write_number(0x10F3, 3, 6, 1), 0);
    assert_int_equal(read_number(0x10F3, 4) & 0xFF, 0);
}

static void diagnosis_overwrites(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    for (uint16_t i = 1; i <= ECT_DIAGNOSIS_MESSAGES + 2; i++)
        diagnose(ECT_DIAGNOSIS_ERROR, 0xFF000000, i);
    assert_int_equal(t.device.diagnosis.newest, 7);
    assert_int_equal(ect_load_le16(t.device.diagnosis.messages[0] + 6), ECT_DIAGNOSIS_MESSAGES + 1);
    assert_int_equal(read_number(0x10F3, 5) & ECT_DIAGNOSIS_LOST, ECT_DIAGNOSIS_LOST);
    assert_int_equal(write_number(0x10F3, 3, 0, 1), 0);
    assert_int_equal(t.device.diagnosis.newest, 0);
    assert_int_equal(read_number(0x10F3, 5), 0);
    static const uint8_t nothing[ECT_DIAGNOSIS_BYTES];
    for (size_t i = 0; i < ECT_DIAGNOSIS_MESSAGES; i++)
        assert_memory_equal(t.device.diagnosis.messages[i], nothing, sizeof nothing);
}

static void diagnosis_acknowledge_mode(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    assert_int_equal(write_number(0x10F3, 5, ECT_DIAGNOSIS_ACKNOWLEDGE, 2), 0);
    for (uint16_t i = 1; i <= ECT_DIAGNOSIS_MESSAGES + 1; i++)
        diagnose(ECT_DIAGNOSIS_INFO, 1, i);
    assert_int_equal(ect_load_le16(t.device.diagnosis.messages[0] + 6), 1);
    assert_int_equal(t.device.diagnosis.newest, 5 + ECT_DIAGNOSIS_MESSAGES);
    assert_int_equal(write_number(0x10F3, 3, 7, 1), 0);
    diagnose(ECT_DIAGNOSIS_INFO, 1, 100);
    assert_int_equal(ect_load_le16(t.device.diagnosis.messages[0] + 6), 100);
}

/* Acknowledge mode is chosen while the newest message is not in the last slot. */
static void diagnosis_mode_changes(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    for (uint16_t i = 1; i <= ECT_DIAGNOSIS_MESSAGES + 2; i++)
        diagnose(ECT_DIAGNOSIS_INFO, 1, i);
    assert_int_equal(write_number(0x10F3, 5, ECT_DIAGNOSIS_ACKNOWLEDGE, 2), 0);
    diagnose(ECT_DIAGNOSIS_INFO, 1, 100);
    assert_int_equal(t.device.diagnosis.newest, 7);
    assert_int_equal(ect_load_le16(t.device.diagnosis.messages[2] + 6), 3);
}

static void diagnosis_filters(void **state)
{
    static const uint16_t flags[] = {ECT_DIAGNOSIS_NO_INFO, ECT_DIAGNOSIS_NO_WARNING, ECT_DIAGNOSIS_NO_ERROR};
    (void)state;
    power_on(false);
    to_preop();
    for (uint8_t off = 0; off < 3; off++) {
        assert_int_equal(write_number(0x10F3, 3, 0, 1), 0);
        assert_int_equal(write_number(0x10F3, 5, flags[off], 2), 0);
        for (uint8_t type = 0; type < 3; type++) {
            uint8_t before = t.device.diagnosis.newest;
            diagnose(type, 1, 1);
            assert_int_equal(t.device.diagnosis.newest != before, type != off);
        }
    }
    assert_int_equal(write_number(0x10F3, 5, 0x40, 2), 0x06090030);
    assert_int_equal(write_number(0x10F3, 3, 5, 1), 0x06090030);
    assert_int_equal(write_number(0x10F3, 3, 14, 1), 0x06090030);
}

static void diagnosis_emergency(void **state)
{
    (void)state;
    uint8_t mail[128] = {0};
    power_on(false);
    to_preop();
    assert_int_equal(write_number(0x10F3, 5, ECT_DIAGNOSIS_EMERGENCY, 2), 0);
    diagnose(ECT_DIAGNOSIS_ERROR, 0x8130E800, 0x0102);
    poll();
    assert_int_equal(datagram(FPRD, 0x1080, mail, 128), 1);
    assert_memory_equal(mail + 6, "\x00\x10\x30\x81\x00\x02\x01\x06", 8);
}

/* The low word E800h marks a diagnosis code that has an emergency error code. */
static void diagnosis_emergency_codes(void **state)
{
    static const struct {
        uint32_t code;
        uint16_t emergency;
    } rows[] = {
        {0x8130E800, 0x8130}, {0xFFFFE800, 0xFFFF}, {0x8130E801, 0xFF00}, {0x8130E900, 0xFF00},
        {0x81306800, 0xFF00}, {0x8130C800, 0xFF00}, {0x0000E800, 0x0000}, {1, 0xFF00},
    };
    (void)state;
    uint8_t mail[128] = {0};
    power_on(false);
    to_preop();
    assert_int_equal(write_number(0x10F3, 5, ECT_DIAGNOSIS_EMERGENCY, 2), 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        diagnose(ECT_DIAGNOSIS_ERROR, rows[i].code, 0x0102);
        poll();
        assert_int_equal(datagram(FPRD, 0x1080, mail, 128), 1);
        if (ect_load_le16(mail + 8) != rows[i].emergency)
            fail_msg("diagnosis code 0x%08X: expected emergency 0x%04X, got 0x%04X", (unsigned int)rows[i].code,
                     rows[i].emergency, ect_load_le16(mail + 8));
    }
}

/* --- store and restore ------------------------------------------------------------------------------------------- */

static void fresh_medium(void)
{
    memset(medium.bank, 0xFF, sizeof medium.bank);
    medium.writes_left = NEVER;
}

static void stored_survives(void **state)
{
    (void)state;
    fresh_medium();
    power_on(true);
    to_preop();
    uint8_t octets[40];
    memset(octets, 0x5A, sizeof octets);
    assert_int_equal(write_number(0x2100, 0, 777, 4), 0);
    assert_int_equal(write_sdo(0x2101, 0, false, octets, sizeof octets), 0);
    power_on(true);
    assert_int_equal(t.device.stored, 100); /* not stored: forgotten */
    to_preop();
    assert_int_equal(write_number(0x2100, 0, 777, 4), 0);
    assert_int_equal(write_sdo(0x2101, 0, false, octets, sizeof octets), 0);
    assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0);
    assert_int_equal(read_number(0x1010, 1), 1);
    power_on(true);
    assert_int_equal(t.device.stored, 777);
    assert_memory_equal(t.device.stored_octets, octets, sizeof octets);
    to_preop();
    assert_int_equal(write_number(0x1011, 1, ECT_LOAD_SIGNATURE, 4), 0);
    assert_int_equal(t.device.stored, 777); /* until the next power-on */
    power_on(true);
    assert_int_equal(t.device.stored, 100);
}

static void wrong_signature(void **state)
{
    (void)state;
    fresh_medium();
    power_on(true);
    to_preop();
    assert_int_equal(write_number(0x1010, 1, ECT_LOAD_SIGNATURE, 4), 0x08000020);
    assert_int_equal(write_number(0x1011, 1, ECT_STORE_SIGNATURE, 4), 0x08000020);
    power_on(false);
    to_preop();
    assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0x08000020);
}

/* With a power failure at each operation of the second store, either the first values or the new ones are there. */
static void power_cut(void **state)
{
    (void)state;
    for (int cut = 0; cut < 12; cut++) {
        fresh_medium();
        power_on(true);
        to_preop();
        assert_int_equal(write_number(0x2100, 0, 1111, 4), 0);
        assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0);
        assert_int_equal(write_number(0x2100, 0, 2222, 4), 0);
        medium.writes_left = cut;
        uint32_t code = write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4);
        medium.writes_left = NEVER;
        power_on(true);
        uint32_t expected = code == 0 ? 2222 : 1111;
        if (t.device.stored != expected || (code != 0 && code != 0x06060000))
            fail_msg("cut at operation %d: reply 0x%08X, value %u", cut, code, t.device.stored);
        to_preop();
        assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0);
    }
}

static void many_stores(void **state)
{
    (void)state;
    fresh_medium();
    for (uint32_t i = 1; i < 10; i++) {
        power_on(true);
        assert_int_equal(t.device.stored, i == 1 ? 100 : i - 1);
        to_preop();
        assert_int_equal(write_number(0x2100, 0, i, 4), 0);
        assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0);
    }
    for (size_t i = 0; i < sizeof medium.bank[0]; i++) { /* no single damaged byte ever gives wrong values */
        uint8_t before = medium.bank[0][i];
        medium.bank[0][i] ^= 0x10;
        power_on(true);
        assert_true(t.device.stored == 9 || t.device.stored == 8);
        medium.bank[0][i] = before;
    }
}

/* One SYNC0: the event is raised and cleared. */
static void sync0(void)
{
    t.extra_event = ECT_EVENT_SYNC0;
    poll();
    poll();
}

/* --- synchronisation --------------------------------------------------------------------------------------------- */

static void sync_types(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    assert_int_equal(read_number(0x1C32, 4) & 0xFFFF, 7);
    assert_int_equal(read_number(0x1C32, 5), 1000000);
    assert_int_equal(write_number(0x1C32, 1, 1, 2), 0);
    assert_int_equal(write_number(0x1C32, 1, 3, 2), 0x06090030);
    assert_int_equal(write_number(0x1C32, 1, 0x22, 2), 0x06090030);
    assert_int_equal(write_number(0x1C32, 1, 2, 2), 0);
    set_sm(2, 1);
    set_sm(3, 3);
    assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_PREOP | ECT_AL_ERROR); /* DC requested, DC not running */
    assert_int_equal(t.slave.code, ECT_AL_DC_SYNC);
}

static void sync_cycles(void **state)
{
    static const struct {
        uint32_t cycle_ns;
        uint16_t code;
    } rows[] = {{1000000, 0},
                {2000000, 0},
                {1500000, ECT_AL_SYNC0_CYCLE},
                {0, ECT_AL_SYNC0_CYCLE},
                {500000, ECT_AL_SYNC0_CYCLE}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        power_on(false);
        to_preop();
        t.activation = 0x03;
        t.cycle_ns = rows[i].cycle_ns;
        set_sm(2, 1);
        set_sm(3, 3);
        (void)request(ECT_STATE_SAFEOP);
        if (t.slave.code != rows[i].code)
            fail_msg("%u ns: expected code 0x%04X, got 0x%04X", rows[i].cycle_ns, rows[i].code, t.slave.code);
    }
}

static void sync_missed(void **state)
{
    (void)state;
    uint8_t output[1] = {0};
    power_on(false);
    to_preop();
    t.activation = 0x03;
    t.cycle_ns = 1000000;
    to_op(1, 3);
    for (int i = 0; i < 10; i++) { /* without errors */
        datagram(FPWR, confdev.sm[2].start, output, 1);
        sync0();
    }
    assert_int_equal(t.device.sync.sm_missed, 0);
    datagram(FPWR, confdev.sm[2].start, output, 1);
    datagram(FPWR, confdev.sm[2].start, output, 1);
    assert_int_equal(t.device.sync.cycle_exceeded, 1);
    sync0();
    for (uint16_t missed = 1; missed <= 5; missed++) {
        assert_int_equal(t.slave.state, ECT_STATE_OP);
        sync0();
        assert_int_equal(t.device.sync.sm_missed, missed);
    }
    assert_int_equal(t.slave.state, ECT_STATE_SAFEOP);
    assert_int_equal(t.slave.code, ECT_AL_SYNC);
    assert_int_equal(t.slave.cause, ECT_CAUSE_LOCAL);
    assert_int_equal(read_number(0x1C32, 32) & 0xFF, 1); /* "Sync error", until a restart */
    assert_int_equal(request(ECT_STATE_PREOP), ECT_STATE_PREOP);
    assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_SAFEOP);
    assert_int_equal(read_number(0x1C32, 32) & 0xFF, 0);
}

/* The event is a level: until it is acknowledged it is one SYNC0. */
static void sync_level(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    t.activation = 1;
    t.cycle_ns = 1000000;
    to_op(1, 3);
    t.device.sync.sm_missed = 0;
    t.device.sync.outputs_new = 0;
    for (int i = 0; i < 3; i++) {
        t.extra_event = ECT_EVENT_SYNC0;
        poll();
    }
    assert_int_equal(t.device.sync.sm_missed, 1);
    sync0();
    assert_int_equal(t.device.sync.sm_missed, 1); /* still the same one */
    sync0();
    assert_int_equal(t.device.sync.sm_missed, 2);
}

static void sync_lost(void **state)
{
    static const uint16_t limits[] = {4, 1, 2};
    (void)state;
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        uint8_t output[1] = {0};
        power_on(false);
        to_preop();
        assert_int_equal(write_number(0x10F1, 2, limits[i], 2), 0);
        t.activation = 0x03;
        t.cycle_ns = 1000000;
        to_op(1, 3);
        for (int ms = 0; ms < 20; ms++) { /* not started yet: nothing is missed */
            datagram(FPWR, confdev.sm[2].start, output, 1);
            poll();
            t.now_ns += MS;
        }
        assert_int_equal(t.slave.state, ECT_STATE_OP);
        sync0();
        uint64_t last_ns = t.slave.now_ns;
        while (t.slave.state == ECT_STATE_OP && t.now_ns < last_ns + 50000000) {
            datagram(FPWR, confdev.sm[2].start, output, 1);
            poll();
        }
        assert_int_equal(t.slave.state, ECT_STATE_SAFEOP);
        assert_int_equal(t.slave.code, ECT_AL_FATAL_SYNC);
        uint64_t patience_ns = (limits[i] + 1u) * 1000000u;
        if (t.slave.now_ns - last_ns < patience_ns || t.slave.now_ns - last_ns > patience_ns + 300000)
            fail_msg("limit %u: expected SAFEOP after %u cycles of 1 ms, got %" PRIu64 " ns", limits[i], limits[i] + 1u,
                     t.slave.now_ns - last_ns);
    }
}

/* Events missed outside OP do not count: the last SYNC0 of the previous OP is long ago. */
static void sync_again(void **state)
{
    (void)state;
    uint8_t output[1] = {0};
    power_on(false);
    to_preop();
    t.activation = 0x03;
    t.cycle_ns = 1000000;
    to_op(1, 3);
    sync0();
    assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_SAFEOP);
    t.now_ns += 1000 * MS;
    datagram(FPWR, confdev.sm[2].start, output, 1);
    assert_int_equal(request(ECT_STATE_OP), ECT_STATE_OP);
    for (int ms = 0; ms < 20; ms++) {
        datagram(FPWR, confdev.sm[2].start, output, 1);
        poll();
        t.now_ns += MS;
    }
    assert_int_equal(t.slave.state, ECT_STATE_OP);
}

/* It has occurred in SAFEOP, and stops before it occurs in OP. */
static void sync_lost_early(void **state)
{
    (void)state;
    uint8_t output[1] = {0};
    power_on(false);
    to_preop();
    t.activation = 0x03;
    t.cycle_ns = 1000000;
    set_sm(2, 1);
    set_sm(3, 3);
    assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_SAFEOP);
    sync0();
    assert_int_equal(datagram(FPWR, confdev.sm[2].start, output, 1), 1);
    assert_int_equal(request(ECT_STATE_OP), ECT_STATE_OP);
    for (int ms = 0; ms < 20 && t.slave.state == ECT_STATE_OP; ms++) {
        datagram(FPWR, confdev.sm[2].start, output, 1);
        poll();
        t.now_ns += MS;
    }
    assert_int_equal(t.slave.state, ECT_STATE_SAFEOP);
    assert_int_equal(t.slave.code, ECT_AL_FATAL_SYNC);
}

static void sync_abilities(void **state)
{
    static const struct {
        const char *what;
        uint16_t supported;
        uint8_t cycles;
        uint32_t cycle_ns;
        uint16_t type; /* at power-on */
        uint16_t code; /* of SAFEOP with SYNC0 running */
    } rows[] = {
        {"no DC", 0x0003, 0, 1000000, ECT_SYNC_FREE_RUN, ECT_AL_NO_SYNC},
        {"no free run", 0x0006, 0, 1000000, ECT_SYNC_SM, 0},
        {"any cycle from the minimum on", 0x0004, 0, 1000000, ECT_SYNC_SM, 0},
        {"below the minimum", 0x0004, 0, 999999, ECT_SYNC_SM, ECT_AL_SYNC0_CYCLE},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = confdev;
        device.sync.supported = rows[i].supported;
        device.sync.dc_cycle_count = rows[i].cycles;
        power_on_device(&device, NULL);
        if (t.device.sync.type != rows[i].type)
            fail_msg("%s: expected type %u, got %u", rows[i].what, rows[i].type, t.device.sync.type);
        to_preop();
        t.activation = 1;
        t.cycle_ns = rows[i].cycle_ns;
        set_sm(2, 1);
        set_sm(3, 3);
        (void)request(ECT_STATE_SAFEOP);
        if (t.slave.code != rows[i].code)
            fail_msg("%s: expected code 0x%04X, got 0x%04X", rows[i].what, rows[i].code, t.slave.code);
    }
}

static void sync_limit_off(void **state)
{
    (void)state;
    uint8_t output[1] = {0};
    power_on(false);
    to_preop();
    assert_int_equal(write_number(0x10F1, 2, 0, 2), 0);
    t.activation = 1;
    t.cycle_ns = 2000000;
    to_op(1, 3);
    t.device.sync.sm_missed = 0xFFFE;
    for (int i = 0; i < 50; i++) {
        sync0();
        if (i % 10 == 0)
            datagram(FPWR, confdev.sm[2].start, output, 1); /* the watchdog is not the subject */
    }
    assert_int_equal(t.slave.state, ECT_STATE_OP);
    assert_int_equal(t.device.sync.sm_missed, 0xFFFF);
}

static void sync_read_fails(void **state)
{
    static const uint16_t registers[] = {ECT_REG_DC_ACTIVATION, ECT_REG_DC_SYNC0_CYCLE};
    (void)state;
    for (size_t i = 0; i < sizeof registers / sizeof registers[0]; i++) {
        power_on(false);
        to_preop();
        set_sm(2, 1);
        set_sm(3, 3);
        t.activation = 1;
        t.cycle_ns = 2000000;
        t.failing = registers[i];
        assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_PREOP);
        t.failing = 0;
        poll();
        assert_int_equal(t.slave.state, ECT_STATE_SAFEOP);
    }
}

/* SYNC0 activates the interrupt line only in synchronous modes. */
static void sync_event_mask(void **state)
{
    static const struct {
        uint16_t supported;
        uint32_t mask;
    } rows[] = {{0x0007, ECT_EVENT_SYNC0}, {0x0004, ECT_EVENT_SYNC0}, {0x0003, 0}, {0, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = confdev;
        uint8_t mask[4] = {0};
        device.sync.supported = rows[i].supported;
        power_on_device(&device, NULL);
        to_preop();
        t.device.sync.type = ECT_SYNC_SM;
        set_sm(2, 1);
        set_sm(3, 3);
        assert_int_equal(request(ECT_STATE_SAFEOP), ECT_STATE_SAFEOP);
        assert_true(ect_esc_pdi_read(&t.esc, ECT_REG_AL_EVENT_MASK, mask, sizeof mask) >= 0);
        if ((ect_load_le32(mask) & ECT_EVENT_SYNC0) != rows[i].mask)
            fail_msg("supported 0x%04X: expected 0x%02X of SYNC0 in 0x0204, got 0x%08X", rows[i].supported,
                     rows[i].mask, ect_load_le32(mask));
    }
}

static unsigned int outputs_taken;

static void take_outputs(void *instance, uint64_t now_ns)
{
    (void)instance;
    (void)now_ns;
    outputs_taken++;
}

/* The status of a SyncManager without events shows that it was written. */
static void outputs_without_event(void **state)
{
    (void)state;
    ect_device_t device = confdev;
    uint8_t output[1] = {0};
    device.sm[2].control &= (uint8_t)~ECT_SM_CONTROL_AL_EVENT;
    device.outputs = take_outputs;
    power_on_device(&device, NULL);
    to_preop();
    to_op(1, 3);
    outputs_taken = 0;
    for (unsigned int i = 1; i <= 3; i++) {
        datagram(FPWR, confdev.sm[2].start, output, 1);
        poll();
        poll();
        assert_int_equal(outputs_taken, i);
    }
}

/* The services have no effect in a device whose dictionary lacks their objects. */
static void services_without_objects(void **state)
{
    (void)state;
    ect_device_t device = confdev;
    ect_object_t few[32];
    uint16_t count = 0;
    for (uint16_t i = 0; i < confdev.object_count; i++) {
        uint16_t index = confdev.objects[i].index;
        if (index != 0x10F3 && index != 0x1C32)
            few[count++] = confdev.objects[i];
    }
    device.objects = few;
    device.object_count = count;
    power_on_device(&device, NULL);
    to_preop();
    diagnose(ECT_DIAGNOSIS_ERROR, 1, 1);
    assert_int_equal(t.device.diagnosis.newest, 0);
    to_op(1, 3);
    sync0();
    assert_int_equal(t.device.sync.sm_missed, 0);
}

static int read_fails(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    (void)medium_read(ctx, bank, offset, buffer, length);
    return medium.reads_left-- > 0 ? 0 : -1;
}

/* A medium that fails: regardless of the data read so far, the slave starts, with stored values or defaults. */
static void medium_does_not_answer(void **state)
{
    (void)state;
    fresh_medium();
    power_on(true);
    to_preop();
    assert_int_equal(write_number(0x2100, 0, 555, 4), 0);
    assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0);
    ect_storage_t failing = storage;
    failing.read = read_fails;
    for (int reads = 0; reads < 20; reads++) {
        medium.reads_left = reads;
        power_on_device(&confdev, &failing);
        assert_true(t.device.stored == 555 || t.device.stored == 100);
    }
}

static void medium_too_small(void **state)
{
    (void)state;
    ect_storage_t small = storage;
    fresh_medium();
    small.bank_size = 8; /* not even a header */
    power_on_device(&confdev, &small);
    to_preop();
    assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0x08000020);
    small.bank_size = 30; /* not all entries */
    power_on_device(&confdev, &small);
    to_preop();
    assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0x06060000);
}

/* A firmware whose 2100h is different, is no longer stored, or is missing, ignores the value in the record. */
static void record_of_another_firmware(void **state)
{
    (void)state;
    static const ect_entry_t shorter[] = {
        {0, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW | ECT_ACCESS_BACKUP, "Stored", 100, ECT_OFFSET(confdev_t, stored)}};
    static const ect_entry_t not_stored[] = {
        {0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, "Stored", 100, ECT_OFFSET(confdev_t, stored)}};
    const ect_entry_t *variants[] = {shorter, not_stored, NULL};
    for (size_t v = 0; v < 3; v++) {
        fresh_medium();
        power_on(true);
        to_preop();
        assert_int_equal(write_number(0x2100, 0, 555, 4), 0);
        assert_int_equal(write_number(0x1010, 1, ECT_STORE_SIGNATURE, 4), 0);
        ect_device_t device = confdev;
        ect_object_t objects[32];
        memcpy(objects, confdev.objects, confdev.object_count * sizeof objects[0]);
        for (uint16_t i = 0; i < confdev.object_count; i++) {
            if (objects[i].index == 0x2100 && variants[v])
                objects[i].entries = variants[v];
            else if (objects[i].index == 0x2100)
                objects[i].index = 0x20FF;
        }
        device.objects = objects;
        power_on_device(&device, &storage);
        assert_int_equal(t.device.stored, 100);
    }
}

/* The device requests it anywhere; the next poll stores once. */
static void stored_by_the_device(void **state)
{
    enum { MAGIC = 0x50435445 };
    ect_record_t record;
    (void)state;
    fresh_medium();
    power_on(true);
    t.device.stored = 888;
    t.device.host->store(t.device.host->ctx);
    assert_int_equal(ect_record_find(&storage, MAGIC, &record), 0);
    for (unsigned int polls = 0; polls < 3; polls++) {
        poll();
        assert_int_equal(ect_record_find(&storage, MAGIC, &record), 1);
        assert_int_equal(record.sequence, 1);
    }
    t.device.host->store(t.device.host->ctx);
    poll();
    assert_int_equal(ect_record_find(&storage, MAGIC, &record), 1);
    assert_int_equal(record.sequence, 2);
    power_on(true);
    assert_int_equal(t.device.stored, 888);
}

/* The entries of a record: index, sub-index, size, value. One that ends behind the record ends the reading. */
static void entries_of_a_record(void **state)
{
    enum { MAGIC = 0x50435445 };
    static const struct {
        const char *title;
        uint8_t bytes[20], length;
        uint32_t stored;
    } rows[] = {
        {"none", {0}, 0, 100},
        {"one", {0x00, 0x21, 0, 4, 0, 0x2B, 2, 0, 0}, 9, 555},
        {"without its last byte", {0x00, 0x21, 0, 4, 0, 0x2B, 2, 0}, 8, 100},
        {"without its value", {0x00, 0x21, 0, 4, 0}, 5, 100},
        {"half an address", {0x00}, 1, 100},
        {"of another sub-index", {0x00, 0x21, 1, 4, 0, 0x2B, 2, 0, 0}, 9, 100},
        {"too short", {0x00, 0x21, 0, 3, 0, 0x2B, 2, 0}, 8, 100},
        {"too long", {0x00, 0x21, 0, 5, 0, 0x2B, 2, 0, 0, 0}, 10, 100},
        {"behind an unknown one", {0xFF, 0x20, 0, 2, 0, 7, 7, 0x00, 0x21, 0, 4, 0, 0x2B, 2, 0, 0}, 16, 555},
        {"behind one too short", {0x00, 0x21, 0, 1, 0, 9, 0x00, 0x21, 0, 4, 0, 0x2B, 2, 0, 0}, 15, 555},
        {"behind one without a value", {0x00, 0x21, 0, 0, 0, 0x00, 0x21, 0, 4, 0, 0x2B, 2, 0, 0}, 14, 555},
        {"before half of one", {0x00, 0x21, 0, 4, 0, 0x2B, 2, 0, 0, 0x00, 0x21, 0, 4}, 13, 555},
        {"behind one of 65535 bytes", {0xFF, 0x20, 0, 0xFF, 0xFF, 0x00, 0x21, 0, 4, 0, 0x2B, 2, 0, 0}, 14, 100},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_record_t newest, record;
        fresh_medium();
        assert_int_equal(ect_record_find(&storage, MAGIC, &newest), 0);
        assert_true(ect_record_begin(&record, &newest));
        assert_true(ect_record_put(&record, rows[i].bytes, rows[i].length));
        assert_true(ect_record_commit(&record, MAGIC));
        power_on_device(&confdev, &storage);
        if (t.device.stored != rows[i].stored)
            fail_msg("%s: expected %u, got %u", rows[i].title, rows[i].stored, t.device.stored);
    }
}

static void refused_in_whole_objects(void **state)
{
    (void)state;
    static const uint8_t wrong_object[] = {1, 0, 0x08, 1, 0, 0x60};
    static const uint8_t unknown_pdo[] = {1, 0, 0x00, 0x17};
    static const uint8_t twice[] = {2, 0, 0x00, 0x1A, 0x00, 0x1A};
    power_on(false);
    to_preop();
    assert_int_equal(write_sdo(0x1600, 0, true, wrong_object, sizeof wrong_object), 0x06040041);
    assert_int_equal(read_number(0x1600, 1), ECT_MAP(0x7000, 1, 8));
    assert_int_equal(write_sdo(0x1C12, 0, true, unknown_pdo, sizeof unknown_pdo), 0x06020000);
    assert_int_equal(write_sdo(0x1C13, 0, true, twice, sizeof twice), 0x06040043);
    assert_int_equal(read_number(0x1C13, 0) & 0xFF, 0);
    /* Entries that became invalid before they are counted: each is checked when it is written, and again with the
     * count. */
    assert_int_equal(write_number(0x1C12, 0, 0, 1), 0);
    t.device.assign_1c12[0] = 0x1A00;
    assert_int_equal(write_number(0x1C12, 0, 1, 1), 0x06040041);
    assert_int_equal(write_number(0x1C12, 1, 0x1600, 2), 0);
    assert_int_equal(write_number(0x1600, 0, 0, 1), 0);
    for (uint8_t sub = 1; sub <= 4; sub++)
        assert_int_equal(write_number(0x1600, sub, ECT_MAP(0x7000, 3, 32), 4), 0);
    assert_int_equal(write_number(0x1600, 0, 4, 1), 0);
    assert_int_equal(write_number(0x1601, 1, ECT_MAP(0x7000, 1, 8), 4), 0);
    assert_int_equal(write_number(0x1601, 0, 1, 1), 0);
    assert_int_equal(write_number(0x1C12, 2, 0x1601, 2), 0);
    assert_int_equal(write_number(0x1C12, 0, 2, 1), 0x06040042); /* 17 bytes, room is 16 */
}

static void diagnosis_types(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    diagnose(3, 1, 1); /* no such type */
    assert_int_equal(t.device.diagnosis.newest, 0);
    for (uint16_t i = 1; i <= ECT_DIAGNOSIS_MESSAGES; i++)
        diagnose(ECT_DIAGNOSIS_INFO, 1, i);
    assert_int_equal(write_number(0x10F3, 3, 13, 1), 0); /* all acknowledged: overwriting loses nothing */
    for (uint16_t i = 1; i <= ECT_DIAGNOSIS_MESSAGES - 1; i++)
        diagnose(ECT_DIAGNOSIS_INFO, 1, (uint16_t)(100 + i));
    assert_int_equal(read_number(0x10F3, 4) & 0xFF, 1);
    diagnose(ECT_DIAGNOSIS_INFO, 1, 200); /* the slot of the acknowledged one */
    assert_int_equal(t.device.diagnosis.acknowledged, 0);
}

static void sync_next_master(void **state)
{
    (void)state;
    power_on(false);
    to_preop();
    t.activation = 1;
    t.cycle_ns = 1000000;
    to_op(1, 3);
    assert_int_equal(request(ECT_STATE_INIT), ECT_STATE_INIT);
    t.activation = 0;
    t.counter = 0;
    to_preop();
    to_op(1, 3);
    uint8_t output[1] = {0};
    for (int i = 0; i < 10; i++)
        datagram(FPWR, confdev.sm[2].start, output, 1);
    assert_int_equal(t.device.sync.cycle_exceeded, 0); /* no cycle is monitored now, none is exceeded */
    assert_int_equal(read_number(0x1C32, 2), 0);
}

static void diagnosis_wraps(void **state)
{
    static const uint16_t modes[] = {0, ECT_DIAGNOSIS_ACKNOWLEDGE};
    (void)state;
    for (size_t m = 0; m < 2; m++) {
        power_on(false);
        to_preop();
        assert_int_equal(write_number(0x10F3, 5, modes[m], 2), 0);
        for (uint16_t i = 1; i <= 3 * ECT_DIAGNOSIS_MESSAGES; i++) {
            diagnose(ECT_DIAGNOSIS_INFO, 1, i);
            uint8_t newest = t.device.diagnosis.newest;
            assert_int_equal(ect_load_le16(t.device.diagnosis.messages[newest - 6] + 6), i);
            assert_int_equal(write_number(0x10F3, 3, newest, 1), 0);
            assert_int_equal(t.device.diagnosis.flags & ECT_DIAGNOSIS_LOST, 0);
        }
    }
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    const struct CMUnitTest tests[] = {
        TEST("CF-074: the remap procedure changes the expected SM length and the real image", remap_changes_image),
        TEST("CF-073 CF-074: a whole mapping by Complete Access", remap_by_complete_access),
        TEST("CF-074 FZM-014: invalid entries are refused, the old mapping stays", refused_mappings),
        TEST("CF-074: PDOs of the wrong direction, unknown PDOs and duplicates are refused", refused_assignments),
        TEST("CF-075: a mapping longer than the SyncManager's memory is refused with 06040042", too_long_mapping),
        TEST("CF-074 CF-078: mapping and assignment change in PREOP only", only_in_preop),
        TEST("CF-080: a message is in 10F3h with code, flags, text id, time and parameters", diagnosis_message),
        TEST("CF-080: overwrite mode keeps the newest messages; 0 to sub-index 3 clears", diagnosis_overwrites),
        TEST("CF-080: acknowledge mode keeps messages that are not acknowledged", diagnosis_acknowledge_mode),
        TEST("CF-080: acknowledge mode keeps the messages before its selection", diagnosis_mode_changes),
        TEST("CF-080: each type can be switched off; impossible values are refused", diagnosis_filters),
        TEST("CF-079 CF-080: with the flag set each message sends an emergency", diagnosis_emergency),
        TEST("CF-080: the error code of the emergency is that of the diagnosis code, else device specific",
             diagnosis_emergency_codes),
        TEST("CF-081: stored values are kept over power-off, others are not, restore sets the defaults",
             stored_survives),
        TEST("CF-081: a wrong signature, or no storage, is refused with 08000020", wrong_signature),
        TEST("CF-081: a power failure at any write leaves the old record or the new one", power_cut),
        TEST("CF-081: banks alternate; a damaged byte is detected", many_stores),
        TEST("CF-082: 1C32h shows the supported types and refuses the others", sync_types),
        TEST("CF-092: SYNC0 cycles that are not supported are refused with 0x0036", sync_cycles),
        TEST("CF-082 CF-092: the abilities of a device decide type and cycle times", sync_abilities),
        TEST("CF-043: missing SYNC0 pulses end OP with 0x002C", sync_lost),
        TEST("CF-043: so do pulses that have ended in SAFEOP", sync_lost_early),
        TEST("CF-082: a SYNC0 event that is read several times counts once", sync_level),
        TEST("CF-082: SYNC0 is in the AL event mask of a device that runs by it, and of no other", sync_event_mask),
        TEST("CF-022: outputs of a SyncManager without an event are applied after each write, once",
             outputs_without_event),
        TEST("CF-082: limit 0 never leaves OP, counters saturate", sync_limit_off),
        TEST("CF-092: a read that fails at the transition to SAFEOP is repeated", sync_read_fails),
        TEST("CF-067: services without their objects have no effect", services_without_objects),
        TEST("CF-081: a medium that does not respond", medium_does_not_answer),
        TEST("CF-081: a medium that is too small is refused", medium_too_small),
        TEST("CF-081: a record of another firmware is ignored", record_of_another_firmware),
        TEST("CF-081: a request of the device stores once, at the next poll", stored_by_the_device),
        TEST("CF-081: a record is read up to an entry that ends behind it", entries_of_a_record),
        TEST("CF-073 CF-074: whole objects and counts are checked like single entries", refused_in_whole_objects),
        TEST("CF-080: unknown types, and overwriting of acknowledged messages", diagnosis_types),
        TEST("CF-082: the next master runs without SYNC0, and is not checked against the SYNC0 of the previous one",
             sync_next_master),
        TEST("CF-043: the SYNC0 of an earlier OP is not missed in the next one", sync_again),
        TEST("CF-080: acknowledged messages are overwritten without loss, in both modes", diagnosis_wraps),
        TEST("CF-043 CF-082: missed and doubled events are counted; too many leave OP with 0x001A", sync_missed),
    };
    return cmocka_run_group_tests_name("object services", tests, NULL, NULL);
}
