/* SPDX-License-Identifier: MIT */
/** @file All sections, in the order of the checklist. */
#ifndef ECTWIN_CONFORM_CATALOGUE_H
#define ECTWIN_CONFORM_CATALOGUE_H

#include "steps/case.h"

extern const cf_section_t *const cf_catalogue[];
extern const size_t cf_catalogue_count;

/** @param bit  one bit of `needs` @return the reason for skipping a case with this need, constant text */
const char *cf_need_text(uint32_t bit);

#endif
