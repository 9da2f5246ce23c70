/* SPDX-License-Identifier: MIT */
/* The functions called by the stack: time, process data, AL states, SDO; and the sequence of a step of 250 us. */
#include "devices/pmctendo/instance.h"

enum { MS_STEPS = ECT_402_STEPS_PER_S / 1000 };

static const ect_402_config_t config = {.turn = PMC_TURN,
                                        .rated_torque = 3.0,
                                        .peak_torque = 9.0,
                                        .inertia = 3e-4,
                                        .reference_bit = PMC_REFERENCE,
                                        .cyclic_halts = true,
                                        .overspeed_at_once = true};

static int8_t mode(const pmctendo_t *u)
{
    if (u->mode != PMC_MODE_BY_PDO)
        return u->mode;
    switch (u->assigned_out) {
    case PMC_PDO_SPEED:
        return PMC_MODE_SPEED;
    case PMC_PDO_TORQUE:
        return PMC_MODE_TORQUE;
    default:
        return PMC_MODE_POSITION;
    }
}

/* Reads the objects that the axis does not read itself. */
static void refresh(pmctendo_t *u)
{
    u->axis.mode = mode(u);
    u->axis.cycle_steps = pmc_cycle_steps(u);
}

/* --- the state machine -------------------------------------------------------------------------------------------- */

static void watch_supply(pmctendo_t *u)
{
    bool on = ect_402_powered(&u->axis);
    if (on && u->plant.sto)
        pmc_fault(u, PMC_F_STO);
    if (on && !u->plant.power)
        pmc_fault(u, PMC_F_UNDERVOLTAGE);
    if (u->axis.state == ECT_402_QUICK_STOP && !ect_402_stop_in_time(&u->axis))
        pmc_fault(u, PMC_F_STOP);
}

static void settle(pmctendo_t *u, uint16_t rising)
{
    watch_supply(u);
    u->axis.conditions = (ect_402_conditions_t){
        .supplied = u->plant.power && u->plant.enable && !u->plant.sto,
        .fault = u->fault != 0,
        .resettable = !pmc_fault_needs_restart(u->fault),
        .fault_brakes = pmc_fault_brakes(u->fault),
        .by_level = u->plant.status_bits == PMC_STATUS_402,
    };
    ect_402_settle(&u->axis, rising);
    if (u->axis.was_reset)
        pmc_fault_reset(u);
    u->axis.was_reset = false;
}

/* --- a step ------------------------------------------------------------------------------------------------------- */

static void latch_edges(pmctendo_t *u)
{
    for (unsigned int i = 0; i < u->axis.edges; i++)
        pmc_latch_edge(u, &u->axis.edge[i]);
}

static void raise_faults(pmctendo_t *u)
{
    if ((u->axis.troubles & ECT_402_LATE) != 0)
        pmc_fault(u, PMC_F_FOLLOWING);
    if ((u->axis.troubles & ECT_402_OVERSPEED) != 0)
        pmc_fault(u, PMC_F_OVERSPEED);
    u->axis.troubles = 0;
}

static bool position_is_mapped(const pmctendo_t *u)
{
    return u->assigned_outs != 0 && u->assigned_out != PMC_PDO_SPEED && u->assigned_out != PMC_PDO_TORQUE;
}

static void step(pmctendo_t *u)
{
    u->axis.time_ns += PMC_STEP_NS;
    refresh(u);
    settle(u, 0);
    ect_402_step(&u->axis);
    raise_faults(u);
    latch_edges(u);
    if (u->axis.action != ECT_402_FOLLOW && !position_is_mapped(u))
        u->axis.set.position = u->set_position = ect_402_counts(
            ect_402_user(&u->axis, u->plant.machine.position)); /* set values by SDO begin at the shaft */
}

void pmc_advance(pmctendo_t *u, uint64_t now_ns)
{
    while (u->axis.time_ns + PMC_STEP_NS <= now_ns) {
        if (ect_402_rests(&u->axis))
            u->axis.time_ns += (now_ns - u->axis.time_ns) / PMC_STEP_NS * PMC_STEP_NS;
        else
            step(u);
    }
    settle(u, 0);
}

