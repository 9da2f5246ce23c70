/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOES's API: an EEPROM emulated by the slave, for ESCs that request its content from the microcontroller (XMC4800, TI
 * ESC).
 *
 * The hardware file provides `EEP_read` and `EEP_write`; the application names ::EEP_process, or a function that calls
 * it, as esc_cfg_t::esc_hw_eep_handler.
 */
#ifndef ECT_SOES_ESC_EEP_H
#define ECT_SOES_ESC_EEP_H

#include "soes/cc.h"

#include "soes/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Commands, bits 8..10 of 0x0502. */
#define EEP_CMD_IDLE   0x0
#define EEP_CMD_READ   0x1
#define EEP_CMD_WRITE  0x2
#define EEP_CMD_RELOAD 0x4

/** Bytes of a write. */
#define EEP_WRITE_SIZE 2

/** Word of the configured station alias. */
#define EEP_CONFIG_ALIAS_WORD_OFFSET 4

/** 0x0502..0x0507. */
typedef struct CC_PACKED {
    union {
        uint16_t reg;
        struct {
            uint8_t wrEnable : 1;
            uint8_t reserved : 4;
            uint8_t eeEmulated : 1;
            uint8_t eightByteRead : 1;
            uint8_t twoByteAddr : 1;

            uint8_t cmdReg : 3;
            uint8_t csumErr : 1;
            uint8_t eeLoading : 1;
            uint8_t ackErr : 1;
            uint8_t wrErr : 1;
            uint8_t busy : 1;
        } bits;
    } contstat;

    uint32_t addr; /**< word address */
} eep_stat_t;

/** Words 0..7 of the SII. */
typedef union eep_config {
    struct {
        uint16_t pdi_control;
        uint16_t pdi_configuration;
        uint16_t sync_impulse_len;
        uint16_t pdi_configuration2;
        uint16_t configured_station_alias;
        uint8_t reserved[4];
        uint16_t checksum;
    };
    uint32_t dword[4];
} eep_config_t;

/** Executes the command of the ESC if ESCvar.ALevent has its event. Cost: 3 PDI accesses for each command. */
void EEP_process(void);

/** Sets the bytes delivered by a read, 8 (initially) or 4; other values have no effect. */
void EEP_set_read_size(uint16_t read_size);

/** Sets a function that handles a reload, and sets the errors in *stat. NULL: a reload gets the requested words. */
void EEP_set_reload_function_pointer(void (*reload_ptr)(eep_stat_t *stat));

/** Functions of the hardware file. `addr` and `size` in bytes; a negative result is a failure. */
void EEP_init(void);
int8_t EEP_read(uint32_t addr, uint8_t *data, uint16_t size);
int8_t EEP_write(uint32_t addr, uint8_t *data, uint16_t size);

ECT_C_END

#endif
