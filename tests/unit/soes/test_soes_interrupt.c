/* SPDX-License-Identifier: MIT */
/*
 * SOES's API in interrupt use: ::DIG_process in the interrupt of the ESC, ecat_slv_worker in the task that it wakes, as
 * SOES's hardware files with interrupts have it. Such a file does not leave the AL event with each access, and its
 * accesses can be interrupted in their middle.
 *
 * The stack is compiled for this test with a call at the beginning and the end of each function: there, and in each
 * access, the master's frame and its interrupt may come. Outputs and inputs have a number each that all of their bytes
 * follow from, so that halves of two show.
 */
#include <string.h>

#include "seams/standard.h"
#include "soes/app.h"
#include "soes/describe.h"
#include "soes/ect_soes.h"
#include "support/wire.h"

enum { PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP, IMAGE = 3, FIRST = 3 };
enum { STATION = 0x1001 };
enum {
    IN_THE_TASK = ESCREG_ALEVENT_CONTROL | ESCREG_ALEVENT_SMCHANGE | ESCREG_ALEVENT_SM0 | ESCREG_ALEVENT_SM1,
    EXCHANGE = ESCREG_ALEVENT_SM2 | ESCREG_ALEVENT_SM3,
};
#define UNWATCHED __attribute__((no_instrument_function))

static wire_t w;
static ect_device_t description;

static struct rig {
    ect_esc_t *esc;
    bool woken;   /* the task has something to do */
    bool in_task; /* interrupts may come */
    bool in_interrupt;
    unsigned long points; /* where one could have come */
    unsigned long at;     /* where it does, 0: nowhere */
    void (*what)(void);   /* comes there */
    uint8_t sent;         /* number of the outputs that the master wrote last */
    unsigned int left, made_safe;
    unsigned int outputs_when_left;
    const char *broken; /* the first thing that was not as it should be */
} t;

UNWATCHED static void expect(bool condition, const char *what)
{
    if (!condition && !t.broken)
        t.broken = what;
}

UNWATCHED static void point(void)
{
    if (!t.in_task || t.in_interrupt)
        return;
    t.points++;
    if (t.points != t.at)
        return;
    t.in_interrupt = true;
    t.what();
    t.in_interrupt = false;
}

UNWATCHED void __cyg_profile_func_enter(void *function, void *caller);
UNWATCHED void __cyg_profile_func_exit(void *function, void *caller);

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

/* --- the hardware file -------------------------------------------------------------------------------------------- */

/* In two parts, as a copy that is interrupted. */
static int in_parts(int (*access)(void *ctx, uint16_t address, void *buffer, uint16_t length), uint16_t address,
                    void *buf, uint16_t len)
{
    uint16_t half = len / 2;
    uint8_t *bytes = buf;
    int result = half > 0 ? access(t.esc, address, bytes, half) : 0;
    point();
    return result < 0 ? result : access(t.esc, (uint16_t)(address + half), bytes + half, (uint16_t)(len - half));
}

static int write_bytes(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    return ect_esc_pdi_write(ctx, address, buffer, length);
}

void ESC_read(uint16_t address, void *buf, uint16_t len)
{
    (void)in_parts(ect_esc_pdi_read, address, buf, len);
}

void ESC_write(uint16_t address, void *buf, uint16_t len)
{
    (void)in_parts(write_bytes, address, buf, len);
}

static void set_mask(uint32_t off, uint32_t on)
{
    uint8_t mask[4];
    (void)ect_esc_pdi_read(t.esc, ECT_REG_AL_EVENT_MASK, mask, sizeof mask);
    ect_store_le32(mask, (ect_load_le32(mask) & ~off) | on);
    (void)ect_esc_pdi_write(t.esc, ECT_REG_AL_EVENT_MASK, mask, sizeof mask);
}

static void enable(uint32_t mask)
{
    set_mask(0, mask);
}

static void disable(uint32_t mask)
{
    set_mask(mask, 0);
}

void ESC_init(const esc_cfg_t *cfg)
{
    (void)cfg;
    set_mask(UINT32_MAX, IN_THE_TASK);
}

