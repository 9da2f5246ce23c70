/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The log of a run: each frame in both directions, and, as comments of the next frame, each fault, plugged or pulled
 * cable, state change, request of a client that changes the chain, and save.
 *
 * Context: the thread of the exchange. No call waits for the disk if the capture has a thread. Cost of a frame: a copy;
 * of a run of the devices: one comparison for each twin.
 */
#ifndef ECT_BUS_TRACE_H
#define ECT_BUS_TRACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/capture.h"
#include "bus/capture/logged.h"
#include "bus/chain/chain.h"
#include "bus/faults/scenario.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_trace ect_trace_t;

/**
 * Makes a trace of a chain.
 * @param capture  for readers; owned by the trace from now on (::ect_trace_close); NULL: none
 * @param record   for replay, likewise: frames, comments, and all other data that a replay needs
 * @param count    number of twins
 * @return NULL: not enough memory; the caller keeps the captures
 */
ect_trace_t *ect_trace_new(ect_capture_t *capture, ect_capture_t *record, size_t count);

/** Adds an item other than a frame to the record. @param text  `length` bytes */
void ect_trace_log(ect_trace_t *trace, ect_logged_kind_t kind, uint32_t value, uint64_t time_ns, const char *text,
                   size_t length);

/** Adds a frame that enters the chain at an end. @return false: the capture has no room */
bool ect_trace_request(ect_trace_t *trace, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length);

/** Adds a frame that has left the chain at an end. @return false: the capture has no room */
bool ect_trace_reply(ect_trace_t *trace, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length);

/** Adds a line to the comment of the next frame. */
void ect_trace_note(ect_trace_t *trace, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Adds the effects of faults on a frame. @param changed  whether its bytes or its length have changed */
void ect_trace_effects(ect_trace_t *trace, const ect_frame_effects_t *effects, bool changed);

/** Adds each twin whose AL state or AL status code has changed. */
void ect_trace_states(ect_trace_t *trace, const ect_chain_t *chain);

/** Writes the added items to the files. */
void ect_trace_flush(ect_trace_t *trace);

/** Starts a writing thread for each file; without a thread, ::ect_trace_flush writes. */
void ect_trace_start(ect_trace_t *trace);

/** Losses in the files of a trace. */
typedef struct ect_trace_lacks {
    int capture;         /**< errno of the first failed write of the capture; 0 */
    int record;          /**< errno of the first failed write of the record; 0 */
    bool record_is_slow; /**< the record ends early: its disk was too slow */
} ect_trace_lacks_t;

/** Closes the files and frees the trace. NULL: no effect */
ect_trace_lacks_t ect_trace_close(ect_trace_t *trace, uint64_t now_ns);

ECT_C_END

#endif
