/* SPDX-License-Identifier: MIT */
/* Words of a line, and the message about a wrong one (bus/chain/words.h). */
#include "bus/chain/words.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static void messages(void **state)
{
    static const struct {
        size_t expected, found;             /* characters */
        size_t shown_expected, shown_found; /* of the message */
    } rows[] = {{0, 0, 0, 0},        {10, 60, 10, 60},    {10, 61, 10, 60},    {187, 100, 187, 60}, {188, 100, 188, 59},
                {214, 100, 214, 33}, {215, 100, 215, 32}, {216, 100, 215, 32}, {300, 100, 215, 32}, {300, 5, 215, 5}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char expected[301], found[101], want[400], message[ECT_WORDS_MESSAGE];
        ect_words_t words = {.message = message};
        memset(expected, 'e', sizeof expected);
        memset(found, 'f', sizeof found);
        expected[rows[i].expected] = found[rows[i].found] = 0;
        snprintf(want, sizeof want, "%.*s, not '%.*s'", (int)rows[i].shown_expected, expected, (int)rows[i].shown_found,
                 found);
        assert_false(ect_words_wrong(&words, expected, found));
        assert_string_equal(message, want);
    }
}

static void nothing_found(void **state)
{
    char message[ECT_WORDS_MESSAGE];
    ect_words_t words = {.message = message};
    (void)state;
    assert_false(ect_words_wrong(&words, "expected a word", NULL));
    assert_string_equal(message, "expected a word, not ''");
}

static void cuts(void **state)
{
    static const struct {
        const char *text;
        const char *words; /* joined by | */
        const char *message;
    } rows[] = {
        {"", "", NULL},
        {"  ", "", NULL},
        {"a", "a", NULL},
        {" a,bc, d", "a|bc|d", NULL},
        {"12345678", "12345678", NULL},
        {"123456789", NULL, "a line is at most 8 characters long, not '123456789'"},
        {"a b c d", NULL, "a line has at most 3 words, not 'a b c d'"},
    };
    static const ect_words_limits_t limits = {"a line", " ,", 8, 3};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_WORDS_MESSAGE] = "", got[64] = "";
        ect_words_t words = {.message = message};
        bool fine = ect_words_cut(&words, &limits, rows[i].text);
        for (; fine && ect_words_next(&words); words.at++)
            snprintf(got + strlen(got), sizeof got - strlen(got), "%s%s", words.at > 0 ? "|" : "",
                     ect_words_next(&words));
        if (fine != (rows[i].words != NULL) ||
            strcmp(fine ? got : message, fine ? rows[i].words : rows[i].message) != 0)
            fail_msg("'%s': got \"%s\"", rows[i].text, fine ? got : message);
    }
}

static void taken(void **state)
{
    static const ect_words_limits_t limits = {"a line", " ", 20, 3};
    char message[ECT_WORDS_MESSAGE];
    ect_words_t words = {.message = message};
    ect_names_t *names = ect_names_new(2);
    (void)state;
    assert_non_null(names);
    assert_true(ect_names_add(names, 1, "arm"));
    assert_true(ect_words_cut(&words, &limits, "at arm"));
    words.names = names;
    assert_int_equal(ect_words_take_twin(&words), 0);
    assert_false(ect_words_take(&words, "a"));
    assert_true(ect_words_take(&words, "at"));
    assert_false(ect_words_take(&words, "at"));
    assert_int_equal(ect_words_take_twin(&words), 2);
    assert_int_equal(ect_words_take_twin(&words), 0);
    assert_false(ect_words_take(&words, "arm"));
    assert_null(ect_words_next(&words));
    ect_names_free(names);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"a message about a word has at most 215 characters of the reason and 60 of the word", messages, NULL, NULL,
         NULL},
        {"a message about a missing word has an empty one", nothing_found, NULL, NULL, NULL},
        {"a line is cut at its separators, within its limits", cuts, NULL, NULL, NULL},
        {"a word is taken if it is the next one, or the name of a twin", taken, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("words of a line", tests, NULL, NULL);
}
