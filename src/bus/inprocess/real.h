/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The real functions of the C library, and the guard that lets calls of this library reach them.
 */
#ifndef ECT_BUS_INPROCESS_REAL_H
#define ECT_BUS_INPROCESS_REAL_H

#include <pthread.h>
#include <stdbool.h>

/** The next definition of a function after this library's, found once at each place of use. */
#define REAL(name)                                                                                                     \
    (__extension__({                                                                                                   \
        static void *found;                                                                                            \
        if (!found)                                                                                                    \
            found = ect_real(#name);                                                                                   \
        (__typeof__(&name))found;                                                                                      \
    }))

/** Marks a replacement, visible to the master. */
#define REPLACES __attribute__((visibility("default")))

/** Depth of calls into the bus; above 0, each replacement calls the real function. */
extern __thread int ect_inside __attribute__((tls_model("initial-exec")));

/**
 * Makes the calls of this thread real, and none of them a cancellation point, until ::ect_leave: a thread that is
 * cancelled with the lock of the bus would keep it. @return the argument of ::ect_leave
 */
static inline int ect_enter(void)
{
    int before;
    (void)pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &before);
    ect_inside++;
    return before;
}

static inline void ect_leave(int before)
{
    ect_inside--;
    (void)pthread_setcancelstate(before, NULL);
}

/**
 * Whether this thread is in dlsym(). dlsym() frees memory, and an allocator (AddressSanitizer's) reads the clock there:
 * a second dlsym() within the first would free the same memory again.
 */
extern __thread bool ect_in_dlsym __attribute__((tls_model("initial-exec")));

/**
 * dlsym(RTLD_NEXT, name), during which each replacement calls the real function and no signal handler runs: a handler
 * of SIGCHLD may be the first to call waitpid(). Only SIGSYS is not blocked, because direct system calls raise SIGSYS.
 */
void *ect_real(const char *name);

#endif
