/* SPDX-License-Identifier: MIT */
/** @file Files that commands write, and the common part of commands that write files of devices. */
#ifndef ECTWIN_OUTPUT_H
#define ECTWIN_OUTPUT_H

#include "commands.h"

enum { OUTPUT_PATH = 4096 };

/**
 * Writes a file. On failure prints the reason.
 * @param path  NULL: standard output
 * @return EXIT_CLEAN · EXIT_OPEN · EXIT_USAGE: binary data, and standard output is a terminal
 */
int output_save(const char *who, const char *path, const void *data, size_t size);

/** Writes FOLDER/NAME. @return false: it does not fit, which is printed */
bool output_path(const char *who, char path[OUTPUT_PATH], const char *folder, const char *name);

/** A text in memory, written to a file when it is complete. */
typedef struct output_text {
    FILE *file;
    char *text;
    size_t size;
} output_text_t;

/** @return `out->file` to print to, for ::output_close; NULL: out of memory, which is printed */
FILE *output_open(const char *who, output_text_t *out);
/** Writes the text as ::output_save does. @return as ::output_save; EXIT_RUN: out of memory, which is printed */
int output_close(const char *who, output_text_t *out, const char *path);

/** The image of a twin's EEPROM. @return `twin->device->sii_size` bytes for free(); NULL: the reason is printed */
uint8_t *output_image(const char *who, const ect_twin_config_t *twin);

/**
 * Writes one file of a device. @param path  NULL: standard output
 * @return EXIT_CLEAN, or an exit status, with the reason printed
 */
int output_esi(const char *who, const ect_twin_config_t *twin, const char *path);
int output_hex(const char *who, const ect_twin_config_t *twin, const char *path);
int output_document(const char *who, const ect_twin_config_t *twin, bool html, const char *path);

/** @return true: SOES supports the SyncManagers of the device */
bool output_suits_soes(const ect_device_t *device);
/** Writes the source for SOES, and the image of the EEPROM, to a folder. @return as ::output_esi */
int output_soes(const char *who, const ect_twin_config_t *twin, const char *folder);

/** The devices and the output file of a command; `key` and `value`: an option of the command, 0 and NULL: none. */
typedef struct output_args {
    twin_args_t twins;
    const char *devices;
    const char *output;
    int key;
    const char *value;
    bool given;   /**< the option `key` was given */
    bool several; /**< the command accepts more than one device */
    bool all;     /**< --all was given: each device of the catalogue */
} output_args_t;

/** Argp parser of devices and output file; its input is an output_args_t. */
error_t output_parse(int key, char *text, struct argp_state *state);

enum { OUTPUT_KEY_ALL = 0x200 };

/** The children of a parser with ::output_parse. */
extern const struct argp_child output_children[];

#endif
