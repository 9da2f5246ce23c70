/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Characters of UTF-8 in texts of users and devices, which may contain any bytes.
 *
 * Context: any.
 */
#ifndef ECT_TEXT_UTF8_H
#define ECT_TEXT_UTF8_H

#include <stdbool.h>
#include <stddef.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Measures the well-formed sequence of two bytes or more (Unicode, table 3-7) at the beginning of a text.
 * @param text  terminated: a sequence cut by the end is not well-formed
 * @return 2, 3 or 4; 0: none
 */
static inline size_t ect_utf8_begins(const char *text)
{
    static const struct {
        unsigned char first, last, second_least, second_most, length;
    } forms[] = {{0xC2, 0xDF, 0x80, 0xBF, 2}, {0xE0, 0xE0, 0xA0, 0xBF, 3}, {0xE1, 0xEC, 0x80, 0xBF, 3},
                 {0xED, 0xED, 0x80, 0x9F, 3}, {0xEE, 0xEF, 0x80, 0xBF, 3}, {0xF0, 0xF0, 0x90, 0xBF, 4},
                 {0xF1, 0xF3, 0x80, 0xBF, 4}, {0xF4, 0xF4, 0x80, 0x8F, 4}};
    const unsigned char *at = (const unsigned char *)text;
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        if (at[0] < forms[i].first || at[0] > forms[i].last)
            continue;
        if (at[1] < forms[i].second_least || at[1] > forms[i].second_most)
            return 0;
        for (size_t n = 2; n < forms[i].length; n++) {
            if ((at[n] & 0xC0) != 0x80)
                return 0;
        }
        return forms[i].length;
    }
    return 0;
}

/**
 * @return whether a well-formed sequence is U+0080 to U+009F: control characters of a terminal, like those below the
 * space.
 */
static inline bool ect_utf8_controls(const char *sequence)
{
    return (unsigned char)sequence[0] == 0xC2 && (unsigned char)sequence[1] < 0xA0;
}

ECT_C_END

#endif
