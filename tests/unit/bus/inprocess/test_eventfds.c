/* SPDX-License-Identifier: MIT */
/* Objects behind descriptors: copies, ends, children. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <limits.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/time.h"
#include "fake_eventfds.h"
#include "fake_process.h"
#include "fakes.h"

/* Descriptors that are numbers only. */
enum { FD = 20, OTHER = 5, DESCRIPTORS = 65536 };

static int locked;

/* --- fakes -------------------------------------------------------------------------------------------------------- */

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

void ect_time_lock(void)
{
    assert_int_equal(locked++, 0);
}

void ect_time_unlock(void)
{
    assert_int_equal(--locked, 0);
}

/* --- two kinds of objects ----------------------------------------------------------------------------------------- */

typedef struct object {
    ect_eventfd_t event;
    int value;
} object_t;

static void closed(ect_eventfd_t *its, int fd)
{
    assert_int_equal(locked, 1);
    CALLED(closed, its->fd, fd);
    ect_eventfd_keep(its);
}

static bool inherited(ect_eventfd_t *its)
{
    return CALLED(inherited, its->fd) != 0;
}

static ect_eventfd_kind_t kind = {.size = sizeof(object_t), .closed = closed, .inherited = inherited};
static ect_eventfd_kind_t other_kind = {.size = sizeof(object_t), .closed = closed, .inherited = inherited};

static int begin(void **state)
{
    ect_eventfds_closed(0, UINT_MAX);
    return begin_fakes(state);
}

static ect_eventfd_t *opened(int fd)
{
    ect_eventfd_t *its = ect_eventfd_make(&kind);
    assert_non_null(its);
    plan("eventfd", fd, 0);
    assert_int_equal(ect_eventfd_open(its, EFD_NONBLOCK), fd);
    forget_calls();
    return its;
}

/* --- cases -------------------------------------------------------------------------------------------------------- */

static void opens(void **state)
{
    static const int fds[] = {0, FD, DESCRIPTORS - 1}; /* any number is a descriptor */
    (void)state;
    for (size_t i = 0; i < sizeof fds / sizeof *fds; i++) {
        ect_eventfd_t *its = ect_eventfd_make(&kind);
        assert_int_equal(its->fd, -1);
        assert_int_equal(its->descriptors, 0);
        plan("eventfd", fds[i], 0);
        assert_int_equal(ect_eventfd_open(its, 0x55), fds[i]);
        EXPECT_CALLS("open", "eventfd(0,85) ");
        assert_int_equal(its->fd, fds[i]);
        assert_int_equal(its->descriptors, 1);
        assert_ptr_equal(ect_eventfd_of(fds[i], &kind), its);
        assert_null(ect_eventfd_of(fds[i], &other_kind));
    }
    assert_null(ect_eventfd_of(-1, &kind));
    assert_null(ect_eventfd_of(DESCRIPTORS, &kind));
    assert_null(ect_eventfd_of(OTHER, &kind));
}

static void refuses_to_open(void **state)
{
    (void)state;
    ect_eventfd_t *its = ect_eventfd_make(&kind);
    plan("eventfd", -1, ENFILE);
    errno = 0;
    assert_int_equal(ect_eventfd_open(its, 0), -1);
    assert_int_equal(errno, ENFILE);
    EXPECT_CALLS("none is left", "eventfd(0,0) ");
    assert_ptr_equal(ect_eventfd_make(&kind), its);
    plan("eventfd", DESCRIPTORS, 0);
    assert_int_equal(ect_eventfd_open(its, 0), -1);
    assert_int_equal(errno, EMFILE);
    EXPECT_CALLS("too high", "eventfd(0,0) close(65536) ");
    assert_ptr_equal(ect_eventfd_make(&kind), its);
    assert_int_equal(its->descriptors, 0);
    ect_eventfd_keep(its);
}

/* The memory of a closed object is used again, for one of its kind; its other members are as they were. */
static void keeps_memory(void **state)
{
    (void)state;
    object_t *first = (object_t *)opened(FD), *second = (object_t *)opened(FD + 1);
    first->value = 1;
    ect_eventfds_closed(FD + 1, FD + 1);
    ect_eventfds_closed(FD, FD);
    forget_calls();
    object_t *other = (object_t *)ect_eventfd_make(&other_kind);
    assert_true(other != first && other != second && other->value == 0);
    ect_eventfd_keep(&other->event);
    assert_ptr_equal(ect_eventfd_make(&kind), first);
    assert_int_equal(first->value, 1);
    assert_ptr_equal(ect_eventfd_make(&kind), second);
    ect_eventfd_t *others[16];
    size_t count = 0;
    do {
        assert_true(count < 16);
        plan("calloc", 1, 0);
        others[count] = ect_eventfd_make(&kind);
    } while (others[count++]); /* closed by other cases */
    forget_calls();
    for (size_t i = 0; i + 1 < count; i++)
        ect_eventfd_keep(others[i]);
    ect_eventfd_keep(&first->event);
    ect_eventfd_keep(&second->event);
}

