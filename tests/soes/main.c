/* SPDX-License-Identifier: MIT */
/* The tests' application as a twin on a PC. */
#include "app.h"
#include "ports/soes_hal/ectwin_soes.h"

static void echo(void)
{
    app.buttons[0] = app.lamps[1];
    app.buttons[1] = app.lamps[0];
}

esc_cfg_t *ectwin_soes_config(void)
{
    static esc_cfg_t config = {.watchdog_cnt = 2000, .application_hook = echo};
    return &config;
}

int main(int argc, char **argv)
{
    return ectwin_soes_main(argc, argv);
}
