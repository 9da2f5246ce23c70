/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Included before each source of the master (-include): redirects its system calls to wire.c.
 */
#ifndef FUZZ_MASTER_CALLS_H
#define FUZZ_MASTER_CALLS_H

#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

int wire_socket(int domain, int type, int protocol);
int wire_setsockopt(int fd, int level, int option, const void *value, socklen_t length);
int wire_ioctl(int fd, unsigned long request, ...);
int wire_bind(int fd, const struct sockaddr *address, socklen_t length);
ssize_t wire_send(int fd, const void *data, size_t length, int flags);
ssize_t wire_recv(int fd, void *data, size_t room, int flags);
int wire_close(int fd);
int wire_clock_gettime(clockid_t clock, struct timespec *time);
int wire_gettimeofday(struct timeval *time, void *zone);
int wire_nanosleep(const struct timespec *time, struct timespec *left);
int wire_usleep(useconds_t time);

#ifndef FUZZ_MASTER_WIRE
#define socket        wire_socket
#define setsockopt    wire_setsockopt
#define ioctl         wire_ioctl
#define bind          wire_bind
#define send          wire_send
#define recv          wire_recv
#define close         wire_close
#define clock_gettime wire_clock_gettime
#define gettimeofday  wire_gettimeofday
#define nanosleep     wire_nanosleep
#define usleep        wire_usleep
#endif

#endif
