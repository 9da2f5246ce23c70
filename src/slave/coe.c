/* SPDX-License-Identifier: MIT */
/* CANopen over EtherCAT: the two-byte header that its protocols share (ETG.1000.6 §5.6.1). */
#include "slave/internal.h"

uint16_t ect_coe_expect(const uint8_t *data, uint16_t length, uint8_t kind)
{
    if (length < ECT_COE_HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    return ect_load_le16(data) >> 12 == kind ? ECT_MAILBOX_OK : ECT_MAILBOX_ERROR_SERVICE;
}

uint8_t *ect_coe_build(ect_slave_t *s, uint8_t kind)
{
    ECT_ASSERT(kind <= 0x0F);
    uint8_t *coe = ect_mailbox_build(s);
    ect_store_le16(coe, (uint16_t)(kind << 12));
    return coe + ECT_COE_HEADER;
}

uint16_t ect_coe_room(const ect_slave_t *s)
{
    return (uint16_t)(ect_mailbox_room(s) - ECT_COE_HEADER);
}

void ect_coe_send(ect_slave_t *s, uint16_t length)
{
    ECT_ASSERT(length > ECT_COE_HEADER);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_COE, length);
}
