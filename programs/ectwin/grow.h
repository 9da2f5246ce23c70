/* SPDX-License-Identifier: MIT */
/** @file
 * Arrays that grow with the options and devices of a command line. */
#ifndef ECTWIN_GROW_H
#define ECTWIN_GROW_H

#include <argp.h>
#include <errno.h>
#include <stdlib.h>

#include "commands.h"

/**
 * Enlarges an array of `count` elements of `size` bytes by one element. Out of memory, the program ends with one line.
 * @param array  from the heap or NULL; the result replaces it
 * @return the array, to be freed with free()
 */
static inline void *grow(const struct argp_state *state, void *array, size_t count, size_t size)
{
    void *grown = realloc(array, (count + 1) * size);
    if (!grown)
        argp_failure(state, EXIT_RUN, ENOMEM, "too many options or devices");
    return grown;
}

#endif
