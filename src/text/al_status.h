/* SPDX-License-Identifier: MIT */
/** @file
 * Names of AL status codes (ETG.1000.6 Table 11, ETG.1020). */
#ifndef ECT_TEXT_AL_STATUS_H
#define ECT_TEXT_AL_STATUS_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** The meaning of an AL status code: "process data watchdog"; constant text, NULL: the code has no name here. */
static inline const char *ect_al_status_text(uint16_t code)
{
    static const struct {
        uint16_t code;
        const char *text;
    } names[] = {
        {0x0000, "no error"},
        {0x0001, "unspecified error"},
        {0x0002, "no memory"},
        {0x0011, "invalid state change requested"},
        {0x0012, "unknown state requested"},
        {0x0013, "BOOT is not supported"},
        {0x0014, "no valid firmware"},
        {0x0015, "invalid mailbox configuration for BOOT"},
        {0x0016, "invalid mailbox configuration for PREOP"},
        {0x0017, "invalid SyncManager configuration"},
        {0x0018, "no valid inputs"},
        {0x0019, "no valid outputs"},
        {0x001A, "synchronisation error"},
        {0x001B, "process data watchdog"},
        {0x001C, "invalid SyncManager types"},
        {0x001D, "invalid output configuration"},
        {0x001E, "invalid input configuration"},
        {0x001F, "invalid watchdog configuration"},
        {0x0020, "cold start required"},
        {0x0021, "INIT required"},
        {0x0022, "PREOP required"},
        {0x0023, "SAFEOP required"},
        {0x0024, "invalid input mapping"},
        {0x0025, "invalid output mapping"},
        {0x0026, "inconsistent settings"},
        {0x0027, "free run is not supported"},
        {0x0028, "synchronous operation is not supported"},
        {0x002C, "fatal synchronisation error"},
        {0x002D, "no synchronisation signal"},
        {0x0030, "invalid DC configuration"},
        {0x0035, "invalid cycle time"},
        {0x0036, "invalid SYNC0 cycle time"},
        {0x0050, "no access to the EEPROM"},
        {0x0051, "EEPROM error"},
        {0x0060, "slave was restarted"},
        {0x0061, "device identification was updated"},
        {0x0070, "module idents differ"},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (names[i].code == code)
            return names[i].text;
    }
    return NULL;
}

ECT_C_END

#endif
