/* SPDX-License-Identifier: MIT */
#include "slave/slave.h"

#include <assert.h>
#include <string.h>

#include "seams/standard.h"
#include "slave/internal.h"

static int check(const ect_slave_config_t *config)
{
    if (!config->device || !config->pdi || !config->pdi->read || !config->pdi->write)
        return -1;
    const ect_device_t *d = config->device;
    bool has_mailbox = d->mailbox_protocols != 0;
    bool has_process_data = false;
    for (unsigned int n = 0; n < d->sm_count; n++)
        has_process_data |= ect_device_sm_is_process(d, n);
    if (!config->instance || (has_mailbox && !config->mailbox) || (has_process_data && !config->process_data) ||
        (config->run_count > 0 && !config->runs))
        return -2;
    return 0;
}

static void power_on(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    const ect_identity_t *identity = s->config.identity ? s->config.identity : &device->identity;
    ect_standard_t *standard = s->config.instance;
    standard->device = device;
    standard->identity = *identity;
    ect_od_set_defaults(&s->od);
    s->state = ECT_STATE_INIT;
    s->status_dirty = true;
    s->tick_ns = s->now_ns;
    ect_mailbox_stop(s);
    ect_sm_disable(s, (1u << device->sm_count) - 1u);
    if (device->init)
        device->init(s->config.instance, &s->host, s->now_ns);
    ect_services_start(s); /* after init: stored values take the place of its start values */
}

int ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns)
{
    int error = check(config);
    if (error != 0)
        return error;
    *slave = (ect_slave_t){.config = *config, .now_ns = now_ns};
    slave->od = ect_device_od(config->device, config->instance);
    ect_host_init(slave);
    power_on(slave);
    return ect_machine_report(slave) ? 0 : -3;
}

static void tick(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    if (!device->tick) {
        s->tick_ns = ECT_NEVER;
        return;
    }
    if (s->now_ns < s->tick_ns)
        return;
    s->tick_ns = device->tick(s->config.instance, s->now_ns);
    assert(s->tick_ns > s->now_ns);
    s->inputs_due = true;
}

static void take_outputs(ect_slave_t *s, uint32_t event)
{
    if (s->state < ECT_STATE_SAFEOP)
        return;
    ect_services_event(s, event);
    unsigned int sms = (event / ECT_EVENT_SM0) & 0xFF;
    if ((sms & s->outputs) != 0)
        ect_pdo_outputs(s, sms & s->outputs, s->outputs_live);
    if ((sms & s->inputs) != 0 && s->config.device->inputs_read)
        s->config.device->inputs_read(s->config.instance, s->now_ns);
    if ((sms & (s->outputs | s->inputs)) != 0)
        s->inputs_due = true;
}

static void give_inputs(ect_slave_t *s)
{
    if (s->state >= ECT_STATE_SAFEOP && s->inputs_due && ect_pdo_inputs(s))
        s->inputs_due = false;
}

static void device_requests(ect_slave_t *s)
{
    if (s->drop_state != 0) {
        uint8_t to = s->drop_state;
        s->drop_state = 0;
        if (to < s->state)
            ect_machine_drop(s, to, s->drop_code, ECT_CAUSE_LOCAL);
    }
}

uint64_t ect_slave_poll(ect_slave_t *s, uint64_t now_ns)
{
    enum { SOON_NS = 100000 };
    uint32_t event = 0;
    s->now_ns = now_ns;
    if (ect_slave_read_event(s, &event)) {
        s->due |= event;
        if ((s->due & ECT_EVENT_AL_CONTROL) != 0)
            ect_machine_al_control(s);
        if (s->request_due)
            ect_machine_request(s);
        if ((s->due & ECT_EVENT_SM_CHANGED) != 0)
            ect_machine_sm_changed(s);
        if ((s->due & ECT_EVENT_WATCHDOG) != 0)
            ect_machine_watchdog(s);
    }
    take_outputs(s, event);
    tick(s);
    device_requests(s);
    give_inputs(s);
    ect_machine_pending(s);
    if (s->status_dirty || s->sm_due != 0)
        (void)ect_machine_report(s);
    if (s->mailbox.running)
        ect_mailbox_poll(s, event);
    if (s->failed || s->tick_ns == 0 || s->restart || s->drop_state != 0 || (s->pending != 0 && s->pending_done))
        return now_ns + SOON_NS; /* the PDI failed, the device asked for something meanwhile, or was told something */
    return s->pending != 0 && s->pending_until_ns < s->tick_ns ? s->pending_until_ns : s->tick_ns;
}
