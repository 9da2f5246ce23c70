/* SPDX-License-Identifier: MIT */
/* What a description asks for, and whether it may: for those who find it out at run time. A firmware does not link
 * this. */
#include "seams/standard.h"
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

/* Below the shortest not every reply has room, and above the longest no datagram reaches the last byte. */
static bool mailboxes_good(const ect_device_t *d)
{
    enum { SHORTEST = 34, LONGEST = 1486 };
    for (unsigned int n = 0; n < 2; n++) {
        uint16_t shortest = d->sm[n].minimum != 0 ? d->sm[n].minimum : d->sm[n].length;
        if (shortest < SHORTEST || ect_mailbox_room(d, n) > LONGEST)
            return false;
    }
    return (d->boot_out.length == 0 && d->boot_in.length == 0) ||
           (d->boot_out.length >= SHORTEST && d->boot_in.length >= SHORTEST);
}

bool ect_slave_check(const ect_device_t *d)
{
    return d->sm_count > 0 && d->sm_count <= 4 && d->instance_size >= sizeof(ect_standard_t) &&
           (d->mailbox_protocols == 0 || (d->sm_count >= 2 && mailboxes_good(d)));
}
