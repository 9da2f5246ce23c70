/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The request `pdos` of the control protocol (docs/CONTROL.md): the entries of the assigned PDOs, with their values.
 * Internal to bus/control.
 *
 * Context: the thread of the chain, between polls.
 */
#ifndef ECT_BUS_CONTROL_PDOS_H
#define ECT_BUS_CONTROL_PDOS_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/control/line.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Reads the member "place" (default 0): SyncManager, number of the assigned PDO and number of its entry, eight bits
 * each, the SyncManager in the highest.
 * @return the reason of a refusal; NULL: *place is set
 */
const char *ect_pdos_place(const cJSON *request, uint32_t *place);

/**
 * Writes the first entry at or after a place. Cost: a few searches in the dictionary, and one for each preceding PDO
 * without entries.
 * @param number         of the slave, from 1
 * @param[in,out] place  set to the place after the entry
 * @return false: no further entry
 */
bool ect_pdos_next(const ect_slave_t *slave, size_t number, uint32_t *place, ect_line_t *line);

ECT_C_END

#endif
