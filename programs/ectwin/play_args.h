/* SPDX-License-Identifier: MIT */
/** @file The option --play: tables of signals, from CSV files. */
#ifndef ECTWIN_PLAY_ARGS_H
#define ECTWIN_PLAY_ARGS_H

#include "commands.h"

/**
 * Appends the table of "[N:]FILE[,loop][,every=TIME]" to the tables of the scenario. Ends the program with a line that
 * names the option where the words, the file or a line of it are wrong.
 */
void play_args_add(twin_args_t *args, const struct argp_state *state, const char *text);

#endif
