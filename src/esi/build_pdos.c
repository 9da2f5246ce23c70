/* SPDX-License-Identifier: MIT */
/* Makes mapping objects from PDOs, makes mapped entries mappable, and sets the default assignments. */
#include <string.h>

#include "esi/internal.h"

enum { LONGEST_MAPPING = 254, LONGEST_ENTRY = 255, ASSIGNMENT = 0x1C10 };

static bool is_input_sm(const ect_esi_sm_t *sm)
{
    return strstr(sm->type, "Inputs") != NULL; // also "DynamicInputs"
}

static bool is_output_sm(const ect_esi_sm_t *sm)
{
    return strstr(sm->type, "Outputs") != NULL;
}

static bool sm_takes(const ect_esi_device_t *model, int sm, const ect_esi_pdo_t *pdo)
{
    if (sm < 0 || (size_t)sm >= model->sm_count || model->sms[sm].virtual_sm)
        return false;
    return pdo->tx ? is_input_sm(&model->sms[sm]) : is_output_sm(&model->sms[sm]);
}

/* --- mapped entries ----------------------------------------------------------------------------------------------- */

/* Makes a record of a value for which a PDO, but not the dictionary, has sub-indices: masters use the PDO. */
static void make_record(ect_build_t *build, ect_build_object_t *object)
{
    ect_build_note(build, "object %04X is a single value in the dictionary and a record in a PDO: it is a record",
                   (unsigned int)object->index);
    object->code = ECT_OBJECT_RECORD;
    object->count = 0;
}

static ect_build_entry_t *entry_for(ect_build_t *build, const ect_esi_entry_t *model, uint16_t index)
{
    ect_build_object_t *object = ect_build_find(build, index);
    if (object == NULL)
        object = ect_build_object(build, index, model->subindex == 0 ? ECT_OBJECT_VAR : ECT_OBJECT_RECORD, model->name);
    else if (object->code == ECT_OBJECT_VAR && model->subindex != 0)
        make_record(build, object);
    ect_build_entry_t *entry = ect_build_entry(object, model->subindex);
    if (entry != NULL)
        return entry;
    ect_build_entry_t *zero = ect_build_entry(object, 0);
    if (object->code != ECT_OBJECT_VAR && zero != NULL && ect_build_number(zero) < model->subindex)
        ect_build_initial(build, zero, model->subindex);
    return ect_build_add(build, object, model->subindex, ECT_TYPE_NONE, 0, ECT_ACCESS_RO, model->name);
}

/* Two PDOs may map an entry with different lengths: the longest one is used. */
static void widen(ect_build_t *build, ect_build_entry_t *entry, const ect_esi_entry_t *model)
{
    ect_esi_basic_t basic;
    if (entry->bits >= model->bits || !ect_esi_resolve(&build->model->dictionary, model->type, model->bits, &basic))
        return;
    entry->data_type = basic.code;
    entry->bits = (uint16_t)basic.bits;
}

static bool map_entry(ect_build_t *build, const ect_build_pdo_t *pdo, const ect_esi_entry_t *model, uint16_t index)
{
    if (ect_od_is_rxpdo(index) || ect_od_is_txpdo(index)) {
        ect_build_note(build, "line %d: PDO %04X maps %04X:%u, which is a mapping itself: it is a gap", model->line,
                       (unsigned int)pdo->index, (unsigned int)index, (unsigned int)model->subindex);
        return false;
    }
    const ect_build_object_t *object = ect_build_find(build, index);
    if (object != NULL && object->code != ECT_OBJECT_VAR && model->subindex == 0 && model->bits > 8) {
        ect_build_note(build, "line %d: PDO %04X maps %u bits of %04X:0, which has 8: they are a gap", model->line,
                       (unsigned int)pdo->index, (unsigned int)model->bits, (unsigned int)index);
        return false;
    }
    ect_build_entry_t *entry = entry_for(build, model, index);
    widen(build, entry, model);
    entry->access |= pdo->model->tx ? ECT_ACCESS_TXPDO : ECT_ACCESS_RXPDO;
    return true;
}

