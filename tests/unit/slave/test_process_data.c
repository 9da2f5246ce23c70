/* SPDX-License-Identifier: MIT */
/* The process image: its layout, the time at which outputs are applied and inputs are valid, and mappings that fail. */
#include <stdio.h>
#include <string.h>

#include "devices/eclink/eclink.h"
#include "support/every.h"
#include "support/testdev.h"
#include "support/wire.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };
enum { SM2 = 0x1200, SM3 = 0x1300, IMAGE = 3, ROOM = 80 };

/* --- helpers ----------------------------------------------------------------------------------------------------- */

static void open_in(wire_t *w, uint8_t state)
{
    wire_open_one(w, &testdev);
    wire_go(w, 0, state);
}

static ect_slave_t *slave_of(wire_t *w)
{
    return (ect_slave_t *)(uintptr_t)ect_chain_slave(w->chain, 0);
}

static int write_outputs(wire_t *w, uint32_t image)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, image);
    return wire_write(w, 0, SM2, bytes, IMAGE);
}

/* Twice, because the first read fetches data that were prepared before. */
static uint32_t read_inputs(wire_t *w)
{
    uint8_t bytes[4] = {0};
    assert_int_equal(wire_read(w, 0, SM3, bytes, IMAGE), 1);
    memset(bytes, 0xEE, IMAGE);
    assert_int_equal(wire_read(w, 0, SM3, bytes, IMAGE), 1);
    return ect_load_le32(bytes);
}

static void expect_state(wire_t *w, const char *where, uint8_t status, uint16_t code)
{
    uint8_t bytes[6] = {0};
    assert_int_equal(wire_read(w, 0, ECT_REG_AL_STATUS, bytes, 6), 1);
    if (bytes[0] != status || ect_load_le16(bytes + 4) != code)
        fail_msg("%s: expected AL status 0x%02X code 0x%04X, got 0x%02X code 0x%04X", where, status, code, bytes[0],
                 ect_load_le16(bytes + 4));
}

static uint32_t draw(uint32_t *x, uint32_t below)
{
    *x = *x * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)(*x >> 8) * below) >> 24);
}

/* --- the image of the test device -------------------------------------------------------------------------------- */

static void expect_outputs(wire_t *w, uint32_t image)
{
    const testdev_t *t = testdev_of(w, 0);
    if (t->out_bool != (image & 1) || t->out_u16 != ((image >> 8) & 0xFFFF))
        fail_msg("image 0x%06X: output bit %u, output word 0x%04X", image, t->out_bool, t->out_u16);
}

static void outputs_bit_by_bit(void **state)
{
    (void)state;
    wire_t w;
    open_in(&w, OP);
    for (unsigned int bit = 0; bit < 24; bit++) {
        assert_int_equal(write_outputs(&w, 1u << bit), 1);
        expect_outputs(&w, 1u << bit);
        assert_int_equal(write_outputs(&w, ~(1u << bit)), 1);
        expect_outputs(&w, ~(1u << bit));
    }
    uint32_t x = 1;
    for (unsigned int n = 0; n < 500; n++) {
        uint32_t image = draw(&x, 1u << 24);
        assert_int_equal(write_outputs(&w, image), 1);
        expect_outputs(&w, image);
    }
    wire_close(&w);
}

static void expect_inputs(wire_t *w, uint16_t word, uint8_t bits)
{
    testdev_of(w, 0)->in_u16 = word;
    testdev_of(w, 0)->in_bits = bits;
    uint32_t image = read_inputs(w);
    if (image != (word | ((uint32_t)(bits & 7u) << 16)))
        fail_msg("input word 0x%04X, bits 0x%02X: image 0x%06X", word, bits, image);
}

static void inputs_bit_by_bit(void **state)
{
    (void)state;
    static const uint8_t states[] = {SAFEOP, OP};
    for (size_t s = 0; s < COUNT(states); s++) {
        wire_t w;
        open_in(&w, states[s]);
        for (unsigned int bit = 0; bit < 16; bit++) {
            expect_inputs(&w, (uint16_t)(1u << bit), 0);
            expect_inputs(&w, (uint16_t)~(1u << bit), 7);
        }
        for (unsigned int bits = 0; bits < 256; bits++)
            expect_inputs(&w, 0, (uint8_t)bits);
        wire_close(&w);
    }
}

/* --- when -------------------------------------------------------------------------------------------------------- */

static void outputs_rest_in_safeop(void **state)
{
    (void)state;
    wire_t w;
    open_in(&w, SAFEOP);
    const testdev_t *t = testdev_of(&w, 0);
    for (unsigned int n = 0; n < 10; n++) {
        assert_int_equal(write_outputs(&w, 0xFFFF00u | n), 1);
        expect_outputs(&w, 0);
        uint8_t event[4];
        assert_int_equal(wire_read(&w, 0, ECT_REG_AL_EVENT, event, 4), 1);
        assert_int_equal(ect_load_le32(event) & ECT_EVENT_SM2, 0);
    }
    assert_int_equal(t->outputs_calls, 0);
    assert_int_equal(t->safe_calls, 0);
    assert_int_equal(write_outputs(&w, 0xABCD01), 1);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, OP);
    expect_state(&w, "to OP", OP, 0);
    expect_outputs(&w, 0xABCD01);
    unsigned int calls = t->outputs_calls;
    assert_true(calls > 0);
    assert_int_equal(write_outputs(&w, 0x123400), 1);
    assert_int_equal(t->outputs_calls, calls + 1);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP);
    expect_outputs(&w, 0);
    assert_int_equal(t->safe_calls, 1);
    assert_int_equal(write_outputs(&w, 0xFFFFFF), 1);
    expect_outputs(&w, 0);
    assert_int_equal(t->outputs_calls, calls + 1);
    wire_close(&w);
}

