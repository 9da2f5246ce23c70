/* SPDX-License-Identifier: MIT */
/* D. The state machine. */
#include <string.h>

#include "steps/case.h"

enum { ACK = ECT_AL_ACKNOWLEDGE, IDENT = ECT_AL_IDENT };
enum {
    INVALID_CHANGE = 0x0011,
    UNKNOWN_STATE = 0x0012,
    NO_BOOT = 0x0013,
    BOOT_MAILBOX = 0x0015,
    MAILBOX = 0x0016,
    WATCHDOG = 0x001B,
    OUTPUTS = 0x001D,
    INPUTS = 0x001E,
};
enum { SII_GENERAL = 30, GENERAL_FLAGS = 11, FLAG_IDENT = 0x08, SII_DC = 60 };
enum {
    WATCHDOG_TICKS_SHORT = 10,
    WATCHDOG_TICKS_FALLBACK = 3000,
    COUNTER_ROUNDS = 270,
    ABSENCE_S = 1,
    ABSENCE_LONG_S = 3600,
    FALLBACK_MS = 5000,
    SHORT_MS = 100,
    SYNC0_DELAY_NS = 200000000,
    SYNC0_CYCLE_NS = 1000000,
    SYNC0_SEEN = 0x0C, /* bits of 0x0151: SYNC0 output, SYNC0 mapped to AL event */
};

/* @return the first SyncManager of a type with process data; -1: none */
static int used_sm(const cf_t *c, uint8_t type)
{
    for (int n = 0; n < c->facts.sm_count; n++) {
        if (c->facts.sm[n].type == type && c->facts.sm[n].length > 0)
            return n;
    }
    return -1;
}

/* --- transitions -------------------------------------------------------------------------------------------------- */

/* Takes the slave through one transition, with the configuration and process data required of the master. */
static void take(cf_t *c, uint8_t from, uint8_t to)
{
    cf_go(c, from);
    cf_step(c, "%s to %s", cf_state_name(from), cf_state_name(to));
    cf_go(c, to);
    uint16_t code = cf_get16(c, ECT_REG_AL_STATUS_CODE);
    cf_expect(c, "AL status code after a legal transition", 0, code);
}

static void legal(cf_t *c)
{
    static const uint8_t ways[][2] = {{CF_INIT, CF_PREOP}, {CF_PREOP, CF_SAFEOP}, {CF_SAFEOP, CF_OP},
                                      {CF_OP, CF_SAFEOP},  {CF_SAFEOP, CF_PREOP}, {CF_PREOP, CF_INIT},
                                      {CF_OP, CF_PREOP},   {CF_OP, CF_INIT},      {CF_SAFEOP, CF_INIT}};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++)
        take(c, ways[i][0], ways[i][1]);
    if ((c->facts.has & CF_BOOTSTRAP) != 0) {
        take(c, CF_INIT, CF_BOOT);
        take(c, CF_BOOT, CF_INIT);
    }
}

/* BOOT from another state than INIT must be refused, as invalid or as unsupported. Some stacks leave OP on this
 * request. */
static void refuse_jump(cf_t *c, uint8_t from, uint8_t to)
{
    uint16_t code;
    cf_go(c, from);
    cf_step(c, "%s to %s", cf_state_name(from), cf_state_name(to));
    uint16_t got = cf_request(c, to, &code);
    if (from == CF_OP && (got & 0x1F) == (CF_SAFEOP | ECT_AL_ERROR)) {
        cf_warn(c, "%s to %s: refused, but the slave fell to SAFEOP", cf_state_name(from), cf_state_name(to));
        from = CF_SAFEOP;
    }
    bool no_boot = to == CF_BOOT && (c->facts.has & CF_BOOTSTRAP) == 0 && code == NO_BOOT;
    cf_expect_that(c, (got & 0x1F) == (from | ECT_AL_ERROR) && (code == INVALID_CHANGE || no_boot),
                   "%s to %s: expected %s with code 0x0011, got %s with code 0x%04X", cf_state_name(from),
                   cf_state_name(to), cf_state_name(from | ECT_AL_ERROR), cf_state_name(got), code);
    cf_expect_state(c, from | ACK, from);
}

