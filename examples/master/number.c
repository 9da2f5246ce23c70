/* SPDX-License-Identifier: MIT */
#include "number.h"

#include <errno.h>
#include <stdlib.h>

unsigned int number_of(const struct argp_state *state, const char *option, const char *text, unsigned int most)
{
    char *end;
    errno = 0;
    unsigned long value = strtoul(text, &end, 10);
    if (*text < '0' || *text > '9' || *end != 0 || errno != 0 || value > most)
        argp_error(state, "%s takes a number up to %u, not '%s'", option, most, text);
    return (unsigned int)value;
}
