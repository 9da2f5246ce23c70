/* SPDX-License-Identifier: MIT */
/* The same with a main of its own, which has no idea of a command line. */
#include "ecat_slv.h"

int main(void)
{
    static esc_cfg_t config = {.user_arg = "/dev/esc", .watchdog_cnt = 2000};
    ecat_slv_init(&config);
    for (;;)
        ecat_slv();
}
