/* SPDX-License-Identifier: MIT */
/* The functions that the stack calls: time, process data, AL states, SDO; and the order within a step of 250 us. */
#include "devices/pmctendo/instance.h"

enum { MS_STEPS = PMC_STEPS_PER_S / 1000, MS_NS = 1000000 };

/* --- the state machine -------------------------------------------------------------------------------------------- */

static bool powered(const pmctendo_t *u)
{
    return u->action != ECT_402_OFF;
}

/* The drive closes the brake before it takes the torque from a shaft at a standstill; else the brake is late. */
static void close_brake(pmctendo_t *u)
{
    bool late = !u->ds.supplied || !pmc_standing(u);
    u->brake_ns = u->time_ns + (late ? (uint64_t)u->plant.brake_delay_ms * MS_NS : 0);
}

static void begin(pmctendo_t *u)
{
    if (u->action != ECT_402_FOLLOW && !pmc_halted(u)) {
        pmc_homing_abort(u);
        pmc_task_drop(u);
        u->task_known = u->homing.done = false;
    }
    switch (u->action) {
    case ECT_402_OFF:
        close_brake(u);
        pmc_control_off(u);
        break;
    case ECT_402_HOLD:
        pmc_hold_begin(u);
        break;
    case ECT_402_FOLLOW:
        pmc_follow_begin(u);
        break;
    case ECT_402_STOP:
        pmc_stop_begin(u);
        pmc_brake_begin(u);
        break;
    case ECT_402_RAMP:
        pmc_brake_begin(u);
        break;
    }
}

static bool supplied(const pmctendo_t *u)
{
    return u->plant.power && u->plant.enable && !u->plant.sto;
}

static void watch_supply(pmctendo_t *u)
{
    if (powered(u) && u->plant.sto)
        pmc_fault(u, PMC_F_STO);
    if (powered(u) && !u->plant.power)
        pmc_fault(u, PMC_F_UNDERVOLTAGE);
    if (u->state == ECT_402_QUICK_STOP && !pmc_stop_in_time(u))
        pmc_fault(u, PMC_F_STOP);
}

static bool can_brake(const pmctendo_t *u)
{
    return powered(u) && supplied(u) && pmc_fault_brakes(u->fault) && u->fault_option != 0 && pmc_stop_in_time(u);
}

static void read_inputs(pmctendo_t *u, uint16_t rising)
{
    watch_supply(u);
    u->ds = (ect_402_inputs_t){
        .control = u->live ? u->set.control : 0,
        .rising = rising,
        .live = u->live,
        .by_level = u->plant.status_bits == PMC_STATUS_402,
        .supplied = supplied(u),
        .fault = u->fault != 0,
        .resettable = !pmc_fault_needs_restart(u->fault),
        .can_brake = can_brake(u),
        .standing = pmc_standing(u) || !pmc_stop_waits(u),
        .stays = pmc_stop_stays(u),
        .coasts = u->disable_option == 0,
    };
}

static bool decide(pmctendo_t *u, uint16_t rising)
{
    bool reset = false;
    ect_402_action_t before = u->action;
    read_inputs(u, rising);
    ect_402_state_t next = ect_402_next(u->state, &u->ds, &reset);
    bool changed = next != u->state;
    u->state = next;
    if (reset) {
        pmc_fault_reset(u);
        u->ds.fault = false;
    }
    u->action = ect_402_action(next, &u->ds);
    if (u->action != before)
        begin(u);
    return changed;
}

/* Transitions until none is left without a new control word: an edge counts once. */
static void settle(pmctendo_t *u, uint16_t rising)
{
    while (decide(u, rising))
        rising = 0;
}

/* --- a step ------------------------------------------------------------------------------------------------------- */

static void hand_out_edges(pmctendo_t *u)
{
    for (unsigned int i = 0; i < u->edges; i++) {
        pmc_latch_edge(u, &u->edge[i]);
        pmc_homing_edge(u, &u->edge[i]);
    }
    u->edges = 0;
}

