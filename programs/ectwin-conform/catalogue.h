/* SPDX-License-Identifier: MIT */
/** @file All sections of the checklist, in its order. */
#ifndef ECTWIN_CONFORM_CATALOGUE_H
#define ECTWIN_CONFORM_CATALOGUE_H

#include "steps/case.h"

extern const cf_section_t *const cf_catalogue[];
extern const size_t cf_catalogue_count;

/** Why a slave without that bit (one of `needs`) cannot be judged, constant text. */
const char *cf_need_text(uint32_t bit);

#endif
