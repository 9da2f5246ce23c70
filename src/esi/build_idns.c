/* SPDX-License-Identifier: MIT */
/*
 * Parameters of SoE drives: those of the file's dictionary, those that process data and start-up commands need, and the
 * standard ones without which no master configures a drive. A number that a telegram may carry has an entry in the
 * dictionary of the twin, which the mapping objects refer to; both share their memory (seams/soe.h).
 */
#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"
#include "wire/bytes.h"

enum {
    TELEGRAM_TYPE = 15,
    AT_LIST = 16,
    ALL_IDNS = 17,
    SAFEOP_ERRORS = 21,
    OP_ERRORS = 22,
    MDT_LIST = 24,
    OPERATION_MODE = 32,
    SPEED_COMMAND = 36,
    POSITION_COMMAND = 47,
    RESET = 99,
    CONTROL_WORD = 134,
    STATUS_WORD = 135,
    AT_IDNS = 187,
    MDT_IDNS = 188,
    APPLICATION_TELEGRAM = 7,
    LIST_HEAD = 4,         /* bytes of the two length words */
    LONGEST_LIST = 0x4000, /* bytes */
    ERROR_LIST = 64,       /* bytes of the lists of invalid IDNs */
    FIRST_ENTRY = 0x5000,  /* indices of entries of numbers: none of a profile */
    LAST_ENTRY = 0x5FFF,
};

#define LOCKED_ABOVE_PREOP (ECT_SOE_LOCK_SAFEOP | ECT_SOE_LOCK_OP)
#define IDN_LIST           (ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_IDNS | 1u)

/* --- the list of all drives --------------------------------------------------------------------------------------- */

ect_build_idn_t *ect_build_idn(const ect_build_t *build, uint8_t drive, uint16_t idn)
{
    const ect_build_soe_t *soe = build->soe;
    ECT_ASSERT(soe != NULL && drive < soe->drives);
    const uint32_t position = soe->positions[drive][idn];
    return position > 0 ? &soe->idns[position - 1] : NULL;
}

const char *ect_build_idn_text(ect_build_t *build, uint16_t idn)
{
    return ect_arena_print(build->arena, "%c-%u-%04u", (idn & 0x8000) != 0 ? 'P' : 'S', idn >> 12 & 7u, idn & 0xFFFu);
}

static ect_build_idn_t *add(ect_build_t *build, uint8_t drive, uint16_t idn, uint32_t attribute, const char *name)
{
    ect_build_soe_t *soe = build->soe;
    ECT_ASSERT(ect_build_idn(build, drive, idn) == NULL);
    soe->idns = ect_arena_grow(build->arena, soe->idns, soe->count, sizeof *soe->idns);
    ect_build_idn_t *added = &soe->idns[soe->count++];
    soe->positions[drive][idn] = (uint32_t)soe->count;
    *added = (ect_build_idn_t){
        .drive = drive,
        .row = {.idn = idn, .attribute = attribute, .name = ect_build_text(build, name, ECT_BUILD_TEXT)},
    };
    return added;
}

static bool is_list(const ect_build_idn_t *idn)
{
    return (idn->row.attribute & ECT_SOE_LIST) != 0;
}

static bool is_number(const ect_build_idn_t *idn)
{
    return (idn->row.attribute & (ECT_SOE_LIST | ECT_SOE_COMMAND)) == 0;
}

static uint32_t width_of(uint32_t bits)
{
    return bits <= 8 ? ECT_SOE_8 : bits <= 16 ? ECT_SOE_16 : bits <= 32 ? ECT_SOE_32 : ECT_SOE_64;
}

/* --- the dictionary of the file ----------------------------------------------------------------------------------- */

/* A value of the dictionary, determined by its type. */
typedef struct shape {
    bool list, head; /* a list; with its two length words in the type */
    uint32_t kind;   /* ECT_SOE_BINARY … */
    uint32_t bits;   /* of a number, or of an element */
    uint32_t bytes;  /* capacity of a list */
} shape_t;

