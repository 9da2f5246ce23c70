/* SPDX-License-Identifier: MIT */
/*
 * Frames into a chain of four twins with a history, while both sides continue to work: the master sends, the
 * microcontrollers read and write, faults occur, cables are disconnected. After each step the stacks must be in a
 * permitted state, and every twin that the step does not concern must be unchanged to the byte: bad input never changes
 * the state of another twin.
 *
 * The input: a byte with two bits for each twin, the state that a master has brought it to (INIT, PREOP, SAFEOP, OP); a
 * byte, bit 0: a tree instead of a line, bit 1: process data have FMMUs. Steps follow: kind (bits 0 to 2) and target
 * (bits 3, 4), a byte of milliseconds that pass first, two bytes of length, and that many bytes; at the end of the
 * input a step is shorter.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "support/every.h"
#include "support/testdev.h"
#include "support/wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { TWINS = 4, EVERYBODY = (1 << TWINS) - 1, PORTS = 4, STEP_HEADER = 4, MOST = 2100 };

/* Kinds of steps. Every other kind only lets time pass. */
enum { FRAME, DATAGRAMS, FROM_BEHIND, PDI_READ, PDI_WRITE, FAULT, PLUG };

/* State that only a datagram to this twin may change. */
typedef struct look {
    uint8_t *memory, *instance, *sii;
    ect_slave_t slave;
    ect_esc_sm_t sm[ECT_ESC_MAX_SM];
} look_t;

typedef struct rig {
    wire_t w;
    look_t looks[TWINS];
    uint8_t ways[TWINS][PORTS]; /* ports by which frames leave while all cables are connected */
} rig_t;

/* A step of the input. */
typedef struct step {
    unsigned int what, who;
    const uint8_t *bytes;
    uint16_t wanted; /* length in the step ... */
    uint16_t length; /* ... and bytes available */
} step_t;

#define EXPECT(condition, ...)                                                                                         \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            (void)fprintf(stderr, "expected " #condition ": " __VA_ARGS__);                                            \
            (void)fputc('\n', stderr);                                                                                 \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

/* --- the chain and its history ------------------------------------------------------------------------------------ */

static void set_fmmus(wire_t *w, size_t i)
{
    const ect_device_t *device = wire_device(w, i);
    unsigned int n = 0;
    for (unsigned int sm = 0; sm < device->sm_count; sm++) {
        uint16_t bytes = ect_device_sm_bytes(device, sm);
        if (!ect_device_sm_is_process(device, sm) || bytes == 0)
            continue;
        uint8_t direction = device->sm[sm].type == ECT_SM_OUTPUTS ? 2 : 1;
        wire_set_fmmu(w, i, n++, (uint32_t)(0x400 * i), bytes, 0, 7, device->sm[sm].start, 0, direction);
    }
}

static void open_rig(rig_t *r, uint8_t states, uint8_t how)
{
    static const ect_device_t *const devices[TWINS] = {&testdev, &ect_eclink_map7, &ect_fzm1, &testdev};
    static const uint8_t state_of[] = {ECT_STATE_INIT, ECT_STATE_PREOP, ECT_STATE_SAFEOP, ECT_STATE_OP};
    static const uint8_t branches[TWINS] = {0, 3, 1, 2}; /* in the order of the frame */
    ect_twin_config_t twins[TWINS];
    for (size_t i = 0; i < TWINS; i++) {
        twins[i] = ect_twin_default(devices[i], plant_of(devices[i]));
        twins[i].up_port = (how & 1u) != 0 ? branches[i] : 0;
    }
    twins[0].esc = "et1100"; /* a chip with four ports */
    wire_open_twins(&r->w, twins, TWINS);
    for (size_t i = 0; i < TWINS; i++) {
        uint8_t state = state_of[states >> (2 * i) & 3u];
        if (state != ECT_STATE_INIT)
            wire_go(&r->w, i, state);
        if ((how & 2u) != 0)
            set_fmmus(&r->w, i);
        for (unsigned int port = 0; port < PORTS; port++)
            r->ways[i][port] = (uint8_t)ect_esc_next_port(ect_chain_esc(r->w.chain, i), port);
    }
}

static void allocate_looks(rig_t *r)
{
    for (size_t i = 0; i < TWINS; i++) {
        const ect_esc_t *esc = ect_chain_esc(r->w.chain, i);
        look_t *look = &r->looks[i];
        look->memory = malloc(esc->memory_size);
        look->instance = malloc(wire_device(&r->w, i)->instance_size);
        look->sii = malloc(esc->config.sii_size);
        if (!look->memory || !look->instance || !look->sii)
            abort();
    }
}

