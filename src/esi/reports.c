/* SPDX-License-Identifier: MIT */
/* Notifications and emergencies of SoE drives. Initially off, because SOEM 1.4 regards both as a wrong reply. */
#include "esi/internal.h"

const ect_signal_t ect_esi_report_signals[] = {
    ECT_SIGNAL(ect_esi_reports_t, on, "reports", BOOL, WRITE, 0, 1, NULL,
               "1: the drives send notifications when commands end, and emergencies of SoE"),
};
const uint16_t ect_esi_report_signal_count = sizeof ect_esi_report_signals / sizeof ect_esi_report_signals[0];

static ect_soe_state_t *state_of(const ect_soe_t *servo, void *instance)
{
    return (ect_soe_state_t *)(void *)((uint8_t *)instance + servo->offset);
}

static void emergency(void *ctx, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    const ect_esi_reporter_t *reporter = ctx;
    if (state_of(reporter->servo, reporter->instance)->notifies)
        ect_soe_emergency(reporter->servo, reporter->instance, reporter->drive, code, error_register, data);
    else
        reporter->twin->emergency(reporter->twin->ctx, code, error_register, data);
}

const ect_host_t *ect_esi_reporter(ect_esi_reporter_t *reporter, const ect_soe_t *servo, void *instance, uint8_t drive,
                                   const ect_host_t *twin)
{
    *reporter = (ect_esi_reporter_t){.host = {.ctx = reporter, .emergency = emergency},
                                     .twin = twin,
                                     .servo = servo,
                                     .instance = instance,
                                     .drive = drive};
    return &reporter->host;
}

void ect_esi_report(const ect_soe_t *servo, void *instance, const ect_esi_reports_t *reports)
{
    state_of(servo, instance)->notifies = reports->on != 0;
}
