/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The slave stack: the software of an EtherCAT slave between an ESC and a device.
 *
 * One ::ect_slave_t drives one device behind one PDI. It owns no memory: the caller provides buffers whose sizes follow
 * from the description (slave/config.h), and keeps the buffers, the description and the PDI valid as long as the slave.
 * No function allocates, blocks beyond the PDI's own accesses, or reads a clock: time is an argument, in nanoseconds of
 * any monotonic clock, 64 bit. Instances are independent of each other.
 *
 * **Use.** Call ::ect_slave_init once and ::ect_slave_poll once after it, then ::ect_slave_poll whenever the ESC
 * signals an event or the time that the last call returned has come. More frequent polls cost one PDI access each and
 * change nothing. The description (seams/device.h) defines the device, the port (seams/pdi.h) the access to the ESC.
 *
 *     ect_slave_t slave;
 *     ect_slave_config_t config = {.device = &device, .pdi = &port, .instance = &instance, ...};
 *     if (ect_slave_init(&slave, &config, now()) == 0)
 *         for (uint64_t next = 0;;)
 *             if (line_is_up() || now() >= next)
 *                 next = ect_slave_poll(&slave, now());
 *
 * **Contexts** (docs/CONCURRENCY.md). ::ect_slave_poll and ::ect_slave_mainline are mainline: one call at a time for an
 * instance. ::ect_slave_cycle may interrupt them, on the same processor and not itself; process data then wait neither
 * for a mailbox nor for a medium. All other functions of this header may be called from either.
 *
 * **Cost**, in PDI accesses: idle poll 1, or 0 with a port that gets the events without an access; a cyclic exchange
 * (outputs in, inputs out) 3; an expedited SDO 6 over two polls, of 42 bytes regardless of the mailbox's size; a state
 * change 4 to 10. Stack and text: tests/budget.
 *
 * **Errors** are of three kinds. A mistake of the master gets a reply on the wire: AL status code, mailbox error, SDO
 * abort. After a failed PDI access, the stack abandons the present step and repeats it at the next poll;
 * ect_slave_t::pdi_errors counts; AL status never reports a state whose preconditions are not established. A mistake of
 * the caller is an assertion (wire/assert.h), or a result of ::ect_slave_init.
 *
 * Clauses: ETG.1000.6 §5 (CoE), §6 (state machine); ETG.1000.4 §5.6 (mailbox); ETG.1020 (synchronisation).
 */
#ifndef ECT_SLAVE_SLAVE_H
#define ECT_SLAVE_SLAVE_H

#include "slave/config.h"
#include "slave/state.h"

ECT_C_BEGIN

/** Origin of an error in AL status, ect_slave_t::cause; determines the ERR indicator (ETG.1300). */
typedef enum ect_error_cause {
    ECT_CAUSE_NONE,     /**< no error */
    ECT_CAUSE_REQUEST,  /**< a request of the master was refused: invalid configuration */
    ECT_CAUSE_LOCAL,    /**< the slave left the state at its own initiative */
    ECT_CAUSE_WATCHDOG, /**< the process-data watchdog expired */
} ect_error_cause_t;

/**
 * Power-on, for the first time or again. Zeroes the instance except for the bytes that belong to the outside, sets the
 * dictionary to its defaults, initialises the device and its object services (1010h restores the stored values), writes
 * the address switches to the station alias, disables all SyncManagers from the PDI side, and sets AL status to INIT
 * without an error. The first poll sets the AL event mask.
 *
 * Context: mainline, with the exchange's interrupt disabled. Cost: 2 PDI accesses and one for each SyncManager, one
 * more with switches; reading the medium, when 1010h is offered.
 *
 * @param slave   any memory; its content does not matter. No other context may use it.
 * @param config  copied, so not in `slave`; the memory that it points to must outlive the slave and be used by nothing
 * else. The description must be one that `ect_device_check` (check/check.h) accepts (asserted in part).
 * @param now_ns  present time; the device's first tick is due at it
 * @return 0 · -1 device or PDI missing · -2 a buffer of ::ect_slave_memory missing, nothing has been changed · -3 the
 * PDI failed: call again. Unless 0, the slave must not be used
 */
int ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns);