static uint32_t element_bits(const ect_esi_dictionary_t *dictionary, const ect_esi_type_t *type)
{
    for (size_t i = 0; i < type->item_count; i++) {
        const ect_esi_type_t *array = ect_esi_find_type(dictionary, type->items[i].type);
        if (array != NULL && array->elements.given && array->elements.value > 0)
            return array->bits / (uint32_t)array->elements.value;
    }
    return 16;
}

static uint32_t kind_of(uint16_t code)
{
    if (code == ECT_TYPE_REAL32 || code == ECT_TYPE_REAL64)
        return ECT_SOE_FLOAT;
    if (code == ECT_TYPE_VISIBLE_STRING)
        return ECT_SOE_TEXT;
    return ect_build_is_signed(code) ? ECT_SOE_SIGNED : ECT_SOE_UNSIGNED;
}

/* A type with parts is a list, which begins with its length, or a number with names for its bits. */
static bool is_list_type(const ect_esi_object_t *object, const ect_esi_type_t *type)
{
    enum { LENGTH_BITS = 16 };
    if (object->flags.attribute.given)
        return (object->flags.attribute.value & ECT_SOE_LIST) != 0;
    return type->items[0].bits >= LENGTH_BITS;
}

/* @return false: its length is not known */
static bool shape_of(const ect_esi_dictionary_t *dictionary, const ect_esi_object_t *object, shape_t *shape)
{
    const ect_esi_type_t *type = ect_esi_find_type(dictionary, object->type);
    const bool forced = object->flags.attribute.given && (object->flags.attribute.value & ECT_SOE_LIST) != 0;
    ect_esi_basic_t basic;
    *shape = (shape_t){.list = true, .head = true, .kind = ECT_SOE_BINARY};
    if (type != NULL && type->item_count > 0) {
        const uint32_t bits = type->bits > object->bits ? type->bits : object->bits;
        const uint32_t bytes = bits / 8;
        if (bits <= 64 && !is_list_type(object, type)) {
            *shape = (shape_t){.kind = ECT_SOE_BINARY, .bits = bits};
            return true;
        }
        shape->bits = element_bits(dictionary, type);
        shape->bytes = bytes > LIST_HEAD ? bytes - LIST_HEAD : 0;
        return true;
    }
    if (!ect_esi_resolve(dictionary, object->type, object->bits, &basic))
        return false;
    const bool text = basic.code == ECT_TYPE_VISIBLE_STRING || basic.code == ECT_TYPE_OCTET_STRING;
    shape->list = text || forced;
    shape->head = false;
    shape->kind = kind_of(basic.code);
    shape->bits = text ? 8 : basic.bits;
    shape->bytes = (basic.bits + 7) / 8;
    return shape->list || basic.bits <= 64;
}

/* @return ECT_SOE_LOCK_... of the states in which an object cannot be written */
static uint32_t locks_of(const ect_esi_flags_t *flags)
{
    const uint16_t access = ect_build_access(flags, flags);
    return ((access & ECT_ACCESS_W_PREOP) != 0 ? 0 : ECT_SOE_LOCK_PREOP) |
           ((access & ECT_ACCESS_W_SAFEOP) != 0 ? 0 : ECT_SOE_LOCK_SAFEOP) |
           ((access & ECT_ACCESS_W_OP) != 0 ? 0 : ECT_SOE_LOCK_OP);
}

static uint32_t attribute_of(const ect_esi_object_t *object, const shape_t *shape)
{
    const ect_esi_number_t *given = &object->flags.attribute;
    const uint32_t width = given->given && shape->list ? (uint32_t)given->value & ECT_SOE_64 : width_of(shape->bits);
    const uint32_t rest = given->given ? (uint32_t)given->value & ~(ECT_SOE_64 | ECT_SOE_LIST)
                                       : shape->kind | locks_of(&object->flags) | 1u;
    const bool command = (rest & ECT_SOE_COMMAND) != 0;
    return command ? rest | ECT_SOE_16 : rest | width | (shape->list ? ECT_SOE_LIST : 0);
}

