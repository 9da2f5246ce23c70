/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "finder.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static void remove_dead(buses_t *buses)
{
    size_t kept = 0;
    for (size_t i = 0; i < buses->count; i++) {
        bus_t *bus = buses->all[i];
        if (bus->socket || bus->trace.socket || ect_endpoint_identity(bus->path) != 0) {
            buses->all[kept++] = bus;
        } else {
            table_clear(&bus->table);
            free(bus);
            buses->changes++;
        }
    }
    buses->count = kept;
}

static bool add(void *ctx, const char *path)
{
    buses_t *buses = ctx;
    for (size_t i = 0; i < buses->count; i++) {
        if (strcmp(buses->all[i]->path, path) == 0)
            return true;
    }
    bus_t *bus = buses->count < BUS_MOST ? calloc(1, sizeof *bus) : NULL;
    if (!bus)
        return false;
    snprintf(bus->path, sizeof bus->path, "%s", path);
    bus->number = ++buses->numbers;
    buses->all[buses->count++] = bus;
    return true;
}

void finder_connect(bus_t *bus, finder_taker_t take, void *ctx)
{
    struct ucred peer = {0};
    socklen_t size = sizeof peer;
    uid_t owner = 0;
    int fd = ect_endpoint_connect_now(bus->path, &owner);
    if (fd < 0) {
        ect_endpoint_clear(bus->path);
        return;
    }
    (void)getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size);
    if (owner == geteuid())
        take(ctx, bus, fd, peer.pid);
    else
        close(fd);
}

void finder_search(buses_t *buses, finder_taker_t take, void *ctx)
{
    char folder[ECT_ENDPOINT_PATH];
    remove_dead(buses);
    if (ect_endpoint_folder(folder) == 0 && ect_endpoint_trust(folder) == 0)
        ect_endpoint_each(folder, add, buses);
    for (size_t i = 0; i < buses->count; i++) {
        if (!buses->all[i]->socket)
            finder_connect(buses->all[i], take, ctx);
    }
}
