/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A growing capture file. The caller adds frames to a buffer, at the cost of a copy; a thread, or ::ect_capture_flush,
 * writes the buffer to the file. If the buffer is full, the frame is dropped and counted, so a slow disk never delays a
 * reply.
 *
 * With a limit, the file keeps the newest frames: at the limit the older half is removed, in place. After
 * ::ect_capture_start only read, write, pread, pwrite, ftruncate, futex and clock_nanosleep are called, so a sandbox
 * may forbid other system calls.
 *
 * Context: one thread for all functions; the writing thread is internal.
 */
#ifndef ECT_BUS_CAPTURE_CAPTURE_H
#define ECT_BUS_CAPTURE_CAPTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/pcapng.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Number of interfaces of a capture, room for a message, and the smallest limit of a file in bytes. */
enum { ECT_CAPTURE_ENDS = 2, ECT_CAPTURE_MESSAGE = 512, ECT_CAPTURE_SMALLEST = 65536 };

typedef struct ect_capture ect_capture_t;

typedef struct ect_capture_config {
    const char *path;
    uint64_t most;                       /**< bytes of this section, at least ECT_CAPTURE_SMALLEST; 0: no limit */
    size_t buffer;                       /**< bytes in memory, a power of two, at least 4 * ECT_PCAPNG_ROOM */
    bool append;                         /**< appends a section to the file; false: truncates the file first */
    uint64_t offset_ns;                  /**< added to each time */
    const char *application;             /**< program and version */
    const char *names[ECT_CAPTURE_ENDS]; /**< of the interfaces; NULL: none */
} ect_capture_config_t;

/**
 * Opens or creates the file, and writes the headers. No other capture can open the file meanwhile.
 * @param config  only read during the call
 * @param[out] message  on failure one line for the user; ECT_CAPTURE_MESSAGE bytes
 * @return the capture, to be closed with ::ect_capture_close; NULL (errno; EWOULDBLOCK: in use by another capture)
 */
ect_capture_t *ect_capture_open(const ect_capture_config_t *config, char *message);

/** Starts the writing thread; then ::ect_capture_flush only wakes the thread. @return false: no thread; flushing writes
 */
bool ect_capture_start(ect_capture_t *capture);

/**
 * Adds a frame, with the comments added since the last frame.
 * @param interface  below ECT_CAPTURE_ENDS
 * @param length     on the wire; at most ECT_PCAPNG_FRAME_MOST bytes are read and kept
 * @return false: the frame was dropped
 */
bool ect_capture_frame(ect_capture_t *capture, uint32_t interface, ect_pcapng_direction_t direction, uint64_t time_ns,
                       const uint8_t *frame, size_t length);

/** Adds a line to the comment of the next frame; a comment that is too long is truncated. */
void ect_capture_comment(ect_capture_t *capture, const char *text);

/** Adds local data (::ect_pcapng_local), in order with the frames. @return false: the buffer is full, nothing is added
 **/
bool ect_capture_local(ect_capture_t *capture, const void *data, size_t length);

/** Writes the buffer to the file, or wakes the writing thread. */
void ect_capture_flush(ect_capture_t *capture);

/**
 * Writes the rest of the buffer and closes the file.
 * @param last     local data for the end of the file, `length` bytes; length 0: none
 * @param time_ns  of the end
 * @return 0; or errno of the first failed write, which was also the last one. NULL: no effect
 */
int ect_capture_close(ect_capture_t *capture, const void *last, size_t length, uint64_t time_ns);

ECT_C_END

#endif
