/* SPDX-License-Identifier: MIT */
/* The registers of the ESC except SII, FMMU, SyncManager and watchdog behaviour: reset values, access rights of both
 * sides, effects of reads and writes (data sheet II sections 2.1 to 2.8). */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "esc/route.h"
#include "support/wire.h"

enum { RAM_KB = 8, MEMORY = 0x1000 + RAM_KB * 1024, DATA = 10 };

typedef struct rig {
    ect_esc_personality_t personality;
    uint8_t memory[MEMORY];
    uint8_t sii[64];
    ect_esc_config_t config;
    ect_esc_t esc;
    wire_t w;
} rig_t;

static uint8_t crc8(const uint8_t *bytes, unsigned int count)
{
    unsigned int crc = 0xFF;
    for (unsigned int bit = 0; bit < count * 8; bit++) {
        unsigned int in = ((unsigned int)bytes[bit / 8] >> (7 - bit % 8)) & 1u;
        crc = ((crc << 1) & 0xFF) ^ (((crc >> 7) ^ in) != 0 ? 0x07u : 0u);
    }
    return (uint8_t)crc;
}

/* Words 0 to 6: PDI control, configuration, pulse length, extended, alias, A5, A6. */
static void make_sii(rig_t *r)
{
    static const uint8_t words[14] = {0x05, 0x0C, 0x03, 0x88, 0xE8, 0x03, 0x41,
                                      0x42, 0x34, 0x12, 0x51, 0x52, 0x61, 0x62};
    memset(r->sii, 0, sizeof r->sii);
    memcpy(r->sii, words, sizeof words);
    r->sii[14] = crc8(r->sii, 14);
}

static void power_on(rig_t *r)
{
    assert_int_equal(ect_esc_init(&r->esc, &r->config, r->w.now_ns), 0);
}

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->personality = *ect_esc_personality("et1100");
    r->personality.features = 0; /* clocks, and the features of other chips, have tests of their own */
    r->personality.units = ECT_UNIT_LED_RUN | ECT_UNIT_LED_ERR;
    r->w.now_ns = 1000;
    make_sii(r);
    r->config = (ect_esc_config_t){
        .personality = &r->personality, .memory = r->memory, .sii = r->sii, .sii_size = sizeof r->sii, .open_ports = 1};
    power_on(r);
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    free(*state);
    return 0;
}

/* Sends one datagram by position and returns its data. */
static unsigned int send(rig_t *r, uint8_t command, uint16_t ado, void *data, uint16_t length)
{
    wire_build(&r->w, command, 0, ado, data, length);
    assert_int_equal(ect_esc_process(&r->esc, r->w.frame, r->w.frame_length, r->w.now_ns), ECT_FRAME_FORWARD);
    memcpy(data, wire_datagram(&r->w, 0) + DATA, length);
    return wire_wkc(&r->w, 0);
}

static unsigned int ecat_write(rig_t *r, uint16_t ado, uint8_t value)
{
    return send(r, APWR, ado, &value, 1);
}

static uint8_t ecat_read(rig_t *r, uint16_t ado)
{
    uint8_t value = 0;
    assert_int_equal(send(r, APRD, ado, &value, 1), 1);
    return value;
}

static uint8_t pdi_read(rig_t *r, uint16_t address)
{
    uint8_t value = 0;
    assert_int_equal(ect_esc_pdi_read(&r->esc, address, &value, 1), 0);
    return value;
}

static void pdi_write(rig_t *r, uint16_t address, uint8_t value)
{
    assert_int_equal(ect_esc_pdi_write(&r->esc, address, &value, 1), 0);
}

static uint16_t ecat_event(const rig_t *r)
{
    return ect_load_le16(r->memory + ECT_REG_ECAT_EVENT);
}

static void identity(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *name;
        uint8_t type, fmmus, sms, ram_kb;
    } rows[] = {
        {"et1100", 0x11, 8, 8, 8}, {"lan9252", 0xC0, 3, 4, 4}, {"np40", 0x05, 4, 4, 16}, {"ipcore", 0x04, 8, 8, 60}};
    static uint8_t memory[0x1000 + 60 * 1024];
    assert_null(ect_esc_personality("no such chip"));
    assert_null(ect_esc_personality(""));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_esc_personality_t *p = ect_esc_personality(rows[i].name);
        assert_non_null(p);
        const uint8_t want[10] = {
            p->type,     p->revision,    (uint8_t)p->build, (uint8_t)(p->build >> 8), rows[i].fmmus,
            rows[i].sms, rows[i].ram_kb, p->port_types,     (uint8_t)p->features,     (uint8_t)(p->features >> 8)};
        assert_int_equal(p->type, rows[i].type);
        r->config.personality = p;
        r->config.memory = memory;
        power_on(r);
        uint8_t got[10] = {0};
        assert_int_equal(send(r, APRD, 0, got, 10), 1);
        assert_memory_equal(got, want, 10);
        uint8_t other[10] = {0x5A, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A};
        ect_esc_pdi_write(&r->esc, 0, other, 10);
        assert_int_equal(send(r, APWR, 0, other, 10), 0);
        assert_int_equal(ect_esc_pdi_read(&r->esc, 0, got, 10), 0);
        assert_memory_equal(got, want, 10);
    }
}

