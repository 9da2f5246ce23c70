/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Requests of clients that wait for their time of the bus. Internal to bus/control.
 */
#ifndef ECT_BUS_CONTROL_PLANS_H
#define ECT_BUS_CONTROL_PLANS_H

#include <stddef.h>
#include <stdint.h>

#include <cjson/cJSON.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Most requests that wait. */
enum { ECT_PLANS = 64 };

/** All zero: none waits. */
typedef struct ect_plans {
    struct {
        uint64_t due_ns;
        cJSON *request;
    } plan[ECT_PLANS]; /**< in the order of their times; of the same time in the order of ::ect_plans_add */
    size_t count;
} ect_plans_t;

/** Adds a copy of a request. @return why not; NULL: added */
const char *ect_plans_add(ect_plans_t *plans, uint64_t due_ns, const cJSON *request);

/** Time of the first request; ECT_NEVER: none. */
uint64_t ect_plans_due(const ect_plans_t *plans);

/** Takes the first request away, which is then the caller's, to be deleted. Only with one that waits. */
cJSON *ect_plans_take(ect_plans_t *plans);

/** Deletes all requests. */
void ect_plans_clear(ect_plans_t *plans);

ECT_C_END

#endif
