/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Faults of one twin above the wire: its mails and its AL status. Internal to bus/chain.
 *
 * The faults act between the slave stack and the ESC, in the accesses of the PDI: reads of a request, of AL control or
 * of the registers of a SyncManager return changed values, and a mail is changed, kept or dropped on its way into SM1.
 * The stack, the device and the ESC are not changed. Without a fault the stack accesses the ESC directly.
 *
 * This file uses no clock; memory comes from the heap, with the first fault. Context: the thread of the chain. Cost:
 * none without a fault, else a search of the faults for each mail and each AL control.
 */
#ifndef ECT_BUS_CHAIN_ABOVE_H
#define ECT_BUS_CHAIN_ABOVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/fault.h"
#include "esc/esc.h"
#include "seams/pdi.h"
#include "slave/slave.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Limit of faults of a twin above the wire. */
enum { ECT_ABOVE_FAULTS = 8 };

typedef struct ect_above ect_above_t;

/** @param esc  of the twin, outlives the result @return NULL: out of memory. To be freed with free() */
ect_above_t *ect_above_new(ect_esc_t *esc);

/**
 * Adds a fault (::ect_fault_is_above_wire).
 * @param pdi  of the slave stack: passes through the faults from now on
 * @return false: ECT_ABOVE_FAULTS are set
 */
bool ect_above_add(ect_above_t *above, const ect_fault_t *fault, ect_pdi_t *pdi);

/**
 * Ends the faults with this tag; 0: all. After the last one, and once no mail is kept, the stack accesses the ESC
 * directly again.
 */
void ect_above_end(ect_above_t *above, uint32_t tag);

/** @return the i-th fault that is set, from 0, without ECT_FAULT_COUNT; NULL: none */
const ect_fault_t *ect_above_at(const ect_above_t *above, size_t i);

/** @return the number of SDO transfers counted by the fault with this tag; 0: none, or no such fault */
uint64_t ect_above_seen(const ect_above_t *above, uint32_t tag);

/** Handles a restart of the twin: drops kept mails, the transfer and the requests, not the faults. */
void ect_above_restart(ect_above_t *above);

/** Sends a mail that is due. Call it before the poll of the stack. */
void ect_above_before(ect_above_t *above, uint64_t now_ns);

/**
 * Sets the AL status code of a refused request. Call it after the poll of the stack.
 * @return the time of the next poll; ECT_NEVER: not necessary
 */
uint64_t ect_above_after(ect_above_t *above, ect_slave_t *slave, ect_pdi_t *pdi);

ECT_C_END

#endif
