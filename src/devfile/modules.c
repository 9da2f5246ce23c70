/* SPDX-License-Identifier: MIT */
/* `modules`, and the `slots` that accept them (ETG.5001). */
#include "devfile/internal.h"

#include <inttypes.h>
#include <string.h>

#include "od/pdo.h"

/* PLACES: sub-indices of F030h. */
enum { MODULES = 256, SLOTS = 254, PLACES = 254, INDICES = 0x10000, MODULAR_DEVICE = 5001, INCREMENT = 0x10 };

static size_t length_of(const yaml_node_t *list)
{
    return (size_t)(list->data.sequence.items.top - list->data.sequence.items.start);
}

static const yaml_node_t *item(ect_draft_t *d, const yaml_node_t *list, size_t n)
{
    return ect_yaml_node(&d->yaml, list->data.sequence.items.start[n]);
}

static uint32_t number_of(ect_draft_t *d, const char *key, const yaml_node_t *node, int64_t least, int64_t most,
                          uint32_t otherwise)
{
    if (node == NULL || d->mistake.failed)
        return otherwise;
    const ect_word_t word = ect_draft_word(d, node, key);
    return d->mistake.failed ? otherwise : (uint32_t)ect_draft_number(d, key, word, least, most);
}

static const char *text_of(ect_draft_t *d, const char *key, const yaml_node_t *node, const char *otherwise)
{
    const char *text = node != NULL ? ect_yaml_scalar(&d->yaml, node, key) : otherwise;
    if (*text == '\0')
        ect_yaml_fail(&d->yaml, node, "'%s' is empty", key);
    return ect_arena_copy(d->arena, text, strlen(text));
}

/* --- modules ------------------------------------------------------------------------------------------------------ */

/* A module whose keys are being read. */
typedef struct module_keys {
    ect_draft_t *d;
    const yaml_node_t *name, *type, *profile, *objects, *inputs, *outputs;
} module_keys_t;

static void take_module_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    module_keys_t *k = ctx;
    const struct {
        const char *name;
        const yaml_node_t **node;
    } nodes[] = {{"name", &k->name},       {"type", &k->type},     {"profile", &k->profile},
                 {"objects", &k->objects}, {"inputs", &k->inputs}, {"outputs", &k->outputs}};
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0]; i++) {
        if (strcmp(nodes[i].name, key) == 0) {
            *nodes[i].node = value;
            return;
        }
    }
    ect_yaml_fail(&k->d->yaml, name, "'%.60s' is no key of a module: name, type, profile, objects, inputs, outputs",
                  key);
}

/* Reads objects and PDOs of a module as those of a device without others. */
static void read_parts(const module_keys_t *k)
{
    ect_draft_t *d = k->d;
    if (k->objects != NULL)
        ect_draft_objects(d, k->objects);
    if (!d->mistake.failed && k->outputs != NULL)
        ect_draft_pdos(d, k->outputs, false);
    if (!d->mistake.failed && k->inputs != NULL)
        ect_draft_pdos(d, k->inputs, true);
    if (!d->mistake.failed)
        ect_draft_end(d);
}

/* Moves the objects and PDOs that were read from the device to the module. */
static void take_over(ect_draft_t *d, ect_esi_module_t *module)
{
    ect_esi_device_t *device = d->device;
    ect_esi_object_t *objects = (ect_esi_object_t *)(uintptr_t)device->dictionary.objects; /* ours */
    for (size_t i = 0; i < device->dictionary.object_count; i++) {
        const ect_draft_object_t *from = ect_draft_find(d, objects[i].index);
        objects[i].moves = ECT_ESI_BY_SLOT;
        objects[i].line = from != NULL ? (int)from->line : module->line;
    }
    module->dictionary = device->dictionary;
    module->pdos = device->pdos;
    module->pdo_count = device->pdo_count;
}

static void read_module(const module_keys_t *k, ect_esi_module_t *module)
{
    ect_draft_t *d = k->d;
    ect_esi_device_t *device = d->device;
    const ect_draft_t own = *d;
    const ect_esi_device_t model = *device;
    d->objects = NULL;
    d->object_count = 0;
    d->positions = d->module_positions;
    d->moves = ECT_ESI_BY_SLOT;
    device->pdos = NULL;
    device->pdo_count = 0;
    device->dictionary = (ect_esi_dictionary_t){0};
    read_parts(k);
    if (!d->mistake.failed)
        take_over(d, module);
    for (size_t i = 0; i < d->object_count; i++)
        d->positions[d->objects[i].index] = 0;
    d->module_positions = d->positions;
    d->objects = own.objects;
    d->object_count = own.object_count;
    d->positions = own.positions;
    d->moves = 0;
    device->pdos = model.pdos;
    device->pdo_count = model.pdo_count;
    device->dictionary = model.dictionary;
}

