/* SPDX-License-Identifier: MIT */
/*
 * "Save to unit" (Q179 §3-2, §4-3): system data, then each scene that differs from the factory's. A save writes the
 * current group and copies the others from the previous record.
 *
 * A save consists of steps, some scenes in each poll, and then waits for the medium; no other work waits for the save.
 * Scenes of a group are in the order of their numbers, so that a save processes each once.
 */
#include <string.h>

#include "devices/fzm1/instance.h"

#define MAGIC   0x314D5A46u /* "FZM1" */
#define STEP_NS 100000u     /* between two steps */
#define ASK_NS  1000000u    /* between two queries of the medium */

enum {
    LAYOUT = 2,                 /* version: records of another version are not read */
    SYSTEM = 1 + 3 + 4 * 2 + 2, /* layout, flags, numbers, scene and group */
    ENTRY = 4,                  /* of a scene: its group, its number, its packed length */
    FIXED = 8 * FZM1_DATA + 4,  /* packed: data, judgements, flow and format; then texts, each after its length */
    TEXTS = 2 * FZM1_DATA,      /* comments, expressions */
    SCENE = FIXED + TEXTS * (1 + FZM1_TEXT), /* at most */
    SCENES_A_STEP = 8,
};

enum { IDLE, OWN, OTHERS, DATA, HEADER }; /* part under way: written, or (DATA, HEADER) made safe */

/* --- packing ------------------------------------------------------------------------------------------------------ */

static void pack_system(const fzm1_t *u, uint8_t *b)
{
    const fzm1_settings_t *s = &u->settings;
    b[0] = LAYOUT;
    b[1] = s->fieldbus;
    b[2] = s->output_control;
    b[3] = s->output_repeat;
    ect_store_le16(b + 4, s->output_period);
    ect_store_le16(b + 6, s->output_time);
    ect_store_le16(b + 8, s->timeout);
    ect_store_le16(b + 10, s->exe_timeout);
    b[12] = u->scene_group;
    b[13] = u->scene_number;
}

/* Accepts only values that a user could have set, because a record may be of any origin. */
static bool valid_settings(const fzm1_settings_t *s)
{
    return s->fieldbus <= 1 && s->output_control <= 1 && s->output_repeat <= 1 && s->output_period >= 20 &&
           s->output_period <= 50000 && s->output_time >= 10 && s->output_time < s->output_period && s->timeout >= 5 &&
           s->timeout <= 1200 && s->exe_timeout <= 1200;
}

static bool unpack_system(fzm1_t *u, const uint8_t *b)
{
    fzm1_settings_t s = {.fieldbus = b[1],
                         .output_control = b[2],
                         .output_repeat = b[3],
                         .output_period = ect_load_le16(b + 4),
                         .output_time = ect_load_le16(b + 6),
                         .timeout = ect_load_le16(b + 8),
                         .exe_timeout = ect_load_le16(b + 10)};
    if (!valid_settings(&s) || b[12] >= FZM1_GROUPS || b[13] >= FZM1_SCENES)
        return false;
    u->settings = s;
    u->scene_group = b[12];
    u->scene_number = b[13];
    return true;
}

static const char *text_of(const fzm1_scene_t *scene, unsigned int n)
{
    return n < FZM1_DATA ? scene->comment[n] : scene->expression[n - FZM1_DATA];
}

/* @return length of the packed scene */
static uint16_t pack_scene(const fzm1_scene_t *scene, uint8_t *b)
{
    uint8_t ng = 0;
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        uint64_t bits;
        memcpy(&bits, &scene->data[n], sizeof bits);
        ect_store_le64(b + 8 * n, bits);
    }
    for (unsigned int n = 0; n < FZM1_UNITS; n++)
        ng |= (uint8_t)((scene->judgement[n] < 0) << n);
    b[FIXED - 4] = ng;
    b[FIXED - 3] = scene->units;
    b[FIXED - 2] = scene->output_unit;
    b[FIXED - 1] = scene->format;
    uint16_t at = FIXED;
    for (unsigned int n = 0; n < TEXTS; n++) {
        const char *text = text_of(scene, n);
        uint8_t length = (uint8_t)strlen(text);
        b[at] = length;
        memcpy(b + at + 1, text, length);
        at = (uint16_t)(at + 1 + length);
    }
    return at;
}

