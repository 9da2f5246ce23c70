/* SPDX-License-Identifier: MIT */
/* Objects of the dictionary: a type with sub-items is a record, a type with a sub-item for elements is an array. */
#include <string.h>
#include <strings.h>

#include "esi/internal.h"

enum { ASSIGNMENTS = 32 /* 1C10h to 1C2Fh */ };

/* @return the states in which an access is allowed; all for an unknown word */
static uint16_t states(const char *restriction, uint16_t preop, uint16_t safeop, uint16_t op)
{
    const struct {
        const char *name;
        unsigned int bits;
    } known[] = {
        {"PreOP", preop},   {"PreOP_SafeOP", (unsigned int)preop | safeop}, {"PreOP_OP", (unsigned int)preop | op},
        {"SafeOP", safeop}, {"SafeOP_OP", (unsigned int)safeop | op},       {"OP", op},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcasecmp(known[i].name, restriction) == 0)
            return (uint16_t)known[i].bits;
    }
    return (uint16_t)(preop | safeop | op);
}

/* @return the flag of the sub-item, or else that of the object */
static const char *either(const char *own, const char *inherited)
{
    return *own != '\0' ? own : inherited;
}

uint16_t ect_build_access(const ect_esi_flags_t *own, const ect_esi_flags_t *object)
{
    const char *access = either(own->access, object->access);
    const char *mapping = either(own->mapping, object->mapping);
    uint16_t bits = 0;
    if (strcmp(access, "wo") != 0)
        bits = (uint16_t)(bits | states(either(own->read_in, object->read_in), ECT_ACCESS_R_PREOP, ECT_ACCESS_R_SAFEOP,
                                        ECT_ACCESS_R_OP));
    if (strcmp(access, "rw") == 0 || strcmp(access, "wo") == 0)
        bits = (uint16_t)(bits | states(either(own->write_in, object->write_in), ECT_ACCESS_W_PREOP,
                                        ECT_ACCESS_W_SAFEOP, ECT_ACCESS_W_OP));
    if (strpbrk(mapping, "tT") != NULL)
        bits |= ECT_ACCESS_TXPDO;
    if (strpbrk(mapping, "rR") != NULL)
        bits |= ECT_ACCESS_RXPDO;
    if (own->backup || object->backup)
        bits |= ECT_ACCESS_BACKUP;
    if (own->setting || object->setting)
        bits |= ECT_ACCESS_SETTING;
    return bits;
}

/* Extends the sign of bytes as the entry's type requires. */
static ect_esi_number_t limit_of(const ect_build_entry_t *entry, ect_esi_number_t limit)
{
    uint64_t sign = limit.bytes > 0 ? UINT64_C(1) << (8 * limit.bytes - 1) : 0;
    if (ect_build_is_signed(entry->data_type) && ((uint64_t)limit.value & sign) != 0)
        limit.value = (int64_t)((uint64_t)limit.value | ~(2 * sign - 1));
    limit.bytes = 0;
    return limit;
}

static void take_info(ect_build_entry_t *entry, const ect_esi_info_t *info)
{
    size_t room = (entry->bits + 7u) / 8u;
    ECT_ASSERT(info->initial.bytes != NULL || info->initial.length == 0);
    if (info->initial.bytes != NULL) {
        entry->initial = info->initial;
        if (entry->initial.length > room)
            entry->initial.length = room; /* a number of 8 bytes for a shorter entry, or a text that is too long */
    }
    if (info->minimum.given)
        entry->minimum = limit_of(entry, info->minimum);
    if (info->maximum.given)
        entry->maximum = limit_of(entry, info->maximum);
    if (info->unit != 0) {
        entry->unit = (uint16_t)(info->unit >> 16);
        entry->per = (uint8_t)(info->unit >> 8);
    }
}

/* An object under construction. */
typedef struct maker {
    ect_build_t *build;
    const ect_esi_dictionary_t *dictionary;
    const ect_esi_object_t *model;
    ect_build_object_t *object;
} maker_t;

/* @return the info of the object for an entry, by the name of the sub-item, or else by its position */
static const ect_esi_info_t *info_of(const ect_esi_object_t *model, const char *name, size_t place)
{
    if (place < model->item_count && strcmp(model->items[place].name, name) == 0)
        return &model->items[place];
    for (size_t i = 0; i < model->item_count; i++) {
        if (strcmp(model->items[i].name, name) == 0)
            return &model->items[i];
    }
    return place < model->item_count ? &model->items[place] : NULL;
}

/* @return the display name, because many sub-items are called "SubIndex 001" to be unique */
static const char *display_of(const ect_esi_item_t *item, const ect_esi_info_t *info, const char *name)
{
    if (info != NULL && info->display != NULL && *info->display != '\0')
        return info->display;
    return item->display != NULL && *item->display != '\0' ? item->display : name;
}

