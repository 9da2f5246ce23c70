/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The whole `ectwin` command as a function, for programs with devices of their own: `list`, `run`, `with` and all other
 * subcommands accept the names of these devices and of ectwin's. docs/DEVICE.md shows such a program.
 */
#ifndef ECTWIN_H
#define ECTWIN_H

#include <stddef.h>

#include "seams/plant.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Runs the command that the arguments name, as the program `ectwin` does.
 * @param argc, argv  the arguments of main(); the order of `argv` may change, the strings do not
 * @param products    `count` additional devices, which must be valid until the program ends; NULL with 0: none
 * @return the exit status: 0 clean · 1 wrong usage · 2 an interface or a file cannot be opened · 3 the run failed;
 *         for `with` the status of its command. Some errors call exit() with that status.
 * Context: main(), once, before other threads are started. Registers an atexit() handler that reports lost output.
 */
int ectwin_main(int argc, char **argv, const ect_product_t *products, size_t count);

ECT_C_END

#endif
