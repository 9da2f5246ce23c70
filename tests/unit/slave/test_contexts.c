/* SPDX-License-Identifier: MIT */
/*
 * Mainline, the cyclic exchange in an interrupt, and the interrupt line (docs/CONCURRENCY.md).
 *
 * The device's outputs and inputs are twelve bytes each, all equal in one generation, and scattered over the instance,
 * so that a partial transfer is visible. The stack is compiled a second time for this test, with a call at the
 * beginning and the end of each of its functions: there, and at the beginning and the end of each PDI access, an
 * interrupt may occur.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ports/virtual/virtual.h"
#include "seams/standard.h"
#include "slave/slave.h"
#include "wire/bytes.h"
#include "wire/crc.h"
#include "wire/registers.h"

#define MS 1000000ull
enum { FPRD = 4, FPWR = 5, PIECES = 4, IMAGE = 12, SIZE = 64, BANK = 256, OUTPUTS = 0x1200, INPUTS = 0x1300 };

typedef struct pieces {
    uint8_t a;
    uint16_t b;
    uint8_t between;
    uint32_t c;
    uint8_t d[5];
} pieces_t;

typedef struct device {
    ect_standard_t standard;
    const ect_host_t *host;
    pieces_t out;
    pieces_t in;
    uint32_t stored;
    ect_sync_data_t sync;
    uint8_t generation; /* of the inputs */
    uint8_t taken;      /* generation of the outputs that arrived last */
    unsigned int outputs_calls, tick_calls;
    bool safe;
} device_t;

static struct rig {
    ect_esc_t esc;
    uint8_t memory[ECT_ESC_MEMORY_SIZE(8)];
    uint8_t sii[2048];
    ect_pdi_t port; /* the virtual port, ... */
    ect_pdi_t pdi;  /* ... and its observer */
    ect_slave_t slave;
    device_t device;
    uint8_t mailbox[SIZE * 3];
    uint8_t staging[64];
    uint8_t process_data[IMAGE];
    ect_pdo_run_t runs[2 * PIECES];
    ect_storage_t storage;
    uint8_t bank[2][BANK];
    uint64_t now_ns;
    uint8_t counter;  /* of mails */
    uint8_t sent;     /* generation of the outputs that the master wrote last */
    bool in_mainline; /* interrupts may occur */
    bool in_interrupt;
    bool in_device;
    bool in_pdi;
    unsigned long points; /* places for an interrupt so far */
    unsigned long at;     /* the place of the interrupt, 0: none */
    unsigned long exchanges, kept_out;
    const char *broken; /* the first violation */
} t;

static void expect(bool condition, const char *what)
{
    if (!condition && !t.broken)
        t.broken = what;
}

/* --- the device --------------------------------------------------------------------------------------------------- */

static void fill(pieces_t *p, uint8_t generation)
{
    p->a = generation;
    p->b = (uint16_t)(generation * 0x0101u);
    p->c = generation * 0x01010101u;
    memset(p->d, generation, sizeof p->d);
}

static bool is_whole(const pieces_t *p)
{
    pieces_t want = *p;
    fill(&want, p->a);
    return memcmp(&want, p, sizeof want) == 0;
}

static device_t *enter(void *instance)
{
    device_t *d = instance;
    expect(!t.in_device, "a function of the device was called within another");
    expect(is_whole(&d->out), "outputs were there by halves");
    t.in_device = true;
    return d;
}

static void leave(void)
{
    t.in_device = false;
}

static void init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    device_t *d = enter(instance);
    (void)now_ns;
    d->host = host;
    d->safe = true;
    leave();
}

static uint16_t state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    (void)enter(instance);
    (void)from;
    (void)to;
    (void)now_ns;
    leave();
    return 0;
}

static void outputs(void *instance, uint64_t now_ns)
{
    device_t *d = enter(instance);
    (void)now_ns;
    d->outputs_calls++;
    d->taken = d->out.a;
    d->safe = false;
    leave();
}

