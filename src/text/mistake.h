/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Mistake: the first mistake in a file written by a user, as one line `FILE:LINE: ERROR`. Readers continue after the
 * mistake, so that they need no error path, and check ::ect_mistake_t::failed at the end.
 *
 * Context: any. Cost: the characters of the line.
 */
#ifndef ECT_TEXT_MISTAKE_H
#define ECT_TEXT_MISTAKE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "wire/linkage.h"

/** The mistakes in one file. Set `path`, `text` and `room`, and zero the other members. */
typedef struct ect_mistake {
    const char *path; /**< as the user named the file */
    char *text;       /**< the line, zero-terminated, truncated at `room` */
    size_t room;      /**< bytes at `text`, at least 1 */
    bool failed;
} ect_mistake_t;

ECT_C_BEGIN

/** As ::ect_mistake. */
static inline void ect_mistake_of(ect_mistake_t *mistake, size_t line, const char *format, va_list values)
{
    char why[300];
    if (mistake->failed)
        return;
    mistake->failed = true;
    (void)vsnprintf(why, sizeof why, format, values);
    for (char *letter = why; *letter != '\0'; letter++)
        *letter = (unsigned char)*letter < ' ' || *letter == 0x7F ? '?' : *letter; /* in quotes from the file */
    (void)snprintf(mistake->text, mistake->room, "%s:%zu: %s", mistake->path, line, why);
}

/**
 * Reports a mistake, unless one has been reported before.
 * @param line    from 1
 * @param format  as of printf; control characters of the result become `?`
 */
__attribute__((format(printf, 3, 4))) static inline void ect_mistake(ect_mistake_t *mistake, size_t line,
                                                                     const char *format, ...)
{
    va_list values;
    va_start(values, format);
    ect_mistake_of(mistake, line, format, values);
    va_end(values);
}

ECT_C_END

#endif
