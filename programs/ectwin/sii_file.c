/* SPDX-License-Identifier: MIT */
#include "sii_file.h"

#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { DATA = 0, END = 1, SEGMENT = 2, START_SEGMENT = 3, LINEAR = 4, START_LINEAR = 5 };

typedef struct hex_record {
    uint8_t bytes[5 + 255]; /* length, address, type, data, sum */
    size_t count;
} hex_record_t;

/* @return the error in the line; NULL: none */
static const char *parse_record(const char *line, hex_record_t *record)
{
    uint8_t sum = 0;
    record->count = 0;
    if (*line++ != ':')
        return "does not begin with ':'";
    for (; isxdigit((unsigned char)line[0]) && isxdigit((unsigned char)line[1]); line += 2) {
        const char digits[] = {line[0], line[1], '\0'};
        if (record->count == sizeof record->bytes)
            return "is too long";
        record->bytes[record->count] = (uint8_t)strtoul(digits, NULL, 16);
        sum = (uint8_t)(sum + record->bytes[record->count++]);
    }
    if (record->count < 5 || record->count != 5u + record->bytes[0])
        return "has another length than its first byte";
    return sum != 0 ? "has a wrong sum" : NULL;
}

/* @return the error; NULL: none */
static const char *apply(const hex_record_t *record, uint32_t *base, uint8_t *image, long *size)
{
    const uint8_t *r = record->bytes;
    uint32_t number = (uint32_t)(r[4] << 8 | r[5]);
    uint32_t at = *base + (uint32_t)(r[1] << 8 | r[2]);
    switch (r[3]) {
    case DATA:
        if (at + r[0] > SII_FILE_MOST)
            return "is beyond the largest EEPROM";
        memcpy(image + at, r + 4, r[0]);
        if (*size < (long)at + r[0])
            *size = (long)at + r[0];
        return NULL;
    case SEGMENT:
    case LINEAR:
        if (r[0] != 2)
            return "has an address of another length than 2";
        *base = r[3] == SEGMENT ? number << 4 : number << 16;
        return *base < SII_FILE_MOST ? NULL : "is beyond the largest EEPROM";
    case END:
    case START_SEGMENT:
    case START_LINEAR:
        return NULL;
    default:
        return "has an unknown type";
    }
}

static long read_hex(FILE *file, const char *path, uint8_t *image, char *message, size_t room)
{
    char line[600];
    uint32_t base = 0;
    long size = 0;
    memset(image, 0xFF, SII_FILE_MOST);
    for (unsigned int number = 1; fgets(line, sizeof line, file) != NULL; number++) {
        hex_record_t record;
        if (line[strspn(line, " \t\r\n")] == '\0')
            continue;
        const char *wrong = parse_record(line, &record);
        wrong = wrong != NULL ? wrong : apply(&record, &base, image, &size);
        if (wrong != NULL) {
            (void)snprintf(message, room, "%s:%u: a line of Intel HEX that %s", path, number, wrong);
            return -1;
        }
        if (record.bytes[3] == END)
            break;
    }
    return size;
}

long sii_file_read(const char *path, uint8_t *image, char *message, size_t room)
{
    FILE *file = fopen(path, "rb");
    long size;
    if (file == NULL) {
        (void)snprintf(message, room, "%s: %s", path, strerror(errno));
        return -1;
    }
    int first = fgetc(file);
    if (first != EOF)
        (void)ungetc(first, file);
    if (first == ':') {
        size = read_hex(file, path, image, message, room);
    } else {
        size = (long)fread(image, 1, SII_FILE_MOST, file);
        bool fine = ferror(file) == 0 && fgetc(file) == EOF;
        if (!fine) {
            (void)snprintf(message, room, "%s: not an EEPROM image of at most %d bytes", path, (int)SII_FILE_MOST);
            size = -1;
        }
    }
    (void)fclose(file);
    return size;
}

uint8_t *sii_file_make(const ect_device_t *device, const ect_identity_t *identity, uint16_t alias, char *message,
                       size_t room)
{
    uint8_t *image = malloc(device->sii_size);
    if (image && ect_sii_write(device, identity, alias, image, device->sii_size) >= 0)
        return image;
    snprintf(message, room, "the EEPROM of '%s' cannot be made: %s", device->name,
             image ? "its content does not fit" : strerror(errno));
    free(image);
    return NULL;
}
