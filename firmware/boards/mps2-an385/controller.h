/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EtherCAT slave controller of this board: software, on the bare Ethernet controller.
 *
 * The controller runs in interrupts: the interrupt of the Ethernet controller processes a frame and sends the reply, at
 * any point of mainline; the interrupt of the alarm executes the timed actions (watchdog, SYNC0, EEPROM). Mainline
 * accesses the controller like a chip, through the PDI seam; interrupts are disabled during each access.
 */
#ifndef FIRMWARE_MPS2_CONTROLLER_H
#define FIRMWARE_MPS2_CONTROLLER_H

#include <stdbool.h>
#include <stddef.h>

#include "esc/personality.h"
#include "seams/pdi.h"

/** Room for the largest personality and EEPROM. */
enum { CONTROLLER_RAM_KB = 60, CONTROLLER_SII = 32768 };

/** Results of ::controller_init. */
typedef enum controller_result {
    CONTROLLER_OK,
    CONTROLLER_NO_ETHERNET, /**< the Ethernet controller does not answer */
    CONTROLLER_BAD_SII,     /**< the size is odd, 0, or above CONTROLLER_SII */
} controller_result_t;

/**
 * The EEPROM: CONTROLLER_SII bytes, to be filled before ::controller_init. Writes of the master are kept until
 * power-off.
 */
uint8_t *controller_sii(void);

/**
 * Power-on reset of the controller, which then replies to frames.
 * @param sii_size  bytes of the EEPROM
 */
controller_result_t controller_init(const ect_esc_personality_t *personality, uint32_t sii_size);

/** @return the PDI of the controller, which never fails. */
const ect_pdi_t *controller_pdi(void);

/**
 * Sleeps until an action of the ECAT side that mainline has not handled since the last call, or until a time. Returns
 * at once after such an action, or if the time has passed.
 */
void controller_wait(uint64_t until_ns);

#endif
