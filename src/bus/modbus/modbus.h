/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A Modbus TCP server for the Modbus tables (seams/modbus.h) of the first twin of a chain.
 *
 * Frames come first: ::ect_modbus_server_serve does one bounded piece of work. It accepts one client, or receives the
 * present request of one client and replies to it; the next call serves the next client. The server stores at most one
 * request of each client; further bytes wait in the socket, where TCP's flow control stops the client. A client that
 * does not read its replies is not served meanwhile. The device sets the number of connections. A further connection is
 * closed at once, as is a connection without a request during the device's timeout, or with bytes that are not Modbus
 * TCP.
 *
 * Every unit identifier gets a reply, because the IP address alone selects the server (MODBUS Messaging on TCP/IP
 * Implementation Guide V1.0b §4.4.2.1).
 *
 * Context: the thread of the runner. Built without libmodbus, ::ect_modbus_server_open fails with a message.
 */
#ifndef ECT_BUS_MODBUS_MODBUS_H
#define ECT_BUS_MODBUS_MODBUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_MODBUS_MESSAGE = 512, /**< room for a message of one line */
    ECT_MODBUS_CLIENTS = 16,  /**< most connections that a device may set */
    ECT_MODBUS_ADU = 260,     /**< bytes of the longest request and reply */
};

typedef struct ect_modbus_server ect_modbus_server_t;

/**
 * Opens a listening server.
 * @param where  "PORT", at 127.0.0.1; or "ADDRESS:PORT", a numeric address, IPv6 in brackets. Port 0: any free port
 * @param[out] message  on failure one line for the user; ECT_MODBUS_MESSAGE bytes
 * @return the server, to be closed with ::ect_modbus_server_close, or NULL (errno; EINVAL: invalid `where`)
 */
ect_modbus_server_t *ect_modbus_server_open(const char *where, char *message);

/**
 * Makes a server of a listening socket.
 * @param fd  a stream socket, non-blocking; owned by the server, also on failure
 * @return as ::ect_modbus_server_open
 */
ect_modbus_server_t *ect_modbus_server_at(int fd, char *message);

/** Closes a server. NULL: no effect */
void ect_modbus_server_close(ect_modbus_server_t *server);

/** @return the address of the server, "127.0.0.1:1502", "[::1]:502"; valid until the server is closed. */
const char *ect_modbus_server_address(const ect_modbus_server_t *server);

/** A descriptor that is readable when ::ect_modbus_server_serve has work. */
int ect_modbus_server_fd(const ect_modbus_server_t *server);

/** The time of the next ::ect_modbus_server_serve without a readable descriptor; ECT_NEVER without connections. */
uint64_t ect_modbus_server_due(const ect_modbus_server_t *server);

/** Does one bounded piece of work. Cost: at most six system calls and one request; two more calls with an observer. */
void ect_modbus_server_serve(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns);

/** Gets an executed request and its reply, both valid during the call. */
typedef void ect_modbus_observer_t(void *ctx, const uint8_t *request, size_t length, const uint8_t *reply,
                                   size_t reply_length);

/** Sets a function that gets every request of a client and its reply. @return false: no descriptor is free */
bool ect_modbus_server_observe(ect_modbus_server_t *server, ect_modbus_observer_t *observer, void *ctx);

/** Makes a server without an address, for ::ect_modbus_server_request alone. @return as ::ect_modbus_server_open */
ect_modbus_server_t *ect_modbus_server_new(char *message);

/**
 * Executes a request without a client.
 * @param request     with header, `length` bytes of any content
 * @param[out] reply  ECT_MODBUS_ADU bytes
 * @return bytes of the reply; 0: not a request, or no twin replies
 */
size_t ect_modbus_server_request(ect_modbus_server_t *server, ect_chain_t *chain, uint64_t now_ns,
                                 const uint8_t *request, size_t length, uint8_t *reply);

ECT_C_END

#endif
