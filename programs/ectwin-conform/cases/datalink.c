/* SPDX-License-Identifier: MIT */
/* A. Data link and ESC registers. In INIT, FMMU 0 is unused: its logical start address serves as a scratch register. */
#include <string.h>

#include "steps/case.h"

enum { SCRATCH = ECT_REG_FMMU + ECT_FMMU_LOGICAL, NOBODY = 0x7ABC, PATTERN = 0xA5, IDENTITY_BYTES = 10 };
enum { LOOP_CLOSED = 0x0100, COMMUNICATION = 0x0200, LINK = 0x0010 }; /* DL status of port 0; the others follow */
enum { REG_WRITE_ENABLE = 0x0020, REG_WRITE_PROTECT = 0x0021, REG_RESET = 0x0040 };
enum { ETHERNET = 14, FRAME_MIN = 60, ERRORS = 0x14, EVENT_MS = 3000 };

/* --- identity and addressing -------------------------------------------------------------------------------------- */

static void read_only(cf_t *c, uint16_t address, size_t length, const char *what)
{
    uint8_t before[16], other[16], after[16];
    cf_get(c, address, before, length);
    for (size_t i = 0; i < length; i++)
        other[i] = (uint8_t)~before[i];
    (void)cf_write(c, address, other, length);
    cf_get(c, address, after, length);
    if (memcmp(before, after, length) != 0)
        (void)cf_write(c, address, before, length); /* restores the register for the next cases */
    cf_expect_bytes(c, what, before, after, length);
}

static void absent(cf_t *c, uint16_t address, uint16_t length, const char *what)
{
    const uint8_t zeros[16] = {0};
    cf_expect_wkc(c, what, 0, cf_write(c, address, zeros, length));
}

static void information(cf_t *c)
{
    const cf_facts_t *f = &c->facts;
    uint8_t fmmus = cf_get8(c, ECT_REG_FMMU_COUNT), sms = cf_get8(c, ECT_REG_SM_COUNT);
    cf_expect_that(c, f->type != 0, "type (0x0000): expected not 0x00, got 0x00");
    cf_expect_range(c, "SyncManagers (0x0005)", 1, CF_MAX_SMS, sms);
    cf_expect_range(c, "FMMUs (0x0004)", 1, CF_MAX_FMMUS, fmmus);
    cf_expect_range(c, "RAM in KB (0x0006)", 1, 60, f->ram_kb);
    cf_expect_that(c, (f->ports & 3) >= 2, "port descriptor (0x0007): expected a configured port 0, got 0x%02X",
                   f->ports);
    cf_step(c, "writes to read-only registers");
    read_only(c, ECT_REG_TYPE, IDENTITY_BYTES, "chip information after a write");
    cf_step(c, "the first FMMU and the first SyncManager beyond those of the chip");
    if (fmmus < CF_MAX_FMMUS)
        absent(c, CF_FMMU(fmmus), ECT_FMMU_SIZE, "a write to the FMMU after the last");
    if (sms < CF_MAX_SMS)
        absent(c, CF_SM(sms), ECT_SM_SIZE, "a write to the SyncManager after the last");
    uint8_t time[4];
    if ((f->features & 0x0004) != 0)
        cf_expect_wkc(c, "a read of the system time, which the feature word announces", 1,
                      cf_read(c, ECT_REG_DC_SYSTEM_TIME, time, sizeof time));
}

static void broadcast(cf_t *c)
{
    uint8_t all[IDENTITY_BYTES] = {0}, expected[IDENTITY_BYTES] = {0}, one[IDENTITY_BYTES];
    for (uint16_t n = 0; n < c->facts.slaves; n++) {
        memset(one, 0, sizeof one);
        cf_expect_wkc(c, "a read of each slave by its address", 1,
                      cf_command(c, CF_FPRD, (uint16_t)(CF_STATION + n), ECT_REG_TYPE, one, sizeof one));
        for (size_t i = 0; i < sizeof one; i++)
            expected[i] |= one[i];
    }
    cf_datagram_t d = {.command = CF_BRD, .address = CF_AT(0, ECT_REG_TYPE), .length = sizeof all, .data = all};
    cf_exchange(c, &d, 1);
    cf_expect_wkc(c, "the broadcast read", c->facts.slaves, d.wkc);
    cf_expect(c, "ADP after the broadcast read", c->facts.slaves, d.address & 0xFFFF);
    cf_expect_bytes(c, "the broadcast read", expected, all, sizeof all);
    cf_step(c, "bits set in the frame remain set: BRD is an OR");
    memset(all, 0, sizeof all);
    all[IDENTITY_BYTES - 1] = 0x80;
    d = (cf_datagram_t){.command = CF_BRD, .address = CF_AT(5, ECT_REG_TYPE), .length = sizeof all, .data = all};
    cf_exchange(c, &d, 1);
    cf_expect_bits(c, "the bit set in the frame", 0x80, 0x80, all[IDENTITY_BYTES - 1]);
    cf_expect(c, "ADP, begun at 5", 5u + c->facts.slaves, d.address & 0xFFFF);
}

