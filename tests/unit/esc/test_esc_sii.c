/* SPDX-License-Identifier: MIT */
/* The SII EEPROM interface at 0x0500..0x050F: commands, busy time, error bits, ownership, and the configuration that
 * the chip loads (data sheet I section 11, II section 2.11). */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "support/wire.h"

enum { RAM_KB = 8, MEMORY = 0x1000 + RAM_KB * 1024, DATA = 10, SII_SIZE = 256, US = 1000 };
enum { CONTROL = 0x0502, ADDRESS = 0x0504, VALUE = 0x0508 };
enum { BUSY = 0x8000, NO_WRITE_ENABLE = 0x4000, NO_ACK = 0x2000, NOT_LOADED = 0x1000, BAD_CHECKSUM = 0x0800 };

typedef struct rig {
    ect_esc_personality_t personality;
    uint8_t *memory;
    uint8_t *sii; /* in its own allocation, so that a sanitizer detects its end */
    ect_esc_config_t config;
    ect_esc_t esc;
    wire_t w;
} rig_t;

static void seal(rig_t *r)
{
    unsigned int crc = 0xFF;
    for (unsigned int bit = 0; bit < 14 * 8; bit++) {
        unsigned int in = ((unsigned int)r->sii[bit / 8] >> (7 - bit % 8)) & 1u;
        crc = ((crc << 1) & 0xFF) ^ (((crc >> 7) ^ in) != 0 ? 0x07u : 0u);
    }
    r->sii[14] = (uint8_t)crc;
    r->sii[15] = 0;
}

static void power_on(rig_t *r)
{
    assert_int_equal(ect_esc_init(&r->esc, &r->config, r->w.now_ns), 0);
}

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->personality = *ect_esc_personality("et1100");
    r->memory = malloc(MEMORY);
    r->sii = malloc(SII_SIZE);
    for (unsigned int i = 0; i < SII_SIZE; i++)
        r->sii[i] = (uint8_t)(i ^ 0xA5);
    memcpy(r->sii, "\x05\x0C\x03\x88\xE8\x03\x41\x42\x34\x12\x51\x52\x61\x62", 14);
    seal(r);
    r->config = (ect_esc_config_t){
        .personality = &r->personality, .memory = r->memory, .sii = r->sii, .sii_size = SII_SIZE, .open_ports = 1};
    r->w.now_ns = 1000;
    power_on(r);
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    free(r->memory);
    free(r->sii);
    free(r);
    return 0;
}

static void process(rig_t *r)
{
    assert_int_equal(ect_esc_process(&r->esc, r->w.frame, r->w.frame_length, r->w.now_ns), ECT_FRAME_FORWARD);
}

static unsigned int send(rig_t *r, uint8_t command, uint16_t ado, void *data, uint16_t length)
{
    wire_build(&r->w, command, 0, ado, data, length);
    process(r);
    memcpy(data, wire_datagram(&r->w, 0) + DATA, length);
    return wire_wkc(&r->w, 0);
}

static unsigned int ecat_write(rig_t *r, uint16_t ado, const void *bytes, uint16_t length)
{
    uint8_t copy[32];
    memcpy(copy, bytes, length);
    return send(r, APWR, ado, copy, length);
}

static uint16_t status(rig_t *r)
{
    uint8_t s[2] = {0};
    assert_int_equal(send(r, APRD, CONTROL, s, 2), 1);
    return ect_load_le16(s);
}

/* The command with its address in one datagram of 6 bytes. */
static unsigned int command(rig_t *r, uint16_t control, uint32_t address)
{
    uint8_t request[6];
    ect_store_le16(request, control);
    ect_store_le32(request + 2, address);
    return ecat_write(r, CONTROL, request, 6);
}

static void expect_status(rig_t *r, const char *what, uint16_t mask, uint16_t want)
{
    uint16_t got = status(r);
    if ((got & mask) != want)
        fail_msg("%s: expected 0x0502 & 0x%04X = 0x%04X, got 0x%04X", what, mask, want, got);
}

/* The words from `address` on, as a read must deliver them. Cells beyond the end are erased. */
static void expect_data(rig_t *r, uint32_t address, unsigned int bytes)
{
    uint8_t got[8] = {0};
    assert_int_equal(send(r, APRD, VALUE, got, 8), 1);
    for (unsigned int i = 0; i < bytes; i++) {
        uint64_t at = (uint64_t)address * 2 + i;
        uint8_t want = at < SII_SIZE ? r->sii[at] : 0xFF;
        if (got[i] != want)
            fail_msg("read of word 0x%X, byte %u: expected 0x%02X, got 0x%02X", address, i, want, got[i]);
    }
}

