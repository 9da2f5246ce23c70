/* SPDX-License-Identifier: MIT */
/* An ordinary SOES application. CMake has selected its device. */
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
