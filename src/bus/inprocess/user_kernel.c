/* SPDX-License-Identifier: MIT */
/* Copies that the kernel makes, for processors without instructions in user.c. */
#define _GNU_SOURCE
#include "bus/inprocess/user.h"

#include <errno.h>
#include <stdint.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

#include "bus/inprocess/real.h"

/* The kernel may lack the call, or a sandbox refuse it: the copy is then made here, unchecked. */
static bool result_of(ssize_t copied, int error, void *to, const void *from, size_t length)
{
    if (copied < 0 && errno != EFAULT)
        memcpy(to, from, length);
    bool whole = copied == (ssize_t)length || (copied < 0 && errno != EFAULT);
    errno = error;
    return whole;
}

bool ect_user_read(void *to, const void *from, size_t length)
{
    const struct iovec own = {.iov_base = to, .iov_len = length};
    const struct iovec its = {.iov_base = (void *)(uintptr_t)from, .iov_len = length};
    int error = errno;
    return length == 0 || result_of(process_vm_readv(getpid(), &own, 1, &its, 1, 0), error, to, from, length);
}

bool ect_user_write(void *to, const void *from, size_t length)
{
    const struct iovec own = {.iov_base = (void *)(uintptr_t)from, .iov_len = length};
    const struct iovec its = {.iov_base = to, .iov_len = length};
    int error = errno;
    return length == 0 || result_of(process_vm_writev(getpid(), &own, 1, &its, 1, 0), error, to, from, length);
}
