/* SPDX-License-Identifier: MIT */
/* UTF-8 in texts with any bytes (src/text/utf8.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "text/utf8.h"

/* The first and the last character of each well-formed kind. */
static void well_formed(void **state)
{
    static const char *const good[] = {"\xC2\x80",         "\xC2\xBF",         "\xC3\x80",         "\xC3\xBF",
                                       "\xDF\x80",         "\xDF\xBF",         "\xE0\xA0\x80",     "\xE0\xBF\xBF",
                                       "\xE1\x80\x80",     "\xEC\xBF\xBF",     "\xED\x80\x80",     "\xED\x9F\xBF",
                                       "\xEE\x80\x80",     "\xEF\xBF\xBF",     "\xF0\x90\x80\x80", "\xF0\xBF\xBF\xBF",
                                       "\xF1\x80\x80\x80", "\xF3\xBF\xBF\xBF", "\xF4\x80\x80\x80", "\xF4\x8F\xBF\xBF"};
    char more[8];
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        size_t length = strlen(good[i]);
        memset(more, 0x80, sizeof more);
        memcpy(more, good[i], length);
        if (ect_utf8_begins(good[i]) != length || ect_utf8_begins(more) != length)
            fail_msg("character %zu has %zu bytes, got %zu", i, length, ect_utf8_begins(good[i]));
    }
}

/* Their neighbours; characters that the end of the text cuts. */
static void other_bytes(void **state)
{
    static const char *const bad[] = {"",
                                      "\x1F",
                                      "a",
                                      "~",
                                      "\x7F",
                                      "\x80",
                                      "\xBF",
                                      "\xC1\xBF",
                                      "\xC2\x7F",
                                      "\xC2\xC0",
                                      "\xC3\x7F",
                                      "\xDF\xC0",
                                      "\xE0\x9F\xBF",
                                      "\xE0\xC0\x80",
                                      "\xE1\x7F\x80",
                                      "\xEC\xC0\x80",
                                      "\xED\x7F\x80",
                                      "\xED\xA0\x80",
                                      "\xEE\x7F\x80",
                                      "\xEF\xC0\x80",
                                      "\xF0\x8F\xBF\xBF",
                                      "\xF0\xC0\x80\x80",
                                      "\xF1\x7F\x80\x80",
                                      "\xF3\xC0\x80\x80",
                                      "\xF4\x7F\x80\x80",
                                      "\xF4\x90\x80\x80",
                                      "\xF5\x80\x80\x80",
                                      "\xFF\x80\x80\x80",
                                      "\xE1\x80\x7F",
                                      "\xE1\x80\xC0",
                                      "\xF1\x80\x80\x7F",
                                      "\xF1\x80\xC0\x80",
                                      "\xC3",
                                      "\xE2\x82",
                                      "\xF0\x9F\x99",
                                      "\xFC"};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        if (ect_utf8_begins(bad[i]) != 0)
            fail_msg("text %zu: expected none, got %zu bytes", i, ect_utf8_begins(bad[i]));
    }
}

static void controls(void **state)
{
    static const char *const yes[] = {"\xC2\x80", "\xC2\x9B", "\xC2\x9F"};
    static const char *const no[] = {"\xC2\xA0", "\xC3\x80", "\xE2\x80\x80"};
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        assert_true(ect_utf8_controls(yes[i]));
        assert_false(ect_utf8_controls(no[i]));
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"characters of two, three and four bytes, whatever follows", well_formed, NULL, NULL, NULL},
        {"ASCII, and bytes that are no UTF-8, are none", other_bytes, NULL, NULL, NULL},
        {"U+0080 to U+009F are control characters", controls, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("UTF-8", tests, NULL, NULL);
}
