/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Requests that change a chain, as the control socket takes them (docs/CONTROL.md): {"op":"set",…} and
 * {"op":"fault",…}. The replay of a record carries out the same requests.
 */
#ifndef ECT_BUS_CONTROL_CHANGE_H
#define ECT_BUS_CONTROL_CHANGE_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/faults/scenario.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** @return "op" of a request; "" without one */
const char *ect_change_op(const cJSON *request);

/** @return whether an operation changes the chain */
bool ect_change_is(const char *op);

/** @return the slave that a request is for by its number or its name, from 1 (default 1); 0: all; -1: there is none */
long ect_change_slave(const cJSON *request, const ect_chain_t *chain);

/**
 * Carries out a request of an operation that changes the chain.
 * @param scenario      NULL: no faults can be set
 * @param[out] message  room of ECT_SIGNAL_MESSAGE bytes for a reason
 * @return the reason why not, one line; NULL: done
 */
const char *ect_change_apply(ect_chain_t *chain, ect_scenario_t *scenario, const cJSON *request, uint64_t now_ns,
                             char *message);

/**
 * Whether the signals of a `set` request exist and can be set; their values are judged when it is carried out.
 * @param slave         from 1
 * @param[out] message  room of ECT_SIGNAL_MESSAGE bytes for a reason
 * @return the reason why not, one line; NULL: they can be set
 */
const char *ect_change_check(const ect_chain_t *chain, size_t slave, const cJSON *request, char *message);

ECT_C_END

#endif
