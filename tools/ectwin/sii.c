/* SPDX-License-Identifier: MIT */
#include "sii/sii.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"

typedef struct sii_args {
    twin_args_t twins;
    const char *device;
    const char *output;
} sii_args_t;

static const struct argp_option options[] = {
    {"output", 'o', "FILE", 0, "Write to FILE (default: standard output)", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state)
{
    sii_args_t *args = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twins;
        return 0;
    case 'o':
        args->output = text;
        return 0;
    case ARGP_KEY_ARG:
        if (args->device)
            argp_error(state, "one device at a time");
        args->device = text;
        return 0;
    case ARGP_KEY_END:
        if (!args->device || strchr(args->device, ','))
            argp_error(state, "name one device; 'ectwin list' lists those there are");
        twin_args_devices(&args->twins, state, args->device);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int save(const char *path, const uint8_t *image, size_t size)
{
    FILE *file = path ? fopen(path, "wb") : stdout;
    bool fine = file && fwrite(image, 1, size, file) == size;
    fine = file && (path ? fclose(file) : fflush(file)) == 0 && fine;
    if (fine)
        return EXIT_CLEAN;
    fprintf(stderr, "ectwin sii: cannot write '%s': %s\n", path ? path : "standard output", strerror(errno));
    return EXIT_OPEN;
}

int command_sii(int argc, char **argv)
{
    static const struct argp_child children[] = {{&twin_argp, 0, "The twin:", 1}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "DEVICE",
        .doc = "Writes the SII (EEPROM) image of a device.",
        .children = children,
    };
    sii_args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    const ect_twin_config_t *twin = &args.twins.twins[0];
    uint8_t *image = malloc(twin->device->sii_size);
    int status = EXIT_RUN;
    if (image && ect_sii_write(twin->device, &twin->identity, twin->alias, image, twin->device->sii_size) >= 0)
        status = save(args.output, image, twin->device->sii_size);
    free(image);
    twin_args_free(&args.twins);
    return status;
}
