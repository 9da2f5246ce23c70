/* SPDX-License-Identifier: MIT */
#include "bus/chain/connect.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "wire/assert.h"

typedef struct delayed {
    uint64_t due_ns;
    double value;
} delayed_t;

typedef struct line {
    ect_connection_t c;
    bool known, set;              /* `last` is a value of the source, `sent` one of the target */
    uint8_t last[sizeof(double)]; /* as in the instance */
    double sent;
    delayed_t *values; /* a ring; NULL: no delay */
    size_t first, count;
} line_t;

struct ect_connections {
    size_t count;
    line_t lines[];
};

bool ect_connection_fits(const ect_connection_t *c)
{
    return ect_signal_is_number(c->source.signal) && ect_signal_is_number(c->target.signal) &&
           c->target.signal->access == ECT_SIGNAL_WRITE;
}

/* --- loops -------------------------------------------------------------------------------------------------------- */

/* @return whether `from` reaches `to` by connections without a delay. Each connection is followed once */
static bool reaches(const ect_connection_t *list, size_t count, size_t from, size_t to, bool *followed)
{
    if (from == to)
        return true;
    for (size_t i = 0; i < count; i++) {
        if (followed[i] || list[i].delay_ns != 0 || list[i].from != from)
            continue;
        followed[i] = true;
        if (reaches(list, count, list[i].to, to, followed))
            return true;
    }
    return false;
}

size_t ect_connections_loop(const ect_connection_t *list, size_t count)
{
    bool *followed = calloc(count + 1, sizeof *followed);
    size_t i = followed ? 0 : count;
    for (; i < count; i++) {
        memset(followed, 0, i * sizeof *followed);
        if (list[i].delay_ns == 0 && reaches(list, i, list[i].to, list[i].from, followed))
            break;
    }
    free(followed);
    return i;
}

/* --- a connection ------------------------------------------------------------------------------------------------- */

void ect_connections_free(ect_connections_t *connections)
{
    for (size_t i = 0; connections && i < connections->count; i++)
        free(connections->lines[i].values);
    free(connections);
}

ect_connections_t *ect_connections_new(const ect_connection_t *list, size_t count)
{
    ect_connections_t *result = calloc(1, sizeof *result + count * sizeof result->lines[0]);
    for (size_t i = 0; result && i < count; i++) {
        line_t *line = &result->lines[result->count++];
        line->c = list[i];
        line->values = list[i].delay_ns > 0 ? calloc(ECT_CONNECTION_VALUES, sizeof *line->values) : NULL;
        if (list[i].delay_ns > 0 && !line->values) {
            ect_connections_free(result);
            return NULL;
        }
    }
    return result;
}

static double value_of(const ect_signal_ref_t *ref)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    double real;
    if (ref->signal->type == ECT_SIGNAL_REAL) {
        memcpy(&real, ref->value, sizeof real);
        return real;
    }
    ect_signal_read(ref, text);
    return strtod(text, NULL);
}

static double result_of(const ect_connection_t *c, double value)
{
    double result = value * c->factor + c->offset;
    if (c->invert)
        result = result == 0;
    return ect_signal_fit(c->target.signal, result);
}

/* Sets the target, unless its plant refuses the value: the last value remains. @return whether the target was set */
static bool set(line_t *line, double value, uint64_t now_ns)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    char message[ECT_SIGNAL_MESSAGE];
    double result = result_of(&line->c, value);
    if (line->set && result == line->sent)
        return false;
    line->set = true;
    line->sent = result;
    (void)snprintf(text, sizeof text, "%.15g", result);
    (void)ect_signal_write(&line->c.target, text, now_ns, message);
    return true;
}

static void put(line_t *line, double value, uint64_t now_ns)
{
    size_t at = line->count < ECT_CONNECTION_VALUES ? line->count++ : line->count - 1;
    line->values[(line->first + at) % ECT_CONNECTION_VALUES] =
        (delayed_t){.due_ns = now_ns + line->c.delay_ns, .value = value};
}

/* @return whether the target was set */
static bool pass_due(line_t *line, uint64_t now_ns)
{
    bool passed = false;
    while (line->count > 0 && line->values[line->first].due_ns <= now_ns) {
        passed = set(line, line->values[line->first].value, now_ns) || passed;
        line->first = (line->first + 1) % ECT_CONNECTION_VALUES;
        line->count--;
    }
    return passed;
}

static bool run(line_t *line, uint64_t now_ns)
{
    const ect_signal_ref_t *source = &line->c.source;
    const size_t size = ect_signal_size(source->signal);
    ECT_ASSERT(size <= sizeof line->last); /* ect_connection_fits: a number */
    bool changed = !line->known || memcmp(line->last, source->value, size) != 0;
    line->known = true;
    memcpy(line->last, source->value, size);
    if (!line->values)
        return changed && set(line, value_of(source), now_ns);
    if (changed)
        put(line, value_of(source), now_ns);
    return pass_due(line, now_ns);
}

bool ect_connections_run(ect_connections_t *connections, uint64_t now_ns, void (*changed)(void *ctx, size_t position),
                         void *ctx)
{
    bool any = false;
    for (size_t i = 0; i < connections->count; i++) {
        if (!run(&connections->lines[i], now_ns))
            continue;
        changed(ctx, connections->lines[i].c.to);
        any = true;
    }
    return any;
}

uint64_t ect_connections_next(const ect_connections_t *connections)
{
    uint64_t next = ECT_NEVER;
    for (size_t i = 0; i < connections->count; i++) {
        const line_t *line = &connections->lines[i];
        if (line->count > 0)
            next = ect_earlier(next, line->values[line->first].due_ns);
    }
    return next;
}