/* All values that are not 0 after power-on, transcribed from data sheet II. SII words as in make_sii. */
static const struct {
    uint16_t address;
    uint8_t size;
    uint32_t value;
} reset_values[] = {
    {0x0012, 2, 0x1234}, {0x0100, 4, 0x00070001}, {0x0120, 2, 1},      {0x0130, 2, 1},      {0x0140, 2, 0x0C05},
    {0x0142, 2, 0x5251}, {0x0144, 2, 0x6261},     {0x0150, 2, 0x8803}, {0x0152, 2, 0x4241}, {0x0204, 4, 0x00FFFF0F},
    {0x0400, 2, 0x09C2}, {0x0410, 2, 0x03E8},     {0x0420, 2, 0x03E8}, {0x0440, 2, 0},      {0x0805, 1, 0x30},
    {0x080D, 1, 0x30},   {0x0815, 1, 0x30},       {0x083D, 1, 0x30},   {0x0220, 4, 0},      {0x0210, 2, 0},
    {0x0502, 1, 0x40},   {0x0138, 2, 0},          {0x0200, 2, 0},      {0x0108, 2, 0},      {0x0010, 2, 0},
};

static void reset_state(void **state)
{
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof reset_values / sizeof reset_values[0]; i++) {
        uint8_t b[4] = {0};
        assert_int_equal(send(r, APRD, reset_values[i].address, b, reset_values[i].size), 1);
        if (ect_load_le32(b) != reset_values[i].value)
            fail_msg("0x%04X: expected 0x%X, got 0x%X", reset_values[i].address, reset_values[i].value,
                     ect_load_le32(b));
    }
    /* Addresses between the blocks, which the data sheet does not name, read 0. */
    static const uint16_t zero[][2] = {{0x000A, 0x000F}, {0x0014, 0x001F}, {0x0042, 0x00FF}, {0x0104, 0x0107},
                                       {0x0112, 0x011F}, {0x0122, 0x012F}, {0x0300, 0x03FF}, {0x0440, 0x04FF},
                                       {0x0600, 0x07FF}, {0x0840, 0x08FF}};
    for (size_t i = 0; i < sizeof zero / sizeof zero[0]; i++) {
        for (uint16_t a = zero[i][0]; a <= zero[i][1]; a++) {
            if (ecat_read(r, a) != 0)
                fail_msg("0x%04X: expected 0, got 0x%02X", a, r->memory[a]);
        }
    }
}

/* Write access: e ECAT, p PDI, b both, ? not defined by the data sheet for this chip. Addresses without a row:
 * neither. */
static const struct {
    uint16_t first, last;
    char writer;
} rights[] = {
    {0x0010, 0x0011, 'e'}, {0x0012, 0x0013, 'p'}, {0x0020, 0x0021, '?'}, {0x0030, 0x0031, '?'}, {0x0040, 0x0041, '?'},
    {0x0100, 0x0103, 'e'}, {0x0108, 0x0109, 'e'}, {0x0120, 0x0121, 'e'}, {0x0130, 0x0131, 'p'}, {0x0134, 0x0135, 'p'},
    {0x0138, 0x0139, 'b'}, {0x0200, 0x0201, 'e'}, {0x0204, 0x0207, 'p'}, {0x0300, 0x030D, 'e'}, {0x030E, 0x030E, '?'},
    {0x0310, 0x0313, 'e'}, {0x0400, 0x0401, 'e'}, {0x0410, 0x0411, 'e'}, {0x0420, 0x0421, 'e'}, {0x0442, 0x0443, 'e'},
    {0x0444, 0x0444, '?'}, {0x0500, 0x0500, 'e'}, {0x0502, 0x050F, 'e'}, {0x0510, 0x051B, '?'}, {0x0900, 0x0903, 'e'},
    {0x0E00, 0x0EFF, '?'}, {0x0F00, 0x0F03, 'e'}, {0x0F10, 0x0F1F, '?'}, {0x0F80, 0x0FFF, 'b'},
};

static char right(uint16_t a)
{
    if (a >= 0x0600 && a < 0x0680)
        return a % 16 <= 12 ? 'e' : '-';
    if (a >= 0x0800 && a < 0x0840)
        return a % 8 == 7 ? 'p' : a % 8 == 5 ? '-' : 'e';
    for (size_t i = 0; i < sizeof rights / sizeof rights[0]; i++) {
        if (a >= rights[i].first && a <= rights[i].last)
            return rights[i].writer;
    }
    return '-';
}

static void access_rights(void **state)
{
    rig_t *r = *state;
    static uint8_t before[MEMORY];
    for (uint16_t a = 0; a < 0x1000; a++) {
        char writer = right(a);
        if (writer == '?')
            continue;
        power_on(r);
        memcpy(before, r->memory, MEMORY);
        unsigned int wkc = ecat_write(r, a, (uint8_t)~before[a]);
        bool allowed = writer == 'e' || writer == 'b';
        if (wkc != (allowed ? 1 : 0) || (!allowed && memcmp(before, r->memory, MEMORY) != 0))
            fail_msg("ECAT write to 0x%04X: expected WKC %d, got %u", a, allowed, wkc);
        power_on(r);
        pdi_write(r, a, (uint8_t)~before[a]);
        allowed = writer == 'p' || writer == 'b';
        bool changed = memcmp(before, r->memory, MEMORY) != 0;
        if (changed != allowed)
            fail_msg("PDI write to 0x%04X: expected allowed %d, got %d", a, allowed, changed);
    }
}