static void close_rig(rig_t *r)
{
    wire_close(&r->w);
    for (size_t i = 0; i < TWINS; i++) {
        free(r->looks[i].memory);
        free(r->looks[i].instance);
        free(r->looks[i].sii);
    }
}

/* --- twins that a step may concern -------------------------------------------------------------------------------- */

/* Whether frames take their initial path, so that positions are those of the chain. */
static bool is_whole(const rig_t *r)
{
    for (size_t i = 0; i < TWINS; i++) {
        const ect_esc_t *esc = ect_chain_esc(r->w.chain, i);
        for (unsigned int port = 0; port < PORTS; port++) {
            if (ect_esc_next_port(esc, port) != r->ways[i][port] || ect_esc_circulates(esc))
                return false;
        }
    }
    return true;
}

/* Offset of the first datagram of a valid frame; 0: the frame is invalid. */
static size_t find_datagrams(const uint8_t *frame, size_t length)
{
    size_t at = 12;
    if (length >= 16 && ect_load_be16(frame + at) == 0x8100)
        at += 4;
    if (length < at + 2 || length > ECT_ESC_MAX_FRAME)
        return 0;
    unsigned int type = ect_load_be16(frame + at);
    at += 2;
    if (type == 0x0800) {
        if (length < at + 28 || frame[at] != 0x45 || frame[at + 9] != 17 || ect_load_be16(frame + at + 22) != 0x88A4)
            return 0;
        at += 28;
    } else if (type != 0x88A4) {
        return 0;
    }
    return length >= at + 2 && frame[at + 1] >> 4 == 1 ? at + 2 : 0;
}

static bool overlaps(uint64_t a, uint64_t a_length, uint64_t b, uint64_t b_length)
{
    return a < b + b_length && b < a + a_length;
}

static unsigned int by_station(const rig_t *r, uint16_t address)
{
    unsigned int whom = 0;
    for (unsigned int i = 0; i < TWINS; i++) {
        const uint8_t *m = ect_chain_esc(r->w.chain, i)->memory;
        bool alias = (m[0x0103] & 1u) != 0 && ect_load_le16(m + 0x0012) == address;
        whom |= alias || ect_load_le16(m + 0x0010) == address ? 1u << i : 0u;
    }
    return whom;
}

static unsigned int by_fmmu(const rig_t *r, uint32_t logical, uint16_t length)
{
    unsigned int whom = 0;
    for (unsigned int i = 0; i < TWINS; i++) {
        const uint8_t *fmmu = ect_chain_esc(r->w.chain, i)->memory + 0x0600;
        for (unsigned int n = 0; n < ECT_ESC_MAX_FMMU; n++, fmmu += 16) {
            bool hit = (fmmu[12] & 1u) != 0 && overlaps(logical, length, ect_load_le32(fmmu), ect_load_le16(fmmu + 4));
            whom |= hit ? 1u << i : 0u;
        }
    }
    return whom;
}

static unsigned int by_datagram(const rig_t *r, const uint8_t *d, uint16_t length)
{
    uint16_t adp = ect_load_le16(d + 2);
    uint16_t position = (uint16_t)(0u - adp);
    if (length == 0 || d[0] == NOP || d[0] > FRMW)
        return 0;
    if (d[0] <= APRW)
        return position < TWINS ? 1u << position : 0u;
    if (d[0] >= FPRD && d[0] <= FPRW)
        return by_station(r, adp);
    return d[0] >= LRD && d[0] <= LRW ? by_fmmu(r, ect_load_le32(d + 2), length) : (unsigned int)EVERYBODY;
}

/* A write to the registers that route datagrams may concern every twin. */
static bool redirects(const uint8_t *d, uint16_t length)
{
    bool reads = d[0] == APRD || d[0] == FPRD || d[0] == BRD || d[0] == LRD;
    bool logical = d[0] == LWR || d[0] == LRW;
    return length > 0 && !reads && (logical || ect_load_le16(d + 4) < 0x0700 || (d[0] <= BRW && d[0] % 3 == 0));
}

