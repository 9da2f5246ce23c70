/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "net_folder.h"

#include <dirent.h>
#include <ftw.h>
#include <limits.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"

static const char system_folder[] = "/sys/class/net";

static bool write_file(const char *folder, const char *name, const char *text)
{
    char path[PATH_MAX];
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path)
        return false;
    FILE *file = fopen(path, "we");
    if (!file)
        return false;
    bool whole = fprintf(file, "%s\n", text) > 0;
    return fclose(file) == 0 && whole;
}

/* The files of /sys/class/net/IFACE that programs read, with the values of a virtual Ethernet interface. */
static bool make_interface(const char *tree, const char *name, size_t end, bool up)
{
    char folder[PATH_MAX], index[24], event[128];
    snprintf(index, sizeof index, "%zu", ECT_BUS_INDEX + end);
    snprintf(event, sizeof event, "INTERFACE=%.32s\nIFINDEX=%s", name, index);
    const struct {
        const char *name, *text;
    } files[] = {{"address", "02:00:00:00:00:01"},
                 {"addr_len", "6"},
                 {"broadcast", "ff:ff:ff:ff:ff:ff"},
                 {"carrier", up ? "1" : "0"},
                 {"duplex", "full"},
                 {"flags", up ? "0x1103" : "0x1102"},
                 {"ifindex", index},
                 {"iflink", index},
                 {"mtu", "1500"},
                 {"operstate", up ? "up" : "down"},
                 {"speed", "100"},
                 {"type", "1"},
                 {"uevent", event}};
    bool whole = snprintf(folder, sizeof folder, "%s/%s", tree, name) < (int)sizeof folder && mkdir(folder, 0755) == 0;
    for (size_t i = 0; whole && i < sizeof files / sizeof *files; i++)
        whole = write_file(folder, files[i].name, files[i].text);
    return whole;
}

/* EEXIST: an interface of the bus has the same name as one of the machine. */
static void link_others(const char *tree)
{
    DIR *list = opendir(system_folder);
    const struct dirent *one;
    while (list && (one = readdir(list))) {
        char target[PATH_MAX], path[PATH_MAX];
        snprintf(target, sizeof target, "%s/%s", system_folder, one->d_name);
        if (one->d_name[0] != '.' && snprintf(path, sizeof path, "%s/%s", tree, one->d_name) < (int)sizeof path)
            (void)!symlink(target, path);
    }
    if (list)
        closedir(list);
}

static bool make_tree(const char *folder, bool up, const char *const *names, size_t count)
{
    char tree[PATH_MAX];
    snprintf(tree, sizeof tree, "%s/%s", folder, up ? "up" : "down");
    if (mkdir(tree, 0755) != 0)
        return false;
    for (size_t end = 0; end < count; end++) {
        if (!make_interface(tree, names[end], end, up))
            return false;
    }
    link_others(tree);
    return true;
}

bool net_folder_make(const char *folder, const char *const *names, size_t count)
{
    return make_tree(folder, true, names, count) && make_tree(folder, false, names, count);
}

static int remove_one(const char *path, const struct stat *its, int kind, struct FTW *place)
{
    (void)its;
    (void)kind;
    (void)place;
    return remove(path);
}

void net_folder_remove(const char *folder)
{
    enum { DESCRIPTORS = 8 };
    (void)nftw(folder, remove_one, DESCRIPTORS, FTW_DEPTH | FTW_PHYS);
}
