/* SPDX-License-Identifier: MIT */
/* A user sets a signal (bus/chain/signals.h, seams/plant.h): the plant checks the value, the value is stored, the
 * plant is notified. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "bus/chain/signals.h"

typedef struct unit {
    uint16_t number;
    char text[9];
    const char *answer; /* of signal_write */
    struct {
        const ect_signal_t *signal;
        uint16_t group_number, number; /* the value as the instance held it */
        uint64_t now_ns;
    } checked, notified;
} unit_t;

static const ect_signal_t signals[] = {
    {"number", "a number", NULL, ECT_SIGNAL_U16, ECT_SIGNAL_WRITE, offsetof(unit_t, number), 0, 40000},
    {"text", "a text", NULL, ECT_SIGNAL_TEXT, ECT_SIGNAL_WRITE, offsetof(unit_t, text), 0, 8},
};
static const ect_signal_group_t groups[] = {
    {.signal_count = 2, .signals = signals},
    {.prefix = "part", .count = 2, .signal_count = 1, .signals = signals},
};

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    unit_t *u = instance;
    (void)value;
    u->checked.signal = signal;
    u->checked.group_number = number;
    u->checked.number = u->number;
    u->checked.now_ns = now_ns;
    return u->answer;
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    unit_t *u = instance;
    u->notified.signal = signal;
    u->notified.group_number = number;
    u->notified.number = u->number;
    u->notified.now_ns = now_ns;
}

static bool set(unit_t *u, const ect_plant_t *plant, const char *name, const char *value, char *message)
{
    ect_signal_ref_t ref;
    assert_true(ect_signal_find(plant, u, name, &ref));
    return ect_signal_write(&ref, value, 12345, message);
}

static const ect_plant_t plant = {
    .signal_groups = groups, .signal_group_count = 2, .signal_write = signal_write, .signal_written = signal_written};

static void checked_stored_notified(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    unit_t u = {.number = 1};
    (void)state;
    assert_true(set(&u, &plant, "part2.number", "40000", message));
    assert_ptr_equal(u.checked.signal, &signals[0]);
    assert_int_equal(u.checked.group_number, 2);
    assert_int_equal(u.checked.number, 1);
    assert_int_equal(u.checked.now_ns, 12345);
    assert_ptr_equal(u.notified.signal, &signals[0]);
    assert_int_equal(u.notified.group_number, 2);
    assert_int_equal(u.notified.number, 40000);
    assert_int_equal(u.notified.now_ns, 12345);
    assert_true(set(&u, &plant, "text", "12345678", message));
    assert_string_equal(u.text, "12345678");
    assert_ptr_equal(u.notified.signal, &signals[1]);
}

static void done_or_refused(void **state)
{
    static const char *const answers[] = {"", "not now"};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        char message[ECT_SIGNAL_MESSAGE] = "";
        unit_t u = {.number = 1, .answer = answers[i]};
        assert_int_equal(set(&u, &plant, "number", "2", message), i == 0);
        assert_string_equal(message, i == 0 ? "" : "number: not now");
        assert_ptr_equal(u.checked.signal, &signals[0]);
        assert_int_equal(u.number, 1);
        assert_null(u.notified.signal);
    }
}

static void out_of_range(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    unit_t u = {.number = 1};
    (void)state;
    assert_false(set(&u, &plant, "number", "40001", message));
    assert_non_null(strstr(message, "0..40000"));
    assert_null(u.checked.signal);
    assert_null(u.notified.signal);
    assert_int_equal(u.number, 1);
}

static void without_functions(void **state)
{
    static const ect_plant_t silent = {.signal_groups = groups, .signal_group_count = 2};
    char message[ECT_SIGNAL_MESSAGE];
    unit_t u = {.number = 1};
    (void)state;
    assert_true(set(&u, &silent, "number", "2", message));
    assert_int_equal(u.number, 2);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a value that a user sets: the plant checks it, then it is stored, then the plant is notified",
         checked_stored_notified, NULL, NULL, NULL},
        {"the plant has done it itself, or refuses: nothing is stored, no notification follows", done_or_refused, NULL,
         NULL, NULL},
        {"a value out of range does not come to the plant", out_of_range, NULL, NULL, NULL},
        {"a plant without functions: the value is stored", without_functions, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("signals", tests, NULL, NULL);
}
