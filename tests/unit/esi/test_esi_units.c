/* SPDX-License-Identifier: MIT */
/* Units of ETG.1004 as numbers and as their usual names. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "esi/units.h"

static void names(void **state)
{
    static const struct {
        const char *name;
        uint32_t unit;
    } rows[] = {
        {"m", 0x00010000},    {"mm", 0xFD010000},   {"um", 0xFA010000},   {"nm", 0xF7010000},    {"km", 0x03010000},
        {"MHz", 0x06200000},  {"s", 0x00030000},    {"ms", 0xFD030000},   {"A", 0x00040000},     {"K", 0x00050000},
        {"rad", 0x00100000},  {"N", 0x00210000},    {"kPa", 0x03220000},  {"kW", 0x03240000},    {"mV", 0xFD260000},
        {"kOhm", 0x03280000}, {"degC", 0x002D0000}, {"mm/s", 0xFD010300}, {"rad/s", 0x00100300}, {"mbar", 0xFD4E0000},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[40];
        uint32_t unit = 0;
        if (!ect_esi_unit_parse(rows[i].name, &unit) || unit != rows[i].unit)
            fail_msg("%s: expected 0x%08X, got 0x%08X", rows[i].name, (unsigned int)rows[i].unit, (unsigned int)unit);
        assert_string_equal(ect_esi_unit_text(rows[i].unit, text, sizeof text), rows[i].name);
    }
}

static void numbers(void **state)
{
    static const struct {
        const char *text;
        uint32_t unit;
    } rows[] = {{"0", 0}, {"65536", 0x10000}, {"0xFD010300", 0xFD010300}, {"4294967295", UINT32_MAX}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t unit = 1;
        assert_true(ect_esi_unit_parse(rows[i].text, &unit));
        assert_int_equal(unit, rows[i].unit);
    }
}

static void refused(void **state)
{
    static const char *const rows[] = {"", "k", "mile", "m/", "m/mile", "/s", "mm/mm", "-1", "4294967296", "degCC"};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t unit = 77;
        if (ect_esi_unit_parse(rows[i], &unit) || unit != 77)
            fail_msg("\"%s\": expected a refusal, got 0x%08X", rows[i], (unsigned int)unit);
    }
}

/* A power of ten without a prefix is written; a unit without a name is not. */
static void texts(void **state)
{
    static const struct {
        uint32_t unit;
        const char *text;
    } rows[] = {
        {0x02010000, "10^2 m"}, {0xFF010300, "10^-1 m/s"}, {0x00FF0000, NULL}, {0x0001FF00, NULL}, {0, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[40] = "old";
        const char *got = ect_esi_unit_text(rows[i].unit, text, sizeof text);
        if (rows[i].text == NULL && (got != NULL || *text != '\0'))
            fail_msg("0x%08X: expected no name, got \"%s\"", (unsigned int)rows[i].unit, text);
        if (rows[i].text != NULL && (got == NULL || strcmp(got, rows[i].text) != 0))
            fail_msg("0x%08X: expected \"%s\", got \"%s\"", (unsigned int)rows[i].unit, rows[i].text, text);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"a unit has the name that it is read from", names, NULL, NULL, NULL},
        {"a number is a unit", numbers, NULL, NULL, NULL},
        {"a text that is no unit is refused, and the unit stays", refused, NULL, NULL, NULL},
        {"a power of ten without a prefix; a unit without a name", texts, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("units of ETG.1004", tests, NULL, NULL);
}
