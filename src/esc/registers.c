/* SPDX-License-Identifier: MIT */
/*
 * The registers as a table: which block each side may write, and what follows from a write or a read. An address that
 * stands in no row is read-only; one of an absent function answers nothing.
 */
#include <string.h>

#include "esc/internal.h"

typedef bool (*write_fn)(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
typedef void (*read_fn)(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

typedef struct block {
    uint16_t first;
    uint16_t size;
    write_fn ecat_write; /* NULL: read-only for that side */
    write_fn pdi_write;
    read_fn after_read;
} block_t;

static bool write_plain(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    ect_esc_copy(access, esc->memory + address, 0, length);
    return true;
}

/* The chip answers AL control itself: a device without a microcontroller. */
static bool emulation(const ect_esc_t *esc)
{
    return (esc->memory[ECT_REG_PDI_CONTROL + 1] & 0x01) != 0;
}

static bool write_al_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (esc->al_control_locked && !emulation(esc))
        return false;
    write_plain(esc, access, address, length);
    if (emulation(esc)) {
        memcpy(esc->memory + ECT_REG_AL_STATUS, esc->memory + ECT_REG_AL_CONTROL, 2);
        esc->activity++; /* no event, but what stands for its logic wants to follow */
        return true;
    }
    esc->al_control_locked = true;
    ect_esc_raise(esc, ECT_EVENT_AL_CONTROL);
    return true;
}

static void read_al_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    if (access->side != ECT_SIDE_PDI)
        return;
    esc->al_control_locked = false;
    ect_esc_clear(esc, ECT_EVENT_AL_CONTROL);
}

static bool write_al_status(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (emulation(esc))
        return false;
    uint8_t before[2];
    memcpy(before, esc->memory + ECT_REG_AL_STATUS, sizeof before);
    write_plain(esc, access, address, length);
    if (memcmp(before, esc->memory + ECT_REG_AL_STATUS, sizeof before) != 0)
        esc->memory[ECT_REG_LED_RUN] &= 0x0F;
    ect_esc_raise_ecat(esc, ECT_ECAT_EVENT_AL_STATUS);
    return true;
}

static void read_al_status(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    if (access->side == ECT_SIDE_ECAT)
        ect_esc_clear_ecat(esc, ECT_ECAT_EVENT_AL_STATUS);
}

static void read_dl_status(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    if (access->side == ECT_SIDE_ECAT)
        ect_esc_clear_ecat(esc, ECT_ECAT_EVENT_DL_STATUS);
}

static bool write_dl_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    static const uint8_t writable[4] = {0x03, 0xFF, 0x4F, 0x01};
    for (uint16_t i = 0; i < length; i++) {
        uint8_t mask = writable[address - ECT_REG_DL_CONTROL + i];
        uint8_t *reg = esc->memory + address + i;
        *reg = (uint8_t)((*reg & ~mask) | (access->data[i] & mask));
    }
    ect_esc_update_dl_status(esc);
    return true;
}

/* Any write to one of a group of counters clears the group; the value does not matter. */
static bool clear_counters(ect_esc_t *esc, uint16_t first, uint16_t last)
{
    ECT_ASSERT(first <= last && last < ECT_RAM);
    memset(esc->memory + first, 0, (size_t)(last - first) + 1u);
    return true;
}

static bool write_port_errors(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)access;
    (void)address;
    (void)length;
    return clear_counters(esc, ECT_REG_RX_ERROR, ECT_REG_FORWARDED_ERROR + 3);
}

static bool write_processing_error(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)access;
    return clear_counters(esc, address, (uint16_t)(address + length - 1));
}

static bool write_lost_link(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)access;
    (void)address;
    (void)length;
    return clear_counters(esc, ECT_REG_LOST_LINK, ECT_REG_LOST_LINK + 3);
}

static bool write_watchdog_counter(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)access;
    (void)address;
    (void)length;
    return clear_counters(esc, ECT_REG_WD_COUNTER_PD, ECT_REG_WD_COUNTER_PD + 2);
}

static bool write_watchdog_time(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    write_plain(esc, access, address, length);
    ect_esc_watchdog_time_written(esc);
    return true;
}

static void read_watchdog_status(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    if (access->side == ECT_SIDE_PDI)
        ect_esc_clear(esc, ECT_EVENT_WATCHDOG);
}

static bool write_fmmu(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    static const uint8_t writable[ECT_FMMU_SIZE] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x07, 0x07,
                                                    0xFF, 0xFF, 0x07, 0x03, 0x01, 0x00, 0x00, 0x00};
    unsigned int end = ECT_REG_FMMU + ECT_FMMU_SIZE * (unsigned int)esc->config.personality->fmmu_count;
    bool any = false;
    for (uint16_t i = 0; i < length && (unsigned int)address + i < end; i++) {
        uint8_t mask = writable[(unsigned int)(address + i) % ECT_FMMU_SIZE];
        esc->memory[address + i] = access->data[i] & mask;
        any |= mask != 0;
    }
    return any;
}

enum { FMMU_BYTES = ECT_FMMU_SIZE * ECT_ESC_MAX_FMMU, SM_BYTES = ECT_SM_SIZE * ECT_ESC_MAX_SM };