/* A list of the file begins with its length and its capacity, in bytes; a text has neither. */
static void take_list(ect_build_t *build, ect_build_idn_t *idn, const ect_esi_object_t *object, const shape_t *shape)
{
    const ect_esi_bytes_t *initial = &object->info.initial;
    const size_t head = shape->head ? LIST_HEAD : 0;
    const uint32_t bytes = shape->bytes < LONGEST_LIST ? shape->bytes : LONGEST_LIST;
    idn->row.size = (uint16_t)(bytes - bytes % ect_soe_width(idn->row.attribute));
    if (initial->bytes == NULL || object->info.initial_is_number || initial->length < head)
        return;
    const size_t used = shape->head ? ect_load_le16(initial->bytes) : initial->length;
    if (used > initial->length - head || used > idn->row.size || used % ect_soe_width(idn->row.attribute) != 0) {
        ect_build_note(build, "line %d: the default of %s does not fit its type: it is empty", object->line,
                       ect_build_idn_text(build, idn->row.idn));
        return;
    }
    idn->row.content = initial->bytes + head;
    idn->row.used = (uint16_t)used;
}

static int64_t extended(const ect_build_idn_t *idn, ect_esi_number_t number)
{
    const uint64_t sign = number.bytes > 0 ? UINT64_C(1) << (8 * number.bytes - 1) : 0;
    const bool negative = (idn->row.attribute & ECT_SOE_KIND) == ECT_SOE_SIGNED && ((uint64_t)number.value & sign) != 0;
    return negative ? (int64_t)((uint64_t)number.value | ~(2 * sign - 1)) : number.value;
}

/* @return an initial value as a number with its sign */
static int64_t initial_of(const ect_build_idn_t *idn)
{
    const ect_esi_number_t number = {.bytes = (uint8_t)ect_soe_width(idn->row.attribute),
                                     .value = (int64_t)idn->row.initial};
    return extended(idn, number);
}

static void take_limits(ect_build_t *build, ect_build_idn_t *idn, const ect_esi_object_t *object)
{
    const ect_esi_info_t *info = &object->info;
    const int64_t initial = initial_of(idn);
    ect_soe_idn_t *row = &idn->row;
    const int64_t minimum = extended(idn, info->minimum);
    const int64_t maximum = extended(idn, info->maximum);
    const bool both = info->minimum.given && info->maximum.given;
    if ((row->attribute & ECT_SOE_KIND) == ECT_SOE_FLOAT || (both && minimum == maximum))
        return;
    if ((info->minimum.given && initial < minimum) || (info->maximum.given && initial > maximum)) {
        ect_build_note(build, "line %d: the default of %s is not within its limits: it has no limits", object->line,
                       ect_build_idn_text(build, row->idn));
        return;
    }
    row->minimum = minimum;
    row->maximum = maximum;
    row->flags |= (info->minimum.given ? ECT_SOE_MINIMUM : 0) | (info->maximum.given ? ECT_SOE_MAXIMUM : 0);
}

static void take_number(ect_build_t *build, ect_build_idn_t *idn, const ect_esi_object_t *object)
{
    const ect_esi_bytes_t *initial = &object->info.initial;
    const uint16_t width = ect_soe_width(idn->row.attribute);
    for (size_t i = 0; initial->bytes != NULL && i < initial->length && i < width; i++)
        idn->row.initial |= (uint64_t)initial->bytes[i] << 8 * i;
    idn->row.flags |= initial->bytes != NULL ? ECT_SOE_DEFAULT : 0;
    take_limits(build, idn, object);
}

static void add_object(ect_build_t *build, uint8_t drive, const ect_esi_object_t *object)
{
    shape_t shape;
    const bool twice = ect_build_idn(build, drive, object->index) != NULL;
    if (twice || !shape_of(&build->model->idns, object, &shape)) {
        ect_build_note(build, "line %d: %s is left out: %s", object->line, ect_build_idn_text(build, object->index),
                       twice ? "it exists already" : "the length of its type is not known");
        return;
    }
    ect_build_idn_t *idn = add(build, drive, object->index, attribute_of(object, &shape), object->name);
    if (object->index != CONTROL_WORD && object->index != STATUS_WORD)
        idn->row.flags = (uint8_t)((strpbrk(object->flags.mapping, "tT") != NULL ? ECT_SOE_IN_AT : 0) |
                                   (strpbrk(object->flags.mapping, "rR") != NULL ? ECT_SOE_IN_MDT : 0));
    if (is_list(idn))
        take_list(build, idn, object, &shape);
    else if (is_number(idn))
        take_number(build, idn, object);
    if (!is_number(idn))
        idn->row.flags = 0;
}

