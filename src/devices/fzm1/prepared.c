/* SPDX-License-Identifier: MIT */
/* Prepared scenes: each load of their group includes them, until the group is saved with them. */
#include "devices/fzm1/instance.h"

fzm1_prepared_t *fzm1_prepared_find(fzm1_t *u, uint8_t group, uint8_t scene)
{
    for (unsigned int i = 0; i < u->plant.prepared_count; i++) {
        if (u->plant.prepared[i].group == group && u->plant.prepared[i].scene == scene)
            return &u->plant.prepared[i];
    }
    return NULL;
}

bool fzm1_prepare(fzm1_t *u, uint8_t group, uint8_t scene, const fzm1_scene_t *content)
{
    fzm1_prepared_t *p = fzm1_prepared_find(u, group, scene);
    if (!p && u->plant.prepared_count == FZM1_PREPARED)
        return false;
    if (!p)
        p = &u->plant.prepared[u->plant.prepared_count++];
    *p = (fzm1_prepared_t){.group = group, .scene = scene, .content = *content};
    return true;
}

void fzm1_prepared_forget(fzm1_t *u, uint8_t group)
{
    uint16_t kept = 0;
    for (unsigned int i = 0; i < u->plant.prepared_count; i++) {
        if (u->plant.prepared[i].group != group)
            u->plant.prepared[kept++] = u->plant.prepared[i];
    }
    u->plant.prepared_count = kept;
}
