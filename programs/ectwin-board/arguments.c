/* SPDX-License-Identifier: MIT */
#include "arguments.h"
#include "text/argument.h"

#include <argp.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

enum {
    KEY_IRQ = 256,
    KEY_IRQ_HIGH,
    KEY_RESET,
    KEY_RUN,
    KEY_ERR,
    KEY_POLL,
    KEY_STORE,
    KEY_EEPROM,
    KEY_ALIAS,
    KEY_SERIAL
};
enum { DEFAULT_HZ = 20000000, LARGEST_HZ = 30000000, SMALLEST_HZ = 100000, DEFAULT_POLL_US = 250 };

static const struct argp_option options[] = {
    {NULL, 0, NULL, 0, "The chip:", 1},
    {"spi", 's', "DEVICE", 0, "SPI device of the chip (default /dev/spidev0.0)", 1},
    {"speed", 'f', "HZ", 0, "SPI clock, 100000 to 30000000 (default 20000000)", 1},
    {"irq", KEY_IRQ, "CHIP:LINE", 0,
     "GPIO line of the chip's interrupt pin, e.g. gpiochip0:25 (default: poll the chip)", 1},
    {"irq-high", KEY_IRQ_HIGH, NULL, 0, "The interrupt pin is active high, push-pull (default: active low, open drain)",
     1},
    {"reset", KEY_RESET, "CHIP:LINE", 0, "GPIO line of the chip's reset pin, active low (default: reset by register)",
     1},
    {"poll", KEY_POLL, "US", 0, "Interval of polls without --irq, microseconds, 50 to 10000 (default 250)", 1},
    {NULL, 0, NULL, 0, "The device:", 2},
    {"store", KEY_STORE, "DIR", 0, "Keep saved parameters in this folder (default: in memory, until the end)", 2},
    {"alias", KEY_ALIAS, "N", 0, "Explicit device id, 1 to 65535", 2},
    {"serial", KEY_SERIAL, "N", 0, "Serial number in 1018h", 2},
    {"run-led", KEY_RUN, "CHIP:LINE", 0, "GPIO line of a RUN lamp (default: the chip's own)", 2},
    {"err-led", KEY_ERR, "CHIP:LINE", 0, "GPIO line of an ERR lamp", 2},
    {"eeprom", KEY_EEPROM, "FILE", 0, "Write the image for the chip's EEPROM to FILE, and exit", 2},
    {0},
};

static uint32_t number(const struct argp_state *state, const char *name, const char *text, uint32_t least,
                       uint32_t most)
{
    return (uint32_t)ect_argument_number(state, name, text, least, most);
}

static void take_device(arguments_t *args, const struct argp_state *state, const char *name)
{
    const ect_product_t *known;
    if (args->product)
        argp_error(state, "a board is one device");
    args->product = ect_catalogue_find(name);
    if (args->product)
        return;
    fprintf(stderr, "%s: there is no device '%s'; there are:", state->name, name);
    for (size_t n = 0; (known = ect_catalogue_at(n)); n++)
        fprintf(stderr, " %s", known->device->name);
    fputc('\n', stderr);
    exit(argp_err_exit_status);
}

static error_t parse_chip(int key, char *text, struct argp_state *state)
{
    arguments_t *args = state->input;
    switch (key) {
    case 's':
        args->spi = text;
        return 0;
    case 'f':
        args->speed_hz = number(state, "--speed", text, SMALLEST_HZ, LARGEST_HZ);
        return 0;
    case KEY_IRQ:
        args->interrupt = text;
        return 0;
    case KEY_IRQ_HIGH:
        args->interrupt_high = true;
        return 0;
    case KEY_RESET:
        args->reset = text;
        return 0;
    case KEY_POLL:
        args->poll_us = number(state, "--poll", text, 50, 10000);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse_device(int key, char *text, struct argp_state *state)
{
    arguments_t *args = state->input;
    switch (key) {
    case KEY_STORE:
        args->store = text;
        return 0;
    case KEY_ALIAS:
        args->alias = (uint16_t)number(state, "--alias", text, 1, UINT16_MAX);
        return 0;
    case KEY_SERIAL:
        args->serial = number(state, "--serial", text, 1, UINT32_MAX);
        return 0;
    case KEY_RUN:
        args->run_led = text;
        return 0;
    case KEY_ERR:
        args->err_led = text;
        return 0;
    case KEY_EEPROM:
        args->eeprom = text;
        return 0;
    default:
        return parse_chip(key, text, state);
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    const arguments_t *args = state->input;
    if (key == ARGP_KEY_ARG) {
        take_device(state->input, state, text);
        return 0;
    }
    if (key == ARGP_KEY_END) {
        if (!args->product)
            argp_error(state, "name the device that the board is, e.g. fzm1");
        return 0;
    }
    return parse_device(key, text, state);
}

arguments_t read_arguments(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "DEVICE",
        .doc = "Runs one of ectwin's devices with an EtherCAT slave controller LAN9252 on SPI, e.g. on a Raspberry Pi "
               "with a "
               "HAT, until SIGINT, SIGTERM or SIGHUP.",
    };
    arguments_t args = {.spi = "/dev/spidev0.0", .speed_hz = DEFAULT_HZ, .poll_us = DEFAULT_POLL_US};
    argp_err_exit_status = 1;
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    return args;
}
