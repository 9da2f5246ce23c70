/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Sets several signals, of one twin or by the names of twins: all or none.
 */
#ifndef ECT_BUS_CHAIN_SETTINGS_H
#define ECT_BUS_CHAIN_SETTINGS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_setting {
    const char *name;  /**< "data1"; "gripper.data1" with the name of a twin (::ect_chain_resolve) */
    const char *value; /**< text of ::ect_signal_write */
} ect_setting_t;

/**
 * Sets signals and wakes their twins: signals with a turn (ect_signal_t) first, the others in the given order. A
 * setting without the name of a twin is for the twin at `position`. A refused setting is repeated after each later one,
 * so limits that depend on each other may be given in any order. Cost: one write for each setting and repetition; with
 * several settings, the instance of each twin is copied before.
 * @param position      0..::ect_chain_count - 1
 * @param settings      `count` of them; 0: none
 * @param[out] message  on failure the reason for the first refusal; ECT_SIGNAL_MESSAGE bytes
 * @return whether all signals were set; on false the twins are unchanged, except effects already started (a save, a
 *         restart): give settings with such effects last
 */
bool ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                        uint64_t now_ns, char *message);

/** A signal found once, to be set repeatedly. */
typedef struct ect_setting_place {
    ect_signal_ref_t ref;
    size_t position; /**< of its twin in the chain, from 0 */
} ect_setting_place_t;

/**
 * Finds a signal, of the twin at a position or by the name of a twin.
 * @param[out] place    valid as long as the chain
 * @param[out] message  on failure the reason, with the nearest name; ECT_SIGNAL_MESSAGE bytes
 * @return whether the signal exists
 */
bool ect_settings_find(const ect_chain_t *chain, size_t position, const char *name, ect_setting_place_t *place,
                       char *message);

/**
 * As ::ect_settings_apply, for signals that ::ect_settings_find has found.
 * @param values  `count` texts; NULL: the signal keeps its value
 */
bool ect_settings_write(ect_chain_t *chain, const ect_setting_place_t *places, const char *const *values, size_t count,
                        uint64_t now_ns, char *message);

ECT_C_END

#endif
