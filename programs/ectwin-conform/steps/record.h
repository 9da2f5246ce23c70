/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The record of a run: each frame sent or received, numbered, in a capture file and as evidence of the running case.
 * The linker wraps send() and recv(), so frames of SOEM itself are recorded too.
 */
#ifndef ECTWIN_CONFORM_RECORD_H
#define ECTWIN_CONFORM_RECORD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef enum cf_item_kind { CF_ITEM_STEP, CF_ITEM_SENT, CF_ITEM_RECEIVED } cf_item_kind_t;

/** A line of evidence: a sentence, or a frame. */
typedef struct cf_item {
    cf_item_kind_t kind;
    uint32_t frame;   /**< its number in the capture, from 1; of a sentence: the number of the next frame */
    uint32_t folded;  /**< number of equal exchanges directly before this one, which only the capture contains */
    uint64_t time_ns; /**< since the start of the run */
    uint32_t length;
    uint32_t room;  /**< bytes of memory at `bytes` */
    uint8_t *bytes; /**< a frame from the destination MAC on, or a text with its zero; owned by the item */
} cf_item_t;

/** Evidence of one case: its last CF_EVIDENCE_MAX items, with equal polls folded into one. */
typedef struct cf_evidence {
    cf_item_t *items; /**< oldest first */
    size_t count;
    uint32_t first_frame, last_frame; /**< 0: none */
} cf_evidence_t;

enum { CF_EVIDENCE_MAX = 400 };

/** Starts the record. @param capture  pcapng file, which the caller closes after ::cf_record_close; NULL: none */
void cf_record_open(FILE *capture);
/**
 * Replaces the source address of frames that SOEM and cases send with a multicast address, which no station may have.
 * @param mac  6 bytes, copied; NULL: frames leave as they are
 */
void cf_record_source(const uint8_t *mac);
/** Starts the evidence of a case; the title becomes the comment of its first frame in the capture. */
void cf_record_begin(const char *id, const char *title);
/** Adds a sentence to the evidence, and to the comment of the next frame. */
void cf_record_step(const char *text);
/** Ends the case. @return its last `most` items, for ::cf_evidence_free */
cf_evidence_t cf_record_end(size_t most);
void cf_evidence_free(cf_evidence_t *evidence);
/** @return number of the last frame */
uint32_t cf_record_frame(void);
/** Frees all items; the record is closed until ::cf_record_open. */
void cf_record_close(void);

#endif