static void safe_outputs(void *instance, uint64_t now_ns)
{
    device_t *d = enter(instance);
    (void)now_ns;
    fill(&d->out, 0);
    d->safe = true;
    leave();
}

static void inputs(void *instance, uint64_t now_ns)
{
    device_t *d = enter(instance);
    (void)now_ns;
    fill(&d->in, ++d->generation);
    leave();
}

static uint64_t tick(void *instance, uint64_t now_ns)
{
    device_t *d = enter(instance);
    d->tick_calls++;
    fill(&d->in, ++d->generation);
    leave();
    return now_ns + 10 * MS;
}

static void sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    (void)enter(instance);
    (void)index;
    (void)subindex;
    (void)now_ns;
    leave();
}

#define PIECE(sub, kind, bits, direction, member)                                                                      \
    {sub, ECT_TYPE_##kind, bits, ECT_ACCESS_RO | (direction), "Piece", 0, ECT_OFFSET(device_t, member)}
#define PIECES_OF(member, direction)                                                                                   \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(PIECES),                                                                                       \
        PIECE(1, UNSIGNED8, 8, direction, member.a),                                                                   \
        PIECE(2, UNSIGNED16, 16, direction, member.b),                                                                 \
        PIECE(3, UNSIGNED32, 32, direction, member.c),                                                                 \
        PIECE(4, OCTET_STRING, 40, direction, member.d),                                                               \
    }
#define MAPPING(index)                                                                                                 \
    {                                                                                                                  \
        ECT_ENTRY_COUNT(PIECES),                                                                                       \
        ECT_ENTRY_MAP(1, ECT_MAP(index, 1, 8)),                                                                        \
        ECT_ENTRY_MAP(2, ECT_MAP(index, 2, 16)),                                                                       \
        ECT_ENTRY_MAP(3, ECT_MAP(index, 3, 32)),                                                                       \
        ECT_ENTRY_MAP(4, ECT_MAP(index, 4, 40)),                                                                       \
    }

static const ect_entry_t e1010[] = ECT_ENTRIES_STORE("Save all");
static const ect_entry_t e1600[] = MAPPING(0x7000);
static const ect_entry_t e1a00[] = MAPPING(0x6000);
static const ect_entry_t e1c12[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1600)};
static const ect_entry_t e1c13[] = {ECT_ENTRY_COUNT(1), ECT_ENTRY_ASSIGN(1, 0x1A00)};
static const ect_entry_t e1c32[] = ECT_ENTRIES_SYNC(device_t, sync);
static const ect_entry_t e2100[] = {
    {0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW | ECT_ACCESS_BACKUP, "Stored", 7, ECT_OFFSET(device_t, stored)}};
static const ect_entry_t e6000[] = PIECES_OF(in, ECT_ACCESS_TXPDO);
static const ect_entry_t e7000[] = PIECES_OF(out, ECT_ACCESS_RXPDO);
static const ect_object_t objects[] = {
    ECT_ARRAY(0x1010, "Store", e1010),    ECT_RECORD(0x1600, "Outputs", e1600),
    ECT_RECORD(0x1A00, "Inputs", e1a00),  ECT_ARRAY(0x1C12, "SM2", e1c12),
    ECT_ARRAY(0x1C13, "SM3", e1c13),      ECT_SPARSE(0x1C32, RECORD, 32, "Sync", e1c32),
    ECT_VAR(0x2100, "Stored", e2100),     ECT_RECORD(0x6000, "Inputs", e6000),
    ECT_RECORD(0x7000, "Outputs", e7000),
};
static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &ect_protocol_sdo_info,
                                                  NULL};
static const ect_service_t *const services[] = {&ect_service_store, &ect_service_sync, NULL};
static const ect_dc_mode_t dc_modes[] = {{.name = "DC", .description = "SYNC0", .assign_activate = 0x0300}};

