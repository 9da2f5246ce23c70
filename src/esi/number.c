/* SPDX-License-Identifier: MIT */
#include "esi/number.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

bool ect_esi_parse_number(const char *text, int64_t *value)
{
    bool hexadecimal = strncmp(text, "#x", 2) == 0 || strncmp(text, "#X", 2) == 0 || strncmp(text, "0x", 2) == 0 ||
                       strncmp(text, "0X", 2) == 0;
    const char *digits = hexadecimal ? text + 2 : text;
    if (*digits == '\0' || (hexadecimal && strspn(digits, "0123456789abcdefABCDEF") != strlen(digits)))
        return false;
    char *end;
    errno = 0;
    if (hexadecimal) {
        unsigned long long number = strtoull(digits, &end, 16);
        *value = (int64_t)number;
    } else {
        if (strspn(digits, "0123456789+-") != strlen(digits))
            return false;
        *value = strtoll(digits, &end, 10);
        if (errno == ERANGE && *digits != '-') { // an unsigned 64-bit number
            errno = 0;
            *value = (int64_t)strtoull(digits, &end, 10);
        }
    }
    return errno == 0 && *end == '\0';
}
