/* SPDX-License-Identifier: MIT */
/** @file The devices that are made for tests, as products of the catalogue. */
#ifndef TESTS_INTEGRATION_DEVICES_OF_TESTS_H
#define TESTS_INTEGRATION_DEVICES_OF_TESTS_H

#include "bus/chain/catalogue.h"

enum { DEVICES_OF_TESTS_MOST = 32 };

/** Fills in the devices. @return their number */
size_t devices_of_tests(ect_product_t products[DEVICES_OF_TESTS_MOST]);

#endif
