/* SPDX-License-Identifier: MIT */
/** @file Reports of a run, for people and for programs. Each cf_report_* function writes one whole report. */
#ifndef ECTWIN_CONFORM_REPORT_H
#define ECTWIN_CONFORM_REPORT_H

#include <cjson/cJSON.h>

#include "report/result.h"

typedef void (*cf_report_t)(FILE *to, const cf_run_t *run);

void cf_report_text(FILE *to, const cf_run_t *run);
void cf_report_json(FILE *to, const cf_run_t *run);
void cf_report_junit(FILE *to, const cf_run_t *run);
void cf_report_html(FILE *to, const cf_run_t *run);

/** Histograms of a run, as parts of the reports; no output when there are none. Sort the values. */
void cf_timing_text(FILE *to, const cf_run_t *run);
void cf_timing_json(cJSON *report, const cf_run_t *run);
void cf_timing_html(FILE *to, const cf_run_t *run);

/** Number of results by ::cf_verdict_t. */
typedef struct cf_counts {
    size_t of[CF_INTERRUPTED + 1];
} cf_counts_t;

/** Counts the results of one section. @param section  NULL: all sections */
cf_counts_t cf_count(const cf_run_t *run, const cf_section_t *section);
/** @return "pass", "warn", "fail", "skip", "unjudged", "interrupted": constant text */
const char *cf_verdict_name(cf_verdict_t verdict);
/** Writes "frames 210-228, seen in 228", or "" without frames. */
void cf_frames_text(const cf_result_t *result, char *text, size_t room);

/**
 * Writes one item of evidence in words: a sentence unchanged, a frame as one line per datagram. Any bytes are allowed.
 * @param c           the addresses of the mailbox are read
 * @param[out] text   `room` bytes (1 or more), always terminated by zero; longer text is truncated
 */
void cf_decode(const cf_t *c, const cf_item_t *item, char *text, size_t room);
/** @return index of the first item after the preparation of the slave */
size_t cf_evidence_start(const cf_evidence_t *evidence);
/** Writes text for XML and HTML: `&`, `<`, `>`, `"` as entities, control characters and invalid UTF-8 as `?`. */
void cf_put_escaped(FILE *to, const char *text);
/** Replaces control characters except line feed, and invalid UTF-8, by `?`: JSON allows neither. */
void cf_clean(char *text);

#endif
