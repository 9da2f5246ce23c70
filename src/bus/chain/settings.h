/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Several signals of one twin at once: all of them, or none.
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
    const char *name;
    const char *value; /**< as ::ect_signal_write takes it */
} ect_setting_t;

/**
 * Sets signals of the twin at a position, in the order given; one that is refused because of another is tried again
 * after each that follows, so that limits which depend on each other can be given in any order. Wakes the twin.
 * Cost: one write a setting and try; with more than one, the twin's instance is copied first.
 * @param count         0: nothing is to be done
 * @param[out] message  on failure why the first one is not taken; ECT_SIGNAL_MESSAGE bytes
 * @return whether all were set; if not, the twin is as it was. What a setting has sent off (a save, a restart) is not
 *         called back: name those last.
 */
bool ect_settings_apply(ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                        uint64_t now_ns, char *message);

ECT_C_END

#endif
