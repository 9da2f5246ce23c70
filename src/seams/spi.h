/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SPI: how a port reaches a chip behind a serial bus. Four functions around a board's own driver; on bare metal each is
 * a few lines, on Linux ports/linux has them.
 *
 * **Context**: as the port that uses it: mainline, and the interrupt in which ::ect_slave_cycle runs, never both at
 * once (seams/pdi.h). A bus that serves other chips too locks against those.
 */
#ifndef ECT_SEAMS_SPI_H
#define ECT_SEAMS_SPI_H

#include <stdbool.h>
#include <stdint.h>

typedef struct ect_spi {
    /** Handed to each function; owned by the board, must outlive the port that uses it. */
    void *ctx;

    /**
     * One transfer: selects the chip, sends `length` bytes (1..67) and puts into the place of each the one that came
     * back meanwhile, deselects the chip. Mode 0, most significant bit first, no gap that the chip would take for an
     * end. Ends in bounded time. Required.
     * @return 0, or negative: the bytes are then undefined, and the chip may or may not have seen them
     */
    int (*transfer)(void *ctx, uint8_t *bytes, uint16_t length);

    /** Puts the chip's reset pin to its active level, or lets it go. NULL: the pin is not wired. Mainline only. */
    void (*reset)(void *ctx, bool active);

    /** Whether the chip's interrupt pin is at its active level now: the level, not an edge. NULL: it is not wired. */
    bool (*line)(void *ctx);

    /** Lets at least so many microseconds pass. For the start of a chip only. Required; mainline only. */
    void (*pause)(void *ctx, uint32_t us);
} ect_spi_t;

#endif
