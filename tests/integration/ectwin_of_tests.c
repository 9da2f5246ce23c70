/* SPDX-License-Identifier: MIT */
/* The whole command with the devices that are made for tests. */
#include "ectwin.h"
#include "support/gauge.h"
#include "support/terminal.h"

int main(int argc, char **argv)
{
    static const ect_product_t products[] = {{&terminal, NULL}, {&gauge, NULL}};
    return ectwin_main(argc, argv, products, sizeof products / sizeof products[0]);
}
