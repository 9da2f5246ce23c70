/* SPDX-License-Identifier: MIT */
/*
 * Which blocks of a program run, for tools/dev/mutate.py: the compiler calls a function at the begin of each block
 * (-fsanitize-coverage=trace-pc), which marks the block's place in the program in the file REACHED. The file is in
 * memory before main: neither a sandbox nor a signal that ends the process keeps a mark from it, and programs that are
 * started by others mark it too.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stddef.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { SIZE = 1 << 24 }; /* of the file; code further back is left out */

extern const char __ehdr_start[] __attribute__((visibility("hidden"))); /* of this program or library alone */
void __sanitizer_cov_trace_pc(void) __attribute__((visibility("hidden")));

static char *marks;

/* System calls, because a library of `ectwin with --in-process` may be in the place of the functions. */
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
