/* SPDX-License-Identifier: MIT */
#include "support/voe.h"

#include <string.h>

#include "wire/bytes.h"

static voe_t *state_of(const ect_protocol_t *self, const ect_slave_t *slave)
{
    const voe_protocol_t *own = (const voe_protocol_t *)(const void *)self;
    return (voe_t *)(void *)((uint8_t *)ect_mailbox_instance(slave) + own->offset);
}

uint16_t voe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    if (length < 2)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    if (length > 6 && memcmp(data, "again ", 6) == 0) {
        state_of(self, slave)->again = data[6];
        ect_mailbox_wake(slave);
    }
    uint8_t *answer = ect_mailbox_build(slave);
    uint16_t size = length < ect_mailbox_room(slave) ? length : ect_mailbox_room(slave);
    for (uint16_t i = 0; i < size; i++)
        answer[i] = data[length - 1 - i];
    ect_mailbox_send(slave, self->type, size);
    return ECT_MAILBOX_OK;
}

bool voe_next(const ect_protocol_t *self, ect_slave_t *slave, bool send)
{
    voe_t *voe = state_of(self, slave);
    if (voe->again == 0)
        return false;
    if (send) {
        ect_mailbox_build(slave)[0] = voe->again--;
        ect_mailbox_send(slave, self->type, 1);
    }
    return true;
}

void voe_reset(const ect_protocol_t *self, ect_slave_t *slave)
{
    voe_t *voe = state_of(self, slave);
    voe->again = 0;
    voe->received = 0;
    voe->resets++;
}

uint16_t voe_boot_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    voe_t *voe = state_of(self, slave);
    (void)data;
    voe->received += length;
    ect_store_le32(ect_mailbox_build(slave), voe->received);
    ect_mailbox_send(slave, self->type, 4);
    return ECT_MAILBOX_OK;
}
