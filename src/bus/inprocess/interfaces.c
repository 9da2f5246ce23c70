/* SPDX-License-Identifier: MIT */
/* The interfaces of the bus, by name, by index, and at the end of lists of all interfaces. */
#define _GNU_SOURCE
#include "bus/inprocess/interfaces.h"

#include <errno.h>
#include <ifaddrs.h>
#include <linux/if_link.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <netpacket/packet.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/ports.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/user.h"

enum { ADDRESS = 6, MTU = 1500 };

static const unsigned char hardware_address[ADDRESS] = {2, 0, 0, 0, 0, 1};

static unsigned int flags_of(unsigned int end)
{
    unsigned int up = ect_port_is_up(end) ? IFF_UP | IFF_RUNNING : 0;
    return IFF_BROADCAST | IFF_PROMISC | IFF_MULTICAST | up;
}

/* --- requests of ioctl ---------------------------------------------------------------------------------------------
 */

static int about(unsigned long request, struct ifreq *its, unsigned int end)
{
    switch (request) {
    case SIOCGIFINDEX:
        its->ifr_ifindex = (int)(ECT_BUS_INDEX + end);
        return 0;
    case SIOCGIFFLAGS:
        its->ifr_flags = (short)flags_of(end);
        return 0;
    case SIOCSIFFLAGS:
        ect_port_take(end, (its->ifr_flags & IFF_UP) != 0);
        return 0;
    case SIOCGIFMTU:
        its->ifr_mtu = MTU;
        return 0;
    case SIOCGIFHWADDR:
        its->ifr_hwaddr.sa_family = ARPHRD_ETHER;
        memcpy(its->ifr_hwaddr.sa_data, hardware_address, sizeof hardware_address);
        return 0;
    case SIOCGIFADDR: /* no IP address */
        errno = EADDRNOTAVAIL;
        return -1;
    default: /* SIOCSIFMTU */
        return 0;
    }
}

bool ect_interface_has(unsigned long request)
{
    static const unsigned long requests[] = {SIOCGIFINDEX,  SIOCGIFFLAGS, SIOCGIFMTU,
                                             SIOCGIFHWADDR, SIOCSIFFLAGS, SIOCSIFMTU};
    size_t i = 0;
    while (i < sizeof requests / sizeof *requests && requests[i] != request)
        i++;
    return i < sizeof requests / sizeof *requests;
}

static int bad_address(void)
{
    errno = EFAULT;
    return -1;
}

/* @return whether the entry of an interface is now in a list */
static bool add(const struct ifconf *list, const char *name)
{
    struct ifreq one = {.ifr_addr.sa_family = AF_INET};
    strncpy(one.ifr_name, name, IFNAMSIZ - 1);
    return ect_user_write(ect_user_at(list->ifc_req, (size_t)list->ifc_len), &one, sizeof one);
}

/* A kernel lists only interfaces with an IPv4 address; those of the bus are listed with 0.0.0.0, because masters search
 * adapters here. Without a buffer the result is the length. */
static int list(int fd, struct ifconf *argument)
{
    struct ifconf its;
    if (!ect_user_read(&its, argument, sizeof its))
        return bad_address();
    int room = its.ifc_len;
    bool counts = !its.ifc_req;
    int result = ect_port_of(fd) ? (its.ifc_len = 0) : REAL(ioctl)(fd, SIOCGIFCONF, &its);
    for (unsigned int end = 0; result == 0 && end < ECT_BUS_ENDS; end++) {
        const char *name = ect_bus_name(end);
        if (!name || (!counts && room - its.ifc_len < (int)sizeof(struct ifreq)))
            continue;
        if (!counts && !add(&its, name))
            return bad_address();
        its.ifc_len += (int)sizeof(struct ifreq);
    }
    if (result != 0)
        return result;
    return ect_user_write(ect_user_at(argument, offsetof(struct ifconf, ifc_len)), &its.ifc_len, sizeof its.ifc_len)
               ? 0
               : bad_address();
}

/* @return whether the kernel writes the argument of a request */
static bool is_output(unsigned long request)
{
    return request != SIOCSIFFLAGS && request != SIOCSIFMTU;
}

bool ect_interface_request(int fd, unsigned long request, void *argument, int *result)
{
    struct ifreq its;
    if (request == SIOCGIFCONF) {
        *result = list(fd, argument);
        return true;
    }
    bool has = ect_interface_has(request) || request == SIOCGIFADDR;
    if (!has && request != SIOCGIFNAME)
        return false;
    if (!ect_user_read(&its, argument, sizeof its)) {
        *result = bad_address();
        return true;
    }
    its.ifr_name[IFNAMSIZ - 1] = 0;
    int end = has ? ect_bus_end_of_name(its.ifr_name) : ect_bus_end_of_index(its.ifr_ifindex);
    if (end < 0)
        return false;
    *result = has                                                           ? about(request, &its, (unsigned int)end)
              : if_indextoname((unsigned int)its.ifr_ifindex, its.ifr_name) ? 0
                                                                            : -1;
    if (*result == 0 && is_output(request) && !ect_user_write(argument, &its, sizeof its))
        *result = bad_address();
    return true;
}

