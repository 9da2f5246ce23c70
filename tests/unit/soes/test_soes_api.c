/* SPDX-License-Identifier: MIT */
/*
 * SOES's API over ectwin's stack: an application and a hardware file in SOES's manner (tests/soes), unchanged except
 * the configuration that a test sets, behind a software ESC. docs/SOES.md defines the names.
 */
#include <stdio.h>
#include <string.h>

#include "seams/standard.h"
#include "soes/app.h"
#include "soes/describe.h"
#include "soes/ect_soes.h"
#include "soes/esc_eep.h"
#include "soes/esc_foe.h"
#include "soes/hal.h"
#include "soes/internal.h"
#include "support/wire.h"

enum {
    INIT = ECT_STATE_INIT,
    PREOP = ECT_STATE_PREOP,
    BOOT = ECT_STATE_BOOT,
    SAFEOP = ECT_STATE_SAFEOP,
    OP = ECT_STATE_OP
};

static wire_t w;
static ect_device_t description;
static esc_cfg_t config;
static void (*turn)(void);

/* --- recorded calls ----------------------------------------------------------------------------------------- */

static char calls[2000];

__attribute__((format(printf, 1, 2))) static void note(const char *format, ...)
{
    va_list arguments;
    size_t used = strlen(calls);
    va_start(arguments, format);
    (void)vsnprintf(calls + used, sizeof calls - used, format, arguments);
    va_end(arguments);
}

static void expect_calls(const char *want)
{
    if (strcmp(calls, want) != 0)
        fail_msg("expected the calls\n  %s\ngot\n  %s", want, calls);
    calls[0] = '\0';
}

/* --- the bench ---------------------------------------------------------------------------------------------------- */

static uint64_t now(void)
{
    return w.now_ns;
}

static void poll_application(wire_t *wire)
{
    (void)ect_esc_tick(hal.esc, wire->now_ns);
    turn();
}

/* A way to the ESC that a firmware gives to the slave, in the place of ESC_read and ESC_write. */
static const ect_pdi_t *own_way; /* NULL: none */
ect_slave_config_t __real_ect_soes_slave_config(void);
ect_slave_config_t __wrap_ect_soes_slave_config(void);

ect_slave_config_t __wrap_ect_soes_slave_config(void)
{
    ect_slave_config_t made_of = __real_ect_soes_slave_config();
    made_of.pdi = own_way ? own_way : made_of.pdi;
    return made_of;
}

/* The application with its configuration, and a master that has not requested anything yet. */
static void power_on(void)
{
    memset(&w, 0, sizeof w);
    memset(&hal, 0, sizeof hal);
    app_outputs = app_inputs = 0;
    calls[0] = '\0';
    ect_soes_describe(&description);
    description.instance_size = sizeof(ect_standard_t);
    wire_open_one(&w, &description); /* its own slave will never be polled: this is about the chip */
    hal.esc = ect_chain_esc(w.chain, 0);
    w.poll = poll_application;
    turn = ecat_slv;
    ect_soes_clock(now);
    ecat_slv_init(&config);
}

static void open_in(uint8_t state)
{
    power_on();
    wire_go(&w, 0, state);
    calls[0] = '\0';
}

static int plain(void **state)
{
    (void)state;
    memset(&app, 0, sizeof app);
    config = (esc_cfg_t){.watchdog_cnt = 100000};
    own_way = NULL;
    return 0;
}

static int close_all(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

static void turns(unsigned int count)
{
    for (unsigned int n = 0; n < count; n++)
        wire_poll(&w);
}

static uint32_t download(uint16_t index, uint8_t subindex, const void *data, size_t size)
{
    return wire_sdo_download(&w, 0, index, subindex, false, data, size);
}

static uint32_t download32(uint16_t index, uint8_t subindex, uint32_t value)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    return download(index, subindex, bytes, sizeof bytes);
}

static void expect_upload(uint16_t index, uint8_t subindex, const void *want, size_t length)
{
    uint8_t got[300];
    size_t size = sizeof got;
    uint32_t abort = wire_sdo_upload(&w, 0, index, subindex, false, got, &size);
    if (abort != 0 || size != length || memcmp(got, want, length) != 0)
        fail_msg("%04Xh:%u: abort %08X, %zu bytes, or not as expected", index, subindex, abort, size);
}

static void expect_status(uint8_t status, uint16_t code)
{
    uint8_t bytes[6] = {0};
    assert_int_equal(wire_read(&w, 0, ECT_REG_AL_STATUS, bytes, 6), 1);
    if (bytes[0] != status || ect_load_le16(bytes + 4) != code)
        fail_msg("expected AL status %02Xh, code %04Xh; got %02Xh, %04Xh", status, code, bytes[0],
                 ect_load_le16(bytes + 4));
}

/* --- start -------------------------------------------------------------------------------------------------------- */

static void start(void **state)
{
    static int argument;
    (void)state;
    config.user_arg = &argument;
    power_on();
    assert_ptr_equal(hal.user_arg, &argument);
    assert_int_equal(ESCvar.DLstatus & 1, 1);
    assert_int_equal(sizeof(_ESCvar) - offsetof(_ESCvar, mbxdata) >= PREALLOC_BUFFER_SIZE, 1);
    assert_int_equal(ESCvar.mb[1].cfg_sma, MBX1_sma);
    assert_int_equal(sizeof(sm_cfg_t), 8);
    assert_int_equal(sizeof(_App), 1);
    expect_status(INIT, 0);
    assert_int_equal(ESCvar.App.state, APPSTATE_IDLE);
    assert_int_equal(app.gain, 1000);
    assert_int_equal(app.bits[0], 7);
    assert_int_equal(app.mapped_1601[0], 0x80000220);
    hal.loading = 5; /* once more, with an ESC that is not ready yet */
    ecat_slv_init(&config);
    assert_int_equal(hal.loading, 0);
}

static void other_defaults(void)
{
    app.bits[1] = (uint8_t)(app.bits[0] + 1);
}

static void defaults(void **state)
{
    (void)state;
    config.set_defaults_hook = other_defaults;
    power_on();
    assert_int_equal(app.bits[1], 8);
    wire_close(&w);
    app.gain = 5;
    config.skip_default_initialization = true;
    hal.esc = NULL;
    power_on();
    app.gain = 5;
    ecat_slv_init(&config);
    assert_int_equal(app.gain, 5);
}

/* --- process data ------------------------------------------------------------------------------------------------- */

static void process_data(void **state)
{
    uint8_t out[3] = {0x02, 0x34, 0x12};
    uint8_t in[3];
    (void)state;
    open_in(OP);
    app.buttons[1] = 1;
    assert_int_equal(wire_write(&w, 0, SM2_sma, out, sizeof out), 1);
    assert_int_equal(app.lamps[0], 0);
    assert_int_equal(app.lamps[1], 1);
    assert_int_equal(app.speed, 0x1234);
    assert_true(app_outputs > 0);
    assert_int_equal(wire_read(&w, 0, SM3_sma, in, sizeof in), 1);
    assert_int_equal(in[0], 0x02);
    assert_int_equal(ect_load_le16(in + 1) + 1, app.position);
    assert_int_equal(ESCvar.ESC_SM2_sml, 3);
    assert_int_equal(ESCvar.ESC_SM3_sml, 3);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_SM + 16 + ECT_SM_CONTROL), ESC_SM2_smc);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_SM + 24 + ECT_SM_CONTROL), ESC_SM3_smc);
    assert_int_equal(wire_read16(&w, 0, ECT_REG_SM + 16), ESC_SM2_sma);
    assert_int_equal(wire_read16(&w, 0, ECT_REG_SM + 24), ESC_SM3_sma);
    assert_int_equal(ESC_SM2_act + ESC_SM3_act, 2);
    assert_int_equal(ESC_MBXBUFFERS, MBXBUFFERS);
    assert_int_equal(ESCvar.App.state, APPSTATE_INPUT | APPSTATE_OUTPUT);
}

