/* SPDX-License-Identifier: MIT */
/** @file Runs cases: each between two known states of the slave. */
#ifndef ECTWIN_CONFORM_RUNNER_H
#define ECTWIN_CONFORM_RUNNER_H

#include "report/result.h"

/** Runs one case between two known states. */
void cf_run_case(cf_run_t *run, const cf_section_t *section, const cf_case_t *entry, cf_result_t *result);

#endif
