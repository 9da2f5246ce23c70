/* SPDX-License-Identifier: MIT */
/** @file SHA-256 (FIPS 180-4) of a file, so that a report names the ESI file that it compared with. */
#ifndef ECTWIN_CONFORM_SHA256_H
#define ECTWIN_CONFORM_SHA256_H

#include <stdio.h>

/** @param[out] hex  64 digits and a zero; "" when `file` cannot be read to its end */
void cf_sha256(FILE *file, char hex[65]);

#endif
