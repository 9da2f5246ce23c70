/* SPDX-License-Identifier: MIT */
/* A binary heap with an index of each member's place. */
#include "bus/chain/deadlines.h"
#include "wire/assert.h"

#include <stdlib.h>

typedef struct place {
    uint64_t time_ns;
    uint32_t member;
} place_t;

struct ect_deadlines {
    size_t count;
    uint32_t *where; /* of each member: its place in the heap */
    place_t heap[];
};

ect_deadlines_t *ect_deadlines_new(size_t count)
{
    ECT_ASSERT(count >= 1 && count <= UINT32_MAX);
    ect_deadlines_t *d = calloc(1, sizeof *d + count * sizeof d->heap[0]);
    uint32_t *where = calloc(count, sizeof *where);
    if (!d || !where) {
        free(where);
        free(d);
        return NULL;
    }
    d->count = count;
    d->where = where;
    for (size_t i = 0; i < count; i++) {
        where[i] = (uint32_t)i;
        d->heap[i] = (place_t){.time_ns = UINT64_MAX, .member = (uint32_t)i};
    }
    return d;
}

void ect_deadlines_free(ect_deadlines_t *deadlines)
{
    if (deadlines)
        free(deadlines->where);
    free(deadlines);
}

static void put(ect_deadlines_t *d, size_t at, place_t place)
{
    ECT_ASSERT(at < d->count && place.member < d->count);
    d->heap[at] = place;
    d->where[place.member] = (uint32_t)at;
}

static void rise(ect_deadlines_t *d, size_t at, place_t place)
{
    while (at > 0 && d->heap[(at - 1) / 2].time_ns > place.time_ns) {
        put(d, at, d->heap[(at - 1) / 2]);
        at = (at - 1) / 2;
    }
    put(d, at, place);
}

static void sink(ect_deadlines_t *d, size_t at, place_t place)
{
    for (;;) {
        size_t child = 2 * at + 1;
        if (child + 1 < d->count && d->heap[child + 1].time_ns < d->heap[child].time_ns)
            child++;
        if (child >= d->count || d->heap[child].time_ns >= place.time_ns)
            break;
        put(d, at, d->heap[child]);
        at = child;
    }
    put(d, at, place);
}

void ect_deadlines_set(ect_deadlines_t *deadlines, size_t member, uint64_t time_ns)
{
    ECT_ASSERT(member < deadlines->count);
    size_t at = deadlines->where[member];
    ECT_ASSERT(deadlines->heap[at].member == member);
    uint64_t before = deadlines->heap[at].time_ns;
    const place_t place = {.time_ns = time_ns, .member = (uint32_t)member};
    if (time_ns < before)
        rise(deadlines, at, place);
    else if (time_ns > before)
        sink(deadlines, at, place);
}

uint64_t ect_deadlines_of(const ect_deadlines_t *deadlines, size_t member)
{
    ECT_ASSERT(member < deadlines->count);
    return deadlines->heap[deadlines->where[member]].time_ns;
}

uint64_t ect_deadlines_first(const ect_deadlines_t *deadlines, size_t *member)
{
    *member = deadlines->heap[0].member;
    return deadlines->heap[0].time_ns;
}