static void plain_registers(void **state)
{
    rig_t *r = *state;
    static const struct {
        uint16_t address, length;
        char side;
    } rows[] = {{0x0010, 2, 'e'}, {0x0108, 2, 'e'},   {0x0200, 2, 'e'},  {0x0400, 2, 'e'}, {0x0410, 2, 'e'},
                {0x0420, 2, 'e'}, {0x0F00, 4, 'e'},   {0x0012, 2, 'p'},  {0x0134, 2, 'p'}, {0x0204, 4, 'p'},
                {0x0130, 2, 'p'}, {0x0F80, 128, 'e'}, {0x0F80, 128, 'p'}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[128], got[128] = {0};
        for (unsigned int k = 0; k < sizeof data; k++)
            data[k] = (uint8_t)(0xA5 + 3 * k + i);
        if (rows[i].side == 'e')
            assert_int_equal(send(r, APWR, rows[i].address, data, rows[i].length), 1);
        else
            ect_esc_pdi_write(&r->esc, rows[i].address, data, rows[i].length);
        assert_int_equal(send(r, APRD, rows[i].address, got, rows[i].length), 1);
        if (memcmp(got, data, rows[i].length) != 0)
            fail_msg("0x%04X: does not read back over ECAT", rows[i].address);
        ect_esc_pdi_read(&r->esc, rows[i].address, got, rows[i].length);
        if (memcmp(got, data, rows[i].length) != 0)
            fail_msg("0x%04X: does not read back over the PDI", rows[i].address);
    }
}

static void ranges(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *what;
        uint8_t command;
        uint16_t address, length;
        unsigned int wkc;
    } rows[] = {
        {"all FMMUs and beyond", BWR, 0x0600, 256, 1},
        {"all SMs and beyond", BWR, 0x0800, 256, 1},
        {"reserved bytes of an FMMU", BWR, 0x060D, 3, 0},
        {"reserved bytes of an FMMU and the next one", BWR, 0x060D, 4, 1},
        {"FMMU 3 of 3", BWR, 0x0620, 16, 1},
        {"absent FMMU", BWR, 0x0630, 16, 0},
        {"SM 3 of 4", BWR, 0x0818, 8, 1},
        {"absent SM", BWR, 0x0820, 8, 0},
        {"status byte of an SM", BWR, 0x0805, 1, 0},
        {"read-only block", BWR, 0x0000, 16, 0},
        {"read-only block and one byte more", BWR, 0x0000, 17, 1},
        {"reserved only", BWR, 0x0014, 12, 0},
        {"receive times", BWR, 0x0900, 4, 1},
        {"receive times of ports 1 to 3", BWR, 0x0904, 12, 0},
        {"absent clock, whole", BWR, 0x0910, 32, 0},
        {"absent clock, difference", BWR, 0x092C, 4, 0},
        {"absent clock, activation", BWR, 0x0981, 1, 0},
        {"read receive times", BRD, 0x0900, 16, 1},
        {"read receive times and clock", BRD, 0x0900, 32, 1},
        {"read last receive byte and clock", BRD, 0x090F, 2, 1},
        {"read absent clock", BRD, 0x0910, 32, 0},
        {"read absent clock, last byte", BRD, 0x09FF, 1, 0},
        {"read from the clock beyond it", BRD, 0x09FF, 2, 1},
        {"read over the whole clock", BRD, 0x0900, 0x200, 1},
        {"read behind the clock", BRD, 0x0A00, 4, 1},
        {"read reserved", BRD, 0x0070, 4, 1},
        {"read absent FMMU", BRD, 0x0630, 4, 1},
        {"read last RAM byte", BRD, 0x1FFF, 1, 1},
        {"read over the end of RAM", BRD, 0x1FFF, 2, 1},
        {"read beyond RAM", BRD, 0x2000, 1, 0},
        {"write over the end of RAM", BWR, 0x1FFF, 2, 1},
        {"write beyond RAM", BWR, 0x2000, 1, 0},
        {"last address", BRD, 0xFFFF, 1, 0},
        {"over the last address", BRD, 0xFFFF, 20, 0},
        {"write over the last address", BWR, 0xFFFF, 20, 0},
        {"from the registers into RAM", BWR, 0x0FF0, 32, 1},
        {"from read-only registers into RAM", BWR, 0x0F20, 0x200, 1},
        {"all there is", BRD, 0x0000, 1400, 1},
    };
    r->personality.fmmu_count = 3;
    r->personality.sm_count = 4;
    r->personality.ram_kb = 4;
    power_on(r);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[1486] = {0};
        unsigned int wkc = send(r, rows[i].command, rows[i].address, data, rows[i].length);
        if (wkc != rows[i].wkc)
            fail_msg("%s (0x%04X, %u bytes): expected WKC %u, got %u", rows[i].what, rows[i].address, rows[i].length,
                     rows[i].wkc, wkc);
    }
}

