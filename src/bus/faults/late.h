/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Answers that are late on purpose: each waits for its own time, and none overtakes another, as on a slow wire.
 *
 * No sockets and no clock in here. Context: the thread of the runner. A frame costs one allocation; nothing is
 * allocated while no answer is late.
 */
#ifndef ECT_BUS_FAULTS_LATE_H
#define ECT_BUS_FAULTS_LATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** A frame that waits. Members are read only for others. */
typedef struct ect_late_frame {
    struct ect_late_frame *next;
    uint64_t due_ns; /**< when it may leave */
    size_t length;
    uint8_t frame[];
} ect_late_frame_t;

/** Those that wait for one end of the wire, the first due first. All zero: none. */
typedef struct ect_late {
    ect_late_frame_t *first, *last;
    size_t count;
} ect_late_t;

/** More than so many are lost: ten seconds of a 1 ms cycle with six frames. */
enum { ECT_LATE_MOST = 65536 };

/**
 * Lets a copy of a frame wait until `due_ns`, or until the one before it has left, whichever is later.
 * @return false: there is no memory for it, or ECT_LATE_MOST wait already; it is lost
 */
bool ect_late_add(ect_late_t *late, const uint8_t *frame, size_t length, uint64_t due_ns);

/** @return when the first one is due; UINT64_MAX: none waits */
static inline uint64_t ect_late_due(const ect_late_t *late)
{
    return late->first ? late->first->due_ns : UINT64_MAX;
}

/** Takes the first one if it is due. @return the frame, the caller's to free(), or NULL */
ect_late_frame_t *ect_late_take(ect_late_t *late, uint64_t now_ns);

/** Forgets all of them. */
void ect_late_clear(ect_late_t *late);

ECT_C_END

#endif
