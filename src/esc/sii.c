/* SPDX-License-Identifier: MIT */
/*
 * The SII EEPROM interface, 0x0500..0x050F: ownership, commands with their busy time and error bits, and the
 * configuration that the chip itself loads from the first words at power-on and on reload (data sheet I §11).
 */
#include <string.h>

#include "esc/internal.h"
#include "wire/crc.h"

enum {
    WRITE_ENABLE = 0x0001,
    NOT_PRESENT = 0x0008,
    EMULATION = 0x0020,
    READ_8_BYTES = 0x0040,
    TWO_ADDRESS_BYTES = 0x0080,
    COMMAND = 0x0700,
    CHECKSUM_ERROR = 0x0800,
    NOT_LOADED = 0x1000,
    COMMAND_ERROR = 0x2000,
    WRITE_ENABLE_ERROR = 0x4000,
    BUSY = 0x8000,
};

/* Longest time that an EEPROM of this kind needs to store a word. */
enum { REST_NS = 5000000 };

enum { COMMAND_IDLE = 0, COMMAND_READ = 1, COMMAND_WRITE = 2, COMMAND_RELOAD = 4 };

static uint8_t *reg(const ect_esc_t *esc, uint16_t address)
{
    return esc->memory + address;
}

static uint16_t status(const ect_esc_t *esc)
{
    return ect_load_le16(reg(esc, ECT_REG_SII_CONTROL));
}

static void set_status(ect_esc_t *esc, unsigned int value)
{
    ect_store_le16(reg(esc, ECT_REG_SII_CONTROL), (uint16_t)value);
}

static bool checksum_good(const uint8_t *sii)
{
    if (ect_load_le16(sii + 14) == 0x88A4) /* check value disabled, for debugging */
        return true;
    return ect_crc_sii(sii) == sii[ECT_SII_CHECKED_BYTES];
}

static bool reads_8(const ect_esc_t *esc)
{
    return esc->config.personality->sii_read == 8;
}

/* Loads the configuration from the first seven words. */
static void take_words(ect_esc_t *esc, const uint8_t *words, bool power_on)
{
    memcpy(reg(esc, ECT_REG_PDI_CONTROL), words, 2);
    memcpy(reg(esc, ECT_REG_PDI_CONFIG), words + 2, 2);
    memcpy(reg(esc, ECT_REG_DC_PULSE_LENGTH), words + 4, 2);
    memcpy(reg(esc, ECT_REG_PDI_EXTENDED), words + 6, 2);
    memcpy(reg(esc, ECT_REG_PDI_INFORMATION), words + 10, 2);
    memcpy(reg(esc, ECT_REG_PDI_INFORMATION_2), words + 12, 2);
    if (power_on)
        memcpy(reg(esc, ECT_REG_STATION_ALIAS), words + 8, 2);
    ect_esc_sync_moved(esc); /* the event bits and the length of pulses may have changed */
}

/* Updates the rest of the chip, once it is known whether there is a configuration. */
static void loaded(ect_esc_t *esc, bool valid)
{
    enum { AREA_LOADED = 0x02, PDI_ACTIVE = 0x04 };
    esc->sii_valid = valid;
    if (ect_esc_has(esc, ECT_UNIT_PDI_INFORMATION))
        *reg(esc, ECT_REG_PDI_STATE) = valid ? AREA_LOADED | PDI_ACTIVE : 0;
    ect_esc_update_dl_status(esc);
    ect_esc_led_errors(esc);
}

/* Without an EEPROM, the PDI must deliver the configuration from power-on on. */
static void request_reload(ect_esc_t *esc)
{
    esc->sii_command = COMMAND_RELOAD;
    set_status(esc, (status(esc) & WRITE_ENABLE) | EMULATION | NOT_LOADED | BUSY |
                        (reads_8(esc) ? (unsigned int)READ_8_BYTES : 0u) | (unsigned int)COMMAND_RELOAD << 8);
    ect_esc_raise(esc, ECT_EVENT_SII);
    loaded(esc, false);
}