/**
 * Executes all work that is due, in this order: AL control, SyncManager changes, watchdog, outputs, the device's own
 * time, inputs, a delayed transition, AL status, the mailbox (one request or one mail), the AL event mask.
 *
 * Context: mainline. Cost: see above; the longest step is one request with its reply (the bytes in use of each, and one
 * more), and the device's functions.
 *
 * @param slave   initialised
 * @param now_ns  the time, not smaller than in an earlier call; all effects of this poll happen at this time
 * @return time of the next call if no event precedes it, > now_ns: the device's own time, a timeout, or a short delay
 * after a PDI failure or a request of the device. ECT_NEVER: only the bus can cause work
 */
uint64_t ect_slave_poll(ect_slave_t *slave, uint64_t now_ns);

/**
 * As ::ect_slave_poll without process data, which ::ect_slave_cycle exchanges. Inputs that the device changes at its
 * own initiative leave with the next exchange.
 */
uint64_t ect_slave_mainline(ect_slave_t *slave, uint64_t now_ns);

/**
 * Exchanges outputs and inputs that are due according to the AL event word. No effect below SAFEOP; in SAFEOP outputs
 * are fetched and not applied. Calls the device's `outputs`, `inputs` and `inputs_read`. During a step of mainline it
 * only records the request, and mainline executes the exchange at the end of that step.
 *
 * Context: an interrupt, which only interrupts that do not use the stack may interrupt; or mainline, between polls.
 * Cost: 1 PDI access, and 1 for each SyncManager with data; 0 below SAFEOP or in a step of mainline.
 *
 * @param slave   initialised
 * @param now_ns  the time, not smaller than in an earlier call of this function or of a poll
 */
void ect_slave_cycle(ect_slave_t *slave, uint64_t now_ns);

/**
 * @return the interface for the device's requests, for code that acts on behalf of the device; valid as long as the
 * slave.
 */
static inline const ect_host_t *ect_slave_host(const ect_slave_t *slave)
{
    return &slave->host;
}

/** Whether an SDO transfer of more than one mail is under way. Between polls, and in functions of a device. */
static inline bool ect_slave_in_transfer(const ect_slave_t *slave)
{
    return slave->sdo.state != ECT_SDO_IDLE;
}

/**
 * Reads an entry of the dictionary as an SDO upload of a master does: with the rights of the present AL state, which
 * allows no access below PREOP, and with the functions of the device. Context: mainline, between polls. Cost: no PDI
 * access; as many bytes as are read.
 * @param[out] to    the first `room` (1..65535) bytes of the value, in wire form; the rest of `to` must be 0
 * @param[out] size  bytes of the value; set with ECT_OK
 * @return ECT_OK · ECT_REASON_LOCAL_CONTROL: an SDO transfer of a master is under way · another reason, or abort code
 */
ect_reason_t ect_slave_upload(ect_slave_t *slave, uint16_t index, uint8_t subindex, uint8_t *to, uint16_t room,
                              uint16_t *size);

/**
 * Writes an entry of the dictionary as an SDO download of a master does. Context, cost, rights: ::ect_slave_upload.
 * @param data  `size` bytes, in wire form
 * @return as ::ect_slave_upload
 */
ect_reason_t ect_slave_download(ect_slave_t *slave, uint16_t index, uint8_t subindex, const uint8_t *data,
                                uint16_t size);

/** The dictionary of the slave, for reading; valid until the device replaces its description. */
static inline const ect_od_t *ect_slave_dictionary(const ect_slave_t *slave)
{
    return &slave->od;
}

/**
 * While held, inputs that are due are not written: the master reads the former image. Held inputs are written by the
 * first poll afterwards. For a caller that polls for frames of the past, whose replies have left (bus/kernel).
 * Context: mainline. Cost: one byte.
 */
static inline void ect_slave_hold_inputs(ect_slave_t *slave, bool held)
{
    slave->inputs_held = held;
}

/** Whether inputs wait for the next poll. */
static inline bool ect_slave_owes_inputs(const ect_slave_t *slave)
{
    return slave->inputs_due;
}

/**
 * Makes the device's own time due at the next poll, regardless of the time that it returned: its surroundings have
 * changed. Context: any. Cost: one byte.
 */
static inline void ect_slave_wake(ect_slave_t *slave)
{
    slave->woken = true;
}

ECT_C_END

#endif
