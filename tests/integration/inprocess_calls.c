/* SPDX-License-Identifier: MIT */
/*
 * The calls by which masters reach a packet socket, one test each, against twins in this process.
 * usage: ectwin with --in-process [--virtual-time] fzm1,fzm1 -- inprocess_calls {} real|virtual [CASE]
 */
#define _GNU_SOURCE
#include "inprocess.h"

#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/select.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

/* --- sockets -------------------------------------------------------------------------------------------------------
 */

static void sends_and_receives(void **state)
{
    uint8_t frame[FRAME];
    struct sockaddr_ll from;
    socklen_t length = sizeof from;
    struct iovec piece = {.iov_base = frame, .iov_len = sizeof frame};
    struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1};
    (void)state;
    int fd = open_socket(0);
    frame_of(frame, 1);
    assert_int_equal(write(fd, frame, sizeof frame), FRAME);
    assert_reply(frame, read(fd, frame, sizeof frame), 1);
    frame_of(frame, 2);
    assert_int_equal(sendto(fd, frame, sizeof frame, 0, NULL, 0), FRAME);
    assert_reply(frame, recvfrom(fd, frame, sizeof frame, 0, (struct sockaddr *)&from, &length), 2);
    assert_int_equal(from.sll_ifindex, if_nametoindex(interface));
    frame_of(frame, 3);
    assert_int_equal(sendmsg(fd, &message, 0), FRAME);
    assert_reply(frame, recvmsg(fd, &message, 0), 3);
    frame_of(frame, 4);
    assert_int_equal(writev(fd, &piece, 1), FRAME);
    assert_reply(frame, readv(fd, &piece, 1), 4);
    assert_int_equal(close(fd), 0);
}

static void sends_and_receives_many(void **state)
{
    enum { MANY = 4 };
    uint8_t frames[MANY][FRAME];
    struct iovec pieces[MANY];
    struct mmsghdr messages[MANY];
    (void)state;
    int fd = open_socket(0);
    memset(messages, 0, sizeof messages);
    for (uint8_t i = 0; i < MANY; i++) {
        frame_of(frames[i], i);
        pieces[i] = (struct iovec){.iov_base = frames[i], .iov_len = FRAME};
        messages[i].msg_hdr = (struct msghdr){.msg_iov = &pieces[i], .msg_iovlen = 1};
    }
    assert_int_equal(sendmmsg(fd, messages, MANY, 0), MANY);
    for (uint8_t i = 0; i < MANY; i++) {
        assert_int_equal(messages[i].msg_len, FRAME);
        messages[i].msg_len = 0;
    }
    assert_int_equal(recvmmsg(fd, messages, MANY, MSG_WAITFORONE, NULL), MANY);
    for (uint8_t i = 0; i < MANY; i++)
        assert_reply(frames[i], messages[i].msg_len, i);
    close(fd);
}

/* Pieces of any length; what follows the frame in the last one stays. */
static void pieces_of_a_frame(void **state)
{
    static const size_t lengths[] = {14, 0, 3, 100};
    uint8_t room[4][100], frame[FRAME];
    struct iovec pieces[4];
    size_t used = 0;
    (void)state;
    int fd = open_socket(0);
    send_one(fd, 6);
    memset(room, 0xEE, sizeof room);
    for (size_t i = 0; i < 4; i++)
        pieces[i] = (struct iovec){.iov_base = room[i], .iov_len = lengths[i]};
    assert_int_equal(readv(fd, pieces, 4), FRAME);
    for (size_t i = 0; i < 4; i++) {
        size_t part = i < 3 ? lengths[i] : FRAME - used;
        memcpy(frame + used, room[i], part);
        assert_int_equal(room[i][part < 99 ? part : 99], 0xEE);
        used += part;
    }
    assert_reply(frame, (ssize_t)used, 6);
    close(fd);
}

/* The address of a received frame, in each call that returns one: the interface's own. */
static void addresses_of_frames(void **state)
{
    uint8_t frame[FRAME];
    struct iovec piece = {.iov_base = frame, .iov_len = sizeof frame};
    (void)state;
    int fd = open_socket(0);
    for (unsigned int call = 0; call < 3; call++) {
        struct sockaddr_ll its;
        struct msghdr message = {
            .msg_name = &its, .msg_namelen = sizeof its, .msg_iov = &piece, .msg_iovlen = 1, .msg_controllen = 7};
        socklen_t length = sizeof its;
        memset(&its, 0xEE, sizeof its);
        send_one(fd, (uint8_t)call);
        if (call == 0) {
            assert_int_equal(getsockname(fd, (struct sockaddr *)&its, &length), 0);
            assert_int_equal(read(fd, frame, sizeof frame), FRAME);
        } else if (call == 1) {
            assert_int_equal(recvfrom(fd, frame, sizeof frame, 0, (struct sockaddr *)&its, &length), FRAME);
        } else {
            assert_int_equal(recvmsg(fd, &message, 0), FRAME);
            length = message.msg_namelen;
            assert_int_equal(message.msg_controllen, 0);
            assert_int_equal(message.msg_flags, 0);
        }
        assert_int_equal(length, sizeof its);
        assert_int_equal(its.sll_family, AF_PACKET);
        assert_int_equal(its.sll_protocol, htons(ETHERCAT));
        assert_int_equal(its.sll_ifindex, if_nametoindex(interface));
        assert_int_equal(its.sll_hatype, 1);
        assert_int_equal(its.sll_halen, 6);
        assert_memory_equal(its.sll_addr, "\2\0\0\0\0\1", 6);
    }
    close(fd);
}