static void lives_as_long_as_a_copy(void **state)
{
    (void)state;
    ect_eventfd_t *its = opened(FD);
    ect_eventfd_copied(FD, 0);
    ect_eventfd_copied(0, DESCRIPTORS - 1);
    ect_eventfd_copied(FD, -1);
    ect_eventfd_copied(FD, DESCRIPTORS);
    ect_eventfd_copied(OTHER, OTHER + 1);
    ect_eventfd_copied(-1, OTHER + 1);
    ect_eventfd_copied(DESCRIPTORS, OTHER + 1);
    assert_int_equal(its->descriptors, 3);
    assert_null(ect_eventfd_of(OTHER + 1, &kind));
    ect_eventfds_closed(DESCRIPTORS - 1, DESCRIPTORS - 1);
    assert_int_equal(its->fd, FD);
    ect_eventfd_copied(FD, DESCRIPTORS - 1);
    ect_eventfds_closed(FD, FD);
    assert_int_equal(its->fd, 0);
    ect_eventfds_closed(0, 0);
    assert_int_equal(its->fd, DESCRIPTORS - 1);
    EXPECT_CALLS("a copy is left", "");
    ect_eventfds_closed(DESCRIPTORS - 1, UINT_MAX);
    EXPECT_CALLS("the last", "closed(-1,65535) ");
    assert_null(ect_eventfd_of(DESCRIPTORS - 1, &kind));
}

static void closes_a_range(void **state)
{
    static const struct {
        unsigned int from, to;
        const char *closed; /* of FD, FD + 1, FD + 2 */
    } rows[] = {{FD + 1, FD + 1, "closed(-1,21) "},
                {FD + 1, UINT_MAX, "closed(-1,21) closed(-1,22) "},
                {0, FD, "closed(-1,20) "},
                {0, FD - 1, ""},
                {FD + 3, UINT_MAX, ""},
                {0x80000000u, UINT_MAX, ""},
                {FD + 2, FD, ""}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        for (int n = 0; n < 3; n++)
            (void)opened(FD + n);
        ect_eventfds_closed(rows[i].from, rows[i].to);
        EXPECT_CALLS("a range", rows[i].closed);
        ect_eventfds_closed(0, UINT_MAX);
        forget_calls();
    }
}

/* Its memory is that of the program. */
static void ignores_a_child_of_vfork(void **state)
{
    (void)state;
    ect_eventfd_t *its = opened(FD);
    process++;
    ect_eventfd_copied(FD, OTHER);
    ect_eventfds_closed(FD, FD);
    EXPECT_CALLS("closed by the child", "");
    process--;
    assert_int_equal(its->descriptors, 1);
    ect_eventfds_closed(FD, FD);
    EXPECT_CALLS("closed by the parent", "closed(-1,20) ");
}

static void gets_eventfds_in_a_child(void **state)
{
    (void)state;
    (void)opened(FD);
    ect_eventfd_copied(FD, FD + 1);
    (void)opened(FD + 2);
    assert_non_null(in_child);
    process++;
    plan("eventfd", 0, 0); /* any number is a descriptor */
    plan("get_flags", 0x802, 0);
    plan("inherited", 0, 0);
    plan("inherited", 1, 0);
    plan("eventfd", 40, 0);
    plan("get_fd_flags", 8, 0);
    plan("get_fd_flags", FD_CLOEXEC | 8, 0);
    plan("get_fd_flags", FD_CLOEXEC, 0);
    in_child();
    EXPECT_CALLS(
        "each with its flags",
        "inherited(20) eventfd(0,2048) get_flags(20) set_flags(0,2050) get_fd_flags(20,1) dup3(0,20,0) close(0) "
        "inherited(22) eventfd(1,2048) get_flags(22) set_flags(40,0) get_fd_flags(22,1) dup3(40,22,524288) "
        "close(40) get_fd_flags(21,1) dup3(20,21,524288) ");
    plan("eventfd", -1, EMFILE);
    plan("eventfd", -1, EMFILE);
    in_child();
    EXPECT_CALLS("none is left", "inherited(20) eventfd(0,2048) inherited(22) eventfd(0,2048) get_fd_flags(21,1) "
                                 "dup3(20,21,0) ");
    ect_eventfds_closed(FD + 2, FD + 2);
    EXPECT_CALLS("closed by the child", "closed(-1,22) ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"An object is found by its descriptor and its kind", opens, begin, NULL, NULL},
        {"An object without an eventfd is kept for the next one", refuses_to_open, begin, NULL, NULL},
        {"An object gets the memory of a closed one of its kind", keeps_memory, begin, NULL, NULL},
        {"dup(2): an object lives as long as a copy of its descriptor", lives_as_long_as_a_copy, begin, NULL, NULL},
        {"close_range(2): the objects of a range of descriptors are closed", closes_a_range, begin, NULL, NULL},
        {"vfork(2): a child changes no objects", ignores_a_child_of_vfork, begin, NULL, NULL},
        {"fork(2): objects have eventfds of their own in a child", gets_eventfds_in_a_child, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