static const uint32_t addresses[] = {0,    1,    7,    8,      0x40,    0x7C,       0x7D,       0x7E,
                                     0x7F, 0x80, 0x81, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF};

static void read_sizes(void **state)
{
    rig_t *r = *state;
    for (uint8_t size = 4; size <= 8; size = (uint8_t)(size + 4)) {
        r->personality.sii_read = size;
        power_on(r);
        expect_status(r, "bit 6 gives the size of a read", 0xFFFF, size == 8 ? 0x0040 : 0);
        for (size_t i = 0; i < sizeof addresses / sizeof addresses[0]; i++) {
            memset(r->memory + VALUE, 0x3C, 8);
            assert_int_equal(command(r, 0x0100, addresses[i]), 1);
            expect_status(r, "after a read", 0xFFBF, 0);
            expect_data(r, addresses[i], size);
            if (size == 4)
                assert_memory_equal(r->memory + VALUE + 4, "\x3C\x3C\x3C\x3C", 4);
            assert_int_equal(ect_load_le32(r->memory + ADDRESS), addresses[i]);
        }
    }
}

static void address_bytes(void **state)
{
    rig_t *r = *state;
    static uint8_t big[8192];
    static const struct {
        uint32_t size;
        uint16_t bit7;
    } rows[] = {{128, 0}, {2048, 0}, {4094, 0}, {4096, 0x80}, {8192, 0x80}}; /* 4096 bytes are 32 kbit */
    ect_store_le16(big + 14, 0x88A4);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        r->config.sii = big;
        r->config.sii_size = rows[i].size;
        power_on(r);
        expect_status(r, "bit 7: two address bytes", 0x0080, rows[i].bit7);
    }
}

/* Command and address as masters write them. All must read word 8. */
static void access_lengths(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *what;
        uint16_t ado;
        uint8_t bytes[8];
        uint16_t length;
        bool address_before;
    } rows[] = {
        {"6 bytes: command and address", 0x0502, {0x00, 0x01, 8, 0, 0, 0}, 6, false},
        {"4 bytes with bit 7 set: command and low address", 0x0502, {0x80, 0x01, 8, 0}, 4, false},
        {"3 bytes", 0x0502, {0x00, 0x01, 8}, 3, false},
        {"2 bytes, address before", 0x0502, {0x00, 0x01}, 2, true},
        {"1 byte, address before", 0x0503, {0x01}, 1, true},
        {"7 bytes from the high byte on", 0x0503, {0x01, 8, 0, 0, 0, 0, 0}, 7, false},
        {"8 bytes with ownership", 0x0500, {0, 0, 0x00, 0x01, 8, 0, 0, 0}, 8, false},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t address[4] = {rows[i].address_before ? 8 : 0, 0, 0, 0};
        assert_int_equal(ecat_write(r, ADDRESS, address, 4), 1);
        memset(r->memory + VALUE, 0, 8);
        assert_int_equal(ecat_write(r, rows[i].ado, rows[i].bytes, rows[i].length), 1);
        uint8_t got[10] = {0};
        assert_int_equal(send(r, APRD, CONTROL, got, 10), 1);
        if (ect_load_le16(got) != 0x0040 || memcmp(got + 6, r->sii + 16, 4) != 0)
            fail_msg("%s: status 0x%04X, data %02X %02X", rows[i].what, ect_load_le16(got), got[6], got[7]);
    }
    /* Without the high byte of the command, no command starts. */
    memset(r->memory + VALUE, 0, 8);
    assert_int_equal(ecat_write(r, CONTROL, "\x01", 1), 1);
    assert_int_equal(ecat_write(r, ADDRESS, "\x08\x00\x00\x00", 4), 1);
    assert_memory_equal(r->memory + VALUE, "\0\0\0\0", 4);
}

static void busy_read(void **state)
{
    rig_t *r = *state;
    r->config.sii_command_ns = 50 * US;
    power_on(r);
    memset(r->memory + VALUE, 0x3C, 8);
    assert_int_equal(command(r, 0x0100, 8), 1);
    uint64_t done = r->w.now_ns + 50 * US;
    assert_int_equal(ect_esc_tick(&r->esc, r->w.now_ns), done);
    expect_status(r, "right after the command", 0x8700, 0x8100);
    /* While busy, command, address and data cannot be written. */
    assert_int_equal(command(r, 0x0100, 1), 0);
    assert_int_equal(command(r, 0x0000, 1), 0);
    assert_int_equal(ecat_write(r, ADDRESS, "\x01", 1), 0);
    assert_int_equal(ecat_write(r, VALUE, "\x01", 1), 0);
    r->w.now_ns = done - 1;
    expect_status(r, "one nanosecond before the end", 0x8700, 0x8100);
    assert_memory_equal(r->memory + VALUE, "\x3C\x3C\x3C\x3C", 4);
    r->w.now_ns = done;
    expect_status(r, "at the end", 0xFFFF, 0x0040);
    expect_data(r, 8, 8);
    assert_int_equal(ect_esc_tick(&r->esc, r->w.now_ns), UINT64_MAX);
}

