/* SPDX-License-Identifier: MIT */
/*
 * Calls with bad addresses, one for each pointer argument: each gives EFAULT as from a kernel, and the socket works on.
 * usage: ectwin with --in-process [--virtual-time] fzm1,fzm1 -- inprocess_addresses {} real|virtual [CASE]
 */
#define _GNU_SOURCE
#include "inprocess.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

/* --- bad memory -----------------------------------------------------------------------------------------------------
 */

/* Kinds of addresses, as bits; those of an argument that is read, and that is written. */
enum {
    ZERO = 1,
    UNMAPPED = 2,
    OUTSIDE = 4, /* of every address space of the processor */
    PARTLY = 8,  /* accessible, but for all bytes after the first */
    FILE_END = 16,
    READ_ONLY = 32,
    KINDS = 6,
    OPTIONAL = UNMAPPED | OUTSIDE | PARTLY | FILE_END,
    READ = ZERO | OPTIONAL,
    OPTIONAL_WRITE = OPTIONAL | READ_ONLY,
    WRITE = READ | READ_ONLY,
};

static struct {
    const char *name;
    void *volatile address;
} kinds[KINDS] = {{.name = "0"},      {.name = "unmapped"},      {.name = "outside"},
                  {.name = "a part"}, {.name = "behind a file"}, {.name = "read-only"}};

static void map_bad_memory(void)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = mmap(NULL, 5 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    int file = memfd_create("empty", 0);
    assert_true(pages != MAP_FAILED && file >= 0);
    memset(pages, 0, 5 * page);
    pages[page - 1] = 'x';         /* the begin of a path */
    kinds[1].address = (void *)16; /* the first page is never mapped, and no later mapping takes its place */
    kinds[2].address = (void *)(uintptr_t)0x4141414141414141ull;
    kinds[3].address = pages + page - 1;
    kinds[4].address = pages + 2 * page;
    kinds[5].address = pages + 4 * page;
    assert_int_equal(mprotect(pages + page, page, PROT_NONE), 0);
    assert_true(mmap(pages + 2 * page, page, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, file, 0) != MAP_FAILED);
    assert_int_equal(mprotect(pages + 4 * page, page, PROT_READ), 0);
    close(file);
}

/* --- the calls: each with a socket, whose frame waits, and an address ------------------------------------------------
 */

static uint8_t frame[FRAME];
static struct sockaddr_ll address;
static struct sockaddr *const name = (struct sockaddr *)&address;

static struct iovec whole(void)
{
    return (struct iovec){frame, FRAME};
}

/* The headers exclude address 0, which UndefinedBehaviorSanitizer checks; the kernel does not. */
#define CALL(title) __attribute__((no_sanitize("undefined"))) static long title(int fd, void *at)

CALL(send_data)
{
    return send(fd, at, FRAME, 0);
}

CALL(sendto_data)
{
    return sendto(fd, at, FRAME, 0, NULL, 0);
}

CALL(sendto_name)
{
    return sendto(fd, frame, FRAME, 0, at, sizeof address);
}

CALL(write_data)
{
    return write(fd, at, FRAME);
}

CALL(writev_list)
{
    return writev(fd, at, 1);
}

CALL(writev_piece)
{
    const struct iovec pieces[] = {{frame, 20}, {at, FRAME - 20}};
    return writev(fd, pieces, 2);
}

CALL(sendmsg_message)
{
    return sendmsg(fd, at, 0);
}

CALL(sendmsg_list)
{
    const struct msghdr message = {.msg_iov = at, .msg_iovlen = 1};
    return sendmsg(fd, &message, 0);
}

CALL(sendmsg_piece)
{
    struct iovec piece = {at, FRAME};
    const struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1};
    return sendmsg(fd, &message, 0);
}

CALL(sendmsg_name)
{
    struct iovec piece = whole();
    const struct msghdr message = {.msg_name = at, .msg_namelen = sizeof address, .msg_iov = &piece, .msg_iovlen = 1};
    return sendmsg(fd, &message, 0);
}

CALL(sendmsg_control)
{
    struct iovec piece = whole();
    const struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1, .msg_control = at, .msg_controllen = 5000};
    return sendmsg(fd, &message, 0);
}

