/* SPDX-License-Identifier: MIT */
#include "bus/control/watch.h"

#include <stdlib.h>
#include <string.h>

#include "bus/chain/lamps.h"
#include "wire/assert.h"

/* NOTES and TABLE are powers of 2; TABLE has twice the number of signals, which keeps searches short. */
enum { NOTES = 256 * 1024, TABLE = 2 * ECT_WATCH_MOST, VALUE_ROOM = ECT_SIGNAL_TEXT_ROOM };

/* The data of a comparison, close together in memory. */
typedef struct peek {
    const uint8_t *value;
    uint32_t reported; /* offset of the last reported value */
    uint16_t size;
    bool text; /* compare only up to the terminator */
} peek_t;

typedef struct watched {
    ect_signal_ref_t ref;
    size_t slave;
} watched_t;

/* Header of each recorded value. */
typedef struct note {
    uint64_t time_ns;
    uint64_t signal;
} note_t;

struct ect_watch {
    bool every, lost;
    size_t count;
    size_t round;          /* next signal of the round; `count`: the round has ended */
    size_t reported_used;  /* bytes of `reported` */
    size_t first, end;     /* positions in the notes, which only increase */
    uint16_t table[TABLE]; /* hash table by the address of the value, open addressing: signal + 1; 0: free */
    peek_t peeks[ECT_WATCH_MOST];
    watched_t watched[ECT_WATCH_MOST];
    size_t lamps[ECT_WATCH_MOST]; /* slaves with a watched lamp */
    size_t lamp_count;
    uint16_t choices[ECT_WATCH_MOST]; /* watched signals with a turn, sorted by turn */
    size_t choice_count;
    uint8_t reported[ECT_WATCH_MOST * VALUE_ROOM];
    uint8_t notes[NOTES];
};

ect_watch_t *ect_watch_new(void)
{
    return calloc(1, sizeof(ect_watch_t));
}

void ect_watch_free(ect_watch_t *watch)
{
    free(watch);
}

size_t ect_watch_count(const ect_watch_t *watch)
{
    return watch->count;
}

size_t ect_watch_lamps(const ect_watch_t *watch, const size_t **slaves)
{
    *slaves = watch->lamps;
    return watch->lamp_count;
}

void ect_watch_every(ect_watch_t *watch)
{
    watch->every = true;
}

bool ect_watch_is_every(const ect_watch_t *watch)
{
    return watch->every;
}

bool ect_watch_lost(const ect_watch_t *watch)
{
    return watch->lost;
}

/* @return the entry of a signal in the table, or a free entry */
static uint16_t *place_of(ect_watch_t *watch, const ect_signal_ref_t *ref)
{
    size_t at = (size_t)(((uint64_t)(uintptr_t)ref->value * UINT64_C(0x9E3779B97F4A7C15)) >> 40) % TABLE;
    while (watch->table[at] != 0) {
        const ect_signal_ref_t *other = &watch->watched[watch->table[at] - 1].ref;
        if (other->value == ref->value && other->signal == ref->signal)
            break;
        at = (at + 1) % TABLE;
    }
    return &watch->table[at];
}

static uint8_t turn_of(const ect_watch_t *watch, size_t i)
{
    return watch->watched[i].ref.signal->turn;
}

static void add_choice(ect_watch_t *watch, size_t signal)
{
    size_t at = watch->choice_count++;
    for (; at > 0 && turn_of(watch, watch->choices[at - 1]) > turn_of(watch, signal); at--)
        watch->choices[at] = watch->choices[at - 1];
    watch->choices[at] = (uint16_t)signal;
}

bool ect_watch_add(ect_watch_t *watch, const ect_signal_ref_t *ref, size_t slave)
{
    uint16_t *place = place_of(watch, ref);
    if (*place != 0)
        return true;
    if (watch->count == ECT_WATCH_MOST)
        return false;
    size_t size = ect_signal_size(ref->signal);
    peek_t *peek = &watch->peeks[watch->count];
    *peek = (peek_t){.value = ref->value,
                     .reported = (uint32_t)watch->reported_used,
                     .size = (uint16_t)(size < VALUE_ROOM ? size : VALUE_ROOM),
                     .text = ref->signal->type == ECT_SIGNAL_TEXT};
    memcpy(watch->reported + peek->reported, ref->value, peek->size);
    watch->reported_used += peek->size;
    watch->watched[watch->count] = (watched_t){.ref = *ref, .slave = slave};
    if (ref->signal->turn > 0)
        add_choice(watch, watch->count);
    if (watch->round == watch->count)
        watch->round++; /* prevents an addition from starting a round */
    watch->count++;
    ECT_ASSERT(watch->count <= ECT_WATCH_MOST && watch->reported_used <= sizeof watch->reported);
    *place = (uint16_t)watch->count;
    bool known = watch->lamp_count > 0 && watch->lamps[watch->lamp_count - 1] == slave;
    if (ref->plant == &ect_lamps_plant && !known)
        watch->lamps[watch->lamp_count++] = slave;
    return true;
}

