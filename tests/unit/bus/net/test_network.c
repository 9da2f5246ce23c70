/* SPDX-License-Identifier: MIT */
/* A private network and its wires (bus/net/netns.h, bus/net/veth.h), and ports on them (bus/net/packet.h). All of it
 * happens in a network namespace of this process; where none can be made, the tests are skipped. */
#define _GNU_SOURCE
#include "bus/net/packet.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/if_ether.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <poll.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus/net/netns.h"
#include "bus/net/rights.h"
#include "bus/net/veth.h"

enum { FRAME = 60, ROOM = 2048 };

static bool inside;
static unsigned int lacks;

/* Whether this machine lets the user have a network, as a process of its own finds out. */
static bool allowed(void)
{
    int status = -1;
    pid_t child = fork();
    if (child == 0) {
        bool has = unshare(CLONE_NEWUSER | CLONE_NEWNET | CLONE_NEWNS) == 0 && socket(AF_PACKET, SOCK_RAW, 0) >= 0;
        _exit(has ? 0 : 1);
    }
    return waitpid(child, &status, 0) == child && status == 0;
}

static int enter(void **state)
{
    static const char *const masters[ECT_NETNS_WIRES] = {"ecat0", "ecat1"};
    char message[ECT_NETNS_MESSAGE];
    (void)state;
    if (!allowed())
        return 0;
    inside = ect_netns_enter(masters, &lacks, message) == 0;
    if (!inside) {
        print_error("%s\n", message);
        return -1;
    }
    (void)prctl(PR_SET_DUMPABLE, 1); /* for the check for leaks at the end */
    return 0;
}

/* --- interfaces ------------------------------------------------------------------------------------------------- */

static short flags_of(const char *name)
{
    struct ifreq request = {0};
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
    if (ioctl(fd, SIOCGIFFLAGS, &request) < 0)
        request.ifr_flags = 0;
    close(fd);
    return request.ifr_flags;
}

static void set_up(const char *name, bool up)
{
    struct ifreq request = {0};
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
    request.ifr_flags = (short)(up ? flags_of(name) | IFF_UP : flags_of(name) & ~IFF_UP);
    assert_int_equal(ioctl(fd, SIOCSIFFLAGS, &request), 0);
    close(fd);
}

static bool is_up(const char *name)
{
    return (flags_of(name) & IFF_UP) != 0;
}

/* '?': this kernel has no IPv6. */
static char ipv6_is_off(const char *name)
{
    char path[96], flag = '?';
    snprintf(path, sizeof path, "/proc/sys/net/ipv6/conf/%s/disable_ipv6", name);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return '?';
    assert_int_equal(read(fd, &flag, 1), 1);
    close(fd);
    return flag;
}