void ect_esc_sii_load(ect_esc_t *esc, bool power_on)
{
    const uint8_t *sii = esc->config.sii;
    unsigned int flags = (reads_8(esc) ? (unsigned int)READ_8_BYTES : 0u) |
                         (esc->config.sii_size >= 4096 ? (unsigned int)TWO_ADDRESS_BYTES : 0u);
    if (esc->config.sii_emulated) {
        request_reload(esc);
        return;
    }
    bool valid = sii != NULL && esc->config.sii_size >= 16 && checksum_good(sii);
    if (!sii)
        flags |= NOT_PRESENT | NOT_LOADED;
    else if (!valid)
        flags |= CHECKSUM_ERROR | NOT_LOADED;
    set_status(esc, flags | (status(esc) & WRITE_ENABLE));
    if (valid)
        take_words(esc, sii, power_on);
    loaded(esc, valid);
}

/* Cells beyond the end read as erased. */
static uint8_t sii_byte(const ect_esc_t *esc, uint64_t offset)
{
    return offset < esc->config.sii_size ? esc->config.sii[offset] : 0xFF;
}

static void flip_bits(ect_esc_t *esc, uint8_t *data)
{
    for (unsigned int i = 0; i < esc->config.personality->sii_read; i += 2)
        data[i + esc->sii_fault_bit / 8] ^= (uint8_t)(1u << esc->sii_fault_bit % 8);
}

static void finish(ect_esc_t *esc)
{
    uint64_t offset = (uint64_t)ect_load_le32(reg(esc, ECT_REG_SII_ADDRESS)) * 2u;
    uint8_t *data = reg(esc, ECT_REG_SII_DATA);
    uint8_t command = esc->sii_command;
    ECT_ASSERT(command == COMMAND_READ || command == COMMAND_WRITE || command == COMMAND_RELOAD);
    esc->sii_command = COMMAND_IDLE;
    set_status(esc, status(esc) & ~(unsigned int)(BUSY | COMMAND));
    if (esc->sii_fault == ECT_SII_NO_ANSWER || esc->sii_unacknowledged) {
        set_status(esc, status(esc) | COMMAND_ERROR);
        return;
    }
    if (command == COMMAND_READ) {
        for (unsigned int i = 0; i < esc->config.personality->sii_read; i++)
            data[i] = sii_byte(esc, offset + i);
        if (esc->sii_fault == ECT_SII_BIT_ERROR)
            flip_bits(esc, data);
    } else if (command == COMMAND_WRITE) {
        if (offset < esc->config.sii_size) /* always even */
            memcpy(esc->config.sii + offset, data, 2);
        esc->sii_writes++;
        esc->sii_rest_ns = esc->config.sii_command_ns == ECT_ESC_SII_I2C ? esc->now_ns + REST_NS : 0;
    } else {
        ect_esc_sii_load(esc, false);
    }
}

/* A command that the PDI executes ends when the PDI reports so. */
void ect_esc_sii_tick(ect_esc_t *esc)
{
    if (esc->sii_command == COMMAND_IDLE || esc->config.sii_emulated || esc->sii_fault == ECT_SII_BUSY)
        return;
    if (esc->now_ns >= esc->sii_done_ns)
        finish(esc);
    else
        ect_esc_expect(esc, esc->sii_done_ns);
}

void ect_esc_sii_fault(ect_esc_t *esc, ect_sii_fault_t fault, unsigned int bit)
{
    ECT_ASSERT(fault != ECT_SII_BIT_ERROR || bit < 16);
    esc->sii_fault = (uint8_t)fault;
    esc->sii_fault_bit = (uint8_t)bit;
    if (esc->sii_command != COMMAND_IDLE && !esc->config.sii_emulated)
        ect_esc_expect(esc, esc->now_ns);
}

/* Clock periods of an I²C transfer: 9 for each byte, one for each start and stop condition. A read sends the address,
 * and the control byte again; a larger EEPROM has one more byte of address. */
static uint64_t i2c_time(const ect_esc_t *esc, uint8_t command)
{
    enum { PERIOD_NS = 6720, CONFIGURATION = 16 };
    unsigned int bytes = 2 + ((status(esc) & TWO_ADDRESS_BYTES) != 0 ? 1u : 0u);
    unsigned int conditions = 2;
    if (esc->sii_unacknowledged)
        return 11 * PERIOD_NS; /* start, control byte, stop */
    if (command == COMMAND_WRITE) {
        bytes += 2;
    } else {
        bytes += 1u + (command == COMMAND_READ ? esc->config.personality->sii_read : (unsigned int)CONFIGURATION);
        conditions++;
    }
    return (uint64_t)PERIOD_NS * (9u * bytes + conditions);
}

