/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Sets several signals, of one twin or by the names of twins: all of them, or none.
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
    const char *value; /**< as ::ect_signal_write takes it */
} ect_setting_t;

/**
 * Sets signals and wakes their twins: those with a turn (ect_signal_t) first, the others in the order given. A setting
 * without the name of a twin is for the twin at a position. A refused setting is tried again after each that follows,
 * so limits that depend on each other come in any order. Cost: one write a setting and try; with more than one, the
 * instance of each twin is copied first.
 * @param position      0..::ect_chain_count - 1
 * @param settings      `count` of them; 0: none
 * @param[out] message  on failure the reason for the first refusal; ECT_SIGNAL_MESSAGE bytes
 * @return whether all were set; if not, the twins are unchanged, but for effects that a setting has already started (a
 *         save, a restart): give those last
 */
bool ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                        uint64_t now_ns, char *message);

/** A signal that has been found, to be set again and again. */
typedef struct ect_setting_place {
    ect_signal_ref_t ref;
    size_t position; /**< of its twin in the chain, from 0 */
} ect_setting_place_t;

/**
 * Finds a signal, of the twin at a position or by the name of a twin.
 * @param[out] place    valid as long as the chain
 * @param[out] message  on failure the reason, with the nearest name; ECT_SIGNAL_MESSAGE bytes
 * @return whether there is one
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
