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
    LAYOUT = 1, /* of what follows: another one is not read */
    COMMENTS = FZM1_DATA * FZM1_COMMENT,
    SYSTEM = 2 + 3 + 4 * 2 + 2 + COMMENTS,  /* layout, scenes in a group, flags, numbers, scene and group, comments */
    SCENE = 8 * FZM1_DATA + FZM1_UNITS + 3, /* data, judgements, flow and format */
    GROUP = 1 + FZM1_SCENES * SCENE,        /* its number, its scenes */
};

static void pack_system(const fzm1_t *u, uint8_t *b)
{
    const fzm1_settings_t *s = &u->settings;
    b[0] = LAYOUT;
    b[1] = (uint8_t)FZM1_SCENES;
    b[2] = s->fieldbus;
    b[3] = s->output_control;
    b[4] = s->output_repeat;
    ect_store_le16(b + 5, s->output_period);
    ect_store_le16(b + 7, s->output_time);
    ect_store_le16(b + 9, s->timeout);
    ect_store_le16(b + 11, s->exe_timeout);
    b[13] = u->scene_group;
    b[14] = u->scene_number;
    for (unsigned int n = 0; n < FZM1_DATA; n++)
        memcpy(b + 15 + n * FZM1_COMMENT, s->comment[n], FZM1_COMMENT);
}

/* Only what a user could have set: a record may come from anywhere. */
static bool valid_settings(const fzm1_settings_t *s)
{
    return s->fieldbus <= 1 && s->output_control <= 1 && s->output_repeat <= 1 && s->output_period >= 20 &&
           s->output_period <= 50000 && s->output_time >= 10 && s->output_time < s->output_period && s->timeout >= 5 &&
           s->timeout <= 1200 && s->exe_timeout <= 1200;
}

static bool unpack_system(fzm1_t *u, const uint8_t *b)
{
    fzm1_settings_t s = {.fieldbus = b[2],
                         .output_control = b[3],
                         .output_repeat = b[4],
                         .output_period = ect_load_le16(b + 5),
                         .output_time = ect_load_le16(b + 7),
                         .timeout = ect_load_le16(b + 9),
                         .exe_timeout = ect_load_le16(b + 11)};
    for (unsigned int n = 0; n < FZM1_DATA; n++)
        memcpy(s.comment[n], b + 15 + n * FZM1_COMMENT, FZM1_COMMENT);
    if (!valid_settings(&s) || b[13] >= FZM1_GROUPS || b[14] >= FZM1_SCENES)
        return false;
    u->settings = s;
    u->scene_group = b[13];
    u->scene_number = b[14];
    return true;
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

static bool unpack_scene(fzm1_scene_t *scene, const uint8_t *b)
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
    return scene->units <= FZM1_UNITS && scene->output_unit < scene->units && scene->format <= FZM1_FLOATING;
}

/* The newest record, if this firmware can read it. 1 found, 0 none, -1 the memory does not answer. */
static int find_record(const fzm1_t *u, ect_record_t *r)
{
    uint8_t kind[2];
    if (!u->host->storage)
        return -1;
    int found = ect_record_find(u->host->storage, MAGIC, r);
    if (found <= 0)
        return found;
    if (!ect_record_get(r, 0, kind, sizeof kind))
        return -1;
    return kind[0] == LAYOUT && kind[1] == (uint8_t)FZM1_SCENES && r->length >= SYSTEM &&
           (r->length - SYSTEM) % GROUP == 0;
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
    ect_record_t from, to;
    uint8_t system[SYSTEM];
    int found = find_record(u, &from);
    if (found < 0)
        return false;
    uint32_t own = found > 0 ? find_group(&from, u->scene_group) : 0;
    u->scenes[u->scene_number] = u->scene;
    pack_system(u, system);
    return ect_record_begin(&to, &from) && ect_record_put(&to, system, SYSTEM) &&
           (found == 0 || copy_others(&from, own, &to)) && put_group(u, &to) && ect_record_commit(&to, MAGIC);
}

/* --- reading ------------------------------------------------------------------------------------------------------ */

/* A group that was never saved, or makes no sense, is as from the factory. @return false: the memory does not answer */
static bool read_group(fzm1_t *u, const ect_record_t *r, uint8_t group)
{
    uint8_t scene[SCENE];
    uint32_t at = find_group(r, group);
    fzm1_default_scenes(u->loading);
    if (at == r->length)
        return true;
    for (unsigned int i = 0; i < FZM1_SCENES; i++) {
        if (!ect_record_get(r, at + 1 + i * SCENE, scene, SCENE))
            return false;
        if (!unpack_scene(&u->loading[i], scene)) {
            fzm1_default_scenes(u->loading);
            return true;
        }
    }
    return true;
}

bool fzm1_load_group(fzm1_t *u, uint8_t group)
{
    ect_record_t r;
    int found = u->host->storage ? find_record(u, &r) : 0;
    if (found < 0 || (found > 0 && !read_group(u, &r, group)))
        return false;
    if (found == 0)
        fzm1_default_scenes(u->loading);
    memcpy(u->scenes, u->loading, sizeof u->scenes);
    return true;
}

void fzm1_load(fzm1_t *u)
{
    ect_record_t r;
    uint8_t system[SYSTEM];
    fzm1_default_scenes(u->scenes);
    if (find_record(u, &r) <= 0 || !ect_record_get(&r, 0, system, SYSTEM) || !unpack_system(u, system))
        return;
    if (read_group(u, &r, u->scene_group))
        memcpy(u->scenes, u->loading, sizeof u->scenes);
}
