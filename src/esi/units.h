/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Units of ETG.1004 and their usual names: a prefix, a unit, and a unit as denominator: "mm/s".
 *
 * Units are numbers as in ESI files: power of ten in bits 24 to 31, numerator in bits 16 to 23, denominator in bits 8
 * to 15. Units without a usual name are written as numbers.
 */
#ifndef ECT_ESI_UNITS_H
#define ECT_ESI_UNITS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Reads a name, or a number. @return false: neither; `unit` is unchanged */
bool ect_esi_unit_parse(const char *text, uint32_t *unit);

/** @return `text` with the name; NULL: the unit has none, `text` is "" */
const char *ect_esi_unit_text(uint32_t unit, char *text, size_t room);

ECT_C_END

#endif