static bool unpack_texts(fzm1_scene_t *scene, const uint8_t *b, uint16_t size)
{
    uint16_t at = 0;
    for (unsigned int n = 0; n < TEXTS; n++) {
        char *text = n < FZM1_DATA ? scene->comment[n] : scene->expression[n - FZM1_DATA];
        uint8_t length = at < size ? b[at] : UINT8_MAX;
        if (length > FZM1_TEXT || length > size - at - 1)
            return false;
        memset(text, 0, FZM1_TEXT + 1);
        memcpy(text, b + at + 1, length);
        at = (uint16_t)(at + 1 + length);
    }
    return at == size;
}

static bool unpack_scene(fzm1_scene_t *scene, const uint8_t *b, uint16_t size)
{
    if (size < FIXED)
        return false;
    for (unsigned int n = 0; n < FZM1_DATA; n++) {
        uint64_t bits = ect_load_le64(b + 8 * n);
        memcpy(&scene->data[n], &bits, sizeof bits);
    }
    for (unsigned int n = 0; n < FZM1_UNITS; n++)
        scene->judgement[n] = (b[FIXED - 4] >> n & 1) != 0 ? -1 : 1;
    scene->units = b[FIXED - 3];
    scene->output_unit = b[FIXED - 2];
    scene->format = b[FIXED - 1];
    return unpack_texts(scene, b + FIXED, (uint16_t)(size - FIXED)) && fzm1_scene_fault(scene) == FZM1_DONE;
}

/* --- the record --------------------------------------------------------------------------------------------------- */

/* Finds the newest record that this firmware can read. @return 1 found · 0 none · -1 no memory, or it does not respond
 */
static int8_t find_record(fzm1_t *u)
{
    uint8_t layout;
    if (!u->host->storage)
        return -1;
    int found = ect_record_find(u->host->storage, MAGIC, &u->record);
    if (found <= 0)
        return (int8_t)found;
    if (!ect_record_get(&u->record, 0, &layout, 1))
        return -1;
    return layout == LAYOUT && u->record.length >= SYSTEM;
}

static bool locate_record(fzm1_t *u)
{
    if (u->record_found < 0)
        u->record_found = find_record(u);
    return u->record_found >= 0;
}

/* A scene in the record. */
typedef struct entry {
    uint32_t at; /* of the packed form */
    uint16_t size;
    uint8_t group, scene;
} entry_t;

/* Reads the entry at `from`. @return 1 found · 0 the end of the record · -1 the memory does not respond */
static int read_entry(const ect_record_t *r, uint32_t from, entry_t *e)
{
    uint8_t header[ENTRY];
    if (from + ENTRY > r->length)
        return 0;
    if (!ect_record_get(r, from, header, ENTRY))
        return -1;
    *e = (entry_t){from + ENTRY, ect_load_le16(header + 2), header[0], header[1]};
    return e->size <= SCENE && e->at + e->size <= r->length;
}

/* --- reading ------------------------------------------------------------------------------------------------------ */

/* Reads a scene; an invalid one gets the factory state. @return whether the memory responds */
static bool read_scene(const ect_record_t *r, const entry_t *e, fzm1_scene_t *scene)
{
    uint8_t packed[SCENE];
    if (!ect_record_get(r, e->at, packed, e->size))
        return false;
    if (!unpack_scene(scene, packed, e->size))
        fzm1_default_scene(scene);
    return true;
}

/* Finds the next scene of a group at or after `from`. @return 1 found · 0 none · -1 the memory does not respond */
static int next_of_group(const fzm1_t *u, uint8_t group, uint32_t from, entry_t *e)
{
    int there = u->record_found;
    while (there > 0) {
        there = read_entry(&u->record, from, e);
        if (there > 0 && e->group == group)
            break;
        from = e->at + e->size;
    }
    return there;
}

static bool read_group(const fzm1_t *u, uint8_t group, fzm1_group_t *to)
{
    entry_t e;
    fzm1_scene_t scene;
    int there = next_of_group(u, group, SYSTEM, &e);
    for (; there > 0; there = next_of_group(u, group, e.at + e.size, &e)) {
        if (!read_scene(&u->record, &e, &scene))
            return false;
        fzm1_group_add(to, e.scene, &scene);
    }
    return there == 0;
}

bool fzm1_load_scene(fzm1_t *u, uint8_t group, uint8_t number, fzm1_scene_t *scene)
{
    entry_t e;
    const fzm1_prepared_t *prepared = fzm1_prepared_find(u, group, number);
    fzm1_default_scene(scene);
    if (prepared)
        *scene = prepared->content;
    if (prepared || !u->host->storage)
        return true;
    if (!locate_record(u))
        return false;
    int there = next_of_group(u, group, SYSTEM, &e);
    while (there > 0 && e.scene != number)
        there = next_of_group(u, group, e.at + e.size, &e);
    return there == 0 || (there > 0 && read_scene(&u->record, &e, scene));
}

