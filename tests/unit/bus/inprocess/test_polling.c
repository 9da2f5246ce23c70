/* SPDX-License-Identifier: MIT */
/* poll, select and epoll on the virtual clock. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/inprocess/deadline.h"
#include "bus/inprocess/ports.h"
#include "bus/inprocess/signals.h"
#include "bus/inprocess/threads.h"
#include "bus/inprocess/time.h"
#include "fakes.h"

/* Descriptors that are numbers only. */
enum { PORT = 700, FULL = 701, PORTS_END = 702, OTHER = 5, PIPE = 6 };

OURS(poll);
OURS(ppoll);
OURS(select);
OURS(pselect);
OURS(epoll_wait);
OURS(epoll_pwait);
int ours___poll_chk(struct pollfd *fds, nfds_t count, int timeout_ms, size_t room);
int ours___ppoll_chk(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask,
                     size_t room);
int ours_epoll_pwait2(int fd, struct epoll_event *events, int most, const struct timespec *timeout,
                      const sigset_t *mask);

static uint64_t now_ns;
static ect_wait_t end_of_wait;
static unsigned int looks; /* at the condition of a wait */
static short revents;      /* of the real poll() */
static struct timeval receive_timeout;

/* --- fakes -------------------------------------------------------------------------------------------------------- */

static int fake_poll(struct pollfd *fds, nfds_t count, int timeout_ms)
{
    long result = CALLED(poll, count > 0 ? fds->fd : 0, (long)count, timeout_ms);
    if (count > 0 && result > 0)
        fds->revents = revents;
    return (int)result;
}

static int fake___poll_chk(struct pollfd *fds, nfds_t count, int timeout_ms, size_t room)
{
    return (int)CALLED(__poll_chk, (long)fds, (long)count, timeout_ms, (long)room);
}

static int fake_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask)
{
    return (int)CALLED(ppoll, (long)fds, (long)count, (long)timeout, (long)mask);
}

static int fake___ppoll_chk(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask,
                            size_t room)
{
    return (int)CALLED(__ppoll_chk, (long)fds, (long)count, (long)timeout, (long)mask, (long)room);
}

static long word_of(const fd_set *set)
{
    return (long)set < 4096 ? (long)set : (long)set->fds_bits[0];
}

/* Only descriptor 0 of the first set is ready. The timeout is one of 0. */
static int fake_select(int count, fd_set *restrict to_read, fd_set *restrict to_write, fd_set *restrict except,
                       struct timeval *restrict timeout)
{
    long limit = (long)timeout < 4096 ? (long)timeout : timeout->tv_sec + timeout->tv_usec;
    long result = CALLED(select, count, word_of(to_read), word_of(to_write), word_of(except), limit);
    if ((long)to_read > 4096)
        to_read->fds_bits[0] = 1;
    return (int)result;
}

static int fake_pselect(int count, fd_set *restrict to_read, fd_set *restrict to_write, fd_set *restrict except,
                        const struct timespec *restrict timeout, const sigset_t *restrict mask)
{
    return (int)CALLED(pselect, count, (long)to_read, (long)to_write, (long)except, (long)timeout, (long)mask);
}

static int fake_epoll_wait(int fd, struct epoll_event *events, int most, int timeout_ms)
{
    return (int)CALLED(epoll_wait, fd, (long)events, most, timeout_ms);
}

static int fake_epoll_pwait(int fd, struct epoll_event *events, int most, int timeout_ms, const sigset_t *mask)
{
    return (int)CALLED(epoll_pwait, fd, (long)events, most, timeout_ms, (long)mask);
}

static int fake_epoll_pwait2(int fd, struct epoll_event *events, int most, const struct timespec *timeout,
                             const sigset_t *mask)
{
    return (int)CALLED(epoll_pwait2, fd, (long)events, most, (long)timeout, (long)mask);
}

static int fake_getsockopt(int fd, int level, int name, void *restrict value, socklen_t *restrict length)
{
    assert_int_equal(level, SOL_SOCKET);
    assert_int_equal(name, SO_RCVTIMEO);
    assert_int_equal(*length, sizeof receive_timeout);
    memcpy(value, &receive_timeout, sizeof receive_timeout);
    return (int)CALLED(getsockopt, fd);
}