/* --- telegrams ---------------------------------------------------------------------------------------------------- */

bool ect_build_is_telegram(const ect_build_t *build, const ect_esi_pdo_t *pdo)
{
    const uint16_t first = pdo->tx ? 0x1A00 : 0x1600;
    const bool mapping = pdo->index >= first && pdo->index < first + 0x200;
    return build->soe != NULL && build->module == 0 && !pdo->virtual_pdo && (!build->model->mailbox.coe || !mapping);
}

uint8_t ect_build_drive_of(const ect_build_t *build, const ect_esi_pdo_t *pdo)
{
    const unsigned int drive = (pdo->index & 0x0FFFu) < 0x600 ? pdo->index >> 12 : 0u;
    return build->soe != NULL && drive < build->soe->drives ? (uint8_t)drive : 0;
}

static bool is_value(const ect_esi_entry_t *entry)
{
    return entry->index != 0 && entry->subindex == 0 &&
           (entry->bits == 8 || entry->bits == 16 || entry->bits == 32 || entry->bits == 64);
}

/* The width of process data is that of the PDO, whatever the dictionary has. */
static void add_value(ect_build_t *build, const ect_esi_pdo_t *pdo, const ect_esi_entry_t *entry)
{
    const uint8_t drive = ect_build_drive_of(build, pdo);
    ect_build_idn_t *idn = ect_build_idn(build, drive, entry->index);
    ect_esi_basic_t basic;
    const bool known = ect_esi_resolve(&build->model->idns, entry->type, entry->bits, &basic);
    const bool word = entry->index == CONTROL_WORD || entry->index == STATUS_WORD;
    if (idn == NULL)
        idn = add(build, drive, entry->index,
                  (word    ? ECT_SOE_BINARY
                   : known ? kind_of(basic.code)
                           : ECT_SOE_BINARY) |
                      width_of(entry->bits) | (pdo->tx ? ECT_SOE_READ_ONLY : 0) | 1u,
                  entry->name);
    if (!is_number(idn) || 8u * ect_soe_width(idn->row.attribute) != entry->bits) {
        ect_build_note(build, "line %d: PDO %04X has %u bits of %s, unlike the dictionary: the PDO counts", entry->line,
                       (unsigned int)pdo->index, (unsigned int)entry->bits, ect_build_idn_text(build, entry->index));
        idn->row = (ect_soe_idn_t){.idn = entry->index,
                                   .name = idn->row.name,
                                   .flags = idn->row.flags & (ECT_SOE_IN_AT | ECT_SOE_IN_MDT),
                                   .attribute = (idn->row.attribute & ~(ECT_SOE_64 | ECT_SOE_LIST | ECT_SOE_COMMAND)) |
                                                width_of(entry->bits)};
    }
    if (!word)
        idn->row.flags |= pdo->tx ? ECT_SOE_IN_AT : ECT_SOE_IN_MDT;
    idn->cyclic = true;
}

static void add_telegram(ect_build_t *build, const ect_esi_pdo_t *pdo)
{
    for (size_t i = 0; i < pdo->entry_count; i++) {
        const ect_esi_entry_t *entry = &pdo->entries[i];
        if (is_value(entry))
            add_value(build, pdo, entry);
        else if (entry->index != 0)
            ect_build_note(build, "line %d: PDO %04X has %u bits of %s: they are a gap", entry->line,
                           (unsigned int)pdo->index, (unsigned int)entry->bits,
                           ect_build_idn_text(build, entry->index));
    }
}

