/* SPDX-License-Identifier: MIT */
/* Direct system calls of the program that read the virtual clock, or wait. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/raw.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/user.h"

static const char vector_path[] = "/proc/self/auxv";

/* Converts a signal mask of the kernel, which is shorter than that of the C library; a sanitizer reads all of the
 * latter.
 * @param[out] mask  `room`; NULL: no mask @return false: a bad address */
static bool read_mask(const sigset_t **mask, sigset_t *room, long address)
{
    uint64_t its;
    *mask = NULL;
    if (address == 0)
        return true;
    if (!ect_user_read(&its, (const void *)address, sizeof its))
        return false;
    its = ect_action_mask(its);
    sigemptyset(room);
    memcpy(room, &its, sizeof its);
    *mask = room;
    return true;
}

static long make_clock_gettime(const long *a)
{
    return ect_raw_result(clock_gettime((clockid_t)a[0], (struct timespec *)a[1]));
}

static long make_gettimeofday(const long *a)
{
    return ect_raw_result(gettimeofday((struct timeval *)a[0], (void *)a[1]));
}

static long make_time(const long *a)
{
    return ect_raw_result(time((time_t *)a[0]));
}

static long make_nanosleep(const long *a)
{
    return ect_raw_result(nanosleep((const struct timespec *)a[0], (struct timespec *)a[1]));
}

static long make_clock_nanosleep(const long *a)
{
    return -clock_nanosleep((clockid_t)a[0], (int)a[1], (const struct timespec *)a[2], (struct timespec *)a[3]);
}

static long make_sched_yield(const long *a)
{
    (void)a;
    return sched_yield();
}

static long make_poll(const long *a)
{
    return ect_raw_result(poll((struct pollfd *)a[0], (nfds_t)a[1], (int)a[2]));
}

static long make_ppoll(const long *a)
{
    const sigset_t *mask;
    sigset_t room;
    if (!read_mask(&mask, &room, a[3]))
        return -EFAULT;
    return ect_raw_result(ppoll((struct pollfd *)a[0], (nfds_t)a[1], (const struct timespec *)a[2], mask));
}

static long make_select(const long *a)
{
    return ect_raw_result(select((int)a[0], (fd_set *)a[1], (fd_set *)a[2], (fd_set *)a[3], (struct timeval *)a[4]));
}

/* The sixth argument points to the address of the mask, before its length. */
static long make_pselect6(const long *a)
{
    const sigset_t *mask;
    sigset_t room;
    long its = 0;
    if ((a[5] != 0 && !ect_user_read(&its, (const void *)a[5], sizeof its)) || !read_mask(&mask, &room, its))
        return -EFAULT;
    return ect_raw_result(
        pselect((int)a[0], (fd_set *)a[1], (fd_set *)a[2], (fd_set *)a[3], (const struct timespec *)a[4], mask));
}

static long make_epoll_wait(const long *a)
{
    return ect_raw_result(epoll_wait((int)a[0], (struct epoll_event *)a[1], (int)a[2], (int)a[3]));
}

static long make_epoll_pwait(const long *a)
{
    const sigset_t *mask;
    sigset_t room;
    if (!read_mask(&mask, &room, a[4]))
        return -EFAULT;
    return ect_raw_result(epoll_pwait((int)a[0], (struct epoll_event *)a[1], (int)a[2], (int)a[3], mask));
}

int epoll_pwait2(int fd, struct epoll_event *events, int most, const struct timespec *timeout, const sigset_t *mask);
static long make_epoll_pwait2(const long *a)
{
    const sigset_t *mask;
    sigset_t room;
    if (!read_mask(&mask, &room, a[4]))
        return -EFAULT;
    return ect_raw_result(
        epoll_pwait2((int)a[0], (struct epoll_event *)a[1], (int)a[2], (const struct timespec *)a[3], mask));
}

static long make_timerfd_create(const long *a)
{
    return ect_raw_result(timerfd_create((clockid_t)a[0], (int)a[1]));
}

static long make_timerfd_settime(const long *a)
{
    return ect_raw_result(
        timerfd_settime((int)a[0], (int)a[1], (const struct itimerspec *)a[2], (struct itimerspec *)a[3]));
}

static long make_timerfd_gettime(const long *a)
{
    return ect_raw_result(timerfd_gettime((int)a[0], (struct itimerspec *)a[1]));
}

static long make_setitimer(const long *a)
{
    return ect_raw_result(setitimer((__itimer_which_t)a[0], (const struct itimerval *)a[1], (struct itimerval *)a[2]));
}

