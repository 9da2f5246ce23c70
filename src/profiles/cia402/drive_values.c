/* SPDX-License-Identifier: MIT */
/* Settings of the dictionary into the axis, actual values of the axis into the dictionary. */
#include "profiles/cia402/drive.h"

#define DEFAULT_INCREMENTS 1048576.0
#define SHORTEST_TURN      1e-6 /* position units */
#define LONGEST_TURN       1e12
#define INERTIA_A_NM       1e-4 /* kg m2 for each Nm of rated torque: rated torque accelerates by 10 000 rad/s2 */
#define PEAK               3.0  /* times the rated torque */
enum { POSITION_TURNED = 0x80, SPEED_TURNED = 0x40, SHORTEST_UNITS = 250 /* of 60C2h, an integer with any power */ };

static bool has(const ect_402_drive_t *d, ect_402_value_t value)
{
    return d->links[value].bytes != 0;
}

static int64_t most_of(const ect_402_link_t *link)
{
    if (link->bytes >= 8 || link->is_real)
        return INT64_MAX;
    return (INT64_C(1) << (8u * link->bytes - (link->is_signed ? 1u : 0u))) - 1;
}

/* --- units -------------------------------------------------------------------------------------------------------- */

static double ratio(const ect_402_drive_t *d, ect_402_value_t above, ect_402_value_t below, double otherwise)
{
    double a = (double)d->value[above];
    double b = (double)d->value[below];
    return a > 0 ? a / (b > 0 ? b : 1) : otherwise;
}

/* @return the distance of a turn of the motor, in the master's position units (DRV-230) */
static double turn_of(const ect_402_drive_t *d)
{
    double feed = ratio(d, ECT_402_V_FEED, ECT_402_V_FEED_TURNS, 0);
    double turn = feed > 0 ? feed / ratio(d, ECT_402_V_GEAR_MOTOR, ECT_402_V_GEAR_SHAFT, 1) : d->increments;
    return turn < SHORTEST_TURN ? SHORTEST_TURN : turn < LONGEST_TURN ? turn : LONGEST_TURN;
}

static double scaled(int32_t at, double factor)
{
    return ect_402_size((double)at) < INT32_MAX ? at * factor : at;
}

/* Converts the description of the machine to a new unit. */
static void rescale(ect_402_surroundings_t *s, double turn)
{
    double factor = s->turn > 0 ? turn / s->turn : 1;
    ect_402_plant_t *m = &s->machine;
    s->turn = turn;
    if (factor == 1)
        return;
    m->position *= factor;
    m->speed *= factor;
    for (unsigned int i = 0; i < sizeof m->mark / sizeof m->mark[0]; i++) {
        m->mark[i].at = ect_402_saturated(scaled(m->mark[i].at, factor));
        m->mark[i].width = ect_402_saturated(m->mark[i].width * factor);
    }
    m->stop_negative.at = ect_402_saturated(scaled(m->stop_negative.at, factor));
    m->stop_positive.at = ect_402_saturated(scaled(m->stop_positive.at, factor));
    m->index_at = ect_402_saturated(scaled(m->index_at, factor));
}

static double speed_unit(const ect_402_drive_t *d)
{
    switch (d->around->velocity_unit) {
    case ECT_402_UNIT_RPM:
        return d->config.turn / 60;
    case ECT_402_UNIT_TENTH_RPM:
        return d->config.turn / 600;
    default:
        return 1;
    }
}

/* Applies a change of the distance of a turn without a motion of the shaft. */
static void take_units(ect_402_drive_t *d)
{
    double before = d->config.turn;
    d->increments = ratio(d, ECT_402_V_INCREMENTS, ECT_402_V_INCREMENT_TURNS,
                          d->around->resolution > 0 ? d->around->resolution : DEFAULT_INCREMENTS);
    d->config.turn = turn_of(d);
    rescale(d->around, d->config.turn);
    if (before > 0)
        d->axis.zero *= d->config.turn / before;
    d->speed_unit = speed_unit(d);
}