static void busy_write(void **state)
{
    rig_t *r = *state;
    r->config.sii_command_ns = 5000 * US;
    power_on(r);
    assert_int_equal(ecat_write(r, VALUE, "\xAB\xCD", 2), 1);
    assert_int_equal(command(r, 0x0201, 0x20), 1);
    expect_status(r, "write running", 0x8700, 0x8200);
    r->w.now_ns += 5000 * US - 1;
    expect_status(r, "one nanosecond before the end", 0x8000, 0x8000);
    r->w.now_ns += 1;
    expect_status(r, "at the end", 0xFF3F, 0);
    assert_memory_equal(r->sii + 0x40, "\xAB\xCD", 2);
    /* The next one. */
    assert_int_equal(ecat_write(r, VALUE, "\x12\x34", 2), 1);
    assert_int_equal(command(r, 0x0201, 0x21), 1);
    r->w.now_ns += 5000 * US;
    expect_status(r, "second write", 0xFF3F, 0);
    assert_memory_equal(r->sii + 0x40, "\xAB\xCD\x12\x34", 4);
}

/* A PDI access waits for the end of a write or the watchdog (100 ms), whichever is earlier. */
static void next_deadline(void **state)
{
    rig_t *r = *state;
    static const uint32_t times_ms[] = {50, 99, 101, 200};
    for (size_t i = 0; i < sizeof times_ms / sizeof times_ms[0]; i++) {
        uint64_t time = times_ms[i] * MS;
        r->config.sii_command_ns = (uint32_t)time;
        power_on(r);
        assert_int_equal(ecat_write(r, 0x0800, "\x00\x10\x04\x00\x64\x00\x01\x00", 8), 1);
        assert_int_equal(ecat_write(r, 0x1000, "\x00\x00\x00\x00", 4), 1);
        assert_int_equal(command(r, 0x0201, 0x20), 1);
        uint64_t next = ect_esc_tick(&r->esc, r->w.now_ns) - r->w.now_ns;
        uint64_t latest = time < 100 * MS ? time : 100 * MS + 100 * US; /* up to one tick more */
        if (next > latest || next < (time < 100 * MS ? time : 100 * MS))
            fail_msg("write of %u ms: next event expected after at most %llu ns, got %llu", times_ms[i],
                     (unsigned long long)latest, (unsigned long long)next);
        r->w.now_ns += 300 * MS;
    }
}

static void busy_reload(void **state)
{
    rig_t *r = *state;
    r->config.sii_command_ns = 50 * US;
    power_on(r);
    assert_int_equal(command(r, 0x0400, 0), 1);
    expect_status(r, "reload running", 0x8700, 0x8400);
    expect_status(r, "reload running: device info not loaded meanwhile", NOT_LOADED, NOT_LOADED);
    r->w.now_ns += 50 * US;
    expect_status(r, "reload done", 0xFFFF, 0x0040);
}

/* Exactly one word each: its neighbours keep their value. */
static void write_one_word(void **state)
{
    rig_t *r = *state;
    uint8_t before[SII_SIZE];
    for (uint32_t word = 8; word < SII_SIZE / 2; word++) {
        memcpy(before, r->sii, SII_SIZE);
        uint8_t request[14] = {0x01,           0x02, (uint8_t)word, 0,    0,    0,    (uint8_t)(word * 3),
                               (uint8_t)~word, 0x99, 0x99,          0x99, 0x99, 0x99, 0x99};
        assert_int_equal(ecat_write(r, CONTROL, request, 14), 1);
        expect_status(r, "after a write", 0xFF3F, 0);
        memcpy(before + word * 2, request + 6, 2);
        assert_memory_equal(r->sii, before, SII_SIZE);
    }
    memcpy(before, r->sii, SII_SIZE);
    for (size_t i = 9; i < sizeof addresses / sizeof addresses[0]; i++) {
        assert_int_equal(command(r, 0x0201, addresses[i]), 1);
        expect_status(r, "write behind the end", BUSY, 0);
        assert_memory_equal(r->sii, before, SII_SIZE);
    }
}

