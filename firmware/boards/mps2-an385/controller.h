/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EtherCAT slave controller of this board: software, on the bare Ethernet controller.
 *
 * It lives in interrupts: a frame is processed and answered in that of the Ethernet controller, whatever mainline is
 * about, and what the controller does in its own time (watchdog, SYNC0, EEPROM) in that of the alarm. Mainline reaches
 * it as it would reach a chip, through the PDI seam; each access holds the interrupts off for as long as it takes.
 */
#ifndef FIRMWARE_MPS2_CONTROLLER_H
#define FIRMWARE_MPS2_CONTROLLER_H

#include <stdbool.h>
#include <stddef.h>

#include "esc/personality.h"
#include "seams/pdi.h"

/** Room for the largest personality and EEPROM there are. */
enum { CONTROLLER_RAM_KB = 60, CONTROLLER_SII = 32768 };

/** Results of ::controller_init. */
typedef enum controller_result {
    CONTROLLER_OK,
    CONTROLLER_NO_ETHERNET, /**< the Ethernet controller does not answer */
    CONTROLLER_BAD_SII,     /**< its size is odd, 0, or beyond CONTROLLER_SII */
} controller_result_t;

/** The EEPROM: CONTROLLER_SII bytes, to be filled before ::controller_init. A write of the master lasts until
 * power-off. */
uint8_t *controller_sii(void);

/**
 * Power-on reset of the controller; from now on it answers frames.
 * @param sii_size  bytes of the EEPROM
 */
controller_result_t controller_init(const ect_esc_personality_t *personality, uint32_t sii_size);

/** Its PDI; never fails. */
const ect_pdi_t *controller_pdi(void);

/**
 * Sleeps until the ECAT side has done something that mainline has not handled since the last call, or until that
 * time. Returns at once when it has, or when the time has come.
 */
void controller_wait(uint64_t until_ns);

#endif