static int fake_fcntl(int fd, int command, ...)
{
    assert_int_equal(command, F_GETFL);
    return (int)CALLED(fcntl, fd);
}

FAKES(FAKE(poll), FAKE(__poll_chk), FAKE(ppoll), FAKE(__ppoll_chk), FAKE(select), FAKE(pselect), FAKE(epoll_wait),
      FAKE(epoll_pwait), FAKE(epoll_pwait2), FAKE(getsockopt), FAKE(fcntl))

int fake_fstat(int fd, struct stat *its);
int fake_fstat(int fd, struct stat *its)
{
    *its = (struct stat){.st_mode = fd == PIPE ? S_IFIFO : S_IFREG};
    return fd < 0 ? -1 : 0;
}

ect_port_t *ect_port_of(int fd)
{
    return fd >= PORT && fd < PORTS_END ? (ect_port_t *)(long)fd : NULL;
}

bool ect_port_has_frame(const ect_port_t *port)
{
    return (long)port == FULL;
}

void ect_ports_show(void)
{
    CALLED(show);
}

int ect_signals_mask(const sigset_t *mask, sigset_t *before)
{
    (void)before;
    return (int)CALLED(mask, (long)mask);
}

void ect_signals_unmask(const sigset_t *mask, const sigset_t *before)
{
    (void)before;
    CALLED(unmask, (long)mask);
}

uint64_t ect_virtual_now(void)
{
    return now_ns;
}

void ect_virtual_charge(uint64_t cost_ns)
{
    CALLED(charge, (long)cost_ns);
}

static ect_wait_t wait_until(const char *kind, bool (*ready)(void *arg), void *arg, const char *call, uint64_t until_ns)
{
    char name[48];
    long span_ns = until_ns == UINT64_MAX ? -1 : (long)(until_ns - now_ns);
    snprintf(name, sizeof name, "%s %.*s", kind, call ? (int)strcspn(call, "(") : 7, call ? call : "the bus");
    fake_call(name, &span_ns, 1);
    for (unsigned int i = 0; i < looks; i++)
        CALLED(ready, ready(arg));
    return end_of_wait;
}

ect_wait_t ect_virtual_wait_until(bool (*ready)(void *arg), void *arg, const char *outside, uint64_t until_ns)
{
    return wait_until("wait", ready, arg, outside, until_ns);
}

ect_wait_t ect_virtual_wait_for_process(bool (*ready)(void *arg), void *arg, const char *call, uint64_t until_ns)
{
    return wait_until("stop", ready, arg, call, until_ns);
}

bool ect_virtual_restarts(void)
{
    return CALLED(restarts) != 0;
}

bool ect_virtual_has_child(void)
{
    return CALLED(has_child) != 0;
}

static int begin(void **state)
{
    now_ns = ECT_VIRTUAL_START_NS;
    end_of_wait = ECT_WAIT_WOKEN;
    looks = 1;
    revents = POLLIN;
    receive_timeout = (struct timeval){0};
    return begin_fakes(state);
}

/* --- poll --------------------------------------------------------------------------------------------------------- */

static void polls_ports(void **state)
{
    static const struct {
        int fd;
        short events, revents;
    } rows[] = {{PORT, POLLIN, 0},
                {PORT, POLLIN | POLLOUT, POLLOUT},
                {PORT, POLLWRNORM | POLLRDNORM, POLLWRNORM},
                {FULL, POLLIN | POLLPRI, POLLIN},
                {FULL, POLLRDNORM | POLLWRNORM, POLLRDNORM | POLLWRNORM},
                {FULL, POLLOUT, POLLOUT}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct pollfd one = {.fd = rows[i].fd, .events = rows[i].events, .revents = POLLNVAL};
        int want = rows[i].revents != 0;
        assert_int_equal(ours_poll(&one, 1, 7), want);
        assert_int_equal(one.revents, rows[i].revents);
        EXPECT_CALLS("one", want ? "charge(1000) wait the bus(7000000) ready(1) "
                                 : "charge(1000) wait the bus(7000000) ready(0) ");
    }
    struct pollfd two[] = {{.fd = FULL, .events = POLLIN}, {.fd = FULL, .events = POLLIN}};
    assert_int_equal(ours_poll(two, 2, -1), 2);
    EXPECT_CALLS("two", "charge(1000) wait the bus(-1) ready(1) ");
}

