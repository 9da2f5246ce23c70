/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The common steps of the example masters, over SOEM: open the interface, take one bus to OP, keep the cycle, end in
 * INIT. The process data and the sequence of a machine's tasks are in the example.
 *
 * SOEM's global context (ec_slave, ec_slavecount) is the bus. Context: one thread.
 */
#ifndef EXAMPLES_MASTER_H
#define EXAMPLES_MASTER_H

#include <argp.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include "ethercat.h"

/** Exit codes: 0, wrong usage, an interface that cannot be opened, a bus that failed. */
enum { MASTER_USAGE = 1, MASTER_OPEN = 2, MASTER_FAILED = 3 };

/** Parameters of the way to OP. Members that are zero have the meaning in their lines. */
typedef struct master_start {
    int (*configure)(uint16 slave); /**< writes settings of slave 1 in PREOP, > 0: accepted; NULL: no settings */
    bool clocks;                    /**< synchronise distributed clocks */
    uint32_t sync0_ns;              /**< cycle of SYNC0 in slave 1; 0: no SYNC0 */
    bool (*fits)(void); /**< returns whether the process data of slave 1 have the expected size; NULL: any size */
} master_start_t;

/** Set by SIGINT and SIGTERM, after ::master_catch_signals. */
extern volatile sig_atomic_t master_ended;

/** Makes SIGINT and SIGTERM set ::master_ended instead of ending the process. */
void master_catch_signals(void);

/** Monotonic time in nanoseconds. */
uint64_t master_now(void);

/**
 * Opens an interface for SOEM.
 * @param program  name for messages
 * @return false: standard error has one line with the cause and the cure
 */
bool master_open(const char *program, const char *iface);

/** Requests INIT from all slaves and closes the interface. */
void master_close(void);

/** Sends the process data and receives them. @return working counter; <= 0: the frame is lost */
int master_exchange(void);

/** @return working counter of an exchange in which each slave takes part */
int master_expected(void);

/**
 * Takes the bus from INIT to OP, with running process data from SAFEOP on. Lasts up to some seconds.
 * @return false: a slave did not follow, `fits` refused, or a signal has arrived. On a bus that loses frames: repeat
 * the call
 */
bool master_to_op(const master_start_t *start);

/**
 * Sleeps until the next cycle. A late cycle is not repeated: the rhythm restarts at the present time.
 * @param[in,out] next_ns  begin of the cycle, from ::master_now before the first one
 */
void master_pace(uint64_t *next_ns, uint32_t cycle_us);

/**
 * Parses IFACE, the only argument, for an argp parser.
 * @return 0: parsed; ARGP_ERR_UNKNOWN: another `key`. A missing or second interface ends the program.
 */
error_t master_parse_iface(int key, char *text, struct argp_state *state, const char **iface);

/**
 * Reads the decimal number of an option (010 is ten). Any other text, or a number outside `least` to `most`, ends the
 * program with one line that names the option.
 */
unsigned int master_number(const struct argp_state *state, const char *option, const char *text, unsigned int least,
                           unsigned int most);

#endif
