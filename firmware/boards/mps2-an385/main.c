/* SPDX-License-Identifier: MIT */
/* One of the devices, chosen at configure time, on a microcontroller with nothing but an Ethernet controller. */
#include FIRMWARE_HEADER

#include <stdlib.h>

#include "board.h"
#include "controller.h"
#include "cpu.h"
#include "sii/sii.h"
#include "slave/slave.h"

static const ect_device_t *const device = &FIRMWARE_DEVICE;

static ect_slave_t slave;

/* --- memory: what the description asks for, taken once from the board's plenty ---------------------------------------
 */

static uint64_t memory[(2u << 20) / sizeof(uint64_t)];
static size_t taken;

static void *take(size_t bytes)
{
    size_t words = (bytes + sizeof memory[0] - 1) / sizeof memory[0];
    if (words > sizeof memory / sizeof memory[0] - taken)
        return NULL;
    taken += words;
    return &memory[taken - words];
}

static ect_slave_config_t configuration(void)
{
    ect_slave_memory_t need = ect_slave_memory(device);
    return (ect_slave_config_t){
        .device = device,
        .pdi = controller_pdi(),
        .instance = take(need.instance),
        .mailbox = take(need.mailbox),
        .process_data = take(need.process_data),
        .process_size = (uint16_t)need.process_data,
        .runs = take(need.runs * sizeof(ect_pdo_run_t)),
        .run_count = (uint16_t)need.runs,
        .staging = take(need.staging),
        .staging_size = (uint16_t)need.staging,
        .buffer = take(need.buffer),
    };
}

/* --- what is told on the serial line
 * ----------------------------------------------------------------------------------- */

static const char *name_of(uint8_t state)
{
    switch (state) {
    case ECT_STATE_INIT:
        return "INIT\n";
    case ECT_STATE_PREOP:
        return "PREOP\n";
    case ECT_STATE_SAFEOP:
        return "SAFEOP\n";
    case ECT_STATE_OP:
        return "OP\n";
    default:
        return "?\n";
    }
}

static void tell_state(void)
{
    static uint8_t told;
    if (slave.state == told)
        return;
    told = slave.state;
    board_print(name_of(told));
}

static _Noreturn void stop(const char *why)
{
    board_print(why);
    for (;;)
        cpu_sleep();
}

int main(void)
{
    board_init();
    if (ect_sii_write(device, NULL, 0, controller_sii(), CONTROLLER_SII) < 0)
        stop("the EEPROM is too small\n");
    if (controller_init(ect_esc_personality(device->esc), device->sii_size) != CONTROLLER_OK)
        stop("the Ethernet controller does not answer\n");
    const ect_slave_config_t config = configuration();
    if (ect_slave_init(&slave, &config, board_now_ns()) != 0)
        stop("there is not enough memory\n");
    board_print(device->name);
    board_print("\n");
    while (!slave.restart) {
        uint64_t next_ns = ect_slave_poll(&slave, board_now_ns());
        tell_state();
        controller_wait(next_ns);
    }
    return 0;
}
