/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Which chip the software ESC pretends to be: the read-only registers 0x0000..0x0009, which registers there are, how
 * long things take. A chip is one constant value; nothing else in here knows a chip by its name.
 *
 * What stands in the tables comes from the makers' data sheets and from real chips that were read out over the bus
 * (docs/CHIPS.md says which is which). A register that a chip lacks is read as 0 and cannot be written; those of
 * absent clocks do not answer at all.
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
    ECT_FEATURE_FCS = 0x0080,      /**< errors that another chip has found are counted apart (0x0308) */
    ECT_FEATURE_SYNC = 0x0100,     /**< enhanced activation of SYNC: 0x0981 bits 3 to 7, 0x0984 */
    ECT_FEATURE_NO_LRW = 0x0200,
    ECT_FEATURE_NO_RW = 0x0400,
    ECT_FEATURE_SEQUENTIAL = 0x1000, /**< SyncManagers that want to be written from start to end (control bit 7) */
};

/** Registers that some chips have and others lack: ect_esc_personality_t::units. */
enum {
    ECT_UNIT_PROTECTION = 0x0001,      /**< write protection, 0x0020..0x0031 */
    ECT_UNIT_RESET_ECAT = 0x0002,      /**< 0x0040 */
    ECT_UNIT_RESET_PDI = 0x0004,       /**< 0x0041 */
    ECT_UNIT_LED_RUN = 0x0008,         /**< 0x0138 */
    ECT_UNIT_LED_ERR = 0x0010,         /**< 0x0139 */
    ECT_UNIT_PDI_INFORMATION = 0x0020, /**< 0x014E */
    ECT_UNIT_SII_EMULATION = 0x0080,   /**< the PDI may stand for the EEPROM (0x0502 bit 5) */
    ECT_UNIT_LATCH_MODE = 0x0100,      /**< receive times taken by the next frame, or the last one: 0x0936 */
    ECT_UNIT_SM_TIMES = 0x0200,        /**< SyncManager events latch times, 0x09F0..0x09FF */
    ECT_UNIT_LATCH_PIN = 0x0400,       /**< level of the latch inputs in 0x09AE and 0x09AF bit 2 */
};

typedef struct ect_esc_personality {
    const char *name;   /**< what a device description asks for */
    uint8_t type;       /**< 0x0000 */
    uint8_t revision;   /**< 0x0001 */
    uint16_t build;     /**< 0x0002 */
    uint8_t fmmu_count; /**< 1..8 */
    uint8_t sm_count;   /**< 1..8 */
    uint8_t ram_kb;     /**< 1..60 */
    uint8_t port_types; /**< 0x0007 of a device with an input and an output: two bits a port, 3 MII, 2 EBUS, 0 absent */
    uint8_t ports;      /**< ports that the chip may have: bit n for port n */
    uint16_t features;  /**< ECT_FEATURE_... */
    uint16_t units;     /**< ECT_UNIT_... */
    uint8_t sii_read;   /**< bytes that one SII read delivers: 4 or 8 */
    uint32_t sii_read_ns; /**< how long busy lasts for a read; 0: finished at once */
    uint32_t sii_write_ns;
    uint16_t processing_ns; /**< from a frame's arrival at port 0, through the processing unit, to the next port */
    uint16_t forwarding_ns; /**< from its arrival at another port, past the processing unit, to the next port */
} ect_esc_personality_t;

/**
 * Looks a personality up by name:
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
 * @return constant data, or NULL when there is none of that name.
 */
const ect_esc_personality_t *ect_esc_personality(const char *name);

/** Those that there are, i from 0. @return NULL after the last */
const ect_esc_personality_t *ect_esc_personality_at(size_t i);

ECT_C_END

#endif
