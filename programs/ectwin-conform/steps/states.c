/* SPDX-License-Identifier: MIT */
/* The state of the slave, the configuration for each state, process data. */
#include <stdio.h>
#include <string.h>

#include "steps/engine.h"
#include "text/state.h"

enum { LOGICAL = 0x00010000, READS = 1, WRITES = 2 };
/* 6 s with the default divider: unlike a controller, cases and loaded machines pause. */
enum { LONG_WATCHDOG = 60000 };
/* Defaults of ETG.2000. OP to SAFEOP gets the longer limit too, because no step judges speed. */
enum { PREOP_MS = 3000, SAFEOP_OP_MS = 10000, INIT_MS = 5000, STUCK_MS = 300, SETTLE_MS = 100 };

const char *cf_state_name(uint16_t al_status)
{
    return ect_state_text(al_status);
}

/* --- configuration ------------------------------------------------------------------------------------------------ */

void cf_set_sm(cf_t *c, unsigned int n, uint16_t start, uint16_t length, uint8_t control)
{
    uint8_t registers[ECT_SM_SIZE] = {0};
    cf_put8(c, (uint16_t)(CF_SM(n) + ECT_SM_ACTIVATE), 0); /* while active, the other registers are write-protected */
    if (length > 0) {
        ect_store_le16(registers + ECT_SM_START, start);
        ect_store_le16(registers + ECT_SM_LENGTH, length);
        registers[ECT_SM_CONTROL] = control;
        registers[ECT_SM_ACTIVATE] = ECT_SM_ACTIVATE_ENABLE;
    }
    cf_put(c, CF_SM(n), registers, sizeof registers);
}

void cf_set_fmmu(cf_t *c, unsigned int n, uint32_t logical, uint16_t length, uint8_t start_bit, uint8_t stop_bit,
                 uint16_t physical, uint8_t physical_bit, uint8_t type)
{
    uint8_t registers[ECT_FMMU_SIZE] = {0};
    ect_store_le32(registers + ECT_FMMU_LOGICAL, logical);
    ect_store_le16(registers + ECT_FMMU_LENGTH, length);
    registers[ECT_FMMU_START_BIT] = start_bit;
    registers[ECT_FMMU_STOP_BIT] = stop_bit;
    ect_store_le16(registers + ECT_FMMU_PHYSICAL, physical);
    registers[ECT_FMMU_PHYSICAL_BIT] = physical_bit;
    registers[ECT_FMMU_TYPE] = type;
    registers[ECT_FMMU_ACTIVATE] = 1;
    cf_put(c, CF_FMMU(n), registers, sizeof registers);
}

void cf_clear_fmmu(cf_t *c, unsigned int n)
{
    const uint8_t registers[ECT_FMMU_SIZE] = {0};
    cf_put(c, CF_FMMU(n), registers, sizeof registers);
}

void cf_set_mailbox(cf_t *c, uint8_t state)
{
    const cf_mailbox_t *m = state == CF_BOOT ? &c->facts.boot : &c->mailbox;
    if ((c->facts.has & CF_MAILBOX) == 0)
        return;
    cf_set_sm(c, 0, m->out_start, m->out_size, c->facts.sm[0].control);
    cf_set_sm(c, 1, m->in_start, m->in_size, c->facts.sm[1].control);
    c->mail_counter = 0;
}

/* @return the FMMU assigned to `use` by the SII, else the first free one */
static unsigned int choose_fmmu(const cf_t *c, uint8_t use, uint32_t *taken)
{
    unsigned int n = 0;
    while (n < c->facts.fmmu_count && (c->facts.fmmu_use[n] != use || (*taken & (1u << n)) != 0))
        n++;
    if (n >= c->facts.fmmu_count) {
        n = 0;
        while ((*taken & (1u << n)) != 0)
            n++;
    }
    *taken |= 1u << n;
    return n;
}

static uint32_t map_direction(cf_t *c, uint8_t sm_type, uint32_t logical, uint32_t *taken)
{
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        const cf_sm_t *sm = &c->facts.sm[n];
        if (sm->type != sm_type)
            continue;
        cf_set_sm(c, n, sm->start, sm->length, sm->control);
        if (sm->length == 0)
            continue;
        unsigned int fmmu = choose_fmmu(c, sm_type == ECT_SM_OUTPUTS ? 1 : 2, taken);
        if (fmmu >= c->facts.fmmus)
            cf_skip(c, "the chip has fewer FMMUs (%u) than its process data need", c->facts.fmmus);
        cf_set_fmmu(c, fmmu, logical, sm->length, 0, 7, sm->start, 0, sm_type == ECT_SM_OUTPUTS ? WRITES : READS);
        logical += sm->length;
    }
    return logical;
}

