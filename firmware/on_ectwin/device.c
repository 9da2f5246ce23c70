/* SPDX-License-Identifier: MIT */
/* The device on ectwin's stack, which uses the description directly, in place of an object list (soes/internal.h). */
#include <stddef.h>
#include <string.h>

#include "board.h"
#include "firmware.h"
#include "slave/indicator.h"
#include "soes/describe.h"
#include "soes/ect_soes.h"
#include "soes/internal.h"
#include "wire/assert.h"

static ect_identity_t identity;

/* The memory of the slave, by its description. The firmware does not start if FIRMWARE_MEMORY is too small. */
static max_align_t memory[(FIRMWARE_MEMORY + sizeof(max_align_t) - 1) / sizeof(max_align_t)];
static size_t used;

static bool fits(size_t bytes)
{
    return bytes <= sizeof memory - used * sizeof memory[0];
}

static void *take(void *ctx, size_t bytes)
{
    void *taken = &memory[used];
    (void)ctx;
    if (!fits(bytes))
        firmware_stop(); /* FIRMWARE_MEMORY is too small: a mistake in the configuration */
    used += (bytes + sizeof memory[0] - 1) / sizeof memory[0];
    return taken;
}

ect_slave_config_t ect_soes_slave_config(void)
{
    const ect_device_t *device = firmware_device();
    identity = device->identity;
    identity.serial = board_serial() != 0 ? board_serial() : identity.serial;
    ect_slave_config_t config = {
        .device = device,
        .pdi = board_pdi(),
        .identity = &identity,
        .storage = board_storage(),
        .switches = board_switches(),
    };
    (void)ect_slave_take(&config, take, NULL); /* stops if the memory is too small */
    if (device->buffer_size > 0 && fits(device->buffer_size))
        config.buffer = take(NULL, device->buffer_size); /* which is optional */
    return config;
}

/* Outputs and inputs in one call of the stack. */
void ect_soes_outputs(void)
{
    ect_slave_cycle(&ect_soes.slave, ect_soes_now());
}

void ect_soes_inputs(void)
{
}

/* A hardware file with a software ESC makes the EEPROM from this description. */
void ect_soes_describe(ect_device_t *to)
{
    *to = *firmware_device();
}

esc_cfg_t *firmware_config(void)
{
    static esc_cfg_t config; /* the device's functions are its hooks, the ESC's watchdog is its watchdog */
    ect_soes_clock(board_now_ns);
    return &config;
}

uint64_t firmware_turn(void)
{
    const ect_slave_t *slave = &ect_soes.slave;
    uint64_t lamps_ns = ect_indicator_drive(slave, board_leds(), false, board_now_ns());
    if (slave->restart)
        board_reset();
    uint64_t slave_ns = ect_soes_due();
    return slave_ns < lamps_ns ? slave_ns : lamps_ns;
}
