/* SPDX-License-Identifier: MIT */
/* Types, values and rights of an entry, as words. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "devfile/internal.h"
#include "esi/number.h"
#include "esi/types.h"
#include "esi/units.h"

enum { LONGEST = 8191 /* bytes of a text: the length of an entry, in bits, is 16 bits wide */ };

const char *const ect_word_names[ECT_WORDS] = {
    [ECT_WORD_NAME] = "name",       [ECT_WORD_TYPE] = "type",         [ECT_WORD_ACCESS] = "access",
    [ECT_WORD_DEFAULT] = "default", [ECT_WORD_MIN] = "min",           [ECT_WORD_MAX] = "max",
    [ECT_WORD_UNIT] = "unit",       [ECT_WORD_WRITE_IN] = "write-in", [ECT_WORD_BACKUP] = "backup",
    [ECT_WORD_SETTING] = "setting",
};

int64_t ect_draft_number(ect_draft_t *d, const char *key, ect_word_t word, int64_t minimum, int64_t maximum)
{
    int64_t value = minimum;
    if (ect_esi_parse_number(word.text, &value) && value >= minimum && value <= maximum)
        return value;
    ect_mistake(&d->mistake, word.line, "'%s' takes a number from %" PRId64 " to %" PRId64 ", not '%.60s'", key,
                minimum, maximum, word.text);
    return minimum;
}

bool ect_draft_flag(ect_draft_t *d, const char *key, ect_word_t word)
{
    if (strcmp(word.text, "true") != 0 && strcmp(word.text, "false") != 0)
        ect_mistake(&d->mistake, word.line, "'%s' takes true or false, not '%.60s'", key, word.text);
    return strcmp(word.text, "true") == 0;
}

ect_esi_bytes_t ect_draft_hex(ect_draft_t *d, const char *key, ect_word_t word, size_t most)
{
    static const char digits[] = "0123456789ABCDEFabcdef";
    uint8_t *bytes = ect_arena_alloc(d->arena, strlen(word.text) / 2 + 1);
    size_t count = 0;
    const char *at = word.text + strspn(word.text, " ");
    while (*at != '\0' && strspn(at, digits) >= 2) {
        const char pair[3] = {at[0], at[1], '\0'};
        bytes[count++] = (uint8_t)strtoul(pair, NULL, 16);
        at += 2;
        at += strspn(at, " ");
    }
    if (*at != '\0' || count > most) {
        ect_mistake(&d->mistake, word.line, "'%s' takes at most %zu bytes as pairs of hexadecimal digits, not '%.60s'",
                    key, most, word.text);
        count = 0;
    }
    return (ect_esi_bytes_t){.bytes = bytes, .length = count};
}

/* --- types -------------------------------------------------------------------------------------------------------- */

/* Names of ETG.1020 and others, each with the name of IEC 61131-3 that ESI files use. */
static const struct {
    const char *name, *iec;
} others[] = {
    {"BOOLEAN", "BOOL"},     {"INTEGER8", "SINT"},   {"INTEGER16", "INT"},   {"INTEGER32", "DINT"},
    {"INTEGER64", "LINT"},   {"UNSIGNED8", "USINT"}, {"UNSIGNED16", "UINT"}, {"UNSIGNED32", "UDINT"},
    {"UNSIGNED64", "ULINT"}, {"REAL32", "REAL"},     {"REAL64", "LREAL"},    {"BYTE", "USINT"},
    {"WORD", "UINT"},        {"DWORD", "UDINT"},     {"LWORD", "ULINT"},     {"BIT", "BIT1"},
    {"INT8", "SINT"},        {"INT16", "INT"},       {"INT32", "DINT"},      {"INT64", "LINT"},
    {"UINT8", "USINT"},      {"UINT16", "UINT"},     {"UINT32", "UDINT"},    {"UINT64", "ULINT"},
};