void pmc_read_levels(pmctendo_t *u)
{
    ect_402_read_levels(&u->axis);
    latch_edges(u);
    pmc_latch_control(u); /* updates the levels */
    settle(u, 0);
}

/* --- actual values ------------------------------------------------------------------------------------------------ */

/* @return 60FDh as in CiA 402: limit switches and home, then the unchanged levels of the four inputs */
static uint32_t digital_inputs(const pmctendo_t *u)
{
    uint32_t bits = (u->axis.level[PMC_NSTOP] ? 0u : 1u) | (u->axis.level[PMC_PSTOP] ? 0u : 2u) |
                    (u->axis.level[PMC_HOME] ? 4u : 0u);
    for (unsigned int line = 0; line < ECT_402_INPUTS; line++)
        bits |= (uint32_t)u->axis.level[line] << (16 + line);
    return bits;
}

/* Updates actual values in SAFEOP and OP; below, they keep their last state. */
static void publish_actual(pmctendo_t *u)
{
    bool following = u->axis.reference.loop == ECT_402_LOOP_POSITION && ect_402_powered(&u->axis);
    double position = ect_402_user(&u->axis, u->plant.machine.position);
    double demand = following ? ect_402_user(&u->axis, u->axis.reference.position) : position;
    u->status = pmc_status(u);
    u->position = u->internal_position = ect_402_counts(position);
    u->demand = ect_402_counts(demand);
    u->following_error = ect_402_saturated(demand - position);
    u->speed = ect_402_saturated(u->plant.machine.speed);
    u->torque = u->torque_demand = u->current =
        (int16_t)ect_402_saturated(u->axis.torque_now / config.rated_torque * 1000);
    u->inputs = digital_inputs(u);
    u->analog = u->plant.analog;
    u->feedback2 = u->plant.feedback2;
    u->mode_display = u->axis.mode;
}

/* @return the display on the front: the fault, else the first warning */
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

/* Updates the values for the master. */
static void publish(pmctendo_t *u)
{
    refresh(u);
    pmc_warn(u, PMC_N_SOFT_NEGATIVE, u->axis.limit_negative);
    pmc_warn(u, PMC_N_SOFT_POSITIVE, u->axis.limit_positive);
    pmc_warn(u, PMC_N_PSTOP, !u->axis.level[PMC_PSTOP]);
    pmc_warn(u, PMC_N_NSTOP, !u->axis.level[PMC_NSTOP]);
    if (u->al >= ECT_STATE_SAFEOP)
        publish_actual(u);
}

/* Sets the outputs: by 60FEh where its mask permits, the others by 2001h. */
static uint8_t digital_output(const pmctendo_t *u, unsigned int number)
{
    bool masked = (u->axis.physical[1] >> (16 + number) & 1u) != 0;
    uint32_t bits = masked ? u->axis.physical[0] >> 16 : u->outputs;
    return u->axis.live && (bits >> number & 1u) != 0;
}

/* Updates the signals; a tick follows each exchange. */
static void show(pmctendo_t *u)
{
    u->state_shown = (uint16_t)u->axis.state;
    u->display = displayed(u);
    u->position_turns = ect_402_user(&u->axis, u->plant.machine.position) / PMC_TURN;
    u->speed_rpm = u->plant.machine.speed * 60 / PMC_TURN;
    u->torque_nm = u->axis.torque_now;
    u->synchronised = u->sync.synchronised;
    u->homed_level = u->axis.homed;
    u->powered = ect_402_powered(&u->axis);
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
                       .machine = {.friction = 0.05,
                                   .brake = config.peak_torque,
                                   .brake_delay_ms = 30,
                                   .input = {0, 0, 1, 1},
                                   .stop_negative = {.at = INT32_MIN},
                                   .stop_positive = {.at = INT32_MAX}},
                       .power = 1,
                       .enable = 1,
                       .sync_timeout_ms = 2000};
}

