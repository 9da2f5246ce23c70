/* SPDX-License-Identifier: MIT */
/* Access to the dictionary by the program that runs the slave, as an SDO server carries it out for a master. */
#include "slave/internal.h"

static uint32_t place_of(uint16_t index, uint8_t subindex)
{
    return (uint32_t)index << 16 | subindex;
}

ect_reason_t ect_slave_upload(ect_slave_t *s, uint16_t index, uint8_t subindex, uint8_t *to, uint16_t room,
                              uint16_t *size)
{
    uint32_t length = room;
    ECT_ASSERT(to && room > 0);
    if (ect_slave_in_transfer(s))
        return ECT_REASON_LOCAL_CONTROL;
    ect_reason_t reason = ect_sdo_read_all(s, place_of(index, subindex), to, &length);
    if (reason == ECT_OK)
        *size = (uint16_t)length;
    return reason;
}

ect_reason_t ect_slave_download(ect_slave_t *s, uint16_t index, uint8_t subindex, const uint8_t *data, uint16_t size)
{
    if (ect_slave_in_transfer(s))
        return ECT_REASON_LOCAL_CONTROL;
    ect_reason_t reason = ect_sdo_write_all(s, place_of(index, subindex), data, size);
    if (reason == ECT_OK)
        ect_slave_wake(s);
    return reason;
}
