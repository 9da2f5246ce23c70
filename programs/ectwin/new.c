/* SPDX-License-Identifier: MIT */
/* `ectwin new`: all files made from a device file, in one folder. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "products.h"

static const char who[] = "ectwin new";

static const struct argp_option options[] = {
    {"output", 'o', "DIR", 0, "Write to folder DIR, created if necessary (default: the device's type)", 0},
    {0},
};

typedef struct arguments {
    const char *file;
    const char *folder;
} arguments_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments_t *args = state->input;
    switch (key) {
    case 'o':
        args->folder = text;
        return 0;
    case ARGP_KEY_ARG:
        if (args->file)
            argp_error(state, "one device file at a time");
        args->file = text;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "name a device file: DEVICE.yaml");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* "DIR/gauge-1.xml". */
static bool path_of(const ect_twin_config_t *twin, const char *folder, const char *ending, char path[OUTPUT_PATH])
{
    char name[128];
    snprintf(name, sizeof name, "%.100s%s", twin->device->name, ending);
    return output_path(who, path, folder, name);
}

static int write_image(const ect_twin_config_t *twin, const char *path)
{
    uint8_t *image = output_image(who, twin);
    int status = image ? output_save(who, path, image, twin->device->sii_size) : EXIT_RUN;
    free(image);
    return status;
}

static int write_one(const ect_twin_config_t *twin, size_t which, const char *path)
{
    switch (which) {
    case 0:
        return output_esi(who, twin, path);
    case 1:
        return write_image(twin, path);
    case 2:
        return output_hex(who, twin, path);
    default:
        return output_document(who, twin, which == 4, path);
    }
}

static int write_files(const ect_twin_config_t *twin, const char *folder)
{
    static const struct {
        const char *ending, *what;
    } files[] = {
        {".xml", "ESI file, for engineering tools"},
        {".bin", "EEPROM image"},
        {".hex", "EEPROM image as Intel HEX"},
        {".md", "manual"},
        {".html", "manual, with links"},
    };
    char path[OUTPUT_PATH];
    int status = EXIT_CLEAN;
    for (size_t i = 0; i < sizeof files / sizeof files[0] && status == EXIT_CLEAN; i++) {
        status = path_of(twin, folder, files[i].ending, path) ? write_one(twin, i, path) : EXIT_OPEN;
        if (status == EXIT_CLEAN)
            printf("%-32s %s\n", path, files[i].what);
    }
    return status;
}

static int write_source(const ect_twin_config_t *twin, const char *folder)
{
    char path[OUTPUT_PATH];
    if (!output_suits_soes(twin->device)) {
        fprintf(stderr, "%s: %s does not have the SyncManagers of a SOES slave: no C source is written\n", who,
                twin->device->name);
        return EXIT_CLEAN;
    }
    if (!output_path(who, path, folder, "soes"))
        return EXIT_OPEN;
    int status = output_soes(who, twin, path);
    if (status == EXIT_CLEAN)
        printf("%-32s C source for SOES\n", path);
    return status;
}

int command_new(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "DEVICE.yaml",
        .doc =
            "Writes all files of a device of your own from its device file, or from a project of the EEPROM generator "
            "(esi.json): ESI file, EEPROM image, manual, and C source for SOES. 'ectwin with yaml:DEVICE.yaml' runs it "
            "as a twin.",
    };
    arguments_t args = {.file = NULL};
    char message[PRODUCT_MESSAGE] = "out of memory";
    char *name = NULL;
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    bool named = asprintf(&name, "%s%s", product_file(args.file) ? "" : "yaml:", args.file) > 0;
    const ect_product_t *product = named ? product_find(name, NULL, 0, ECT_BEHAVIOUR_BY_FILE, message) : NULL;
    if (!product) {
        fprintf(stderr, "%s: %s\n", who, message);
        free(name);
        return EXIT_USAGE;
    }
    ect_twin_config_t twin = ect_twin_default(product->device, product->plant);
    const char *folder = args.folder ? args.folder : product->device->name;
    twin.identity.serial = 1;
    int status = write_files(&twin, folder);
    if (status == EXIT_CLEAN)
        status = write_source(&twin, folder);
    if (status == EXIT_CLEAN)
        printf("Run it: ectwin with %s -- ./my_master {}\n", name);
    free(name);
    return status;
}