static void add_prepared(const fzm1_t *u, uint8_t group, fzm1_group_t *to)
{
    for (unsigned int i = 0; i < u->plant.prepared_count; i++) {
        if (u->plant.prepared[i].group == group)
            fzm1_group_add(to, u->plant.prepared[i].scene, &u->plant.prepared[i].content);
    }
}

/* Reads a scene of a group, from memory or from the record. */
static bool scene_of(fzm1_t *u, const fzm1_group_t *in, uint8_t group, uint8_t number, fzm1_scene_t *scene)
{
    const fzm1_scene_t *found = fzm1_group_find(in, number);
    if (!found && in->partial)
        return fzm1_load_scene(u, group, number, scene);
    fzm1_default_scene(scene);
    if (found)
        *scene = *found;
    return true;
}

bool fzm1_scene(fzm1_t *u, uint8_t number, fzm1_scene_t *scene)
{
    return scene_of(u, &u->group, u->scene_group, number, scene);
}

fzm1_why_t fzm1_keep_scene(fzm1_t *u, uint8_t number, const fzm1_scene_t *content)
{
    fzm1_scene_t before;
    if (!fzm1_scene(u, number, &before))
        return FZM1_WHY_MEMORY_SILENT;
    if (!fzm1_group_change(&u->group, number, &before, content))
        return FZM1_WHY_CHANGED_FULL;
    return FZM1_DONE;
}

bool fzm1_load_group(fzm1_t *u, uint8_t group, uint8_t number, fzm1_scene_t *scene)
{
    fzm1_group_t *to = &u->loading;
    to->count = 0;
    to->partial = false;
    if (u->host->storage && !(locate_record(u) && read_group(u, group, to)))
        return false;
    add_prepared(u, group, to);
    if (!scene_of(u, to, group, number, scene))
        return false;
    u->group = *to;
    return true;
}

void fzm1_load(fzm1_t *u)
{
    uint8_t system[SYSTEM];
    u->record_found = find_record(u);
    if (u->record_found > 0 && ect_record_get(&u->record, 0, system, SYSTEM))
        (void)unpack_system(u, system);
    if (fzm1_load_group(u, u->scene_group, u->scene_number, &u->scene))
        return;
    add_prepared(u, u->scene_group, &u->group);
    if (!fzm1_scene(u, u->scene_number, &u->scene))
        fzm1_default_scene(&u->scene);
}

/* --- writing ------------------------------------------------------------------------------------------------------ */

static bool put_scene(ect_record_t *to, uint8_t group, uint8_t number, const uint8_t *packed, uint16_t size)
{
    uint8_t header[ENTRY] = {group, number};
    ect_store_le16(header + 2, size);
    return ect_record_put(to, header, ENTRY) && ect_record_put(to, packed, size);
}

/* Finds a scene of the current group in the previous record; called with each number in order. @return 1 found · 0 not
 * saved · -1 the memory does not respond, or the record is damaged */
static int next_saved(fzm1_t *u, uint8_t number, entry_t *e)
{
    fzm1_saving_t *s = &u->saving;
    int there = next_of_group(u, u->scene_group, s->own, e);
    if (there == 0)
        s->own = u->record.length;
    if (there <= 0)
        return there;
    s->own = e->scene > number ? e->at - ENTRY : e->at + e->size;
    return e->scene > number ? 0 : e->scene == number ? 1 : -1;
}

/* Copies the current scene, which may be changed before the save ends. */
static const fzm1_scene_t *keep_written(fzm1_t *u)
{
    u->loading.places[0].content = u->scene;
    return &u->loading.places[0].content;
}

/* Reads a scene in the state to be saved. @return whether the memory responds */
static bool own_scene(fzm1_t *u, uint8_t number, fzm1_scene_t *scene)
{
    entry_t e;
    int saved = next_saved(u, number, &e);
    const fzm1_scene_t *content = fzm1_group_find(&u->group, number);
    const fzm1_prepared_t *prepared = fzm1_prepared_find(u, u->scene_group, number);
    fzm1_default_scene(scene);
    if (number == u->scene_number)
        content = keep_written(u);
    else if (!content && prepared)
        content = &prepared->content;
    if (content)
        *scene = *content;
    else if (saved > 0)
        return read_scene(&u->record, &e, scene);
    return saved >= 0;
}

