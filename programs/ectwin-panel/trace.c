/* SPDX-License-Identifier: MIT */
#include "trace.h"

#include <stdio.h>
#include <string.h>

typedef struct taking {
    trace_t *trace;
    table_t *table;
} taking_t;

bool trace_set_has(const trace_set_t *set, size_t signal)
{
    return (set->bits[signal / 8] >> signal % 8 & 1) != 0;
}

void trace_set_add(trace_set_t *set, size_t signal)
{
    set->count += !trace_set_has(set, signal);
    set->bits[signal / 8] = (uint8_t)(set->bits[signal / 8] | 1U << signal % 8);
}

void trace_set_unite(trace_set_t *set, const trace_set_t *other)
{
    for (size_t signal = 0; other->count > 0 && signal < TABLE_SIGNALS; signal++) {
        if (trace_set_has(other, signal))
            trace_set_add(set, signal);
    }
}

void trace_restart(trace_t *trace)
{
    memset(&trace->link, 0, sizeof trace->link);
    memset(&trace->watched, 0, sizeof trace->watched);
}

/* A name with a wildcard is no literal pattern. */
static bool ask(trace_t *trace, const table_signal_t *signal)
{
    static const link_request_t request = {.kind = LINK_WATCH};
    char line[512];
    int length = snprintf(line, sizeof line, "{\"op\":\"watch\",\"slave\":%ld,\"pattern\":\"%s\",\"every\":true}",
                          signal->slave, signal->name);
    if (strpbrk(signal->name, "*?[\\\"") || (size_t)length >= sizeof line)
        return true;
    return link_ask(&trace->link, line, &request);
}

void trace_want(trace_t *trace, const table_t *table, const trace_set_t *wanted)
{
    for (size_t i = 0; wanted->count > 0 && i < table->count && trace->watched.count < TRACE_SIGNALS; i++) {
        if (!trace_set_has(wanted, i) || trace_set_has(&trace->watched, i))
            continue;
        if (!ask(trace, &table->signals[i]))
            return;
        trace_set_add(&trace->watched, i);
    }
}

static void take(void *ctx, const link_request_t *request, const char *text, const cJSON *line, bool last)
{
    const taking_t *taking = ctx;
    trace_t *trace = taking->trace;
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(line, "value");
    const cJSON *time_s = cJSON_GetObjectItemCaseSensitive(line, "time");
    (void)text;
    (void)last;
    if (request->kind != LINK_CHANGE || !cJSON_IsNumber(value) || !cJSON_IsNumber(time_s))
        return;
    size_t signal = table_find(taking->table, line);
    if (signal == TABLE_SIGNALS)
        return;
    trace->ring[trace->written++ % TRACE_ROOM] =
        (trace_change_t){.signal = (uint16_t)signal, .time_s = time_s->valuedouble, .value = value->valuedouble};
}

bool trace_take(trace_t *trace, table_t *table, const char *bytes, size_t length)
{
    taking_t taking = {.trace = trace, .table = table};
    return link_take(&trace->link, bytes, length, take, &taking);
}