/* A call with no room takes a frame, and returns 0 bytes of it. */
static void receives_into_no_room(void **state)
{
    struct mmsghdr messages[2] = {{.msg_len = 7}, {.msg_len = 7}};
    struct sockaddr_ll from;
    struct msghdr message = {.msg_name = &from, .msg_namelen = sizeof from, .msg_controllen = 7};
    (void)state;
    int fd = open_socket(0);
    for (uint8_t n = 0; n < 3; n++)
        send_one(fd, n);
    assert_int_equal(recvmsg(fd, &message, 0), 0);
    assert_int_equal(message.msg_controllen, 0);
    assert_int_equal(message.msg_flags & MSG_TRUNC, MSG_TRUNC);
    assert_int_equal(recvmmsg(fd, messages, 2, 0, NULL), 2);
    assert_int_equal(messages[0].msg_len + messages[1].msg_len, 0);
    assert_int_equal(recvmsg(fd, &message, MSG_DONTWAIT), -1);
    close(fd);
}

static void options_are_read_back(void **state)
{
    static const struct {
        int level, name, want;
    } rows[] = {{SOL_SOCKET, SO_TYPE, SOCK_RAW}, {SOL_SOCKET, SO_DOMAIN, AF_PACKET}, {SOL_PACKET, SO_DOMAIN, 0},
                {SOL_PACKET, SO_TYPE, 0},        {SOL_SOCKET, SO_ERROR, 0},          {SOL_SOCKET, SO_RCVBUF, 212992},
                {SOL_SOCKET, SO_SNDBUF, 212992}};
    static const struct timeval times[] = {{3, 0}, {0, 7}, {1, 999999}, {0, 0}};
    (void)state;
    int fd = open_socket(0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int value = -1;
        socklen_t length = sizeof value;
        assert_int_equal(getsockopt(fd, rows[i].level, rows[i].name, &value, &length), 0);
        assert_int_equal(value, rows[i].want);
        assert_int_equal(length, sizeof value);
    }
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        struct timeval time = {-1, -1};
        socklen_t length = sizeof time;
        assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &times[i], sizeof times[i]), 0);
        assert_int_equal(getsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &time, &length), 0);
        assert_int_equal(time.tv_sec, times[i].tv_sec);
        assert_int_equal(time.tv_usec, times[i].tv_usec);
        assert_int_equal(length, sizeof time);
    }
    close(fd);
}

/* A daemon's standard input may be closed: a socket gets descriptor 0 then. Other calls leave descriptor 0 alone. */
static void descriptor_0(void **state)
{
    uint8_t frame[FRAME];
    int type = 0;
    socklen_t length = sizeof type;
    (void)state;
    const int input = dup(STDIN_FILENO);
    close(STDIN_FILENO);
    const int fd = open_socket(0);
    send_one(fd, 3);
    const ssize_t got = recv(fd, frame, sizeof frame, 0);
    close(fd);
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        close(input);
    }
    assert_int_equal(fd, STDIN_FILENO);
    assert_reply(frame, got, 3);
    int other = open_socket(0);
    assert_int_equal(fcntl(other, F_GETFD), 0);
    assert_int_equal(getsockopt(STDIN_FILENO, SOL_SOCKET, SO_TYPE, &type, &length), -1);
    assert_int_equal(ioctl(other, FIOCLEX), 0);
    assert_int_equal(fcntl(other, F_GETFD), FD_CLOEXEC);
    assert_int_equal(ioctl(other, FIONCLEX), 0);
    assert_int_equal(fcntl(other, F_GETFD), 0);
    assert_int_equal(ioctl(other, TIOCGWINSZ, &(struct winsize){0}), -1);
    assert_int_equal(errno, ENOTTY);
    assert_int_equal(ioctl(other, SIOCGIFADDR, &(struct ifreq){0}), -1);
    assert_int_equal(errno, EOPNOTSUPP);
    close(other);
}

static void refuses_as_the_kernel(void **state)
{
    uint8_t frame[2000] = {0};
    struct sockaddr_ll to = {.sll_family = AF_PACKET, .sll_ifindex = 77};
    (void)state;
    int fd = socket(AF_PACKET, SOCK_RAW, htons(ETHERCAT));
    assert_int_equal(send(fd, frame, FRAME, 0), -1);
    assert_int_equal(errno, ENXIO);
    assert_int_equal(bind(fd, (struct sockaddr *)&to, sizeof to), -1);
    assert_int_equal(errno, ENODEV);
    close(fd);
    fd = open_socket(0);
    assert_int_equal(send(fd, frame, 13, 0), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(send(fd, frame, sizeof frame, 0), -1);
    assert_int_equal(errno, EMSGSIZE);
    close(fd);
}

static void waits_as_long_as_asked(void **state)
{
    static const struct {
        const char *how;
        int type;
        int flags;
        struct timeval timeout;
        uint64_t takes_ns;
    } cases[] = {
        {"SOCK_NONBLOCK", SOCK_NONBLOCK, 0, {0, 0}, 0},
        {"MSG_DONTWAIT", 0, MSG_DONTWAIT, {0, 0}, 0},
        {"SO_RCVTIMEO of 1 ms", 0, 0, {0, 1000}, MS},
        {"SO_RCVTIMEO of 20 ms", 0, 0, {0, 20000}, 20 * MS},
    };
    uint8_t frame[FRAME];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        print_message("%s\n", cases[i].how);
        int fd = open_socket(cases[i].type);
        assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &cases[i].timeout, sizeof cases[i].timeout), 0);
        uint64_t since_ns = now_ns();
        assert_int_equal(recv(fd, frame, sizeof frame, cases[i].flags), -1);
        assert_int_equal(errno, EAGAIN);
        assert_took(since_ns, cases[i].takes_ns);
        close(fd);
    }
}

