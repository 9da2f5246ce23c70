/* SPDX-License-Identifier: MIT */
/* An encoder of CiA 406: its shaft in time, and the position of the shaft in the units of the master. */
#include "profiles/encoder/encoder.h"

#define MS_NS         UINT64_C(1000000)
#define NS_A_S        1e9
#define S_A_MIN       60.0
#define NM_A_MM       1e6                   /* 6005h:1 counts nm */
#define LINEAR_SPEEDS 100.0                 /* 6005h:2 counts 0.01 mm/s */
#define FARTHEST      536870912.0           /* turns: with 2^32 units per turn, a position has 61 bits */
#define MOST_COUNTS   2305843009213693952.0 /* 2^61: the sum with a preset has 63 bits */
#define WIDEST        (INT64_C(1) << 62u)   /* range without limit */
#define FASTEST       1e18                  /* units per second */
enum { USUAL_ROTARY = 65536, USUAL_LINEAR = 1000, LONGEST_RANGE = 62 };

typedef enum kind { VAR, MEMBER, FIRST, EACH } kind_t;

static const struct {
    uint16_t index;
    uint8_t subindex;
    kind_t kind;
} rows[ECT_ENCODER_VALUE_COUNT] = {
#define ROW(name, index, subindex, kind) {index, subindex, kind},
    ECT_ENCODER_VALUES(ROW)
#undef ROW
};

/* --- links -------------------------------------------------------------------------------------------------------- */

static bool has(const ect_link_t *links, ect_encoder_value_t value)
{
    return links[value].bytes != 0;
}

bool ect_encoder_links_find(const ect_od_t *od, unsigned int number, ect_link_t *links)
{
    for (unsigned int i = 0; i < ECT_ENCODER_VALUE_COUNT; i++) {
        if (rows[i].kind == EACH)
            links[i] = ect_link_to_element(od, rows[i].index, number);
        else if (rows[i].kind == FIRST && number > 0)
            links[i] = (ect_link_t){0};
        else
            links[i] = ect_link_to(od, rows[i].index, rows[i].subindex);
    }
    return has(links, ECT_ENCODER_POSITION) || has(links, ECT_ENCODER_WIDE_POSITION) ||
           has(links, ECT_ENCODER_CHANNEL_POSITION);
}

bool ect_encoder_is_linear(const ect_link_t *links)
{
    return has(links, ECT_ENCODER_STEP) && !has(links, ECT_ENCODER_UNITS);
}

bool ect_encoder_knows(uint16_t index)
{
    for (unsigned int i = 0; i < ECT_ENCODER_VALUE_COUNT; i++) {
        if (rows[i].index == index)
            return true;
    }
    return false;
}

bool ect_encoder_is_actual(ect_encoder_value_t value)
{
    switch (value) {
    case ECT_ENCODER_POSITION:
    case ECT_ENCODER_WIDE_POSITION:
    case ECT_ENCODER_CHANNEL_POSITION:
    case ECT_ENCODER_RAW:
    case ECT_ENCODER_WIDE_RAW:
    case ECT_ENCODER_SPEED:
    case ECT_ENCODER_STATUS:
    case ECT_ENCODER_ALARMS:
    case ECT_ENCODER_WARNINGS:
    case ECT_ENCODER_OFFSET:
    case ECT_ENCODER_CHANNEL_OFFSET:
        return true;
    default:
        return false;
    }
}

bool ect_encoder_value_of(unsigned int number, uint16_t index, uint8_t subindex, ect_encoder_value_t *value)
{
    for (unsigned int i = 0; i < ECT_ENCODER_VALUE_COUNT; i++) {
        const bool each = rows[i].kind == EACH && (subindex == number + 1 || (subindex == 0 && number == 0));
        const bool one = rows[i].kind != EACH && subindex == rows[i].subindex && (rows[i].kind != FIRST || number == 0);
        if (rows[i].index == index && (each || one)) {
            *value = (ect_encoder_value_t)i;
            return true;
        }
    }
    return false;
}

/* --- units -------------------------------------------------------------------------------------------------------- */

static int64_t load(const ect_encoder_t *e, ect_encoder_value_t value)
{
    return ect_link_load(e->instance, &e->links[value]);
}

