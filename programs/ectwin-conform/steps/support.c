/* SPDX-License-Identifier: MIT */
/* Common parts of all steps: random numbers, waiting, histograms, the list of changes. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "steps/engine.h"

enum { POLL_NS = 200000 };

/* xorshift64* */
uint32_t cf_random(cf_t *c, uint32_t limit)
{
    c->random ^= c->random >> 12;
    c->random ^= c->random << 25;
    c->random ^= c->random >> 27;
    return (uint32_t)((c->random * UINT64_C(2685821657736338717)) >> 32) % limit;
}

void cf_while_waiting(cf_t *c, void (*idle)(cf_t *c, void *ctx), void *ctx)
{
    c->engine->idle = idle;
    c->engine->idle_ctx = ctx;
}

/* `in_idle` prevents recursion: the function may itself call waiting steps. */
void cf_poll_pause(cf_t *c)
{
    cf_engine_t *e = c->engine;
    const struct timespec pause = {.tv_nsec = POLL_NS};
    if (!e->idle || e->in_idle) {
        (void)nanosleep(&pause, NULL);
        return;
    }
    e->in_idle = true;
    e->idle(c, e->idle_ctx);
    e->in_idle = false;
}

void cf_measure(cf_t *c, const char *series, uint64_t ns)
{
    cf_engine_t *e = c->engine;
    size_t n = 0;
    while (n < e->series_count && strcmp(e->series[n].name, series) != 0)
        n++;
    if (n == CF_SERIES_MOST)
        cf_fail(c, "more than %d histograms", (int)CF_SERIES_MOST);
    cf_series_t *s = &e->series[n];
    if (n == e->series_count) {
        *s = (cf_series_t){.name = series, .values_ns = calloc(CF_VALUES_MOST, sizeof s->values_ns[0])};
        if (!s->values_ns)
            cf_fail(c, "out of memory");
        e->series_count++;
    }
    if (s->count < CF_VALUES_MOST)
        s->values_ns[s->count++] = ns;
}

cf_undo_t *cf_new_undo(cf_t *c)
{
    cf_engine_t *e = c->engine;
    if (e->undo_count == CF_UNDO_MOST)
        cf_fail(c, "this case changes more than %d values", (int)CF_UNDO_MOST);
    return &e->undo[e->undo_count++];
}

void cf_keep(cf_t *c, void (*put_back)(cf_t *c, const uint8_t *data, size_t size), const void *data, size_t size)
{
    cf_expect_that(c, size <= CF_CHANGE_MOST, "a value to restore: expected at most %d bytes, got %zu",
                   (int)CF_CHANGE_MOST, size);
    cf_undo_t *u = cf_new_undo(c);
    *u = (cf_undo_t){.what = CF_UNDO_CALL, .size = size, .put_back = put_back};
    memcpy(u->data, data, size);
}

void cf_forget_changes(cf_engine_t *e)
{
    for (size_t i = 0; i < CF_UNDO_MOST; i++) {
        free(e->undo[i].file);
        e->undo[i].file = NULL;
    }
    e->undo_count = 0;
}

uint8_t *cf_room(cf_t *c, unsigned int n)
{
    uint8_t **room = &c->engine->room[n];
    if (!*room)
        *room = malloc(CF_FILE_MOST);
    if (!*room)
        cf_fail(c, "out of memory");
    return *room;
}

void cf_engine_free(cf_engine_t *e)
{
    cf_forget_changes(e);
    for (size_t i = 0; i < e->series_count; i++)
        free(e->series[i].values_ns);
    e->series_count = 0;
    for (size_t i = 0; i < sizeof e->room / sizeof e->room[0]; i++) {
        free(e->room[i]);
        e->room[i] = NULL;
    }
}