void cf_set_process_data(cf_t *c)
{
    uint32_t taken = 0;
    cf_put16(c, ECT_REG_WD_TIME_PD, LONG_WATCHDOG);
    uint32_t logical = map_direction(c, ECT_SM_OUTPUTS, LOGICAL, &taken);
    (void)map_direction(c, ECT_SM_INPUTS, logical, &taken);
}

uint16_t cf_spare_ram(const cf_t *c)
{
    (void)c;
    return ECT_RAM;
}

unsigned int cf_spare_sm(cf_t *c)
{
    for (unsigned int n = c->facts.sms; n-- > 0;) {
        if ((cf_get8(c, (uint16_t)(CF_SM(n) + ECT_SM_PDI_CONTROL)) & ECT_SM_PDI_DISABLE) == 0)
            return n;
    }
    cf_skip(c, "the slave's software keeps all %u SyncManagers disabled in INIT", c->facts.sms);
}

/* --- process data ------------------------------------------------------------------------------------------------- */

uint16_t cf_cycle_wkc(const cf_t *c)
{
    bool lrw = (c->facts.has & CF_LRW_OK) != 0;
    return (uint16_t)((c->facts.output_bytes > 0 ? (lrw ? 2 : 1) : 0) + (c->facts.input_bytes > 0 ? 1 : 0));
}

uint16_t cf_cycle(cf_t *c, const uint8_t *outputs, uint8_t *inputs)
{
    uint8_t image[CF_MAX_DATA] = {0};
    const uint16_t out = c->facts.output_bytes, in = c->facts.input_bytes;
    if (out + in > CF_MAX_DATA - 12)
        cf_skip(c, "%u bytes of process data do not fit one datagram", (unsigned int)out + in);
    if (outputs)
        memcpy(image, outputs, out);
    cf_datagram_t d[2] = {{.command = CF_LRW, .address = LOGICAL, .length = (uint16_t)(out + in), .data = image}};
    size_t count = 1;
    if ((c->facts.has & CF_LRW_OK) == 0) {
        d[0] = (cf_datagram_t){.command = CF_LWR, .address = LOGICAL, .length = out, .data = image};
        d[1] = (cf_datagram_t){.command = CF_LRD, .address = LOGICAL + out, .length = in, .data = image + out};
        count = 2;
    }
    cf_exchange(c, d, count);
    if (inputs)
        memcpy(inputs, image + out, in);
    return (uint16_t)(d[0].wkc + d[1].wkc);
}

