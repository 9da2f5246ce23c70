/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The device that this firmware was built for, towards its main loop: on_ectwin/ by our stack, on_soes/ by SOES's.
 */
#ifndef FIRMWARE_FIRMWARE_H
#define FIRMWARE_FIRMWARE_H

#include <stdint.h>

#include "ecat_slv.h"
#include "seams/device.h"

/** The device as it is described (plain.c), or with updates (update.c). Constant from the first call on. */
const ect_device_t *firmware_described(void);

/** The device of the firmware: firmware_described, with a network address (network.c) or without one (no_network.c).
 * Constant from the first call on. */
const ect_device_t *firmware_device(void);

/** A number of the firmware's configuration does not fit its device: ::board_fault. */
_Noreturn void firmware_stop(void);

/** The configuration of the stack, for ecat_slv_init. After board_init. */
esc_cfg_t *firmware_config(void);

/**
 * Once a turn, after ecat_slv: lamps, and what the device asks of the board.
 * @return when the next turn is due, unless the ESC has something before
 */
uint64_t firmware_turn(void);

#endif
