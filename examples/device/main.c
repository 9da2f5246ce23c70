/* SPDX-License-Identifier: MIT */
/* The complete `ectwin` command, with one more device. */
#include "ectwin.h"
#include "heater.h"

int main(int argc, char **argv)
{
    static const ect_product_t products[] = {{&heater, &heater_plant}};
    return ectwin_main(argc, argv, products, 1);
}
