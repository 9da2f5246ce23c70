/* SPDX-License-Identifier: MIT */
/* Basics of all units of the chip: bytes of an access, event words, counters. */
#include <string.h>

#include "esc/internal.h"

void ect_esc_copy(const ect_access_t *access, uint8_t *memory, uint16_t offset, uint16_t length)
{
    uint8_t *data = access->data + offset;
    ECT_ASSERT(access->data && memory);
    uint8_t *to = access->write ? memory : data;
    const uint8_t *from = access->write ? data : memory;
    if (!access->mask) {
        memcpy(to, from, length);
        return;
    }
    const uint8_t *mask = access->mask + offset;
    for (uint16_t i = 0; i < length; i++)
        to[i] = (uint8_t)((to[i] & ~mask[i]) | (from[i] & mask[i]));
}

/* Datagrams collect a word of events that is not zero. */
void ect_esc_raise(ect_esc_t *esc, uint32_t al_event)
{
    ECT_ASSERT(al_event != 0);
    uint8_t *event = esc->memory + ECT_REG_AL_EVENT;
    ect_store_le32(event, ect_load_le32(event) | al_event);
    esc->activity++;
}

void ect_esc_clear(ect_esc_t *esc, uint32_t al_event)
{
    uint8_t *event = esc->memory + ECT_REG_AL_EVENT;
    ect_store_le32(event, ect_load_le32(event) & ~al_event);
}

static void change_ecat(ect_esc_t *esc, uint16_t events)
{
    uint8_t *event = esc->memory + ECT_REG_ECAT_EVENT;
    if (events == ect_load_le16(event))
        return;
    ect_store_le16(event, events);
    esc->routing++;
}

void ect_esc_raise_ecat(ect_esc_t *esc, uint16_t ecat_event)
{
    ECT_ASSERT(ecat_event != 0);
    change_ecat(esc, (uint16_t)(ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT) | ecat_event));
}

void ect_esc_clear_ecat(ect_esc_t *esc, uint16_t ecat_event)
{
    change_ecat(esc, (uint16_t)(ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT) & ~ecat_event));
}

void ect_esc_count(ect_esc_t *esc, uint16_t counter_register)
{
    ECT_ASSERT(counter_register >= ECT_REG_RX_ERROR && counter_register <= ECT_REG_WD_COUNTER_PD + 1);
    uint8_t *counter = esc->memory + counter_register;
    if (*counter < 0xFF)
        (*counter)++;
}
