/* SPDX-License-Identifier: MIT */
/** @file A condition on a signal, as `wait` and `watch --until` take it: NAME=VALUE, NAME!=VALUE, NAME<VALUE,
 * NAME>VALUE. */
#ifndef ECTWIN_UNTIL_H
#define ECTWIN_UNTIL_H

#include <cjson/cJSON.h>
#include <stdbool.h>

typedef struct until {
    char name[128];
    char relation;     /**< '=', '!', '<', '>' */
    const char *value; /**< of the text that was read */
    bool has_number;
    double number;
    const char *slave; /**< number or name of the twin; "0": any. A name in `name` counts before it */
    char current[256]; /**< last value that ::until_met has seen */
} until_t;

/** Reads a condition. @return NULL; else why not, a line for the user */
const char *until_read(until_t *until, const char *text);

/** @return whether a line of `watch` fulfils the condition; a line of another signal does not */
bool until_met(void *until, const cJSON *line);

#endif
