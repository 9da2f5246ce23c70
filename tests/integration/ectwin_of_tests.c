/* SPDX-License-Identifier: MIT */
/* The whole command with the devices that are made for tests. */
#include "ectwin.h"
#include "support/eoedev.h"
#include "support/filedev.h"
#include "support/gauge.h"
#include "support/liardev.h"
#include "support/terminal.h"

enum { PRODUCTS_MOST = 32 };

int main(int argc, char **argv)
{
    ect_product_t products[PRODUCTS_MOST] = {
        {&terminal, NULL}, {&gauge, NULL}, {eoedev(false), NULL}, {eoedev(true), NULL}, {filedev_hesitant(), NULL}};
    size_t count = 5;
    for (size_t i = 0; count < PRODUCTS_MOST && liardev(i) != NULL; i++)
        products[count++] = (ect_product_t){liardev(i), NULL};
    return ectwin_main(argc, argv, products, count);
}