static ect_esi_module_t *modules_of(const ect_draft_t *d)
{
    return (ect_esi_module_t *)(uintptr_t)d->device->modules; /* ours */
}

static const ect_esi_module_t *find(const ect_draft_t *d, uint32_t ident)
{
    for (size_t i = 0; i < d->device->module_count; i++) {
        if (d->device->modules[i].ident == ident)
            return &d->device->modules[i];
    }
    return NULL;
}

static void take_module(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    ect_draft_t *d = ctx;
    module_keys_t k = {.d = d};
    const ect_word_t word = {.text = key, .line = ect_yaml_line(name)};
    const uint32_t ident = (uint32_t)ect_draft_number(d, "modules", word, 1, UINT32_MAX);
    if (!d->mistake.failed && find(d, ident) != NULL)
        ect_yaml_fail(&d->yaml, name, "module 0x%08" PRIX32 " occurs twice, first in line %d: give one another ident",
                      ident, find(d, ident)->line);
    if (d->device->module_count == MODULES)
        ect_yaml_fail(&d->yaml, name, "more than %d modules", (int)MODULES);
    ect_yaml_each(&d->yaml, value, "a module", true, take_module_key, &k);
    if (!d->mistake.failed && k.name == NULL)
        ect_yaml_fail(&d->yaml, name, "module %.60s has no 'name'", key);
    if (d->mistake.failed)
        return;
    ect_esi_module_t *modules = ect_arena_grow(d->arena, modules_of(d), d->device->module_count, sizeof *modules);
    ect_esi_module_t *module = &modules[d->device->module_count];
    d->device->modules = modules;
    *module = (ect_esi_module_t){.ident = ident, .module_class = "", .line = (int)word.line};
    module->name = text_of(d, "name", k.name, "");
    module->type = text_of(d, "type", k.type, module->name);
    module->profile = number_of(d, "profile", k.profile, 0, UINT32_MAX, 0);
    if (!d->mistake.failed)
        read_module(&k, module);
    d->device->module_count++;
}

/* --- slots -------------------------------------------------------------------------------------------------------- */

/* A slot whose keys are being read. */
typedef struct slot_keys {
    ect_draft_t *d;
    const yaml_node_t *name, *modules, *count, *least, *preset;
} slot_keys_t;

static void take_slot_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    slot_keys_t *k = ctx;
    const struct {
        const char *name;
        const yaml_node_t **node;
    } nodes[] = {{"name", &k->name},
                 {"modules", &k->modules},
                 {"count", &k->count},
                 {"min", &k->least},
                 {"default", &k->preset}};
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0]; i++) {
        if (strcmp(nodes[i].name, key) == 0) {
            *nodes[i].node = value;
            return;
        }
    }
    ect_yaml_fail(&k->d->yaml, name, "'%.60s' is no key of a slot: name, modules, count, min, default", key);
}

/* @return the module that a node names; NULL: none, a mistake */
static const ect_esi_module_t *named(ect_draft_t *d, const char *key, const yaml_node_t *node)
{
    const uint32_t ident = number_of(d, key, node, 1, UINT32_MAX, 0);
    const ect_esi_module_t *module = find(d, ident);
    if (!d->mistake.failed && module == NULL)
        ect_yaml_fail(&d->yaml, node, "there is no module 0x%08" PRIX32 " among the 'modules': add it, or correct it",
                      ident);
    return module;
}

/* Sets the idents of the modules that a slot accepts: those of a list, else all. */
static void accept_modules(ect_draft_t *d, const yaml_node_t *list, ect_esi_slot_t *slot)
{
    const size_t most = list != NULL ? MODULES : d->device->module_count;
    if (list != NULL && (list->type != YAML_SEQUENCE_NODE || length_of(list) == 0 || length_of(list) > most)) {
        ect_yaml_fail(&d->yaml, list, "'modules' of a slot takes a list of idents, as [0x00000110, 0x00000120]");
        return;
    }
    const size_t count = list != NULL ? length_of(list) : most;
    uint32_t *idents = ect_arena_alloc(d->arena, (count + 1) * sizeof *idents);
    for (size_t i = 0; i < count && !d->mistake.failed; i++) {
        const ect_esi_module_t *module = list != NULL ? named(d, "modules", item(d, list, i)) : &d->device->modules[i];
        idents[i] = module != NULL ? module->ident : 0;
    }
    slot->idents = idents;
    slot->ident_count = count;
}

static bool accepts(const ect_esi_slot_t *slot, uint32_t ident)
{
    bool found = false;
    for (size_t i = 0; i < slot->ident_count; i++)
        found |= slot->idents[i] == ident;
    return found;
}