/* --- settings ----------------------------------------------------------------------------------------------------- */

static bool counts_position(ect_402_value_t value)
{
    return value == ECT_402_V_ERROR_WINDOW || value == ECT_402_V_POSITION_WINDOW;
}

static double default_of(const ect_402_drive_t *d, ect_402_value_t value)
{
    const ect_402_object_t *object = ect_402_object(value);
    if (!object->turns)
        return object->initial;
    return object->initial * d->config.turn / (counts_position(value) ? 1 : d->speed_unit);
}

void ect_402_drive_defaults(ect_402_drive_t *d)
{
    for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++) {
        const ect_402_object_t *object = ect_402_object((ect_402_value_t)i);
        const ect_402_link_t *link = &d->links[i];
        bool unset = object->kind == ECT_402_LIMIT || (object->kind == ECT_402_SETTING && !link->given);
        if (!unset || link->bytes == 0 || object->initial == 0 || ect_402_load(d->instance, link) != 0 ||
            i == ECT_402_V_CYCLE_POWER)
            continue;
        double initial = default_of(d, (ect_402_value_t)i);
        double most = (double)most_of(link);
        ect_402_store(d->instance, link, initial < most ? (int64_t)(initial + 0.5) : most_of(link));
    }
}

/* @return a setting of the dictionary, else the default */
static double setting(const ect_402_drive_t *d, ect_402_value_t value)
{
    return has(d, value) ? (double)d->value[value] : default_of(d, value);
}

static uint32_t nearest_u32(double x)
{
    return x >= UINT32_MAX ? UINT32_MAX : x > 0 ? (uint32_t)(x + 0.5) : 0;
}

static uint32_t setting_u32(const ect_402_drive_t *d, ect_402_value_t value)
{
    return nearest_u32(setting(d, value));
}

static uint16_t setting_u16(const ect_402_drive_t *d, ect_402_value_t value)
{
    uint32_t x = setting_u32(d, value);
    return x < UINT16_MAX ? (uint16_t)x : UINT16_MAX;
}

static int16_t option(const ect_402_drive_t *d, ect_402_value_t value)
{
    return (int16_t)ect_402_within(setting(d, value), INT16_MAX);
}

/* Converts speeds and accelerations to position units. */
static uint32_t speed_u32(const ect_402_drive_t *d, ect_402_value_t value)
{
    return nearest_u32(setting(d, value) * d->speed_unit);
}

static void take_options(ect_402_drive_t *d)
{
    ect_402_axis_t *a = &d->axis;
    a->quick_option = option(d, ECT_402_V_QUICK_OPTION);
    a->shutdown_option = option(d, ECT_402_V_SHUTDOWN_OPTION);
    a->disable_option = option(d, ECT_402_V_DISABLE_OPTION);
    a->halt_option = option(d, ECT_402_V_HALT_OPTION);
    a->fault_option = option(d, ECT_402_V_FAULT_OPTION);
}

static void take_speeds(ect_402_drive_t *d)
{
    ect_402_axis_t *a = &d->axis;
    a->task_speed = speed_u32(d, ECT_402_V_TASK_SPEED);
    a->end_speed = speed_u32(d, ECT_402_V_END_SPEED);
    a->acceleration = speed_u32(d, ECT_402_V_ACCELERATION);
    a->deceleration = has(d, ECT_402_V_DECELERATION) || !has(d, ECT_402_V_ACCELERATION)
                          ? speed_u32(d, ECT_402_V_DECELERATION)
                          : a->acceleration;
    a->quick_deceleration = speed_u32(d, ECT_402_V_QUICK_DECELERATION);
    a->speed_limit = speed_u32(d, ECT_402_V_SPEED_LIMIT);
    d->max_slippage = speed_u32(d, ECT_402_V_MAX_SLIPPAGE);
    a->motor_speed = setting_u32(d, ECT_402_V_MOTOR_SPEED);
    a->most_acceleration = speed_u32(d, ECT_402_V_MOST_ACCELERATION);
    a->most_deceleration = speed_u32(d, ECT_402_V_MOST_DECELERATION);
    a->home_speed[0] = speed_u32(d, ECT_402_V_HOME_SEARCH);
    a->home_speed[1] = speed_u32(d, ECT_402_V_HOME_ZERO);
    a->home_acceleration = speed_u32(d, ECT_402_V_HOME_ACCELERATION);
}

