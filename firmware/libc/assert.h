/* SPDX-License-Identifier: MIT */
/** @file For a firmware with NDEBUG, where nothing is asserted: C11 §7.2. */
#ifndef NDEBUG
#error "without a C library an assertion has no output: define NDEBUG, or ECT_ASSERT_HOOK"
#endif
#undef assert
#define assert(condition) ((void)0)
#define static_assert     _Static_assert
