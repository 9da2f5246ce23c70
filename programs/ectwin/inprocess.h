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
    bool virtual_time;  /**< selects the library on the virtual clock */
    char *const *words; /**< options and devices for the library (bus/library.h) */
    int word_count;
    const char *command;           /**< the program of CMD */
    const char *const *interfaces; /**< names */
    size_t interface_count;
    char folder[64]; /**< private: folder of the file `mark`, which a bus writes when it starts, and of interfaces */
} in_process_t;

/**
 * Sets the environment of this process for CMD: LD_PRELOAD, with the library before existing ones, and the variables of
 * bus/inprocess/bus.h.
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