/* The layout of the 4-byte and 8-byte writes in use: bit 0 and the command in one datagram. */
static void write_enable(void **state)
{
    rig_t *r = *state;
    uint8_t before[SII_SIZE];
    memcpy(before, r->sii, SII_SIZE);
    assert_int_equal(ecat_write(r, VALUE, "\x11\x22", 2), 1);
    assert_int_equal(command(r, 0x0200, 0x20), 1);
    expect_status(r, "write without enable", 0xFFFF, NO_WRITE_ENABLE | 0x0040);
    /* Enabled one frame earlier: the bit is cleared again. */
    assert_int_equal(ecat_write(r, CONTROL, "\x01", 1), 1);
    expect_status(r, "the enable bit clears itself", 0x0001, 0);
    assert_int_equal(ecat_write(r, CONTROL + 1, "\x02", 1), 1);
    expect_status(r, "write, enabled a frame before", NO_WRITE_ENABLE, NO_WRITE_ENABLE);
    assert_memory_equal(r->sii, before, SII_SIZE);
    /* The error is cleared by command 0, and by a valid command. */
    assert_int_equal(command(r, 0x0000, 0), 1);
    expect_status(r, "cleared by command 0", 0xFFFF, 0x0040);
    assert_int_equal(command(r, 0x0200, 0x20), 1);
    assert_int_equal(command(r, 0x0201, 0x20), 1);
    expect_status(r, "the write with enable", 0xFFFF, 0x0040);
    memcpy(before + 0x40, "\x11\x22", 2);
    assert_memory_equal(r->sii, before, SII_SIZE);
    /* Enable in one datagram, the command in the next of the same frame; both take effect when it has ended. */
    assert_int_equal(ecat_write(r, VALUE, "\x33\x44", 2), 1);
    wire_build(&r->w, APWR, 0, CONTROL, "\x01", 1);
    wire_append(&r->w, APRD, 0, CONTROL, "\0", 1);
    wire_append(&r->w, APWR, 0, CONTROL + 1, "\x02", 1);
    process(r);
    assert_int_equal(wire_datagram(&r->w, 1)[DATA] & 1, 0);
    expect_status(r, "enable and command in one frame", 0xFFFF, 0x0040);
    memcpy(before + 0x40, "\x33\x44", 2);
    assert_memory_equal(r->sii, before, SII_SIZE);
}

static void invalid_commands(void **state)
{
    rig_t *r = *state;
    static const uint8_t invalid[] = {3, 5, 6, 7};
    for (size_t i = 0; i < sizeof invalid; i++) {
        memset(r->memory + VALUE, 0x3C, 8);
        assert_int_equal(command(r, (uint16_t)(invalid[i] << 8 | 1), 8), 1);
        expect_status(r, "invalid command", 0xF800, NO_ACK);
        assert_memory_equal(r->memory + VALUE, "\x3C\x3C", 2);
        assert_int_equal(ecat_write(r, CONTROL, "\x01", 1), 1);
        assert_int_equal(ecat_write(r, ADDRESS, "\x08", 1), 1);
        expect_status(r, "the error stays without a command", 0xF800, NO_ACK);
        assert_int_equal(command(r, 0x0000, 8), 1);
        expect_status(r, "cleared by command 0", 0xFFFF, 0x0040);
        assert_int_equal(command(r, 0x0100, 8), 1);
        expect_status(r, "read after it", 0xFFFF, 0x0040);
        expect_data(r, 8, 8);
    }
    /* The read-only bits cannot be written, neither can the error bits. */
    assert_int_equal(command(r, 0xF8FE, 8), 1);
    expect_status(r, "all but the command written as 1", 0xFFFF, 0x0040);
}

static void no_eeprom(void **state)
{
    rig_t *r = *state;
    r->config.sii = NULL;
    r->config.sii_size = 0;
    power_on(r);
    expect_status(r, "no EEPROM", 0xFFFF, 0x0048 | NOT_LOADED);
    static const uint16_t commands[] = {0x0100, 0x0201, 0x0400};
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        assert_int_equal(command(r, commands[i], 0), 1);
        expect_status(r, "nothing acknowledges", NO_ACK | BUSY, NO_ACK);
    }
    assert_int_equal(r->memory[0x0110] & 1, 0);
}