static void no_data_below_safeop(void **state)
{
    (void)state;
    wire_t w;
    uint8_t image[IMAGE] = {0xFF, 0xFF, 0xFF};
    open_in(&w, PREOP);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_write(&w, 0, SM2, image, IMAGE), 0);
    assert_int_equal(wire_read(&w, 0, SM3, image, IMAGE), 0);
    assert_int_equal(testdev_of(&w, 0)->inputs_calls, 0);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP);
    expect_state(&w, "to SAFEOP", SAFEOP, 0);
    assert_int_equal(wire_read(&w, 0, SM3, image, IMAGE), 1);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, PREOP);
    expect_state(&w, "to PREOP", PREOP, 0);
    assert_int_equal(wire_read(&w, 0, SM3, image, IMAGE), 0);
    assert_int_equal(wire_write(&w, 0, SM2, image, IMAGE), 0);
    wire_close(&w);
}

/* Reads the chip at the moment when AL status is written. */
typedef struct spy {
    ect_pdi_t real;
    ect_pdi_t pdi;
    unsigned int sm;       /* the first one with inputs */
    unsigned int buffer;   /* its buffer that holds inputs then; 3: none */
    uint16_t first_inputs; /* the first two bytes of it */
    bool seen;
} spy_t;

static int spy_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    spy_t *spy = ctx;
    return spy->real.read(spy->real.ctx, address, buffer, length);
}

static int spy_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    spy_t *spy = ctx;
    const ect_esc_t *esc = spy->real.ctx;
    if (address == ECT_REG_AL_STATUS && (((const uint8_t *)buffer)[0] & 0x0F) == SAFEOP && !spy->seen) {
        spy->seen = true;
        const uint8_t *sm = esc->memory + ECT_REG_SM + spy->sm * ECT_SM_SIZE;
        spy->buffer = (unsigned int)(sm[ECT_SM_STATUS] >> 4) & 3u;
        if (spy->buffer < 3)
            spy->first_inputs =
                ect_load_le16(esc->memory + ect_load_le16(sm) + spy->buffer * ect_load_le16(sm + ECT_SM_LENGTH));
    }
    return spy->real.write(spy->real.ctx, address, buffer, length);
}

static void inputs_before_safeop(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        const ect_device_t *device = every_device(i);
        wire_t w;
        wire_open_one(&w, device);
        wire_go(&w, 0, PREOP);
        wire_configure_process_data(&w, 0);
        spy_t spy = {.real = *slave_of(&w)->config.pdi, .sm = first_sm_of(device, ECT_SM_INPUTS)};
        while (ect_device_sm_bytes(device, spy.sm) == 1) /* a SyncManager of one byte has no buffers */
            spy.sm++;
        spy.pdi = (ect_pdi_t){.ctx = &spy, .read = spy_read, .write = spy_write};
        slave_of(&w)->config.pdi = &spy.pdi;
        if (i == 0)
            testdev_of(&w, 0)->in_u16 = 0x7788;
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP);
        assert_true(spy.seen);
        if (spy.buffer == 3)
            fail_msg("%s: no inputs in SM%u when SAFEOP is confirmed", device->name, spy.sm);
        if (i == 0)
            assert_int_equal(spy.first_inputs, 0x7788);
        uint8_t image[256];
        assert_int_equal(wire_read(&w, 0, device->sm[spy.sm].start, image, ect_device_sm_bytes(device, spy.sm)), 1);
        wire_close(&w);
    }
}

static uint64_t ticking(void *instance, uint64_t now_ns)
{
    ((testdev_t *)instance)->in_u16++;
    return now_ns + 2 * MS;
}

static void inputs_follow_time(void **state)
{
    (void)state;
    ect_device_t device = testdev;
    device.tick = ticking;
    wire_t w;
    wire_open_one(&w, &device);
    wire_write16(&w, 0, ECT_REG_WD_TIME_PD, 0);
    for (unsigned int s = 0; s < 2; s++) {
        wire_go(&w, 0, s == 0 ? SAFEOP : OP);
        for (unsigned int n = 0; n < 5; n++) {
            wire_advance(&w, 20 * MS);
            uint8_t bytes[IMAGE];
            assert_int_equal(wire_read(&w, 0, SM3, bytes, IMAGE), 1);
            assert_int_equal(ect_load_le16(bytes), testdev_of(&w, 0)->in_u16);
        }
        assert_true(testdev_of(&w, 0)->in_u16 >= 50);
    }
    wire_go(&w, 0, PREOP);
    unsigned int calls = testdev_of(&w, 0)->inputs_calls;
    wire_advance(&w, 20 * MS);
    assert_int_equal(testdev_of(&w, 0)->inputs_calls, calls);
    wire_close(&w);
}

/* --- logical addressing ------------------------------------------------------------------------------------------ */

static void map(wire_t *w, size_t position, uint32_t out, uint32_t in)
{
    const ect_device_t *device = wire_device(w, position);
    if (ect_device_sm_bytes(device, 2) > 0)
        wire_set_fmmu(w, position, 0, out, ect_device_sm_bytes(device, 2), 0, 7, device->sm[2].start, 0, 2);
    wire_set_fmmu(w, position, 1, in, ect_device_sm_bytes(device, 3), 0, 7, device->sm[3].start, 0, 1);
}

/* All process data in succession, one FMMU each. @return bytes */
static uint16_t map_all(wire_t *w, uint32_t logical)
{
    const ect_device_t *device = wire_device(w, 0);
    uint16_t at = 0;
    for (unsigned int n = 0; n < device->sm_count; n++) {
        uint16_t bytes = ect_device_sm_bytes(device, n);
        if ((process_sms_of(device) >> n & 1) == 0 || bytes == 0)
            continue;
        wire_set_fmmu(w, 0, n, logical + at, bytes, 0, 7, device->sm[n].start, 0,
                      device->sm[n].type == ECT_SM_OUTPUTS ? 2 : 1);
        at = (uint16_t)(at + bytes);
    }
    return at;
}

