/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/pages.h"

#include <errno.h>
#include <stdint.h>
#include <sys/mman.h>

#ifndef MADV_COLLAPSE /* C library older than the kernel */
#define MADV_COLLAPSE 25
#endif

void ect_pages_make_huge(void *block, size_t size)
{
    const int error = errno;
    const uintptr_t begin = (uintptr_t)block, end = begin + size;
    const uintptr_t first = (begin + ECT_PAGES_HUGE - 1) / ECT_PAGES_HUGE * ECT_PAGES_HUGE;
    const uintptr_t last = end / ECT_PAGES_HUGE * ECT_PAGES_HUGE;
    if (first < last && madvise((void *)first, last - first, MADV_HUGEPAGE) == 0)
        (void)madvise((void *)first, last - first, MADV_COLLAPSE);
    errno = error;
}
