/* SPDX-License-Identifier: MIT */
/* SDO writes: the communication settings 2400h, Clear error 2401h. */
#include <string.h>

#include "devices/fzm1/instance.h"

static ect_reason_t check_setting(const fzm1_t *u, uint8_t subindex, const uint8_t *data)
{
    uint16_t number = (uint16_t)(data[0] | (subindex == 2 || subindex == 3 ? data[1] << 8 : 0));
    switch (subindex) {
    case 1:
    case 5:
        return number > 1 ? ECT_REASON_RANGE : ECT_OK;
    case 2:
        return fzm1_time_fits(u->settings.output_time, number) ? ECT_OK : ECT_REASON_INCOMPATIBLE;
    case 3:
        return fzm1_time_fits(number, u->settings.output_period) ? ECT_OK : ECT_REASON_INCOMPATIBLE;
    default:
        return ECT_OK;
    }
}

ect_reason_t fzm1_sdo_request(void *instance, uint16_t index, uint8_t subindex)
{
    fzm1_t *u = instance;
    ect_reason_t code = u->plant.sdo_abort;
    (void)index;
    (void)subindex;
    u->plant.sdo_abort = 0;
    return code;
}

ect_reason_t fzm1_sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    (void)size;
    return index == 0x2400 && data ? check_setting(instance, subindex, data) : (ect_reason_t)ECT_OK;
}

void fzm1_sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns)
{
    fzm1_t *u = instance;
    (void)fzm1_tick(u, now_ns);
    if (index == 0x2401)
        fzm1_end_errors(u, FZM1_ERROR_ALL);
    else if (index == 0x2400 && subindex == 1)
        fzm1_output_reset(u);
    else if (index == 0x2400 && subindex == 2)
        fzm1_output_new_period(u, u->settings.output_period);
}
