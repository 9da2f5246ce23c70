/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The device of this firmware for the main loop: on_ectwin/ with ectwin's stack, on_soes/ with SOES's.
 */
#ifndef FIRMWARE_FIRMWARE_H
#define FIRMWARE_FIRMWARE_H

#include <stdint.h>

#include "ecat_slv.h"
#include "seams/device.h"

/** @return the device unchanged (plain.c), or with updates (update.c). Constant from the first call on. */
const ect_device_t *firmware_described(void);

/**
 * @return the device of the firmware: firmware_described, with a network address (network.c) or without (no_network.c).
 * Constant from the first call on.
 */
const ect_device_t *firmware_device(void);

/** Reports a number of the firmware's configuration that does not fit the device, by ::board_fault. */
_Noreturn void firmware_stop(void);

/** @return the configuration of the stack, for ecat_slv_init. Due after board_init. */
esc_cfg_t *firmware_config(void);

/**
 * Called in each iteration of the main loop, after ecat_slv: updates the lamps, and executes requests of the device to
 * the board.
 * @return time of the next iteration, unless an event of the ESC occurs before
 */
uint64_t firmware_turn(void);

#endif
