/* SPDX-License-Identifier: MIT */
/* The interfaces of the bus after those of a machine, which the test supplies. */
#define _GNU_SOURCE
#include <ifaddrs.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <netpacket/packet.h>
#include <sys/ioctl.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/interfaces.h"
#include "bus/inprocess/ports.h"
#include "fakes.h"

OURS(if_nametoindex);
OURS(if_indextoname);
OURS(if_nameindex);
OURS(if_freenameindex);
OURS(getifaddrs);
OURS(freeifaddrs);

enum { PORT = 700, OTHER = 5, LO = 1 };

static const char *names[ECT_BUS_ENDS]; /* of the bus */
static bool up[ECT_BUS_ENDS];
static unsigned int blocks; /* of memory that is left */

/* --- fakes -------------------------------------------------------------------------------------------------------- */

static int fake_ioctl(int fd, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    struct ifconf *its = va_arg(arguments, struct ifconf *);
    va_end(arguments);
    assert_true(request == SIOCGIFCONF);
    if (its->ifc_req)
        strcpy(its->ifc_req->ifr_name, "lo");
    its->ifc_len = sizeof(struct ifreq);
    return (int)CALLED(ioctl, fd);
}

static unsigned int fake_if_nametoindex(const char *name)
{
    return (unsigned int)CALLED(if_nametoindex, name[0]);
}

static char *fake_if_indextoname(unsigned int index, char *name)
{
    return CALLED(if_indextoname, index) != 0 ? strcpy(name, "lo") : NULL;
}

static struct if_nameindex machine[] = {{.if_index = LO, .if_name = (char *)"lo"}, {.if_index = 0}};

static struct if_nameindex *fake_if_nameindex(void)
{
    return CALLED(if_nameindex) == 0 ? machine : NULL;
}

static void fake_if_freenameindex(struct if_nameindex *list)
{
    CALLED(if_freenameindex, list == machine);
}

static struct ifaddrs *addresses; /* of the machine */

static int fake_getifaddrs(struct ifaddrs **all)
{
    *all = addresses;
    return (int)CALLED(getifaddrs);
}

static void fake_freeifaddrs(struct ifaddrs *all)
{
    CALLED(freeifaddrs, all == addresses && (!all || !all->ifa_next));
}

FAKES(FAKE(ioctl), FAKE(if_nametoindex), FAKE(if_indextoname), FAKE(if_nameindex), FAKE(if_freenameindex),
      FAKE(getifaddrs), FAKE(freeifaddrs))

void *fake_calloc(size_t count, size_t size);
void *fake_calloc(size_t count, size_t size)
{
    return blocks > 0 && blocks-- > 0 ? calloc(count, size) : NULL;
}

char *fake_strdup(const char *text);
char *fake_strdup(const char *text)
{
    return strdup(text);
}

const char *ect_bus_name(unsigned int end)
{
    return names[end];
}

int ect_bus_end_of_name(const char *name)
{
    for (int end = 0; end < ECT_BUS_ENDS; end++) {
        if (names[end] && strcmp(names[end], name) == 0)
            return end;
    }
    return -1;
}

int ect_bus_end_of_index(int index)
{
    int end = index - ECT_BUS_INDEX;
    return end >= 0 && end < ECT_BUS_ENDS && names[end] ? end : -1;
}

ect_port_t *ect_port_of(int fd)
{
    return fd == PORT ? (ect_port_t *)(long)fd : NULL;
}

bool ect_port_is_up(unsigned int end)
{
    return up[end];
}

void ect_port_take(unsigned int end, bool is_up)
{
    CALLED(take, end, is_up);
}