static void names(void **state)
{
    static const struct {
        const char *name, *why; /* NULL: fit */
    } rows[] = {
        {"a", NULL},
        {"ecat0", NULL},
        {"ectwin2", NULL},
        {"...", NULL},
        {"fifteen-letters", NULL},
        {"", "a name has 1 to 15 characters"},
        {"sixteen-letters-", "a name has 1 to 15 characters"},
        {"a/b", "a name has no blank, '/' or ':' in it, and is not '.' or '..'"},
        {"a:b", "a name has no blank, '/' or ':' in it, and is not '.' or '..'"},
        {"a b", "a name has no blank, '/' or ':' in it, and is not '.' or '..'"},
        {".", "a name has no blank, '/' or ':' in it, and is not '.' or '..'"},
        {"..", "a name has no blank, '/' or ':' in it, and is not '.' or '..'"},
        {"lo", "'lo', 'ectwin0' and 'ectwin1' are reserved"},
        {"ectwin0", "'lo', 'ectwin0' and 'ectwin1' are reserved"},
        {"ectwin1", "'lo', 'ectwin0' and 'ectwin1' are reserved"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const char *why = ect_netns_unfit(rows[i].name);
        if ((why == NULL) != (rows[i].why == NULL) || (why && strcmp(why, rows[i].why) != 0))
            fail_msg("'%s': expected '%s', got '%s'", rows[i].name, rows[i].why, why);
    }
}

static void private_network(void **state)
{
    static const char *const want[] = {"lo", "ectwin0", "ecat0", "ectwin1", "ecat1"};
    size_t count = 0;
    (void)state;
    if (!inside)
        skip();
    struct if_nameindex *all = if_nameindex();
    for (; all[count].if_index != 0; count++)
        ;
    if_freenameindex(all);
    assert_int_equal(count, sizeof want / sizeof want[0]);
    for (size_t i = 0; i < count; i++) {
        assert_true(is_up(want[i]));
        assert_true(i == 0 || ipv6_is_off(want[i]) != '0');
    }
    if ((lacks & ECT_NETNS_OWN_SYSFS) == 0)
        assert_int_equal(access("/sys/class/net/ectwin1", F_OK), 0);
    assert_int_equal(geteuid(), 0);
}

/* Another one, from inside and by a user without rights: one wire, files as before. */
static void another_network(void **state)
{
    static const char *const masters[ECT_NETNS_WIRES] = {"wire", NULL};
    (void)state;
    if (!inside)
        skip();
    for (unsigned int user = 0; user < 2; user++) {
        (void)fflush(NULL);
        pid_t child = fork();
        if (child == 0) {
            char message[ECT_NETNS_MESSAGE];
            unsigned int missing = 0;
            if (user == 1 && setresuid(1000, 1000, 1000) < 0)
                _exit(0); /* one id is all that there is here */
            (void)prctl(PR_SET_DUMPABLE, 1);
            if (ect_netns_enter(masters, &missing, message) < 0)
                _exit(strstr(message, "no private network: ") == message ? 0 : 1);
            bool good = is_up("wire") && is_up("ectwin0") && if_nametoindex("ectwin1") == 0 && geteuid() == 0 &&
                        if_nametoindex("ecat0") == 0;
            _exit(good ? 0 : 2);
        }
        int status = -1;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_int_equal(status, 0);
    }
    assert_true(is_up("ecat0"));
}

static void pairs(void **state)
{
    char message[ECT_VETH_MESSAGE];
    (void)state;
    if (!inside)
        skip();
    for (unsigned int by = 0; by < 2; by++) { /* removed by either end */
        assert_int_equal(ect_veth_create("one", "other", message), 0);
        assert_true(is_up("one") && is_up("other"));
        assert_true(ipv6_is_off("one") != '0' && ipv6_is_off("other") != '0');
        assert_int_equal(ect_veth_create("third", "other", message), -1);
        assert_string_equal(message,
                            "'third' or 'other' exists already: choose another name, or 'sudo ip link del third'");
        assert_int_equal(if_nametoindex("third"), 0);
        assert_int_equal(ect_veth_destroy(by == 0 ? "one" : "other"), 0);
        assert_int_equal(if_nametoindex("one"), 0);
        assert_int_equal(if_nametoindex("other"), 0);
    }
    assert_int_equal(ect_veth_destroy("one"), -1);
}

static int wire_end(const char *name)
{
    const struct sockaddr_ll end = {
        .sll_family = AF_PACKET, .sll_protocol = htons(0x88A4), .sll_ifindex = (int)if_nametoindex(name)};
    const struct timeval patience = {.tv_sec = 20};
    int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&end, sizeof end), 0);
    return fd;
}

