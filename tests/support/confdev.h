/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A second device made for tests: every object service. Four PDO slots a direction that can be mapped and assigned
 * freely, 10F1h, 10F3h, 1C32h, 1C33h, 1010h, 1011h with two entries that are stored.
 *
 *   7000h:1..4 outputs UNSIGNED8, UNSIGNED16, UNSIGNED32, BOOLEAN     6000h:1..4 inputs, the same types
 *   1600h, 1601h, 1A00h, 1A01h: up to 4 entries, RW in PREOP          1C12h, 1C13h: up to 2 PDOs, RW in PREOP
 *   2100h UNSIGNED32 rw stored, default 100                           2101h OCTET_STRING[40] rw stored
 * Defaults: 1600h = 7000h:1; 1A00h = 6000h:1, 6000h:2; 1C12h = 1600h; 1C13h = 1A00h. SM2 1200h/1 (at most 16 bytes),
 * SM3 1300h/3 (at most 16). SYNC0 cycles 1 and 2 ms.
 */
#ifndef TESTS_SUPPORT_CONFDEV_H
#define TESTS_SUPPORT_CONFDEV_H

#include "seams/standard.h"

typedef struct confdev {
    ect_standard_t standard;
    uint8_t count_1600, count_1601, count_1a00, count_1a01, count_1c12, count_1c13;
    uint32_t map_1600[4], map_1601[4], map_1a00[4], map_1a01[4];
    uint16_t assign_1c12[2], assign_1c13[2];
    uint8_t out_u8, in_u8, out_bool, in_bool;
    uint16_t out_u16, in_u16;
    uint32_t out_u32, in_u32;
    uint32_t stored;
    uint8_t stored_octets[40];
    ect_diagnosis_t diagnosis;
    ect_sync_data_t sync;
    const ect_host_t *host;
} confdev_t;

extern const ect_device_t confdev;

#endif
