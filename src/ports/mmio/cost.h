/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bus accesses of an access of the port (ports/mmio/mmio.h), as a function. A test compares the function with the
 * port.
 */
#ifndef ECT_PORTS_MMIO_COST_H
#define ECT_PORTS_MMIO_COST_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Computes the cost of an access. Pure. Context: any.
 * @param address  ESC address
 * @param length   bytes, 1 to 65535
 * @param width    of the bus, in bytes: 1, 2, 4
 * @return bus accesses, the same for a read and a write
 */
uint32_t ect_mmio_cost(uint16_t address, uint16_t length, unsigned int width);

ECT_C_END

#endif
