/* SPDX-License-Identifier: MIT */
/* Execution of the state machine: checks before a transition, actions with it, and transitions caused by errors. */
#include "slave/al.h"
#include "slave/internal.h"

static bool has_mailbox(const ect_slave_t *s)
{
    return s->config.device->mailbox_protocols != 0;
}

/* SyncManagers are disabled before the state is reported. The code is written before the state, so that a fast master
 * that reads the error flag finds its code (ETG.1000.6 §6.4.1.3). */
bool ect_machine_report(ect_slave_t *s)
{
    uint8_t code[2];
    uint8_t status[2] = {s->state, 0};
    ECT_ASSERT(s->error == (s->code != ECT_AL_NO_ERROR));
    ECT_ASSERT(!s->ident || !s->error);
    ect_store_le16(code, s->ident ? s->config.device_id : s->code);
    status[0] |= s->error ? ECT_AL_ERROR : 0;
    status[0] |= s->ident ? ECT_AL_IDENT : 0;
    (void)ect_sm_flush(s);
    (void)ect_slave_write(s, ECT_REG_AL_STATUS_CODE, code, sizeof code);
    if (!ect_slave_write(s, ECT_REG_AL_STATUS, status, sizeof status)) /* no access if an earlier one failed */
        return false;
    s->status_dirty = false;
    return true;
}

/* Code 0 clears the error. */
static void set_error(ect_slave_t *s, uint16_t code, ect_error_cause_t cause)
{
    const ect_device_t *device = s->config.device;
    ECT_ASSERT((code == ECT_AL_NO_ERROR) == (cause == ECT_CAUSE_NONE));
    s->error = code != ECT_AL_NO_ERROR;
    s->cause = (uint8_t)cause;
    s->ident = false;
    s->code = device->al_error ? device->al_error(s->config.instance, s->state, code, s->now_ns) : code;
    s->status_dirty = true;
}

static void outputs_off(ect_slave_t *s)
{
    ECT_ASSERT(!s->outputs_live || s->state == ECT_STATE_OP);
    const ect_device_t *device = s->config.device;
    if (s->outputs_live && device->safe_outputs)
        device->safe_outputs(s->config.instance, s->now_ns);
    s->outputs_live = false;
    s->outputs_seen = 0;
}

/* Calls the device: 0, ECT_AL_PENDING, or an AL status code. */
static uint16_t notify_device(ect_slave_t *s, uint8_t from, uint8_t to)
{
    ECT_ASSERT(from != to);
    const ect_device_t *device = s->config.device;
    return device->state_change ? device->state_change(s->config.instance, from, to, s->now_ns)
                                : (uint16_t)ECT_AL_NO_ERROR;
}

/* A transition downwards cannot be refused. */
static void go_down(ect_slave_t *s, uint8_t target)
{
    uint8_t from = s->state;
    ECT_ASSERT(target < from);
    outputs_off(s);
    if (target < ECT_STATE_SAFEOP && from >= ECT_STATE_SAFEOP) {
        s->inputs_due = false;
        ect_sm_disable(s, ect_sm_process(s->config.device));
    }
    if (target == ECT_STATE_INIT && has_mailbox(s)) {
        ect_mailbox_stop(s);
        ect_sm_disable(s, ECT_MAILBOX_SMS);
    }
    s->pending = 0;
    s->state = target;
    s->status_dirty = true;
    (void)notify_device(s, from, target);
    ect_slave_wake(s);
}

void ect_machine_drop(ect_slave_t *s, uint8_t state, uint16_t code, ect_error_cause_t cause)
{
    go_down(s, state);
    set_error(s, code, cause);
}

/* --- upwards ---------------------------------------------------------------------------------------------------- */

static uint16_t check_mailbox(ect_slave_t *s, uint8_t target, const uint8_t *block)
{
    ECT_ASSERT(!s->mailbox.running && s->state == ECT_STATE_INIT);
    bool boot = target == ECT_STATE_BOOT;
    if (!ect_sm_mailbox_good(s->config.device, block, boot))
        return boot ? ECT_AL_BOOT_MAILBOX : ECT_AL_MAILBOX;
    ect_mailbox_configure(s, block);
    return ECT_AL_NO_ERROR;
}

