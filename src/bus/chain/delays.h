/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Propagation delays: the time after which a frame reaches each port and each processing unit of a chain. Internal to
 * bus/chain.
 */
#ifndef ECT_BUS_CHAIN_DELAYS_H
#define ECT_BUS_CHAIN_DELAYS_H

#include "bus/chain/cabling.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Computes the propagation delays of all twins and sets them in their ESCs (::ect_esc_set_arrival). Due after a change
 * of a link or of a port's loop. If memory is exhausted, the delays are unchanged. Cost: two walks through all ports.
 */
void ect_delays_update(ect_cabling_t *cabling);

ECT_C_END

#endif
