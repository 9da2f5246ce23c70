/* SPDX-License-Identifier: MIT */
/* The whole command with the devices that are made for tests. */
#include "devices_of_tests.h"
#include "ectwin.h"

int main(int argc, char **argv)
{
    ect_product_t products[DEVICES_OF_TESTS_MOST];
    size_t count = devices_of_tests(products);
    return ectwin_main(argc, argv, products, count);
}
