/* SPDX-License-Identifier: MIT */
/* Packet sockets of a bus that is the test's. */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/uio.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/eventfds.h"
#include "bus/inprocess/ports.h"
#include "bus/library.h"
#include "fake_process.h"
#include "fakes.h"

/* Of bus/inprocess/time.h, where it is constant: this test runs on both clocks. */
extern bool ect_time_is_virtual;
bool ect_time_is_virtual = true;

enum { HEADER = 14, FD = 20, ECAT = 0x88A4, DESCRIPTORS = 65536 };
#define NOW_NS 5000ull

static int locked;
static bool down[ECT_BUS_ENDS];
static ect_bus_deliver_t *deliver;
static unsigned int blocks; /* of memory that is left */
static void (*on_wait)(void);
static uint8_t sent[ECTWIN_FRAME_MAX];

/* --- fakes ----------------------------------------------------------------------------------------------------------
 */

static int fake_close(int fd)
{
    return (int)CALLED(close, fd);
}

static int fake_fcntl(int fd, int command, ...)
{
    va_list arguments;
    va_start(arguments, command);
    int argument = va_arg(arguments, int);
    va_end(arguments);
    if (command == F_GETFD || command == F_GETFL)
        return (int)(command == F_GETFD ? CALLED(get_fd, fd) : CALLED(get_fl, fd));
    if (command == F_DUPFD_CLOEXEC)
        return (int)CALLED(copy, fd, argument);
    assert_int_equal(command, F_SETFL);
    return (int)CALLED(fcntl, fd, argument);
}

static int fake_dup3(int fd, int to, int flags)
{
    return (int)CALLED(dup3, fd, to, flags);
}

static ssize_t fake_read(int fd, void *data, size_t size)
{
    memset(data, 0, size);
    CALLED(read, fd, (long)size);
    return (ssize_t)size;
}

FAKES(FAKE(close), FAKE(dup3), FAKE(fcntl), FAKE(read))

void *fake_calloc(size_t count, size_t size)
{
    void *memory = blocks > 0 && blocks-- > 0 ? calloc(count, size) : NULL;
    errno = memory ? errno : ENOMEM;
    return memory;
}

static unsigned int mapped; /* pieces of memory */

void *fake_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset)
{
    void *memory = blocks > 0 && blocks-- > 0 ? calloc(1, size) : NULL;
    assert_true(!at && fd == -1 && offset == 0);
    assert_int_equal(protection, PROT_READ | PROT_WRITE);
    assert_int_equal(flags, MAP_PRIVATE | MAP_ANONYMOUS);
    errno = memory ? errno : ENOMEM;
    mapped += memory ? 1 : 0;
    return memory ? memory : MAP_FAILED;
}

int fake_munmap(void *memory, size_t size)
{
    assert_true(size > 0);
    free(memory);
    mapped--;
    return 0;
}

int fake_eventfd(unsigned int value, int flags)
{
    if (value == 0)
        return (int)CALLED(eventfd, flags);
    assert_int_equal(value, 1);
    return (int)CALLED(eventfd_with_1, flags);
}

int fake_eventfd_write(int fd, eventfd_t value)
{
    return (int)CALLED(show, fd, value > 0);
}

/* --- the rest of the room
 * --------------------------------------------------------------------------------------------- */

void ect_time_lock(void)
{
    assert_int_equal(locked++, 0);
}

void ect_time_unlock(void)
{
    assert_int_equal(--locked, 0);
}

uint64_t ect_time_now(void)
{
    assert_int_equal(locked, 1);
    return NOW_NS;
}

void ect_time_charge(uint64_t cost_ns)
{
    assert_int_equal(locked, 0);
    CALLED(charge, (long)cost_ns);
}

void ect_time_bus_started(void)
{
    assert_int_equal(locked, 1);
    CALLED(bus_started);
}

void ect_time_bus_next(uint64_t next_ns)
{
    assert_int_equal(locked, 1);
    CALLED(next, (long)next_ns);
}

bool ect_time_wait(int fd, bool (*ready)(const void *arg), const void *arg, uint64_t until_ns)
{
    assert_int_equal(locked, 1);
    assert_false(ready(arg));
    bool ended = CALLED(wait, fd, (long)until_ns) != 0;
    ect_time_unlock(); /* as while a thread waits */
    if (on_wait)
        on_wait();
    ect_time_lock();
    return !ended && ready(arg);
}

int ect_bus_end_of_index(int index)
{
    int end = index - ECT_BUS_INDEX;
    return end >= 0 && end < ECT_BUS_ENDS ? end : -1;
}

int ect_bus_start(uint64_t now_ns, ect_bus_deliver_t *its)
{
    assert_true(now_ns == NOW_NS);
    assert_int_equal(locked, 1);
    deliver = its;
    return (int)CALLED(start);
}

bool ect_bus_is_up(unsigned int end)
{
    assert_int_equal(locked, 1);
    return !down[end];
}

void ect_bus_plug(unsigned int end, bool in, uint64_t now_ns)
{
    assert_int_equal(locked, 1);
    CALLED(plug, end, in, (long)now_ns);
}

uint64_t ect_bus_frame(unsigned int end, const void *frame, size_t length, uint64_t now_ns)
{
    assert_int_equal(locked, 1);
    assert_true(now_ns == NOW_NS);
    memcpy(sent, frame, length);
    return (uint64_t)CALLED(frame, end, (long)length);
}

/* --- helpers
 * ---------------------------------------------------------------------------------------------------------- */

static int begin(void **state)
{
    ect_time_is_virtual = true;
    locked = 0;
    memset(down, 0, sizeof down);
    blocks = 10000;
    on_wait = NULL;
    return begin_fakes(state);
}

static ect_port_t *open_port(int fd, int protocol)
{
    plan("eventfd", fd, 0);
    assert_int_equal(ect_port_open(SOCK_RAW, htons((uint16_t)protocol)), fd);
    forget_calls();
    return ect_port_of(fd);
}