void ESC_reset(void)
{
}

static void interrupt(void)
{
    bool within = t.in_interrupt;
    t.in_interrupt = true;
    CC_ATOMIC_SET(ESCvar.ALevent, ect_esc_al_event(t.esc));
    if ((ESCvar.ALevent & EXCHANGE) != 0)
        DIG_process(DIG_PROCESS_OUTPUTS_FLAG | DIG_PROCESS_APP_HOOK_FLAG | DIG_PROCESS_INPUTS_FLAG);
    if ((ESCvar.ALevent & IN_THE_TASK) != 0) {
        disable(IN_THE_TASK);
        t.woken = true;
    }
    t.in_interrupt = within;
}

static void serve(wire_t *wire)
{
    (void)ect_esc_tick(t.esc, wire->now_ns);
    for (unsigned int turns = 0; ect_esc_line(t.esc) || t.woken; turns++) {
        expect(turns < 20, "the interrupt does not end");
        if (t.broken)
            return;
        if (ect_esc_line(t.esc))
            interrupt();
        if (!t.woken)
            continue;
        t.woken = false;
        t.in_task = true;
        ecat_slv_worker(IN_THE_TASK);
        t.in_task = false;
    }
}

/* --- the application ---------------------------------------------------------------------------------------------- */

/* Behind outputs, before inputs. */
static void hook(void)
{
    uint8_t number = (uint8_t)app.speed;
    expect(app.speed == number * 0x0101 && (app.lamps[0] | app.lamps[1] << 1) == (number & 3), "outputs by halves");
    expect(t.left == 0 || app_outputs == t.outputs_when_left, "outputs were delivered after the end of OP");
    app.buttons[0] = (uint8_t)(app.position + 1) & 1;
    app.buttons[1] = (uint8_t)(app.position + 1) >> 1 & 1;
}

static void safe(void)
{
    t.made_safe++;
}

/* --- the master --------------------------------------------------------------------------------------------------- */

/* Not by the wire's own functions: one of them may be waiting for what this interrupts. @return the working counter */
static unsigned int datagram(uint8_t command, uint16_t address, uint8_t data[IMAGE])
{
    enum { ETHERNET = 14, HEADER = 12, DATA = ETHERNET + HEADER };
    uint8_t frame[60] = {[12] = 0x88, [13] = 0xA4};
    ect_store_le16(frame + ETHERNET, 0x1000 | (IMAGE + HEADER));
    frame[16] = command;
    ect_store_le16(frame + 18, STATION);
    ect_store_le16(frame + 20, address);
    ect_store_le16(frame + 22, IMAGE);
    memcpy(frame + DATA, data, IMAGE);
    (void)ect_esc_process(t.esc, frame, sizeof frame, w.now_ns);
    memcpy(data, frame + DATA, IMAGE);
    return frame[DATA + IMAGE];
}

static void master_cycle(void)
{
    uint8_t out[IMAGE], in[IMAGE] = {0};
    t.sent++;
    out[0] = t.sent & 3;
    out[1] = out[2] = t.sent;
    (void)datagram(FPWR, SM2_sma, out);
    if (datagram(FPRD, SM3_sma, in) == 1)
        expect((in[0] & 3) == (in[1] & 3), "inputs by halves");
}

static void frame_and_interrupt(void)
{
    master_cycle();
    if (ect_esc_line(t.esc))
        interrupt();
}

static void cycle(void)
{
    master_cycle();
    serve(&w);
    expect(t.left > 0 || app.speed == t.sent * 0x0101, "outputs were lost");
}

static uint64_t now(void)
{
    return w.now_ns;
}

