/* SPDX-License-Identifier: MIT */
/* Synchronisation, 1C32h, 1C33h and 10F1h (ETG.1020 §13): checks before SAFEOP, and missed events. */
#include "slave/internal.h"

enum { ERROR_SETTINGS = 0x10F1, OUTPUTS = 0x1C32, INPUTS = 0x1C33 };

/* A device without outputs has only 1C33h. */
static ect_sync_data_t *data_of(const ect_slave_t *s)
{
    ect_sync_data_t *d = ect_services_data(s, OUTPUTS);
    return d ? d : ect_services_data(s, INPUTS);
}

static void start(ect_slave_t *s)
{
    ect_sync_data_t *d = data_of(s);
    const ect_sync_t *ability = &s->config.device->sync;
    if (!d)
        return;
    d->supported = ability->supported;
    d->minimum_ns = ability->minimum_cycle_ns;
    d->type = (ability->supported & (1u << ECT_SYNC_FREE_RUN)) != 0 ? ECT_SYNC_FREE_RUN : ECT_SYNC_SM;
    if (!ect_od_find(&s->od, ERROR_SETTINGS)) /* otherwise its entries define them */
        d->error_limit = 4;
}

static ect_reason_t write_sync(ect_slave_t *s, const ect_download_t *d)
{
    if ((d->index != OUTPUTS && d->index != INPUTS) || d->subindex != 1 || d->size != 2)
        return ECT_OK;
    uint16_t type = ect_load_le16(d->data);
    return type < 16 && (s->config.device->sync.supported & (1u << type)) != 0 ? ECT_OK : ECT_REASON_RANGE;
}

static bool cycle_supported(const ect_sync_t *ability, uint32_t cycle_ns)
{
    for (unsigned int i = 0; i < ability->dc_cycle_count; i++) {
        if (ability->dc_cycles_ns[i] == cycle_ns)
            return true;
    }
    return ability->dc_cycle_count == 0 && cycle_ns >= ability->minimum_cycle_ns;
}

/* While the cyclic unit of the distributed clocks runs, the device is synchronised, regardless of the written type. */
static uint16_t check_dc(ect_slave_t *s, ect_sync_data_t *d)
{
    uint8_t activation = 0;
    uint8_t cycle[4] = {0};
    if (!ect_slave_read(s, ECT_REG_DC_ACTIVATION, &activation, 1))
        return ECT_AL_NO_ERROR;
    d->cycle_ns = 0;
    d->dc = s->sync0_runs = 0;
    if ((activation & 1u) == 0)
        return d->type == ECT_SYNC_DC_SYNC0 ? ECT_AL_DC_SYNC : ECT_AL_NO_ERROR;
    if ((s->config.device->sync.supported & (1u << ECT_SYNC_DC_SYNC0)) == 0)
        return ECT_AL_NO_SYNC;
    if (!ect_slave_read(s, ECT_REG_DC_SYNC0_CYCLE, cycle, sizeof cycle))
        return ECT_AL_NO_ERROR;
    if (!cycle_supported(&s->config.device->sync, ect_load_le32(cycle)))
        return ECT_AL_SYNC0_CYCLE;
    d->dc = s->sync0_runs = 1;
    d->cycle_ns = ect_load_le32(cycle);
    return ECT_AL_NO_ERROR;
}

/* SYNC0 has occurred and then stopped: a device that waits for it would wait forever. */
static bool sync0_lost(const ect_slave_t *s, const ect_sync_data_t *d)
{
    uint64_t patience_ns = (d->error_limit + 1ull) * d->cycle_ns;
    return d->error_limit != 0 && d->sync0_ns != 0 && patience_ns != 0 && s->now_ns - d->sync0_ns > patience_ns;
}

static uint16_t check_up(ect_slave_t *s, uint8_t target)
{
    ect_sync_data_t *d = data_of(s);
    if (!d || target < ECT_STATE_SAFEOP)
        return ECT_AL_NO_ERROR;
    if (target == ECT_STATE_SAFEOP || sync0_lost(s, d))
        d->sync0_ns = 0; /* a time from a previous OP is meaningless */
    if (target == ECT_STATE_OP)
        return check_dc(s, d); /* SYNC0 may have been started, or changed, meanwhile */
    d->sm_missed = 0;
    d->cycle_exceeded = 0;
    d->sync_error = 0;
    d->errors = 0;
    d->outputs_new = 0;
    d->sync0 = 0;
    return check_dc(s, d);
}

static void count(uint16_t *counter)
{
    if (*counter < 0xFFFF)
        (*counter)++;
}

static void on_sync0(ect_slave_t *s, ect_sync_data_t *d)
{
    ECT_ASSERT(d->dc != 0 && s->state == ECT_STATE_OP);
    bool missed = d->outputs_new == 0 && s->outputs != 0;
    d->outputs_new = 0;
    d->sync_error = missed;
    if (!missed) {
        d->errors = 0;
        return;
    }
    count(&d->sm_missed);
    count(&d->errors);
    if (d->error_limit != 0 && d->errors > d->error_limit && !s->config.device->sync.asynchronous)
        ect_host_drop(s, ECT_STATE_SAFEOP, ECT_AL_SYNC);
}

/* In acknowledge mode the event remains until its status is read. @return whether this was the case: the next event is
 * a new one */
static bool acknowledge_sync0(ect_slave_t *s)
{
    uint8_t status = 0;
    return ect_slave_read(s, ECT_REG_DC_SYNC0_STATUS, &status, 1) && (status & 1u) != 0;
}

static void supervise(ect_slave_t *s, ect_sync_data_t *d, uint32_t event)
{
    bool sync0 = (event & ECT_EVENT_SYNC0) != 0; /* a level: its edge is a SYNC0 */
    if ((event & ect_sm_events(s->outputs)) != 0) {
        if (d->outputs_new != 0)
            count(&d->cycle_exceeded);
        d->outputs_new = 1;
    }
    if (sync0 && d->sync0 == 0)
        on_sync0(s, d);
    d->sync0 = sync0;
    if (!sync0 && sync0_lost(s, d))
        ect_host_drop(s, ECT_STATE_SAFEOP, ECT_AL_FATAL_SYNC);
}

/* Only counts in OP with SYNC0, because in SAFEOP the master may still be adjusting its rhythm. The event is cleared
 * in either case, as it must not keep the interrupt line active. */
static void on_event(ect_slave_t *s, uint32_t event)
{
    if (!s->sync0_runs && (event & ECT_EVENT_SYNC0) == 0)
        return;
    ect_sync_data_t *d = data_of(s);
    if (d && (event & ECT_EVENT_SYNC0) != 0)
        d->sync0_ns = s->now_ns; /* in SAFEOP too: it may stop before it occurs in OP */
    if (d && d->dc != 0 && s->state == ECT_STATE_OP)
        supervise(s, d, event);
    if ((event & ECT_EVENT_SYNC0) != 0 && acknowledge_sync0(s) && d)
        d->sync0 = 0;
}

const ect_service_t ect_service_sync = {.start = start, .write = write_sync, .check_up = check_up, .event = on_event};