static void first_frames(void **state)
{
    static const char *const names[] = {"one", "other"};
    static const uint8_t frame[FRAME] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, [12] = 0x88, [13] = 0xA4};
    uint8_t got[ROOM];
    char message[ECT_VETH_MESSAGE];
    (void)state;
    if (!inside)
        skip();
    for (unsigned int n = 0; n < 20; n++) {
        assert_int_equal(ect_veth_create("one", "other", message), 0);
        int ends[2] = {wire_end("one"), wire_end("other")};
        for (unsigned int from = 0; from < 2; from++) {
            assert_int_equal(send(ends[from], frame, sizeof frame, 0), sizeof frame);
            if (recv(ends[1 - from], got, sizeof got, 0) != sizeof frame)
                fail_msg("pair %u: expected the first frame of '%s', got none", n, names[from]);
        }
        close(ends[0]);
        close(ends[1]);
        assert_int_equal(ect_veth_destroy("one"), 0);
    }
}

/* --- ports ------------------------------------------------------------------------------------------------------ */

typedef struct rig {
    ect_packet_t twin, master;
    ect_packet_time_t time;
    uint8_t sent[ROOM], got[ROOM];
} rig_t;

static void must_open(ect_packet_t *port, const char *iface)
{
    char message[ECT_PACKET_MESSAGE];
    if (ect_packet_open(port, iface, message) != 0)
        fail_msg("%s", message);
}

static void open_rig(rig_t *r)
{
    memset(r, 0, sizeof *r);
    must_open(&r->twin, "ectwin0");
    must_open(&r->master, "ecat0");
}

static void close_rig(rig_t *r)
{
    ect_packet_close(&r->twin);
    ect_packet_close(&r->master);
}

static const uint8_t head[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0, 0, 0, 0, 1, 0x88, 0xA4};
static const uint8_t tagged[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0,    0,
                                 0,    0,    1,    0x81, 0x00, 0xA0, 0x07, 0x88, 0xA4};

/* From the master, with bytes that no other frame has. */
static void send_frame(rig_t *r, const uint8_t *begin, size_t size, size_t length, uint8_t seed)
{
    for (size_t i = 0; i < length; i++)
        r->sent[i] = (uint8_t)(seed + 7 * i);
    memcpy(r->sent, begin, size);
    ect_packet_send(&r->master, r->sent, length);
}

static ssize_t receive(rig_t *r, size_t room)
{
    memset(r->got, 0xEE, sizeof r->got);
    return ect_packet_receive(&r->twin, false, r->got, room, &r->time);
}

static void refused(void **state)
{
    static const struct {
        const char *iface, *why;
    } rows[] = {
        {"sixteen-letters-", "'sixteen-letters-' is no interface name: they have at most 15 characters"},
        {"fifteen-letters", "there is no network interface 'fifteen-letters': 'ip -br link' lists all interfaces"},
        {"", "there is no network interface '': 'ip -br link' lists all interfaces"},
        {"lo", "'lo' is no Ethernet interface: name a NIC or one end of a veth pair"},
        {"ecat0", "another program has 'ecat0' open for EtherCAT already, a twin or a master: end that one first"},
    };
    ect_packet_t port;
    rig_t r;
    (void)state;
    if (!inside)
        skip();
    open_rig(&r);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_PACKET_MESSAGE] = "";
        assert_int_equal(ect_packet_open(&port, rows[i].iface, message), -1);
        assert_string_equal(message, rows[i].why);
    }
    close_rig(&r);
    must_open(&port, "ecat0"); /* free again */
    ect_packet_close(&port);
}

/* A master that another program has opened by itself is detected too, on this interface only. */
static void beside_a_foreign_master(void **state)
{
    char message[ECT_PACKET_MESSAGE];
    ect_packet_t port;
    (void)state;
    if (!inside)
        skip();
    int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
    const struct sockaddr_ll {
        uint16_t family, protocol;
        int index;
        uint8_t rest[12];
    } address = {.family = AF_PACKET, .protocol = __builtin_bswap16(0x88A4), .index = (int)if_nametoindex("ecat0")};
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(ect_packet_open(&port, "ecat0", message), -1);
    assert_non_null(strstr(message, "another program has 'ecat0' open"));
    must_open(&port, "ecat1");
    ect_packet_close(&port);
    close(fd);
}

