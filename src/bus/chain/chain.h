/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A chain of twins behind one port: software ESCs, each with its slave stack and device, wired as a line, ring or tree.
 *
 * A program passes each frame to the chain (::ect_chain_pass), sends the reply, and then runs the devices
 * (::ect_chain_poll):
 *
 *     ect_twin_config_t twin = ect_twin_default(entry->device, entry->plant);
 *     ect_chain_t *chain = ect_chain_new(&twin, 1, now_ns);
 *     if (ect_chain_process(chain, frame, length, now_ns))
 *         send(frame, length);
 *     uint64_t next_ns = ect_chain_poll(chain, now_ns);
 *
 * This file uses no sockets and no clock. Frames and times are arguments; times are nanoseconds of any clock that never
 * decreases, real or virtual. Context: one thread at a time for each chain; chains are independent of each other.
 * Memory comes from the heap in ::ect_chain_new, for a copy of a twin's state in ::ect_chain_keep; ::ect_chain_set_link
 * and ::ect_chain_poll allocate one byte for each twin during the call when a link changes. `position` is that of a
 * twin on the wire, 0..::ect_chain_count - 1; another value is a mistake of the caller.
 */
#ifndef ECT_BUS_CHAIN_CHAIN_H
#define ECT_BUS_CHAIN_CHAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/connect.h"
#include "bus/chain/crossing.h"
#include "bus/chain/fault.h"
#include "bus/chain/names.h"
#include "bus/chain/signals.h"
#include "bus/chain/twin_config.h"
#include "esc/esc.h"
#include "slave/slave.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_chain ect_chain_t;

/**
 * Builds a chain and powers it on at `now_ns`. A cable is plugged in at ECT_END_IN, none at ECT_END_OUT.
 * @param twins  `count` of them (1..65535), in the order of the wire; copied. ::ect_chain_check_wires accepts them
 * @return the chain, to be freed with ::ect_chain_free; NULL: out of memory, an unknown chip, or impossible wires
 */
ect_chain_t *ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns);

/** Frees a chain. NULL: no effect */
void ect_chain_free(ect_chain_t *chain);

/**
 * Checks whether twins can be wired according to `up` and `up_port`.
 * @return count: possible, or memory is exhausted; else the position of the first invalid twin: `up` is not less than
 * its own position, the chip of `up` has no port `up_port`, or another twin is wired to that port
 */
size_t ect_chain_check_wires(const ect_twin_config_t *twins, size_t count);

/**
 * Finds the wire at port 0 of a twin.
 * @param[out] port  port of the previous twin at which the wire begins, 1..3; 0: at the master
 * @return number of the previous twin, from 1; 0: the master
 */
size_t ect_chain_wire(const ect_chain_t *chain, size_t position, unsigned int *port);

/**
 * Calls `block` for each large block of memory that every frame and every run of the devices use: the twins, and the
 * RAM of their ESCs. A caller can advise the system about these; their content must not change.
 */
void ect_chain_memory(const ect_chain_t *chain, void (*block)(void *ctx, void *at, size_t size), void *ctx);

/** Switches all twins off and on: only their surroundings (ect_plant_t::outside_size) keep their state. */
void ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns);

/** Plugs in or pulls a cable at an end (ECT_END_IN, ECT_END_OUT). Frames enter and leave only at ends with a cable.
 */
void ect_chain_set_link(ect_chain_t *chain, ect_end_t end, bool link);

/**
 * Passes a frame through the ESCs, from the end where it enters to the end where it leaves. No device code runs.
 *
 * As in the chip, the ESC processes a frame on the way from port 0 to port 1 and only forwards it in the other
 * direction. A frame that enters at ECT_END_OUT is therefore processed by no slave while all wires are intact, and
 * leaves at ECT_END_IN. The slave before a cut wire sends frames back. The slave behind the cut, without link at port
 * 0, processes frames from ECT_END_OUT and marks them as circulating, as do all slaves behind it; these frames leave at
 * the end where they entered (data sheet I §3).
 *
 * @param in  ECT_END_IN or ECT_END_OUT
 * @param frame  changed in place; from the destination address on, without the check sum
 * @param length  bytes of the frame; the length changes only if a guard reduces it
 * @return the end where the caller sends the frame; ECT_END_NONE: the frame is lost
 *
 * Cost: for plain frames on a line (bus/chain/fast.h), each datagram and the ESCs that take part in it; else every ESC
 * on the way.
 */