static bool changed(const ect_watch_t *watch, const peek_t *peek)
{
    const uint8_t *reported = watch->reported + peek->reported;
    if (peek->text)
        return strncmp((const char *)peek->value, (const char *)reported, peek->size) != 0;
    switch (peek->size) {
    case 1:
        return *peek->value != *reported;
    case 2:
        return memcmp(peek->value, reported, 2) != 0;
    case 4:
        return memcmp(peek->value, reported, 4) != 0;
    default:
        return memcmp(peek->value, reported, peek->size) != 0;
    }
}

/* @return the signal to report before a changed one: the first changed choice of the slave, or the signal itself. A
 * replay of the list of changes therefore selects a scene before it sets values of the scene. */
static size_t first_change(const ect_watch_t *watch, size_t signal)
{
    for (size_t n = 0; n < watch->choice_count; n++) {
        size_t i = watch->choices[n];
        if (watch->watched[i].slave == watch->watched[signal].slave && changed(watch, &watch->peeks[i]))
            return i;
    }
    return signal;
}

static void push(ect_watch_t *watch, const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++)
        watch->notes[(watch->end + i) % NOTES] = ((const uint8_t *)data)[i];
    watch->end += size;
    ECT_ASSERT(watch->end - watch->first <= NOTES);
}

static void pop(ect_watch_t *watch, void *data, size_t size)
{
    ECT_ASSERT(watch->end - watch->first >= size);
    for (size_t i = 0; i < size; i++)
        ((uint8_t *)data)[i] = watch->notes[(watch->first + i) % NOTES];
    watch->first += size;
}

void ect_watch_record(ect_watch_t *watch, uint64_t now_ns)
{
    for (size_t at = 0; at < watch->count;) {
        if (!changed(watch, &watch->peeks[at])) {
            at++;
            continue;
        }
        size_t i = first_change(watch, at);
        const peek_t *peek = &watch->peeks[i];
        const note_t note = {.time_ns = now_ns, .signal = i};
        memcpy(watch->reported + peek->reported, peek->value, peek->size);
        if (watch->end - watch->first + sizeof note + peek->size > NOTES) {
            watch->lost = true;
            return;
        }
        push(watch, &note, sizeof note);
        push(watch, peek->value, peek->size);
    }
}

void ect_watch_round(ect_watch_t *watch)
{
    if (watch->round == watch->count)
        watch->round = 0;
}

bool ect_watch_pending(const ect_watch_t *watch)
{
    return watch->first != watch->end || (!watch->every && watch->round < watch->count);
}

void ect_watch_describe(ect_line_t *line, const ect_signal_ref_t *ref, size_t slave, const void *value)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    ect_signal_text(ref, value, text);
    ect_line_number(line, "slave", slave + 1);
    if (ref->twin)
        ect_line_string(line, "twin", ref->twin);
    ect_line_string(line, "name", ref->name);
    if (ect_signal_is_number(ref->signal))
        ect_line_plain(line, "value", strpbrk(text, "in") ? "null" : text); /* JSON has neither inf nor nan */
    else
        ect_line_string(line, "value", text);
}

static void write_change(const watched_t *watched, const void *value, uint64_t time_ns, ect_line_t *line)
{
    ect_line_begin(line);
    ect_watch_describe(line, &watched->ref, watched->slave, value);
    ect_line_time(line, time_ns);
    ect_line_end(line);
}

static bool next_note(ect_watch_t *watch, ect_line_t *line)
{
    note_t note;
    uint8_t value[VALUE_ROOM];
    if (watch->first == watch->end)
        return false;
    pop(watch, &note, sizeof note);
    ECT_ASSERT(note.signal < watch->count);
    pop(watch, value, watch->peeks[note.signal].size);
    write_change(&watch->watched[note.signal], value, note.time_ns, line);
    return true;
}

bool ect_watch_next(ect_watch_t *watch, unsigned int *budget, uint64_t now_ns, ect_line_t *line)
{
    if (watch->every)
        return next_note(watch, line);
    for (; watch->round < watch->count && *budget > 0; --*budget) {
        if (changed(watch, &watch->peeks[watch->round])) {
            size_t i = first_change(watch, watch->round);
            const peek_t *peek = &watch->peeks[i];
            watch->round += i == watch->round;
            memcpy(watch->reported + peek->reported, peek->value, peek->size);
            write_change(&watch->watched[i], peek->value, now_ns, line);
            return true;
        }
        watch->round++;
    }
    return false;
}