static void store(const ect_encoder_t *e, ect_encoder_value_t value, int64_t number)
{
    ect_link_store(e->instance, &e->links[value], number);
}

/* @return whether 6001h and 6002h apply: by 6000h, and without 6000h */
static bool is_scaled(const ect_encoder_t *e)
{
    return !has(e->links, ECT_ENCODER_OPERATING) ||
           ((uint64_t)load(e, ECT_ENCODER_OPERATING) & ECT_ENCODER_SCALING) != 0;
}

static int64_t positive(int64_t first, int64_t second)
{
    return first > 0 ? first : second;
}

static double usual(const ect_encoder_t *e)
{
    if (e->shaft->resolution > 0)
        return e->shaft->resolution;
    return ect_encoder_is_linear(e->links) ? (double)USUAL_LINEAR : (double)USUAL_ROTARY;
}

/* @return the units per turn without scaling: those of the sensor */
static double raw_units(const ect_encoder_t *e)
{
    int64_t step = load(e, ECT_ENCODER_STEP);
    if (ect_encoder_is_linear(e->links))
        return step > 0 ? NM_A_MM / (double)step : usual(e);
    int64_t units = positive(load(e, ECT_ENCODER_RESOLUTION), load(e, ECT_ENCODER_UNITS));
    return units > 0 ? (double)units : usual(e);
}

static double units(const ect_encoder_t *e)
{
    int64_t scaled = load(e, ECT_ENCODER_UNITS);
    return is_scaled(e) && scaled > 0 ? (double)scaled : raw_units(e);
}

/* @return the range of an entry; positions of a linear encoder do not wrap */
static int64_t width(const ect_link_t *link)
{
    unsigned int bits = 8u * link->bytes - (link->is_signed ? 1u : 0u);
    return bits < LONGEST_RANGE ? INT64_C(1) << bits : WIDEST;
}

/* @return the range of the sensor, its turns; 0: unknown */
static int64_t raw_range(const ect_encoder_t *e)
{
    double range = units(e) * (double)load(e, ECT_ENCODER_TURNS);
    return range >= 1 && range < (double)WIDEST ? (int64_t)range : 0;
}

static int64_t range_of(const ect_encoder_t *e, ect_encoder_value_t position)
{
    const bool wide = position == ECT_ENCODER_WIDE_POSITION && has(e->links, ECT_ENCODER_WIDE_RANGE);
    int64_t scaled = load(e, wide ? ECT_ENCODER_WIDE_RANGE : ECT_ENCODER_RANGE);
    if (ect_encoder_is_linear(e->links))
        return WIDEST;
    if (is_scaled(e) && scaled > 0)
        return scaled;
    return positive(raw_range(e), positive(scaled, width(&e->links[position])));
}

static bool is_reversed(const ect_encoder_t *e)
{
    uint64_t bits = (uint64_t)load(e, ECT_ENCODER_OPERATING);
    return ((bits & ECT_ENCODER_COUNTERCLOCKWISE) != 0) != ((bits & ECT_ENCODER_REVERSE) != 0);
}

/* --- position and speed ------------------------------------------------------------------------------------------- */

static double within(double x, double most)
{
    return x > most ? most : x < -most ? -most : x;
}

static int64_t floored(double x)
{
    int64_t whole = (int64_t)x;
    return (double)whole > x ? whole - 1 : whole;
}

static int64_t wrapped(int64_t x, int64_t range)
{
    if (range >= WIDEST)
        return x;
    int64_t rest = x % range;
    return rest < 0 ? rest + range : rest;
}

static int64_t counted(const ect_encoder_t *e, double units_a_turn)
{
    double at = within(e->shaft->position, FARTHEST);
    return floored(within((is_reversed(e) ? -at : at) * units_a_turn, MOST_COUNTS));
}

static int64_t position_of(const ect_encoder_t *e, ect_encoder_value_t value)
{
    return wrapped(counted(e, units(e)) + e->offset, range_of(e, value));
}

static ect_encoder_value_t main_position(const ect_encoder_t *e)
{
    if (has(e->links, ECT_ENCODER_POSITION))
        return ECT_ENCODER_POSITION;
    return has(e->links, ECT_ENCODER_WIDE_POSITION) ? ECT_ENCODER_WIDE_POSITION : ECT_ENCODER_CHANNEL_POSITION;
}

