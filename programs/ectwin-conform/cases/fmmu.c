/* SPDX-License-Identifier: MIT */
/* C. FMMUs, tested in INIT on RAM outside of SyncManagers. */
#include <string.h>

#include "steps/case.h"

enum {
    LOGICAL = 0x30000,
    FILL = 0xA5,
    DIGITAL_OUTPUT = ECT_REG_DIGITAL_OUTPUT,
    STATUS_1 = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS
};
enum { READS = 1, WRITES = 2, BYTE_ORIENTED = 0x0001 };

static const uint8_t numbers[16] = {0x10, 0x21, 0x32, 0x43, 0x54, 0x65, 0x76, 0x87,
                                    0x98, 0xA9, 0xBA, 0xCB, 0xDC, 0xED, 0xFE, 0x0F};

static void needs_fmmus(cf_t *c, unsigned int count)
{
    if (c->facts.fmmus < count)
        cf_skip(c, "the chip has %u FMMUs, %u are needed", c->facts.fmmus, count);
}

static void needs_bits(cf_t *c)
{
    if ((c->facts.features & BYTE_ORIENTED) != 0)
        cf_skip(c, "the chip maps whole bytes only");
}

static void map_bytes(cf_t *c, unsigned int fmmu, uint32_t logical, uint16_t length, uint16_t physical, uint8_t type)
{
    cf_set_fmmu(c, fmmu, logical, length, 0, 7, physical, 0, type);
}

/* --- bytes -------------------------------------------------------------------------------------------------------- */

static void read_bytes(cf_t *c, uint16_t ram)
{
    uint8_t data[16], expected[16];
    cf_step(c, "8 bytes mapped for reading, in the middle of a datagram of 16");
    cf_put(c, ram, numbers, sizeof numbers);
    map_bytes(c, 0, LOGICAL + 4, 8, ram, READS);
    memset(data, FILL, sizeof data);
    memset(expected, FILL, sizeof expected);
    memcpy(expected + 4, numbers, 8);
    cf_expect_wkc(c, "LRD", 1, cf_logical(c, CF_LRD, LOGICAL, data, sizeof data));
    cf_expect_bytes(c, "LRD of 8 mapped bytes among 16", expected, data, sizeof data);
}

static void write_bytes(cf_t *c, uint16_t ram)
{
    uint8_t data[16], expected[16] = {0}, zeros[16] = {0};
    cf_step(c, "8 bytes mapped for writing, in the middle of a datagram of 16");
    cf_put(c, ram, zeros, sizeof zeros);
    cf_clear_fmmu(c, 0);
    map_bytes(c, 1, LOGICAL + 4, 8, (uint16_t)(ram + 2), WRITES);
    memcpy(data, numbers, sizeof data);
    memcpy(expected + 2, numbers + 4, 8);
    cf_expect_wkc(c, "LWR", 1, cf_logical(c, CF_LWR, LOGICAL, data, sizeof data));
    cf_get(c, ram, data, sizeof data);
    cf_expect_bytes(c, "the RAM around 8 mapped bytes after LWR", expected, data, sizeof data);
}

static void both_ways(cf_t *c, uint16_t ram)
{
    uint8_t data[8] = {0};
    if ((c->facts.has & CF_LRW_OK) == 0)
        return;
    cf_step(c, "LRW over 4 bytes for writing and 4 for reading");
    map_bytes(c, 0, LOGICAL + 4, 4, ram, READS);
    map_bytes(c, 1, LOGICAL, 4, (uint16_t)(ram + 8), WRITES);
    cf_put(c, ram, numbers, 16);
    memset(data, FILL, sizeof data);
    cf_expect_wkc(c, "LRW", 3, cf_logical(c, CF_LRW, LOGICAL, data, sizeof data));
    cf_expect_bytes(c, "the read part of LRW", numbers, data + 4, 4);
    cf_expect(c, "the write part of LRW, in the frame", 0xA5A5A5A5, ect_load_le32(data));
    cf_expect(c, "the write part of LRW, in the RAM", 0xA5A5A5A5, cf_get32(c, (uint16_t)(ram + 8)));
}

