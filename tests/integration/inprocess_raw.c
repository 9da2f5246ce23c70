/* SPDX-License-Identifier: MIT */
/*
 * The functions that inprocess_calls.c calls, as a program without the C library makes them: system calls of its own.
 * They are hidden, so that they hold in this program alone.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "raw_call.h"

#define HIDDEN __attribute__((visibility("hidden")))

enum { KERNEL_MASK = 8 };

static long make(long number, long a, long b, long c, long d, long e, long f)
{
    long result = raw_call(number, a, b, c, d, e, f);
    if (result > -4096 && result < 0) {
        errno = (int)-result;
        return -1;
    }
    return result;
}

HIDDEN int socket(int domain, int type, int protocol)
{
    return (int)make(SYS_socket, domain, type, protocol, 0, 0, 0);
}

HIDDEN int bind(int fd, __CONST_SOCKADDR_ARG address, socklen_t length)
{
    return (int)make(SYS_bind, fd, (long)address.__sockaddr__, length, 0, 0, 0);
}

HIDDEN int setsockopt(int fd, int level, int name, const void *value, socklen_t length)
{
    return (int)make(SYS_setsockopt, fd, level, name, (long)value, length, 0);
}

HIDDEN int getsockopt(int fd, int level, int name, void *restrict value, socklen_t *restrict length)
{
    return (int)make(SYS_getsockopt, fd, level, name, (long)value, (long)length, 0);
}

HIDDEN int getsockname(int fd, __SOCKADDR_ARG address, socklen_t *restrict length)
{
    return (int)make(SYS_getsockname, fd, (long)address.__sockaddr__, (long)length, 0, 0, 0);
}

HIDDEN int ioctl(int fd, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    long argument = va_arg(arguments, long);
    va_end(arguments);
    return (int)make(SYS_ioctl, fd, (long)request, argument, 0, 0, 0);
}

HIDDEN int fcntl(int fd, int command, ...)
{
    va_list arguments;
    va_start(arguments, command);
    long argument = va_arg(arguments, long);
    va_end(arguments);
    return (int)make(SYS_fcntl, fd, command, argument, 0, 0, 0);
}

HIDDEN ssize_t send(int fd, const void *data, size_t size, int flags)
{
    return (ssize_t)make(SYS_sendto, fd, (long)data, (long)size, flags, 0, 0);
}

HIDDEN ssize_t sendto(int fd, const void *data, size_t size, int flags, __CONST_SOCKADDR_ARG to, socklen_t length)
{
    return (ssize_t)make(SYS_sendto, fd, (long)data, (long)size, flags, (long)to.__sockaddr__, length);
}

HIDDEN ssize_t sendmsg(int fd, const struct msghdr *message, int flags)
{
    return (ssize_t)make(SYS_sendmsg, fd, (long)message, flags, 0, 0, 0);
}

HIDDEN int sendmmsg(int fd, struct mmsghdr *messages, unsigned int count, int flags)
{
    return (int)make(SYS_sendmmsg, fd, (long)messages, count, flags, 0, 0);
}

HIDDEN ssize_t write(int fd, const void *data, size_t size)
{
    return (ssize_t)make(SYS_write, fd, (long)data, (long)size, 0, 0, 0);
}

HIDDEN ssize_t writev(int fd, const struct iovec *pieces, int count)
{
    return (ssize_t)make(SYS_writev, fd, (long)pieces, count, 0, 0, 0);
}

HIDDEN ssize_t recv(int fd, void *data, size_t size, int flags)
{
    return (ssize_t)make(SYS_recvfrom, fd, (long)data, (long)size, flags, 0, 0);
}

HIDDEN ssize_t recvfrom(int fd, void *restrict data, size_t size, int flags, __SOCKADDR_ARG from,
                        socklen_t *restrict length)
{
    return (ssize_t)make(SYS_recvfrom, fd, (long)data, (long)size, flags, (long)from.__sockaddr__, (long)length);
}

HIDDEN ssize_t recvmsg(int fd, struct msghdr *message, int flags)
{
    return (ssize_t)make(SYS_recvmsg, fd, (long)message, flags, 0, 0, 0);
}

HIDDEN int recvmmsg(int fd, struct mmsghdr *messages, unsigned int count, int flags, struct timespec *timeout)
{
    return (int)make(SYS_recvmmsg, fd, (long)messages, count, flags, (long)timeout, 0);
}

HIDDEN ssize_t read(int fd, void *data, size_t size)
{
    return (ssize_t)make(SYS_read, fd, (long)data, (long)size, 0, 0, 0);
}

HIDDEN ssize_t readv(int fd, const struct iovec *pieces, int count)
{
    return (ssize_t)make(SYS_readv, fd, (long)pieces, count, 0, 0, 0);
}

HIDDEN int close(int fd)
{
    return (int)make(SYS_close, fd, 0, 0, 0, 0, 0);
}

HIDDEN int dup(int fd)
{
    return (int)make(SYS_dup, fd, 0, 0, 0, 0, 0);
}

HIDDEN int dup2(int fd, int to)
{
    return (int)make(SYS_dup2, fd, to, 0, 0, 0, 0);
}

HIDDEN int dup3(int fd, int to, int flags)
{
    return (int)make(SYS_dup3, fd, to, flags, 0, 0, 0);
}

/* --- clocks and waits -----------------------------------------------------------------------------------------------
 */

HIDDEN int clock_gettime(clockid_t clock, struct timespec *time)
{
    return (int)make(SYS_clock_gettime, clock, (long)time, 0, 0, 0, 0);
}

HIDDEN int gettimeofday(struct timeval *restrict time, void *restrict zone)
{
    return (int)make(SYS_gettimeofday, (long)time, (long)zone, 0, 0, 0, 0);
}

