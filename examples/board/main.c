/* SPDX-License-Identifier: MIT */
/* The heater as a firmware: the same description and the same code as the twin, behind a real ESC. */
#include "board.h"
#include "heater.h"
#include "slave/slave.h"

enum { MAILBOX = 3 * 128, PROCESS_DATA = 3, RUNS = 2, STAGING = 2 };

static ect_slave_t slave;
static heater_t instance;
static uint8_t mailbox[MAILBOX];
static uint8_t process_data[PROCESS_DATA];
static ect_pdo_run_t runs[RUNS];
static uint8_t staging[STAGING];

static bool enough(void)
{
    ect_slave_memory_t need = ect_slave_memory(&heater);
    return need.instance <= sizeof instance && need.mailbox <= sizeof mailbox &&
           need.process_data <= sizeof process_data && need.runs <= RUNS && need.staging <= sizeof staging;
}

int main(void)
{
    const ect_pdi_t pdi = ect_template_pdi(&board_window);
    const ect_slave_config_t config = {
        .device = &heater,
        .pdi = &pdi,
        .instance = &instance,
        .mailbox = mailbox,
        .process_data = process_data,
        .process_size = PROCESS_DATA,
        .runs = runs,
        .run_count = RUNS,
        .staging = staging,
        .staging_size = STAGING,
    };
    if (!enough()) /* the arrays above are too small for the description */
        return 1;
    while (ect_slave_init(&slave, &config, board_now_ns()) != 0)
        board_alive(); /* the ESC is still loading its EEPROM */
    while (!slave.restart) {
        instance.sensed = board_temperature();
        (void)ect_slave_poll(&slave, board_now_ns());
        board_heat(instance.power);
        board_alive();
    }
    board_reset();
    return 0;
}