static void absent_leaves_data(void **state)
{
    rig_t *r = *state;
    uint8_t data[32];
    memset(data, 0x5A, sizeof data);
    assert_int_equal(send(r, APRD, 0x0910, data, 32), 0);
    for (unsigned int i = 0; i < 32; i++)
        assert_int_equal(data[i], 0x5A);
    r->memory[MEMORY - 1] = 0x77;
    assert_int_equal(send(r, APRD, MEMORY - 1, data, 2), 1);
    assert_int_equal(data[0], 0x77);
    assert_int_equal(data[1], 0x5A);
    /* The PDI reads 0 there. */
    memset(data, 0x5A, sizeof data);
    ect_esc_pdi_read(&r->esc, MEMORY - 1, data, 32);
    assert_int_equal(data[0], 0x77);
    for (unsigned int i = 1; i < 32; i++)
        assert_int_equal(data[i], 0);
}

static void with_clock_feature(void **state)
{
    rig_t *r = *state;
    uint8_t data[8] = {0};
    r->personality.features = ECT_FEATURE_DC;
    power_on(r);
    assert_int_equal(send(r, APRD, 0x0910, data, 8), 1);
    assert_int_equal(send(r, APRD, 0x0982, data, 2), 1);
    assert_int_equal(ect_load_le16(data), 0x03E8);
    assert_int_equal(send(r, APWR, 0x0982, data, 2), 0);
}

static void al_control_lock(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *what;
        char side;
        uint16_t address, length;
        bool releases;
    } rows[] = {
        {"PDI reads both bytes", 'p', 0x0120, 2, true},    {"PDI reads the low byte", 'p', 0x0120, 1, true},
        {"PDI reads the high byte", 'p', 0x0121, 1, true}, {"PDI reads across", 'p', 0x0110, 0x20, true},
        {"PDI reads before", 'p', 0x011C, 4, false},       {"PDI reads behind", 'p', 0x0122, 4, false},
        {"PDI reads the event", 'p', 0x0220, 4, false},    {"ECAT reads it", 'e', 0x0120, 2, false},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t request[2] = {0x02, 0}, second[2] = {0x04, 0}, data[64] = {0};
        power_on(r);
        uint32_t activity = ect_esc_activity(&r->esc);
        assert_int_equal(send(r, APWR, 0x0120, request, 2), 1);
        assert_int_not_equal(ect_esc_activity(&r->esc), activity);
        assert_int_equal(ect_esc_al_event(&r->esc), ECT_EVENT_AL_CONTROL);
        assert_int_equal(send(r, APWR, 0x0120, second, 2), 0);
        assert_int_equal(ecat_write(r, 0x0120, 8), 0);
        assert_int_equal(ecat_write(r, 0x0121, 8), 0);
        assert_int_equal(ecat_read(r, 0x0120), 2);
        if (rows[i].side == 'p')
            ect_esc_pdi_read(&r->esc, rows[i].address, data, rows[i].length);
        else
            send(r, APRD, rows[i].address, data, rows[i].length);
        bool event = (ect_esc_al_event(&r->esc) & ECT_EVENT_AL_CONTROL) != 0;
        unsigned int wkc = send(r, APWR, 0x0120, second, 2);
        if (wkc != (rows[i].releases ? 1 : 0) || event == rows[i].releases || ecat_read(r, 0x0120) != (wkc ? 4 : 2))
            fail_msg("%s: expected released %d, got WKC %u, event %d", rows[i].what, rows[i].releases, wkc, event);
    }
}

/* A fault of the twin: one event goes unnoticed, the next does not. */
static void al_event_lost(void **state)
{
    rig_t *r = *state;
    ect_esc_lose_al_event(&r->esc);
    for (unsigned int i = 0; i < 3; i++) {
        uint8_t control[2];
        assert_int_equal(ecat_write(r, 0x0120, 2), 1);
        assert_int_equal(ect_esc_al_event(&r->esc) & ECT_EVENT_AL_CONTROL, i == 0 ? 0 : ECT_EVENT_AL_CONTROL);
        ect_esc_pdi_read(&r->esc, 0x0120, control, 2);
    }
}

static void emulation(void **state)
{
    rig_t *r = *state;
    static const uint8_t values[] = {0x11, 0x02, 0x12, 0x04, 0x08, 0x01};
    r->sii[1] |= 0x01;
    r->sii[14] = crc8(r->sii, 14);
    power_on(r);
    for (size_t i = 0; i < sizeof values; i++) {
        uint8_t request[2] = {values[i], 0};
        uint32_t routing = ect_esc_routing(&r->esc);
        assert_int_equal(send(r, APWR, 0x0120, request, 2), 1);
        assert_int_not_equal(ect_esc_routing(&r->esc), routing);
        assert_int_equal(ecat_read(r, 0x0130), values[i]);
        assert_int_equal(ect_esc_al_event(&r->esc), 0);
        pdi_write(r, 0x0130, 0x0F);
        assert_int_equal(ecat_read(r, 0x0130), values[i]);
    }
}

/* The lock of a request that was not read ends when a reload switches emulation on. */
static void emulation_unlocks(void **state)
{
    rig_t *r = *state;
    uint8_t request[2] = {0x02, 0}, reload[2] = {0x00, 0x04};
    assert_int_equal(send(r, APWR, 0x0120, request, 2), 1);
    assert_int_equal(send(r, APWR, 0x0120, request, 2), 0);
    r->sii[1] |= 0x01;
    r->sii[14] = crc8(r->sii, 14);
    assert_int_equal(send(r, APWR, 0x0502, reload, 2), 1);
    assert_int_equal(send(r, APWR, 0x0120, request, 2), 1);
    assert_int_equal(ecat_read(r, 0x0130), 2);
}