static uint64_t duration(const ect_esc_t *esc, uint8_t command)
{
    uint32_t fixed_ns = esc->config.sii_command_ns;
    return fixed_ns == ECT_ESC_SII_I2C ? i2c_time(esc, command) : fixed_ns;
}

/* The error bit of a command that is refused, or 0. */
static unsigned int refusal(const ect_esc_t *esc, uint8_t command, bool write_enabled)
{
    if (command != COMMAND_READ && command != COMMAND_WRITE && command != COMMAND_RELOAD)
        return COMMAND_ERROR;
    if (command == COMMAND_WRITE && !write_enabled)
        return WRITE_ENABLE_ERROR;
    return esc->config.sii || esc->config.sii_emulated ? 0 : COMMAND_ERROR;
}

static void start(ect_esc_t *esc, uint8_t command, bool write_enabled)
{
    ECT_ASSERT(esc->sii_command == COMMAND_IDLE);
    unsigned int flags = status(esc) & ~(unsigned int)(COMMAND | COMMAND_ERROR | WRITE_ENABLE_ERROR);
    unsigned int error = command == COMMAND_IDLE ? 0 : refusal(esc, command, write_enabled);
    if (command == COMMAND_IDLE || error != 0) {
        set_status(esc, flags | error);
        return;
    }
    flags |= command == COMMAND_RELOAD ? (unsigned int)NOT_LOADED : 0u;
    set_status(esc, flags | BUSY | ((unsigned int)command << 8));
    esc->sii_command = command;
    esc->sii_unacknowledged = esc->now_ns < esc->sii_rest_ns;
    esc->sii_done_ns = esc->now_ns + duration(esc, command);
    if (esc->config.sii_emulated)
        ect_esc_raise(esc, ECT_EVENT_SII);
    ect_esc_sii_tick(esc);
}

static bool pdi_owns(const ect_esc_t *esc)
{
    return (*reg(esc, ECT_REG_SII_CONFIG) & 1u) != 0 || (*reg(esc, ECT_REG_SII_PDI_ACCESS) & 1u) != 0;
}

static bool write_ownership(ect_esc_t *esc, ect_side_t side, uint16_t address, uint8_t value)
{
    uint8_t *config = reg(esc, ECT_REG_SII_CONFIG);
    uint8_t *pdi = reg(esc, ECT_REG_SII_PDI_ACCESS);
    if (address == ECT_REG_SII_CONFIG && side == ECT_SIDE_ECAT) {
        *config = value & 3u;
        if ((value & 2u) != 0)
            *pdi &= 0xFE;
    } else if (address == ECT_REG_SII_PDI_ACCESS && side == ECT_SIDE_PDI && (*config & 2u) == 0 &&
               ((*config | *pdi) & 1u) != 0) {
        *pdi = value & 1u;
    } else {
        return false;
    }
    ect_esc_sii_end_of_frame(esc);
    return true;
}

/* With 4 bytes of data, the PDI delivers only the alias; with 8, all words, four at a time. */
static void take_reloaded(ect_esc_t *esc)
{
    if (reads_8(esc)) {
        uint32_t first = ect_load_le32(reg(esc, ECT_REG_SII_ADDRESS));
        if (first < 8)
            memcpy(esc->reloaded + 2 * (first & 4), reg(esc, ECT_REG_SII_DATA), 8);
        if (first < 4) { /* the event remains: the rest is requested */
            ect_store_le32(reg(esc, ECT_REG_SII_ADDRESS), 4);
            return;
        }
    }
    bool valid = !reads_8(esc) || checksum_good(esc->reloaded);
    if (valid && reads_8(esc))
        take_words(esc, esc->reloaded, !esc->alias_loaded);
    else if (valid && !esc->alias_loaded)
        memcpy(reg(esc, ECT_REG_STATION_ALIAS), reg(esc, ECT_REG_SII_DATA), 2);
    esc->alias_loaded |= valid;
    set_status(esc, (status(esc) & ~(unsigned int)(NOT_LOADED | CHECKSUM_ERROR | BUSY | COMMAND)) |
                        (valid ? 0u : (unsigned int)(NOT_LOADED | CHECKSUM_ERROR)));
    esc->sii_command = COMMAND_IDLE;
    ect_esc_clear(esc, ECT_EVENT_SII);
    loaded(esc, valid);
}

