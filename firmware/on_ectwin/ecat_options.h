/* SPDX-License-Identifier: MIT */
/* For ectwin's stack, which takes the layout from the device's description: memory used only by SOES's API is minimal.
 */
#ifndef FIRMWARE_ECAT_OPTIONS_H
#define FIRMWARE_ECAT_OPTIONS_H

#define USE_FOE         0
#define USE_EOE         0
#define MBXSIZE         1
#define PREALLOC_FACTOR 1

#endif
