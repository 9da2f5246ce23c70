/* SPDX-License-Identifier: MIT */
/** @file The start of a user's command beside twins, for `with` and `enter`. */
#ifndef ECTWIN_LAUNCH_H
#define ECTWIN_LAUNCH_H

#include "bus/chain/crossing.h"

/** Exit statuses of a command that cannot run, as those of a shell. */
enum { LAUNCH_NOT_FOUND = 127, LAUNCH_NOT_EXECUTABLE = 126 };

/**
 * Replaces this process by a command. The names of the interfaces are in its environment and replace {} and {2} in its
 * arguments. A failure ends the process, with a line for the user.
 * @param who      first words of that line
 * @param command  ended by NULL
 * @param masters  names of the master's interfaces; [1] NULL: one
 * @param socket   path of the control socket; NULL: none
 */
_Noreturn void launch(const char *who, char **command, const char *const masters[ECT_ENDS], const char *socket);

#endif