/* One bit for each twin. An invalid frame is not executed at all. */
static unsigned int concerned(const rig_t *r, const uint8_t *frame, size_t length)
{
    size_t at = find_datagrams(frame, length);
    unsigned int whom = 0;
    bool redirected = false;
    bool more = true;
    if (!is_whole(r))
        return EVERYBODY;
    if (at == 0)
        return 0;
    while (more) {
        const uint8_t *d = frame + at;
        if (length < at + 12)
            return 0;
        uint16_t size = ect_load_le16(d + 6) & 0x7FFu;
        if (length < at + 12 + size)
            return 0;
        whom |= redirected ? (unsigned int)EVERYBODY : by_datagram(r, d, size);
        redirected |= redirects(d, size);
        more = (d[7] & 0x80) != 0;
        at += 12u + size;
    }
    return whom;
}

/* --- unchanged twins ---------------------------------------------------------------------------------------------- */

static void look_at(rig_t *r)
{
    for (size_t i = 0; i < TWINS; i++) {
        const ect_esc_t *esc = ect_chain_esc(r->w.chain, i);
        look_t *look = &r->looks[i];
        memcpy(look->memory, esc->memory, esc->memory_size);
        memcpy(look->sii, esc->config.sii, esc->config.sii_size);
        memcpy(look->sm, esc->sm, sizeof look->sm);
        memcpy(&look->slave, ect_chain_slave(r->w.chain, i), sizeof look->slave);
        memcpy(look->instance, look->slave.config.instance, wire_device(&r->w, i)->instance_size);
    }
}

/* Write enables and a reset sequence end with any frame, and every twin that receives an invalid frame counts it. */
static bool may_change(uint32_t address)
{
    return (address >= 0x0020 && address <= 0x0041) || (address >= 0x0300 && address <= 0x030D);
}

static void expect_same(const rig_t *r, size_t i)
{
    const ect_esc_t *esc = ect_chain_esc(r->w.chain, i);
    const ect_slave_t *slave = ect_chain_slave(r->w.chain, i);
    const look_t *look = &r->looks[i];
    bool same = memcmp(esc->memory, look->memory, esc->memory_size) == 0;
    for (uint32_t at = 0; !same && at < esc->memory_size; at++)
        EXPECT(esc->memory[at] == look->memory[at] || may_change(at), "twin %zu, address 0x%04X: 0x%02X, was 0x%02X", i,
               at, esc->memory[at], look->memory[at]);
    EXPECT(memcmp(look->sm, esc->sm, sizeof look->sm) == 0, "twin %zu, SyncManagers", i);
    EXPECT(memcmp(look->sii, esc->config.sii, esc->config.sii_size) == 0, "twin %zu, EEPROM", i);
    EXPECT(memcmp(&look->slave, slave, sizeof *slave) == 0, "twin %zu, stack", i);
    EXPECT(memcmp(look->instance, slave->config.instance, slave->config.device->instance_size) == 0, "twin %zu, device",
           i);
}

static void expect_sound(const ect_slave_t *slave)
{
    uint8_t state = slave->state;
    EXPECT(state == 1 || state == 2 || state == 3 || state == 4 || state == 8, "state %u", state);
    EXPECT(slave->error == (slave->code != 0), "code 0x%04X", slave->code);
    EXPECT(slave->outputs_live == (state == 8), "state %u", state);
}

/* A twin that leaves the bus, or returns, changes the links of its neighbours. */
static bool same_links(const rig_t *r)
{
    for (size_t i = 0; i < TWINS; i++) {
        if (r->looks[i].slave.off_bus != ect_chain_slave(r->w.chain, i)->off_bus)
            return false;
    }
    return true;
}

static void expect_others_same(const rig_t *r, unsigned int whom)
{
    for (size_t i = 0; i < TWINS; i++) {
        if ((whom & (1u << i)) == 0 && same_links(r))
            expect_same(r, i);
        expect_sound(ect_chain_slave(r->w.chain, i));
    }
}

/* The effects of time are completed before the step, because the update of an unused chip may be late. */
static void let_time_pass(rig_t *r)
{
    for (size_t i = 0; i < TWINS; i++)
        (void)ect_esc_tick(ect_chain_esc(r->w.chain, i), r->w.now_ns);
    wire_poll(&r->w);
}

/* --- steps -------------------------------------------------------------------------------------------------------- */

/* In memory of exactly that size, so that any access beyond it is detected. */
static uint8_t *exactly(const void *bytes, size_t length)
{
    uint8_t *copy = malloc(length > 0 ? length : 1);
    if (!copy)
        abort();
    memcpy(copy, bytes, length);
    return copy;
}

