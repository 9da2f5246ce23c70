/* SPDX-License-Identifier: MIT */
/* The unchanged device, in a firmware without updates. */
#include FIRMWARE_DEVICE_HEADER
#include "firmware.h"

const ect_device_t *firmware_described(void)
{
    return &FIRMWARE_DEVICE;
}