static void al_status_event(void **state)
{
    rig_t *r = *state;
    static const struct {
        char side;
        uint16_t address, length;
        bool clears;
    } rows[] = {{'e', 0x0130, 2, true},  {'e', 0x0130, 1, true},  {'e', 0x0131, 1, true},
                {'e', 0x0130, 6, true},  {'e', 0x012F, 1, false}, {'e', 0x0132, 1, false},
                {'e', 0x0134, 2, false}, {'p', 0x0130, 2, false}, {'e', 0x0210, 2, false}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[8] = {0};
        pdi_write(r, 0x0130, 0x02);
        assert_int_equal(ecat_event(r), ECT_ECAT_EVENT_AL_STATUS);
        if (rows[i].side == 'e')
            send(r, APRD, rows[i].address, data, rows[i].length);
        else
            ect_esc_pdi_read(&r->esc, rows[i].address, data, rows[i].length);
        if (ecat_event(r) != (rows[i].clears ? 0 : ECT_ECAT_EVENT_AL_STATUS))
            fail_msg("%c reads 0x%04X, %u bytes: event 0x0210 is 0x%04X", rows[i].side, rows[i].address, rows[i].length,
                     ecat_event(r));
    }
    uint8_t status[2] = {0x12, 0};
    ect_esc_pdi_write(&r->esc, 0x0134, "\x1B", 1);
    assert_int_equal(send(r, APWR, 0x0130, status, 2), 0);
    assert_int_equal(send(r, APWR, 0x0134, status, 2), 0);
    assert_int_equal(ecat_read(r, 0x0130), 0x02);
    assert_int_equal(ecat_read(r, 0x0134), 0x1B);
}

static void dl_status_event(void **state)
{
    rig_t *r = *state;
    static const struct {
        char side;
        uint16_t address, length;
        bool clears;
    } rows[] = {{'e', 0x0110, 2, true},  {'e', 0x0110, 1, true},  {'e', 0x0111, 1, true}, {'e', 0x0100, 17, true},
                {'e', 0x0112, 1, false}, {'e', 0x010F, 1, false}, {'p', 0x0110, 2, false}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[32] = {0};
        ect_store_le16(r->memory + ECT_REG_ECAT_EVENT, ECT_ECAT_EVENT_DL_STATUS);
        if (rows[i].side == 'e')
            send(r, APRD, rows[i].address, data, rows[i].length);
        else
            ect_esc_pdi_read(&r->esc, rows[i].address, data, rows[i].length);
        if (ecat_event(r) != (rows[i].clears ? 0 : ECT_ECAT_EVENT_DL_STATUS))
            fail_msg("%c reads 0x%04X: event 0x0210 is 0x%04X", rows[i].side, rows[i].address, ecat_event(r));
    }
}

/* A reload with a wrong check value clears DL status bit 0. */
static void dl_status_change(void **state)
{
    rig_t *r = *state;
    uint8_t reload[2] = {0x00, 0x04};
    assert_int_equal(ecat_read(r, 0x0110) & 1, 1);
    r->sii[0] ^= 0x80;
    assert_int_equal(send(r, APWR, 0x0502, reload, 2), 1);
    assert_int_equal(r->memory[0x0110] & 1, 0);
    if ((ecat_event(r) & ECT_ECAT_EVENT_DL_STATUS) == 0)
        fail_msg("DL status changed, event request 0x0210 is 0x%04X: expected bit 2 set", ecat_event(r));
}

static void dl_status_same(void **state)
{
    rig_t *r = *state;
    uint8_t control[4];
    memcpy(control, r->memory + ECT_REG_DL_CONTROL, sizeof control);
    ect_store_le16(r->memory + ECT_REG_ECAT_EVENT, 0);
    assert_int_equal(send(r, APWR, ECT_REG_DL_CONTROL, control, sizeof control), 1);
    assert_int_equal(ecat_event(r) & ECT_ECAT_EVENT_DL_STATUS, 0);
}

static void sm_changed_event(void **state)
{
    rig_t *r = *state;
    for (unsigned int n = 0; n < 8; n++) {
        uint16_t sm = (uint16_t)(0x0800 + 8 * n);
        for (unsigned int enable = 2; enable-- > 0;) {
            assert_int_equal(ecat_write(r, (uint16_t)(sm + 6), (uint8_t)enable), 1);
            assert_int_equal(ect_esc_al_event(&r->esc), ECT_EVENT_SM_CHANGED);
            (void)ecat_read(r, (uint16_t)(sm + 6));
            for (uint16_t at = 0; at < 8; at++) {
                if (at != 6)
                    (void)pdi_read(r, (uint16_t)(sm + at));
            }
            assert_int_equal(ect_esc_al_event(&r->esc), ECT_EVENT_SM_CHANGED);
            (void)pdi_read(r, (uint16_t)(sm + 6));
            if (ect_esc_al_event(&r->esc) != 0)
                fail_msg("SM%u: the PDI's read of the activate register is to clear the event", n);
        }
    }
    /* In a longer access, from any byte on. */
    for (uint16_t first = 0x0800; first < 0x0808; first++) {
        for (uint16_t length = 1; length <= 16; length++) {
            uint8_t data[16];
            ecat_write(r, 0x0806, (uint8_t)(r->memory[0x0806] ^ 1));
            ecat_write(r, 0x080E, (uint8_t)(r->memory[0x080E] ^ 1));
            ect_esc_pdi_read(&r->esc, first, data, length);
            bool both = first <= 0x0806 && first + length > 0x080E;
            bool none = first + length <= 0x0806 || (first > 0x0806 && first + length <= 0x080E);
            bool event = ect_esc_al_event(&r->esc) != 0;
            if ((both && event) || (none && !event))
                fail_msg("PDI reads 0x%04X, %u bytes: event %d", first, length, event);
            ect_esc_pdi_read(&r->esc, 0x0800, data, 16);
        }
    }
}

