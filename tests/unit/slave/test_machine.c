/* SPDX-License-Identifier: MIT */
/* Execution of the state machine, observed on the wire: transitions, their checks, drops, timeouts, identification. */
#include <stdio.h>
#include <string.h>

#include "devices/eclink/eclink.h"
#include "support/every.h"
#include "support/testdev.h"
#include "support/wire.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

enum {
    INIT = ECT_STATE_INIT,
    PREOP = ECT_STATE_PREOP,
    BOOT = ECT_STATE_BOOT,
    SAFEOP = ECT_STATE_SAFEOP,
    OP = ECT_STATE_OP
};
enum { ERR = ECT_AL_ERROR, ACK = ECT_AL_ACKNOWLEDGE, ID = ECT_AL_IDENT };

static const uint8_t states[] = {INIT, PREOP, SAFEOP, OP};

/* --- helpers ----------------------------------------------------------------------------------------------------- */

static void open_with_alias(wire_t *w, const ect_device_t *device, uint16_t alias)
{
    ect_twin_config_t twin = ect_twin_default(device, plant_of(device));
    twin.alias = alias;
    wire_open_twins(w, &twin, 1);
}

static ect_slave_t *slave_of(wire_t *w)
{
    return (ect_slave_t *)(uintptr_t)ect_chain_slave(w->chain, 0);
}

static void al(wire_t *w, uint8_t *status, uint16_t *code)
{
    uint8_t bytes[6] = {0};
    assert_int_equal(wire_read(w, 0, ECT_REG_AL_STATUS, bytes, 6), 1);
    *status = bytes[0];
    *code = ect_load_le16(bytes + 4);
}

static void expect(wire_t *w, const char *where, uint8_t status, uint16_t code)
{
    uint8_t got;
    uint16_t got_code;
    al(w, &got, &got_code);
    if (got != status || got_code != code)
        fail_msg("%s, %s: expected AL status 0x%02X code 0x%04X, got 0x%02X code 0x%04X", wire_device(w, 0)->name,
                 where, status, code, got, got_code);
}

static void request(wire_t *w, uint16_t value)
{
    assert_int_equal(wire_write16(w, 0, ECT_REG_AL_CONTROL, value), 1);
}

static void ask(wire_t *w, const char *where, uint16_t value, uint8_t status, uint16_t code)
{
    request(w, value);
    expect(w, where, status, code);
}

static int outputs(wire_t *w, uint8_t value)
{
    return wire_outputs(w, 0, value);
}

static void drop(wire_t *w, uint8_t state, uint16_t code)
{
    const ect_host_t *host = testdev_of(w, 0)->host;
    host->drop(host->ctx, state, code);
    (void)ect_slave_poll(slave_of(w), w->now_ns);
}

static void done(wire_t *w, uint16_t code)
{
    const ect_host_t *host = testdev_of(w, 0)->host;
    host->transition_done(host->ctx, code);
    (void)ect_slave_poll(slave_of(w), w->now_ns);
}

/* Enters `state` with error flag and any code, by a drop of the device itself. Only the test device. */
static void go_with_error(wire_t *w, uint8_t state, uint16_t code)
{
    if (state == OP) {
        wire_go(w, 0, OP);
        ask(w, "unknown state", 0x07, OP | ERR, 0x0012);
        return;
    }
    wire_go(w, 0, state == INIT ? PREOP : state == PREOP ? SAFEOP : OP);
    drop(w, state, code);
    expect(w, "drop", state | ERR, code);
}

/* --- power-up ---------------------------------------------------------------------------------------------------- */

static void power_up(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        wire_t w;
        wire_open_one(&w, every_device(i));
        expect(&w, "power-up", INIT, 0);
        for (unsigned int n = 0; n < every_device(i)->sm_count; n++)
            assert_int_equal(wire_read8(&w, 0, (uint16_t)(ECT_REG_SM + 8 * n + ECT_SM_PDI_CONTROL)) & 1, 1);
        wire_close(&w);
    }
}

/* --- transitions ------------------------------------------------------------------------------------------------- */

/* Spec C.2; columns INIT PREOP BOOT SAFEOP OP; '=' same, '+' entered, 'x' 0x0011, 'b' 0x0013. */
static const struct {
    uint8_t from;
    const char *to;
} table[] = {{INIT, "=+bxx"}, {PREOP, "+=x+x"}, {SAFEOP, "++x=+"}, {OP, "++x+="}};
static const uint8_t columns[] = {INIT, PREOP, BOOT, SAFEOP, OP};

static void one_transition(const ect_device_t *device, uint8_t from, uint8_t to, char want, uint16_t bits)
{
    wire_t w;
    char where[64];
    (void)snprintf(where, sizeof where, "state %u asked for %u | 0x%02X", from, to, bits);
    wire_open_one(&w, device);
    wire_go(&w, 0, from);
    if (from == INIT)
        wire_configure_mailbox(&w, 0);
    if (from <= PREOP)
        wire_configure_process_data(&w, 0);
    if (from == SAFEOP)
        assert_int_equal(outputs(&w, 0), 1);
    if (want == '=' || want == '+')
        ask(&w, where, to | bits, to, 0);
    else
        ask(&w, where, to | bits, from | ERR, want == 'b' ? 0x0013 : 0x0011);
    wire_close(&w);
}

static void every_pair(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        for (size_t row = 0; row < COUNT(table); row++) {
            for (size_t column = 0; column < COUNT(columns); column++) {
                one_transition(every_device(i), table[row].from, columns[column], table[row].to[column], 0);
                one_transition(every_device(i), table[row].from, columns[column], table[row].to[column], ACK);
            }
        }
    }
}

static void unknown_states(void **state)
{
    (void)state;
    static const uint8_t unknown[] = {0, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15};
    for (size_t s = 0; s < COUNT(states); s++) {
        for (size_t n = 0; n < COUNT(unknown); n++) {
            wire_t w;
            wire_open_one(&w, &testdev);
            wire_go(&w, 0, states[s]);
            ask(&w, "unknown state", unknown[n], states[s] | ERR, 0x0012);
            ask(&w, "acknowledged", states[s] | ACK, states[s], 0);
            wire_close(&w);
        }
    }
}

static void device_is_notified_of_transitions(void **state)
{
    (void)state;
    for (size_t row = 0; row < COUNT(table); row++) {
        for (size_t column = 0; column < COUNT(columns); column++) {
            if (table[row].to[column] != '+')
                continue;
            wire_t w;
            wire_open_one(&w, &testdev);
            wire_go(&w, 0, table[row].from);
            wire_configure_mailbox(&w, 0);
            wire_configure_process_data(&w, 0);
            wire_go(&w, 0, table[row].from);
            outputs(&w, 0);
            testdev_of(&w, 0)->from = testdev_of(&w, 0)->to = 0;
            if (table[row].from == PREOP)
                wire_configure_process_data(&w, 0);
            if (table[row].from == INIT)
                wire_configure_mailbox(&w, 0);
            request(&w, columns[column]);
            if (testdev_of(&w, 0)->from != table[row].from || testdev_of(&w, 0)->to != columns[column])
                fail_msg("%u to %u: the device was notified of %u to %u", table[row].from, columns[column],
                         testdev_of(&w, 0)->from, testdev_of(&w, 0)->to);
            wire_close(&w);
        }
    }
}

static void sms_follow_state(void **state)
{
    (void)state;
    static const uint8_t walk[] = {INIT, PREOP, SAFEOP, OP, SAFEOP, PREOP, INIT};
    for (size_t i = 0; every_device(i); i++) {
        const ect_device_t *device = every_device(i);
        unsigned int process = process_sms_of(device), mailbox = mailbox_sms_of(device);
        wire_t w;
        wire_open_one(&w, device);
        wire_configure_mailbox(&w, 0);
        for (size_t n = 0; n < COUNT(walk); n++) {
            unsigned int on = (walk[n] >= PREOP ? mailbox : 0) | (walk[n] >= SAFEOP ? process : 0);
            if (walk[n] == SAFEOP && n < 3)
                wire_configure_process_data(&w, 0);
            if (walk[n] == OP)
                outputs(&w, 0);
            ask(&w, "walk", walk[n], walk[n], 0);
            for (unsigned int sm = 0; sm < device->sm_count; sm++) {
                uint8_t off = wire_read8(&w, 0, (uint16_t)(ECT_REG_SM + 8 * sm + ECT_SM_PDI_CONTROL)) & 1;
                if (off == (on >> sm & 1))
                    fail_msg("%s, step %zu, state %u: SM%u off is %u", device->name, n, walk[n], sm, off);
            }
        }
        wire_close(&w);
    }
}

/* --- SyncManager checks ------------------------------------------------------------------------------------------ */

typedef struct sm_fault {
    const char *what;
    int start, length; /* differences */
    uint8_t control;   /* inverted bits */
    bool disabled;
    bool allowed;
} sm_fault_t;