static long make_getitimer(const long *a)
{
    return ect_raw_result(getitimer((__itimer_which_t)a[0], (struct itimerval *)a[1]));
}

static long make_alarm(const long *a)
{
    return ect_raw_result(alarm((unsigned int)a[0]));
}

static long make_pause(const long *a)
{
    (void)a;
    return ect_raw_result(pause());
}

static long make_rt_sigsuspend(const long *a)
{
    const sigset_t *mask;
    sigset_t room;
    if (!read_mask(&mask, &room, a[0]))
        return -EFAULT;
    return ect_raw_result(sigsuspend(mask));
}

static long make_rt_sigtimedwait(const long *a)
{
    const sigset_t *mask;
    sigset_t room;
    if (!read_mask(&mask, &room, a[0]))
        return -EFAULT;
    return ect_raw_result(sigtimedwait(mask, (siginfo_t *)a[1], (const struct timespec *)a[2]));
}

static long make_wait4(const long *a)
{
    return ect_raw_result(wait4((pid_t)a[0], (int *)a[1], (int)a[2], (struct rusage *)a[3]));
}

static long make_futex(const long *a)
{
    return ect_raw_result(syscall(SYS_futex, a[0], a[1], a[2], a[3], a[4], a[5]));
}

static long make_waitid(const long *a)
{
    const ect_raw_call_t call = {.number = SYS_waitid, .a = {a[0], a[1], a[2], a[3], a[4]}};
    if (a[4] != 0) /* the C library's function lacks this argument */
        return ect_raw_pass(&call);
    return ect_raw_result(waitid((idtype_t)a[0], (id_t)a[1], (siginfo_t *)a[2], (int)a[3]));
}

static const ect_raw_entry_t table[] = {{SYS_clock_gettime, make_clock_gettime},
                                        {SYS_gettimeofday, make_gettimeofday},
                                        {SYS_time, make_time},
                                        {SYS_nanosleep, make_nanosleep},
                                        {SYS_clock_nanosleep, make_clock_nanosleep},
                                        {SYS_sched_yield, make_sched_yield},
                                        {SYS_poll, make_poll},
                                        {SYS_ppoll, make_ppoll},
                                        {SYS_select, make_select},
                                        {SYS_pselect6, make_pselect6},
                                        {SYS_epoll_wait, make_epoll_wait},
                                        {SYS_epoll_pwait, make_epoll_pwait},
                                        {SYS_epoll_pwait2, make_epoll_pwait2},
                                        {SYS_timerfd_create, make_timerfd_create},
                                        {SYS_timerfd_settime, make_timerfd_settime},
                                        {SYS_timerfd_gettime, make_timerfd_gettime},
                                        {SYS_setitimer, make_setitimer},
                                        {SYS_getitimer, make_getitimer},
                                        {SYS_alarm, make_alarm},
                                        {SYS_pause, make_pause},
                                        {SYS_rt_sigsuspend, make_rt_sigsuspend},
                                        {SYS_rt_sigtimedwait, make_rt_sigtimedwait},
                                        {SYS_wait4, make_wait4},
                                        {SYS_futex, make_futex},
                                        {SYS_waitid, make_waitid}};

/* Opens a file with the auxiliary vector. */
static long open_vector(long flags)
{
    enum { MOST = 64 };
    ElfW(auxv_t) vector[MOST + 1] = {{0}};
    int fd = REAL(open)(vector_path, O_RDONLY | O_CLOEXEC);
    ssize_t length = fd >= 0 ? REAL(read)(fd, vector, MOST * sizeof *vector) : -1;
    if (fd >= 0)
        REAL(close)(fd);
    int copy = length > 0 ? memfd_create("auxv", (flags & O_CLOEXEC) != 0 ? MFD_CLOEXEC : 0) : -1;
    if (copy < 0)
        return -errno;
    ect_raw_hide_vdso(vector);
    (void)!REAL(write)(copy, vector, (size_t)length);
    (void)lseek(copy, 0, SEEK_SET);
    return copy;
}

bool ect_raw_on_clock(const ect_raw_call_t *call, long *result)
{
    char path[sizeof vector_path];
    if (call->number == SYS_openat && ect_user_string(path, (const char *)call->a[1], sizeof path) &&
        strcmp(path, vector_path) == 0) {
        *result = open_vector(call->a[2]);
        return true;
    }
    return ect_raw_find(table, sizeof table / sizeof *table, call, result);
}
