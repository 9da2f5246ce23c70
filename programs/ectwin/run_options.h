/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The options of `run` and `with` themselves, in one place: the commands take them from here, and so do the readers of
 * whole command lines, the library (library.c) and a replay (replay_file.c).
 */
#ifndef ECTWIN_RUN_OPTIONS_H
#define ECTWIN_RUN_OPTIONS_H

#include "commands.h"

/** Keys of the options of `with`; those of `run` are letters. */
enum {
    KEY_IFACE = 0x200,
    KEY_LEAVE_CHILDREN,
    KEY_EXTERNAL,
    KEY_IN_PROCESS,
    KEY_VIRTUAL_TIME,
    KEY_REQUIRE_PRIVATE,
    KEYS_OF_WITH_END, /**< behind the last one */
};

extern const struct argp_option run_options[];
extern const struct argp_option with_options[];

/** A command line of `with` up to its devices, of which only the twins count. Zero but `twins` at the start. */
typedef struct with_words {
    twin_args_t *twins;
    const char *devices;
    bool in_process, virtual_time;
} with_words_t;

/** Argp parser of such a line; its input is a with_words_t. The twins' devices are taken at its end. */
extern const struct argp with_words_argp;

/** Argp parser that takes the options of `run` and ignores them; without an input. */
extern const struct argp run_words_argp;

#endif
