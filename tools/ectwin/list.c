/* SPDX-License-Identifier: MIT */
#include "bus/catalogue.h"
#include "commands.h"

static unsigned int bytes_of(const ect_device_t *device, uint8_t type)
{
    for (unsigned int i = 0; i < device->sm_count; i++) {
        if (device->sm[i].type == type)
            return device->sm[i].length;
    }
    return 0;
}

int command_list(int argc, char **argv)
{
    static const struct argp argp = {
        .doc = "Lists the devices: name, input/output bytes as the master sees them, what it is."};
    argp_parse(&argp, argc, argv, 0, NULL, NULL);
    size_t count;
    const ect_product_t *products = ect_catalogue(&count);
    for (size_t i = 0; i < count; i++) {
        const ect_device_t *d = products[i].device;
        printf("%-20s %3u/%-3u  %s\n", d->name, bytes_of(d, ECT_SM_INPUTS), bytes_of(d, ECT_SM_OUTPUTS), d->summary);
    }
    return EXIT_CLEAN;
}
