/* SPDX-License-Identifier: MIT */
/** @file
 * The loaded objects of a process, and the system call instructions in them. */
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
    ect_text_t passed[ECT_TEXTS_MOST]; /**< texts without dispatch: the dynamic linker, the vDSO, sanitizers */
    size_t passed_count;
    bool has_calls;          /**< another object contains the instruction */
    unsigned long long adds; /**< objects loaded so far */
} ect_objects_t;

/** Searches all objects if the number of objects has grown. @param[in,out] its  zeroed before the first call */
void ect_objects_search(ect_objects_t *its);

/** @return whether an address is in a text whose system calls are not dispatched */
bool ect_objects_pass(const ect_objects_t *its, const void *address);

/** @return whether a text has a system call instruction shortly after an instruction that loads the number of a call;
 *          the two bytes of the former alone also occur inside other instructions */
bool ect_text_has_call(const uint8_t *text, size_t length);

#endif
