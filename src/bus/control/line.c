/* SPDX-License-Identifier: MIT */
#include "bus/control/line.h"
#include "text/utf8.h"
#include "wire/assert.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* Room reserved after a text for the quote and the end of the line. */
enum { END_ROOM = 3, ESCAPE_ROOM = 6 };

static void put(ect_line_t *line, const char *text, size_t length)
{
    ECT_ASSERT(line->length + length <= ECT_LINE_ROOM - END_ROOM);
    memcpy(line->text + line->length, text, length);
    line->length += length;
}

/* Writes the first character of a text. @return number of bytes read */
static size_t put_character(ect_line_t *line, const char *text)
{
    char escape[ESCAPE_ROOM + 1];
    unsigned char byte = (unsigned char)*text;
    size_t length = ect_utf8_begins(text);
    if (length > 0) {
        put(line, ect_utf8_controls(text) ? "?" : text, ect_utf8_controls(text) ? 1 : length);
        return length;
    }
    if (byte < ' ') {
        snprintf(escape, sizeof escape, "\\u%04x", byte);
        put(line, escape, ESCAPE_ROOM);
        return 1;
    }
    if (byte == '"' || byte == '\\')
        line->text[line->length++] = '\\';
    line->text[line->length++] = byte < 0x7F ? *text : '?';
    return 1;
}

/* Writes the key of a member with `length` bytes of value. @return false: no room, nothing is written */
static bool key_of(ect_line_t *line, const char *key, size_t length)
{
    size_t size = strlen(key);
    if (line->length + size + 4 + length + END_ROOM > ECT_LINE_ROOM)
        return false;
    if (line->length > 1)
        put(line, ",", 1);
    put(line, "\"", 1);
    put(line, key, size);
    put(line, "\":", 2);
    return true;
}

void ect_line_begin(ect_line_t *line)
{
    line->text[0] = '{';
    line->length = 1;
}

void ect_line_string(ect_line_t *line, const char *key, const char *value)
{
    if (!key_of(line, key, 2))
        return;
    line->text[line->length++] = '"';
    while (*value != 0 && line->length + ESCAPE_ROOM + 1 + END_ROOM <= ECT_LINE_ROOM)
        value += put_character(line, value);
    line->text[line->length++] = '"';
}

void ect_line_plain(ect_line_t *line, const char *key, const char *value)
{
    if (key_of(line, key, strlen(value)))
        put(line, value, strlen(value));
}

void ect_line_number(ect_line_t *line, const char *key, uint64_t value)
{
    char text[24];
    snprintf(text, sizeof text, "%" PRIu64, value);
    ect_line_plain(line, key, text);
}

void ect_line_time(ect_line_t *line, uint64_t time_ns)
{
    char text[32];
    snprintf(text, sizeof text, "%" PRIu64 ".%06" PRIu64, time_ns / 1000000000, time_ns / 1000 % 1000000);
    ect_line_plain(line, "time", text);
}

void ect_line_end(ect_line_t *line)
{
    ECT_ASSERT(line->length + 2 <= ECT_LINE_ROOM);
    line->text[line->length++] = '}';
    line->text[line->length++] = '\n';
}