static double linear_speed(const ect_encoder_t *e)
{
    int64_t step = load(e, ECT_ENCODER_SPEED_STEP);
    return step > 0 ? e->shaft->speed * LINEAR_SPEEDS / (double)step : e->shaft->speed * units(e);
}

static double rotary_speed(const ect_encoder_t *e)
{
    switch (e->shaft->velocity_unit) {
    case ECT_ENCODER_RPM:
        return e->shaft->speed;
    case ECT_ENCODER_TENTH_RPM:
        return e->shaft->speed * 10;
    default:
        return e->shaft->speed / S_A_MIN * units(e);
    }
}

static int64_t speed_of(const ect_encoder_t *e)
{
    double speed = ect_encoder_is_linear(e->links) ? linear_speed(e) : rotary_speed(e);
    int64_t multiplier = load(e, ECT_ENCODER_MULTIPLIER);
    int64_t divisor = load(e, ECT_ENCODER_DIVISOR);
    speed *= multiplier > 0 ? (double)multiplier : 1;
    speed /= divisor > 0 ? (double)divisor : 1;
    speed = within(is_reversed(e) ? -speed : speed, FASTEST);
    return (int64_t)(speed < 0 ? speed - 0.5 : speed + 0.5);
}

static void publish(ect_encoder_t *e)
{
    static const ect_encoder_value_t positions[] = {ECT_ENCODER_POSITION, ECT_ENCODER_WIDE_POSITION,
                                                    ECT_ENCODER_CHANNEL_POSITION};
    int64_t raw = counted(e, raw_units(e));
    e->counts = position_of(e, main_position(e));
    e->velocity = speed_of(e);
    for (unsigned int i = 0; i < sizeof positions / sizeof positions[0]; i++)
        store(e, positions[i], position_of(e, positions[i]));
    store(e, ECT_ENCODER_RAW, wrapped(raw, width(&e->links[ECT_ENCODER_RAW])));
    store(e, ECT_ENCODER_WIDE_RAW, wrapped(raw, WIDEST));
    store(e, ECT_ENCODER_SPEED, e->velocity);
    store(e, ECT_ENCODER_STATUS, load(e, ECT_ENCODER_OPERATING));
    store(e, ECT_ENCODER_ALARMS, e->shaft->alarms);
    store(e, ECT_ENCODER_WARNINGS, e->shaft->warnings);
    store(e, ECT_ENCODER_OFFSET, e->offset);
    store(e, ECT_ENCODER_CHANNEL_OFFSET, e->offset);
}

void ect_encoder_init(ect_encoder_t *e, const ect_link_t *links, ect_encoder_shaft_t *shaft, void *instance,
                      uint64_t now_ns)
{
    e->links = links;
    e->shaft = shaft;
    e->instance = instance;
    ect_encoder_moved(e, now_ns);
}

void ect_encoder_advance(ect_encoder_t *e, uint64_t now_ns)
{
    const double seconds = now_ns > e->from_ns ? (double)(now_ns - e->from_ns) / NS_A_S : 0;
    const double rate = ect_encoder_is_linear(e->links) ? e->shaft->speed : e->shaft->speed / S_A_MIN;
    e->shaft->position = within(e->from + rate * seconds, FARTHEST);
    publish(e);
}

void ect_encoder_moved(ect_encoder_t *e, uint64_t now_ns)
{
    e->from = e->shaft->position;
    e->from_ns = now_ns;
    publish(e);
}

uint64_t ect_encoder_next(const ect_encoder_t *e, uint64_t now_ns)
{
    const bool turns = e->shaft->speed > 0 || e->shaft->speed < 0;
    return turns ? now_ns + MS_NS : UINT64_MAX;
}

/* --- a master's writes -------------------------------------------------------------------------------------------- */

static bool is_preset(ect_encoder_value_t value)
{
    return value == ECT_ENCODER_PRESET || value == ECT_ENCODER_WIDE_PRESET || value == ECT_ENCODER_CHANNEL_PRESET;
}

