/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The whole `ectwin` command as a function, for a program that brings devices of its own: `list`, `run`, `with`, `get`,
 * `set` and all others know them by name, beside those of ectwin. docs/DEVICE.md shows such a program.
 */
#ifndef ECTWIN_H
#define ECTWIN_H

#include <stddef.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Runs the command that the arguments name, as the program `ectwin` does.
 * @param argc, argv  of main(); the strings stay the caller's, the order of `argv` may change
 * @param products    `count` devices more than ectwin's; they must live until the program ends. NULL with 0: none
 * @return what main() returns: 0 clean · 1 wrong usage · 2 an interface or a file cannot be opened · 3 the run failed ·
 *         of `with` the status of its command. Some errors end the process with that code at once.
 * Context: main(), once, before other threads are started. Registers an atexit() handler that reports lost output.
 */
int ectwin_main(int argc, char **argv, const ect_product_t *products, size_t count);

ECT_C_END

#endif
