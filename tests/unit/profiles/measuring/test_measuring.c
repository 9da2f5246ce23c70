/* SPDX-License-Identifier: MIT */
/* A measuring input alone, over a dictionary of its own: numbers at their limits, and a VAR in place of an array. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/measuring/measuring.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define AT(member)   ((void *)offsetof(values_t, member))

typedef struct values {
    int64_t first; /* an entry at offset 0 would have no memory */
    double process;
    int32_t wide;
    float field[2], ends[2], offset;
    uint32_t autozero;
} values_t;

static const ect_entry_t field_1[] = {{0, ECT_TYPE_REAL32, 32, ECT_ACCESS_RW, "", 0, AT(field[0])}};
static const ect_entry_t field_2[] = {{0, ECT_TYPE_REAL32, 32, ECT_ACCESS_RW, "", 0, AT(field[1])}};
static const ect_entry_t process_1[] = {{0, ECT_TYPE_REAL32, 32, ECT_ACCESS_RW, "", 0, AT(ends[0])}};
static const ect_entry_t process_2[] = {{0, ECT_TYPE_REAL32, 32, ECT_ACCESS_RW, "", 0, AT(ends[1])}};
static const ect_entry_t offset[] = {{0, ECT_TYPE_REAL32, 32, ECT_ACCESS_RW, "", 0, AT(offset)}};
static const ect_entry_t autozero[] = {{0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, "", 0, AT(autozero)}};
static const ect_entry_t process[] = {{0, ECT_TYPE_REAL64, 64, ECT_ACCESS_RO, "", 0, AT(process)}};
static const ect_entry_t wide[] = {{0, ECT_TYPE_INTEGER32, 32, ECT_ACCESS_RO, "", 0, AT(wide)}};
static const ect_object_t objects[] = {
    {0x6120, ECT_OBJECT_VAR, 0, 0, "", field_1}, {0x6121, ECT_OBJECT_VAR, 0, 0, "", process_1},
    {0x6122, ECT_OBJECT_VAR, 0, 0, "", field_2}, {0x6123, ECT_OBJECT_VAR, 0, 0, "", process_2},
    {0x6124, ECT_OBJECT_VAR, 0, 0, "", offset},  {0x6125, ECT_OBJECT_VAR, 0, 0, "", autozero},
    {0x6130, ECT_OBJECT_VAR, 0, 0, "", process}, {0x9130, ECT_OBJECT_VAR, 0, 0, "", wide},
};
static const ect_od_t od = {.objects = objects, .count = COUNT(objects)};

static values_t values;
static ect_measuring_t input;
static ect_measuring_sensor_t sensor;
static ect_measuring_links_t links;

static int power_on(void **state)
{
    (void)state;
    memset(&values, 0, sizeof values);
    memset(&input, 0, sizeof input);
    memset(&sensor, 0, sizeof sensor);
    values.field[1] = 10;
    values.ends[1] = 100;
    assert_true(ect_measuring_links_find(&od, 0, &links));
    ect_measuring_init(&input, &links, &sensor, &values);
    return 0;
}

static void is_close(double got, double wanted)
{
    if (!(fabs(got - wanted) <= 1e-9 * (1 + fabs(wanted))))
        fail_msg("expected %.12g, got %.12g", wanted, got);
}

static void fractions_stay(void **state)
{
    (void)state;
    sensor.value = -12.375;
    ect_measuring_update(&input);
    is_close(values.process, -12.375);
    is_close(input.field, -1.2375);
    assert_int_equal(values.wide, -12);
}

static void at_the_limits(void **state)
{
    static const double rows[] = {1e12, -1e12};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        sensor.value = rows[i];
        ect_measuring_update(&input);
        is_close(values.process, rows[i]);
        assert_int_equal(values.wide, rows[i] > 0 ? INT32_MAX : INT32_MIN);
    }
}

static void not_a_number(void **state)
{
    (void)state;
    values.ends[1] = NAN;
    sensor.value = 5;
    ect_measuring_update(&input);
    assert_true(isnan(values.process));
    assert_int_equal(values.wide, 0);
    values.ends[1] = 100;
    values.field[1] = INFINITY;
    ect_measuring_update(&input);
    is_close(values.process, 0);
}

static void huge_offset(void **state)
{
    (void)state;
    values.offset = 3e38F;
    ect_measuring_update(&input);
    assert_int_equal(values.wide, INT32_MAX);
    values.offset = -3e38F;
    ect_measuring_update(&input);
    assert_int_equal(values.wide, INT32_MIN);
}

static void entries_of_a_var(void **state)
{
    (void)state;
    assert_false(ect_measuring_links_find(&od, 1, &links));
    assert_true(ect_measuring_links_find(&od, 0, &links));
    assert_ptr_equal(ect_measuring_link(&links, 0, 0x6125, 0), &links.autozero);
    assert_null(ect_measuring_link(&links, 1, 0x6125, 0));
    assert_null(ect_measuring_link(&links, 0, 0x6125, 2));
    assert_null(ect_measuring_link(&links, 0, 0x6132, 0));
    assert_true(ect_measuring_writes(&links, offsetof(values_t, process)));
    assert_true(ect_measuring_writes(&links, offsetof(values_t, wide)));
    assert_false(ect_measuring_writes(&links, offsetof(values_t, offset)));
    assert_false(ect_measuring_knows(0x8130));
    assert_true(ect_measuring_knows(0x6131));
}

static void zero_by_a_real_offset(void **state)
{
    (void)state;
    sensor.value = 0.0625;
    ect_measuring_written(&input, offsetof(values_t, autozero));
    is_close(values.process, 0);
    is_close((double)values.offset, -0.0625);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"process values in floating point keep their fraction, integers are rounded", fractions_stay, power_on, NULL,
         NULL},
        {"a process value stops at the limits of its entry", at_the_limits, power_on, NULL, NULL},
        {"points that are no numbers make the integer 0", not_a_number, power_on, NULL, NULL},
        {"an offset beyond all integers stops at the limits", huge_offset, power_on, NULL, NULL},
        {"a dictionary of VARs has one input", entries_of_a_var, power_on, NULL, NULL},
        {"6125h sets an offset in floating point exactly", zero_by_a_real_offset, power_on, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