/* The IDNs that the lists S-0-0187 and S-0-0188 of the dictionary name may be in the telegrams too. */
static void take_choices(ect_build_t *build, uint8_t drive, uint16_t list, uint8_t flag)
{
    const ect_build_idn_t *of = ect_build_idn(build, drive, list);
    if (of == NULL || !is_list(of) || of->row.content == NULL)
        return;
    for (uint16_t i = 0; i + 1 < of->row.used; i += 2) {
        const uint16_t number = ect_load_le16((const uint8_t *)of->row.content + i);
        ect_build_idn_t *idn = ect_build_idn(build, drive, number);
        if (idn != NULL && is_number(idn) && number != CONTROL_WORD && number != STATUS_WORD)
            idn->row.flags |= flag;
    }
}

/* --- standard parameters ------------------------------------------------------------------------------------------ */

static ect_build_idn_t *standard(ect_build_t *build, uint8_t drive, uint16_t idn, uint32_t attribute, const char *name)
{
    ect_build_idn_t *found = ect_build_idn(build, drive, idn);
    return found != NULL ? found : add(build, drive, idn, attribute, name);
}

static void force(ect_build_idn_t *idn, uint32_t shape)
{
    const uint32_t bits = ECT_SOE_64 | ECT_SOE_LIST | ECT_SOE_COMMAND;
    idn->row.attribute = (idn->row.attribute & ~bits) | (shape & bits);
    idn->row.flags = 0;
}

/* Sets S-0-0016 and S-0-0024: the IDNs after the first one, in the order of the PDO. */
static void set_list(ect_build_t *build, uint8_t drive, bool tx, ect_build_idn_t *list)
{
    uint16_t count = 0;
    uint16_t most = 0;
    for (size_t i = 0; i < build->soe->count; i++) {
        const ect_build_idn_t *idn = &build->soe->idns[i];
        if (idn->drive == drive && (idn->row.flags & (tx ? ECT_SOE_IN_AT : ECT_SOE_IN_MDT)) != 0)
            most++;
    }
    uint8_t *content = ect_arena_alloc(build->arena, 2u * ECT_ESI_VALUES);
    const ect_esi_pdo_t *pdo = build->soe->telegrams[drive][tx];
    for (size_t i = 1; pdo != NULL && i < pdo->entry_count; i++)
        ect_store_le16(content + 2u * count++, pdo->entries[i].index);
    force(list, IDN_LIST);
    list->row.content = content;
    list->row.used = (uint16_t)(2 * count);
    most = most < ECT_ESI_VALUES ? most : ECT_ESI_VALUES;
    list->row.size = (uint16_t)(2u * (most > count ? most : count));
}

/* The primary operation mode that the set values in the telegram belong to: 11 position, 2 speed, 1 torque. */
static uint16_t mode_of(const ect_build_t *build, uint8_t drive)
{
    const ect_build_idn_t *position = ect_build_idn(build, drive, POSITION_COMMAND);
    const ect_build_idn_t *speed = ect_build_idn(build, drive, SPEED_COMMAND);
    if (position != NULL && position->cyclic)
        return 11;
    return speed != NULL && speed->cyclic ? 2 : 1;
}

