/* SPDX-License-Identifier: MIT */
/* Calls of the operating system, which the linker replaces by calls of a test (-Wl,--wrap): each is recorded in a line,
 * and fails where the test requests it. */
#ifndef TESTS_BUS_NET_CALLS_H
#define TESTS_BUS_NET_CALLS_H

#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* The calls of a name that fail: bit 0 the first one. */
typedef struct failing {
    const char *call; /* NULL: none */
    unsigned int which;
    int error;
} failing_t;

enum { FIRST = 1, SECOND = 2, THIRD = 4, FOURTH = 8, ALL = -1, FAKE_FD = 1000, FAKE_FDS = 32 };

static struct calls {
    failing_t failing;
    unsigned int made; /* calls of the failing name */
    const char *opened[FAKE_FDS];
    size_t fds, open;
    size_t zero_at; /* the place of the descriptor that is 0, as without a standard input; from 1, 0: none */
    size_t used;
    char log[8192];
} calls;

static inline void begin_calls(failing_t failing)
{
    memset(&calls, 0, sizeof calls);
    calls.failing = failing;
}

__attribute__((format(printf, 1, 2))) static inline void note(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    calls.used += (size_t)vsnprintf(calls.log + calls.used, sizeof calls.log - calls.used, format, arguments);
    va_end(arguments);
    assert_true(calls.used < sizeof calls.log);
}

/* Whether this call fails, with errno set. */
static inline bool fails(const char *call)
{
    if (!calls.failing.call || strcmp(calls.failing.call, call) != 0)
        return false;
    bool now = (calls.failing.which >> calls.made++ & 1) != 0;
    errno = now ? calls.failing.error : errno;
    return now;
}

/* A descriptor that exists only in the test. */
static inline int fake_open(const char *name)
{
    assert_true(calls.fds < FAKE_FDS);
    calls.opened[calls.fds] = name;
    calls.open++;
    calls.fds++;
    return calls.fds == calls.zero_at ? 0 : FAKE_FD + (int)calls.fds - 1;
}

static inline bool is_fake(int fd)
{
    return (fd >= FAKE_FD && fd < FAKE_FD + (int)calls.fds) ||
           (fd == 0 && calls.zero_at > 0 && calls.zero_at <= calls.fds);
}

/* How many descriptors were opened before this one. */
static inline int place_of(int fd)
{
    return fd == 0 ? (int)calls.zero_at - 1 : fd - FAKE_FD;
}

static inline void fake_close(int fd)
{
    const int place = place_of(fd);
    if (!calls.opened[place])
        fail_msg("descriptor %d is closed twice", fd);
    calls.opened[place] = NULL;
    calls.open--;
}

#define EXPECT_LOG(title, want)                                                                                        \
    do {                                                                                                               \
        if (strcmp(calls.log, want) != 0)                                                                              \
            fail_msg("%s: expected the calls\n%s\ngot\n%s", title, want, calls.log);                                   \
    } while (0)

#endif
