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
    size_t count;
    const ect_product_t *products = ect_catalogue(&count);
    return i < count ? products[i].device : NULL;
}

const ect_plant_t *plant_of(const ect_device_t *device)
{
    size_t count;
    const ect_product_t *products = ect_catalogue(&count);
    for (size_t i = 0; i < count; i++) {
        if (products[i].device == device)
            return products[i].plant;
    }
    return NULL;
}
