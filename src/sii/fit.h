/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A device on another controller than its description names: a board has the ESC that it has. Objects and behaviour
 * stay; the SyncManagers are laid out anew, one behind another from 0x1000 on (but for those over the registers of the
 * digital outputs, which every controller has at the same place), and the EEPROM's first words are the controller's.
 *
 * A master finds the new layout in the EEPROM (::ect_sii_write of the new description). An ESI file must be one of the
 * new description, too.
 */
#ifndef ECT_SII_FIT_H
#define ECT_SII_FIT_H

#include <stdbool.h>

#include "seams/device.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** What a controller has room for, and what its EEPROM has to say of its PDI. */
typedef struct ect_fit {
    const char *esc;    /**< ect_device_t::esc */
    uint16_t ram_bytes; /**< of process RAM */
    uint8_t sm_count;   /**< that it has; likewise FMMUs */
    uint8_t fmmu_count;
    uint8_t pdi_control; /**< byte 0 of the EEPROM, 0x0140 */
    uint8_t pdi_config;  /**< byte 2, 0x0150 */
} ect_fit_t;

/** The LAN9252 on SPI. */
extern const ect_fit_t ect_fit_lan9252;

/**
 * @param device  one that `ect_device_check` (check/check.h) accepts
 * @param[out] on  the description on that controller; what it points to is that of `device`
 * @return whether it fits: SyncManagers, FMMUs, and process RAM for the longest that each SyncManager may become,
 * process data three times where they are buffered. If not, *on is undefined.
 */
bool ect_fit(const ect_device_t *device, const ect_fit_t *controller, ect_device_t *on);

ECT_C_END

#endif
