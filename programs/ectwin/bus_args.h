/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Bus files on a command line: `ectwin run bus.yaml`, `ectwin with bus.yaml -- CMD`.
 */
#ifndef ECTWIN_BUS_ARGS_H
#define ECTWIN_BUS_ARGS_H

#include <argp.h>
#include <stdbool.h>

#include "commands.h"

/**
 * Replaces a bus file, the first operand, by the devices and options that it describes. Options of the command line
 * follow those of the file, and therefore override them. If the file cannot be read, the program ends with EXIT_OPEN
 * and one line.
 * @param argp  the command's parser: its options, and whether each has an argument
 * @param[in,out] argc, argv  arguments of the command; the words of a file are valid until the program ends
 */
void bus_args_expand(const struct argp *argp, int *argc, char ***argv);

/**
 * Finds the path in the argument of an option: FILE, DIR, [N:]FILE[,loop], or unix:PATH if the option accepts it.
 * @param text  the argument, without N:
 * @return the beginning of the path; NULL: the argument has none
 */
const char *bus_option_path(const struct argp_option *option, const char *text);

/** @return whether the option has a path that a run writes; a bus file names only one below its folder for this */
bool bus_option_writes(const struct argp_option *option);

/** The bus that is the operand of a command. */
typedef struct bus_operand {
    twin_args_t twins;
    const char *devices; /**< as on the command line */
} bus_operand_t;

/**
 * Argp parser for a command whose operand is one bus, a bus file or devices: reads the operand and the options of
 * twins, the first child of the command's parser. A missing or second operand ends the program with one line.
 * @return ARGP_ERR_UNKNOWN: the key is neither that of an operand nor of the end
 */
error_t bus_operand_parse(bus_operand_t *bus, int key, char *text, struct argp_state *state);

#endif
