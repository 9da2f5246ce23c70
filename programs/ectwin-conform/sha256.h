/* SPDX-License-Identifier: MIT */
/** @file SHA-256 (FIPS 180-4) of a file, to identify the ESI file in a report. */
#ifndef ECTWIN_CONFORM_SHA256_H
#define ECTWIN_CONFORM_SHA256_H

#include <stdio.h>

/** Computes the hash. @param[out] hex  64 digits and a zero; "" when `file` cannot be read to its end */
void cf_sha256(FILE *file, char hex[65]);

#endif