/* In both ways of receiving. */
static void frames(void **state)
{
    static const struct {
        const char *title;
        const uint8_t *begin;
        size_t size, length, room;
        bool comes;
    } rows[] = {
        {"a short frame", head, sizeof head, FRAME, ROOM, true},
        {"the longest frame", head, sizeof head, 1514, ROOM, true},
        {"one that fits exactly", head, sizeof head, 100, 100, true},
        {"one that is cut", head, sizeof head, 1514, 100, true},
        {"one with a tag", tagged, sizeof tagged, FRAME + 4, ROOM, true},
        {"the longest one with a tag", tagged, sizeof tagged, 1518, ROOM, true},
        {"another type", (const uint8_t *)"\xFF\xFF\xFF\xFF\xFF\xFF\x02\0\0\0\0\1\x88\xA5", 14, FRAME, ROOM, false},
        {"an ARP request", (const uint8_t *)"\xFF\xFF\xFF\xFF\xFF\xFF\x02\0\0\0\0\1\x08\x06", 14, FRAME, ROOM, false},
        {"to another station", (const uint8_t *)"\x02\0\0\0\0\x77\x02\0\0\0\0\1\x88\xA4", 14, FRAME, ROOM, true},
    };
    (void)state;
    if (!inside)
        skip();
    for (unsigned int shared = 0; shared < 2; shared++) {
        rig_t r;
        open_rig(&r);
        if (shared == 1 && !ect_packet_share(&r.twin)) {
            close_rig(&r);
            break;
        }
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            uint64_t before_ns = ect_packet_now();
            send_frame(&r, rows[i].begin, rows[i].size, rows[i].length, (uint8_t)i);
            ssize_t got = receive(&r, rows[i].room);
            ssize_t want = rows[i].comes ? (ssize_t)rows[i].length : ECT_PACKET_NONE;
            size_t kept = rows[i].length < rows[i].room ? rows[i].length : rows[i].room;
            if (got != want || (rows[i].comes && memcmp(r.got, r.sent, kept) != 0))
                fail_msg("%s, shared %u: expected %zd, got %zd", rows[i].title, shared, want, got);
            assert_int_equal(r.got[rows[i].comes ? kept : 0], 0xEE);
            assert_int_equal(receive(&r, ROOM), ECT_PACKET_NONE);
            assert_true(!rows[i].comes || (r.time.now_ns >= before_ns && r.time.now_ns <= ect_packet_now()));
        }
        for (uint8_t n = 0; n < 200; n++) { /* more than there are slots */
            send_frame(&r, head, sizeof head, FRAME + n, n);
            assert_int_equal(receive(&r, ROOM), FRAME + n);
            assert_memory_equal(r.got, r.sent, FRAME + n);
        }
        ect_packet_send(&r.twin, r.sent, FRAME); /* its own frames do not return */
        assert_int_equal(receive(&r, ROOM), ECT_PACKET_NONE);
        assert_int_equal(ect_packet_receive(&r.master, false, r.got, ROOM, &r.time), FRAME);
        close_rig(&r);
    }
}

/* A wait for a frame that is already queued returns it; one for none ends by itself. */
static void waits(void **state)
{
    rig_t r;
    (void)state;
    if (!inside)
        skip();
    open_rig(&r);
    assert_true(r.twin.wait_ns > 0 && r.twin.wait_ns <= 100000000u);
    uint64_t before_ns = ect_packet_now();
    assert_int_equal(ect_packet_receive(&r.twin, true, r.got, ROOM, &r.time), ECT_PACKET_NONE);
    assert_true(ect_packet_now() > before_ns);
    send_frame(&r, head, sizeof head, FRAME, 1);
    assert_int_equal(ect_packet_receive(&r.twin, true, r.got, ROOM, &r.time), FRAME);
    send_frame(&r, tagged, sizeof tagged, FRAME, 1);
    assert_int_equal(ect_packet_receive(&r.twin, true, r.got, ROOM, &r.time), ECT_PACKET_NONE);
    assert_int_equal(ect_packet_receive(&r.twin, false, r.got, ROOM, &r.time), FRAME);
    assert_int_equal(r.twin.wait_ns, 0); /* from now on it must read both */
    close_rig(&r);
}