static void not_before_op(void **state)
{
    uint8_t out[3] = {0x01, 0x34, 0x12};
    uint8_t in[3] = {0};
    (void)state;
    open_in(SAFEOP);
    app_outputs = 0;
    assert_int_equal(wire_read(&w, 0, SM3_sma, in, sizeof in), 1); /* from the beginning */
    assert_true(app_inputs > 0);
    assert_int_equal(wire_write(&w, 0, SM2_sma, out, sizeof out), 1);
    assert_int_equal(app_outputs, 0);
    assert_int_equal(app.speed, 0);
    assert_int_equal(ESCvar.ALevent & ESCREG_ALEVENT_SM2, 0); /* fetched all the same */
    wire_go(&w, 0, PREOP);
    app_inputs = 0;
    turns(3);
    assert_int_equal(app_inputs, 0);
}

static void read_outputs(void)
{
    uint8_t image[3];
    ESC_read(SM2_sma, image, sizeof image);
    note("outputs %02X; ", image[1]);
}

static void write_inputs(void)
{
    uint8_t image[3] = {0xA5, 0, 0};
    ESC_write(SM3_sma, image, sizeof image);
}

static void overrides(void **state)
{
    uint8_t out[3] = {0x01, 0x34, 0x12};
    uint8_t in[3];
    (void)state;
    config.rxpdo_override = read_outputs;
    config.txpdo_override = write_inputs;
    open_in(OP);
    assert_int_equal(wire_write(&w, 0, SM2_sma, out, sizeof out), 1);
    expect_calls("outputs 34; ");
    assert_int_equal(wire_read(&w, 0, SM3_sma, in, sizeof in), 1);
    assert_int_equal(in[0], 0xA5);
}

/* --- the watchdog, and leaving a state on one's own account
 * ----------------------------------------------------------- */

static void safe(void)
{
    note("safe; ");
}

static void watchdog(void **state)
{
    uint8_t out[3] = {0};
    (void)state;
    config.watchdog_cnt = 20;
    config.safeoutput_override = safe;
    open_in(OP);
    for (unsigned int n = 0; n < 30; n++)
        assert_int_equal(wire_write(&w, 0, SM2_sma, out, sizeof out), 1);
    turns(18);
    expect_status(OP, 0);
    expect_calls("");
    turns(4);
    expect_status(SAFEOP | ECT_AL_ERROR, ALERR_WATCHDOG);
    expect_calls("safe; ");
    assert_int_equal(ESCvar.App.state, APPSTATE_INPUT);
    assert_int_equal(ESCvar.ALerror, ALERR_WATCHDOG);
    APP_setwatchdog(100000);
    wire_go(&w, 0, OP);
    turns(200);
    expect_status(OP, 0);
}

static uint8_t wish;
static uint16_t why;

static void leave(void)
{
    if (wish != 0)
        ESC_ALstatusgotoerror(wish, why);
    wish = 0;
}

static void own_account(void **state)
{
    static const struct {
        uint8_t from, wish, status;
        uint16_t why, code;
        const char *calls;
    } rows[] = {
        {OP, ESCsafeop | ESCerror, SAFEOP | ECT_AL_ERROR, ALERR_SYNCERROR, ALERR_SYNCERROR, "safe; "},
        {OP, ESCpreop | ESCerror, PREOP | ECT_AL_ERROR, 0x8001, 0x8001, "safe; "},
        {OP, ESCinit | ESCerror, INIT | ECT_AL_ERROR, 0, ALERR_UNSPECIFIEDERROR, "safe; "},
        {SAFEOP, ESCpreop | ESCerror, PREOP | ECT_AL_ERROR, 0x8001, 0x8001, ""},
        {OP, ESCop | ESCerror, OP, 0x8001, 0, ""},
        {SAFEOP, ESCsafeop | ESCerror, SAFEOP, 0x8001, 0, ""},
        {PREOP, ESCsafeop | ESCerror, PREOP, 0x8001, 0, ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        config.application_hook = leave;
        config.safeoutput_override = safe;
        open_in(rows[i].from);
        wish = rows[i].wish;
        why = rows[i].why;
        turns(3);
        expect_status(rows[i].status, rows[i].code);
        expect_calls(rows[i].calls);
        if (i + 1 < sizeof rows / sizeof rows[0])
            wire_close(&w);
    }
}

/* --- changes of state --------------------------------------------------------------------------------------------- */

static uint8_t refuse; /* the change that is refused, 0: none */
static uint16_t refuse_with;

static void before(uint8_t *as, uint8_t *an)
{
    note("%02X %u>", *as, *an);
}

static void after(uint8_t *as, uint8_t *an)
{
    note("%02X; ", *an);
    if (*as == refuse) {
        *an |= ESCerror;
        if (refuse_with != 0)
            ESC_ALerror(refuse_with);
    }
}

static void state_hooks(void **state)
{
    (void)state;
    config.pre_state_change_hook = before;
    config.post_state_change_hook = after;
    refuse = 0;
    power_on();
    wire_go(&w, 0, OP);
    expect_calls("21 1>02; 42 2>04; 84 4>08; ");
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_al(&w, 0, INIT, NULL), INIT);
    expect_calls("28 8>02; 12 2>01; ");
    assert_int_equal(ESCvar.ALcontrol, INIT);
    assert_int_equal(ESCvar.ALstatus, INIT);
    assert_int_equal(ESCvar.MBXrun, 0);
}

static void refused(void **state)
{
    static const struct {
        uint8_t change, from, to;
        uint16_t with, code;
    } rows[] = {
        {INIT_TO_PREOP, INIT, PREOP, ALERR_NOVALIDFIRMWARE, ALERR_NOVALIDFIRMWARE},
        {PREOP_TO_SAFEOP, PREOP, SAFEOP, 0, ALERR_UNSPECIFIEDERROR},
        {SAFEOP_TO_OP, SAFEOP, OP, ALERR_NOVALIDOUTPUTS, ALERR_NOVALIDOUTPUTS},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint16_t code = 0;
        refuse = 0;
        config.post_state_change_hook = after;
        open_in(rows[i].from);
        if (rows[i].to == PREOP)
            wire_configure_mailbox(&w, 0);
        if (rows[i].to == SAFEOP)
            wire_configure_process_data(&w, 0);
        refuse = rows[i].change;
        refuse_with = rows[i].with;
        assert_int_equal(wire_al(&w, 0, rows[i].to, &code), rows[i].from | ECT_AL_ERROR);
        assert_int_equal(code, rows[i].code);
        refuse = 0;
        assert_int_equal(wire_al(&w, 0, rows[i].to | ECT_AL_ACKNOWLEDGE, &code), rows[i].to);
        if (i + 1 < sizeof rows / sizeof rows[0])
            wire_close(&w);
    }
}

static void boot(void **state)
{
    (void)state;
    open_in(INIT);
    wire_set_sm(&w, 0, 0, MBX0_sma_b, MBX0_sml_b, MBX0_smc_b);
    wire_set_sm(&w, 0, 1, MBX1_sma_b, MBX1_sml_b, MBX1_smc_b);
    assert_int_equal(wire_al(&w, 0, BOOT, NULL), BOOT);
    assert_int_equal(ESC_MBXSIZE, MBXSIZEBOOT);
    assert_int_equal(ESC_MBX0_sma + ESC_MBX0_sml - 1, ESC_MBX0_sme);
    assert_int_equal(ESC_MBX1_sma, MBX1_sma_b);
    assert_int_equal(wire_al(&w, 0, INIT, NULL), INIT);
    wire_go(&w, 0, PREOP);
    assert_int_equal(ESC_MBXSIZE, MBXSIZE);
    assert_int_equal(ESC_MBX0_smc, MBX0_smc);
    assert_int_equal(ESC_MBX1_sml, MBX1_sml);
    assert_int_equal(ESC_MBX1_smc, MBX1_smc);
    assert_int_equal(ESC_MBX1_sme, MBX1_sme);
    assert_int_equal(ESCvar.address, WIRE_STATION);
}

static int device_id(uint16_t *id)
{
    *id = 0x0BAD;
    return 0;
}

static int no_device_id(uint16_t *id)
{
    *id = 0x0BAD;
    return -1;
}