static void add_entry(maker_t *m, unsigned int subindex, const ect_esi_item_t *item, const char *name,
                      const char *type_name, uint32_t bits)
{
    ect_esi_basic_t basic;
    if (subindex > UINT8_MAX || ect_build_entry(m->object, (uint8_t)subindex) != NULL ||
        !ect_esi_resolve(m->dictionary, type_name, bits, &basic)) {
        ect_build_note(m->build, "line %d: object %04X: sub-index %u of type %s is left out: %s", item->line,
                       (unsigned int)m->object->index, subindex, type_name,
                       subindex > UINT8_MAX                                    ? "255 is the highest"
                       : ect_build_entry(m->object, (uint8_t)subindex) != NULL ? "it exists already"
                                                                               : "its length is not known");
        return;
    }
    size_t place = m->object->count;
    const ect_esi_info_t *info = info_of(m->model, name, place);
    ect_build_entry_t *entry =
        ect_build_add(m->build, m->object, (uint8_t)subindex, basic.code, basic.bits,
                      ect_build_access(&item->flags, &m->model->flags), display_of(item, info, name));
    entry->minimum = basic.minimum;
    entry->maximum = basic.maximum;
    entry->reported_access = item->flags.reported_access;
    entry->reported_bits = item->flags.reported_bits;
    take_info(entry, &item->info);
    if (info != NULL)
        take_info(entry, info);
}

/* Adds the elements described by a sub-item without a number. */
static void add_elements(maker_t *m, const ect_esi_item_t *item, const ect_esi_type_t *array)
{
    uint32_t bits = array->elements.value > 0 ? array->bits / (uint32_t)array->elements.value : 0;
    unsigned int first = array->first.given && array->first.value > 0 ? (unsigned int)array->first.value : 1;
    m->object->code = ECT_OBJECT_ARRAY;
    for (unsigned int i = 0; i < array->elements.value && first + i <= UINT8_MAX; i++) {
        const char *name = ect_arena_print(m->build->arena, "SubIndex %03u", first + i);
        add_entry(m, first + i, item, name, array->base, bits);
    }
}

static void add_items(maker_t *m, const ect_esi_type_t *type)
{
    unsigned int next = 0;
    for (size_t i = 0; i < type->item_count; i++) {
        const ect_esi_item_t *item = &type->items[i];
        const ect_esi_type_t *array = ect_esi_find_type(m->dictionary, item->type);
        if (item->subindex < 0 && array != NULL && array->elements.given) {
            add_elements(m, item, array);
            continue;
        }
        unsigned int subindex = item->subindex >= 0 ? (unsigned int)item->subindex : next;
        add_entry(m, subindex, item, item->name, item->type, item->bits);
        next = subindex + 1;
    }
}

/* Sets sub-index 0 to the number of entries if the file has no default. */
static void count_entries(ect_build_t *build, ect_build_object_t *object)
{
    ect_build_entry_t *zero = ect_build_entry(object, 0);
    uint8_t highest = 0;
    for (size_t i = 0; i < object->count; i++)
        highest = object->entries[i].subindex > highest ? object->entries[i].subindex : highest;
    object->complete = zero != NULL;
    if (zero == NULL)
        return;
    const uint64_t count = zero->initial.length > 0 ? ect_build_number(zero) : highest;
    if (zero->data_type != ECT_TYPE_UNSIGNED8 || zero->bits != 8) {
        ect_build_note(build, "object %04X: sub-index 0 is no USINT in the file: the twin uses USINT",
                       (unsigned int)object->index);
        zero->data_type = ECT_TYPE_UNSIGNED8;
        zero->bits = 8;
    }
    ect_build_initial(build, zero, count < highest ? count : highest);
}

static bool has_pdo(const ect_esi_pdo_t *pdos, size_t count, uint16_t index)
{
    for (size_t i = 0; i < count; i++) {
        if (pdos[i].index == index && !pdos[i].virtual_pdo)
            return true;
    }
    return false;
}

static bool is_pdo_of(const ect_esi_device_t *model, uint16_t index)
{
    for (size_t i = 0; i < model->module_count; i++) {
        if (has_pdo(model->modules[i].pdos, model->modules[i].pdo_count, index))
            return true;
    }
    return has_pdo(model->pdos, model->pdo_count, index);
}

