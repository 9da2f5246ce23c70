/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A bus of twins as a library (libectwin.so): frame in, frame out; time is an argument. No network, no thread, no
 * clock.
 *
 *     char why[ECTWIN_MESSAGE];
 *     ectwin_bus_t *bus = ectwin_bus_open(1, (const char *[]){"fzm1"}, now_ns, why);
 *     ectwin_bus_frame(bus, 0, frame, length, now_ns);
 *     while ((length = ectwin_bus_reply(bus, &end, frame, sizeof frame)) > 0)
 *         ... a frame that leaves the bus at that end ...
 *     next_ns = ectwin_bus_run(bus, now_ns);
 *
 * Times are nanoseconds of any clock that never decreases; a time before that of the previous call counts as the
 * latter. Context: one thread at a time for each bus; buses are independent. Frames begin with the destination address
 * and have no check sum. This header is the stable interface of the library: plain C types only.
 */
#ifndef ECT_BUS_LIBRARY_H
#define ECT_BUS_LIBRARY_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

#define ECTWIN_API __attribute__((visibility("default")))

typedef struct ectwin_bus ectwin_bus_t;

/** A time: no call is necessary before the next frame. */
#define ECTWIN_NEVER UINT64_MAX

/** Longest frame of a bus, bytes. */
enum { ECTWIN_FRAME_MAX = 2048 };

/** Room for a reason, and for a signal's value, with the final zero. */
enum { ECTWIN_MESSAGE = 1280 };

/** The version of the library, "MAJOR.MINOR.PATCH". */
ECTWIN_API const char *ectwin_version(void);

/**
 * Builds a bus and powers it on.
 * @param words   options and devices, as on the command line of `ectwin with` before `--`: {"--set", "data1=1.5",
 *                "fzm1,vr-bu-ect-map7"}; only read during the call
 * @param[out] message  on failure the reason in one line, ECTWIN_MESSAGE bytes; NULL: not wanted
 * @return the bus, to be closed with ::ectwin_bus_close; NULL: a word is invalid, a file cannot be opened, or memory is
 *         exhausted. A call with an invalid word may leak up to 1 KB of memory
 */
ECTWIN_API ectwin_bus_t *ectwin_bus_open(int count, const char *const words[], uint64_t now_ns, char *message);

/** Completes saves, switches the twins off, and frees the bus. NULL: no effect */
ECTWIN_API void ectwin_bus_close(ectwin_bus_t *bus);

/**
 * Switches all twins off and on: the state after ::ectwin_bus_open, except stored values, EEPROMs, cables, faults and
 * the surroundings, which keep their state. The cost is far below that of a new bus. Waiting replies are dropped.
 */
ECTWIN_API void ectwin_bus_power_cycle(ectwin_bus_t *bus, uint64_t now_ns);

/** Number of twins. */
ECTWIN_API size_t ectwin_bus_slaves(const ectwin_bus_t *bus);

/**
 * Plugs a cable in at an end, or pulls it.
 * @param end  0: the input of the first twin (plugged in after ::ectwin_bus_open), 1: the output of the last one
 */
ECTWIN_API void ectwin_bus_link(ectwin_bus_t *bus, unsigned int end, int link, uint64_t now_ns);

/**
 * Passes a frame through the bus, then runs the devices. Replies wait for ::ectwin_bus_reply.
 * @param end     end at which the frame enters, 0 or 1
 * @param length  1..ECTWIN_FRAME_MAX; a longer frame is lost
 * @return as ::ectwin_bus_run; no call of the latter is necessary
 */
ECTWIN_API uint64_t ectwin_bus_frame(ectwin_bus_t *bus, unsigned int end, const void *frame, size_t length,
                                     uint64_t now_ns);

/**
 * Takes the next frame that has left the bus, in order.
 * @param[out] end  end at which the frame left, 0 or 1
 * @return length of the frame, of which `frame` has at most the first `room` bytes; 0: none
 */
ECTWIN_API size_t ectwin_bus_reply(ectwin_bus_t *bus, unsigned int *end, void *frame, size_t room);

/**
 * Advances the time: runs due devices and sends due replies.
 * @return the time of the next call without a frame; ECTWIN_NEVER
 */
ECTWIN_API uint64_t ectwin_bus_run(ectwin_bus_t *bus, uint64_t now_ns);

/**
 * Reads a signal as text.
 * @param slave  1..::ectwin_bus_slaves
 * @return 0; -1: no such slave or signal, or `room` is too small
 */
ECTWIN_API int ectwin_bus_get(const ectwin_bus_t *bus, size_t slave, const char *name, char *text, size_t room);

/**
 * Sets a signal from text.
 * @param[out] message  on failure the reason in one line, at most `room` bytes
 * @return 0; -1: refused, nothing has changed
 */
ECTWIN_API int ectwin_bus_set(ectwin_bus_t *bus, size_t slave, const char *name, const char *value, uint64_t now_ns,
                              char *message, size_t room);

/**
 * Sets a fault, as a line of `--fault` without a condition ("drop 5%", "hang slave 1", "off"; docs/FAULTS.md).
 * @param[out] message  on failure the reason in one line, at most `room` bytes
 * @return 0; -1: refused, nothing has changed
 */
ECTWIN_API int ectwin_bus_fault(ectwin_bus_t *bus, const char *fault, uint64_t now_ns, char *message, size_t room);

/**
 * Ends the scenario of the bus (--scenario, --faults, --fault): expectations that are not yet met have failed.
 * @param[out] text  a line for each expectation, then one for all, at most `room` bytes; empty: no expectations
 * @return the number of expectations that have failed
 */
ECTWIN_API int ectwin_bus_verdict(ectwin_bus_t *bus, char *text, size_t room);

/**
 * Opens the control socket of the bus (docs/CONTROL.md), once.
 * @return a descriptor that is readable when ::ectwin_bus_serve has work; -1, with the reason on standard error
 */
ECTWIN_API int ectwin_bus_control(ectwin_bus_t *bus);

/** Path of the control socket; NULL: not open. Valid until ::ectwin_bus_close. */
ECTWIN_API const char *ectwin_bus_control_path(const ectwin_bus_t *bus);

/**
 * Does one bounded piece of work for the clients of the control socket.
 * @return whether more work is pending
 */
ECTWIN_API int ectwin_bus_serve(ectwin_bus_t *bus, uint64_t now_ns);

ECT_C_END

#endif
