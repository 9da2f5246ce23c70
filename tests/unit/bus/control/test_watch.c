/* SPDX-License-Identifier: MIT */
/* Watched signals without a socket: the buffer of recorded changes, and the budget of a round (bus/control/watch.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "bus/control/watch.h"

enum { NOTES = 256 * 1024, HEADER = 16, MOST = 10 };

static const ect_plant_t plant;

static ect_signal_ref_t ref_of(const ect_signal_t *signal, uint8_t *value)
{
    ect_signal_ref_t ref = {.plant = &plant, .signal = signal, .value = value};
    strcpy(ref.name, signal->name);
    return ref;
}

static size_t count_notes(ect_watch_t *watch)
{
    unsigned int budget = 0;
    size_t count = 0;
    ect_line_t line;
    while (ect_watch_next(watch, &budget, 0, &line))
        count++;
    return count;
}

/* A change consists of time, signal and value. Values of 16 bytes fill the buffer exactly; values of 128 bytes leave a
 * rest that is too small. */
static void changes_are_recorded_while_there_is_room(void **state)
{
    static const unsigned int sizes[] = {1, 2, 16, 100, 127, 128};
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        const ect_signal_t signal = {.name = "bytes", .type = ECT_SIGNAL_BYTES, .maximum = (int)sizes[i]};
        const size_t most = NOTES / (HEADER + sizes[i]);
        uint8_t value[128] = {0};
        ect_watch_t *watch = ect_watch_new();
        const ect_signal_ref_t ref = ref_of(&signal, value);
        assert_true(ect_watch_add(watch, &ref, 0));
        ect_watch_every(watch);
        for (size_t n = 0; n < most; n++) {
            value[0]++;
            ect_watch_record(watch, n);
        }
        assert_false(ect_watch_lost(watch));
        value[0]++;
        ect_watch_record(watch, most);
        assert_true(ect_watch_lost(watch));
        assert_int_equal(count_notes(watch), most);
        ect_watch_free(watch);
    }
}

/* A client that reads: the room of sent changes is used again. */
static void changes_that_were_sent_leave_their_room(void **state)
{
    static const ect_signal_t signal = {.name = "bytes", .type = ECT_SIGNAL_BYTES, .maximum = 100};
    uint8_t value[100] = {0};
    ect_watch_t *watch = ect_watch_new();
    const ect_signal_ref_t ref = ref_of(&signal, value);
    (void)state;
    assert_true(ect_watch_add(watch, &ref, 0));
    ect_watch_every(watch);
    for (size_t n = 0; n < 2 * NOTES / (HEADER + 100); n++) {
        value[n % 100]++;
        ect_watch_record(watch, n);
        assert_true(ect_watch_pending(watch));
        assert_int_equal(count_notes(watch), 1);
        assert_false(ect_watch_pending(watch));
    }
    assert_false(ect_watch_lost(watch));
    ect_watch_free(watch);
}

/* A device may leave the rest of a longer text after the zero. */
static void texts_end_with_their_zero(void **state)
{
    static const ect_signal_t signal = {.name = "text", .type = ECT_SIGNAL_TEXT, .maximum = 7};
    static const struct {
        char before[8], after[8];
        bool changed;
    } rows[] = {{"ab", "ab\0cd", false}, {"ab", "ac", true},           {"ab", "a", true},
                {"ab", "abc", true},     {"abcdefg", "abcdefh", true}, {"\0x", "\0y", false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t value[8];
        unsigned int budget = 10;
        ect_line_t line;
        ect_watch_t *watch = ect_watch_new();
        const ect_signal_ref_t ref = ref_of(&signal, value);
        memcpy(value, rows[i].before, sizeof value);
        assert_true(ect_watch_add(watch, &ref, 0));
        memcpy(value, rows[i].after, sizeof value);
        ect_watch_round(watch);
        assert_int_equal(ect_watch_next(watch, &budget, 0, &line), rows[i].changed);
        ect_watch_free(watch);
    }
}

/* Compares with a budget. @return the reported signal; MOST: none */
static size_t next_of(ect_watch_t *watch, unsigned int *budget)
{
    ect_line_t line;
    char digit[2] = {0};
    if (!ect_watch_next(watch, budget, 0, &line))
        return MOST;
    const char *name = memchr(line.text, '#', line.length);
    assert_non_null(name);
    digit[0] = name[1];
    return (size_t)(digit[0] - '0');
}

/* A step of the loop compares as many signals as its budget allows; the next step continues after these. */
static void a_round_stops_at_its_budget(void **state)
{
    static const ect_signal_t signals[MOST] = {
        {.name = "#0", .type = ECT_SIGNAL_U8}, {.name = "#1", .type = ECT_SIGNAL_U8},
        {.name = "#2", .type = ECT_SIGNAL_U8}, {.name = "#3", .type = ECT_SIGNAL_U8},
        {.name = "#4", .type = ECT_SIGNAL_U8}, {.name = "#5", .type = ECT_SIGNAL_U8},
        {.name = "#6", .type = ECT_SIGNAL_U8}, {.name = "#7", .type = ECT_SIGNAL_U8},
        {.name = "#8", .type = ECT_SIGNAL_U8}, {.name = "#9", .type = ECT_SIGNAL_U8}};
    uint8_t values[MOST] = {0};
    ect_watch_t *watch = ect_watch_new();
    unsigned int budget = 4;
    (void)state;
    for (size_t i = 0; i < MOST; i++) {
        const ect_signal_ref_t ref = ref_of(&signals[i], &values[i]);
        assert_true(ect_watch_add(watch, &ref, 0));
    }
    assert_false(ect_watch_pending(watch));
    ect_watch_round(watch);
    assert_int_equal(next_of(watch, &budget), MOST); /* compares signals 0 to 3 */
    assert_int_equal(budget, 0);
    values[2] = values[5] = values[9] = 1;
    assert_int_equal(next_of(watch, &budget), MOST);
    budget = 1;
    assert_int_equal(next_of(watch, &budget), MOST); /* compares signal 4 */
    assert_int_equal(budget, 0);
    budget = 1;
    assert_int_equal(next_of(watch, &budget), 5);
    assert_true(ect_watch_pending(watch));
    budget = 100;
    assert_int_equal(next_of(watch, &budget), 9);
    assert_int_equal(next_of(watch, &budget), MOST);
    assert_false(ect_watch_pending(watch));
    ect_watch_round(watch);
    assert_int_equal(next_of(watch, &budget), 2);
    ect_watch_free(watch);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Changes of any size are recorded until the buffer is full, and then lost",
         changes_are_recorded_while_there_is_room, NULL, NULL, NULL},
        {"A sent change makes room for the next one", changes_that_were_sent_leave_their_room, NULL, NULL, NULL},
        {"A text has changed if it differs before its zero", texts_end_with_their_zero, NULL, NULL, NULL},
        {"A round compares as many signals as its budget allows, and continues in the next step",
         a_round_stops_at_its_budget, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Watch", tests, NULL, NULL);
}
