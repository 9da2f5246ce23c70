/* SPDX-License-Identifier: MIT */
#include "bus/faults/wires.h"

#include <stdlib.h>
#include <string.h>

#include "esc/route.h"
#include "seams/random.h"
#include "wire/assert.h"
#include "wire/bytes.h"

void ect_frame_corrupt(uint32_t *seed, uint8_t *frame, size_t length)
{
    size_t first = ect_frame_datagrams(frame, length);
    size_t from = first != 0 ? first + ECT_DATAGRAM_DATA : 0;
    if (length == 0)
        return;
    uint32_t random = ect_random_next(seed);
    frame[from + random / 8 % (length - from)] ^= (uint8_t)(1u << random % 8);
}

void ect_frame_count(uint8_t *frame, size_t length, int32_t by)
{
    size_t first = by != 0 ? ect_frame_datagrams(frame, length) : 0;
    if (first == 0)
        return;
    uint8_t *counter = frame + first + ECT_DATAGRAM_DATA + ect_datagram_length(frame + first);
    ect_store_le16(counter, (uint16_t)(ect_load_le16(counter) + by));
}

/* --- kept frames -------------------------------------------------------------------------------------------------- */

/* @return whether a further frame can be kept */
static bool keep(ect_wires_t *w, const ect_crossing_t *c, uint64_t due_ns, uint64_t due_frame, bool slow)
{
    ect_kept_t **last = &w->kept;
    ect_kept_t *kept = w->kept_count < ECT_WIRES_KEPT ? malloc(sizeof *kept + c->length) : NULL;
    if (!kept)
        return false;
    while (*last)
        last = &(*last)->next;
    *kept = (ect_kept_t){
        .due_ns = due_ns, .due_frame = due_frame, .latest_ns = w->now_ns + ECT_WIRES_BEHIND_NS, .slow = slow, .at = *c};
    kept->at.frame = kept->frame;
    memcpy(kept->frame, c->frame, c->length);
    *last = kept;
    w->kept_count++;
    return true;
}

/* @return the time at which the wire is free of delayed frames; 0: now */
static uint64_t free_at(const ect_wires_t *w, const ect_crossing_t *c)
{
    uint64_t free_ns = 0;
    for (const ect_kept_t *k = w->kept; k; k = k->next) {
        if (k->slow && k->at.wire == c->wire && k->at.back == c->back && k->due_ns > free_ns)
            free_ns = k->due_ns;
    }
    return free_ns;
}

static bool is_due(const ect_wires_t *w, const ect_kept_t *kept, uint64_t now_ns)
{
    return now_ns >= kept->due_ns && (w->frames >= kept->due_frame || now_ns >= kept->latest_ns);
}

ect_kept_t *ect_wires_release(ect_wires_t *w, ect_chain_t *chain, uint64_t now_ns)
{
    ect_kept_t **link = &w->kept;
    while (*link && !is_due(w, *link, now_ns))
        link = &(*link)->next;
    ect_kept_t *kept = *link;
    if (!kept)
        return NULL;
    ECT_ASSERT(w->kept_count > 0);
    *link = kept->next;
    w->kept_count--;
    kept->end = ect_chain_resume(chain, &kept->at, now_ns);
    return kept;
}

uint64_t ect_wires_due(const ect_wires_t *w)
{
    uint64_t due_ns = ECT_NEVER;
    for (const ect_kept_t *k = w->kept; k; k = k->next) {
        uint64_t its_ns = w->frames >= k->due_frame ? k->due_ns : ect_later(k->due_ns, k->latest_ns);
        due_ns = its_ns < due_ns ? its_ns : due_ns;
    }
    return due_ns;
}

void ect_wires_clear(ect_wires_t *w)
{
    while (w->kept) {
        ect_kept_t *kept = w->kept;
        w->kept = kept->next;
        free(kept);
    }
    w->kept_count = 0;
}

/* --- a frame on its way ------------------------------------------------------------------------------------------- */

static void cut(ect_wires_t *w, ect_crossing_t *c, size_t bytes)
{
    bytes = bytes < c->length ? bytes : c->length;
    c->length -= bytes;
    w->cut += bytes;
}

/* Keeps the frame, if the limit permits. */
static bool delay_frame(ect_wires_t *w, const ect_crossing_t *c, uint64_t due_ns, uint64_t due_frame, bool slow)
{
    w->result = keep(w, c, due_ns, due_frame, slow) ? ECT_WIRES_KEEP : ECT_WIRES_LOST;
    return false;
}

/* @return whether the frame continues */
static bool apply_fault(ect_wires_t *w, const ect_fault_t *fault, ect_crossing_t *c, uint64_t free_ns)
{
    switch (fault->kind) {
    case ECT_FAULT_DROP:
        w->result = ECT_WIRES_LOST;
        return false;
    case ECT_FAULT_DAMAGE:
        c->damaged = true;
        return true;
    case ECT_FAULT_DELAY:
        return delay_frame(w, c, ect_later(free_ns, w->now_ns + 1000ull * (uint32_t)fault->amount), 0, true);
    case ECT_FAULT_REORDER:
        return delay_frame(w, c, free_ns, w->frames + 1, false);
    case ECT_FAULT_DUPLICATE:
        (void)keep(w, c, free_ns, 0, false);
        return true;
    case ECT_FAULT_TRUNCATE:
        cut(w, c, (size_t)fault->amount);
        return true;
    case ECT_FAULT_CORRUPT:
        ect_frame_corrupt(w->seed, c->frame, c->length);
        return true;
    default:
        ect_frame_count(c->frame, c->length, fault->amount);
        return true;
    }
}

/* Frames never overtake each other on a slow wire. */
static bool cross(void *ctx, ect_crossing_t *c)
{
    ect_wires_t *w = ctx;
    uint64_t free_ns = free_at(w, c);
    for (size_t i = 0; i < w->fault_count; i++) {
        const ect_fault_t *fault = &w->faults[i];
        if (fault->slave - 1u == c->wire && fault->back == c->back && !apply_fault(w, fault, c, free_ns))
            return false;
    }
    return free_ns == 0 || delay_frame(w, c, free_ns, 0, true);
}

void ect_wires_begin(ect_wires_t *w, uint32_t *seed, uint64_t now_ns)
{
    w->seed = seed;
    w->now_ns = now_ns;
    w->frames++;
    w->fault_count = 0;
    w->result = ECT_WIRES_PASSED;
    w->cut = 0;
}

void ect_wires_add(ect_wires_t *w, const ect_fault_t *fault)
{
    if (w->fault_count < ECT_WIRES_FAULTS)
        w->faults[w->fault_count++] = *fault;
}

void ect_wires_end(ect_wires_t *w, ect_chain_t *chain)
{
    if (w->fault_count > 0 || w->kept)
        ect_chain_guard(chain, cross, w);
}
