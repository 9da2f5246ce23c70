/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Packet sockets of the master that end at the bus in this process.
 *
 * A socket is an eventfd, so that a real poll, select or epoll finds it readable while frames wait; on the virtual
 * clock it becomes so in ::ect_ports_show, which precedes these calls. Descriptors that dup, dup2 and fcntl make of it
 * stand for the same socket.
 */
#ifndef ECT_BUS_INPROCESS_PORTS_H
#define ECT_BUS_INPROCESS_PORTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>
#include <sys/types.h>

typedef struct ect_port ect_port_t;

/** The socket behind a descriptor; NULL: none of ours. Cost: a look into a table. */
ect_port_t *ect_port_of(int fd);

/** Whether a frame waits in it. With the lock. */
bool ect_port_has_frame(const ect_port_t *port);
/** Makes the descriptors of all sockets readable, or not, as frames wait. With the lock. */
void ect_ports_show(void);

/** Makes a socket. @param type as of socket(2) @param protocol network order @return the descriptor; -1 (errno) */
int ect_port_open(int type, int protocol);
/** The descriptor `copy` stands for the socket too; without effect when `fd` is none of ours. */
void ect_port_copied(int fd, int copy);
/** A descriptor is closed. */
void ect_port_closed(int fd);

/** Whether the interface at an end (0, 1) is up, and taking it up or down: a cable that is plugged in or pulled. */
bool ect_port_is_up(unsigned int end);
void ect_port_take(unsigned int end, bool up);

/** The master has set or cleared O_NONBLOCK of a descriptor. */
void ect_port_set_nonblocking(ect_port_t *port, bool on);

/** The functions of a socket with the results of their system calls: -1 and errno on failure. */
int ect_port_bind(ect_port_t *port, const struct sockaddr *address, socklen_t length);
int ect_port_set(ect_port_t *port, int level, int name, const void *value, socklen_t length);
int ect_port_get(ect_port_t *port, int level, int name, void *value, socklen_t *length);
int ect_port_name(ect_port_t *port, struct sockaddr *address, socklen_t *length);
ssize_t ect_port_send(ect_port_t *port, const struct iovec *pieces, size_t count, const struct sockaddr *to);
/** @param flags  MSG_DONTWAIT, MSG_PEEK, MSG_TRUNC @param from  NULL: not wanted */
ssize_t ect_port_receive(ect_port_t *port, const struct iovec *pieces, size_t count, int flags, int *result_flags,
                         struct sockaddr *from, socklen_t *from_length);

#endif
