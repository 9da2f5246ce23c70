/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A base unit in memory, and where the fields of TS-0007 chapters 8 and 9 stand in the process data.
 */
#ifndef ECT_DEVICES_ECLINK_INSTANCE_H
#define ECT_DEVICES_ECLINK_INSTANCE_H

#include "seams/standard.h"

enum { ECLINK_INPUT_BYTES = 142, ECLINK_OUTPUT_BYTES = 228, ECLINK_PERIODIC_BYTES = 200 };

/** Offsets in the input data (TS-0007 §8). */
enum {
    ECLINK_IN_PCI = 0,
    ECLINK_IN_CCI = 1,
    ECLINK_IN_PAI = 2,
    ECLINK_IN_CAI = 3,
    ECLINK_IN_COMMAND_RU = 4,
    ECLINK_IN_COMMAND = 6,
    ECLINK_IN_BU_STATE = 22,
    ECLINK_IN_VLAPS = 23,
    ECLINK_IN_UNARMED = 24,
    ECLINK_IN_EG_LINK = 25,
    ECLINK_IN_EC_LINK = 26,
    ECLINK_IN_RU = 28, /* first remote; the second and third follow at this stride */
    ECLINK_IN_RU_STRIDE = 38,
};

/** Offsets in the output data (TS-0007 §9). */
enum {
    ECLINK_OUT_PCO = 0,
    ECLINK_OUT_CCO = 1,
    ECLINK_OUT_PAO = 2,
    ECLINK_OUT_CAO = 3,
    ECLINK_OUT_COMMAND_RU = 4,
    ECLINK_OUT_COMMAND = 6,
    ECLINK_OUT_PERIODIC_SIZE = 24,
    ECLINK_OUT_PERIODIC_BLOCK = 26,
    ECLINK_OUT_PERIODIC = 28,
};

typedef struct eclink {
    ect_standard_t standard;
    uint8_t inputs[ECLINK_INPUT_BYTES];
    uint8_t outputs[ECLINK_OUTPUT_BYTES];
    uint8_t input_numbers[ECLINK_INPUT_BYTES]; /* 3001h: the same fields in the host's byte order */
    uint8_t output_numbers[ECLINK_OUT_PERIODIC];
    uint64_t update_ns; /* when PCI counts next */
} eclink_t;

void eclink_init(void *instance, const ect_identity_t *identity, const ect_host_t *host, uint64_t now_ns);
void eclink_outputs(void *instance, uint64_t now_ns);
uint64_t eclink_tick(void *instance, uint64_t now_ns);
void eclink_sdo_read(void *instance, uint16_t index);

#endif
