/* SPDX-License-Identifier: MIT */
/**
 * @file
 * One line of a GPIO chip on Linux, through the kernel's character device (`/dev/gpiochipN`, Linux 5.10 or later).
 * `gpioinfo` of the package gpiod lists the lines.
 */
#ifndef ECT_PORTS_LINUX_GPIO_H
#define ECT_PORTS_LINUX_GPIO_H

#include <stdbool.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_LINUX_MESSAGE = 256 };

/** Use of a line: one of the first two, with any of the others. */
enum {
    ECT_GPIO_INPUT = 1,  /**< the descriptor becomes readable (poll) when the line becomes active */
    ECT_GPIO_OUTPUT = 2, /**< initially inactive */
    ECT_GPIO_LOW = 4,    /**< active is low */
    ECT_GPIO_PULL_UP = 8,
    ECT_GPIO_PULL_DOWN = 16,
};

/**
 * Takes a line exclusively for this process.
 * @param name          "CHIP:LINE", e.g. "gpiochip0:25"
 * @param use           ECT_GPIO_...
 * @param[out] message  on failure one line for the user; ECT_LINUX_MESSAGE bytes
 * @return a descriptor, to be closed by the caller, or -1
 */
int ect_gpio_open(const char *name, unsigned int use, char *message);

/** @return whether the line is active. A line that cannot be read counts as active, so that the ESC is read. */
bool ect_gpio_get(int line);

void ect_gpio_set(int line, bool active);

/** Reads all edges that made an input readable. */
void ect_gpio_seen(int line);

ECT_C_END

#endif
