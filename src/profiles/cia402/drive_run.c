/* SPDX-License-Identifier: MIT */
/* The functions of a description: time, process data, AL states, SDO; and the sequence of a step of 250 us. */
#include "profiles/cia402/drive.h"

enum {
    STEPS_A_MS = ECT_402_STEPS_PER_S / 1000,
    LONGEST_CYCLE = ECT_402_STEPS_PER_S, /* steps in a second */
    CYCLES_WITHOUT_SYNC0 = 4,
    UNDERVOLTAGE = 0x3220,
    STO = 0x5441,
    COMMUNICATION = 0x7500,
    OVERSPEED = 0x8400,
    FOLLOWING = 0x8611,
    LIMIT_SWITCH = 0x8612,
    SYNCHRONISATION = 0x8700,
};
enum { AL_SYNC_ERROR = 0x001A, WRONG_CYCLES = 20, CYCLE_TOLERANCE = 5 /* parts of 60C2h */ };
enum { LEAVES_NOTHING, LEAVES_FAULT, LEAVES_OFF, LEAVES_QUICK_STOP }; /* 6007h */

/* --- the state machine -------------------------------------------------------------------------------------------- */

static void watch_supply(ect_402_drive_t *d)
{
    if (!ect_402_powered(&d->axis))
        return;
    if (d->around->sto)
        ect_402_drive_fault(d, STO);
    if (!d->around->power)
        ect_402_drive_fault(d, UNDERVOLTAGE);
}

static bool cause_is_gone(const ect_402_drive_t *d)
{
    return !(d->error_code == STO && d->around->sto) && !(d->error_code == UNDERVOLTAGE && !d->around->power) &&
           !ect_402_fault_restarts(d->error_code);
}

/* DRV-530. */
static bool may_reset(const ect_402_drive_t *d)
{
    enum { COMMAND_BITS = 0x0F };
    return d->around->choices.reset_needs_zero == 0 || (d->axis.set.control & COMMAND_BITS) == 0;
}

static void settle(ect_402_drive_t *d, uint16_t rising)
{
    const ect_402_surroundings_t *s = d->around;
    watch_supply(d);
    d->axis.conditions = (ect_402_conditions_t){
        .supplied = s->power && s->enable && !s->sto,
        .fault = d->error_code != 0,
        .resettable = cause_is_gone(d) && may_reset(d),
        .fault_brakes = d->error_code == 0 || ect_402_fault_brakes(d->error_code),
        .by_level = true,
    };
    ect_402_settle(&d->axis, rising);
    if (d->axis.was_reset)
        ect_402_drive_fault_reset(d);
    d->axis.was_reset = false;
}

/* --- a step ------------------------------------------------------------------------------------------------------- */

/* @return whether the shaft moves further into a limit switch */
static bool hits_switch(const ect_402_axis_t *a)
{
    double speed = a->plant->speed;
    bool into = (speed > 0 && !a->level[ECT_402_POSITIVE]) || (speed < 0 && !a->level[ECT_402_NEGATIVE]);
    return into && a->state == ECT_402_OPERATION_ENABLED && !a->homing.active;
}

static void raise_faults(ect_402_drive_t *d)
{
    const ect_402_choices_t *c = &d->around->choices;
    if (c->switch_faults != 0 && hits_switch(&d->axis))
        ect_402_drive_fault(d, LIMIT_SWITCH);
    if ((d->axis.troubles & ECT_402_LATE) != 0 && c->following_warns == 0)
        ect_402_drive_fault(d, FOLLOWING);
    if ((d->axis.troubles & ECT_402_OVERSPEED) != 0)
        ect_402_drive_fault(d, OVERSPEED);
    d->axis.troubles = 0;
}

static void step(ect_402_drive_t *d)
{
    d->axis.time_ns += ECT_402_STEP_NS;
    settle(d, 0);
    ect_402_step(&d->axis);
    ect_402_drive_probe_edges(d);
    raise_faults(d);
}

void ect_402_drive_advance(ect_402_drive_t *d, uint64_t now_ns)
{
    while (d->axis.time_ns + ECT_402_STEP_NS <= now_ns) {
        if (ect_402_rests(&d->axis))
            d->axis.time_ns += (now_ns - d->axis.time_ns) / ECT_402_STEP_NS * ECT_402_STEP_NS;
        else
            step(d);
    }
    settle(d, 0);
}

uint64_t ect_402_drive_next(const ect_402_drive_t *d)
{
    return ect_402_rests(&d->axis) ? ECT_NEVER : d->axis.time_ns + (uint64_t)STEPS_A_MS * ECT_402_STEP_NS;
}

/* --- power-on ----------------------------------------------------------------------------------------------------- */

static void surroundings(ect_402_drive_t *d)
{
    ect_402_surroundings_t *s = d->around;
    if (s->known)
        return;
    s->known = true;
    s->power = s->enable = 1;
    s->machine = (ect_402_plant_t){.friction = d->config.rated_torque / 60,
                                   .brake_delay_ms = 30,
                                   .input = {0, 0, 1, 1},
                                   .stop_negative = {.at = INT32_MIN},
                                   .stop_positive = {.at = INT32_MAX}};
}

