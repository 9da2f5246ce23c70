/* SPDX-License-Identifier: MIT */
/*
 * The ways by which masters list adapters, against twins in this process.
 * usage: ectwin with --in-process [--virtual-time] fzm1,fzm1 -- inprocess_lists {} real|virtual [CASE]
 */
#define _GNU_SOURCE
#include "inprocess.h"

#include <dirent.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

static void addresses_list_the_interface(void **state)
{
    struct ifaddrs *all = NULL;
    unsigned int found = 0;
    (void)state;
    assert_int_equal(getifaddrs(&all), 0);
    for (const struct ifaddrs *one = all; one; one = one->ifa_next) {
        const struct sockaddr_ll *address = (const struct sockaddr_ll *)(const void *)one->ifa_addr;
        if (strcmp(one->ifa_name, interface) != 0)
            continue;
        found++;
        assert_int_equal(address->sll_family, AF_PACKET);
        assert_int_equal(address->sll_ifindex, if_nametoindex(interface));
        assert_int_equal(address->sll_halen, 6);
        assert_memory_equal(address->sll_addr, "\2\0\0\0\0\1", 6);
        assert_true((one->ifa_flags & IFF_UP) != 0);
    }
    freeifaddrs(all);
    assert_int_equal(found, 1);
}

/* SIOCGIFCONF with room for some entries. @return whether the interface is among them */
static bool is_in_list(int fd, int room, int *used)
{
    struct ifreq all[64];
    struct ifconf list = {.ifc_len = room, .ifc_req = all};
    bool found = false;
    assert_int_equal(ioctl(fd, SIOCGIFCONF, &list), 0);
    assert_true(list.ifc_len <= room);
    for (size_t i = 0; i < (size_t)list.ifc_len / sizeof *all; i++)
        found |= strcmp(all[i].ifr_name, interface) == 0 && all[i].ifr_addr.sa_family == AF_INET;
    *used = list.ifc_len;
    return found;
}

static void sockets_list_the_interface(void **state)
{
    struct ifreq its = {0};
    struct ifconf length = {0};
    int used;
    (void)state;
    for (unsigned int kind = 0; kind < 2; kind++) {
        int fd = kind == 0 ? socket(AF_INET, SOCK_DGRAM, 0) : socket(AF_PACKET, SOCK_RAW, htons(ETHERCAT));
        assert_true(is_in_list(fd, 64 * (int)sizeof its, &used));
        assert_int_equal(ioctl(fd, SIOCGIFCONF, &length), 0); /* without a buffer */
        assert_int_equal(length.ifc_len, used);
        assert_false(is_in_list(fd, used - 1, &used));
        its.ifr_ifindex = (int)if_nametoindex(interface);
        assert_int_equal(ioctl(fd, SIOCGIFNAME, &its), 0);
        assert_string_equal(its.ifr_name, interface);
        assert_int_equal(ioctl(fd, SIOCGIFADDR, &its), -1);
        assert_int_equal(errno, EADDRNOTAVAIL);
        close(fd);
    }
}

/* A file of the interface in /sys, as fopen() and openat() read it. */
static void assert_file(const char *name, const char *expected)
{
    char path[128], text[64] = "";
    snprintf(path, sizeof path, "/sys/class/net/%s/%s", interface, name);
    FILE *file = fopen(path, "re");
    assert_non_null(file);
    assert_non_null(fgets(text, sizeof text, file));
    fclose(file);
    assert_string_equal(text, expected);
    memset(text, 0, sizeof text);
    int fd = openat(AT_FDCWD, path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    assert_true(read(fd, text, sizeof text - 1) > 0);
    close(fd);
    assert_string_equal(text, expected);
}

static void system_files_describe_the_interface(void **state)
{
    char index[16], path[128], target[PATH_MAX];
    struct stat its;
    struct ifreq request = {0};
    struct dirent **list = NULL;
    bool opened = false, scanned = false;
    (void)state;
    snprintf(index, sizeof index, "%u\n", if_nametoindex(interface));
    snprintf(path, sizeof path, "/sys/class/net/%s", interface);
    assert_file("address", "02:00:00:00:00:01\n");
    assert_file("ifindex", index);
    assert_file("mtu", "1500\n");
    assert_file("type", "1\n");
    assert_file("operstate", "up\n");
    assert_file("flags", "0x1103\n");
    assert_int_equal(stat(path, &its), 0);
    assert_true(S_ISDIR(its.st_mode));
    assert_int_equal(access(path, R_OK), 0);
    assert_int_equal(stat("/sys/class/net/lo/mtu", &its), 0); /* of the machine */
    assert_int_equal(open("/sys/class/net/none/mtu", O_RDONLY | O_CLOEXEC), -1);
    /* The folder exists, and is no link. The compiler cannot derive the size, and adds a check of it. */
    volatile size_t size = sizeof target;
    assert_int_equal(readlink(path, target, size), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(readlinkat(AT_FDCWD, path, target, size), -1);
    assert_int_equal(errno, EINVAL);
    assert_ptr_equal(realpath(path, target), target);
    DIR *folder = opendir("/sys/class/net/");
    assert_non_null(folder);
    for (const struct dirent *one = readdir(folder); one; one = readdir(folder))
        opened |= strcmp(one->d_name, interface) == 0;
    closedir(folder);
    int count = scandir("/sys/class/net", &list, NULL, alphasort);
    for (int i = 0; i < count; i++) {
        scanned |= strcmp(list[i]->d_name, interface) == 0;
        free(list[i]);
    }
    free(list);
    assert_true(opened && scanned);
    int fd = open_socket(0);
    strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
    assert_int_equal(ioctl(fd, SIOCSIFFLAGS, &request), 0);
    assert_file("operstate", "down\n");
    assert_file("flags", "0x1102\n");
    request.ifr_flags = IFF_UP;
    assert_int_equal(ioctl(fd, SIOCSIFFLAGS, &request), 0);
    assert_file("operstate", "up\n");
    close(fd);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"getifaddrs lists the interface with its hardware address", addresses_list_the_interface, NULL, NULL, NULL},
        {"SIOCGIFCONF and SIOCGIFNAME of any socket list the interface", sockets_list_the_interface, NULL, NULL, NULL},
        {"Files in /sys/class/net describe the interface, and its state", system_files_describe_the_interface, NULL,
         NULL, NULL},
    };
    if (!is_started(argc, argv))
        return 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