static void fcntl_and_ioctl_set_nonblocking(void **state)
{
    uint8_t frame[FRAME];
    int on = 1;
    (void)state;
    int fd = open_socket(0);
    assert_int_equal(fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK), 0);
    assert_int_equal(recv(fd, frame, sizeof frame, 0), -1);
    close(fd);
    fd = open_socket(0);
    assert_int_equal(ioctl(fd, FIONBIO, &on), 0);
    assert_int_equal(recv(fd, frame, sizeof frame, 0), -1);
    close(fd);
}

static void peeks_and_truncates(void **state)
{
    uint8_t frame[FRAME];
    (void)state;
    int fd = open_socket(0);
    send_one(fd, 7);
    assert_reply(frame, recv(fd, frame, sizeof frame, MSG_PEEK), 7);
    assert_int_equal(recv(fd, frame, 20, MSG_TRUNC), FRAME);
    assert_int_equal(recv(fd, frame, sizeof frame, MSG_DONTWAIT), -1);
    close(fd);
}

static void interface_has_its_attributes(void **state)
{
    struct ifreq its = {0};
    char name[IF_NAMESIZE];
    bool listed = false;
    (void)state;
    int fd = socket(AF_PACKET, SOCK_RAW, htons(ETHERCAT));
    strncpy(its.ifr_name, interface, IFNAMSIZ - 1);
    assert_int_equal(ioctl(fd, SIOCGIFINDEX, &its), 0);
    assert_int_equal(its.ifr_ifindex, if_nametoindex(interface));
    assert_string_equal(if_indextoname((unsigned int)its.ifr_ifindex, name), interface);
    assert_int_equal(ioctl(fd, SIOCGIFFLAGS, &its), 0);
    assert_true((its.ifr_flags & IFF_UP) != 0 && (its.ifr_flags & IFF_RUNNING) != 0);
    its.ifr_flags |= IFF_PROMISC;
    assert_int_equal(ioctl(fd, SIOCSIFFLAGS, &its), 0);
    assert_int_equal(ioctl(fd, SIOCGIFMTU, &its), 0);
    assert_int_equal(its.ifr_mtu, 1500);
    assert_int_equal(ioctl(fd, SIOCGIFHWADDR, &its), 0);
    assert_memory_equal(its.ifr_hwaddr.sa_data, "\2\0\0\0\0\1", 6);
    close(fd);
    struct if_nameindex *all = if_nameindex();
    for (const struct if_nameindex *one = all; one->if_index != 0; one++)
        listed |= strcmp(one->if_name, interface) == 0;
    if_freenameindex(all);
    assert_true(listed);
}

static void an_interface_that_is_down_sends_nothing(void **state)
{
    uint8_t frame[FRAME];
    struct ifreq its = {0};
    (void)state;
    int fd = open_socket(0);
    strncpy(its.ifr_name, interface, IFNAMSIZ - 1);
    frame_of(frame, 1);
    assert_int_equal(ioctl(fd, SIOCSIFFLAGS, &its), 0);
    assert_int_equal(ioctl(fd, SIOCGIFFLAGS, &its), 0);
    assert_int_equal(its.ifr_flags & IFF_UP, 0);
    assert_int_equal(send(fd, frame, sizeof frame, 0), -1);
    assert_int_equal(errno, ENETDOWN);
    its.ifr_flags |= IFF_UP;
    assert_int_equal(ioctl(fd, SIOCSIFFLAGS, &its), 0);
    send_one(fd, 2);
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 2);
    close(fd);
}

static void copies_of_a_descriptor_are_the_socket(void **state)
{
    uint8_t frame[FRAME];
    (void)state;
    int fd = open_socket(0);
    int copies[] = {dup(fd), fcntl(fd, F_DUPFD, 50), dup2(fd, 60), dup3(fd, 61, O_CLOEXEC),
                    fcntl(fd, F_DUPFD_CLOEXEC, 55)};
    close(fd);
    for (uint8_t i = 0; i < 5; i++) {
        send_one(copies[i], i);
        assert_reply(frame, recv(copies[3], frame, sizeof frame, 0), i);
    }
    for (unsigned int i = 0; i < 5; i++)
        close(copies[i]);
    assert_int_equal(send(copies[0], frame, sizeof frame, 0), -1);
    assert_int_equal(errno, EBADF);
}

static void two_sockets_both_receive(void **state)
{
    uint8_t frame[FRAME];
    (void)state;
    int one = open_socket(0);
    int two = open_socket(0);
    send_one(one, 9);
    assert_reply(frame, recv(one, frame, sizeof frame, 0), 9);
    assert_reply(frame, recv(two, frame, sizeof frame, 0), 9);
    close(one);
    close(two);
}