HIDDEN time_t time(time_t *result)
{
    return (time_t)make(SYS_time, (long)result, 0, 0, 0, 0, 0);
}

HIDDEN int nanosleep(const struct timespec *time, struct timespec *left)
{
    return (int)make(SYS_nanosleep, (long)time, (long)left, 0, 0, 0, 0);
}

HIDDEN int clock_nanosleep(clockid_t clock, int flags, const struct timespec *time, struct timespec *left)
{
    return make(SYS_clock_nanosleep, clock, flags, (long)time, (long)left, 0, 0) == 0 ? 0 : errno;
}

HIDDEN int usleep(useconds_t microseconds)
{
    const struct timespec time = {.tv_sec = microseconds / 1000000, .tv_nsec = (long)(microseconds % 1000000) * 1000};
    return nanosleep(&time, NULL);
}

HIDDEN unsigned int sleep(unsigned int seconds)
{
    struct timespec time = {.tv_sec = seconds};
    return nanosleep(&time, &time) == 0 ? 0 : (unsigned int)time.tv_sec;
}

HIDDEN int poll(struct pollfd *fds, nfds_t count, int timeout_ms)
{
    return (int)make(SYS_poll, (long)fds, (long)count, timeout_ms, 0, 0, 0);
}

/* The kernel stores the time left where the C library would keep the limit. */
HIDDEN int ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask)
{
    return (int)make(SYS_ppoll, (long)fds, (long)count, (long)timeout, (long)mask, KERNEL_MASK, 0);
}

HIDDEN int pselect(int count, fd_set *restrict to_read, fd_set *restrict to_write, fd_set *restrict except,
                   const struct timespec *restrict timeout, const sigset_t *restrict mask)
{
    const long its[] = {(long)mask, KERNEL_MASK};
    return (int)make(SYS_pselect6, count, (long)to_read, (long)to_write, (long)except, (long)timeout, (long)its);
}

HIDDEN int select(int count, fd_set *restrict to_read, fd_set *restrict to_write, fd_set *restrict except,
                  struct timeval *restrict timeout)
{
    return (int)make(SYS_select, count, (long)to_read, (long)to_write, (long)except, (long)timeout, 0);
}

HIDDEN int epoll_wait(int fd, struct epoll_event *events, int most, int timeout_ms)
{
    return (int)make(SYS_epoll_wait, fd, (long)events, most, timeout_ms, 0, 0);
}

HIDDEN int epoll_pwait(int fd, struct epoll_event *events, int most, int timeout_ms, const sigset_t *mask)
{
    return (int)make(SYS_epoll_pwait, fd, (long)events, most, timeout_ms, (long)mask, KERNEL_MASK);
}

HIDDEN int timerfd_create(int clock, int flags)
{
    return (int)make(SYS_timerfd_create, clock, flags, 0, 0, 0, 0);
}

HIDDEN int timerfd_settime(int fd, int flags, const struct itimerspec *value, struct itimerspec *before)
{
    return (int)make(SYS_timerfd_settime, fd, flags, (long)value, (long)before, 0, 0);
}

HIDDEN int timerfd_gettime(int fd, struct itimerspec *value)
{
    return (int)make(SYS_timerfd_gettime, fd, (long)value, 0, 0, 0, 0);
}

HIDDEN int setitimer(__itimer_which_t which, const struct itimerval *restrict value, struct itimerval *restrict before)
{
    return (int)make(SYS_setitimer, which, (long)value, (long)before, 0, 0, 0);
}

HIDDEN int getitimer(__itimer_which_t which, struct itimerval *value)
{
    return (int)make(SYS_getitimer, which, (long)value, 0, 0, 0, 0);
}

HIDDEN unsigned int alarm(unsigned int seconds)
{
    return (unsigned int)make(SYS_alarm, seconds, 0, 0, 0, 0, 0);
}

HIDDEN int pause(void)
{
    return (int)make(SYS_pause, 0, 0, 0, 0, 0, 0);
}

HIDDEN int sigsuspend(const sigset_t *mask)
{
    return (int)make(SYS_rt_sigsuspend, (long)mask, KERNEL_MASK, 0, 0, 0, 0);
}

HIDDEN int sigtimedwait(const sigset_t *restrict set, siginfo_t *restrict info, const struct timespec *restrict timeout)
{
    return (int)make(SYS_rt_sigtimedwait, (long)set, (long)info, (long)timeout, KERNEL_MASK, 0, 0);
}

HIDDEN int sigwaitinfo(const sigset_t *restrict set, siginfo_t *restrict info)
{
    return (int)make(SYS_rt_sigtimedwait, (long)set, (long)info, 0, KERNEL_MASK, 0, 0);
}

HIDDEN int sigprocmask(int how, const sigset_t *restrict set, sigset_t *restrict before)
{
    return (int)make(SYS_rt_sigprocmask, how, (long)set, (long)before, KERNEL_MASK, 0, 0);
}

HIDDEN pid_t wait4(pid_t pid, int *status, int options, struct rusage *usage)
{
    return (pid_t)make(SYS_wait4, pid, (long)status, options, (long)usage, 0, 0);
}

HIDDEN pid_t waitpid(pid_t pid, int *status, int options)
{
    return wait4(pid, status, options, NULL);
}

HIDDEN pid_t wait(int *status)
{
    return wait4(-1, status, 0, NULL);
}

HIDDEN int waitid(idtype_t kind, id_t id, siginfo_t *info, int options)
{
    return (int)make(SYS_waitid, (long)kind, id, (long)info, options, 0, 0);
}

HIDDEN pid_t fork(void)
{
    return (pid_t)make(SYS_fork, 0, 0, 0, 0, 0, 0);
}