static void move(pmctendo_t *u)
{
    switch (u->action) {
    case ECT_402_FOLLOW:
        pmc_follow(u);
        break;
    case ECT_402_RAMP:
    case ECT_402_STOP:
        pmc_brake(u, pmc_stop_deceleration(u));
        break;
    default:
        break;
    }
    if (powered(u))
        pmc_control(u);
}

static bool position_is_mapped(const pmctendo_t *u)
{
    return u->assigned_outs != 0 && u->assigned_out != PMC_PDO_SPEED && u->assigned_out != PMC_PDO_TORQUE;
}

static void step(pmctendo_t *u)
{
    u->time_ns += PMC_STEP_NS;
    settle(u, 0);
    move(u);
    pmc_motor_step(u, powered(u));
    hand_out_edges(u);
    pmc_status_step(u);
    if (u->action != ECT_402_FOLLOW && !position_is_mapped(u))
        u->set.position = u->set_position =
            pmc_counts(pmc_user(u, u->plant.position)); /* set values by SDO begin at the shaft */
}

static bool resting(const pmctendo_t *u)
{
    return !powered(u) && pmc_motor_rests(u);
}

void pmc_advance(pmctendo_t *u, uint64_t now_ns)
{
    while (u->time_ns + PMC_STEP_NS <= now_ns) {
        if (resting(u))
            u->time_ns += (now_ns - u->time_ns) / PMC_STEP_NS * PMC_STEP_NS;
        else
            step(u);
    }
    settle(u, 0);
}

void pmc_read_levels(pmctendo_t *u)
{
    u->edges = 0;
    pmc_motor_levels(u);
    hand_out_edges(u);
    pmc_latch_control(u); /* shows the levels */
    settle(u, 0);
}

/* --- actual values ------------------------------------------------------------------------------------------------ */

/* 60FDh as in CiA 402: limit switches and home, then the four inputs as they are. */
static uint32_t digital_inputs(const pmctendo_t *u)
{
    uint32_t bits = (u->level[PMC_NSTOP] ? 0u : 1u) | (u->level[PMC_PSTOP] ? 0u : 2u) | (u->level[PMC_HOME] ? 4u : 0u);
    for (unsigned int line = 0; line < PMC_INPUTS; line++)
        bits |= (uint32_t)u->level[line] << (16 + line);
    return bits;
}

/* In SAFEOP and OP; below, actual values keep their last state. */
static void publish_actual(pmctendo_t *u)
{
    bool following = u->reference.loop == PMC_LOOP_POSITION && powered(u);
    double position = pmc_user(u, u->plant.position);
    double demand = following ? pmc_user(u, u->reference.position) : position;
    u->status = pmc_status(u);
    u->position = u->internal_position = pmc_counts(position);
    u->demand = pmc_counts(demand);
    u->following_error = pmc_saturated(demand - position);
    u->speed = pmc_saturated(u->plant.speed);
    u->torque = u->torque_demand = u->current = (int16_t)pmc_saturated(u->torque_now / PMC_RATED_TORQUE * 1000);
    u->inputs = digital_inputs(u);
    u->analog = u->plant.analog;
    u->feedback2 = u->plant.feedback2;
    u->mode_display = pmc_mode(u);
}

/* The display on the front: the fault, else the first warning. */
static uint16_t displayed(const pmctendo_t *u)
{
    if (u->fault != 0)
        return PMC_DISPLAYS_FAULT | u->fault;
    for (uint16_t n = 1; n <= 32; n++) {
        if ((u->warnings >> (n - 1) & 1u) != 0)
            return n;
    }
    return 0;
}

/* To the master. */
static void publish(pmctendo_t *u)
{
    pmc_warn(u, PMC_N_PSTOP, !u->level[PMC_PSTOP]);
    pmc_warn(u, PMC_N_NSTOP, !u->level[PMC_NSTOP]);
    if (u->al >= ECT_STATE_SAFEOP)
        publish_actual(u);
}

