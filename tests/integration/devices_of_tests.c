/* SPDX-License-Identifier: MIT */
#include "devices_of_tests.h"

#include "support/eoedev.h"
#include "support/filedev.h"
#include "support/gauge.h"
#include "support/liardev.h"
#include "support/soedev.h"
#include "support/tally.h"
#include "support/terminal.h"

size_t devices_of_tests(ect_product_t products[DEVICES_OF_TESTS_MOST])
{
    const ect_device_t *const own[] = {&terminal,          &gauge,  eoedev(false), eoedev(true),
                                       filedev_hesitant(), &soedev, &tally};
    size_t count = 0;
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++)
        products[count++] = (ect_product_t){own[i], NULL};
    for (size_t i = 0; count < DEVICES_OF_TESTS_MOST && liardev(i) != NULL; i++)
        products[count++] = (ect_product_t){liardev(i), NULL};
    return count;
}
