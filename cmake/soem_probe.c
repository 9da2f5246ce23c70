/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the demo's master and the tests use of SOEM 1.4, compiled and linked, never run: SOEM 2 has other headers,
 * another context and other arguments.
 */
#include <stddef.h>

#include "ethercat.h"

static ec_slavet *slaves(const ecx_contextt *context)
{
    return context->port == NULL ? NULL : context->slavelist;
}

int main(void)
{
    static uint8 image[64];
    static ecx_contextt context;

    return slaves(&context) != NULL || ec_init("lo") + ec_config_init(FALSE) + ec_config_map(image) +
                                           ecx_config_init(&context, FALSE) + ecx_send_processdata(&context) +
                                           ecx_receive_processdata(&context, EC_TIMEOUTRET);
}