static void identification(void **state)
{
    uint8_t alias[2] = {0x23, 0x01};
    uint16_t code = 0;
    (void)state;
    open_in(PREOP);
    assert_int_equal(wire_al(&w, 0, PREOP | ECT_AL_IDENT, &code), PREOP); /* no alias, no identification */
    ESC_write(ESCREG_CONF_STATION_ALIAS, alias, sizeof alias);
    assert_int_equal(wire_al(&w, 0, PREOP | ECT_AL_IDENT, &code), PREOP | ECT_AL_IDENT);
    assert_int_equal(code, 0x0123);
    ESCvar.get_device_id = device_id;
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_al(&w, 0, PREOP | ECT_AL_IDENT, &code), PREOP | ECT_AL_IDENT);
    assert_int_equal(code, 0x0BAD);
    ESCvar.get_device_id = no_device_id;
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_al(&w, 0, PREOP | ECT_AL_IDENT, &code), PREOP);
}

/* --- by interrupt ------------------------------------------------------------------------------------------------- */

static void enable(uint32_t mask)
{
    note("on %X; ", (unsigned int)mask);
}

static void disable(uint32_t mask)
{
    note("off %X; ", (unsigned int)mask);
}

static uint16_t dc_answer;

static uint16_t check_dc(void)
{
    note("dc; ");
    ESCvar.dcsync = 1;
    return dc_answer;
}

static void start_sync0(void)
{
    uint8_t cycle[4];
    ect_store_le32(cycle, 1000000);
    assert_int_equal(wire_write(&w, 0, ECT_REG_DC_SYNC0_CYCLE, cycle, sizeof cycle), 1);
    assert_int_equal(wire_write8(&w, 0, ECT_REG_DC_ACTIVATION, 0x03), 1);
}

static void interrupts(void **state)
{
    uint16_t code = 0;
    (void)state;
    config.use_interrupt = 1;
    config.esc_hw_interrupt_enable = enable;
    config.esc_hw_interrupt_disable = disable;
    open_in(PREOP);
    wire_configure_process_data(&w, 0);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    expect_calls("on 400; ");
    assert_int_equal(wire_al(&w, 0, OP, NULL), OP);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    expect_calls("");
    assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
    expect_calls("off C04; ");
    start_sync0();
    assert_int_equal(wire_al(&w, 0, SAFEOP, &code), PREOP | ECT_AL_ERROR);
    assert_int_equal(code, ALERR_DCINVALIDSYNCCFG);
    ESCvar.esc_check_dc_handler = check_dc;
    dc_answer = ALERR_DCSYNC0CYCLETIME;
    assert_int_equal(wire_al(&w, 0, SAFEOP | ECT_AL_ACKNOWLEDGE, &code), PREOP | ECT_AL_ERROR);
    assert_int_equal(code, ALERR_DCSYNC0CYCLETIME);
    dc_answer = 0;
    assert_int_equal(wire_al(&w, 0, SAFEOP | ECT_AL_ACKNOWLEDGE, &code), SAFEOP);
    expect_calls("dc; dc; on 404; ");
}

/* Without use_interrupt the functions of interrupts are not called, and use_interrupt needs none of them. */
static void no_interrupts(void **state)
{
    (void)state;
    for (int use = 0; use < 2; use++) {
        config.use_interrupt = use;
        config.esc_hw_interrupt_enable = use == 0 ? enable : NULL;
        config.esc_hw_interrupt_disable = use == 0 ? disable : NULL;
        power_on();
        wire_go(&w, 0, OP);
        assert_int_equal(wire_al(&w, 0, PREOP, NULL), PREOP);
        expect_calls("");
        if (use == 0)
            wire_close(&w);
    }
}

/* The state that the hook behind a change gets: with ESCerror, the one that a refusal or a fall leads to. */
static void errors_of_state_hooks(void **state)
{
    (void)state;
    refuse = 0;
    config.use_interrupt = 1;
    config.pre_state_change_hook = before;
    config.post_state_change_hook = after;
    open_in(PREOP);
    wire_configure_process_data(&w, 0);
    start_sync0();
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), PREOP | ECT_AL_ERROR);
    expect_calls("42 2>12; ");
    wire_close(&w);
    config.use_interrupt = 0;
    config.application_hook = leave;
    open_in(OP);
    wish = ESCpreop | ESCerror;
    why = ALERR_SYNCERROR;
    turns(3);
    expect_status(PREOP | ECT_AL_ERROR, ALERR_SYNCERROR);
    expect_calls("28 8>12; ");
}

static void clock_modes(void **state)
{
    (void)state;
    power_on();
    ect_soes_describe(&description);
    assert_int_equal(description.dc_mode_count, 0);
    ESCvar.esc_check_dc_handler = check_dc;
    ect_soes_describe(&description);
    assert_int_equal(description.dc_mode_count, 2);
}

static void only_poll(void)
{
    ecat_slv_poll();
}

static void parts_of_the_exchange(void **state)
{
    uint8_t out[3] = {0x01, 0x34, 0x12};
    (void)state;
    config.application_hook = leave;
    open_in(OP);
    turn = only_poll;
    app_outputs = app_inputs = 0;
    assert_int_equal(wire_write(&w, 0, SM2_sma, out, sizeof out), 1);
    assert_int_equal(app_outputs + app_inputs, 0);
    DIG_process(DIG_PROCESS_INPUTS_FLAG);
    assert_int_equal(app_inputs, 1);
    assert_int_equal(app_outputs, 0);
    DIG_process(DIG_PROCESS_OUTPUTS_FLAG);
    assert_int_equal(app_outputs, 1);
    DIG_process(DIG_PROCESS_OUTPUTS_FLAG); /* there are no new ones */
    assert_int_equal(app_outputs, 1);
    wish = ESCpreop | ESCerror;
    DIG_process(DIG_PROCESS_WD_FLAG);
    assert_int_not_equal(wish, 0);
    DIG_process(DIG_PROCESS_APP_HOOK_FLAG);
    assert_int_equal(wish, 0);
    assert_int_equal(app_inputs, 1);
}

static void no_turn(void)
{
}

static const uint32_t worker_events =
    ESCREG_ALEVENT_CONTROL | ESCREG_ALEVENT_SMCHANGE | ESCREG_ALEVENT_SM0 | ESCREG_ALEVENT_SM1 | ESCREG_ALEVENT_EEP;

static void work(void)
{
    ecat_slv_worker(worker_events);
}

static void worker(void **state)
{
    (void)state;
    power_on();
    turn = work;
    ESC_ALeventmaskwrite(ESCREG_ALEVENT_SM2);
    wire_go(&w, 0, PREOP);
    assert_int_equal(download32(0x8000, 2, 77), 0);
    assert_int_equal(app.gain, 77);
    /* It waits for requests, not for mails that were fetched; what others have let through stays. */
    assert_int_equal(ESC_ALeventmaskread(), ESCREG_ALEVENT_SM2 | (worker_events & ~(uint32_t)ESCREG_ALEVENT_SM1));
}

static void in_pieces(void)
{
    ESC_state();
    ESC_sm_act_event();
    if (ESC_mbxprocess() != 0)
        fail_msg("ESC_state leaves nothing to be done");
    ESC_coeprocess();
    ESC_foeprocess();
    ESC_xoeprocess();
    DIG_process(DIG_PROCESS_OUTPUTS_FLAG | DIG_PROCESS_INPUTS_FLAG);
}

static void pieces(void **state)
{
    (void)state;
    power_on();
    turn = in_pieces;
    wire_go(&w, 0, OP);
    assert_int_equal(download32(0x8000, 2, 78), 0);
    assert_int_equal(app.gain, 78);
}

/* --- objects ------------------------------------------------------------------------------------------------------ */

static uint32_t abort_before, abort_after;
static size_t upload_size;

static uint32_t before_download(uint16_t index, uint8_t subindex, void *data, size_t size, uint16_t flags)
{
    note("W%04X:%u %zu %02X%s>", index, subindex, size, *(uint8_t *)data,
         (flags & COMPLETE_ACCESS_FLAG) != 0 ? " CA" : "");
    return abort_before;
}

static uint32_t after_download(uint16_t index, uint8_t subindex, uint16_t flags)
{
    note("%04X:%u%s; ", index, subindex, (flags & COMPLETE_ACCESS_FLAG) != 0 ? " CA" : "");
    return abort_after;
}