static const sm_fault_t sm_faults[] = {
    {"as described", 0, 0, 0, false, true},
    {"start - 1", -1, 0, 0, false, false},
    {"start + 1", 1, 0, 0, false, false},
    {"start + 0x100", 0x100, 0, 0, false, false},
    {"length - 1", 0, -1, 0, false, false},
    {"length + 1", 0, 1, 0, false, false},
    {"length + 256", 0, 256, 0, false, false},
    {"mode bit 0", 0, 0, 0x01, false, false},
    {"mode bit 1", 0, 0, 0x02, false, false},
    {"direction", 0, 0, 0x04, false, false},
    {"direction, upper bit", 0, 0, 0x08, false, false},
    {"no PDI event", 0, 0, 0x20, false, false},
    {"switched off", 0, 0, 0, true, false},
    {"ECAT event", 0, 0, 0x10, false, true},
    {"watchdog trigger", 0, 0, 0x40, false, true},
};

static void set_sm(wire_t *w, unsigned int n, const sm_fault_t *fault)
{
    const ect_sm_t *sm = &wire_device(w, 0)->sm[n];
    wire_set_sm(w, 0, n, (uint16_t)(sm->start + fault->start),
                (uint16_t)(ect_device_sm_bytes(wire_device(w, 0), n) + fault->length), sm->control ^ fault->control);
    if (fault->disabled)
        assert_int_equal(wire_write8(w, 0, (uint16_t)(ECT_REG_SM + 8 * n + ECT_SM_ACTIVATE), 0), 1);
}

static void mailbox_checked(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        for (unsigned int n = 0; n < 2 && mailbox_sms_of(every_device(i)) != 0; n++) {
            for (size_t f = 0; f < COUNT(sm_faults); f++) {
                bool allowed = sm_faults[f].allowed;
                bool in_limits =
                    every_device(i)->sm[n].minimum != 0 && (sm_faults[f].length == 1 || sm_faults[f].length == -1);
                wire_t w;
                wire_open_one(&w, every_device(i));
                wire_configure_mailbox(&w, 0);
                set_sm(&w, n, &sm_faults[f]);
                if (allowed || in_limits)
                    ask(&w, sm_faults[f].what, PREOP, PREOP, 0);
                else
                    ask(&w, sm_faults[f].what, PREOP, INIT | ERR, 0x0016);
                ask(&w, "back", INIT | ACK, INIT, 0);
                wire_configure_mailbox(&w, 0);
                ask(&w, "then right", PREOP, PREOP, 0);
                wire_close(&w);
            }
        }
    }
}

static void mailbox_length_limits(void **state)
{
    (void)state;
    static const struct {
        uint16_t length;
        bool allowed;
    } rows[] = {{0, false},  {1, false},  {33, false}, {34, true},   {35, true},   {127, true},
                {128, true}, {255, true}, {256, true}, {257, false}, {1024, false}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        wire_t w;
        char where[32];
        (void)snprintf(where, sizeof where, "SM1 length %u", rows[i].length);
        wire_open_one(&w, &testdev);
        wire_configure_mailbox(&w, 0);
        wire_set_sm(&w, 0, 1, 0x1080, rows[i].length, 0x22);
        ask(&w, where, PREOP, rows[i].allowed ? PREOP : INIT | ERR, rows[i].allowed ? 0 : 0x0016);
        wire_close(&w);
    }
}

/* A direction without data requires its SyncManager off, or of length 0. */
static bool process_fault_allowed(const ect_device_t *device, unsigned int n, const sm_fault_t *f)
{
    if (ect_device_sm_bytes(device, n) == 0)
        return f->disabled || f->length <= 0;
    return f->allowed;
}

static void process_sm_checked(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        const ect_device_t *device = every_device(i);
        for (unsigned int n = 0; n < device->sm_count; n++) {
            uint16_t code = device->sm[n].type == ECT_SM_OUTPUTS ? 0x001D : 0x001E;
            for (size_t f = 0; f < COUNT(sm_faults); f++) {
                bool impossible_blocks = ect_device_sm_bytes(device, n) == 0 && sm_faults[f].length < 0;
                if (impossible_blocks || (process_sms_of(device) >> n & 1) == 0)
                    continue;
                wire_t w;
                wire_open_one(&w, device);
                wire_go(&w, 0, PREOP);
                wire_configure_process_data(&w, 0);
                set_sm(&w, n, &sm_faults[f]);
                if (process_fault_allowed(device, n, &sm_faults[f]))
                    ask(&w, sm_faults[f].what, SAFEOP, SAFEOP, 0);
                else
                    ask(&w, sm_faults[f].what, SAFEOP, PREOP | ERR, code);
                ask(&w, "back", PREOP | ACK, PREOP, 0);
                wire_configure_process_data(&w, 0);
                ask(&w, "then right", SAFEOP, SAFEOP, 0);
                wire_close(&w);
            }
        }
    }
}

static void both_wrong(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, PREOP);
    ask(&w, "SM2 and SM3 off", SAFEOP, PREOP | ERR, 0x001D);
    wire_set_sm(&w, 0, 2, 0x1200, 3, 0x64);
    ask(&w, "SM3 off", SAFEOP | ACK, PREOP | ERR, 0x001E);
    wire_set_sm(&w, 0, 3, 0x1300, 3, 0x20);
    ask(&w, "both right", SAFEOP | ACK, SAFEOP, 0);
    wire_close(&w);
}

/* 1C13h is missing: the device has outputs only. */
static void output_only(void **state)
{
    (void)state;
    ect_object_t objects[64];
    ect_device_t device = testdev;
    device.objects = objects;
    device.object_count = 0;
    for (uint16_t i = 0; i < testdev.object_count; i++) {
        if (testdev.objects[i].index != 0x1C13)
            objects[device.object_count++] = testdev.objects[i];
    }
    wire_t w;
    wire_open_one(&w, &device);
    wire_go(&w, 0, PREOP);
    wire_configure_process_data(&w, 0);
    wire_set_sm(&w, 0, 3, 0x1300, 3, 0x20);
    ask(&w, "SM3 on", SAFEOP, PREOP | ERR, 0x001E);
    wire_set_sm(&w, 0, 3, 0x1300, 0, 0x20);
    ask(&w, "SM3 off", SAFEOP | ACK, SAFEOP, 0);
    assert_int_equal(outputs(&w, 0xFF), 1);
    ask(&w, "to OP", OP, OP, 0);
    assert_int_equal(outputs(&w, 0xFF), 1);
    assert_int_equal(testdev_of(&w, 0)->out_u16, 0xFFFF);
    wire_close(&w);
}

/* A device with only a mailbox. */
static void mailbox_only(void **state)
{
    (void)state;
    ect_object_t objects[64];
    ect_device_t device = testdev;
    device.objects = objects;
    device.object_count = 0;
    for (uint16_t i = 0; i < testdev.object_count; i++) {
        if (testdev.objects[i].index != 0x1C13 && testdev.objects[i].index != 0x1C12)
            objects[device.object_count++] = testdev.objects[i];
    }
    device.sm_count = 2;
    wire_t w;
    wire_open_one(&w, &device);
    wire_configure_mailbox(&w, 0);
    ask(&w, "mailbox only", PREOP, PREOP, 0);
    ask(&w, "mailbox only", SAFEOP, SAFEOP, 0);
    ask(&w, "mailbox only", OP, OP, 0);
    ask(&w, "mailbox only", PREOP, PREOP, 0);
    wire_close(&w);
}

/* A device without a mailbox: PREOP does not check SM0 and SM1. */
static void no_mailbox(void **state)
{
    (void)state;
    ect_device_t device = testdev;
    device.mailbox_protocols = 0;
    wire_t w;
    wire_open_one(&w, &device);
    ask(&w, "no mailbox", PREOP, PREOP, 0);
    wire_configure_process_data(&w, 0);
    ask(&w, "no mailbox", SAFEOP, SAFEOP, 0);
    assert_int_equal(outputs(&w, 0), 1);
    ask(&w, "no mailbox", OP, OP, 0);
    wire_set_sm(&w, 0, 0, 0x1000, 64, 0x26);
    expect(&w, "SM0 is nobody's business", OP, 0);
    ask(&w, "no mailbox", INIT, INIT, 0);
    wire_close(&w);
}

/* --- BOOT -------------------------------------------------------------------------------------------------------- */