static void polls_others(void **state)
{
    struct pollfd mixed[] = {{.fd = PORT, .events = POLLIN}, {.fd = OTHER, .events = POLLIN}};
    (void)state;
    plan("poll", 0, 0);
    plan("poll", 1, 0);
    assert_int_equal(ours_poll(mixed, 2, 7), 1);
    assert_int_equal(mixed[0].revents, POLLIN);
    EXPECT_CALLS("mixed", "charge(1000) show() poll(700,2,0) wait poll(7000000) show() poll(700,2,0) ready(1) ");
    plan("poll", -1, EINVAL);
    assert_int_equal(ours_poll(mixed, 2, 0), 0);
    EXPECT_CALLS("mixed, at once", "charge(1000) show() poll(700,2,0) wait poll(0) show() poll(700,2,0) ready(0) ");
    assert_int_equal(ours_poll(NULL, 0, 7), 0);
    EXPECT_CALLS("none", "charge(1000) show() poll(0,0,0) wait poll(7000000) show() poll(0,0,0) ready(0) ");
    errno = 0;
    assert_int_equal(ours_poll(AT(0), 1, 7), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("a bad address", "charge(1000) ");
}

/* Time is stopped while the program waits for a pipe and has a child. */
static void polls_pipes(void **state)
{
    static const struct {
        int fd;
        long child, ready;
        const char *calls;
    } rows[] = {
        {PIPE, 1, 0, "charge(1000) show() poll(6,1,0) has_child() stop poll(-1) "},
        {PIPE, 0, 0, "charge(1000) show() poll(6,1,0) has_child() wait poll(-1) "},
        {PIPE, 1, 1, "charge(1000) show() poll(6,1,0) wait poll(-1) "},
        {OTHER, 1, 0, "charge(1000) show() poll(5,1,0) wait poll(-1) "},
        {-3, 1, 0, "charge(1000) show() poll(-3,1,0) wait poll(-1) "},
    };
    (void)state;
    looks = 0;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct pollfd one = {.fd = rows[i].fd, .events = POLLIN};
        plan("poll", rows[i].ready, 0);
        if (strstr(rows[i].calls, "has_child"))
            plan("has_child", rows[i].child, 0);
        assert_int_equal(ours_poll(&one, 1, -1), rows[i].ready);
        EXPECT_CALLS("a descriptor", rows[i].calls);
    }
    struct pollfd two[] = {{.fd = OTHER}, {.fd = PIPE}};
    plan("has_child", 1, 0);
    (void)ours_poll(two, 2, -1);
    EXPECT_CALLS("the second", "charge(1000) show() poll(5,2,0) has_child() stop poll(-1) ");
}

static void ends_with_a_handler(void **state)
{
    struct pollfd one = {.fd = FULL, .events = POLLIN};
    fd_set set;
    (void)state;
    FD_ZERO(&set);
    end_of_wait = ECT_WAIT_INTERRUPTED;
    for (unsigned int call = 0; call < 3; call++) {
        errno = 0;
        int result = call == 0   ? ours_poll(&one, 1, 7)
                     : call == 1 ? ours_select(1, &set, NULL, NULL, NULL)
                                 : ours_epoll_wait(OTHER, AT(8), 9, 10);
        assert_int_equal(result, -1);
        assert_int_equal(errno, EINTR);
    }
    end_of_wait = ECT_WAIT_TIMED_OUT;
    one.fd = PORT;
    assert_int_equal(ours_poll(&one, 1, 7), 0);
    forget_calls();
}