static void lrw_counts(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        const ect_device_t *device = every_device(i);
        int outputs = ect_device_bytes(device, ECT_SM_OUTPUTS) > 0;
        uint8_t data[512] = {0};
        wire_t w;
        wire_open_one(&w, device);
        wire_go(&w, 0, PREOP);
        wire_configure_process_data(&w, 0);
        uint16_t length = map_all(&w, 0x10000);
        assert_int_equal(wire_logical(&w, LRW, 0x10000, data, length), 0);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP);
        for (unsigned int n = 0; n < 3; n++) {
            int wkc = wire_logical(&w, LRW, 0x10000, data, length);
            if (wkc != 1 + 2 * outputs)
                fail_msg("%s: LRW in SAFEOP has WKC %d", device->name, wkc);
        }
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, OP);
        expect_state(&w, device->name, OP, 0);
        assert_int_equal(wire_logical(&w, LRW, 0x10000, data, length), 1 + 2 * outputs);
        assert_int_equal(wire_logical(&w, LRD, 0x10000, data, length), 1);
        assert_int_equal(wire_logical(&w, LWR, 0x10000, data, length), outputs);
        wire_close(&w);
    }
}

static void lrw_data(void **state)
{
    (void)state;
    /* outputs before inputs, inputs before outputs, both at one address, apart */
    static const uint32_t at[][2] = {{0x20000, 0x20003}, {0x20003, 0x20000}, {0x20000, 0x20000}, {0x20000, 0x20008}};
    for (size_t i = 0; i < COUNT(at); i++) {
        wire_t w;
        open_in(&w, OP);
        map(&w, 0, at[i][0], at[i][1]);
        testdev_t *t = testdev_of(&w, 0);
        t->in_u16 = 0xA55A;
        t->in_bits = 5;
        for (uint32_t n = 1; n < 20; n++) {
            uint8_t data[12];
            memset(data, 0x3C, sizeof data);
            uint32_t image = (0x1000 + n) << 8 | (n & 1);
            memcpy(data + (at[i][0] - 0x20000),
                   (uint8_t[3]){(uint8_t)image, (uint8_t)(image >> 8), (uint8_t)(image >> 16)}, IMAGE);
            assert_int_equal(wire_logical(&w, LRW, 0x20000, data, sizeof data), 3);
            expect_outputs(&w, image);
            const uint8_t *in = data + (at[i][1] - 0x20000);
            if (n > 1 && (ect_load_le16(in) != 0xA55A || in[2] != 5))
                fail_msg("layout %zu: inputs 0x%04X 0x%02X", i, ect_load_le16(in), in[2]);
            if (data[11] != 0x3C)
                fail_msg("layout %zu: an unmapped byte was changed", i);
        }
        wire_close(&w);
    }
}

static void lrw_over_two(void **state)
{
    (void)state;
    const ect_device_t *const devices[] = {&testdev, &ect_eclink_map1, &testdev};
    wire_t w;
    wire_open(&w, devices, 3);
    for (size_t i = 0; i < 3; i++)
        wire_go(&w, i, OP);
    map(&w, 0, 0, 6);
    map(&w, 1, 0, 9);
    map(&w, 2, 3, 75);
    testdev_of(&w, 0)->in_u16 = 0x1111;
    testdev_of(&w, 2)->in_u16 = 0x2222;
    for (unsigned int n = 0; n < 3; n++) {
        uint8_t data[78] = {1, 0x34, 0x12, 0, 0x78, 0x56};
        assert_int_equal(wire_logical(&w, LRW, 0, data, sizeof data), 7);
        assert_int_equal(testdev_of(&w, 0)->out_u16, 0x1234);
        assert_int_equal(testdev_of(&w, 0)->out_bool, 1);
        assert_int_equal(testdev_of(&w, 2)->out_u16, 0x5678);
        assert_int_equal(testdev_of(&w, 2)->out_bool, 0);
        assert_int_equal(ect_load_le16(data + 6), n == 0 ? ect_load_le16(data + 6) : 0x1111);
        assert_int_equal(ect_load_le16(data + 75), n == 0 ? ect_load_le16(data + 75) : 0x2222);
    }
    wire_close(&w);
}

static void input_only(void **state)
{
    (void)state;
    const ect_device_t *device = &ect_eclink_map1;
    assert_non_null(device);
    wire_t w;
    wire_open_one(&w, device);
    wire_go(&w, 0, OP);
    assert_int_equal(ect_chain_slave(w.chain, 0)->outputs, 0);
    assert_int_equal(ect_chain_slave(w.chain, 0)->image[3].bytes, 66);
    uint8_t image[66];
    uint8_t before = 0;
    for (unsigned int n = 0; n < 10; n++) {
        wire_advance(&w, 125 * MS);
        assert_int_equal(wire_read(&w, 0, device->sm[3].start, image, sizeof image), 1);
        if (n > 0 && image[0] != (uint8_t)(before + 1))
            fail_msg("step %u: PCI is %u after %u", n, image[0], before);
        before = image[0];
    }
    expect_state(&w, "input-only, no outputs ever", OP, 0);
    wire_close(&w);
}

/* --- the watchdog and parts of an image -------------------------------------------------------------------------- */

/* Writes SM2 in some way each 10 ms for 300 ms; whether that counts as outputs. */
static const struct {
    const char *what;
    uint16_t first_at, first_length, then_at, then_length;
    bool complete;
} writes[] = {
    {"whole", SM2, 3, 0, 0, true},
    {"nothing", 0, 0, 0, 0, false},
    {"first byte", SM2, 1, 0, 0, false},
    {"all but the last byte", SM2, 2, 0, 0, false},
    {"last byte", SM2 + 2, 1, 0, 0, false},
    {"all but the first byte", SM2 + 1, 2, 0, 0, false},
    {"middle byte", SM2 + 1, 1, 0, 0, false},
    {"first, then last byte", SM2, 1, SM2 + 2, 1, true},
    {"two, then last byte", SM2, 2, SM2 + 2, 1, true},
};

