/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Numbers typed by users: on a command line, in a fault, in an address.
 *
 * A number consists of decimal digits, or of 0x and hexadecimal digits; 010 is ten. A sign or a blank is invalid; the
 * locale has no effect. Context: any. Cost: linear in the digits.
 */
#ifndef ECT_TEXT_NUMBER_H
#define ECT_TEXT_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** @return the value of a digit; 255: not a digit */
static inline unsigned int ect_number_digit(char c)
{
    if (c >= '0' && c <= '9')
        return (unsigned int)(c - '0');
    if (c >= 'a' && c <= 'f')
        return (unsigned int)(c - 'a') + 10;
    return c >= 'A' && c <= 'F' ? (unsigned int)(c - 'A') + 10 : 255;
}

/**
 * Reads the number at the beginning of a text.
 * @param minimum, maximum  inclusive
 * @param[out] value  set on success
 * @return the text after the last digit; NULL: no number, or a number outside the range
 */
static inline const char *ect_number_begins(const char *text, uint64_t minimum, uint64_t maximum, uint64_t *value)
{
    unsigned int base = text[0] == '0' && (text[1] == 'x' || text[1] == 'X') ? 16 : 10;
    const char *at = base == 16 ? text + 2 : text;
    uint64_t number = 0;
    if (ect_number_digit(*at) >= base)
        return NULL;
    for (; ect_number_digit(*at) < base; at++) {
        unsigned int digit = ect_number_digit(*at);
        if (number > (UINT64_MAX - digit) / base)
            return NULL;
        number = number * base + digit;
    }
    if (number < minimum || number > maximum)
        return NULL;
    *value = number;
    return at;
}

/**
 * Reads a text that consists of a number.
 * @param minimum, maximum  inclusive
 * @param[out] value  set on success
 * @return whether the text is a number in the range
 */
static inline bool ect_number(const char *text, uint64_t minimum, uint64_t maximum, uint64_t *value)
{
    uint64_t number = 0;
    const char *end = ect_number_begins(text, minimum, maximum, &number);
    if (end == NULL || *end != 0)
        return false;
    *value = number;
    return true;
}

/**
 * Reads a duration: a number, 1 to 1000000, with a unit: us, ms or s.
 * @param[out] ns  set on success
 * @return whether the text is a duration
 */
static inline bool ect_number_time(const char *text, uint64_t *ns)
{
    static const struct {
        const char *unit;
        uint64_t ns;
    } units[] = {{"us", 1000}, {"ms", 1000000}, {"s", 1000000000}};
    uint64_t number = 0;
    const char *unit = ect_number_begins(text, 1, 1000000, &number);
    for (size_t i = 0; unit && i < sizeof units / sizeof units[0]; i++) {
        if (strcmp(unit, units[i].unit) == 0) {
            *ns = number * units[i].ns;
            return true;
        }
    }
    return false;
}

ECT_C_END

#endif
