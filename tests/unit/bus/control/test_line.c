/* SPDX-License-Identifier: MIT */
/* Lines of JSON in a buffer of fixed size (src/bus/control/line.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "bus/control/line.h"

static void assert_text(const ect_line_t *line, const char *want)
{
    assert_int_equal(line->length, strlen(want));
    assert_memory_equal(line->text, want, line->length);
}

static void members(void **state)
{
    ect_line_t line;
    (void)state;
    ect_line_begin(&line);
    ect_line_end(&line);
    assert_text(&line, "{}\n");
    ect_line_begin(&line);
    ect_line_time(&line, UINT64_MAX);
    ect_line_end(&line);
    assert_text(&line, "{\"time\":18446744073.709551}\n");
    ect_line_begin(&line);
    ect_line_string(&line, "a", "x\"y\\z\n\x7f\xc3");
    ect_line_plain(&line, "b", "true");
    ect_line_number(&line, "c", UINT64_MAX);
    ect_line_time(&line, 1000000000ull * 12 + 3456789);
    ect_line_end(&line);
    assert_text(&line, "{\"a\":\"x\\\"y\\\\z\\u000a??\",\"b\":true,\"c\":18446744073709551615,\"time\":12.003456}\n");
}

/* A text is truncated, a member that does not fit is omitted, and the line stays complete. */
static void full_lines(void **state)
{
    static char text[2 * ECT_LINE_ROOM];
    static const char fillers[] = "x\"\n";
    (void)state;
    for (size_t c = 0; fillers[c] != 0; c++) {
        for (size_t length = ECT_LINE_ROOM - 24; length < ECT_LINE_ROOM + 8; length++) {
            struct {
                ect_line_t line;
                uint8_t behind[8];
            } room;
            memset(&room, 0x5A, sizeof room);
            memset(text, fillers[c], length);
            text[length] = 0;
            ect_line_begin(&room.line);
            ect_line_string(&room.line, "t", text);
            ect_line_number(&room.line, "n", 123456);
            ect_line_plain(&room.line, "p", text);
            ect_line_end(&room.line);
            assert_true(room.line.length <= ECT_LINE_ROOM);
            assert_memory_equal(room.line.text, "{\"t\":\"", 6);
            assert_memory_equal(room.line.text + room.line.length - 2, "}\n", 2);
            assert_null(memchr(room.line.text, '\n', room.line.length - 1));
            for (size_t i = 0; i < sizeof room.behind; i++)
                assert_int_equal(room.behind[i], 0x5A);
        }
    }
}

/* Texts of users are UTF-8; '?' replaces other bytes, DEL and the control characters beyond ASCII. */
static void characters(void **state)
{
    static const struct {
        const char *value, *want;
    } rows[] = {
        {"at 0s hang slave 1 \xE2\x82\xAC", "{\"a\":\"at 0s hang slave 1 \xE2\x82\xAC\"}\n"},
        {"M\xC3\xBCller", "{\"a\":\"M\xC3\xBCller\"}\n"},
        {"\xF0\x9F\x99\x82.", "{\"a\":\"\xF0\x9F\x99\x82.\"}\n"},
        {"\xC2\xA0", "{\"a\":\"\xC2\xA0\"}\n"},
        {"\xC2\x80\xC2\x9Fx\x7F", "{\"a\":\"??x?\"}\n"},
        {"\xFCx", "{\"a\":\"?x\"}\n"},
        {"\xE2\x82", "{\"a\":\"??\"}\n"},
    };
    ect_line_t line;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_line_begin(&line);
        ect_line_string(&line, "a", rows[i].value);
        ect_line_end(&line);
        assert_text(&line, rows[i].want);
    }
}

/* Long texts of characters of two, three and four bytes. */
static void whole_characters(void **state)
{
    static const char *const fillers[] = {"\xC3\xBC", "\xE2\x82\xAC", "\xF0\x9F\x99\x82"};
    enum { HEAD = sizeof "{\"t\":\"" - 1, TAIL = sizeof "\"}\n" - 1, ONE = 4 };
    char text[ECT_LINE_ROOM + ONE];
    ect_line_t line;
    (void)state;
    for (size_t c = 0; c < sizeof fillers / sizeof fillers[0]; c++) {
        const size_t size = strlen(fillers[c]);
        for (size_t at = 0; at < ECT_LINE_ROOM; at += size)
            memcpy(text + at, fillers[c], size + 1);
        ect_line_begin(&line);
        ect_line_string(&line, "t", text);
        ect_line_end(&line);
        const size_t length = line.length - HEAD - TAIL;
        assert_int_equal(length % size, 0);
        assert_in_range(length, ECT_LINE_ROOM - 32, ECT_LINE_ROOM);
        assert_memory_equal(line.text + HEAD, text, length);
    }
}

/* The longest value that fits, and the next longer one; a space is not escaped. */
static void exact_room(void **state)
{
    enum { MOST = ECT_LINE_ROOM - 9 }; /* without {"p": and }, line feed, and the room reserved for a quote */
    static char text[ECT_LINE_ROOM];
    ect_line_t line;
    (void)state;
    for (size_t length = MOST - 1; length <= MOST + 1; length++) {
        memset(text, '7', length);
        text[length] = 0;
        ect_line_begin(&line);
        ect_line_plain(&line, "p", text);
        ect_line_end(&line);
        assert_int_equal(line.length, length <= MOST ? length + 7 : 3);
    }
    for (size_t length = MOST - 8; length <= MOST - 4; length++) { /* with a further member of six characters */
        memset(text, '7', length);
        text[length] = 0;
        ect_line_begin(&line);
        ect_line_plain(&line, "p", text);
        ect_line_string(&line, "s", "");
        ect_line_end(&line);
        assert_int_equal(line.length, length <= MOST - 6 ? length + 14 : length + 7);
    }
    memset(text, 'x', sizeof text - 1);
    ect_line_begin(&line);
    ect_line_string(&line, "a", text); /* truncated so that an escape would fit */
    ect_line_end(&line);
    assert_int_equal(line.length, ECT_LINE_ROOM - 6);
    ect_line_begin(&line);
    ect_line_string(&line, "a", " x \x1f~");
    ect_line_end(&line);
    assert_text(&line, "{\"a\":\" x \\u001f~\"}\n");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A line contains members of every kind, with escapes", members, NULL, NULL, NULL},
        {"A text that does not fit is truncated, and the line is complete", full_lines, NULL, NULL, NULL},
        {"A text of UTF-8 is written unchanged, any other byte as '?'", characters, NULL, NULL, NULL},
        {"A text is truncated between two characters of UTF-8", whole_characters, NULL, NULL, NULL},
        {"The longest member that fits is written, a longer one is omitted", exact_room, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Line", tests, NULL, NULL);
}