/* --- mapping objects --------------------------------------------------------------------------------------------- */

static size_t mapping_values(ect_build_t *build, const ect_build_pdo_t *pdo, uint32_t *values)
{
    size_t count = 0;
    for (size_t i = 0; i < pdo->model->entry_count; i++) {
        const ect_esi_entry_t *entry = &pdo->model->entries[i];
        uint16_t index = ect_build_mapped(build, pdo, entry);
        uint32_t bits = entry->bits;
        if (bits == 0) {
            ect_build_note(build, "line %d: PDO %04X has an entry of no bits: it is left out", entry->line,
                           (unsigned int)pdo->index);
            continue;
        }
        if (index == 0 || !map_entry(build, pdo, entry, index)) {
            for (; bits > 0 && count < LONGEST_MAPPING; bits -= bits < LONGEST_ENTRY ? bits : LONGEST_ENTRY)
                values[count++] = bits < LONGEST_ENTRY ? bits : LONGEST_ENTRY;
        } else if (count < LONGEST_MAPPING) {
            values[count++] = (uint32_t)index << 16 | (uint32_t)entry->subindex << 8 | bits;
        }
    }
    return count;
}

static bool is_on_virtual(const ect_esi_device_t *model, const ect_esi_pdo_t *pdo)
{
    if (pdo->sm < 0 || (size_t)pdo->sm >= model->sm_count || !model->sms[pdo->sm].virtual_sm)
        return false;
    return pdo->tx ? is_input_sm(&model->sms[pdo->sm]) : is_output_sm(&model->sms[pdo->sm]);
}

static const char *why_not(const ect_build_pdo_t *pdo, bool on_virtual)
{
    const ect_esi_pdo_t *model = pdo->model;
    uint16_t first = model->tx ? 0x1A00 : 0x1600;
    if (model->virtual_pdo && !on_virtual)
        return "it maps registers of the controller, and no virtual SyncManager has it";
    if (pdo->index < first || pdo->index >= first + 0x200)
        return model->tx ? "its index is not that of a PDO of inputs" : "its index is not that of a PDO of outputs";
    if (model->entry_count > LONGEST_MAPPING)
        return "a mapping object has at most 254 entries";
    for (size_t i = 0; i < model->entry_count; i++) {
        if (model->entries[i].index != 0 && model->entries[i].bits > LONGEST_ENTRY)
            return "an entry can map at most 255 bits";
    }
    return NULL;
}

/* @return whether the PDO is part of the default process data */
static bool counts_by_default(const ect_build_t *build, const ect_esi_pdo_t *model)
{
    return !model->virtual_pdo && model->sm >= 0 && (size_t)model->sm < build->model->sm_count &&
           !build->model->sms[model->sm].virtual_sm;
}

/* Whether the lists of a SoE drive change a mapping. Its first element exists (build_idns.c). */
static bool is_configured(const ect_build_t *build, const ect_build_pdo_t *pdo)
{
    return pdo->is_telegram && build->soe->telegrams[pdo->drive][pdo->model->tx] == pdo->model;
}

/* @return the most values that the list of a SoE drive can name */
static size_t values_of(const ect_build_t *build, const ect_build_pdo_t *pdo)
{
    const uint16_t list = pdo->model->tx ? 16 : 24;
    return ect_build_idn(build, pdo->drive, list)->row.size / sizeof(uint16_t);
}

/* Whether the dictionary of the file lets a master write a mapping or an assignment, whatever PdoConfig and
 * PdoAssign announce. */
static bool is_writable(const ect_build_t *build, uint16_t index)
{
    const ect_build_object_t *object = ect_build_find(build, index);
    const ect_build_entry_t *count = object != NULL ? ect_build_entry(object, 0) : NULL;
    return count != NULL && (count->access & ECT_ACCESS_W_PREOP) != 0;
}

