/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Huge pages for the memory of many twins. A cycle of a thousand twins uses more pages of 4 KB than a processor keeps
 * translations for; with pages of 2 MB the cycle takes about a seventh less time.
 *
 * Linux only; elsewhere, and where the system refuses, nothing changes.
 */
#ifndef ECT_BUS_PAGES_H
#define ECT_BUS_PAGES_H

#include <stddef.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Size of a huge page of x86-64, and of aarch64 with pages of 4 KB. */
enum { ECT_PAGES_HUGE = 2 * 1024 * 1024 };

/**
 * Puts the huge pages that are entirely inside a block of memory into use, at once where the system can (Linux 6.1),
 * else at the next use of a page. The content stays unchanged. Unused parts of the block become allocated.
 *
 * Context: any; before system calls are restricted (bus/net/sandbox.h). errno stays unchanged.
 */
void ect_pages_make_huge(void *block, size_t size);

ECT_C_END

#endif
