/* SPDX-License-Identifier: MIT */
/* The functions of the C library behind those that a source of src/bus/inprocess replaces, for its unit test: each fake
 * is logged with its arguments and returns the result that the test has planned. in_process_source() of
 * tests/CMakeLists.txt gives the functions of a source other names, so that the test program itself keeps those of the
 * C library. No fake reaches the operating system: descriptors, processes and times are numbers of the test. */
#ifndef TESTS_BUS_INPROCESS_FAKES_H
#define TESTS_BUS_INPROCESS_FAKES_H

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus/inprocess/real.h"
#include "bus/inprocess/user.h"

/* Declares the replacement of a function, as in_process_source() names it. */
#define OURS(name) extern __typeof__(name) ours_##name

__thread int ect_inside __attribute__((tls_model("initial-exec")));
__thread bool ect_in_dlsym __attribute__((tls_model("initial-exec")));

enum { FAKES_PLANNED = 64 };

static struct fakes {
    size_t used, planned;
    struct {
        const char *name; /* NULL: used up */
        long result;
        int error; /* errno of the call; 0: unchanged */
    } plans[FAKES_PLANNED];
    char log[8192];
} fakes;

/* Plans the result of the next call of a name that has no plan yet. Without a plan, a call returns 0. */
__attribute__((unused)) static void plan(const char *name, long result, int error)
{
    assert_true(fakes.planned < FAKES_PLANNED);
    fakes.plans[fakes.planned].name = name;
    fakes.plans[fakes.planned].result = result;
    fakes.plans[fakes.planned++].error = error;
}

static long planned(const char *name)
{
    for (size_t i = 0; i < fakes.planned; i++) {
        if (!fakes.plans[i].name || strcmp(fakes.plans[i].name, name) != 0)
            continue;
        fakes.plans[i].name = NULL;
        errno = fakes.plans[i].error != 0 ? fakes.plans[i].error : errno;
        return fakes.plans[i].result;
    }
    return 0;
}

/* Logs a call with its arguments, all numbers. @return the planned result */
__attribute__((unused)) static long fake_call(const char *name, const long *arguments, size_t count)
{
    char *at = fakes.log + fakes.used;
    size_t room = sizeof fakes.log - fakes.used, length = 0;
    for (size_t i = 0; i < count && length < room; i++)
        length += (size_t)snprintf(at + length, room - length, "%s%s%ld", i == 0 ? name : "", i == 0 ? "(" : ",",
                                   arguments[i]);
    if (count == 0)
        length += (size_t)snprintf(at, room, "%s(", name);
    length += length < room ? (size_t)snprintf(at + length, room - length, ") ") : 0;
    fakes.used += length < room ? length : 0; /* a full log keeps its beginning, which no test expects */
    return planned(name);
}

#define CALLED(name, ...)                                                                                              \
    fake_call(#name, (const long[]){0, __VA_ARGS__} + 1, sizeof((const long[]){0, __VA_ARGS__}) / sizeof(long) - 1)

static void forget_calls(void)
{
    memset(&fakes, 0, sizeof fakes);
}

/* Memory of the program: an address below a page, as of AT(), and the address that a test names are bad. */
static struct {
    const void *unreadable, *unwritable;
} bad_memory;

static bool is_good(const void *address, const void *its_bad)
{
    return (uintptr_t)address >= 4096 && address != its_bad;
}

bool ect_user_read(void *to, const void *from, size_t length)
{
    bool good = length == 0 || is_good(from, bad_memory.unreadable);
    if (good && length > 0)
        memcpy(to, from, length);
    return good;
}

bool ect_user_write(void *to, const void *from, size_t length)
{
    bool good = length == 0 || is_good(to, bad_memory.unwritable);
    if (good && length > 0)
        memcpy(to, from, length);
    return good;
}

/* Each test begins and ends with no call logged. */
__attribute__((unused)) static int begin_fakes(void **state)
{
    (void)state;
    forget_calls();
    ect_inside = 0;
    ect_in_dlsym = false;
    memset(&bad_memory, 0, sizeof bad_memory);
    errno = 0;
    return 0;
}

/* Compares the calls since the previous comparison, "name(1,2) name() ", and that each planned result was used. */
#define EXPECT_CALLS(title, want)                                                                                      \
    do {                                                                                                               \
        if (strcmp(fakes.log, want) != 0)                                                                              \
            fail_msg("%s: expected the calls\n%s\ngot\n%s", title, want, fakes.log);                                   \
        for (size_t plan_ = 0; plan_ < fakes.planned; plan_++) {                                                       \
            if (fakes.plans[plan_].name)                                                                               \
                fail_msg("%s: no further call of %s", title, fakes.plans[plan_].name);                                 \
        }                                                                                                              \
        forget_calls();                                                                                                \
    } while (0)

/* The table that ect_real() searches: FAKES(FAKE(read), FAKE(write)). */
typedef struct fake {
    const char *name;
    void *function;
} fake_t;

#define FAKE(called) {#called, __extension__(void *) fake_##called}

#define FAKES(...)                                                                                                     \
    void *ect_real(const char *name)                                                                                   \
    {                                                                                                                  \
        static const fake_t table[] = {__VA_ARGS__};                                                                   \
        return fake_of(table, sizeof table / sizeof *table, name);                                                     \
    }

__attribute__((unused)) static void *fake_of(const fake_t *table, size_t count, const char *name)
{
    for (size_t i = 0; i < count; i++) {
        if (strcmp(table[i].name, name) == 0)
            return table[i].function;
    }
    fprintf(stderr, "the test has no fake of %s\n", name);
    abort();
}

/* A function of up to six words, whatever their types: each is a register of its own. */
#define FAKE_1(name)                                                                                                   \
    long fake_##name(long a)                                                                                           \
    {                                                                                                                  \
        return CALLED(name, a);                                                                                        \
    }
#define FAKE_2(name)                                                                                                   \
    long fake_##name(long a, long b)                                                                                   \
    {                                                                                                                  \
        return CALLED(name, a, b);                                                                                     \
    }
#define FAKE_3(name)                                                                                                   \
    long fake_##name(long a, long b, long c)                                                                           \
    {                                                                                                                  \
        return CALLED(name, a, b, c);                                                                                  \
    }
#define FAKE_4(name)                                                                                                   \
    long fake_##name(long a, long b, long c, long d)                                                                   \
    {                                                                                                                  \
        return CALLED(name, a, b, c, d);                                                                               \
    }
#define FAKE_5(name)                                                                                                   \
    long fake_##name(long a, long b, long c, long d, long e)                                                           \
    {                                                                                                                  \
        return CALLED(name, a, b, c, d, e);                                                                            \
    }
#define FAKE_6(name)                                                                                                   \
    long fake_##name(long a, long b, long c, long d, long e, long f)                                                   \
    {                                                                                                                  \
        return CALLED(name, a, b, c, d, e, f);                                                                         \
    }

/* An address that no code reads, of a value that the compiler cannot derive. */
__attribute__((unused)) static void *AT(long number)
{
    volatile long address = number;
    return (void *)address;
}

#define TEST(title, function) {title, function, begin_fakes, NULL, NULL}

#endif
