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
 * come after those of the file, and therefore replace them.
 * @param argp  of the command: which options there are, and which of them take a value
 * @param[in,out] argc, argv  of the command; the words of a file live until the program ends
 * Ends the program with EXIT_OPEN and one line when the file cannot be read.
 */
void bus_args_expand(const struct argp *argp, int *argc, char ***argv);

/**
 * The path in an argument of an option: FILE, DIR, [N:]FILE[,loop], or unix:PATH where the option takes that.
 * @param text  the argument, without N:
 * @return where the path begins; NULL: the argument has none
 */
const char *bus_option_path(const struct argp_option *option, const char *text);

/** The bus that a command is about. */
typedef struct bus_operand {
    twin_args_t twins;
    const char *devices; /**< as on the command line */
} bus_operand_t;

/**
 * Parser of argp for a command about one bus, a bus file or devices: reads the operand and the options of twins, which
 * are the command's first child.
 * @return ARGP_ERR_UNKNOWN: neither the operand nor its end. A missing or second operand ends the program with one line
 */
error_t bus_operand_parse(bus_operand_t *bus, int key, char *text, struct argp_state *state);

#endif