static void partial_outputs(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(writes); i++) {
        wire_t w;
        uint8_t ones[IMAGE] = {0xFF, 0xFF, 0xFF};
        open_in(&w, OP);
        for (unsigned int n = 0; n < 30; n++) {
            if (writes[i].first_length > 0)
                (void)wire_write(&w, 0, writes[i].first_at, ones, writes[i].first_length);
            if (writes[i].then_length > 0)
                (void)wire_write(&w, 0, writes[i].then_at, ones, writes[i].then_length);
            wire_advance(&w, 10 * MS);
        }
        expect_state(&w, writes[i].what, writes[i].complete ? OP : SAFEOP | ECT_AL_ERROR,
                     writes[i].complete ? 0 : 0x001B);
        if (!writes[i].complete)
            assert_int_equal(testdev_of(&w, 0)->outputs_calls, 1); /* those of the way to OP */
        wire_close(&w);
    }
}

static void lrw_feeds(void **state)
{
    (void)state;
    wire_t w;
    open_in(&w, OP);
    map(&w, 0, 0, 3);
    for (unsigned int n = 0; n < 20; n++) {
        uint8_t data[6] = {0};
        assert_int_equal(wire_logical(&w, LRW, 0, data, 6), 3);
        wire_advance(&w, 90 * MS);
        expect_state(&w, "fed by LRW", OP, 0);
    }
    for (unsigned int n = 0; n < 3; n++) {
        uint8_t data[6] = {0};
        assert_int_equal(wire_logical(&w, LRD, 0, data, 6), 1);
        wire_advance(&w, 90 * MS);
    }
    expect_state(&w, "not fed by LRD", SAFEOP | ECT_AL_ERROR, 0x001B);
    wire_close(&w);
}

/* --- other mappings ---------------------------------------------------------------------------------------------- */

enum { MAPPED = 24 };

/* A test device whose 1600h and 1A00h can be filled freely, and whose objects can all be mapped. */
typedef struct mapped {
    ect_device_t device;
    ect_object_t objects[64];
    ect_entry_t entries[200];
    ect_entry_t map[2][1 + MAPPED];
    ect_entry_t assign[2][3];
    ect_pdo_run_t runs[2 * MAPPED];
    uint16_t run_count;
} mapped_t;

static const ect_entry_t *copy_entries(mapped_t *m, size_t *used, const ect_object_t *object)
{
    ect_entry_t *first = m->entries + *used;
    const ect_entry_t *from = object->entries;
    for (;; from++) {
        assert_true(*used < COUNT(m->entries));
        m->entries[*used] = *from;
        if (object->index >= 0x2000)
            m->entries[*used].access |= ECT_ACCESS_RXPDO | ECT_ACCESS_TXPDO;
        (*used)++;
        if (from->subindex == object->max_subindex)
            return first;
    }
}

static void make_mapped(mapped_t *m)
{
    size_t used = 0;
    m->device = testdev;
    m->device.objects = m->objects;
    m->run_count = COUNT(m->runs);
    m->device.sm[2].maximum = m->device.sm[3].maximum = ROOM;
    for (uint16_t i = 0; i < testdev.object_count; i++) {
        m->objects[i] = testdev.objects[i];
        m->objects[i].entries = copy_entries(m, &used, &testdev.objects[i]);
        for (unsigned int d = 0; d < 2; d++) {
            if (m->objects[i].index == (d == 0 ? 0x1600 : 0x1A00)) {
                m->map[d][0] = (ect_entry_t)ECT_ENTRY_COUNT(0);
                m->objects[i].entries = m->map[d];
                m->objects[i].max_subindex = m->objects[i].last = MAPPED;
            }
            if (m->objects[i].index == 0x1C12 + d) {
                m->assign[d][0] = (ect_entry_t)ECT_ENTRY_COUNT(1);
                m->assign[d][1] = (ect_entry_t)ECT_ENTRY_ASSIGN(1, d == 0 ? 0x1600 : 0x1A00);
                m->assign[d][2] = (ect_entry_t)ECT_ENTRY_ASSIGN(2, 0);
                m->objects[i].entries = m->assign[d];
                m->objects[i].max_subindex = m->objects[i].last = 2;
            }
        }
    }
    for (unsigned int n = 1; n <= MAPPED; n++) {
        m->map[0][n] = (ect_entry_t)ECT_ENTRY_MAP((uint16_t)n, 0);
        m->map[1][n] = m->map[0][n];
    }
}

static void add(mapped_t *m, unsigned int direction, uint32_t mapping)
{
    ect_entry_t *map = m->map[direction];
    assert_true(map[0].value < MAPPED);
    map[++map[0].value].value = mapping;
}

/* In PREOP with the mapped device behind the ESC of an ordinary one: SII and memory are those of testdev with ROOM. */
static void open_mapped(wire_t *w, mapped_t *m)
{
    static ect_device_t plain; /* source of the SII */
    plain = testdev;
    plain.sm[2].maximum = plain.sm[3].maximum = ROOM;
    wire_open_one(w, &plain);
    ect_slave_t *s = slave_of(w);
    s->config.device = &m->device;
    s->config.runs = m->runs;
    s->config.run_count = m->run_count;
    s->od.objects = m->objects;
    wire_go(w, 0, PREOP);
}

static unsigned int image_bytes(const mapped_t *m, unsigned int direction)
{
    unsigned int bits = 0;
    for (unsigned int n = 1; n <= m->map[direction][0].value; n++)
        bits += m->map[direction][n].value & 0xFF;
    return (bits + 7) / 8;
}