static void two_and_split(cf_t *c, uint16_t ram)
{
    uint8_t data[8] = {0};
    cf_step(c, "two FMMUs for reading in one datagram, the second area before the first in the RAM");
    cf_put(c, ram, numbers, 16);
    map_bytes(c, 0, LOGICAL, 4, (uint16_t)(ram + 8), READS);
    map_bytes(c, 1, LOGICAL + 4, 4, ram, READS);
    cf_expect_wkc(c, "LRD over two FMMUs", 1, cf_logical(c, CF_LRD, LOGICAL, data, 8));
    cf_expect_bytes(c, "bytes of the first FMMU", numbers + 8, data, 4);
    cf_expect_bytes(c, "bytes of the second FMMU", numbers, data + 4, 4);
    cf_step(c, "one FMMU over two datagrams of a frame");
    cf_clear_fmmu(c, 1);
    map_bytes(c, 0, LOGICAL, 8, ram, READS);
    cf_datagram_t d[2] = {{.command = CF_LRD, .address = LOGICAL, .length = 3, .data = data},
                          {.command = CF_LRD, .address = LOGICAL + 3, .length = 5, .data = data + 3}};
    cf_exchange(c, d, 2);
    cf_expect_wkc(c, "the first datagram", 1, d[0].wkc);
    cf_expect_wkc(c, "the second datagram", 1, d[1].wkc);
    cf_expect_bytes(c, "one area read with two datagrams", numbers, data, 8);
}

static void bytes(cf_t *c)
{
    const uint16_t ram = cf_spare_ram(c);
    needs_fmmus(c, 2);
    read_bytes(c, ram);
    write_bytes(c, ram);
    both_ways(c, ram);
    two_and_split(c, ram);
}

/* --- bits --------------------------------------------------------------------------------------------------------- */

static bool bit(const uint8_t *bytes_, unsigned int n)
{
    return (bytes_[n / 8] >> n % 8 & 1) != 0;
}

static void set_bit(uint8_t *bytes_, unsigned int n, bool value)
{
    bytes_[n / 8] = (uint8_t)((bytes_[n / 8] & ~(1u << n % 8)) | (unsigned int)value << n % 8);
}

typedef struct bit_map {
    uint16_t length;
    uint8_t start_bit, stop_bit, physical_bit;
} bit_map_t;

static unsigned int bits_of(const bit_map_t *m)
{
    return (m->length - 1u) * 8 + m->stop_bit - m->start_bit + 1;
}

static void read_bits(cf_t *c, const bit_map_t *m, uint8_t fill)
{
    const uint16_t ram = cf_spare_ram(c);
    uint8_t data[4], expected[4];
    memset(data, fill, sizeof data);
    memset(expected, fill, sizeof expected);
    for (unsigned int n = 0; n < bits_of(m); n++)
        set_bit(expected, m->start_bit + n, bit(numbers + 3, m->physical_bit + n));
    cf_step(c, "%u bits for reading, from logical bit %u, from bit %u of the RAM, in a frame of 0x%02X", bits_of(m),
            m->start_bit, m->physical_bit, fill);
    cf_set_fmmu(c, 0, LOGICAL, m->length, m->start_bit, m->stop_bit, (uint16_t)(ram + 3), m->physical_bit, READS);
    cf_expect_wkc(c, "LRD of bits", 1, cf_logical(c, CF_LRD, LOGICAL, data, sizeof data));
    cf_expect_bytes(c, "LRD of bits", expected, data, sizeof data);
}

/* Uses registers, because only there do all chips support writes of single bits. */
static void write_bits(cf_t *c)
{
    const uint8_t pdi = (uint8_t)c->facts.pdi;
    uint8_t data[1] = {0x00}, set[4] = {0xFF, 0xFF, 0, 0}, got[4];
    bool digital = pdi <= 0x04 || (pdi >= 0x10 && pdi <= 0x14);
    if (digital || cf_write(c, DIGITAL_OUTPUT, set, sizeof set) != 1) {
        cf_note(c, "reading only; single bits can be written only at 0x0F00, which is in use or missing here");
        return;
    }
    cf_step(c, "2 bits for writing: logical bits 3 and 4 to bits 6 and 7 of 0x0F00");
    cf_set_fmmu(c, 0, LOGICAL, 1, 3, 4, DIGITAL_OUTPUT, 6, WRITES);
    cf_expect_wkc(c, "LWR of bits", 1, cf_logical(c, CF_LWR, LOGICAL, data, 1));
    cf_get(c, DIGITAL_OUTPUT, got, sizeof got);
    memset(set, 0, sizeof set);
    (void)cf_write(c, DIGITAL_OUTPUT, set, sizeof set);
    const uint8_t expected[4] = {0x3F, 0xFF, 0, 0};
    cf_expect_bytes(c, "0x0F00 after LWR of its bits 6 and 7", expected, got, sizeof got);
}