CALL(sendmmsg_messages)
{
    return sendmmsg(fd, at, 1, 0);
}

CALL(recv_data)
{
    return recv(fd, at, FRAME, 0);
}

CALL(recvfrom_data)
{
    return recvfrom(fd, at, FRAME, 0, NULL, NULL);
}

CALL(recvfrom_name)
{
    socklen_t length = sizeof address;
    return recvfrom(fd, frame, FRAME, 0, at, &length);
}

CALL(recvfrom_length)
{
    return recvfrom(fd, frame, FRAME, 0, name, at);
}

CALL(read_data)
{
    return read(fd, at, FRAME);
}

CALL(readv_list)
{
    return readv(fd, at, 1);
}

CALL(readv_piece)
{
    const struct iovec pieces[] = {{frame, 20}, {at, FRAME - 20}};
    return readv(fd, pieces, 2);
}

CALL(recvmsg_message)
{
    return recvmsg(fd, at, 0);
}

CALL(recvmsg_list)
{
    struct msghdr message = {.msg_iov = at, .msg_iovlen = 1};
    return recvmsg(fd, &message, 0);
}

CALL(recvmsg_piece)
{
    struct iovec piece = {at, FRAME};
    struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1};
    return recvmsg(fd, &message, 0);
}

CALL(recvmsg_name)
{
    struct iovec piece = whole();
    struct msghdr message = {.msg_name = at, .msg_namelen = sizeof address, .msg_iov = &piece, .msg_iovlen = 1};
    return recvmsg(fd, &message, 0);
}

CALL(recvmmsg_messages)
{
    return recvmmsg(fd, at, 1, 0, NULL);
}

CALL(recvmmsg_limit)
{
    struct iovec piece = whole();
    struct mmsghdr one = {.msg_hdr = {.msg_iov = &piece, .msg_iovlen = 1}};
    return recvmmsg(fd, &one, 1, 0, at);
}

CALL(bind_name)
{
    return bind(fd, at, sizeof address);
}

CALL(getsockname_name)
{
    socklen_t length = sizeof address;
    return getsockname(fd, at, &length);
}

CALL(getsockname_length)
{
    return getsockname(fd, name, at);
}

CALL(setsockopt_time)
{
    return setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, at, sizeof(struct timeval));
}

CALL(setsockopt_number)
{
    return setsockopt(fd, SOL_SOCKET, SO_SNDBUF, at, sizeof(int));
}

CALL(getsockopt_value)
{
    socklen_t length = sizeof(struct timeval);
    return getsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, at, &length);
}

CALL(getsockopt_length)
{
    int type;
    return getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, at);
}

CALL(ioctl_fionbio)
{
    return ioctl(fd, FIONBIO, at);
}

CALL(ioctl_siocgifindex)
{
    return ioctl(fd, SIOCGIFINDEX, at);
}

CALL(ioctl_siocsifflags)
{
    return ioctl(fd, SIOCSIFFLAGS, at);
}

CALL(ioctl_siocgifname)
{
    return ioctl(fd, SIOCGIFNAME, at);
}

CALL(ioctl_siocgifconf)
{
    return ioctl(fd, SIOCGIFCONF, at);
}

CALL(ioctl_rows)
{
    struct ifconf list = {.ifc_len = 4 * sizeof(struct ifreq), .ifc_buf = at};
    return ioctl(fd, SIOCGIFCONF, &list);
}

CALL(open_path)
{
    (void)fd;
    return open(at, O_RDONLY);
}

CALL(stat_path)
{
    struct stat its;
    (void)fd;
    return fstatat(AT_FDCWD, at, &its, 0);
}

CALL(access_path)
{
    (void)fd;
    return access(at, F_OK);
}

/* --- calls with time, on the virtual clock --------------------------------------------------------------------------
 */

static const struct timespec soon = {.tv_nsec = 1000};
static const sigset_t no_signals;

CALL(clock_gettime_time)
{
    (void)fd;
    return clock_gettime(CLOCK_MONOTONIC, at);
}

CALL(clock_gettime_day)
{
    (void)fd;
    return clock_gettime(CLOCK_REALTIME, at);
}

CALL(gettimeofday_time)
{
    (void)fd;
    return gettimeofday(at, NULL);
}

