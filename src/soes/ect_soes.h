/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Functions of this stack in addition to SOES's API. All are optional.
 */
#ifndef ECT_SOES_ECT_SOES_H
#define ECT_SOES_ECT_SOES_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Sets the clock: nanoseconds that never decrease. Due before ecat_slv_init. Without a clock the time is that of the
 * ESC (ESCvar.Time), the only one of SOES's API, which does not advance in a chip without distributed clocks.
 * @param now_ns  called in mainline, and in the context of ::DIG_process
 */
void ect_soes_clock(uint64_t (*now_ns)(void));

/**
 * @return the time at which ecat_slv or ecat_slv_poll is due without an event of the ESC, as of their last call
 * (::ect_slave_poll). For a processor that sleeps. Context: mainline.
 */
uint64_t ect_soes_due(void);

ECT_C_END

#endif
