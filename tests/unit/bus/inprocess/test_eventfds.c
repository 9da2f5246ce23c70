/* SPDX-License-Identifier: MIT */
/* Eventfds of a child of fork(). */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "bus/inprocess/eventfds.h"
#include "fakes.h"

static int fake_fcntl(int fd, int command, ...)
{
    va_list arguments;
    va_start(arguments, command);
    int argument = va_arg(arguments, int);
    va_end(arguments);
    return (int)(command == F_SETFL   ? CALLED(set_flags, fd, argument)
                 : command == F_GETFL ? CALLED(get_flags, fd)
                                      : CALLED(get_fd_flags, fd, command == F_GETFD));
}

static int fake_dup3(int fd, int to, int flags)
{
    return (int)CALLED(dup3, fd, to, flags);
}

static int fake_close(int fd)
{
    return (int)CALLED(close, fd);
}

FAKES(FAKE(fcntl), FAKE(dup3), FAKE(close))

int fake_eventfd(unsigned int value, int flags);
int fake_eventfd(unsigned int value, int flags)
{
    assert_int_equal(flags, EFD_NONBLOCK);
    return (int)CALLED(eventfd, value);
}

static void renews(void **state)
{
    (void)state;
    plan("eventfd", 0, 0); /* any number is a descriptor */
    plan("get_flags", 0x802, 0);
    ect_eventfd_renew(20, false);
    EXPECT_CALLS("without event",
                 "eventfd(0) get_flags(20) set_flags(0,2050) get_fd_flags(20,1) dup3(0,20,0) close(0) ");
    plan("eventfd", 40, 0);
    plan("get_fd_flags", FD_CLOEXEC | 8, 0);
    ect_eventfd_renew(21, true);
    EXPECT_CALLS("with event, closed at exec",
                 "eventfd(1) get_flags(21) set_flags(40,0) get_fd_flags(21,1) dup3(40,21,524288) close(40) ");
    plan("eventfd", -1, EMFILE);
    ect_eventfd_renew(21, true);
    EXPECT_CALLS("none left", "eventfd(1) ");
}

static void replaces(void **state)
{
    (void)state;
    plan("get_fd_flags", 8, 0);
    ect_eventfd_replace(20, 23);
    EXPECT_CALLS("kept at exec", "get_fd_flags(20,1) dup3(23,20,0) ");
    plan("get_fd_flags", FD_CLOEXEC, 0);
    ect_eventfd_replace(20, 23);
    EXPECT_CALLS("closed at exec", "get_fd_flags(20,1) dup3(23,20,524288) ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("A descriptor is opened as one of a new eventfd, with its flags; it stays if none is left", renews),
        TEST("A descriptor is opened as a copy, with its own FD_CLOEXEC", replaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
