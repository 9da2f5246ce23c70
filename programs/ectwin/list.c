/* SPDX-License-Identifier: MIT */
#include <inttypes.h>

#include "bus/chain/catalogue.h"
#include "commands.h"
#include "esi/modules.h"
#include "products.h"

/* Arguments of the command. */
typedef struct args {
    const char *file;
    bool modules;
} args_t;

enum { OPTION_MODULES = 1 };

static error_t parse(int key, char *text, struct argp_state *state)
{
    args_t *args = state->input;
    if (key == OPTION_MODULES)
        args->modules = true;
    else if (key == ARGP_KEY_END && args->modules && !args->file)
        argp_error(state, "--modules takes a modular device: ectwin list --modules esi:FILE.xml#TYPE");
    if (key == OPTION_MODULES || key == ARGP_KEY_END)
        return 0;
    if (key != ARGP_KEY_ARG)
        return ARGP_ERR_UNKNOWN;
    args->file = text;
    if (!product_file(text))
        argp_error(state, "'%s' is none of esi:FILE.xml, sii:FILE, yaml:FILE", text);
    return 0;
}

static int failed(const char *message)
{
    fprintf(stderr, "ectwin list: %s\n", message);
    return EXIT_OPEN;
}

/* Places that accept a module, as "1,3-8"; a star behind those that have it by default. */
static void print_places(const ect_esi_device_t *model, const ect_esi_module_t *module)
{
    const unsigned int count = ect_esi_places(model);
    const char *comma = "";
    for (unsigned int n = 0; n < count; n++) {
        if (!ect_esi_place_takes(model, n, module->ident))
            continue;
        const bool preset = ect_esi_preset(model, n) == module->ident;
        unsigned int last = n;
        while (last + 1 < count && ect_esi_place_takes(model, last + 1, module->ident) &&
               (ect_esi_preset(model, last + 1) == module->ident) == preset)
            last++;
        printf("%s%u", comma, n + 1);
        if (last > n)
            printf("-%u", last + 1);
        printf("%s", preset ? "*" : "");
        comma = ",";
        n = last;
    }
}

static bool is_taken(const ect_esi_device_t *model, const ect_esi_module_t *module)
{
    for (unsigned int n = 0; n < ect_esi_places(model); n++) {
        if (ect_esi_place_takes(model, n, module->ident))
            return true;
    }
    return false;
}

static int list_modules(const char *file)
{
    char message[PRODUCT_MESSAGE];
    product_quiet();
    const ect_product_t *product = product_find(file, NULL, 0, ECT_BEHAVIOUR_NONE, message);
    if (!product)
        return failed(message);
    const ect_esi_device_t *model = ect_esi_twin_model(product_twin(product));
    if (model->slot_count == 0) {
        (void)snprintf(message, sizeof message, "%s has no slots: it takes no modules", model->type);
        return failed(message);
    }
    for (size_t i = 0; i < model->module_count; i++) {
        const ect_esi_module_t *module = &model->modules[i];
        if (!is_taken(model, module))
            continue;
        printf("0x%08" PRIX32 "  %-24s %-12s slots ", module->ident, module->type,
               *module->module_class != '\0' ? module->module_class : "-");
        print_places(model, module);
        printf("  %s\n", module->name);
    }
    return EXIT_CLEAN;
}

int command_list(int argc, char **argv)
{
    static const struct argp_option options[] = {{"modules", OPTION_MODULES, NULL, 0,
                                                  "List the modules of a modular device: ident, type, class, the slots "
                                                  "that take it (*: has it by default), name",
                                                  0},
                                                 {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "[esi:FILE.xml[#TYPE]|sii:FILE|yaml:FILE]",
        .doc = "Lists the devices: name, input and output bytes of the master, description. "
               "For an ESI file: type, @product/revision, name, and the number of its slots, start-up commands, "
               "alternative PDO assignments and EEPROM categories."};
    args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (args.modules)
        return list_modules(args.file);
    if (args.file) {
        char message[PRODUCT_MESSAGE];
        return product_list_file(args.file, message) ? EXIT_CLEAN : failed(message);
    }
    const ect_product_t *product;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        const ect_device_t *d = product->device;
        printf("%-20s %3u/%-3u  %s\n", d->name, ect_device_bytes(d, ECT_SM_INPUTS), ect_device_bytes(d, ECT_SM_OUTPUTS),
               d->summary);
    }
    return EXIT_CLEAN;
}