static void add_object(ect_build_t *build, const ect_esi_dictionary_t *dictionary, const ect_esi_object_t *model,
                       const ect_build_steps_t *steps)
{
    uint16_t index = ect_build_index(model->index, model->moves, steps);
    if ((ect_od_is_rxpdo(index) || ect_od_is_txpdo(index)) && !is_pdo_of(build->model, model->index)) {
        ect_build_note(build, "line %d: object %04X is not one of the file's PDOs: it is left out", model->line,
                       (unsigned int)index);
        return;
    }
    if (ect_build_find(build, index) != NULL) {
        ect_build_note(build, "line %d: object %04X occurs twice: the first one is used", model->line,
                       (unsigned int)index);
        return;
    }
    const ect_esi_type_t *type = ect_esi_find_type(dictionary, model->type);
    bool record = type != NULL && type->item_count > 0;
    maker_t maker = {.build = build, .dictionary = dictionary, .model = model};
    maker.object = ect_build_object(build, index, record ? ECT_OBJECT_RECORD : ECT_OBJECT_VAR, model->name);
    if (record) {
        add_items(&maker, type);
        if (maker.object->count == 1 && index >= ECT_OD_ASSIGNMENT && index < ECT_OD_ASSIGNMENT + ASSIGNMENTS)
            maker.object->code = ECT_OBJECT_ARRAY; /* an assignment is one without elements too */
        count_entries(build, maker.object);
    } else {
        const ect_esi_item_t alone = {.info = model->info,
                                      .display = model->info.display,
                                      .line = model->line,
                                      .flags = {.access = "",
                                                .read_in = "",
                                                .write_in = "",
                                                .mapping = "",
                                                .reported_access = model->flags.reported_access,
                                                .reported_bits = model->flags.reported_bits}};
        add_entry(&maker, 0, &alone, model->name, model->type, model->bits);
    }
    if (maker.object->count == 0)
        ect_build_drop_last(build); /* no entry could be read; a note has the reason */
}

void ect_build_objects(ect_build_t *build, const ect_esi_dictionary_t *dictionary, const ect_build_steps_t *steps)
{
    for (size_t i = 0; i < dictionary->object_count; i++)
        add_object(build, dictionary, &dictionary->objects[i], steps);
}

/* --- start-up commands ------------------------------------------------------------------------------------------- */

/* @return the states with a mailbox in which a master writes at one of the transitions */
static uint16_t written_in(const char *transitions)
{
    uint16_t bits = 0;
    bits |= strstr(transitions, "IP") != NULL || strstr(transitions, "PS") != NULL ? ECT_ACCESS_W_PREOP : 0;
    bits |= strstr(transitions, "SO") != NULL || strstr(transitions, "SP") != NULL ? ECT_ACCESS_W_SAFEOP : 0;
    bits |= strstr(transitions, "OS") != NULL || strstr(transitions, "OP") != NULL ? ECT_ACCESS_W_OP : 0;
    return bits != 0 ? bits : (uint16_t)ECT_ACCESS_WO;
}

/* @return NULL: the object is a single value, which has no elements */
static ect_build_entry_t *make_entry(ect_build_t *build, const ect_esi_init_t *init, uint16_t index)
{
    ect_esi_basic_t basic;
    ect_build_object_t *object = ect_build_find(build, index);
    const char *name = *init->comment != '\0' ? init->comment : "Start-up parameter";
    if (object == NULL)
        object = ect_build_object(build, index, init->subindex == 0 ? ECT_OBJECT_VAR : ECT_OBJECT_RECORD, name);
    if (object->code == ECT_OBJECT_VAR && init->subindex != 0) {
        ect_build_note(build,
                       "line %d: a start-up command writes %04X:%u, and %04X is a single value: the entry is not added",
                       init->line, (unsigned int)index, (unsigned int)init->subindex, (unsigned int)index);
        return NULL;
    }
    bool known = ect_esi_resolve(NULL, "", (uint32_t)(8 * init->data.length), &basic);
    ECT_ASSERT(known); /* a number of bytes */
    (void)known;
    ect_build_note(build, "line %d: a start-up command writes %04X:%u, which the dictionary lacks: it is added",
                   init->line, (unsigned int)index, (unsigned int)init->subindex);
    ect_build_entry_t *zero = ect_build_entry(object, 0);
    if (zero != NULL && init->subindex > ect_build_number(zero))
        ect_build_initial(build, zero, init->subindex);
    return ect_build_add(build, object, init->subindex, basic.code, basic.bits, ECT_ACCESS_RO, name);
}

/* @return whether a command is ignored: mappings and assignments are built elsewhere; entries cover whole objects */
static bool is_left_alone(const ect_esi_init_t *init, uint16_t index)
{
    return init->complete || init->data.length == 0 || ect_od_is_rxpdo(index) || ect_od_is_txpdo(index) ||
           (index >= ECT_OD_ASSIGNMENT && index < ECT_OD_ASSIGNMENT + ASSIGNMENTS);
}

void ect_build_inits(ect_build_t *build, const ect_esi_init_t *inits, size_t count, const ect_build_steps_t *steps)
{
    for (size_t i = 0; i < count; i++) {
        const ect_esi_init_t *init = &inits[i];
        uint16_t index = ect_build_index(init->index, init->moves, steps);
        ect_build_object_t *object = ect_build_find(build, index);
        ect_build_entry_t *entry = object != NULL ? ect_build_entry(object, init->subindex) : NULL;
        uint16_t wanted = written_in(init->transitions);
        if (is_left_alone(init, index))
            continue;
        if (entry == NULL)
            entry = make_entry(build, init, index);
        else if ((entry->access & wanted) != wanted)
            ect_build_note(build,
                           "line %d: a start-up command writes %04X:%u, which is read-only in the file: the twin makes "
                           "it writable",
                           init->line, (unsigned int)index, (unsigned int)init->subindex);
        if (entry != NULL)
            entry->access |= wanted;
    }
}
