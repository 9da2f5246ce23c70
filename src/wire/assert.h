/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Assertions: what only a mistake of our own caller, or of ourselves, can break. What comes from the bus or from a
 * medium never is one of them: it is answered, or counted.
 *
 * - `-DECT_ASSERT_HOOK=name`: a failure calls `void name(const char *file, unsigned int line, const char *condition)`,
 *   of the firmware: to stop safely, to log, to reset. Works with NDEBUG too. When it returns, what follows is
 * undefined.
 * - NDEBUG without a hook: nothing is compiled, nothing is evaluated.
 * - else: the C library's assert().
 */
#ifndef ECT_WIRE_ASSERT_H
#define ECT_WIRE_ASSERT_H

#include "wire/linkage.h"

#if defined(ECT_ASSERT_HOOK)
ECT_C_BEGIN
void ECT_ASSERT_HOOK(const char *file, unsigned int line, const char *condition);
ECT_C_END
#define ECT_ASSERT(condition) ((condition) ? (void)0 : ECT_ASSERT_HOOK(__FILE__, __LINE__, #condition))
#elif defined(NDEBUG)
#define ECT_ASSERT(condition) ((void)sizeof((condition) ? 1 : 0))
#else
#include <assert.h>
#define ECT_ASSERT(condition) assert(condition)
#endif

#endif
