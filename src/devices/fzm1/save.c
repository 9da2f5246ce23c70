/* SPDX-License-Identifier: MIT */
/*
 * "Save to unit" (Q179 §3-2, §4-3): system data, then each scene group that was ever saved. A save writes the current
 * group anew and takes the others over from the record before.
 */
#include <string.h>

#include "devices/fzm1/instance.h"
#include "seams/record.h"

#define MAGIC 0x314D5A46u /* "FZM1" */

enum {
    COMMENTS = FZM1_DATA * FZM1_COMMENT,
    SYSTEM = 3 + 4 * 2 + 2 + COMMENTS,      /* flags, numbers, scene and group, comments */
    SCENE = 8 * FZM1_DATA + FZM1_UNITS + 3, /* data, judgements, flow and format */
    GROUP = 1 + FZM1_SCENES * SCENE,        /* its number, its scenes */
};

static void pack_system(const fzm1_t *u, uint8_t *b)
{
    const fzm1_settings_t *s = &u->settings;
    b[0] = s->fieldbus;
    b[1] = s->output_control;
    b[2] = s->output_repeat;
    ect_store_le16(b + 3, s->output_period);
    ect_store_le16(b + 5, s->output_time);
    ect_store_le16(b + 7, s->timeout);
    ect_store_le16(b + 9, s->exe_timeout);
    b[11] = u->scene_group;
    b[12] = u->scene_number;
    for (unsigned int n = 0; n < FZM1_DATA; n++)
        memcpy(b + 13 + n * FZM1_COMMENT, s->comment[n], FZM1_COMMENT);
}

static void unpack_system(fzm1_t *u, const uint8_t *b)
{
    fzm1_settings_t *s = &u->settings;
    s->fieldbus = b[0];
    s->output_control = b[1];
    s->output_repeat = b[2];
    s->output_period = ect_load_le16(b + 3);
    s->output_time = ect_load_le16(b + 5);
    s->timeout = ect_load_le16(b + 7);
    s->exe_timeout = ect_load_le16(b + 9);
    u->scene_group = b[11];
    u->scene_number = b[12];
    for (unsigned int n = 0; n < FZM1_DATA; n++)
        memcpy(s->comment[n], b + 13 + n * FZM1_COMMENT, FZM1_COMMENT);
}

static void pack_scene(const fzm1_scene_t *scene, uint8_t *b)
{
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        uint64_t bits;
        memcpy(&bits, &scene->data[n], sizeof bits);
        ect_store_le64(b + 8 * n, bits);
    }
    b += 8 * FZM1_DATA;
    for (unsigned int n = 0; n < FZM1_UNITS; n++)
        b[n] = scene->judgement[n] < 0;
    b[FZM1_UNITS] = scene->units;
    b[FZM1_UNITS + 1] = scene->output_unit;
    b[FZM1_UNITS + 2] = scene->format;
}

static void unpack_scene(fzm1_scene_t *scene, const uint8_t *b)
{
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        uint64_t bits = ect_load_le64(b + 8 * n);
        memcpy(&scene->data[n], &bits, sizeof bits);
    }
    b += 8 * FZM1_DATA;
    for (unsigned int n = 0; n < FZM1_UNITS; n++)
        scene->judgement[n] = b[n] ? -1 : 1;
    scene->units = b[FZM1_UNITS];
    scene->output_unit = b[FZM1_UNITS + 1];
    scene->format = b[FZM1_UNITS + 2];
}

/* --- writing ------------------------------------------------------------------------------------------------------ */

static bool put_group(const fzm1_t *u, ect_record_t *to)
{
    uint8_t scene[SCENE];
    bool done = ect_record_put(to, &u->scene_group, 1);
    for (unsigned int i = 0; i < FZM1_SCENES && done; i++) {
        pack_scene(&u->scenes[i], scene);
        done = ect_record_put(to, scene, SCENE);
    }
    return done;
}

static bool copy_group(const ect_record_t *from, uint32_t at, ect_record_t *to)
{
    uint8_t piece[SCENE];
    bool done = true;
    for (uint32_t end = at + GROUP; at < end && done;) {
        uint32_t size = end - at < SCENE ? end - at : SCENE;
        done = ect_record_get(from, at, piece, size) && ect_record_put(to, piece, size);
        at += size;
    }
    return done;
}

/* Where a group begins in a record; the end of the record: it is not there. */
static uint32_t find_group(const ect_record_t *r, uint8_t group)
{
    uint32_t at = SYSTEM;
    for (; at + GROUP <= r->length; at += GROUP) {
        uint8_t number;
        if (ect_record_get(r, at, &number, 1) && number == group)
            return at;
    }
    return r->length;
}

static bool copy_others(const ect_record_t *from, uint32_t own, ect_record_t *to)
{
    bool done = true;
    for (uint32_t at = SYSTEM; at + GROUP <= from->length && done; at += GROUP)
        done = at == own || copy_group(from, at, to);
    return done;
}

bool fzm1_save(fzm1_t *u)
{
    const ect_storage_t *medium = u->host->storage;
    ect_record_t from = {.length = SYSTEM}, to;
    uint8_t system[SYSTEM];
    if (!medium)
        return false;
    (void)ect_record_find(medium, MAGIC, &from);
    uint32_t own = find_group(&from, u->scene_group);
    u->scenes[u->scene_number] = u->scene;
    pack_system(u, system);
    uint32_t length = from.length + (own == from.length ? (uint32_t)GROUP : 0);
    return ect_record_begin(&to, medium, MAGIC, length) && ect_record_put(&to, system, SYSTEM) &&
           copy_others(&from, own, &to) && put_group(u, &to) && ect_record_commit(&to, MAGIC);
}

/* --- reading ------------------------------------------------------------------------------------------------------ */

static bool load_group(fzm1_t *u, const ect_record_t *r, uint8_t group)
{
    uint8_t scene[SCENE];
    uint32_t at = find_group(r, group);
    if (at == r->length)
        return false;
    for (unsigned int i = 0; i < FZM1_SCENES; i++) {
        if (!ect_record_get(r, at + 1 + i * SCENE, scene, SCENE))
            return false;
        unpack_scene(&u->scenes[i], scene);
    }
    return true;
}

bool fzm1_load_group(fzm1_t *u, uint8_t group)
{
    ect_record_t r;
    return u->host->storage && ect_record_find(u->host->storage, MAGIC, &r) && load_group(u, &r, group);
}

void fzm1_load(fzm1_t *u)
{
    ect_record_t r;
    uint8_t system[SYSTEM];
    if (!u->host->storage || !ect_record_find(u->host->storage, MAGIC, &r) || !ect_record_get(&r, 0, system, SYSTEM))
        return;
    unpack_system(u, system);
    (void)load_group(u, &r, u->scene_group);
}