static const ect_device_t description = {
    .name = "contexts",
    .type_name = "contexts",
    .esc = "et1100",
    .sm = {{.start = 0x1000, .length = SIZE, .control = 0x26, .type = ECT_SM_MAILBOX_OUT},
           {.start = 0x1080, .length = SIZE, .control = 0x22, .type = ECT_SM_MAILBOX_IN},
           {.start = OUTPUTS, .control = 0x64, .type = ECT_SM_OUTPUTS},
           {.start = INPUTS, .control = 0x20, .type = ECT_SM_INPUTS}},
    .sm_count = 4,
    .mailbox_protocols = ECT_MAILBOX_COE,
    .protocols = protocols,
    .coe_details = ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_COMPLETE_ACCESS,
    .dc_modes = dc_modes,
    .dc_mode_count = 1,
    .sync = {.supported = 0x0007, .minimum_cycle_ns = 100000},
    .timeouts = {.preop_ms = 1000, .safeop_op_ms = 1000, .back_to_init_ms = 1000, .back_to_safeop_ms = 1000},
    .objects = objects,
    .object_count = sizeof objects / sizeof objects[0],
    .services = services,
    .instance_size = sizeof(device_t),
    .init = init,
    .state_change = state_change,
    .outputs = outputs,
    .safe_outputs = safe_outputs,
    .inputs = inputs,
    .tick = tick,
    .sdo_written = sdo_written,
};

/* --- the master --------------------------------------------------------------------------------------------------- */

/* Sends one datagram to station address 0. @return the working counter */
static unsigned int datagram(uint8_t command, uint16_t address, void *data, uint16_t length)
{
    uint8_t frame[200] = {[12] = 0x88, [13] = 0xA4};
    ect_store_le16(frame + 14, (uint16_t)(0x1000 | (length + 12)));
    frame[16] = command;
    ect_store_le16(frame + 20, address);
    ect_store_le16(frame + 22, length);
    memcpy(frame + 26, data, length);
    assert_int_equal(ect_esc_process(&t.esc, frame, 28u + length, t.now_ns), ECT_FRAME_FORWARD);
    memcpy(data, frame + 26, length);
    return frame[26 + length];
}

/* A new generation of outputs, and the present inputs: both consistent. */
static void master_cycle(void)
{
    uint8_t image[IMAGE];
    memset(image, ++t.sent, sizeof image);
    (void)datagram(FPWR, OUTPUTS, image, sizeof image);
    memset(image, 0, sizeof image);
    if (datagram(FPRD, INPUTS, image, sizeof image) == 1)
        expect(memcmp(image, image + 1, sizeof image - 1) == 0, "inputs of two generations in one image");
}

/* --- interrupts --------------------------------------------------------------------------------------------------- */

static void interrupt(void)
{
    t.in_interrupt = true;
    t.exchanges++;
    t.kept_out += t.slave.held ? 1u : 0u;
    ect_slave_cycle(&t.slave, t.now_ns);
    t.in_interrupt = false;
}

/* A place in mainline: at the chosen one the master's frame arrives, and its interrupt occurs. */
static void point(void)
{
    if (!t.in_mainline || t.in_interrupt)
        return;
    t.points++;
    if (t.points == t.at) {
        t.in_interrupt = true;
        master_cycle();
        interrupt();
    }
}

void __cyg_profile_func_enter(void *function, void *caller);
void __cyg_profile_func_exit(void *function, void *caller);

void __cyg_profile_func_enter(void *function, void *caller)
{
    (void)function;
    (void)caller;
    point();
}

void __cyg_profile_func_exit(void *function, void *caller)
{
    (void)function;
    (void)caller;
    point();
}

static int watched(int (*access)(void *ctx, uint16_t address, void *buffer, uint16_t length), uint16_t address,
                   void *buffer, uint16_t length)
{
    expect(!t.in_pdi, "a PDI access within another");
    t.in_pdi = true;
    point();
    int result = access(&t.esc, address, buffer, length);
    point();
    t.in_pdi = false;
    return result;
}

