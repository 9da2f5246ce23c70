/* SPDX-License-Identifier: MIT */
/* The signals of a bus as the panel keeps them (programs/ectwin-panel/table.h): described once, changed by slave and
 * name. */
#include "table.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static table_t *table;

static int begin(void **state)
{
    (void)state;
    table = calloc(1, sizeof *table);
    return table ? 0 : -1;
}

static int finish(void **state)
{
    (void)state;
    table_clear(table);
    assert_int_equal(table->count, 0);
    free(table);
    return 0;
}

static bool fails; /* there is no memory for the next lines */
static bool no_memory;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);

void *__wrap_malloc(size_t size)
{
    return no_memory ? NULL : __real_malloc(size);
}

static bool add(const char *text)
{
    cJSON *line = cJSON_Parse(text);
    no_memory = fails;
    const bool added = table_add(table, text, line);
    no_memory = false;
    cJSON_Delete(line);
    return added;
}

static bool change(const char *text)
{
    cJSON *line = cJSON_Parse(text);
    cJSON_Hooks hooks = {.malloc_fn = __wrap_malloc, .free_fn = free};
    cJSON_InitHooks(&hooks);
    no_memory = fails;
    const bool changed = table_change(table, text, line);
    no_memory = false;
    cJSON_InitHooks(NULL);
    cJSON_Delete(line);
    return changed;
}

static void each_change_is_one_of_its_signal(void **state)
{
    (void)state;
    assert_true(add("{\"slave\":1,\"name\":\"a\"}"));
    assert_true(add("{\"slave\":1,\"name\":\"b\"}"));
    assert_true(add("{\"slave\":2,\"name\":\"a\",\"unit\":\"mm\"}"));
    assert_true(add("{\"slave\":2,\"name\":\"a\"}")); /* it exists already */
    assert_int_equal(table->count, 3);
    assert_string_equal(table->signals[2].text, "{\"slave\":2,\"name\":\"a\",\"unit\":\"mm\"}");
    assert_string_equal(table->signals[2].name, "a");
    assert_int_equal(table->signals[2].slave, 2);
    assert_int_equal(table->signals[0].changed, 0);
    assert_true(change("{\"slave\":1,\"name\":\"a\",\"value\":1}"));
    assert_true(change("{\"slave\":2,\"name\":\"a\",\"value\":2}"));
    assert_true(change("{\"slave\":1,\"name\":\"b\",\"value\":3}"));
    assert_true(change("{\"slave\":1,\"name\":\"a\",\"value\":4}"));
    for (size_t i = 0; i < 3; i++) {
        static const char *const values[] = {"4", "3", "2"};
        static const uint32_t changed[] = {4, 3, 2};
        assert_string_equal(table->signals[i].value, values[i]);
        assert_int_equal(table->signals[i].changed, changed[i]);
    }
}

static void without_memory_nothing_changes(void **state)
{
    (void)state;
    fails = true;
    assert_false(add("{\"slave\":1,\"name\":\"a\"}"));
    assert_int_equal(table->count, 0);
    fails = false;
    assert_true(add("{\"slave\":1,\"name\":\"a\"}"));
    assert_int_equal(table->count, 1);
    assert_true(change("{\"slave\":1,\"name\":\"a\",\"value\":5}"));
    fails = true;
    assert_false(change("{\"slave\":1,\"name\":\"a\",\"value\":6}"));
    assert_false(change("{\"slave\":1,\"name\":\"a\",\"value\":1234567890123456}"));
    fails = false;
    assert_string_equal(table->signals[0].value, "5");
    assert_int_equal(table->changes, 1);
    assert_int_equal(table->signals[0].changed, 1);
}

static size_t position(const char *text)
{
    cJSON *line = cJSON_Parse(text);
    const size_t found = table_find(table, line);
    cJSON_Delete(line);
    return found;
}

static void a_signal_is_found_by_slave_and_name(void **state)
{
    (void)state;
    assert_true(add("{\"slave\":1,\"name\":\"a\"}"));
    assert_true(add("{\"slave\":2,\"name\":\"a\"}"));
    assert_int_equal(position("{\"slave\":1,\"name\":\"a\"}"), 0);
    assert_int_equal(position("{\"slave\":2,\"name\":\"a\",\"value\":1}"), 1);
    assert_int_equal(position("{\"slave\":3,\"name\":\"a\"}"), TABLE_SIGNALS);
    assert_int_equal(position("{\"slave\":1,\"name\":\"b\"}"), TABLE_SIGNALS);
    assert_int_equal(position("{\"slave\":1}"), TABLE_SIGNALS);
}