static void power_on(unsigned long at, void (*what)(void))
{
    static esc_cfg_t config = {.use_interrupt = 1,
                               .watchdog_cnt = INT32_MAX,
                               .application_hook = hook,
                               .safeoutput_override = safe,
                               .esc_hw_interrupt_enable = enable,
                               .esc_hw_interrupt_disable = disable};
    memset(&w, 0, sizeof w);
    memset(&app, 0, sizeof app);
    t = (struct rig){.at = at, .what = what};
    app_outputs = app_inputs = 0;
    ect_soes_describe(&description);
    description.instance_size = sizeof(ect_standard_t);
    wire_open_one(&w, &description); /* its own slave will never be polled: this is about the chip */
    t.esc = ect_chain_esc(w.chain, 0);
    w.poll = serve;
    ect_soes_clock(now);
    ecat_slv_init(&config);
    expect(t.made_safe == 1, "outputs were not made safe at the start, or twice");
    t.made_safe = 0;
    app.position = FIRST; /* the first inputs have no hook before them */
}

static void upload(void)
{
    uint8_t name[32];
    size_t size = sizeof name;
    if (!t.broken)
        expect(wire_sdo_upload(&w, 0, 0x1008, 0, false, name, &size) == 0 && size == 11, "an SDO got no reply");
}

static void to_op(void)
{
    wire_go(&w, 0, PREOP);
    upload();
    wire_configure_process_data(&w, 0);
    expect(wire_al(&w, 0, SAFEOP, NULL) == SAFEOP, "SAFEOP not reached");
    expect(app_outputs == 0, "outputs arrived in SAFEOP");
    expect(app_inputs > 0, "no inputs in SAFEOP");
    master_cycle();
    serve(&w);
    expect(wire_al(&w, 0, OP, NULL) == OP, "OP not reached");
    cycle();
}

static void life(void)
{
    to_op();
    upload();
    cycle();
    expect(wire_al(&w, 0, PREOP, NULL) == PREOP, "PREOP not reached from OP");
    expect(t.made_safe == 1, "outputs were not made safe, or twice");
    upload();
}

/* --- the tests ---------------------------------------------------------------------------------------------------- */

static void exchange(void **state)
{
    (void)state;
    power_on(0, frame_and_interrupt);
    life();
    unsigned long points = t.points;
    wire_close(&w);
    assert_null(t.broken);
    assert_true(points > 2000); /* functions, not accesses alone */
    for (unsigned long at = 1; at <= points; at++) {
        power_on(at, frame_and_interrupt);
        life();
        wire_close(&w);
        if (t.broken)
            fail_msg("interrupt at point %lu of %lu: %s", at, points, t.broken);
    }
}

/* A hardware file's reaction to the expired watchdog of the chip. */
static void leave(void)
{
    if ((CC_ATOMIC_GET(ESCvar.App.state) & APPSTATE_OUTPUT) == 0)
        return;
    t.outputs_when_left = app_outputs;
    t.left++;
    ESC_ALstatusgotoerror(ESCsafeop | ESCerror, ALERR_WATCHDOG);
    frame_and_interrupt();
}

/* From there on the interrupt comes at a point. */
static void in_op(unsigned long at)
{
    power_on(0, leave);
    to_op();
    t.points = 0;
    t.at = at;
    for (unsigned int n = 0; n < 3; n++) {
        upload();
        cycle();
    }
}

static void own_account(void **state)
{
    (void)state;
    in_op(0);
    unsigned long points = t.points;
    wire_close(&w);
    assert_null(t.broken);
    assert_true(points > 200);
    for (unsigned long at = 1; at <= points; at++) {
        in_op(at);
        expect(t.left == 1 && t.made_safe == 1, "outputs were not made safe, or twice");
        expect(wire_read8(&w, 0, ECT_REG_AL_STATUS) == (SAFEOP | ECT_AL_ERROR), "OP was not left");
        expect(wire_read16(&w, 0, ECT_REG_AL_STATUS_CODE) == ALERR_WATCHDOG, "another AL status code");
        wire_close(&w);
        if (t.broken)
            fail_msg("interrupt at point %lu of %lu: %s", at, points, t.broken);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"DIG_process interrupts the task at every place: nothing is lost, torn or late", exchange, NULL, NULL, NULL},
        {"an interrupt leaves OP, at every place of the task: safe at once, reported by the task", own_account, NULL,
         NULL, NULL},
    };
    return cmocka_run_group_tests_name("SOES's API with interrupts", tests, NULL, NULL);
}