/* Ascending, not overlapping. */
static const block_t blocks[] = {
    {ECT_REG_STATION_ADDRESS, 2, write_plain, NULL, NULL},
    {ECT_REG_STATION_ALIAS, 2, NULL, write_plain, NULL},
    {ECT_REG_DL_CONTROL, 4, write_dl_control, NULL, NULL},
    {ECT_REG_RW_OFFSET, 2, write_plain, NULL, NULL},
    {ECT_REG_DL_STATUS, 2, NULL, NULL, read_dl_status},
    {ECT_REG_AL_CONTROL, 2, write_al_control, NULL, read_al_control},
    {ECT_REG_AL_STATUS, 2, NULL, write_al_status, read_al_status},
    {ECT_REG_AL_STATUS_CODE, 2, NULL, write_plain, NULL},
    {ECT_REG_LED_RUN, 2, write_plain, write_plain, NULL},
    {ECT_REG_ECAT_EVENT_MASK, 2, write_plain, NULL, NULL},
    {ECT_REG_AL_EVENT_MASK, 4, NULL, write_plain, NULL},
    {ECT_REG_RX_ERROR, 12, write_port_errors, NULL, NULL},
    {ECT_REG_PROCESSING_ERROR, 2, write_processing_error, NULL, NULL},
    {ECT_REG_LOST_LINK, 4, write_lost_link, NULL, NULL},
    {ECT_REG_WD_DIVIDER, 2, write_plain, NULL, NULL},
    {ECT_REG_WD_TIME_PDI, 2, write_plain, NULL, NULL},
    {ECT_REG_WD_TIME_PD, 2, write_watchdog_time, NULL, NULL},
    {ECT_REG_WD_STATUS_PD, 2, NULL, NULL, read_watchdog_status},
    {ECT_REG_WD_COUNTER_PD, 3, write_watchdog_counter, NULL, NULL},
    {ECT_REG_SII_CONFIG, 16, ect_esc_sii_write_register, ect_esc_sii_write_register, NULL},
    {ECT_REG_FMMU, FMMU_BYTES, write_fmmu, NULL, NULL},
    {ECT_REG_SM, SM_BYTES, ect_esc_sm_write_register, ect_esc_sm_write_register, ect_esc_sm_read_register},
    {ECT_REG_DC_RECEIVE_TIME, 4, ect_esc_dc_latch, NULL, NULL},
    {ECT_REG_DC_SYSTEM_TIME, 4, ect_esc_dc_compare, NULL, NULL},
    {ECT_REG_DC_OFFSET, 12, ect_esc_dc_write_plain, NULL, NULL},
    {ECT_REG_DC_SPEED_START, 2, ect_esc_dc_write_speed, NULL, NULL},
    {ECT_REG_DC_FILTER, 2, ect_esc_dc_write_plain, NULL, NULL},
    {ECT_REG_DC_CYCLIC_CONTROL, 1, ect_esc_dc_write_plain, NULL, NULL},
    {ECT_REG_DC_ACTIVATION, 1, ect_esc_dc_activate, NULL, NULL},
    {ECT_REG_DC_SYNC0_STATUS, 1, NULL, NULL, ect_esc_dc_acknowledge},
    {ECT_REG_DC_START_TIME, 8, ect_esc_dc_write_plain, NULL, NULL},
    {ECT_REG_DC_SYNC0_CYCLE, 10, ect_esc_dc_write_plain, NULL, NULL},
    {ECT_REG_DIGITAL_OUTPUT, 4, write_plain, NULL, NULL},
    {ECT_REG_GENERAL_OUTPUT, 8, write_plain, write_plain, NULL},
    {ECT_REG_USER_RAM, ECT_RAM - ECT_REG_USER_RAM, write_plain, write_plain, NULL},
};

/* The unit of distributed clocks, but for the receive times, is absent without the feature bit. */
static bool read_registers(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint16_t end = (uint16_t)(address + length);
    uint16_t hole_first = ect_esc_dc_present(esc) ? end : ECT_REG_DC_SYSTEM_TIME;
    uint16_t hole_end = ect_esc_dc_present(esc) ? end : ECT_REG_DC_END;
    uint16_t before = (uint16_t)(end < hole_first ? end : hole_first);
    uint16_t after = (uint16_t)(address > hole_end ? address : hole_end);
    bool any = false;
    if (end > ECT_REG_DC_SYSTEM_TIME && address < ECT_REG_DC_END)
        ect_esc_dc_refresh(esc);
    if (before > address) {
        ect_esc_copy(access, esc->memory + address, 0, (uint16_t)(before - address));
        any = true;
    }
    if (after < end) {
        ect_esc_copy(access, esc->memory + after, (uint16_t)(after - address), (uint16_t)(end - after));
        any = true;
    }
    return any;
}

/* What an access has to do with one block, `from` to `last`. Returns whether a write was taken. */
static bool block_access(ect_esc_t *esc, const block_t *b, const ect_access_t *part, uint16_t from, uint16_t last)
{
    uint16_t size = (uint16_t)(last - from + 1);
    ECT_ASSERT(from >= b->first && from <= last && last < b->first + b->size);
    write_fn write = part->side == ECT_SIDE_ECAT ? b->ecat_write : b->pdi_write;
    if (part->write)
        return write && write(esc, part, from, size);
    if (b->after_read)
        b->after_read(esc, part, from, size);
    return false;
}

bool ect_esc_register_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (length == 0)
        return false;
    ECT_ASSERT((uint32_t)address + length <= ECT_RAM);
    uint16_t last = (uint16_t)(address + length - 1);
    bool any = access->write ? false : read_registers(esc, access, address, length);
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0] && blocks[i].first <= last; i++) {
        const block_t *b = &blocks[i];
        uint16_t block_last = (uint16_t)(b->first + b->size - 1);
        uint16_t from = b->first > address ? b->first : address;
        uint16_t to = block_last < last ? block_last : last;
        if (from > to)
            continue;
        ect_access_t part = ect_esc_slice(access, (uint16_t)(from - address));
        any |= block_access(esc, b, &part, from, to);
    }
    return any;
}
