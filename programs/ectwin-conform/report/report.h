/* SPDX-License-Identifier: MIT */
/** @file What a run found, for a reader or a machine. Each function writes one whole report. */
#ifndef ECTWIN_CONFORM_REPORT_H
#define ECTWIN_CONFORM_REPORT_H

#include <cjson/cJSON.h>

#include "report/result.h"

typedef void (*cf_report_t)(FILE *to, const cf_run_t *run);

void cf_report_text(FILE *to, const cf_run_t *run);
void cf_report_json(FILE *to, const cf_run_t *run);
void cf_report_junit(FILE *to, const cf_run_t *run);
void cf_report_html(FILE *to, const cf_run_t *run);

/** The histograms of a run, as parts of the reports; nothing when there are none. They put the values in order. */
void cf_timing_text(FILE *to, const cf_run_t *run);
void cf_timing_json(cJSON *report, const cf_run_t *run);
void cf_timing_html(FILE *to, const cf_run_t *run);

/** How many results have each verdict, by ::cf_verdict_t. */
typedef struct cf_counts {
    size_t of[CF_INTERRUPTED + 1];
} cf_counts_t;

/** @param section  NULL: all */
cf_counts_t cf_count(const cf_run_t *run, const cf_section_t *section);
const char *cf_verdict_name(cf_verdict_t verdict);
/** "frames 210-228, seen in 228" or "". */
void cf_frames_text(const cf_result_t *result, char *text, size_t room);

/**
 * A line of evidence in words: a sentence as it is, a frame datagram by datagram, one to a line.
 * @param c  for the addresses of the mailbox
 */
void cf_decode(const cf_t *c, const cf_item_t *item, char *text, size_t room);
/** Where the case's own part begins, after the known state. */
size_t cf_evidence_start(const cf_evidence_t *evidence);
/** Text for XML and HTML: `&`, `<`, `>`, `"`; what is no character of XML as `?`. */
void cf_put_escaped(FILE *to, const char *text);

#endif