/* SM2 and SM3 of exactly the mapped lengths. */
static void to_safeop(wire_t *w, mapped_t *m)
{
    for (unsigned int d = 0; d < 2; d++)
        wire_set_sm(w, 0, 2 + d, d == 0 ? SM2 : SM3, (uint16_t)image_bytes(m, d), d == 0 ? 0x64 : 0x20);
    wire_write16(w, 0, ECT_REG_AL_CONTROL, SAFEOP);
}

/* Adjacent in the instance, but not in the image: two pieces. */
static void gap_between_neighbours(void **state)
{
    static mapped_t m;
    wire_t w;
    const uint8_t image[] = {0x11, 0x22, 0x33, 0x44, 0x55, 0x66};
    (void)state;
    memset(&m, 0, sizeof m);
    make_mapped(&m);
    add(&m, 0, ECT_MAP(0x2007, 1, 16));
    add(&m, 0, ECT_MAP(0, 0, 16));
    add(&m, 0, ECT_MAP(0x2007, 2, 16));
    open_mapped(&w, &m);
    to_safeop(&w, &m);
    assert_int_equal(wire_write(&w, 0, SM2, image, sizeof image), 1);
    assert_int_equal(wire_al(&w, 0, OP, NULL), OP);
    assert_int_equal(testdev_of(&w, 0)->array[0], 0x2211);
    assert_int_equal(testdev_of(&w, 0)->array[1], 0x6655);
    wire_close(&w);
}

/* The objects of the layouts: their memory, and their bytes as a number (1: as bytes). */
static const struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t bits;
    uint8_t width;
    size_t offset;
} parts[] = {
    {0x2000, 0, 32, 4, offsetof(testdev_t, u32)},        {0x2001, 0, 160, 1, offsetof(testdev_t, text)},
    {0x2003, 0, 16, 2, offsetof(testdev_t, write_only)}, {0x2005, 0, 16, 2, offsetof(testdev_t, limited)},
    {0x2006, 1, 1, 1, offsetof(testdev_t, record_bool)}, {0x2006, 2, 3, 1, offsetof(testdev_t, record_bit3)},
    {0x2006, 3, 5, 1, offsetof(testdev_t, record_bit5)}, {0x2006, 4, 16, 2, offsetof(testdev_t, record_u16)},
    {0x2006, 5, 8, 1, offsetof(testdev_t, record_ro)},   {0x2006, 6, 32, 4, offsetof(testdev_t, record_u32)},
    {0x2007, 1, 16, 2, offsetof(testdev_t, array[0])},   {0x2007, 2, 16, 2, offsetof(testdev_t, array[1])},
    {0x2007, 3, 16, 2, offsetof(testdev_t, array[2])},   {0x2007, 4, 16, 2, offsetof(testdev_t, array[3])},
    {0x2008, 1, 8, 1, offsetof(testdev_t, sparse[0])},   {0x2008, 3, 8, 1, offsetof(testdev_t, sparse[1])},
    {0x2008, 5, 8, 1, offsetof(testdev_t, sparse[2])},   {0x2009, 0, 64, 8, offsetof(testdev_t, u64)},
};

/* The bytes of a part in wire form. */
static void part_to_wire(const testdev_t *t, size_t part, uint8_t wire[20])
{
    const uint8_t *at = (const uint8_t *)t + parts[part].offset;
    uint16_t v16;
    uint32_t v32;
    uint64_t v64;
    memset(wire, 0, 20);
    switch (parts[part].width) {
    case 2:
        memcpy(&v16, at, 2);
        ect_store_le16(wire, v16);
        break;
    case 4:
        memcpy(&v32, at, 4);
        ect_store_le32(wire, v32);
        break;
    case 8:
        memcpy(&v64, at, 8);
        ect_store_le64(wire, v64);
        break;
    default:
        memcpy(wire, at, (parts[part].bits + 7u) / 8);
        break;
    }
}

static unsigned int bit_of(const uint8_t *bytes, unsigned int bit)
{
    return (unsigned int)(bytes[bit / 8] >> (bit % 8)) & 1u;
}

typedef struct layout {
    unsigned int count;
    struct {
        int part; /* -1: gap */
        unsigned int at, bits;
    } piece[MAPPED];
} layout_t;

/* Parts in any order and at any bit, each once; sometimes truncated. */
static void random_layout(uint32_t *x, mapped_t *m, unsigned int direction, layout_t *l)
{
    bool used[COUNT(parts)] = {false};
    unsigned int at = 0;
    l->count = 0;
    unsigned int wanted = 1 + draw(x, 12);
    while (l->count < wanted) {
        int part = draw(x, 4) == 0 ? -1 : (int)draw(x, COUNT(parts));
        if (part >= 0 && used[part])
            continue;
        unsigned int bits = part < 0 ? 1 + draw(x, 12) : parts[part].bits;
        if (part >= 0 && draw(x, 8) == 0)
            bits = 1 + draw(x, bits);
        if (at + bits > 8 * ROOM)
            break;
        add(m, direction, part < 0 ? ECT_MAP(0, 0, bits) : ECT_MAP(parts[part].index, parts[part].subindex, bits));
        l->piece[l->count].part = part;
        l->piece[l->count].at = at;
        l->piece[l->count++].bits = bits;
        if (part >= 0)
            used[part] = true;
        at += bits;
    }
}

static void fill(uint32_t *x, void *at, size_t size)
{
    for (size_t i = 0; i < size; i++)
        ((uint8_t *)at)[i] = (uint8_t)(1 + draw(x, 255));
}

