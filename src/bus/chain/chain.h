/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A chain of twins behind one port: software ESCs, each with its slave stack and device, wired as a line, ring or tree.
 *
 * A program passes each frame to the chain (::ect_chain_pass), sends what comes back, and then lets the devices run
 * (::ect_chain_poll):
 *
 *     ect_twin_config_t twin = ect_twin_default(entry->device, entry->plant);
 *     ect_chain_t *chain = ect_chain_new(&twin, 1, now_ns);
 *     if (ect_chain_process(chain, frame, length, now_ns))
 *         send(frame, length);
 *     uint64_t next_ns = ect_chain_poll(chain, now_ns);
 *
 * There are no sockets and no clock in here. Frames and times are arguments; times are nanoseconds of any clock that
 * never goes back, real or virtual. Context: one thread at a time for a chain; chains are independent of each other.
 * Memory comes from the heap in ::ect_chain_new, a copy of a twin's state in ::ect_chain_keep; ::ect_chain_set_link
 * and ::ect_chain_poll allocate one byte for each twin during the call when a link changes. `position` is that of a
 * twin on the wire, 0..::ect_chain_count - 1; any other one is a mistake of the caller.
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
 * @return the chain, to be freed with ::ect_chain_free; NULL: out of memory, an unknown chip, or wires that cannot be
 */
ect_chain_t *ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns);

/** Frees a chain. NULL: no effect */
void ect_chain_free(ect_chain_t *chain);

/**
 * Checks whether twins can be wired as `up` and `up_port` name it.
 * @return count: they can, or memory is short; else the position of the first twin that cannot: `up` is not less than
 * its own position, the chip there has no port `up_port`, or another twin is wired to it
 */
size_t ect_chain_check_wires(const ect_twin_config_t *twins, size_t count);

/**
 * The wire at port 0 of a twin.
 * @param[out] port  port of the twin before at which the wire begins, 1..3; 0: at the master
 * @return number of the twin before, from 1; 0: the master
 */
size_t ect_chain_wire(const ect_chain_t *chain, size_t position, unsigned int *port);

/** Switches all twins off and on: only their surroundings (ect_plant_t::outside_size) keep their state. */
void ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns);

/** Plugs a cable in at an end (ECT_END_IN, ECT_END_OUT) or pulls it. Frames enter and leave only at ends with a cable.
 */
void ect_chain_set_link(ect_chain_t *chain, ect_end_t end, bool link);

/**
 * Passes a frame through the ESCs, from the end where it enters to the one where it leaves. No device code runs.
 *
 * As in the chip, the ESC processes a frame on the way from port 0 to port 1 and only forwards it in the other
 * direction. A frame that enters at ECT_END_OUT is therefore processed by no slave while all wires are whole, and
 * leaves at ECT_END_IN. The slave before a cut wire sends frames back. The slave behind it, which has lost link at port
 * 0, processes frames from ECT_END_OUT and marks them as circulating, as do all slaves behind it; these frames leave
 * where they entered (data sheet I §3).
 *
 * @param in  ECT_END_IN or ECT_END_OUT
 * @param frame  changed in place; from the destination address on, without the check sum
 * @param length  bytes of the frame; the length changes only if a guard reduces it
 * @return the end where the caller sends the frame; ECT_END_NONE: it is lost
 *
 * Cost: the datagrams, and for each the ESCs that take part in it, on a line and for plain frames (bus/chain/fast.h);
 * else every ESC on the way.
 */
ect_end_t ect_chain_pass(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns);

/** ::ect_chain_pass for a chain with one end. @return whether the frame comes back */
bool ect_chain_process(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns);

/**
 * Shows the next frame, and no other, to a guard on each wire that it crosses. ESCs before the wire on which a guard
 * ends or damages the frame have processed it. ESCs behind the wire on which it is damaged count it (0x0300, 0x0308,
 * 0x030C) and do not execute it, and the frame is lost at the end.
 * @param guard  NULL: none
 */
void ect_chain_guard(ect_chain_t *chain, ect_guard_t guard, void *ctx);

/**
 * Passes on a frame that a guard has ended, from the wire where it ended.
 * @return as ::ect_chain_pass; ECT_END_NONE also when the wire has no link any more
 */
ect_end_t ect_chain_resume(ect_chain_t *chain, const ect_crossing_t *from, uint64_t now_ns);

/**
 * Carries out a fault of a slave at once, or sets one above the wire (::ect_fault_is_above_wire), which lasts.
 * @param fault  not one of frames (::ect_fault_is_of_frames); `slave` is 1..::ect_chain_count
 * @return NULL: done; else the reason of a refusal, without the name of the slave: no lower state, no emergencies,
 *         eight faults above the wire already, no memory
 */
const char *ect_chain_fault(ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns);

/** Ends the faults above the wire with this tag (ect_fault_t::tag), in all twins; 0: all but ECT_FAULT_COUNT. */
void ect_chain_fault_end(ect_chain_t *chain, uint32_t tag);

/** @return the i-th fault above the wire that is set, from 0, in the order of the twins; NULL: there is none */
const ect_fault_t *ect_chain_fault_at(const ect_chain_t *chain, size_t i);

/** @return the number of SDO transfers that the faults above the wire with this tag have seen, in all twins */
uint64_t ect_chain_fault_seen(const ect_chain_t *chain, uint32_t tag);

