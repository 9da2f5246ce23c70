/* SPDX-License-Identifier: MIT */
/**
 * @file
 * RUN, ERR and Link/Activity indicators (ETG.1300): one implementation for a board's LEDs and for a twin's display.
 *
 * All functions except ::ect_indicator_drive are pure and may be called from any context.
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

/** Name of a pattern in the manuals: "off", "on", "flickering", "blinking", "single flash", "double flash". */
const char *ect_pattern_name(ect_pattern_t pattern);

/** Whether an LED with this pattern is lit at a time. All LEDs of a device flash in phase. */
bool ect_pattern_lit(ect_pattern_t pattern, uint64_t now_ns);

/** Pattern of RUN: off INIT, blinking PREOP, single flash SAFEOP, on OP, flickering BOOT. */
ect_pattern_t ect_indicator_run(const ect_slave_t *slave);

/**
 * Pattern of ERR: off no error; blinking a request refused for its configuration; single flash a state left at the
 * slave's own initiative; double flash process-data watchdog; on: the slave cannot access its ESC (`pdi_failing`), as
 * critical as an expired PDI watchdog.
 */
ect_pattern_t ect_indicator_err(const ect_slave_t *slave, bool pdi_failing);

/** Time that Link/Activity flickers after a frame. */
#define ECT_INDICATOR_TRAFFIC_NS 100000000ull

/** Pattern of Link/Activity of a port: off no link; on a link; flickering with traffic (not at 0) in the last
 * ECT_INDICATOR_TRAFFIC_NS. */
ect_pattern_t ect_indicator_link(bool link, uint64_t last_traffic_ns, uint64_t now_ns);

/**
 * Drives the LEDs of a board; to be called after each poll, and at the returned time. Context: mainline.
 * @param slave        the slave whose state the LEDs indicate
 * @param leds         the pins; each is set at each call
 * @param pdi_failing  as for ::ect_indicator_err
 * @param now_ns       the time, as for the poll
 * @return time of the next change without a change of the slave, > now_ns; ECT_NEVER: none
 */
uint64_t ect_indicator_drive(const ect_slave_t *slave, const ect_leds_t *leds, bool pdi_failing, uint64_t now_ns);

ECT_C_END

#endif
