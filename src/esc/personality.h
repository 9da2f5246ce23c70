/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Which chip the software ESC pretends to be: the read-only registers 0x0000..0x0009 and what follows from them.
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
    ECT_FEATURE_NO_LRW = 0x0200,
    ECT_FEATURE_NO_RW = 0x0400,
};

typedef struct ect_esc_personality {
    const char *name;     /**< what a device description asks for */
    uint8_t type;         /**< 0x0000 */
    uint8_t revision;     /**< 0x0001 */
    uint16_t build;       /**< 0x0002 */
    uint8_t fmmu_count;   /**< 1..8 */
    uint8_t sm_count;     /**< 1..8 */
    uint8_t ram_kb;       /**< 1..60 */
    uint8_t port_types;   /**< 0x0007: two bits a port, 3 MII, 2 EBUS, 0 absent */
    uint16_t features;    /**< ECT_FEATURE_... */
    uint8_t sii_read;     /**< bytes that one SII read delivers: 4 or 8 */
    uint32_t sii_read_ns; /**< how long busy lasts for a read; 0: finished at once */
    uint32_t sii_write_ns;
} ect_esc_personality_t;

/**
 * Looks a personality up by name: "np40" (HMS NP40: 4 FMMUs, 4 SyncManagers, 16 KB), "et1100" (8/8, 8 KB),
 * "lan9252" (3/4, 4 KB), "ipcore" (a customer's IP core at its largest: 8/8, 60 KB).
 * @return constant data, or NULL when there is none of that name.
 */
const ect_esc_personality_t *ect_esc_personality(const char *name);

/** Those that there are, i from 0. @return NULL after the last */
const ect_esc_personality_t *ect_esc_personality_at(size_t i);

ECT_C_END

#endif
