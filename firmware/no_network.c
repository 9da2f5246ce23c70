/* SPDX-License-Identifier: MIT */
/* The device in a firmware without a network address. */
#include "firmware.h"

const ect_device_t *firmware_device(void)
{
    return firmware_described();
}
