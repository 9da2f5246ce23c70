/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Assertions for conditions that only a mistake in this code or in its caller can violate. Data from the bus or from a
 * medium are never asserted: they get a reply, or are counted.
 *
 * - `-DECT_ASSERT_HOOK=name`: a failed assertion calls `void name(const char *file, unsigned int line,
 *   const char *condition)` of the firmware, which may stop safely, log or reset; with NDEBUG too. The behaviour after
 *   a return from the hook is undefined.
 * - NDEBUG without a hook: assertions generate no code, and their conditions are not evaluated.
 * - Otherwise: assert() of the C library.
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
