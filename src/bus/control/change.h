/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Requests of the control protocol that change a chain (docs/CONTROL.md): `set`, `fault`, `write` and `wave`. The
 * control socket and the replay of a record execute them here.
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

/** @return the operation of a request, "op"; "": none */
const char *ect_change_op(const cJSON *request);

/** @return whether an operation changes the chain */
bool ect_change_is(const char *op);

/** @return the slave of a request, by number, name or alias:N, from 1 (default 1); 0: all; -1: no such slave */
long ect_change_slave(const cJSON *request, const ect_chain_t *chain);

/**
 * Executes a request whose operation changes the chain.
 * @param scenario      NULL: `fault` is refused
 * @param[out] message  ECT_SIGNAL_MESSAGE bytes, for a reason
 * @return the reason of a refusal, one line; NULL: done
 */
const char *ect_change_apply(ect_chain_t *chain, ect_scenario_t *scenario, const cJSON *request, uint64_t now_ns,
                             char *message);

/**
 * Checks that the signals of a `set` request exist and are writable. Values are checked at the execution.
 * @param slave         from 1
 * @param[out] message  ECT_SIGNAL_MESSAGE bytes, for a reason
 * @return the reason of a refusal, one line; NULL: existing and writable
 */
const char *ect_change_check(const ect_chain_t *chain, size_t slave, const cJSON *request, char *message);

ECT_C_END

#endif
