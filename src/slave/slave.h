/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The slave stack: everything that an EtherCAT slave's software does between an ESC and a device.
 *
 * One ::ect_slave_t drives one device behind one PDI. It owns no memory: the caller hands in buffers whose sizes
 * follow from the description (slave/config.h), and keeps them, the description and the PDI alive as long as the slave.
 * Nothing allocates, blocks beyond the PDI's own accesses, or reads a clock: time is an argument, nanoseconds of any
 * monotonic clock, 64 bit. Instances are independent of each other.
 *
 * **Use.** ::ect_slave_init once, ::ect_slave_poll once behind it, then whenever the ESC signals an event or the time
 * has come that the last call returned. Polling more often costs one PDI access and changes nothing. What the device is
 * and does stands in its description (seams/device.h), the way to the ESC in its port (seams/pdi.h).
 *
 *     ect_slave_t slave;
 *     ect_slave_config_t config = {.device = &device, .pdi = &port, .instance = &instance, ...};
 *     if (ect_slave_init(&slave, &config, now()) == 0)
 *         for (uint64_t next = 0;;)
 *             if (line_is_up() || now() >= next)
 *                 next = ect_slave_poll(&slave, now());
 *
 * **Contexts** (docs/CONCURRENCY.md). ::ect_slave_poll and ::ect_slave_mainline are mainline: one call at a time for an
 * instance. ::ect_slave_cycle may interrupt them, on the same processor and not itself; then process data do not wait
 * for a mailbox or for a medium. All else in here may be called from either.
 *
 * **Cost**, in PDI accesses: idle poll 1, or 0 where the port knows the events by itself; a cyclic exchange (outputs
 * in, inputs out) 3; an expedited SDO 6 over two polls, of 42 bytes whatever the mailbox's size; a state change 4
 * to 10. Stack and text: tests/budget.
 *
 * **Errors** are of three kinds. What the master does wrong is answered on the wire: AL status code, mailbox error, SDO
 * abort. When the PDI fails, the present step is abandoned and taken up again at the next poll; ect_slave_t::pdi_errors
 * counts; AL status never claims a state whose preconditions were not established. A mistake of the caller is an
 * assertion (wire/assert.h), or one of the results of ::ect_slave_init.
 *
 * Clauses: ETG.1000.6 §5 (CoE), §6 (state machine); ETG.1000.4 §5.6 (mailbox); ETG.1020 (synchronisation).
 */
#ifndef ECT_SLAVE_SLAVE_H
#define ECT_SLAVE_SLAVE_H

#include "slave/config.h"
#include "slave/state.h"

ECT_C_BEGIN

/** Where an error in AL status comes from, ect_slave_t::cause; what the ERR indicator shows (ETG.1300). */
typedef enum ect_error_cause {
    ECT_CAUSE_NONE,     /**< there is none */
    ECT_CAUSE_REQUEST,  /**< a request of the master was refused: invalid configuration */
    ECT_CAUSE_LOCAL,    /**< the slave left the state on its own account */
    ECT_CAUSE_WATCHDOG, /**< the process-data watchdog made it */
} ect_error_cause_t;

/**
 * Power-on, for the first time or again. Zeroes the instance but for what stands outside it, gives the dictionary its
 * defaults, initialises the device and its object services (1010h: what was stored comes back), makes the address
 * switches the station alias, switches all SyncManagers off from the PDI side, and reports INIT without an error. The
 * AL event mask is left to the first poll.
 *
 * @param slave   any memory; its content does not matter. Not while another context uses it.
 * @param config  copied, so not in `slave`; what it points to must outlive the slave, and be nobody else's. The
 *                description must be one that `ect_device_check` (check/check.h) accepts (asserted in part).
 * @param now_ns  the time; the device's first tick is due at it
 * @return 0 · -1 device or PDI missing · -2 a buffer missing that ::ect_slave_memory asks for; nothing has been touched
 * · -3 the PDI failed: try again, the whole of it. Unless 0, the slave must not be used. Context: mainline, with the
 * exchange's interrupt disabled. Cost: 2 PDI accesses and one for each SyncManager, one more with switches; reading the
 * medium, when 1010h is offered.
 */
int ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns);

/**
 * Does all that there is to do, in this order: AL control, SyncManager changes, watchdog, outputs, the device's own
 * time, inputs, a delayed transition, AL status, the mailbox (one request or one mail), the AL event mask.
 *
 * @param now_ns  the time, not smaller than in an earlier call; all that happens in this poll happens at it
 * @return when to call again even without an event, > now_ns: the device's own time, a time-out, or soon when the PDI
 *         failed or the device asked for something. ECT_NEVER: only the bus can bring work.
 * Context: mainline. Cost: see above; the longest step is fetching and answering a mail (of each what is used, and a
 * byte), and the device's functions.
 */
uint64_t ect_slave_poll(ect_slave_t *slave, uint64_t now_ns);

/**
 * The same without process data, which ::ect_slave_cycle exchanges. Inputs that the device changes on its own leave
 * with the next exchange.
 * @param now_ns, return, context, cost  as ::ect_slave_poll
 */
uint64_t ect_slave_mainline(ect_slave_t *slave, uint64_t now_ns);

/**
 * Outputs in, inputs out: what is due of them by the AL event word. Below SAFEOP it does nothing; in SAFEOP outputs are
 * fetched and not applied. Calls the device's `outputs`, `inputs` and `inputs_read`. When mainline is in a step it only
 * takes note, and mainline makes up for it at the step's end.
 *
 * @param now_ns  the time, not smaller than in an earlier call of this function or of a poll
 * Context: an interrupt that nothing but a higher interrupt, one that leaves the stack alone, interrupts; or mainline,
 *          between polls.
 * Cost: 1 PDI access, and 1 for each SyncManager that has something; 0 below SAFEOP or in a step of mainline.
 */
void ect_slave_cycle(ect_slave_t *slave, uint64_t now_ns);

/** What its device was given to ask with, for others who speak for the device; valid as long as the slave. */
static inline const ect_host_t *ect_slave_host(const ect_slave_t *slave)
{
    return &slave->host;
}

/** Whether an SDO transfer is under way that takes more than one mail. Between polls, and in functions of a device. */
static inline bool ect_slave_in_transfer(const ect_slave_t *slave)
{
    return slave->sdo.state != ECT_SDO_IDLE;
}

/**
 * The device's own time is due at the next poll, whatever it said last: something about it was changed from outside.
 * Context: any. Cost: a byte.
 */
static inline void ect_slave_wake(ect_slave_t *slave)
{
    slave->woken = true;
}

ECT_C_END

#endif
