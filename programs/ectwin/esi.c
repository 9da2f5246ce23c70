/* SPDX-License-Identifier: MIT */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "esi/write.h"
#include "output.h"
#include "products.h"

static const char esi[] = "ectwin esi";

static const struct argp_option options[] = {
    {"output", 'o', "FILE", 0,
     "Write to FILE (default: standard output); with --all to this folder, created if necessary (default: the working "
     "directory)",
     0},
    {"all", OUTPUT_KEY_ALL, NULL, 0, "Write all devices, one file for each product family: ectwin-FAMILY.xml", 0},
    {0},
};

static int write_parts(const char *who, const ect_esi_part_t *parts, size_t count, const char *path)
{
    ect_arena_t arena = {0};
    char why[200];
    size_t length;
    int status = EXIT_USAGE;
    const char *file = ect_esi_write(&arena, parts, count, &length, why, sizeof why);
    if (file)
        status = output_save(who, path, file, length);
    else
        fprintf(stderr, "%s: %s\n", who, why);
    ect_arena_free(&arena);
    return status;
}

static ect_esi_part_t part_of(const ect_twin_config_t *twin)
{
    return (ect_esi_part_t){.device = twin->device,
                            .identity = &twin->identity,
                            .plant = twin->plant,
                            .twin = product_twin_of_device(twin->device)};
}

int output_esi(const char *who, const ect_twin_config_t *twin, const char *path)
{
    const ect_esi_part_t part = part_of(twin);
    return write_parts(who, &part, 1, path);
}

/* One file for each family, as ESI/ectwin-vr-bu.xml. */
static int write_family(const ect_esi_part_t *parts, size_t count, const char *folder)
{
    char path[OUTPUT_PATH], name[200];
    snprintf(name, sizeof name, "ectwin-%s.xml", parts[0].device->group_type);
    for (char *letter = name; *letter; letter++)
        *letter = (char)(*letter == ' ' ? '-' : tolower((unsigned char)*letter));
    return output_path(esi, path, folder, name) ? write_parts(esi, parts, count, path) : EXIT_OPEN;
}

static int write_families(ect_esi_part_t *parts, size_t count, const char *folder)
{
    int status = EXIT_CLEAN;
    while (count > 0 && status == EXIT_CLEAN) {
        size_t same = 0;
        for (size_t i = 0; i < count; i++) {
            ect_esi_part_t part = parts[i];
            if (strcmp(part.device->group_type, parts[0].device->group_type) != 0)
                continue;
            memmove(&parts[same + 1], &parts[same],
                    (i - same) * sizeof part); /* the order of the others is unchanged */
            parts[same++] = part;
        }
        status = write_family(parts, same, folder);
        parts += same;
        count -= same;
    }
    return status;
}

int command_esi(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = output_parse,
        .args_doc = "DEVICE[,DEVICE...]\n--all",
        .doc = "Writes the ESI file (EtherCAT Slave Information, XML) that engineering tools import.",
        .children = output_children,
    };
    output_args_t args = {.several = true};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    int status = EXIT_RUN;
    ect_esi_part_t *parts = calloc(args.twins.count, sizeof *parts);
    for (size_t i = 0; parts && i < args.twins.count; i++)
        parts[i] = part_of(&args.twins.twins[i]);
    if (parts)
        status = args.all ? write_families(parts, args.twins.count, args.output ? args.output : ".")
                          : write_parts(esi, parts, args.twins.count, args.output);
    free(parts);
    twin_args_free(&args.twins);
    return status;
}
