/* SPDX-License-Identifier: MIT */
/*
 * The registers as a table: the chips that have them, their reset values, write access for each side, and the effects
 * of writes and reads. An address outside all rows is read-only, and 0 unless the chip sets it; the registers of clocks
 * that a chip lacks do not respond at all.
 */
#include <string.h>

#include "esc/internal.h"

typedef bool (*write_fn)(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
typedef bool (*accept_fn)(const ect_esc_t *esc, uint16_t address, uint16_t length);
typedef void (*read_fn)(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);

typedef struct block {
    uint16_t first;
    uint16_t size;
    uint16_t unit;       /* ECT_UNIT_...; 0: every chip has it */
    uint32_t reset;      /* first bytes, little-endian; further bytes are 0 */
    write_fn ecat_write; /* NULL: read-only for that side; called when the frame has ended */
    write_fn pdi_write;
    read_fn after_read;
    accept_fn ecat_accepts; /* called when the datagram passes, for the working counter; NULL: always */
} block_t;

static bool write_plain(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    ect_esc_copy(access, esc->memory + address, 0, length);
    return true;
}

/* Registers that affect the path of frames, or that frames collect. */
static bool write_routing(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    esc->routing++;
    return write_plain(esc, access, address, length);
}

static bool accepts_al_control(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    (void)address;
    (void)length;
    return !esc->al_control_locked || ect_esc_emulates(esc);
}

static bool write_al_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!accepts_al_control(esc, address, length))
        return false;
    write_plain(esc, access, address, length);
    if (ect_esc_emulates(esc)) {
        memcpy(esc->memory + ECT_REG_AL_STATUS, esc->memory + ECT_REG_AL_CONTROL, 2);
        ect_esc_led_state(esc);
        esc->routing++;
        esc->activity++; /* no event, but the state machine emulation must follow */
        return true;
    }
    esc->al_control_written = true;
    if (esc->lose_al_event)
        esc->lose_al_event = false;
    else
        ect_esc_raise(esc, ECT_EVENT_AL_CONTROL);
    return true;
}

void ect_esc_lose_al_event(ect_esc_t *esc)
{
    esc->lose_al_event = true;
}

/* The lock begins with the end of the frame: the last of several writes in one frame counts. */
void ect_esc_lock_al_control(ect_esc_t *esc)
{
    esc->al_control_locked |= esc->al_control_written;
    esc->al_control_written = false;
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
    if (ect_esc_emulates(esc))
        return false;
    uint8_t before[2];
    memcpy(before, esc->memory + ECT_REG_AL_STATUS, sizeof before);
    write_plain(esc, access, address, length);
    if (memcmp(before, esc->memory + ECT_REG_AL_STATUS, sizeof before) != 0)
        ect_esc_led_state(esc);
    esc->routing++;
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
    ect_esc_port_control(esc, access, address, length);
    return true;
}

static bool write_led(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    ect_esc_led_write(esc, access, address, length);
    return true;
}

/* A write of any value to one counter of a group clears the whole group. */
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
    if (address + length > ECT_REG_PDI_ERROR)
        esc->memory[ECT_REG_PDI_ERROR_CODE] = 0;
    return clear_counters(esc, address, (uint16_t)(address + length - 1));
}

