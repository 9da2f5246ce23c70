/* SPDX-License-Identifier: MIT */
/* Switching scene and scene group (Q179 §4-3). */
#include "devices/fzm1/instance.h"

const char *fzm1_switch_scene(fzm1_t *u, uint32_t number)
{
    if (number >= FZM1_SCENES)
        return "there is no such scene";
    u->scenes[u->scene_number] = u->scene;
    u->scene_number = (uint8_t)number;
    u->scene = u->scenes[number];
    fzm1_clear(u);
    return NULL;
}

/* As it was saved; what was changed in the old group and not saved is forgotten. The new one begins with scene 0. */
const char *fzm1_switch_group(fzm1_t *u, uint32_t number)
{
    if (number >= FZM1_GROUPS)
        return "there is no such scene group";
    if (!fzm1_load_group(u, (uint8_t)number))
        return "the memory does not answer";
    u->scene_group = (uint8_t)number;
    u->scene_number = 0;
    u->scene = u->scenes[0];
    fzm1_clear(u);
    return NULL;
}