/* Sets the supported modes: those of the file's 6502h for which the objects exist; 0 counts as absent. The master reads
 * the modes that 6060h accepts, and those of the manufacturer, which have no behaviour. */
static void find_modes(ect_402_drive_t *d)
{
    enum { MANUFACTURER = 0xFFFF0000 };
    const ect_402_link_t *link = &d->links[ECT_402_V_MODES];
    uint32_t said = (uint32_t)ect_402_load(d->instance, link);
    d->modes = ect_402_modes_of(d->links);
    if ((said & d->modes) != 0)
        d->modes &= said;
    ect_402_store(d->instance, link, (said & d->modes) != 0 ? (said & MANUFACTURER) | d->modes : d->modes);
}

void ect_402_drive_init(ect_402_drive_t *d, const ect_402_link_t *links, ect_402_surroundings_t *around, void *instance,
                        const ect_host_t *host, uint64_t now_ns)
{
    d->links = links;
    d->around = around;
    d->instance = instance;
    d->host = host;
    d->config.coasts = d->config.cyclic_is_free = d->config.ip_waits = d->config.torque_releases = true;
    d->axis.config = &d->config;
    d->axis.plant = &around->machine;
    d->axis.time_ns = now_ns;
    ect_402_drive_read(d, true);
    ect_402_drive_defaults(d);
    ect_402_drive_read(d, true);
    surroundings(d);
    find_modes(d);
    ect_402_drive_set_values(d);
    ect_402_drive_touched(d);
}

/* --- values for the master, and for users ------------------------------------------------------------------------- */

void ect_402_drive_publish(ect_402_drive_t *d)
{
    const ect_402_axis_t *a = &d->axis;
    ect_402_drive_actual(d);
    d->state_shown = (uint16_t)a->state;
    d->mode_shown = a->mode;
    d->powered = ect_402_powered(a);
    d->homed = a->homed;
    d->position_turns = ect_402_user(a, d->around->machine.position) / d->config.turn;
    d->speed_rpm = d->around->machine.speed * 60 / d->config.turn;
    d->torque_nm = a->torque_now;
}

void ect_402_drive_touched(ect_402_drive_t *d)
{
    ect_402_plant_t *m = &d->around->machine;
    m->stop_positive.fitted = m->stop_positive.at != INT32_MAX;
    m->stop_negative.fitted = m->stop_negative.at != INT32_MIN;
    ect_402_drive_read(d, true);
    ect_402_read_levels(&d->axis);
    ect_402_drive_probe_edges(d);
    settle(d, 0);
    ect_402_drive_publish(d);
}

/* --- outputs ------------------------------------------------------------------------------------------------------ */

static uint64_t written_cycle(const ect_402_drive_t *d)
{
    int64_t units = d->value[ECT_402_V_CYCLE_UNITS];
    return d->cycle_written ? ect_402_drive_cycle_ns(units, d->value[ECT_402_V_CYCLE_POWER]) : 0;
}

/* @return the time from one set position to the next: 60C2h of the master, else the distance of the last two */
static uint32_t cycle_steps(const ect_402_drive_t *d, uint64_t now_ns)
{
    uint64_t ns = written_cycle(d);
    if (ns == 0 && d->outputs_ns != 0)
        ns = now_ns - d->outputs_ns;
    uint64_t steps = (ns + ECT_402_STEP_NS / 2) / ECT_402_STEP_NS;
    return steps < 1 ? 1 : steps > LONGEST_CYCLE ? 1 : (uint32_t)steps;
}

static void take(ect_402_drive_t *d, uint64_t now_ns)
{
    ect_402_axis_t *a = &d->axis;
    uint16_t control = (uint16_t)d->value[ECT_402_V_CONTROL];
    uint16_t rising = d->control_known ? control & (uint16_t)~a->set.control : 0;
    d->control_known = true;
    a->set.control = control;
    a->cycle_steps = cycle_steps(d, now_ns);
    d->outputs_ns = now_ns;
    ect_402_drive_set_values(d);
    settle(d, rising);
    ect_402_set_values(a, rising);
}

static bool sync0_runs(const ect_402_drive_t *d, uint64_t now_ns)
{
    uint64_t cycle = (uint64_t)d->axis.cycle_steps * ECT_402_STEP_NS;
    return d->sync0_ns != 0 && now_ns - d->sync0_ns <= CYCLES_WITHOUT_SYNC0 * cycle;
}

/* Compares 60C2h with the distance of SYNC0 or, without SYNC0, of frames (DRV-159). */
static void check_cycle(ect_402_drive_t *d, uint64_t before_ns, uint64_t now_ns)
{
    uint64_t want = written_cycle(d);
    uint64_t got = now_ns - before_ns;
    uint64_t off = got > want ? got - want : want - got;
    bool checked = d->around->choices.sync_check != 0 && want != 0 && before_ns != 0 && d->axis.mode >= ECT_402_IP;
    d->wrong_cycles = checked && off > want / CYCLE_TOLERANCE ? (uint8_t)(d->wrong_cycles + 1) : 0;
    if (d->wrong_cycles < WRONG_CYCLES)
        return;
    d->wrong_cycles = 0;
    ect_402_drive_fault(d, SYNCHRONISATION);
    settle(d, 0);
    d->host->drop(d->host->ctx, ECT_STATE_SAFEOP, AL_SYNC_ERROR);
}