static void boot_state(void **state)
{
    (void)state;
    ect_device_t device = testdev;
    device.boot_out = (ect_boot_mailbox_t){0x1000, 256};
    device.boot_in = (ect_boot_mailbox_t){0x1100, 256};
    wire_t w;
    wire_open_one(&w, &device);
    wire_configure_mailbox(&w, 0);
    ask(&w, "standard mailbox", BOOT, INIT | ERR, 0x0015);
    wire_set_sm(&w, 0, 0, 0x1000, 256, 0x26);
    ask(&w, "SM0 of BOOT only", BOOT | ACK, INIT | ERR, 0x0015);
    wire_set_sm(&w, 0, 1, 0x1100, 256, 0x22);
    ask(&w, "bootstrap mailbox", BOOT | ACK, BOOT, 0);
    assert_int_equal(testdev_of(&w, 0)->outputs_calls, 0);
    ask(&w, "BOOT to PREOP", PREOP, BOOT | ERR, 0x0011);
    ask(&w, "BOOT to INIT", INIT | ACK, INIT, 0);
    wire_close(&w);
}

/* --- error flag and acknowledge ---------------------------------------------------------------------------------- */

static void unacknowledged(void **state)
{
    (void)state;
    static const uint8_t requested[] = {PREOP, BOOT, SAFEOP, OP, 0, 5, 15};
    for (size_t s = 0; s < COUNT(states); s++) {
        uint16_t code = states[s] == OP ? 0x0012 : 0x8123;
        for (size_t n = 0; n < COUNT(requested); n++) {
            wire_t w;
            wire_open_one(&w, &testdev);
            go_with_error(&w, states[s], code);
            ask(&w, "without acknowledge", requested[n], states[s] | ERR, code);
            ask(&w, "without acknowledge, identification wanted", requested[n] | ID, states[s] | ERR, code);
            ask(&w, "acknowledged", states[s] | ACK, states[s], 0);
            wire_close(&w);
        }
        wire_t w;
        wire_open_one(&w, &testdev);
        go_with_error(&w, states[s], code);
        ask(&w, "INIT without acknowledge", INIT, INIT, 0);
        wire_close(&w);
    }
}

static void acknowledge_and_go(void **state)
{
    (void)state;
    static const struct {
        uint8_t in;
        uint16_t requested;
        uint8_t status;
        uint16_t code;
    } rows[] = {
        {INIT, PREOP | ACK, PREOP, 0},
        {INIT, SAFEOP | ACK, INIT | ERR, 0x0011},
        {INIT, BOOT | ACK, INIT | ERR, 0x0013},
        {PREOP, SAFEOP | ACK, SAFEOP, 0},
        {PREOP, OP | ACK, PREOP | ERR, 0x0011},
        {PREOP, INIT | ACK, INIT, 0},
        {PREOP, 7 | ACK, PREOP | ERR, 0x0012},
        {SAFEOP, PREOP | ACK, PREOP, 0},
        {SAFEOP, INIT | ACK, INIT, 0},
        {SAFEOP, BOOT | ACK, SAFEOP | ERR, 0x0011},
        {OP, OP | ACK, OP, 0},
        {OP, SAFEOP | ACK, SAFEOP, 0},
        {OP, PREOP | ACK, PREOP, 0},
        {OP, INIT | ACK, INIT, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        wire_t w;
        char where[64];
        (void)snprintf(where, sizeof where, "row %zu: 0x%02X in state %u with error", i, rows[i].requested, rows[i].in);
        wire_open_one(&w, &testdev);
        go_with_error(&w, rows[i].in, rows[i].in == OP ? 0x0012 : 0x8001);
        wire_configure_mailbox(&w, 0);
        if (rows[i].in == INIT)
            expect(&w, where, INIT | ERR, 0x8001);
        wire_close(&w);
        wire_open_one(&w, &testdev);
        go_with_error(&w, rows[i].in, rows[i].in == OP ? 0x0012 : 0x8001);
        ask(&w, where, rows[i].requested, rows[i].status, rows[i].code);
        wire_close(&w);
    }
}

static void watchdog_error_then_op(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    go_with_error(&w, SAFEOP, 0x8001);
    request(&w, OP | ACK);
    expect(&w, "acknowledged, waits for outputs", SAFEOP, 0);
    assert_int_equal(outputs(&w, 1), 1);
    expect(&w, "outputs came", OP, 0);
    wire_close(&w);
}

/* The order in which the slave's software writes code and status. */
typedef struct order {
    ect_pdi_t real;
    ect_pdi_t pdi;
    ect_esc_t *esc;
    unsigned int status_writes;
    unsigned int bad;
} order_t;

static int order_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    order_t *o = ctx;
    return o->real.read(o->real.ctx, address, buffer, length);
}

static int order_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    order_t *o = ctx;
    if (address <= ECT_REG_AL_STATUS && address + length > ECT_REG_AL_STATUS) {
        uint8_t status = ((const uint8_t *)buffer)[ECT_REG_AL_STATUS - address];
        uint16_t code = ect_load_le16(o->esc->memory + ECT_REG_AL_STATUS_CODE);
        o->status_writes++;
        if (((status & (ERR | ID)) != 0) != (code != 0))
            o->bad++;
    }
    return o->real.write(o->real.ctx, address, buffer, length);
}

static void code_before_flag(void **state)
{
    (void)state;
    static const uint16_t requested[] = {OP,    INIT | ACK,        PREOP,        OP,          PREOP | ACK, PREOP | ID,
                                         PREOP, PREOP | ID,        OP,           PREOP | ACK, SAFEOP,      SAFEOP | ID,
                                         5,     SAFEOP | ACK | ID, SAFEOP | ACK, INIT | ID,   BOOT,        INIT | ACK,
                                         INIT};
    wire_t w;
    open_with_alias(&w, &testdev, 0x1234);
    order_t o = {.real = *slave_of(&w)->config.pdi, .esc = ect_chain_esc(w.chain, 0)};
    o.pdi = (ect_pdi_t){.ctx = &o, .read = order_read, .write = order_write};
    slave_of(&w)->config.pdi = &o.pdi;
    wire_configure_mailbox(&w, 0);
    wire_configure_process_data(&w, 0);
    for (size_t i = 0; i < COUNT(requested); i++)
        request(&w, requested[i]);
    wire_go(&w, 0, OP);
    drop(&w, SAFEOP, 0x8000);
    ask(&w, "back", OP | ACK, SAFEOP, 0);
    outputs(&w, 1);
    wire_advance(&w, 200 * MS);
    expect(&w, "watchdog", SAFEOP | ERR, 0x001B);
    assert_true(o.status_writes > 15);
    if (o.bad != 0)
        fail_msg("%u of %u writes of AL status did not find their code in 0x0134", o.bad, o.status_writes);
    wire_close(&w);
}

/* --- repeated and crossing requests ------------------------------------------------------------------------------ */

static void same_state_again(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT(states); s++) {
        wire_t w;
        wire_open_one(&w, &testdev);
        wire_go(&w, 0, states[s]);
        testdev_t *t = testdev_of(&w, 0);
        t->from = t->to = 0;
        if (states[s] == OP)
            outputs(&w, 0xFF);
        uint16_t before = t->out_u16;
        for (int n = 0; n < 3; n++) {
            ask(&w, "again", states[s], states[s], 0);
            ask(&w, "again, acknowledged", states[s] | ACK, states[s], 0);
        }
        assert_int_equal(t->from, 0);
        assert_int_equal(t->to, 0);
        assert_int_equal(t->out_u16, before);
        assert_int_equal(t->safe_calls, 0);
        wire_close(&w);
    }
}

static void waits_for_outputs(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        const ect_device_t *device = every_device(i);
        wire_t w;
        wire_open_one(&w, device);
        wire_go(&w, 0, SAFEOP);
        request(&w, OP);
        if (ect_device_sm_bytes(device, 2) == 0) {
            expect(&w, "input-only", OP, 0);
            wire_close(&w);
            continue;
        }
        expect(&w, "no outputs yet", SAFEOP, 0);
        wire_advance(&w, device->timeouts.safeop_op_ms * MS - 1);
        expect(&w, "just before the timeout", SAFEOP, 0);
        wire_advance(&w, 1);
        expect(&w, "timeout", SAFEOP | ERR, 0x0019);
        assert_int_equal(outputs(&w, 1), 1);
        expect(&w, "outputs too late", SAFEOP | ERR, 0x0019);
        ask(&w, "acknowledge", SAFEOP | ACK, SAFEOP, 0);
        assert_int_equal(outputs(&w, 1), 1);
        ask(&w, "OP", OP, OP, 0);
        wire_close(&w);
    }
}

static void outputs_in_time(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        const ect_device_t *device = every_device(i);
        if (ect_device_sm_bytes(device, 2) == 0)
            continue;
        wire_t w;
        wire_open_one(&w, device);
        wire_go(&w, 0, SAFEOP);
        request(&w, OP);
        wire_advance(&w, device->timeouts.safeop_op_ms * MS - 1);
        assert_int_equal(outputs(&w, 1), 1);
        expect(&w, "outputs in the last moment", OP, 0);
        wire_advance(&w, 50 * MS);
        outputs(&w, 1);
        expect(&w, "stays", OP, 0);
        wire_close(&w);
    }
}

