/* SPDX-License-Identifier: MIT */
/** @file Files that commands write, and what the commands that write of devices have in common. */
#ifndef ECTWIN_OUTPUT_H
#define ECTWIN_OUTPUT_H

#include "commands.h"

enum { OUTPUT_PATH = 4096 };

/**
 * Writes a file whole. On failure prints why.
 * @param path  NULL: standard output
 * @return EXIT_CLEAN or EXIT_OPEN
 */
int output_save(const char *who, const char *path, const void *data, size_t size);

/** FOLDER/NAME. @return whether it fits; that it does not is told */
bool output_path(const char *who, char path[OUTPUT_PATH], const char *folder, const char *name);

/** A text that becomes a file when it is whole. */
typedef struct output_text {
    FILE *file;
    char *text;
    size_t size;
} output_text_t;

/** @return `out->file` to print to, for ::output_close; NULL: there is no memory, which is told */
FILE *output_open(const char *who, output_text_t *out);
/** Writes it as ::output_save. @return EXIT_CLEAN, EXIT_OPEN; EXIT_RUN: there was no memory, which is told */
int output_close(const char *who, output_text_t *out, const char *path);

/** The image of a twin's EEPROM. @return `twin->device->sii_size` bytes for free(); NULL, and why was told */
uint8_t *output_image(const char *who, const ect_twin_config_t *twin);

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