static void polls_with_a_mask(void **state)
{
    struct pollfd one = {.fd = FULL, .events = POLLIN};
    const struct timespec span = {.tv_sec = 1, .tv_nsec = 2};
    (void)state;
    assert_int_equal(ours_ppoll(&one, 1, &span, AT(8)), 1);
    EXPECT_CALLS("ppoll", "charge(1000) mask(8) wait the bus(1000000002) ready(1) unmask(8) ");
    one.fd = OTHER;
    plan("poll", 0, 0);
    plan("poll", 1, 0);
    assert_int_equal(ours_ppoll(&one, 1, NULL, AT(8)), 1);
    EXPECT_CALLS("another",
                 "charge(1000) mask(8) show() poll(5,1,0) wait ppoll(-1) show() poll(5,1,0) ready(1) unmask(8) ");
    plan("mask", -1, EINTR);
    assert_int_equal(ours_ppoll(&one, 1, NULL, AT(8)), -1);
    EXPECT_CALLS("a signal is pending", "charge(1000) mask(8) unmask(8) ");
}

static void checks_the_room(void **state)
{
    struct pollfd two[2] = {{.fd = FULL, .events = POLLIN}, {.fd = FULL, .events = POLLIN}};
    char want[96];
    (void)state;
    assert_int_equal(ours___poll_chk(two, 2, 7, sizeof two), 2);
    EXPECT_CALLS("poll", "charge(1000) wait the bus(7000000) ready(1) ");
    plan("__poll_chk", 3, 0);
    assert_int_equal(ours___poll_chk(two, 2, 7, sizeof two - 1), 3);
    snprintf(want, sizeof want, "__poll_chk(%ld,2,7,%zu) ", (long)two, sizeof two - 1);
    EXPECT_CALLS("poll, too large", want);
    assert_int_equal(ours___ppoll_chk(two, 2, NULL, NULL, sizeof two), 2);
    EXPECT_CALLS("ppoll", "charge(1000) mask(0) wait the bus(-1) ready(1) unmask(0) ");
    plan("__ppoll_chk", 4, 0);
    assert_int_equal(ours___ppoll_chk(two, 2, AT(8), AT(9), sizeof two - 1), 4);
    snprintf(want, sizeof want, "__ppoll_chk(%ld,2,8,9,%zu) ", (long)two, sizeof two - 1);
    EXPECT_CALLS("ppoll, too large", want);
}

/* --- select and epoll --------------------------------------------------------------------------------------------- */

static void selects(void **state)
{
    struct timeval limit = {.tv_sec = 1, .tv_usec = 2};
    const struct timespec span = {.tv_sec = 1, .tv_nsec = 2};
    fd_set sets[3];
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        FD_ZERO(&sets[i]);
        FD_SET(i + 1, &sets[i]);
    }
    looks = 2;
    plan("select", 0, 0);
    plan("select", 1, 0);
    assert_int_equal(ours_select(4, &sets[0], &sets[1], &sets[2], &limit), 1);
    assert_int_equal(sets[0].fds_bits[0], 1);
    EXPECT_CALLS("select", "charge(1000) wait select(1000002000) show() select(4,2,4,8,0) ready(0) show() "
                           "select(4,2,4,8,0) ready(1) ");
    looks = 1;
    plan("select", 1, 0);
    assert_int_equal(ours_select(4, NULL, &sets[1], NULL, NULL), 1);
    EXPECT_CALLS("one set", "charge(1000) wait select(-1) show() select(4,0,4,0,0) ready(1) ");
    plan("select", 1, 0);
    assert_int_equal(ours_pselect(4, &sets[2], NULL, NULL, &span, AT(8)), 1);
    EXPECT_CALLS("pselect",
                 "mask(8) charge(1000) wait select(1000000002) show() select(4,8,0,0,0) ready(1) unmask(8) ");
    plan("mask", -1, EINTR);
    assert_int_equal(ours_pselect(4, &sets[2], NULL, NULL, NULL, AT(8)), -1);
    EXPECT_CALLS("a signal is pending", "mask(8) unmask(8) ");
}