static struct sockaddr_ll address_of(int index, int protocol)
{
    return (struct sockaddr_ll){
        .sll_family = AF_PACKET, .sll_ifindex = index, .sll_protocol = htons((uint16_t)protocol)};
}

static int bind_to(ect_port_t *port, int index, int protocol)
{
    const struct sockaddr_ll to = address_of(index, protocol);
    return ect_port_bind(port, (const struct sockaddr *)(const void *)&to, sizeof to);
}

static ect_port_t *bound_port(int fd, int protocol, int end)
{
    ect_port_t *port = open_port(fd, protocol);
    assert_int_equal(bind_to(port, ECT_BUS_INDEX + end, 0), 0);
    forget_calls();
    return port;
}

/* A frame of a protocol, whose last byte is `mark`. */
static void arrive(unsigned int end, int protocol, size_t length, uint8_t mark)
{
    uint8_t frame[ECTWIN_FRAME_MAX] = {
        1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, (uint8_t)(protocol >> 8), (uint8_t)protocol};
    frame[length - 1] = mark;
    deliver(end, frame, length);
}

static ssize_t receive(ect_port_t *port, void *data, size_t size, int flags)
{
    const struct iovec piece = {.iov_base = data, .iov_len = size};
    return ect_port_receive(port, &piece, 1, flags, NULL, NULL, NULL);
}

/* @return the mark of the next frame; -1: none */
static int next_mark(ect_port_t *port)
{
    uint8_t frame[ECTWIN_FRAME_MAX];
    ssize_t length = receive(port, frame, sizeof frame, MSG_DONTWAIT);
    return length > 0 ? frame[length - 1] : -1;
}

static void end_port(int fd)
{
    ect_eventfds_closed((unsigned int)fd, (unsigned int)fd);
    assert_null(ect_port_of(fd));
    forget_calls();
}

/* --- descriptors
 * ------------------------------------------------------------------------------------------------------ */

static void opens(void **state)
{
    static const struct {
        int type, flags;
        bool blocks;
    } rows[] = {{0, EFD_NONBLOCK, true},
                {SOCK_CLOEXEC, EFD_NONBLOCK | EFD_CLOEXEC, true},
                {SOCK_NONBLOCK, EFD_NONBLOCK, false}};
    char want[64];
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        plan("eventfd", 0, 0); /* any number is a descriptor */
        assert_int_equal(ect_port_open(SOCK_RAW | rows[i].type, 9), 0);
        snprintf(want, sizeof want, rows[i].blocks ? "eventfd(%d) fcntl(0,%d) " : "eventfd(%d) ", rows[i].flags,
                 O_RDWR);
        EXPECT_CALLS("open", want);
        errno = 0;
        on_wait = NULL;
        assert_int_equal(receive(ect_port_of(0), sent, sizeof sent, 0), -1);
        assert_int_equal(strstr(fakes.log, "wait") != NULL, rows[i].blocks);
        end_port(0);
    }
    plan("eventfd", DESCRIPTORS - 1, 0);
    assert_int_equal(ect_port_open(SOCK_RAW, 9), DESCRIPTORS - 1);
    assert_non_null(ect_port_of(DESCRIPTORS - 1));
    end_port(DESCRIPTORS - 1);
}

/* Sockets in the memory of closed ones, each of which needs one block, the ring. @return their number */
static int open_all_of_closed_ones(void)
{
    int count = -1;
    int fd;
    do {
        count++;
        blocks = 1;
        plan("eventfd", FD + count, 0);
        fd = ect_port_open(SOCK_RAW, 9);
        forget_calls();
    } while (fd >= 0);
    return count;
}

static void refuses_to_open(void **state)
{
    char want[64];
    (void)state;
    plan("eventfd", DESCRIPTORS, 0);
    assert_int_equal(ect_port_open(SOCK_RAW, 9), -1);
    assert_int_equal(errno, EMFILE);
    snprintf(want, sizeof want, "eventfd(%d) close(%d) ", EFD_NONBLOCK, DESCRIPTORS);
    EXPECT_CALLS("too high", want);
    plan("eventfd", -1, ENFILE);
    assert_int_equal(ect_port_open(SOCK_RAW, 9), -1);
    assert_int_equal(errno, ENFILE);
    snprintf(want, sizeof want, "eventfd(%d) ", EFD_NONBLOCK);
    EXPECT_CALLS("none left", want);
    const int open = open_all_of_closed_ones();
    for (unsigned int left = 0; left < 2; left++) {
        blocks = left;
        errno = 0;
        assert_int_equal(ect_port_open(SOCK_RAW, 9), -1);
        assert_int_equal(errno, ENOMEM);
        EXPECT_CALLS("no memory", "");
    }
    for (int i = 0; i < open; i++)
        end_port(FD + i);
    assert_int_equal(mapped, 0);
    assert_null(ect_port_of(-1));
    assert_null(ect_port_of(DESCRIPTORS));
    ect_eventfds_closed(FD, FD);
    ect_eventfd_copied(FD, FD + 1);
    assert_null(ect_port_of(FD + 1));
}

/* The eventfd exists as long as a descriptor of it is open. */
static void lives_as_long_as_a_copy(void **state)
{
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    ect_eventfd_copied(FD, -1);
    ect_eventfd_copied(FD, DESCRIPTORS);
    ect_eventfd_copied(FD, 0);
    ect_eventfd_copied(0, DESCRIPTORS - 1);
    assert_ptr_equal(ect_port_of(0), port);
    ect_eventfds_closed(DESCRIPTORS - 1, DESCRIPTORS - 1);
    EXPECT_CALLS("a copy", "");
    arrive(0, ECAT, 60, 7);
    ect_ports_show();
    EXPECT_CALLS("the first", "show(20,1) ");
    ect_eventfds_closed(FD, FD);
    assert_null(ect_port_of(FD));
    arrive(0, ECAT, 60, 8);
    ect_ports_show();
    EXPECT_CALLS("the copy", "show(0,1) ");
    assert_int_equal(next_mark(port), 7);
    ect_eventfd_copied(0, DESCRIPTORS - 1);
    ect_eventfds_closed(0, 0);
    arrive(0, ECAT, 60, 9);
    forget_calls();
    ect_ports_show();
    EXPECT_CALLS("the last", "show(65535,1) ");
    end_port(DESCRIPTORS - 1);
    ect_ports_show();
    EXPECT_CALLS("none", "");
}

