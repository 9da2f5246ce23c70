/* SPDX-License-Identifier: MIT */
/* Bus files with any bytes: each is refused with one line, or becomes words. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "buses/bus_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The option's name chooses its kind: each kind is reached. */
static unsigned int find(void *ctx, const char *name)
{
    (void)ctx;
    switch (*name) {
    case 'b':
        return ECT_BUS_OPTION_FLAG;
    case 's':
        return ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_PATH;
    case 'a':
        return ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_OF_TWIN;
    case 'c':
    case 'f':
        return ECT_BUS_OPTION_VALUE;
    default:
        return ECT_BUS_OPTION_NONE;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char why[200] = "";
    ect_bus_file_t file;
    const ect_bus_options_t options = {.find = find};
    bool fine = ect_bus_file_parse(&file, "folder/bus.yaml", data, size, &options, why, sizeof why);
    if (fine ? file.devices == NULL || file.twins == 0 : why[0] == '\0' || strchr(why, '\n') != NULL)
        abort();
    ect_bus_file_free(&file);
    return 0;
}