/* The length in "STRING(20)" and "BYTES(8)"; 0: another text. */
static uint32_t length_in(const char *type, const char *name)
{
    size_t length = strlen(name);
    size_t digits = strncmp(type, name, length) == 0 ? strspn(type + length, "0123456789") : 0;
    if (digits == 0 || digits > 4 || strcmp(type + length + digits, ")") != 0)
        return 0;
    return (uint32_t)strtoul(type + length, NULL, 10);
}

static bool resolve(const char *type, ect_esi_basic_t *basic)
{
    char text[40];
    uint32_t characters = length_in(type, "STRING(");
    uint32_t bytes = length_in(type, "BYTES(");
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        type = strcmp(others[i].name, type) == 0 ? others[i].iec : type;
    if ((characters | bytes) != 0) {
        *basic = (ect_esi_basic_t){.code = bytes != 0 ? ECT_TYPE_OCTET_STRING : ECT_TYPE_VISIBLE_STRING,
                                   .bits = 8 * (characters + bytes)};
        return characters + bytes <= LONGEST;
    }
    if (strchr(type, '(') != NULL || strchr(type, '[') != NULL || !ect_esi_resolve(NULL, type, 0, basic))
        return false;
    return strcmp(ect_esi_type_name(basic->code, basic->bits, text, sizeof text), type) == 0; /* not "BIT3x" */
}