/* The sets of a system call may be smaller than an fd_set: bytes behind the last word are another's. */
static void selects_small_sets(void **state)
{
    static const struct {
        int count;
        size_t words;
    } rows[] = {
        {-1, 0}, {0, 0}, {1, 1}, {64, 1}, {65, 2}, {FD_SETSIZE, FD_SETSIZE / 64}, {FD_SETSIZE + 1, FD_SETSIZE / 64}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        size_t size = rows[i].words * sizeof(fd_mask);
        uint8_t *words = malloc(size > 0 ? size : 1); /* AddressSanitizer finds a byte too many */
        assert_non_null(words);
        memset(words, 0x55, size > 0 ? size : 1);
        looks = 2;
        (void)ours_select(rows[i].count, NULL, (fd_set *)(void *)(size > 0 ? words : NULL), NULL, NULL);
        for (size_t at = 0; at < size; at++)
            assert_int_equal(words[at], 0x55);
        free(words);
        forget_calls();
    }
}

static void polls_by_epoll(void **state)
{
    const struct timespec span = {.tv_sec = 1, .tv_nsec = 2};
    (void)state;
    plan("epoll_wait", 2, 0);
    assert_int_equal(ours_epoll_wait(OTHER, AT(8), 9, 10), 2);
    EXPECT_CALLS("epoll_wait", "charge(1000) wait epoll_wait(10000000) show() epoll_wait(5,8,9,0) ready(1) ");
    assert_int_equal(ours_epoll_wait(OTHER, AT(8), 9, -1), 0);
    EXPECT_CALLS("without a limit", "charge(1000) wait epoll_wait(-1) show() epoll_wait(5,8,9,0) ready(0) ");
    plan("epoll_wait", -1, EBADF);
    assert_int_equal(ours_epoll_pwait(OTHER, AT(8), 9, 10, AT(11)), -1);
    EXPECT_CALLS("epoll_pwait",
                 "mask(11) charge(1000) wait epoll_wait(10000000) show() epoll_wait(5,8,9,0) ready(1) unmask(11) ");
    plan("epoll_wait", 3, 0);
    assert_int_equal(ours_epoll_pwait2(OTHER, AT(8), 9, &span, AT(11)), 3);
    EXPECT_CALLS("epoll_pwait2",
                 "mask(11) charge(1000) wait epoll_wait(1000000002) show() epoll_wait(5,8,9,0) ready(1) unmask(11) ");
    plan("mask", -1, EINTR);
    assert_int_equal(ours_epoll_pwait2(OTHER, AT(8), 9, NULL, AT(11)), -1);
    EXPECT_CALLS("a signal is pending", "mask(11) unmask(11) ");
}

static void leaves_the_library_alone(void **state)
{
    (void)state;
    ect_inside = 1;
    plan("poll", 1, 0);
    plan("ppoll", 2, 0);
    plan("select", 3, 0);
    plan("pselect", 4, 0);
    plan("epoll_wait", 5, 0);
    plan("epoll_pwait", 6, 0);
    plan("epoll_pwait2", 7, 0);
    struct pollfd one = {.fd = OTHER};
    assert_int_equal(ours_poll(&one, 1, 10), 1);
    assert_int_equal(ours_ppoll(AT(8), 9, AT(10), AT(11)), 2);
    assert_int_equal(ours_select(8, AT(9), AT(10), AT(11), AT(12)), 3);
    assert_int_equal(ours_pselect(8, AT(9), AT(10), AT(11), AT(12), AT(13)), 4);
    assert_int_equal(ours_epoll_wait(8, AT(9), 10, 11), 5);
    assert_int_equal(ours_epoll_pwait(8, AT(9), 10, 11, AT(12)), 6);
    assert_int_equal(ours_epoll_pwait2(8, AT(9), 10, AT(11), AT(12)), 7);
    EXPECT_CALLS("real", "poll(5,1,10) ppoll(8,9,10,11) select(8,9,10,11,12) pselect(8,9,10,11,12,13) "
                         "epoll_wait(8,9,10,11) epoll_pwait(8,9,10,11,12) epoll_pwait2(8,9,10,11,12) ");
}

/* --- reads that wait ---------------------------------------------------------------------------------------------- */