void ect_402_drive_outputs(ect_402_drive_t *d, uint64_t now_ns)
{
    uint64_t before_ns = d->outputs_ns;
    d->axis.live = true;
    ect_402_drive_read(d, false);
    if (sync0_runs(d, now_ns)) {
        d->fresh = true;
        return;
    }
    take(d, now_ns);
    check_cycle(d, before_ns, now_ns);
}

void ect_402_drive_sync0(ect_402_drive_t *d, uint64_t now_ns)
{
    uint64_t before_ns = d->sync0_ns;
    d->sync0_ns = now_ns;
    if (d->fresh)
        take(d, now_ns);
    d->fresh = false;
    check_cycle(d, before_ns, now_ns);
}

/* --- AL states ---------------------------------------------------------------------------------------------------- */

void ect_402_drive_enter_op(ect_402_drive_t *d, uint64_t now_ns)
{
    (void)now_ns;
    d->al = ECT_STATE_OP;
    d->control_known = false;
    d->sync0_ns = d->outputs_ns = 0;
    d->wrong_cycles = 0;
    ect_402_drive_read(d, true);
}

void ect_402_drive_below_op(ect_402_drive_t *d, uint8_t al)
{
    d->al = al;
    if (al != ECT_STATE_INIT && al != ECT_STATE_BOOT)
        return;
    d->axis.live = false; /* the last control word came by mailbox */
    settle(d, 0);
}

/* Applies 6007h at an end of OP with torque (DRV-155, DRV-156). */
static void lose_op(ect_402_drive_t *d)
{
    int64_t how = d->links[ECT_402_V_ABORT_OPTION].bytes != 0 ? d->value[ECT_402_V_ABORT_OPTION] : LEAVES_FAULT;
    bool moving = d->axis.state == ECT_402_OPERATION_ENABLED || d->axis.state == ECT_402_QUICK_STOP;
    if (!moving || how == LEAVES_QUICK_STOP)
        return;
    if (how == LEAVES_FAULT)
        ect_402_drive_fault(d, COMMUNICATION);
    else
        d->axis.state = ECT_402_SWITCH_ON_DISABLED;
}

/* Restores settings after the end of OP, which sets mappable entries to their defaults; digital outputs and touch
 * probes keep the defaults. */
static void keep_settings(ect_402_drive_t *d)
{
    for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++) {
        const ect_402_object_t *object = ect_402_object((ect_402_value_t)i);
        bool setting = object->kind == ECT_402_SETTING || object->kind == ECT_402_LIMIT;
        bool acts = i == ECT_402_V_OUTPUTS || i == ECT_402_V_OUTPUT_MASK || i == ECT_402_V_PROBE;
        if (setting && !acts && d->links[i].output && !d->links[i].is_real)
            ect_402_store(d->instance, &d->links[i], d->value[i]);
    }
}

void ect_402_drive_leave_op(ect_402_drive_t *d, uint64_t now_ns)
{
    ect_402_drive_advance(d, now_ns);
    d->al = ECT_STATE_SAFEOP;
    if (d->axis.live)
        lose_op(d);
    d->axis.live = d->control_known = d->fresh = false;
    keep_settings(d);
    ect_402_drive_defaults(d);
    ect_402_drive_read(d, true);
    settle(d, 0);
    ect_402_drive_publish(d);
}

/* --- by mailbox --------------------------------------------------------------------------------------------------- */

/* Takes a control word below OP. A command that leads beyond Ready is replaced by the previous one (DRV-154).
 */
static void take_below_op(ect_402_drive_t *d)
{
    ect_402_axis_t *a = &d->axis;
    uint16_t control = (uint16_t)d->value[ECT_402_V_CONTROL];
    if (ect_402_command(control, true) > ECT_402_SHUTDOWN)
        control = (control & ECT_402_RESET) | (a->set.control & (uint16_t)~ECT_402_RESET);
    uint16_t rising = d->control_known ? control & (uint16_t)~a->set.control : 0;
    d->control_known = true;
    a->set.control = control;
    a->live = true;
    settle(d, rising);
}

void ect_402_drive_written(ect_402_drive_t *d, ect_402_value_t value, uint64_t now_ns)
{
    ect_402_drive_advance(d, now_ns);
    ect_402_drive_read(d, true);
    d->cycle_written = d->cycle_written || value == ECT_402_V_CYCLE_UNITS;
    bool by_sdo = ect_402_object(value)->kind == ECT_402_COMMAND && !d->fresh;
    if (by_sdo && d->al == ECT_STATE_OP) {
        d->axis.live = true;
        take(d, now_ns);
    } else if (by_sdo) {
        ect_402_drive_set_values(d);
        if (value == ECT_402_V_CONTROL)
            take_below_op(d);
    }
    ect_402_drive_publish(d);
}
