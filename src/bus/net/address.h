/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Addresses of sockets that users type. Context: any.
 */
#ifndef ECT_BUS_NET_ADDRESS_H
#define ECT_BUS_NET_ADDRESS_H

#include <stdbool.h>
#include <sys/socket.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** An address and a port, of IPv4 or IPv6. */
typedef struct ect_address {
    struct sockaddr_storage at;
    socklen_t size; /**< of the address in `at` */
} ect_address_t;

/** Room of ::ect_address_print. */
enum { ECT_ADDRESS_TEXT = 80 };

/**
 * Reads "PORT" (at 127.0.0.1), "ADDRESS:PORT" or "[ADDRESS]:PORT": the address in numbers, the port from 0 to 65535.
 * @param[out] address  set on success
 * @return false: the text is none of these
 */
bool ect_address_parse(ect_address_t *address, const char *text);

/** The reason why a socket could not be bound to an address, and the cure. @param error  errno; constant text */
const char *ect_address_why(int error);

/** Prints the address that a socket is bound to, as ::ect_address_parse reads it; "" if it has none. */
void ect_address_print(int fd, char text[ECT_ADDRESS_TEXT]);

ECT_C_END

#endif
