/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An ESC that is mapped into memory: an ET1100 or LAN9253 on a parallel bus, an IP core on an FPGA's bus, the
 * XMC4800's.
 *
 * Address n of the ESC is at `base` + n. An access of the stack is cut into the widest ones that the bus can do,
 * aligned, in ascending order, and never wider than requested. A processor that splits a wide access by itself
 * (32 bits on a bus of 16) is fine, as long as the lower address comes first.
 *
 * The chip holds the bus until it is ready, so an access takes what the bus takes, and cannot fail. **Bound**: accesses
 * times bus time; an ET1100 on 16 bits takes some 300 ns for each, a process image of 64 bytes 10 us. Let the
 * controller of the bus end an access that never ends, or let the board's watchdog do it.
 *
 * The processor must see the ESC as device memory: not cached, not reordered, not merged.
 *
 * **Context**: as in seams/pdi.h.
 */
#ifndef ECT_PORTS_MMIO_H
#define ECT_PORTS_MMIO_H

#include <stdbool.h>
#include <stdint.h>

#include "seams/pdi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** One ESC. 0 and NULL are valid unless a member requires another value. */
typedef struct ect_mmio {
    volatile void *base; /**< address 0 of the ESC; a multiple of the width. Required without `load` */
    uint8_t width;       /**< of the bus, in bytes: 1, 2, 4; 0: 4 */

    /**
     * In place of the processor's own access to `base`, for a bus that needs more than that: shifted addresses, swapped
     * lanes, a barrier, a bus that may fail. `bytes` is 1, 2, 4 up to the width, `address` a multiple of it; `*value`
     * holds the byte of the lowest address in its lowest eight bits. @return 0, or negative: it did not happen
     */
    int (*load)(void *ctx, uint16_t address, unsigned int bytes, uint32_t *value);
    int (*store)(void *ctx, uint16_t address, unsigned int bytes, uint32_t value); /**< both or none of the two */

    /** Whether the ESC's interrupt pin is at its active level now: the level, not an edge. NULL: it is not wired. */
    bool (*line)(void *ctx);
    void *ctx; /**< of these functions */
} ect_mmio_t;

/**
 * Whether the ESC has loaded its EEPROM and lets its PDI work (0x0110 bit 0), and is there at all: an empty bus
 * reads as all ones or zeros. Repeat it until it returns true, then call ::ect_slave_init. Context: mainline. Cost:
 * two accesses.
 */
bool ect_mmio_ready(const ect_mmio_t *esc);

/** The PDI of the ESC. @param esc  must outlive its use */
ect_pdi_t ect_mmio_pdi(const ect_mmio_t *esc);

ECT_C_END

#endif