static void crossing_requests(void **state)
{
    (void)state;
    static const struct {
        uint16_t requested;
        uint8_t status;
        uint16_t code;
    } rows[] = {{SAFEOP, SAFEOP, 0},
                {PREOP, PREOP, 0},
                {INIT, INIT, 0},
                {BOOT, SAFEOP | ERR, 0x0011},
                {7, SAFEOP | ERR, 0x0012}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        wire_t w;
        wire_open_one(&w, &testdev);
        wire_go(&w, 0, SAFEOP);
        ask(&w, "OP waits", OP, SAFEOP, 0);
        ask(&w, "OP again", OP, SAFEOP, 0);
        ask(&w, "crossing", rows[i].requested, rows[i].status, rows[i].code);
        outputs(&w, 0xFF);
        expect(&w, "outputs after that change nothing", rows[i].status, rows[i].code);
        wire_advance(&w, 20000 * MS);
        expect(&w, "nor does the timeout", rows[i].status, rows[i].code);
        assert_int_equal(testdev_of(&w, 0)->out_u16, 0);
        wire_close(&w);
    }
}

static void op_again_needs_new_outputs(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, OP);
    ask(&w, "down", SAFEOP, SAFEOP, 0);
    ask(&w, "up without new outputs", OP, SAFEOP, 0);
    outputs(&w, 1);
    expect(&w, "with new outputs", OP, 0);
    wire_close(&w);
}

/* A slow slave: the master writes while the request is unread. */
static void quick_succession(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_configure_mailbox(&w, 0);
    w.manual_poll = true;
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, PREOP), 1);
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, INIT), 0);
    assert_int_equal(wire_read16(&w, 0, ECT_REG_AL_CONTROL), PREOP);
    expect(&w, "unread", INIT, 0);
    wire_poll(&w);
    expect(&w, "first request wins", PREOP, 0);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, SAFEOP), 1);
    wire_poll(&w);
    expect(&w, "SMs and request in one go", SAFEOP, 0);
    assert_int_equal(outputs(&w, 0xFF), 1);
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, OP), 1);
    wire_poll(&w);
    expect(&w, "outputs and request in one go", OP, 0);
    assert_int_equal(testdev_of(&w, 0)->out_u16, 0xFFFF);
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, INIT), 1);
    for (unsigned int n = 0; n < 4; n++)
        wire_write8(&w, 0, (uint16_t)(ECT_REG_SM + 8 * n + ECT_SM_ACTIVATE), 0);
    wire_poll(&w);
    expect(&w, "INIT and SMs off in one go is no error", INIT, 0);
    assert_int_equal(testdev_of(&w, 0)->out_u16, 0);
    wire_close(&w);
}

static void preop_and_sms_off(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, OP);
    w.manual_poll = true;
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, PREOP), 1);
    wire_write8(&w, 0, ECT_REG_SM + 16 + ECT_SM_ACTIVATE, 0);
    wire_write8(&w, 0, ECT_REG_SM + 24 + ECT_SM_ACTIVATE, 0);
    wire_poll(&w);
    expect(&w, "PREOP and SM2, SM3 off in one go is no error", PREOP, 0);
    wire_close(&w);
}

/* --- watchdog ---------------------------------------------------------------------------------------------------- */

static void watchdog_drop(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, OP);
    testdev_t *t = testdev_of(&w, 0);
    outputs(&w, 0xFF);
    wire_advance(&w, 100 * MS - 1);
    expect(&w, "before 100 ms", OP, 0);
    assert_int_equal(t->out_u16, 0xFFFF);
    wire_advance(&w, MS);
    expect(&w, "watchdog", SAFEOP | ERR, 0x001B);
    assert_int_equal(t->safe_calls, 1);
    assert_int_equal(t->out_u16, 0);
    assert_int_equal(t->out_bool, 0);
    assert_int_equal(t->from, OP);
    assert_int_equal(t->to, SAFEOP);
    t->in_u16 = 0xBEEF;
    uint8_t image[3] = {0};
    assert_int_equal(wire_read(&w, 0, 0x1300, image, 3), 1);
    assert_int_equal(wire_read(&w, 0, 0x1300, image, 3), 1);
    assert_int_equal(ect_load_le16(image), 0xBEEF);
    assert_int_equal(outputs(&w, 0xFF), 1);
    assert_int_equal(t->out_u16, 0);
    expect(&w, "outputs alone bring nothing back", SAFEOP | ERR, 0x001B);
    ask(&w, "OP without acknowledge", OP, SAFEOP | ERR, 0x001B);
    ask(&w, "acknowledge", SAFEOP | ACK, SAFEOP, 0);
    assert_int_equal(t->out_u16, 0);
    outputs(&w, 0xFF);
    ask(&w, "OP", OP, OP, 0);
    outputs(&w, 0xFF);
    assert_int_equal(t->out_u16, 0xFFFF);
    assert_int_equal(t->safe_calls, 1);
    wire_close(&w);
}

static void watchdog_direct_op(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        if (ect_device_sm_bytes(every_device(i), 2) == 0)
            continue;
        wire_t w;
        wire_open_one(&w, every_device(i));
        wire_go(&w, 0, OP);
        wire_advance(&w, 101 * MS);
        expect(&w, "watchdog", SAFEOP | ERR, 0x001B);
        ask(&w, "OP with acknowledge", OP | ACK, SAFEOP, 0);
        outputs(&w, 1);
        expect(&w, "outputs", OP, 0);
        wire_close(&w);
    }
}

static void watchdog_elsewhere(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, SAFEOP);
    outputs(&w, 1);
    wire_advance(&w, 1000 * MS);
    expect(&w, "not in SAFEOP", SAFEOP, 0);
    wire_close(&w);
    wire_open_one(&w, &testdev);
    wire_write16(&w, 0, ECT_REG_WD_TIME_PD, 0);
    wire_go(&w, 0, OP);
    wire_advance(&w, 100000 * MS);
    expect(&w, "switched off", OP, 0);
    wire_close(&w);
    wire_open_one(&w, &ect_eclink_map1);
    wire_go(&w, 0, OP);
    wire_advance(&w, 100000 * MS);
    expect(&w, "input-only", OP, 0);
    wire_close(&w);
}

/* The watchdog expired, and outputs arrived again, before the slave polled: its status is that of a running watchdog,
 * and the slave has these outputs. */
static void watchdog_and_outputs_at_once(void **state)
{
    (void)state;
    wire_t w;
    uint8_t status;
    uint16_t code;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, OP);
    outputs(&w, 0x11);
    w.manual_poll = true;
    w.now_ns += 150 * MS;
    (void)ect_esc_tick(ect_chain_esc(w.chain, 0), w.now_ns);
    outputs(&w, 0x22);
    w.manual_poll = false;
    wire_poll(&w);
    al(&w, &status, &code);
    uint16_t out = testdev_of(&w, 0)->out_u16;
    if (status != OP || code != 0 || out != 0x2222)
        fail_msg("expected OP with outputs 0x2222, got AL status 0x%02X, code 0x%04X, outputs 0x%04X", status, code,
                 out);
    wire_close(&w);
}

/* Outputs were written once, their watchdog expired in SAFEOP, and OP is requested afterwards: the outputs are not
 * renewed. */
static void op_needs_live_outputs(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, SAFEOP);
    outputs(&w, 0xFF);
    wire_advance(&w, 1000 * MS);
    request(&w, OP);
    wire_advance(&w, 1000 * MS);
    uint8_t status;
    uint16_t code;
    al(&w, &status, &code);
    if (status == OP)
        fail_msg("OP for a second without outputs, watchdog status 0x%02X, outputs 0x%04X",
                 wire_read8(&w, 0, ECT_REG_WD_STATUS_PD), testdev_of(&w, 0)->out_u16);
    wire_close(&w);
}

static void master_gone(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        if (ect_device_sm_bytes(every_device(i), 2) == 0)
            continue;
        wire_t w;
        wire_open_one(&w, every_device(i));
        wire_go(&w, 0, OP);
        wire_advance(&w, 3600ull * 1000 * MS);
        expect(&w, "an hour without a master", SAFEOP | ERR, 0x001B);
        assert_int_equal(wire_read8(&w, 0, ECT_REG_WD_COUNTER_PD), 1);
        wire_go(&w, 0, OP);
        wire_close(&w);
    }
}

static void watchdog_counter_stops(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, OP);
    for (unsigned int n = 1; n <= 300; n++) {
        wire_advance(&w, 150 * MS);
        expect(&w, "watchdog", SAFEOP | ERR, 0x001B);
        assert_int_equal(wire_read8(&w, 0, ECT_REG_WD_COUNTER_PD), n < 255 ? n : 255);
        request(&w, OP | ACK);
        outputs(&w, 1);
        expect(&w, "again", OP, 0);
    }
    wire_close(&w);
}