static void expect_unloaded(rig_t *r, const char *what, bool loaded)
{
    uint8_t data[4] = {1, 2, 3, 4};
    expect_status(r, what, BAD_CHECKSUM | NOT_LOADED, loaded ? 0 : BAD_CHECKSUM | NOT_LOADED);
    unsigned int want = loaded ? 1 : 0;
    if (send(r, APWR, 0x1000, data, 4) != want || send(r, APRD, 0x1000, data, 4) != want)
        fail_msg("%s: process RAM accessible: expected %u", what, want);
    assert_int_equal(r->memory[0x0110] & 1, want);
    assert_int_equal(send(r, APRD, 0x0000, data, 2), 1);
    assert_int_equal(send(r, APWR, 0x0010, data, 2), 1);
    assert_int_equal(send(r, APWR, 0x0F80, data, 2), 1);
    data[0] = 0x5A;
    ect_esc_pdi_write(&r->esc, 0x1010, data, 1);
    ect_esc_pdi_read(&r->esc, 0x1010, data, 1);
    assert_int_equal(data[0], loaded ? 0x5A : 0);
}

/* Registers under a SyncManager remain registers, regardless of the EEPROM. */
static void user_ram_without_configuration(void **state)
{
    rig_t *r = *state;
    uint8_t data[2] = {0x5A, 0xA5};
    r->sii[0] ^= 1;
    power_on(r);
    assert_int_equal(ecat_write(r, 0x0800, "\x00\x10\x04\x00\x24\x00\x01\x00", 8), 1);
    assert_int_equal(ecat_write(r, 0x0F80, data, 2), 1);
    assert_memory_equal(r->memory + 0x0F80, data, 2);
    assert_int_equal(ecat_write(r, 0x1000, data, 2), 0);
}

static void checksum(void **state)
{
    rig_t *r = *state;
    expect_unloaded(r, "good check sum", true);
    for (unsigned int bit = 0; bit < 15 * 8; bit++) {
        r->sii[bit / 8] ^= (uint8_t)(1u << (bit % 8));
        power_on(r);
        expect_unloaded(r, "one bit wrong", false);
        r->sii[bit / 8] ^= (uint8_t)(1u << (bit % 8));
    }
    ect_store_le16(r->sii + 14, 0x88A4);
    power_on(r);
    expect_unloaded(r, "check switched off", true);
    for (unsigned int size = 2; size <= 16; size += 2) {
        seal(r);
        r->config.sii_size = size;
        power_on(r);
        expect_unloaded(r, "a short EEPROM", size == 16);
    }
}

/* Images of real devices (EK1100, EL2004): their check sums are known. */
static void known_checksums(void **state)
{
    rig_t *r = *state;
    static const uint8_t images[2][16] = {{0x00, 0x0D, [14] = 0x46}, {0x04, 0x01, 0, 0, 0, 0, 0x0F, [14] = 0xD8}};
    for (size_t i = 0; i < 2; i++) {
        memcpy(r->sii, images[i], 16);
        power_on(r);
        expect_unloaded(r, "a real image", true);
    }
}

static void reload(void **state)
{
    rig_t *r = *state;
    static const struct {
        uint16_t address, word;
    } loaded[] = {{0x0140, 0}, {0x0150, 1}, {0x0152, 3}, {0x0142, 5}, {0x0144, 6}};
    memcpy(r->sii, "\x80\x0C\x13\x98\xE9\x03\x71\x72\x78\x56\x91\x92\xA1\xA2", 14);
    seal(r);
    uint8_t want[0x1000];
    memcpy(want, r->memory, sizeof want);
    memcpy(want + 0x0982, r->sii + 4, 2);
    assert_int_equal(command(r, 0x0400, 0), 1);
    for (size_t i = 0; i < sizeof loaded / sizeof loaded[0]; i++)
        memcpy(want + loaded[i].address, r->sii + 2 * loaded[i].word, 2);
    for (unsigned int at = 0; at < sizeof want; at++) {
        if (r->memory[at] != want[at])
            fail_msg("0x%04X: expected 0x%02X after a reload, got 0x%02X", at, want[at], r->memory[at]);
    }
    assert_int_equal(ect_load_le16(r->memory + 0x0012), 0x1234); /* the alias is kept until power-on */
    power_on(r);
    assert_int_equal(ect_load_le16(r->memory + 0x0012), 0x5678);
    /* A bad image, then a good one again. */
    r->sii[0] ^= 1;
    assert_int_equal(command(r, 0x0400, 0), 1);
    expect_unloaded(r, "reload of a bad image", false);
    assert_int_equal(r->memory[0x0140], 0x80);
    r->sii[0] ^= 1;
    assert_int_equal(command(r, 0x0400, 0), 1);
    expect_unloaded(r, "reload of the good image", true);
}