CALL(gettimeofday_zone)
{
    struct timeval now;
    (void)fd;
    return gettimeofday(&now, at);
}

CALL(time_result)
{
    (void)fd;
    return time(at);
}

CALL(nanosleep_time)
{
    (void)fd;
    return nanosleep(at, NULL);
}

CALL(clock_nanosleep_time)
{
    (void)fd;
    errno = clock_nanosleep(CLOCK_MONOTONIC, 0, at, NULL);
    return errno != 0 ? -1 : 0;
}

CALL(poll_list)
{
    (void)fd;
    return poll(at, 1, 1);
}

CALL(ppoll_list)
{
    (void)fd;
    return ppoll(at, 1, &soon, NULL);
}

CALL(ppoll_limit)
{
    struct pollfd one = {.fd = fd};
    return ppoll(&one, 1, at, NULL);
}

CALL(ppoll_mask)
{
    struct pollfd one = {.fd = fd};
    return ppoll(&one, 1, &soon, at);
}

/* The set number `at_set` is at an address, the others are good. */
static long select_set(int fd, void *at, int at_set)
{
    fd_set sets[3];
    struct timeval limit = {.tv_usec = 1};
    for (unsigned int i = 0; i < 3; i++) {
        FD_ZERO(&sets[i]);
        FD_SET(fd, &sets[i]);
    }
    return select(fd + 1, at_set == 0 ? at : &sets[0], at_set == 1 ? at : &sets[1], at_set == 2 ? at : &sets[2],
                  &limit);
}

CALL(select_read)
{
    return select_set(fd, at, 0);
}

CALL(select_write)
{
    return select_set(fd, at, 1);
}

CALL(select_except)
{
    return select_set(fd, at, 2);
}

CALL(select_limit)
{
    return select(fd, NULL, NULL, NULL, at);
}

CALL(pselect_read)
{
    return pselect(fd + 1, at, NULL, NULL, &soon, NULL);
}

CALL(pselect_limit)
{
    return pselect(fd, NULL, NULL, NULL, at, NULL);
}

CALL(pselect_mask)
{
    return pselect(fd, NULL, NULL, NULL, &soon, at);
}

/* @return a new epoll descriptor, for which the waiting frame is an event */
static int epoll_of(int fd)
{
    int all = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    assert_int_equal(epoll_ctl(all, EPOLL_CTL_ADD, fd, &event), 0);
    return all;
}

static long closed(int fd, long result)
{
    int error = errno;
    close(fd);
    errno = error;
    return result;
}

CALL(epoll_wait_events)
{
    int all = epoll_of(fd);
    return closed(all, epoll_wait(all, at, 1, 1));
}

CALL(epoll_pwait_mask)
{
    struct epoll_event event;
    int all = epoll_of(fd);
    return closed(all, epoll_pwait(all, &event, 1, 1, at));
}

static int timer_fd(void)
{
    return timerfd_create(CLOCK_MONOTONIC, 0);
}

static const struct itimerspec in_an_hour = {.it_value.tv_sec = 3600};

CALL(timerfd_settime_value)
{
    (void)fd;
    int timer = timer_fd();
    return closed(timer, timerfd_settime(timer, 0, at, NULL));
}

CALL(timerfd_settime_before)
{
    (void)fd;
    int timer = timer_fd();
    return closed(timer, timerfd_settime(timer, 0, &in_an_hour, at));
}

CALL(timerfd_gettime_value)
{
    (void)fd;
    int timer = timer_fd();
    return closed(timer, timerfd_gettime(timer, at));
}

CALL(timer_create_event)
{
    timer_t timer;
    (void)fd;
    return timer_create(CLOCK_MONOTONIC, at, &timer);
}

CALL(timer_create_timer)
{
    (void)fd;
    return timer_create(CLOCK_MONOTONIC, NULL, at);
}

static timer_t new_timer(void)
{
    timer_t timer;
    assert_int_equal(timer_create(CLOCK_MONOTONIC, NULL, &timer), 0);
    return timer;
}

static long deleted(timer_t timer, long result)
{
    int error = errno;
    assert_int_equal(timer_delete(timer), 0);
    errno = error;
    return result;
}

