/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SPI on Linux, through spidev (`/dev/spidevB.C`), with GPIO lines for reset and interrupt: the four functions of
 * seams/spi.h.
 *
 * A transfer is one system call, with 10 to 50 us in the kernel in addition to the time of the bytes.
 */
#ifndef ECT_PORTS_LINUX_SPIDEV_H
#define ECT_PORTS_LINUX_SPIDEV_H

#include <stdint.h>

#include "ports/linux/gpio.h"
#include "seams/spi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** One chip on a bus. */
typedef struct ect_spidev {
    int fd;
    uint32_t speed_hz;
    int reset; /**< of ::ect_gpio_open, an output; -1: not wired */
    int line;  /**< an input; -1: not wired */
} ect_spidev_t;

/**
 * Opens the bus, in mode 0 with 8 bits. The caller sets the GPIO lines.
 * @param[out] message  on failure one line for the user; ECT_LINUX_MESSAGE bytes
 * @return whether the bus is open; ::ect_spidev_close closes the bus and its lines
 */
bool ect_spidev_open(ect_spidev_t *bus, const char *path, uint32_t speed_hz, char *message);

/** Closes the open descriptors; a second call has no effect. */
void ect_spidev_close(ect_spidev_t *bus);

/** @return the four functions; `bus` must outlive their use, and its lines must be set before. */
ect_spi_t ect_spidev_spi(ect_spidev_t *bus);

ECT_C_END

#endif
