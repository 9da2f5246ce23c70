/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Bus files: a whole bus as one YAML file, read as the words of a command line that describe the same bus.
 *
 * ```yaml
 * ectwin: 1                          # version of the format
 * seed: 7                            # options of the bus, as of `ectwin run`
 * fault: [drop 1%, at 2.5s hang slave gripper]
 * connect: [axis.home=distance.data1]
 * twins:
 *   - device: esi:drives/servo.xml#SERVO
 *     name: axis
 *     alias: 17                      # options of a twin, as of `ectwin run` with N:
 *     set: {stop_positive: 100000}
 *   - device: fzm1
 *     name: gripper
 *     count: 3
 * ```
 *
 * The keys are the long options of the command, so that a file can describe every bus that the command line can. Paths
 * are relative to the file. A name of a twin stands for its number; several twins by `count` have the names gripper1,
 * gripper2, gripper3. The list of devices contains the names, to which the words refer.
 *
 * A file is refused with one line `FILE:LINE: ERROR`. Neither a referenced file nor a network is opened. Anchors,
 * aliases, tags and a second document are refused, so that the content never exceeds the size of the file, except by
 * `count`. A run writes only below the folder of the file, so that running a foreign file changes no other files.
 *
 * Host only. Context: mainline. Cost: linear in the bytes of the file and in the twins, quadratic in the names of
 * twins.
 */
#ifndef ECT_BUSES_BUS_FILE_H
#define ECT_BUSES_BUS_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "wire/linkage.h"

/** Limits. */
enum {
    ECT_BUS_FILE_BYTES = 1 << 20, /**< of a file */
    ECT_BUS_FILE_TWINS = 65535,   /**< of a bus */
    ECT_BUS_FILE_WORDS = 1 << 20, /**< options of a bus, those of `count` counted for each twin */
    ECT_BUS_FILE_NAME = 31,       /**< characters of the name of a twin */
};

/** The argument of an option; bits. */
typedef enum ect_bus_option {
    ECT_BUS_OPTION_NONE = 0,    /**< unknown option */
    ECT_BUS_OPTION_FLAG = 1,    /**< no argument: true or false in a file */
    ECT_BUS_OPTION_VALUE = 2,   /**< an argument, or a list if the option may be repeated */
    ECT_BUS_OPTION_PATH = 4,    /**< with ECT_BUS_OPTION_VALUE: a path, with OF_TWIN after the twin */
    ECT_BUS_OPTION_SOCKET = 16, /**< with ECT_BUS_OPTION_VALUE: a value may be a path behind `unix:` */
    ECT_BUS_OPTION_OF_TWIN = 8, /**< with ECT_BUS_OPTION_VALUE: may begin with the number of a twin and a colon */
    ECT_BUS_OPTION_OUTPUT = 32, /**< with ECT_BUS_OPTION_PATH or _SOCKET: a run writes to the path */
} ect_bus_option_t;

/** The options of the command. */
typedef struct ect_bus_options {
    /** @return the bits of the option with this long name */
    unsigned int (*find)(void *ctx, const char *name);
    void *ctx;
} ect_bus_options_t;

/** A file after reading. */
typedef struct ect_bus_file {
    char **words;       /**< options, "--seed=7" */
    size_t *lines;      /**< of the words, from 1 */
    size_t count;       /**< of words */
    char *devices;      /**< "axis=esi:/a/drives/servo.xml#SERVO,gripper=fzm1*3" */
    size_t *twin_lines; /**< of the devices of the twins, from 1 */
    size_t twins;
} ect_bus_file_t;

ECT_C_BEGIN

/** @return true for a name that ends in .yaml or .yml, and is neither a device, `yaml:FILE`, nor a list of them */
bool ect_bus_file_is(const char *name);

/** @return whether a path is below the folder that it is relative to: neither absolute nor with a part `..` */
bool ect_bus_file_below(const char *path);

/**
 * Reads a file.
 * @param path  a regular file of at most ::ECT_BUS_FILE_BYTES
 * @param[out] file  to be freed with ::ect_bus_file_free, also on failure
 * @param[out] text, room  the error, one line
 * @return false: the file cannot be read, is no YAML, or describes no bus
 */
bool ect_bus_file_read(ect_bus_file_t *file, const char *path, const ect_bus_options_t *options, char *text,
                       size_t room);

/** Reads a file from memory. @param path  prefix of messages; paths in the file are relative to its folder */
bool ect_bus_file_parse(ect_bus_file_t *file, const char *path, const void *data, size_t length,
                        const ect_bus_options_t *options, char *text, size_t room);

/** Frees the content of a file, and zeroes the structure. */
void ect_bus_file_free(ect_bus_file_t *file);

ECT_C_END

#endif
