/* SPDX-License-Identifier: MIT */
/** @file Bytes from a text of hexadecimal digits. */
#ifndef TESTS_SUPPORT_HEX_H
#define TESTS_SUPPORT_HEX_H

#include <stdint.h>
#include <stdlib.h>

/** Two digits are a byte; blanks between bytes are skipped. @return the number of bytes */
static inline uint16_t from_hex(const char *text, uint8_t *bytes)
{
    uint16_t count = 0;
    for (; *text != '\0'; text += *text == ' ' || text[1] == '\0' ? 1 : 2) {
        const char digits[3] = {text[0], text[0] == ' ' ? '\0' : text[1], '\0'};
        if (*text != ' ')
            bytes[count++] = (uint8_t)strtoul(digits, NULL, 16);
    }
    return count;
}

#endif