static void closes_one_of_several(void **state)
{
    (void)state;
    ect_port_t *ports[3];
    for (int i = 0; i < 3; i++)
        ports[i] = bound_port(FD + i, ECAT, 0);
    end_port(FD + 1);
    arrive(0, ECAT, 60, 7);
    assert_int_equal(next_mark(ports[0]), 7);
    assert_int_equal(next_mark(ports[2]), 7);
    end_port(FD + 2);
    arrive(0, ECAT, 60, 8);
    assert_int_equal(next_mark(ports[0]), 8);
    end_port(FD);
    arrive(0, ECAT, 60, 9);
}

static void close_meanwhile(void)
{
    plan("copy", 34, 0);
    ect_eventfds_closed(FD, FD);
    assert_null(ect_port_of(FD));
    arrive(0, ECAT, 60, 9);
    assert_int_equal(mapped, 1);
}

static void close_without_descriptors_meanwhile(void)
{
    plan("copy", -1, EMFILE);
    ect_eventfds_closed(FD, FD);
}

/* The eventfd of a receiver remains open, and shows frames. */
static void is_closed_while_it_receives(void **state)
{
    (void)state;
    ect_time_is_virtual = false;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    on_wait = close_meanwhile;
    plan("copy", 33, 0);
    assert_int_equal(receive(port, sent, sizeof sent, 0), 60);
    assert_int_equal(sent[59], 9);
    EXPECT_CALLS("a frame",
                 "charge(1000) copy(20,20) wait(33,-1) copy(20,20) show(34,1) close(33) read(34,8) close(34) ");
    assert_int_equal(mapped, 0);
    port = bound_port(FD, ECAT, 0);
    on_wait = close_without_descriptors_meanwhile;
    plan("copy", -1, EMFILE);
    assert_int_equal(receive(port, sent, sizeof sent, 0), -1);
    EXPECT_CALLS("no descriptor", "charge(1000) copy(20,20) wait(20,-1) copy(20,20) ");
    assert_int_equal(mapped, 0);
    arrive(0, ECAT, 60, 9);
}

/* Another thread closes a socket after a call has found it, and before the call has the lock. */
static void is_closed_before_a_call(void **state)
{
    uint8_t frame[60] = {0};
    const struct iovec piece = {.iov_base = frame, .iov_len = sizeof frame};
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    end_port(FD);
    errno = 0;
    assert_int_equal(bind_to(port, ECT_BUS_INDEX, 0), -1);
    assert_int_equal(errno, EBADF);
    errno = 0;
    assert_int_equal(ect_port_send(port, &piece, 1,
                                   (const struct sockaddr *)(const void *)&(struct sockaddr_ll){
                                       .sll_family = AF_PACKET, .sll_ifindex = ECT_BUS_INDEX},
                                   sizeof(struct sockaddr_ll)),
                     -1);
    assert_int_equal(errno, EBADF);
    errno = 0;
    assert_int_equal(receive(port, frame, sizeof frame, 0), -1);
    assert_int_equal(errno, EBADF);
    EXPECT_CALLS("no frame, no wait", "charge(1000) charge(1000) ");
    assert_int_equal(mapped, 0);
    assert_ptr_equal(bound_port(FD, ECAT, 1), port);
    arrive(0, ECAT, 60, 7);
    assert_int_equal(next_mark(port), -1);
    arrive(1, ECAT, 60, 8);
    assert_int_equal(next_mark(port), 8);
    end_port(FD);
}

