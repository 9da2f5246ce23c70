/* SPDX-License-Identifier: MIT */
/* Basics of all units of the chip: bytes of an access, event words, counters. */
#include "esc/internal.h"

void ect_esc_copy_bits(const ect_access_t *access, uint8_t *memory, uint16_t offset, uint16_t length)
{
    uint8_t *data = access->data + offset;
    uint8_t *to = access->write ? memory : data;
    const uint8_t *from = access->write ? data : memory;
    const uint8_t *mask = access->mask + offset;
    for (uint16_t i = 0; i < length; i++)
        to[i] = (uint8_t)((to[i] & ~mask[i]) | (from[i] & mask[i]));
}

void ect_esc_set_ecat(ect_esc_t *esc, uint16_t events)
{
    ect_store_le16(esc->memory + ECT_REG_ECAT_EVENT, events);
    esc->routing++;
}

void ect_esc_count(ect_esc_t *esc, uint16_t counter_register)
{
    ECT_ASSERT(counter_register >= ECT_REG_RX_ERROR && counter_register <= ECT_REG_WD_COUNTER_PD + 1);
    uint8_t *counter = esc->memory + counter_register;
    if (*counter < 0xFF)
        (*counter)++;
}
