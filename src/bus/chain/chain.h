/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A chain of twins behind one port: software ESCs in a row, each with its slave stack and device.
 *
 * No sockets and no clock in here: frames and times come as arguments, so a test runs a chain in virtual time.
 * Context: one thread for a chain. Host code: memory comes from the heap, once, in ::ect_chain_new.
 */
#ifndef ECT_BUS_CHAIN_CHAIN_H
#define ECT_BUS_CHAIN_CHAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/fault.h"
#include "bus/chain/signals.h"
#include "esc/esc.h"
#include "slave/slave.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** One twin of a chain. */
typedef struct ect_twin_config {
    const ect_device_t *device;   /**< must outlive the chain */
    const ect_plant_t *plant;     /**< as its device; NULL: none */
    ect_identity_t identity;      /**< who it says it is; copied */
    uint16_t alias;               /**< configured station alias and explicit device id; 0 none */
    const ect_storage_t *storage; /**< its non-volatile memory, must outlive the chain; NULL: none */
    /** Content of its EEPROM, of the description's sii_size; copied. NULL: as the description makes it. */
    const uint8_t *sii;
    /** The master has written to the EEPROM: all of its content as it is now, at the next poll. NULL: nobody cares. */
    void (*sii_written)(void *sii_ctx, const uint8_t *sii, uint32_t size);
    void *sii_ctx;
    size_t up;         /**< with up_port not 0: at which slave of the chain, one before it, its input is plugged in */
    uint8_t up_port;   /**< at which port there: 1, 2, 3; 0: at port 1 of the one before */
    uint16_t cable_m;  /**< length of the cable at its input, metres: distributed clocks see it */
    int32_t drift_ppb; /**< what its oscillator is too fast by, up to ECT_ESC_MAX_DRIFT_PPB either way */
    const char *esc;   /**< its chip (esc/personality.h); NULL: the one that the description names */
    bool keep_source_mac; /**< do not set the bit that an ESC sets in the source address */
} ect_twin_config_t;

typedef struct ect_chain ect_chain_t;

/** The description's own choice of everything. */
ect_twin_config_t ect_twin_default(const ect_device_t *device, const ect_plant_t *plant);

/**
 * Builds a chain and powers it on at `now_ns`.
 * @param twins  `count` of them (1..65535), in the order of the wire; of devices that ::ect_device_check accepts, and
 * plugged in as ::ect_chain_check_wires likes it
 * @return the chain, to be freed with ::ect_chain_free, or NULL when memory is short
 */
ect_chain_t *ect_chain_new(const ect_twin_config_t *twins, size_t count, uint64_t now_ns);

void ect_chain_free(ect_chain_t *chain);

/**
 * Whether twins can be wired as their `up` and `up_port` say.
 * @return count: yes; else the first one that cannot: it is plugged in at one that does not come before it, at a port
 * that the chip has not, or where another one is
 */
size_t ect_chain_check_wires(const ect_twin_config_t *twins, size_t count);

/** Takes the power off all twins and puts it back: what stands outside them (ect_plant_t::outside_size) stays. */
void ect_chain_power_cycle(ect_chain_t *chain, uint64_t now_ns);

/** The two ends of a chain: where frames come in and go out. */
typedef enum ect_end {
    ECT_END_IN,   /**< port 0 of the first slave: the master */
    ECT_END_OUT,  /**< port 1 of the last one: nothing, or the master's second interface (cable redundancy) */
    ECT_END_NONE, /**< a frame that goes to none of them is lost */
} ect_end_t;
enum { ECT_ENDS = ECT_END_NONE };

/** Plugs a cable in at an end or pulls it: frames go in and out there only while one is in. First: ECT_END_IN only. */
void ect_chain_set_link(ect_chain_t *chain, ect_end_t end, bool link);

/**
 * Lets a frame travel through the ESCs, from the end where it comes in to the one where it leaves. No device code runs
 * in here.
 *
 * As in the chip, a frame is processed on the way from port 0 to port 1 and only passed on in the other direction. So
 * one that comes in at ECT_END_OUT is processed by nobody while the wires are whole, and leaves at ECT_END_IN. Where a
 * wire is cut, the slave before the cut sends frames back, and the one behind it, which has lost its port 0, processes
 * those that come from ECT_END_OUT, marks them as circulating, and so do the slaves behind it: they leave where they
 * came in (data sheet I §3).
 *
 * @param in  ECT_END_IN or ECT_END_OUT
 * @return the end where to send the changed frame, at the same length if no guard has cut it; ECT_END_NONE: it is lost
 */
