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
    uint16_t last;
    write_fn ecat_write; /* NULL: read-only for that side */
    write_fn pdi_write;
    read_fn after_read;
} block_t;

static bool write_plain(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    ect_esc_copy(access, esc->memory + address, 0, length);
    return true;
}

static bool write_al_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    bool emulation = (esc->memory[ECT_REG_PDI_CONTROL + 1] & 0x01) != 0;
    if (esc->al_control_locked && !emulation)
        return false;
    write_plain(esc, access, address, length);
    if (emulation) {
        memcpy(esc->memory + ECT_REG_AL_STATUS, esc->memory + ECT_REG_AL_CONTROL, 2);
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
    if ((esc->memory[ECT_REG_PDI_CONTROL + 1] & 0x01) != 0)
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

/* 0 switches it off, and what is off has not expired. */
static bool write_watchdog_time(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    write_plain(esc, access, address, length);
    if (ect_load_le16(esc->memory + ECT_REG_WD_TIME_PD) == 0) {
        esc->memory[ECT_REG_WD_STATUS_PD] = 1;
        esc->watchdog_ns = UINT64_MAX;
    }
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

/* Ascending, not overlapping. */
static const block_t blocks[] = {
    {0x0010, 0x0011, write_plain, NULL, NULL},
    {0x0012, 0x0013, NULL, write_plain, NULL},
    {0x0100, 0x0103, write_dl_control, NULL, NULL},
    {0x0108, 0x0109, write_plain, NULL, NULL},
    {0x0110, 0x0111, NULL, NULL, read_dl_status},
    {0x0120, 0x0121, write_al_control, NULL, read_al_control},
    {0x0130, 0x0131, NULL, write_al_status, read_al_status},
    {0x0134, 0x0135, NULL, write_plain, NULL},
    {0x0138, 0x0139, write_plain, write_plain, NULL},
    {0x0200, 0x0201, write_plain, NULL, NULL},
    {0x0204, 0x0207, NULL, write_plain, NULL},
    {0x0300, 0x030B, write_port_errors, NULL, NULL},
    {0x030C, 0x030D, write_processing_error, NULL, NULL},
    {0x0310, 0x0313, write_lost_link, NULL, NULL},
    {0x0400, 0x0401, write_plain, NULL, NULL},
    {0x0410, 0x0411, write_plain, NULL, NULL},
    {0x0420, 0x0421, write_watchdog_time, NULL, NULL},
    {0x0440, 0x0441, NULL, NULL, read_watchdog_status},
    {0x0442, 0x0444, write_watchdog_counter, NULL, NULL},
    {0x0500, 0x050F, ect_esc_sii_write_register, ect_esc_sii_write_register, NULL},
    {0x0600, 0x067F, write_fmmu, NULL, NULL},
    {0x0800, 0x083F, ect_esc_sm_write_register, ect_esc_sm_write_register, ect_esc_sm_read_register},
    {0x0900, 0x0903, ect_esc_dc_latch, NULL, NULL},
    {0x0910, 0x0913, ect_esc_dc_compare, NULL, NULL},
    {0x0920, 0x092B, ect_esc_dc_write_plain, NULL, NULL},
    {0x0930, 0x0931, ect_esc_dc_write_speed, NULL, NULL},
    {0x0934, 0x0935, ect_esc_dc_write_plain, NULL, NULL},
    {0x0980, 0x0980, ect_esc_dc_write_plain, NULL, NULL},
    {0x0981, 0x0981, ect_esc_dc_activate, NULL, NULL},
    {0x098E, 0x098E, NULL, NULL, ect_esc_dc_acknowledge},
    {0x0990, 0x0997, ect_esc_dc_write_plain, NULL, NULL},
    {0x09A0, 0x09A9, ect_esc_dc_write_plain, NULL, NULL},
    {0x0F00, 0x0F03, write_plain, NULL, NULL},
    {0x0F10, 0x0F17, write_plain, write_plain, NULL},
    {0x0F80, 0x0FFF, write_plain, write_plain, NULL},
};

/* The unit of distributed clocks, but for the receive times, is absent without the feature bit. */
enum { DC_FIRST = 0x0910, DC_END = 0x0A00 };

static bool read_registers(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint16_t end = (uint16_t)(address + length);
    uint16_t hole_first = ect_esc_dc_present(esc) ? end : DC_FIRST;
    uint16_t hole_end = ect_esc_dc_present(esc) ? end : DC_END;
    uint16_t before = (uint16_t)(end < hole_first ? end : hole_first);
    uint16_t after = (uint16_t)(address > hole_end ? address : hole_end);
    bool any = false;
    if (end > DC_FIRST && address < DC_END)
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

bool ect_esc_register_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (length == 0)
        return false;
    uint16_t last = (uint16_t)(address + length - 1);
    bool any = access->write ? false : read_registers(esc, access, address, length);
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) {
        const block_t *b = &blocks[i];
        if (b->first > last)
            break;
        if (b->last < address)
            continue;
        uint16_t from = b->first > address ? b->first : address;
        uint16_t to = b->last < last ? b->last : last;
        ect_access_t part = *access;
        part.data += from - address;
        if (part.mask)
            part.mask += from - address;
        uint16_t size = (uint16_t)(to - from + 1);
        write_fn write = access->side == ECT_SIDE_ECAT ? b->ecat_write : b->pdi_write;
        if (access->write && write)
            any |= write(esc, &part, from, size);
        else if (!access->write && b->after_read)
            b->after_read(esc, &part, from, size);
    }
    return any;
}
