/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One line of JSON, written member by member into a buffer of fixed size, without allocation.
 *
 * A line is always complete and valid: a text that does not fit is truncated between two characters, a member that does
 * not fit is omitted, and texts are UTF-8. A control character of ASCII is written as an escape; '?' replaces invalid
 * UTF-8, U+007F and the control characters from U+0080 to U+009F.
 */
#ifndef ECT_BUS_CONTROL_LINE_H
#define ECT_BUS_CONTROL_LINE_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_LINE_ROOM = 1024 };

typedef struct ect_line {
    size_t length;
    char text[ECT_LINE_ROOM]; /**< not terminated */
} ect_line_t;

/** Begins a line. Then add members, and call ::ect_line_end. */
void ect_line_begin(ect_line_t *line);

/** Adds a member whose value is a string. */
void ect_line_string(ect_line_t *line, const char *key, const char *value);

/** Adds a member whose value is JSON: a number, `true`, `false`. */
void ect_line_plain(ect_line_t *line, const char *key, const char *value);

/** Adds a member whose value is an unsigned integer. */
void ect_line_number(ect_line_t *line, const char *key, uint64_t value);

/** Adds the member "time": seconds, to the microsecond. */
void ect_line_time(ect_line_t *line, uint64_t time_ns);

/** Ends the line, with a line feed in line->text. */
void ect_line_end(ect_line_t *line);

ECT_C_END

#endif
