/* SPDX-License-Identifier: MIT */
/* A normal SOES application, whose device is selected by CMake. */
#include "board.h"
#include "firmware.h"

__attribute__((weak)) _Noreturn void board_fault(void)
{
    const ect_leds_t *leds = board_leds();
    for (;;) {
        if (leds->err)
            leds->err(leds->ctx, true);
    }
}

_Noreturn void firmware_stop(void)
{
    board_fault();
}

int main(int argc, char **argv)
{
    board_init(argc, argv);
    ecat_slv_init(firmware_config());
    for (;;) {
        ecat_slv();
        board_turn(firmware_turn());
    }
}