/* --- names and indices ---------------------------------------------------------------------------------------------
 */

REPLACES unsigned int if_nametoindex(const char *name)
{
    int end = ect_inside > 0 ? -1 : ect_bus_end_of_name(name);
    return end >= 0 ? (unsigned int)(ECT_BUS_INDEX + end) : REAL(if_nametoindex)(name);
}

REPLACES char *if_indextoname(unsigned int index, char name[IF_NAMESIZE])
{
    int end = ect_inside > 0 ? -1 : ect_bus_end_of_index((int)index);
    if (end < 0)
        return REAL(if_indextoname)(index, name);
    strncpy(name, ect_bus_name((unsigned int)end), IF_NAMESIZE - 1);
    name[IF_NAMESIZE - 1] = 0;
    return name;
}

/* if_freenameindex frees each name and the list. */
REPLACES struct if_nameindex *if_nameindex(void)
{
    struct if_nameindex *real = REAL(if_nameindex)();
    size_t count = 0;
    while (real && real[count].if_index != 0)
        count++;
    struct if_nameindex *all = calloc(count + ECT_BUS_ENDS + 1, sizeof *all);
    for (size_t i = 0; all && i < count; i++)
        all[i] = (struct if_nameindex){.if_index = real[i].if_index, .if_name = strdup(real[i].if_name)};
    if (real)
        REAL(if_freenameindex)(real);
    for (unsigned int end = 0; all && end < ECT_BUS_ENDS; end++) {
        const char *name = ect_bus_name(end);
        if (name)
            all[count++] = (struct if_nameindex){.if_index = ECT_BUS_INDEX + end, .if_name = strdup(name)};
    }
    return all;
}

REPLACES void if_freenameindex(struct if_nameindex *list)
{
    for (struct if_nameindex *one = list; one && one->if_index != 0; one++)
        free(one->if_name);
    free(list);
}

/* --- addresses -----------------------------------------------------------------------------------------------------
 */

/* An entry of getifaddrs(3), in one block of memory. */
typedef struct entry {
    struct ifaddrs its; /* first */
    struct sockaddr_ll address, broadcast;
    char name[IF_NAMESIZE];
} entry_t;

static struct rtnl_link_stats
    nothing; /* the counters of each entry of the bus, by which freeifaddrs() recognises the entry */

static struct ifaddrs *new_entry(unsigned int end)
{
    entry_t *one = calloc(1, sizeof *one);
    if (!one)
        return NULL;
    strncpy(one->name, ect_bus_name(end), sizeof one->name - 1);
    one->address = (struct sockaddr_ll){.sll_family = AF_PACKET,
                                        .sll_ifindex = (int)(ECT_BUS_INDEX + end),
                                        .sll_hatype = ARPHRD_ETHER,
                                        .sll_halen = ADDRESS};
    one->broadcast = one->address;
    memcpy(one->address.sll_addr, hardware_address, ADDRESS);
    memset(one->broadcast.sll_addr, 0xFF, ADDRESS);
    one->its = (struct ifaddrs){.ifa_name = one->name,
                                .ifa_flags = flags_of(end),
                                .ifa_addr = (struct sockaddr *)&one->address,
                                .ifa_broadaddr = (struct sockaddr *)&one->broadcast,
                                .ifa_data = &nothing};
    return &one->its;
}

REPLACES int getifaddrs(struct ifaddrs **all)
{
    int result = REAL(getifaddrs)(all);
    if (result != 0 || ect_inside > 0)
        return result;
    struct ifaddrs **at = all;
    while (*at)
        at = &(*at)->ifa_next;
    for (unsigned int end = 0; end < ECT_BUS_ENDS; end++) {
        if (ect_bus_name(end) && (*at = new_entry(end)))
            at = &(*at)->ifa_next;
    }
    return 0;
}

REPLACES void freeifaddrs(struct ifaddrs *all)
{
    struct ifaddrs **at = &all;
    while (*at && (*at)->ifa_data != &nothing)
        at = &(*at)->ifa_next;
    struct ifaddrs *ours = *at;
    *at = NULL;
    while (ours) {
        struct ifaddrs *next = ours->ifa_next;
        free(ours);
        ours = next;
    }
    REAL(freeifaddrs)(all);
}