static uint32_t before_upload(uint16_t index, uint8_t subindex, void *data, size_t *size, uint16_t flags)
{
    note("R%04X:%u %zu%s>", index, subindex, *size, (flags & COMPLETE_ACCESS_FLAG) != 0 ? " CA" : "");
    if (index == 0x8001) {
        memset(data, 'x', 150);
        *size = upload_size;
    }
    return abort_before;
}

static uint32_t after_upload(uint16_t index, uint8_t subindex, uint16_t flags)
{
    note("%04X:%u%s; ", index, subindex, (flags & COMPLETE_ACCESS_FLAG) != 0 ? " CA" : "");
    return 0;
}

static int with_object_hooks(void **state)
{
    (void)plain(state);
    config.pre_object_download_hook = before_download;
    config.post_object_download_hook = after_download;
    config.pre_object_upload_hook = before_upload;
    config.post_object_upload_hook = after_upload;
    abort_before = abort_after = 0;
    upload_size = 150;
    return 0;
}

static void uploads(void **state)
{
    static const uint8_t identity[] = {4, 0, 0x37, 0x13, 0, 0, 0xD2, 4, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0};
    char text[150];
    uint8_t got[32];
    size_t size = sizeof got;
    (void)state;
    open_in(PREOP);
    expect_upload(0x1008, 0, "test device", 11);
    expect_upload(0x1009, 0, "1.0", 3);
    expect_upload(0x8000, 2, "\xE8\x03\0\0", 4);
    expect_calls("R1008:0 11>1008:0; R1009:0 3>1009:0; R8000:2 4>8000:2; ");
    memset(text, 'x', sizeof text);
    expect_upload(0x8001, 0, text, sizeof text);
    expect_calls("R8001:0 200>8001:0; "); /* behind the last segment, once */
    assert_int_equal(wire_sdo_upload(&w, 0, 0x1018, 0, true, got, &size), 0);
    assert_memory_equal(got, identity, sizeof identity);
    expect_calls("R1018:0 1 CA>1018:0 CA; ");
    abort_before = ABORT_DATA_STORE_LOCAL_ERROR;
    size = sizeof got;
    assert_int_equal(wire_sdo_upload(&w, 0, 0x8000, 2, false, got, &size), ABORT_DATA_STORE_LOCAL_ERROR);
    expect_calls("R8000:2 4>");
    size = sizeof got;
    assert_int_equal(wire_sdo_upload(&w, 0, 0x8000, 3, false, got, &size), ABORT_NOSUBINDEX);
    expect_calls("");
}

static void downloads(void **state)
{
    char text[193];
    (void)state;
    open_in(PREOP);
    assert_int_equal(download32(0x8000, 2, 0x01020304), 0);
    assert_int_equal(app.gain, 0x01020304);
    expect_calls("W8000:2 4 04>8000:2; ");
    memset(text, 'y', sizeof text);
    assert_int_equal(download(0x8001, 0, text, 180), 0);
    assert_int_equal(strlen(app.label), 180);
    expect_calls("W8001:0 180 79>8001:0; ");
    assert_int_equal(wire_sdo_download(&w, 0, 0x8002, 0, true, "\2\0\x11\x22", 4), 0);
    assert_int_equal(app.bits[1], 0x22);
    expect_calls("W8002:1 1 11 CA>W8002:2 1 22 CA>8002:0 CA; ");
    abort_before = ABORT_VALUE_TOO_HIGH;
    assert_int_equal(download32(0x8000, 2, 9), ABORT_VALUE_TOO_HIGH);
    abort_before = 5; /* no abort code */
    assert_int_equal(download32(0x8000, 2, 9), ABORT_GENERALERROR);
    assert_int_equal(app.gain, 0x01020304);
    expect_calls("W8000:2 4 09>W8000:2 4 09>");
    abort_before = 0;
    abort_after = ABORT_HARDWARE_ERROR;
    assert_int_equal(download32(0x8000, 2, 9), ABORT_HARDWARE_ERROR);
    assert_int_equal(app.gain, 9);
    expect_calls("W8000:2 4 09>8000:2; ");
    /* As long as PREALLOC_FACTOR mailboxes, a value in pieces may be. */
    assert_int_equal(download(0x8001, 0, text, sizeof text), ABORT_OUT_OF_MEMORY);
    assert_int_equal(download32(0x1000, 0, 0), ABORT_READONLY);
}

/* The stack calls the hooks by these; so may a protocol of the application. */
static void hooks_by_name(void **state)
{
    uint8_t data[4] = {0x42};
    size_t size = 4;
    (void)state;
    open_in(PREOP);
    abort_after = ABORT_GENERALERROR;
    assert_int_equal(ESC_download_pre_objecthandler(0x8000, 2, data, 4, 0), 0);
    assert_int_equal(ESC_download_post_objecthandler(0x8000, 2, 0), ABORT_GENERALERROR);
    assert_int_equal(ESC_upload_pre_objecthandler(0x8000, 2, data, &size, 0), 0);
    assert_int_equal(ESC_upload_post_objecthandler(0x8000, 2, 0), 0);
    expect_calls("W8000:2 4 42>8000:2; R8000:2 4>8000:2; ");
    assert_int_equal(ESC_download_pre_objecthandler(0x1601, 1, data, 4, 0), ABORT_SUBINDEX0_NOT_ZERO);
    assert_int_equal(ESC_download_pre_objecthandler(0x1601, 1, data, 4, COMPLETE_ACCESS_FLAG), 0);
}

#ifndef APP_RAW
/* --- dynamic process data
 * --------------------------------------------------------------------------------------------- */

static uint32_t download8(uint16_t index, uint8_t subindex, uint8_t value)
{
    return download(index, subindex, &value, 1);
}

static uint32_t download16(uint16_t index, uint8_t subindex, uint16_t value)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, value);
    return download(index, subindex, bytes, sizeof bytes);
}

static void assign(uint16_t pdo, uint8_t count)
{
    assert_int_equal(download8(0x1C12, 0, 0), 0);
    assert_int_equal(download16(0x1C12, 1, pdo), 0);
    assert_int_equal(download8(0x1C12, 0, count), 0);
}

static void map(uint32_t first, uint32_t second, uint8_t count)
{
    assert_int_equal(download8(0x1601, 0, 0), 0);
    assert_int_equal(download32(0x1601, 1, first), 0);
    assert_int_equal(download32(0x1601, 2, second), 0);
    assert_int_equal(download8(0x1601, 0, count), 0);
}

static void remapped(void **state)
{
    uint8_t out[6] = {0x78, 0x56, 0x34, 0x12, 0xFE, 0xFF};
    (void)state;
    open_in(PREOP);
    assert_int_equal(download16(0x1C12, 1, 0x1601), ABORT_SUBINDEX0_NOT_ZERO);
    assert_int_equal(download32(0x1601, 1, 0x70010010), ABORT_SUBINDEX0_NOT_ZERO);
    map(0x80000220, 0x80000510, 2);
    assign(0x1601, 1);
    wire_set_sm(&w, 0, 2, SM2_sma, 6, SM2_smc);
    wire_set_sm(&w, 0, 3, SM3_sma, 3, SM3_smc);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    assert_int_equal(ESCvar.ESC_SM2_sml, 6);
    assert_int_equal(ESCvar.sm2mappings, 2);
    assert_ptr_equal(SMmap2[1].obj->data, &app.offset);
    assert_int_equal(SMmap2[1].objectlistitem->index, 0x8000);
    assert_int_equal(SMmap2[1].offset, 32);
    assert_ptr_equal(SMmap3[3].obj->data, &app.position);
    assert_int_equal(wire_al(&w, 0, OP, NULL), OP);
    assert_int_equal(wire_write(&w, 0, SM2_sma, out, sizeof out), 1);
    assert_int_equal(app.gain, 0x12345678);
    assert_int_equal(app.offset, -2);
}

/* Without outputs no watchdog can expire, and no outputs are fetched. */
static void without_outputs(void **state)
{
    (void)state;
    config.watchdog_cnt = 5;
    open_in(PREOP);
    assert_int_equal(download8(0x1C12, 0, 0), 0);
    wire_set_sm(&w, 0, 2, SM2_sma, 0, 0);
    wire_set_sm(&w, 0, 3, SM3_sma, 3, SM3_smc);
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    assert_int_equal(ESCvar.ESC_SM2_sml, 0);
    assert_int_equal(wire_al(&w, 0, OP, NULL), OP);
    turns(30);
    expect_status(OP, 0);
    assert_int_equal(app_outputs, 0);
}

