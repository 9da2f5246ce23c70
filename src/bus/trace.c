/* SPDX-License-Identifier: MIT */
#include "bus/trace.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/state.h"

/* The last recorded AL state and AL status code of a twin; 0: off the bus. */
typedef struct seen {
    uint8_t state;
    uint16_t code;
} seen_t;

enum { FILES = 2, CAPTURE = 0, RECORD = 1 };

struct ect_trace {
    ect_capture_t *files[FILES]; /* NULL: none */
    bool record_ends;            /* a line did not fit */
    size_t count;
    seen_t seen[];
};

ect_trace_t *ect_trace_new(ect_capture_t *capture, ect_capture_t *record, size_t count)
{
    ect_trace_t *t = calloc(1, sizeof *t + count * sizeof t->seen[0]);
    if (!t)
        return NULL;
    t->files[CAPTURE] = capture;
    t->files[RECORD] = record;
    t->count = count;
    for (size_t i = 0; i < count; i++)
        t->seen[i].state = ECT_STATE_INIT;
    return t;
}

static bool recording(const ect_trace_t *t)
{
    return t->files[RECORD] && !t->record_ends;
}

void ect_trace_log(ect_trace_t *t, ect_logged_kind_t kind, uint32_t value, uint64_t time_ns, const char *text,
                   size_t length)
{
    if (!recording(t))
        return;
    uint8_t small[256];
    uint8_t *body = ECT_LOGGED_HEAD + length <= sizeof small ? small : malloc(ECT_LOGGED_HEAD + length);
    if (body) {
        ect_logged_head(body, kind, value, time_ns);
        if (length > 0)
            memcpy(body + ECT_LOGGED_HEAD, text, length);
    }
    t->record_ends = !body || !ect_capture_local(t->files[RECORD], body, ECT_LOGGED_HEAD + length);
    if (body != small)
        free(body);
}

static bool add_frame(ect_trace_t *t, ect_end_t end, ect_pcapng_direction_t direction, uint64_t now_ns,
                      const uint8_t *frame, size_t length)
{
    if (recording(t))
        t->record_ends = !ect_capture_frame(t->files[RECORD], end, direction, now_ns, frame, length);
    return !t->files[CAPTURE] || ect_capture_frame(t->files[CAPTURE], end, direction, now_ns, frame, length);
}

bool ect_trace_request(ect_trace_t *t, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length)
{
    return add_frame(t, end, ECT_PCAPNG_INBOUND, now_ns, frame, length);
}

bool ect_trace_reply(ect_trace_t *t, ect_end_t end, uint64_t now_ns, const uint8_t *frame, size_t length)
{
    return add_frame(t, end, ECT_PCAPNG_OUTBOUND, now_ns, frame, length);
}

void ect_trace_note(ect_trace_t *t, const char *format, ...)
{
    char text[ECT_PCAPNG_COMMENT_MOST];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text, sizeof text, format, values);
    va_end(values);
    for (unsigned int i = 0; i < FILES; i++) {
        if (t->files[i])
            ect_capture_comment(t->files[i], text);
    }
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
    return state == 0 ? "off the bus" : ect_state_text(state);
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
    for (unsigned int i = 0; i < FILES; i++) {
        if (t->files[i])
            ect_capture_flush(t->files[i]);
    }
}

void ect_trace_start(ect_trace_t *t)
{
    for (unsigned int i = 0; i < FILES; i++) {
        if (t->files[i])
            (void)ect_capture_start(t->files[i]);
    }
}

ect_trace_lacks_t ect_trace_close(ect_trace_t *t, uint64_t now_ns)
{
    ect_trace_lacks_t lacks = {0};
    uint8_t lost[ECT_LOGGED_HEAD];
    if (!t)
        return lacks;
    ect_logged_head(lost, ECT_LOGGED_LOST, 0, now_ns);
    lacks.record_is_slow = t->record_ends;
    lacks.capture = ect_capture_close(t->files[CAPTURE], NULL, 0, now_ns);
    lacks.record = ect_capture_close(t->files[RECORD], lost, t->record_ends ? sizeof lost : 0, now_ns);
    free(t);
    return lacks;
}