CALL(timer_settime_value)
{
    (void)fd;
    timer_t timer = new_timer();
    return deleted(timer, timer_settime(timer, 0, at, NULL));
}

CALL(timer_settime_before)
{
    (void)fd;
    timer_t timer = new_timer();
    return deleted(timer, timer_settime(timer, 0, &in_an_hour, at));
}

CALL(timer_gettime_value)
{
    (void)fd;
    timer_t timer = new_timer();
    return deleted(timer, timer_gettime(timer, at));
}

CALL(setitimer_value)
{
    (void)fd;
    return setitimer(ITIMER_REAL, at, NULL);
}

CALL(setitimer_before)
{
    const struct itimerval none = {0};
    (void)fd;
    return setitimer(ITIMER_REAL, &none, at);
}

CALL(getitimer_value)
{
    (void)fd;
    return getitimer(ITIMER_REAL, at);
}

CALL(sigsuspend_mask)
{
    (void)fd;
    return sigsuspend(at);
}

CALL(sigtimedwait_set)
{
    (void)fd;
    return sigtimedwait(at, NULL, &soon);
}

CALL(sigtimedwait_limit)
{
    (void)fd;
    return sigtimedwait(&no_signals, NULL, at);
}

/* The signal is consumed, as with a kernel. */
CALL(sigtimedwait_info)
{
    sigset_t set, before;
    (void)fd;
    sigemptyset(&set);
    sigaddset(&set, SIGUSR1);
    pthread_sigmask(SIG_BLOCK, &set, &before);
    raise(SIGUSR1);
    long result = sigtimedwait(&set, at, &soon);
    int error = errno;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    errno = error;
    return result;
}

CALL(futex_word)
{
    (void)fd;
    return syscall(SYS_futex, at, FUTEX_WAIT_PRIVATE, 0, &soon, NULL, 0);
}

CALL(futex_limit)
{
    static const int word = 0;
    (void)fd;
    return syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, 0, at, NULL, 0);
}

/* --- tests ----------------------------------------------------------------------------------------------------------
 */

enum { KEPT, LOST, FREE }; /* the waiting frame; FREE: no call with a socket */
enum {
    OF_TIME = 1,     /* replaced on the virtual clock alone */
    INTERCEPTED = 2, /* AddressSanitizer's function reads the argument itself, before the call */
};

