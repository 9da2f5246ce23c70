/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The time of the bus in a master's process, with two implementations: real_time.c, in which a thread runs the devices
 * between frames, and threads.c, in which time advances only while every thread waits. Each library contains one of
 * them.
 *
 * Context: any thread of the master. The lock guards the bus and the ports.
 */
#ifndef ECT_BUS_INPROCESS_TIME_H
#define ECT_BUS_INPROCESS_TIME_H

#include <stdbool.h>
#include <stdint.h>

/** Cost of a call on the virtual clock, nanoseconds. */
enum { ECT_COST_CLOCK_NS = 50, ECT_COST_SOCKET_NS = 1000 };

/** True: time advances only while every thread waits. */
extern const bool ect_time_is_virtual;

/** Excludes all other users of the bus and the ports, defers the program's handlers in this thread, and its
 * cancellation (actions.h). Not recursive. */
void ect_time_lock(void);
void ect_time_unlock(void);

/** The present time; with the lock. */
uint64_t ect_time_now(void);

/** Advances the virtual clock by the cost of a call: threads that become ready meanwhile run first. Without the lock.
 * */
void ect_time_charge(uint64_t cost_ns);

/**
 * Called before the master receives from a descriptor that is not of the bus, where it may block: waits on the virtual
 * clock. Without the lock.
 * @param call   name of the function
 * @param flags  as of recv(2); MSG_DONTWAIT: non-blocking
 * @return true: the master receives now; false: the call ends with errno, EINTR, as of ::ect_time_wait
 */
bool ect_time_before_read(const char *call, int fd, int flags);

/** Called after the power-on of the bus. With the lock. */
void ect_time_bus_started(void);

/** Called when the next run of the bus may be earlier than before. With the lock. */
void ect_time_bus_next(uint64_t next_ns);

/**
 * Waits until `ready(arg)`, or a time. With the lock, which is released while waiting: the real clock's wait is a
 * cancellation point without the lock.
 * @param fd        readable when `ready` may be true
 * @param until_ns  ECTWIN_NEVER: no limit
 * @return true: ready; false: errno is EAGAIN, or EINTR after a handler without SA_RESTART, and after each handler if
 * there is a time
 */
bool ect_time_wait(int fd, bool (*ready)(const void *arg), const void *arg, uint64_t until_ns);

#endif
