/* SPDX-License-Identifier: MIT */
/* What a base unit does with its process data (TS-0007 §10). */
#include <string.h>

#include "devices/eclink/instance.h"

enum { UPDATE_NS = 125000000 }; /* §10.3: new input data every 125 ms */

void eclink_init(void *instance, const ect_identity_t *identity, const ect_host_t *host, uint64_t now_ns)
{
    eclink_t *bu = instance;
    (void)host;
    bu->standard.identity = *identity;
    bu->update_ns = now_ns + UPDATE_NS;
}

void eclink_outputs(void *instance, uint64_t now_ns)
{
    eclink_t *bu = instance;
    (void)now_ns;
    bu->inputs[ECLINK_IN_CAI] = bu->outputs[ECLINK_OUT_CCO];
    bu->inputs[ECLINK_IN_PAI] = bu->outputs[ECLINK_OUT_PCO];
}

/* Late calls do not shift the rhythm, and do not make up for missed updates. */
uint64_t eclink_tick(void *instance, uint64_t now_ns)
{
    eclink_t *bu = instance;
    if (now_ns >= bu->update_ns) {
        bu->inputs[ECLINK_IN_PCI]++;
        bu->update_ns += UPDATE_NS;
        if (bu->update_ns <= now_ns)
            bu->update_ns = now_ns + UPDATE_NS;
    }
    return bu->update_ns;
}
