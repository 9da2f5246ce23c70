/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A memory-mapped ESC: an ET1100 or LAN9253 on a parallel bus, an IP core on an FPGA's bus, the ESC of an XMC4800.
 *
 * Address n of the ESC is at `base` + n. The port splits an access of the stack into the widest aligned bus accesses,
 * in ascending order, never wider than requested. A processor may split a wide access (32 bits on a bus of 16) if the
 * lower address comes first.
 *
 * The chip holds the bus until it is ready, so an access takes the time of the bus, and cannot fail. **Bound**:
 * accesses times bus time; an ET1100 on 16 bits takes about 300 ns for each, a process image of 64 bytes 10 us. The bus
 * controller or the board's watchdog must end an access that hangs.
 *
 * The processor must access the ESC as device memory: not cached, not reordered, not merged.
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
     * Replace the processor's own access to `base`, for a bus with shifted addresses, swapped lanes, barriers or
     * failing accesses. `bytes` is 1, 2 or 4 up to the width, `address` a multiple of `bytes`; the lowest eight bits of
     * `*value` are the byte of the lowest address. @return 0, or negative: the access has failed
     */
    int (*load)(void *ctx, uint16_t address, unsigned int bytes, uint32_t *value);
    int (*store)(void *ctx, uint16_t address, unsigned int bytes, uint32_t value); /**< set both functions or none */

    /** Returns whether the ESC's interrupt pin is at its active level: the level, not an edge. NULL: not wired. */
    bool (*line)(void *ctx);
    void *ctx; /**< of these functions */
} ect_mmio_t;

/**
 * Checks whether the ESC is present (an empty bus reads as all ones or zeros), has loaded its EEPROM, and has enabled
 * its PDI (0x0110 bit 0). Repeat the call until it returns true, then call ::ect_slave_init. Context: mainline. Cost:
 * two accesses.
 */
bool ect_mmio_ready(const ect_mmio_t *esc);

/** @return the PDI of the ESC. @param esc  must outlive its use */
ect_pdi_t ect_mmio_pdi(const ect_mmio_t *esc);

ECT_C_END

#endif
