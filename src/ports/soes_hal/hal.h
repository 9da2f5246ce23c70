/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The software ESC behind the hardware file esc_hw.c, which is compiled with the application and its SOES headers. This
 * header does not depend on SOES. Host only; context: the application's one thread.
 */
#ifndef ECT_PORTS_SOES_HAL_H
#define ECT_PORTS_SOES_HAL_H

#include <stdbool.h>

#include "seams/device.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Reads a command line that consists of the options of ectwin_soes.h. @return false: another option, or a missing
 * value; one line on standard error
 */
bool ect_soes_hal_arguments(int argc, char **argv);

/**
 * Opens the interface and powers the ESC on, the first time; writes the ready line (README).
 * Options without a value are read from the command line of the process, then in the environment.
 * @param device  source of the EEPROM's content, if no file is named
 * Ends the program with status 1 or 2 and one line for the user on failure.
 */
void ect_soes_hal_init(const ect_device_t *device);

/** Resets the ESC. */
void ect_soes_hal_reset(void);

/** Accesses of the PDI. @return the AL event word. Reads of 0x0910 and 0x0110 pass frames. */
uint32_t ect_soes_hal_read(uint16_t address, void *buffer, uint16_t length);
uint32_t ect_soes_hal_write(uint16_t address, const void *buffer, uint16_t length);

ECT_C_END

#endif
