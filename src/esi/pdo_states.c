/* SPDX-License-Identifier: MIT */
/*
 * Parameters of PDOs, 14xxh of 16xxh and 18xxh of 1Axxh (MDP-030 to MDP-034): the PDOs that a PDO excludes (sub-index
 * 6), and the TxPDO toggle (sub-index 9), a bit in the inputs that changes with each new set of inputs.
 */
#include <stddef.h>
#include <string.h>

#include "esi/internal.h"
#include "wire/bytes.h"

enum { TX_PARAMETERS = 0x1800, BELOW_MAPPING = 0x200, EXCLUDED = 6, TOGGLE = 9 };

static bool is_toggle(uint16_t index, const ect_build_entry_t *entry)
{
    return index >= TX_PARAMETERS && index < TX_PARAMETERS + BELOW_MAPPING && entry->subindex == TOGGLE &&
           (entry->access & ECT_ACCESS_TXPDO) != 0;
}

/* --- excluded PDOs ------------------------------------------------------------------------------------------------ */

static ect_build_entry_t *list_of(const ect_build_t *build, const ect_build_pdo_t *pdo)
{
    const ect_build_object_t *object = ect_build_find(build, (uint16_t)(pdo->index - BELOW_MAPPING));
    ect_build_entry_t *entry = object != NULL ? ect_build_entry(object, EXCLUDED) : NULL;
    return entry != NULL && entry->bits >= 16 ? entry : NULL;
}

static const ect_build_pdo_t *pdo_of(const ect_build_t *build, uint16_t index)
{
    for (size_t i = 0; i < build->pdo_count; i++) {
        if (build->pdos[i].index == index && build->pdos[i].usable)
            return &build->pdos[i];
    }
    return NULL;
}

/* Appends a PDO that exists to a list that ends with 0. */
static void append(const ect_build_t *build, const ect_build_pdo_t *pdo, uint16_t *list, uint16_t other)
{
    if (other == pdo->index || pdo_of(build, other) == NULL)
        return;
    while (*list != 0 && *list != other)
        list++;
    *list = other;
}

/* Reads the list of the dictionary, without PDOs that the file assigns together. */
static void append_listed(const ect_build_t *build, const ect_build_pdo_t *pdo, const ect_build_entry_t *listed,
                          uint16_t *list)
{
    for (size_t i = 0; i + 1 < listed->initial.length; i += 2) {
        const uint16_t index = ect_load_le16(listed->initial.bytes + i);
        const ect_build_pdo_t *other = pdo_of(build, index);
        if (other != NULL && !(pdo->assigned && other->assigned))
            append(build, pdo, list, index);
    }
}

const uint16_t *ect_build_excludes(const ect_build_t *build, const ect_build_pdo_t *pdo)
{
    const ect_esi_pdo_t *model = pdo->model;
    const ect_build_entry_t *listed = list_of(build, pdo);
    const size_t most = model->exclude_count + (listed != NULL ? listed->initial.length / 2 : 0);
    uint16_t *list = ect_arena_alloc(build->arena, (most + 1) * sizeof *list);
    for (size_t i = 0; i < model->exclude_count; i++)
        append(build, pdo, list, ect_build_pdo_index(model->exclude[i].index, model->exclude[i].moves, pdo->steps));
    if (listed != NULL)
        append_listed(build, pdo, listed, list);
    return *list != 0 ? list : NULL;
}

void ect_build_pdo_states(ect_build_t *build)
{
    for (size_t i = 0; i < build->pdo_count; i++) {
        const ect_build_pdo_t *pdo = &build->pdos[i];
        ect_build_entry_t *listed = pdo->usable ? list_of(build, pdo) : NULL;
        const uint16_t *excluded =
            listed != NULL && listed->initial.length == 0 ? ect_build_excludes(build, pdo) : NULL;
        if (excluded == NULL)
            continue;
        const size_t room = listed->bits / 8u;
        uint8_t *bytes = ect_arena_alloc(build->arena, room);
        for (size_t k = 0; excluded[k] != 0 && 2 * k + 1 < room; k++)
            ect_store_le16(bytes + 2 * k, excluded[k]);
        listed->initial = (ect_esi_bytes_t){.bytes = bytes, .length = room};
    }
}

/* --- toggles ------------------------------------------------------------------------------------------------------ */

const ect_signal_t ect_build_toggle_signals[] = {ECT_SIGNAL(
    ect_esi_instance_t, hold, "hold", BOOL, WRITE, 0, 1, NULL,
    "1: TxPDO toggles (18xxh:09) keep their value, as of a device that does not renew its inputs; 0: they change")};

static void inputs_read(void *instance, uint64_t now_ns)
{
    (void)now_ns;
    ((ect_esi_instance_t *)instance)->read = 1;
}

/* Changes the toggles only if the master has read the previous set of inputs: two changes without a read would be
 * invisible. */
static void inputs(void *instance, uint64_t now_ns)
{
    ect_esi_instance_t *own = instance;
    const ect_build_t *build = &((const ect_esi_twin_t *)own->standard.device->context)->build;
    (void)now_ns;
    if (own->hold != 0 || own->read == 0)
        return;
    own->read = 0;
    for (size_t i = 0; i < build->toggle_count; i++)
        ((uint8_t *)instance)[build->toggles[i]] ^= 1;
}

bool ect_build_is_toggle(const ect_build_t *build, const ect_build_entry_t *entry)
{
    for (size_t i = 0; i < build->toggle_count; i++) {
        if (build->toggles[i] == entry->offset)
            return true;
    }
    return false;
}

void ect_build_toggles(ect_build_t *build, ect_device_t *device)
{
    for (size_t i = 0; i < build->object_count; i++) {
        for (size_t k = 0; k < build->objects[i].count; k++) {
            const ect_build_entry_t *entry = &build->objects[i].entries[k];
            if (!is_toggle(build->objects[i].index, entry))
                continue;
            build->toggles = ect_arena_grow(build->arena, build->toggles, build->toggle_count, sizeof(size_t));
            build->toggles[build->toggle_count++] = entry->offset;
        }
    }
    if (build->toggle_count == 0)
        return;
    device->inputs = inputs;
    device->inputs_read = inputs_read;
}