static int watched_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    (void)ctx;
    return watched(ect_esc_pdi_read, address, buffer, length);
}

static int write_through(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    return ect_esc_pdi_write(ctx, address, buffer, length);
}

static int watched_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    (void)ctx;
    return watched(write_through, address, (void *)(uintptr_t)buffer, length);
}

static int watched_event(void *ctx, uint32_t *event)
{
    return t.port.al_event(ctx, event);
}

/* --- the medium --------------------------------------------------------------------------------------------------- */

static int bank_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    (void)ctx;
    memcpy(buffer, t.bank[bank] + offset, length);
    return 0;
}

/* A medium is slow: the exchange must not wait for it. */
static void slow(void)
{
    if (t.slave.state == ECT_STATE_OP && !t.in_interrupt) {
        unsigned int before = t.device.outputs_calls;
        t.in_interrupt = true;
        master_cycle();
        interrupt();
        expect(t.device.outputs_calls == before + 1, "the exchange was blocked while the medium was being written");
    }
}

static int bank_erase(void *ctx, unsigned int bank)
{
    (void)ctx;
    slow();
    memset(t.bank[bank], 0xFF, BANK);
    return 0;
}

static int bank_write(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length)
{
    (void)ctx;
    slow();
    memcpy(t.bank[bank] + offset, data, length);
    return 0;
}

static int bank_flush(void *ctx, unsigned int bank, bool wait)
{
    (void)ctx;
    (void)bank;
    (void)wait;
    return 0;
}

/* --- the rig ------------------------------------------------------------------------------------------------------ */

static void power_on(unsigned long at, bool line, bool line_for_cycle)
{
    memset(&t, 0, sizeof t);
    t.at = at;
    t.now_ns = 1000 * MS;
    t.sii[0] = 0x08;
    t.sii[3] = 0x08; /* 0x0151: SYNC0 is an AL event */
    ect_store_le16(t.sii + 14, ect_crc_sii(t.sii));
    const ect_esc_config_t esc = {
        .personality = ect_esc_personality("et1100"), .memory = t.memory, .sii = t.sii, .sii_size = sizeof t.sii};
    assert_int_equal(ect_esc_init(&t.esc, &esc, t.now_ns), 0);
    t.port = line ? ect_virtual_line_pdi(&t.esc) : ect_virtual_pdi(&t.esc);
    t.pdi = (ect_pdi_t){.ctx = &t.esc, .read = watched_read, .write = watched_write, .al_event = watched_event};
    t.storage = (ect_storage_t){
        .bank_size = BANK, .read = bank_read, .erase = bank_erase, .write = bank_write, .flush = bank_flush};
    memset(&t.device, 0xEE, sizeof t.device);
    fill(&t.device.out, 0);
    const ect_slave_config_t slave = {.device = &description,
                                      .pdi = &t.pdi,
                                      .storage = &t.storage,
                                      .instance = &t.device,
                                      .mailbox = t.mailbox,
                                      .staging = t.staging,
                                      .staging_size = sizeof t.staging,
                                      .process_data = t.process_data,
                                      .process_size = sizeof t.process_data,
                                      .runs = t.runs,
                                      .run_count = 2 * PIECES,
                                      .line_for_cycle = line_for_cycle};
    assert_int_equal(ect_slave_init(&t.slave, &slave, t.now_ns), 0);
}

/* Handles the master's accesses: the line's interrupt for process data, then mainline. */
static void split_poll(void)
{
    for (unsigned int i = 0; i < 3; i++) {
        t.now_ns += MS / 10;
        (void)ect_esc_tick(&t.esc, t.now_ns);
        interrupt();
        t.in_mainline = true;
        (void)ect_slave_mainline(&t.slave, t.now_ns);
        t.in_mainline = false;
        expect(!t.slave.missed && !t.slave.held, "a blocked exchange was not repeated");
        expect(t.device.safe || t.slave.state == ECT_STATE_OP, "outputs are live outside OP");
    }
}

