/* SPDX-License-Identifier: MIT */
/** @file
 * A slave of a network file that is written. */
#ifndef ECT_ENI_PART_H
#define ECT_ENI_PART_H

#include <stddef.h>
#include <stdint.h>

#include "seams/device.h"

/** A slave of a file. */
typedef struct ect_eni_part {
    const ect_device_t *device; /**< one that ect_device_check() has no objection to */
    ect_identity_t identity;
    uint16_t alias;  /**< 0: none */
    size_t up;       /**< with `up_port` not 0: position of the slave towards the master */
    uint8_t up_port; /**< its port, 1 to 3; 0: port 1 of the slave before this one */
} ect_eni_part_t;

#endif
