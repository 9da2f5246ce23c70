/* SPDX-License-Identifier: MIT */
/** @file
 * Numbers on the command line of a program that uses argp. */
#ifndef ECT_TEXT_ARGUMENT_H
#define ECT_TEXT_ARGUMENT_H

#include <argp.h>
#include <inttypes.h>

#include "text/number.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Reads the number of an option. Any other text ends the program with one line (argp_error).
 * @param option  its name in the line: "--seed"
 * @param minimum, maximum  inclusive
 */
static inline uint64_t ect_argument_number(const struct argp_state *state, const char *option, const char *text,
                                           uint64_t minimum, uint64_t maximum)
{
    uint64_t value = minimum;
    if (!ect_number(text, minimum, maximum, &value))
        argp_error(state, "%s takes a number from %" PRIu64 " to %" PRIu64 ", not '%s'", option, minimum, maximum,
                   text);
    return value;
}

ECT_C_END

#endif