static void add_mapping(ect_build_t *build, ect_build_pdo_t *pdo)
{
    uint32_t values[LONGEST_MAPPING];
    bool on_virtual = is_on_virtual(build->model, pdo->model);
    const char *why = why_not(pdo, on_virtual);
    pdo->usable = why == NULL;
    pdo->on_virtual = on_virtual && pdo->usable;
    if (why != NULL && counts_by_default(build, pdo->model)) {
        ect_build_fail(build, "line %d: PDO %04X (%s) is assigned to SyncManager %d, and %s", pdo->model->line,
                       (unsigned int)pdo->index, pdo->model->name, pdo->model->sm, why);
        return;
    }
    if (why != NULL) {
        ect_build_note(build, "line %d: PDO %04X (%s) is left out: %s", pdo->model->line, (unsigned int)pdo->index,
                       pdo->model->name, why);
        return;
    }
    size_t count = mapping_values(build, pdo, values);
    ECT_ASSERT(count <= LONGEST_MAPPING);
    if (count == 0)
        ect_build_note(build, "line %d: PDO %04X (%s) has no entries: it carries no data", pdo->model->line,
                       (unsigned int)pdo->index, pdo->model->name);
    const ect_build_object_t *described = ect_build_find(build, pdo->index);
    bool changeable = (build->model->mailbox.pdo_config || is_writable(build, pdo->index)) && !pdo->model->fixed;
    size_t capacity = described != NULL && described->count > count + 1 ? described->count - 1 : count;
    if (is_configured(build, pdo))
        capacity = values_of(build, pdo) + 1 > count ? values_of(build, pdo) + 1 : count;
    ect_build_object_t *mapping =
        ect_build_numbers(build, pdo->index, pdo->model->name, "Mapped object", ECT_TYPE_UNSIGNED32,
                          changeable ? ECT_ACCESS_RW_PREOP : ECT_ACCESS_RO, values, count, capacity);
    mapping->entries[1].constant = is_configured(build, pdo); /* control word, status word */
}

/* --- assignment -------------------------------------------------------------------------------------------------- */

static bool excludes(const ect_build_pdo_t *a, const ect_build_pdo_t *b)
{
    for (size_t i = 0; i < a->model->exclude_count; i++) {
        if (ect_build_pdo_index(a->model->exclude[i].index, a->model->exclude[i].moves, a->steps) == b->index)
            return true;
    }
    return false;
}

static const ect_build_pdo_t *conflicting_pdo(const ect_build_t *build, const ect_build_pdo_t *pdo)
{
    for (const ect_build_pdo_t *other = build->pdos; other < pdo; other++) {
        if (other->assigned && (excludes(other, pdo) || excludes(pdo, other)))
            return other;
    }
    return NULL;
}

static void assign(ect_build_t *build, ect_build_pdo_t *pdo)
{
    const ect_esi_pdo_t *model = pdo->model;
    if (!pdo->usable || model->sm < 0 || pdo->on_virtual)
        return;
    const ect_build_pdo_t *other = conflicting_pdo(build, pdo);
    if (!sm_takes(build->model, model->sm, model)) {
        ect_build_note(build, "line %d: PDO %04X is assigned to SyncManager %d, which is not one for %s", model->line,
                       (unsigned int)pdo->index, model->sm, model->tx ? "inputs" : "outputs");
    } else if (other != NULL) {
        ect_build_note(build, "line %d: PDO %04X is assigned beside %04X, which it excludes: it is not", model->line,
                       (unsigned int)pdo->index, (unsigned int)other->index);
    } else {
        pdo->assigned = true;
        if (model->samples > 1)
            ect_build_note(build, "line %d: PDO %04X has %u samples in a cycle with the file's default; the twin has 1",
                           model->line, (unsigned int)pdo->index, (unsigned int)model->samples);
    }
}

uint32_t ect_build_pdo_bits(const ect_build_pdo_t *pdo)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < pdo->model->entry_count; i++)
        bits += pdo->model->entries[i].bits;
    return bits;
}

uint32_t ect_build_assigned_bits(const ect_build_t *build, int sm)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < build->pdo_count; i++) {
        const ect_build_pdo_t *pdo = &build->pdos[i];
        bits += (pdo->assigned || pdo->on_virtual) && pdo->model->sm == sm ? ect_build_pdo_bits(pdo) : 0;
    }
    return bits;
}

