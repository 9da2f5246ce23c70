/* SPDX-License-Identifier: MIT */
/* Replaces modbus.c in a build without libmodbus. */
#include <errno.h>
#include <stdio.h>
#include <unistd.h>

#include "bus/modbus/modbus.h"

ect_modbus_server_t *ect_modbus_server_open(const char *where, char *message)
{
    (void)where;
    snprintf(message, ECT_MODBUS_MESSAGE,
             "built without libmodbus: install it ('sudo apt install libmodbus-dev'), configure and build again");
    errno = ENOSYS;
    return NULL;
}

ect_modbus_server_t *ect_modbus_server_at(int fd, char *message)
{
    close(fd);
    return ect_modbus_server_open(NULL, message);
}

void ect_modbus_server_close(ect_modbus_server_t *server)
{
    (void)server;
}

const char *ect_modbus_server_address(const ect_modbus_server_t *server)
{
    (void)server;
    return "";
}

int ect_modbus_server_fd(const ect_modbus_server_t *server)
{
    (void)server;
    return -1;
}

uint64_t ect_modbus_server_due(const ect_modbus_server_t *server)
{
    (void)server;
    return ECT_NEVER;
}

void ect_modbus_server_serve(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns)
{
    (void)server;
    (void)chain;
    (void)now_ns;
}

bool ect_modbus_server_observe(ect_modbus_server_t *server, ect_modbus_observer_t *observer, void *ctx)
{
    (void)server;
    (void)observer;
    (void)ctx;
    return false;
}

ect_modbus_server_t *ect_modbus_server_new(char *message)
{
    return ect_modbus_server_open(NULL, message);
}

size_t ect_modbus_server_request(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns,
                                 const uint8_t *request, size_t length, uint8_t *reply)
{
    (void)server;
    (void)chain;
    (void)now_ns;
    (void)request;
    (void)length;
    (void)reply;
    return 0;
}