/* Ownership of the interface: 0x0500 as ECAT wrote it, 0x0501 as the PDI did. */
static void ownership(void **state)
{
    rig_t *r = *state;
    static const struct {
        const char *what;
        char side; /* writes `value`: E to 0x0500, P to 0x0501 */
        uint8_t value;
        uint8_t r0500, r0501;
        bool pdi_owns;
    } rows[] = {
        {"PDI takes without an offer", 'P', 1, 0, 0, false},
        {"ECAT offers", 'E', 1, 1, 0, true},
        {"PDI takes", 'P', 1, 1, 1, true},
        {"ECAT offers once more", 'E', 1, 1, 1, true},
        {"ECAT withdraws the offer", 'E', 0, 0, 1, true},
        {"PDI gives back", 'P', 0, 0, 0, false},
        {"PDI takes again without an offer", 'P', 1, 0, 0, false},
        {"ECAT offers again", 'E', 1, 1, 0, true},
        {"PDI takes once more", 'P', 0xFF, 1, 1, true},
        {"ECAT forces", 'E', 2, 2, 0, false},
        {"PDI takes while forced", 'P', 1, 2, 0, false},
        {"ECAT offers and forces", 'E', 3, 3, 0, true},
        {"PDI takes while forced and offered", 'P', 1, 3, 0, true},
        {"ECAT writes all bits", 'E', 0xFF, 3, 0, true},
        {"ECAT back to normal", 'E', 0, 0, 0, false},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].side == 'E')
            assert_int_equal(ecat_write(r, 0x0500, &rows[i].value, 1), 1);
        else
            ect_esc_pdi_write(&r->esc, 0x0501, &rows[i].value, 1);
        if (r->memory[0x0500] != rows[i].r0500 || r->memory[0x0501] != rows[i].r0501)
            fail_msg("%s: expected 0x0500 0x%02X, 0x0501 0x%02X, got 0x%02X, 0x%02X", rows[i].what, rows[i].r0500,
                     rows[i].r0501, r->memory[0x0500], r->memory[0x0501]);
        assert_int_equal(ecat_write(r, 0x0501, "\x01", 1), 0);
        ect_esc_pdi_write(&r->esc, 0x0500, "\x03", 1);
        assert_int_equal(r->memory[0x0500], rows[i].r0500);
        /* The owner reads a word, the other is ignored. */
        memset(r->memory + VALUE, 0x3C, 8);
        unsigned int wkc = command(r, 0x0100, 8);
        bool ecat_did = memcmp(r->memory + VALUE, r->sii + 16, 8) == 0;
        memset(r->memory + VALUE, 0x3C, 8);
        ect_esc_pdi_write(&r->esc, CONTROL, "\x00\x01\x08\x00\x00\x00", 6);
        bool pdi_did = memcmp(r->memory + VALUE, r->sii + 16, 8) == 0;
        if (wkc != (rows[i].pdi_owns ? 0 : 1) || ecat_did == rows[i].pdi_owns || pdi_did != rows[i].pdi_owns)
            fail_msg("%s: expected the PDI to own %d, ECAT WKC %u, read by ECAT %d, by PDI %d", rows[i].what,
                     rows[i].pdi_owns, wkc, ecat_did, pdi_did);
    }
}

static void pdi_writes_eeprom(void **state)
{
    rig_t *r = *state;
    assert_int_equal(ecat_write(r, 0x0500, "\x01", 1), 1);
    ect_esc_pdi_write(&r->esc, 0x0501, "\x01", 1);
    ect_esc_pdi_write(&r->esc, VALUE, "\x5A\xA5", 2);
    ect_esc_pdi_write(&r->esc, CONTROL, "\x00\x02\x30\x00\x00\x00", 6);
    assert_memory_equal(r->sii + 0x60, "\x5A\xA5", 2);
    /* A forced take-over. */
    assert_int_equal(ecat_write(r, 0x0500, "\x02", 1), 1);
    assert_int_equal(ecat_write(r, 0x0500, "\x00", 1), 1);
    assert_int_equal(command(r, 0x0100, 8), 1);
    expect_data(r, 8, 8);
}

/* Both bytes in one access: each side writes its own. */
static void ownership_in_one_access(void **state)
{
    rig_t *r = *state;
    assert_int_equal(ecat_write(r, 0x0500, "\x01\x00", 2), 1);
    ect_esc_pdi_write(&r->esc, 0x0500, "\x00\x01", 2);
    assert_int_equal(ect_load_le16(r->memory + 0x0500), 0x0101);
    assert_int_equal(ecat_write(r, 0x0500, "\x02\x01", 2), 1);
    assert_int_equal(ect_load_le16(r->memory + 0x0500), 0x0002);
}

static void write_enable_of_the_pdi(void **state)
{
    rig_t *r = *state;
    assert_int_equal(ecat_write(r, 0x0500, "\x01", 1), 1);
    ect_esc_pdi_write(&r->esc, 0x0501, "\x01", 1);
    expect_status(r, "the PDI owns: write enable reads 1", 0x0001, 0x0001);
}

