/* SPDX-License-Identifier: MIT */
/* An encoder alone, over a dictionary of its own: time, and numbers at their limits. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/encoder/encoder.h"

#define COUNT(array)   (sizeof(array) / sizeof((array)[0]))
#define HOUR           UINT64_C(3600000000000)
#define AT(member)     ((void *)offsetof(values_t, member))
#define NEXT_MS(ns)    ((ns) + 1000000u)
#define LIMIT_OF_TURNS 536870912.0

typedef struct values {
    int64_t first; /* an entry at offset 0 would have no memory */
    int64_t wide;
    uint32_t position, resolution, preset, raw;
    int32_t speed;
    float real_range;
} values_t;

static const ect_entry_t position[] = {{0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "", 0, AT(position)}};
static const ect_entry_t preset[] = {{0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, "", 0, AT(preset)}};
static const ect_entry_t wide[] = {{0, ECT_TYPE_INTEGER64, 64, ECT_ACCESS_RO, "", 0, AT(wide)}};
static const ect_entry_t resolution[] = {{0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "", 0, AT(resolution)}};
static const ect_entry_t speed[] = {{0, ECT_TYPE_INTEGER32, 32, ECT_ACCESS_RO, "", 0, AT(speed)}};
static const ect_entry_t range[] = {{0, ECT_TYPE_REAL32, 32, ECT_ACCESS_RW, "", 0, AT(real_range)}};
static const ect_object_t objects[] = {
    {0x6002, ECT_OBJECT_VAR, 0, 0, "", range},    {0x6003, ECT_OBJECT_VAR, 0, 0, "", preset},
    {0x6004, ECT_OBJECT_VAR, 0, 0, "", position}, {0x6008, ECT_OBJECT_VAR, 0, 0, "", wide},
    {0x6030, ECT_OBJECT_VAR, 0, 0, "", speed},    {0x6501, ECT_OBJECT_VAR, 0, 0, "", resolution},
};
static const ect_od_t od = {.objects = objects, .count = COUNT(objects)};

static values_t values;
static ect_encoder_t encoder;
static ect_encoder_shaft_t shaft;
static ect_link_t links[ECT_ENCODER_VALUE_COUNT];

static int power_on(void **state)
{
    (void)state;
    memset(&values, 0, sizeof values);
    memset(&encoder, 0, sizeof encoder);
    memset(&shaft, 0, sizeof shaft);
    values.resolution = 1000;
    assert_true(ect_encoder_links_find(&od, 0, links));
    ect_encoder_init(&encoder, links, &shaft, &values, 0);
    return 0;
}

static void an_hour_is_exact(void **state)
{
    (void)state;
    shaft.speed = 3000;
    ect_encoder_moved(&encoder, 0);
    for (uint64_t ns = 0; ns <= HOUR; ns += HOUR / 36000)
        ect_encoder_advance(&encoder, ns);
    assert_true(fabs(shaft.position - 180000) < 1e-6);
    assert_int_equal(values.position, 180000000);
    assert_int_equal(values.speed, 50000);
    assert_int_equal(ect_encoder_next(&encoder, HOUR), NEXT_MS(HOUR));
    shaft.speed = -1;
    assert_int_equal(ect_encoder_next(&encoder, HOUR), NEXT_MS(HOUR));
    shaft.speed = 0;
    assert_true(ect_encoder_next(&encoder, HOUR) == UINT64_MAX);
}

static void time_stands(void **state)
{
    (void)state;
    shaft.speed = 60;
    ect_encoder_moved(&encoder, HOUR);
    ect_encoder_advance(&encoder, 0);
    assert_true(!(shaft.position > 0) && !(shaft.position < 0));
}

static void at_the_limits(void **state)
{
    static const struct {
        double turns;
        uint32_t position;
        int64_t wide;
    } rows[] = {
        {LIMIT_OF_TURNS, 0, 536870912000},
        {-LIMIT_OF_TURNS, 0, -536870912000},
        {-0.0005, UINT32_MAX, -1},
        {4294967.2955, UINT32_MAX, UINT32_MAX},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        shaft.position = rows[i].turns;
        ect_encoder_moved(&encoder, 0);
        assert_true(values.wide == rows[i].wide);
        assert_int_equal(values.position, rows[i].position);
    }
    shaft.speed = 1e7;
    ect_encoder_moved(&encoder, 0);
    ect_encoder_advance(&encoder, 10000 * HOUR);
    assert_true(!(shaft.position < LIMIT_OF_TURNS) && !(shaft.position > LIMIT_OF_TURNS));
    assert_int_equal(values.speed, 166666667);
}

static void no_second_encoder(void **state)
{
    ect_encoder_value_t value;
    (void)state;
    assert_false(ect_encoder_links_find(&od, 1, links));
    assert_false(ect_encoder_value_of(1, 0x6003, 0, &value));
    assert_false(ect_encoder_value_of(0, 0x6004, 1, &value));
    assert_false(ect_encoder_value_of(0, 0x6007, 0, &value));
    assert_true(ect_encoder_value_of(0, 0x6030, 0, &value));
    assert_int_equal(value, ECT_ENCODER_SPEED);
    assert_true(ect_encoder_value_of(1, 0x6030, 2, &value));
    assert_false(ect_encoder_is_actual(ECT_ENCODER_PRESET));
}

static void a_range_in_floating_point(void **state)
{
    (void)state;
    values.real_range = 2000;
    shaft.position = 5.5;
    ect_encoder_moved(&encoder, 0);
    assert_int_equal(values.position, 1500);
    values.preset = 1999;
    ect_encoder_written(&encoder, ECT_ENCODER_PRESET, 0);
    assert_int_equal(values.position, 1999);
    assert_int_equal(ect_encoder_check(&encoder, ECT_ENCODER_PRESET, 2000), ECT_REASON_RANGE);
    assert_int_equal(ect_encoder_check(&encoder, ECT_ENCODER_PRESET, -1), ECT_REASON_RANGE);
    assert_int_equal(ect_encoder_check(&encoder, ECT_ENCODER_OPERATING, 0xFFFF), ECT_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"after an hour of turns the position is exact", an_hour_is_exact, power_on, NULL, NULL},
        {"a time before that of the speed moves nothing", time_stands, power_on, NULL, NULL},
        {"positions and speeds at the limits of turns and of entries", at_the_limits, power_on, NULL, NULL},
        {"a dictionary with VARs alone has one encoder", no_second_encoder, power_on, NULL, NULL},
        {"a range in floating point wraps the position and limits presets", a_range_in_floating_point, power_on, NULL,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
