/* SPDX-License-Identifier: MIT */
#include "support/every.h"

#include "bus/catalogue.h"
#include "support/testdev.h"

const ect_device_t *every_device(size_t i)
{
    return i == 0 ? &testdev : every_product(i - 1);
}

const ect_device_t *every_product(size_t i)
{
    const ect_product_t *product = ect_catalogue_at(i);
    return product ? product->device : NULL;
}

const ect_plant_t *plant_of(const ect_device_t *device)
{
    const ect_product_t *product;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        if (product->device == device)
            return product->plant;
    }
    return NULL;
}
