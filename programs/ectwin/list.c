/* SPDX-License-Identifier: MIT */
#include "bus/chain/catalogue.h"
#include "commands.h"
#include "products.h"

static error_t parse(int key, char *text, struct argp_state *state)
{
    const char **file = state->input;
    if (key != ARGP_KEY_ARG)
        return ARGP_ERR_UNKNOWN;
    *file = text;
    if (!product_file(text))
        argp_error(state, "'%s' is none of esi:FILE.xml, sii:FILE, yaml:FILE", text);
    return 0;
}

int command_list(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "[esi:FILE.xml|sii:FILE|yaml:FILE]",
        .doc = "Lists the devices: name, input and output bytes of the master, description. "
               "For an ESI file: type, @product/revision, name, and the number of its slots, start-up commands, "
               "alternative PDO assignments and EEPROM categories."};
    const char *file = NULL;
    argp_parse(&argp, argc, argv, 0, NULL, &file);
    if (file) {
        char message[PRODUCT_MESSAGE];
        if (product_list_file(file, message))
            return EXIT_CLEAN;
        fprintf(stderr, "ectwin list: %s\n", message);
        return EXIT_OPEN;
    }
    const ect_product_t *product;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        const ect_device_t *d = product->device;
        printf("%-20s %3u/%-3u  %s\n", d->name, ect_device_bytes(d, ECT_SM_INPUTS), ect_device_bytes(d, ECT_SM_OUTPUTS),
               d->summary);
    }
    return EXIT_CLEAN;
}
