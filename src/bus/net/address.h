/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Socket addresses typed by users. Context: any.
 */
#ifndef ECT_BUS_NET_ADDRESS_H
#define ECT_BUS_NET_ADDRESS_H

#include <stdbool.h>
#include <sys/socket.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** An IPv4 or IPv6 address with a port. */
typedef struct ect_address {
    struct sockaddr_storage at;
    socklen_t size; /**< bytes of `at` in use */
} ect_address_t;

/** Room of ::ect_address_print. */
enum { ECT_ADDRESS_TEXT = 80 };

/**
 * Reads "PORT" (at 127.0.0.1), "ADDRESS:PORT" or "[ADDRESS]:PORT": a numeric address, the port from 0 to 65535.
 * @param[out] address  set on success
 * @return false: the text has another form
 */
bool ect_address_parse(ect_address_t *address, const char *text);

/** @return the cause and the cure of a failed bind(), constant text. @param error  errno of the bind() */
const char *ect_address_why(int error);

/** Prints the address that a socket is bound to, in a form of ::ect_address_parse; "" if the socket has none. */
void ect_address_print(int fd, char text[ECT_ADDRESS_TEXT]);

ECT_C_END

#endif