static void (*work)(void); /* makes the slave work after a frame */

static unsigned int send(uint8_t command, uint16_t address, void *data, uint16_t length)
{
    unsigned int counter = datagram(command, address, data, length);
    work();
    return counter;
}

static void set_sm(unsigned int n, uint16_t length)
{
    uint8_t registers[8] = {0};
    send(FPWR, (uint16_t)(ECT_REG_SM + 8 * n + ECT_SM_ACTIVATE), registers, 1);
    ect_store_le16(registers, description.sm[n].start);
    ect_store_le16(registers + 2, length);
    registers[4] = description.sm[n].control;
    registers[6] = length > 0;
    send(FPWR, (uint16_t)(ECT_REG_SM + 8 * n), registers, 8);
}

static uint16_t al_status(void)
{
    uint8_t status[2] = {0};
    (void)datagram(FPRD, ECT_REG_AL_STATUS, status, sizeof status);
    return ect_load_le16(status);
}

static uint16_t al_code(void)
{
    uint8_t code[2] = {0};
    (void)datagram(FPRD, ECT_REG_AL_STATUS_CODE, code, sizeof code);
    return ect_load_le16(code);
}

static uint16_t request(uint8_t state)
{
    uint8_t control[2] = {state, 0};
    send(FPWR, ECT_REG_AL_CONTROL, control, sizeof control);
    return al_status();
}

static void mail(const uint8_t *coe, uint16_t length)
{
    uint8_t bytes[SIZE] = {0};
    t.counter = (uint8_t)(t.counter % 7 + 1);
    ect_store_le16(bytes, length);
    bytes[5] = (uint8_t)(ECT_MAILBOX_TYPE_COE | (t.counter << 4));
    memcpy(bytes + 6, coe, length);
    assert_int_equal(send(FPWR, 0x1000, bytes, SIZE), 1);
}

/* @return whether there was one */
static bool fetch(uint8_t answer[SIZE])
{
    memset(answer, 0, SIZE);
    return send(FPRD, 0x1080, answer, SIZE) == 1;
}

static void expect_sdo(const uint8_t *coe, uint16_t length, uint8_t answer[SIZE])
{
    mail(coe, length);
    expect(fetch(answer), "no reply to an SDO");
    expect(answer[8] != 0x80, "an SDO was refused");
}

static void upload_whole_inputs(void)
{
    const uint8_t coe[10] = {0, 0x20, 0x50, 0x00, 0x60, 0x01};
    uint8_t answer[SIZE];
    expect_sdo(coe, sizeof coe, answer);
    expect(ect_load_le32(answer + 12) == IMAGE, "the inputs are twelve bytes");
    expect(memcmp(answer + 16, answer + 17, IMAGE - 1) == 0, "an object was read in two generations");
}

static void store_all(void)
{
    const uint8_t coe[10] = {0, 0x20, 0x23, 0x10, 0x10, 0x01, 's', 'a', 'v', 'e'};
    uint8_t answer[SIZE];
    expect_sdo(coe, sizeof coe, answer);
}

static void to_op(void)
{
    set_sm(0, SIZE);
    set_sm(1, SIZE);
    expect(request(ECT_STATE_PREOP) == ECT_STATE_PREOP, "PREOP not reached");
    set_sm(2, IMAGE);
    set_sm(3, IMAGE);
    expect(request(ECT_STATE_SAFEOP) == ECT_STATE_SAFEOP, "SAFEOP not reached");
    expect(t.device.outputs_calls == 0, "outputs arrived in SAFEOP");
    master_cycle();
    work();
    expect(request(ECT_STATE_OP) == ECT_STATE_OP, "OP not reached");
    expect(t.device.taken == t.sent, "outputs that the master wrote before OP were not applied with it");
}