static void a_tagged_frame_returns_without_tag(void **state)
{
    uint8_t frame[FRAME + 4];
    uint8_t plain[FRAME];
    (void)state;
    int fd = open_socket(0);
    frame_of(plain, 5);
    memcpy(frame, plain, 12);
    memcpy(frame + 12, (const uint8_t[]){0x81, 0x00, 0xA0, 0x05}, 4);
    memcpy(frame + 16, plain + 12, FRAME - 12);
    assert_int_equal(send(fd, frame, sizeof frame, 0), sizeof frame);
    assert_reply(plain, recv(fd, plain, sizeof plain, 0), 5);
    close(fd);
}

/* --- waiting for several things
 * --------------------------------------------------------------------------------------- */

static void polling_finds_a_reply(void **state)
{
    uint8_t frame[FRAME];
    (void)state;
    int fd = open_socket(0);
    struct pollfd one = {.fd = fd, .events = POLLIN};
    struct epoll_event event = {.events = EPOLLIN, .data.fd = fd};
    fd_set set;
    int all = epoll_create1(0);
    assert_int_equal(epoll_ctl(all, EPOLL_CTL_ADD, fd, &event), 0);

    uint64_t since_ns = now_ns();
    assert_int_equal(poll(&one, 1, 5), 0);
    assert_took(since_ns, 5 * MS);
    since_ns = now_ns();
    assert_int_equal(epoll_wait(all, &event, 1, 5), 0);
    assert_took(since_ns, 5 * MS);
    since_ns = now_ns();
    FD_ZERO(&set);
    FD_SET(fd, &set);
    struct timeval timeout = {.tv_usec = 5000};
    assert_int_equal(select(fd + 1, &set, NULL, NULL, &timeout), 0);
    assert_took(since_ns, 5 * MS);

    send_one(fd, 1);
    assert_int_equal(poll(&one, 1, -1), 1);
    assert_int_equal(ppoll(&one, 1, NULL, NULL), 1);
    assert_int_equal(epoll_wait(all, &event, 1, -1), 1);
    FD_SET(fd, &set);
    assert_int_equal(select(fd + 1, &set, NULL, NULL, NULL), 1);
    FD_SET(fd, &set);
    assert_int_equal(pselect(fd + 1, &set, NULL, NULL, NULL, NULL), 1);
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 1);
    assert_int_equal(poll(&one, 1, 0), 0);
    close(all);
    close(fd);
}

static void timer_descriptors_expire(void **state)
{
    uint64_t expiries;
    (void)state;
    int fd = timerfd_create(CLOCK_MONOTONIC, 0);
    const struct itimerspec every = {.it_value = {.tv_nsec = 3 * MS}, .it_interval = {.tv_nsec = 2 * MS}};
    uint64_t since_ns = now_ns();
    assert_int_equal(timerfd_settime(fd, 0, &every, NULL), 0);
    for (unsigned int i = 0; i < 3; i++)
        assert_int_equal(read(fd, &expiries, sizeof expiries), sizeof expiries);
    assert_took(since_ns, is_virtual ? 7 * MS : 3 * MS);
    close(fd);
}

/* --- time ----------------------------------------------------------------------------------------------------------
 */

static void sleeps_take_their_time(void **state)
{
    const struct timespec five = {.tv_nsec = 5 * MS};
    struct timespec until;
    (void)state;
    uint64_t since_ns = now_ns();
    assert_int_equal(usleep(5000), 0);
    assert_took(since_ns, 5 * MS);
    since_ns = now_ns();
    assert_int_equal(nanosleep(&five, NULL), 0);
    assert_took(since_ns, 5 * MS);
    since_ns = now_ns();
    assert_int_equal(clock_nanosleep(CLOCK_MONOTONIC, 0, &five, NULL), 0);
    assert_took(since_ns, 5 * MS);
    since_ns = now_ns();
    until = (struct timespec){.tv_sec = (time_t)((since_ns + 5 * MS) / 1000000000u),
                              .tv_nsec = (long)((since_ns + 5 * MS) % 1000000000u)};
    assert_int_equal(clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL), 0);
    assert_took(since_ns, 5 * MS);
}

static void clocks_of_the_day_agree(void **state)
{
    struct timeval day;
    struct timespec real;
    (void)state;
    gettimeofday(&day, NULL);
    clock_gettime(CLOCK_REALTIME, &real);
    assert_true(real.tv_sec - day.tv_sec <= 1);
    assert_true(time(NULL) - day.tv_sec <= 1);
}

/* --- timers and signals --------------------------------------------------------------------------------------------
 */

static volatile sig_atomic_t signals_handled;

static void on_signal(int number)
{
    (void)number;
    signals_handled = signals_handled + 1;
}

static void handle(int number, int flags)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = flags};
    assert_int_equal(sigaction(number, &action, NULL), 0);
    signals_handled = 0;
}

static timer_t timer_of(int how, int number)
{
    struct sigevent event = {.sigev_notify = how, .sigev_signo = number};
    timer_t timer;
    assert_int_equal(timer_create(CLOCK_MONOTONIC, &event, &timer), 0);
    return timer;
}

static void start_timer(timer_t timer, long first_ns, long interval_ns)
{
    const struct itimerspec value = {.it_value = {.tv_nsec = first_ns}, .it_interval = {.tv_nsec = interval_ns}};
    assert_int_equal(timer_settime(timer, 0, &value, NULL), 0);
}

