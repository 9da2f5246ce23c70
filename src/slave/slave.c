/* SPDX-License-Identifier: MIT */
#include "slave/slave.h"

#include <string.h>

#include "seams/standard.h"
#include "slave/internal.h"

static bool has_memory(const ect_slave_config_t *config)
{
    const ect_device_t *d = config->device;
    return config->instance && (d->mailbox_protocols == 0 || config->mailbox) &&
           (ect_sm_process(d) == 0 || config->process_data) && (config->run_count == 0 || config->runs);
}

static int check(const ect_slave_config_t *config)
{
    if (!config->device || !config->pdi || !config->pdi->read || !config->pdi->write)
        return -1;
    return has_memory(config) ? 0 : -2;
}

/* Sets the interrupt line's mask such that the line is active exactly while there is work: of the mailbox, only the
 * event that it waits for; of process data, only while they are exchanged. */
static void set_line(ect_slave_t *s)
{
    ECT_ASSERT(s->state != 0);
    uint32_t events = 0;
    uint8_t mask[2];
    if (!s->config.line_for_cycle) {
        events = ECT_EVENT_AL_CONTROL | ECT_EVENT_SM_CHANGED | ECT_EVENT_WATCHDOG;
        if (s->mailbox.running)
            events |= ect_mailbox_waits(s) ? ECT_EVENT_SM1 : ECT_EVENT_SM0;
    }
    if (s->state >= ECT_STATE_SAFEOP) {
        events |= ect_sm_events((unsigned int)s->outputs | s->inputs);
        events |= (s->config.device->sync.supported & (1u << ECT_SYNC_DC_SYNC0)) != 0 ? ECT_EVENT_SYNC0 : 0u;
    }
    ect_store_le16(mask, (uint16_t)events);
    if (events != s->line && ect_slave_write(s, ECT_REG_AL_EVENT_MASK, mask, sizeof mask))
        s->line = (uint16_t)events;
}

/* Clears the device's memory except the bytes that belong to its surroundings. */
static void clear_instance(const ect_slave_config_t *config)
{
    uint8_t *instance = config->instance;
    size_t end = config->outside_offset + config->outside_size;
    ECT_ASSERT(end <= config->device->instance_size);
    ECT_ASSERT(config->outside_size == 0 || config->outside_offset >= sizeof(ect_standard_t));
    memset(instance, 0, config->outside_offset);
    memset(instance + end, 0, config->device->instance_size - end);
}

/* Address switches set the station alias, and replace the configured device id. */
static void take_switches(ect_slave_t *s)
{
    uint8_t alias[2];
    if (s->config.switches == 0)
        return;
    ect_store_le16(alias, s->config.switches);
    s->config.device_id = s->config.switches;
    (void)ect_slave_write(s, ECT_REG_STATION_ALIAS, alias, sizeof alias);
}

static void power_on(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    const ect_identity_t *identity = s->config.identity ? s->config.identity : &device->identity;
    ECT_ASSERT(device->sm_count <= ECT_SMS && device->instance_size >= sizeof(ect_standard_t));
    clear_instance(&s->config);
    ect_standard_t *standard = s->config.instance;
    standard->device = device;
    standard->identity = *identity;
    if (!s->config.exchange_is_callers)
        ect_od_set_defaults(&s->od);
    s->state = ECT_STATE_INIT;
    s->status_dirty = true;
    s->line = UINT16_MAX; /* unknown */
    s->tick_ns = s->now_ns;
    ect_sm_disable(s, (1u << device->sm_count) - 1u);
    if (device->init)
        device->init(s->config.instance, &s->host, s->now_ns);
    ect_services_start(s); /* after init: stored values replace the start values of the device */
}