static void take_windows(ect_402_drive_t *d)
{
    ect_402_axis_t *a = &d->axis;
    bool watched = has(d, ECT_402_V_ERROR_WINDOW) && setting_u32(d, ECT_402_V_ERROR_WINDOW) != UINT32_MAX;
    a->error_window = watched ? setting_u32(d, ECT_402_V_ERROR_WINDOW) : 0;
    d->config.zero_window = watched && d->around->choices.following_zero != 0;
    a->error_time = setting_u16(d, ECT_402_V_ERROR_TIME);
    a->position_window = setting_u32(d, ECT_402_V_POSITION_WINDOW);
    a->position_time = setting_u16(d, ECT_402_V_POSITION_TIME);
    a->speed_window = (uint16_t)ect_402_within(speed_u32(d, ECT_402_V_SPEED_WINDOW), UINT16_MAX);
    a->speed_time = setting_u16(d, ECT_402_V_SPEED_TIME);
    a->zero_window = (uint16_t)ect_402_within(speed_u32(d, ECT_402_V_ZERO_WINDOW), UINT16_MAX);
    a->zero_time = setting_u16(d, ECT_402_V_ZERO_TIME);
}

static void take_torques(ect_402_drive_t *d)
{
    ect_402_axis_t *a = &d->axis;
    d->config.rated_torque = setting(d, ECT_402_V_RATED_TORQUE) / 1000;
    if (!(d->config.rated_torque > 0))
        d->config.rated_torque = ect_402_object(ECT_402_V_RATED_TORQUE)->initial / 1000;
    d->config.peak_torque = PEAK * d->config.rated_torque;
    d->config.inertia = INERTIA_A_NM * d->config.rated_torque;
    a->max_torque = setting_u16(d, ECT_402_V_MAX_TORQUE);
    a->max_current = setting_u16(d, ECT_402_V_MAX_CURRENT);
    a->torque_limit[0] = setting_u16(d, ECT_402_V_TORQUE_POSITIVE);
    a->torque_limit[1] = setting_u16(d, ECT_402_V_TORQUE_NEGATIVE);
    a->torque_slope = setting_u32(d, ECT_402_V_TORQUE_SLOPE);
}

/* Sets the software limit switches: 607Dh counts from the machine home (DRV-235); both extreme values mean none
 * (DRV-237). */
static void take_limits(ect_402_drive_t *d, int64_t offset, bool turned)
{
    ect_402_axis_t *a = &d->axis;
    int64_t lower = d->value[ECT_402_V_LIMIT_MIN];
    int64_t upper = d->value[ECT_402_V_LIMIT_MAX];
    bool none = lower >= upper || (lower <= INT32_MIN && upper >= INT32_MAX);
    a->limit[0] = none ? 0 : ect_402_saturated((double)(turned ? offset - upper : lower - offset));
    a->limit[1] = none ? 0 : ect_402_saturated((double)(turned ? offset - lower : upper - offset));
}

