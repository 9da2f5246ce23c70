/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Modbus TCP: a server in front of the Modbus side (seams/modbus.h) of the first twin of a chain.
 *
 * Frames come first. ::ect_modbus_server_serve does one bounded piece of work: it lets one client in, or takes what one
 * has sent, as far as its present request goes, and answers that. The next call goes on with the next client. Nothing
 * is kept for a client but the beginning of one request; all else waits in the sockets, where TCP stops him. One who
 * does not read what he is answered is not listened to. As many connections as the device serves; another one is closed
 * at once, and so is one without a request for the device's time. What is no Modbus TCP ends the connection.
 *
 * Every unit identifier is answered: the server is found by its address, not by that (MODBUS Messaging on TCP/IP
 * Implementation Guide V1.0b §4.4.2.1).
 *
 * Context: the thread of the runner. Built without libmodbus ::ect_modbus_server_open says so and fails.
 */
#ifndef ECT_BUS_MODBUS_MODBUS_H
#define ECT_BUS_MODBUS_MODBUS_H

#include <stdint.h>

#include "bus/chain/chain.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_MODBUS_MESSAGE = 512, /**< room for a message of one line */
    ECT_MODBUS_CLIENTS = 16,  /**< the most connections that a device may ask for */
    ECT_MODBUS_ADU = 260,     /**< the longest request, and answer */
};

typedef struct ect_modbus_server ect_modbus_server_t;

/**
 * Listens. @param where  "PORT", at 127.0.0.1; "ADDRESS:PORT", the address in numbers, one of IPv6 in brackets. Port 0:
 *                        any that is free
 * @param[out] message  on failure one line for the user; ECT_MODBUS_MESSAGE bytes
 * @return the server, to be closed with ::ect_modbus_server_close, or NULL (errno; EINVAL: `where` is none of these)
 */
ect_modbus_server_t *ect_modbus_server_open(const char *where, char *message);

/**
 * Serves those who connect to a socket that listens.
 * @param fd  of a stream socket, non-blocking; becomes the server's, also on failure
 * @return as ::ect_modbus_server_open
 */
ect_modbus_server_t *ect_modbus_server_at(int fd, char *message);

/** @param server  NULL: nothing to do */
void ect_modbus_server_close(ect_modbus_server_t *server);

/** Where it listens, "127.0.0.1:1502", "[::1]:502"; valid until it is closed. */
const char *ect_modbus_server_address(const ect_modbus_server_t *server);

/** A descriptor that is readable when ::ect_modbus_server_serve has something to do. */
int ect_modbus_server_fd(const ect_modbus_server_t *server);

/** When it has something to do although its descriptor is not readable; ECT_NEVER while nobody is connected. */
uint64_t ect_modbus_server_due(const ect_modbus_server_t *server);

/** Does one bounded piece of work. Cost: at most six system calls and one request. */
void ect_modbus_server_serve(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns);

ECT_C_END

#endif
