/* SPDX-License-Identifier: MIT */
#include "bus/catalogue.h"

#include <string.h>

#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"

static const ect_product_t products[] = {
    {&ect_eclink_map1, &ect_eclink_plant}, {&ect_eclink_map3, &ect_eclink_plant},
    {&ect_eclink_map7, &ect_eclink_plant}, {&ect_eclink_multiarm, &ect_eclink_plant},
    {&ect_fzm1, &ect_fzm1_plant},
};

const ect_product_t *ect_catalogue(size_t *count)
{
    *count = sizeof products / sizeof products[0];
    return products;
}

const ect_product_t *ect_catalogue_find(const char *name)
{
    for (size_t i = 0; i < sizeof products / sizeof products[0]; i++) {
        if (strcmp(products[i].device->name, name) == 0)
            return &products[i];
    }
    return NULL;
}