ect_end_t ect_chain_pass(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns);

/**
 * ::ect_chain_pass at ECT_END_IN for a frame whose reply has left already (bus/kernel): with all effects on the slaves.
 * Afterwards the frame has the reply's headers and working counters; images may be missing.
 */
void ect_chain_pass_replied(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns);

/** ::ect_chain_pass for a chain with one end. @return whether the frame returns */
bool ect_chain_process(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns);

/**
 * Passes the next frame, and no other, to a guard on each wire that the frame crosses. ESCs before the wire on which a
 * guard ends or damages the frame have processed the frame. ESCs behind the wire on which the frame is damaged count
 * the error (0x0300, 0x0308, 0x030C) and do not execute the frame, which is lost at the end.
 * @param guard  NULL: none
 */
void ect_chain_guard(ect_chain_t *chain, ect_guard_t guard, void *ctx);

/**
 * Continues with a frame that a guard has ended, from the wire where the guard ended it.
 * @return as ::ect_chain_pass; ECT_END_NONE also when the wire has lost link
 */
ect_end_t ect_chain_resume(ect_chain_t *chain, const ect_crossing_t *from, uint64_t now_ns);

/**
 * Executes a fault of a slave at once, or sets a lasting one above the wire (::ect_fault_is_above_wire).
 * @param fault  not a fault of frames (::ect_fault_is_of_frames); `slave` is 1..::ect_chain_count
 * @return NULL: done; else the reason of a refusal, without the name of the slave: no lower state, no emergencies,
 *         eight faults above the wire are set, no memory
 */
const char *ect_chain_fault(ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns);

/** Ends the faults above the wire with this tag (ect_fault_t::tag), in all twins; 0: all except ECT_FAULT_COUNT. */
void ect_chain_fault_end(ect_chain_t *chain, uint32_t tag);

/** @return the i-th fault above the wire that is set, from 0, in the order of the twins; NULL: none */
const ect_fault_t *ect_chain_fault_at(const ect_chain_t *chain, size_t i);

/** @return the number of SDO transfers counted by the faults above the wire with this tag, in all twins */
uint64_t ect_chain_fault_seen(const ect_chain_t *chain, uint32_t tag);

/**
 * Runs the slave stacks and devices that are due after a frame, a change of a signal, or by time.
 * @return time of the next call without a frame; ECT_NEVER: not before a frame
 */
uint64_t ect_chain_poll(ect_chain_t *chain, uint64_t now_ns);

/**
 * @return whether ::ect_chain_poll is due before a frame: a slave that takes part in it has yet to run since an earlier
 * frame. True, too, for a frame with other datagrams than LRD, LWR, LRW, and BRD of AL status. Cost: as
 * ::ect_chain_pass, without the slaves.
 */
bool ect_chain_awaits_poll(ect_chain_t *chain, const uint8_t *frame, size_t length);

/**
 * As ::ect_chain_poll, before a past frame whose reply has already left passes the chain: slaves take outputs and the
 * time advances; input images are unchanged until the next ::ect_chain_poll, because the master has read these.
 */
uint64_t ect_chain_catch_up(ect_chain_t *chain, uint64_t now_ns);

/**
 * Connects signals of the twins, and replaces earlier connections. The next poll begins with the connections.
 * @param list  of signals of this chain, as for ::ect_connections_new
 * @return false: no memory; nothing has changed
 */
bool ect_chain_connect(ect_chain_t *chain, const ect_connection_t *list, size_t count);

/** Observers of the runs of twins: clients of the control socket, and plans (bus/kernel). */
typedef enum ect_chain_observer { ECT_CHAIN_CLIENTS, ECT_CHAIN_PLANS, ECT_CHAIN_OBSERVERS } ect_chain_observer_t;

/**
 * Sets the function of an observer, which ::ect_chain_poll calls for each twin after the twin's run. The function must
 * not change the chain.
 * @param ran  NULL, the initial value: none
 */
void ect_chain_observe(ect_chain_t *chain, ect_chain_observer_t observer,
                       void (*ran)(void *ctx, size_t position, uint64_t now_ns), void *ctx);

/** @return whether a twin has work that must be completed (ect_plant_t::unfinished): poll until false before freeing */
bool ect_chain_unfinished(const ect_chain_t *chain);

/** @return the number of twins. */
size_t ect_chain_count(const ect_chain_t *chain);