void pmc_init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    u->host = host;
    u->axis.config = &config;
    u->axis.plant = &u->plant.machine;
    u->axis.time_ns = now_ns;
    u->al = ECT_STATE_INIT;
    u->sync.op_until_ns = ECT_NEVER;
    if (!u->plant.known)
        plant_defaults(&u->plant);
    pmc_read_levels(u);
    pmc_publish(u);
}

/* Clears a fault that needs no restart at the transition to SAFEOP, without a control word. */
static void clear_fault(pmctendo_t *u)
{
    if (u->axis.state != ECT_402_FAULT || pmc_fault_needs_restart(u->fault))
        return;
    pmc_fault_reset(u);
    u->axis.state = ECT_402_SWITCH_ON_DISABLED;
}

/* Applies the effects of a transition on the rhythm, the torque offset and a fault. */
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
    u->axis.set.position = u->set_position;
    u->axis.set.speed = u->set_speed;
    u->axis.set.torque = u->set_torque;
    u->axis.set.ahead = u->torque_ahead;
}

/* Applies the control word and the set values of the outputs. */
static void take(pmctendo_t *u)
{
    uint16_t rising = u->control_known ? u->control & (uint16_t)~u->axis.set.control : 0;
    u->control_known = true;
    u->axis.set.control = u->control;
    take_values(u);
    refresh(u);
    settle(u, rising);
    ect_402_set_values(&u->axis, rising);
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

/* Takes the outputs, which with SYNC0 take effect at the next SYNC0. */
void pmc_outputs(void *instance, uint64_t now_ns)
{
    pmctendo_t *u = instance;
    pmc_advance(u, now_ns);
    u->axis.live = true;
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
    u->axis.live = u->control_known = u->fresh = false;
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
    uint64_t soon = u->axis.time_ns + (uint64_t)MS_STEPS * PMC_STEP_NS;
    return ect_402_rests(&u->axis) || sync < soon ? sync : soon;
}

/* --- by mailbox --------------------------------------------------------------------------------------------------- */

/* Equal limits are off. Limits that are crossed after the first write of a new pair have no effect. */
static ect_reason_t check_limit(const pmctendo_t *u, uint8_t subindex, int32_t value)
{
    int32_t lower = subindex == 1 ? value : u->axis.limit[0];
    int32_t upper = subindex == 2 ? value : u->axis.limit[1];
    return lower <= upper || u->axis.limit[0] == u->axis.limit[1] ? ECT_OK : ECT_REASON_MIN_MAX;
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

/* The manual has no stop at the current or voltage limit: 3, 4, 7, 8. */
static bool is_quick_option(int option)
{
    return ect_402_stop_known(0x605A, option) && (option == 0 || option % 4 == 1 || option % 4 == 2);
}

/* The manual has no search that turns at a limit switch. */
static bool is_method(int8_t method)
{
    return ect_402_homing_known(method) && !(method >= 7 && method <= 14) && !(method >= 23 && method <= 30);
}

static bool is_known(uint16_t index, const uint8_t *data)
{
    switch (index) {
    case 0x605A:
        return is_quick_option((int16_t)ect_load_le16(data));
    case 0x605B:
    case 0x605C:
    case 0x605D:
    case 0x605E:
        return ect_402_stop_known(index, (int16_t)ect_load_le16(data));
    case 0x6060:
        return is_mode((int8_t)data[0]);
    case 0x607E: /* the sense of rotation is fixed, the ramps are linear */
        return data[0] == 0;
    case 0x6086:
        return ect_load_le16(data) == 0;
    case 0x6098:
        return is_method((int8_t)data[0]);
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
    refresh(u);
    (void)ect_402_take_mode(&u->axis);
    if (index == 0x20A4)
        pmc_latch_control(u);
    if (!u->fresh)
        take_values(u);
    publish(u);
}