static void mapped_wrongly(void **state)
{
    static const struct {
        const char *what;
        uint32_t first, second;
        uint8_t pdos;
        uint16_t bytes, code;
    } rows[] = {
        {"a missing object", 0x90000020, 0, 1, 4, ALERR_INVALIDOUTPUTMAPPING},
        {"a missing entry", 0x80000320, 0, 1, 4, ALERR_INVALIDOUTPUTMAPPING},
        {"fewer bits than the entry has", 0x80000208, 0, 1, 1, ALERR_INVALIDOUTPUTMAPPING},
        {"more entries than MAX_MAPPINGS_SM2", 0x70010010, 0x70010010, 2, 7, ALERR_INVALIDOUTPUTMAPPING},
        {"more bytes than MAX_RXPDO_SIZE", 0x80000220, 0x80000220, 1, 8, ALERR_INVALIDOUTPUTMAPPING},
        {"other bytes than the SyncManager", 0x80000220, 0x80000510, 1, 5, ALERR_INVALIDOUTPUTSM},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint16_t code = 0;
        open_in(PREOP);
        map(rows[i].first, rows[i].second, rows[i].second != 0 ? 2 : 1);
        assert_int_equal(download8(0x1C12, 0, 0), 0);
        assert_int_equal(download16(0x1C12, 1, 0x1601), 0);
        assert_int_equal(download16(0x1C12, 2, 0x1600), 0);
        assert_int_equal(download8(0x1C12, 0, rows[i].pdos), 0);
        wire_set_sm(&w, 0, 2, SM2_sma, rows[i].bytes, SM2_smc);
        wire_set_sm(&w, 0, 3, SM3_sma, 3, SM3_smc);
        if (wire_al(&w, 0, SAFEOP, &code) != (PREOP | ECT_AL_ERROR) || code != rows[i].code)
            fail_msg("%s: AL status code %04Xh, expected %04Xh", rows[i].what, code, rows[i].code);
        if (i + 1 < sizeof rows / sizeof rows[0])
            wire_close(&w);
    }
}

#endif

static void dictionary(void **state)
{
    uint8_t image[4] = {0};
    _SMmap sm[4];
    int count = 0;
    (void)state;
    open_in(PREOP);
    config.get_device_id = device_id;
    ESC_config(&config);
    assert_ptr_equal(ESCvar.get_device_id, device_id);
    assert_int_equal(SDO_findobject(0x1000), 0);
    assert_int_equal(SDO_findobject(0x8002), 16);
    assert_int_equal(SDO_findobject(0x1001), -1);
    assert_int_equal(SDO_findobject(0xFFFF), -1);
    assert_int_equal(SDO_findsubindex(SDO_findobject(0x8000), 5), 2);
    assert_int_equal(SDO_findsubindex(SDO_findobject(0x8000), 3), -1);
    assert_int_equal(COE_maxSub(0x1600), 4);
    assert_int_equal(COE_maxSub(0x1601), 1);
    assert_int_equal(COE_maxSub(0x1111), 0);
    assert_int_equal(sizeOfPDO(TX_PDO_OBJIDX, &count, sm, 4), 3);
    assert_int_equal(count, 4);
    assert_null(sm[2].obj);
    assert_null(sm[2].objectlistitem);
    assert_ptr_equal(sm[1].objectlistitem, &SDOobjects[SDO_findobject(0x6000)]);
    assert_ptr_equal(sm[3].objectlistitem, &SDOobjects[SDO_findobject(0x6001)]); /* of a variable */
    assert_int_equal(sizeOfPDO(RX_PDO_OBJIDX, &count, NULL, 0), 3);
    assert_int_equal(count, 0);
    assert_int_equal(sizeOfPDO(TX_PDO_OBJIDX, &count, sm, 3), 0);
    assert_int_equal(count, -1);
    assert_int_equal(sizeOfPDO(0x1C10, &count, sm, 4), 0);
    assert_int_equal(sizeOfPDO(TX_PDO_OBJIDX, &count, sm, 4), 3);
    app.buttons[0] = 1;
    app.position = 0x1234;
    COE_pdoPack(image, count, sm);
    assert_memory_equal(image, "\x01\x34\x12\0", 4);
    image[0] = 0x02;
    COE_pdoUnpack(image, count, sm);
    assert_int_equal(app.buttons[0], 0);
    assert_int_equal(app.buttons[1], 1);
    app.gain = 1;
    COE_initDefaultValues();
    assert_int_equal(app.gain, 1000);
}

/* The mailbox of PREOP and above is the active one, until a transition to BOOT. */
static void configured_mailboxes(void **state)
{
    static const sm_cfg_t want[] = {{MBX0_sma, MBX0_sml, MBX0_sme, MBX0_smc, 0},
                                    {MBX1_sma, MBX1_sml, MBX1_sme, MBX1_smc, 0},
                                    {MBX0_sma_b, MBX0_sml_b, MBX0_sme_b, MBX0_smc_b, 0},
                                    {MBX1_sma_b, MBX1_sml_b, MBX1_sme_b, MBX1_smc_b, 0}};
    const sm_cfg_t *const got[] = {&ESCvar.mb[0], &ESCvar.mb[1], &ESCvar.mbboot[0], &ESCvar.mbboot[1]};
    (void)state;
    open_in(INIT);
    ESC_config(&config);
    for (size_t i = 0; i < sizeof want / sizeof want[0]; i++) {
        if (got[i]->cfg_sma != want[i].cfg_sma || got[i]->cfg_sml != want[i].cfg_sml ||
            got[i]->cfg_sme != want[i].cfg_sme || got[i]->cfg_smc != want[i].cfg_smc)
            fail_msg("mailbox %zu: expected %04Xh..%04Xh, got %04Xh..%04Xh", i, want[i].cfg_sma, want[i].cfg_sme,
                     got[i]->cfg_sma, got[i]->cfg_sme);
    }
    assert_ptr_equal(ESCvar.activemb0, &ESCvar.mb[0]);
    assert_ptr_equal(ESCvar.activemb1, &ESCvar.mb[1]);
    assert_int_equal(ESC_MBXSIZE, MBXSIZE);
}

/* A mapped entry has at most 255 bits. An application may fill in a mapping of a longer one: 32 bytes of it move. */
static void longest_mapped_entries(void **state)
{
    enum { SIZE = 40, MOVED = 32 };
    static const struct {
        uint16_t bits;
        uint8_t last; /* byte 31 of 0xFF in the image */
    } rows[] = {{255, 0x7F}, {256, 0xFF}, {300, 0xFF}};
    (void)state;
    open_in(INIT);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[SIZE], image[SIZE] = {0};
        const _objd entry = {0, DTYPE_OCTET_STRING, rows[i].bits, ATYPE_RO | ATYPE_TXPDO, "long", 0, data};
        _SMmap mapping = {.obj = &entry};
        memset(data, 0xFF, sizeof data);
        COE_pdoPack(image, 1, &mapping);
        assert_int_equal(image[MOVED - 2], 0xFF);
        assert_int_equal(image[MOVED - 1], rows[i].last);
        for (unsigned int n = MOVED; n < SIZE; n++)
            assert_int_equal(image[n], 0);
    }
}

static void results_of_the_seam(void **state)
{
    const ect_pdi_t *pdi = &ect_soes.pdi;
    uint8_t bytes[2] = {0};
    uint32_t event = 1;
    (void)state;
    open_in(INIT);
    assert_int_equal(pdi->read(pdi->ctx, ECT_REG_TYPE, bytes, sizeof bytes), 0);
    assert_int_equal(bytes[0], hal.esc->memory[ECT_REG_TYPE]);
    assert_int_equal(pdi->write(pdi->ctx, 0x0F80, bytes, sizeof bytes), 0);
    assert_int_equal(pdi->al_event(pdi->ctx, &event), 0);
    assert_int_equal(event, ESCvar.ALevent);
}