static void by_position(cf_t *c)
{
    for (uint16_t n = 0; n < c->facts.slaves; n++) {
        uint8_t station[2] = {0};
        cf_datagram_t d = {
            .command = CF_APRD, .address = CF_AT((uint16_t)-n, ECT_REG_STATION_ADDRESS), .length = 2, .data = station};
        cf_exchange(c, &d, 1);
        cf_expect_wkc(c, "APRD by position", 1, d.wkc);
        cf_expect(c, "station address of the slave at that position", CF_STATION + n, ect_load_le16(station));
        cf_expect(c, "ADP: every slave increments it", (uint16_t)(c->facts.slaves - n), d.address & 0xFFFF);
    }
    cf_step(c, "a position after the last slave");
    uint8_t data[2] = {PATTERN, PATTERN};
    cf_expect_wkc(c, "APRD after the last slave", 0,
                  cf_command(c, CF_APRD, (uint16_t)-c->facts.slaves, ECT_REG_STATION_ADDRESS, data, 2));
    cf_expect(c, "data of a datagram without a receiver", 0xA5A5, ect_load_le16(data));
    cf_step(c, "APWR, then APRW");
    uint8_t value[4] = {1, 2, 3, 4};
    cf_expect_wkc(c, "APWR", 1, cf_command(c, CF_APWR, c->facts.ring, SCRATCH, value, 4));
    cf_expect(c, "the register written by APWR", 0x04030201, cf_get32(c, SCRATCH));
    if ((c->facts.has & CF_RW) == 0)
        return;
    uint8_t next[4] = {5, 6, 7, 8};
    cf_expect_wkc(c, "APRW", 3, cf_command(c, CF_APRW, c->facts.ring, SCRATCH, next, 4));
    cf_expect(c, "what APRW read", 0x04030201, ect_load_le32(next));
    cf_expect(c, "what APRW wrote", 0x08070605, cf_get32(c, SCRATCH));
}

static void by_alias(cf_t *c)
{
    uint16_t alias = cf_get16(c, ECT_REG_STATION_ALIAS);
    uint8_t data[4] = {PATTERN, PATTERN, PATTERN, PATTERN};
    if (alias == 0 || (alias >= CF_STATION && alias < CF_STATION + c->facts.slaves)) {
        cf_note(c, "the alias is 0x%04X: addressing by alias was not tested", alias);
        return;
    }
    cf_step(c, "the alias 0x%04X, not enabled, then enabled", alias);
    cf_expect_wkc(c, "FPRD of the alias before it is enabled", 0, cf_command(c, CF_FPRD, alias, SCRATCH, data, 4));
    cf_put8(c, ECT_REG_DL_CONTROL + 3, 1);
    cf_expect_wkc(c, "FPRD of the alias", 1, cf_command(c, CF_FPRD, alias, SCRATCH, data, 4));
    cf_expect_wkc(c, "FPRD of the station address with the alias enabled", 1, cf_read(c, SCRATCH, data, 4));
    cf_put8(c, ECT_REG_DL_CONTROL + 3, 0);
    cf_expect_wkc(c, "FPRD of the alias, disabled again", 0, cf_command(c, CF_FPRD, alias, SCRATCH, data, 4));
}