static void life(void)
{
    to_op();
    for (unsigned int i = 0; i < 3; i++) {
        master_cycle();
        work();
        expect(t.device.taken == t.sent, "outputs were lost");
    }
    upload_whole_inputs();
    store_all();
    master_cycle();
    work();
    expect(t.device.taken == t.sent, "outputs were lost");
    expect(request(ECT_STATE_PREOP) == ECT_STATE_PREOP, "PREOP not reached from OP");
    expect(t.device.safe && t.device.out.a == 0, "outputs are not safe");
    upload_whole_inputs();
    expect(request(ECT_STATE_INIT) == ECT_STATE_INIT, "INIT not reached");
}

/* --- the exchange interrupts mainline ----------------------------------------------------------------------------- */

static void everywhere(void **state)
{
    (void)state;
    work = split_poll;
    power_on(0, false, false);
    life();
    assert_null(t.broken);
    unsigned long points = t.points;
    unsigned long kept_out = 0;
    assert_true(points > 2000); /* functions, not only PDI accesses */
    for (unsigned long at = 1; at <= points; at++) {
        power_on(at, false, false);
        life();
        if (t.broken)
            fail_msg("interrupt at point %lu of %lu: %s", at, points, t.broken);
        kept_out += t.kept_out;
    }
    assert_true(kept_out > points / 2);
}

/* A slow operation of the medium, e.g. an erase, must not let the master's watchdog expire. */
static void exchange_continues(void **state)
{
    (void)state;
    work = split_poll;
    power_on(0, false, false);
    to_op();
    unsigned int before = t.device.outputs_calls;
    store_all();
    assert_null(t.broken);
    assert_true(t.device.outputs_calls >= before + 2); /* one while erasing, one at least while writing */
}

static void no_exchange_below_safeop(void **state)
{
    (void)state;
    work = split_poll;
    power_on(0, false, false);
    unsigned long errors = t.slave.pdi_errors;
    ect_slave_cycle(&t.slave, t.now_ns);
    assert_int_equal(t.device.outputs_calls, 0);
    assert_int_equal(t.slave.pdi_errors, errors);
    set_sm(0, SIZE);
    set_sm(1, SIZE);
    assert_int_equal(request(ECT_STATE_PREOP), ECT_STATE_PREOP);
    master_cycle();
    ect_slave_cycle(&t.slave, t.now_ns);
    assert_int_equal(t.device.outputs_calls, 0);
}

/* --- the interrupt line ------------------------------------------------------------------------------------------- */

/* A firmware that sleeps: it polls while the line is active, and at the time that the last poll returned. */
static uint64_t deadline_ns;

static void sleep_and_wake(void)
{
    t.now_ns += MS / 10;
    (void)ect_esc_tick(&t.esc, t.now_ns);
    for (unsigned int polls = 0; ect_esc_line(&t.esc) || t.now_ns >= deadline_ns; polls++) {
        expect(polls < 6, "the line stays up: a level interrupt would never end");
        if (t.broken)
            return;
        deadline_ns = ect_slave_poll(&t.slave, t.now_ns);
        t.now_ns += MS / 100;
        (void)ect_esc_tick(&t.esc, t.now_ns);
    }
}

static void start_line(void)
{
    work = sleep_and_wake;
    power_on(0, true, false);
    deadline_ns = ect_slave_poll(&t.slave, t.now_ns);
}

static void pass(uint64_t ns)
{
    for (uint64_t end = t.now_ns + ns; t.now_ns < end;)
        sleep_and_wake();
}

static void line_life(void **state)
{
    (void)state;
    start_line();
    assert_false(ect_esc_line(&t.esc));
    life();
    if (t.broken)
        fail_msg("%s", t.broken);
}