/* --- a way of the firmware's own ---------------------------------------------------------------------------------- */

static unsigned int own_reads, failing_read; /* from 1; 0: none fails */

static int own_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    (void)ctx;
    const int result = ect_esc_pdi_read(hal.esc, address, buffer, length);
    return ++own_reads == failing_read ? -1 : result; /* with data that must not count */
}

static int own_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    (void)ctx;
    return ect_esc_pdi_write(hal.esc, address, buffer, length);
}

/* Whichever read of the start fails, the start repeats its step until the ESC answers. */
static void failing_start(void **state)
{
    static const ect_pdi_t way = {.read = own_read, .write = own_write};
    (void)state;
    own_way = &way;
    unsigned int reads = 2;
    for (unsigned int k = 0; k <= reads; k++) {
        own_reads = 0;
        failing_read = k;
        power_on();
        if (k == 0)
            reads = own_reads;
        else if (own_reads <= reads)
            fail_msg("read %u of the start fails: expected more than %u, got %u", k, reads, own_reads);
        assert_null(ect_soes.pdi.al_event);
        assert_int_equal(ESCvar.DLstatus & 1, 1);
        wire_go(&w, 0, PREOP);
        if (k < reads)
            wire_close(&w);
    }
}

/* --- registers ---------------------------------------------------------------------------------------------------- */

static void registers(void **state)
{
    (void)state;
    open_in(SAFEOP);
    turn = no_turn;
    ESC_ALeventmaskwrite(0x0F01);
    assert_int_equal(ESC_ALeventmaskread(), 0x0F01);
    assert_int_equal(wire_write8(&w, 0, SM2_sma, 0) + wire_write8(&w, 0, SM2_sma + 2, 0), 2);
    assert_int_equal(ESC_ALeventread() & ESCREG_ALEVENT_SM2, ESCREG_ALEVENT_SM2);
    ESC_ALeventwrite(0); /* which the chip does not take */
    assert_int_equal(ESC_ALeventread() & ESCREG_ALEVENT_SM2, ESCREG_ALEVENT_SM2);
    ESC_SMstatus(2);
    assert_int_equal(ESCvar.SM[2].IntW, 1);
    assert_int_equal(((uint8_t *)&ESCvar.SM[2])[offsetof(_ESCsm2, Status)] & ECT_SM_STATUS_WRITTEN,
                     ECT_SM_STATUS_WRITTEN);
    assert_int_equal(sizeof(_ESCsm), sizeof(_ESCsm2));
    assert_int_equal(sizeof(_ESCsmCompact), 5);
    assert_int_equal(ESC_WDstatus() & 1, 1);
    ESC_ALerror(ALERR_PLLERROR);
    ESC_ALstatus(SAFEOP | ESCerror);
    expect_status(SAFEOP | ECT_AL_ERROR, ALERR_PLLERROR);
    assert_int_equal(ESCvar.ALstatus, SAFEOP | ESCerror);
    ESC_reset();
    assert_int_equal(hal.resets, 1);
    APP_safeoutput(); /* without an override there is nothing to do */
}

static void read_sm(void)
{
    ESC_SMstatus(3);
}

static void write_events(void)
{
    ESC_ALeventwrite(0);
}

static void read_events(void)
{
    (void)ESC_ALeventread();
}

static void read_mask(void)
{
    (void)ESC_ALeventmaskread();
}

static void write_mask(void)
{
    ESC_ALeventmaskwrite(0);
}

static void read_watchdog(void)
{
    (void)ESC_WDstatus();
}

static void write_error(void)
{
    ESC_ALerror(0);
}

static void write_status(void)
{
    ESC_ALstatus(SAFEOP);
}

static void accesses(void **state)
{
    static const struct {
        void (*call)(void);
        uint16_t address, length;
        bool written;
    } rows[] = {
        {read_events, 0x0220, 4, false}, {write_events, 0x0220, 4, true}, {read_mask, 0x0204, 4, false},
        {write_mask, 0x0204, 4, true},   {read_sm, 0x081D, 1, false},     {read_watchdog, 0x0440, 2, false},
        {write_error, 0x0134, 2, true},  {write_status, 0x0130, 2, true},
    };
    (void)state;
    open_in(SAFEOP);
    turn = no_turn;
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        hal.length = 0;
        rows[n].call();
        assert_int_equal(hal.address, rows[n].address);
        assert_int_equal(hal.length, rows[n].length);
        assert_int_equal(hal.written, rows[n].written);
    }
}

/* Elements of a mapping or an assignment are fixed while its sub-index 0 counts them. */
static void fixed_elements(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint16_t flags;
        bool fixed;
    } rows[] = {
        {0x1600, 1, 0, true},  {0x1600, 0, 0, false}, {0x1600, 1, COMPLETE_ACCESS_FLAG, false},
        {0x1601, 1, 0, true},  {0x15FF, 1, 0, false}, {0x1A00, 1, 0, true},
        {0x1A00, 0, 0, false}, {0x1C12, 1, 0, true},  {0x1C13, 1, 0, true},
        {0x1C00, 1, 0, false}, {0x1018, 1, 0, false}, {0x8000, 1, 0, false},
    };
    uint8_t data[4] = {0};
    (void)state;
    open_in(PREOP);
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const uint32_t abort = ESC_download_pre_objecthandler(rows[n].index, rows[n].subindex, data, 4, rows[n].flags);
        if (abort != (rows[n].fixed ? ABORT_SUBINDEX0_NOT_ZERO : 0))
            fail_msg("%04Xh:%u: got the abort code %08X", rows[n].index, rows[n].subindex, abort);
    }
}

/* The indices of mappings and assignments, and their neighbours, which all count one element here. */
static void fixed_indices(void **state)
{
    static const struct {
        uint16_t index;
        bool fixed;
    } rows[] = {{0x15FF, false}, {0x1600, true},  {0x17FF, true},  {0x1800, false}, {0x19FF, false}, {0x1A00, true},
                {0x1BFF, true},  {0x1C00, false}, {0x1C11, false}, {0x1C12, true},  {0x1C13, true},  {0x1C14, false}};
    enum { ROWS = sizeof rows / sizeof rows[0] };
    static const ect_entry_t one = {
        .data_type = ECT_TYPE_UNSIGNED8, .bit_length = 8, .access = ECT_ACCESS_RO, .value = 1};
    ect_object_t objects[ROWS];
    uint8_t data[4] = {0};
    (void)state;
    open_in(PREOP);
    for (size_t n = 0; n < ROWS; n++)
        objects[n] = (ect_object_t){.index = rows[n].index, .object_code = ECT_OBJECT_ARRAY, .entries = &one};
    const ect_od_t before = ect_soes.slave.od;
    ect_soes.slave.od = (ect_od_t){.objects = objects, .count = ROWS};
    for (size_t n = 0; n < ROWS; n++) {
        assert_int_equal(COE_maxSub(rows[n].index), 1);
        const uint32_t abort = ESC_download_pre_objecthandler(rows[n].index, 1, data, 4, 0);
        if (abort != (rows[n].fixed ? ABORT_SUBINDEX0_NOT_ZERO : 0))
            fail_msg("%04Xh: got the abort code %08X", rows[n].index, abort);
    }
    ect_soes.slave.od = before;
}

/* --- the description ---------------------------------------------------------------------------------------------- */

