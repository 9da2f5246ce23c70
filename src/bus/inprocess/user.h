/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Memory of the program, as the kernel reads and writes it in a system call: a bad address is a result, EFAULT, and
 * does not end the program. Every address that the program passes to a replaced system call is accessed here alone.
 *
 * On x86-64 and 64-bit Arm (user.c), a copy costs a few instructions, and the handler of SIGSEGV and SIGBUS ends a copy
 * that faults. In a thread that blocks these signals the kernel ends the process. On other processors (user_kernel.c),
 * a copy is a system call.
 *
 * Context: any thread, signal handlers, with or without the lock.
 */
#ifndef ECT_BUS_INPROCESS_USER_H
#define ECT_BUS_INPROCESS_USER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * Copies from the program's memory.
 * @param length  0: no access
 * @return false: a byte cannot be read; `to` is then undefined
 */
bool ect_user_read(void *to, const void *from, size_t length);

/**
 * Copies into the program's memory.
 * @param length  0: no access
 * @return false: a byte cannot be written; bytes before may have been
 */
bool ect_user_write(void *to, const void *from, size_t length);

/** @return an address in the program's memory, which may be any number: the compiler derives nothing from its type */
static inline void *ect_user_at(const void *base, size_t offset)
{
    return (void *)((uintptr_t)base + offset);
}

/** Copies a string of the program. @return false: it is not readable, or has no end within `room` bytes */
static inline bool ect_user_string(char *to, const char *from, size_t room)
{
    for (size_t i = 0; i < room; i++) {
        if (!ect_user_read(&to[i], ect_user_at(from, i), 1))
            return false;
        if (to[i] == 0)
            return true;
    }
    return false;
}

#endif
