/* SPDX-License-Identifier: MIT */
/* Faults and warnings by their numbers on the front of the amplifier. */
#include "devices/pmctendo/instance.h"

/* Bits of the error register 1001h. */
enum { GENERIC = 0x01, CURRENT = 0x02, VOLTAGE = 0x04, HOT = 0x08, BUS = 0x10, PROFILE = 0x20 };

typedef struct fault {
    uint8_t number;
    uint8_t reg;
    uint16_t code; /* 603Fh, CiA 402 */
    bool brakes;
    bool restart; /* ended only by a power cycle */
} fault_t;

static const fault_t faults[] = {
    {1, HOT, 0x4210, true, false},       /* heat sink too warm */
    {2, VOLTAGE, 0x3210, false, false},  /* overvoltage */
    {3, PROFILE, 0x8611, true, false},   /* following error */
    {4, PROFILE, 0x7305, false, true},   /* feedback */
    {5, VOLTAGE, 0x3220, false, false},  /* undervoltage */
    {6, HOT, 0x4310, true, false},       /* motor too warm */
    {8, PROFILE, 0x8480, false, false},  /* overspeed */
    {9, 0, 0x5530, false, true},         /* memory */
    {14, CURRENT, 0x5400, false, true},  /* power stage */
    {15, CURRENT, 0x2310, true, false},  /* I2t */
    {16, VOLTAGE, 0x3130, true, false},  /* mains */
    {27, PROFILE, 0xFF1B, false, false}, /* STO while enabled */
    {28, BUS, 0x8700, true, false},      /* synchronisation */
    {30, PROFILE, 0xFF1E, false, false}, /* quick stop takes too long */
    {32, 0, 0x6100, false, true},        /* firmware */
};

static const fault_t *find(uint16_t number)
{
    for (unsigned int i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        if (faults[i].number == number)
            return &faults[i];
    }
    return NULL;
}

bool pmc_fault_known(uint16_t number)
{
    return find(number) != NULL;
}

bool pmc_fault_needs_restart(uint16_t number)
{
    const fault_t *f = find(number);
    return f && f->restart;
}

bool pmc_fault_brakes(uint16_t number)
{
    const fault_t *f = find(number);
    return f && f->brakes;
}

void pmc_fault(pmctendo_t *u, uint16_t number)
{
    const fault_t *f = find(number);
    const uint8_t data[5] = {(uint8_t)number};
    if (u->fault != 0 || !f)
        return;
    u->fault = number;
    u->error_code = f->code;
    u->host->emergency(u->host->ctx, f->code, f->reg | GENERIC, data);
}

/* Sends an emergency at the end of a fault, as at its beginning. */
void pmc_fault_reset(pmctendo_t *u)
{
    static const uint8_t nothing[5];
    if (u->fault == 0)
        return;
    u->fault = 0;
    u->error_code = 0;
    u->host->emergency(u->host->ctx, 0, 0, nothing);
}

void pmc_warn(pmctendo_t *u, unsigned int number, bool on)
{
    uint32_t mask = 1u << (number - 1);
    u->warnings = on ? u->warnings | mask : u->warnings & ~mask;
}
