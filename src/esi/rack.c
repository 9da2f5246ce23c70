/* SPDX-License-Identifier: MIT */
/* Twins. A twin whose modules can change gets a description for each set of modules that its slots have contained. */
#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"

/* Longest process image; largest instance. A device that needs more keeps its modules. */
enum { LONGEST_IMAGE = 1486, LARGEST = 8 << 20 };

/* Room in addition to each entry: for its alignment, and for the end of a text. */
enum { BESIDE = 9 };

/* @return whether an index is that of an axis's control word of CiA 402: drives keep their modules */
static bool is_of_drive(uint16_t index)
{
    return index >= 0x6000 && index < 0xA000 && index % 0x800 == 0x40;
}

static bool pdos_are_of_drive(const ect_esi_pdo_t *pdos, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < pdos[i].entry_count; k++) {
            if (is_of_drive(pdos[i].entries[k].index))
                return true;
        }
    }
    return false;
}

static bool objects_are_of_drive(const ect_esi_dictionary_t *dictionary)
{
    for (size_t i = 0; i < dictionary->object_count; i++) {
        if (is_of_drive(dictionary->objects[i].index))
            return true;
    }
    return false;
}

static bool has_drive(const ect_esi_device_t *model)
{
    bool drive = pdos_are_of_drive(model->pdos, model->pdo_count) || objects_are_of_drive(&model->dictionary);
    for (size_t i = 0; i < model->module_count && !drive; i++)
        drive = pdos_are_of_drive(model->modules[i].pdos, model->modules[i].pdo_count) ||
                objects_are_of_drive(&model->modules[i].dictionary);
    return drive;
}

static uint16_t larger(size_t a, size_t b)
{
    const size_t most = a > b ? a : b;
    return (uint16_t)(most < UINT16_MAX ? most : UINT16_MAX);
}

/* Adds the memory of a module in one slot. */
static void measure(ect_esi_rack_t *rack, const ect_esi_module_t *module, size_t slots)
{
    ect_arena_t arena = {0};
    ect_build_t build = {.arena = &arena, .model = rack->model};
    size_t bytes = 0, runs = 0;
    ect_build_module(&build, module, &ect_build_device);
    ect_build_pdos(&build);
    for (size_t i = 0; i < build.object_count; i++) {
        bytes += BESIDE + 1;
        for (size_t k = 0; k < build.objects[i].count; k++) {
            const size_t size = (build.objects[i].entries[k].bits + 7u) / 8u;
            bytes += size + BESIDE;
            rack->growth.value = larger(rack->growth.value, size);
        }
    }
    for (size_t i = 0; i < module->pdo_count; i++)
        runs += module->pdos[i].entry_count;
    rack->room += bytes * slots;
    rack->growth.runs = larger(rack->growth.runs + runs * slots, 0);
    ect_arena_free(&arena);
}

static size_t slots_for(const ect_esi_device_t *model, const ect_esi_module_t *module)
{
    size_t count = 0;
    for (unsigned int n = 0; n < ect_esi_places(model); n++)
        count += ect_esi_place_takes(model, n, module->ident);
    return count;
}

static ect_esi_twin_t *find(ect_esi_rack_t *rack, const uint32_t *idents)
{
    ect_module_choice_t choices[UINT8_MAX];
    char why[200];
    const size_t size = rack->slots * sizeof *idents;
    for (size_t i = 0; i < rack->set_count; i++) {
        if (memcmp(rack->sets[i].idents, idents, size) == 0)
            return rack->sets[i].twin;
    }
    if (rack->set_count == ECT_ESI_SETS)
        return NULL;
    for (unsigned int n = 0; n < rack->slots; n++)
        choices[n] = (ect_module_choice_t){.slot = n, .ident = idents[n]};
    uint32_t *kept = ect_arena_alloc(rack->arena, size);
    memcpy(kept, idents, size);
    ect_esi_twin_t *twin = ect_esi_twin_assemble(rack->esi, rack->model, choices, rack->slots, rack, why, sizeof why);
    rack->sets[rack->set_count].idents = kept;
    rack->sets[rack->set_count++].twin = twin;
    return twin;
}

/* @return NULL: the modules of the device do not change */
static ect_esi_rack_t *make_rack(ect_arena_t *arena, const ect_esi_t *esi, const ect_esi_device_t *model)
{
    enum { BASE_RUNS = 1024, ASSIGNMENTS = 4096 };
    const unsigned int slots = ect_esi_places(model);
    if (slots == 0 || slots > UINT8_MAX || !model->mailbox.coe || model->mailbox.eoe || has_drive(model))
        return NULL;
    ect_esi_rack_t *rack = ect_arena_alloc(arena, sizeof *rack);
    *rack = (ect_esi_rack_t){.esi = esi,
                             .model = model,
                             .arena = arena,
                             .places = ect_arena_alloc(arena, (UINT16_MAX + 1) * sizeof(ect_esi_place_t *)),
                             .room = ASSIGNMENTS,
                             .growth = {.image = LONGEST_IMAGE, .runs = BASE_RUNS},
                             .slots = slots,
                             .find = find};
    rack->used = ect_esi_change_size(rack) + ect_esi_ads_size(model);
    for (size_t i = 0; i < model->module_count && rack->room <= LARGEST; i++)
        measure(rack, &model->modules[i], slots_for(model, &model->modules[i]));
    return rack->room <= LARGEST ? rack : NULL;
}

ect_esi_twin_t *ect_esi_twin_of(const ect_esi_t *esi, const ect_esi_device_t *model, const ect_module_choice_t *modules,
                                size_t module_count, char *text, size_t room)
{
    ect_arena_t arena = {0};
    ect_esi_rack_t *rack = make_rack(&arena, esi, model);
    ect_esi_twin_t *twin = ect_esi_twin_assemble(esi, model, modules, module_count, rack, text, room);
    if (twin == NULL) {
        ect_arena_free(&arena);
        return NULL;
    }
    if (rack != NULL) {
        twin->racks = arena;
        rack->arena = &twin->racks;
        rack->sets[0].idents = twin->build.idents;
        rack->sets[0].twin = twin;
        rack->set_count = 1;
    } else {
        ect_arena_free(&arena); /* of a rack that would be too large */
    }
    return twin;
}

ect_esi_twin_t *ect_esi_twin_make(const char *path, const char *selector, const ect_module_choice_t *modules,
                                  size_t module_count, char *text, size_t room)
{
    return ect_esi_twin_take(ect_esi_open(path, text, room), selector, modules, module_count, text, room);
}

ect_esi_twin_t *ect_esi_twin_take(ect_esi_t *esi, const char *selector, const ect_module_choice_t *modules,
                                  size_t module_count, char *text, size_t room)
{
    const ect_esi_device_t *model = esi != NULL ? ect_esi_select(esi, selector, text, room) : NULL;
    ect_esi_twin_t *twin = model != NULL ? ect_esi_twin_of(esi, model, modules, module_count, text, room) : NULL;
    if (twin != NULL)
        twin->own = esi;
    else
        ect_esi_close(esi);
    return twin;
}

void ect_esi_twin_free(ect_esi_twin_t *twin)
{
    if (twin == NULL)
        return;
    ect_esi_rack_t *rack = twin->build.rack;
    for (size_t i = 1; rack != NULL && i < rack->set_count; i++)
        ect_esi_twin_drop(rack->sets[i].twin);
    ect_arena_free(&twin->racks);
    ect_esi_twin_drop(twin);
}
