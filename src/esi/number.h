/* SPDX-License-Identifier: MIT */
/** @file
 * Numbers as ESI files have them. */
#ifndef ECT_ESI_NUMBER_H
#define ECT_ESI_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Reads a number as ESI files have them: decimal with a sign, `#x` or `0x` and hexadecimal digits.
 * @return false: it is none, or none of 64 bits
 */
bool ect_esi_parse_number(const char *text, int64_t *value);

ECT_C_END

#endif
