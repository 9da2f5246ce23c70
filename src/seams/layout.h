/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Layout: what the SyncManagers of a description take of a controller's memory. For those who lay a description out
 * and those who check one; a device does not need it.
 *
 * Context: any. Cost: as ::ect_device_sm_bytes.
 */
#ifndef ECT_SEAMS_LAYOUT_H
#define ECT_SEAMS_LAYOUT_H

#include "seams/device.h"
#include "wire/registers.h"

/** Bytes that SyncManager n may come to. */
static inline unsigned int ect_layout_room(const ect_device_t *device, unsigned int n)
{
    unsigned int bytes = ect_device_sm_bytes(device, n);
    return device->sm[n].maximum > bytes ? device->sm[n].maximum : bytes;
}

/** Whether it lies over the registers of the digital outputs, which have no buffers. */
static inline bool ect_layout_in_registers(const ect_device_t *device, unsigned int n)
{
    unsigned int start = device->sm[n].start;
    return start >= ECT_REG_DIGITAL_OUTPUT && start < ECT_RAM && start + ect_layout_room(device, n) <= ECT_RAM;
}

/** Bytes from its start on that are its own: three buffers, or one in mailbox mode, of a single byte, in registers. */
static inline unsigned int ect_layout_memory(const ect_device_t *device, unsigned int n)
{
    unsigned int room = ect_layout_room(device, n);
    bool mailbox = (device->sm[n].control & ECT_SM_CONTROL_MODE) == ECT_SM_CONTROL_MAILBOX;
    return mailbox || room == 1 || ect_layout_in_registers(device, n) ? room : 3 * room;
}

#endif
