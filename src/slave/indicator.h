/* SPDX-License-Identifier: MIT */
/**
 * @file
 * RUN, ERR and Link/Activity indicators (ETG.1300): one piece of code for a board's LEDs and for a twin's display.
 *
 * All functions but ::ect_indicator_drive are pure and may be called from any context.
 */
#ifndef ECT_SLAVE_INDICATOR_H
#define ECT_SLAVE_INDICATOR_H

#include <stdbool.h>
#include <stdint.h>

#include "seams/leds.h"
#include "slave/slave.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Flash patterns, with the times of ETG.1300. */
typedef enum ect_pattern {
    ECT_PATTERN_OFF,
    ECT_PATTERN_ON,
    ECT_PATTERN_FLICKERING,   /**< 50 ms on, 50 ms off */
    ECT_PATTERN_BLINKING,     /**< 200 ms on, 200 ms off */
    ECT_PATTERN_SINGLE_FLASH, /**< 200 ms on, 1000 ms off */
    ECT_PATTERN_DOUBLE_FLASH, /**< 200 on, 200 off, 200 on, 1000 off */
} ect_pattern_t;

/** What a pattern is called in the manuals: "off", "on", "flickering", "blinking", "single flash", "double flash". */
const char *ect_pattern_name(ect_pattern_t pattern);

/** Whether a lamp with this pattern is lit at a time. All lamps of a device flash in step. */
bool ect_pattern_lit(ect_pattern_t pattern, uint64_t now_ns);

/** RUN: off INIT, blinking PREOP, single flash SAFEOP, on OP, flickering BOOT. */
ect_pattern_t ect_indicator_run(const ect_slave_t *slave);

/**
 * ERR: off no error; blinking a request refused for its configuration; single flash a state left on the slave's own
 * account; double flash process-data watchdog; on: the slave cannot reach its ESC (`pdi_failing`), as critical as a
 * PDI watchdog.
 */
ect_pattern_t ect_indicator_err(const ect_slave_t *slave, bool pdi_failing);

/** How long a frame keeps L/A flickering. */
#define ECT_INDICATOR_TRAFFIC_NS 100000000ull

/** L/A of a port: off no link; on a link; flickering with traffic (not at 0) in the last ECT_INDICATOR_TRAFFIC_NS. */
ect_pattern_t ect_indicator_link(bool link, uint64_t last_traffic_ns, uint64_t now_ns);

/**
 * Lights the lamps of a board as its slave is: to be called after each poll, and at the time that it returned.
 * @param leds         the pins; each is set at each call
 * @param pdi_failing  as for ::ect_indicator_err
 * @param now_ns       the time, as for the poll
 * @return when a lamp changes by itself, > now_ns; ECT_NEVER: not before the slave does
 * Context: mainline.
 */
uint64_t ect_indicator_drive(const ect_slave_t *slave, const ect_leds_t *leds, bool pdi_failing, uint64_t now_ns);

ECT_C_END

#endif