static void take_preset(const slot_keys_t *k, const yaml_node_t *node, ect_esi_slot_t *slot)
{
    ect_draft_t *d = k->d;
    const ect_esi_module_t *module = k->preset != NULL ? named(d, "default", k->preset) : NULL;
    if (module != NULL && !accepts(slot, module->ident))
        ect_yaml_fail(&d->yaml, k->preset,
                      "the slot does not accept its 'default' 0x%08" PRIX32 ": add it to 'modules'", module->ident);
    if (slot->instances_min > slot->instances_max)
        ect_yaml_fail(&d->yaml, k->least, "'min' %u is more than the 'count' %u of the slot", slot->instances_min,
                      slot->instances_max);
    if (slot->instances_min > 0 && k->preset == NULL)
        ect_yaml_fail(&d->yaml, node, "a slot with 'min' needs the module of these places: 'default: 0x00000110'");
    slot->preset = module != NULL ? module->ident : 0;
}

static void take_slot(ect_draft_t *d, const yaml_node_t *node, ect_esi_slot_t *slot, size_t number)
{
    slot_keys_t k = {.d = d};
    ect_yaml_each(&d->yaml, node, "a slot", true, take_slot_key, &k);
    if (d->mistake.failed)
        return;
    slot->name = text_of(d, "name", k.name, ect_arena_print(d->arena, "Slot %zu", number));
    slot->instances_max = number_of(d, "count", k.count, 1, PLACES, 1);
    slot->instances_min = number_of(d, "min", k.least, 0, PLACES, 0);
    slot->pdo_increment = d->device->slot_pdo_increment;
    slot->index_increment = d->device->slot_index_increment;
    if (!d->mistake.failed)
        accept_modules(d, k.modules, slot);
    if (!d->mistake.failed)
        take_preset(&k, node, slot);
}

static void take_slots(ect_draft_t *d, const yaml_node_t *list)
{
    if (list->type != YAML_SEQUENCE_NODE || length_of(list) == 0 || length_of(list) > SLOTS) {
        ect_yaml_fail(&d->yaml, list, "'slots' takes a list of 1 to %d, '- {name: IO, count: 4}' each", (int)SLOTS);
        return;
    }
    const size_t count = length_of(list);
    ect_esi_slot_t *slots = ect_arena_alloc(d->arena, count * sizeof *slots);
    for (size_t i = 0; i < count && !d->mistake.failed; i++) {
        take_slot(d, item(d, list, i), &slots[i], i + 1);
        d->device->slots_max += slots[i].instances_max;
    }
    d->device->slots = slots;
    d->device->slot_count = count;
    if (d->device->slots_max > PLACES)
        ect_yaml_fail(&d->yaml, list, "the slots have %u places: a device has at most %d", d->device->slots_max,
                      (int)PLACES);
}

/* --- indices ------------------------------------------------------------------------------------------------------ */

/* Objects and PDOs of a device with modules in all its places. */
typedef struct plan {
    ect_draft_t *d;
    uint16_t *owners; /* by index: number of the place that has it, from 1; 0: none */
} plan_t;

/* @return whether an index is that of a list that follows from the slots */
static bool is_list(uint16_t index)
{
    return index == 0xF000 || (index >= 0xF010 && index <= 0xF050 && index % 0x10 == 0);
}

static bool is_pdo(uint16_t index)
{
    return ect_od_is_rxpdo(index) || ect_od_is_txpdo(index);
}

/* @return whether the index of an object or PDO may differ between the first place and another one */
static bool may_have(uint16_t first, uint32_t index)
{
    if (index >= INDICES)
        return false;
    const uint16_t moved = (uint16_t)index;
    return is_pdo(first) ? is_pdo(moved) && ect_od_is_txpdo(first) == ect_od_is_txpdo(moved)
                         : ect_draft_reserved(moved) == NULL && !is_list(moved);
}

/* Reserves an index of a module in a place. @param first  index in the first place */
static void reserve(const plan_t *plan, unsigned int place, uint16_t first, uint32_t increment, int line)
{
    static const char cure[] = "choose another, or change 'slot-increments'";
    ect_draft_t *d = plan->d;
    const uint32_t index = first + place * increment;
    if (!may_have(first, index)) {
        ect_mistake(&d->mistake, (size_t)line, "%04X is %04" PRIX32 " in slot %u, which no module may have: %s",
                    (unsigned int)first, index, place + 1, cure);
        return;
    }
    bool taken = ect_draft_find(d, (uint16_t)index) != NULL;
    for (size_t i = 0; i < d->device->pdo_count; i++)
        taken |= d->device->pdos[i].index == index;
    const unsigned int owner = plan->owners[index];
    if (taken)
        ect_mistake(&d->mistake, (size_t)line, "%04X is %04" PRIX32 " in slot %u, as one of the device: %s",
                    (unsigned int)first, index, place + 1, cure);
    if (owner != 0 && owner != place + 1)
        ect_mistake(&d->mistake, (size_t)line, "%04X is %04" PRIX32 " in slot %u, as one of slot %u: %s",
                    (unsigned int)first, index, place + 1, owner, cure);
    plan->owners[index] = (uint16_t)(place + 1);
}

