/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Checks the consistency of a network file (ENI): the description of each slave against the writes to its registers.
 * The player (eni/play.h) checks slaves against the file.
 *
 * Host only. Context: mainline. Clauses: ETG.2100.
 */
#ifndef ECT_ENI_CHECK_H
#define ECT_ENI_CHECK_H

#include <stddef.h>

#include "eni/read.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Checks a file: `AutoIncAddr` against the position of each slave; the elements of mailboxes, SyncManagers and FMMUs
 * against the registers; the bits of `Send` and `Recv` against PDOs and FMMUs; the limits of the process image for
 * commands and variables.
 * @param report  called for each contradiction, with one line `FILE:LINE: ...` without a line end
 * @return the number of contradictions
 */
size_t ect_eni_check(const ect_eni_t *eni, void (*report)(void *ctx, const char *line), void *ctx);

ECT_C_END

#endif