/* @return whether a master may assign a PDO to a SyncManager, by default or by choice */
static bool may_be_assigned(const ect_build_t *build, const ect_build_pdo_t *pdo, int sm)
{
    return pdo->usable && !pdo->on_virtual && (pdo->model->sm == sm || pdo->model->sm < 0) &&
           sm_takes(build->model, sm, pdo->model);
}

static bool shares(const ect_build_t *build, size_t i, size_t place)
{
    for (size_t k = place; k < i; k++) {
        const ect_build_pdo_t *a = &build->pdos[k], *b = &build->pdos[i];
        if (a->place == place && !excludes(a, b) && !excludes(b, a))
            return false;
    }
    return build->pdos[place].place == place;
}

static void find_place(ect_build_t *build, size_t i)
{
    size_t place = 0;
    while (place < i && !shares(build, i, place))
        place++;
    ECT_ASSERT(place <= i);
    build->pdos[i].place = place;
}

/* Sums the longest PDO of each place. */
uint32_t ect_build_largest_bits(const ect_build_t *build, int sm)
{
    uint32_t bits = 0;
    for (size_t place = 0; place < build->pdo_count; place++) {
        uint32_t most = 0;
        for (size_t i = place; i < build->pdo_count; i++) {
            const ect_build_pdo_t *pdo = &build->pdos[i];
            bool counts = pdo->place == place && may_be_assigned(build, pdo, sm);
            most = counts && ect_build_pdo_bits(pdo) > most ? ect_build_pdo_bits(pdo) : most;
        }
        bits += most;
    }
    return bits;
}

static bool has_place(const ect_build_t *build, size_t place, int sm)
{
    for (size_t i = place; i < build->pdo_count; i++) {
        if (build->pdos[i].place == place && may_be_assigned(build, &build->pdos[i], sm))
            return true;
    }
    return false;
}

static void add_assignment(ect_build_t *build, int sm)
{
    uint32_t values[LONGEST_MAPPING];
    size_t count = 0;
    size_t capacity = 0;
    for (size_t i = 0; i < build->pdo_count; i++) {
        const ect_build_pdo_t *pdo = &build->pdos[i];
        capacity += has_place(build, i, sm) && capacity < LONGEST_MAPPING ? 1 : 0;
        if (pdo->assigned && pdo->model->sm == sm && count < LONGEST_MAPPING)
            values[count++] = pdo->index;
    }
    ECT_ASSERT(sm >= 0 && (size_t)sm < build->model->sm_count && count <= capacity);
    bool changeable = build->model->mailbox.pdo_assign || is_writable(build, (uint16_t)(ASSIGNMENT + sm));
    (void)ect_build_numbers(build, (uint16_t)(ASSIGNMENT + sm), "", "Assigned PDO", ECT_TYPE_UNSIGNED16,
                            changeable ? ECT_ACCESS_RW_PREOP : ECT_ACCESS_RO, values, count,
                            changeable ? capacity : count);
    ect_build_object_t *object = ect_build_find(build, (uint16_t)(ASSIGNMENT + sm));
    if (*object->name == '\0')
        object->name = ect_arena_print(build->arena, "SyncManager %d PDO assignment", sm);
}

void ect_build_pdos(ect_build_t *build)
{
    const ect_esi_device_t *model = build->model;
    for (size_t i = 0; i < build->pdo_count; i++) {
        build->module = build->pdos[i].module;
        add_mapping(build, &build->pdos[i]);
    }
    build->module = 0;
    for (size_t i = 0; i < build->pdo_count; i++) {
        assign(build, &build->pdos[i]);
        find_place(build, i);
    }
    for (size_t sm = 0; sm < model->sm_count; sm++) {
        if (!model->sms[sm].virtual_sm && (is_input_sm(&model->sms[sm]) || is_output_sm(&model->sms[sm])))
            add_assignment(build, (int)sm);
    }
}