/* The kernel begins to note times of arrival some time after the first port asked for one. */
static void wait_for_times(rig_t *r)
{
    const struct timespec pause = {.tv_nsec = 10000000};
    for (unsigned int n = 0; n < 1000; n++) {
        send_frame(r, head, sizeof head, FRAME, 0);
        nanosleep(&pause, NULL);
        assert_int_equal(receive(r, ROOM), FRAME);
        if (r->time.waited_ns >= 10000000u)
            return;
    }
    fail_msg("the kernel notes no times of arrival");
}

/* At least so long: the frames before are older than a master waits. */
static void stale(void **state)
{
    const struct timespec pause = {.tv_nsec = 20000000};
    (void)state;
    if (!inside)
        skip();
    for (unsigned int shared = 0; shared < 2; shared++) {
        rig_t r;
        open_rig(&r);
        if (shared == 1 && !ect_packet_share(&r.twin)) {
            close_rig(&r);
            break;
        }
        wait_for_times(&r);
        send_frame(&r, head, sizeof head, FRAME, 1);
        send_frame(&r, head, sizeof head, FRAME + 1, 2);
        nanosleep(&pause, NULL);
        assert_int_equal(receive(&r, ROOM), ECT_PACKET_STALE);
        assert_true(r.time.waited_ns >= 20000000u);
        assert_int_equal(receive(&r, ROOM), FRAME + 1); /* the last one, however old */
        assert_memory_equal(r.got, r.sent, FRAME + 1);
        assert_true(r.time.waited_ns >= 20000000u);
        close_rig(&r);
    }
}

static void down_and_gone(void **state)
{
    char message[ECT_PACKET_MESSAGE];
    (void)state;
    if (!inside)
        skip();
    for (unsigned int shared = 0; shared < 2; shared++) {
        rig_t r = {0};
        assert_int_equal(ect_veth_create("a-twin", "a-master", message), 0);
        must_open(&r.twin, "a-twin");
        must_open(&r.master, "a-master");
        if (shared == 1 && !ect_packet_share(&r.twin)) {
            close_rig(&r);
            assert_int_equal(ect_veth_destroy("a-twin"), 0);
            break;
        }
        assert_true(ect_packet_has_link(&r.twin));
        set_up("a-master", false); /* the other end: no carrier */
        assert_false(ect_packet_has_link(&r.twin));
        assert_int_equal(receive(&r, ROOM), ECT_PACKET_NONE);
        set_up("a-master", true);
        assert_true(ect_packet_has_link(&r.twin));
        set_up("a-twin", false); /* this end: it may return */
        assert_false(ect_packet_has_link(&r.twin));
        for (unsigned int n = 0; n < 200000; n++)
            assert_int_equal(receive(&r, 1), ECT_PACKET_NONE);
        set_up("a-twin", true);
        assert_true(ect_packet_has_link(&r.twin));
        ssize_t got = ECT_PACKET_NONE;
        for (unsigned int n = 0; n < 10000 && got != FRAME; n++) { /* the kernel opens the queues some time */
            const struct timespec pause = {.tv_nsec = 1000000};
            send_frame(&r, head, sizeof head, FRAME, 1);
            got = receive(&r, ROOM);
            nanosleep(&pause, NULL);
        }
        assert_int_equal(got, FRAME);
        while (receive(&r, ROOM) != ECT_PACKET_NONE)
            ;
        assert_int_equal(ect_veth_destroy("a-twin"), 0);
        got = ECT_PACKET_NONE;
        for (unsigned int n = 0; n < 200000 && got == ECT_PACKET_NONE; n++)
            got = receive(&r, ROOM);
        assert_int_equal(got, ECT_PACKET_GONE);
        assert_int_equal(errno, ENODEV);
        assert_false(ect_packet_has_link(&r.twin));
        close_rig(&r);
    }
}

