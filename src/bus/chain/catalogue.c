/* SPDX-License-Identifier: MIT */
#include "bus/chain/catalogue.h"

#include <string.h>

#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "devices/optoncdt2300/optoncdt2300.h"
#include "devices/pmctendo/pmctendo.h"

static const ect_product_t products[] = {
    {&ect_eclink_map1, &ect_eclink_plant},
    {&ect_eclink_map3, &ect_eclink_plant},
    {&ect_eclink_map7, &ect_eclink_plant},
    {&ect_eclink_multiarm, &ect_eclink_plant},
    {&ect_fzm1, &ect_fzm1_plant},
    {&ect_optoncdt2300, &ect_optoncdt2300_plant},
    {&ect_pmctendo_dd5, &ect_pmctendo_dd5_plant},
};

static const ect_product_t *added;
static size_t added_count;

const ect_product_t *ect_catalogue_at(size_t index)
{
    const size_t ours = sizeof products / sizeof products[0];
    if (index < ours)
        return &products[index];
    return index - ours < added_count ? &added[index - ours] : NULL;
}

const ect_product_t *ect_catalogue_find(const char *name)
{
    const ect_product_t *product;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        if (strcmp(product->device->name, name) == 0)
            return product;
    }
    return NULL;
}

void ect_catalogue_add(const ect_product_t *more, size_t count)
{
    added = more;
    added_count = count;
}
