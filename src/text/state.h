/* SPDX-License-Identifier: MIT */
/** @file
 * Names of AL states (ETG.1000.6 §6). */
#ifndef ECT_TEXT_STATE_H
#define ECT_TEXT_STATE_H

#include <stdint.h>

#include "wire/linkage.h"
#include "wire/registers.h"

ECT_C_BEGIN

/** The name of a value of AL control or AL status, with its error bit: "SAFEOP + error"; constant text. */
static inline const char *ect_state_text(unsigned int al_status)
{
    static const char *const names[2][16] = {
        {"state 0", "INIT", "PREOP", "BOOT", "SAFEOP", "state 5", "state 6", "state 7", "OP", "state 9", "state 10",
         "state 11", "state 12", "state 13", "state 14", "state 15"},
        {"state 0 + error", "INIT + error", "PREOP + error", "BOOT + error", "SAFEOP + error", "state 5 + error",
         "state 6 + error", "state 7 + error", "OP + error", "state 9 + error", "state 10 + error", "state 11 + error",
         "state 12 + error", "state 13 + error", "state 14 + error", "state 15 + error"},
    };
    return names[(al_status & ECT_AL_ERROR) != 0][al_status & ECT_AL_STATE_MASK];
}

ECT_C_END

#endif