static void line_watchdog(void **state)
{
    (void)state;
    start_line();
    to_op();
    assert_false(t.device.safe);
    pass(99 * MS); /* the reset value of the watchdog is 100 ms */
    assert_int_equal(al_status(), ECT_STATE_OP);
    pass(2 * MS);
    assert_int_equal(al_status(), ECT_STATE_SAFEOP | ECT_AL_ERROR);
    assert_int_equal(al_code(), ECT_AL_WATCHDOG);
    assert_true(t.device.safe);
    assert_int_equal(t.device.out.a, 0);
    assert_null(t.broken);
}

static void line_sm_off(void **state)
{
    (void)state;
    start_line();
    to_op();
    set_sm(2, 0);
    assert_int_equal(al_status(), ECT_STATE_PREOP | ECT_AL_ERROR);
    assert_int_equal(al_code(), ECT_AL_OUTPUT_SM);
    assert_true(t.device.safe);
    assert_null(t.broken);
}

/* Each fragment of the list follows in the interrupt that the read of the previous one causes. */
static void line_mails(void **state)
{
    (void)state;
    const uint8_t list[8] = {0, 0x80, 1, 0, 0, 0, 1, 0};
    const uint8_t upload[10] = {0, 0x20, 0x40, 0x00, 0x21, 0};
    const uint8_t data[5] = {1, 2, 3, 4, 5};
    uint8_t answer[SIZE];
    start_line();
    to_op();
    mail(list, sizeof list);
    t.device.host->emergency(t.device.host->ctx, 0x1234, 0, data); /* while the list's mail is pending */
    ect_slave_wake(&t.slave);
    pass(20 * MS);
    assert_true(fetch(answer));
    assert_int_equal(answer[8], 0x02); /* the list */
    assert_true(fetch(answer));
    assert_int_equal(ect_load_le16(answer + 8), 0x1234);
    mail(upload, sizeof upload);
    mail(upload, sizeof upload); /* before the reply to the first was fetched */
    assert_true(fetch(answer));
    assert_int_equal(ect_load_le32(answer + 12), 7);
    assert_true(fetch(answer));
    assert_int_equal(ect_load_le32(answer + 12), 7);
    assert_false(fetch(answer));
    assert_false(ect_esc_line(&t.esc));
    assert_null(t.broken);
}

/* SYNC0 runs from PREOP on; it causes no interrupt below SAFEOP, and is acknowledged from SAFEOP on. */
static void line_sync0(void **state)
{
    (void)state;
    uint8_t bytes[8];
    start_line();
    set_sm(0, SIZE);
    set_sm(1, SIZE);
    expect(request(ECT_STATE_PREOP) == ECT_STATE_PREOP, "PREOP not reached");
    ect_store_le32(bytes, 1000000);
    send(FPWR, ECT_REG_DC_SYNC0_CYCLE, bytes, 4);
    const uint64_t first_ns = t.now_ns + 5 * MS;
    ect_store_le64(bytes, first_ns - 1000 * MS);
    send(FPWR, ECT_REG_DC_START_TIME, bytes, 8);
    bytes[0] = 3;
    send(FPWR, ECT_REG_DC_ACTIVATION, bytes, 1);
    pass(10 * MS);
    assert_true((ect_esc_al_event(&t.esc) & ECT_EVENT_SYNC0) != 0);
    assert_false(ect_esc_line(&t.esc));
    set_sm(2, IMAGE);
    set_sm(3, IMAGE);
    expect(request(ECT_STATE_SAFEOP) == ECT_STATE_SAFEOP, "SAFEOP not reached");
    pass(3 * MS);
    assert_int_equal(ect_esc_al_event(&t.esc) & ECT_EVENT_SYNC0, 0); /* acknowledged, again and again */
    master_cycle();
    work();
    expect(request(ECT_STATE_OP) == ECT_STATE_OP, "OP not reached");
    uint64_t last_ns = 0;
    for (unsigned int i = 0; i < 5; i++) {
        last_ns = t.now_ns;
        master_cycle();
        pass(MS);
        assert_int_equal(ect_esc_al_event(&t.esc) & ECT_EVENT_SYNC0, 0);
    }
    assert_int_equal(al_status(), ECT_STATE_OP);
    /* The master stops: SYNC0 alone detects this, after one more than the successive errors that 10F1h:2 allows. */
    while (al_status() == ECT_STATE_OP && t.now_ns < last_ns + 20 * MS)
        pass(MS / 10);
    assert_int_equal((t.now_ns - first_ns) / MS - (last_ns - first_ns) / MS,
                     6); /* those of the last outputs, and five without */
    assert_int_equal(al_status(), ECT_STATE_SAFEOP | ECT_AL_ERROR);
    assert_int_equal(al_code(), ECT_AL_SYNC);
    assert_null(t.broken);
}

