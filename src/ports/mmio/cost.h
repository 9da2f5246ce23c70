/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The accesses of the bus that an access of the port needs (ports/mmio/mmio.h), as a function. A test compares it with
 * the port.
 */
#ifndef ECT_PORTS_MMIO_COST_H
#define ECT_PORTS_MMIO_COST_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Pure. Any context.
 * @param address  ESC address
 * @param length   bytes, 1 to 65535
 * @param width    of the bus, in bytes: 1, 2, 4
 * @return accesses of the bus, for a read and for a write
 */
uint32_t ect_mmio_cost(uint16_t address, uint16_t length, unsigned int width);

ECT_C_END

#endif