static const struct {
    const char *title;
    long (*call)(int fd, void *at);
    int kinds;
    int waiting;
    int flags;
} rows[] = {
#define ROW(call, kinds, waiting, flags) {#call, call, kinds, waiting, flags}
    ROW(send_data, READ, KEPT, 0),
    ROW(sendto_data, READ, KEPT, 0),
    ROW(sendto_name, OPTIONAL, KEPT, 0),
    ROW(write_data, READ, KEPT, 0),
    ROW(writev_list, READ, KEPT, 0),
    ROW(writev_piece, READ, KEPT, 0),
    ROW(sendmsg_message, READ, KEPT, 0),
    ROW(sendmsg_list, READ, KEPT, 0),
    ROW(sendmsg_piece, READ, KEPT, 0),
    ROW(sendmsg_name, OPTIONAL, KEPT, 0),
    ROW(sendmsg_control, OPTIONAL, KEPT, 0),
    ROW(sendmmsg_messages, READ, KEPT, 0),
    ROW(recv_data, WRITE, LOST, 0),
    ROW(recvfrom_data, WRITE, LOST, 0),
    ROW(recvfrom_name, OPTIONAL_WRITE, LOST, 0),
    ROW(recvfrom_length, WRITE, LOST, INTERCEPTED),
    ROW(read_data, WRITE, LOST, 0),
    ROW(readv_list, READ, KEPT, 0),
    ROW(readv_piece, WRITE, LOST, 0),
    ROW(recvmsg_message, READ, KEPT, 0),
    ROW(recvmsg_message, READ_ONLY, LOST, 0),
    ROW(recvmsg_list, READ, KEPT, 0),
    ROW(recvmsg_piece, WRITE, LOST, 0),
    ROW(recvmsg_name, OPTIONAL_WRITE, LOST, 0),
    ROW(recvmmsg_messages, READ, KEPT, 0),
    ROW(recvmmsg_messages, READ_ONLY, LOST, 0),
    ROW(recvmmsg_limit, OPTIONAL, KEPT, 0),
    ROW(recvmmsg_limit, READ_ONLY, LOST, 0),
    ROW(bind_name, READ, KEPT, 0),
    ROW(getsockname_name, WRITE, KEPT, 0),
    ROW(getsockname_length, WRITE, KEPT, INTERCEPTED),
    ROW(setsockopt_time, READ, KEPT, 0),
    ROW(setsockopt_number, READ, KEPT, 0),
    ROW(getsockopt_value, WRITE, KEPT, 0),
    ROW(getsockopt_length, WRITE, KEPT, 0),
    ROW(ioctl_fionbio, READ, KEPT, 0),
    ROW(ioctl_siocgifindex, READ, KEPT, 0),
    ROW(ioctl_siocsifflags, READ, KEPT, 0),
    ROW(ioctl_siocgifname, READ, KEPT, 0),
    ROW(ioctl_siocgifconf, READ, KEPT, 0),
    ROW(ioctl_rows, OPTIONAL_WRITE, KEPT, 0),
    ROW(open_path, READ, FREE, 0),
    ROW(stat_path, READ, FREE, 0),
    ROW(access_path, READ, FREE, 0),
    ROW(clock_gettime_time, WRITE, FREE, OF_TIME),
    ROW(clock_gettime_day, WRITE, FREE, OF_TIME),
    ROW(gettimeofday_time, OPTIONAL_WRITE, FREE, OF_TIME),
    ROW(gettimeofday_zone, OPTIONAL_WRITE, FREE, OF_TIME),
    ROW(time_result, OPTIONAL_WRITE, FREE, OF_TIME | INTERCEPTED),
    ROW(nanosleep_time, READ, FREE, OF_TIME),
    ROW(clock_nanosleep_time, READ, FREE, OF_TIME),
    ROW(poll_list, WRITE, KEPT, OF_TIME),
    ROW(ppoll_list, WRITE, KEPT, OF_TIME),
    ROW(ppoll_limit, OPTIONAL, KEPT, OF_TIME),
    ROW(ppoll_mask, OPTIONAL, KEPT, OF_TIME),
    ROW(select_read, OPTIONAL_WRITE, KEPT, OF_TIME),
    ROW(select_write, OPTIONAL_WRITE, KEPT, OF_TIME),
    ROW(select_except, OPTIONAL_WRITE, KEPT, OF_TIME),
    ROW(select_limit, OPTIONAL, KEPT, OF_TIME),
    ROW(pselect_read, OPTIONAL_WRITE, KEPT, OF_TIME),
    ROW(pselect_limit, OPTIONAL, KEPT, OF_TIME),
    ROW(pselect_mask, OPTIONAL, KEPT, OF_TIME),
    ROW(epoll_wait_events, WRITE, KEPT, OF_TIME),
    ROW(epoll_pwait_mask, OPTIONAL, KEPT, OF_TIME),
    ROW(timerfd_settime_value, READ, FREE, OF_TIME),
    ROW(timerfd_settime_before, OPTIONAL_WRITE, FREE, OF_TIME),
    ROW(timerfd_gettime_value, WRITE, FREE, OF_TIME),
    ROW(timer_create_event, OPTIONAL, FREE, OF_TIME),
    ROW(timer_create_timer, WRITE, FREE, OF_TIME),
    ROW(timer_settime_value, READ, FREE, OF_TIME),
    ROW(timer_settime_before, OPTIONAL_WRITE, FREE, OF_TIME),
    ROW(timer_gettime_value, WRITE, FREE, OF_TIME),
    ROW(setitimer_value, OPTIONAL, FREE, OF_TIME),
    ROW(setitimer_before, OPTIONAL_WRITE, FREE, OF_TIME),
    ROW(getitimer_value, WRITE, FREE, OF_TIME),
    ROW(sigsuspend_mask, READ, FREE, OF_TIME),
    ROW(sigtimedwait_set, READ, FREE, OF_TIME),
    ROW(sigtimedwait_limit, OPTIONAL, FREE, OF_TIME),
    ROW(sigtimedwait_info, OPTIONAL_WRITE, FREE, OF_TIME),
    ROW(futex_word, READ, FREE, OF_TIME),
    ROW(futex_limit, OPTIONAL, FREE, OF_TIME),
};

