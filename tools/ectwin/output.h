/* SPDX-License-Identifier: MIT */
/** @file Files that commands write, and what the commands that write of devices have in common. */
#ifndef ECTWIN_OUTPUT_H
#define ECTWIN_OUTPUT_H

#include "commands.h"

/**
 * Writes a file whole. On failure prints why.
 * @param path  NULL: standard output
 * @return EXIT_CLEAN or EXIT_OPEN
 */
int output_save(const char *who, const char *path, const void *data, size_t size);

/** Devices and where to write of them; `key` and `value` are the command's own option, 0 and NULL for none. */
typedef struct output_args {
    twin_args_t twins;
    const char *devices;
    const char *output;
    int key;
    const char *value;
    bool given;   /**< the own option was */
    bool several; /**< more than one device may be named */
    bool all;     /**< all of the catalogue, one after another, when none is named */
} output_args_t;

/** Argp parser of these; its input is an output_args_t. */
error_t output_parse(int key, char *text, struct argp_state *state);

enum { OUTPUT_KEY_ALL = 0x200 };

/** The children of such a parser. */
extern const struct argp_child output_children[];

#endif