static void take_positions(ect_402_drive_t *d)
{
    ect_402_axis_t *a = &d->axis;
    const ect_402_choices_t *c = &d->around->choices;
    int64_t offset = (c->home_offset_added != 0 ? -1 : 1) * d->value[ECT_402_V_HOME_OFFSET];
    bool turned = ((unsigned int)d->value[ECT_402_V_POLARITY] & POSITION_TURNED) != 0;
    a->home_offset = ect_402_saturated((double)(turned ? offset : -offset));
    take_limits(d, c->limits_absolute != 0 ? 0 : offset, turned);
    int64_t lowest = d->value[ECT_402_V_RANGE_MIN];
    int64_t highest = d->value[ECT_402_V_RANGE_MAX];
    bool endless = lowest >= highest || (lowest <= INT32_MIN && highest >= INT32_MAX);
    a->range[0] = endless ? 0 : ect_402_saturated((double)lowest);
    a->range[1] = endless ? 0 : ect_402_saturated((double)highest);
    a->options = (uint16_t)d->value[ECT_402_V_POSITIONING];
    a->home_method = (int8_t)d->value[ECT_402_V_HOME_METHOD];
    bool op = d->al == ECT_STATE_OP; /* outside of it the outputs are 0 (DRV-312) */
    a->physical[0] = op ? (uint32_t)d->value[ECT_402_V_OUTPUTS] : 0;
    a->physical[1] = op ? (uint32_t)d->value[ECT_402_V_OUTPUT_MASK] : 0;
}

static void take_choices(ect_402_drive_t *d)
{
    const ect_402_choices_t *c = &d->around->choices;
    d->config.coasts = c->switched_on_holds == 0;
    d->config.homing_by_level = c->homing_by_level != 0;
    d->config.home_stays = c->home_stays != 0;
    d->config.no_buffer = c->no_buffer != 0;
}

static void take_settings(ect_402_drive_t *d)
{
    take_choices(d);
    take_units(d);
    take_options(d);
    take_speeds(d);
    take_windows(d);
    take_torques(d);
    take_positions(d);
    ect_402_drive_probe_control(d);
}

void ect_402_drive_read(ect_402_drive_t *d, bool all)
{
    bool changed = all;
    for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++) {
        if (!all && !d->links[i].output)
            continue;
        const ect_402_object_t *object = ect_402_object((ect_402_value_t)i);
        if (object->kind == ECT_402_ACTUAL)
            continue;
        int64_t value = ect_402_load(d->instance, &d->links[i]);
        changed = changed || (object->kind != ECT_402_COMMAND && value != d->value[i]);
        d->value[i] = value;
    }
    if (changed)
        take_settings(d);
}

/* --- what a master may write -------------------------------------------------------------------------------------- */

static bool is_factor(ect_402_value_t value)
{
    return value >= ECT_402_V_INCREMENTS && value <= ECT_402_V_FEED_TURNS;
}

uint64_t ect_402_drive_cycle_ns(int64_t units, int64_t power)
{
    uint64_t ns = 1000000000;
    for (; power < 0 && ns > 0; power++)
        ns /= 10;
    return power > 0 ? 0 : (uint64_t)units * ns;
}

/* Checks 60C2h, a multiple of the control step (DRV-263). */
static bool is_cycle(int64_t units, int64_t power)
{
    return power >= -6 && power <= 0 && ect_402_drive_cycle_ns(units, power) % ECT_402_STEP_NS == 0;
}

/* Checks a method against 60E3h, if the dictionary has 60E3h (DRV-280). */
static bool is_method(const ect_402_drive_t *d, int64_t number)
{
    bool listed = d->methods == 0 || (number < 64 && (d->methods >> number & 1u) != 0);
    return number <= INT8_MAX && ect_402_homing_known((int8_t)number) && listed;
}

