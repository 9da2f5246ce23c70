/* SPDX-License-Identifier: MIT */
/* The object services that a device names, called in the order of the list. */
#include "slave/internal.h"

#define FOR_EACH_SERVICE(s, service)                                                                                   \
    for (const ect_service_t *const *service = (s)->config.device->services; service && *service; service++)

void ect_services_start(ect_slave_t *s)
{
    FOR_EACH_SERVICE(s, service)
    {
        if ((*service)->start)
            (*service)->start(s);
    }
}

ect_reason_t ect_services_write(ect_slave_t *s, const ect_download_t *d)
{
    FOR_EACH_SERVICE(s, service)
    {
        ect_reason_t reason = (*service)->write ? (*service)->write(s, d) : ECT_OK;
        if (reason != ECT_OK)
            return reason;
    }
    return ECT_OK;
}

ect_reason_t ect_services_written(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete)
{
    FOR_EACH_SERVICE(s, service)
    {
        ect_reason_t reason = (*service)->written ? (*service)->written(s, index, subindex, complete) : ECT_OK;
        if (reason != ECT_OK)
            return reason;
    }
    return ECT_OK;
}

uint16_t ect_services_check_up(ect_slave_t *s, uint8_t target)
{
    FOR_EACH_SERVICE(s, service)
    {
        uint16_t code = (*service)->check_up ? (*service)->check_up(s, target) : (uint16_t)ECT_AL_NO_ERROR;
        if (code != ECT_AL_NO_ERROR)
            return code;
    }
    return ECT_AL_NO_ERROR;
}

void ect_services_event(ect_slave_t *s, uint32_t event)
{
    FOR_EACH_SERVICE(s, service)
    {
        if ((*service)->event)
            (*service)->event(s, event);
    }
}
