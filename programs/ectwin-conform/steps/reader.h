/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The reader of slaves (reader/reader.h) over the port of the run, for steps that need the slave's data and do not
 * judge the transfers: the facts, and the comparison with an ESI file. There, a lost frame or a repeated mail has no
 * effect on the verdict. Cases that judge the transfers have steps of their own: sii_access.c, sdo.c, coe_walk.h.
 */
#ifndef ECTWIN_CONFORM_READER_H
#define ECTWIN_CONFORM_READER_H

#include "reader/reader.h"
#include "steps/case.h"

/**
 * Opens the reader for the slave under test; a slave in PREOP or higher keeps state and mailbox. Leaves the case when
 * the slave cannot be read.
 * @return the reader, to be closed with ::cf_reader_close; one at a time
 */
ect_reader_t *cf_reader_open(cf_t *c);

/**
 * Closes the reader. With a result other than ECT_READER_OK leaves the case: at its time limit and on Ctrl-C as every
 * step does, else with the reader's text.
 */
void cf_reader_close(cf_t *c, ect_reader_result_t result);

#endif