void ect_esc_pdi_error(ect_esc_t *esc, uint8_t code)
{
    ect_esc_count(esc, ECT_REG_PDI_ERROR);
    esc->memory[ECT_REG_PDI_ERROR_CODE] = code;
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

enum { FMMU_BYTES = ECT_FMMU_SIZE * ECT_ESC_MAX_FMMU, SM_BYTES = ECT_SM_SIZE * ECT_ESC_MAX_SM };

/* Ascending, not overlapping. */
static const block_t blocks[] = {
    {ECT_REG_STATION_ADDRESS, 2, 0, 0, write_routing, NULL, NULL, NULL},
    {ECT_REG_STATION_ALIAS, 2, 0, 0, NULL, write_routing, NULL, NULL},
    {ECT_REG_WRITE_ENABLE, 2, ECT_UNIT_PROTECTION, 0, ect_esc_protect_write, NULL, NULL, NULL},
    {ECT_REG_ESC_WRITE_ENABLE, 2, ECT_UNIT_PROTECTION, 0, ect_esc_protect_write, NULL, NULL, NULL},
    {ECT_REG_RESET_ECAT, 1, ECT_UNIT_RESET_ECAT, 0, ect_esc_reset_write, NULL, NULL, NULL},
    {ECT_REG_RESET_PDI, 1, ECT_UNIT_RESET_PDI, 0, NULL, ect_esc_reset_write, NULL, NULL},
    {ECT_REG_DL_CONTROL, 4, 0, 0x00070001, write_dl_control, NULL, NULL, NULL},
    {ECT_REG_RW_OFFSET, 2, 0, 0, write_plain, NULL, NULL, NULL},
    {ECT_REG_DL_STATUS, 2, 0, 0, NULL, NULL, read_dl_status, NULL},
    {ECT_REG_AL_CONTROL, 2, 0, 1, write_al_control, NULL, read_al_control, accepts_al_control},
    {ECT_REG_AL_STATUS, 2, 0, 1, NULL, write_al_status, read_al_status, NULL},
    {ECT_REG_AL_STATUS_CODE, 2, 0, 0, NULL, write_plain, NULL, NULL},
    {ECT_REG_LED_RUN, 1, ECT_UNIT_LED_RUN, 0, write_led, write_led, NULL, NULL},
    {ECT_REG_LED_ERR, 1, ECT_UNIT_LED_ERR, 0, write_led, write_led, NULL, NULL},
    {ECT_REG_ECAT_EVENT_MASK, 2, 0, 0, write_routing, NULL, NULL, NULL},
    {ECT_REG_AL_EVENT_MASK, 4, 0, 0x00FFFF0F, NULL, write_plain, NULL, NULL},
    {ECT_REG_RX_ERROR, 12, 0, 0, write_port_errors, NULL, NULL, NULL},
    {ECT_REG_PROCESSING_ERROR, 2, 0, 0, write_processing_error, NULL, NULL, NULL},
    {ECT_REG_LOST_LINK, 4, 0, 0, write_lost_link, NULL, NULL, NULL},
    {ECT_REG_WD_DIVIDER, 2, 0, 0x09C2, write_watchdog_time, NULL, NULL, NULL},
    {ECT_REG_WD_TIME_PDI, 2, 0, 0x03E8, write_watchdog_time, NULL, NULL, NULL},
    {ECT_REG_WD_TIME_PD, 2, 0, 0x03E8, write_watchdog_time, NULL, NULL, NULL},
    {ECT_REG_WD_STATUS_PD, 2, 0, 0, NULL, NULL, read_watchdog_status, NULL},
    {ECT_REG_WD_COUNTER_PD, 3, 0, 0, write_watchdog_counter, NULL, NULL, NULL},
    {ECT_REG_SII_CONFIG, 16, 0, 0, ect_esc_sii_write_register, ect_esc_sii_write_register, NULL, ect_esc_sii_accepts},
    {ECT_REG_MII_CONTROL, 6, 0, 0, ect_esc_mii_write_register, NULL, NULL, ect_esc_mii_accepts},
    {ECT_REG_FMMU, FMMU_BYTES, 0, 0, ect_esc_fmmu_write_register, NULL, NULL, ect_esc_fmmu_accepts},
    {ECT_REG_SM, SM_BYTES, 0, 0, ect_esc_sm_write_register, ect_esc_sm_write_register, ect_esc_sm_read_register,
     ect_esc_sm_accepts},
    {ECT_REG_DC_RECEIVE_TIME, 4, 0, 0, ect_esc_dc_latch, NULL, NULL, NULL},
    {ECT_REG_DC_SYSTEM_TIME, 4, 0, 0, ect_esc_dc_compare, ect_esc_dc_compare, NULL, ect_esc_dc_accepts},
    {ECT_REG_DC_OFFSET, 12, 0, 0, ect_esc_dc_write_loop, ect_esc_dc_write_loop, NULL, ect_esc_dc_accepts},
    {ECT_REG_DC_SPEED_START, 2, 0, 0x1000, ect_esc_dc_write_speed, ect_esc_dc_write_speed, NULL, ect_esc_dc_accepts},
    {ECT_REG_DC_FILTER, 2, 0, 0x0C04, ect_esc_dc_write_loop, ect_esc_dc_write_loop, NULL, ect_esc_dc_accepts},
    {ECT_REG_DC_LATCH_MODE, 1, ECT_UNIT_LATCH_MODE, 0, write_plain, NULL, NULL, NULL},
    {ECT_REG_DC_CYCLIC_CONTROL, 1, 0, 0, ect_esc_sync_control, NULL, NULL, ect_esc_sync_control_accepts},
    {ECT_REG_DC_ACTIVATION, 1, 0, 0, ect_esc_sync_activate, ect_esc_sync_activate, NULL, ect_esc_sync_start_accepts},
    {ECT_REG_DC_SYNC0_STATUS, 2, 0, 0, NULL, NULL, ect_esc_sync_acknowledge, NULL},
    {ECT_REG_DC_START_TIME, 8, 0, 0, ect_esc_sync_start, ect_esc_sync_start, NULL, ect_esc_sync_start_accepts},
    {ECT_REG_DC_SYNC0_CYCLE, 4, 0, 0, ect_esc_sync_cycle, ect_esc_sync_cycle, NULL, ect_esc_sync_cycle_accepts},
    {ECT_REG_DC_SYNC1_CYCLE, 4, 0, 0, ect_esc_sync_cycle, ect_esc_sync_cycle, NULL, ect_esc_sync_cycle_accepts},
    {ECT_REG_DC_LATCH_CONTROL, 2, 0, 0, ect_esc_latch_control, ect_esc_latch_control, NULL,
     ect_esc_latch_control_accepts},
    {ECT_REG_DC_LATCH_TIME, 32, 0, 0, NULL, NULL, ect_esc_latch_read, NULL},
    {ECT_REG_DIGITAL_OUTPUT, 4, 0, 0, write_plain, NULL, NULL, NULL},
    {ECT_REG_GENERAL_OUTPUT, 8, 0, 0, write_plain, write_plain, NULL, NULL},
    {ECT_REG_USER_RAM, ECT_RAM - ECT_REG_USER_RAM, 0, 0, write_plain, write_plain, NULL, NULL},
};

enum { BLOCKS = sizeof blocks / sizeof blocks[0] };

/* Clocks that the chip lacks cannot be read; any other absent unit reads as 0. */
void ect_esc_registers_reset(ect_esc_t *esc)
{
    for (size_t i = 0; i < BLOCKS; i++) {
        const block_t *b = &blocks[i];
        for (unsigned int byte = 0; b->reset != 0 && byte < b->size && byte < 4; byte++)
            esc->memory[b->first + byte] = (uint8_t)(b->reset >> (8 * byte));
    }
}

/* Without the feature bit the chip lacks all DC registers except the receive times. */
static bool read_registers(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint16_t end = (uint16_t)(address + length);
    uint16_t hole_first = ect_esc_dc_present(esc) ? end : ECT_REG_DC_SYSTEM_TIME;
    uint16_t hole_end = ect_esc_dc_present(esc) ? end : ECT_REG_DC_END;
    uint16_t before = (uint16_t)(end < hole_first ? end : hole_first);
    uint16_t after = (uint16_t)(address > hole_end ? address : hole_end);
    bool any = false;
    if (end > ECT_REG_DC_SYSTEM_TIME && address < ECT_REG_DC_END)
        ect_esc_dc_refresh(esc, access->side, address, end);
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

/* Executes the part of an access in one block, `from` to `last`. @return whether a write was accepted */
static bool block_access(ect_esc_t *esc, const block_t *b, const ect_access_t *part, uint16_t from, uint16_t last)
{
    uint16_t size = (uint16_t)(last - from + 1);
    ECT_ASSERT(from >= b->first && from <= last && last < b->first + b->size);
    if (b->unit != 0 && !ect_esc_has(esc, b->unit))
        return false;
    write_fn write = part->side == ECT_SIDE_ECAT ? b->ecat_write : b->pdi_write;
    if (part->stage == ECT_STAGE_ASKS)
        return write && (!b->ecat_accepts || b->ecat_accepts(esc, from, size));
    if (part->write)
        return write && write(esc, part, from, size);
    if (b->after_read)
        b->after_read(esc, part, from, size);
    return false;
}

/* The first row that ends behind an address. */
static size_t first_block(uint16_t address)
{
    size_t low = 0, high = BLOCKS;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (blocks[middle].first + blocks[middle].size <= address)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

bool ect_esc_register_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (length == 0)
        return false;
    ECT_ASSERT((uint32_t)address + length <= ECT_RAM);
    uint16_t last = (uint16_t)(address + length - 1);
    bool any = access->write ? false : read_registers(esc, access, address, length);
    for (size_t i = first_block(address); i < BLOCKS && blocks[i].first <= last; i++) {
        const block_t *b = &blocks[i];
        uint16_t block_last = (uint16_t)(b->first + b->size - 1);
        uint16_t from = b->first > address ? b->first : address;
        uint16_t to = block_last < last ? block_last : last;
        ect_access_t part = ect_esc_slice(access, (uint16_t)(from - address));
        any |= block_access(esc, b, &part, from, to);
    }
    return any;
}