uint16_t cf_read_inputs(cf_t *c, uint8_t *inputs)
{
    return cf_logical(c, CF_LRD, LOGICAL + c->facts.output_bytes, inputs, c->facts.input_bytes);
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

static uint16_t al_status(cf_t *c, uint16_t *code)
{
    uint8_t bytes[6];
    cf_get(c, ECT_REG_AL_STATUS, bytes, sizeof bytes);
    if (code)
        *code = ect_load_le16(bytes + 4);
    return ect_load_le16(bytes);
}

bool cf_wait_status(cf_t *c, uint16_t status, uint32_t ms, bool cyclic, uint16_t *last, uint16_t *code)
{
    uint64_t until = cf_now_ns() + ms * UINT64_C(1000000);
    uint16_t now_code = 0, now = 0;
    for (bool over = false; !over;) {
        over = cf_now_ns() >= until;
        if (cyclic)
            (void)cf_cycle(c, NULL, NULL);
        now = al_status(c, &now_code);
        if ((now & 0x1F) == (status & 0x1F))
            break;
        cf_poll_pause(c);
    }
    if (last)
        *last = now;
    if (code)
        *code = now_code;
    return (now & 0x1F) == (status & 0x1F);
}

static uint32_t transition_ms(uint16_t al_control)
{
    switch (al_control & ECT_AL_STATE_MASK) {
    case CF_PREOP:
    case CF_BOOT:
        return PREOP_MS;
    case CF_SAFEOP:
    case CF_OP:
        return SAFEOP_OP_MS;
    default:
        return INIT_MS;
    }
}

/* After a failed return to INIT the slave gets a shorter timeout. */
static uint32_t init_ms(const cf_t *c)
{
    return c->engine->stuck ? STUCK_MS : INIT_MS;
}

/* The chip refuses a request until the slave's software has read the previous one. */
static void write_al_control(cf_t *c, uint16_t al_control)
{
    uint8_t bytes[2];
    uint64_t until = cf_now_ns() + init_ms(c) * UINT64_C(1000000);
    ect_store_le16(bytes, al_control);
    while (cf_write(c, ECT_REG_AL_CONTROL, bytes, sizeof bytes) != 1) {
        if (cf_now_ns() >= until)
            cf_fail(c, "AL control: WKC expected 1, got 0 for %u ms: the slave does not read the previous request",
                    init_ms(c));
        cf_poll_pause(c);
    }
    if ((c->facts.has & CF_EMULATION) == 0)
        (void)cf_wait_bits(c, ECT_REG_AL_EVENT, ECT_EVENT_AL_CONTROL, 0, init_ms(c), NULL);
}

/* AL status and AL status code. */
typedef struct al {
    uint16_t status, code;
} al_t;

/* @return whether the slave has replied to the request */
static bool has_replied(uint16_t wanted, al_t before, al_t now)
{
    if ((now.status & ECT_AL_ERROR) != 0)
        return now.code != 0 &&
               ((before.status & ECT_AL_ERROR) == 0 || now.code != before.code || now.status != before.status);
    return (now.status & ECT_AL_STATE_MASK) == (wanted & ECT_AL_STATE_MASK) && now.code == 0;
}

/* @return whether the status is a reply if it does not change: an old error (not acknowledged, or the same refusal
 * again), a state whose code may follow, and an error whose code is not yet or no longer present */
static bool may_be_reply(uint16_t wanted, al_t before, al_t now)
{
    if ((now.status & ECT_AL_ERROR) != 0)
        return (before.status & ECT_AL_ERROR) != 0 || now.code == 0;
    return (now.status & ECT_AL_STATE_MASK) == (wanted & ECT_AL_STATE_MASK);
}

static uint16_t request(cf_t *c, uint16_t al_control, bool cyclic, uint16_t *code)
{
    al_t before, now;
    before.status = al_status(c, &before.code);
    write_al_control(c, al_control);
    const uint64_t taken = cf_now_ns();
    const uint64_t until = taken + transition_ms(al_control) * UINT64_C(1000000);
    for (;;) {
        bool over = cf_now_ns() >= until;
        bool settled = cf_now_ns() >= taken + SETTLE_MS * UINT64_C(1000000);
        if (cyclic)
            (void)cf_cycle(c, NULL, NULL);
        now.status = al_status(c, &now.code);
        if (over || has_replied(al_control, before, now) || (settled && may_be_reply(al_control, before, now)))
            break;
        cf_poll_pause(c);
    }
    if (code)
        *code = now.code;
    return now.status;
}

uint16_t cf_request(cf_t *c, uint16_t al_control, uint16_t *code)
{
    return request(c, al_control, false, code);
}

void cf_expect_refused(cf_t *c, uint16_t al_control, uint8_t stays, uint16_t code)
{
    uint16_t got_code;
    uint16_t got = cf_request(c, al_control, &got_code);
    cf_expect_that(c, (got & 0x1F) == (stays | ECT_AL_ERROR) && got_code == code,
                   "AL control 0x%02X: expected %s with code 0x%04X, got %s with code 0x%04X", al_control,
                   cf_state_name(stays | ECT_AL_ERROR), code, cf_state_name(got), got_code);
}

void cf_expect_state(cf_t *c, uint16_t al_control, uint8_t state)
{
    uint16_t got_code;
    uint16_t got = cf_request(c, al_control, &got_code);
    cf_expect_that(c, (got & 0x1F) == state && got_code == 0,
                   "AL control 0x%02X: expected %s with code 0x0000, got %s with code 0x%04X", al_control,
                   cf_state_name(state), cf_state_name(got), got_code);
}

/* --- start-up ----------------------------------------------------------------------------------------------------- */

static void step_to(cf_t *c, uint8_t state)
{
    uint16_t code;
    uint16_t error = al_status(c, NULL) & ECT_AL_ERROR;
    if (state == CF_OP)
        (void)cf_cycle(c, NULL, NULL); /* the watchdog may have expired, and OP needs outputs */
    uint16_t got = request(c, state | error, state == CF_OP, &code);
    if ((got & 0x1F) != state)
        cf_fail(c, "on the way to %s: expected %s, got %s with code 0x%04X", cf_state_name(state), cf_state_name(state),
                cf_state_name(got), code);
}

void cf_go(cf_t *c, uint8_t state)
{
    uint8_t now = (uint8_t)(al_status(c, NULL) & ECT_AL_STATE_MASK);
    if (now == CF_BOOT || (state == CF_BOOT && now != CF_INIT)) {
        step_to(c, CF_INIT);
        now = CF_INIT;
    }
    if (now == CF_INIT && state != CF_INIT) {
        cf_set_mailbox(c, state == CF_BOOT ? CF_BOOT : CF_PREOP);
        now = state == CF_BOOT ? CF_BOOT : CF_PREOP;
        step_to(c, now);
    }
    if (now == CF_PREOP && state > CF_BOOT) {
        cf_set_process_data(c);
        step_to(c, CF_SAFEOP);
        now = CF_SAFEOP;
    }
    if (now != state || (al_status(c, NULL) & ECT_AL_ERROR) != 0)
        step_to(c, state);
}

static void back_to_init(cf_t *c)
{
    const uint8_t address[2] = {(uint8_t)c->facts.station, (uint8_t)(c->facts.station >> 8)};
    uint8_t copy[2] = {address[0], address[1]};
    uint16_t got = 0, code = 0;
    uint16_t wkc = cf_command(c, CF_APWR, c->facts.ring, ECT_REG_STATION_ADDRESS, copy, sizeof copy);
    if (wkc != 1)
        cf_fail(c, "no reply: APWR of the station address: WKC expected 1, got %u", wkc);
    bool emulation = (c->facts.has & CF_EMULATION) != 0;
    for (int tries = 0; tries < 2; tries++) { /* the second try acknowledges an error raised during the first */
        write_al_control(c, emulation ? CF_INIT : CF_INIT | ECT_AL_ACKNOWLEDGE);
        if (cf_wait_status(c, CF_INIT, init_ms(c), false, &got, &code) && code == 0)
            return;
    }
    cf_fail(c, "back to INIT: expected INIT with code 0x0000 within %u ms, got %s with code 0x%04X", init_ms(c),
            cf_state_name(got), code);
}

/* Sets registers to their values after power-on. Working counters are ignored: a chip may lack some registers. */
static void reset_registers(cf_t *c)
{
    static const struct {
        uint16_t address;
        uint8_t length;
        uint8_t value[8];
    } values[] = {
        {ECT_REG_DL_CONTROL + 3, 1, {0}},       {ECT_REG_RW_OFFSET, 2, {0}},
        {ECT_REG_ECAT_EVENT_MASK, 2, {0}},      {ECT_REG_WD_DIVIDER, 2, {0xC2, 0x09}},
        {ECT_REG_WD_TIME_PDI, 2, {0xE8, 0x03}}, {ECT_REG_WD_TIME_PD, 2, {0xE8, 0x03}},
        {ECT_REG_DC_ACTIVATION - 1, 2, {0}},    {ECT_REG_DC_SYNC0_CYCLE, 8, {0}},
        {ECT_REG_SII_CONFIG, 1, {2}},           {ECT_REG_SII_CONFIG, 1, {0}},
        {ECT_REG_SII_CONTROL, 2, {0}},
    };
    uint8_t zeros[CF_MAX_FMMUS * ECT_FMMU_SIZE] = {0};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
        (void)cf_write(c, values[i].address, values[i].value, values[i].length);
    (void)cf_write(c, ECT_REG_FMMU, zeros, (size_t)c->facts.fmmus * ECT_FMMU_SIZE);
    for (unsigned int n = 0; n < c->facts.sms;
         n++) { /* deactivate first: the other registers are write-protected while active */
        (void)cf_write(c, (uint16_t)(CF_SM(n) + ECT_SM_ACTIVATE), zeros, 1);
        (void)cf_write(c, CF_SM(n), zeros, ECT_SM_SIZE);
    }
}

void cf_known_state(cf_t *c)
{
    back_to_init(c);
    reset_registers(c);
    c->mail_counter = 0;
    c->engine->stuck = false;
}
