/* SPDX-License-Identifier: MIT */
#include "bus/control/events.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/al_status.h"
#include "text/emergency.h"
#include "text/state.h"
#include "wire/assert.h"

enum { TEXT = 128 };

typedef struct event {
    uint64_t time_ns;
    size_t position;
    bool emergency; /* else a change of state */
    uint8_t state;  /* 0: off the bus */
    bool error;
    uint16_t code; /* AL status code, or error code of the emergency */
    uint8_t error_register;
    uint8_t data[5];
} event_t;

/* The state of a twin at the last check. */
typedef struct seen {
    uint8_t state;
    bool error;
    uint16_t code;
    uint8_t emergencies; /* counter of the slave */
} seen_t;

struct ect_events {
    uint64_t count; /* number of the last event */
    event_t event[ECT_EVENTS];
    seen_t seen[];
};

static seen_t state_of(const ect_slave_t *slave)
{
    if (slave->off_bus)
        return (seen_t){0};
    return (seen_t){.state = slave->state, .error = slave->error, .code = slave->code};
}

ect_events_t *ect_events_new(const ect_chain_t *chain)
{
    size_t count = ect_chain_count(chain);
    ect_events_t *events = calloc(1, sizeof *events + count * sizeof events->seen[0]);
    for (size_t i = 0; events && i < count; i++) {
        events->seen[i] = state_of(ect_chain_slave(chain, i));
        events->seen[i].emergencies = ect_chain_slave(chain, i)->emergency_put;
    }
    return events;
}

void ect_events_free(ect_events_t *events)
{
    free(events);
}

static event_t *add(ect_events_t *events, size_t position, uint64_t now_ns)
{
    event_t *event = &events->event[++events->count % ECT_EVENTS];
    *event = (event_t){.time_ns = now_ns, .position = position};
    return event;
}

static void look_at_state(ect_events_t *events, const ect_slave_t *slave, size_t position, uint64_t now_ns)
{
    seen_t *seen = &events->seen[position];
    const seen_t now = state_of(slave);
    if (now.state == seen->state && now.error == seen->error && now.code == seen->code)
        return;
    event_t *event = add(events, position, now_ns);
    event->state = seen->state = now.state;
    event->error = seen->error = now.error;
    event->code = seen->code = now.code;
}

/* A restarted slave counts from 0 again. */
static void look_at_emergencies(ect_events_t *events, const ect_slave_t *slave, size_t position, uint64_t now_ns)
{
    seen_t *seen = &events->seen[position];
    uint8_t fresh = (uint8_t)(slave->emergency_put - seen->emergencies);
    if (fresh > ECT_EMERGENCY_QUEUE)
        fresh = slave->emergency_put < ECT_EMERGENCY_QUEUE ? slave->emergency_put : (uint8_t)ECT_EMERGENCY_QUEUE;
    seen->emergencies = slave->emergency_put;
    for (; fresh > 0; fresh--) {
        const ect_emergency_t *emergency =
            &slave->emergency[(uint8_t)(slave->emergency_put - fresh) % ECT_EMERGENCY_QUEUE];
        event_t *event = add(events, position, now_ns);
        event->emergency = true;
        event->code = emergency->code;
        event->error_register = emergency->error_register;
        memcpy(event->data, emergency->data, sizeof event->data);
    }
}

void ect_events_look(ect_events_t *events, const ect_chain_t *chain, size_t position, uint64_t now_ns)
{
    const ect_slave_t *slave = ect_chain_slave(chain, position);
    look_at_state(events, slave, position, now_ns);
    look_at_emergencies(events, slave, position, now_ns);
}

static void write_state(const event_t *event, ect_line_t *line)
{
    char text[TEXT];
    const char *state =
        event->state == 0 ? "off the bus" : ect_state_text(event->state | (event->error ? (unsigned)ECT_AL_ERROR : 0u));
    const char *cause = ect_al_status_text(event->code);
    ect_line_string(line, "event", "state");
    ect_line_number(line, "state", event->state);
    ect_line_number(line, "code", event->code);
    if (event->code == 0)
        snprintf(text, sizeof text, "%s", state);
    else
        snprintf(text, sizeof text, "%s, AL status code 0x%04X%s%s", state, event->code, cause ? ": " : "",
                 cause ? cause : "");
    ect_line_string(line, "text", text);
}

static void write_emergency(const event_t *event, ect_line_t *line)
{
    char text[TEXT];
    char data[2 * sizeof event->data + 1];
    for (size_t i = 0; i < sizeof event->data; i++)
        snprintf(data + 2 * i, 3, "%02x", event->data[i]);
    ect_line_string(line, "event", "emergency");
    ect_line_number(line, "code", event->code);
    ect_line_number(line, "register", event->error_register);
    ect_line_string(line, "data", data);
    snprintf(text, sizeof text, "emergency 0x%04X: %s", event->code, ect_emergency_text(event->code));
    ect_line_string(line, "text", text);
}

bool ect_events_next(const ect_events_t *events, const ect_chain_t *chain, uint64_t *number, uint64_t start_ns,
                     ect_line_t *line)
{
    if (*number >= events->count)
        return false;
    uint64_t lost = events->count > ECT_EVENTS ? events->count - ECT_EVENTS : 0;
    *number = (*number > lost ? *number : lost) + 1;
    const event_t *event = &events->event[*number % ECT_EVENTS];
    const char *name = ect_names_at(ect_chain_names(chain), event->position);
    ECT_ASSERT(event->position < ect_chain_count(chain));
    ect_line_begin(line);
    ect_line_number(line, "number", *number);
    ect_line_number(line, "slave", event->position + 1);
    if (name)
        ect_line_string(line, "twin", name);
    if (event->emergency)
        write_emergency(event, line);
    else
        write_state(event, line);
    ect_line_time(line, event->time_ns > start_ns ? event->time_ns - start_ns : 0);
    ect_line_end(line);
    return true;
}
