/* SPDX-License-Identifier: MIT */
/* Faults by their code of CiA 402-2: reaction, error register, emergency. */
#include "profiles/cia402/drive.h"

/* Bits of the error register 1001h. */
enum { GENERIC = 0x01, CURRENT = 0x02, VOLTAGE = 0x04, HOT = 0x08, BUS = 0x10, PROFILE = 0x20 };

/* Faults that disable the power stage, so that no reaction can brake. */
static const uint16_t off[] = {0x2310, 0x2320, 0x2340, 0x3210, 0x3220, 0x5112, 0x5441,
                               0x5530, 0x6100, 0x6320, 0x7303, 0x7305, 0x7320, 0x8400};

bool ect_402_fault_brakes(uint16_t code)
{
    bool safety = code >> 4 == 0xFF1;
    for (unsigned int i = 0; i < sizeof off / sizeof off[0]; i++) {
        if (off[i] == code)
            return false;
    }
    return !safety;
}

bool ect_402_fault_restarts(uint16_t code)
{
    return code == 0x5530 || code == 0x6100; /* memory, firmware */
}

static uint8_t register_of(uint16_t code)
{
    static const struct {
        uint16_t mask, value;
        uint8_t bit;
    } rows[] = {{0xF000, 0x2000, CURRENT}, {0xF000, 0x3000, VOLTAGE}, {0xF000, 0x4000, HOT},    {0xFF00, 0x7500, BUS},
                {0xFF00, 0x8100, BUS},     {0xF000, 0x8000, PROFILE}, {0xFF00, 0xFF00, PROFILE}};
    for (unsigned int i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if ((code & rows[i].mask) == rows[i].value)
            return GENERIC | rows[i].bit;
    }
    return GENERIC;
}

void ect_402_drive_fault(ect_402_drive_t *d, uint16_t code)
{
    static const uint8_t nothing[5];
    if (code == 0 || d->error_code == code)
        return;
    d->error_code = code;
    d->host->emergency(d->host->ctx, code, register_of(code), nothing);
}

void ect_402_drive_fault_reset(ect_402_drive_t *d)
{
    static const uint8_t nothing[5];
    if (d->error_code == 0)
        return;
    d->error_code = 0;
    d->host->emergency(d->host->ctx, 0, 0, nothing);
}
