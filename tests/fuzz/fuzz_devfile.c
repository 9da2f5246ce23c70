/* SPDX-License-Identifier: MIT */
/* Device files with any bytes: each is refused with one line, or is a device with a right description. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "check/check.h"
#include "devfile/devfile.h"
#include "esi/twin.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char why[400] = "";
    char text[ECT_CHECK_TEXT];
    ect_esi_twin_t *twin = ect_esi_twin_take(ect_devfile_parse("folder/g.yaml", data, size, why, sizeof why), "", NULL,
                                             0, why, sizeof why);
    const ect_product_t *product = twin != NULL ? ect_esi_twin_product(twin) : NULL;
    if (product == NULL ? why[0] == '\0' || strchr(why, '\n') != NULL
                        : !ect_device_check(product->device, text, sizeof text) ||
                              !ect_plant_check(product->plant, product->device, text, sizeof text))
        abort();
    ect_esi_twin_free(twin);
    return 0;
}
