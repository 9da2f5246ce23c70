/* SPDX-License-Identifier: MIT */
/* Callbacks for the source that `ectwin new examples/new/gauge.yaml` writes: the distance follows the command. */
#include "ecat_slv.h"
#include "ports/soes_hal/ectwin_soes.h"
#include "utypes.h"

void cb_get_inputs(void)
{
    Obj.v6000_00 = 1000 * Obj.v7000_00;
}

void cb_set_outputs(void)
{
}

esc_cfg_t *ectwin_soes_config(void)
{
    static esc_cfg_t config = {.watchdog_cnt = 2000};
    return &config;
}

int main(int argc, char **argv)
{
    return ectwin_soes_main(argc, argv);
}
