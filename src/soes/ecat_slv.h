/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOES's API: the slave's main loop.
 *
 *     static esc_cfg_t config = {.watchdog_cnt = 150, ...};
 *     ecat_slv_init(&config);
 *     for (;;)
 *         ecat_slv();
 *
 * Context: mainline, one call at a time. ::DIG_process alone may run in an interrupt, as SOES has it: then the
 * hardware file's ESC_read and ESC_write must bear being interrupted by themselves.
 */
#ifndef ECT_SOES_ECAT_SLV_H
#define ECT_SOES_ECAT_SLV_H

#include "soes/options.h"

#include "soes/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The application's: brings the entries of its inputs up to date. SAFEOP and OP. */
void cb_get_inputs(void);
/** The application's: acts on the entries of its outputs, which the master has renewed. OP. */
void cb_set_outputs(void);

/** Calls of ::DIG_process with DIG_PROCESS_WD_FLAG, without new outputs, until OP is left with ALERR_WATCHDOG. */
void APP_setwatchdog(int watchdogcnt);

#define DIG_PROCESS_INPUTS_FLAG   0x01
#define DIG_PROCESS_OUTPUTS_FLAG  0x02
#define DIG_PROCESS_WD_FLAG       0x04
#define DIG_PROCESS_APP_HOOK_FLAG 0x08
/**
 * The exchange with the application, what `flags` name of it, in this order: the watchdog counts; outputs, when
 * ESCvar.ALevent has them; application_hook; inputs.
 * Cost: 1 PDI access for outputs, 1 for inputs.
 */
void DIG_process(uint8_t flags);

/** State machine and mailbox, one step. Reads the ESC's time into ESCvar.Time first. Then esc_hw_eep_handler. */
void ecat_slv_poll(void);

/** ::ecat_slv_poll and all of ::DIG_process. */
void ecat_slv(void);

/**
 * As ::ecat_slv_poll, until none of the events of `event_mask` asks for more; then those that still concern the slave
 * are let through by the AL event mask again. For a task that an interrupt wakes, which has masked them.
 */
void ecat_slv_worker(uint32_t event_mask);

/**
 * Brings the hardware file up (ESC_init), waits until the ESC has loaded its EEPROM, for ever if it does not, and
 * reports INIT. `config` is copied.
 */
void ecat_slv_init(esc_cfg_t *config);

ECT_C_END

#endif
