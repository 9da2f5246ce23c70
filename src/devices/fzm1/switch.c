/* SPDX-License-Identifier: MIT */
/* Switching scene and scene group (Q179 §4-3), by command or manually, and preparing scenes in advance. */
#include "devices/fzm1/instance.h"

fzm1_why_t fzm1_switch_scene(fzm1_t *u, uint32_t number)
{
    if (number >= FZM1_SCENES)
        return FZM1_WHY_NO_SCENE;
    fzm1_scene_t next;
    fzm1_why_t why = fzm1_keep_scene(u, u->scene_number, &u->scene);
    if (why != FZM1_DONE)
        return why;
    if (!fzm1_scene(u, (uint8_t)number, &next))
        return FZM1_WHY_MEMORY_SILENT;
    u->scene_number = (uint8_t)number;
    u->scene = next;
    fzm1_clear(u);
    return FZM1_DONE;
}

/* Loads a group in its saved or prepared state, and begins with its scene 0. Unsaved changes of the previous group are
 * lost. */
fzm1_why_t fzm1_switch_group(fzm1_t *u, uint32_t number)
{
    if (number >= FZM1_GROUPS)
        return FZM1_WHY_NO_GROUP;
    fzm1_scene_t first;
    if (!fzm1_load_group(u, (uint8_t)number, 0, &first))
        return FZM1_WHY_MEMORY_SILENT;
    u->scene_group = (uint8_t)number;
    u->scene_number = 0;
    u->scene = first;
    fzm1_clear(u);
    return FZM1_DONE;
}

/* --- manual switching --------------------------------------------------------------------------------------------- */

static fzm1_why_t not_by_hand(const fzm1_t *u)
{
    if (u->switching || u->continuous || u->image_count > 0 || u->image_due_ns != ECT_NEVER)
        return FZM1_WHY_BUSY_BY_MASTER;
    return fzm1_saving(u) ? FZM1_WHY_SAVING : FZM1_DONE;
}

/* Makes the new scene current at once, so that later settings apply to it; BUSY stays on for the duration of switching.
 */
fzm1_why_t fzm1_switch_by_hand(fzm1_t *u, bool group, uint32_t number)
{
    fzm1_why_t why = not_by_hand(u);
    if (why == FZM1_DONE)
        why = group ? fzm1_switch_group(u, number) : fzm1_switch_scene(u, number);
    if (why == FZM1_DONE)
        u->switched_due_ns = u->time_ns + u->plant.switch_us * 1000ull;
    return why;
}

void fzm1_switch_due(fzm1_t *u)
{
    if (u->switched_due_ns <= u->time_ns)
        u->switched_due_ns = ECT_NEVER;
}

/* --- prepared scenes ---------------------------------------------------------------------------------------------- */

fzm1_why_t fzm1_edit_open(fzm1_t *u, uint8_t group, uint8_t scene)
{
    fzm1_scene_t content = u->scene;
    bool there = true;
    if (group != u->scene_group)
        there = fzm1_load_scene(u, group, scene, &content);
    else if (scene != u->scene_number)
        there = fzm1_scene(u, scene, &content);
    if (!there)
        return FZM1_WHY_MEMORY_SILENT;
    u->plant.edit = (fzm1_prepared_t){.group = group, .scene = scene, .content = content};
    return FZM1_DONE;
}

fzm1_why_t fzm1_edit_change(fzm1_t *u, const fzm1_scene_t *content)
{
    fzm1_prepared_t *edit = &u->plant.edit;
    if (fzm1_saving(u))
        return FZM1_WHY_SAVING;
    if (!fzm1_prepare(u, edit->group, edit->scene, content))
        return FZM1_WHY_PREPARED_FULL;
    edit->content = *content;
    if (edit->group != u->scene_group)
        return FZM1_DONE;
    if (edit->scene == u->scene_number)
        u->scene = *content;
    fzm1_group_add(&u->group, edit->scene, content);
    return FZM1_DONE;
}