static void described(void **state)
{
    static const uint8_t esc_config[14] = {0x05, 0x0E, 0x03, 0x6E};
    static const uint8_t roles[] = {ECT_SM_MAILBOX_OUT, ECT_SM_MAILBOX_IN, ECT_SM_OUTPUTS, ECT_SM_INPUTS};
    static const uint16_t starts[] = {MBX0_sma, MBX1_sma, SM2_sma, SM3_sma};
    static const uint8_t controls[] = {MBX0_smc, MBX1_smc, SM2_smc, SM3_smc};
    static const uint8_t fmmus[] = {ECT_FMMU_OUTPUTS, ECT_FMMU_INPUTS, ECT_FMMU_MAILBOX_STATE};
    (void)state;
    power_on();
    const ect_device_t *d = &description;
    ect_soes_describe(&description);
    assert_memory_equal(d->esc_config, esc_config, sizeof esc_config);
    assert_int_equal(d->sii_size, 4096);
    assert_int_equal(d->sm_count, 4);
    for (size_t n = 0; n < 4; n++) {
        assert_int_equal(d->sm[n].type, roles[n]);
        assert_int_equal(d->sm[n].start, starts[n]);
        assert_int_equal(d->sm[n].control, controls[n]);
    }
    assert_int_equal(d->sm[0].length, MBX0_sml);
    assert_int_equal(d->sm[1].length, MBX1_sml);
    assert_int_equal(d->fmmu_count, 3);
    for (size_t n = 0; n < 3; n++)
        assert_int_equal(d->fmmu[n], fmmus[n]);
    assert_true(d->boot_out.start == MBX0_sma_b && d->boot_out.length == MBX0_sml_b);
    assert_true(d->boot_in.start == MBX1_sma_b && d->boot_in.length == MBX1_sml_b);
    assert_int_equal(d->mailbox_protocols, ECT_MAILBOX_COE | ECT_MAILBOX_FOE);
    assert_int_equal(d->coe_details, ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_COMPLETE_ACCESS);
    assert_string_equal(d->physics, "YY");
    assert_string_equal(d->type_name, "test device");
    assert_true(d->identity.vendor_id == 0x1337 && d->identity.product_code == 1234 && d->identity.revision == 2);
    assert_int_equal(d->objects[d->object_count - 1].index, 0x8002);
    assert_int_equal(d->device_type, ect_od_element(&d->objects[0], 0));
    assert_int_equal(d->objects[0].index, 0x1000);
}

/* --- events that stay --------------------------------------------------------------------------------------------- */

static unsigned int steps;

static void count_step(void)
{
    steps++;
}

static void staying_event(void **state)
{
    (void)state;
    config.esc_hw_eep_handler = count_step;
    open_in(PREOP);
    turn = no_turn;
    steps = 0;
    ecat_slv_worker(worker_events);
    assert_int_equal(steps, 1);
    hal.emulated = true; /* an EEPROM command that the application does not execute */
    steps = 0;
    ecat_slv_worker(worker_events);
    assert_int_equal(steps, 16);
    steps = 0;
    ecat_slv_worker(worker_events & ~(uint32_t)ESCREG_ALEVENT_EEP);
    assert_int_equal(steps, 1);
}

/* --- a transfer that a state ends --------------------------------------------------------------------------------- */

static void reset_transfer(void **state)
{
    uint8_t begin[10] = {0, 0x20, 0x40, 0x01, 0x80, 0}, segment[10] = {0, 0x20, 0x60}, reply[200];
    (void)state;
    open_in(PREOP);
    assert_true(wire_coe(&w, 0, begin, sizeof begin, reply, sizeof reply) > 0);
    assert_int_equal(reply[2], 0x41); /* with its length, the rest in segments */
    wire_go(&w, 0, INIT);
    wire_go(&w, 0, PREOP);
    assert_true(wire_coe(&w, 0, segment, sizeof segment, reply, sizeof reply) > 0);
    assert_int_equal(reply[2], 0x80); /* there is none to continue */
}

/* Without a clock the time is that of the ESC, and a jump of the ESC's time has no effect. */
static void time_of_the_esc(void **state)
{
    uint8_t offset[8] = {0, 0, 0, 0x80, 0, 0, 0, 0};
    (void)state;
    power_on();
    ect_soes_clock(NULL);
    ecat_slv_poll();
    uint32_t before_ns = ESCvar.Time;
    w.now_ns += 5 * MS;
    (void)ect_esc_tick(hal.esc, w.now_ns);
    ecat_slv_poll();
    assert_int_equal(ESCvar.Time - before_ns, 5 * MS);
    assert_int_equal(wire_write(&w, 0, ECT_REG_DC_OFFSET, offset, sizeof offset), 1);
    wire_go(&w, 0, OP);
    expect_status(OP, 0);
}

/* --- files -------------------------------------------------------------------------------------------------------- */

static uint8_t stored[64];
static uint32_t store_answer;

static uint32_t store_file(foe_file_cfg_t *self, uint8_t *data, size_t length)
{
    note("%s %u+%zu of %u; ", self->name, (unsigned int)self->address_offset, length, (unsigned int)self->total_size);
    memcpy(stored + self->address_offset, data, length);
    return store_answer;
}

static uint8_t file_buffer[16];
static foe_file_cfg_t file_list[] = {
    {.name = "firmware", .max_data = 60, .filepass = 0x1234, .write_only_in_boot = 1, .write_function = store_file},
    {.name = "notes", .max_data = 60, .write_function = store_file},
};
static foe_cfg_t file_config = {
    .fbuffer = file_buffer, .buffer_size = sizeof file_buffer, .n_files = 2, .files = file_list};

static int with_files(void **state)
{
    (void)plain(state);
    store_answer = 0;
    memset(stored, 0, sizeof stored);
    FOE_config(&file_config);
    return 0;
}

/* A mail of FoE to the slave, and its reply. @return its operation; *answer: packet or error */
static uint8_t foe(uint8_t operation, uint32_t number, const void *data, uint16_t length, uint32_t *answer)
{
    uint8_t mail[128] = {0};
    w.mail_counter = (uint8_t)(w.mail_counter % 7 + 1);
    ect_store_le16(mail, (uint16_t)(6 + length));
    mail[5] = (uint8_t)(MBXFOE | w.mail_counter << 4);
    mail[6] = operation;
    ect_store_le32(mail + 8, number);
    memcpy(mail + 12, data, length);
    assert_int_equal(wire_mail_send(&w, 0, mail, (uint16_t)(12 + length)), 1);
    assert_true(wire_mail_receive(&w, 0, mail, sizeof mail) >= 6);
    *answer = ect_load_le32(mail + 8);
    return mail[6];
}

enum { PACKET = MBXSIZE - 12 };

static void file_written(void **state)
{
    uint8_t data[PACKET];
    uint32_t answer = 0;
    (void)state;
    open_in(PREOP);
    for (unsigned int n = 0; n < sizeof data; n++)
        data[n] = (uint8_t)(n + 1);
    assert_int_equal(foe(FOE_OP_WRQ, 0, "notes", 5, &answer), FOE_OP_ACK);
    assert_int_equal(foe(FOE_OP_DATA, 1, data, PACKET, &answer), FOE_OP_ACK);
    expect_calls("notes 0+16 of 0; notes 16+16 of 0; notes 32+16 of 0; ");
    assert_int_equal(foe(FOE_OP_DATA, 2, "xyz", 3, &answer), FOE_OP_ACK);
    expect_calls("notes 48+7 of 55; ");
    assert_memory_equal(stored, data, PACKET);
    assert_memory_equal(stored + PACKET, "xyz", 3);
    FOE_init();
    ESC_foeprocess();
}

static void file_refused(void **state)
{
    static const struct {
        const char *name;
        uint32_t password;
        uint8_t operation;
        uint32_t error;
    } rows[] = {
        {"firmware", 0x1234, FOE_OP_WRQ, FOE_ERR_NOTINBOOTSTRAP},
        {"firmware", 0, FOE_OP_WRQ, FOE_ERR_NORIGHTS},
        {"firmwar", 0x1234, FOE_OP_WRQ, FOE_ERR_NOTFOUND},
        {"notes", 0, FOE_OP_RRQ, FOE_ERR_ACCESS},
        {"nothing", 0, FOE_OP_WRQ, FOE_ERR_NOTFOUND},
    };
    uint8_t data[PACKET] = {0};
    uint32_t answer = 0;
    (void)state;
    open_in(PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t got = foe(rows[i].operation, rows[i].password, rows[i].name, (uint16_t)strlen(rows[i].name), &answer);
        if (got != FOE_OP_ERR || answer != rows[i].error)
            fail_msg("%s: expected error %04Xh, got operation %u, %04Xh", rows[i].name, rows[i].error, got, answer);
    }
    assert_int_equal(foe(FOE_OP_WRQ, 0, "notes", 5, &answer), FOE_OP_ACK);
    assert_int_equal(foe(FOE_OP_DATA, 1, data, PACKET, &answer), FOE_OP_ACK);
    assert_int_equal(foe(FOE_OP_DATA, 2, data, PACKET, &answer), FOE_OP_ERR); /* longer than max_data */
    assert_int_equal(answer, FOE_ERR_DISKFULL);
    store_answer = 5; /* no error of FoE */
    assert_int_equal(foe(FOE_OP_WRQ, 0, "notes", 5, &answer), FOE_OP_ACK);
    assert_int_equal(foe(FOE_OP_DATA, 1, data, 3, &answer), FOE_OP_ERR);
    assert_int_equal(answer, FOE_ERR_PROGERROR);
    store_answer = FOE_ERR_CHECKSUM;
    assert_int_equal(foe(FOE_OP_WRQ, 0, "notes", 5, &answer), FOE_OP_ACK);
    assert_int_equal(foe(FOE_OP_DATA, 1, data, 3, &answer), FOE_OP_ERR);
    assert_int_equal(answer, FOE_ERR_CHECKSUM);
}

