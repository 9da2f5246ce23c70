/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A device on another controller than its description names, because a board has a certain ESC. Objects and behaviour
 * remain; the SyncManagers get a new layout, in succession from 0x1000 on (except SyncManagers over the registers
 * of the digital outputs, whose address is the same in every controller), and the first words of the EEPROM become
 * those of the controller.
 *
 * A master finds the new layout in the EEPROM (::ect_sii_write of the new description). Its ESI file must be that of
 * the new description as well.
 */
#ifndef ECT_SII_FIT_H
#define ECT_SII_FIT_H

#include <stdbool.h>

#include "seams/device.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Resources of a controller, and the configuration of its PDI for the EEPROM. */
typedef struct ect_fit {
    const char *esc;    /**< ect_device_t::esc */
    uint16_t ram_bytes; /**< process RAM */
    uint8_t sm_count;   /**< number of SyncManagers */
    uint8_t fmmu_count;
    uint8_t pdi_control; /**< byte 0 of the EEPROM, 0x0140 */
    uint8_t pdi_config;  /**< byte 2, 0x0150 */
} ect_fit_t;

/** The LAN9252 on SPI. */
extern const ect_fit_t ect_fit_lan9252;

/** The ET1100 on an asynchronous bus of 16 bits. */
extern const ect_fit_t ect_fit_et1100;

/**
 * Adapts a description to a controller. Pure.
 * @param device   one that `ect_device_check` (check/check.h) accepts
 * @param controller  the controller
 * @param[out] on  the description for that controller; it shares the memory that `device` points to
 * @return whether it fits: SyncManagers, FMMUs, and process RAM for the greatest length of each SyncManager, three
 * times for buffered process data. If not, *on is undefined.
 */
bool ect_fit(const ect_device_t *device, const ect_fit_t *controller, ect_device_t *on);

ECT_C_END

#endif
