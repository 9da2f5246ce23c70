/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The SPI transfers and bytes of an access of the port, without waits for the chip: the table of
 * ports/lan9252/lan9252.h as a function. A test compares the function with the port at the virtual chip.
 */
#ifndef ECT_PORTS_LAN9252_COST_H
#define ECT_PORTS_LAN9252_COST_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_lan9252_cost {
    uint32_t transfers, bytes;
} ect_lan9252_cost_t;

/**
 * Computes the cost of an access. Pure. Context: any.
 * @param address  ESC address
 * @param length   bytes, 1 to 65535
 * @param write    false: a read
 */
ect_lan9252_cost_t ect_lan9252_cost(uint16_t address, uint16_t length, bool write);

ECT_C_END

#endif