/**
 * Updates the lamps of a twin, for a caller that keeps references to their signals. Not necessary before
 * ::ect_chain_signal and ::ect_chain_next_signal. Cost: a comparison without a change.
 */
void ect_chain_show_lamps(const ect_chain_t *chain, size_t position);

/**
 * Names the twins. A name must not be the first part of the name of a signal, as `ru1` in `ru1.on`, because it would
 * hide the signal.
 * @param names         must outlive the chain; NULL: no twin has a name
 * @param[out] message  on failure the reason, one line; ECT_SIGNAL_MESSAGE bytes
 * @return false: a name hides a signal; the names are unchanged
 */
bool ect_chain_set_names(ect_chain_t *chain, const ect_names_t *names, char *message);

/** @return the names of the twins; NULL: no twin has a name. */
const ect_names_t *ect_chain_names(const ect_chain_t *chain);

/**
 * Separates the name of a twin from the name of a signal: "gripper.data1" is "data1" of the twin "gripper".
 * @param[in,out] position  set to that of the twin
 * @param[in,out] name      set to the text after the dot
 * @return whether the text begins with the name of a twin and a dot; if not, nothing has changed
 */
bool ect_chain_resolve(const ect_chain_t *chain, size_t *position, const char **name);

/** Position in the list of a twin's signals. Zeroed: before the first. */
typedef struct ect_chain_cursor {
    ect_signal_cursor_t device, beside, lamps, wiring, shown;
} ect_chain_cursor_t;

/**
 * Adds signals of the bus to those of the first twin.
 * @param plant, instance  must outlive the chain; read-only signals. NULL: none
 */
void ect_chain_show(ect_chain_t *chain, const ect_plant_t *plant, void *instance);

/**
 * ::ect_signals_next for the device of a twin, then for ect_twin_config_t::beside, for its lamps and wiring
 * (ecat.NAME), and for the signals of the bus.
 */
bool ect_chain_next_signal(const ect_chain_t *chain, size_t position, ect_chain_cursor_t *cursor,
                           ect_signal_ref_t *ref);

/**
 * Finds a signal of a twin by its exact name; "gripper.data1" is found at any position (::ect_chain_resolve).
 * @return whether the signal exists; *ref is set on true, and valid as long as the chain
 */
bool ect_chain_signal(const ect_chain_t *chain, size_t position, const char *name, ect_signal_ref_t *ref);

/**
 * Returns the Modbus side of a twin, for one request. The caller calls ::ect_chain_wake after the request.
 * @param[out] instance  argument of its functions
 * @return NULL: the device has no Modbus side, the twin is switched off, or its microcontroller hangs
 */
const ect_modbus_t *ect_chain_modbus(const ect_chain_t *chain, size_t position, void **instance);

/**
 * Returns the slave stack of a twin, for ::ect_slave_upload and ::ect_slave_download. The caller calls ::ect_chain_wake
 * afterwards.
 * @param[out] why  with NULL the reason, one line
 * @return NULL: the device has no SDO, the twin is switched off, or its microcontroller hangs
 */
ect_slave_t *ect_chain_sdo(ect_chain_t *chain, size_t position, const char **why);

/** @return ect_plant_t::bulk of a twin; `data` is NULL if the plant has none. */
ect_bulk_t ect_chain_bulk(const ect_chain_t *chain, size_t position);

/** Saves the state of a twin that signals can change, for ::ect_chain_put_back. @return false: out of memory */
bool ect_chain_keep(ect_chain_t *chain, size_t position);

/** Restores the state saved by the last ::ect_chain_keep of this position. No poll is permitted in between. */
void ect_chain_put_back(ect_chain_t *chain, size_t position);

/**
 * Makes the next poll run the twin: its signals, instance or wiring were changed from outside. Cost: a check of four
 * plugs; if the link of one has changed, the next poll updates the links of all twins.
 */
void ect_chain_wake(ect_chain_t *chain, size_t position);

/**
 * @param alias  1 to 65535
 * @return number, from 1, of the first twin with this configured station alias (0012h) or explicit device id; 0: none
 */
size_t ect_chain_find_alias(const ect_chain_t *chain, uint16_t alias);

/** @return the slave stack of a twin, valid as long as the chain. */
const ect_slave_t *ect_chain_slave(const ect_chain_t *chain, size_t position);

/** @return the ESC of a twin, for reading or changing until the next call of the chain. */
ect_esc_t *ect_chain_esc(ect_chain_t *chain, size_t position);

ECT_C_END

#endif