/* --- the device's own drops -------------------------------------------------------------------------------------- */

static void device_drops(void **state)
{
    (void)state;
    static const uint16_t codes[] = {0x0001, 0x001A, 0x0021, 0x0022, 0x0023, 0x002C, 0x002D, 0x0030, 0x8000, 0xFFFF};
    for (size_t f = 0; f < COUNT(states); f++) {
        for (size_t t = 0; t < COUNT(states); t++) {
            for (size_t c = 0; c < COUNT(codes); c++) {
                wire_t w;
                wire_open_one(&w, &testdev);
                wire_go(&w, 0, states[f]);
                if (states[f] == OP)
                    outputs(&w, 0xFF);
                (void)wire_read16(&w, 0, ECT_REG_AL_STATUS);
                drop(&w, states[t], codes[c]);
                bool falls = states[t] < states[f];
                uint16_t event = wire_read16(&w, 0, ECT_REG_ECAT_EVENT);
                expect(&w, "drop", falls ? states[t] | ERR : states[f], falls ? codes[c] : 0);
                assert_int_equal((event & ECT_ECAT_EVENT_AL_STATUS) != 0, falls);
                assert_int_equal(testdev_of(&w, 0)->safe_calls, states[f] == OP && falls ? 1 : 0);
                assert_int_equal(testdev_of(&w, 0)->out_u16, states[f] == OP && !falls ? 0xFFFF : 0);
                if (falls) {
                    ask(&w, "acknowledge", states[t] | ACK, states[t], 0);
                    wire_go(&w, 0, OP);
                }
                wire_close(&w);
            }
        }
    }
}

static void drop_ends_waiting(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, SAFEOP);
    request(&w, OP);
    drop(&w, PREOP, 0x0022);
    expect(&w, "drop while OP waits", PREOP | ERR, 0x0022);
    wire_advance(&w, 20000 * MS);
    expect(&w, "later", PREOP | ERR, 0x0022);
    wire_close(&w);
}

/* --- refused and delayed by the device --------------------------------------------------------------------------- */

static const struct {
    uint8_t from, to;
    uint16_t timeout_ms;
} ups[] = {{INIT, PREOP, 3000}, {PREOP, SAFEOP, 5000}, {SAFEOP, OP, 5000}};

static void prepare_up(wire_t *w, size_t i, uint16_t answer)
{
    wire_open_one(w, &testdev);
    wire_go(w, 0, ups[i].from);
    if (ups[i].from == INIT)
        wire_configure_mailbox(w, 0);
    if (ups[i].from == PREOP)
        wire_configure_process_data(w, 0);
    if (ups[i].from == SAFEOP)
        outputs(w, 0xFF);
    testdev_of(w, 0)->state_change_answer = answer;
}

static void device_refuses(void **state)
{
    (void)state;
    static const uint16_t codes[] = {0x0001, 0x0018, 0x0021, 0x0023, 0x8001, 0xFFFE};
    for (size_t i = 0; i < COUNT(ups); i++) {
        for (size_t c = 0; c < COUNT(codes); c++) {
            wire_t w;
            prepare_up(&w, i, codes[c]);
            ask(&w, "refused by the device", ups[i].to, ups[i].from | ERR, codes[c]);
            ask(&w, "and again", ups[i].to | ACK, ups[i].from | ERR, codes[c]);
            assert_int_equal(testdev_of(&w, 0)->out_u16, 0);
            testdev_of(&w, 0)->state_change_answer = 0;
            ask(&w, "allowed at last", ups[i].to | ACK, ups[i].to, 0);
            wire_close(&w);
        }
    }
}

static void device_delays(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(ups); i++) {
        wire_t w;
        prepare_up(&w, i, ECT_AL_PENDING);
        done(&w, 0);
        expect(&w, "finished before it began", ups[i].from, 0);
        ask(&w, "delayed", ups[i].to, ups[i].from, 0);
        wire_advance(&w, 50 * MS);
        expect(&w, "still", ups[i].from, 0);
        done(&w, 0);
        expect(&w, "finished", ups[i].to, 0);
        done(&w, 0x8001);
        expect(&w, "finished twice", ups[i].to, 0);
        wire_close(&w);
        prepare_up(&w, i, ECT_AL_PENDING);
        request(&w, ups[i].to);
        done(&w, 0x8765);
        expect(&w, "finished with a code", ups[i].from | ERR, 0x8765);
        assert_int_equal(testdev_of(&w, 0)->out_u16, 0);
        wire_close(&w);
    }
}

static void device_delays_too_long(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(ups); i++) {
        wire_t w;
        prepare_up(&w, i, ECT_AL_PENDING);
        wire_write16(&w, 0, ECT_REG_WD_TIME_PD, 0);
        request(&w, ups[i].to);
        assert_true(ect_slave_poll(slave_of(&w), w.now_ns) == w.now_ns + ups[i].timeout_ms * MS); /* not before */
        wire_advance(&w, ups[i].timeout_ms * MS - 1);
        expect(&w, "just before the timeout", ups[i].from, 0);
        wire_advance(&w, 1);
        expect(&w, "timeout", ups[i].from | ERR, 0x0001);
        done(&w, 0);
        expect(&w, "finished too late", ups[i].from | ERR, 0x0001);
        testdev_of(&w, 0)->state_change_answer = 0;
        if (ups[i].to == OP)
            outputs(&w, 0xFF);
        ask(&w, "again", ups[i].to | ACK, ups[i].to, 0);
        wire_close(&w);
    }
}

static void crossing_a_delay(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(ups); i++) {
        wire_t w;
        prepare_up(&w, i, ECT_AL_PENDING);
        request(&w, ups[i].to);
        ask(&w, "called back", ups[i].from, ups[i].from, 0);
        done(&w, 0);
        expect(&w, "finished too late", ups[i].from, 0);
        request(&w, ups[i].to);
        ask(&w, "INIT", INIT, INIT, 0);
        done(&w, 0);
        expect(&w, "finished too late", INIT, 0);
        wire_advance(&w, 20000 * MS);
        expect(&w, "no timeout either", INIT, 0);
        wire_close(&w);
    }
}

/* The device is ready before the master has sent outputs: OP still requires them. */
static void delayed_op_needs_outputs(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, SAFEOP);
    testdev_of(&w, 0)->state_change_answer = ECT_AL_PENDING;
    request(&w, OP);
    done(&w, 0);
    expect(&w, "device ready, no outputs yet", SAFEOP, 0);
    outputs(&w, 0xFF);
    expect(&w, "first outputs", OP, 0);
    wire_close(&w);
}

/* A change by the master during a delayed transition is checked before the state is confirmed. */
static void sm_changed_in_a_delay(void **state)
{
    (void)state;
    static const struct {
        size_t up;
        unsigned int sm;
        uint8_t status;
        uint16_t code;
    } rows[] = {{0, 0, INIT | ERR, 0x0016},  {0, 1, INIT | ERR, 0x0016}, {1, 2, PREOP | ERR, 0x001D},
                {1, 3, PREOP | ERR, 0x001E}, {1, 0, INIT | ERR, 0x0016}, {2, 2, PREOP | ERR, 0x001D},
                {2, 1, INIT | ERR, 0x0016}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        wire_t w;
        char where[48];
        (void)snprintf(where, sizeof where, "row %zu: SM%u off in a delay", i, rows[i].sm);
        prepare_up(&w, rows[i].up, ECT_AL_PENDING);
        request(&w, ups[rows[i].up].to);
        wire_write8(&w, 0, (uint16_t)(ECT_REG_SM + 8 * rows[i].sm + ECT_SM_ACTIVATE), 0);
        done(&w, 0);
        expect(&w, where, rows[i].status, rows[i].code);
        wire_close(&w);
    }
}

/* --- restart ----------------------------------------------------------------------------------------------------- */

/* The power cycle that the device requests; the master must configure the slave again. */
static void restart(wire_t *w)
{
    testdev_t *t = testdev_of(w, 0);
    t->host->restart(t->host->ctx);
    ect_chain_wake(w->chain, 0);
    wire_poll(w);
    wire_assign_stations(w);
}

static void restarts(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT(states); s++) {
        wire_t w;
        wire_open_one(&w, &testdev);
        wire_go(&w, 0, states[s]);
        testdev_t *t = testdev_of(&w, 0);
        if (states[s] == OP)
            outputs(&w, 0xFF);
        t->u32 = 1;
        restart(&w);
        expect(&w, "restart", INIT, 0);
        assert_int_equal(t->inits, 1);
        assert_int_equal(t->u32, 0x11223344);
        assert_int_equal(t->out_u16, 0);
        for (unsigned int n = 0; n < 4; n++)
            assert_int_equal(wire_read8(&w, 0, (uint16_t)(ECT_REG_SM + 8 * n + ECT_SM_PDI_CONTROL)) & 1, 1);
        wire_go(&w, 0, OP);
        wire_close(&w);
    }
}

