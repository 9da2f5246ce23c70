/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Delayed replies: each leaves at its own time, and none overtakes another, as on a slow wire.
 *
 * This file uses no sockets and no clock. Context: the thread of the runner. Cost: one allocation for each delayed
 * frame.
 */
#ifndef ECT_BUS_FAULTS_LATE_H
#define ECT_BUS_FAULTS_LATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** A delayed frame. Members are read-only for callers. */
typedef struct ect_late_frame {
    struct ect_late_frame *next;
    uint64_t due_ns; /**< time at which the frame is due */
    size_t length;
    uint8_t frame[];
} ect_late_frame_t;

/** The delayed frames of one end of the wire, in the order in which they leave; zeroed: none. */
typedef struct ect_late {
    ect_late_frame_t *first, *last;
    size_t count;
} ect_late_t;

/** Limit of waiting frames; further ones are lost. Sufficient for ten seconds of a 1 ms cycle with six frames. */
enum { ECT_LATE_MOST = 65536 };

/**
 * Keeps a copy of a frame until `due_ns`, or until the previous frame has left, whichever is later.
 * @return false: the frame is lost, because memory is exhausted or ECT_LATE_MOST frames wait
 */
bool ect_late_add(ect_late_t *late, const uint8_t *frame, size_t length, uint64_t due_ns);

/** @return the time at which the first frame is due; UINT64_MAX: no frame waits */
static inline uint64_t ect_late_due(const ect_late_t *late)
{
    return late->first ? late->first->due_ns : UINT64_MAX;
}

/** Removes the first frame if it is due. @return the frame, for the caller to free(); NULL: none is due */
ect_late_frame_t *ect_late_take(ect_late_t *late, uint64_t now_ns);

/** Frees all frames. */
void ect_late_clear(ect_late_t *late);

ECT_C_END

#endif
