/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "output.h"

static const char sii[] = "ectwin sii";

enum { KEY_FORMAT = 0x203, HEX_RECORD = 16 };

static const struct argp_option options[] = {
    {"output", 'o', "FILE", 0, "Write to FILE (default: standard output)", 0},
    {"format", KEY_FORMAT, "bin|hex|c", 0, "The image itself, Intel HEX, or an array in C (default: bin)", 0},
    {0},
};

/* --- Intel HEX ---------------------------------------------------------------------------------------------------- */

/* ":LLAAAATT...CC": length, address, type, data, checksum (all bytes sum to zero). */
static void put_record(FILE *file, uint16_t address, uint8_t type, const uint8_t *data, uint8_t length)
{
    unsigned int sum = (unsigned int)length + (address >> 8) + (address & 0xFFu) + type;
    fprintf(file, ":%02X%04X%02X", length, address, type);
    for (unsigned int i = 0; i < length; i++) {
        fprintf(file, "%02X", data[i]);
        sum += data[i];
    }
    fprintf(file, "%02X\n", (0x100u - (sum & 0xFF)) & 0xFF);
}

static void put_hex(FILE *file, const ect_device_t *device, const uint8_t *image)
{
    for (uint32_t at = 0; at < device->sii_size; at += HEX_RECORD)
        put_record(file, (uint16_t)at, 0, image + at, HEX_RECORD);
    put_record(file, 0, 1, NULL, 0);
}

static void put_c(FILE *file, const ect_device_t *device, const uint8_t *image)
{
    fprintf(file, "/* The SII of %s, written by ectwin from its description. */\n#include <stdint.h>\n\n",
            device->type_name);
    fprintf(file, "const uint8_t sii[%u] = {", device->sii_size);
    for (uint32_t at = 0; at < device->sii_size; at++)
        fprintf(file, "%s0x%02X,", at % 16 == 0 ? "\n    " : " ", image[at]);
    fprintf(file, "\n};\n");
}

static int save_text(const char *who, const char *path, const ect_device_t *device, const uint8_t *image,
                     void (*put)(FILE *, const ect_device_t *, const uint8_t *))
{
    output_text_t out;
    if (!output_open(who, &out))
        return EXIT_RUN;
    put(out.file, device, image);
    return output_close(who, &out, path);
}

int output_hex(const char *who, const ect_twin_config_t *twin, const char *path)
{
    uint8_t *image = output_image(who, twin);
    int status = image ? save_text(who, path, twin->device, image, put_hex) : EXIT_RUN;
    free(image);
    return status;
}

static int save(const output_args_t *args, const ect_device_t *device, const uint8_t *image)
{
    const char *format = args->given ? args->value : "bin";
    if (strcmp(format, "hex") == 0)
        return save_text(sii, args->output, device, image, put_hex);
    if (strcmp(format, "c") == 0)
        return save_text(sii, args->output, device, image, put_c);
    if (strcmp(format, "bin") == 0)
        return output_save(sii, args->output, image, device->sii_size);
    fprintf(stderr, "%s: --format takes bin, hex or c, not '%s'\n", sii, format);
    return EXIT_USAGE;
}

int command_sii(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = output_parse,
        .args_doc = "DEVICE",
        .doc = "Writes the SII (EEPROM) image of a device.",
        .children = output_children,
    };
    output_args_t args = {.key = KEY_FORMAT};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    const ect_twin_config_t *twin = &args.twins.twins[0];
    uint8_t *image = output_image(sii, twin);
    int status = image ? save(&args, twin->device, image) : EXIT_RUN;
    free(image);
    twin_args_free(&args.twins);
    return status;
}
