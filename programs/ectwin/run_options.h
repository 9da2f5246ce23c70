/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The options of `run` and `with` except those of twins, for the commands and for the parsers of recorded command lines
 * (library.c, replay_file.c).
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
    KEY_PLANT,
    KEYS_OF_WITH_END, /**< after the last key */
};

extern const struct argp_option run_options[];
extern const struct argp_option with_options[];

/** A command line of `with` up to its devices. Initialise all members but `twins` to zero. */
typedef struct with_words {
    twin_args_t *twins;
    const char *devices;
    const char *plant; /**< the bus begins with this plant; NULL: at once */
    bool in_process, virtual_time;
} with_words_t;

/** Argp parser of a with_words_t, its input. The list of devices is parsed last. */
extern const struct argp with_words_argp;

/** Argp parser that accepts and ignores the options of `run`; without an input. */
extern const struct argp run_words_argp;

#endif
