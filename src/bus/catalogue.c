/* SPDX-License-Identifier: MIT */
#include "bus/catalogue.h"

#include <string.h>

#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"

static const ect_device_t *const devices[] = {
    &ect_eclink_map1, &ect_eclink_map3, &ect_eclink_map7, &ect_eclink_multiarm, &ect_fzm1,
};

const ect_device_t *const *ect_catalogue(size_t *count)
{
    *count = sizeof devices / sizeof devices[0];
    return devices;
}

const ect_device_t *ect_catalogue_find(const char *name)
{
    for (size_t i = 0; i < sizeof devices / sizeof devices[0]; i++) {
        if (strcmp(devices[i]->name, name) == 0)
            return devices[i];
    }
    return NULL;
}