/* The PDI reports the result of the command under way. */
static void acknowledge(ect_esc_t *esc, uint8_t control)
{
    unsigned int errors = ((unsigned int)control << 8) & (CHECKSUM_ERROR | COMMAND_ERROR);
    if ((control & 7u) != esc->sii_command)
        return;
    if (esc->sii_command == COMMAND_RELOAD && errors == 0) {
        take_reloaded(esc);
        return;
    }
    bool reload = esc->sii_command == COMMAND_RELOAD;
    set_status(esc, (status(esc) & ~(unsigned int)(BUSY | COMMAND)) | errors);
    esc->sii_command = COMMAND_IDLE;
    ect_esc_clear(esc, ECT_EVENT_SII);
    if (reload)
        loaded(esc, false);
}

/* While a command is under way, a PDI that emulates the EEPROM writes the data and acknowledges the command. */
static bool write_reply(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    bool acknowledged = false;
    uint8_t control = 0;
    for (uint16_t i = 0; i < length; i++) {
        uint16_t at = (uint16_t)(address + i);
        if (at == ECT_REG_SII_CONTROL + 1) {
            acknowledged = true;
            control = access->data[i];
        } else if (at >= ECT_REG_SII_DATA && at < ECT_REG_SII_DATA + esc->config.personality->sii_read &&
                   esc->sii_command != COMMAND_WRITE) {
            *reg(esc, at) = access->data[i];
        }
    }
    if (acknowledged)
        acknowledge(esc, control);
    return true;
}

/* Executes a command after all bytes of the access are stored, because address and command may share a datagram. */
static bool write_command_area(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    ECT_ASSERT(address >= ECT_REG_SII_CONTROL && length > 0);
    if (esc->config.sii_emulated && access->side == ECT_SIDE_PDI && (status(esc) & BUSY) != 0)
        return write_reply(esc, access, address, length);
    if (pdi_owns(esc) != (access->side == ECT_SIDE_PDI) || (status(esc) & BUSY) != 0)
        return false;
    bool has_high = false;
    uint8_t high = 0;
    for (uint16_t i = 0; i < length; i++) {
        uint16_t at = (uint16_t)(address + i);
        uint8_t value = access->data[i];
        if (at == ECT_REG_SII_CONTROL) {
            set_status(esc, (status(esc) & ~(unsigned int)WRITE_ENABLE) | (value & 1u));
            esc->per_frame |= ECT_FRAME_END_SII;
        } else if (at == ECT_REG_SII_CONTROL + 1) {
            has_high = true;
            high = value;
        } else {
            *reg(esc, at) = value;
        }
    }
    bool write_enabled = access->side == ECT_SIDE_PDI || (status(esc) & WRITE_ENABLE) != 0;
    if (has_high)
        start(esc, high & 7u, write_enabled);
    if (access->side == ECT_SIDE_PDI)
        ect_esc_sii_end_of_frame(esc);
    return true;
}

bool ect_esc_sii_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    bool ownership = address == ECT_REG_SII_CONFIG;
    bool command_area = (uint32_t)address + length > ECT_REG_SII_CONTROL;
    return ownership || (command_area && !pdi_owns(esc) && (status(esc) & BUSY) == 0);
}

bool ect_esc_sii_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    bool any = false;
    uint16_t done = 0;
    while (done < length && address + done < ECT_REG_SII_CONTROL) {
        any |= write_ownership(esc, access->side, (uint16_t)(address + done), access->data[done]);
        done++;
    }
    if (done < length) {
        ect_access_t rest = *access;
        rest.data += done;
        any |= write_command_area(esc, &rest, (uint16_t)(address + done), (uint16_t)(length - done));
    }
    return any;
}

/* Write enable lasts for one frame; while the PDI owns the interface, the bit reads 1. */
void ect_esc_sii_end_of_frame(ect_esc_t *esc)
{
    unsigned int enabled = pdi_owns(esc) ? WRITE_ENABLE : 0u;
    esc->per_frame &= (uint8_t)~ECT_FRAME_END_SII;
    set_status(esc, (status(esc) & ~(unsigned int)WRITE_ENABLE) | enabled);
}
