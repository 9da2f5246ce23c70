/* SPDX-License-Identifier: MIT */
/** @file
 * The objects of a process, and the instructions in them that make system calls. */
#ifndef ECT_BUS_INPROCESS_RAW_OBJECTS_H
#define ECT_BUS_INPROCESS_RAW_OBJECTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ect_text {
    uintptr_t begin, end;
} ect_text_t;

enum { ECT_TEXTS_MOST = 16 };

typedef struct ect_objects {
    ect_text_t c_library;
    ect_text_t
        passed[ECT_TEXTS_MOST]; /**< the dynamic linker, the kernel's own page, sanitizers: the system's own calls */
    size_t passed_count;
    bool has_calls;          /**< another object has the instruction */
    unsigned long long adds; /**< objects loaded so far */
} ect_objects_t;

/** Searches all objects, if there are more than at the last time. @param[in,out] its  zero at the first time */
void ect_objects_search(ect_objects_t *its);

/** Whether an address is in a text whose calls pass. */
bool ect_objects_pass(const ect_objects_t *its, const void *address);

/** Whether a text has the instruction that makes a system call, shortly behind one that loads the number of a call: the
 * two bytes alone occur in other instructions too. */
bool ect_text_has_call(const uint8_t *text, size_t length);

#endif
