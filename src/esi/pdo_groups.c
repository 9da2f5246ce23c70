/* SPDX-License-Identifier: MIT */
/* Groups of PDOs of a modular device (`ModulePdoGroup`): the PDOs of a group are adjacent, and a PDO without data fills
 * the following bytes up to the alignment. */
#include <string.h>

#include "esi/internal.h"

enum { BYTE_BITS = 8 };

static bool has_data(const ect_esi_pdo_t *pdo)
{
    for (size_t i = 0; i < pdo->entry_count; i++) {
        if (pdo->entries[i].index != 0)
            return true;
    }
    return false;
}

/* Removes the PDO of the file with the index of a padding PDO: its length follows from the modules.
 * @return false: that PDO has data, and stays */
static bool remove_padding(ect_build_t *build, uint16_t index, bool tx)
{
    size_t kept = 0;
    bool free_of_data = true;
    for (size_t i = 0; i < build->pdo_count; i++) {
        const ect_build_pdo_t *pdo = &build->pdos[i];
        const bool same = pdo->index == index && pdo->model->tx == tx;
        free_of_data &= !same || !has_data(pdo->model);
        if (!same || has_data(pdo->model))
            build->pdos[kept++] = *pdo;
    }
    build->pdo_count = kept;
    return free_of_data;
}

/* Sorts the PDOs by group; those of a group keep their order. PDOs without a group come first. */
static void sort(ect_build_t *build)
{
    for (size_t i = 1; i < build->pdo_count; i++) {
        const ect_build_pdo_t pdo = build->pdos[i];
        size_t at = i;
        for (; at > 0 && build->pdos[at - 1].group > pdo.group; at--)
            build->pdos[at] = build->pdos[at - 1];
        build->pdos[at] = pdo;
    }
}

static uint32_t bits_of(const ect_esi_pdo_t *pdo)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < pdo->entry_count; i++)
        bits += pdo->entries[i].bits;
    return bits;
}

static bool is_assigned(const ect_build_pdo_t *pdo, bool tx)
{
    return pdo->model->tx == tx && pdo->model->sm >= 0 && !pdo->model->virtual_pdo;
}

static void insert(ect_build_t *build, size_t at, const ect_build_pdo_t *pdo)
{
    build->pdos = ect_arena_grow(build->arena, build->pdos, build->pdo_count, sizeof *build->pdos);
    memmove(&build->pdos[at + 1], &build->pdos[at], (build->pdo_count - at) * sizeof *build->pdos);
    build->pdos[at] = *pdo;
    build->pdo_count++;
}

/* Adds the padding PDO after the PDOs of a group, which ends with PDO `last`. */
static void add_padding(ect_build_t *build, size_t last, uint16_t index, bool tx, uint32_t bits)
{
    ect_esi_entry_t *entry = ect_arena_alloc(build->arena, sizeof *entry);
    ect_esi_pdo_t *pdo = ect_arena_alloc(build->arena, sizeof *pdo);
    *entry = (ect_esi_entry_t){.bits = (uint16_t)bits, .name = "", .type = ""};
    *pdo = (ect_esi_pdo_t){.index = index,
                           .name = "Padding",
                           .tx = tx,
                           .fixed = true,
                           .sm = build->pdos[last].model->sm,
                           .samples = 1,
                           .entries = entry,
                           .entry_count = 1};
    insert(
        build, last + 1,
        &(ect_build_pdo_t){.model = pdo, .index = index, .steps = &ect_build_device, .group = build->pdos[last].group});
}

/* Pads the PDOs of a direction of a group. */
static void pad(ect_build_t *build, uint32_t group, uint32_t bytes, uint16_t index, bool tx)
{
    uint32_t bits = 0;
    size_t last = build->pdo_count;
    for (size_t i = 0; i < build->pdo_count && build->pdos[i].group <= group; i++) {
        if (!is_assigned(&build->pdos[i], tx))
            continue;
        bits += bits_of(build->pdos[i].model);
        last = build->pdos[i].group == group ? i : last;
    }
    const uint32_t beyond = bits % (bytes * BYTE_BITS);
    if (last < build->pdo_count && beyond != 0)
        add_padding(build, last, index, tx, bytes * BYTE_BITS - beyond);
}

void ect_build_pdo_groups(ect_build_t *build)
{
    const ect_esi_device_t *model = build->model;
    if (model->pdo_group_count > 0)
        sort(build);
    for (size_t i = 0; i < model->pdo_group_count; i++) {
        const ect_esi_pdo_group_t *group = &model->pdo_groups[i];
        const uint16_t indices[] = {group->rx, group->tx};
        for (unsigned int tx = 0; tx < 2; tx++) {
            if (indices[tx] == 0 || group->alignment == 0)
                continue;
            if (remove_padding(build, indices[tx], tx == 1))
                pad(build, (uint32_t)i + 1, group->alignment, indices[tx], tx == 1);
            else
                ect_build_note(build, "PDO %04X has data: it does not fill the group of PDOs %zu",
                               (unsigned int)indices[tx], i);
        }
    }
}
