/* SPDX-License-Identifier: MIT */
#include "clone_blank.h"

#include <stdio.h>
#include <string.h>

#include "od/od.h"
#include "wire/bytes.h"
#include "wire/sii.h"

enum { PARTS = 4, HEADER = 128, CATEGORY_HEADER = 4, STRINGS = 10, GENERAL = 30, END = 0xFFFF };
enum {
    GENERAL_TEXTS = 4,
    UNICODE_STRING = 0x000B,
    IDENTITY = 0x1018,
    SERIAL = 4,
    DEVICE_NAME = 0x1008,
    SOFTWARE = 0x100A
};

static const char *const names[PARTS] = {"serial", "alias", "names", "texts"}; /* by bit of CLONE_BLANK_... */

static unsigned int part_of(const char *word, size_t length)
{
    for (unsigned int i = 0; i < PARTS; i++) {
        if (strlen(names[i]) == length && strncmp(names[i], word, length) == 0)
            return 1u << i;
    }
    return 0;
}

bool clone_blank_parse(const char *text, unsigned int *parts)
{
    *parts = 0;
    if (strcmp(text, "none") == 0)
        return true;
    for (;;) {
        const size_t length = strcspn(text, ",");
        const unsigned int part = part_of(text, length);
        *parts |= part;
        if (part == 0 || text[length] == '\0')
            return part != 0;
        text += length + 1;
    }
}

const char *clone_blank_text(unsigned int parts, char text[40])
{
    size_t used = 0;
    text[0] = '\0';
    for (unsigned int i = 0; i < PARTS; i++) {
        if ((parts >> i & 1u) != 0)
            used += (size_t)snprintf(text + used, 40 - used, "%s%s", used > 0 ? ", " : "", names[i]);
    }
    return used > 0 ? text : "nothing";
}

/* --- EEPROM ------------------------------------------------------------------------------------------------------- */

/* The content of the first category of a type; NULL: none. */
static uint8_t *category(uint8_t *image, size_t size, unsigned int type, size_t *length)
{
    for (size_t at = HEADER; at + CATEGORY_HEADER <= size;) {
        *length = 2 * (size_t)ect_load_le16(image + at + 2);
        const unsigned int is = ect_load_le16(image + at);
        at += CATEGORY_HEADER;
        if (is == END || *length > size - at)
            return NULL;
        if (is == type)
            return image + at;
        at += *length;
    }
    return NULL;
}

/* Blanks text n, from 1, of category STRINGS: a count, then each text after its length. */
static void blank_string(uint8_t *strings, size_t size, unsigned int n)
{
    size_t at = 1;
    for (unsigned int i = 1; i < n && at < size; i++)
        at += 1 + (size_t)strings[at];
    if (n > 0 && at < size && strings[at] < size - at)
        memset(strings + at + 1, 'x', strings[at]);
}

static void blank_names(uint8_t *image, size_t size)
{
    size_t general_size = 0, strings_size = 0;
    const uint8_t *general = category(image, size, GENERAL, &general_size);
    uint8_t *strings = category(image, size, STRINGS, &strings_size);
    if (!general || !strings || general_size < GENERAL_TEXTS)
        return;
    for (unsigned int i = 0; i < GENERAL_TEXTS; i++) /* group, picture, order number, name */
        blank_string(strings, strings_size, general[i]);
}

void clone_blank_image(unsigned int parts, uint8_t *image, size_t size)
{
    if (size < HEADER)
        return;
    if ((parts & CLONE_BLANK_SERIAL) != 0)
        ect_store_le32(image + ECT_SII_AT_SERIAL, 0);
    if ((parts & CLONE_BLANK_ALIAS) != 0)
        ect_store_le16(image + ECT_SII_AT_ALIAS, 0);
    if ((parts & CLONE_BLANK_NAMES) != 0)
        blank_names(image, size);
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static bool is_text(uint16_t type)
{
    return type == ECT_TYPE_VISIBLE_STRING || type == ECT_TYPE_OCTET_STRING || type == UNICODE_STRING;
}

void clone_blank_value(unsigned int parts, uint16_t index, uint8_t subindex, uint16_t type, uint16_t access,
                       uint8_t *value, size_t size)
{
    if ((parts & CLONE_BLANK_SERIAL) != 0 && index == IDENTITY && subindex == SERIAL)
        memset(value, 0, size);
    if ((parts & CLONE_BLANK_NAMES) != 0 && index >= DEVICE_NAME && index <= SOFTWARE)
        memset(value, 'x', size);
    if ((parts & CLONE_BLANK_TEXTS) != 0 && is_text(type) && (access & ECT_ACCESS_WO) != 0)
        memset(value, 0, size);
}