static int begin(void **state)
{
    names[0] = "ect0";
    names[1] = "ect1";
    up[0] = true;
    up[1] = false;
    blocks = 100;
    addresses = NULL;
    return begin_fakes(state);
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

/* @return the result of a request for an interface; -2: for none of the bus */
static int request(unsigned long number, const char *name, struct ifreq *its)
{
    int result = -2;
    strncpy(its->ifr_name, name, IFNAMSIZ - 1);
    return ect_interface_request(OTHER, number, its, &result) ? result : -2;
}

static void describes_an_interface(void **state)
{
    static const uint8_t address[] = {2, 0, 0, 0, 0, 1};
    enum { DOWN = IFF_BROADCAST | IFF_PROMISC | IFF_MULTICAST };
    struct ifreq its = {0};
    (void)state;
    assert_int_equal(request(SIOCGIFINDEX, "ect1", &its), 0);
    assert_int_equal(its.ifr_ifindex, ECT_BUS_INDEX + 1);
    assert_int_equal(request(SIOCGIFFLAGS, "ect0", &its), 0);
    assert_int_equal(its.ifr_flags, DOWN | IFF_UP | IFF_RUNNING);
    assert_int_equal(request(SIOCGIFFLAGS, "ect1", &its), 0);
    assert_int_equal(its.ifr_flags, DOWN);
    assert_int_equal(request(SIOCGIFMTU, "ect0", &its), 0);
    assert_int_equal(its.ifr_mtu, 1500);
    assert_int_equal(request(SIOCSIFMTU, "ect0", &its), 0);
    assert_int_equal(request(SIOCGIFHWADDR, "ect0", &its), 0);
    assert_int_equal(its.ifr_hwaddr.sa_family, ARPHRD_ETHER);
    assert_memory_equal(its.ifr_hwaddr.sa_data, address, sizeof address);
    assert_int_equal(request(SIOCGIFADDR, "ect0", &its), -1);
    assert_int_equal(errno, EADDRNOTAVAIL);
    EXPECT_CALLS("reads", "");
}

static void takes_an_interface_up_and_down(void **state)
{
    struct ifreq its = {.ifr_flags = IFF_UP | IFF_PROMISC};
    (void)state;
    assert_int_equal(request(SIOCSIFFLAGS, "ect1", &its), 0);
    EXPECT_CALLS("up", "take(1,1) ");
    its.ifr_flags = IFF_PROMISC;
    assert_int_equal(request(SIOCSIFFLAGS, "ect0", &its), 0);
    EXPECT_CALLS("down", "take(0,0) ");
}

static void leaves_other_requests(void **state)
{
    struct ifreq its = {0};
    int result = 7;
    (void)state;
    assert_int_equal(request(SIOCGIFINDEX, "lo", &its), -2);
    assert_int_equal(request(SIOCGIFMETRIC, "ect0", &its), -2);
    assert_false(ect_interface_request(OTHER, SIOCGIFMETRIC, NULL, &result));
    assert_int_equal(result, 7);
    static const unsigned long has[] = {SIOCGIFINDEX,  SIOCGIFFLAGS, SIOCGIFMTU,
                                        SIOCGIFHWADDR, SIOCSIFFLAGS, SIOCSIFMTU};
    for (size_t i = 0; i < sizeof has / sizeof *has; i++)
        assert_true(ect_interface_has(has[i]));
    assert_false(ect_interface_has(SIOCGIFADDR));
    assert_false(ect_interface_has(SIOCGIFMETRIC));
}

static void names_an_index(void **state)
{
    struct ifreq its = {.ifr_ifindex = ECT_BUS_INDEX + 1};
    int result = -2;
    (void)state;
    assert_true(ect_interface_request(OTHER, SIOCGIFNAME, &its, &result));
    assert_int_equal(result, 0);
    assert_string_equal(its.ifr_name, "ect1");
    its.ifr_ifindex = LO;
    assert_false(ect_interface_request(OTHER, SIOCGIFNAME, &its, &result));
}

/* --- the list of SIOCGIFCONF -------------------------------------------------------------------------------------- */

static void lists_interfaces(void **state)
{
    struct ifreq rows[5];
    struct ifconf its = {.ifc_len = sizeof rows, .ifc_req = rows};
    int result = -2;
    (void)state;
    memset(rows, 0x55, sizeof rows);
    assert_true(ect_interface_request(OTHER, SIOCGIFCONF, &its, &result));
    assert_int_equal(result, 0);
    assert_int_equal(its.ifc_len, 3 * sizeof *rows);
    assert_string_equal(rows[0].ifr_name, "lo");
    assert_string_equal(rows[1].ifr_name, "ect0");
    assert_string_equal(rows[2].ifr_name, "ect1");
    assert_int_equal(rows[2].ifr_addr.sa_family, AF_INET);
    assert_int_equal(rows[2].ifr_addr.sa_data[0], 0);
    EXPECT_CALLS("another socket", "ioctl(5) ");
    its.ifc_len = sizeof rows;
    assert_true(ect_interface_request(PORT, SIOCGIFCONF, &its, &result));
    assert_int_equal(its.ifc_len, 2 * sizeof *rows);
    assert_string_equal(rows[0].ifr_name, "ect0");
    EXPECT_CALLS("a port", "");
}

static void lists_what_there_is_room_for(void **state)
{
    struct ifreq rows[3];
    (void)state;
    for (size_t room = 1; room <= 3; room++) {
        struct ifconf its = {.ifc_len = (int)(room * sizeof *rows), .ifc_req = rows};
        int result = -2;
        memset(rows, 0, sizeof rows);
        assert_true(ect_interface_request(OTHER, SIOCGIFCONF, &its, &result));
        assert_int_equal(its.ifc_len, room * sizeof *rows);
        assert_int_equal(rows[1].ifr_name[0], room > 1 ? 'e' : 0);
        assert_int_equal(rows[2].ifr_name[0], room > 2 ? 'e' : 0);
    }
    struct ifconf less = {.ifc_len = 2 * sizeof *rows - 1, .ifc_req = rows};
    int result = -2;
    assert_true(ect_interface_request(OTHER, SIOCGIFCONF, &less, &result));
    assert_int_equal(less.ifc_len, sizeof *rows);
    struct ifconf count = {.ifc_len = 1};
    assert_true(ect_interface_request(OTHER, SIOCGIFCONF, &count, &result));
    assert_int_equal(count.ifc_len, 3 * sizeof *rows);
    forget_calls();
}

static void lists_only_interfaces_with_a_name(void **state)
{
    struct ifreq rows[3];
    struct ifconf its = {.ifc_len = sizeof rows, .ifc_req = rows};
    int result = -2;
    (void)state;
    names[0] = NULL;
    assert_true(ect_interface_request(PORT, SIOCGIFCONF, &its, &result));
    assert_int_equal(its.ifc_len, sizeof *rows);
    assert_string_equal(rows[0].ifr_name, "ect1");
    its.ifc_len = sizeof rows;
    plan("ioctl", -1, EBADF);
    assert_true(ect_interface_request(OTHER, SIOCGIFCONF, &its, &result));
    assert_int_equal(result, -1);
    assert_int_equal(its.ifc_len, sizeof rows);
    forget_calls();
}

static void refuses_bad_addresses(void **state)
{
    struct ifreq its = {.ifr_ifindex = ECT_BUS_INDEX}, rows[3];
    struct ifconf all = {.ifc_len = sizeof rows, .ifc_req = rows};
    struct ifconf nowhere = {.ifc_len = sizeof rows, .ifc_req = AT(5)};
    const struct {
        const char *title;
        unsigned long request;
        void *argument, *unwritable;
        int result;
    } cases[] = {{"SIOCGIFINDEX", SIOCGIFINDEX, AT(5), NULL, -1},
                 {"SIOCGIFINDEX at address 0", SIOCGIFINDEX, NULL, NULL, -1},
                 {"SIOCSIFFLAGS", SIOCSIFFLAGS, AT(5), NULL, -1},
                 {"SIOCGIFADDR", SIOCGIFADDR, AT(5), NULL, -1},
                 {"SIOCGIFNAME", SIOCGIFNAME, AT(5), NULL, -1},
                 {"SIOCGIFCONF", SIOCGIFCONF, AT(5), NULL, -1},
                 {"the rows of SIOCGIFCONF", SIOCGIFCONF, &nowhere, NULL, -1},
                 {"the length of SIOCGIFCONF", SIOCGIFCONF, &all, &all.ifc_len, -1},
                 {"the reply of SIOCGIFMTU", SIOCGIFMTU, &its, &its, -1},
                 {"the reply of SIOCGIFNAME", SIOCGIFNAME, &its, &its, -1},
                 {"SIOCSIFMTU, which has none", SIOCSIFMTU, &its, &its, 0},
                 {"SIOCSIFFLAGS, which has none", SIOCSIFFLAGS, &its, &its, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int result = 7;
        if (cases[i].request != SIOCGIFNAME)
            strcpy(its.ifr_name, "ect0");
        bad_memory.unwritable = cases[i].unwritable;
        errno = 0;
        if (!ect_interface_request(PORT, cases[i].request, cases[i].argument, &result) || result != cases[i].result ||
            errno != (cases[i].result != 0 ? EFAULT : 0))
            fail_msg("%s: result %d, errno %d", cases[i].title, result, errno);
        its.ifr_ifindex = ECT_BUS_INDEX;
    }
    EXPECT_CALLS("the requests", "take(0,1) "); /* the index is in the place of the flags */
}

/* --- names and indices -------------------------------------------------------------------------------------------- */

static void maps_names_and_indices(void **state)
{
    char name[IF_NAMESIZE];
    (void)state;
    memset(name, 'x', sizeof name);
    assert_int_equal(ours_if_nametoindex("ect0"), ECT_BUS_INDEX);
    assert_int_equal(ours_if_nametoindex("ect1"), ECT_BUS_INDEX + 1);
    assert_ptr_equal(ours_if_indextoname(ECT_BUS_INDEX + 1, name), name);
    assert_string_equal(name, "ect1");
    assert_ptr_equal(ours_if_indextoname(ECT_BUS_INDEX, name), name);
    assert_string_equal(name, "ect0");
    EXPECT_CALLS("of the bus", "");
    names[0] = "a-name-of-24-letters....";
    assert_ptr_equal(ours_if_indextoname(ECT_BUS_INDEX, name), name);
    assert_string_equal(name, "a-name-of-24-le");
    plan("if_nametoindex", LO, 0);
    assert_int_equal(ours_if_nametoindex("lo"), LO);
    plan("if_indextoname", 1, 0);
    assert_ptr_equal(ours_if_indextoname(LO, name), name);
    EXPECT_CALLS("of the machine", "if_nametoindex(108) if_indextoname(1) ");
    ect_inside = 1;
    assert_int_equal(ours_if_nametoindex("ect1"), 0);
    assert_null(ours_if_indextoname(ECT_BUS_INDEX + 1, name));
    EXPECT_CALLS("of the library", "if_nametoindex(101) if_indextoname(1002) ");
}

static void lists_names(void **state)
{
    (void)state;
    struct if_nameindex *all = ours_if_nameindex();
    assert_non_null(all);
    assert_int_equal(all[0].if_index, LO);
    assert_string_equal(all[0].if_name, "lo");
    assert_int_equal(all[1].if_index, ECT_BUS_INDEX);
    assert_string_equal(all[1].if_name, "ect0");
    assert_int_equal(all[2].if_index, ECT_BUS_INDEX + 1);
    assert_string_equal(all[2].if_name, "ect1");
    assert_int_equal(all[3].if_index, 0);
    assert_null(all[3].if_name);
    EXPECT_CALLS("all", "if_nameindex() if_freenameindex(1) ");
    ours_if_freenameindex(all);
    EXPECT_CALLS("free", ""); /* LeakSanitizer finds a name that is left */
    names[0] = NULL;
    plan("if_nameindex", 1, 0);
    all = ours_if_nameindex();
    assert_non_null(all);
    assert_string_equal(all[0].if_name, "ect1");
    assert_int_equal(all[1].if_index, 0);
    EXPECT_CALLS("of the bus alone", "if_nameindex() ");
    ours_if_freenameindex(all);
    ours_if_freenameindex(NULL);
    blocks = 0;
    assert_null(ours_if_nameindex());
    EXPECT_CALLS("without memory", "if_nameindex() if_freenameindex(1) ");
}

/* --- addresses ---------------------------------------------------------------------------------------------------- */

static void lists_addresses(void **state)
{
    static const uint8_t broadcast[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
    static const uint8_t address[] = {2, 0, 0, 0, 0, 1};
    struct ifaddrs lo = {.ifa_name = (char *)"lo"};
    struct ifaddrs *all = NULL;
    (void)state;
    addresses = &lo;
    assert_int_equal(ours_getifaddrs(&all), 0);
    assert_ptr_equal(all, &lo);
    for (unsigned int end = 0; end < ECT_BUS_ENDS; end++) {
        const struct ifaddrs *one = end == 0 ? lo.ifa_next : lo.ifa_next->ifa_next;
        struct sockaddr_ll its;
        assert_non_null(one);
        assert_string_equal(one->ifa_name, names[end]);
        assert_int_equal((one->ifa_flags & IFF_UP) != 0, up[end]);
        memcpy(&its, one->ifa_addr, sizeof its);
        assert_int_equal(its.sll_family, AF_PACKET);
        assert_int_equal(its.sll_ifindex, ECT_BUS_INDEX + end);
        assert_int_equal(its.sll_hatype, ARPHRD_ETHER);
        assert_int_equal(its.sll_halen, 6);
        assert_memory_equal(its.sll_addr, address, sizeof address);
        memcpy(&its, one->ifa_broadaddr, sizeof its);
        assert_int_equal(its.sll_ifindex, ECT_BUS_INDEX + end);
        assert_memory_equal(its.sll_addr, broadcast, sizeof broadcast);
    }
    assert_null(lo.ifa_next->ifa_next->ifa_next);
    EXPECT_CALLS("all", "getifaddrs() ");
    ours_freeifaddrs(all);
    EXPECT_CALLS("free", "freeifaddrs(1) ");
}

static void lists_addresses_of_the_bus_alone(void **state)
{
    struct ifaddrs *all = NULL;
    (void)state;
    names[0] = NULL;
    assert_int_equal(ours_getifaddrs(&all), 0);
    assert_string_equal(all->ifa_name, "ect1");
    assert_null(all->ifa_next);
    ours_freeifaddrs(all);
    EXPECT_CALLS("one", "getifaddrs() freeifaddrs(1) ");
    names[0] = "ect0";
    blocks = 1;
    assert_int_equal(ours_getifaddrs(&all), 0);
    assert_string_equal(all->ifa_name, "ect0");
    assert_null(all->ifa_next);
    ours_freeifaddrs(all);
    EXPECT_CALLS("without memory", "getifaddrs() freeifaddrs(1) ");
}

static void lists_addresses_of_the_machine_alone(void **state)
{
    struct ifaddrs lo = {.ifa_name = (char *)"lo"};
    struct ifaddrs *all = NULL;
    (void)state;
    addresses = &lo;
    plan("getifaddrs", -1, ENOMEM);
    assert_int_equal(ours_getifaddrs(&all), -1);
    assert_null(lo.ifa_next);
    ect_inside = 1;
    assert_int_equal(ours_getifaddrs(&all), 0);
    assert_null(lo.ifa_next);
    EXPECT_CALLS("of the library", "getifaddrs() getifaddrs() ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"An interface of the bus has an index, flags, an MTU and an address", describes_an_interface, begin, NULL,
         NULL},
        {"SIOCSIFFLAGS takes an interface up and down", takes_an_interface_up_and_down, begin, NULL, NULL},
        {"Other interfaces and requests are the kernel's", leaves_other_requests, begin, NULL, NULL},
        {"SIOCGIFNAME names an interface of the bus", names_an_index, begin, NULL, NULL},
        {"SIOCGIFCONF lists the interfaces of the machine, then those of the bus", lists_interfaces, begin, NULL, NULL},
        {"SIOCGIFCONF fills the room that it gets", lists_what_there_is_room_for, begin, NULL, NULL},
        {"A bad address is refused with EFAULT", refuses_bad_addresses, begin, NULL, NULL},
        {"SIOCGIFCONF lists no end without an interface", lists_only_interfaces_with_a_name, begin, NULL, NULL},
        {"Names and indices map both ways", maps_names_and_indices, begin, NULL, NULL},
        {"if_nameindex() lists the machine, then the bus", lists_names, begin, NULL, NULL},
        {"getifaddrs() lists the machine, then the bus", lists_addresses, begin, NULL, NULL},
        {"getifaddrs() lists the bus of a machine without interfaces", lists_addresses_of_the_bus_alone, begin, NULL,
         NULL},
        {"getifaddrs() of the library, or with an error, adds nothing", lists_addresses_of_the_machine_alone, begin,
         NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
