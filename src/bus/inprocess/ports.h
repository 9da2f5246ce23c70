/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Packet sockets of the master that are connected to the bus in this process.
 *
 * Each socket is an eventfd (eventfds.h), readable for the real poll, select or epoll while frames wait; on the virtual
 * clock ::ect_ports_show, called before these functions, makes it readable. A thread that waits in ::ect_port_receive
 * keeps a closed socket until it returns, as the kernel does.
 */
#ifndef ECT_BUS_INPROCESS_PORTS_H
#define ECT_BUS_INPROCESS_PORTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>
#include <sys/types.h>

typedef struct ect_port ect_port_t;

/** @return the socket of a descriptor; NULL: not a socket of the bus. Cost: one access to a table. */
ect_port_t *ect_port_of(int fd);

/** @return whether a frame can be received. With the lock. */
bool ect_port_has_frame(const ect_port_t *port);
/** Updates the readability of the descriptors of all sockets. With the lock. */
void ect_ports_show(void);

/** Creates a socket. @param type as in socket(2) @param protocol in network order @return the descriptor; -1 (errno) */
int ect_port_open(int type, int protocol);

/** State of the interface at an end (0, 1). Up and down also plug in and pull the cable. */
bool ect_port_is_up(unsigned int end);
void ect_port_take(unsigned int end, bool up);

/** Sets or clears O_NONBLOCK. */
void ect_port_set_nonblocking(ect_port_t *port, bool on);

/** Socket functions, with results as those of the system calls: -1 and errno on failure. Addresses are the program's
 * (user.h): a bad one gives EFAULT. */
int ect_port_bind(ect_port_t *port, const struct sockaddr *address, socklen_t length);
int ect_port_set(ect_port_t *port, int level, int name, const void *value, socklen_t length);
int ect_port_get(ect_port_t *port, int level, int name, void *value, socklen_t *length);
int ect_port_name(ect_port_t *port, struct sockaddr *address, socklen_t *length);
ssize_t ect_port_send(ect_port_t *port, const struct iovec *pieces, size_t count, const struct sockaddr *to,
                      socklen_t to_length);
/** @param flags  MSG_DONTWAIT, MSG_PEEK, MSG_TRUNC @param[out] result_flags  not the program's @param from  NULL: not
 * wanted */
ssize_t ect_port_receive(ect_port_t *port, const struct iovec *pieces, size_t count, int flags, int *result_flags,
                         struct sockaddr *from, socklen_t *from_length);

#endif