static void by_station(cf_t *c)
{
    uint8_t data[4] = {PATTERN, PATTERN, PATTERN, PATTERN};
    cf_expect_wkc(c, "FPRD of an unused address", 0, cf_command(c, CF_FPRD, NOBODY, SCRATCH, data, 4));
    cf_expect(c, "data of an FPRD without a receiver", 0xA5A5A5A5, ect_load_le32(data));
    cf_expect_wkc(c, "FPWR to an unused address", 0, cf_command(c, CF_FPWR, NOBODY, SCRATCH, data, 4));
    cf_expect(c, "an unwritten register", 0, cf_get32(c, SCRATCH));
    cf_put32(c, SCRATCH, 0x11223344);
    cf_expect(c, "FPRD of the register written by FPWR", 0x11223344, cf_get32(c, SCRATCH));
    if ((c->facts.has & CF_RW) != 0) {
        cf_expect_wkc(c, "FPRW", 3, cf_command(c, CF_FPRW, c->facts.station, SCRATCH, data, 4));
        cf_expect(c, "what FPRW read", 0x11223344, ect_load_le32(data));
        cf_expect(c, "what FPRW wrote", 0xA5A5A5A5, cf_get32(c, SCRATCH));
    }
    by_alias(c);
}

/* --- working counters --------------------------------------------------------------------------------------------- */

/* Writes the present value: a chip that accepts a forbidden write keeps its values. */
static uint16_t counted(cf_t *c, uint8_t command, uint16_t address, uint16_t begun)
{
    uint8_t data[4];
    (void)cf_read(c, address, data, sizeof data);
    cf_datagram_t d = {.command = command,
                       .address = CF_AT(c->facts.station, address),
                       .length = sizeof data,
                       .data = data,
                       .wkc = begun};
    cf_exchange(c, &d, 1);
    return d.wkc;
}

static void logical_counters(cf_t *c)
{
    const uint16_t ram = cf_spare_ram(c);
    uint8_t data[8] = {0};
    cf_set_fmmu(c, 0, 0x10000, 4, 0, 7, ram, 0, 1);
    cf_expect_wkc(c, "LRD of a mapped area", 1, cf_logical(c, CF_LRD, 0x10000, data, 4));
    cf_expect_wkc(c, "LWR of an area mapped for reading", 0, cf_logical(c, CF_LWR, 0x10000, data, 4));
    if ((c->facts.has & CF_LRW_OK) != 0)
        cf_expect_wkc(c, "LRW of an area mapped for reading", 1, cf_logical(c, CF_LRW, 0x10000, data, 4));
    if (c->facts.fmmus < 2)
        return;
    cf_set_fmmu(c, 1, 0x10004, 4, 0, 7, (uint16_t)(ram + 4), 0, 2);
    cf_expect_wkc(c, "LWR of a mapped area", 1, cf_logical(c, CF_LWR, 0x10004, data, 4));
    cf_expect_wkc(c, "LRD of an area mapped for writing", 0, cf_logical(c, CF_LRD, 0x10004, data, 4));
    if ((c->facts.has & CF_LRW_OK) == 0)
        return;
    cf_expect_wkc(c, "LRW of an area mapped for writing", 2, cf_logical(c, CF_LRW, 0x10004, data, 4));
    cf_expect_wkc(c, "LRW of one area for reading and one for writing", 3, cf_logical(c, CF_LRW, 0x10000, data, 8));
}

static void counters(cf_t *c)
{
    cf_expect_wkc(c, "FPRD, begun at 5", 6, counted(c, CF_FPRD, SCRATCH, 5));
    cf_expect_wkc(c, "FPWR, begun at 5", 6, counted(c, CF_FPWR, SCRATCH, 5));
    cf_expect_wkc(c, "FPRD with an initial working counter of 0xFFFF, which wraps", 0,
                  counted(c, CF_FPRD, SCRATCH, 0xFFFF));
    cf_expect_wkc(c, "FPWR of a read-only register", 0, counted(c, CF_FPWR, ECT_REG_TYPE, 0));
    if ((c->facts.has & CF_RW) != 0) {
        cf_expect_wkc(c, "FPRW", 3, counted(c, CF_FPRW, SCRATCH, 0));
        cf_expect_wkc(c, "FPRW of a read-only register", 1, counted(c, CF_FPRW, ECT_REG_TYPE, 0));
    }
    logical_counters(c);
}