static void bits(cf_t *c)
{
    static const bit_map_t maps[] = {{1, 2, 4, 2}, {1, 0, 3, 4}, {3, 3, 0, 1},
                                     {2, 7, 0, 7}, {2, 1, 7, 0}, {1, 6, 6, 0}};
    needs_bits(c);
    cf_put(c, cf_spare_ram(c), numbers, sizeof numbers);
    for (size_t i = 0; i < sizeof maps / sizeof maps[0]; i++) {
        read_bits(c, &maps[i], 0x00);
        read_bits(c, &maps[i], 0xFF);
    }
    write_bits(c);
}

/* Maps the "mailbox full" bit of SM1 into a byte shared with other slaves. */
static void mailbox_state(cf_t *c)
{
    uint8_t mapped = 0xFF;
    cf_mail_t mail;
    needs_bits(c);
    cf_go(c, CF_PREOP);
    cf_set_fmmu(c, c->facts.fmmus - 1u, LOGICAL, 1, 2, 2, STATUS_1, 3, READS);
    cf_step(c, "SM1 is empty: its bit 2 of the logical byte becomes 0, the others stay 1");
    cf_expect_wkc(c, "LRD of the mailbox state", 1, cf_logical(c, CF_LRD, LOGICAL, &mapped, 1));
    cf_expect(c, "logical byte with an empty SM1", 0xFB, mapped);
    cf_step(c, "SM1 is full: the bit becomes 1, the others stay 0");
    const uint8_t anything[4] = {0};
    cf_send_mail(c, 9, anything, sizeof anything); /* unknown type: the reply is a mailbox error */
    for (int tries = 0; mapped != 0x04 && tries < (int)CF_MAIL_MS; tries++) {
        mapped = 0;
        (void)cf_logical(c, CF_LRD, LOGICAL, &mapped, 1);
        if (mapped == 0)
            cf_sleep_ms(c, 1);
    }
    cf_expect(c, "logical byte with a mail in SM1", 0x04, mapped);
    (void)cf_receive_mail(c, &mail, CF_MAIL_MS);
    mapped = 0xFF;
    cf_expect_wkc(c, "LRD of the mailbox state", 1, cf_logical(c, CF_LRD, LOGICAL, &mapped, 1));
    cf_expect(c, "logical byte after reading the mail", 0xFB, mapped);
}

/* --- FMMUs without effect ----------------------------------------------------------------------------------------- */

static void expect_nothing(cf_t *c, const char *what, uint8_t command)
{
    uint8_t data[4];
    memset(data, FILL, sizeof data);
    cf_expect_wkc(c, what, 0, cf_logical(c, command, LOGICAL, data, sizeof data));
    cf_expect(c, what, 0xA5A5A5A5, ect_load_le32(data));
}

static void overlapping(cf_t *c, uint16_t ram)
{
    uint8_t data[4] = {0};
    cf_step(c, "two FMMUs for the same logical bytes: the lower one is used");
    cf_put(c, ram, numbers, 16);
    map_bytes(c, 0, LOGICAL, 4, (uint16_t)(ram + 8), READS);
    map_bytes(c, 1, LOGICAL, 4, ram, READS);
    cf_expect_wkc(c, "LRD of bytes mapped twice", 1, cf_logical(c, CF_LRD, LOGICAL, data, 4));
    cf_expect_bytes(c, "LRD of bytes mapped twice", numbers + 8, data, 4);
}

static void nothing(cf_t *c)
{
    const uint16_t ram = cf_spare_ram(c);
    const uint32_t end = ECT_RAM + c->facts.ram_kb * 1024u;
    needs_fmmus(c, 2);
    map_bytes(c, 0, LOGICAL, 4, ram, READS);
    expect_nothing(c, "LWR of an area for reading", CF_LWR);
    cf_put8(c, CF_FMMU(0) + ECT_FMMU_ACTIVATE, 0);
    expect_nothing(c, "LRD of a disabled FMMU", CF_LRD);
    map_bytes(c, 0, LOGICAL, 0, ram, READS);
    expect_nothing(c, "LRD of an FMMU of length 0", CF_LRD);
    map_bytes(c, 0, LOGICAL + 0x1000, 4, ram, READS);
    expect_nothing(c, "LRD outside the area of an FMMU", CF_LRD);
    map_bytes(c, 0, LOGICAL, 4, ram, 0);
    expect_nothing(c, "LRD of an FMMU without a direction", CF_LRD);
    if (end < 0x10000) {
        map_bytes(c, 0, LOGICAL, 4, (uint16_t)end, READS);
        expect_nothing(c, "LRD of an area after the end of the RAM", CF_LRD);
    }
    overlapping(c, ram);
}

/* --- several slaves ----------------------------------------------------------------------------------------------- */

typedef struct area {
    uint16_t station;
    unsigned int fmmu;
    uint32_t logical;
    uint16_t physical;
    uint8_t type;
} area_t;

