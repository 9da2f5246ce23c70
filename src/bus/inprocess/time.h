/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The time of the bus in a master's process. Two implementations: real_time.c, in which a thread runs the devices
 * between frames, and virtual_time.c, in which time passes only while every thread waits. Each library has one.
 *
 * Context: any thread of the master. The lock guards the bus and the ports.
 */
#ifndef ECT_BUS_INPROCESS_TIME_H
#define ECT_BUS_INPROCESS_TIME_H

#include <stdbool.h>
#include <stdint.h>

/** Stated cost of a call on the virtual clock, nanoseconds; the real clock has its own. */
enum { ECT_COST_CLOCK_NS = 50, ECT_COST_SOCKET_NS = 1000 };

/** Whether time passes only while every thread waits. */
extern const bool ect_time_is_virtual;

/** Excludes all other users of the bus and the ports. Not recursive. */
void ect_time_lock(void);
void ect_time_unlock(void);

/** The present time; with the lock. */
uint64_t ect_time_now(void);

/** Charges a call to the virtual clock: other threads that become ready by it run before this one goes on. Without
 * the lock. */
void ect_time_charge(uint64_t cost_ns);

/**
 * The master is about to receive from a descriptor that is none of ours, and may have to wait there. Without the lock.
 * @param call   its name
 * @param flags  as of recv(2); MSG_DONTWAIT: it does not wait
 */
void ect_time_before_read(const char *call, int fd, int flags);

/** The master closes a descriptor that is none of ours. Without the lock. */
void ect_time_closed(int fd);

/** The bus has been powered on; with the lock. */
void ect_time_bus_started(void);

/** The bus may want to run earlier than before; with the lock. */
void ect_time_bus_next(uint64_t next_ns);

/**
 * Waits until `ready(arg)`, or a time. With the lock, which is released while waiting.
 * @param fd        readable when `ready` may have become true
 * @param until_ns  ECTWIN_NEVER: no limit
 * @return whether it is ready; false: errno is EAGAIN, or EINTR after a handler without SA_RESTART (virtual clock)
 */
bool ect_time_wait(int fd, bool (*ready)(const void *arg), const void *arg, uint64_t until_ns);

#endif