static void add_standard(ect_build_t *build, uint8_t drive)
{
    static const struct {
        uint16_t idn;
        uint16_t size;
        uint32_t attribute;
        const char *name;
    } lists[] = {
        {ALL_IDNS, 0, IDN_LIST | ECT_SOE_READ_ONLY, "IDN list of all operation data"},
        {SAFEOP_ERRORS, ERROR_LIST, IDN_LIST | ECT_SOE_READ_ONLY, "IDN list of invalid operation data for SAFEOP"},
        {OP_ERRORS, ERROR_LIST, IDN_LIST | ECT_SOE_READ_ONLY, "IDN list of invalid operation data for OP"},
        {AT_IDNS, 0, IDN_LIST | ECT_SOE_READ_ONLY, "IDN list of configurable data in the AT"},
        {MDT_IDNS, 0, IDN_LIST | ECT_SOE_READ_ONLY, "IDN list of configurable data in the MDT"},
    };
    take_choices(build, drive, AT_IDNS, ECT_SOE_IN_AT);
    take_choices(build, drive, MDT_IDNS, ECT_SOE_IN_MDT);
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        ect_build_idn_t *list = standard(build, drive, lists[i].idn, lists[i].attribute, lists[i].name);
        force(list, IDN_LIST);
        list->row.content = NULL;
        list->row.used = 0;
        list->row.size = lists[i].size;
    }
    ect_build_idn_t *type =
        standard(build, drive, TELEGRAM_TYPE, ECT_SOE_16 | LOCKED_ABOVE_PREOP | 1u, "Telegram type");
    force(type, ECT_SOE_16);
    type->row.initial = APPLICATION_TELEGRAM;
    ect_build_idn_t *mode = ect_build_idn(build, drive, OPERATION_MODE);
    if (mode == NULL)
        add(build, drive, OPERATION_MODE, ECT_SOE_16 | LOCKED_ABOVE_PREOP | 1u, "Primary operation mode")->row.initial =
            mode_of(build, drive);
    force(standard(build, drive, RESET, ECT_SOE_16 | ECT_SOE_COMMAND | 1u, "Reset class 1 diagnostic"),
          ECT_SOE_16 | ECT_SOE_COMMAND);
    set_list(build, drive, true,
             standard(build, drive, AT_LIST, IDN_LIST | LOCKED_ABOVE_PREOP, "Configuration list of the AT"));
    set_list(build, drive, false,
             standard(build, drive, MDT_LIST, IDN_LIST | LOCKED_ABOVE_PREOP, "Configuration list of the MDT"));
}

/* --- start-up commands -------------------------------------------------------------------------------------------- */

/* @return ECT_SOE_LOCK_... that would refuse a write at one of the transitions */
static uint32_t locks_at(const char *transitions)
{
    const bool preop = strstr(transitions, "IP") != NULL || strstr(transitions, "PS") != NULL;
    const bool safeop = strstr(transitions, "SO") != NULL || strstr(transitions, "SP") != NULL;
    const bool op = strstr(transitions, "OS") != NULL || strstr(transitions, "OP") != NULL;
    return (preop ? ECT_SOE_LOCK_PREOP : 0) | (safeop ? ECT_SOE_LOCK_SAFEOP : 0) | (op ? ECT_SOE_LOCK_OP : 0);
}

/* A list begins with its length, which fits the data, and its capacity. */
static bool looks_like_list(const ect_esi_bytes_t *data)
{
    return data->length >= LIST_HEAD && data->bytes != NULL && ect_load_le16(data->bytes) == data->length - LIST_HEAD &&
           data->length != 8;
}

static ect_build_idn_t *add_from(ect_build_t *build, const ect_esi_mail_t *init)
{
    const char *name = *init->comment != '\0' ? init->comment : "Start-up parameter";
    const size_t length = init->data.length;
    ect_build_note(build, "line %d: a start-up command writes %s, which the dictionary lacks: it is added", init->line,
                   ect_build_idn_text(build, init->idn));
    if (!looks_like_list(&init->data))
        return add(build, init->drive, init->idn, width_of((uint32_t)(8 * length)) | ECT_SOE_UNSIGNED | 1u, name);
    ect_build_idn_t *list = add(build, init->drive, init->idn, ECT_SOE_8 | ECT_SOE_LIST | 1u, name);
    const uint16_t said = ect_load_le16(init->data.bytes + 2);
    const uint16_t used = (uint16_t)(length - LIST_HEAD);
    list->row.size = said > used ? said : used;
    return list;
}

static bool fits(const ect_build_idn_t *idn, const ect_esi_bytes_t *data)
{
    if (!is_list(idn))
        return data->length == ect_soe_width(idn->row.attribute);
    return data->length >= LIST_HEAD && ect_load_le16(data->bytes) == data->length - LIST_HEAD &&
           data->length - LIST_HEAD <= idn->row.size;
}