/* 60FEh sets the outputs that its mask names, 2001h the others. */
static uint8_t digital_output(const pmctendo_t *u, unsigned int number)
{
    bool masked = (u->physical[1] >> (16 + number) & 1u) != 0;
    uint32_t bits = masked ? u->physical[0] >> 16 : u->outputs;
    return u->live && (bits >> number & 1u) != 0;
}

/* Signals: a tick follows each exchange. */
static void show(pmctendo_t *u)
{
    u->state_shown = (uint16_t)u->state;
    u->display = displayed(u);
    u->position_turns = pmc_user(u, u->plant.position) / PMC_TURN;
    u->speed_rpm = u->plant.speed * 60 / PMC_TURN;
    u->torque_nm = u->torque_now;
    u->synchronised = u->sync.synchronised;
    u->homed_level = u->homed;
    u->powered = powered(u);
    u->do1 = digital_output(u, 0);
    u->do2 = digital_output(u, 1);
}

void pmc_publish(pmctendo_t *u)
{
    publish(u);
    show(u);
}

/* --- from the stack ----------------------------------------------------------------------------------------------- */

static void plant_defaults(pmc_plant_t *p)
{
    *p = (pmc_plant_t){.known = true,
                       .friction = 0.05,
                       .brake = PMC_PEAK_TORQUE,
                       .brake_delay_ms = 30,
                       .input = {0, 0, 1, 1},
                       .stop_negative = {.at = INT32_MIN},
                       .stop_positive = {.at = INT32_MAX},
                       .power = 1,
                       .enable = 1,
                       .sync_timeout_ms = 2000};
}

void pmc_init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    u->host = host;
    u->time_ns = now_ns;
    u->al = ECT_STATE_INIT;
    u->sync.op_until_ns = ECT_NEVER;
    if (!u->plant.known)
        plant_defaults(&u->plant);
    pmc_read_levels(u);
    pmc_publish(u);
}

/* The transition to SAFEOP clears a fault that needs no restart, without a control word. */
static void clear_fault(pmctendo_t *u)
{
    if (u->state != ECT_402_FAULT || pmc_fault_needs_restart(u->fault))
        return;
    pmc_fault_reset(u);
    u->state = ECT_402_SWITCH_ON_DISABLED;
}

/* The effects of a transition by itself: on the rhythm, the torque offset, a fault. */
static void enter(pmctendo_t *u, uint8_t from, uint8_t to)
{
    bool up = to > from;
    u->sync.op_until_ns = ECT_NEVER;
    if ((up && to <= ECT_STATE_SAFEOP) || to < ECT_STATE_SAFEOP)
        pmc_sync_lose(u);
    if (up && to == ECT_STATE_SAFEOP) {
        u->torque_ahead = 0;
        clear_fault(u);
    }
    u->al = to;
}

uint16_t pmc_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    pmc_advance(u, now_ns);
    if (to == ECT_STATE_OP && !u->sync.synchronised && pmc_sync_is_clocked(u)) {
        pmc_sync_wait(u, now_ns);
        return ECT_AL_PENDING;
    }
    enter(u, from, to);
    settle(u, 0);
    pmc_publish(u);
    return ECT_AL_NO_ERROR;
}

uint16_t pmc_al_error(void *instance, uint8_t state, uint16_t code, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    bool sync =
        code == ECT_AL_SYNC || code == ECT_AL_WATCHDOG || code == ECT_AL_FATAL_SYNC || code == ECT_AL_NO_OUTPUTS;
    if (sync && state == ECT_STATE_SAFEOP) {
        pmc_advance(u, now_ns);
        pmc_sync_lose(u);
        pmc_fault(u, PMC_F_SYNC);
        settle(u, 0);
        pmc_publish(u);
    }
    return pmc_al_code(u, code);
}

static void take_values(pmctendo_t *u)
{
    u->set.position = u->set_position;
    u->set.speed = u->set_speed;
    u->set.torque = u->set_torque;
    u->set.ahead = u->torque_ahead;
}

