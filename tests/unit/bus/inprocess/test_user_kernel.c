/* SPDX-License-Identifier: MIT */
/* Copies by a kernel that is the test's. */
#define _GNU_SOURCE
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/uio.h>

#include <cmocka.h>

#include "bus/inprocess/user.h"

enum { PID = 77, LENGTH = 8 };

static struct {
    int error; /* of the kernel; 0: none */
    size_t copied;
    unsigned int reads, writes;
} kernel;

/* --- fakes ----------------------------------------------------------------------------------------------------------
 */

int fake_getpid(void)
{
    return PID;
}

/* @return the result of the call; its bytes are copied if there is no error */
static ssize_t copy(void *to, const void *from, size_t length)
{
    assert_int_equal(length, LENGTH);
    if (kernel.error != 0) {
        errno = kernel.error;
        return -1;
    }
    memcpy(to, from, kernel.copied);
    return (ssize_t)kernel.copied;
}

ssize_t fake_process_vm_readv(long pid, const struct iovec *own, unsigned long own_count, const struct iovec *its,
                              unsigned long its_count, unsigned long flags)
{
    kernel.reads++;
    assert_int_equal(pid, PID);
    assert_int_equal(own_count + its_count, 2);
    assert_int_equal(flags, 0);
    assert_int_equal(own->iov_len, its->iov_len);
    return copy(own->iov_base, its->iov_base, own->iov_len);
}

ssize_t fake_process_vm_writev(long pid, const struct iovec *own, unsigned long own_count, const struct iovec *its,
                               unsigned long its_count, unsigned long flags)
{
    kernel.writes++;
    assert_int_equal(pid, PID);
    assert_int_equal(own_count + its_count, 2);
    assert_int_equal(flags, 0);
    assert_int_equal(own->iov_len, its->iov_len);
    return copy(its->iov_base, own->iov_base, own->iov_len);
}

/* --- tests ----------------------------------------------------------------------------------------------------------
 */

/* A kernel without the call, or a sandbox, leaves the copy to the library. */
static void copies_as_the_kernel_does(void **state)
{
    static const struct {
        int error;
        size_t copied;
        bool whole, changed;
    } rows[] = {{0, LENGTH, true, true},
                {0, LENGTH - 1, false, true},
                {EFAULT, 0, false, false},
                {ENOSYS, 0, true, true},
                {EPERM, 0, true, true}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (unsigned int writes = 0; writes < 2; writes++) {
            static const char from[LENGTH] = "1234567";
            char to[LENGTH] = "";
            memset(&kernel, 0, sizeof kernel);
            kernel.error = rows[i].error;
            kernel.copied = rows[i].copied;
            errno = ERANGE;
            assert_int_equal(writes ? ect_user_write(to, from, LENGTH) : ect_user_read(to, from, LENGTH),
                             rows[i].whole);
            assert_int_equal(errno, ERANGE);
            assert_int_equal(kernel.writes, writes);
            assert_int_equal(kernel.reads, 1 - writes);
            assert_string_equal(to, rows[i].changed ? from : "");
        }
    }
}

static void copies_nothing_without_a_call(void **state)
{
    (void)state;
    memset(&kernel, 0, sizeof kernel);
    assert_true(ect_user_read(NULL, NULL, 0));
    assert_true(ect_user_write(NULL, NULL, 0));
    assert_int_equal(kernel.reads + kernel.writes, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A copy is whole, or a byte is at a bad address; errno stays", copies_as_the_kernel_does, NULL, NULL, NULL},
        {"A length of 0 needs no call", copies_nothing_without_a_call, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
