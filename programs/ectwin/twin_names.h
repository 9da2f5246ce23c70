/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Names of twins on the command line: "gripper=fzm1,axis=esi:servo.xml#SERVO*2" names gripper, axis1 and axis2.
 */
#ifndef ECTWIN_TWIN_NAMES_H
#define ECTWIN_TWIN_NAMES_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>

#include "bus/chain/names.h"

/** One part of a list of devices, between commas. */
typedef struct listed_device {
    const char *name; /**< NULL: none */
    const char *device;
    size_t count; /**< of equal twins, from 1 */
} listed_device_t;

/**
 * Reads the next part of a list. An invalid part ends the program with a line.
 * @param[in,out] rest  the unread part of the list, which is modified; NULL after the last part
 * @return false: the list is at its end
 */
bool listed_device_next(const struct argp_state *state, char **rest, listed_device_t *one);

/** @return the names in a list of devices, to be freed with ect_names_free; NULL: none */
ect_names_t *names_of_devices(const struct argp_state *state, const char *list);

/**
 * Removes "N:" or "NAME:" from the beginning of an option's text.
 * @param none  the result for a text without such a prefix
 * @return the number of the twin; 0: not from 1 to 65535
 */
size_t twin_of(const ect_names_t *names, const char **text, size_t none);

#endif
