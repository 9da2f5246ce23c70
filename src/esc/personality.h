/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Kind of chip that the software ESC models: the read-only registers 0x0000..0x0009, the registers that exist, and the
 * duration of operations. A chip is one constant value; no other code depends on the name of a chip.
 *
 * The tables contain facts from the manufacturers' data sheets and from real chips whose registers were read over the
 * bus (docs/CHIPS.md names the source of each). A register that a chip lacks reads as 0 and cannot be written; the
 * registers of absent distributed clocks do not respond at all.
 */
#ifndef ECT_ESC_PERSONALITY_H
#define ECT_ESC_PERSONALITY_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Bits of the feature word (0x0008), ESC data sheet II §2.1.8. */
enum {
    ECT_FEATURE_BYTE_FMMU = 0x0001,
    ECT_FEATURE_NO_UNUSED_REGISTERS = 0x0002,
    ECT_FEATURE_DC = 0x0004,
    ECT_FEATURE_DC64 = 0x0008,
    ECT_FEATURE_EBUS = 0x0030,     /**< low jitter, and enhanced link detection at an EBUS port */
    ECT_FEATURE_LINK_MII = 0x0040, /**< enhanced link detection at an MII port */
    ECT_FEATURE_FCS = 0x0080,      /**< errors that another chip has detected are counted separately (0x0308) */
    ECT_FEATURE_SYNC = 0x0100,     /**< enhanced activation of SYNC: 0x0981 bits 3 to 7, 0x0984 */
    ECT_FEATURE_NO_LRW = 0x0200,
    ECT_FEATURE_NO_RW = 0x0400,
    ECT_FEATURE_SEQUENTIAL = 0x1000, /**< SyncManagers with sequential mode (control bit 7) */
};

/** Registers that only some chips have: ect_esc_personality_t::units. */
enum {
    ECT_UNIT_PROTECTION = 0x0001,      /**< write protection, 0x0020..0x0031 */
    ECT_UNIT_RESET_ECAT = 0x0002,      /**< 0x0040 */
    ECT_UNIT_RESET_PDI = 0x0004,       /**< 0x0041 */
    ECT_UNIT_LED_RUN = 0x0008,         /**< 0x0138 */
    ECT_UNIT_LED_ERR = 0x0010,         /**< 0x0139 */
    ECT_UNIT_PDI_INFORMATION = 0x0020, /**< 0x014E */
    ECT_UNIT_SII_EMULATION = 0x0080,   /**< the PDI can emulate the EEPROM (0x0502 bit 5) */
    ECT_UNIT_LATCH_MODE = 0x0100,      /**< receive times latched by the next frame, or the last one: 0x0936 */
    ECT_UNIT_SM_TIMES = 0x0200,        /**< SyncManager events latch times, 0x09F0..0x09FF */
    ECT_UNIT_LATCH_PIN = 0x0400,       /**< level of the latch inputs in 0x09AE and 0x09AF bit 2 */
};

typedef struct ect_esc_personality {
    const char *name;   /**< name in a device description (ect_device_t::esc) */
    uint8_t type;       /**< 0x0000 */
    uint8_t revision;   /**< 0x0001 */
    uint16_t build;     /**< 0x0002 */
    uint8_t fmmu_count; /**< 1..8 */
    uint8_t sm_count;   /**< 1..8 */
    uint8_t ram_kb;     /**< 1..60 */
    uint8_t
        port_types; /**< 0x0007 of a device with one input and one output: two bits a port, 3 MII, 2 EBUS, 0 absent */
    uint8_t ports;  /**< ports that the chip may have: bit n for port n */
    uint16_t features;      /**< ECT_FEATURE_... */
    uint16_t units;         /**< ECT_UNIT_... */
    uint8_t sii_read;       /**< bytes that one SII read delivers: 4 or 8 */
    uint16_t processing_ns; /**< delay of a frame from port 0 through the processing unit to the next port */
    uint16_t forwarding_ns; /**< delay from another port, past the processing unit, to the next port */
} ect_esc_personality_t;

/**
 * Finds a personality by its name.
 *
 * | name | chip | FMMUs, SyncManagers, RAM |
 * |---|---|---|
 * | et1100, et1200 | Beckhoff's | 8, 8, 8 KB; 3, 4, 1 KB |
 * | lan9252, lan9253 | Microchip's | 3, 4, 4 KB; 8, 8, 8 KB |
 * | xmc4800 | Infineon's microcontroller | 8, 8, 8 KB |
 * | np40 | HMS's | 4, 4, 16 KB |
 * | ax58100 | ASIX's | 8, 8, 9 KB |
 * | ipcore | Beckhoff's IP core at its largest | 8, 8, 60 KB |
 * | ipcore-small | an IP core without clocks | 3, 4, 4 KB |
 *
 * @return constant data, or NULL when no chip has this name
 */
const ect_esc_personality_t *ect_esc_personality(const char *name);

/** All personalities, by position from 0. @return NULL after the last one */
const ect_esc_personality_t *ect_esc_personality_at(size_t i);

ECT_C_END

#endif