static void sm_changed_each(void **state)
{
    rig_t *r = *state;
    ecat_write(r, 0x0806, 1);
    ecat_write(r, 0x081E, 1);
    (void)pdi_read(r, 0x0806);
    if (ect_esc_al_event(&r->esc) != ECT_EVENT_SM_CHANGED)
        fail_msg("SM0 and SM3 changed, the PDI read SM0's activate register only: expected the event still set");
    (void)pdi_read(r, 0x081E);
    assert_int_equal(ect_esc_al_event(&r->esc), 0);
}

static void masks_do_not_touch_requests(void **state)
{
    rig_t *r = *state;
    static const uint8_t none[4] = {0};
    ect_esc_pdi_write(&r->esc, 0x0204, none, 4);
    assert_int_equal(ecat_write(r, 0x0120, 2), 1);
    pdi_write(r, 0x0130, 2);
    assert_int_equal(pdi_read(r, 0x0220), ECT_EVENT_AL_CONTROL);
    assert_int_equal(pdi_read(r, 0x0220), ECT_EVENT_AL_CONTROL);
    assert_int_equal(ecat_read(r, 0x0210), ECT_ECAT_EVENT_AL_STATUS);
    assert_int_equal(ecat_read(r, 0x0220), ECT_EVENT_AL_CONTROL);
}

/* Counters by group: a write to any of `first..last` clears all of them, and no other group. */
static void counters(void **state)
{
    rig_t *r = *state;
    static const uint16_t groups[][2] = {
        {0x0300, 0x030B}, {0x030C, 0x030C}, {0x030D, 0x030D}, {0x0310, 0x0313}, {0x0442, 0x0443}};
    enum { GROUPS = sizeof groups / sizeof groups[0] };
    for (size_t g = 0; g < GROUPS; g++) {
        for (uint16_t a = groups[g][0]; a <= groups[g][1]; a++) {
            for (size_t k = 0; k < GROUPS; k++)
                memset(r->memory + groups[k][0], 0x21, (size_t)(groups[k][1] - groups[k][0]) + 1);
            for (uint16_t i = groups[g][0]; i <= groups[g][1]; i++)
                assert_int_equal(pdi_read(r, i), 0x21);
            pdi_write(r, a, 0);
            assert_int_equal(r->memory[a], 0x21);
            unsigned int wkc = ecat_write(r, a, (uint8_t)(a * 5));
            for (size_t k = 0; k < GROUPS; k++) {
                for (uint16_t i = groups[k][0]; i <= groups[k][1]; i++) {
                    if (wkc != 1 || r->memory[i] != (k == g ? 0 : 0x21))
                        fail_msg("write to 0x%04X: WKC %u, 0x%04X is 0x%02X", a, wkc, i, r->memory[i]);
                }
            }
        }
    }
}

static void watchdog_counter_of_pdi1(void **state)
{
    rig_t *r = *state;
    memset(r->memory + 0x0441, 0x21, 5);
    unsigned int wkc = ecat_write(r, 0x0444, 0);
    if (wkc != 1 || r->memory[0x0442] != 0 || r->memory[0x0443] != 0 || r->memory[0x0444] != 0)
        fail_msg("write to 0x0444: expected WKC 1 and 0x0442..0x0444 at 0, got WKC %u, 0x0442 0x%02X", wkc,
                 r->memory[0x0442]);
    assert_int_equal(r->memory[0x0441], 0x21); /* the adjacent registers keep their values */
    assert_int_equal(r->memory[0x0445], 0x21);
}

static void ports(void **state)
{
    rig_t *r = *state;
    static const struct {
        uint8_t open_ports, loops, links;
    } rows[] = {{0x00, 0x56, 0x10}, {0x01, 0x56, 0x10}, {0x03, 0x5A, 0x30}, {0x02, 0x5A, 0x30}, {0x05, 0x66, 0x50},
                {0x07, 0x6A, 0x70}, {0x09, 0x96, 0x90}, {0x0F, 0xAA, 0xF0}, {0xF1, 0x56, 0x10}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        r->config.open_ports = rows[i].open_ports;
        power_on(r);
        uint8_t low = ecat_read(r, 0x0110), high = ecat_read(r, 0x0111);
        if ((low & 0xF1) != (rows[i].links | 1) || high != rows[i].loops)
            fail_msg("open ports 0x%02X: expected DL status 0x%02X, 0x%02X, got 0x%02X, 0x%02X", rows[i].open_ports,
                     rows[i].loops, rows[i].links | 1, high, low);
        assert_int_equal(ecat_write(r, 0x0110, 0), 0);
        assert_int_equal(ecat_write(r, 0x0111, 0), 0);
        pdi_write(r, 0x0111, 0);
        assert_int_equal(ecat_read(r, 0x0111), rows[i].loops);
    }
}

