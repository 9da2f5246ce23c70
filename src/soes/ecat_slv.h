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
 * Context: mainline, one call at a time. Only ::DIG_process may run in an interrupt, as with SOES: the hardware file's
 * ESC_read and ESC_write must then be reentrant.
 */
#ifndef ECT_SOES_ECAT_SLV_H
#define ECT_SOES_ECAT_SLV_H

#include "soes/options.h"

#include "soes/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Defined by the application: updates the entries of its inputs. SAFEOP and OP. */
void cb_get_inputs(void);
/** Defined by the application: processes the entries of its outputs, which contain new data of the master. OP. */
void cb_set_outputs(void);

/**
 * Sets the number of calls of ::DIG_process with DIG_PROCESS_WD_FLAG, without new outputs, after which OP is left with
 * ALERR_WATCHDOG.
 */
void APP_setwatchdog(int watchdogcnt);

#define DIG_PROCESS_INPUTS_FLAG   0x01
#define DIG_PROCESS_OUTPUTS_FLAG  0x02
#define DIG_PROCESS_WD_FLAG       0x04
#define DIG_PROCESS_APP_HOOK_FLAG 0x08
/**
 * Executes the parts of the exchange in `flags`, in this order: the watchdog counts; outputs, if ESCvar.ALevent has
 * their event; application_hook; inputs. Cost: 1 PDI access for outputs, 1 for inputs.
 */
void DIG_process(uint8_t flags);

/**
 * Reads the ESC's time into ESCvar.Time, executes one step of state machine and mailbox, and calls esc_hw_eep_handler.
 */
void ecat_slv_poll(void);

/** ::ecat_slv_poll, and ::DIG_process with all flags. */
void ecat_slv(void);

/**
 * Repeats ::ecat_slv_poll until no event of `event_mask` is pending, at most 16 times; then enables these events in the
 * AL event mask, as far as the slave waits for them. For a task woken by an interrupt that has masked the events.
 */
void ecat_slv_worker(uint32_t event_mask);

/**
 * Initialises the hardware file (ESC_init), waits without limit until the ESC has loaded its EEPROM, and reports INIT.
 * `config` is copied.
 */
void ecat_slv_init(esc_cfg_t *config);

ECT_C_END

#endif
