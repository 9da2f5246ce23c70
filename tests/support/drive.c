/* SPDX-License-Identifier: MIT */
#include "support/drive.h"

#include <string.h>

#include "devices/pmctendo/pmctendo.h"

enum { OUTPUTS = 0x1100, INPUTS = 0x1140, NO = DRIVE_NOWHERE };

/* clang-format off */
static const drive_out_t outs[] = {
    /* pdo  bytes  control  set  latch_control  torque_ahead  outputs  max_torque */
    {0x1701,  6,      4,     0,       NO,            NO,        NO,       NO},
    {0x1702,  6,      4,     0,       NO,            NO,        NO,       NO},
    {0x1704,  4,      2,     0,       NO,            NO,        NO,       NO},
    {0x1720, 12,      0,     2,        6,             8,        10,       NO},
    {0x1721,  8,      4,     0,       NO,             6,        NO,       NO},
    {0x1722, 14,      0,     2,        6,             8,        10,       12},
};
static const drive_in_t ins[] = {
    /* pdo  bytes  status  position  latch_status  latch1  latch2  torque  following_error  inputs */
    {0x1B01,  6,      4,       0,         NO,        NO,     NO,     NO,         NO,          NO},
    {0x1B25, 32,     24,       0,         28,        20,      8,     26,         16,          12},
    {0x1B26, 16,      0,       2,         NO,        NO,     NO,     NO,         12,           8},
};
/* clang-format on */

static void choose(drive_t *d, uint16_t out, uint16_t in)
{
    d->to = (drive_out_t){0};
    d->from = (drive_in_t){0};
    for (size_t i = 0; i < sizeof outs / sizeof outs[0]; i++)
        d->to = outs[i].pdo == out ? outs[i] : d->to;
    for (size_t i = 0; i < sizeof ins / sizeof ins[0]; i++)
        d->from = ins[i].pdo == in ? ins[i] : d->from;
    assert_true(d->to.bytes > 0 && d->from.bytes > 0);
}

void drive_open_with(drive_t *d, const ect_storage_t *storage)
{
    ect_twin_config_t twin = ect_twin_default(&ect_pmctendo_dd5, &ect_pmctendo_dd5_plant);
    twin.storage = storage;
    memset(d, 0, sizeof *d);
    d->cycle_ns = MS;
    wire_open_twins(&d->w, &twin, 1);
    wire_go(&d->w, 0, ECT_STATE_PREOP);
}

void drive_open(drive_t *d)
{
    drive_open_with(d, NULL);
}

void drive_close(drive_t *d)
{
    wire_close(&d->w);
}