/* @return the position that a preset sets */
static ect_encoder_value_t preset_position(ect_encoder_value_t preset)
{
    if (preset == ECT_ENCODER_PRESET)
        return ECT_ENCODER_POSITION;
    return preset == ECT_ENCODER_WIDE_PRESET ? ECT_ENCODER_WIDE_POSITION : ECT_ENCODER_CHANNEL_POSITION;
}

ect_reason_t ect_encoder_check(const ect_encoder_t *e, ect_encoder_value_t value, int64_t wanted)
{
    const int64_t finest = load(e, ECT_ENCODER_RESOLUTION);
    if (is_preset(value) && !ect_encoder_is_linear(e->links))
        return wanted >= 0 && wanted < range_of(e, preset_position(value)) ? ECT_OK : ECT_REASON_RANGE;
    switch (value) {
    case ECT_ENCODER_UNITS:
        return wanted > 0 && (finest == 0 || wanted <= finest) ? ECT_OK : ECT_REASON_RANGE;
    case ECT_ENCODER_RANGE:
    case ECT_ENCODER_WIDE_RANGE:
    case ECT_ENCODER_STEP:
    case ECT_ENCODER_SPEED_STEP:
    case ECT_ENCODER_MULTIPLIER:
    case ECT_ENCODER_DIVISOR:
        return wanted > 0 ? ECT_OK : ECT_REASON_RANGE;
    default:
        return ECT_OK;
    }
}

void ect_encoder_written(ect_encoder_t *e, ect_encoder_value_t value, uint64_t now_ns)
{
    ect_encoder_advance(e, now_ns);
    if (!is_preset(value))
        return;
    int64_t range = range_of(e, preset_position(value));
    e->offset = load(e, value) - wrapped(counted(e, units(e)), range);
    publish(e);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

#define COUNTS(member, name, meaning)                                                                                  \
    ECT_SIGNAL(ect_encoder_t, member, name, I64, READ, INT64_MIN, INT64_MAX, "counts", meaning)
const ect_signal_t ect_encoder_signals[] = {
    COUNTS(counts, "counts", "position as the master reads it: 6004h, 6008h or 6020h"),
    ECT_SIGNAL(ect_encoder_t, velocity, "velocity", I64, READ, INT64_MIN, INT64_MAX, NULL,
               "speed as the master reads it, 6030h, without the limits of its width"),
};
const uint16_t ect_encoder_signal_count = sizeof ect_encoder_signals / sizeof ect_encoder_signals[0];

#define SHAFT(member, name, kind, most, unit, meaning)                                                                 \
    ECT_SIGNAL(ect_encoder_shaft_t, member, name, kind, WRITE, 0, most, unit, meaning)
#define SIGNED(member, name, most, unit, meaning)                                                                      \
    ECT_SIGNAL(ect_encoder_shaft_t, member, name, REAL, WRITE, -(most), most, unit, meaning)
#define COMMON(way)                                                                                                    \
    SHAFT(resolution, "resolution", U32, UINT32_MAX, "counts",                                                         \
          "units " way " where the dictionary has no resolution; 0: the usual one"),                                   \
        SHAFT(alarms, "alarms", U16, UINT16_MAX, NULL, "alarms to report, bits of 6503h"),                             \
        SHAFT(warnings, "warnings", U16, UINT16_MAX, NULL, "warnings to report, bits of 6505h"),                       \
        SHAFT(velocity_unit, "velocity_unit", U8, ECT_ENCODER_TENTH_RPM, NULL,                                         \
              "6030h of a rotary encoder: 0 units per second, 1 turns per minute, 2 tenths of turns per minute")

const ect_signal_t ect_encoder_rotary_signals[] = {
    SIGNED(position, "position", 1 << 29, "turns", "position of the shaft, clockwise; does not wrap"),
    SIGNED(speed, "speed", 10000000, "1/min", "speed at which the shaft turns, clockwise"),
    COMMON("a turn"),
};
const ect_signal_t ect_encoder_linear_signals[] = {
    SIGNED(position, "position", 1 << 29, "mm", "position of the carriage"),
    SIGNED(speed, "speed", 10000000, "mm/s", "speed at which the carriage moves"),
    COMMON("a mm"),
};
const uint16_t ect_encoder_shaft_signal_count =
    sizeof ect_encoder_rotary_signals / sizeof ect_encoder_rotary_signals[0];
