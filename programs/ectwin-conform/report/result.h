/* SPDX-License-Identifier: MIT */
/** @file The results of a run: input of every report. */
#ifndef ECTWIN_CONFORM_RESULT_H
#define ECTWIN_CONFORM_RESULT_H

#include "steps/engine.h"

/** What came of a case. */
typedef struct cf_result {
    const cf_section_t *section;
    const cf_case_t *entry;
    cf_verdict_t verdict;
    char reason[CF_REASON]; /**< why it failed, was skipped, is warned of; or the note of one that passed */
    char step[CF_STEP];     /**< the last ::cf_step before that; "" none */
    uint32_t frame;         /**< the last one before the verdict */
    uint64_t duration_ns;
    cf_evidence_t evidence;
} cf_result_t;

/** All cases that the user chose, in order. */
typedef struct cf_run {
    cf_t c;
    cf_engine_t engine;
    cf_result_t *results;
    size_t count;
    size_t planned;
    const char *iface;
    const char *esi;  /**< the ESI file, and which device of it; NULL: none */
    char started[32]; /**< local time, ISO 8601 */
    uint64_t duration_ns;
} cf_run_t;

#endif
