/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The newest frames of a bus in memory, in the form of a pcapng file, for clients that download them.
 *
 * Memory comes from the heap at the first start and is kept. Context: the thread of the runner. Cost of a frame: a copy
 * while a capture runs.
 */
#ifndef ECT_BUS_CAPTURE_RECENT_H
#define ECT_BUS_CAPTURE_RECENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/pcapng.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Bytes of frames that are kept; room for the blocks before them. */
enum { ECT_RECENT_BYTES = 4 * 1024 * 1024, ECT_RECENT_HEAD = 1024 };

/** Zeroed: no capture. */
typedef struct ect_recent {
    bool on;
    uint32_t serial;     /**< counts the captures */
    uint64_t offset_ns;  /* added to each time */
    uint64_t first, end; /* bytes added before the oldest block that is kept, and before the next one */
    uint8_t *bytes;      /* a ring; NULL: none yet */
    size_t head_length;
    uint8_t head[ECT_RECENT_HEAD];
} ect_recent_t;

/**
 * Begins a capture; the previous one is dropped.
 * @param names      of the interfaces at both ends; NULL: none
 * @param offset_ns  added to each time: nanoseconds since 1970 at time 0
 * @return false: no memory; nothing has changed
 */
bool ect_recent_start(ect_recent_t *recent, const char *const names[2], uint64_t offset_ns);

/** Ends the capture; its frames are kept. */
void ect_recent_stop(ect_recent_t *recent);

/** Adds a frame. If the ring is full, the oldest frames are dropped. @param end  0 or 1 */
void ect_recent_add(ect_recent_t *recent, uint32_t end, ect_pcapng_direction_t direction, uint64_t time_ns,
                    const uint8_t *frame, size_t length);

/** @return bytes of the file; 0: none. */
size_t ect_recent_size(const ect_recent_t *recent);

/** Copies bytes of the file. @param offset  with `length` at most ::ect_recent_size */
void ect_recent_read(const ect_recent_t *recent, size_t offset, uint8_t *to, size_t length);

/** Frees the memory. */
void ect_recent_free(ect_recent_t *recent);

ECT_C_END

#endif