/* USE_FOE is 1 unless an application defines another value, and its EEPROM names FoE. */
static void no_files(void **state)
{
    uint32_t answer = 0;
    (void)state;
    FOE_config(NULL); /* as if the application had not called it */
    open_in(PREOP);
    assert_int_equal(foe(FOE_OP_RRQ, 0, "notes", 5, &answer), FOE_OP_ERR);
    assert_int_equal(answer, FOE_ERR_ACCESS); /* as of any that might be written */
    assert_int_equal(foe(FOE_OP_WRQ, 0, "notes", 5, &answer), FOE_OP_ERR);
    assert_int_equal(answer, FOE_ERR_NOTFOUND);
}

/* --- an emulated EEPROM
 * ------------------------------------------------------------------------------------------------ */

static uint8_t eeprom[32];
static int8_t eeprom_fails;

void EEP_init(void)
{
    for (unsigned int n = 0; n < sizeof eeprom; n++)
        eeprom[n] = (uint8_t)n;
}

int8_t EEP_read(uint32_t addr, uint8_t *data, uint16_t size)
{
    memcpy(data, eeprom + addr, size);
    return eeprom_fails;
}

int8_t EEP_write(uint32_t addr, uint8_t *data, uint16_t size)
{
    memcpy(eeprom + addr, data, size);
    return eeprom_fails;
}

static void reload(eep_stat_t *stat)
{
    stat->contstat.bits.csumErr = 1;
}

static void command(uint8_t number, uint8_t word)
{
    hal.emulated = true;
    hal.acknowledged = 0;
    memset(hal.data, 0xEE, sizeof hal.data);
    hal.control[0] = 0x20;
    hal.control[1] = (uint8_t)(0x80 | 0x78 | number); /* busy, with all errors of the previous one */
    hal.control[2] = word;
    turns(1);
    assert_int_equal(hal.acknowledged, 1);
    hal.emulated = false;
}

static void emulated_eeprom(void **state)
{
    (void)state;
    assert_int_equal(sizeof(eep_config_t), 16);
    assert_int_equal(EEP_CONFIG_ALIAS_WORD_OFFSET * 2, offsetof(eep_config_t, configured_station_alias));
    EEP_init();
    eeprom_fails = 0;
    config.esc_hw_eep_handler = EEP_process;
    power_on();
    command(EEP_CMD_READ, 4);
    assert_memory_equal(hal.data, eeprom + 8, 8);
    assert_int_equal(hal.control[1], EEP_CMD_READ);
    EEP_set_read_size(4);
    EEP_set_read_size(5);
    command(EEP_CMD_READ, 4);
    assert_memory_equal(hal.data, "\x08\x09\x0A\x0B\xEE", 5);
    command(EEP_CMD_RELOAD, 0);
    assert_memory_equal(hal.data, "\x08\x09\xEE", 3);
    EEP_set_read_size(8);
    command(EEP_CMD_RELOAD, 1);
    assert_memory_equal(hal.data, eeprom + 2, 8);
    EEP_set_reload_function_pointer(reload);
    command(EEP_CMD_RELOAD, 0);
    assert_int_equal(hal.control[1], 0x08 | EEP_CMD_RELOAD);
    EEP_set_reload_function_pointer(NULL);
    command(EEP_CMD_WRITE, 3);
    assert_memory_equal(eeprom + 6, "\xEE\xEE\x08", EEP_WRITE_SIZE + 1);
    command(EEP_CMD_IDLE, 0);
    assert_int_equal(hal.control[1], EEP_CMD_IDLE);
    command(5, 0);
    assert_int_equal(hal.control[1], 0x20 | 5);
    eeprom_fails = -1;
    command(EEP_CMD_WRITE, 3);
    assert_int_equal(hal.control[1], 0x20 | EEP_CMD_WRITE);
}

int main(int argc, char **argv)
{
#define T(title, test)       {title, test, plain, close_all, NULL}
#define T_HOOKS(title, test) {title, test, with_object_hooks, close_all, NULL}
#define T_FILES(title, test) {title, test, with_files, close_all, NULL}
    const struct CMUnitTest tests[] = {
        T("ecat_slv_init: the hardware file, the ESC's EEPROM, defaults, INIT", start),
        T("set_defaults_hook and skip_default_initialization", defaults),
        T("CF-037: cb_set_outputs and cb_get_inputs run with the process data", process_data),
        T("SAFEOP has inputs and fetches outputs; PREOP has neither", not_before_op),
        T("rxpdo_override and txpdo_override move them instead", overrides),
        T("watchdog_cnt: so many turns without outputs leave OP with 0x001B, outputs safe once", watchdog),
        T("ESC_ALstatusgotoerror leaves for a lower state, and for no other", own_account),
        T("CF-033: hooks of state changes, each once, up and down", state_hooks),
        T("a hook that sets ESCerror refuses the change, with the code of ESC_ALerror", refused),
        T("BOOT has a mailbox of its own", boot),
        T("CF-040: get_device_id, or the station alias, is the explicit identification", identification),
        T("use_interrupt: the enabled and disabled events, and the check of DC by the application", interrupts),
        T("Without use_interrupt, or without the functions of interrupts, none is called", no_interrupts),
        T("a hook of a refusal or a fall gets the state with ESCerror", errors_of_state_hooks),
        T("SYNC0 is in the EEPROM of an application that checks it", clock_modes),
        T("DIG_process does what its flags name", parts_of_the_exchange),
        T("ecat_slv_worker serves events, and lets through those that concern it", worker),
        T("a loop of separate calls: ESC_state does everything", pieces),
#ifndef APP_RAW
        T("CF-074: dynamic process data", remapped),
        T("CF-074: without outputs the watchdog does not leave OP", without_outputs),
        T("CF-074: a mapping that cannot be is refused on the way to SAFEOP", mapped_wrongly),
#endif
        T_HOOKS("CF-067 CF-068: hooks of uploads: data, length, abort codes, each once", uploads),
        T_HOOKS("CF-069 CF-070: hooks of downloads: data, length, abort codes, each once", downloads),
        T_HOOKS("hooks of objects by their own names", hooks_by_name),
        T("the object list as SOES's functions read it", dictionary),
        T("ESC_config sets the mailboxes, and those of PREOP are active", configured_mailboxes),
        T("32 bytes of a mapped entry move at most", longest_mapped_entries),
        T("an access by ESC_read and ESC_write succeeds", results_of_the_seam),
        T("a start with an ESC that does not answer is repeated", failing_start),
        T("registers, by SOES's functions", registers),
        T("each function of a register reads or writes its address and length", accesses),
        T("elements of mapping and assignment are fixed while they count", fixed_elements),
        T("the indices of mappings and assignments alone have fixed elements", fixed_indices),
        T("the description is made of the options and of the object list", described),
        T("a permanent event is served 16 times in succession", staying_event),
        T_HOOKS("a transfer ends with the state that it was in", reset_transfer),
        T("without a clock the time is the ESC's", time_of_the_esc),
        T_FILES("FOE_config: a file goes to its function by buffers", file_written),
        T_FILES("FOE_config: names, passwords, states and lengths that are refused", file_refused),
        T("without FOE_config there is no file", no_files),
        T("EEP_process: an emulated EEPROM", emulated_eeprom),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SOES's API", tests, NULL, NULL);
}