pmctendo_t *drive_instance(drive_t *d)
{
    return ect_chain_slave(d->w.chain, 0)->config.instance;
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static void assign(drive_t *d, uint16_t index, uint16_t pdo)
{
    assert_int_equal(drive_write(d, index, 0, 0, 1), 0);
    assert_int_equal(drive_write(d, index, 1, pdo, 2), 0);
    assert_int_equal(drive_write(d, index, 0, 1, 1), 0);
}

static void start_sync0(drive_t *d)
{
    uint8_t bytes[8];
    ect_store_le32(bytes, d->dc_ns);
    assert_int_equal(wire_write(&d->w, 0, ECT_REG_DC_SYNC0_CYCLE, bytes, 4), 1);
    assert_int_equal(wire_read(&d->w, 0, ECT_REG_DC_SYSTEM_TIME, bytes, 8), 1);
    ect_store_le64(bytes, ect_load_le64(bytes) + d->dc_ns / 2);
    assert_int_equal(wire_write(&d->w, 0, ECT_REG_DC_START_TIME, bytes, 8), 1);
    assert_int_equal(wire_write8(&d->w, 0, ECT_REG_DC_ACTIVATION, 0x03), 1);
}

void drive_safeop(drive_t *d, uint16_t out, uint16_t in)
{
    uint16_t code = 0;
    choose(d, out, in);
    assign(d, 0x1C12, out);
    assign(d, 0x1C13, in);
    wire_set_sm(&d->w, 0, 2, OUTPUTS, d->to.bytes, 0x64);
    wire_set_sm(&d->w, 0, 3, INPUTS, d->from.bytes, 0x20);
    if (d->dc_ns != 0)
        start_sync0(d);
    memset(d->out, 0, sizeof d->out);
    if (wire_al(&d->w, 0, ECT_STATE_SAFEOP, &code) != ECT_STATE_SAFEOP)
        fail_msg("SAFEOP with %04X and %04X is refused, code %04X", out, in, code);
}

void drive_operational(drive_t *d, uint16_t out, uint16_t in)
{
    drive_safeop(d, out, in);
    drive_cycle(d);
    (void)wire_al(&d->w, 0, ECT_STATE_OP, NULL);
    for (unsigned int n = 0; n < 100 && wire_read8(&d->w, 0, ECT_REG_AL_STATUS) != ECT_STATE_OP; n++)
        drive_cycle(d);
    assert_int_equal(wire_read8(&d->w, 0, ECT_REG_AL_STATUS), ECT_STATE_OP);
    drive_cycle(d);
}

/* --- cycles ------------------------------------------------------------------------------------------------------- */

uint16_t drive_status(drive_t *d)
{
    assert_int_equal(wire_read(&d->w, 0, INPUTS, d->in, d->from.bytes), 1);
    return ect_load_le16(d->in + d->from.status);
}

void drive_cycle(drive_t *d)
{
    assert_int_equal(wire_write(&d->w, 0, OUTPUTS, d->out, d->to.bytes), 1);
    wire_advance(&d->w, d->cycle_ns);
    (void)drive_status(d);
}

void drive_cycles(drive_t *d, unsigned int count)
{
    while (count-- > 0)
        drive_cycle(d);
}

void drive_control(drive_t *d, uint16_t control)
{
    ect_store_le16(d->out + d->to.control, control);
}

uint16_t drive_controlled(const drive_t *d)
{
    return ect_load_le16(d->out + d->to.control);
}

void drive_set(drive_t *d, int32_t value)
{
    if (d->to.pdo == PMC_PDO_TORQUE)
        ect_store_le16(d->out + d->to.set, (uint16_t)value);
    else
        ect_store_le32(d->out + d->to.set, (uint32_t)value);
}

void drive_latch(drive_t *d, uint16_t control)
{
    assert_true(d->to.latch_control != NO);
    ect_store_le16(d->out + d->to.latch_control, control);
}

int32_t drive_position(const drive_t *d)
{
    return (int32_t)ect_load_le32(d->in + d->from.position);
}

uint16_t drive_latch_status(const drive_t *d)
{
    assert_true(d->from.latch_status != NO);
    return ect_load_le16(d->in + d->from.latch_status);
}

int32_t drive_latched(const drive_t *d, unsigned int n)
{
    return (int32_t)ect_load_le32(d->in + (n == 1 ? d->from.latch1 : d->from.latch2));
}

unsigned int drive_until(drive_t *d, uint16_t mask, uint16_t want, unsigned int limit_ms)
{
    for (unsigned int ms = 0; ms <= limit_ms; ms++) {
        drive_cycle(d);
        if ((ect_load_le16(d->in + d->from.status) & mask) == want)
            return ms;
    }
    fail_msg("after %u ms: expected status %04X of %04X, got %04X", limit_ms, want, mask,
             ect_load_le16(d->in + d->from.status));
    return 0;
}

void drive_expect(drive_t *d, ect_402_state_t state, const char *when)
{
    static const struct {
        uint16_t mask, value;
    } codes[ECT_402_STATES] = {{0x4F, 0x00}, {0x4F, 0x40}, {0x6F, 0x21}, {0x6F, 0x23},
                               {0x6F, 0x27}, {0x6F, 0x07}, {0x4F, 0x0F}, {0x4F, 0x08}};
    uint16_t status = drive_status(d);
    if ((status & codes[state].mask) != codes[state].value)
        fail_msg("%s: expected status %02X of %02X, got %04X", when, codes[state].value, codes[state].mask, status);
}

void drive_enable(drive_t *d)
{
    if (d->to.pdo != PMC_PDO_SPEED && d->to.pdo != PMC_PDO_TORQUE)
        drive_set(d, drive_position(d));
    drive_control(d, 0x06);
    (void)drive_until(d, 0x6F, 0x21, 10);
    drive_control(d, 0x07);
    (void)drive_until(d, 0x6F, 0x23, 10);
    drive_control(d, 0x0F);
    (void)drive_until(d, 0x6F, 0x27, 10);
}

/* --- by mailbox --------------------------------------------------------------------------------------------------- */

uint32_t drive_write(drive_t *d, uint16_t index, uint8_t subindex, uint32_t value, size_t size)
{
    uint8_t data[4];
    ect_store_le32(data, value);
    return wire_sdo_download(&d->w, 0, index, subindex, false, data, size);
}

uint32_t drive_read(drive_t *d, uint16_t index, uint8_t subindex)
{
    uint8_t data[4] = {0};
    size_t size = sizeof data;
    uint32_t abort = wire_sdo_upload(&d->w, 0, index, subindex, false, data, &size);
    if (abort != 0)
        fail_msg("%04Xh:%u: abort %08X", index, subindex, abort);
    return ect_load_le32(data);
}