/* DL control 0x0101: two bits for each port, 00 auto, 10 open, 11 closed. Ports 0 and 1 have a link. */
static void forced_loops(void **state)
{
    rig_t *r = *state;
    static const struct {
        uint8_t control, mask, want;
    } rows[] = {
        {0x00, 0xFF, 0x5A}, {0x0C, 0x04, 0x04}, /* port 1 closed: loop bit 10 of DL status */
        {0x00, 0xFF, 0x5A}, {0x20, 0x10, 0x00}, /* port 2 open without a link */
        {0xF0, 0xFF, 0x5A}, {0x08, 0x04, 0x00},
    };
    r->config.open_ports = 3;
    power_on(r);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(ecat_write(r, 0x0101, rows[i].control), 1);
        assert_int_equal(ecat_read(r, 0x0101), rows[i].control);
        uint8_t loops = ecat_read(r, 0x0111);
        if ((loops & rows[i].mask) != rows[i].want)
            fail_msg("row %zu: DL control 0x0101 = 0x%02X: expected 0x0111 & 0x%02X = 0x%02X, got 0x%02X", i,
                     rows[i].control, rows[i].mask, rows[i].want, loops);
    }
}

static void dl_control_bits(void **state)
{
    rig_t *r = *state;
    static const uint8_t all[4] = {0xFF, 0xFF, 0xFF, 0xFF};
    uint8_t data[4];
    memcpy(data, all, 4);
    assert_int_equal(send(r, APWR, 0x0100, data, 4), 1);
    for (unsigned int bit = 0; bit < 32; bit++) {
        bool is = (r->memory[0x0100 + bit / 8] >> (bit % 8) & 1) != 0;
        bool writable = bit < 2 || (bit >= 8 && bit <= 19) || bit == 22 || bit == 24;
        if (bit != 22 && is != writable)
            fail_msg("DL control bit %u: expected writable %d, got %d", bit, writable, is);
    }
    memset(data, 0, 4);
    assert_int_equal(send(r, APWR, 0x0100, data, 4), 1);
    assert_int_equal(ect_load_le32(r->memory + 0x0100), 0);
    memcpy(data, all, 4);
    assert_int_equal(send(r, APWR, 0x0100, data, 4), 1);
    assert_int_equal(ect_load_le32(r->memory + 0x0100), 0x014FFF03);
    memset(data, 0, 4);
    assert_int_equal(send(r, BWR, 0x0103, data, 1), 1);
    assert_int_equal(send(r, BWR, 0x0101, data, 1), 1);
    assert_int_equal(ecat_read(r, 0x0103), 0);
    assert_int_equal(ecat_read(r, 0x0101), 0);
    assert_int_equal(ecat_read(r, 0x0100), 3);
}

static void dl_control_bit_22(void **state)
{
    rig_t *r = *state;
    assert_int_equal(ecat_write(r, 0x0102, 0x47), 1);
    assert_int_equal(ecat_read(r, 0x0102), 0x47);
}

static void run_led(void **state)
{
    rig_t *r = *state;
    assert_int_equal(ecat_write(r, 0x0138, 0x1F), 1);
    pdi_write(r, 0x0130, 0x01); /* no change */
    assert_int_equal(ecat_read(r, 0x0138) & 0x10, 0x10);
    pdi_write(r, 0x0134, 0x11);
    assert_int_equal(ecat_read(r, 0x0138) & 0x10, 0x10);
    pdi_write(r, 0x0130, 0x02);
    assert_int_equal(ecat_read(r, 0x0138) & 0x10, 0);
    pdi_write(r, 0x0139, 0x1D);
    assert_int_equal(ecat_read(r, 0x0139), 0x1D);
}

static void fmmu_bits(void **state)
{
    rig_t *r = *state;
    static const uint8_t want[16] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x07, 0x07,
                                     0xFF, 0xFF, 0x07, 0x03, 0x01, 0x00, 0x00, 0x00};
    for (unsigned int n = 0; n < 8; n++) {
        uint8_t data[16];
        memset(data, 0xFF, sizeof data);
        assert_int_equal(send(r, APWR, (uint16_t)(0x0600 + 16 * n), data, 16), 1);
        assert_int_equal(send(r, APRD, (uint16_t)(0x0600 + 16 * n), data, 16), 1);
        assert_memory_equal(data, want, 16);
    }
}