static void restart_forgets(void **state)
{
    (void)state;
    wire_t w;
    open_with_alias(&w, &testdev, 0x0042);
    go_with_error(&w, PREOP, 0x8001);
    restart(&w);
    expect(&w, "restart with an error", INIT, 0);
    wire_go(&w, 0, SAFEOP);
    request(&w, OP);
    restart(&w);
    wire_advance(&w, 20000 * MS);
    expect(&w, "restart while OP waits", INIT, 0);
    wire_go(&w, 0, PREOP);
    ask(&w, "identification", PREOP | ID, PREOP | ID, 0x0042);
    restart(&w);
    expect(&w, "restart with identification shown", INIT, 0);
    wire_close(&w);
}

/* --- identification ---------------------------------------------------------------------------------------------- */

static void identification(void **state)
{
    (void)state;
    static const uint16_t ids[] = {1, 0x0010, 0x1234, 0xFFFF};
    for (size_t n = 0; n < COUNT(ids); n++) {
        for (size_t i = 0; every_device(i); i++) {
            for (size_t s = 0; s < COUNT(states); s++) {
                wire_t w;
                open_with_alias(&w, every_device(i), ids[n]);
                wire_go(&w, 0, states[s]);
                ask(&w, "identification", states[s] | ID, states[s] | ID, ids[n]);
                ask(&w, "identification again", states[s] | ID, states[s] | ID, ids[n]);
                ask(&w, "no longer", states[s], states[s], 0);
                ask(&w, "with acknowledge", states[s] | ID | ACK, states[s] | ID, ids[n]);
                ask(&w, "refused request", BOOT | ID, states[s] | ERR, states[s] == INIT ? 0x0013 : 0x0011);
                ask(&w, "not with an error", states[s] | ID, states[s] | (states[s] == INIT ? ID : ERR),
                    states[s] == INIT ? ids[n] : 0x0011);
                ask(&w, "after the acknowledge", states[s] | ID | ACK, states[s] | ID, ids[n]);
                wire_close(&w);
            }
        }
    }
}

static void identification_on_the_move(void **state)
{
    (void)state;
    wire_t w;
    open_with_alias(&w, &testdev, 7);
    wire_configure_mailbox(&w, 0);
    ask(&w, "with a transition", PREOP | ID, PREOP | ID, 7);
    ask(&w, "with a transition down", INIT | ID, INIT | ID, 7);
    ask(&w, "with a transition", PREOP, PREOP, 0);
    wire_configure_process_data(&w, 0);
    ask(&w, "with a transition", SAFEOP | ID, SAFEOP | ID, 7);
    ask(&w, "not while OP is only asked for", OP | ID, SAFEOP, 0);
    outputs(&w, 1);
    uint8_t status;
    uint16_t code;
    al(&w, &status, &code);
    if ((status & 0x1F) != OP || ((status & ID) != 0) != (code == 7))
        fail_msg("OP reached with identification: status 0x%02X code 0x%04X", status, code);
    ask(&w, "in OP", OP | ID, OP | ID, 7);
    drop(&w, SAFEOP, 0x8001);
    expect(&w, "a drop takes it away", SAFEOP | ERR, 0x8001);
    ask(&w, "back", SAFEOP | ID | ACK, SAFEOP | ID, 7);
    wire_write8(&w, 0, ECT_REG_SM + 16 + ECT_SM_ACTIVATE, 0);
    expect(&w, "so does a lost SM", PREOP | ERR, 0x001D);
    wire_close(&w);
}

static void no_identification(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT(states); s++) {
        wire_t w;
        wire_open_one(&w, &testdev);
        wire_go(&w, 0, states[s]);
        ask(&w, "no id to give", states[s] | ID, states[s], 0);
        wire_close(&w);
    }
}

/* --- SyncManagers changed in a running state --------------------------------------------------------------------- */

typedef struct sm_change {
    uint8_t in;
    unsigned int sm;
    uint8_t status;
    uint16_t code;
} sm_change_t;

static const sm_change_t sm_changes[] = {
    {INIT, 0, INIT, 0},
    {INIT, 1, INIT, 0},
    {INIT, 2, INIT, 0},
    {INIT, 3, INIT, 0},
    {PREOP, 0, INIT | ERR, 0x0016},
    {PREOP, 1, INIT | ERR, 0x0016},
    {PREOP, 2, PREOP, 0},
    {PREOP, 3, PREOP, 0},
    {SAFEOP, 0, INIT | ERR, 0x0016},
    {SAFEOP, 1, INIT | ERR, 0x0016},
    {SAFEOP, 2, PREOP | ERR, 0x001D},
    {SAFEOP, 3, PREOP | ERR, 0x001E},
    {OP, 0, INIT | ERR, 0x0016},
    {OP, 1, INIT | ERR, 0x0016},
    {OP, 2, PREOP | ERR, 0x001D},
    {OP, 3, PREOP | ERR, 0x001E},
};

/* 0: disabled; 1: another start address while the slave does not poll; 2: another direction, likewise */
static void one_sm_change(const ect_device_t *device, const sm_change_t *row, int kind)
{
    wire_t w;
    char where[64];
    (void)snprintf(where, sizeof where, "state %u, SM%u, change %d", row->in, row->sm, kind);
    wire_open_one(&w, device);
    wire_go(&w, 0, row->in);
    const ect_sm_t *sm = &device->sm[row->sm];
    w.manual_poll = true;
    if (row->in == OP && device == &testdev)
        outputs(&w, 0xFF);
    if (kind == 0)
        wire_write8(&w, 0, (uint16_t)(ECT_REG_SM + 8 * row->sm + ECT_SM_ACTIVATE), 0);
    else
        wire_set_sm(&w, 0, row->sm, (uint16_t)(sm->start + (kind == 1 ? 8 : 0)), ect_device_sm_bytes(device, row->sm),
                    sm->control ^ (kind == 2 ? 0x04 : 0));
    w.manual_poll = false;
    wire_poll(&w);
    expect(&w, where, row->status, row->code);
    if (device == &testdev && (row->status & 0x0F) != OP)
        assert_int_equal(testdev_of(&w, 0)->out_u16, 0);
    if ((row->status & ERR) != 0)
        ask(&w, "acknowledge", (row->status & 0x0F) | ACK, row->status & 0x0F, 0);
    wire_go(&w, 0, OP);
    wire_close(&w);
}

static void sm_changed(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        for (size_t n = 0; n < COUNT(sm_changes); n++) {
            if (every_device(i)->sm[sm_changes[n].sm].length == 0)
                continue;
            for (int kind = 0; kind < 3; kind++)
                one_sm_change(every_device(i), &sm_changes[n], kind);
        }
    }
}

static void rewritten_unchanged(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        wire_t w;
        wire_open_one(&w, every_device(i));
        wire_go(&w, 0, OP);
        for (unsigned int n = 0; n < 4; n++) {
            uint8_t block[8];
            uint16_t address = (uint16_t)(ECT_REG_SM + 8 * n);
            assert_int_equal(wire_read(&w, 0, address, block, 8), 1);
            assert_int_equal(wire_write(&w, 0, address, block, 8), 1);
        }
        expect(&w, "the same block written again", OP, 0);
        wire_close(&w);
    }
}

/* Another permitted length of the mailbox, chosen while it runs and before the slave polls. */
static void mailbox_resized(void **state)
{
    (void)state;
    for (size_t s = 1; s < COUNT(states); s++) {
        wire_t w;
        wire_open_one(&w, &testdev);
        wire_go(&w, 0, states[s]);
        w.manual_poll = true;
        wire_set_sm(&w, 0, 1, 0x1080, 64, 0x22);
        w.manual_poll = false;
        wire_poll(&w);
        expect(&w, "SM1 with another length", INIT | ERR, 0x0016);
        wire_close(&w);
    }
}

/* Disabled and enabled before the slave polls: the buffer is empty now. Either the slave drops, or it continues to
 * work. */
static void inputs_after_reenable(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, SAFEOP);
    w.manual_poll = true;
    wire_set_sm(&w, 0, 3, 0x1300, 3, 0x20);
    w.manual_poll = false;
    wire_poll(&w);
    uint8_t image[3];
    uint8_t status;
    uint16_t code;
    al(&w, &status, &code);
    int wkc = wire_read(&w, 0, 0x1300, image, 3);
    if (!(status == SAFEOP && wkc == 1) && !(status == (PREOP | ERR) && code == 0x001E))
        fail_msg("SM3 off and on in SAFEOP: AL status 0x%02X code 0x%04X, inputs WKC %d", status, code, wkc);
    wire_close(&w);
}

/* --- distributed clocks ------------------------------------------------------------------------------------------ */