static unsigned int open_descriptors(void)
{
    unsigned int count = 0;
    for (int fd = 0; fd < 1024; fd++)
        count += fcntl(fd, F_GETFD) >= 0;
    return count;
}

/* An interface that was down is up while the port is open. */
static void brought_up(void **state)
{
    ect_packet_t port;
    (void)state;
    if (!inside)
        skip();
    for (unsigned int down = 0; down < 2; down++) {
        const unsigned int open_before = open_descriptors();
        set_up("ecat1", down == 0);
        must_open(&port, "ecat1");
        assert_int_equal(port.was_down, down == 1);
        assert_true(is_up("ecat1"));
        assert_int_equal(flags_of("ecat1") & IFF_UP, IFF_UP);
        ect_packet_close(&port);
        assert_int_equal(is_up("ecat1"), down == 0);
        assert_int_equal(port.fd + port.tagged_fd + port.claim_fd, -3);
        assert_int_equal(open_descriptors(), open_before);
    }
    set_up("ecat1", true);
}

static bool is_readable(int fd)
{
    struct pollfd one = {.fd = fd, .events = POLLIN};
    return poll(&one, 1, 0) == 1;
}

/* Whether the messages end. The kernel sends one of the link's operational state up to a second late. */
static bool ends(int fd)
{
    const struct timespec late = {.tv_nsec = 200000000};
    for (unsigned int n = 0; n < 10; n++) {
        ect_packet_links_seen(fd);
        if (!is_readable(fd))
            return true;
        nanosleep(&late, NULL);
    }
    return false;
}

static void watched_links(void **state)
{
    (void)state;
    if (!inside)
        skip();
    int fd = ect_packet_watch_links();
    assert_true(fd >= 0);
    assert_true(ends(fd));
    set_up("ecat1", false);
    assert_true(is_readable(fd));
    assert_true(ends(fd));
    for (unsigned int n = 0; n < 2000; n++) /* more messages than there is room for */
        set_up("ecat1", n % 2 == 0);
    assert_true(is_readable(fd));
    assert_true(ends(fd));
    set_up("ecat1", true);
    close(fd);
}

/* A process without rights gets the name of the missing one; a name that is wrong is wrong with every right. */
static void without_rights(void **state)
{
    static const struct {
        const char *iface, *why;
    } rows[] = {{"ecat0", "opening 'ecat0' needs the capability CAP_NET_RAW: "},
                {"nothere", "there is no network interface 'nothere'"}};
    (void)state;
    if (!inside)
        skip();
    (void)fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        char message[512];
        if (setresuid(1000, 1000, 1000) < 0)
            _exit(0);
        for (size_t i = 0; i < 2; i++) {
            ect_packet_t port;
            if (ect_packet_open(&port, rows[i].iface, message) != -1 || strstr(message, rows[i].why) != message)
                _exit(1);
        }
        if (ect_veth_create("new", "other", message) != -1 ||
            strcmp(message, "a pair of interfaces needs CAP_NET_ADMIN: run 'sudo ectwin veth new'") != 0)
            _exit(2);
        _exit(ect_veth_destroy("ecat0") == -1 ? 0 : 3);
    }
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_true(is_up("ecat0"));
}

/* --- rights ----------------------------------------------------------------------------------------------------- */

/* A line of /proc/self/status, as the kernel writes it. */
static bool status_has(const char *line)
{
    static char all[8192];
    int fd = open("/proc/self/status", O_RDONLY | O_CLOEXEC);
    ssize_t length = fd >= 0 ? read(fd, all, sizeof all - 1) : -1;
    if (fd >= 0)
        close(fd);
    all[length > 0 ? length : 0] = 0;
    return strstr(all, line) != NULL;
}

