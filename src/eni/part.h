/* SPDX-License-Identifier: MIT */
/** @file
 * A slave for the writer of network files (eni/write.h). */
#ifndef ECT_ENI_PART_H
#define ECT_ENI_PART_H

#include <stddef.h>
#include <stdint.h>

#include "seams/device.h"

/** A slave. */
typedef struct ect_eni_part {
    const ect_device_t *device; /**< valid by ect_device_check() */
    ect_identity_t identity;
    uint16_t alias;             /**< 0: none */
    size_t up;                  /**< position of the neighbour towards the master; ignored if `up_port` is 0 */
    uint8_t up_port;            /**< port of the neighbour, 1 to 3; 0: port 1 of the previous slave */
    const ect_dc_mode_t *clock; /**< mode of the distributed clocks; NULL: not synchronised */
    const char *group;          /**< name of the hot-connect group that begins with this slave; NULL: none */
    unsigned int members;       /**< slaves of the group, at least 1 */
} ect_eni_part_t;

#endif
