/* SPDX-License-Identifier: MIT */
/*
 * Periodic output data: blocks of 200 bytes, reassembled in any order; a set is handed over when it is complete, and
 * the next one is assembled beside it (TS-0007 §10.4).
 */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"
#include "wire/crc.h"

static uint16_t blocks_of(uint16_t size)
{
    return (uint16_t)((size + ECLINK_PERIODIC_BYTES - 1) / ECLINK_PERIODIC_BYTES);
}

static void begin_set(eclink_periodic_t *p, uint16_t size)
{
    p->size = size;
    p->missing = blocks_of(size);
    memset(p->have, 0, sizeof p->have);
}

static void hand_over(eclink_t *unit)
{
    eclink_periodic_t *p = &unit->periodic;
    p->shown ^= 1;
    unit->bu.periodic_sets++;
    unit->bu.periodic_size = p->size;
    unit->bu.periodic_check = ~ect_crc32(0xFFFFFFFF, p->data[p->shown], p->size);
    for (unsigned int i = 0; i < ECLINK_RUS; i++)
        unit->ru[i].periodic_waits |= eclink_reachable(&unit->ru[i]);
    begin_set(p, p->size);
}

static void take_block(eclink_t *unit, uint16_t size, uint8_t block)
{
    eclink_periodic_t *p = &unit->periodic;
    uint32_t offset = (uint32_t)block * ECLINK_PERIODIC_BYTES;
    uint32_t length = size - offset < ECLINK_PERIODIC_BYTES ? size - offset : ECLINK_PERIODIC_BYTES;
    uint8_t mask = (uint8_t)(1u << (block % 8));
    if (size != p->size)
        begin_set(p, size);
    memcpy(p->data[p->shown ^ 1] + offset, unit->outputs + ECLINK_OUT_PERIODIC, length);
    if ((p->have[block / 8] & mask) != 0)
        return;
    p->have[block / 8] |= mask;
    p->missing--;
    if (p->missing == 0)
        hand_over(unit);
}

void eclink_periodic_outputs(eclink_t *unit, bool first)
{
    uint8_t pco = unit->outputs[ECLINK_OUT_PCO];
    uint16_t size = ect_load_be16(unit->outputs + ECLINK_OUT_PERIODIC_SIZE);
    uint8_t block = unit->outputs[ECLINK_OUT_PERIODIC_BLOCK];
    if (!first && pco == unit->last_pco)
        return;
    if (first || size == 0) {
        begin_set(&unit->periodic, 0); /* half a set from before an interruption is never completed */
        return;
    }
    if (size > ECLINK_PERIODIC_ROOM || block >= blocks_of(size)) {
        unit->bu.periodic_errors++;
        return;
    }
    take_block(unit, size, block);
}
