/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Places in the bus file of the command line: the line behind an option or a device, for errors.
 */
#ifndef ECTWIN_BUS_PLACE_H
#define ECTWIN_BUS_PLACE_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>

#include "buses/bus_file.h"

/** Room for a place: FILE:LINE behind the name of the command. */
enum { BUS_PLACE = 320 };

/** The state of a parser, for an option of a bus file. */
typedef struct bus_place {
    struct argp_state state;
    char name[BUS_PLACE];
} bus_place_t;

/**
 * Copies the state of a parser for one option. argp_error and argp_failure with the copy print one line that begins
 * with the line of the bus file: "ectwin run: bus.yaml:12: ...". Cost: the logarithm of the options of the file.
 * @param[out] place  the copy; must outlive the use of the result
 * @param text        argument of the option; of the command line, or NULL: the copy equals `state`
 * @return the copy
 */
struct argp_state *bus_place_at(bus_place_t *place, const struct argp_state *state, const char *text);

/** The same for the device of a twin. @param twin  its number, from 1 */
struct argp_state *bus_place_at_twin(bus_place_t *place, const struct argp_state *state, size_t twin);

/** The place of an option: "bus.yaml:12: ". @return room; of the command line, or NULL: "" */
const char *bus_place_of(char room[BUS_PLACE], const char *text);

/** The place of the device of a twin. @param twin  its number, from 1 @return room; without a bus file: "" */
const char *bus_place_of_twin(char room[BUS_PLACE], size_t twin);

/**
 * Makes the places of a bus file known.
 * @param path, file  must outlive the program's use of argp; the words of the file must stay where they are
 * @return false: no memory
 */
bool bus_place_open(const char *path, const ect_bus_file_t *file);

#endif
