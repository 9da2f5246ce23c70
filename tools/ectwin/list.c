/* SPDX-License-Identifier: MIT */
#include "bus/catalogue.h"
#include "commands.h"

int command_list(int argc, char **argv)
{
    static const struct argp argp = {
        .doc = "Lists the devices: name, input/output bytes as the master sees them, what it is."};
    argp_parse(&argp, argc, argv, 0, NULL, NULL);
    const ect_product_t *product;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        const ect_device_t *d = product->device;
        printf("%-20s %3u/%-3u  %s\n", d->name, ect_device_bytes(d, ECT_SM_INPUTS), ect_device_bytes(d, ECT_SM_OUTPUTS),
               d->summary);
    }
    return EXIT_CLEAN;
}