static void illegal(cf_t *c)
{
    static const uint8_t jumps[][2] = {{CF_INIT, CF_SAFEOP}, {CF_INIT, CF_OP},     {CF_PREOP, CF_OP},
                                       {CF_PREOP, CF_BOOT},  {CF_SAFEOP, CF_BOOT}, {CF_OP, CF_BOOT}};
    static const uint8_t from_boot[] = {CF_PREOP, CF_SAFEOP, CF_OP};
    for (size_t i = 0; i < sizeof jumps / sizeof jumps[0]; i++)
        refuse_jump(c, jumps[i][0], jumps[i][1]);
    for (size_t i = 0; (c->facts.has & CF_BOOTSTRAP) != 0 && i < sizeof from_boot; i++)
        refuse_jump(c, CF_BOOT, from_boot[i]);
}

static void unknown(cf_t *c)
{
    static const uint8_t states[] = {CF_INIT, CF_PREOP}, values[] = {0, 5, 6, 7, 9, 10, 12, 15};
    for (size_t s = 0; s < sizeof states; s++) {
        cf_go(c, states[s]);
        for (size_t i = 0; i < sizeof values; i++) {
            cf_expect_refused(c, values[i], states[s], UNKNOWN_STATE);
            cf_expect_state(c, states[s] | ACK, states[s]);
        }
    }
    if ((c->facts.has & CF_BOOTSTRAP) != 0) {
        cf_note(c, "unknown states; BOOT is supported");
        return;
    }
    cf_go(c, CF_INIT);
    cf_step(c, "BOOT, which the slave does not support");
    cf_expect_refused(c, CF_BOOT, CF_INIT, NO_BOOT);
}

/* --- wrong SyncManagers ------------------------------------------------------------------------------------------- */

/* A wrong setting of a SyncManager. */
typedef struct defect {
    const char *what;
    int start, length; /* added to the right values; length -65535: 4 bytes */
    uint8_t control;   /* inverted bits */
    bool off;
} defect_t;

static const defect_t mailbox_defects[] = {{"off", 0, 0, 0, true},
                                           {"starts 2 bytes later", 2, 0, 0, false},
                                           {"is 4 bytes long", 0, -65535, 0, false},
                                           {"has the other direction", 0, 0, 0x04, false},
                                           {"has three buffers", 0, 0, 0x02, false}};

static void set_wrong_sm(cf_t *c, unsigned int n, uint16_t start, uint16_t length, uint8_t control, const defect_t *d)
{
    uint16_t wrong = d->length == -65535 ? 4 : (uint16_t)(length + d->length);
    cf_set_sm(c, n, (uint16_t)(start + d->start), d->off ? 0 : wrong, control ^ d->control);
}

static void wrong_mailbox_sm(cf_t *c, uint8_t state, unsigned int n, uint16_t code)
{
    const cf_mailbox_t *m = state == CF_BOOT ? &c->facts.boot : &c->mailbox;
    for (size_t i = 0; i < sizeof mailbox_defects / sizeof mailbox_defects[0]; i++) {
        cf_step(c, "%s: SM%u %s", cf_state_name(state), n, mailbox_defects[i].what);
        cf_set_mailbox(c, state);
        set_wrong_sm(c, n, n == 0 ? m->out_start : m->in_start, n == 0 ? m->out_size : m->in_size,
                     c->facts.sm[n].control, &mailbox_defects[i]);
        cf_expect_refused(c, state, CF_INIT, code);
        cf_expect_state(c, CF_INIT | ACK, CF_INIT);
    }
}

static void wrong_mailbox(cf_t *c)
{
    wrong_mailbox_sm(c, CF_PREOP, 0, MAILBOX);
    wrong_mailbox_sm(c, CF_PREOP, 1, MAILBOX);
    if ((c->facts.has & CF_BOOTSTRAP) != 0) {
        wrong_mailbox_sm(c, CF_BOOT, 0, BOOT_MAILBOX);
        wrong_mailbox_sm(c, CF_BOOT, 1, BOOT_MAILBOX);
    }
    cf_step(c, "with the right settings it works");
    cf_go(c, CF_PREOP);
}

static const defect_t process_defects[] = {{"off", 0, 0, 0, true},
                                           {"starts 2 bytes later", 2, 0, 0, false},
                                           {"is a byte longer", 0, 1, 0, false},
                                           {"is a byte shorter", 0, -1, 0, false},
                                           {"has the other direction", 0, 0, 0x04, false}};