/* The control word and the set values of the outputs come into force. */
static void take(pmctendo_t *u)
{
    uint16_t rising = u->control_known ? u->control & (uint16_t)~u->set.control : 0;
    u->control_known = true;
    u->set.control = u->control;
    take_values(u);
    settle(u, rising);
    pmc_set_values(u, rising);
    if ((rising & PMC_SAVE) != 0) {
        u->saves++;
        u->host->store(u->host->ctx);
    }
}

void pmc_cyclic(void *instance, uint8_t events, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    pmc_advance(u, now_ns);
    pmc_sync_event(u, events, now_ns);
    if ((events & ECT_CYCLIC_SYNC0) != 0 && u->fresh) {
        u->fresh = false;
        take(u);
    }
    publish(u);
}

/* With SYNC0 the outputs come into force at the next one. */
void pmc_outputs(void *instance, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    pmc_advance(u, now_ns);
    u->live = true;
    u->al = ECT_STATE_OP;
    pmc_latch_control(u);
    if (u->sync_data.dc != 0)
        u->fresh = true;
    else
        take(u);
    publish(u);
}

void pmc_safe_outputs(void *instance, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    pmc_advance(u, now_ns);
    u->live = u->control_known = u->fresh = false;
    u->outputs = 0;
    settle(u, 0);
    publish(u);
}

void pmc_inputs(void *instance, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    pmc_advance(u, now_ns);
    publish(u);
}

uint64_t pmc_tick(void *instance, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    pmc_advance(u, now_ns);
    pmc_sync_due(u, now_ns);
    settle(u, 0);
    pmc_publish(u);
    uint64_t sync = pmc_sync_next(u);
    uint64_t soon = u->time_ns + (uint64_t)MS_STEPS * PMC_STEP_NS;
    return resting(u) || sync < soon ? sync : soon;
}

/* --- by mailbox --------------------------------------------------------------------------------------------------- */

/* Equal limits are off. The first write of a new pair may leave the limits crossed; then none is in force. */
static ect_reason_t check_limit(const pmctendo_t *u, uint8_t subindex, int32_t value)
{
    int32_t lower = subindex == 1 ? value : u->limit[0];
    int32_t upper = subindex == 2 ? value : u->limit[1];
    return lower <= upper || u->limit[0] == u->limit[1] ? ECT_OK : ECT_REASON_MIN_MAX;
}

static bool is_mode(int8_t mode)
{
    static const int8_t modes[] = {PMC_MODE_BY_PDO,       PMC_MODE_TASK,     PMC_MODE_SPEED_RAMP, PMC_MODE_HOMING,
                                   PMC_MODE_INTERPOLATED, PMC_MODE_POSITION, PMC_MODE_SPEED,      PMC_MODE_TORQUE};
    for (unsigned int i = 0; i < sizeof modes / sizeof modes[0]; i++) {
        if (modes[i] == mode)
            return true;
    }
    return false;
}

static bool is_known(uint16_t index, const uint8_t *data)
{
    switch (index) {
    case 0x605A:
    case 0x605B:
    case 0x605C:
    case 0x605D:
    case 0x605E:
        return pmc_stop_known(index, (int16_t)ect_load_le16(data));
    case 0x6060:
        return is_mode((int8_t)data[0]);
    case 0x607E: /* the sense of rotation is fixed, the ramps are linear */
        return data[0] == 0;
    case 0x6086:
        return ect_load_le16(data) == 0;
    case 0x6098:
        return pmc_homing_known((int8_t)data[0]);
    default:
        return true;
    }
}

ect_reason_t pmc_sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    if (size == 0 || !data)
        return ECT_OK;
    if (index == 0x607D)
        return check_limit(instance, subindex, (int32_t)ect_load_le32(data));
    return is_known(index, data) ? ECT_OK : ECT_REASON_RANGE;
}

void pmc_sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    (void)subindex;
    pmc_advance(u, now_ns);
    if (index == 0x20A4)
        pmc_latch_control(u);
    if (!u->fresh)
        take_values(u);
    publish(u);
}