static void closes_a_range(void **state)
{
    static const struct {
        unsigned int from, to;
        const char *open; /* of FD, FD + 1, FD + 2 */
    } rows[] = {
        {FD + 1, FD + 1, "101"},   {FD, FD + 1, "001"},       {FD + 1, FD + 2, "100"}, {0, FD - 1, "111"},
        {FD + 3, UINT_MAX, "111"}, {FD + 1, UINT_MAX, "100"}, {0, UINT_MAX, "000"},    {0x80000000u, UINT_MAX, "111"},
        {FD + 2, FD, "111"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char open[4] = "";
        for (int n = 0; n < 3; n++)
            (void)bound_port(FD + n, ECAT, 0);
        ect_eventfds_closed(rows[i].from, rows[i].to);
        for (int n = 0; n < 3; n++)
            open[n] = ect_port_of(FD + n) ? '1' : '0';
        if (strcmp(open, rows[i].open) != 0)
            fail_msg("%u to %u: open are %s, expected %s", rows[i].from, rows[i].to, open, rows[i].open);
        ect_eventfds_closed(0, UINT_MAX);
        assert_int_equal(mapped, 0);
    }
}

/* Its memory is that of the program. */
static void ignores_a_child_of_vfork(void **state)
{
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    process++;
    ect_eventfds_closed(FD, FD);
    ect_eventfd_copied(FD, FD + 1);
    ect_eventfds_closed(0, UINT_MAX);
    process--;
    assert_ptr_equal(ect_port_of(FD), port);
    assert_null(ect_port_of(FD + 1));
    end_port(FD);
}

static void gets_eventfds_in_a_child(void **state)
{
    char want[256];
    (void)state;
    ect_port_t *first = bound_port(FD, ECAT, 0);
    (void)bound_port(FD + 3, ECAT, 0);
    ect_eventfd_copied(FD + 3, FD + 1);
    arrive(0, ECAT, 60, 7);
    ect_ports_show();
    (void)next_mark(first);
    ect_ports_show();
    forget_calls();
    assert_non_null(in_child);
    plan("eventfd", 40, 0);
    plan("eventfd_with_1", 41, 0);
    plan("get_fl", O_RDWR | O_NONBLOCK, 0);
    plan("get_fl", O_RDWR, 0);
    plan("get_fd", FD_CLOEXEC, 0);
    in_child();
    snprintf(want, sizeof want,
             "eventfd(%d) get_fl(20) fcntl(40,%d) get_fd(20) dup3(40,20,%d) close(40) "
             "eventfd_with_1(%d) get_fl(23) fcntl(41,%d) get_fd(23) dup3(41,23,0) close(41) get_fd(21) dup3(23,21,0) ",
             EFD_NONBLOCK, O_RDWR | O_NONBLOCK, O_CLOEXEC, EFD_NONBLOCK, O_RDWR);
    EXPECT_CALLS("two sockets", want);
    process++;
    ect_eventfds_closed(FD + 3, FD + 3);
    plan("eventfd", -1, EMFILE);
    plan("eventfd_with_1", 41, 0);
    in_child();
    snprintf(want, sizeof want,
             "eventfd(%d) eventfd_with_1(%d) get_fl(23) fcntl(41,0) get_fd(23) dup3(41,23,0) close(41) get_fd(21) "
             "dup3(23,21,0) ",
             EFD_NONBLOCK, EFD_NONBLOCK);
    EXPECT_CALLS("without a further descriptor a socket keeps its own", want);
    ect_eventfds_closed(0, UINT_MAX); /* the descriptors of the new process */
    assert_int_equal(mapped, 0);
}

/* --- the interface
 * ---------------------------------------------------------------------------------------------------- */

static void binds(void **state)
{
    struct sockaddr_ll its;
    socklen_t length = sizeof its;
    (void)state;
    ect_port_t *port = open_port(FD, ECAT);
    plan("start", 1, 0);
    down[1] = true;
    assert_int_equal(bind_to(port, ECT_BUS_INDEX + 1, 0), 0);
    EXPECT_CALLS("the first", "start() bus_started() plug(1,0,5000) next(5000) ");
    assert_int_equal(ect_port_name(port, (struct sockaddr *)(void *)&its, &length), 0);
    assert_int_equal(its.sll_ifindex, ECT_BUS_INDEX + 1);
    assert_int_equal(its.sll_protocol, htons(ECAT));
    assert_int_equal(bind_to(port, ECT_BUS_INDEX, 0x1234), 0);
    EXPECT_CALLS("again", "start() plug(0,1,5000) next(5000) ");
    assert_int_equal(ect_port_name(port, (struct sockaddr *)(void *)&its, &length), 0);
    assert_int_equal(its.sll_ifindex, ECT_BUS_INDEX);
    assert_int_equal(its.sll_protocol, htons(0x1234));
    arrive(0, 0x1234, 60, 7);
    assert_int_equal(next_mark(port), 7);
    assert_int_equal(next_mark(port), -1);
    end_port(FD);
}

static void refuses_to_bind(void **state)
{
    enum { SHORTEST = offsetof(struct sockaddr_ll, sll_addr) };
    struct sockaddr_ll to = address_of(ECT_BUS_INDEX, ECAT);
    const struct sockaddr *address = (const struct sockaddr *)(const void *)&to;
    (void)state;
    ect_port_t *port = open_port(FD, ECAT);
    assert_int_equal(ect_port_bind(port, NULL, sizeof to), -1);
    assert_int_equal(errno, EFAULT);
    assert_int_equal(ect_port_bind(port, address, SHORTEST - 1), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(ect_port_bind(port, NULL, 0), -1);
    assert_int_equal(errno, EINVAL);
    to.sll_family = AF_INET;
    assert_int_equal(ect_port_bind(port, address, sizeof to), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(bind_to(port, ECT_BUS_INDEX + 2, 0), -1);
    assert_int_equal(errno, ENODEV);
    EXPECT_CALLS("refused", "");
    plan("start", -1, 0);
    assert_int_equal(bind_to(port, ECT_BUS_INDEX, 0), -1);
    assert_int_equal(errno, ENETDOWN);
    EXPECT_CALLS("no bus", "start() ");
    to.sll_family = AF_PACKET;
    assert_int_equal(ect_port_bind(port, address, SHORTEST), 0);
    forget_calls();
    end_port(FD);
}

static void takes_up_and_down(void **state)
{
    (void)state;
    assert_true(ect_port_is_up(0));
    down[1] = true;
    assert_false(ect_port_is_up(1));
    ect_port_take(1, true);
    EXPECT_CALLS("up", "plug(1,1,5000) next(5000) ");
    ect_port_take(0, false);
    EXPECT_CALLS("down", "plug(0,0,5000) next(5000) ");
}

/* --- frames of the bus
 * ------------------------------------------------------------------------------------------------ */

static void gets_frames_of_its_protocol(void **state)
{
    (void)state;
    ect_port_t *ecat = bound_port(FD, ECAT, 0);
    ect_port_t *all = bound_port(FD + 1, ETH_P_ALL, 0);
    ect_port_t *other = bound_port(FD + 2, ECAT, 1);
    arrive(0, ECAT, 60, 1);
    arrive(0, 0x0800, 60, 2);
    arrive(1, ECAT, 60, 3);
    assert_int_equal(next_mark(ecat), 1);
    assert_int_equal(next_mark(ecat), -1);
    assert_int_equal(next_mark(all), 1);
    assert_int_equal(next_mark(all), 2);
    assert_int_equal(next_mark(all), -1);
    assert_true(ect_port_has_frame(other));
    assert_int_equal(next_mark(other), 3);
    assert_false(ect_port_has_frame(other));
    for (int i = 0; i < 3; i++)
        end_port(FD + i);
}

/* A tag needs room for the protocol behind it. */
static void removes_a_tag(void **state)
{
    static const struct {
        uint8_t tpid[2];
        size_t length;
        bool removed;
    } rows[] = {{{0x81, 0x00}, 60, true},  {{0x81, 0x00}, 18, true},  {{0x81, 0x01}, 60, false},
                {{0x82, 0x00}, 60, false}, {{0x81, 0x00}, 17, false}, {{0x81, 0x00}, ECTWIN_FRAME_MAX, true}};
    uint8_t got[ECTWIN_FRAME_MAX];
    (void)state;
    ect_port_t *port = bound_port(FD, ETH_P_ALL, 0);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        uint8_t frame[ECTWIN_FRAME_MAX], want[ECTWIN_FRAME_MAX];
        for (size_t at = 0; at < sizeof frame; at++)
            frame[at] = (uint8_t)(at * 7 + 1);
        memcpy(frame + 12, rows[i].tpid, 2);
        size_t tag = rows[i].removed ? 4 : 0;
        memcpy(want, frame, 12);
        memcpy(want + 12, frame + 12 + tag, rows[i].length - 12 - tag);
        deliver(0, frame, rows[i].length);
        assert_int_equal(receive(port, got, sizeof got, MSG_DONTWAIT), rows[i].length - tag);
        assert_memory_equal(got, want, rows[i].length - tag);
    }
    ect_port_t *tagged = bound_port(FD + 1, ECAT, 0);
    const uint8_t ecat[60] = {[12] = 0x81, [16] = 0x88, 0xA4, [59] = 5};
    deliver(0, ecat, sizeof ecat);
    assert_int_equal(next_mark(tagged), 5);
    end_port(FD);
    end_port(FD + 1);
}

static void drops_frames_when_full(void **state)
{
    enum { MOST = 256, ROUNDS = 3 };
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    blocks = 0; /* frames need no further memory */
    for (unsigned int round = 0; round < ROUNDS; round++) {
        for (unsigned int i = 0; i < MOST + 1; i++)
            arrive(0, ECAT, 60, (uint8_t)(i % 251));
        assert_int_equal(next_mark(port), 0);
        arrive(0, ECAT, 60, 252); /* behind the last place of the ring */
        arrive(0, ECAT, 60, 253);
        for (unsigned int i = 1; i < MOST; i++)
            assert_int_equal(next_mark(port), i % 251);
        assert_int_equal(next_mark(port), 252);
        assert_int_equal(next_mark(port), -1);
        forget_calls();
    }
    end_port(FD);
    assert_int_equal(mapped, 0);
}

static void shows_frames_on_the_virtual_clock(void **state)
{
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    ect_ports_show();
    arrive(0, ECAT, 60, 1);
    EXPECT_CALLS("not yet", "");
    ect_ports_show();
    EXPECT_CALLS("a frame", "show(20,1) ");
    ect_ports_show();
    EXPECT_CALLS("no other", "");
    arrive(0, ECAT, 60, 2);
    ect_ports_show();
    EXPECT_CALLS("each frame is an event", "show(20,1) ");
    assert_int_equal(next_mark(port), 1);
    forget_calls();
    ect_ports_show();
    EXPECT_CALLS("one is left", "");
    assert_int_equal(next_mark(port), 2);
    forget_calls();
    ect_ports_show();
    EXPECT_CALLS("none is left", "read(20,8) ");
    ect_ports_show();
    EXPECT_CALLS("still none", "");
    arrive(0, ECAT, 60, 3);
    assert_int_equal(next_mark(port), 3);
    forget_calls();
    ect_ports_show();
    EXPECT_CALLS("a frame that is received before", "");
    end_port(FD);
}

static void shows_frames_at_once_on_the_real_clock(void **state)
{
    (void)state;
    ect_time_is_virtual = false;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    arrive(0, ECAT, 60, 1);
    arrive(0, ECAT, 60, 2);
    EXPECT_CALLS("two frames", "show(20,1) show(20,1) ");
    assert_int_equal(next_mark(port), 1);
    EXPECT_CALLS("the first", "charge(1000) ");
    assert_int_equal(next_mark(port), 2);
    EXPECT_CALLS("the second", "charge(1000) read(20,8) ");
    end_port(FD);
}

/* --- options
 * ---------------------------------------------------------------------------------------------------------- */

static void has_options(void **state)
{
    static const struct {
        int name, value;
    } rows[] = {{SO_TYPE, SOCK_RAW}, {SO_DOMAIN, AF_PACKET}, {SO_RCVBUF, 212992}, {SO_SNDBUF, 212992}, {SO_ERROR, 0}};
    (void)state;
    ect_port_t *port = open_port(FD, ECAT);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        int value[2] = {-1, -1};
        socklen_t length = sizeof value;
        assert_int_equal(ect_port_get(port, SOL_SOCKET, rows[i].name, value, &length), 0);
        assert_int_equal(value[0], rows[i].value);
        assert_int_equal(value[1], -1);
        assert_int_equal(length, sizeof(int));
        value[0] = -1;
        length = sizeof value;
        assert_int_equal(ect_port_get(port, SOL_PACKET, rows[i].name, value, &length), 0);
        assert_int_equal(value[0], 0);
        length = 2;
        assert_int_equal(ect_port_get(port, SOL_SOCKET, rows[i].name, value, &length), 0);
        assert_int_equal(length, 2);
    }
    socklen_t length = 4;
    assert_int_equal(ect_port_get(port, SOL_SOCKET, SO_TYPE, NULL, &length), -1);
    assert_int_equal(errno, EFAULT);
    errno = 0;
    assert_int_equal(ect_port_get(port, SOL_SOCKET, SO_TYPE, sent, NULL), -1);
    assert_int_equal(errno, EFAULT);
    bad_memory.unwritable = &length;
    errno = 0;
    assert_int_equal(ect_port_get(port, SOL_SOCKET, SO_TYPE, sent, &length), -1);
    assert_int_equal(errno, EFAULT);
    errno = 0;
    assert_int_equal(ect_port_set(port, SOL_SOCKET, SO_SNDBUF, NULL, 4), -1);
    assert_int_equal(errno, EFAULT);
    assert_int_equal(ect_port_set(port, SOL_SOCKET, SO_SNDBUF, NULL, 0), 0);
    static const int rings[] = {PACKET_RX_RING, PACKET_TX_RING, PACKET_FANOUT};
    for (size_t i = 0; i < 3; i++) {
        errno = 0;
        assert_int_equal(ect_port_set(port, SOL_PACKET, rings[i], sent, 4), -1);
        assert_int_equal(errno, ENOPROTOOPT);
        assert_int_equal(ect_port_set(port, SOL_SOCKET, rings[i], sent, 4), 0);
    }
    assert_int_equal(ect_port_set(port, SOL_PACKET, PACKET_STATISTICS, sent, 4), 0);
    end_port(FD);
}

static void has_a_timeout(void **state)
{
    const struct timeval limit = {.tv_sec = 3, .tv_usec = 4};
    struct timeval got = {0};
    socklen_t length = sizeof got;
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    plan("wait", 1, EAGAIN);
    assert_int_equal(receive(port, sent, sizeof sent, 0), -1);
    EXPECT_CALLS("none", "charge(1000) wait(20,-1) ");
    assert_int_equal(ect_port_set(port, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit), 0);
    assert_int_equal(ect_port_get(port, SOL_SOCKET, SO_RCVTIMEO, &got, &length), 0);
    assert_int_equal(got.tv_sec, 3);
    assert_int_equal(got.tv_usec, 4);
    assert_int_equal(length, sizeof got);
    plan("wait", 1, EAGAIN);
    assert_int_equal(receive(port, sent, sizeof sent, 0), -1);
    assert_int_equal(errno, EAGAIN);
    EXPECT_CALLS("3 s", "charge(1000) wait(20,3000009000) ");
    assert_int_equal(ect_port_set(port, SOL_SOCKET, SO_RCVTIMEO, NULL, sizeof limit), -1);
    assert_int_equal(errno, EFAULT);
    assert_int_equal(ect_port_set(port, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit - 1), 0);
    const struct timeval none = {0};
    assert_int_equal(ect_port_set(port, SOL_PACKET, SO_RCVTIMEO, &none, sizeof none), 0);
    assert_int_equal(ect_port_get(port, SOL_SOCKET, SO_RCVTIMEO, &got, &length), 0);
    assert_int_equal(got.tv_sec, 3);
    end_port(FD);
}

/* As the kernel reads them. */
static void has_timeouts_at_their_limits(void **state)
{
    enum { LONGEST_S = 9223372036 };
    static const struct {
        struct timeval limit;
        int error;
        const char *wait; /* of a receive */
    } rows[] = {{{0, -1}, EDOM, "wait(20,-1) "},
                {{0, 1000000}, EDOM, "wait(20,-1) "},
                {{0, 999999}, 0, "wait(20,1000004000) "},
                {{-1, 0}, 0, "wait(20,5001) "},
                {{LONGEST_S - 1, 0}, 0, "wait(20,9223372035000005000) "},
                {{LONGEST_S, 0}, 0, "wait(20,-1) "},
                {{INT64_MAX, 999999}, 0, "wait(20,-1) "}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ect_port_t *port = bound_port(FD, ECAT, 0);
        errno = 0;
        int result = ect_port_set(port, SOL_SOCKET, SO_RCVTIMEO, &rows[i].limit, sizeof rows[i].limit);
        if (result != (rows[i].error == 0 ? 0 : -1) || errno != rows[i].error)
            fail_msg("row %zu: %d, errno %d", i, result, errno);
        plan("wait", 1, EAGAIN);
        assert_int_equal(receive(port, sent, sizeof sent, 0), -1);
        if (!strstr(fakes.log, rows[i].wait))
            fail_msg("row %zu: expected %s, got %s", i, rows[i].wait, fakes.log);
        end_port(FD);
    }
}

static void has_a_name(void **state)
{
    static const uint8_t address[8] = {2, 0, 0, 0, 0, 1};
    struct sockaddr_ll its;
    socklen_t length = 4;
    (void)state;
    ect_port_t *port = open_port(FD, ECAT);
    memset(&its, 0x55, sizeof its);
    assert_int_equal(ect_port_name(port, (struct sockaddr *)(void *)&its, &length), 0);
    assert_int_equal(length, sizeof its);
    assert_int_equal(its.sll_protocol, htons(ECAT));
    assert_int_equal(its.sll_ifindex, 0x55555555); /* beyond the room */
    length = sizeof its;
    assert_int_equal(ect_port_name(port, (struct sockaddr *)(void *)&its, &length), 0);
    assert_int_equal(its.sll_family, AF_PACKET);
    assert_int_equal(its.sll_ifindex, 0);
    assert_int_equal(its.sll_hatype, 1);
    assert_int_equal(its.sll_pkttype, PACKET_HOST);
    assert_int_equal(its.sll_halen, 6);
    assert_memory_equal(its.sll_addr, address, sizeof address);
    assert_int_equal(ect_port_name(port, NULL, &length), -1);
    assert_int_equal(errno, EFAULT);
    errno = 0;
    assert_int_equal(ect_port_name(port, (struct sockaddr *)(void *)&its, NULL), -1);
    assert_int_equal(errno, EFAULT);
    end_port(FD);
}

/* --- sending
 * ---------------------------------------------------------------------------------------------------------- */

enum { LONGEST = 1518 };

static void sends(void **state)
{
    uint8_t frame[LONGEST + 2];
    const struct iovec pieces[] = {{frame, 10}, {frame + 10, 0}, {frame + 10, 50}};
    const struct sockaddr_ll to = address_of(ECT_BUS_INDEX + 1, ECAT);
    (void)state;
    for (size_t i = 0; i < sizeof frame; i++)
        frame[i] = (uint8_t)(i * 3 + 1);
    ect_port_t *port = bound_port(FD, ECAT, 0);
    plan("frame", 77, 0);
    assert_int_equal(ect_port_send(port, pieces, 3, NULL, 0), 60);
    assert_memory_equal(sent, frame, 60);
    EXPECT_CALLS("pieces", "charge(1000) start() frame(0,60) next(77) ");
    assert_int_equal(ect_port_send(port, pieces, 3, (const struct sockaddr *)(const void *)&to, sizeof to), 60);
    EXPECT_CALLS("to the other end", "charge(1000) start() frame(1,60) next(0) ");
    static const struct {
        size_t length;
        int error;
    } rows[] = {{HEADER - 1, EINVAL}, {HEADER, 0}, {LONGEST, 0}, {LONGEST + 1, EMSGSIZE}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct iovec one = {frame, rows[i].length};
        errno = 0;
        assert_int_equal(ect_port_send(port, &one, 1, NULL, 0), rows[i].error == 0 ? (long)rows[i].length : -1);
        assert_int_equal(errno, rows[i].error);
        if (rows[i].error == 0)
            assert_memory_equal(sent, frame, rows[i].length);
    }
    for (size_t more = 1; more <= LONGEST; more += LONGEST - 1) {
        const struct iovec two[] = {{frame, LONGEST}, {frame, more}};
        errno = 0;
        assert_int_equal(ect_port_send(port, two, 2, NULL, 0), -1);
        assert_int_equal(errno, EMSGSIZE);
    }
    end_port(FD);
}

static void refuses_to_send(void **state)
{
    uint8_t frame[60] = {0};
    const struct iovec one = {frame, sizeof frame};
    const struct iovec bad[] = {{frame, sizeof frame}, {NULL, 1}};
    struct sockaddr_ll to = address_of(ECT_BUS_INDEX + 2, ECAT);
    (void)state;
    ect_port_t *port = open_port(FD, ECAT);
    assert_int_equal(ect_port_send(port, &one, 1, NULL, 0), -1);
    assert_int_equal(errno, ENXIO);
    EXPECT_CALLS("not bound", "");
    assert_int_equal(bind_to(port, ECT_BUS_INDEX, 0), 0);
    forget_calls();
    assert_int_equal(ect_port_send(port, &one, 1, (const struct sockaddr *)(const void *)&to, sizeof to), -1);
    assert_int_equal(errno, ENXIO);
    assert_int_equal(ect_port_send(port, bad, 2, NULL, 0), -1);
    assert_int_equal(errno, EFAULT);
    errno = 0;
    assert_int_equal(ect_port_send(port, NULL, 1, NULL, 0), -1);
    assert_int_equal(errno, EFAULT);
    errno = 0;
    assert_int_equal(ect_port_send(port, &one, 1, AT(5), sizeof to), -1);
    assert_int_equal(errno, EFAULT);
    EXPECT_CALLS("bad addresses", "");
    assert_int_equal(ect_port_send(port, &one, 1, AT(5), 0), 60); /* an address without bytes */
    forget_calls();
    to.sll_family = AF_INET; /* no address of a packet socket */
    assert_int_equal(ect_port_send(port, &one, 1, (const struct sockaddr *)(const void *)&to, sizeof to), 60);
    forget_calls();
    down[0] = true;
    assert_int_equal(ect_port_send(port, &one, 1, NULL, 0), -1);
    assert_int_equal(errno, ENETDOWN);
    EXPECT_CALLS("down", "charge(1000) ");
    down[0] = false;
    plan("start", -1, 0);
    errno = 0;
    assert_int_equal(ect_port_send(port, &one, 1, NULL, 0), -1);
    assert_int_equal(errno, ENETDOWN);
    EXPECT_CALLS("no bus", "charge(1000) start() ");
    end_port(FD);
}

/* --- receiving
 * -------------------------------------------------------------------------------------------------------- */

static void arrive_later(void)
{
    arrive(0, ECAT, 60, 9);
}

static void waits_for_a_frame(void **state)
{
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    on_wait = arrive_later;
    assert_int_equal(receive(port, sent, sizeof sent, 0), 60);
    assert_int_equal(sent[59], 9);
    EXPECT_CALLS("wait", "charge(1000) wait(20,-1) ");
    on_wait = NULL;
    plan("wait", 1, EINTR);
    assert_int_equal(receive(port, sent, sizeof sent, 0), -1);
    assert_int_equal(errno, EINTR);
    forget_calls();
    assert_int_equal(receive(port, sent, sizeof sent, MSG_DONTWAIT), -1);
    assert_int_equal(errno, EAGAIN);
    ect_port_set_nonblocking(port, true);
    errno = 0;
    assert_int_equal(receive(port, sent, sizeof sent, 0), -1);
    assert_int_equal(errno, EAGAIN);
    EXPECT_CALLS("at once", "charge(1000) charge(1000) ");
    ect_port_set_nonblocking(port, false);
    arrive(0, ECAT, 60, 8);
    assert_int_equal(receive(port, sent, sizeof sent, 0), 60);
    EXPECT_CALLS("a frame is there", "charge(1000) ");
    end_port(FD);
}

static void receives_in_pieces(void **state)
{
    uint8_t got[3][40];
    const struct iovec pieces[] = {{got[0], 10}, {got[1], 40}, {got[2], 40}};
    struct sockaddr_ll from;
    socklen_t length = sizeof from;
    int flags = -1;
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 1);
    memset(got, 0x55, sizeof got);
    arrive(1, ECAT, 60, 7);
    assert_int_equal(ect_port_receive(port, pieces, 3, MSG_PEEK, &flags, (struct sockaddr *)(void *)&from, &length),
                     60);
    assert_int_equal(flags, 0);
    assert_int_equal(got[0][9], 10);
    assert_int_equal(got[0][10], 0x55);
    assert_int_equal(got[1][0], 11);
    assert_int_equal(got[2][9], 7);
    assert_int_equal(got[2][10], 0x55);
    assert_int_equal(from.sll_ifindex, ECT_BUS_INDEX + 1);
    assert_int_equal(from.sll_protocol, htons(ECAT));
    assert_int_equal(length, sizeof from);
    assert_int_equal(ect_port_receive(port, pieces, 2, 0, &flags, NULL, &length), 50);
    assert_int_equal(flags, MSG_TRUNC);
    assert_false(ect_port_has_frame(port));
    arrive(1, ECAT, 60, 7);
    assert_int_equal(ect_port_receive(port, pieces, 2, MSG_TRUNC, &flags, NULL, NULL), 60);
    assert_int_equal(flags, MSG_TRUNC);
    end_port(FD);
}

