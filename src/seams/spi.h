/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SPI: the interface of a port to a chip behind a serial bus. Four functions around a board's own driver: a few lines
 * each on bare metal; ports/linux has the functions for Linux.
 *
 * **Context**: that of the port: mainline, and the interrupt in which ::ect_slave_cycle runs, never both at once
 * (seams/pdi.h). A driver whose bus serves further chips locks against those.
 */
#ifndef ECT_SEAMS_SPI_H
#define ECT_SEAMS_SPI_H

#include <stdbool.h>
#include <stdint.h>

/** The functions of a driver, and their context. */
typedef struct ect_spi {
    /** Passed to each function; owned by the board, must outlive the port that uses it. */
    void *ctx;

    /**
     * Executes one transfer: selects the chip, sends `length` bytes (1..67), replaces each by the byte that was
     * received at the same time, and deselects the chip. Mode 0, most significant bit first, without a pause in which
     * the chip is deselected. Ends in bounded time. Required.
     * @return 0, or negative: the bytes are then undefined, and the chip may or may not have received them
     */
    int (*transfer)(void *ctx, uint8_t *bytes, uint16_t length);

    /** Sets the chip's reset pin to its active level, or releases it. NULL: the pin is not wired. Mainline only. */
    void (*reset)(void *ctx, bool active);

    /** Returns whether the chip's interrupt pin has its active level: the level, not an edge. NULL: not wired. */
    bool (*line)(void *ctx);

    /** Waits at least `us` microseconds. Only used to start a chip. Required; mainline only. */
    void (*pause)(void *ctx, uint32_t us);
} ect_spi_t;

#endif
