/* SPDX-License-Identifier: MIT */
#include "support/every.h"

#include "bus/chain/catalogue.h"
#include "support/confdev.h"
#include "support/gauge.h"
#include "support/terminal.h"
#include "support/testdev.h"

const ect_device_t *every_device(size_t i)
{
    static const ect_device_t *const made[] = {&testdev, &confdev, &terminal, &gauge};
    const size_t count = sizeof made / sizeof made[0];
    return i < count ? made[i] : every_product(i - count);
}

const ect_device_t *every_product(size_t i)
{
    const ect_product_t *product = ect_catalogue_at(i);
    return product ? product->device : NULL;
}

const ect_plant_t *plant_of(const ect_device_t *device)
{
    const ect_product_t *product;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        if (product->device == device)
            return product->plant;
    }
    return NULL;
}

unsigned int process_sms_of(const ect_device_t *device)
{
    unsigned int sms = 0;
    for (unsigned int n = 0; n < device->sm_count; n++)
        sms |= device->sm[n].type == ECT_SM_OUTPUTS || device->sm[n].type == ECT_SM_INPUTS ? 1u << n : 0;
    return sms;
}

unsigned int mailbox_sms_of(const ect_device_t *device)
{
    return device->mailbox_protocols != 0 ? 3 : 0;
}

unsigned int first_sm_of(const ect_device_t *device, uint8_t type)
{
    unsigned int n = 0;
    while (n < device->sm_count && device->sm[n].type != type)
        n++;
    return n < device->sm_count ? n : ECT_SMS;
}

bool has_coe(const ect_device_t *device)
{
    return (device->mailbox_protocols & ECT_MAILBOX_COE) != 0;
}
