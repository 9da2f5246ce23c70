/* SPDX-License-Identifier: MIT */
/* For our stack, which takes the layout from the device's description: what SOES's API alone would keep memory for is
 * as small as it can be. */
#ifndef FIRMWARE_ECAT_OPTIONS_H
#define FIRMWARE_ECAT_OPTIONS_H

#define USE_FOE         0
#define USE_EOE         0
#define MBXSIZE         1
#define PREALLOC_FACTOR 1

#endif
