/* SPDX-License-Identifier: MIT */
/* A mailbox protocol of the vendor's own, by seams/mailbox.h alone. */
#include "heater.h"

#include "seams/mailbox.h"
#include "wire/bytes.h"

enum { VENDOR = 4, HEADER = VENDOR + 2, PEAK = 2 };

/* @return bytes of the data behind the header, -1: the service does not exist */
static int serve(heater_t *h, uint16_t service, uint8_t *data)
{
    switch (service) {
    case HEATER_READ_PEAK:
        ect_store_le16(data, (uint16_t)h->peak);
        return PEAK;
    case HEATER_CLEAR_PEAK:
        h->peak = h->sensed;
        return 0;
    default:
        return -1;
    }
}

/* Each request gets one mail: its reply, or the mailbox error that the result selects. */
static uint16_t request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    uint8_t content[PEAK];
    if (length < HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    if (ect_load_le32(data) != heater.identity.vendor_id)
        return ECT_MAILBOX_ERROR_SERVICE;
    const uint16_t service = ect_load_le16(data + VENDOR);
    const int size = serve(ect_mailbox_instance(slave), service, content);
    if (size < 0)
        return ECT_MAILBOX_ERROR_SERVICE;
    uint8_t *reply = ect_mailbox_build(slave);
    ect_store_le32(reply, heater.identity.vendor_id);
    ect_store_le16(reply + VENDOR, service);
    for (int i = 0; i < size; i++)
        reply[HEADER + i] = content[i];
    ect_mailbox_send(slave, self->type, (uint16_t)(HEADER + size));
    return ECT_MAILBOX_OK;
}

const ect_protocol_t heater_voe = {.type = ECT_MAILBOX_TYPE_VOE, .states = ECT_IN_PREOP_AND_ABOVE, .request = request};
