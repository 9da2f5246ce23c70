/* SPDX-License-Identifier: MIT */
/* The requests of a device (ect_host_t): recorded here, executed by the poll, in mainline. */
#include <string.h>

#include "seams/standard.h"
#include "slave/internal.h"

void ect_host_drop(void *slave, uint8_t state, uint16_t al_status_code)
{
    ect_slave_t *s = slave;
    ECT_ASSERT(state >= ECT_STATE_INIT && state <= ECT_STATE_OP);
    ECT_ASSERT(al_status_code != ECT_AL_NO_ERROR);
    s->drop_code = al_status_code;
    s->drop_state = state;
}

void ect_host_emergency(void *slave, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    ect_slave_t *s = slave;
    ECT_ASSERT((uint8_t)(s->emergency_put - s->emergency_got) <= ECT_EMERGENCY_QUEUE);
    ((ect_standard_t *)s->config.instance)->error_register = error_register;
    if ((uint8_t)(s->emergency_put - s->emergency_got) == ECT_EMERGENCY_QUEUE) {
        s->emergencies_lost++;
        return;
    }
    ect_emergency_t *e = &s->emergency[s->emergency_put % ECT_EMERGENCY_QUEUE];
    e->code = code;
    e->error_register = error_register;
    memcpy(e->data, data, sizeof e->data);
    s->emergency_put++;
    s->mailbox.announced = true;
}

static void transition_done(void *slave, uint16_t al_status_code)
{
    ect_slave_t *s = slave;
    s->pending_result = al_status_code;
    s->pending_done = true;
}

static void off_bus(void *slave, bool off)
{
    ((ect_slave_t *)slave)->off_bus = off;
}

static void restart(void *slave)
{
    ((ect_slave_t *)slave)->restart = true;
}

static void describe(void *slave, const ect_device_t *device)
{
    ect_slave_t *s = slave;
    ECT_ASSERT(s->state < ECT_STATE_SAFEOP && device->sm_count == s->config.device->sm_count);
    ECT_ASSERT(device->instance_size == s->config.device->instance_size);
    s->config.device = device;
    s->od = ect_device_od(device, s->config.instance);
    ((ect_standard_t *)s->config.instance)->device = device;
}

void ect_host_init(ect_slave_t *s)
{
    s->host = (ect_host_t){.ctx = s,
                           .emergency = ect_host_emergency,
                           .drop = ect_host_drop,
                           .transition_done = transition_done,
                           .off_bus = off_bus,
                           .restart = restart,
                           .describe = describe,
                           .storage = s->config.storage,
                           .buffer = s->config.buffer};
}
