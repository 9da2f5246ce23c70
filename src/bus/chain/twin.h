/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One twin: a software ESC with its slave stack, device, lamps and surroundings. Internal to bus/chain.
 *
 * This file uses no clock; memory comes from the heap, once, in ::ect_twin_make. Context: the thread of the chain.
 */
#ifndef ECT_BUS_CHAIN_TWIN_H
#define ECT_BUS_CHAIN_TWIN_H

#include <stdalign.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/above.h"
#include "bus/chain/fault.h"
#include "bus/chain/lamps.h"
#include "bus/chain/signals.h"
#include "bus/chain/slow.h"
#include "bus/chain/topology.h"
#include "bus/chain/twin_config.h"
#include "bus/chain/wiring.h"
#include "esc/esc.h"
#include "slave/slave.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Limit of memory blocks of a twin. */
enum { ECT_TWIN_BLOCKS = 10 };

/** Bytes of a line of most processors' caches. */
enum { ECT_TWIN_LINE = 64 };

/**
 * A twin. The members from `pdi` to `slave_ns` are those that each run uses: they fill a line of the cache, and place
 * the configuration of the slave at the beginning of one.
 */
typedef struct ect_twin {
    alignas(ECT_TWIN_LINE) ect_esc_t esc;
    alignas(ECT_TWIN_LINE) ect_pdi_t pdi;
    ect_above_t *above; /* faults above the wire; NULL: none yet */
    ect_wiring_t wiring;
    uint32_t ports_seen; /* ect_esc_port_changes() that the propagation delays include */
    uint32_t seen;       /* ect_esc_activity() that the slave stack has handled */
    uint32_t sii_seen;   /* ect_esc_sii_writes() that config.sii_written has reported */
    ect_slow_t *slow;    /* NULL: no delays */
    uint64_t esc_ns;     /* deadline that the ESC returned at its last tick */
    uint64_t slave_ns;   /* deadline of the slave stack */
    ect_slave_t slave;
    bool link[ECT_TOPOLOGY_PORTS]; /* link state of the ports, as set in the ESC */
    ect_lamps_t *lamps;
    uint64_t last_frame_ns; /* time of the last frame, except those of the fast path */
    uint8_t *esc_memory;
    uint8_t *buffer; /* NULL: the device needs none */
    ect_twin_config_t config;
    void *memory[ECT_TWIN_BLOCKS]; /* every block allocated for this twin */
    size_t blocks;
} ect_twin_t;

/** Finds the chip of a twin. @return NULL: no such chip */
const ect_esc_personality_t *ect_twin_chip(const ect_twin_config_t *config);

/** @return bytes that a twin needs for the memory of its ESC. */
size_t ect_twin_ram_size(const ect_twin_config_t *config);

/** @return bytes that a twin needs for the buffer of its device; 0: none. */
size_t ect_twin_buffer_size(const ect_twin_config_t *config);

/**
 * Builds a twin and powers it on.
 * @param twin    zeroed, except `link`
 * @param ram     ::ect_twin_ram_size zeroed bytes that outlive the twin
 * @param buffer  ::ect_twin_buffer_size zeroed bytes that outlive the twin; not accessed if this is 0
 * @return false: out of memory, or no such chip; ::ect_twin_free frees the rest
 */
bool ect_twin_make(ect_twin_t *twin, const ect_twin_config_t *config, uint8_t *ram, uint8_t *buffer, uint64_t now_ns);

void ect_twin_free(ect_twin_t *twin);

/** Switches the twin off and on: only the surroundings (ect_plant_t::outside_size) keep their state. */
void ect_twin_restart(ect_twin_t *twin, uint64_t now_ns);

/**
 * Executes a fault of a slave, or sets a fault above the wire.
 * @param[out] why  the reason of a refusal, a line for the user without the name of the slave; NULL: done
 * @return whether the fault has restarted the twin
 */
bool ect_twin_fault(ect_twin_t *twin, const ect_fault_t *fault, uint64_t now_ns, const char **why);

/** @return whether pending work of the slave stack is done now; if not, ::ect_twin_next returns the time. */
static inline bool ect_twin_begins(const ect_twin_t *twin, uint64_t now_ns)
{
    return !twin->slow || ect_slow_begins(twin->slow, now_ns);
}

/** @return the deadline of the twin: of its slave stack, or of pending writes to the ESC */
static inline uint64_t ect_twin_next(const ect_twin_t *twin)
{
    return twin->slow ? ect_slow_next(twin->slow, twin->slave_ns) : twin->slave_ns;
}

/** Runs the slave stack and the device. @return whether the twin has restarted, on its own or the master's request */
bool ect_twin_poll(ect_twin_t *twin, uint64_t now_ns);

/** Reports the content of the EEPROM to `config.sii_written` if the master has written to it. */
void ect_twin_report_sii(ect_twin_t *twin);

/** @return whether the microcontroller hangs: the watchdog of the PDI observes it then. */
static inline bool ect_twin_hangs(const ect_twin_t *twin)
{
    return twin->esc.config.pdi_watched;
}

/** @return false: the twin is switched off and has no link at any port */
static inline bool ect_twin_on_bus(const ect_twin_t *twin)
{
    return !twin->slave.off_bus;
}

/** @return the plant with the present signals of the device (ect_plant_t::present). */
const ect_plant_t *ect_twin_plant(const ect_twin_t *twin);

/**
 * Finds a signal of the device, the lamps or the wiring by its name. @return whether the signal exists; sets *ref on
 * true
 */
bool ect_twin_signal(const ect_twin_t *twin, const char *name, ect_signal_ref_t *ref);

/** The state of a twin that signals can change. Zeroed: empty. */
typedef struct ect_twin_snapshot {
    void *instance;
    size_t room; /* bytes of `instance` */
    ect_wiring_t wiring;
    uint8_t beside[ECT_BESIDE_MOST];
    bool off_bus, restart;
} ect_twin_snapshot_t;

/** Copies the state of a twin. @return false: out of memory; nothing has changed */
bool ect_twin_save(const ect_twin_t *twin, ect_twin_snapshot_t *snapshot);
/** Restores the state of the same twin. */
void ect_twin_restore(ect_twin_t *twin, const ect_twin_snapshot_t *snapshot);
/** Frees the memory of a snapshot. */
void ect_twin_snapshot_free(ect_twin_snapshot_t *snapshot);

ECT_C_END

#endif