static void drop_limits(ect_build_idn_t *idn, const ect_esi_mail_t *init)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < init->data.length && i < 8; i++)
        bits |= (uint64_t)init->data.bytes[i] << 8 * i;
    const ect_esi_number_t number = {.bytes = (uint8_t)ect_soe_width(idn->row.attribute), .value = (int64_t)bits};
    const int64_t value = extended(idn, number);
    if (is_number(idn) && ((value < idn->row.minimum && (idn->row.flags & ECT_SOE_MINIMUM) != 0) ||
                           (value > idn->row.maximum && (idn->row.flags & ECT_SOE_MAXIMUM) != 0)))
        idn->row.flags &= (uint8_t)~(unsigned int)(ECT_SOE_MINIMUM | ECT_SOE_MAXIMUM);
}

/* Makes each IDN of a command exist and accept the data (SOE-046). */
static void take_init(ect_build_t *build, const ect_esi_mail_t *init)
{
    if (init->drive >= build->soe->drives) {
        ect_build_note(build, "line %d: a start-up command is for drive %u; the device has %u", init->line,
                       (unsigned int)init->drive, (unsigned int)build->soe->drives);
        return;
    }
    ect_build_idn_t *idn = ect_build_idn(build, init->drive, init->idn);
    if (idn == NULL && init->data.length > 0 && init->data.length <= LONGEST_LIST)
        idn = add_from(build, init);
    if (idn == NULL || !fits(idn, &init->data)) {
        ect_build_note(build, "line %d: a start-up command writes %zu bytes to %s, which does not take them",
                       init->line, init->data.length, ect_build_idn_text(build, init->idn));
        return;
    }
    drop_limits(idn, init);
    idn->row.attribute &= ~locks_at(init->transitions);
}

/* --- entries of the dictionary ------------------------------------------------------------------------------------ */

static uint16_t entry_type(const ect_build_idn_t *idn)
{
    static const uint16_t unsigned_types[] = {ECT_TYPE_UNSIGNED8, ECT_TYPE_UNSIGNED16, ECT_TYPE_UNSIGNED32,
                                              ECT_TYPE_UNSIGNED64};
    static const uint16_t signed_types[] = {ECT_TYPE_INTEGER8, ECT_TYPE_INTEGER16, ECT_TYPE_INTEGER32,
                                            ECT_TYPE_INTEGER64};
    const unsigned int width = idn->row.attribute >> 16 & 3u;
    const uint32_t kind = idn->row.attribute & ECT_SOE_KIND;
    if (kind == ECT_SOE_FLOAT && width >= 2)
        return width == 2 ? ECT_TYPE_REAL32 : ECT_TYPE_REAL64;
    return kind == ECT_SOE_SIGNED ? signed_types[width] : unsigned_types[width];
}

static void add_entry(ect_build_t *build, ect_build_idn_t *idn, uint16_t *next)
{
    while (*next <= LAST_ENTRY && ect_build_find(build, *next) != NULL)
        (*next)++;
    if (*next > LAST_ENTRY) {
        ect_build_fail(build, "its drives have more than %u values for telegrams", LAST_ENTRY - FIRST_ENTRY + 1u);
        return;
    }
    const uint16_t bits = (uint16_t)(8u * ect_soe_width(idn->row.attribute));
    const uint16_t access = ECT_ACCESS_RO | ((idn->row.flags & ECT_SOE_IN_AT) != 0 ? ECT_ACCESS_TXPDO : 0) |
                            ((idn->row.flags & ECT_SOE_IN_MDT) != 0 ? ECT_ACCESS_RXPDO : 0);
    ect_build_object_t *object = ect_build_object(build, *next, ECT_OBJECT_VAR, idn->row.name);
    ect_build_entry_t *entry = ect_build_add(build, object, 0, entry_type(idn), bits, access, idn->row.name);
    ect_build_initial(build, entry, idn->row.initial);
    idn->entry = (*next)++;
    idn->row.mapping = ECT_MAP(idn->entry, 0, bits);
}

static void add_entries(ect_build_t *build)
{
    uint16_t next = FIRST_ENTRY;
    for (size_t i = 0; i < build->soe->count && build->failure == NULL; i++) {
        ect_build_idn_t *idn = &build->soe->idns[i];
        if (idn->cyclic || (idn->row.flags & (ECT_SOE_IN_AT | ECT_SOE_IN_MDT)) != 0)
            add_entry(build, idn, &next);
    }
}

