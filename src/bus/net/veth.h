/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Pairs of virtual Ethernet interfaces. A function with a socket returns a result of libnl: negative is an error.
 */
#ifndef ECT_BUS_NET_VETH_H
#define ECT_BUS_NET_VETH_H

#include "wire/linkage.h"

ECT_C_BEGIN

struct nl_sock;

/** Room for a message of ::ect_veth_create. */
enum { ECT_VETH_MESSAGE = 512 };

/** Brings an interface up. @param socket  connected to NETLINK_ROUTE */
int ect_veth_up(struct nl_sock *socket, const char *name);

/**
 * Makes a pair, both ends up. Waits until both can send, at most 5 s each; usually less than 1 ms.
 * @param socket  connected to NETLINK_ROUTE
 */
int ect_veth_add(struct nl_sock *socket, const char *one, const char *other);

/**
 * Makes a pair in the network of this process, both ends up and without IPv6, and waits as ::ect_veth_add.
 * Needs CAP_NET_ADMIN.
 * @param[out] message  on failure one line for the user, cause and cure; ECT_VETH_MESSAGE bytes
 * @return 0; -1: nothing was made
 */
int ect_veth_create(const char *one, const char *other, char *message);

/** Removes a pair by the name of one of its ends. @return 0; -1: no such pair, or CAP_NET_ADMIN is missing */
int ect_veth_destroy(const char *one);

ECT_C_END

#endif