static void check_input_image(const testdev_t *t, const layout_t *l, const uint8_t *image, unsigned int bytes,
                              uint32_t seed)
{
    uint8_t want[ROOM] = {0};
    for (unsigned int n = 0; n < l->count; n++) {
        uint8_t wire[20];
        if (l->piece[n].part < 0)
            continue;
        part_to_wire(t, (size_t)l->piece[n].part, wire);
        for (unsigned int bit = 0; bit < l->piece[n].bits; bit++)
            want[(l->piece[n].at + bit) / 8] |= (uint8_t)(bit_of(wire, bit) << ((l->piece[n].at + bit) % 8));
    }
    for (unsigned int i = 0; i < bytes; i++) {
        if (image[i] != want[i])
            fail_msg("seed %u: input byte %u is 0x%02X, expected 0x%02X", seed, i, image[i], want[i]);
    }
}

static void check_output_data(const testdev_t *t, const layout_t *l, const uint8_t *image, uint32_t seed)
{
    for (unsigned int n = 0; n < l->count; n++) {
        uint8_t wire[20];
        if (l->piece[n].part < 0)
            continue;
        part_to_wire(t, (size_t)l->piece[n].part, wire);
        unsigned int all = parts[l->piece[n].part].bits;
        for (unsigned int bit = 0; bit < all; bit++) {
            unsigned int want = bit < l->piece[n].bits ? bit_of(image, l->piece[n].at + bit) : 0;
            if (bit_of(wire, bit) != want)
                fail_msg("seed %u: piece %u, %04X:%u, bit %u is not %u", seed, n, parts[l->piece[n].part].index,
                         parts[l->piece[n].part].subindex, bit, want);
        }
    }
}

/* An unmapped value is unchanged by copies next to it. */
static void check_others(const testdev_t *t, const testdev_t *before, const layout_t *l, uint32_t seed)
{
    bool mapped[COUNT(parts)] = {false};
    for (unsigned int n = 0; n < l->count; n++) {
        if (l->piece[n].part >= 0)
            mapped[l->piece[n].part] = true;
    }
    for (size_t part = 0; part < COUNT(parts); part++) {
        uint8_t want[20], got[20];
        part_to_wire(before, part, want);
        part_to_wire(t, part, got);
        if (!mapped[part] && memcmp(want, got, sizeof want) != 0)
            fail_msg("seed %u: %04X:%u is not mapped and has changed", seed, parts[part].index, parts[part].subindex);
    }
    if (memcmp(t->octets, before->octets, sizeof t->octets) != 0 || t->in_u16 != before->in_u16)
        fail_msg("seed %u: what lies behind a text or a number of 64 bits has changed", seed);
}

static void random_layouts(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 300; seed++) {
        wire_t w;
        mapped_t m = {0};
        layout_t layouts[2];
        uint8_t image[ROOM];
        uint32_t x = seed;
        make_mapped(&m);
        for (unsigned int d = 0; d < 2; d++)
            random_layout(&x, &m, d, &layouts[d]);
        open_mapped(&w, &m);
        to_safeop(&w, &m);
        expect_state(&w, "random layout", SAFEOP, 0);
        testdev_t *t = testdev_of(&w, 0);
        fill(&x, &t->u32, sizeof t->u32);
        fill(&x, t->text, sizeof t->text);
        fill(&x, &t->write_only, offsetof(testdev_t, in_u16) - offsetof(testdev_t, write_only));
        t->record_bool &= 1;
        t->record_bit3 &= 7;
        t->record_bit5 &= 31;
        uint16_t in_bytes = (uint16_t)image_bytes(&m, 1);
        uint16_t out_bytes = (uint16_t)image_bytes(&m, 0);
        assert_int_equal(wire_read(&w, 0, SM3, image, in_bytes), 1);
        assert_int_equal(wire_read(&w, 0, SM3, image, in_bytes), 1);
        check_input_image(t, &layouts[1], image, in_bytes, seed);
        fill(&x, image, sizeof image);
        const testdev_t before = *t;
        assert_int_equal(wire_write(&w, 0, SM2, image, out_bytes), 1);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, OP);
        expect_state(&w, "random layout", OP, 0);
        check_output_data(t, &layouts[0], image, seed);
        check_others(t, &before, &layouts[0], seed);
        wire_close(&w);
    }
}

/* Impossible mappings, in either direction, and similar possible ones. */
static const struct {
    const char *what;
    uint32_t mapping[3];
    bool allowed;
} mappings[] = {
    {"one object", {ECT_MAP(0x2000, 0, 32)}, true},
    {"a gap only", {ECT_MAP(0, 0, 8)}, true},
    {"unknown object", {ECT_MAP(0x2FFF, 0, 8)}, false},
    {"unknown object behind a good one", {ECT_MAP(0x2000, 0, 32), ECT_MAP(0x2FFF, 0, 8)}, false},
    {"unknown sub-index", {ECT_MAP(0x2006, 7, 8)}, false},
    {"missing sub-index", {ECT_MAP(0x2008, 2, 8)}, false},
    {"sub-index of a VAR", {ECT_MAP(0x2000, 1, 32)}, false},
    {"not mappable", {ECT_MAP(0x1018, 1, 32)}, false},
    {"one bit too long", {ECT_MAP(0x2006, 2, 4)}, false},
    {"much too long", {ECT_MAP(0x2000, 0, 255)}, false},
    {"twice", {ECT_MAP(0x2007, 1, 16), ECT_MAP(0x2007, 2, 16)}, true},
};

static void bad_mappings(void **state)
{
    (void)state;
    for (unsigned int d = 0; d < 2; d++) {
        for (size_t i = 0; i < COUNT(mappings); i++) {
            wire_t w;
            mapped_t m = {0};
            make_mapped(&m);
            for (unsigned int n = 0; n < 3 && mappings[i].mapping[n] != 0; n++)
                add(&m, d, mappings[i].mapping[n]);
            add(&m, 1 - d, ECT_MAP(0x2009, 0, 64));
            open_mapped(&w, &m);
            to_safeop(&w, &m);
            uint16_t code = d == 0 ? 0x0025 : 0x0024;
            expect_state(&w, mappings[i].what, mappings[i].allowed ? SAFEOP : PREOP | ECT_AL_ERROR,
                         mappings[i].allowed ? 0 : code);
            wire_close(&w);
        }
    }
}