/* In a process of its own: 0, or the number of the first step that is wrong. */
static int drop_rights(unsigned int keep)
{
    char message[ECT_RIGHTS_MESSAGE];
    const bool link = (keep & ECT_RIGHTS_LINK) != 0;
    if (ect_rights_drop(keep, message) != 0)
        return 1;
    if (!status_has(link ? "CapEff:\t0000000000001000\n" : "CapEff:\t0000000000000000\n"))
        return 2;
    if (!status_has(link ? "CapPrm:\t0000000000001000\n" : "CapPrm:\t0000000000000000\n"))
        return 3;
    if (!status_has("CapInh:\t0000000000000000\n") || !status_has("CapAmb:\t0000000000000000\n"))
        return 4;
    if (!status_has("CapBnd:\t0000000000000000\n"))
        return 5;
    return status_has("NoNewPrivs:\t1\n") ? 0 : 6;
}

static void rights_given_up(void **state)
{
    (void)state;
    if (!inside)
        skip();
    for (unsigned int keep = 0; keep < 8; keep++) {
        int status = -1;
        (void)fflush(NULL);
        pid_t child = fork();
        if (child == 0)
            _exit(drop_rights(keep));
        assert_int_equal(waitpid(child, &status, 0), child);
        if (status != 0)
            fail_msg("rights %u: step %d is wrong", keep, WEXITSTATUS(status));
    }
}

/* Without the right, and without a limit that allows it. */
static int realtime_refused(void)
{
    char message[ECT_RIGHTS_MESSAGE];
    const struct rlimit none = {0, 0};
    if (setrlimit(RLIMIT_RTPRIO, &none) < 0 || ect_rights_realtime(50, message) != -1)
        return 1;
    static const char want[] = "--realtime 50 lacks a right: CAP_SYS_NICE, or a sufficient limit of real-time priority";
    return strncmp(message, want, sizeof want - 1) == 0 ? 0 : 2;
}

static void realtime_without_the_right(void **state)
{
    int status = -1;
    (void)state;
    if (!inside || (lacks & ECT_NETNS_USER_NAMESPACE) != 0)
        skip();
    (void)fflush(NULL);
    pid_t child = fork();
    if (child == 0)
        _exit(realtime_refused());
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"names for the end of a wire: refused with the reason", names, NULL, NULL, NULL},
        {"a private network: two wires and the loopback, up, without IPv6, its own /sys", private_network, NULL, NULL,
         NULL},
        {"a private network with one wire, made by root and by a user", another_network, NULL, NULL, NULL},
        {"a pair of interfaces is made up and whole, and removed by either end", pairs, NULL, NULL, NULL},
        {"the first frame of each end of a new pair arrives at the other one", first_frames, NULL, NULL, NULL},
        {"a port that cannot be opened: one line with the cause", refused, NULL, NULL, NULL},
        {"an interface that a foreign master has open is refused, another one is not", beside_a_foreign_master, NULL,
         NULL, NULL},
        {"CF-013: EtherCAT frames come whole, with their tag, and no others do; nor do its own", frames, NULL, NULL,
         NULL},
        {"a wait returns a queued frame, or ends", waits, NULL, NULL, NULL},
        {"a frame that has waited for more than 5 ms is discarded if a newer one is queued", stale, NULL, NULL, NULL},
        {"an interface that is down may return, one that is removed is gone", down_and_gone, NULL, NULL, NULL},
        {"an interface that was down is up while its port is open, and down again", brought_up, NULL, NULL, NULL},
        {"each change of an interface makes the descriptor of links readable, until it is read", watched_links, NULL,
         NULL, NULL},
        {"a user without rights gets the missing right, or the wrong name, in one line", without_rights, NULL, NULL,
         NULL},
        {"rights are dropped permanently, except the right for the link where it is needed", rights_given_up, NULL,
         NULL, NULL},
        {"real-time priority without the right for it: one line with the cause", realtime_without_the_right, NULL, NULL,
         NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("network", tests, enter, NULL);
}