static void lines_of_no_signal_are_refused(void **state)
{
    static const char *const descriptions[] = {"{\"slave\":0,\"name\":\"a\"}",
                                               "{\"slave\":-1,\"name\":\"a\"}",
                                               "{\"name\":\"a\"}",
                                               "{\"slave\":\"1\",\"name\":\"a\"}",
                                               "{\"slave\":1}",
                                               "{\"slave\":1,\"name\":7}"};
    static const char *const changes[] = {"{\"slave\":1,\"name\":\"b\",\"value\":1}",
                                          "{\"slave\":2,\"name\":\"a\",\"value\":1}", "{\"slave\":1,\"name\":\"a\"}",
                                          "{\"slave\":1,\"value\":1}", "{\"name\":\"a\",\"value\":1}"};
    (void)state;
    assert_false(change("{\"slave\":1,\"name\":\"a\",\"value\":1}")); /* there is none yet */
    for (size_t i = 0; i < sizeof descriptions / sizeof descriptions[0]; i++)
        assert_false(add(descriptions[i]));
    assert_int_equal(table->count, 0);
    assert_true(add("{\"slave\":1,\"name\":\"a\"}"));
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++)
        assert_false(change(changes[i]));
    assert_int_equal(table->changes, 0);
    assert_null(table->signals[0].value);
}

/* A browser's numbers are exact up to 15 digits. */
static void a_whole_number_of_more_than_15_digits_is_a_text(void **state)
{
    static const struct {
        const char *value, *kept;
    } rows[] = {
        {"0", "0"},
        {"-5", "-5"},
        {"1.5", "1.5"},
        {"true", "true"},
        {"\"1234567890123456\"", "\"1234567890123456\""},
        {"123456789012345", "123456789012345"},
        {"1234567890123456", "\"1234567890123456\""},
        {"-12345678901234567", "\"-12345678901234567\""},
        {"18446744073709551615", "\"18446744073709551615\""},
    };
    (void)state;
    assert_true(add("{\"slave\":1,\"name\":\"a\"}"));
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        char text[200];
        snprintf(text, sizeof text, "{\"slave\":1,\"name\":\"a\",\"value\":%s%s}", rows[i / 2].value,
                 i % 2 != 0 ? ",\"time\":1234567890123456" : "");
        assert_true(change(text));
        assert_string_equal(table->signals[0].value, rows[i / 2].kept);
    }
}

static void the_number_of_a_change_is_never_0(void **state)
{
    (void)state;
    assert_true(add("{\"slave\":1,\"name\":\"a\"}"));
    table->changes = UINT32_MAX - 1;
    assert_true(change("{\"slave\":1,\"name\":\"a\",\"value\":1}"));
    assert_true(table->signals[0].changed == UINT32_MAX);
    assert_true(change("{\"slave\":1,\"name\":\"a\",\"value\":2}"));
    assert_int_equal(table->signals[0].changed, 1);
}

static void a_full_table_takes_no_more(void **state)
{
    char text[100];
    (void)state;
    for (unsigned int i = 0; i < TABLE_SIGNALS; i++) {
        snprintf(text, sizeof text, "{\"slave\":%u,\"name\":\"s%u\"}", 1 + i % 3, i);
        assert_true(add(text));
    }
    assert_false(add("{\"slave\":1,\"name\":\"more\"}"));
    for (unsigned int i = 0; i < TABLE_SIGNALS; i++) {
        snprintf(text, sizeof text, "{\"slave\":%u,\"name\":\"s%u\",\"value\":%u}", 1 + i % 3, i, i);
        assert_true(change(text));
        assert_int_equal(table->signals[i].changed, i + 1);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_change_is_one_of_its_signal, begin, finish),
        cmocka_unit_test_setup_teardown(without_memory_nothing_changes, begin, finish),
        cmocka_unit_test_setup_teardown(a_signal_is_found_by_slave_and_name, begin, finish),
        cmocka_unit_test_setup_teardown(lines_of_no_signal_are_refused, begin, finish),
        cmocka_unit_test_setup_teardown(a_whole_number_of_more_than_15_digits_is_a_text, begin, finish),
        cmocka_unit_test_setup_teardown(the_number_of_a_change_is_never_0, begin, finish),
        cmocka_unit_test_setup_teardown(a_full_table_takes_no_more, begin, finish),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("the panel's table", tests, NULL, NULL);
}