static void wrong_direction(void **state)
{
    (void)state;
    for (unsigned int d = 0; d < 2; d++) {
        wire_t w;
        mapped_t m = {0};
        make_mapped(&m);
        for (size_t i = 0; i < COUNT(m.entries); i++)
            m.entries[i].access &= (uint16_t)~(d == 0 ? ECT_ACCESS_RXPDO : ECT_ACCESS_TXPDO);
        add(&m, d, ECT_MAP(0x2000, 0, 32));
        open_mapped(&w, &m);
        to_safeop(&w, &m);
        expect_state(&w, d == 0 ? "not for RxPDO" : "not for TxPDO", PREOP | ECT_AL_ERROR, d == 0 ? 0x0025 : 0x0024);
        wire_close(&w);
    }
}

static void assignments(void **state)
{
    (void)state;
    for (unsigned int d = 0; d < 2; d++) {
        wire_t w;
        mapped_t m = {0};
        make_mapped(&m);
        add(&m, d, ECT_MAP(0x2000, 0, 32));
        m.assign[d][1].value = 0x1601;
        open_mapped(&w, &m);
        to_safeop(&w, &m);
        expect_state(&w, "assigned PDO does not exist", PREOP | ECT_AL_ERROR, d == 0 ? 0x0025 : 0x0024);
        m.assign[d][1].value = d == 0 ? 0x1600 : 0x1A00;
        m.assign[d][0].value = 3;
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP | ECT_AL_ACKNOWLEDGE);
        expect_state(&w, "count beyond the entries", PREOP | ECT_AL_ERROR, d == 0 ? 0x0025 : 0x0024);
        m.assign[d][0].value = 1;
        m.map[d][0].value = MAPPED + 1;
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP | ECT_AL_ACKNOWLEDGE);
        expect_state(&w, "mapping count beyond the entries", PREOP | ECT_AL_ERROR, d == 0 ? 0x0025 : 0x0024);
        m.map[d][0].value = 1;
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP | ECT_AL_ACKNOWLEDGE);
        expect_state(&w, "put right", SAFEOP, 0);
        wire_close(&w);
    }
}

static void two_pdos(void **state)
{
    (void)state;
    wire_t w;
    mapped_t m = {0};
    make_mapped(&m);
    add(&m, 0, ECT_MAP(0x2000, 0, 32));
    add(&m, 0, ECT_MAP(0, 0, 3));
    add(&m, 1, ECT_MAP(0x2009, 0, 64));
    m.assign[0][0].value = 2;
    m.assign[0][2].value = 0x1600;
    open_mapped(&w, &m);
    wire_set_sm(&w, 0, 2, SM2, 9, 0x64);
    wire_set_sm(&w, 0, 3, SM3, 8, 0x20);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP);
    expect_state(&w, "two PDOs, 70 bits in 9 bytes", SAFEOP, 0);
    wire_close(&w);
}

static void image_limits(void **state)
{
    (void)state;
    for (unsigned int d = 0; d < 2; d++) {
        for (unsigned int extra = 0; extra < 3; extra++) {
            wire_t w;
            mapped_t m = {0};
            make_mapped(&m);
            for (unsigned int n = 0; n < 3; n++)
                add(&m, d, ECT_MAP(0, 0, 8 * ROOM / 4));
            add(&m, d, ECT_MAP(0, 0, 8 * ROOM / 4 - 1 + extra));
            open_mapped(&w, &m);
            to_safeop(&w, &m);
            if (extra < 2)
                expect_state(&w, "image that just fits", SAFEOP, 0);
            else
                expect_state(&w, "image of one bit too many", PREOP | ECT_AL_ERROR, d == 0 ? 0x0025 : 0x0024);
            wire_close(&w);
        }
        wire_t w;
        mapped_t m = {0};
        make_mapped(&m);
        for (unsigned int n = 0; n < MAPPED; n++)
            add(&m, d, ECT_MAP(0, 0, 255));
        m.assign[d][0].value = 2;
        m.assign[d][2].value = m.assign[d][1].value;
        open_mapped(&w, &m);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP);
        expect_state(&w, "larger than any datagram", PREOP | ECT_AL_ERROR, d == 0 ? 0x0025 : 0x0024);
        wire_close(&w);
    }
}

/* testdev has 2 pieces in each direction; adjacent in image and instance they become one. */
static void run_limits(void **state)
{
    (void)state;
    static const struct {
        uint16_t runs;
        uint16_t code;
    } rows[] = {{4, 0}, {3, 0x0024}, {2, 0x0024}, {1, 0x0025}, {0, 0x0025}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        wire_t w;
        wire_open_one(&w, &testdev);
        slave_of(&w)->config.run_count = rows[i].runs;
        wire_go(&w, 0, PREOP);
        wire_configure_process_data(&w, 0);
        wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP);
        expect_state(&w, "pieces", rows[i].code ? PREOP | ECT_AL_ERROR : SAFEOP, rows[i].code);
        wire_close(&w);
    }
    wire_t w;
    mapped_t m = {0};
    make_mapped(&m);
    m.run_count = 2;
    for (unsigned int d = 0; d < 2; d++) {
        for (uint8_t n = 1; n <= 4; n++)
            add(&m, d, ECT_MAP(0x2007, n, 16));
    }
    open_mapped(&w, &m);
    to_safeop(&w, &m);
    expect_state(&w, "four neighbours in one piece", SAFEOP, 0);
    wire_close(&w);
}