/**
 * Runs the slave stacks and devices that a frame, a signal or the time concerns.
 * @return when to call again if no frame comes first; ECT_NEVER: not before
 */
uint64_t ect_chain_poll(ect_chain_t *chain, uint64_t now_ns);

/**
 * As ::ect_chain_poll, before a frame of the past passes whose reply has left: slaves take outputs and the time passes,
 * but input images stay as they are until the next ::ect_chain_poll, since the master has not read newer ones.
 */
uint64_t ect_chain_catch_up(ect_chain_t *chain, uint64_t now_ns);

/**
 * Connects signals of the twins; the connections replace earlier ones. The next poll runs them first.
 * @param list  of signals of this chain, as for ::ect_connections_new
 * @return false: no memory; nothing has changed
 */
bool ect_chain_connect(ect_chain_t *chain, const ect_connection_t *list, size_t count);

/**
 * Sets a function that ::ect_chain_poll calls for each twin after it has run. It must not change the chain.
 * @param ran  NULL, the initial value: none
 */
void ect_chain_observe(ect_chain_t *chain, void (*ran)(void *ctx, size_t position, uint64_t now_ns), void *ctx);

/** @return whether a twin does work that must not be cut off (ect_plant_t::unfinished); then poll on before freeing */
bool ect_chain_unfinished(const ect_chain_t *chain);

/** The number of twins. */
size_t ect_chain_count(const ect_chain_t *chain);

/**
 * Updates the lamps of a twin, for a caller that keeps references to their signals. ::ect_chain_signal and
 * ::ect_chain_next_signal do so by themselves. Cost: a comparison when nothing has changed.
 */
void ect_chain_show_lamps(const ect_chain_t *chain, size_t position);

/**
 * Names the twins. No name is the first part of a name of a signal, as `ru1` is of `ru1.on`: it would hide the signal.
 * @param names         must outlive the chain; NULL: no twin has a name
 * @param[out] message  on failure the reason, one line; ECT_SIGNAL_MESSAGE bytes
 * @return false: a name hides a signal; the names are as before
 */
bool ect_chain_set_names(ect_chain_t *chain, const ect_names_t *names, char *message);

/** The names of the twins; NULL: no twin has one. */
const ect_names_t *ect_chain_names(const ect_chain_t *chain);

/**
 * Takes the name of a twin off the name of a signal: "gripper.data1" is "data1" of the twin "gripper".
 * @param[in,out] position  set to that of the twin
 * @param[in,out] name      set to the text behind the dot
 * @return whether the text begins with the name of a twin and a dot; if not, nothing has changed
 */
bool ect_chain_resolve(const ect_chain_t *chain, size_t *position, const char **name);

/** Position in the list of a twin's signals. Zeroed: before the first. */
typedef struct ect_chain_cursor {
    ect_signal_cursor_t device, beside, lamps, wiring, shown;
} ect_chain_cursor_t;

/**
 * Adds signals of the bus to those of the first twin.
 * @param plant, instance  must outlive the chain; signals that can be read only. NULL: none
 */
void ect_chain_show(ect_chain_t *chain, const ect_plant_t *plant, void *instance);

/**
 * ::ect_signals_next for the device of a twin, then for ect_twin_config_t::beside, its lamps and wiring (ecat.NAME),
 * and the signals of the bus.
 */
bool ect_chain_next_signal(const ect_chain_t *chain, size_t position, ect_chain_cursor_t *cursor,
                           ect_signal_ref_t *ref);

/**
 * Finds a signal of a twin by its exact name; "gripper.data1" is found whatever the position is (::ect_chain_resolve).
 * @return whether there is one; then sets *ref, valid with the chain
 */
bool ect_chain_signal(const ect_chain_t *chain, size_t position, const char *name, ect_signal_ref_t *ref);

/**
 * The Modbus side of a twin, for one request. The caller calls ::ect_chain_wake after the request.
 * @param[out] instance  argument of its functions
 * @return NULL: the device has none, the twin is switched off, or its microcontroller hangs
 */
const ect_modbus_t *ect_chain_modbus(const ect_chain_t *chain, size_t position, void **instance);

/**
 * The slave stack of a twin, for ::ect_slave_upload and ::ect_slave_download. The caller calls ::ect_chain_wake
 * afterwards.
 * @param[out] why  with NULL the reason, one line
 * @return NULL: the device has no SDO, the twin is switched off, or its microcontroller hangs
 */
ect_slave_t *ect_chain_sdo(ect_chain_t *chain, size_t position, const char **why);

/** ect_plant_t::bulk of a twin; `data` is NULL when the plant has none. */
ect_bulk_t ect_chain_bulk(const ect_chain_t *chain, size_t position);

/** Saves what signals can change in a twin, for ::ect_chain_put_back. @return false: out of memory */
bool ect_chain_keep(ect_chain_t *chain, size_t position);

/** Restores the state saved by the last ::ect_chain_keep of this position. No poll in between. */
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

/** The slave stack of a twin, valid with the chain. */
const ect_slave_t *ect_chain_slave(const ect_chain_t *chain, size_t position);

/** The ESC of a twin, for reading or changing until the next call of the chain. */
ect_esc_t *ect_chain_esc(ect_chain_t *chain, size_t position);

ECT_C_END

#endif