/* Slaves before the addressed one must contain the value sent, slaves after it the value read. */
static void check_others(cf_t *c, uint32_t sent, uint32_t read)
{
    for (uint16_t n = 0; n < c->facts.slaves; n++) {
        uint8_t value[4] = {0}, zeros[4] = {0};
        uint16_t station = (uint16_t)(CF_STATION + n);
        if (n == c->facts.position)
            continue;
        uint16_t wkc = cf_command(c, CF_FPRD, station, SCRATCH, value, 4);
        (void)cf_command(c, CF_FPWR, station, SCRATCH, zeros, 4);
        if (wkc == 1)
            cf_expect(c,
                      n < c->facts.position ? "the register of a previous slave" : "the register of a following slave",
                      n < c->facts.position ? sent : read, ect_load_le32(value));
    }
}

static void multiple_write(cf_t *c)
{
    static const uint8_t commands[] = {CF_ARMW, CF_FRMW};
    uint16_t expected = 1;
    for (uint16_t n = 0; n < c->facts.slaves; n++) { /* a slave without FMMUs cannot count */
        uint8_t zeros[4] = {0};
        if (n != c->facts.position)
            expected = (uint16_t)(expected + cf_command(c, CF_FPWR, (uint16_t)(CF_STATION + n), SCRATCH, zeros, 4));
    }
    for (size_t i = 0; i < sizeof commands; i++) {
        uint8_t data[4] = {1, 1, 1, 1};
        uint16_t adp = commands[i] == CF_ARMW ? c->facts.ring : c->facts.station;
        cf_put32(c, SCRATCH, 0x22222222);
        cf_expect_wkc(c, i == 0 ? "ARMW" : "FRMW", expected, cf_command(c, commands[i], adp, SCRATCH, data, 4));
        cf_expect(c, "the value that the addressed slave wrote to the frame", 0x22222222, ect_load_le32(data));
        cf_expect(c, "the addressed slave's register, which is read only", 0x22222222, cf_get32(c, SCRATCH));
        check_others(c, 0x01010101, 0x22222222);
    }
}

static void no_operation(cf_t *c)
{
    uint8_t data[4] = {PATTERN, PATTERN, PATTERN, PATTERN};
    cf_datagram_t d = {
        .command = CF_NOP, .address = CF_AT(c->facts.station, SCRATCH), .length = 4, .data = data, .wkc = 7};
    cf_exchange(c, &d, 1);
    cf_expect_wkc(c, "NOP, begun at 7", 7, d.wkc);
    cf_expect(c, "address of NOP", CF_AT(c->facts.station, SCRATCH), d.address);
    cf_expect(c, "data of NOP", 0xA5A5A5A5, ect_load_le32(data));
    d = (cf_datagram_t){.command = 200, .address = CF_AT(0, SCRATCH), .length = 4, .data = data, .wkc = 7};
    cf_exchange(c, &d, 1);
    cf_expect_wkc(c, "an unknown command, initial working counter 7", 7, d.wkc);
    cf_expect(c, "data of an unknown command", 0xA5A5A5A5, ect_load_le32(data));
    cf_expect(c, "an unwritten register", 0, cf_get32(c, SCRATCH));
}

/* --- ranges ------------------------------------------------------------------------------------------------------- */

static void missing_ranges(cf_t *c)
{
    const uint32_t end = ECT_RAM + c->facts.ram_kb * 1024u;
    uint8_t data[CF_MAX_DATA];
    cf_step(c, "over a thousand registers, existing or not");
    cf_expect_wkc(c, "a read of 0x0000 to 0x03FF", 1, cf_read(c, 0x0000, data, 1024));
    cf_expect_wkc(c, "a read from the registers into the RAM", 1, cf_read(c, 0x0FF0, data, 32));
    if (end >= 0x10000) {
        cf_note(c, "the RAM fills the address space: no address lies after its end");
        return;
    }
    cf_step(c, "after the end of the RAM, 0x%04X", end);
    cf_expect_wkc(c, "a read across the end of the RAM", 1, cf_read(c, (uint16_t)(end - 4), data, 8));
    cf_expect_wkc(c, "a read after the end of the RAM", 0, cf_read(c, (uint16_t)end, data, 8));
    cf_expect_wkc(c, "a write after the end of the RAM", 0, cf_write(c, (uint16_t)end, data, 8));
    cf_expect(c, "station address afterwards", c->facts.station, cf_get16(c, ECT_REG_STATION_ADDRESS));
}