static uint16_t check_process_data(ect_slave_t *s, const uint8_t *block)
{
    ECT_ASSERT(s->state == ECT_STATE_PREOP && !s->outputs_live);
    uint8_t cyclic_unit = 0;
    uint16_t code = ect_pdo_configure(s);
    if (code == ECT_AL_NO_ERROR)
        code = ect_sm_check_process(s, block);
    if (code != ECT_AL_NO_ERROR)
        return code;
    if (s->config.device->dc_mode_count == 0 && ect_slave_read(s, ECT_REG_DC_ACTIVATION, &cyclic_unit, 1) &&
        (cyclic_unit & 1u) != 0)
        return ECT_AL_DC_SYNC;
    return ECT_AL_NO_ERROR;
}

static uint16_t check_up(ect_slave_t *s, uint8_t target)
{
    uint8_t block[ECT_SM_BLOCK];
    if (target == ECT_STATE_OP || !ect_sm_read(s, block))
        return ECT_AL_NO_ERROR;
    if (target != ECT_STATE_SAFEOP)
        return has_mailbox(s) ? check_mailbox(s, target, block) : (uint16_t)ECT_AL_NO_ERROR;
    if (s->mailbox.running && !ect_mailbox_check(s, block))
        s->due |= ECT_EVENT_SM_CHANGED; /* its registers must be read as well */
    return check_process_data(s, block);
}

static uint16_t check_all(ect_slave_t *s, uint8_t target)
{
    uint16_t code = check_up(s, target);
    return code == ECT_AL_NO_ERROR && !s->failed ? ect_services_check_up(s, target) : code;
}

static uint64_t timeout_ns(const ect_slave_t *s, uint8_t target)
{
    const ect_timeouts_t *t = &s->config.device->timeouts;
    return 1000000ull * (target < ECT_STATE_SAFEOP ? t->preop_ms : t->safeop_op_ms);
}

/* Starts everything that must run before the new state is reported. */
static void enter(ect_slave_t *s, uint8_t target)
{
    ECT_ASSERT(target < ECT_STATE_SAFEOP || !has_mailbox(s) || s->mailbox.running);
    if (target == ECT_STATE_PREOP || target == ECT_STATE_BOOT) {
        if (has_mailbox(s)) {
            ect_mailbox_start(s);
            ect_sm_enable(s, ECT_MAILBOX_SMS);
        }
    } else if (target == ECT_STATE_SAFEOP) {
        s->outputs_seen = 0;
        ect_sm_enable(s, ect_sm_process(s->config.device));
        if (ect_sm_flush(s) && ect_pdo_inputs(s))
            s->inputs_due = false;
    } else {
        if (s->outputs != 0)
            ect_pdo_outputs(s, s->outputs, true);
        s->outputs_live = !s->failed;
    }
}

/* After a failed PDI access the request remains due: the next poll starts it again. */
static void finish_up(ect_slave_t *s, uint8_t target, uint16_t code)
{
    ECT_ASSERT(target > s->state && !s->outputs_live);
    if (code == ECT_AL_NO_ERROR && !s->failed)
        enter(s, target);
    if (s->failed)
        return;
    s->pending = 0;
    if (code != ECT_AL_NO_ERROR) {
        set_error(s, code, ECT_CAUSE_REQUEST);
        return;
    }
    s->state = target;
    s->status_dirty = true;
}

static void wait_for(ect_slave_t *s, uint8_t target, bool device)
{
    ECT_ASSERT(target > s->state);
    s->pending = target;
    s->pending_device = device;
    s->pending_until_ns = s->now_ns + timeout_ns(s, target);
}

/* The device and the checks agree; only the first outputs may be missing. */
static void agree(ect_slave_t *s, uint8_t target, uint16_t code)
{
    ECT_ASSERT(target > s->state);
    bool outputs_missing = target == ECT_STATE_OP && s->outputs_seen != s->outputs;
    if (code == ECT_AL_NO_ERROR && outputs_missing)
        wait_for(s, target, false);
    else
        finish_up(s, target, code);
}

static void go_up(ect_slave_t *s, uint8_t target)
{
    ECT_ASSERT(target > s->state);
    s->pending = 0;
    s->pending_done = false;
    uint16_t code = check_all(s, target);
    if (s->failed)
        return;
    if (code == ECT_AL_NO_ERROR)
        code = notify_device(s, s->state, target);
    if (code == ECT_AL_PENDING)
        wait_for(s, target, true);
    else
        agree(s, target, code);
}

