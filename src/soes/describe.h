/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The description of a slave, made from the object list and the `ecat_options.h` of a SOES application.
 *
 * describe.c is compiled with the application, with the headers of this folder or with SOES's own, so this header
 * includes neither.
 */
#ifndef ECT_SOES_DESCRIBE_H
#define ECT_SOES_DESCRIBE_H

#include "seams/device.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Describes the application: identity and name from 1018h and 1008h, SyncManagers and mailboxes from its options, its
 * objects unchanged; SYNC0 if the application checks the master's settings of the clocks. The caller adds behaviour,
 * protocols and the instance.
 * @param[out] device  refers to SDOobjects; the caller's memory
 * Context: any, after ESC_config. Cost: a walk over the object list.
 */
void ect_soes_describe(ect_device_t *device);

ECT_C_END

#endif