static bool try_map(cf_t *c, const area_t *a)
{
    uint8_t registers[ECT_FMMU_SIZE] = {0};
    ect_store_le32(registers + ECT_FMMU_LOGICAL, a->logical);
    ect_store_le16(registers + ECT_FMMU_LENGTH, a->type == 0 ? 0 : 4);
    registers[ECT_FMMU_STOP_BIT] = a->type == 0 ? 0 : 7;
    ect_store_le16(registers + ECT_FMMU_PHYSICAL, a->physical);
    registers[ECT_FMMU_TYPE] = a->type;
    registers[ECT_FMMU_ACTIVATE] = a->type != 0;
    return cf_command(c, CF_FPWR, a->station, CF_FMMU(a->fmmu), registers, sizeof registers) == 1;
}

/* @return station address of another slave with two FMMUs and RAM; 0: none */
static uint16_t partner(cf_t *c)
{
    for (uint16_t n = 0; n < c->facts.slaves; n++) {
        uint8_t copy[4] = {1, 2, 3, 4}, count = 0;
        const uint16_t station = (uint16_t)(CF_STATION + n);
        if (n == c->facts.position)
            continue;
        if (cf_command(c, CF_FPRD, station, ECT_REG_FMMU_COUNT, &count, 1) == 1 && count >= 2 &&
            cf_command(c, CF_FPWR, station, ECT_RAM, copy, 4) == 1)
            return station;
    }
    return 0;
}

/* Exchanges the outputs of both slaves at `out` and the inputs at `in`, in this order in the logical image. */
static void exchange_both(cf_t *c, uint16_t other, const uint32_t out[2], const uint32_t in[2])
{
    const uint16_t stations[2] = {c->facts.station, other}, ram = cf_spare_ram(c);
    uint8_t data[16], inputs[2][4] = {{1, 2, 3, 4}, {5, 6, 7, 8}}, written[2][4] = {{0}};
    uint16_t wkc = 0;
    for (unsigned int i = 0; i < 2; i++) {
        (void)cf_command(c, CF_FPWR, stations[i], ram, inputs[i], 4);
        (void)try_map(c, &(area_t){stations[i], 0, LOGICAL + out[i], (uint16_t)(ram + 8), WRITES});
        (void)try_map(c, &(area_t){stations[i], 1, LOGICAL + in[i], ram, READS});
    }
    memcpy(data, numbers, sizeof data);
    wkc = cf_logical(c, CF_LRW, LOGICAL, data, sizeof data);
    for (unsigned int i = 0; i < 2; i++) {
        (void)cf_command(c, CF_FPRD, stations[i], (uint16_t)(ram + 8), written[i], 4);
        (void)try_map(c, &(area_t){stations[i], 0, 0, 0, 0}); /* clears the other slave before any verdict */
        (void)try_map(c, &(area_t){stations[i], 1, 0, 0, 0});
    }
    cf_expect_wkc(c, "LRW over two slaves", 6, wkc);
    for (unsigned int i = 0; i < 2; i++) {
        cf_expect_bytes(c, "inputs of a slave", inputs[i], data + in[i], 4);
        cf_expect_bytes(c, "outputs of a slave", numbers + out[i], written[i], 4);
    }
}

static void several(cf_t *c)
{
    needs_fmmus(c, 2);
    uint16_t other = partner(c);
    if (other == 0)
        cf_skip(c, "no other slave on the segment has two FMMUs and RAM");
    cf_step(c, "all outputs, then all inputs, as in SOEM");
    exchange_both(c, other, (const uint32_t[]){0, 4}, (const uint32_t[]){8, 12});
    cf_step(c, "slave by slave");
    exchange_both(c, other, (const uint32_t[]){0, 8}, (const uint32_t[]){4, 12});
}

static const cf_case_t cases[] = {
    {"CF-028", "FMMUs map bytes in both directions, several in a datagram, one over several datagrams", 'R', 0, 0,
     bytes},
    {"CF-029", "FMMUs map bits across bytes; other bits are unchanged", 'R', 0, 0, bits},
    {"CF-030", "The mailbox state is mapped to one bit of a logical byte; the other bits are unchanged", 'R',
     CF_MAILBOX, 0, mailbox_state},
    {"CF-031", "An FMMU maps nothing if disabled, empty, of another direction or beyond the RAM", 'R', 0, 0, nothing},
    {"CF-032", "One LRW exchanges data with several slaves, interleaved and in blocks", 'R', CF_CHAIN | CF_LRW_OK, 0,
     several},
};

CF_SECTION(cf_fmmu, 'C', "FMMUs", cases);
