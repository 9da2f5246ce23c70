/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bus of this process, powered on when its first socket is bound. Only then is libectwin.so, with the twins,
 * loaded, so that programs without a bus (a shell before the master) are not affected.
 *
 * Environment, set by `ectwin with --in-process`:
 *   ECTWIN_INPROCESS       options and devices, separated by the character 1Fh
 *   ECTWIN_INPROCESS_CWD   base folder of relative paths in the options
 *   ECTWIN_INPROCESS_MARK  file that gets a byte when an interface is opened, even if the bus does not start
 *   ECTWIN_INPROCESS_NET   folder with `up` and `down`: /sys/class/net with the interfaces of the bus in this state
 *
 *   ECTWIN_IFACE, ECTWIN_IFACE2   names of the interfaces
 */
#ifndef ECT_BUS_INPROCESS_BUS_H
#define ECT_BUS_INPROCESS_BUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { ECT_BUS_ENDS = 2 };

/** Interface index of end 0 for the master; end 1 has the next index. */
enum { ECT_BUS_INDEX = 1001 };

/** @return the end (0, 1) of the interface with this name; -1: not an interface of the bus */
int ect_bus_end_of_name(const char *name);
/** @return the end of the interface with this index; -1: not an interface of the bus */
int ect_bus_end_of_index(int index);
/** Name of the interface at an end; NULL: none. */
const char *ect_bus_name(unsigned int end);

/** Gets each frame that leaves the bus at an end. With the lock. */
typedef void ect_bus_deliver_t(unsigned int end, const uint8_t *frame, size_t length);

/**
 * Powers the bus on, once for each process; a child of fork() gets a bus of its own. With the lock.
 * @param deliver  for every frame that leaves the bus from now on
 * @return 1: now powered on; 0: already on; -1: failure, with the reason on standard error
 */
int ect_bus_start(uint64_t now_ns, ect_bus_deliver_t *deliver);
/** @return whether this process has a bus. With the lock. */
bool ect_bus_running(void);
/** Plugs the cable of an end in, or pulls it, as the master takes the interface up or down. With the lock. */
void ect_bus_plug(unsigned int end, bool in, uint64_t now_ns);
/** @return whether the interface of an end is up, its initial state. With the lock. */
bool ect_bus_is_up(unsigned int end);
/** Passes a frame and delivers the replies. With the lock. @return time of the next run of the bus; ECTWIN_NEVER */
uint64_t ect_bus_frame(unsigned int end, const void *frame, size_t length, uint64_t now_ns);
/** Advances the time, and delivers late replies. With the lock. @return as ::ect_bus_frame */
uint64_t ect_bus_run(uint64_t now_ns);
/** Serves one client of the control socket. With the lock. @return whether more work is pending */
bool ect_bus_serve(uint64_t now_ns);
/** @return descriptor of the control socket; -1: none */
int ect_bus_control_fd(void);
/** Ends the bus after finishing its saves. With the lock. */
void ect_bus_end(void);

/** Bytes in the file $ECTWIN_INPROCESS_MARK: an interface was opened; a bus has ended, and all expectations of its
 * scenario are met. */
enum { ECT_BUS_MARK_OPENED = '+', ECT_BUS_MARK_MET = '.' };

#endif
