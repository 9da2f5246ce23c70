/* SPDX-License-Identifier: MIT */
/** @file
 * Numbers in the formats of ESI files. */
#ifndef ECT_ESI_NUMBER_H
#define ECT_ESI_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Parses a number: decimal with an optional sign, or `#x` or `0x` and hexadecimal digits.
 * @return false: not a number, or more than 64 bits
 */
bool ect_esi_parse_number(const char *text, int64_t *value);

ECT_C_END

#endif