int ect_slave_init(ect_slave_t *slave, const ect_slave_config_t *config, uint64_t now_ns)
{
    ECT_ASSERT(slave && config && config != &slave->config);
    int error = check(config);
    if (error != 0)
        return error;
    memset(slave, 0, sizeof *slave);
    slave->config = *config;
    slave->now_ns = now_ns;
    slave->od = ect_device_od(config->device, config->instance);
    ect_host_init(slave);
    power_on(slave);
    take_switches(slave);
    return ect_machine_report(slave) ? 0 : -3;
}

static void tick(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    if (!s->woken && s->now_ns < s->tick_ns)
        return;
    s->woken = false;
    s->tick_ns = ECT_NEVER;
    if (!device->tick)
        return;
    s->tick_ns = device->tick(s->config.instance, s->now_ns);
    ECT_ASSERT(s->tick_ns > s->now_ns);
    s->inputs_due = true;
}

static void device_requests(ect_slave_t *s)
{
    uint8_t to = s->drop_state;
    uint16_t code = s->drop_code;
    s->drop_state = 0;
    if (to != 0 && to < s->state)
        ect_machine_drop(s, to, code, ECT_CAUSE_LOCAL);
}

/* A chip that replies to AL control itself (0x0141 bit 0) raises no event: every poll reads the request. */
static bool emulated(const ect_slave_t *s)
{
    return (s->config.device->esc_config[1] & 1u) != 0;
}

/* Handles the master's changes of state machine, SyncManagers and watchdog. */
static void control(ect_slave_t *s, uint32_t event)
{
    s->due |= event;
    if ((s->due & ECT_EVENT_AL_CONTROL) != 0 || emulated(s))
        ect_machine_al_control(s);
    if (s->request_due)
        ect_machine_request(s);
    if ((s->due & ECT_EVENT_SM_CHANGED) != 0)
        ect_machine_sm_changed(s);
    if ((s->due & ECT_EVENT_WATCHDOG) != 0)
        ect_machine_watchdog(s);
}

/* Time of the next poll without an event. Soon after a failure of the PDI, or after a request or notification of the
 * device. */
static uint64_t next_time(const ect_slave_t *s)
{
    enum { SOON_NS = 100000 };
    if (s->failed || s->woken || s->restart || s->drop_state != 0 || (s->pending != 0 && s->pending_done))
        return s->now_ns + SOON_NS;
    return s->pending != 0 ? ect_earlier(s->pending_until_ns, s->tick_ns) : s->tick_ns;
}

static void do_later(ect_slave_t *s)
{
    void (*later)(ect_slave_t *s) = s->later;
    s->later = NULL;
    if (later)
        later(s);
}

/* The sequence of all steps. */
static uint64_t poll(ect_slave_t *s, uint64_t now_ns, bool with_exchange)
{
    uint32_t event = 0;
    ECT_ASSERT(!s->held && s->state != 0);
    ect_cycle_hold(s);
    if (s->now_ns < now_ns) /* an exchange may have run since the caller read its clock */
        s->now_ns = now_ns;
    if (ect_slave_read_event(s, &event))
        control(s, event);
    ect_cycle_yield(s);
    if (with_exchange)
        ect_cycle_outputs(s, event);
    tick(s);
    device_requests(s);
    if (with_exchange)
        ect_cycle_inputs(s);
    ect_cycle_yield(s);
    if (s->pending != 0)
        ect_machine_pending(s);
    if (s->status_dirty || s->sm_due != 0)
        (void)ect_machine_report(s);
    ect_cycle_yield(s);
    if (s->mailbox.running)
        ect_mailbox_poll(s, event);
    do_later(s);
    set_line(s);
    ect_cycle_release(s);
    ECT_ASSERT(!s->outputs_live || s->state == ECT_STATE_OP);
    return next_time(s);
}

uint64_t ect_slave_poll(ect_slave_t *s, uint64_t now_ns)
{
    return poll(s, now_ns, true);
}

uint64_t ect_slave_mainline(ect_slave_t *s, uint64_t now_ns)
{
    return poll(s, now_ns, false);
}