static void take_type(ect_draft_t *d, ect_draft_entry_t *entry, const ect_word_t *words, size_t line)
{
    ect_esi_basic_t basic = {.code = ECT_TYPE_UNSIGNED8, .bits = 8};
    const ect_word_t type = words[ECT_WORD_TYPE];
    const char *initial = words[ECT_WORD_DEFAULT].text;
    if (type.text == NULL) {
        ect_mistake(&d->mistake, line,
                    "'type' is missing: BOOL, USINT, UINT, UDINT, SINT, INT, DINT, REAL, STRING(20)");
    } else if (strcmp(type.text, "STRING") == 0 || strcmp(type.text, "VISIBLE_STRING") == 0) {
        size_t length = initial != NULL ? strlen(initial) : 0;
        if (length == 0 || length > LONGEST)
            ect_mistake(&d->mistake, type.line, "'type: %s' takes its length from 'default'; else write STRING(20)",
                        type.text);
        basic = (ect_esi_basic_t){.code = ECT_TYPE_VISIBLE_STRING, .bits = (uint32_t)(8 * length)};
    } else if (!resolve(type.text, &basic)) {
        ect_mistake(
            &d->mistake, type.line,
            "'type: %.60s' is none: BOOL, BIT1 to BIT8, USINT, UINT, UDINT, ULINT, SINT, INT, DINT, LINT, REAL, "
            "LREAL, STRING(1) to STRING(%d), BYTES(1) to BYTES(%d)",
            type.text, (int)LONGEST, (int)LONGEST);
    }
    entry->type = basic.code;
    entry->bits = (uint16_t)basic.bits;
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static bool is_signed(const ect_draft_entry_t *entry)
{
    return entry->type == ECT_TYPE_INTEGER8 || entry->type == ECT_TYPE_INTEGER16 || entry->type == ECT_TYPE_INTEGER32 ||
           entry->type == ECT_TYPE_INTEGER64;
}

bool ect_draft_is_integer(const ect_draft_entry_t *entry)
{
    return entry->type != ECT_TYPE_REAL32 && entry->type != ECT_TYPE_REAL64 && entry->type != ECT_TYPE_VISIBLE_STRING &&
           entry->type != ECT_TYPE_OCTET_STRING;
}

void ect_draft_range(const ect_draft_entry_t *entry, int64_t *minimum, int64_t *maximum)
{
    ECT_ASSERT(entry->bits > 0 && entry->bits <= 64);
    unsigned int magnitude = entry->bits - (is_signed(entry) ? 1u : 0u);
    *maximum = magnitude < 63 ? (INT64_C(1) << magnitude) - 1 : INT64_MAX;
    *minimum = is_signed(entry) ? -*maximum - 1 : 0;
}

static ect_esi_bytes_t wire_of(ect_draft_t *d, uint64_t number, size_t length)
{
    uint8_t *bytes = ect_arena_alloc(d->arena, length);
    ECT_ASSERT(length > 0 && length <= 8);
    for (size_t i = 0; i < length; i++)
        bytes[i] = (uint8_t)(number >> 8 * i);
    return (ect_esi_bytes_t){.bytes = bytes, .length = length};
}

static uint64_t integer_of(ect_draft_t *d, const char *key, const ect_draft_entry_t *entry, ect_word_t word)
{
    int64_t minimum, maximum, value = 0;
    ect_draft_range(entry, &minimum, &maximum);
    if (entry->bits == 1 && (strcmp(word.text, "true") == 0 || strcmp(word.text, "false") == 0))
        return *word.text == 't';
    bool whole = entry->type == ECT_TYPE_UNSIGNED64 && *word.text != '-'; /* also above INT64_MAX */
    if (whole && ect_esi_parse_number(word.text, &value))
        return (uint64_t)value;
    return (uint64_t)ect_draft_number(d, key, word, minimum, maximum);
}

static ect_esi_bytes_t real_of(ect_draft_t *d, const ect_draft_entry_t *entry, ect_word_t word)
{
    char *end;
    double value = strtod(word.text, &end);
    uint64_t bits = 0;
    float single = (float)value;
    bool fits = isfinite(value) && (entry->type == ECT_TYPE_REAL64 || isfinite(single));
    if (*word.text == '\0' || *end != '\0' || strspn(word.text, "+-.0123456789eE") != strlen(word.text) || !fits)
        ect_mistake(&d->mistake, word.line, "'default' takes a number as 12.5 or 1e-3, not '%.60s'", word.text);
    if (entry->type == ECT_TYPE_REAL64) {
        memcpy(&bits, &value, sizeof value);
    } else {
        uint32_t low = 0;
        memcpy(&low, &single, sizeof single);
        bits = low;
    }
    return wire_of(d, bits, entry->bits / 8u);
}

void ect_draft_default(ect_draft_t *d, ect_draft_entry_t *entry, ect_word_t word)
{
    size_t length = (entry->bits + 7u) / 8u;
    if (ect_draft_is_integer(entry)) {
        entry->initial = wire_of(d, integer_of(d, "default", entry, word), length);
    } else if (entry->type == ECT_TYPE_OCTET_STRING) {
        entry->initial = ect_draft_hex(d, "default", word, length);
    } else if (entry->type == ECT_TYPE_VISIBLE_STRING) {
        size_t characters = strlen(word.text);
        for (const char *letter = word.text; *letter != '\0'; letter++) {
            if (*letter < ' ' || *letter > '~')
                ect_mistake(&d->mistake, word.line, "'default' has a character outside ISO 646 (ASCII)");
        }
        if (characters > length)
            ect_mistake(&d->mistake, word.line, "'default' has %zu characters: write STRING(%zu)", characters,
                        characters);
        entry->initial = (ect_esi_bytes_t){.bytes = (const uint8_t *)ect_arena_copy(d->arena, word.text, characters),
                                           .length = characters};
    } else {
        entry->initial = real_of(d, entry, word);
    }
}

int64_t ect_draft_initial(const ect_draft_entry_t *entry)
{
    uint64_t value = 0, sign = is_signed(entry) ? UINT64_C(1) << (entry->bits - 1) : 0;
    for (size_t i = entry->initial.length; i-- > 0;)
        value = value << 8 | entry->initial.bytes[i];
    return (value & sign) != 0 ? (int64_t)(value | ~(2 * sign - 1)) : (int64_t)value;
}

static void take_limits(ect_draft_t *d, ect_draft_entry_t *entry, const ect_word_t *words)
{
    const ect_word_t min = words[ECT_WORD_MIN], max = words[ECT_WORD_MAX];
    size_t line = min.text != NULL ? min.line : max.line;
    if (min.text == NULL && max.text == NULL)
        return;
    if (!ect_draft_is_integer(entry)) {
        ect_mistake(&d->mistake, line, "'min' and 'max' are for integers: leave them out");
        return;
    }
    ect_draft_range(entry, &entry->minimum, &entry->maximum);
    int64_t lowest = entry->minimum, highest = entry->maximum;
    entry->limited = true;
    if (min.text != NULL)
        entry->minimum = ect_draft_number(d, "min", min, lowest, highest);
    if (max.text != NULL)
        entry->maximum = ect_draft_number(d, "max", max, lowest, highest);
    if (entry->minimum >= entry->maximum)
        ect_mistake(&d->mistake, line, "'min' %" PRId64 " is not less than 'max' %" PRId64, entry->minimum,
                    entry->maximum);
}

/* --- rights ------------------------------------------------------------------------------------------------------- */

static uint16_t rights_of(ect_draft_t *d, ect_word_t word)
{
    if (word.text == NULL)
        return 0;
    if (strcmp(word.text, "ro") == 0)
        return ECT_ACCESS_RO;
    if (strcmp(word.text, "wo") == 0)
        return ECT_ACCESS_WO;
    if (strcmp(word.text, "rw") != 0)
        ect_mistake(&d->mistake, word.line, "'access' takes ro, rw or wo, not '%.60s'", word.text);
    return ECT_ACCESS_RW;
}

/* The AL states in which a master may write. */
static uint16_t states_of(ect_draft_t *d, ect_word_t word)
{
    static const struct {
        const char *name;
        uint16_t bits;
    } states[] = {
        {"preop", ECT_ACCESS_W_PREOP},
        {"preop safeop", ECT_ACCESS_W_PREOP | ECT_ACCESS_W_SAFEOP},
        {"preop safeop op", ECT_ACCESS_WO},
    };
    for (size_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        if (strcmp(word.text, states[i].name) == 0)
            return states[i].bits;
    }
    ect_mistake(&d->mistake, word.line, "'write-in' takes preop, preop safeop, or preop safeop op, not '%.60s'",
                word.text);
    return ECT_ACCESS_WO;
}

static void take_rights(ect_draft_t *d, ect_draft_entry_t *entry, const ect_word_t *words)
{
    const ect_word_t states = words[ECT_WORD_WRITE_IN], backup = words[ECT_WORD_BACKUP];
    const ect_word_t setting = words[ECT_WORD_SETTING];
    entry->access = rights_of(d, words[ECT_WORD_ACCESS]);
    if (states.text != NULL && (entry->access & ECT_ACCESS_WO) == 0)
        ect_mistake(&d->mistake, states.line, "'write-in' is for 'access: rw' or 'access: wo'");
    if (states.text != NULL)
        entry->access = (uint16_t)((entry->access & ~ECT_ACCESS_WO) | states_of(d, states));
    bool kept = backup.text != NULL && ect_draft_flag(d, "backup", backup);
    bool set = setting.text != NULL && ect_draft_flag(d, "setting", setting);
    if ((kept || set) && entry->access == 0)
        entry->access = ECT_ACCESS_RW; /* a stored entry is writable */
    entry->access = (uint16_t)(entry->access | (kept ? ECT_ACCESS_BACKUP : 0) | (set ? ECT_ACCESS_SETTING : 0));
}

void ect_draft_words(ect_draft_t *d, ect_draft_entry_t *entry, const ect_word_t *words, size_t line)
{
    const ect_word_t name = words[ECT_WORD_NAME], unit = words[ECT_WORD_UNIT];
    *entry = (ect_draft_entry_t){.line = line, .name = ""};
    if (name.text != NULL)
        entry->name = ect_arena_copy(d->arena, name.text, strlen(name.text));
    take_type(d, entry, words, line);
    if (d->mistake.failed)
        return;
    take_rights(d, entry, words);
    if (unit.text != NULL && !ect_esi_unit_parse(unit.text, &entry->unit))
        ect_mistake(&d->mistake, unit.line,
                    "'unit: %.60s' is none: um, mm/s, degC … or a number of ETG.1004, 0xFD010300", unit.text);
    take_limits(d, entry, words);
    if (words[ECT_WORD_DEFAULT].text != NULL)
        ect_draft_default(d, entry, words[ECT_WORD_DEFAULT]);
}
