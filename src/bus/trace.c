/* SPDX-License-Identifier: MIT */
#include "bus/trace.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* The AL state and the code that a twin had, off the bus 0. */
typedef struct seen {
    uint8_t state;
    uint16_t code;
} seen_t;

struct ect_trace {
    ect_capture_t *capture;
    size_t count;
    seen_t seen[];
};

ect_trace_t *ect_trace_new(ect_capture_t *capture, size_t count)
{
    ect_trace_t *t = calloc(1, sizeof *t + count * sizeof t->seen[0]);
    if (!t)
        return NULL;
    t->capture = capture;
    t->count = count;
    for (size_t i = 0; i < count; i++)
        t->seen[i].state = ECT_STATE_INIT;
    return t;
}

bool ect_trace_request(ect_trace_t *t, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length)
{
    return ect_capture_frame(t->capture, end, ECT_PCAPNG_INBOUND, now_ns, frame, length);
}

bool ect_trace_reply(ect_trace_t *t, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length)
{
    return ect_capture_frame(t->capture, end, ECT_PCAPNG_OUTBOUND, now_ns, frame, length);
}

void ect_trace_note(ect_trace_t *t, const char *format, ...)
{
    char text[ECT_PCAPNG_COMMENT_MOST];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text, sizeof text, format, values);
    va_end(values);
    ect_capture_comment(t->capture, text);
}

void ect_trace_effects(ect_trace_t *t, const ect_frame_effects_t *effects, bool changed)
{
    if (changed)
        ect_trace_note(t, "fault: the request is changed");
    if (effects->lose_request)
        ect_trace_note(t, "fault: the request is lost");
    if (effects->lose_reply)
        ect_trace_note(t, "fault: the reply is lost");
    if (effects->twice)
        ect_trace_note(t, "fault: the reply leaves twice");
    if (effects->after_next)
        ect_trace_note(t, "fault: the reply leaves after the next one");
    if (effects->delay_us > 0)
        ect_trace_note(t, "fault: the reply leaves %u us late", effects->delay_us);
    if (effects->counter != 0)
        ect_trace_note(t, "fault: working counter %+d", effects->counter);
}

static const char *state_name(uint8_t state)
{
    switch (state) {
    case 0:
        return "off the bus";
    case ECT_STATE_INIT:
        return "INIT";
    case ECT_STATE_PREOP:
        return "PREOP";
    case ECT_STATE_BOOT:
        return "BOOT";
    case ECT_STATE_SAFEOP:
        return "SAFEOP";
    default:
        return "OP";
    }
}

void ect_trace_states(ect_trace_t *t, const ect_chain_t *chain)
{
    for (size_t i = 0; i < t->count; i++) {
        const ect_slave_t *slave = ect_chain_slave(chain, i);
        const seen_t now = {.state = slave->off_bus ? 0 : slave->state, .code = slave->off_bus ? 0 : slave->code};
        seen_t *seen = &t->seen[i];
        if (now.state == seen->state && now.code == seen->code)
            continue;
        *seen = now;
        if (now.code != 0)
            ect_trace_note(t, "slave %zu: %s, AL status code 0x%04X", i + 1, state_name(now.state), now.code);
        else
            ect_trace_note(t, "slave %zu: %s", i + 1, state_name(now.state));
    }
}

void ect_trace_flush(ect_trace_t *t)
{
    ect_capture_flush(t->capture);
}

bool ect_trace_start(ect_trace_t *t)
{
    return ect_capture_start(t->capture);
}

int ect_trace_close(ect_trace_t *t, uint64_t now_ns)
{
    if (!t)
        return 0;
    int failed = ect_capture_close(t->capture, now_ns);
    free(t);
    return failed;
}
