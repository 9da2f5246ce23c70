/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The functions behind those that the library replaces, and the guard by which its own calls reach them.
 */
#ifndef ECT_BUS_INPROCESS_REAL_H
#define ECT_BUS_INPROCESS_REAL_H

#include <stdbool.h>

/** The next definition of a function behind this library, found once for each place of use. */
#define REAL(name)                                                                                                     \
    (__extension__({                                                                                                   \
        static void *found;                                                                                            \
        if (!found)                                                                                                    \
            found = ect_real(#name);                                                                                   \
        (__typeof__(&name))found;                                                                                      \
    }))

/** A replacement that the master's program sees. */
#define REPLACES __attribute__((visibility("default")))

/** Depth of the calls into the bus: inside, every replacement is the real function. */
extern __thread int ect_inside __attribute__((tls_model("initial-exec")));

/**
 * Whether this thread is in dlsym(). dlsym() frees memory, and an allocator (AddressSanitizer's) reads the clock there:
 * a second dlsym() within the first would free the same memory again.
 */
extern __thread bool ect_in_dlsym __attribute__((tls_model("initial-exec")));

/**
 * dlsym(RTLD_NEXT, name), during which every replacement is the real function, and no handler of a signal runs: one of
 * SIGCHLD may be the first to call waitpid(). SIGSYS alone is not blocked: system calls without the C library raise it.
 */
void *ect_real(const char *name);

#endif
