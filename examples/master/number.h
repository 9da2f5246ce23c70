/* SPDX-License-Identifier: MIT */
/** @file Numbers on the command lines of masters. */
#ifndef TOOLS_MASTER_NUMBER_H
#define TOOLS_MASTER_NUMBER_H

#include <argp.h>

/**
 * An option's number, in decimal (010 is ten). What is none, or more than `most`, ends the program with a line that
 * names the option.
 */
unsigned int number_of(const struct argp_state *state, const char *option, const char *text, unsigned int most);

#endif
