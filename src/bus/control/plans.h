/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Requests of clients with a future time of the bus ("at"). Internal to bus/control.
 */
#ifndef ECT_BUS_CONTROL_PLANS_H
#define ECT_BUS_CONTROL_PLANS_H

#include <stddef.h>
#include <stdint.h>

#include <cjson/cJSON.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Most pending requests. */
enum { ECT_PLANS = 64 };

/** The pending requests. Zeroed: none. */
typedef struct ect_plans {
    struct {
        uint64_t due_ns;
        cJSON *request;
    } plan[ECT_PLANS]; /**< sorted by time; equal times in the order of ::ect_plans_add */
    size_t count;
} ect_plans_t;

/** Adds a copy of a request. @return the reason of a refusal; NULL: added */
const char *ect_plans_add(ect_plans_t *plans, uint64_t due_ns, const cJSON *request);

/** @return the time of the first request; ECT_NEVER: none. */
uint64_t ect_plans_due(const ect_plans_t *plans);

/** Removes the first request; call it only with a pending one. @return the request, to be deleted by the caller */
cJSON *ect_plans_take(ect_plans_t *plans);

/** Deletes all requests. */
void ect_plans_clear(ect_plans_t *plans);

ECT_C_END

#endif
