/* SPDX-License-Identifier: MIT */
#include "esi/units.h"

#include <stdio.h>
#include <string.h>

#include "esi/number.h"

typedef struct named {
    uint8_t code;
    const char *name;
} named_t;

static const named_t units[] = {
    {0x01, "m"},  {0x03, "s"}, {0x04, "A"}, {0x05, "K"},   {0x10, "rad"},  {0x20, "Hz"},  {0x21, "N"},
    {0x22, "Pa"}, {0x24, "W"}, {0x26, "V"}, {0x28, "Ohm"}, {0x2D, "degC"}, {0x4E, "bar"},
};

static const struct {
    int8_t power;
    const char *name;
} prefixes[] = {{0, ""}, {3, "k"}, {6, "M"}, {-3, "m"}, {-6, "u"}, {-9, "n"}};

enum { UNITS = sizeof units / sizeof units[0], PREFIXES = sizeof prefixes / sizeof prefixes[0] };

/* @return the code of a name of `length` characters; 0: none */
static uint8_t code_of(const char *name, size_t length)
{
    for (size_t i = 0; i < UNITS; i++) {
        if (strlen(units[i].name) == length && memcmp(units[i].name, name, length) == 0)
            return units[i].code;
    }
    return 0;
}

static const char *name_of(uint8_t code)
{
    for (size_t i = 0; i < UNITS; i++) {
        if (units[i].code == code)
            return units[i].name;
    }
    return NULL;
}

bool ect_esi_unit_parse(const char *text, uint32_t *unit)
{
    const char *slash = strchr(text, '/');
    size_t length = slash != NULL ? (size_t)(slash - text) : strlen(text);
    uint8_t per = slash != NULL ? code_of(slash + 1, strlen(slash + 1)) : 0;
    int64_t number;
    if (ect_esi_parse_number(text, &number) && number >= 0 && number <= UINT32_MAX) {
        *unit = (uint32_t)number;
        return true;
    }
    for (size_t i = 0; i < PREFIXES && (slash == NULL || per != 0); i++) {
        size_t prefix = strlen(prefixes[i].name);
        uint8_t code = strncmp(text, prefixes[i].name, prefix) == 0 && length > prefix
                           ? code_of(text + prefix, length - prefix)
                           : 0;
        if (code == 0)
            continue;
        *unit = (uint32_t)(uint8_t)prefixes[i].power << 24 | (uint32_t)code << 16 | (uint32_t)per << 8;
        return true;
    }
    return false;
}

const char *ect_esi_unit_text(uint32_t unit, char *text, size_t room)
{
    const char *name = name_of((uint8_t)(unit >> 16));
    uint8_t per = (uint8_t)(unit >> 8);
    const char *divisor = per != 0 ? name_of(per) : "";
    *text = '\0';
    if (name == NULL || divisor == NULL)
        return NULL;
    for (size_t i = 0; i < PREFIXES; i++) {
        if (prefixes[i].power != (int8_t)(unit >> 24))
            continue;
        (void)snprintf(text, room, "%s%s%s%s", prefixes[i].name, name, per != 0 ? "/" : "", divisor);
        return text;
    }
    (void)snprintf(text, room, "10^%d %s%s%s", (int)(int8_t)(unit >> 24), name, per != 0 ? "/" : "", divisor);
    return text;
}
