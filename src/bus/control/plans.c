/* SPDX-License-Identifier: MIT */
#include "bus/control/plans.h"

#include <string.h>

#include "seams/device.h"
#include "wire/assert.h"

const char *ect_plans_add(ect_plans_t *plans, uint64_t due_ns, const cJSON *request)
{
    size_t at = plans->count;
    if (at == ECT_PLANS)
        return "64 requests wait for their time already";
    cJSON *copy = cJSON_Duplicate(request, 1);
    if (!copy)
        return "not enough memory";
    while (at > 0 && plans->plan[at - 1].due_ns > due_ns)
        at--;
    memmove(&plans->plan[at + 1], &plans->plan[at], (plans->count - at) * sizeof plans->plan[0]);
    plans->plan[at].due_ns = due_ns;
    plans->plan[at].request = copy;
    plans->count++;
    return NULL;
}

uint64_t ect_plans_due(const ect_plans_t *plans)
{
    return plans->count > 0 ? plans->plan[0].due_ns : ECT_NEVER;
}

cJSON *ect_plans_take(ect_plans_t *plans)
{
    ECT_ASSERT(plans->count > 0 && plans->count <= ECT_PLANS);
    cJSON *request = plans->plan[0].request;
    memmove(&plans->plan[0], &plans->plan[1], --plans->count * sizeof plans->plan[0]);
    return request;
}

void ect_plans_clear(ect_plans_t *plans)
{
    for (size_t i = 0; i < plans->count; i++)
        cJSON_Delete(plans->plan[i].request);
    plans->count = 0;
}
