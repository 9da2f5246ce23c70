/* SPDX-License-Identifier: MIT */
#include "bus/faults/late.h"
#include "wire/assert.h"

#include <stdlib.h>
#include <string.h>

bool ect_late_add(ect_late_t *late, const uint8_t *frame, size_t length, uint64_t due_ns)
{
    ect_late_frame_t *added = late->count < ECT_LATE_MOST ? malloc(sizeof *added + length) : NULL;
    if (!added)
        return false;
    ECT_ASSERT((late->first == NULL) == (late->count == 0));
    added->next = NULL;
    added->due_ns = late->first && late->last->due_ns > due_ns ? late->last->due_ns : due_ns;
    added->length = length;
    memcpy(added->frame, frame, length);
    if (late->first)
        late->last->next = added;
    else
        late->first = added;
    late->last = added;
    late->count++;
    return true;
}

ect_late_frame_t *ect_late_take(ect_late_t *late, uint64_t now_ns)
{
    ect_late_frame_t *taken = late->first;
    if (!taken || taken->due_ns > now_ns)
        return NULL;
    ECT_ASSERT(late->count > 0);
    late->first = taken->next;
    late->count--;
    return taken;
}

void ect_late_clear(ect_late_t *late)
{
    for (ect_late_frame_t *frame = ect_late_take(late, UINT64_MAX); frame; frame = ect_late_take(late, UINT64_MAX))
        free(frame);
}
