/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One line of JSON, written member by member into a room of fixed size: thousands of them are made while frames wait.
 *
 * A line is always whole and valid: what does not fit is cut inside its text, and a character that is not visible ASCII
 * is written as an escape (control characters) or as '?' (all others).
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

/** Begins a line. Then members, then ::ect_line_end. */
void ect_line_begin(ect_line_t *line);

/** A member that is text, in quotes. */
void ect_line_string(ect_line_t *line, const char *key, const char *value);

/** A member whose value is JSON already: a number, `true`, `false`. */
void ect_line_plain(ect_line_t *line, const char *key, const char *value);

/** A member that is a count. */
void ect_line_number(ect_line_t *line, const char *key, uint64_t value);

/** A member "time": seconds, to the microsecond. */
void ect_line_time(ect_line_t *line, uint64_t time_ns);

/** Closes it; line->text then ends with a line feed. */
void ect_line_end(ect_line_t *line);

ECT_C_END

#endif