static void wrong_process_sm(cf_t *c, uint8_t type, uint16_t code)
{
    int n = used_sm(c, type);
    for (size_t i = 0; n >= 0 && i < sizeof process_defects / sizeof process_defects[0]; i++) {
        const cf_sm_t *sm = &c->facts.sm[n];
        if (sm->length == 1 && process_defects[i].length == -1)
            continue;
        cf_step(c, "SAFEOP: SM%d %s", n, process_defects[i].what);
        cf_set_process_data(c);
        set_wrong_sm(c, (unsigned int)n, sm->start, sm->length, sm->control, &process_defects[i]);
        cf_expect_refused(c, CF_SAFEOP, CF_PREOP, code);
        cf_expect_state(c, CF_PREOP | ACK, CF_PREOP);
    }
}

static void wrong_process_data(cf_t *c)
{
    int out = used_sm(c, ECT_SM_OUTPUTS), in = used_sm(c, ECT_SM_INPUTS);
    uint16_t code;
    if (out < 0 && in < 0)
        cf_skip(c, "the slave has no process data");
    cf_go(c, CF_PREOP);
    wrong_process_sm(c, ECT_SM_OUTPUTS, OUTPUTS);
    wrong_process_sm(c, ECT_SM_INPUTS, INPUTS);
    if (out >= 0 && in >= 0) {
        cf_step(c, "SAFEOP: both off");
        cf_set_sm(c, (unsigned int)out, 0, 0, 0);
        cf_set_sm(c, (unsigned int)in, 0, 0, 0);
        uint16_t got = cf_request(c, CF_SAFEOP, &code);
        cf_expect_that(c, (got & 0x1F) == (CF_PREOP | ECT_AL_ERROR) && (code == OUTPUTS || code == INPUTS),
                       "both SMs off: expected PREOP + error with code 0x001D or 0x001E, got %s with code 0x%04X",
                       cf_state_name(got), code);
        cf_expect_state(c, CF_PREOP | ACK, CF_PREOP);
    }
    cf_step(c, "with the right settings it works");
    cf_go(c, CF_SAFEOP);
}

/* --- errors ------------------------------------------------------------------------------------------------------- */

static void error_in_preop(cf_t *c)
{
    cf_go(c, CF_PREOP);
    cf_expect_refused(c, CF_OP, CF_PREOP, INVALID_CHANGE);
}

static void acknowledge(cf_t *c)
{
    uint16_t code;
    error_in_preop(c);
    cf_set_process_data(c);
    cf_step(c, "a valid request without an acknowledge");
    uint16_t got = cf_request(c, CF_SAFEOP, &code);
    cf_expect_that(c, (got & 0x1F) == (CF_PREOP | ECT_AL_ERROR) && code == INVALID_CHANGE,
                   "a request without acknowledge: expected PREOP + error with code 0x0011 as before, got %s with code "
                   "0x%04X",
                   cf_state_name(got), code);
    cf_step(c, "the acknowledge");
    cf_expect_state(c, CF_PREOP | ACK, CF_PREOP);
}

static void acknowledge_and_go(cf_t *c)
{
    error_in_preop(c);
    cf_set_process_data(c);
    cf_step(c, "the acknowledge together with SAFEOP");
    cf_expect_state(c, CF_SAFEOP | ACK, CF_SAFEOP);
}

/* A read of status and code in one datagram must never return the error flag without a code. */
static void code_before_flag(cf_t *c)
{
    cf_go(c, CF_PREOP);
    cf_expect(c, "AL status code without an error", 0, cf_get16(c, ECT_REG_AL_STATUS_CODE));
    for (int round = 0; round < 10; round++) {
        uint8_t seen[6] = {0};
        uint64_t until = cf_now_ns() + FALLBACK_MS * UINT64_C(1000000);
        cf_put16(c, ECT_REG_AL_CONTROL, CF_OP);
        while ((seen[0] & ECT_AL_ERROR) == 0 && cf_now_ns() < until)
            cf_get(c, ECT_REG_AL_STATUS, seen, sizeof seen);
        cf_expect(c, "AL status after an illegal request", CF_PREOP | ECT_AL_ERROR, seen[0]);
        cf_expect(c, "AL status code in the first read with the error flag", INVALID_CHANGE, ect_load_le16(seen + 4));
        cf_expect_state(c, CF_PREOP | ACK, CF_PREOP);
    }
}