static bool is_known(const ect_402_drive_t *d, ect_402_value_t value, int64_t number)
{
    uint16_t index = ect_402_object(value)->index;
    switch (value) {
    case ECT_402_V_ABORT_OPTION:
        return number >= 0 && number <= 3;
    case ECT_402_V_QUICK_OPTION:
    case ECT_402_V_SHUTDOWN_OPTION:
    case ECT_402_V_DISABLE_OPTION:
    case ECT_402_V_HALT_OPTION:
    case ECT_402_V_FAULT_OPTION:
        return number < 0 || ect_402_stop_known(index, (int)ect_402_saturated((double)number));
    case ECT_402_V_MODE:
        return number <= 0 || (number <= 32 && (d->modes >> (number - 1) & 1u) != 0);
    case ECT_402_V_HOME_METHOD:
        return number <= 0 || is_method(d, number);
    case ECT_402_V_POSITIONING: /* base of relative targets, direction of rotary axes; the other bits must be 0 */
        return (number & ~INT64_C(0xC3)) == 0 && (number & 3) != 3;
    case ECT_402_V_PROFILE_TYPE:
    case ECT_402_V_TORQUE_PROFILE:
    case ECT_402_V_SUB_MODE:
        return number <= 0;
    case ECT_402_V_SYNC_FUNCTIONS: /* 60D9h: none */
        return number == 0;
    case ECT_402_V_CYCLE_UNITS: /* may precede its power, whose write is checked */
        return number >= 1 && number <= UINT8_MAX;
    case ECT_402_V_CYCLE_POWER:
        return is_cycle(d->cycle_written ? d->value[ECT_402_V_CYCLE_UNITS] : SHORTEST_UNITS, number);
    default:
        return !is_factor(value) || number > 0;
    }
}

/* Checks a pair at the second write; a maximum of 0 is not yet written. */
static bool is_crossed(const ect_402_drive_t *d, ect_402_value_t value, int64_t number)
{
    switch (value) {
    case ECT_402_V_LIMIT_MIN:
    case ECT_402_V_RANGE_MIN:
        return d->value[value + 1] != 0 && number > d->value[value + 1];
    case ECT_402_V_LIMIT_MAX:
    case ECT_402_V_RANGE_MAX:
        return number < d->value[value - 1];
    default:
        return false;
    }
}

ect_reason_t ect_402_drive_check(const ect_402_drive_t *d, ect_402_value_t value, int64_t number)
{
    if (!is_known(d, value, number))
        return ECT_REASON_RANGE;
    bool is_cycle_time = value == ECT_402_V_CYCLE_UNITS || value == ECT_402_V_CYCLE_POWER;
    if (is_factor(value) && ect_402_powered(&d->axis))
        return ECT_REASON_STATE;
    if (is_cycle_time && (d->al == ECT_STATE_SAFEOP || d->al == ECT_STATE_OP))
        return ECT_REASON_STATE;
    return is_crossed(d, value, number) ? ECT_REASON_MIN_MAX : ECT_OK;
}

/* --- set values --------------------------------------------------------------------------------------------------- */

static int sign_of(const ect_402_drive_t *d, unsigned int mask)
{
    return ((unsigned int)d->value[ECT_402_V_POLARITY] & mask) != 0 ? -1 : 1;
}

/* @return the mode of the existing set value, without 6060h */
static int8_t fixed_mode(const ect_402_drive_t *d)
{
    if (has(d, ECT_402_V_TARGET_POSITION))
        return ECT_402_CSP;
    return has(d, ECT_402_V_TARGET_SPEED) ? ECT_402_CSV : ECT_402_CST;
}

/* DRV-529. */
static bool mode_is_held(const ect_402_drive_t *d)
{
    uint8_t change = d->around->choices.mode_change;
    if (d->axis.state != ECT_402_OPERATION_ENABLED || change == ECT_402_CHANGE_ANY)
        return false;
    return change == ECT_402_CHANGE_NONE || !ect_402_standing(&d->axis);
}

static void take_mode(ect_402_drive_t *d)
{
    int64_t mode = has(d, ECT_402_V_MODE) ? d->value[ECT_402_V_MODE] : fixed_mode(d);
    if (mode_is_held(d))
        return;
    if (mode == 0 && d->around->choices.mode_zero != 0)
        d->axis.mode = ECT_402_NO_MODE;
    if (mode > 0 && mode <= 32 && (d->modes >> (mode - 1) & 1u) != 0)
        d->axis.mode = (int8_t)mode;
}