/* Writes scenes of the current group. @return whether the memory has room and responds */
static bool put_own(fzm1_t *u)
{
    fzm1_saving_t *s = &u->saving;
    fzm1_scene_t scene;
    uint8_t packed[SCENE], factory[SCENE];
    fzm1_default_scene(&scene);
    uint16_t factory_size = pack_scene(&scene, factory);
    for (unsigned int n = 0; n < SCENES_A_STEP && s->scene < FZM1_SCENES; n++, s->scene++) {
        if (!own_scene(u, (uint8_t)s->scene, &scene))
            return false;
        uint16_t size = pack_scene(&scene, packed);
        bool as_factory = size == factory_size && memcmp(packed, factory, size) == 0;
        if (!as_factory && !put_scene(&s->to, u->scene_group, (uint8_t)s->scene, packed, size))
            return false;
    }
    if (s->scene == FZM1_SCENES)
        s->phase = u->record_found > 0 ? OTHERS : DATA;
    return true;
}

/* Copies scenes of the other groups. @return whether the memory has room and responds */
static bool put_others(fzm1_t *u)
{
    fzm1_saving_t *s = &u->saving;
    uint8_t packed[SCENE];
    entry_t e;
    int there = 1;
    for (unsigned int n = 0; n < SCENES_A_STEP && there > 0; n++) {
        there = read_entry(&u->record, s->from, &e);
        if (there <= 0)
            break;
        s->from = e.at + e.size;
        if (e.group != u->scene_group &&
            (!ect_record_get(&u->record, e.at, packed, e.size) || !put_scene(&s->to, e.group, e.scene, packed, e.size)))
            return false;
    }
    if (there == 0)
        s->phase = DATA;
    return there >= 0;
}

static void end(fzm1_t *u, fzm1_why_t failure)
{
    u->saving.phase = IDLE;
    u->saving.due_ns = ECT_NEVER;
    u->saving.failure = failure;
    if (failure != FZM1_DONE)
        fzm1_refuse(&u->save_failed, failure);
    else
        u->saves++;
}

/* Completes a save: groups are loaded from the new record from now on. */
static void sealed(fzm1_t *u)
{
    u->record = u->saving.to;
    u->record_found = 1;
    fzm1_prepared_forget(u, u->scene_group);
    fzm1_group_saved(&u->group);
    fzm1_group_add(&u->group, u->scene_number, &u->loading.places[0].content);
    end(u, FZM1_DONE);
}

static void flush(fzm1_t *u)
{
    fzm1_saving_t *s = &u->saving;
    int result = ect_record_flush(&s->to, false);
    if (result == ECT_STORAGE_BUSY)
        s->due_ns = u->poll_ns + ASK_NS;
    else if (result < 0)
        end(u, FZM1_WHY_MEMORY_FORGETS);
    else if (s->phase == HEADER)
        sealed(u);
    else if (ect_record_seal(&s->to, MAGIC))
        s->phase = HEADER;
    else
        end(u, FZM1_WHY_MEMORY_SILENT);
}

void fzm1_save_due(fzm1_t *u)
{
    fzm1_saving_t *s = &u->saving;
    if (s->due_ns > u->time_ns)
        return;
    s->due_ns = u->poll_ns + STEP_NS; /* one step in each poll, however late the poll is */
    if (s->phase == DATA || s->phase == HEADER)
        flush(u);
    else if (!(s->phase == OWN ? put_own(u) : put_others(u)))
        end(u, FZM1_WHY_MEMORY_FULL);
}

bool fzm1_saving(const fzm1_t *u)
{
    return u->saving.phase != IDLE;
}

fzm1_why_t fzm1_save(fzm1_t *u)
{
    fzm1_saving_t *s = &u->saving;
    uint8_t system[SYSTEM];
    pack_system(u, system);
    *s = (fzm1_saving_t){.phase = OWN, .own = SYSTEM, .from = SYSTEM, .due_ns = u->time_ns};
    if (locate_record(u) && ect_record_begin(&s->to, &u->record) && ect_record_put(&s->to, system, SYSTEM))
        return FZM1_DONE;
    end(u, u->host->storage ? FZM1_WHY_MEMORY_SILENT : FZM1_WHY_NO_MEMORY);
    return s->failure;
}

void fzm1_save_reset(fzm1_t *u)
{
    u->saving = (fzm1_saving_t){.phase = IDLE, .due_ns = ECT_NEVER};
}
