/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A description of a slave made from what a SOES application has: its object list and its `ecat_options.h`.
 *
 * describe.c is compiled with the application, against our headers or against SOES's own; so nothing in here knows
 * either.
 */
#ifndef ECT_SOES_DESCRIBE_H
#define ECT_SOES_DESCRIBE_H

#include "seams/device.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Describes the application: identity and name from 1018h and 1008h, SyncManagers and mailboxes from its options, its
 * objects as they are; SYNC0 when it checks what a master makes of the clocks. No behaviour, no protocols, no instance:
 * those are the caller's to add.
 * @param[out] device  refers to SDOobjects, and lives as long as the caller wants
 * Context: any, after ESC_config. Cost: a walk over the object list.
 */
void ect_soes_describe(ect_device_t *device);

ECT_C_END

#endif