static void a_timer_ends_every_kind_of_wait(void **state)
{
    uint8_t frame[FRAME];
    struct timespec left = {0};
    const struct timespec long_time = {.tv_nsec = 500 * MS};
    sigset_t usual;
    struct epoll_event event;
    sem_t semaphore;
    (void)state;
    int fd = open_socket(0);
    int all = epoll_create1(0);
    struct pollfd one = {.fd = fd, .events = POLLIN};
    timer_t timer = timer_of(SIGEV_SIGNAL, SIGUSR1);
    sem_init(&semaphore, 0, 0);
    sigemptyset(&usual);
    handle(SIGUSR1, 0);
    for (unsigned int i = 0; i < 9; i++) {
        const int handled = signals_handled;
        uint64_t since_ns = now_ns();
        start_timer(timer, 5 * MS, is_virtual ? 0 : 5 * MS); /* a busy machine may begin the wait after an expiry */
        int result = i == 0   ? usleep(500000)
                     : i == 1 ? nanosleep(&long_time, &left)
                     : i == 2 ? poll(&one, 1, -1)
                     : i == 3 ? ppoll(&one, 1, NULL, &usual)
                     : i == 4 ? select(0, NULL, NULL, NULL, NULL)
                     : i == 5 ? epoll_wait(all, &event, 1, -1)
                     : i == 6 ? sem_wait(&semaphore)
                     : i == 7 ? pause()
                              : (int)recv(fd, frame, sizeof frame, 0);
        const int error = errno;
        start_timer(timer, 0, 0);
        print_message("wait %u\n", i);
        assert_int_equal(result, -1);
        assert_int_equal(error, EINTR);
        assert_took(since_ns, 5 * MS);
        assert_in_range(signals_handled, handled + 1, is_virtual ? handled + 1 : INT_MAX);
    }
    if (is_virtual)
        assert_in_range(left.tv_nsec, 494 * MS, 495 * MS);
    assert_int_equal(timer_delete(timer), 0);
    close(all);
    close(fd);
}