/* A delayed transition ends by the device, by the first outputs, or by the timeout of the description. The conditions
 * that were checked may have changed since. */
void ect_machine_pending(ect_slave_t *s)
{
    uint8_t target = s->pending;
    ECT_ASSERT(target > s->state);
    if (s->pending_device && s->pending_done) {
        s->pending_done = false;
        agree(s, target, s->pending_result != ECT_AL_NO_ERROR ? s->pending_result : check_all(s, target));
    } else if (!s->pending_device && s->outputs_seen == s->outputs) {
        finish_up(s, target, ECT_AL_NO_ERROR);
    } else if (s->now_ns >= s->pending_until_ns) {
        finish_up(s, target, s->pending_device ? ECT_AL_UNSPECIFIED : ECT_AL_NO_OUTPUTS);
    }
}

/* --- actions of the master -------------------------------------------------------------------------------------- */

static void identification(ect_slave_t *s, bool wanted)
{
    bool given = wanted && s->config.device_id != 0 && !s->error && s->pending == 0 && s->state != ECT_STATE_BOOT;
    if (given != s->ident) {
        s->ident = given;
        s->status_dirty = true;
    }
}

void ect_machine_al_control(ect_slave_t *s)
{
    uint8_t bytes[2];
    if (!ect_slave_read(s, ECT_REG_AL_CONTROL, bytes, sizeof bytes))
        return;
    s->due &= ~(uint32_t)ECT_EVENT_AL_CONTROL;
    s->request = ect_load_le16(bytes);
    s->request_due = true;
}

void ect_machine_request(ect_slave_t *s)
{
    uint16_t request = s->request;
    ect_slave_requested(s, 0);
    bool has_boot = s->config.device->boot_out.length > 0;
    ect_al_decision_t d = ect_al_decide(s->state, s->error, request, has_boot);
    ECT_ASSERT(d.action != ECT_AL_REFUSE || d.code != ECT_AL_NO_ERROR);
    if (d.clear_error)
        set_error(s, ECT_AL_NO_ERROR, ECT_CAUSE_NONE);
    switch (d.action) {
    case ECT_AL_REFUSE:
        s->pending = 0;
        set_error(s, d.code, ECT_CAUSE_REQUEST);
        break;
    case ECT_AL_UP:
        if (s->pending != d.target)
            go_up(s, d.target); /* on a repeated request a delayed transition continues */
        break;
    case ECT_AL_DOWN:
        go_down(s, d.target);
        break;
    case ECT_AL_STAY:
        s->pending = 0;
        s->status_dirty = true;
        break;
    case ECT_AL_IGNORE:
        break;
    }
    identification(s, (request & ECT_AL_IDENT) != 0);
    s->request_due = s->failed;
}

void ect_machine_sm_changed(ect_slave_t *s)
{
    uint8_t block[ECT_SM_BLOCK];
    if (!ect_sm_read(s, block))
        return;
    if (s->mailbox.running && !ect_mailbox_check(s, block)) {
        uint16_t code = s->state == ECT_STATE_BOOT ? ECT_AL_BOOT_MAILBOX : ECT_AL_MAILBOX;
        ect_machine_drop(s, ECT_STATE_INIT, code, ECT_CAUSE_REQUEST);
        return;
    }
    if (s->state >= ECT_STATE_SAFEOP) {
        uint16_t code = ect_sm_check_process(s, block);
        if (code != ECT_AL_NO_ERROR)
            ect_machine_drop(s, ECT_STATE_PREOP, code, ECT_CAUSE_REQUEST);
        s->inputs_due = true; /* the SyncManager was disabled and enabled: its buffers are empty */
    }
}

void ect_machine_watchdog(ect_slave_t *s)
{
    uint8_t status[2];
    if (!ect_slave_read(s, ECT_REG_WD_STATUS_PD, status, sizeof status))
        return;
    s->due &= ~(uint32_t)ECT_EVENT_WATCHDOG;
    if ((status[0] & 1u) != 0 || s->outputs == 0)
        return;
    s->outputs_seen = 0; /* outputs from before do not permit OP */
    if (s->state == ECT_STATE_OP)
        ect_machine_drop(s, ECT_STATE_SAFEOP, ECT_AL_WATCHDOG, ECT_CAUSE_WATCHDOG);
}