/* Constants can be sent, and are unchanged by received data. */
static void constants(void **state)
{
    (void)state;
    wire_t w;
    mapped_t m = {0};
    uint8_t image[5] = {0};
    make_mapped(&m);
    for (size_t i = 0; i < COUNT(m.entries); i++)
        m.entries[i].access |= ECT_ACCESS_RXPDO | ECT_ACCESS_TXPDO;
    for (unsigned int d = 0; d < 2; d++) {
        add(&m, d, ECT_MAP(0, 0, 4));
        add(&m, d, ECT_MAP(0x1000, 0, 32));
    }
    open_mapped(&w, &m);
    to_safeop(&w, &m);
    expect_state(&w, "constants", SAFEOP, 0);
    assert_int_equal(wire_write(&w, 0, SM2, image, 5), 1);
    wire_write16(&w, 0, ECT_REG_AL_CONTROL, OP);
    assert_int_equal(wire_read(&w, 0, SM3, image, 5), 1);
    assert_int_equal(ect_load_le32(image), 0x23456780);
    assert_int_equal(image[4], 0x01);
    wire_close(&w);
}

/* A part of an object longer than any mapping entry: refused, or correct, but no byte beyond it is accessed. */
static void part_of_a_long_object(void **state)
{
    enum { MOST = 31 };
    static const struct {
        unsigned int gap, bytes; /* bits in front of the part; its bytes */
    } rows[] = {{0, 5}, {0, 8}, {4, 5}, {4, 8}, {4, MOST}};
    (void)state;
    for (size_t i = 0; i < 2 * COUNT(rows); i++) {
        const unsigned int d = i % 2, gap = rows[i / 2].gap, bytes = rows[i / 2].bytes;
        const uint16_t size = (uint16_t)(bytes + (gap > 0 ? 1 : 0));
        wire_t w;
        mapped_t m = {0};
        uint8_t data[MOST], image[MOST + 1] = {0}, got[MOST + 1];
        for (unsigned int n = 0; n < bytes; n++) {
            data[n] = (uint8_t)(0x81 + 7 * n);
            image[n] = (uint8_t)(image[n] | data[n] << gap);
            image[n + 1] = (uint8_t)(data[n] << gap >> 8);
        }
        make_mapped(&m);
        if (gap > 0)
            add(&m, d, ECT_MAP(0, 0, gap));
        add(&m, d, ECT_MAP(0x2002, 0, 8 * bytes));
        add(&m, 1 - d, ECT_MAP(0x2000, 0, 32));
        open_mapped(&w, &m);
        to_safeop(&w, &m);
        testdev_t *t = testdev_of(&w, 0);
        uint8_t status = wire_read8(&w, 0, ECT_REG_AL_STATUS);
        if (status == SAFEOP && d == 0) {
            assert_int_equal(wire_write(&w, 0, SM2, image, size), 1);
            wire_write16(&w, 0, ECT_REG_AL_CONTROL, OP);
            assert_memory_equal(t->octets, data, bytes);
            assert_int_equal(t->octets[bytes], 0);
        } else if (status == SAFEOP) {
            memcpy(t->octets, data, bytes);
            memset(t->octets + bytes, 0xFF, 4);
            assert_int_equal(wire_read(&w, 0, SM3, got, size), 1);
            assert_int_equal(wire_read(&w, 0, SM3, got, size), 1);
            assert_memory_equal(got, image, size);
        } else {
            expect_state(&w, "part of a long object", PREOP | ECT_AL_ERROR, d == 0 ? 0x0025 : 0x0024);
        }
        wire_close(&w);
    }
}

#define T(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    const struct CMUnitTest tests[] = {
        T("CF-048: each bit of the output image is stored in its object, gaps in none", outputs_bit_by_bit),
        T("CF-048: each bit of the inputs has its position, gaps are 0, in SAFEOP and OP", inputs_bit_by_bit),
        T("CF-048: in SAFEOP SM2 is read and not applied; OP applies the newest outputs; the end of OP makes outputs "
          "safe",
          outputs_rest_in_safeop),
        T("CF-048: below SAFEOP neither SM2 nor SM3 can be accessed", no_data_below_safeop),
        T("CF-048 L11: inputs are in their SyncManager before SAFEOP is confirmed", inputs_before_safeop),
        T("CF-048: inputs follow the device's own time in SAFEOP and OP, not in PREOP", inputs_follow_time),
        T("CF-005 CF-048: LRW counts 3 in SAFEOP and OP, 1 for an input-only device, 0 below", lrw_counts),
        T("CF-048: LRW transfers outputs and inputs in any layout, and changes nothing else", lrw_data),
        T("CF-032: one LRW over three devices, outputs first, counts 7 and gives each device its own data",
          lrw_over_two),
        T("CF-048: an input-only device runs in OP without outputs, its inputs renewed by its own time", input_only),
        T("CF-052: only a complete write of SM2 triggers the watchdog and reaches the device", partial_outputs),
        T("CF-052: LRW triggers the watchdog, LRD does not", lrw_feeds),
        T("CF-037: a gap in the image between two entries that are neighbours in memory", gap_between_neighbours),
        T("CF-037: any layout of objects and gaps, at any bit, is packed and unpacked right", random_layouts),
        T("CF-037: an impossible mapping gives 0x0025 for outputs, 0x0024 for inputs", bad_mappings),
        T("CF-037: an object mapped in the direction that it does not allow is refused", wrong_direction),
        T("CF-037: an assignment or count without an object is refused, and accepted after its correction",
          assignments),
        T("CF-037: two assigned PDOs follow each other without a gap", two_pdos),
        T("CF-037: an image larger than its memory or than a datagram is refused", image_limits),
        T("CF-037: an image in more pieces than fit into the memory is refused; neighbours are one piece", run_limits),
        T("CF-048: constants are sent, and received data do not change them", constants),
        T("CF-037: a part of an object longer than 255 bits is refused or correct", part_of_a_long_object),
    };
    return cmocka_run_group_tests_name("Process data", tests, NULL, NULL);
}