static void reserve_module(const plan_t *plan, unsigned int place, const ect_esi_slot_t *slot,
                           const ect_esi_module_t *module)
{
    for (size_t i = 0; i < module->dictionary.object_count && !plan->d->mistake.failed; i++)
        reserve(plan, place, module->dictionary.objects[i].index, slot->index_increment,
                module->dictionary.objects[i].line);
    for (size_t i = 0; i < module->pdo_count && !plan->d->mistake.failed; i++)
        reserve(plan, place, module->pdos[i].index, slot->pdo_increment, module->pdos[i].line);
}

/* Checks that each object and PDO of each module has a unique index in each place that accepts the module. */
static void check_indices(ect_draft_t *d)
{
    const plan_t plan = {.d = d, .owners = ect_arena_alloc(d->arena, INDICES * sizeof *plan.owners)};
    unsigned int place = 0;
    for (size_t i = 0; i < d->device->slot_count; i++) {
        const ect_esi_slot_t *slot = &d->device->slots[i];
        for (unsigned int n = 0; n < slot->instances_max; n++, place++) {
            for (size_t k = 0; k < slot->ident_count && !d->mistake.failed; k++)
                reserve_module(&plan, place, slot, find(d, slot->idents[k]));
        }
    }
}

/* Checks that each module has a slot. */
static void check_homes(ect_draft_t *d)
{
    for (size_t m = 0; m < d->device->module_count; m++) {
        bool accepted = false;
        for (size_t i = 0; i < d->device->slot_count && !accepted; i++)
            accepted = accepts(&d->device->slots[i], d->device->modules[m].ident);
        if (!accepted)
            ect_mistake(&d->mistake, (size_t)d->device->modules[m].line,
                        "no slot accepts module 0x%08" PRIX32 ": add it to the 'modules' of a slot",
                        d->device->modules[m].ident);
    }
}

/* Checks that the objects of the device contain no list of modules, because these follow from the slots. */
static void check_lists(ect_draft_t *d)
{
    for (size_t i = 0; i < d->object_count; i++) {
        if (is_list(d->objects[i].index))
            ect_mistake(&d->mistake, d->objects[i].line, "object %04X is left out here: the key 'slots' makes it",
                        (unsigned int)d->objects[i].index);
    }
}

static void take_increment(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    ect_draft_t *d = ctx;
    if (strcmp(key, "objects") == 0)
        d->device->slot_index_increment = number_of(d, key, value, 0, UINT16_MAX, 0);
    else if (strcmp(key, "pdos") == 0)
        d->device->slot_pdo_increment = number_of(d, key, value, 0, UINT16_MAX, 0);
    else
        ect_yaml_fail(&d->yaml, name, "'%.60s' is no key of 'slot-increments': objects, pdos", key);
}

/* @return the first node that is given; NULL: none */
static const yaml_node_t *first_of(const ect_draft_rack_t *rack)
{
    const yaml_node_t *nodes[] = {rack->slots, rack->modules, rack->increments, rack->download};
    const yaml_node_t *first = NULL;
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0] && first == NULL; i++)
        first = nodes[i];
    return first;
}

void ect_draft_rack(ect_draft_t *d, const ect_draft_rack_t *rack)
{
    ect_esi_device_t *device = d->device;
    if (first_of(rack) == NULL)
        return;
    if (rack->slots == NULL || rack->modules == NULL)
        ect_yaml_fail(&d->yaml, first_of(rack), "a device with modules takes both 'slots' and 'modules'");
    if (!device->mailbox.coe)
        ect_yaml_fail(&d->yaml, first_of(rack), "a device with slots needs a mailbox with coe: change 'mailbox'");
    if (d->mistake.failed)
        return;
    device->slot_index_increment = INCREMENT;
    device->slot_pdo_increment = 1;
    device->download_idents = true;
    if (device->profile == 0)
        device->profile = MODULAR_DEVICE;
    if (rack->increments != NULL)
        ect_yaml_each(&d->yaml, rack->increments, "slot-increments", true, take_increment, d);
    if (!d->mistake.failed && rack->download != NULL)
        device->download_idents =
            ect_draft_flag(d, "download-idents", ect_draft_word(d, rack->download, "download-idents"));
    if (!d->mistake.failed)
        ect_yaml_each(&d->yaml, rack->modules, "modules", false, take_module, d);
    if (!d->mistake.failed)
        take_slots(d, rack->slots);
    check_lists(d);
    if (!d->mistake.failed)
        check_homes(d);
    if (!d->mistake.failed)
        check_indices(d);
}