static void read_only_registers(cf_t *c)
{
    read_only(c, ECT_REG_DL_STATUS, 2, "DL status after a write");
    read_only(c, ECT_REG_AL_STATUS, 2, "AL status after a write");
    read_only(c, ECT_REG_AL_STATUS_CODE, 2, "AL status code after a write");
    read_only(c, ECT_REG_PDI_CONTROL, 2, "PDI control after a write");
    read_only(c, ECT_REG_STATION_ALIAS, 2, "station alias after a write");
    for (unsigned int n = 0; n < c->facts.sms && n < 4; n++) {
        read_only(c, (uint16_t)(CF_SM(n) + ECT_SM_STATUS), 1, "a SyncManager's status after a write");
        read_only(c, (uint16_t)(CF_SM(n) + ECT_SM_PDI_CONTROL), 1, "a SyncManager's PDI control after a write");
    }
}

/* --- ports and errors --------------------------------------------------------------------------------------------- */

static unsigned int open_ports(uint16_t dl_status)
{
    unsigned int open = 0;
    for (unsigned int p = 0; p < 4; p++)
        open += (dl_status & (LOOP_CLOSED << 2 * p)) == 0;
    return open;
}

static void cabling(cf_t *c)
{
    unsigned int open = 0;
    for (uint16_t n = 0; n < c->facts.slaves; n++) {
        uint8_t status[2] = {0};
        (void)cf_command(c, CF_FPRD, (uint16_t)(CF_STATION + n), ECT_REG_DL_STATUS, status, 2);
        open += open_ports(ect_load_le16(status));
    }
    uint16_t status = cf_get16(c, ECT_REG_DL_STATUS);
    for (unsigned int p = 0; p < 4; p++) {
        bool closed = (status & (LOOP_CLOSED << 2 * p)) != 0, talks = (status & (COMMUNICATION << 2 * p)) != 0;
        bool there = (c->facts.ports >> 2 * p & 3) >= 2;
        cf_expect_that(c, there || (closed && !talks),
                       "port %u, absent from the descriptor 0x%02X: expected closed, got DL status 0x%04X", p,
                       c->facts.ports, status);
        cf_expect_that(c, !talks || (status & (LINK << p)) != 0 || (c->facts.ports >> 2 * p & 3) == 2,
                       "port %u communicates: expected a link, got DL status 0x%04X", p, status);
        cf_expect_that(c, closed || talks, "port %u is open: expected communication, got DL status 0x%04X", p, status);
    }
    cf_expect_bits(c, "DL status: the SII is loaded", 1, 1, status);
    unsigned int expected = 2u * c->facts.slaves - 1;
    if (c->facts.slaves == 1)
        cf_expect_range(c, "open ports of the only slave", 1, 1, open);
    else if (open != expected)
        cf_warn(c, "%u slaves in a tree have %u open ports, got %u", c->facts.slaves, expected, open);
}

/* Builds a frame of one datagram of FRAME_MIN bytes; its header claims `claims` bytes. @return length of the frame */
static size_t odd_frame(uint8_t *frame, uint8_t type, uint16_t claims)
{
    static const uint8_t ethernet[ETHERNET] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1, 0x88, 0xA4};
    memset(frame, 0, FRAME_MIN);
    memcpy(frame, ethernet, sizeof ethernet);
    ect_store_le16(frame + ETHERNET, (uint16_t)(type << 12 | (claims + 12)));
    frame[ETHERNET + 2] = CF_BRD;
    frame[ETHERNET + 3] = 0x77;
    ect_store_le16(frame + ETHERNET + 8, claims);
    return FRAME_MIN;
}

static void error_counters(cf_t *c)
{
    uint8_t frame[FRAME_MIN], zeros[ERRORS] = {0}, got[ERRORS];
    cf_put8(c, ECT_REG_RX_ERROR, 0xFF);
    cf_get(c, ECT_REG_RX_ERROR, got, 12);
    cf_expect_bytes(c, "error counters of the ports after a write", zeros, got, 12);
    cf_put8(c, ECT_REG_LOST_LINK, 0xFF);
    cf_get(c, ECT_REG_LOST_LINK, got, 4);
    cf_expect_bytes(c, "lost link counters after a write", zeros, got, 4);
    cf_put8(c, ECT_REG_PROCESSING_ERROR, 0xFF);
    cf_expect(c, "processing unit error counter after a write", 0, cf_get8(c, ECT_REG_PROCESSING_ERROR));
    if (c->facts.position > 0)
        cf_skip(c, "only the first slave receives bad frames, which it destroys");
    cf_step(c, "a datagram longer than its frame");
    size_t length = odd_frame(frame, 1, 1400);
    (void)cf_raw_frame(c, frame, length, NULL);
    uint8_t one = cf_get8(c, ECT_REG_PROCESSING_ERROR);
    cf_expect_range(c, "processing unit errors after one bad frame", 1, 2, one);
    cf_step(c, "300 more");
    for (int i = 0; i < 300; i++)
        (void)cf_raw_frame(c, frame, length, NULL);
    cf_expect_range(c, "processing unit errors after 300 more bad frames", 255, 255,
                    cf_get8(c, ECT_REG_PROCESSING_ERROR));
    cf_put8(c, ECT_REG_PROCESSING_ERROR, 0);
    cf_expect(c, "processing unit error counter after a write", 0, cf_get8(c, ECT_REG_PROCESSING_ERROR));
    (void)cf_write(c, ECT_REG_RX_ERROR, zeros, 1);
}

