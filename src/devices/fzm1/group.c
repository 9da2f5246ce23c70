/* SPDX-License-Identifier: MIT */
/* Scenes of a group in memory: all, or some on a board with little memory. */
#include <stddef.h>
#include <string.h>

#include "devices/fzm1/instance.h"

/* @return the place of a scene; `count`: none */
static unsigned int find(const fzm1_group_t *group, uint8_t number)
{
    unsigned int i = 0;
    while (i < group->count && group->places[i].number != number)
        i++;
    return i;
}

const fzm1_scene_t *fzm1_group_find(const fzm1_group_t *group, uint8_t number)
{
    unsigned int i = find(group, number);
    return i < group->count ? &group->places[i].content : NULL;
}

/* Copies member by member, because a compound literal would need stack for an entire place. */
static void fill(fzm1_place_t *place, uint8_t number, bool changed, const fzm1_scene_t *content)
{
    place->number = number;
    place->changed = changed;
    place->content = *content;
}

void fzm1_group_add(fzm1_group_t *group, uint8_t number, const fzm1_scene_t *content)
{
    unsigned int i = find(group, number);
    if (i == group->count && i < FZM1_KEPT)
        group->count++;
    if (i < group->count)
        fill(&group->places[i], number, false, content);
    else
        group->partial = true;
}

/* @return a place that is free, or whose scene can be read from the record again */
static fzm1_place_t *make_room(fzm1_group_t *group)
{
    if (group->count < FZM1_KEPT)
        return &group->places[group->count++];
    for (unsigned int i = 0; i < group->count; i++) {
        if (!group->places[i].changed) {
            group->partial = true;
            return &group->places[i];
        }
    }
    return NULL;
}

static bool same(const fzm1_scene_t *a, const fzm1_scene_t *b)
{
    return memcmp(a, b, offsetof(fzm1_scene_t, expression) + sizeof a->expression) == 0; /* the rest is padding */
}

bool fzm1_group_change(fzm1_group_t *group, uint8_t number, const fzm1_scene_t *before, const fzm1_scene_t *content)
{
    unsigned int i = find(group, number);
    if (same(before, content))
        return true;
    fzm1_place_t *place = i < group->count ? &group->places[i] : make_room(group);
    if (place)
        fill(place, number, true, content);
    return place != NULL;
}

void fzm1_group_saved(fzm1_group_t *group)
{
    for (unsigned int i = 0; i < group->count; i++)
        group->places[i].changed = false;
}
