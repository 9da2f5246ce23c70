/* SPDX-License-Identifier: MIT */
/** @file A condition on a signal for `wait` and `watch --until`: NAME=VALUE, NAME!=VALUE, NAME<VALUE, NAME>VALUE. */
#ifndef ECTWIN_UNTIL_H
#define ECTWIN_UNTIL_H

#include <cjson/cJSON.h>
#include <stdbool.h>

typedef struct until {
    char name[128];
    char relation;     /**< '=', '!', '<', '>' */
    const char *value; /**< in the parsed text */
    bool has_number;
    double number;
    const char *slave; /**< number or name of the twin; "0": any. A name of a twin in `name` takes precedence */
    char current[256]; /**< last value passed to ::until_met */
} until_t;

/** Parses a condition. @return NULL, or the reason of a failure, one line for the user */
const char *until_read(until_t *until, const char *text);

/** @return whether a line of `watch` fulfils the condition; a line of another signal does not */
bool until_met(void *until, const cJSON *line);

#endif
