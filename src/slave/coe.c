/* SPDX-License-Identifier: MIT */
/* CANopen over EtherCAT: the two-byte header, emergencies, and who handles which service (ETG.1000.6 §5.6). */
#include <string.h>

#include "seams/standard.h"
#include "slave/internal.h"

uint8_t *ect_coe_build(ect_slave_t *s, uint8_t service)
{
    uint8_t *coe = ect_mailbox_build(s) + ECT_MAILBOX_HEADER;
    ect_store_le16(coe, (uint16_t)(service << 12));
    return coe + ECT_COE_HEADER;
}

void ect_coe_send(ect_slave_t *s, uint16_t length)
{
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_COE, length);
}

void ect_coe_request(ect_slave_t *s, const uint8_t *payload, uint16_t length)
{
    if (length < ECT_COE_HEADER) {
        ect_mailbox_error(s, ECT_MAILBOX_ERROR_TOO_SHORT);
        return;
    }
    const uint8_t *request = payload + ECT_COE_HEADER;
    uint16_t rest = (uint16_t)(length - ECT_COE_HEADER);
    switch (ect_load_le16(payload) >> 12) {
    case ECT_COE_SERVICE_SDO_REQUEST:
        ect_sdo_request(s, request, rest);
        break;
    case ECT_COE_SERVICE_SDO_INFO:
        ect_sdo_info_request(s, request, rest);
        break;
    default:
        ect_mailbox_error(s, ECT_MAILBOX_ERROR_SERVICE);
        break;
    }
}

void ect_coe_send_emergency(ect_slave_t *s)
{
    const ect_emergency_t *e = &s->emergency[s->emergency_first];
    uint8_t *payload = ect_coe_build(s, ECT_COE_SERVICE_EMERGENCY);
    ect_store_le16(payload, e->code);
    payload[2] = e->error_register;
    memcpy(payload + 3, e->data, sizeof e->data);
    s->emergency_first = (uint8_t)((s->emergency_first + 1) % ECT_EMERGENCY_QUEUE);
    s->emergency_count--;
    ect_coe_send(s, ECT_SDO_LENGTH);
}

void ect_coe_emergency(void *slave, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    ect_slave_t *s = slave;
    ((ect_standard_t *)s->config.instance)->error_register = error_register;
    if (s->emergency_count == ECT_EMERGENCY_QUEUE) {
        s->emergencies_lost++;
        return;
    }
    ect_emergency_t *e = &s->emergency[(s->emergency_first + s->emergency_count) % ECT_EMERGENCY_QUEUE];
    e->code = code;
    e->error_register = error_register;
    memcpy(e->data, data, sizeof e->data);
    s->emergency_count++;
}
