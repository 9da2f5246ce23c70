/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "ports/linux/gpio.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum { PATH = 64 };

/* "CHIP:LINE" */
static bool parse(const char *name, char path[PATH], unsigned int *offset)
{
    const char *colon = strrchr(name, ':');
    char *end;
    if (!colon || colon == name || colon[1] < '0') /* a sign or a blank, which strtoul accepts */
        return false;
    unsigned long number = strtoul(colon + 1, &end, 10);
    const char *folder = *name == '/' ? "" : "/dev/";
    int length = snprintf(path, PATH, "%s%.*s", folder, (int)(colon - name), name);
    *offset = (unsigned int)number;
    return *end == 0 && number < 1024 && length < PATH;
}

static uint64_t flags_of(unsigned int use)
{
    uint64_t flags = (use & ECT_GPIO_OUTPUT) != 0 ? (uint64_t)GPIO_V2_LINE_FLAG_OUTPUT
                                                  : (uint64_t)GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING;
    flags |= (use & ECT_GPIO_LOW) != 0 ? (uint64_t)GPIO_V2_LINE_FLAG_ACTIVE_LOW : 0;
    flags |= (use & ECT_GPIO_PULL_UP) != 0 ? (uint64_t)GPIO_V2_LINE_FLAG_BIAS_PULL_UP : 0;
    flags |= (use & ECT_GPIO_PULL_DOWN) != 0 ? (uint64_t)GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN : 0;
    return flags;
}

int ect_gpio_open(const char *name, unsigned int use, char *message)
{
    struct gpio_v2_line_request request = {.num_lines = 1, .consumer = "ectwin"};
    char path[PATH];
    if (!parse(name, path, &request.offsets[0])) {
        snprintf(message, ECT_LINUX_MESSAGE, "'%.60s' names no GPIO line: CHIP:LINE, e.g. gpiochip0:25", name);
        return -1;
    }
    request.config.flags = flags_of(use);
    int chip = open(path, O_RDWR | O_CLOEXEC);
    int result = chip < 0 ? chip : ioctl(chip, GPIO_V2_GET_LINE_IOCTL, &request);
    if (result < 0)
        snprintf(message, ECT_LINUX_MESSAGE, "cannot take line %u of '%s': %s%s", request.offsets[0], path,
                 strerror(errno), errno == EACCES ? "; on a Raspberry Pi the group gpio has access" : "");
    if (chip >= 0)
        close(chip);
    return result < 0 ? -1 : request.fd;
}

bool ect_gpio_get(int line)
{
    struct gpio_v2_line_values values = {.mask = 1};
    return ioctl(line, GPIO_V2_LINE_GET_VALUES_IOCTL, &values) < 0 || (values.bits & 1) != 0;
}

void ect_gpio_set(int line, bool active)
{
    struct gpio_v2_line_values values = {.bits = active, .mask = 1};
    (void)ioctl(line, GPIO_V2_LINE_SET_VALUES_IOCTL, &values); /* the only consequence is a lamp that does not light */
}

void ect_gpio_seen(int line)
{
    struct gpio_v2_line_event events[16];
    struct pollfd more = {.fd = line, .events = POLLIN};
    while (poll(&more, 1, 0) == 1 && (more.revents & POLLIN) != 0 &&
           read(line, events, sizeof events) >= (ssize_t)sizeof events[0]) {
    }
}
