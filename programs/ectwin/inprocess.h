/* SPDX-License-Identifier: MIT */
/**
 * @file
 * `ectwin with --in-process`: the environment in which each process of CMD that opens the interface has a bus of its
 * own (bus/inprocess).
 */
#ifndef ECTWIN_INPROCESS_H
#define ECTWIN_INPROCESS_H

#include <stdbool.h>
#include <stddef.h>

enum { INPROCESS_MESSAGE = 1024 };

typedef struct in_process {
    bool virtual_time;  /**< of the two libraries, the one on the virtual clock */
    char *const *words; /**< options and devices, as the library takes them (bus/library.h) */
    int word_count;
    const char *command;           /**< the program that will run */
    const char *const *interfaces; /**< names */
    size_t interface_count;
    char folder[64]; /**< private: a folder for `mark`, the file that a bus marks when it starts, and for interfaces */
} in_process_t;

/**
 * Sets the environment of this process for CMD: LD_PRELOAD, in front of libraries that are there already, and the
 * variables of bus/inprocess/bus.h.
 * @param[out] message  on failure one line for the user; INPROCESS_MESSAGE bytes
 * @return false: a library is missing, or CMD is a program of another word size or processor; nothing has changed
 */
bool in_process_prepare(in_process_t *p, char *message);

/**
 * Removes the marks and files.
 * @param[in,out] met  set to true if each process with a bus has ended with all expectations of its scenario met
 * @return whether a process of CMD has had a bus
 */
bool in_process_finish(in_process_t *p, bool *met);

#endif