static void bad_configuration(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *what;
        int member;
        unsigned int value;
        int want;
    } rows[] = {
        {"9 FMMUs", 'f', 9, -1},
        {"9 SyncManagers", 's', 9, -1},
        {"8 and 8", 'f', 8, 0},
        {"no RAM", 'r', 0, -1},
        {"61 KB", 'r', 61, -1},
        {"no personality", 'p', 0, -1},
        {"no memory", 'm', 0, -2},
        {"odd SII", 'o', 63, -3},
        {"SII without content", 'n', 64, -3},
        {"reads of 9 bytes", '9', 9, -1},
        {"content without size", 'o', 0, -3},
        {"no SII", 'n', 0, 0},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esc_personality_t p = *ect_esc_personality("et1100");
        ect_esc_config_t c = r->config;
        uint8_t v = (uint8_t)rows[i].value;
        c.personality = rows[i].member == 'p' ? NULL : &p;
        p.fmmu_count = rows[i].member == 'f' ? v : p.fmmu_count;
        p.sm_count = rows[i].member == 's' ? v : p.sm_count;
        p.ram_kb = rows[i].member == 'r' ? v : p.ram_kb;
        p.sii_read = rows[i].member == '9' ? v : p.sii_read;
        c.memory = rows[i].member == 'm' ? NULL : c.memory;
        c.sii = rows[i].member == 'n' ? NULL : c.sii;
        c.sii_size = rows[i].member == 'n' || rows[i].member == 'o' ? v : c.sii_size;
        int got = ect_esc_init(&r->esc, &c, 0);
        if (got != rows[i].want)
            fail_msg("%s: expected %d, got %d", rows[i].what, rows[i].want, got);
    }
}

static void pdi_extremes(void **state)
{
    rig_t *r = *state;
    static uint8_t big[65535];
    memset(big, 0x5A, sizeof big);
    assert_int_equal(ect_esc_pdi_read(&r->esc, 0x0001, big, 65535), 0);
    assert_memory_equal(big + 0x11, "\x34\x12", 2);
    assert_int_equal(big[0x3000], 0);
    assert_int_equal(big[65534], 0);
    assert_int_equal(ect_esc_pdi_read(&r->esc, 0xFFFF, big, 65535), 0);
    assert_int_equal(ect_esc_pdi_write(&r->esc, 0xFFFF, big, 65535), 0);
    assert_int_equal(ect_esc_pdi_read(&r->esc, 0x0000, big, 0), 0);
    assert_int_equal(ect_esc_pdi_write(&r->esc, 0x0000, big, 0), 0);
    memset(big, 0x33, sizeof big);
    assert_int_equal(ect_esc_pdi_write(&r->esc, 0x0FF0, big, 65535), 0);
    assert_int_equal(r->memory[MEMORY - 1], 0x33);
    assert_int_equal(r->memory[0x0FEF], 0);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-005: DL control that changes nothing raises no DL status event", dl_status_same),
        TEST("CF-001: 0x0000..0x0009 read as in the personality and no side can write them", identity),
        TEST("CF-001 CF-047: after power-on all registers have their reset values, reserved ones read 0", reset_state),
        TEST("CF-009: each register byte is written by the permitted sides: WKC 1, else WKC 0 and no change",
             access_rights),
        TEST("CF-009: plain registers keep the value of the permitted side, and both sides read it", plain_registers),
        TEST("CF-008: ranges across read-only, missing and existing bytes count if one byte exists", ranges),
        TEST("CF-008: missing bytes are unchanged in the frame, the PDI reads 0", absent_leaves_data),
        TEST("CF-001: with the DC feature bit the clock's registers are read, pulse length from the SII",
             with_clock_feature),
        TEST("CF-041: AL control refuses a second write until the PDI has read a byte of it", al_control_lock),
        TEST("CF-041: the event of one write to AL control may be lost, by a requested fault", al_event_lost),
        TEST("CF-045: with device emulation AL control is never locked, AL status mirrors it, no event", emulation),
        TEST("CF-045: emulation switched on by a reload ends the lock of AL control", emulation_unlocks),
        TEST("CF-009: a PDI write of AL status sets ECAT event bit 3, an ECAT read of it clears it", al_status_event),
        TEST("CF-010: an ECAT read of any byte of DL status clears ECAT event bit 2", dl_status_event),
        TEST("CF-010: a change of DL status sets ECAT event bit 2", dl_status_change),
        TEST("CF-021: a change of an activate register sets AL event bit 4, the PDI's read of it clears it",
             sm_changed_event),
        TEST("CF-021: AL event bit 4 stays until the activate register of every changed SM was read", sm_changed_each),
        TEST("CF-009: event masks do not change the requests, reading requests does not clear them",
             masks_do_not_touch_requests),
        TEST("CF-011: a write of any value to any counter of a group clears the group, the PDI cannot", counters),
        TEST("CF-011: a write to 0x0444 clears the watchdog counters 0x0442..0x0444", watchdog_counter_of_pdi1),
        TEST("CF-010: DL status shows links and loops of the ports", ports),
        TEST("CF-010: loops that DL control forces open or closed show in DL status", forced_loops),
        TEST("CF-010: DL control accepts its defined bits, byte by byte too", dl_control_bits),
        TEST("CF-010: DL control bit 22 is writable", dl_control_bit_22),
        TEST("CF-093: the override of the RUN LED ends with a change of AL status", run_led),
        TEST("CF-009: an FMMU's registers accept their defined bits", fmmu_bits),
        TEST("CF-001: impossible configurations are refused with the documented number", bad_configuration),
        TEST("CF-008: PDI accesses of any address and length stay inside", pdi_extremes),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC registers", tests, NULL, NULL);
}
