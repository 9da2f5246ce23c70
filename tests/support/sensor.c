/* SPDX-License-Identifier: MIT */
#include "support/sensor.h"

#include <stdlib.h>
#include <string.h>

#include "devices/fzm1/fzm1.h"

enum { OUTPUTS = 0x1100, INPUTS = 0x1200, CONTROL_IN = 0, CONTROL_OUT = 0, DATA = 16 };
enum { CODE = 4, PARAMETER = 8, RESPONSE_CODE = 4, RESULT = 8, RESPONSE_DATA = 12 };

void sensor_open_with(sensor_t *s, const ect_storage_t *storage)
{
    ect_twin_config_t twin = ect_twin_default(&ect_fzm1, &ect_fzm1_plant);
    twin.storage = storage;
    memset(s, 0, sizeof *s);
    wire_open_twins(&s->w, &twin, 1);
    sensor_operational(s);
}

void sensor_open(sensor_t *s)
{
    sensor_open_with(s, NULL);
}

void sensor_operational(sensor_t *s)
{
    memset(s->out, 0, sizeof s->out);
    assert_int_equal(wire_write16(&s->w, 0, ECT_REG_WD_TIME_PD, 0), 1);
    wire_go(&s->w, 0, ECT_STATE_OP);
    sensor_exchange(s);
}

void sensor_close(sensor_t *s)
{
    wire_close(&s->w);
}

fzm1_t *sensor_instance(sensor_t *s)
{
    return ect_chain_slave(s->w.chain, 0)->config.instance;
}

uint32_t sensor_read(sensor_t *s)
{
    assert_int_equal(wire_read(&s->w, 0, INPUTS, s->in, sizeof s->in), 1);
    return ect_load_le32(s->in + CONTROL_OUT);
}

void sensor_exchange(sensor_t *s)
{
    assert_int_equal(wire_write(&s->w, 0, OUTPUTS, s->out, sizeof s->out), 1);
    (void)sensor_read(s);
}

void sensor_set(sensor_t *s, uint32_t signals, bool on)
{
    uint32_t control = ect_load_le32(s->out + CONTROL_IN);
    ect_store_le32(s->out + CONTROL_IN, on ? control | signals : control & ~signals);
    sensor_exchange(s);
}

uint32_t sensor_wait(sensor_t *s, uint64_t ns)
{
    wire_advance(&s->w, ns);
    return sensor_read(s);
}

void sensor_expect(sensor_t *s, const char *when, uint32_t mask, uint32_t want)
{
    uint32_t got = sensor_read(s) & mask;
    if (got != want)
        fail_msg("%s: expected control signals %05X of %05X, got %05X", when, want, mask, got);
}

uint64_t sensor_until(sensor_t *s, uint32_t mask, uint32_t want)
{
    uint64_t from = s->w.now_ns;
    while ((sensor_read(s) & mask) != want) {
        if (s->w.now_ns - from > 60000 * MS)
            fail_msg("control signals %05X of %05X never came, they are %05X", want, mask, sensor_read(s) & mask);
        uint64_t next = ect_chain_poll(s->w.chain, s->w.now_ns);
        wire_advance(&s->w, next == ECT_NEVER ? 61000 * MS : next - s->w.now_ns);
    }
    return s->w.now_ns - from;
}

int32_t sensor_data(sensor_t *s, unsigned int n)
{
    (void)sensor_read(s);
    return (int32_t)ect_load_le32(s->in + DATA + 4 * (n - 1));
}

void sensor_prepare(sensor_t *s, uint32_t code, int32_t p1, int32_t p2, int32_t p3)
{
    const int32_t parameters[] = {p1, p2, p3};
    ect_store_le32(s->out + CODE, code);
    for (unsigned int i = 0; i < 3; i++)
        ect_store_le32(s->out + PARAMETER + 4 * i, (uint32_t)parameters[i]);
}

