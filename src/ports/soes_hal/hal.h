/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The software ESC behind the hardware file esc_hw.c, which is compiled with the application and its SOES headers.
 * In here nothing of SOES is known. Host only; context: the application's one thread.
 */
#ifndef ECT_PORTS_SOES_HAL_H
#define ECT_PORTS_SOES_HAL_H

#include <stdbool.h>

#include "seams/device.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Takes a command line that has our options alone. @return false: it has others, or lacks a value; one line on
 * standard error */
bool ect_soes_hal_arguments(int argc, char **argv);

/**
 * Opens the interface and powers the ESC on, the first time; writes the ready line (README).
 * Options without a value are read from the command line of the process, then in the environment.
 * @param device  what the EEPROM is made from, when no file is named
 * Ends the program with status 1 or 2 and one line for the user when that is not possible.
 */
void ect_soes_hal_init(const ect_device_t *device);

/** Resets the ESC. */
void ect_soes_hal_reset(void);

/** As the PDI; then the AL event word. Frames are answered in reads of 0x0910 and 0x0110. */
uint32_t ect_soes_hal_read(uint16_t address, void *buffer, uint16_t length);
uint32_t ect_soes_hal_write(uint16_t address, const void *buffer, uint16_t length);

ECT_C_END

#endif
