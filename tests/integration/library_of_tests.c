/* SPDX-License-Identifier: MIT */
/* The bus library with the devices that are made for tests, for `ectwin_of_tests with --in-process`. */
#include "devices_of_tests.h"

__attribute__((constructor)) static void add_devices(void)
{
    static ect_product_t products[DEVICES_OF_TESTS_MOST];
    ect_catalogue_add(products, devices_of_tests(products));
}
