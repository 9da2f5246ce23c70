/* SPDX-License-Identifier: MIT */
/** @file
 * Names of emergency error codes (CiA 301, ETG.1000.6 §5.6.4). */
#ifndef ECT_TEXT_EMERGENCY_H
#define ECT_TEXT_EMERGENCY_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** The class of an emergency error code: 0x5530 is "device hardware"; constant text. */
static inline const char *ect_emergency_text(uint16_t code)
{
    static const struct {
        uint8_t high, mask;
        const char *text;
    } classes[] = {
        {0x21, 0xFF, "current at the input"},
        {0x22, 0xFF, "current inside the device"},
        {0x23, 0xFF, "current at the output"},
        {0x20, 0xF0, "current"},
        {0x31, 0xFF, "mains voltage"},
        {0x32, 0xFF, "voltage inside the device"},
        {0x33, 0xFF, "output voltage"},
        {0x30, 0xF0, "voltage"},
        {0x41, 0xFF, "ambient temperature"},
        {0x42, 0xFF, "device temperature"},
        {0x40, 0xF0, "temperature"},
        {0x50, 0xF0, "device hardware"},
        {0x61, 0xFF, "internal software"},
        {0x62, 0xFF, "user software"},
        {0x63, 0xFF, "data set"},
        {0x60, 0xF0, "device software"},
        {0x70, 0xF0, "additional modules"},
        {0x81, 0xFF, "communication"},
        {0x82, 0xFF, "protocol"},
        {0x80, 0xF0, "monitoring"},
        {0x90, 0xF0, "external error"},
        {0xA0, 0xF0, "state machine"},
        {0xF0, 0xFF, "additional functions"},
        {0xFF, 0xFF, "device-specific error"},
        {0x10, 0xFF, "generic error"},
    };
    for (size_t i = 0; i < sizeof classes / sizeof classes[0]; i++) {
        if ((code >> 8 & classes[i].mask) == classes[i].high)
            return classes[i].text;
    }
    return code >> 8 == 0 ? "error reset or no error" : "unknown error";
}

ECT_C_END

#endif