/* Tests the write protection, and ends it before the verdict. @return false: not supported by the chip */
static bool protection(cf_t *c)
{
    uint8_t on = 1, off = 0, any = 1, value[4] = {1, 0, 0, 0};
    const uint16_t station = c->facts.station;
    if (cf_write(c, REG_WRITE_PROTECT, &on, 1) != 1 || cf_get8(c, REG_WRITE_PROTECT) != 1)
        return false;
    (void)cf_write(c, SCRATCH, value, sizeof value);
    uint32_t locked = cf_get32(c, SCRATCH);
    cf_datagram_t d[2] = {
        {.command = CF_FPWR, .address = CF_AT(station, REG_WRITE_ENABLE), .length = 1, .data = &any},
        {.command = CF_FPWR, .address = CF_AT(station, SCRATCH), .length = sizeof value, .data = value}};
    cf_exchange(c, d, 2);
    uint32_t unlocked = cf_get32(c, SCRATCH);
    cf_datagram_t release[2] = {
        {.command = CF_FPWR, .address = CF_AT(station, REG_WRITE_ENABLE), .length = 1, .data = &any},
        {.command = CF_FPWR, .address = CF_AT(station, REG_WRITE_PROTECT), .length = 1, .data = &off}};
    cf_exchange(c, release, 2);
    cf_expect(c, "a protected register after a write", 0, locked);
    cf_expect(c, "a protected register after a write with the enable in the same frame", 1, unlocked);
    return true;
}

/* Writes two letters of the reset sequence, whose progress the chip reports, and a wrong third one, which must abort
 * the sequence. Any frame between two letters aborts it too, even a read of the progress, so each try starts with a
 * wrong letter. @return false: not supported by the chip */
static bool reset_sequence(cf_t *c)
{
    uint8_t letters[4] = {'X', 'R', 'E', 'X'}, progress[3];
    for (size_t i = 0; i < sizeof progress; i++) {
        for (size_t k = 0; k <= i + 1; k++) {
            if (cf_write(c, REG_RESET, &letters[k], 1) != 1)
                return false;
        }
        progress[i] = cf_get8(c, REG_RESET) & 3;
    }
    if (progress[0] == 0)
        return false;
    cf_expect(c, "progress of the reset after R", 1, progress[0]);
    cf_expect(c, "progress of the reset after R E", 2, progress[1]);
    cf_expect(c, "progress of the reset after a wrong third letter", 0, progress[2]);
    return true;
}

