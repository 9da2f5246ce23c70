/* SPDX-License-Identifier: MIT */
/* The whole `ectwin` command, with one device more. */
#include "ectwin.h"
#include "heater.h"

int main(int argc, char **argv)
{
    static const ect_product_t products[] = {{&heater, &heater_plant}};
    return ectwin_main(argc, argv, products, 1);
}