/* The kernel reads the list of pieces before the frame, and writes into them after it. */
static void loses_a_frame_to_a_bad_address(void **state)
{
    uint8_t got[60];
    const struct iovec good = {got, 60}, nowhere = {AT(5), 60};
    struct sockaddr_ll its;
    socklen_t room = sizeof its;
    struct sockaddr *from = (struct sockaddr *)(void *)&its;
    const struct {
        const char *title;
        const struct iovec *pieces;
        int flags;
        struct sockaddr *from;
        socklen_t *room;
        bool kept;
    } rows[] = {
        {"a list", AT(5), 0, NULL, NULL, true},        {"no list", NULL, 0, NULL, NULL, true},
        {"a piece", &nowhere, 0, NULL, NULL, false},   {"a piece, peeked", &nowhere, MSG_PEEK, NULL, NULL, true},
        {"an address", &good, 0, AT(5), &room, false}, {"an address, peeked", &good, MSG_PEEK, AT(5), &room, true},
        {"its length", &good, 0, from, AT(5), false},  {"no length", &good, 0, from, NULL, false}};
    (void)state;
    ect_port_t *port = bound_port(FD, ECAT, 0);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        int flags = -1;
        arrive(0, ECAT, 60, 7);
        arrive(0, ECAT, 60, 8);
        errno = 0;
        if (ect_port_receive(port, rows[i].pieces, 1, rows[i].flags, &flags, rows[i].from, rows[i].room) != -1 ||
            errno != EFAULT || flags != -1)
            fail_msg("%s: errno %d, flags %d", rows[i].title, errno, flags);
        if (rows[i].kept)
            assert_int_equal(next_mark(port), 7);
        assert_int_equal(next_mark(port), 8);
        assert_int_equal(next_mark(port), -1);
    }
    bad_memory.unwritable = &room; /* it can be read */
    arrive(0, ECAT, 60, 7);
    assert_int_equal(ect_port_receive(port, &good, 1, 0, NULL, from, &room), -1);
    assert_int_equal(errno, EFAULT);
    assert_int_equal(next_mark(port), -1);
    end_port(FD);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A socket is an eventfd with the flags of its type", opens, begin, NULL, NULL},
        {"A socket needs a descriptor below 65536 and memory", refuses_to_open, begin, NULL, NULL},
        {"A socket exists as long as a copy of its descriptor is open", lives_as_long_as_a_copy, begin, NULL, NULL},
        {"The others of several sockets remain when one is closed", closes_one_of_several, begin, NULL, NULL},
        {"A call on a socket that another thread closes first is refused with EBADF", is_closed_before_a_call, begin,
         NULL, NULL},
        {"A socket that is closed while it receives still gets a frame", is_closed_while_it_receives, begin, NULL,
         NULL},
        {"A range of descriptors has both ends", closes_a_range, begin, NULL, NULL},
        {"A child of vfork() changes no descriptor of the program", ignores_a_child_of_vfork, begin, NULL, NULL},
        {"A child of fork() gets eventfds of its own, with the same flags", gets_eventfds_in_a_child, begin, NULL,
         NULL},
        {"bind() starts the bus and plugs the cable in", binds, begin, NULL, NULL},
        {"bind() refuses other addresses", refuses_to_bind, begin, NULL, NULL},
        {"An interface that is taken up or down has its cable plugged in or pulled", takes_up_and_down, begin, NULL,
         NULL},
        {"A socket gets the frames of its protocol and its end", gets_frames_of_its_protocol, begin, NULL, NULL},
        {"A VLAN tag is removed", removes_a_tag, begin, NULL, NULL},
        {"A socket with 256 frames drops further ones", drops_frames_when_full, begin, NULL, NULL},
        {"Frames make the descriptor readable before a poll on the virtual clock", shows_frames_on_the_virtual_clock,
         begin, NULL, NULL},
        {"Frames make the descriptor readable at once on the real clock", shows_frames_at_once_on_the_real_clock, begin,
         NULL, NULL},
        {"Options have values, rings are refused", has_options, begin, NULL, NULL},
        {"SO_RCVTIMEO limits a wait", has_a_timeout, begin, NULL, NULL},
        {"SO_RCVTIMEO: a negative time ends a wait, the longest is no limit, an invalid fraction is refused",
         has_timeouts_at_their_limits, begin, NULL, NULL},
        {"A socket has a name, cut to its room", has_a_name, begin, NULL, NULL},
        {"A frame has 14 to 1518 bytes in pieces", sends, begin, NULL, NULL},
        {"A frame needs an interface that is up", refuses_to_send, begin, NULL, NULL},
        {"A blocking socket waits for a frame", waits_for_a_frame, begin, NULL, NULL},
        {"A frame is received in pieces, kept by MSG_PEEK, and cut", receives_in_pieces, begin, NULL, NULL},
        {"A frame is lost to a bad piece or address, and not to a bad list", loses_a_frame_to_a_bad_address, begin,
         NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