/* Faults of the EEPROM itself. */
static void faults(void **state)
{
    rig_t *r = *state;
    r->config.sii_command_ns = 50 * US;
    power_on(r);
    for (unsigned int bit = 0; bit < 16; bit++) {
        uint8_t got[8] = {0};
        ect_esc_sii_fault(&r->esc, ECT_SII_BIT_ERROR, bit);
        assert_int_equal(command(r, 0x0100, 8), 1);
        r->w.now_ns += 50 * US;
        assert_int_equal(send(r, APRD, VALUE, got, 8), 1);
        for (unsigned int i = 0; i < 8; i++) {
            unsigned int want = r->sii[16 + i] ^ (i % 2 == bit / 8 ? 1u << bit % 8 : 0u);
            if (got[i] != want)
                fail_msg("bit %u of each word is wrong: byte %u: expected 0x%02X, got 0x%02X", bit, i, want, got[i]);
        }
    }
    ect_esc_sii_fault(&r->esc, ECT_SII_NO_ANSWER, 0);
    assert_int_equal(command(r, 0x0100, 8), 1);
    r->w.now_ns += 50 * US;
    expect_status(r, "nothing answers", BUSY | NO_ACK, NO_ACK);
    ect_esc_sii_fault(&r->esc, ECT_SII_BUSY, 0);
    assert_int_equal(command(r, 0x0100, 8), 1);
    r->w.now_ns += 1000 * MS;
    expect_status(r, "busy for ever", BUSY, BUSY);
    assert_true(ect_esc_tick(&r->esc, r->w.now_ns) == UINT64_MAX);
    ect_esc_sii_fault(&r->esc, ECT_SII_GOOD, 0);
    expect_status(r, "until it is over", BUSY | NO_ACK, 0);
    expect_data(r, 8, 8);
}

/* A reply that the same frame requests and reads: any data, but no error. */
static void many_commands_in_a_frame(void **state)
{
    rig_t *r = *state;
    uint8_t zero[8] = {0};
    wire_build(&r->w, APWR, 0, CONTROL, "\x00\x01\x08\x00\x00\x00", 6);
    wire_append(&r->w, APWR, 0, CONTROL, "\x01\x02\x30\x00\x00\x00\x77\x66", 8);
    wire_append(&r->w, APWR, 0, CONTROL, "\x00\x01\x30\x00\x00\x00", 6);
    wire_append(&r->w, APRD, 0, VALUE, zero, 8);
    process(r);
    expect_status(r, "afterwards", BUSY | NO_ACK | NO_WRITE_ENABLE, 0);
    assert_memory_equal(r->sii + 0x60, "\x77\x66", 2);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

/* The figures of the ET1100's data sheet (III, table 79), to 10 %, and those of 4 bytes by the same rule. */
static void i2c_times(void **state)
{
    static const struct {
        const char *what;
        uint32_t size;
        uint8_t read;
        uint16_t command;
        uint64_t want_us;
    } rows[] = {
        {"4 words, small", 2048, 8, 0x0100, 680},        {"4 words, large", 4096, 8, 0x0100, 740},
        {"2 words, small", 2048, 4, 0x0100, 440},        {"a written word, small", 2048, 8, 0x0201, 250},
        {"a written word, large", 4096, 8, 0x0201, 310}, {"configuration, small", 2048, 8, 0x0400, 1160},
        {"configuration, large", 4096, 8, 0x0400, 1220},
    };
    rig_t *r = *state;
    uint8_t image[4096] = {0};
    memcpy(image, r->sii, 16);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        r->config.sii = image;
        r->config.sii_size = rows[i].size;
        r->config.sii_command_ns = ECT_ESC_SII_I2C;
        r->personality.sii_read = rows[i].read;
        power_on(r);
        assert_int_equal(command(r, rows[i].command, 8), 1);
        uint64_t took_us = (ect_esc_tick(&r->esc, r->w.now_ns) - r->w.now_ns) / US;
        if (took_us * 10 < rows[i].want_us * 9 || took_us * 10 > rows[i].want_us * 11)
            fail_msg("%s: expected %u us, got %u us", rows[i].what, (unsigned int)rows[i].want_us,
                     (unsigned int)took_us);
        assert_int_equal(r->memory[CONTROL + 1] & 0x80, 0x80);
        r->w.now_ns += 2000 * US;
        assert_int_equal(ect_esc_tick(&r->esc, r->w.now_ns), UINT64_MAX);
        assert_int_equal(r->memory[CONTROL + 1] & 0x80, 0);
    }
}

