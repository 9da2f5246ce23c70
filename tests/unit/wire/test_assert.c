/* SPDX-License-Identifier: MIT */
/* ECT_ASSERT with a hook of the firmware (wire/assert.h), with and without NDEBUG. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#ifndef NDEBUG
#define NDEBUG
#endif
#define ECT_ASSERT_HOOK failed
#include "wire/assert.h"

static struct {
    unsigned int calls, line;
    const char *file, *condition;
} last;

void failed(const char *file, unsigned int line, const char *condition)
{
    last.calls++;
    last.file = file;
    last.line = line;
    last.condition = condition;
}

static void hook(void **state)
{
    int length = 3;
    (void)state;
    ECT_ASSERT(length == 3);
    assert_int_equal(last.calls, 0);
    ECT_ASSERT(length == 4);
    assert_int_equal(last.line, __LINE__ - 1);
    assert_int_equal(last.calls, 1);
    assert_string_equal(last.condition, "length == 4");
    assert_non_null(strstr(last.file, "test_assert.c"));
}

/* As in a release build. */
#undef ECT_WIRE_ASSERT_H
#undef ECT_ASSERT_HOOK
#undef ECT_ASSERT
#include "wire/assert.h"

static void free_in_release(void **state)
{
    int evaluated = 0;
    (void)state;
    ECT_ASSERT(++evaluated == 2);
    assert_int_equal(evaluated, 0);
    assert_int_equal(last.calls, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"Assertions: a failure calls the firmware's hook with file, line and condition", hook, NULL, NULL, NULL},
        {"Assertions: without a hook and with NDEBUG nothing is evaluated", free_in_release, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("assertions", tests, NULL, NULL);
}
