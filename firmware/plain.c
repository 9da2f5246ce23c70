/* SPDX-License-Identifier: MIT */
/* The device as it is described, in a firmware that takes no updates. */
#include FIRMWARE_DEVICE_HEADER
#include "firmware.h"

const ect_device_t *firmware_described(void)
{
    return &FIRMWARE_DEVICE;
}
