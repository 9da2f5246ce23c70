/* SPDX-License-Identifier: MIT */
/** @file
 * Names of SDO abort codes (CiA 301, ETG.1000.6 Table 41). */
#ifndef ECT_TEXT_ABORT_H
#define ECT_TEXT_ABORT_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** The meaning of an SDO abort code: "the object is read-only"; constant text, NULL: the code has no name here. */
static inline const char *ect_abort_text(uint32_t code)
{
    static const struct {
        uint32_t code;
        const char *text;
    } names[] = {
        {0x05030000, "the toggle bit did not change"},
        {0x05040000, "timeout"},
        {0x05040001, "unknown command"},
        {0x05040005, "out of memory"},
        {0x06010000, "unsupported access"},
        {0x06010001, "the object is write-only"},
        {0x06010002, "the object is read-only"},
        {0x06010003, "sub-index 0 must be 0 for this write"},
        {0x06010004, "no Complete Access to objects of variable length"},
        {0x06010005, "the object is longer than the mailbox"},
        {0x06010006, "the object is mapped to a PDO"},
        {0x06020000, "the object does not exist"},
        {0x06040041, "the object cannot be mapped to a PDO"},
        {0x06040042, "the mapped objects are longer than the PDO"},
        {0x06040043, "incompatible parameters"},
        {0x06040047, "incompatible inside the device"},
        {0x06060000, "hardware error"},
        {0x06070010, "the length does not match"},
        {0x06070012, "the value is too long"},
        {0x06070013, "the value is too short"},
        {0x06090011, "the sub-index does not exist"},
        {0x06090030, "the value is out of range"},
        {0x06090031, "the value is too high"},
        {0x06090032, "the value is too low"},
        {0x06090033, "the modules differ from the detected ones"},
        {0x06090036, "the maximum is below the minimum"},
        {0x060A0023, "a resource is not available"},
        {0x08000000, "general error"},
        {0x08000020, "the value cannot be stored"},
        {0x08000021, "the value cannot be stored because of local control"},
        {0x08000022, "not in this AL state"},
        {0x08000023, "no object dictionary"},
        {0x08000024, "no data"},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (names[i].code == code)
            return names[i].text;
    }
    return NULL;
}

ECT_C_END

#endif