static unsigned int send(rig_t *r, const uint8_t *bytes, size_t length)
{
    unsigned int whom = concerned(r, bytes, length);
    uint8_t *frame = exactly(bytes, length);
    (void)ect_chain_process(r->w.chain, frame, length, r->w.now_ns);
    free(frame);
    return whom;
}

static unsigned int send_datagrams(rig_t *r, const step_t *s)
{
    uint8_t frame[16 + MOST] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1, 0x88, 0xA4, 0x00, 0x10};
    memcpy(frame + 16, s->bytes, s->length);
    return send(r, frame, 16u + s->length);
}

static unsigned int send_from_behind(rig_t *r, const step_t *s)
{
    uint8_t *frame = exactly(s->bytes, s->length);
    ect_chain_set_link(r->w.chain, ECT_END_OUT, true);
    (void)ect_chain_pass(r->w.chain, ECT_END_OUT, frame, s->length, r->w.now_ns);
    ect_chain_set_link(r->w.chain, ECT_END_OUT, false);
    free(frame);
    return EVERYBODY;
}

/* The microcontroller, without the knowledge of its own stack. */
static unsigned int access_pdi(rig_t *r, const step_t *s)
{
    ect_esc_t *esc = ect_chain_esc(r->w.chain, s->who);
    if (s->length <= 2)
        return 0;
    uint16_t address = ect_load_le16(s->bytes);
    uint16_t length = (uint16_t)(s->what == PDI_READ ? s->wanted : s->length - 2);
    uint8_t *bytes = s->what == PDI_READ ? calloc(1, length + 1u) : exactly(s->bytes + 2, length);
    if (s->what == PDI_READ)
        (void)ect_esc_pdi_read(esc, address, bytes, length);
    else
        (void)ect_esc_pdi_write(esc, address, bytes, length);
    free(bytes);
    return 1u << s->who;
}

static unsigned int let_fail(rig_t *r, const step_t *s)
{
    if (s->length < 5)
        return 0;
    unsigned int kinds = ECT_FAULT_KINDS - ECT_FAULT_HANG;
    ect_fault_t fault = {.kind = (ect_fault_kind_t)(ECT_FAULT_HANG + s->bytes[0] % kinds),
                         .slave = (uint16_t)(s->who + 1),
                         .amount = (int32_t)ect_load_le32(s->bytes + 1)};
    if (fault.kind == ECT_FAULT_EEPROM_FLIP)
        fault.amount &= 15;
    ect_chain_fault(r->w.chain, &fault, r->w.now_ns);
    return 1u << s->who;
}

static unsigned int plug(rig_t *r, const step_t *s)
{
    static const char *const names[] = {"ecat.plug_in", "ecat.plug_out", "ecat.plug_2",
                                        "ecat.plug_3",  "ecat.latch0",   "ecat.latch1"};
    char message[ECT_SIGNAL_MESSAGE];
    if (s->length == 0)
        return 0;
    const ect_setting_t setting = {.name = names[s->bytes[0] % 6], .value = s->bytes[0] >= 128 ? "1" : "0"};
    (void)ect_settings_apply(r->w.chain, s->who, &setting, 1, r->w.now_ns, message);
    return EVERYBODY;
}

static unsigned int act(rig_t *r, const step_t *s)
{
    switch (s->what) {
    case FRAME:
        return send(r, s->bytes, s->length);
    case DATAGRAMS:
        return send_datagrams(r, s);
    case FROM_BEHIND:
        return send_from_behind(r, s);
    case PDI_READ:
    case PDI_WRITE:
        return access_pdi(r, s);
    case FAULT:
        return let_fail(r, s);
    case PLUG:
        return plug(r, s);
    default:
        return 0;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    rig_t r;
    if (size < 2)
        return 0;
    open_rig(&r, data[0], data[1]);
    allocate_looks(&r);
    data += 2;
    size -= 2;
    while (size >= STEP_HEADER) {
        step_t s = {.what = data[0] & 7u, .who = data[0] >> 3 & 3u, .wanted = ect_load_le16(data + 2) % MOST};
        r.w.now_ns += data[1] * MS;
        data += STEP_HEADER;
        size -= STEP_HEADER;
        s.bytes = data;
        s.length = s.wanted < size ? s.wanted : (uint16_t)size;
        let_time_pass(&r);
        look_at(&r);
        unsigned int whom = act(&r, &s);
        wire_poll(&r.w);
        expect_others_same(&r, whom);
        data += s.length;
        size -= s.length;
    }
    close_rig(&r);
    return 0;
}
