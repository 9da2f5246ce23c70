/* SPDX-License-Identifier: MIT */
/*
 * Marks the blocks of a program that run, for tools/dev/mutate.py: the compiler inserts a call at the beginning of each
 * block (-fsanitize-coverage=trace-pc), and the call marks the block's place in the file REACHED. The file is mapped
 * before main, so marks survive a sandbox and a signal that ends the process; child processes mark the same file.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stddef.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { SIZE = 1 << 24 }; /* of the file; code beyond is ignored */

extern const char __ehdr_start[] __attribute__((visibility("hidden"))); /* of this program or library alone */
void __sanitizer_cov_trace_pc(void) __attribute__((visibility("hidden")));

static char *marks;

/* Direct system calls, because a library of `ectwin with --in-process` may have replaced the functions. */
static void __attribute__((constructor(101))) begin(void)
{
    long fd = syscall(SYS_openat, AT_FDCWD, REACHED, O_RDWR | O_CLOEXEC);
    if (fd < 0)
        return;
    long at = syscall(SYS_mmap, NULL, (size_t)SIZE, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    (void)syscall(SYS_close, fd);
    if (at > 0 || at < -4096)
        marks = (char *)at;
}

void __sanitizer_cov_trace_pc(void)
{
    size_t place = (size_t)((const char *)__builtin_return_address(0) - __ehdr_start);
    if (marks && place < SIZE)
        marks[place] = 1;
}
