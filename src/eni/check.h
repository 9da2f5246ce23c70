/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Checks whether the parts of a network file (ENI) agree with each other: the description of a slave, and the writes to
 * its registers. Whether slaves agree with the file is a matter of playing it (eni/play.h).
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
 * Checks a file: `AutoIncAddr` and place of each slave; mailboxes, SyncManagers and FMMUs as elements and as registers;
 * bits of `Send` and `Recv` as of PDOs and FMMUs; commands and variables inside the process image.
 * @param report  takes each contradiction, one line `FILE:LINE: ...` without its end
 * @return the number of lines
 */
size_t ect_eni_check(const ect_eni_t *eni, void (*report)(void *ctx, const char *line), void *ctx);

ECT_C_END

#endif