static int dc_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    order_t *o = ctx;
    int result = o->real.read(o->real.ctx, address, buffer, length);
    if (address <= ECT_REG_DC_ACTIVATION && address + length > ECT_REG_DC_ACTIVATION)
        ((uint8_t *)buffer)[ECT_REG_DC_ACTIVATION - address] = (uint8_t)o->bad;
    return result;
}

static void dc_not_offered(void **state)
{
    (void)state;
    wire_t w;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, PREOP);
    wire_configure_process_data(&w, 0);
    order_t o = {.real = *slave_of(&w)->config.pdi, .esc = ect_chain_esc(w.chain, 0), .bad = 1};
    o.pdi = (ect_pdi_t){.ctx = &o, .read = dc_read, .write = order_write};
    slave_of(&w)->config.pdi = &o.pdi;
    ask(&w, "cyclic unit on", SAFEOP, PREOP | ERR, 0x0030);
    o.bad = 0;
    ask(&w, "cyclic unit off", SAFEOP | ACK, SAFEOP, 0);
    wire_close(&w);

    static const ect_dc_mode_t mode = {.name = "DC", .assign_activate = 0x0300};
    ect_device_t device = testdev;
    device.dc_modes = &mode;
    device.dc_mode_count = 1;
    wire_open_one(&w, &device);
    wire_go(&w, 0, PREOP);
    wire_configure_process_data(&w, 0);
    o = (order_t){.real = *slave_of(&w)->config.pdi, .esc = ect_chain_esc(w.chain, 0), .bad = 1};
    o.pdi = (ect_pdi_t){.ctx = &o, .read = dc_read, .write = order_write};
    slave_of(&w)->config.pdi = &o.pdi;
    ask(&w, "cyclic unit on, device with DC", SAFEOP, SAFEOP, 0);
    wire_close(&w);
}

/* --- a device without hooks -------------------------------------------------------------------------------------- */

static void bare_device(void **state)
{
    (void)state;
    ect_device_t device = testdev;
    device.state_change = NULL;
    device.outputs = NULL;
    device.safe_outputs = NULL;
    device.inputs = NULL;
    device.tick = NULL;
    device.init = NULL;
    wire_t w;
    wire_open_one(&w, &device);
    wire_go(&w, 0, OP);
    outputs(&w, 0xFF);
    assert_int_equal(testdev_of(&w, 0)->out_u16, 0xFFFF);
    wire_advance(&w, 200 * MS);
    expect(&w, "watchdog", SAFEOP | ERR, 0x001B);
    wire_go(&w, 0, INIT);
    wire_close(&w);
}

/* --- random walks ------------------------------------------------------------------------------------------------ */

typedef struct random {
    uint32_t x;
} random_t;

static uint32_t draw(random_t *r, uint32_t below)
{
    r->x = r->x * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)(r->x >> 8) * below) >> 24);
}

/* The model: the master's configuration, and the state of the slave that follows from it. Polled at once, watchdog
 * off. */
typedef struct model {
    uint8_t state;
    bool error;
    uint16_t code;
    bool ident;
    bool good[4];
    bool seen;         /* outputs written since SAFEOP */
    uint64_t until_ns; /* end of a delayed OP, 0: none */
} model_t;

enum { WALK_ID = 0x0A5B };

static void model_down(model_t *m, uint8_t to)
{
    m->state = to;
    m->seen = false;
    m->until_ns = 0;
}

static void model_error(model_t *m, uint16_t code)
{
    m->error = true;
    m->code = code;
    m->ident = false;
    m->until_ns = 0;
}

static void model_up(model_t *m, uint8_t to, uint64_t now_ns)
{
    if (to == PREOP && !(m->good[0] && m->good[1])) {
        model_error(m, 0x0016);
    } else if (to == SAFEOP && !m->good[2]) {
        model_error(m, 0x001D);
    } else if (to == SAFEOP && !m->good[3]) {
        model_error(m, 0x001E);
    } else if (to == OP && !m->seen) {
        m->until_ns = now_ns + 5000 * MS;
    } else {
        m->state = to;
        m->until_ns = 0;
        m->seen = to == OP;
    }
}

static void model_request(model_t *m, uint16_t requested, uint64_t now_ns)
{
    uint8_t to = requested & 0x0F;
    if (m->error && (requested & ACK) == 0 && to != INIT)
        return;
    m->error = false;
    m->code = 0;
    char want = 'u';
    for (size_t row = 0; row < COUNT(table); row++) {
        for (size_t column = 0; column < COUNT(columns); column++) {
            if (table[row].from == m->state && columns[column] == to)
                want = table[row].to[column];
        }
    }
    m->ident = false;
    if (want == '=')
        m->until_ns = 0;
    else if (want != '+')
        model_error(m, want == 'b' ? 0x0013 : want == 'x' ? 0x0011 : 0x0012);
    else if (to < m->state)
        model_down(m, to);
    else
        model_up(m, to, now_ns);
    m->ident = (requested & ID) != 0 && !m->error && m->until_ns == 0;
}

static void model_sm(model_t *m)
{
    if (m->state >= PREOP && !(m->good[0] && m->good[1])) {
        model_down(m, INIT);
        model_error(m, 0x0016);
    } else if (m->state >= SAFEOP && !(m->good[2] && m->good[3])) {
        uint16_t code = m->good[2] ? 0x001E : 0x001D;
        model_down(m, PREOP);
        model_error(m, code);
    }
}

static void model_outputs(model_t *m)
{
    m->seen = m->seen || m->state >= SAFEOP;
    if (m->until_ns != 0) {
        m->state = OP;
        m->until_ns = 0;
    }
}

static void model_time(model_t *m, uint64_t now_ns)
{
    if (m->until_ns != 0 && now_ns >= m->until_ns)
        model_error(m, 0x0019);
}

static uint16_t random_request(random_t *r)
{
    static const uint8_t likely[] = {INIT, PREOP, SAFEOP, OP, PREOP, SAFEOP, OP, SAFEOP, OP, BOOT};
    uint16_t to = draw(r, 12) == 0 ? (uint16_t)draw(r, 16) : likely[draw(r, COUNT(likely))];
    return (uint16_t)(to | (draw(r, 2) ? ACK : 0) | (draw(r, 5) == 0 ? ID : 0));
}

static void random_sm(wire_t *w, random_t *r, bool good[4])
{
    unsigned int n = draw(r, 4);
    bool make_good = draw(r, 6) != 0;
    if (make_good == good[n])
        return;
    const ect_sm_t *sm = &testdev.sm[n];
    good[n] = make_good;
    if (make_good)
        wire_set_sm(w, 0, n, sm->start, ect_device_sm_bytes(wire_device(w, 0), n), sm->control);
    else
        wire_write8(w, 0, (uint16_t)(ECT_REG_SM + 8 * n + ECT_SM_ACTIVATE), 0);
}

static void walk_step(wire_t *w, random_t *r, model_t *m, char *what, size_t size)
{
    static const uint64_t times[] = {1, MS, 10 * MS, 4999 * MS, 5000 * MS};
    uint32_t kind = draw(r, 16);
    if (kind < 7) {
        uint16_t requested = random_request(r);
        (void)snprintf(what, size, "request 0x%02X", requested);
        request(w, requested);
        model_request(m, requested, w->now_ns);
    } else if (kind < 11) {
        random_sm(w, r, m->good);
        (void)snprintf(what, size, "SMs good: %d %d %d %d", m->good[0], m->good[1], m->good[2], m->good[3]);
        model_sm(m);
    } else if (kind < 14) {
        (void)snprintf(what, size, "outputs");
        if (m->good[2])
            outputs(w, 0xFF);
        if (m->good[2])
            model_outputs(m);
    } else if (kind == 14) {
        wire_advance(w, times[draw(r, COUNT(times))]);
        (void)snprintf(what, size, "time");
        model_time(m, w->now_ns);
    } else {
        uint8_t to = states[draw(r, 3)];
        (void)snprintf(what, size, "drop to %u", to);
        drop(w, to, 0x8000 | to);
        if (to < m->state) {
            model_down(m, to);
            model_error(m, 0x8000 | to);
        }
    }
}

static void exact_walk(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 60; seed++) {
        wire_t w;
        random_t r = {seed};
        model_t m = {.state = INIT};
        open_with_alias(&w, &testdev, WALK_ID);
        wire_write16(&w, 0, ECT_REG_WD_TIME_PD, 0);
        for (unsigned int n = 0; n < 500; n++) {
            char what[48] = "";
            char where[96];
            walk_step(&w, &r, &m, what, sizeof what);
            (void)snprintf(where, sizeof where, "seed %u step %u: %s", seed, n, what);
            expect(&w, where, (uint8_t)(m.state | (m.error ? ERR : 0) | (m.ident ? ID : 0)),
                   m.ident ? WALK_ID : m.code);
            uint16_t out = testdev_of(&w, 0)->out_u16;
            if (out != 0 && m.state != OP)
                fail_msg("%s: outputs are 0x%04X in state %u", where, out, m.state);
        }
        wire_go(&w, 0, OP);
        wire_close(&w);
    }
}

