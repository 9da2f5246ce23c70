/* SPDX-License-Identifier: MIT */
/** @file What ectwin-probe reads of a slave in PREOP and writes to a file. Segment set up with SOEM's ec_config_init.
 */
#ifndef ECTWIN_PROBE_H
#define ECTWIN_PROBE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "ethercat.h"

/** CoE among the mailbox protocols of a slave. */
enum { ECT_PROBE_COE = 0x04 };

/** Writes the whole EEPROM, as long as its header says. @return false: the slave does not answer any more */
bool probe_sii(uint16_t slave, FILE *file);

/**
 * Writes the dictionary as JSON: `described`, whether the slave has SDO information; `objects`, each with `index`,
 * `code`, `name` and `entries`, those with `subindex`, `type`, `bits`, `access`, `name`, and as hexadecimal bytes of
 * the wire `default`, `minimum`, `maximum`, `unit`, where the slave tells them. `value` is there for identity, device
 * type and name, mapping and assignment. A slave without CoE has no objects.
 * @return false: the slave does not answer any more
 */
bool probe_dictionary(uint16_t slave, FILE *file);

#endif