static void protection_and_reset(cf_t *c)
{
    bool has_protection = protection(c);
    bool has_reset = reset_sequence(c);
    if (!has_protection && !has_reset)
        cf_skip(c, "the chip offers neither write protection nor a reset over EtherCAT");
    if (!has_protection || !has_reset)
        cf_note(c, "the chip offers no %s", has_reset ? "write protection" : "reset over EtherCAT");
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

static void many_datagrams(cf_t *c, size_t count)
{
    cf_datagram_t d[15];
    uint8_t data[15][15];
    memset(data, 0, sizeof data);
    for (size_t i = 0; i < count; i++)
        d[i] = (cf_datagram_t){.command = i % 2 == 0 ? CF_FPRD : CF_APRD,
                               .address = CF_AT(i % 2 == 0 ? c->facts.station : c->facts.ring, ECT_REG_STATION_ADDRESS),
                               .length = (uint16_t)(i + 1),
                               .data = data[i]};
    cf_exchange(c, d, count);
    for (size_t i = 0; i < count; i++) {
        cf_expect_wkc(c, "each datagram of the frame", 1, d[i].wkc);
        cf_expect(c, "data of each datagram", c->facts.station & 0xFF, data[i][0]);
    }
}

static void lengths(cf_t *c)
{
    static uint8_t most[CF_MAX_DATA];
    cf_datagram_t none = {.command = CF_FPRD, .address = CF_AT(c->facts.station, ECT_REG_TYPE), .length = 0};
    cf_step(c, "the longest datagram, %d bytes", (int)CF_MAX_DATA);
    cf_expect_wkc(c, "the longest datagram", 1, cf_read(c, ECT_REG_TYPE, most, sizeof most));
    cf_expect(c, "its first byte", c->facts.type, most[0]);
    cf_step(c, "a datagram without data");
    cf_exchange(c, &none, 1);
    cf_expect_wkc(c, "a datagram without data", 0, none.wkc);
}

/* The frame must not be processed: it is lost, or returns unchanged. */
static void not_processed(cf_t *c, const uint8_t *frame, size_t length, const char *what)
{
    uint8_t reply[CF_MAX_FRAME];
    size_t got = cf_raw_frame(c, frame, length, reply);
    cf_expect_that(c, got == 0 || memcmp(reply + ETHERNET, frame + ETHERNET, length - ETHERNET) == 0,
                   "%s: expected not to be processed, got a reply of %zu bytes", what, got);
}

static void frames(cf_t *c)
{
    uint8_t frame[FRAME_MIN];
    cf_step(c, "15 datagrams of 1 to 15 bytes");
    many_datagrams(c, 15);
    lengths(c);
    cf_step(c, "a datagram longer than its frame");
    size_t length = odd_frame(frame, 1, 1400);
    not_processed(c, frame, length, "a datagram longer than its frame");
    cf_step(c, "EtherCAT type 4, network variables");
    length = odd_frame(frame, 4, 4);
    not_processed(c, frame, length, "a frame of type 4");
    cf_expect(c, "station address afterwards", c->facts.station, cf_get16(c, ECT_REG_STATION_ADDRESS));
}

/* The frame must return; a second try, because a busy machine may lose one frame. */
static void must_pass(cf_t *c, const char *what, const uint8_t *frame, size_t length, uint8_t *reply)
{
    size_t got = 0;
    for (int tries = 0; got == 0 && tries < 5; tries++)
        got = cf_raw_frame(c, frame, length, reply);
    cf_expect_that(c, got >= ETHERNET + 18, "%s: expected to return, got no reply", what);
}

/* The circulating flag is for an isolated part of a ring: with port 0 open, no ESC sets or checks it. */
static void circulating(cf_t *c)
{
    uint8_t frame[FRAME_MIN], reply[CF_MAX_FRAME] = {0};
    size_t length = odd_frame(frame, 1, 4);
    cf_step(c, "a frame with the circulating flag, port 0 open");
    frame[ETHERNET + 9] |= 0x40;
    must_pass(c, "a frame with the circulating flag", frame, length, reply);
    cf_expect_bits(c, "the circulating flag of a frame sent with the flag", 0x40, 0x40, reply[ETHERNET + 9]);
    frame[ETHERNET + 9] &= 0xBF;
    must_pass(c, "a plain frame", frame, length, reply);
    cf_expect_bits(c, "the circulating flag of a frame sent without the flag", 0x40, 0, reply[ETHERNET + 9]);
    cf_note(c, "with port 0 open; what a closed port 0 does needs a ring");
}

static void complete(cf_t *c)
{
    for (size_t count = 1; count <= 15; count++)
        many_datagrams(c, count);
    cf_note(c, "complete; the delay of a frame cannot be measured by a PC");
}

/* --- events ------------------------------------------------------------------------------------------------------- */

/* @return the IRQ field of a datagram that clears no event */
static uint16_t irq_field(cf_t *c)
{
    uint8_t type = 0;
    cf_datagram_t d = {
        .command = CF_FPRD, .address = CF_AT(c->facts.station, ECT_REG_TYPE), .length = 1, .data = &type};
    cf_exchange(c, &d, 1);
    return d.irq;
}

static void event_mask(cf_t *c, uint16_t mask)
{
    uint8_t zeros[2] = {0};
    (void)cf_command(c, CF_BWR, 0, ECT_REG_ECAT_EVENT_MASK, zeros,
                     sizeof zeros); /* of all slaves: the IRQ field is ORed */
    cf_put16(c, ECT_REG_ECAT_EVENT_MASK, mask);
}

static void ecat_events(cf_t *c)
{
    uint8_t status[6], last;
    cf_set_mailbox(c, CF_PREOP);
    event_mask(c, 0);
    cf_get(c, ECT_REG_AL_STATUS, status, sizeof status);
    cf_expect_bits(c, "ECAT event (0x0210) after a read of AL status", ECT_ECAT_EVENT_AL_STATUS, 0,
                   cf_get16(c, ECT_REG_ECAT_EVENT));
    cf_step(c, "PREOP without reading AL status: the event reports the change");
    cf_put16(c, ECT_REG_AL_CONTROL, CF_PREOP);
    bool came =
        cf_wait_bits(c, ECT_REG_ECAT_EVENT, ECT_ECAT_EVENT_AL_STATUS, ECT_ECAT_EVENT_AL_STATUS, EVENT_MS, &last);
    cf_expect_that(c, came, "ECAT event (0x0210): expected bit 3 within %d ms, got 0x%02X", (int)EVENT_MS, last);
    cf_expect_bits(c, "IRQ field, event mask 0x0000", ECT_ECAT_EVENT_AL_STATUS, 0, irq_field(c));
    event_mask(c, ECT_ECAT_EVENT_AL_STATUS);
    cf_expect_bits(c, "IRQ field, event mask 0x0008", ECT_ECAT_EVENT_AL_STATUS, ECT_ECAT_EVENT_AL_STATUS, irq_field(c));
    cf_step(c, "a read of AL status clears the event");
    cf_get(c, ECT_REG_AL_STATUS, status, sizeof status);
    cf_expect_bits(c, "ECAT event (0x0210) after a read of AL status", ECT_ECAT_EVENT_AL_STATUS, 0,
                   cf_get16(c, ECT_REG_ECAT_EVENT));
    cf_expect_bits(c, "IRQ field after a read of AL status", ECT_ECAT_EVENT_AL_STATUS, 0, irq_field(c));
}

static const cf_case_t cases[] = {
    {"CF-001", "Type, FMMUs, SyncManagers, RAM and features are consistent and read-only", 'R', 0, 0, information},
    {"CF-002", "BRD ORs the registers of all slaves; each slave increments WKC and ADP", 'R', 0, 0, broadcast},
    {"CF-003", "APRD, APWR, APRW address the slave by position; every slave increments ADP", 'R', 0, 0, by_position},
    {"CF-004", "FPRD, FPWR, FPRW address the slave by station address and enabled alias only", 'R', 0, 0, by_station},
    {"CF-005",
     "The working counter increments by 1 for a read, 1 for a write, 3 for both, 1 + 2 for LRW; a failed part adds "
     "nothing",
     'R', 0, 0, counters},
    {"CF-006", "ARMW and FRMW: the addressed slave is read, all others are written", 'R', 0, 0, multiple_write},
    {"CF-007", "NOP and unknown commands leave data, address and WKC unchanged", 'R', 0, 0, no_operation},
    {"CF-008", "Accesses to missing ranges have no effect; after the end of the RAM WKC is 0", 'R', 0, 0,
     missing_ranges},
    {"CF-009", "Read-only registers are unchanged by writes", 'R', 0, 0, read_only_registers},
    {"CF-010", "DL status matches the cabling", 'R', 0, 0, cabling},
    {"CF-011", "Error counters count up to 255 and are cleared by a write", 'R', 0, 0, error_counters},
    {"CF-012", "Write protection and reset sequence work as described", 'R', 0, 0, protection_and_reset},
    {"CF-013",
     "Frames with several datagrams, odd, maximum and zero lengths are processed, damaged and foreign frames are not",
     'R', 0, 0, frames},
    {"CF-014", "The circulating flag has no effect while port 0 is open", 'R', 0, 0, circulating},
    {"CF-015", "A frame of 1 to 15 datagrams returns complete", 'T', 0, 0, complete},
    {"CF-097", "A change of AL status is an ECAT event, masked in the IRQ field, and cleared by a read of AL status",
     'R', CF_APPLICATION, 0, ecat_events},
};

CF_SECTION(cf_datalink, 'A', "Data link and ESC registers", cases);
