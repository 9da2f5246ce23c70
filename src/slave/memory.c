/* SPDX-License-Identifier: MIT */
/* How much memory a slave needs: for those who find it out at run time. A firmware that knows does not link this. */
#include "slave/internal.h"

static uint16_t process_room(const ect_device_t *device, unsigned int sm)
{
    return sm < device->sm_count ? ect_sm_room(device, sm) : 0;
}

ect_slave_memory_t ect_slave_memory(const ect_device_t *device)
{
    uint16_t outputs = process_room(device, 2);
    uint16_t inputs = process_room(device, 3);
    return (ect_slave_memory_t){
        .instance = device->instance_size,
        .mailbox = ect_mailbox_room(device, 0) + 2u * ect_mailbox_room(device, 1),
        .process_data = outputs > inputs ? outputs : inputs,
        .runs = device->pdo_runs,
    };
}
