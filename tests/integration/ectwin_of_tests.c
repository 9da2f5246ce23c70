/* SPDX-License-Identifier: MIT */
/* The whole command with the devices that are made for tests. */
#include "ectwin.h"
#include "support/eoedev.h"
#include "support/filedev.h"
#include "support/gauge.h"
#include "support/terminal.h"

int main(int argc, char **argv)
{
    const ect_product_t products[] = {
        {&terminal, NULL}, {&gauge, NULL}, {eoedev(false), NULL}, {eoedev(true), NULL}, {filedev_hesitant(), NULL}};
    return ectwin_main(argc, argv, products, sizeof products / sizeof products[0]);
}