static void reload_under_sync(void **state)
{
    rig_t *r = *state;
    r->config.sii_command_ns = 50 * US;
    power_on(r);
    uint8_t start[8], cycle[4];
    ect_store_le64(start, ect_esc_system_time(&r->esc, r->w.now_ns) + 1000 * US);
    ect_store_le32(cycle, 1000000);
    assert_int_equal(ecat_write(r, 0x09A0, cycle, 4), 1);
    assert_int_equal(ecat_write(r, 0x0990, start, 8), 1);
    assert_int_equal(ecat_write(r, 0x0981, "\x03", 1), 1);
    assert_int_equal(command(r, 0x0400, 0), 1);
    r->w.now_ns += 50 * US;
    assert_true(ect_esc_tick(&r->esc, r->w.now_ns) > r->w.now_ns);
    expect_status(r, "reload done", 0xFFFF, 0x0040);
}

/* While it stores a word, the EEPROM acknowledges no access; the master repeats its command. */
static void busy_after_a_write(void **state)
{
    rig_t *r = *state;
    r->config.sii_command_ns = ECT_ESC_SII_I2C;
    power_on(r);
    assert_int_equal(ecat_write(r, VALUE, "\x11\x22", 2), 1);
    assert_int_equal(command(r, 0x0201, 0x20), 1);
    r->w.now_ns += 300 * US;
    expect_status(r, "written", 0xE700, 0);
    assert_int_equal(command(r, 0x0100, 0x20), 1);
    r->w.now_ns += 1000 * US;
    expect_status(r, "read at once: not acknowledged", 0xE700, NO_ACK);
    r->w.now_ns += 5000 * US;
    assert_int_equal(command(r, 0x0100, 0x20), 1);
    r->w.now_ns += 1000 * US;
    expect_status(r, "read later", 0xE700, 0);
    assert_memory_equal(r->memory + VALUE, "\x11\x22", 2);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-055: EEPROM commands take the time of an I2C EEPROM, as in the data sheet", i2c_times, setup, teardown,
         NULL},
        {"CF-055: a reload ends while SYNC0 is running", reload_under_sync, setup, teardown, NULL},
        {"CF-055: an EEPROM that stores a word acknowledges no command for 5 ms", busy_after_a_write, setup, teardown,
         NULL},
        TEST("CF-055: a read delivers 4 or 8 bytes according to bit 6, FF beyond the end, the rest stays", read_sizes),
        TEST("CF-055: bit 7 is set from 32 kbit on", address_bytes),
        TEST("CF-055: command and address are accepted in accesses of any length", access_lengths),
        TEST("CF-055: busy for the time of a read, writes are refused meanwhile, data at the end", busy_read),
        TEST("CF-056: busy for the time of a write, then the next one works", busy_write),
        TEST("CF-049 CF-055: the next event in time is the end of the command or the watchdog", next_deadline),
        TEST("CF-056: busy for the time of a reload, bit 12 set meanwhile", busy_reload),
        TEST("CF-056: a write stores exactly one word, beyond the end none", write_one_word),
        TEST("CF-056: a write needs the enable bit in its own frame, else bit 14, cleared by command 0", write_enable),
        TEST("CF-055: an invalid command sets bit 13; command 0 clears it; read-only bits are unchanged",
             invalid_commands),
        TEST("CF-055: without an EEPROM bits 3 and 12 show it and commands end with bit 13", no_eeprom),
        TEST("CF-056: each wrong bit of words 0..7 is found: bits 11 and 12, DL status bit 0, no process RAM, "
             "registers work",
             checksum),
        TEST("CF-056: without a configuration, user RAM is writable outside an enabled SyncManager, process RAM is not",
             user_ram_without_configuration),
        TEST("CF-054: check sums of real devices are good", known_checksums),
        TEST("CF-056 CF-065: a reload brings the configuration but not the alias", reload),
        TEST("CF-056: 0x0500 and 0x0501 determine the owner of the interface; the other side is ignored", ownership),
        TEST("CF-056: 0x0500 and 0x0501 in one access: each side writes its own byte", ownership_in_one_access),
        TEST("CF-056: the PDI as owner writes without the enable bit; ECAT regains it by force", pdi_writes_eeprom),
        TEST("CF-056: the enable bit reads 1 while the PDI owns the interface", write_enable_of_the_pdi),
        TEST("CF-055: faults of the EEPROM: a wrong bit in each word, no acknowledge, busy until the fault ends",
             faults),
        TEST("CF-056: several commands in a frame are executed one after the other", many_commands_in_a_frame),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC SII", tests, NULL, NULL);
}