static void a_periodic_timer_is_accepted_by_sigwait(void **state)
{
    enum { NUMBER = 40 };
    sigset_t set, before;
    siginfo_t info;
    int number = 0;
    struct itimerspec left;
    const struct timespec ten = {.tv_nsec = 10 * MS};
    (void)state;
    sigemptyset(&set);
    sigaddset(&set, NUMBER);
    pthread_sigmask(SIG_BLOCK, &set, &before);
    timer_t timer = timer_of(SIGEV_SIGNAL, NUMBER);
    uint64_t since_ns = now_ns();
    start_timer(timer, 3 * MS, 2 * MS);
    assert_int_equal(sigwait(&set, &number), 0);
    assert_int_equal(number, NUMBER);
    assert_int_equal(sigwaitinfo(&set, &info), NUMBER);
    assert_int_equal(info.si_code, SI_TIMER);
    assert_int_equal(sigtimedwait(&set, &info, &ten), NUMBER);
    assert_took(since_ns, 7 * MS);
    assert_int_equal(timer_gettime(timer, &left), 0);
    assert_int_equal(left.it_interval.tv_nsec, 2 * MS);
    usleep(9000); /* expiries at 2, 4, 6 and 8 ms: one signal, three overruns */
    assert_int_equal(sigwait(&set, &number), 0);
    assert_true(timer_getoverrun(timer) >= 3);
    if (is_virtual)
        assert_int_equal(timer_getoverrun(timer), 3);
    start_timer(timer, 0, 0);
    while (sigtimedwait(&set, &info, &(const struct timespec){0}) > 0)
        ;
    since_ns = now_ns();
    assert_int_equal(sigtimedwait(&set, &info, &ten), -1);
    assert_int_equal(errno, EAGAIN);
    assert_took(since_ns, 10 * MS);
    timer_delete(timer);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

static void post_semaphore(union sigval value)
{
    sem_post(value.sival_ptr);
}

static void a_timer_runs_a_function_in_a_thread(void **state)
{
    static sem_t semaphore; /* on a busy machine a thread of the timer posts after the end of this test */
    struct sigevent event = {
        .sigev_notify = SIGEV_THREAD, .sigev_notify_function = post_semaphore, .sigev_value.sival_ptr = &semaphore};
    timer_t timer;
    (void)state;
    sem_init(&semaphore, 0, 0);
    assert_int_equal(timer_create(CLOCK_REALTIME, &event, &timer), 0);
    uint64_t since_ns = now_ns();
    start_timer(timer, 3 * MS, 2 * MS);
    for (unsigned int i = 0; i < 3; i++)
        assert_int_equal(sem_wait(&semaphore), 0);
    assert_took(since_ns, 7 * MS);
    assert_int_equal(timer_delete(timer), 0);
    usleep(5000);
}

static void interval_timer_and_alarm_send_sigalrm(void **state)
{
    const struct itimerval every = {.it_value.tv_usec = 3000, .it_interval.tv_usec = 2000};
    const struct itimerval none = {0};
    struct itimerval left;
    (void)state;
    handle(SIGALRM, 0);
    uint64_t since_ns = now_ns();
    assert_int_equal(setitimer(ITIMER_REAL, &every, NULL), 0);
    while (signals_handled < 3)
        assert_int_equal(pause(), -1);
    assert_took(since_ns, 7 * MS);
    assert_int_equal(getitimer(ITIMER_REAL, &left), 0);
    assert_int_equal(left.it_interval.tv_usec, 2000);
    assert_int_equal(setitimer(ITIMER_REAL, &none, NULL), 0);
    signals_handled = 0;
    assert_int_equal(alarm(50), 0);
    assert_int_equal(alarm(1), 50);
    if (is_virtual) {
        since_ns = now_ns();
        assert_int_equal(sleep(3), 2);
        assert_took(since_ns, 1000ull * MS - MS / 100);
        assert_int_equal(signals_handled, 1);
    }
    (void)alarm(0);
}

/* --- threads -------------------------------------------------------------------------------------------------------
 */

typedef struct relay {
    pthread_mutex_t mutex;
    pthread_cond_t condition;
    sem_t semaphore;
    unsigned int turn;
    unsigned int rounds;
    int fd;
} relay_t;

static void *play(void *arg)
{
    relay_t *relay = arg;
    for (unsigned int i = 0; i < relay->rounds; i++) {
        pthread_mutex_lock(&relay->mutex);
        while (relay->turn % 2 == 0)
            pthread_cond_wait(&relay->condition, &relay->mutex);
        relay->turn++;
        usleep(1000); /* with the mutex held */
        pthread_cond_signal(&relay->condition);
        pthread_mutex_unlock(&relay->mutex);
    }
    sem_post(&relay->semaphore);
    return relay;
}

static void threads_take_turns(void **state)
{
    relay_t relay = {.mutex = PTHREAD_MUTEX_INITIALIZER, .condition = PTHREAD_COND_INITIALIZER, .rounds = 20};
    pthread_t thread;
    void *result = NULL;
    (void)state;
    sem_init(&relay.semaphore, 0, 0);
    uint64_t since_ns = now_ns();
    assert_int_equal(pthread_create(&thread, NULL, play, &relay), 0);
    for (unsigned int i = 0; i < relay.rounds; i++) {
        pthread_mutex_lock(&relay.mutex);
        while (relay.turn % 2 == 1)
            pthread_cond_wait(&relay.condition, &relay.mutex);
        relay.turn++;
        usleep(1000);
        pthread_cond_signal(&relay.condition);
        pthread_mutex_unlock(&relay.mutex);
    }
    sem_wait(&relay.semaphore);
    assert_int_equal(pthread_join(thread, &result), 0);
    assert_ptr_equal(result, &relay);
    assert_int_equal(relay.turn, 2 * relay.rounds);
    assert_took(since_ns, 40 * MS);
}

static void a_condition_times_out(void **state)
{
    relay_t relay = {.mutex = PTHREAD_MUTEX_INITIALIZER, .condition = PTHREAD_COND_INITIALIZER};
    struct timespec until;
    (void)state;
    sem_init(&relay.semaphore, 0, 0);
    uint64_t since_ns = now_ns();
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += 10 * MS;
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_mutex_lock(&relay.mutex);
    assert_int_equal(pthread_cond_timedwait(&relay.condition, &relay.mutex, &until), ETIMEDOUT);
    pthread_mutex_unlock(&relay.mutex);
    assert_took(since_ns, 10 * MS);
    assert_int_equal(sem_timedwait(&relay.semaphore, &until), -1);
    assert_int_equal(errno, ETIMEDOUT);
}

static void *receive_one(void *arg)
{
    static uint8_t frame[FRAME];
    const relay_t *relay = arg;
    ssize_t length = recv(relay->fd, frame, sizeof frame, 0);
    return length == FRAME ? frame : NULL;
}

static void one_thread_receives_for_another(void **state)
{
    relay_t relay = {.fd = open_socket(0)};
    pthread_t thread;
    void *frame = NULL;
    (void)state;
    assert_int_equal(pthread_create(&thread, NULL, receive_one, &relay), 0);
    usleep(5000);
    send_one(relay.fd, 11);
    assert_int_equal(pthread_join(thread, &frame), 0);
    assert_non_null(frame);
    assert_reply(frame, FRAME, 11);
    close(relay.fd);
}

static void *write_event(void *arg)
{
    const relay_t *relay = arg;
    usleep(3000);
    eventfd_write(relay->fd, 1);
    return NULL;
}

static void an_event_of_another_thread_ends_a_read(void **state)
{
    relay_t relay = {.fd = eventfd(0, 0)};
    pthread_t thread;
    eventfd_t value = 0;
    (void)state;
    uint64_t since_ns = now_ns();
    assert_int_equal(pthread_create(&thread, NULL, write_event, &relay), 0);
    assert_int_equal(read(relay.fd, &value, sizeof value), sizeof value);
    assert_took(since_ns, 3 * MS);
    pthread_join(thread, NULL);
    close(relay.fd);
}

typedef struct meeting {
    pthread_barrier_t barrier;
    unsigned int serial;
} meeting_t;

static void *meet(void *arg)
{
    meeting_t *meeting = arg;
    for (unsigned int i = 0; i < 3; i++) {
        usleep(1000);
        if (pthread_barrier_wait(&meeting->barrier) == PTHREAD_BARRIER_SERIAL_THREAD)
            __atomic_fetch_add(&meeting->serial, 1, __ATOMIC_SEQ_CST);
    }
    return NULL;
}

static void threads_meet_at_a_barrier(void **state)
{
    meeting_t meeting = {0};
    pthread_t threads[2];
    (void)state;
    assert_int_equal(pthread_barrier_init(&meeting.barrier, NULL, 3), 0);
    for (unsigned int i = 0; i < 2; i++)
        pthread_create(&threads[i], NULL, meet, &meeting);
    uint64_t since_ns = now_ns();
    for (unsigned int i = 0; i < 3; i++) {
        usleep(5000);
        if (pthread_barrier_wait(&meeting.barrier) == PTHREAD_BARRIER_SERIAL_THREAD)
            __atomic_fetch_add(&meeting.serial, 1, __ATOMIC_SEQ_CST);
    }
    assert_took(since_ns, 15 * MS);
    for (unsigned int i = 0; i < 2; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(meeting.serial, 3);
    assert_int_equal(pthread_barrier_destroy(&meeting.barrier), 0);
}

typedef struct locks {
    pthread_rwlock_t lock;
    pthread_spinlock_t spin;
    sem_t held, release;
} locks_t;

static void *hold_locks(void *arg)
{
    locks_t *locks = arg;
    pthread_rwlock_wrlock(&locks->lock);
    pthread_spin_lock(&locks->spin);
    sem_post(&locks->held);
    usleep(5000);
    pthread_spin_unlock(&locks->spin);
    sem_wait(&locks->release);
    pthread_rwlock_unlock(&locks->lock);
    return NULL;
}

static struct timespec in_ms(unsigned int ms)
{
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    uint64_t at_ns = (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_nsec + (uint64_t)ms * MS;
    return (struct timespec){.tv_sec = (time_t)(at_ns / 1000000000u), .tv_nsec = (long)(at_ns % 1000000000u)};
}

static void locks_and_joins_end_at_their_deadlines(void **state)
{
    locks_t locks;
    pthread_t thread;
    struct timespec until;
    (void)state;
    pthread_rwlock_init(&locks.lock, NULL);
    pthread_spin_init(&locks.spin, PTHREAD_PROCESS_PRIVATE);
    sem_init(&locks.held, 0, 0);
    sem_init(&locks.release, 0, 0);
    pthread_create(&thread, NULL, hold_locks, &locks);
    sem_wait(&locks.held);
    pthread_spin_lock(&locks.spin);
    pthread_spin_unlock(&locks.spin);
    uint64_t since_ns = now_ns();
    until = in_ms(2);
    assert_int_equal(pthread_rwlock_timedrdlock(&locks.lock, &until), ETIMEDOUT);
    assert_took(since_ns, 2 * MS);
    since_ns = now_ns();
    until = in_ms(3);
    assert_int_equal(pthread_timedjoin_np(thread, NULL, &until), ETIMEDOUT);
    assert_took(since_ns, 3 * MS);
    sem_post(&locks.release);
    until = in_ms(10000);
    assert_int_equal(pthread_rwlock_timedwrlock(&locks.lock, &until), 0);
    until = in_ms(10000);
    assert_int_equal(pthread_timedjoin_np(thread, NULL, &until), 0);
}

/* --- processes ------------------------------------------------------------------------------------------------------
 */

static void a_child_has_a_bus_of_its_own(void **state)
{
    uint8_t frame[FRAME];
    int status = -1;
    (void)state;
    int fd = open_socket(0);
    send_one(fd, 1);
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 1);
    pid_t child = fork();
    if (child == 0) {
        close(fd);
        fd = open_socket(0);
        frame_of(frame, 2);
        bool done = send(fd, frame, sizeof frame, 0) == FRAME && recv(fd, frame, sizeof frame, 0) == FRAME &&
                    counter_of(frame) == 2;
        _exit(done ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    send_one(fd, 3);
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 3);
    close(fd);
}

typedef struct sender {
    int fd;
    atomic_bool ends;
} sender_t;

static void *send_until_the_end(void *arg)
{
    sender_t *its = arg;
    uint8_t frame[FRAME];
    for (uint8_t n = 0; !its->ends; n++) {
        frame_of(frame, n);
        (void)!send(its->fd, frame, sizeof frame, 0);
        (void)!recv(its->fd, frame, sizeof frame, MSG_DONTWAIT);
    }
    return NULL;
}

static void forks_beside_calls_of_another_thread(void **state)
{
    enum { FORKS = 50, LONGEST_S = 30 };
    const struct timeval timeout = {.tv_sec = 1};
    pthread_t thread;
    int status = -1;
    (void)state;
    sender_t its = {.fd = open_socket(0)};
    assert_int_equal(pthread_create(&thread, NULL, send_until_the_end, &its), 0);
    for (unsigned int n = 0; n < FORKS; n++) {
        pid_t child = fork();
        if (child == 0) {
            (void)alarm(LONGEST_S);
            _exit(setsockopt(its.fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout) == 0 ? 0 : 1);
        }
        assert_int_equal(waitpid(child, &status, 0), child);
        if (status != 0)
            fail_msg("child %u of %u: status 0x%04x, expected 0", n + 1, FORKS, (unsigned int)status);
    }
    its.ends = true;
    pthread_join(thread, NULL);
    close(its.fd);
}

/* No time of the virtual clock passes while CMD waits for another process. */
static void child_processes_end_in_order(void **state)
{
    char line[16] = "";
    int status = -1;
    siginfo_t info;
    (void)state;
    int fd = open_socket(0);
    uint64_t since_ns = now_ns();
    assert_int_equal(system("exit 3"), 3 << 8);
    FILE *output = popen("echo hello", "re");
    assert_non_null(fgets(line, sizeof line, output));
    assert_string_equal(line, "hello\n");
    assert_int_equal(pclose(output), 0);
    for (unsigned int i = 0; i < 7; i++) {
        pid_t child = fork();
        if (child == 0)
            _exit(5);
        if (i == 6)
            (void)setpgid(child, child);
        pid_t ended = i == 0                                            ? wait(&status)
                      : i == 1                                          ? waitpid(child, &status, 0)
                      : i == 2                                          ? wait4(child, &status, 0, NULL)
                      : i == 4                                          ? waitpid(-1, &status, 0)
                      : i == 5                                          ? waitpid(0, &status, 0)
                      : i == 6                                          ? waitpid(-child, &status, 0)
                      : waitid(P_PID, (id_t)child, &info, WEXITED) == 0 ? child
                                                                        : -1;
        assert_int_equal(ended, child);
        assert_int_equal(WEXITSTATUS(status), 5);
    }
    assert_took(since_ns, 0);
    close(fd);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"write, sendto, sendmsg, writev send; read, recvfrom, recvmsg, readv receive", sends_and_receives, NULL, NULL,
         NULL},
        {"sendmmsg and recvmmsg carry several frames", sends_and_receives_many, NULL, NULL, NULL},
        {"readv fills pieces of any length, and nothing behind the frame", pieces_of_a_frame, NULL, NULL, NULL},
        {"recvfrom, recvmsg and getsockname return the address of the interface", addresses_of_frames, NULL, NULL,
         NULL},
        {"A receive without room takes a frame", receives_into_no_room, NULL, NULL, NULL},
        {"getsockopt returns type, domain, buffers and timeout", options_are_read_back, NULL, NULL, NULL},
        {"A socket may have descriptor 0; fcntl and ioctl change the descriptor alone", descriptor_0, NULL, NULL, NULL},
        {"Unbound sockets, foreign interfaces, short and long frames: the kernel's errors", refuses_as_the_kernel, NULL,
         NULL, NULL},
        {"A receive without a frame waits as long as the socket is set to", waits_as_long_as_asked, NULL, NULL, NULL},
        {"O_NONBLOCK by fcntl and FIONBIO by ioctl", fcntl_and_ioctl_set_nonblocking, NULL, NULL, NULL},
        {"MSG_PEEK leaves the frame, MSG_TRUNC returns its length", peeks_and_truncates, NULL, NULL, NULL},
        {"The interface has an index, flags, MTU and address, and is listed", interface_has_its_attributes, NULL, NULL,
         NULL},
        {"An interface that is down sends nothing; up again, the twins reply", an_interface_that_is_down_sends_nothing,
         NULL, NULL, NULL},
        {"dup, dup2, dup3 and F_DUPFD make descriptors of the same socket", copies_of_a_descriptor_are_the_socket, NULL,
         NULL, NULL},
        {"Two sockets on one interface both receive a reply", two_sockets_both_receive, NULL, NULL, NULL},
        {"A frame with a VLAN tag is replied to; the socket sees the reply without the tag",
         a_tagged_frame_returns_without_tag, NULL, NULL, NULL},
        {"poll, ppoll, select, pselect, epoll wait for a reply, or for their timeout", polling_finds_a_reply, NULL,
         NULL, NULL},
        {"A timer descriptor expires at its times", timer_descriptors_expire, NULL, NULL, NULL},
        {"Sleeps take the requested time", sleeps_take_their_time, NULL, NULL, NULL},
        {"Clocks of the time of day agree", clocks_of_the_day_agree, NULL, NULL, NULL},
        {"A timer of timer_create ends sleeps, poll, ppoll, select, epoll_wait, sem_wait, pause and recv with EINTR",
         a_timer_ends_every_kind_of_wait, NULL, NULL, NULL},
        {"A periodic timer is accepted by sigwait, sigwaitinfo and sigtimedwait, and counts its overruns",
         a_periodic_timer_is_accepted_by_sigwait, NULL, NULL, NULL},
        {"A timer with SIGEV_THREAD runs its function at its times", a_timer_runs_a_function_in_a_thread, NULL, NULL,
         NULL},
        {"setitimer and alarm send SIGALRM at their times", interval_timer_and_alarm_send_sigalrm, NULL, NULL, NULL},
        {"Threads hand over by mutex, condition and semaphore", threads_take_turns, NULL, NULL, NULL},
        {"A condition and a semaphore end at their deadlines", a_condition_times_out, NULL, NULL, NULL},
        {"A thread that waits in recv gets the reply to a frame of another thread", one_thread_receives_for_another,
         NULL, NULL, NULL},
        {"A read of an event descriptor ends when another thread writes", an_event_of_another_thread_ends_a_read, NULL,
         NULL, NULL},
        {"Threads meet at a barrier when the last one comes", threads_meet_at_a_barrier, NULL, NULL, NULL},
        {"Read-write locks and joins end at their deadlines; a spin lock waits for its holder",
         locks_and_joins_end_at_their_deadlines, NULL, NULL, NULL},
        {"system, popen, wait, waitpid, wait4 and waitid wait for another process", child_processes_end_in_order, NULL,
         NULL, NULL},
        {"A child made by fork has a bus of its own", a_child_has_a_bus_of_its_own, NULL, NULL, NULL},
        {"Children made by fork while another thread sends can call its sockets", forks_beside_calls_of_another_thread,
         NULL, NULL, NULL},
    };
    if (!is_started(argc, argv))
        return 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
