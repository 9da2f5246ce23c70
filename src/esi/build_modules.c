/* SPDX-License-Identifier: MIT */
/* Modular devices: a module brings PDOs and objects, whose indices move with its slot. */
#include "esi/internal.h"

/* @return whether a PDO has the index: one that was added, or one of the file */
static bool is_taken(const ect_build_t *build, uint16_t index)
{
    for (size_t i = 0; i < build->pdo_count; i++) {
        if (build->pdos[i].index == index)
            return true;
    }
    for (size_t i = 0; i < build->model->pdo_count; i++) {
        if (build->model->pdos[i].index == index)
            return true;
    }
    return false;
}

/* Gives a PDO an index that a mapping object may have. Without CoE the index in the file has no meaning for a master,
 * and may be any number; for a SoE drive it is an IDN. */
static uint16_t index_of(ect_build_t *build, const ect_esi_pdo_t *model, const ect_build_steps_t *steps)
{
    uint16_t index = ect_build_pdo_index(model->index, model->moves, steps);
    uint16_t first = model->tx ? 0x1A00 : 0x1600;
    const bool telegram = ect_build_is_telegram(build, model);
    if ((build->model->mailbox.coe && !telegram) || (index >= first && index < first + 0x200))
        return index;
    uint16_t substitute = first;
    while (is_taken(build, substitute))
        substitute++;
    if (!telegram)
        ect_build_note(build, "line %d: PDO %04X is PDO %04X in the SII of the twin", model->line, (unsigned int)index,
                       (unsigned int)substitute);
    return substitute;
}

static void add_pdo(ect_build_t *build, const ect_esi_pdo_t *model, const ect_build_steps_t *steps)
{
    uint16_t index = index_of(build, model, steps);
    for (size_t i = 0; i < build->pdo_count; i++) {
        if (build->pdos[i].index == index && build->pdos[i].model->tx == model->tx) {
            ect_build_note(build, "line %d: PDO %04X occurs twice: the first one is used", model->line,
                           (unsigned int)index);
            return;
        }
    }
    build->pdos = ect_arena_grow(build->arena, build->pdos, build->pdo_count, sizeof *build->pdos);
    build->pdos[build->pdo_count++] = (ect_build_pdo_t){.model = model,
                                                        .index = index,
                                                        .steps = steps,
                                                        .module = build->module,
                                                        .group = build->pdo_group,
                                                        .is_telegram = ect_build_is_telegram(build, model),
                                                        .drive = ect_build_drive_of(build, model)};
}

void ect_build_module(ect_build_t *build, const ect_esi_module_t *module, const ect_build_steps_t *steps)
{
    build->module = module->ident;
    build->pdo_group = module->pdo_group;
    for (size_t i = 0; i < module->pdo_count; i++)
        add_pdo(build, &module->pdos[i], steps);
    ect_build_objects(build, &module->dictionary, steps);
    ect_build_inits(build, module->inits, module->init_count, steps);
    build->module = 0;
    build->pdo_group = 0;
}

/* One place for a module. */
typedef struct place {
    const ect_esi_slot_t *slot;
    unsigned int number;   /* in the device, from 0 */
    unsigned int instance; /* of that slot, from 0 */
} place_t;

static void insert(ect_build_t *build, const place_t *place, uint32_t ident)
{
    ECT_ASSERT(ident != 0 && place->instance < place->slot->instances_max);
    const ect_esi_module_t *module = ect_esi_module(build->model, ident);
    if (module == NULL || !ect_esi_slot_takes(place->slot, module)) {
        ect_build_fail(build, "slot %u (%s) takes no module 0x%08X", place->number + 1, place->slot->name,
                       (unsigned int)ident);
        return;
    }
    const ect_esi_slot_t *slot = place->slot;
    const unsigned int before = slot->own_increments ? place->instance : place->number;
    ect_build_steps_t *steps = ect_arena_alloc(build->arena, sizeof *steps);
    *steps = (ect_build_steps_t){.slot_index = before * slot->index_increment,
                                 .slot_pdo = before * slot->pdo_increment,
                                 .group_index = slot->group * slot->group_index_increment,
                                 .group_pdo = slot->group * slot->group_pdo_increment};
    ect_build_module(build, module, steps);
}

/* Selects the module of a place: the user's choice, else the preset of the file, in as many places as need a module. */
static uint32_t ident_in(const ect_build_t *build, const place_t *place, const ect_module_choice_t *choices,
                         size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (choices[i].slot == place->number)
            return choices[i].ident;
    }
    return ect_esi_preset(build->model, place->number);
}

void ect_build_modules(ect_build_t *build, const ect_module_choice_t *choices, size_t count)
{
    const ect_esi_device_t *model = build->model;
    place_t place = {.number = 0};
    build->pdo_group = model->pdo_group;
    for (size_t i = 0; i < model->pdo_count; i++)
        add_pdo(build, &model->pdos[i], &ect_build_device);
    for (size_t i = 0; i < model->slot_count; i++) {
        place.slot = &model->slots[i];
        for (place.instance = 0; place.instance < place.slot->instances_max; place.instance++, place.number++) {
            uint32_t ident = ident_in(build, &place, choices, count);
            if (ident != 0)
                insert(build, &place, ident);
            build->idents = ect_arena_grow(build->arena, build->idents, build->ident_count, sizeof *build->idents);
            build->idents[build->ident_count++] = ident;
        }
    }
    for (size_t i = 0; i < count; i++) {
        if (choices[i].slot >= place.number)
            ect_build_fail(build, "there is no slot %u; the device has %u", choices[i].slot + 1, place.number);
    }
    ect_build_pdo_groups(build);
}