static bool receives(int fd)
{
    return recv(fd, frame, FRAME, MSG_DONTWAIT) == FRAME;
}

static void every_bad_address_gives_efault(void **state)
{
    const bool sanitized = dlsym(RTLD_DEFAULT, "__asan_init") != NULL;
    int fd = open_socket(0);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (((rows[i].flags & OF_TIME) != 0 && !is_virtual) || ((rows[i].flags & INTERCEPTED) != 0 && sanitized))
            continue;
        int skipped = sanitized ? OUTSIDE : 0; /* has no shadow */
        for (unsigned int kind = 0; kind < KINDS; kind++) {
            if ((rows[i].kinds & ~skipped & 1 << kind) == 0)
                continue;
            send_one(fd, 1);
            errno = 0;
            long result = rows[i].call(fd, kinds[kind].address);
            int error = errno;
            if (result != -1 || error != EFAULT)
                fail_msg("%s, %s: result %ld, %s", rows[i].title, kinds[kind].name, result, strerror(error));
            if (receives(fd) == (rows[i].waiting == LOST) || receives(fd))
                fail_msg("%s, %s: the waiting frame", rows[i].title, kinds[kind].name);
        }
    }
    send_one(fd, 7);
    assert_reply(frame, recv(fd, frame, FRAME, 0), 7);
    close(fd);
}

/* --- the program's own actions of SIGSEGV and SIGBUS ----------------------------------------------------------------
 */

static struct {
    unsigned int count;
    int number, code;
    void *address;
    bool on_stack, blocks_usr1, blocks_itself;
    long sent; /* result of a call with a bad address */
    int error;
} handled;

static uint8_t signal_stack[65536];
static sigjmp_buf after_fault;
static int socket_of_handler = -1;

static void on_fault(int number, siginfo_t *info, void *context)
{
    sigset_t mask;
    const uint8_t *here = __builtin_frame_address(0); /* AddressSanitizer may keep variables elsewhere */
    (void)context;
    handled.count++;
    handled.number = number;
    handled.code = info->si_code;
    handled.address = info->si_addr;
    handled.on_stack = here >= signal_stack && here < signal_stack + sizeof signal_stack;
    pthread_sigmask(SIG_BLOCK, NULL, &mask);
    handled.blocks_usr1 = sigismember(&mask, SIGUSR1) == 1;
    handled.blocks_itself = sigismember(&mask, number) == 1;
    if (socket_of_handler >= 0) {
        handled.sent = send_data(socket_of_handler, kinds[1].address);
        handled.error = errno;
    }
    if (info->si_code > 0)
        siglongjmp(after_fault, 1);
}

static void read_from(const void *address_of_fault)
{
    (void)*(const volatile int *)address_of_fault;
}

/* A fault of the program itself, which its handler leaves by a jump. */
static void fault_at(void *address_of_fault)
{
    memset(&handled, 0, sizeof handled);
    if (sigsetjmp(after_fault, 1) == 0)
        read_from(address_of_fault);
}

static void set_action(int number, int flags)
{
    struct sigaction action = {.sa_sigaction = on_fault, .sa_flags = flags | SA_SIGINFO};
    sigaddset(&action.sa_mask, SIGUSR1);
    assert_int_equal(sigaction(number, &action, NULL), 0);
}

static void assert_refused(int fd)
{
    errno = 0;
    assert_int_equal(send_data(fd, kinds[1].address), -1);
    assert_int_equal(errno, EFAULT);
}

