/* SPDX-License-Identifier: MIT */
/* CoE emergencies (ETG.1000.6 §5.6.4): sends the queue of the device, oldest first. */
#include <string.h>

#include "slave/internal.h"

static bool next(const ect_protocol_t *self, ect_slave_t *s, bool send)
{
    const ect_emergency_t *e = &s->emergency[s->emergency_got % ECT_EMERGENCY_QUEUE];
    (void)self;
    ECT_ASSERT((uint8_t)(s->emergency_put - s->emergency_got) <= ECT_EMERGENCY_QUEUE);
    if (s->emergency_got == s->emergency_put)
        return false;
    if (!send)
        return true;
    uint8_t *payload = ect_coe_build(s, ECT_COE_MAIL_EMERGENCY);
    ect_store_le16(payload, e->code);
    payload[2] = e->error_register;
    memcpy(payload + 3, e->data, sizeof e->data);
    s->emergency_got++;
    ect_coe_send(s, ECT_SDO_LENGTH);
    return true;
}

const ect_protocol_t ect_protocol_emergency = {
    .type = ECT_MAILBOX_TYPE_COE, .states = ECT_IN_PREOP_AND_ABOVE, .next = next};