/* Wraps integers, as positions do; floating-point numbers beyond 32 bits do not wrap. */
static int64_t set_position(const ect_402_drive_t *d, ect_402_value_t value)
{
    int64_t position = sign_of(d, POSITION_TURNED) * d->value[value];
    return d->links[value].is_real ? ect_402_saturated((double)position) : position;
}

void ect_402_drive_set_values(ect_402_drive_t *d)
{
    ect_402_axis_t *a = &d->axis;
    int64_t position = set_position(d, ECT_402_V_TARGET_POSITION);
    double speed = sign_of(d, SPEED_TURNED) * (double)d->value[ECT_402_V_TARGET_SPEED];
    double torque = (double)d->value[ECT_402_V_TARGET_TORQUE];
    take_mode(d);
    a->target = (int32_t)(uint32_t)position;
    if (a->mode == ECT_402_CSP)
        position += set_position(d, ECT_402_V_POSITION_OFFSET);
    if (a->mode == ECT_402_IP)
        position = set_position(d, ECT_402_V_RECORD);
    if (a->mode == ECT_402_CSV)
        speed += sign_of(d, SPEED_TURNED) * (double)d->value[ECT_402_V_SPEED_OFFSET];
    if (a->mode == ECT_402_CST)
        torque += (double)d->value[ECT_402_V_TORQUE_OFFSET];
    a->set.position = (int32_t)(uint32_t)position;
    a->set.speed = ect_402_saturated(speed * d->speed_unit);
    a->set.torque = (int16_t)ect_402_within(torque, INT16_MAX);
    a->set.ahead = (int16_t)ect_402_within((double)d->value[ECT_402_V_TORQUE_OFFSET], INT16_MAX);
}

/* --- actual values ------------------------------------------------------------------------------------------------ */

static void put(const ect_402_drive_t *d, ect_402_value_t value, double x)
{
    double nearest = ect_402_within(x < 0 ? x - 0.5 : x + 0.5, 9e18);
    if (has(d, value))
        ect_402_store(d->instance, &d->links[value], (int64_t)nearest);
}

static void put_bits(const ect_402_drive_t *d, ect_402_value_t value, uint32_t bits)
{
    ect_402_store(d->instance, &d->links[value], bits);
}

/* @return whether the shaft is slower or faster than its demand by more than the maximum slippage (DRV-075) */
static bool slips(const ect_402_drive_t *d)
{
    const ect_402_axis_t *a = &d->axis;
    return a->mode == ECT_402_PV && d->max_slippage != 0 && a->action == ECT_402_FOLLOW &&
           ect_402_size(a->reference.speed - a->plant->speed) > d->max_slippage;
}

/* @return the bits of the mode, in mode 8 by the choices of vendors (DRV-510, DRV-511) */
static uint16_t mode_bits(const ect_402_drive_t *d)
{
    const ect_402_axis_t *a = &d->axis;
    const ect_402_choices_t *c = &d->around->choices;
    uint16_t bits = ect_402_mode_bits(a) | (slips(d) ? ECT_402_STATUS_MODE_ERROR : 0);
    if (a->mode != ECT_402_CSP)
        return bits;
    bool target =
        c->csp_bit10 == ECT_402_BIT10_TOGGLES ? a->toggle : c->csp_bit10 == ECT_402_BIT10_WINDOW && ect_402_reached(a);
    if (c->csp_bit12 != ECT_402_BIT12_FOLLOWS)
        bits &= (uint16_t)~ECT_402_STATUS_ATTAINED;
    return (uint16_t)(bits | (target ? ECT_402_STATUS_TARGET : 0) |
                      (c->csp_bit12 == ECT_402_BIT12_ONE ? ECT_402_STATUS_ATTAINED : 0));
}

