/* SPDX-License-Identifier: MIT */
/* Reports the rhythm of the bus to a device. */
#include "slave/internal.h"
#include "slave/service.h"

static void report_rhythm(ect_slave_t *s, uint32_t event)
{
    const ect_device_t *device = s->config.device;
    uint8_t status;
    unsigned int events = ((event & ect_sm_events(s->outputs)) != 0 ? ECT_CYCLIC_OUTPUTS : 0u) |
                          ((event & ECT_EVENT_SYNC0) != 0 ? ECT_CYCLIC_SYNC0 : 0u);
    if (events == 0 || !device->cyclic)
        return;
    device->cyclic(s->config.instance, (uint8_t)events, s->now_ns);
    if ((events & ECT_CYCLIC_SYNC0) != 0 && !s->sync0_runs) /* else ect_service_sync acknowledges */
        (void)ect_slave_read(s, ECT_REG_DC_SYNC0_STATUS, &status, 1);
    ect_slave_wake(s);
}

const ect_service_t ect_service_rhythm = {.event = report_rhythm};
