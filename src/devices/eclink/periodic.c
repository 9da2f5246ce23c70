/* SPDX-License-Identifier: MIT */
/*
 * Periodic output data: blocks of 200 bytes become sets. Block 0 always begins a set; the others may follow in any
 * order. A complete set is passed on, and the next one is assembled in the other half of the buffer (TS-0007 §10.4).
 */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"
#include "wire/crc.h"

static uint16_t blocks_of(uint16_t size)
{
    return (uint16_t)((size + ECLINK_PERIODIC_BYTES - 1) / ECLINK_PERIODIC_BYTES);
}

/* @return the half of the buffer with the complete set, or the other half */
static uint8_t *half(const eclink_t *unit, bool complete)
{
    bool second = (unit->periodic.shown != 0) == complete;
    uint8_t *buffer = unit->host->buffer;
    return buffer && second ? buffer + ECLINK_PERIODIC_ROOM : buffer;
}

const uint8_t *eclink_periodic_set(const eclink_t *unit)
{
    return half(unit, true);
}

void eclink_periodic_drop(eclink_t *unit)
{
    unit->bu.periodic_unfinished += unit->bu.periodic_missing > 0;
    unit->bu.periodic_lost += unit->bu.periodic_missing;
    unit->bu.periodic_pending = 0;
    unit->bu.periodic_missing = 0;
}

static void begin_set(eclink_t *unit, uint16_t size)
{
    eclink_periodic_drop(unit);
    unit->bu.periodic_pending = size;
    unit->bu.periodic_missing = blocks_of(size);
    memset(unit->periodic.have, 0, sizeof unit->periodic.have);
}

static void hand_over(eclink_t *unit)
{
    unit->periodic.shown ^= 1;
    const uint8_t *set = eclink_periodic_set(unit);
    unit->bu.periodic_sets++;
    unit->bu.periodic_size = unit->bu.periodic_pending;
    unit->bu.periodic_pending = 0;
    unit->bu.periodic_check = set ? ~ect_crc32(0xFFFFFFFF, set, unit->bu.periodic_size) : 0;
    for (unsigned int i = 0; i < ECLINK_RUS; i++)
        unit->ru[i].periodic_waits |= eclink_reachable(&unit->ru[i]);
}

/* A repeated block replaces its bytes. */
static void take_block(eclink_t *unit, uint8_t block)
{
    eclink_periodic_t *p = &unit->periodic;
    uint32_t offset = (uint32_t)block * ECLINK_PERIODIC_BYTES;
    uint32_t left = unit->bu.periodic_pending - offset;
    uint8_t mask = (uint8_t)(1u << (block % 8));
    uint8_t *set = half(unit, false);
    if (set)
        memcpy(set + offset, unit->outputs + ECLINK_OUT_PERIODIC,
               left < ECLINK_PERIODIC_BYTES ? left : ECLINK_PERIODIC_BYTES);
    if ((p->have[block / 8] & mask) != 0)
        return;
    p->have[block / 8] |= mask;
    unit->bu.periodic_missing--;
    if (unit->bu.periodic_missing == 0)
        hand_over(unit);
}

void eclink_periodic_outputs(eclink_t *unit)
{
    uint16_t size = ect_load_be16(unit->outputs + ECLINK_OUT_PERIODIC_SIZE);
    uint8_t block = unit->outputs[ECLINK_OUT_PERIODIC_BLOCK];
    if (size == 0) {
        eclink_periodic_drop(unit);
    } else if (size > ECLINK_PERIODIC_ROOM || block >= blocks_of(size)) {
        unit->bu.periodic_errors++;
    } else if (block == 0) {
        begin_set(unit, size);
        take_block(unit, 0);
    } else if (size == unit->bu.periodic_pending) {
        take_block(unit, block);
    } else {
        eclink_periodic_drop(unit); /* a block of another set, whose block 0 is missing */
        unit->bu.periodic_skipped++;
    }
}
