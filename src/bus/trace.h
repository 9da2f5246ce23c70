/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a run writes down: each frame in both directions, and as comments of the next frame each fault, plug, state
 * change, request of a client that changes something, and save.
 *
 * Context: the thread of the exchange. No call waits for the disk when the capture has a thread of its own. Cost of a
 * frame: a copy; of a run of the devices: a comparison a twin.
 */
#ifndef ECT_BUS_TRACE_H
#define ECT_BUS_TRACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/capture/capture.h"
#include "bus/chain/chain.h"
#include "bus/faults/scenario.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_trace ect_trace_t;

/**
 * Makes a trace of a chain.
 * @param capture  becomes the trace's: ::ect_trace_close closes it
 * @param count    number of twins
 * @return NULL: not enough memory; the capture stays the caller's
 */
ect_trace_t *ect_trace_new(ect_capture_t *capture, size_t count);

/** A frame enters the chain at an end. @return false: dropped, for lack of room */
bool ect_trace_request(ect_trace_t *trace, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length);

/** A frame has left the chain at an end. @return false: dropped, for lack of room */
bool ect_trace_reply(ect_trace_t *trace, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length);

/** Adds a line to the comment of the next frame. */
void ect_trace_note(ect_trace_t *trace, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Notes the effects that faults have on a frame. @param changed  its bytes or its length */
void ect_trace_effects(ect_trace_t *trace, const ect_frame_effects_t *effects, bool changed);

/** Notes the twins whose AL state or AL status code differs from the one before. */
void ect_trace_states(ect_trace_t *trace, const ect_chain_t *chain);

/** Passes what was added on to the file. */
void ect_trace_flush(ect_trace_t *trace);

/** Lets a thread of its own write. @return false: there is none; ::ect_trace_flush writes */
bool ect_trace_start(ect_trace_t *trace);

/** Closes the capture and frees the trace. @return as ::ect_capture_close. NULL: no effect */
int ect_trace_close(ect_trace_t *trace, uint64_t now_ns);

ECT_C_END

#endif