/* The error codes that are permitted in each state. */
static bool legal_combination(uint8_t status, uint16_t code)
{
    uint8_t s = status & 0x0F;
    if (s != INIT && s != PREOP && s != SAFEOP && s != OP)
        return false;
    if ((status & ERR) == 0)
        return (status & ID) != 0 ? code == WALK_ID : code == 0;
    if ((status & ID) != 0)
        return false;
    switch (code) {
    case 0x0011:
    case 0x0012:
        return true;
    case 0x0013:
    case 0x0016:
        return s == INIT;
    case 0x001D:
    case 0x001E:
        return s == PREOP;
    case 0x0019:
    case 0x001B:
        return s == SAFEOP;
    default:
        return code == (0x8000 | s);
    }
}

/* The slave polls only now and then, the watchdog runs. After a poll, its status is valid. */
static void check_slow(wire_t *w, const bool good[4], const char *where)
{
    uint8_t status;
    uint16_t code;
    al(w, &status, &code);
    uint8_t s = status & 0x0F;
    if (!legal_combination(status, code))
        fail_msg("%s: AL status 0x%02X with code 0x%04X cannot be", where, status, code);
    if ((s >= PREOP && !(good[0] && good[1])) || (s >= SAFEOP && !(good[2] && good[3])))
        fail_msg("%s: AL status 0x%02X with SMs good %d %d %d %d", where, status, good[0], good[1], good[2], good[3]);
    if (s != OP && testdev_of(w, 0)->out_u16 != 0)
        fail_msg("%s: outputs not safe in AL status 0x%02X", where, status);
}

static void slow_walk(void **state)
{
    (void)state;
    static const uint64_t times[] = {1, MS, 30 * MS, 99 * MS, 100 * MS, 101 * MS, 5000 * MS};
    for (uint32_t seed = 1; seed <= 100; seed++) {
        wire_t w;
        random_t r = {seed * 7919u};
        bool good[4] = {false};
        open_with_alias(&w, &testdev, WALK_ID);
        w.manual_poll = true;
        for (unsigned int n = 0; n < 600; n++) {
            char where[48];
            (void)snprintf(where, sizeof where, "seed %u step %u", seed, n);
            uint32_t kind = draw(&r, 16);
            if (kind < 5)
                wire_write16(&w, 0, ECT_REG_AL_CONTROL, random_request(&r));
            else if (kind < 8)
                random_sm(&w, &r, good);
            else if (kind < 11 && good[2])
                outputs(&w, 0xFF);
            else if (kind == 11)
                w.now_ns += times[draw(&r, COUNT(times))];
            else if (kind == 12)
                testdev_of(&w, 0)->host->drop(slave_of(&w), states[draw(&r, 3)], 0x8000);
            else
                wire_poll(&w);
            if (kind == 12) { /* its code identifies the state, for legal_combination */
                slave_of(&w)->drop_code = 0x8000 | slave_of(&w)->drop_state;
                (void)ect_slave_poll(slave_of(&w), w.now_ns);
            }
            if (kind >= 12)
                check_slow(&w, good, where);
        }
        w.manual_poll = false;
        wire_poll(&w);
        wire_go(&w, 0, OP);
        wire_close(&w);
    }
}

#define T(title, function) {title, function, NULL, NULL, NULL}

static const struct CMUnitTest tests[] = {
    T("CF-047: after power-up the state is INIT, no code, all SyncManagers off from the PDI side", power_up),
    T("CF-033 CF-034 CF-035: every pair of states moves, stays or is refused as in the table, with the right "
      "code",
      every_pair),
    T("CF-035: an unknown state is refused with 0x0012 in every state", unknown_states),
    T("CF-033: the device is notified of every transition, from where and to where", device_is_notified_of_transitions),
    T("CF-033: the mailbox is on from PREOP, process data from SAFEOP, and off again below", sms_follow_state),
    T("CF-036: an error in SM0 or SM1 keeps INIT with 0x0016; without it PREOP is reached", mailbox_checked),
    T("CF-027 CF-036: a mailbox may have any length from its minimum to its maximum", mailbox_length_limits),
    T("CF-037: an error in a SyncManager of outputs gives 0x001D, of inputs 0x001E; without it SAFEOP is reached",
      process_sm_checked),
    T("CF-037: both wrong gives 0x001D, then 0x001E", both_wrong),
    T("CF-037: an output-only device requires SM3 off and goes to OP with outputs", output_only),
    T("CF-033: a device without process data goes to OP with its mailbox alone", mailbox_only),
    T("CF-033: a device without a mailbox does not check SM0 and SM1", no_mailbox),
    T("CF-033 CF-036: a device with BOOT enters it only with the bootstrap mailbox, else 0x0015", boot_state),
    T("CF-038: with the error flag set, requests without acknowledge are ignored, except INIT", unacknowledged),
    T("CF-039: acknowledge and request in one: the flag is cleared, the request is processed", acknowledge_and_go),
    T("CF-039 CF-042: OP with acknowledge after an error waits for new outputs", watchdog_error_then_op),
    T("CF-040: the code is in 0x0134 before the flag, and is 0 when there is no error", code_before_flag),
    T("CF-041: a request for the present state changes nothing", same_state_again),
    T("CF-033: OP waits in SAFEOP without error for first outputs, until the timeout with 0x0019", waits_for_outputs),
    T("CF-033: outputs at the end of the timeout still lead to OP", outputs_in_time),
    T("CF-041: another request while OP waits is executed and ends the waiting", crossing_requests),
    T("CF-033: after OP has ended, OP needs new outputs", op_again_needs_new_outputs),
    T("CF-041: requests in quick succession: the first counts until the slave has read it", quick_succession),
    T("CF-041: a request for PREOP, and SM2 and SM3 off before the slave polls, is no error", preop_and_sms_off),
    T("CF-042: the watchdog in OP leads to SAFEOP with 0x001B and safe outputs; inputs continue; acknowledge and OP "
      "recover",
      watchdog_drop),
    T("CF-042: after the watchdog, OP with acknowledge and outputs leads straight back", watchdog_direct_op),
    T("CF-042: the watchdog drops nothing in SAFEOP, switched off, or without outputs", watchdog_elsewhere),
    T("CF-042: OP is not kept without outputs if their watchdog has expired before, in SAFEOP", op_needs_live_outputs),
    T("CF-042: the watchdog expires and outputs return before the slave polls: OP, with these outputs",
      watchdog_and_outputs_at_once),
    T("CF-049: an hour without a master: one drop, one count, then an ordinary start", master_gone),
    T("CF-049: the watchdog counter stops at 255", watchdog_counter_stops),
    T("CF-043 CF-044: the device can drop to any lower state with its own code, and to no other", device_drops),
    T("CF-044: a drop ends the waiting for OP", drop_ends_waiting),
    T("CF-044: a transition that the device refuses leaves the lower state, with the device's code", device_refuses),
    T("CF-041: a transition that the device delays ends when the device reports so", device_delays),
    T("CF-041: a delayed transition fails after the timeout of the description", device_delays_too_long),
    T("CF-041: another request ends a delayed transition", crossing_a_delay),
    T("CF-033: OP delayed by the device still waits for outputs", delayed_op_needs_outputs),
    T("CF-022: SMs changed during a delayed transition are detected before the state is confirmed",
      sm_changed_in_a_delay),
    T("CF-047: a restart of the device leads to INIT without error, from every state", restarts),
    T("CF-047: a restart clears error, waiting and identification", restart_forgets),
    T("CF-046: bit 5 requests the id in 0x0134 in every state, and removes it, except with an error", identification),
    T("CF-046: identification together with transitions, waiting and drops", identification_on_the_move),
    T("CF-046: a device without an id does not reply to bit 5", no_identification),
    T("CF-022: an SM changed in a running state leads to INIT 0x0016 or PREOP 0x001D / 0x001E", sm_changed),
    T("CF-022: the same SM block written again changes nothing", rewritten_unchanged),
    T("CF-022: another length of a running mailbox is detected, although the length is allowed", mailbox_resized),
    T("CF-022: SM3 off and on before the slave polls: inputs are valid again, or 0x001E", inputs_after_reenable),
    T("CF-043: the cyclic unit of DC on a device without DC gives 0x0030", dc_not_offered),
    T("CF-033: a device without any hooks enters each state upwards and downwards", bare_device),
    T("CF-033..CF-046: random walks agree with the model at every step", exact_walk),
    T("CF-033..CF-046: random walks with a slow slave end in legal states, correctly reported", slow_walk),
};

int main(int argc, char **argv)
{
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("State machine", tests, NULL, NULL);
}
