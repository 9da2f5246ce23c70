/* SPDX-License-Identifier: MIT */
/** @file The results of a run: input of every report. */
#ifndef ECTWIN_CONFORM_RESULT_H
#define ECTWIN_CONFORM_RESULT_H

#include "steps/engine.h"

/** Result of one case. */
typedef struct cf_result {
    const cf_section_t *section;
    const cf_case_t *entry;
    cf_verdict_t verdict;
    char reason[CF_REASON]; /**< of fail, skip, warn, unjudged; the note of pass */
    char step[CF_STEP];     /**< the last ::cf_step before the verdict; "" none */
    uint32_t frame;         /**< the last frame before the verdict */
    uint64_t duration_ns;
    cf_evidence_t evidence;
} cf_result_t;

/** Ability of the slave to pass the canary, a minimal start-up and mail exchange before each case. */
typedef enum cf_canary { CF_CANARY_UNTRIED, CF_CANARY_ABLE, CF_CANARY_UNABLE } cf_canary_t;

/** The run of all selected cases, in order. */
typedef struct cf_run {
    cf_t c;
    cf_engine_t engine;
    cf_result_t *results;
    size_t count;
    size_t planned;
    const char *iface;
    const char *esi;   /**< the ESI file and its device; NULL: none */
    char esi_hash[65]; /**< SHA-256 of the file, hexadecimal; "" none */
    char started[32];  /**< local time, ISO 8601 */
    uint64_t duration_ns;
    const char *command;   /**< command line of the run, as typed */
    const char *version;   /**< of ectwin-conform */
    const char *operator_; /**< --operator, --firmware; NULL: not given, blank in the report */
    const char *firmware;
    cf_canary_t canary;
    const char *last;    /**< id of the last case with a verdict; NULL: none */
    const char *since;   /**< id of the case after which the canary fails; NULL: the canary passes */
    char why[CF_REASON]; /**< reason of the first canary that failed since then */
} cf_run_t;

#endif
