/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Layout: the memory of a controller that the SyncManagers of a description occupy, for code that builds or checks a
 * description; a device does not need it.
 *
 * Context: any. Cost: as ::ect_device_sm_bytes.
 */
#ifndef ECT_SEAMS_LAYOUT_H
#define ECT_SEAMS_LAYOUT_H

#include "seams/device.h"
#include "wire/registers.h"

/** Largest length of SyncManager n, bytes. */
static inline unsigned int ect_layout_room(const ect_device_t *device, unsigned int n)
{
    unsigned int bytes = ect_device_sm_bytes(device, n);
    return device->sm[n].maximum > bytes ? device->sm[n].maximum : bytes;
}

/** Whether SyncManager n lies in the registers of the digital outputs, which have no buffers. */
static inline bool ect_layout_in_registers(const ect_device_t *device, unsigned int n)
{
    unsigned int start = device->sm[n].start;
    return start >= ECT_REG_DIGITAL_OUTPUT && start < ECT_RAM && start + ect_layout_room(device, n) <= ECT_RAM;
}

/** Memory that SyncManager n occupies from its start on, bytes: three buffers; a single one in mailbox mode, with a
 * length of one byte, or in registers. */
static inline unsigned int ect_layout_memory(const ect_device_t *device, unsigned int n)
{
    unsigned int room = ect_layout_room(device, n);
    bool mailbox = (device->sm[n].control & ECT_SM_CONTROL_MODE) == ECT_SM_CONTROL_MAILBOX;
    return mailbox || room == 1 || ect_layout_in_registers(device, n) ? room : 3 * room;
}

#endif
