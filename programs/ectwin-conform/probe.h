/* SPDX-License-Identifier: MIT */
/** @file Finds the slaves of the segment and examines the one under test, before the first case. */
#ifndef ECTWIN_CONFORM_PROBE_H
#define ECTWIN_CONFORM_PROBE_H

#include "steps/case.h"

/** Counts the slaves of the segment and sets their station addresses. @return number of slaves; 0 none */
uint16_t cf_scan(cf_t *c);
/** Fills c->facts and c->mailbox. Leaves by longjmp, as a step does, when the slave cannot be read. */
void cf_probe(cf_t *c);

#endif