static uint32_t mask(void)
{
    uint8_t bytes[4] = {0};
    (void)datagram(FPRD, ECT_REG_AL_EVENT_MASK, bytes, sizeof bytes);
    return ect_load_le32(bytes);
}

static void line_masks(void **state)
{
    (void)state;
    enum { CONTROL = ECT_EVENT_AL_CONTROL | ECT_EVENT_SM_CHANGED | ECT_EVENT_WATCHDOG };
    start_line();
    assert_int_equal(mask() & 0xFFFF, CONTROL);
    to_op();
    assert_int_equal(mask() & 0xFFFF, CONTROL | ECT_EVENT_SM0 | ECT_EVENT_SM2 | ECT_EVENT_SM3 | ECT_EVENT_SYNC0);
    expect(request(ECT_STATE_PREOP) == ECT_STATE_PREOP, "PREOP not reached");
    assert_int_equal(mask() & 0xFFFF, CONTROL | ECT_EVENT_SM0);
    expect(request(ECT_STATE_INIT) == ECT_STATE_INIT, "INIT not reached");
    assert_int_equal(mask() & 0xFFFF, CONTROL);
    assert_null(t.broken);
}

/* A line for the exchange only: mainline ignores its level. */
static void line_for_cycle(void **state)
{
    (void)state;
    work = split_poll;
    power_on(0, true, true);
    split_poll();
    assert_int_equal(mask() & 0xFFFF, 0);
    to_op();
    if (t.broken)
        fail_msg("%s", t.broken);
    assert_int_equal(mask() & 0xFFFF, ECT_EVENT_SM2 | ECT_EVENT_SM3 | ECT_EVENT_SYNC0);
    assert_false(ect_esc_line(&t.esc));
    master_cycle();
    assert_true(ect_esc_line(&t.esc));
    ect_slave_cycle(&t.slave, t.now_ns);
    assert_false(ect_esc_line(&t.esc));
    assert_int_equal(t.device.taken, t.sent);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"Contexts: an exchange that interrupts mainline at any PDI access or function neither loses nor splits data",
         everywhere, NULL, NULL, NULL},
        {"Contexts: while a medium is being written the exchange continues", exchange_continues, NULL, NULL, NULL},
        {"Contexts: below SAFEOP nothing is exchanged", no_exchange_below_safeop, NULL, NULL, NULL},
        {"Line: from INIT to OP and back by interrupts alone", line_life, NULL, NULL, NULL},
        {"Line: the process-data watchdog leads to SAFEOP with 0x001B and safe outputs (CF-047)", line_watchdog, NULL,
         NULL, NULL},
        {"Line: a SyncManager that the master switches off leads to PREOP with 0x001D", line_sm_off, NULL, NULL, NULL},
        {"Line: a reply that waits for the read of a mail follows in the interrupt of the read", line_mails, NULL, NULL,
         NULL},
        {"Line: SYNC0 does not activate it below SAFEOP, is acknowledged from there, and supervises in OP", line_sync0,
         NULL, NULL, NULL},
        {"Line: the AL event mask enables the events of each state", line_masks, NULL, NULL, NULL},
        {"Line: a line for the exchange alone", line_for_cycle, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("contexts", tests, NULL, NULL);
}