uint16_t ect_build_mapped(const ect_build_t *build, const ect_build_pdo_t *pdo, const ect_esi_entry_t *entry)
{
    if (!pdo->is_telegram)
        return entry->index != 0 ? ect_build_index(entry->index, entry->moves, pdo->steps) : 0;
    const ect_build_idn_t *idn = is_value(entry) ? ect_build_idn(build, pdo->drive, entry->index) : NULL;
    return idn != NULL ? idn->entry : 0;
}

/* --- all of it ---------------------------------------------------------------------------------------------------- */

/* @return whether a list of IDNs can describe a telegram: it begins with the word, and the others are values */
static bool is_listed(const ect_esi_pdo_t *pdo)
{
    const uint16_t word = pdo->tx ? STATUS_WORD : CONTROL_WORD;
    if (pdo->entry_count == 0 || pdo->entry_count > ECT_ESI_VALUES + 1 || pdo->entries[0].index != word ||
        pdo->entries[0].bits != 16)
        return false;
    for (size_t i = 0; i < pdo->entry_count; i++) {
        const uint16_t idn = pdo->entries[i].index;
        if (!is_value(&pdo->entries[i]) || (i > 0 && (idn == STATUS_WORD || idn == CONTROL_WORD)))
            return false;
    }
    return true;
}

static void find_telegrams(ect_build_t *build)
{
    for (size_t i = 0; i < build->model->pdo_count; i++) {
        const ect_esi_pdo_t *pdo = &build->model->pdos[i];
        if (!ect_build_is_telegram(build, pdo))
            continue;
        const ect_esi_pdo_t **of = &build->soe->telegrams[ect_build_drive_of(build, pdo)][pdo->tx];
        if (*of == NULL && pdo->sm >= 0 && is_listed(pdo))
            *of = pdo;
        add_telegram(build, pdo);
    }
}

static int by_drive(const void *a, const void *b)
{
    const ect_build_idn_t *left = a;
    const ect_build_idn_t *right = b;
    return left->drive != right->drive ? left->drive - right->drive : left->row.idn - right->row.idn;
}

void ect_build_idns(ect_build_t *build)
{
    const ect_esi_device_t *model = build->model;
    const uint8_t channels = model->mailbox.soe_channels;
    if (!model->mailbox.soe || build->rack != NULL)
        return;
    build->soe = ect_arena_alloc(build->arena, sizeof *build->soe);
    build->soe->drives = channels == 0 ? 1 : channels < ECT_SOE_DRIVES ? channels : (uint8_t)ECT_SOE_DRIVES;
    for (uint8_t drive = 0; drive < build->soe->drives; drive++)
        build->soe->positions[drive] = ect_arena_alloc(build->arena, (UINT16_MAX + 1) * sizeof(uint32_t));
    if (channels > ECT_SOE_DRIVES)
        ect_build_note(build, "it has %u drives; SoE reaches %u", (unsigned int)channels, (unsigned int)ECT_SOE_DRIVES);
    for (uint8_t drive = 0; drive < build->soe->drives; drive++) {
        for (size_t i = 0; i < model->idns.object_count; i++)
            add_object(build, drive, &model->idns.objects[i]);
    }
    find_telegrams(build);
    for (uint8_t drive = 0; drive < build->soe->drives; drive++)
        add_standard(build, drive);
    for (size_t i = 0; i < model->mailbox.mail_count; i++) {
        const ect_esi_mail_t *mail = &model->mailbox.mails[i];
        if (mail->protocol == ECT_MAILBOX_TYPE_SOE && mail->type == ECT_INIT_WRITES)
            take_init(build, mail);
    }
    add_entries(build);
    qsort(build->soe->idns, build->soe->count, sizeof *build->soe->idns, by_drive);
    for (size_t i = 0; i < build->soe->count; i++) {
        const ect_build_idn_t *idn = &build->soe->idns[i];
        build->soe->positions[idn->drive][idn->row.idn] = (uint32_t)i + 1;
    }
}
