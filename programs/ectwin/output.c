/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "output.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "sii_file.h"

const struct argp_child output_children[] = {{&twin_argp, 0, "The twin:", 1}, {0}};

int output_save(const char *who, const char *path, const void *data, size_t size)
{
    if (!path && memchr(data, 0, size) && isatty(STDOUT_FILENO)) {
        fprintf(stderr,
                "%s: binary data are not written to a terminal: name a file with -o FILE, or redirect the output\n",
                who);
        return EXIT_USAGE;
    }
    FILE *file = path ? fopen(path, "wb") : stdout;
    bool fine = file && fwrite(data, 1, size, file) == size;
    fine = file && (path ? fclose(file) : fflush(file)) == 0 && fine;
    if (fine)
        return EXIT_CLEAN;
    fprintf(stderr, "%s: cannot write '%s': %s\n", who, path ? path : "standard output", strerror(errno));
    return EXIT_OPEN;
}

bool output_path(const char *who, char path[OUTPUT_PATH], const char *folder, const char *name)
{
    bool fits = snprintf(path, OUTPUT_PATH, "%s/%s", folder, name) < OUTPUT_PATH;
    if (fits)
        (void)mkdir(folder, 0777); /* may exist; a failure is reported when the file is opened */
    else
        fprintf(stderr, "%s: the folder's name is too long\n", who);
    return fits;
}

static void report_failure(const char *who)
{
    fprintf(stderr, "%s: the output cannot be generated: %s\n", who, strerror(errno));
}

FILE *output_open(const char *who, output_text_t *out)
{
    *out = (output_text_t){0};
    out->file = open_memstream(&out->text, &out->size);
    if (!out->file)
        report_failure(who);
    return out->file;
}

int output_close(const char *who, output_text_t *out, const char *path)
{
    int status = EXIT_RUN;
    if (fclose(out->file) == 0)
        status = output_save(who, path, out->text, out->size);
    else
        report_failure(who);
    free(out->text);
    return status;
}

uint8_t *output_image(const char *who, const ect_twin_config_t *twin)
{
    char message[200];
    uint8_t *image = sii_file_make(twin->device, &twin->identity, twin->alias, message, sizeof message);
    if (!image)
        fprintf(stderr, "%s: %s\n", who, message);
    return image;
}

/* @return the names of the catalogue, separated by commas, for free() */
static char *all_names(void)
{
    char *names = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&names, &size);
    const ect_product_t *product;
    for (size_t i = 0; stream && (product = ect_catalogue_at(i)) != NULL; i++)
        fprintf(stream, "%s%s", i > 0 ? "," : "", product->device->name);
    if (!stream || fclose(stream) != 0)
        return NULL;
    return names;
}

/* Accepts either --all or names, and a single name unless the command accepts several. */
static void check_choice(const output_args_t *args, const struct argp_state *state)
{
    if (args->all && args->devices)
        argp_error(state, "--all is for all devices: name none beside it");
    if (!args->all && (!args->devices || (!args->several && strchr(args->devices, ','))))
        argp_error(state, "name %s; 'ectwin list' lists all devices", args->several ? "a device" : "one device");
}

static void take_devices(output_args_t *args, const struct argp_state *state)
{
    check_choice(args, state);
    char *names = args->all ? all_names() : NULL;
    if (args->all && !names)
        argp_failure(state, EXIT_RUN, ENOMEM, "the devices");
    args->twins.kinds = true;
    twin_args_devices(&args->twins, state, names ? names : args->devices);
    free(names);
}

error_t output_parse(int key, char *text, struct argp_state *state)
{
    output_args_t *args = state->input;
    if (args->key != 0 && key == args->key) {
        args->value = text;
        args->given = true;
        return 0;
    }
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twins;
        return 0;
    case 'o':
        args->output = text;
        return 0;
    case OUTPUT_KEY_ALL:
        args->all = true;
        return 0;
    case ARGP_KEY_ARG:
        if (args->devices)
            argp_error(state, "%s", args->several ? "put commas between devices" : "one device at a time");
        args->devices = text;
        return 0;
    case ARGP_KEY_END:
        take_devices(args, state);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}