ect_end_t ect_chain_pass(ect_chain_t *chain, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns);

/** A frame on a wire: the one at the input of the slave at that position; `count`: the one behind the last slave. */
typedef struct ect_crossing {
    size_t wire;
    bool back; /**< towards the master, and not away from him */
    uint8_t *frame;
    size_t length; /**< may be made less */
    bool damaged;  /**< may be set: its check sum is wrong */
    bool noticed;  /**< a controller has counted it for that */
} ect_crossing_t;

/** Who stands at the wires and may change what comes by. @return whether it goes on; false: it ends here */
typedef bool (*ect_guard_t)(void *ctx, ect_crossing_t *crossing);

/**
 * The next frame that passes is shown to a guard on each wire that it comes by, in their order. What ends there was
 * processed by those before. So was one that is damaged there, and those behind count it (0x0300, 0x0308, 0x030C) and
 * do not execute it; it comes back to nobody.
 */
void ect_chain_guard(ect_chain_t *chain, ect_guard_t guard, void *ctx);

/**
 * Lets a frame that has ended on a wire go on from there, at a later time.
 * @return as ::ect_chain_pass; ECT_END_NONE also when the wire is not there any more
 */
ect_end_t ect_chain_go_on(ect_chain_t *chain, const ect_crossing_t *from, uint64_t now_ns);

/**
 * Does to a slave what a fault says, at once.
 * @param fault  one that is not of frames (::ect_fault_is_of_frames), of a slave that there is
 */
void ect_chain_fault(ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns);

/** ::ect_chain_pass for a chain with one end. @return whether the frame comes back */
bool ect_chain_process(ect_chain_t *chain, uint8_t *frame, size_t length, uint64_t now_ns);

/**
 * Lets the slaves and devices do what the last frames and the time ask of them.
 * @return when to call again if no frame comes first; ECT_NEVER
 */
uint64_t ect_chain_poll(ect_chain_t *chain, uint64_t now_ns);

/** @return whether a twin has something under way that must not be cut off (ect_plant_t::unfinished): poll on */
bool ect_chain_unfinished(const ect_chain_t *chain);

size_t ect_chain_count(const ect_chain_t *chain);

/**
 * Brings the lamps of a twin up to date, for those who hold on to their signals: they are made when they are looked for
 * (::ect_chain_signal, ::ect_chain_next_signal), and when they are asked for here. Cost: a comparison.
 */
void ect_chain_show_lamps(const ect_chain_t *chain, size_t position);

/** How far a walk through the signals of a twin has come. Zeroed: at its beginning. */
typedef struct ect_chain_cursor {
    ect_signal_cursor_t device, lamps, wiring;
} ect_chain_cursor_t;

/** As ect_signals_next, for the device of a twin, then its lamps and its plugs (`ecat.*`). */
bool ect_chain_next_signal(const ect_chain_t *chain, size_t position, ect_chain_cursor_t *cursor,
                           ect_signal_ref_t *ref);
/** @return whether a twin has a signal of exactly that name; then *ref is set */
bool ect_chain_signal(const ect_chain_t *chain, size_t position, const char *name, ect_signal_ref_t *ref);
/**
 * The Modbus side of a twin as it is at this moment, for one request. Whoever writes there, or reads, wakes the twin
 * (::ect_chain_wake).
 * @param[out] instance  what its functions work on
 * @return NULL: it has none, or nobody answers: the twin is off the bus, or its microcontroller stands still
 */
const ect_modbus_t *ect_chain_modbus(const ect_chain_t *chain, size_t position, void **instance);
/** What ect_plant_t::bulk gives for a twin; `data` is NULL when it has no such thing. */
ect_bulk_t ect_chain_bulk(const ect_chain_t *chain, size_t position);
/**
 * Keeps a copy of what signals can change in a twin, for ::ect_chain_put_back. @return false: no memory
 */
bool ect_chain_keep(ect_chain_t *chain, size_t position);
/** Takes back what signals have done to a twin since ::ect_chain_keep of the same position. No poll in between. */
void ect_chain_put_back(ect_chain_t *chain, size_t position);
/**
 * Lets the slave at a position look at its device again at the next poll: something was done to it from outside. Cost:
 * a look at its plugs; when one of them is in or out now and was not, the next poll looks at those of all twins.
 */
void ect_chain_wake(ect_chain_t *chain, size_t position);
const ect_slave_t *ect_chain_slave(const ect_chain_t *chain, size_t position);
/** Its controller; whoever does something to it does so before the next poll. */
ect_esc_t *ect_chain_esc(ect_chain_t *chain, size_t position);

ECT_C_END

#endif