static void a_handler_gets_the_faults_of_the_program(void **state)
{
    static const struct {
        int number, flags, code, kind;
    } cases[] = {{SIGSEGV, 0, SEGV_MAPERR, 1},
                 {SIGSEGV, SA_ONSTACK, SEGV_MAPERR, 1},
                 {SIGBUS, SA_ONSTACK, BUS_ADRERR, 4},
                 {SIGSEGV, SA_NODEFER, SEGV_MAPERR, 1}};
    const stack_t stack = {.ss_sp = signal_stack, .ss_size = sizeof signal_stack};
    stack_t stack_before;
    int fd = open_socket(0);
    (void)state;
    assert_int_equal(sigaltstack(&stack, &stack_before), 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct sigaction now;
        set_action(cases[i].number, cases[i].flags);
        assert_refused(fd);
        socket_of_handler =
            cases[i].flags == SA_NODEFER ? fd : -1; /* with the signal blocked the kernel ends the process */
        fault_at(kinds[cases[i].kind].address);
        assert_int_equal(handled.count, 1);
        assert_int_equal(handled.number, cases[i].number);
        assert_int_equal(handled.code, cases[i].code);
        assert_ptr_equal(handled.address, kinds[cases[i].kind].address);
        assert_int_equal(handled.on_stack, cases[i].flags == SA_ONSTACK);
        assert_true(handled.blocks_usr1);
        assert_int_equal(handled.blocks_itself, cases[i].flags != SA_NODEFER);
        if (cases[i].flags == SA_NODEFER)
            assert_true(handled.sent == -1 && handled.error == EFAULT);
        assert_int_equal(sigaction(cases[i].number, NULL, &now), 0);
        assert_ptr_equal((void *)now.sa_sigaction, (void *)on_fault);
        assert_int_equal(now.sa_flags & (SA_SIGINFO | SA_ONSTACK | SA_NODEFER), cases[i].flags | SA_SIGINFO);
        assert_int_equal(sigismember(&now.sa_mask, SIGUSR1), 1);
        assert_refused(fd);
    }
    socket_of_handler = -1;
    assert_int_equal(sigaltstack(&stack_before, NULL), 0);
    close(fd);
}

static void a_handler_gets_a_sent_signal(void **state)
{
    struct sigaction now;
    int fd = open_socket(0);
    (void)state;
    set_action(SIGSEGV, (int)SA_RESETHAND);
    memset(&handled, 0, sizeof handled);
    assert_int_equal(raise(SIGSEGV), 0);
    assert_int_equal(handled.count, 1);
    assert_int_equal(handled.code, SI_TKILL);
    assert_int_equal(sigaction(SIGSEGV, NULL, &now), 0);
    assert_ptr_equal((void *)now.sa_handler, (void *)SIG_DFL);
    assert_refused(fd);
    close(fd);
}

static void on_sent(int number)
{
    handled.number = number;
}

static void signal_returns_the_handler_before(void **state)
{
    struct sigaction now;
    (void)state;
    signal(SIGSEGV, SIG_IGN);
    assert_ptr_equal((void *)signal(SIGSEGV, on_sent), (void *)SIG_IGN);
    assert_int_equal(sigaction(SIGSEGV, NULL, &now), 0);
    assert_int_equal(now.sa_flags & (SA_RESTART | SA_SIGINFO), SA_RESTART);
    assert_int_equal(raise(SIGSEGV), 0);
    assert_int_equal(handled.number, SIGSEGV);
    assert_ptr_equal((void *)signal(SIGSEGV, SIG_ERR), (void *)SIG_ERR);
    assert_int_equal(errno, EINVAL);
    assert_ptr_equal((void *)sysv_signal(SIGSEGV, SIG_DFL), (void *)on_sent);
    assert_int_equal(sigaction(SIGSEGV, NULL, &now), 0);
    assert_int_equal(now.sa_flags & ((int)SA_RESETHAND | SA_NODEFER), (int)SA_RESETHAND | SA_NODEFER);
}

static void end_by(int fd, int number, __sighandler_t action, bool blocked, int kind)
{
    sigset_t set;
    const struct rlimit none = {0};
    (void)setrlimit(RLIMIT_CORE, &none);
    signal(number, action);
    sigemptyset(&set);
    sigaddset(&set, number);
    pthread_sigmask(blocked ? SIG_BLOCK : SIG_UNBLOCK, &set, NULL);
    if (!blocked && send_data(fd, kinds[1].address) != -1)
        _exit(1);
    if (kind >= 0)
        read_from(kinds[kind].address);
    else
        (void)raise(number);
    _exit(0);
}