static void waits_before_a_read(void **state)
{
    (void)state;
    receive_timeout = (struct timeval){.tv_sec = 1, .tv_usec = 2};
    (void)ect_time_before_read("read()", OTHER, 0);
    EXPECT_CALLS("a limit", "poll(5,1,0) fcntl(5) getsockopt(5) show() poll(5,1,0) wait read(1000002000) show() "
                            "poll(5,1,0) ready(0) ");
    static const struct {
        struct timeval limit;
        long result;
        const char *wait;
    } rows[] = {{{0, 0}, 0, "wait read(-1)"},
                {{0, 1}, 0, "wait read(1000)"},
                {{1, 0}, 0, "wait read(1000000000)"},
                {{1, 0}, -1, "wait read(-1)"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        receive_timeout = rows[i].limit;
        plan("getsockopt", rows[i].result, ENOTSOCK);
        (void)ect_time_before_read("read()", OTHER, 0);
        assert_non_null(strstr(fakes.log, rows[i].wait));
        forget_calls();
    }
}

static void ends_a_read(void **state)
{
    static const struct {
        ect_wait_t end;
        time_t limit_s;
        bool restarts; /* the first handler */
        int error;     /* 0: the master reads */
        long waits;
    } rows[] = {{ECT_WAIT_TIMED_OUT, 1, false, 0, 1},      {ECT_WAIT_INTERRUPTED, 1, false, EINTR, 1},
                {ECT_WAIT_INTERRUPTED, 1, true, EINTR, 1}, {ECT_WAIT_INTERRUPTED, 0, false, EINTR, 1},
                {ECT_WAIT_INTERRUPTED, 0, true, EINTR, 2}, {ECT_WAIT_WOKEN, 1, false, 0, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        receive_timeout = (struct timeval){.tv_sec = rows[i].limit_s};
        end_of_wait = rows[i].end;
        plan("poll", 0, 0);
        plan("poll", 0, 0);
        plan("poll", rows[i].end == ECT_WAIT_WOKEN, 0);
        plan("restarts", rows[i].restarts, 0);
        errno = 0;
        bool reads = ect_time_before_read("read()", OTHER, 0);
        long waits = 0;
        for (const char *at = fakes.log; (at = strstr(at, "wait read")); at++)
            waits++;
        if (reads != (rows[i].error == 0) || (!reads && errno != rows[i].error) || waits != rows[i].waits)
            fail_msg("row %zu: %s, errno %d, %ld waits", i, reads ? "reads" : "ends", errno, waits);
        forget_calls();
    }
}

static void does_not_wait_before_others(void **state)
{
    (void)state;
    assert_true(ect_time_before_read("read()", OTHER, MSG_DONTWAIT));
    EXPECT_CALLS("MSG_DONTWAIT", "");
    plan("poll", 1, 0);
    assert_true(ect_time_before_read("read()", OTHER, 0));
    EXPECT_CALLS("readable", "poll(5,1,0) ");
    plan("fcntl", O_RDWR | O_NONBLOCK, 0);
    assert_true(ect_time_before_read("read()", OTHER, 0));
    EXPECT_CALLS("O_NONBLOCK", "poll(5,1,0) fcntl(5) ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"Sockets of the bus are polled without a system call", polls_ports, begin, NULL, NULL},
        {"Other descriptors are polled by the C library, without a timeout", polls_others, begin, NULL, NULL},
        {"Time is stopped while the program waits for a pipe of a child", polls_pipes, begin, NULL, NULL},
        {"A handler ends a wait with EINTR", ends_with_a_handler, begin, NULL, NULL},
        {"ppoll() sets the mask for the wait alone", polls_with_a_mask, begin, NULL, NULL},
        {"A fortified poll of more descriptors than there is room for is the C library's", checks_the_room, begin, NULL,
         NULL},
        {"select() checks the wanted descriptors each time", selects, begin, NULL, NULL},
        {"select() touches only the words of its sets", selects_small_sets, begin, NULL, NULL},
        {"epoll_wait() and its variants wait on the virtual clock", polls_by_epoll, begin, NULL, NULL},
        {"The library itself polls in real time", leaves_the_library_alone, begin, NULL, NULL},
        {"A read that would block waits on the virtual clock", waits_before_a_read, begin, NULL, NULL},
        {"signal(7): a read ends with EINTR after a handler without SA_RESTART, or with a timeout; recv(2): with "
         "EAGAIN",
         ends_a_read, begin, NULL, NULL},
        {"A read that would not block does not wait", does_not_wait_before_others, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