static uint16_t status_word(const ect_402_drive_t *d)
{
    const ect_402_axis_t *a = &d->axis;
    bool stop = !a->level[ECT_402_POSITIVE] || !a->level[ECT_402_NEGATIVE];
    return (uint16_t)(ect_402_status(a->state, &a->inputs) | mode_bits(d) |
                      (d->around->power ? ECT_402_STATUS_VOLTAGE : 0) |
                      (d->around->warning ? ECT_402_STATUS_WARNING : 0) |
                      (a->live && d->al == ECT_STATE_OP ? ECT_402_STATUS_REMOTE : 0) |
                      (ect_402_limit_acts(a) || stop || a->held ? ECT_402_STATUS_LIMIT : 0));
}

/* @return 60FDh: limit switches, home switch, interlock, probe inputs */
static uint32_t digital_inputs(const ect_402_drive_t *d)
{
    const uint8_t *level = d->axis.level;
    return (level[ECT_402_NEGATIVE] ? 0u : 1u) | (level[ECT_402_POSITIVE] ? 0u : 2u) | (level[ECT_402_HOME] ? 4u : 0u) |
           (d->around->sto || !d->around->enable ? 8u : 0u) | (level[ECT_402_PROBE] ? 1u << 16 : 0u) |
           (level[ECT_402_HOME] ? 1u << 17 : 0u);
}

/* `actual` and `demand` count from the zero of the machine. */
static void put_positions(ect_402_drive_t *d, double actual, double demand)
{
    double increments = d->increments / d->config.turn;
    int sign = sign_of(d, POSITION_TURNED);
    d->position = ect_402_drive_position(d, actual + d->axis.zero);
    d->demand = ect_402_drive_position(d, demand + d->axis.zero);
    d->following_error = ect_402_saturated(sign * (demand - actual));
    put(d, ECT_402_V_POSITION, d->position);
    put(d, ECT_402_V_DEMAND, d->demand);
    put(d, ECT_402_V_FOLLOWING_ERROR, d->following_error);
    put(d, ECT_402_V_INTERNAL, ect_402_counts(actual * increments));
    put(d, ECT_402_V_INTERNAL_DEMAND, ect_402_counts(demand * increments));
}

static void put_speeds(const ect_402_drive_t *d, double actual, double demand)
{
    double unit = sign_of(d, SPEED_TURNED) / d->speed_unit;
    put(d, ECT_402_V_SPEED, actual * unit);
    put(d, ECT_402_V_SPEED_DEMAND, demand * unit);
    put(d, ECT_402_V_EFFORT, demand * unit);
    put(d, ECT_402_V_SENSOR_SPEED, actual / d->config.turn * d->increments);
}

static void put_torques(const ect_402_drive_t *d)
{
    double torque = d->axis.torque_now / d->config.rated_torque * 1000;
    put(d, ECT_402_V_TORQUE, torque);
    put(d, ECT_402_V_TORQUE_DEMAND, torque);
    put(d, ECT_402_V_CURRENT, torque);
    put(d, ECT_402_V_DC_LINK, d->around->power ? 325000 : 0);
}

void ect_402_drive_actual(ect_402_drive_t *d)
{
    const ect_402_axis_t *a = &d->axis;
    bool following = a->reference.loop == ECT_402_LOOP_POSITION && ect_402_powered(a);
    double actual = ect_402_user(a, d->around->machine.position);
    put_bits(d, ECT_402_V_STATUS, status_word(d));
    put_bits(d, ECT_402_V_ERROR_CODE, d->error_code);
    put_bits(d, ECT_402_V_INPUTS, digital_inputs(d));
    put(d, ECT_402_V_MODE_DISPLAY, a->mode);
    put_positions(d, actual, following ? ect_402_user(a, a->reference.position) : actual);
    put_speeds(d, d->around->machine.speed, ect_402_powered(a) ? a->reference.speed : 0);
    put_torques(d);
    ect_402_drive_probe_publish(d);
}
