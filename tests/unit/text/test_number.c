/* SPDX-License-Identifier: MIT */
/* Numbers that users type (src/text/number.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "text/number.h"

static void numbers(void **state)
{
    static const struct {
        const char *text;
        uint64_t minimum, maximum, value;
    } rows[] = {
        {"0", 0, 5, 0},
        {"5", 0, 5, 5},
        {"010", 0, 99, 10},
        {"0x10", 0, 99, 16},
        {"0XfF", 0, 255, 255},
        {"0xAbCdEf", 0, UINT32_MAX, 0xABCDEF},
        {"18446744073709551615", 0, UINT64_MAX, UINT64_MAX},
        {"0xffffffffffffffff", 0, UINT64_MAX, UINT64_MAX},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint64_t value = 77;
        if (!ect_number(rows[i].text, rows[i].minimum, rows[i].maximum, &value) || value != rows[i].value)
            fail_msg("'%s': got %llu", rows[i].text, (unsigned long long)value);
    }
}

static void others(void **state)
{
    static const char *const texts[] = {"",
                                        " 1",
                                        "1 ",
                                        "+1",
                                        "-1",
                                        "1.5",
                                        "0x",
                                        "0x ",
                                        "x1",
                                        "a",
                                        "1a",
                                        "0xg",
                                        "6",
                                        "2",
                                        "99999999999999999999",
                                        "18446744073709551616",
                                        "0x10000000000000000",
                                        "1:"};
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        uint64_t value = 77;
        if (ect_number(texts[i], 3, 5, &value))
            fail_msg("'%s' was read as %llu", texts[i], (unsigned long long)value);
        assert_int_equal(value, 77);
    }
}

static void beginnings(void **state)
{
    const char *text = "12:rest";
    uint64_t value = 77;
    (void)state;
    assert_ptr_equal(ect_number_begins(text, 1, 12, &value), text + 2);
    assert_int_equal(value, 12);
    assert_null(ect_number_begins(text, 1, 11, &value));
    assert_null(ect_number_begins(text, 13, 99, &value));
    assert_null(ect_number_begins(":", 0, 99, &value));
    assert_int_equal(value, 12);
}

/* Every character, whatever the locale. */
static void digits(void **state)
{
    static const char all[] = "0123456789abcdef", capitals[] = "ABCDEF";
    (void)state;
    for (unsigned int c = 0; c < 256; c++) {
        unsigned int expected = 255;
        for (unsigned int i = 0; i < 16; i++)
            expected = (char)c == all[i] ? i : expected;
        for (unsigned int i = 0; i < 6; i++)
            expected = (char)c == capitals[i] ? i + 10 : expected;
        if (ect_number_digit((char)c) != expected)
            fail_msg("character %u: expected %u, got %u", c, expected, ect_number_digit((char)c));
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"decimal, hexadecimal, up to 64 bits", numbers, NULL, NULL, NULL},
        {"other texts, and numbers outside the range, change nothing", others, NULL, NULL, NULL},
        {"ten digits, six letters of both sizes, and no other character", digits, NULL, NULL, NULL},
        {"a number at the beginning of a text", beginnings, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Number", tests, NULL, NULL);
}
