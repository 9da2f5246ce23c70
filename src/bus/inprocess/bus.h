/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bus of this process: powered on when its first socket is bound. The twins come from libectwin.so beside this
 * library, loaded at that moment, so that programs without a bus (a shell before the master) stay as they are.
 *
 * Environment, set by `ectwin with --in-process`:
 *   ECTWIN_INPROCESS       options and devices, separated by the character 1Fh
 *   ECTWIN_INPROCESS_CWD   folder that relative paths in them start from
 *   ECTWIN_INPROCESS_MARK  file that gets a byte when an interface is opened, whether its bus starts or not
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

/** The index that the interface at an end has for the master. */
enum { ECT_BUS_INDEX = 1001 };

/** @return the end (0, 1) of the interface with this name; -1: not one of ours */
int ect_bus_end_of_name(const char *name);
/** @return the end with this index; -1: not one of ours */
int ect_bus_end_of_index(int index);
/** Name of the interface at an end; NULL: none. */
const char *ect_bus_name(unsigned int end);

/** Takes a frame that has left the bus at an end. With the lock. */
typedef void ect_bus_deliver_t(unsigned int end, const uint8_t *frame, size_t length);

/**
 * Powers the bus on, once a process; a child made by fork gets a bus of its own. With the lock.
 * @param deliver  for every frame that leaves the bus from now on
 * @return 1: powered on now; 0: it is on; -1: it cannot be, with the reason on standard error
 */
int ect_bus_start(uint64_t now_ns, ect_bus_deliver_t *deliver);
/** Whether this process has a bus. With the lock. */
bool ect_bus_running(void);
/** Plugs the cable of an end in, or pulls it, as the master takes the interface up or down. With the lock. */
void ect_bus_plug(unsigned int end, bool in, uint64_t now_ns);
/** Whether the interface of an end is up; it is at the start. With the lock. */
bool ect_bus_is_up(unsigned int end);
/** Passes a frame and delivers the replies. With the lock. @return the next time at which the bus runs, ECTWIN_NEVER */
uint64_t ect_bus_frame(unsigned int end, const void *frame, size_t length, uint64_t now_ns);
/** Lets time pass and delivers late replies. With the lock. @return the next time, ECTWIN_NEVER */
uint64_t ect_bus_run(uint64_t now_ns);
/** Serves one client of the control socket. With the lock. @return whether there is more to do */
bool ect_bus_serve(uint64_t now_ns);
/** Descriptor of the control socket; -1. */
int ect_bus_control_fd(void);
/** Ends the bus: saves are finished. With the lock. */
void ect_bus_end(void);

/** Marks in the file that $ECTWIN_INPROCESS_MARK names: an interface has been opened; its bus has ended with all
 * expectations of its scenario met. */
enum { ECT_BUS_MARK_OPENED = '+', ECT_BUS_MARK_MET = '.' };

#endif