static void the_default_action_ends_the_program(void **state)
{
    static const struct {
        const char *title;
        int number;
        __sighandler_t action;
        bool blocked;
        int kind; /* of address; -1: sent */
        int status;
    } cases[] = {{"a fault", SIGSEGV, SIG_DFL, false, 1, SIGSEGV},
                 {"a fault behind a file", SIGBUS, SIG_DFL, false, 4, SIGBUS},
                 {"a fault while the signal is ignored", SIGSEGV, SIG_IGN, false, 1, SIGSEGV},
                 {"a fault while the signal is blocked", SIGSEGV, on_sent, true, 1, SIGSEGV},
                 {"sent", SIGSEGV, SIG_DFL, false, -1, SIGSEGV},
                 {"sent while ignored", SIGSEGV, SIG_IGN, false, -1, 0},
                 {"sent while blocked", SIGSEGV, SIG_DFL, true, -1, 0}};
    int fd = open_socket(0);
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        int status = -1;
        pid_t child = fork();
        if (child == 0)
            end_by(fd, cases[i].number, cases[i].action, cases[i].blocked, cases[i].kind);
        assert_int_equal(waitpid(child, &status, 0), child);
        int got = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
        if (got != cases[i].status)
            fail_msg("%s: expected %d, got %d", cases[i].title, cases[i].status, got);
    }
    close(fd);
}

static void *send_badly(void *arg)
{
    enum { MANY = 2000 };
    const int *fd = arg;
    size_t refused = 0;
    for (size_t i = 0; i < MANY; i++)
        refused += send_data(*fd, kinds[1 + i % 2 * 2].address) == -1 && errno == EFAULT;
    return refused == MANY ? arg : NULL;
}

static void threads_are_refused_side_by_side(void **state)
{
    enum { THREADS = 4 };
    pthread_t threads[THREADS];
    int fd = open_socket(0);
    (void)state;
    for (size_t i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, send_badly, &fd), 0);
    for (size_t i = 0; i < THREADS; i++) {
        void *all = NULL;
        assert_int_equal(pthread_join(threads[i], &all), 0);
        assert_non_null(all);
    }
    send_one(fd, 7);
    assert_reply(frame, recv(fd, frame, FRAME, 0), 7);
    close(fd);
}

static void a_sanitizer_checks_the_buffers_of_frames(void **state)
{
    void (*poison)(const void *address, size_t size);
    *(void **)&poison = dlsym(RTLD_DEFAULT, "__asan_poison_memory_region");
    if (!poison)
        skip(); /* only with AddressSanitizer in the program */
    for (unsigned int sends = 0; sends < 2; sends++) {
        int fd = open_socket(0), status = 0;
        pid_t child = fork();
        if (child == 0) {
            static uint8_t buffer[FRAME] __attribute__((aligned(8)));
            if (!freopen("/dev/null", "w", stderr)) /* gets the report */
                _exit(0);
            send_one(fd, 1);
            poison(buffer + FRAME - 8 + FRAME % 8, 8);
            (void)(sends ? send(fd, buffer, FRAME, 0) : recv(fd, buffer, FRAME, 0));
            _exit(0);
        }
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(!WIFEXITED(status) || WEXITSTATUS(status) != 0);
        close(fd);
    }
    (void)state;
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Every bad address of every call gives EFAULT, and the next call works", every_bad_address_gives_efault, NULL,
         NULL, NULL},
        {"A handler of the program gets the faults of the program, with its mask, stack and flags",
         a_handler_gets_the_faults_of_the_program, NULL, NULL, NULL},
        {"A handler of the program gets a signal that was sent", a_handler_gets_a_sent_signal, NULL, NULL, NULL},
        {"signal() returns the program's handler", signal_returns_the_handler_before, NULL, NULL, NULL},
        {"The default action ends the program by the signal", the_default_action_ends_the_program, NULL, NULL, NULL},
        {"AddressSanitizer reports a buffer that is shorter than its frame", a_sanitizer_checks_the_buffers_of_frames,
         NULL, NULL, NULL},
        {"Bad addresses of several threads are refused side by side", threads_are_refused_side_by_side, NULL, NULL,
         NULL},
    };
    if (!is_started(argc, argv))
        return 2;
    address = (struct sockaddr_ll){.sll_family = AF_PACKET, .sll_protocol = htons(ETHERCAT)};
    frame_of(frame, 3);
    map_bad_memory();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
