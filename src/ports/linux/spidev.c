/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "ports/linux/spidev.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

static int transfer(void *ctx, uint8_t *bytes, uint16_t length)
{
    const ect_spidev_t *bus = ctx;
    struct spi_ioc_transfer t = {.tx_buf = (uintptr_t)bytes,
                                 .rx_buf = (uintptr_t)bytes,
                                 .len = length,
                                 .speed_hz = bus->speed_hz,
                                 .bits_per_word = 8};
    return ioctl(bus->fd, SPI_IOC_MESSAGE(1), &t) == length ? 0 : -1;
}

static void reset(void *ctx, bool active)
{
    ect_gpio_set(((const ect_spidev_t *)ctx)->reset, active);
}

static bool line(void *ctx)
{
    return ect_gpio_get(((const ect_spidev_t *)ctx)->line);
}

static void pause_us(void *ctx, uint32_t us)
{
    const struct timespec time = {.tv_sec = (time_t)(us / 1000000), .tv_nsec = (long)(us % 1000000) * 1000};
    (void)ctx;
    (void)nanosleep(&time, NULL);
}

bool ect_spidev_open(ect_spidev_t *bus, const char *path, uint32_t speed_hz, char *message)
{
    uint8_t mode = SPI_MODE_0;
    *bus = (ect_spidev_t){.fd = open(path, O_RDWR | O_CLOEXEC), .speed_hz = speed_hz, .reset = -1, .line = -1};
    if (bus->fd >= 0 && ioctl(bus->fd, SPI_IOC_WR_MODE, &mode) >= 0 &&
        ioctl(bus->fd, SPI_IOC_WR_MAX_SPEED_HZ, &bus->speed_hz) >= 0)
        return true;
    const char *hint = errno == ENOENT   ? "; on a Raspberry Pi: dtparam=spi=on in config.txt"
                       : errno == EACCES ? "; on a Raspberry Pi the group spi has access"
                       : errno == ENOTTY ? "; it is no SPI device"
                                         : "";
    snprintf(message, ECT_LINUX_MESSAGE, "cannot use '%.80s': %s%s", path, strerror(errno), hint);
    ect_spidev_close(bus);
    return false;
}

void ect_spidev_close(ect_spidev_t *bus)
{
    int *const fds[] = {&bus->fd, &bus->reset, &bus->line};
    for (unsigned int n = 0; n < sizeof fds / sizeof fds[0]; n++) {
        if (*fds[n] >= 0)
            close(*fds[n]);
        *fds[n] = -1;
    }
}

ect_spi_t ect_spidev_spi(ect_spidev_t *bus)
{
    return (ect_spi_t){.ctx = bus,
                       .transfer = transfer,
                       .reset = bus->reset >= 0 ? reset : NULL,
                       .line = bus->line >= 0 ? line : NULL,
                       .pause = pause_us};
}