uint32_t sensor_command(sensor_t *s, uint32_t code, int32_t p1, int32_t p2, int32_t p3, int32_t *data)
{
    sensor_prepare(s, code, p1, p2, p3);
    sensor_set(s, FZM1_EXE, true);
    (void)sensor_until(s, FZM1_FLG, FZM1_FLG);
    uint32_t echo = ect_load_le32(s->in + RESPONSE_CODE);
    if (echo != code)
        fail_msg("command %08X: the response echoes %08X", code, echo);
    if (data)
        *data = (int32_t)ect_load_le32(s->in + RESPONSE_DATA);
    uint32_t result = ect_load_le32(s->in + RESULT);
    sensor_set(s, FZM1_EXE, false);
    sensor_expect(s, "EXE off", FZM1_FLG, 0);
    return result;
}

void sensor_step(sensor_t *s)
{
    sensor_set(s, FZM1_STEP, true);
    sensor_expect(s, "STEP", FZM1_READY | FZM1_BUSY, FZM1_BUSY);
    sensor_set(s, FZM1_STEP, false);
}

/* --- memory ------------------------------------------------------------------------------------------------------- */

static int memory_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    sensor_memory_t *m = ctx;
    if (m->reads == 0)
        return -1;
    m->reads -= m->reads == UINT32_MAX ? 0 : 1;
    memcpy(buffer, m->bank[bank] + offset, length);
    return 0;
}

static int memory_erase(void *ctx, unsigned int bank)
{
    sensor_memory_t *m = ctx;
    if (m->budget == 0)
        return -1;
    if (m->lazy == 0)
        memset(m->bank[bank], 0xFF,
               SENSOR_BANK); /* otherwise a file, whose old content remains until it is overwritten */
    return 0;
}

/* Keeps the previous content; of many writes, the first ones become safe without a flush. */
static void cache(sensor_memory_t *m, unsigned int bank, uint32_t offset, uint32_t length)
{
    assert_true(length <= sizeof m->cache[0].before);
    if (m->lazy == 0)
        return;
    if (m->cached == SENSOR_UNSAFE) {
        memmove(m->cache, m->cache + 1, sizeof m->cache - sizeof m->cache[0]);
        m->cached--;
    }
    m->cache[m->cached].bank = bank;
    m->cache[m->cached].offset = offset;
    m->cache[m->cached].length = length;
    memcpy(m->cache[m->cached++].before, m->bank[bank] + offset, length);
    m->flushes = 0;
}

static int memory_flush(void *ctx, unsigned int bank, bool wait)
{
    sensor_memory_t *m = ctx;
    (void)bank;
    if (m->unsafe)
        return -1;
    if (!wait && m->cached > 0 && ++m->flushes < m->lazy)
        return ECT_STORAGE_BUSY;
    m->cached = 0;
    return 0;
}

void sensor_memory_cut(sensor_memory_t *m, uint32_t written_mask)
{
    while (m->cached > 0) { /* the last one first: each restores the content before it */
        m->cached--;
        if ((written_mask >> (m->cached % 32) & 1) != 0)
            memcpy(m->bank[m->cache[m->cached].bank] + m->cache[m->cached].offset, m->cache[m->cached].before,
                   m->cache[m->cached].length);
    }
}

bool sensor_memory_dirty(const sensor_memory_t *m)
{
    return m->cached > 0;
}

static int memory_write(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length)
{
    sensor_memory_t *m = ctx;
    uint32_t part = length < m->budget ? length : m->budget;
    m->written += length;
    cache(m, bank, offset, length);
    memcpy(m->bank[bank] + offset, data, part);
    m->budget -= m->budget == UINT32_MAX ? 0 : part;
    return part == length ? 0 : -1;
}

void sensor_memory_open(sensor_memory_t *m)
{
    *m = (sensor_memory_t){.budget = UINT32_MAX, .reads = UINT32_MAX};
    for (unsigned int i = 0; i < 2; i++) {
        m->bank[i] = malloc(SENSOR_BANK);
        assert_non_null(m->bank[i]);
        memset(m->bank[i], 0xFF, SENSOR_BANK);
    }
    m->storage = (ect_storage_t){.ctx = m,
                                 .bank_size = SENSOR_BANK,
                                 .read = memory_read,
                                 .erase = memory_erase,
                                 .write = memory_write,
                                 .flush = memory_flush};
}

void sensor_memory_close(sensor_memory_t *m)
{
    free(m->bank[0]);
    free(m->bank[1]);
}