static void repeated(cf_t *c)
{
    static const uint8_t states[] = {CF_INIT, CF_PREOP, CF_SAFEOP};
    for (size_t i = 0; i < sizeof states; i++) {
        cf_go(c, states[i]);
        cf_step(c, "%s again, three times", cf_state_name(states[i]));
        for (int times = 0; times < 3; times++)
            cf_expect_state(c, states[i], states[i]);
    }
    cf_step(c, "OP, and SAFEOP before OP is reached");
    cf_put16(c, ECT_REG_AL_CONTROL, CF_OP);
    (void)cf_wait_bits(c, ECT_REG_AL_EVENT, ECT_EVENT_AL_CONTROL, 0, FALLBACK_MS, NULL);
    cf_expect_state(c, CF_SAFEOP, CF_SAFEOP);
    cf_sleep_ms(c, SHORT_MS);
    cf_expect(c, "AL status some time later", CF_SAFEOP, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
    cf_go(c, CF_OP);
    cf_expect_state(c, CF_OP, CF_OP);
}

/* --- watchdog ----------------------------------------------------------------------------------------------------- */

/* @return whether there are outputs, and they trigger the watchdog */
static bool is_watched(const cf_t *c)
{
    int n = used_sm(c, ECT_SM_OUTPUTS);
    return n >= 0 && (c->facts.sm[n].control & ECT_SM_CONTROL_WATCHDOG) != 0;
}

static void fallback(cf_t *c)
{
    uint8_t data[CF_MAX_DATA];
    uint16_t got, code;
    const int in = used_sm(c, ECT_SM_INPUTS);
    if (!is_watched(c))
        cf_skip(c, "the SII's output SyncManager does not trigger the watchdog");
    cf_go(c, CF_OP);
    cf_put16(c, ECT_REG_WD_TIME_PD, WATCHDOG_TICKS_FALLBACK);
    (void)cf_cycle(c, NULL, NULL);
    cf_step(c, "no more outputs");
    (void)cf_wait_status(c, CF_SAFEOP | ECT_AL_ERROR, FALLBACK_MS, false, &got, &code);
    cf_expect_that(c, (got & 0x1F) == (CF_SAFEOP | ECT_AL_ERROR) && code == WATCHDOG,
                   "outputs stop: expected SAFEOP + error with code 0x001B, got %s with code 0x%04X",
                   cf_state_name(got), code);
    if (in >= 0)
        cf_expect_wkc(c, "a read of the inputs after the fallback", 1,
                      cf_read(c, c->facts.sm[in].start, data, c->facts.sm[in].length));
    cf_step(c, "acknowledge, and OP again");
    cf_put16(c, ECT_REG_WD_TIME_PD, 60000);
    cf_expect_state(c, CF_SAFEOP | ACK, CF_SAFEOP);
    cf_go(c, CF_OP);
}

/* In SAFEOP the slave's software does not react: only the chip counts. */
static void counter_stops(cf_t *c)
{
    cf_go(c, CF_SAFEOP);
    cf_put16(c, ECT_REG_WD_TIME_PD, WATCHDOG_TICKS_SHORT);
    cf_put8(c, ECT_REG_WD_COUNTER_PD, 0);
    cf_step(c, "outputs once, then none until the watchdog expires; %d times", (int)COUNTER_ROUNDS);
    for (int i = 0; i < COUNTER_ROUNDS; i++) {
        (void)cf_cycle(c, NULL, NULL);
        bool expired = cf_wait_bits(c, ECT_REG_WD_STATUS_PD, 1, 0, FALLBACK_MS, NULL);
        cf_expect_that(c, expired, "watchdog of 1 ms: expected to expire within %d ms, got 0x0440 = 1",
                       (int)FALLBACK_MS);
    }
    cf_expect_range(c, "watchdog counter", 255, 255, cf_get8(c, ECT_REG_WD_COUNTER_PD));
    cf_expect(c, "AL status", CF_SAFEOP, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
}

/* After a long time without frames, the watchdog has counted once, and the slave can be restarted. */
static void without_master(cf_t *c, uint32_t seconds)
{
    const bool watched = is_watched(c);
    cf_put16(c, ECT_REG_WD_TIME_PD, 60000);
    cf_go(c, CF_OP);
    cf_put16(c, ECT_REG_WD_TIME_PD, WATCHDOG_TICKS_FALLBACK);
    cf_put8(c, ECT_REG_WD_COUNTER_PD, 0);
    (void)cf_cycle(c, NULL, NULL);
    cf_step(c, "no frame for %u s", seconds);
    cf_extend(c, 1000 * seconds);
    cf_sleep_ms(c, 1000 * seconds);
    const uint16_t status = cf_get16(c, ECT_REG_AL_STATUS) & 0x1F, code = cf_get16(c, ECT_REG_AL_STATUS_CODE);
    const bool fell = status == (CF_SAFEOP | ECT_AL_ERROR) && code == WATCHDOG;
    if (watched)
        cf_expect_range(c, "watchdog counter after that", 1, 1, cf_get8(c, ECT_REG_WD_COUNTER_PD));
    /* A slave whose outputs do not trigger the chip's watchdog may have a watchdog in software. */
    cf_expect_that(c, fell || (!watched && status == CF_OP),
                   "AL status after %u s: expected SAFEOP + error with code 0x001B%s, got %s with code 0x%04X", seconds,
                   watched ? "" : ", or OP", cf_state_name(status), code);
    cf_step(c, "the master is back");
    cf_go(c, CF_SAFEOP);
    cf_put16(c, ECT_REG_WD_TIME_PD, 60000);
    cf_go(c, CF_OP);
}

static void long_absence(cf_t *c)
{
    if (is_watched(c))
        counter_stops(c);
    without_master(c, c->whole ? ABSENCE_LONG_S : ABSENCE_S);
    cf_note(c, "%d s without a master%s", c->whole ? ABSENCE_LONG_S : ABSENCE_S, c->whole ? "" : "; --long: an hour");
}

/* --- synchronisation ---------------------------------------------------------------------------------------------- */

/* Finds the DC mode with SYNC0 that is easiest for a PC: cycle 0, set by the master, or else the longest cycle.
 * @return AssignActivate; *cycle_ns */
static uint16_t dc_mode(cf_t *c, uint32_t *cycle_ns)
{
    size_t length;
    uint16_t best = 0;
    const uint8_t *data = cf_sii_category(c, SII_DC, &length);
    for (size_t at = 0; data && at + 24 <= length; at += 24) {
        uint16_t activate = ect_load_le16(data + at + 14);
        uint32_t cycle = ect_load_le32(data + at);
        bool better = best == 0 || (*cycle_ns != 0 && (cycle == 0 || cycle > *cycle_ns));
        if ((activate & 0x0200) == 0 || !better)
            continue;
        best = activate;
        *cycle_ns = cycle;
    }
    if (best == 0)
        cf_skip(c, "the SII contains no mode with SYNC0");
    return best;
}

/* Starts SYNC0. @return the system time after a few pulses */
static uint64_t start_sync0(cf_t *c, uint16_t activate, uint32_t cycle_ns)
{
    uint64_t start_ns = cf_get64(c, ECT_REG_DC_SYSTEM_TIME) + SYNC0_DELAY_NS;
    cf_put8(c, ECT_REG_DC_ACTIVATION, 0);
    cf_put8(c, ECT_REG_DC_ACTIVATION - 1, (uint8_t)activate);
    cf_put32(c, ECT_REG_DC_SYNC0_CYCLE, cycle_ns);
    cf_put64(c, ECT_REG_DC_START_TIME, start_ns);
    cf_put8(c, ECT_REG_DC_ACTIVATION, (uint8_t)(activate >> 8));
    return start_ns + UINT64_C(10) * cycle_ns;
}

/* @return the cycle of the SII, which may be the only one allowed; else the minimum of 1C32h, at least 1 ms */
static uint32_t sync0_cycle(cf_t *c, uint32_t cycle_ns)
{
    uint32_t code;
    if (cycle_ns != 0)
        return cycle_ns;
    if ((c->facts.has & CF_COE) != 0 && cf_object_exists(c, 0x1C32, 5, &code))
        cycle_ns = (uint32_t)cf_upload_number(c, 0x1C32, 5);
    return cycle_ns < SYNC0_CYCLE_NS ? SYNC0_CYCLE_NS : cycle_ns;
}

/* Selects synchronisation by SYNC0 if selectable, with a high limit of sync errors: this PC is no real-time controller.
 */
static void choose_sync0(cf_t *c)
{
    const uint8_t sync0[2] = {2, 0}, limit[2] = {200, 0};
    if ((c->facts.has & CF_COE) == 0)
        return;
    (void)cf_change(c, 0x1C32, 1, sync0, sizeof sync0);
    (void)cf_change(c, 0x1C33, 1, sync0, sizeof sync0);
    (void)cf_change(c, 0x10F1, 2, limit, sizeof limit);
}

static void sync_lost(cf_t *c)
{
    static const uint16_t codes[] = {0x001A, 0x002C, 0x002D, 0x0030, 0x0032, 0x0033, 0x0034};
    uint32_t cycle_ns;
    uint16_t got, code, activate = dc_mode(c, &cycle_ns);
    bool known = false;
    if ((cf_get8(c, ECT_REG_SYNC_CONFIG) & SYNC0_SEEN) == 0)
        cf_skip(c, "the chip outputs SYNC0 neither to a pin nor to the slave's software (0x0151)");
    cf_go(c, CF_PREOP);
    choose_sync0(c);
    uint64_t runs_ns = start_sync0(c, activate, sync0_cycle(c, cycle_ns));
    cf_go(c, CF_OP);
    while (cf_get64(c, ECT_REG_DC_SYSTEM_TIME) < runs_ns) {
        (void)cf_cycle(c, NULL, NULL);
        cf_poll_pause(c);
    }
    cf_expect(c, "AL status with SYNC0", CF_OP, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
    cf_step(c, "SYNC0 stops, process data continue");
    cf_put8(c, ECT_REG_DC_ACTIVATION, 0);
    (void)cf_wait_status(c, CF_SAFEOP | ECT_AL_ERROR, FALLBACK_MS, true, &got, &code);
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++)
        known |= code == codes[i];
    cf_expect_that(c, (got & 0x1F) == (CF_SAFEOP | ECT_AL_ERROR) && known,
                   "SYNC0 stops: expected SAFEOP + error with a synchronisation code, got %s with code 0x%04X",
                   cf_state_name(got), code);
}

static void local_error(cf_t *c)
{
    cf_skip(c, "only the slave's application can cause this, not a master");
}

static void power_up(cf_t *c)
{
    static const struct {
        uint16_t address;
        uint8_t width;
        uint32_t value;
        const char *what;
    } values[] = {
        {ECT_REG_AL_STATUS, 2, CF_INIT, "AL status"},
        {ECT_REG_AL_STATUS_CODE, 2, 0, "AL status code"},
        {ECT_REG_RX_ERROR, 4, 0, "receive errors of ports 0 and 1"},
        {ECT_REG_WD_DIVIDER, 2, 0x09C2, "watchdog divider"},
        {ECT_REG_WD_TIME_PD, 2, 1000, "process data watchdog"},
        {ECT_REG_SM + ECT_SM_ACTIVATE, 1, 0, "activation of SM0"},
        {ECT_REG_SM + ECT_SM_SIZE + ECT_SM_ACTIVATE, 1, 0, "activation of SM1"},
        {ECT_REG_FMMU + ECT_FMMU_ACTIVATE, 1, 0, "activation of FMMU0"},
    };
    uint8_t bytes[8];
    if (!c->power)
        cf_skip(c, "needs a power cycle: give a command that switches the slave off and on, --power COMMAND");
    cf_go(c, CF_OP);
    cf_power_cycle(c);
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        memset(bytes, 0, sizeof bytes);
        uint16_t wkc = cf_command(c, CF_APRD, c->facts.ring, values[i].address, bytes, values[i].width);
        cf_expect_that(c, wkc == 1 && ect_load_le32(bytes) == values[i].value,
                       "%s after power-on: expected 0x%X, got 0x%X, WKC %u", values[i].what, values[i].value,
                       (unsigned int)ect_load_le32(bytes), wkc);
    }
}

static void emulation(cf_t *c)
{
    static const uint8_t values[] = {CF_INIT, CF_PREOP, CF_SAFEOP, CF_OP, CF_INIT | ACK, CF_INIT};
    for (size_t i = 0; i < sizeof values; i++) {
        cf_put16(c, ECT_REG_AL_CONTROL, values[i]);
        cf_expect(c, "AL status, which mirrors AL control", values[i], cf_get16(c, ECT_REG_AL_STATUS));
    }
}

/* --- identification, process data --------------------------------------------------------------------------------- */

static bool wait_ident(cf_t *c, bool set)
{
    return cf_wait_bits(c, ECT_REG_AL_STATUS, IDENT, set ? IDENT : 0, SHORT_MS * 20, NULL);
}

static void identify_in(cf_t *c, uint8_t state, uint16_t *id)
{
    cf_go(c, state);
    cf_step(c, "the identification value in %s", cf_state_name(state));
    cf_put16(c, ECT_REG_AL_CONTROL, state | IDENT);
    cf_expect_that(c, wait_ident(c, true), "AL status in %s: expected bit 5 set, got 0x%04X", cf_state_name(state),
                   cf_get16(c, ECT_REG_AL_STATUS));
    cf_expect(c, "AL status with the value", state | IDENT, cf_get16(c, ECT_REG_AL_STATUS));
    uint16_t value = cf_get16(c, ECT_REG_AL_STATUS_CODE);
    cf_expect_that(c, value != 0 && (*id == 0 || *id == value), "identification value: expected %s, got 0x%04X",
                   *id == 0 ? "not 0" : "the same in every state", value);
    *id = value;
    cf_put16(c, ECT_REG_AL_CONTROL, state);
    cf_expect_that(c, wait_ident(c, false), "AL status without the request: expected bit 5 clear, got 0x%04X",
                   cf_get16(c, ECT_REG_AL_STATUS));
    cf_expect(c, "0x0134 without the request", 0, cf_get16(c, ECT_REG_AL_STATUS_CODE));
}

/* A slave with alias 0 may have no identification value, which only its reply reveals. */
static void expect_value(cf_t *c)
{
    if (c->facts.alias != 0)
        return;
    cf_step(c, "the identification value in INIT, with alias 0");
    cf_put16(c, ECT_REG_AL_CONTROL, CF_INIT | IDENT);
    bool given = wait_ident(c, true);
    cf_put16(c, ECT_REG_AL_CONTROL, CF_INIT);
    if (!given)
        cf_skip(c, "the slave has no identification value: its alias is 0");
}

static void identification(cf_t *c)
{
    size_t length;
    uint16_t id = 0;
    const uint8_t *general = cf_sii_category(c, SII_GENERAL, &length);
    if (!general || length <= GENERAL_FLAGS || (general[GENERAL_FLAGS] & FLAG_IDENT) == 0)
        cf_skip(c, "the SII does not announce identification by AL status");
    expect_value(c);
    identify_in(c, CF_INIT, &id);
    identify_in(c, CF_PREOP, &id);
    identify_in(c, CF_SAFEOP, &id);
    cf_step(c, "with an error pending");
    cf_go(c, CF_PREOP);
    cf_expect_refused(c, CF_OP, CF_PREOP, INVALID_CHANGE);
    cf_put16(c, ECT_REG_AL_CONTROL, CF_PREOP | IDENT);
    cf_sleep_ms(c, SHORT_MS);
    cf_expect(c, "AL status after a request for the value with an error pending", CF_PREOP | ECT_AL_ERROR,
              cf_get16(c, ECT_REG_AL_STATUS));
    cf_note(c, "identification value 0x%04X", id);
}

/* Finds the first mapped output that an SDO may read. @return false: none */
static bool first_output(cf_t *c, uint16_t *index, uint8_t *sub)
{
    uint32_t code;
    uint16_t assignment = (uint16_t)(0x1C10 + used_sm(c, ECT_SM_OUTPUTS));
    if ((c->facts.has & CF_COE) == 0 || !cf_object_exists(c, assignment, 1, &code))
        return false;
    uint16_t pdo = (uint16_t)cf_upload_number(c, assignment, 1);
    if (!cf_object_exists(c, pdo, 1, &code))
        return false;
    uint32_t entry = (uint32_t)cf_upload_number(c, pdo, 1);
    *index = (uint16_t)(entry >> 16);
    *sub = (uint8_t)(entry >> 8);
    return *index != 0 && cf_object_exists(c, *index, *sub, &code);
}

static void outputs_stay(cf_t *c)
{
    uint8_t outputs[CF_MAX_DATA], before[64] = {0}, after[64] = {0};
    size_t size = sizeof before, again = sizeof after;
    uint16_t index, sub_index;
    uint8_t sub;
    cf_go(c, CF_SAFEOP);
    if (!first_output(c, &index, &sub)) {
        cf_note(c, "inputs only; outputs of this slave cannot be read by SDO");
        return;
    }
    sub_index = sub;
    (void)cf_upload(c, index, sub, false, before, &size);
    cf_step(c, "outputs 0x55 in SAFEOP; %04Xh:%02X is the first one", index, sub_index);
    memset(outputs, 0x55, sizeof outputs);
    for (int i = 0; i < 10; i++)
        (void)cf_cycle(c, outputs, NULL);
    (void)cf_upload(c, index, sub, false, after, &again);
    cf_expect_range(c, "length of the output object", size, size, again);
    cf_expect_bytes(c, "the first output in SAFEOP, while other values are sent", before, after, size);
    cf_expect(c, "AL status", CF_SAFEOP, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
}

static void safe_outputs(cf_t *c)
{
    uint8_t data[CF_MAX_DATA];
    const int in = used_sm(c, ECT_SM_INPUTS);
    cf_go(c, CF_SAFEOP);
    if (in >= 0)
        cf_expect_wkc(c, "a read of the inputs as soon as AL status is SAFEOP", 1,
                      cf_read(c, c->facts.sm[in].start, data, c->facts.sm[in].length));
    if (used_sm(c, ECT_SM_OUTPUTS) >= 0)
        outputs_stay(c);
}

static const cf_case_t cases[] = {
    {"CF-033", "Every legal transition completes in time, without an error", 'R', 0, 60000, legal},
    {"CF-034", "An illegal transition is refused with code 0x0011; the state is unchanged", 'R', CF_APPLICATION, 60000,
     illegal},
    {"CF-035", "An unknown state is refused with 0x0012, an unsupported BOOT with 0x0013", 'R', CF_APPLICATION, 0,
     unknown},
    {"CF-036", "With a wrong SM0 or SM1 the slave stays in INIT, code 0x0016 (BOOT: 0x0015)", 'R',
     CF_APPLICATION | CF_MAILBOX, 60000, wrong_mailbox},
    {"CF-037", "With a wrong SyncManager for process data the slave stays in PREOP, code 0x001D or 0x001E", 'R',
     CF_APPLICATION, 60000, wrong_process_data},
    {"CF-038", "With the error flag set a request without acknowledge is ignored", 'R', CF_APPLICATION, 0, acknowledge},
    {"CF-039", "A request with acknowledge and a higher state does both", 'R', CF_APPLICATION, 0, acknowledge_and_go},
    {"CF-040", "The code precedes the error flag, and clears with it", 'R', CF_APPLICATION, 0, code_before_flag},
    {"CF-041", "Repeated requests, and a request during a transition, cause no error", 'R', CF_APPLICATION, 60000,
     repeated},
    {"CF-042", "Without outputs the slave falls from OP to SAFEOP, code 0x001B; inputs continue; OP is reachable again",
     'R', CF_APPLICATION | CF_OUTPUTS, 0, fallback},
    {"CF-043", "Without SYNC0 the slave falls from OP to SAFEOP with a synchronisation code", 'R',
     CF_APPLICATION | CF_DC | CF_SII | CF_REAL_TIME, 30000, sync_lost},
    {"CF-044", "After a local error the slave falls to the state of the error, with the code of the error", 'R',
     CF_APPLICATION, 0, local_error},
    {"CF-045", "With device emulation AL status mirrors AL control", 'R', CF_EMULATION, 0, emulation},
    {"CF-046", "The slave returns its identification value on request in each state, except with an error pending", 'R',
     CF_APPLICATION | CF_SII, 0, identification},
    {"CF-047", "After power-on the slave is in INIT, with all registers at their reset values", 'R', 0, 0, power_up},
    {"CF-048", "In SAFEOP inputs are valid and outputs do not change", 'R', CF_APPLICATION, 0, safe_outputs},
    {"CF-049", "The watchdog counter stops at 255; a long absence of the master is counted once", 'R', CF_APPLICATION,
     60000, long_absence},
};

CF_SECTION(cf_machine, 'D', "State machine", cases);
