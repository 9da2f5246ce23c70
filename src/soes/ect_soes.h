/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Functions of this stack beside SOES's API. All of them are optional.
 */
#ifndef ECT_SOES_ECT_SOES_H
#define ECT_SOES_ECT_SOES_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * The time: nanoseconds of any clock that never goes back, to be given before ecat_slv_init. Without it time is that of
 * the ESC (ESCvar.Time), which does not move in a chip without distributed clocks; an application of SOES knows no
 * other.
 * @param now_ns  called in mainline, and where ::DIG_process is called
 */
void ect_soes_clock(uint64_t (*now_ns)(void));

/**
 * When ecat_slv or ecat_slv_poll is to be called again even if the ESC has no event: what the last call of them found,
 * as
 * ::ect_slave_poll returns it. For a processor that sleeps. Context: mainline.
 */
uint64_t ect_soes_due(void);

ECT_C_END

#endif
