/* SPDX-License-Identifier: MIT */
#include "bus/faults/scenario.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "seams/random.h"
#include "text/number.h"
#include "wire/assert.h"

enum { NS_PER_S = 1000000000 };

/* --- a script ----------------------------------------------------------------------------------------------------- */

static bool state_of(const char *name, size_t length, uint64_t *state)
{
    static const struct {
        const char *name;
        uint8_t state;
    } states[] = {{"INIT", ECT_STATE_INIT},
                  {"PREOP", ECT_STATE_PREOP},
                  {"BOOT", ECT_STATE_BOOT},
                  {"SAFEOP", ECT_STATE_SAFEOP},
                  {"OP", ECT_STATE_OP}};
    for (size_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        if (strlen(states[i].name) == length && strncmp(states[i].name, name, length) == 0) {
            *state = states[i].state;
            return true;
        }
    }
    return false;
}

/* "frame 100 " @return what follows; NULL: it is not that */
static const char *read_frame(const char *text, ect_scenario_step_t *step)
{
    const char *end = ect_number_begins(text, 0, UINT64_MAX, &step->value);
    step->when = ECT_STEP_AT_FRAME;
    return end && *end == ' ' ? end + 1 : NULL;
}

/* "1 OP " */
static const char *read_state(const char *text, ect_scenario_step_t *step)
{
    uint64_t slave = 0;
    const char *end = ect_number_begins(text, 1, UINT16_MAX, &slave);
    if (!end || *end != ' ')
        return NULL;
    const char *name = end + 1;
    size_t length = strcspn(name, " ");
    step->when = ECT_STEP_AT_STATE;
    step->slave = (uint16_t)slave;
    return state_of(name, length, &step->value) && name[length] == ' ' ? name + length + 1 : NULL;
}

/* "2.5s " */
static const char *read_time(const char *text, ect_scenario_step_t *step)
{
    char *end = NULL;
    double seconds = strtod(text, &end);
    if (end == text || !(seconds >= 0 && seconds < 1e9) || strncmp(end, "s ", 2) != 0)
        return NULL;
    step->when = ECT_STEP_AT_TIME;
    step->value = (uint64_t)(seconds * (double)NS_PER_S);
    return end + 2;
}

/* "at ..." at the beginning of a line; without it at 0 s. @return what follows; NULL: it makes no sense */
static const char *read_when(const char *text, ect_scenario_step_t *step)
{
    if (strncmp(text, "at ", 3) != 0)
        return text;
    text += 3;
    if (strncmp(text, "frame ", 6) == 0)
        return read_frame(text + 6, step);
    if (strncmp(text, "slave ", 6) == 0)
        return read_state(text + 6, step);
    return read_time(text, step);
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t';
}

/* A line without its comment, its end, and spaces around it; what is too long is cut, and then makes no sense. */
static void trim(const char *line, char *text, size_t room)
{
    size_t length = strcspn(line, "#\r\n");
    while (length > 0 && is_space(line[length - 1]))
        length--;
    while (length > 0 && is_space(*line)) {
        line++;
        length--;
    }
    snprintf(text, room, "%.*s", (int)(length < room ? length : room - 1), line);
}

bool ect_scenario_read(ect_scenario_t *s, const char *line, char *message)
{
    char text[ECT_FAULT_TEXT + 64];
    ect_scenario_step_t step = {.when = ECT_STEP_AT_TIME};
    trim(line, text, sizeof text);
    if (*text == 0)
        return true;
    const char *fault = read_when(text, &step);
    if (!fault) {
        snprintf(message, ECT_FAULT_MESSAGE,
                 "expected 'at 2.5s', 'at frame 100' or 'at slave 1 OP', then a fault, not '%.60s'", text);
        return false;
    }
    if (!ect_fault_parse(fault, &step.fault, message))
        return false;
    if (s->step_count == ECT_SCENARIO_STEPS) {
        snprintf(message, ECT_FAULT_MESSAGE, "a script has at most %d faults", ECT_SCENARIO_STEPS);
        return false;
    }
    s->steps[s->step_count++] = step;
    s->steps_left++;
    return true;
}

uint16_t ect_scenario_highest_slave(const ect_scenario_t *s)
{
    uint16_t highest = 0;
    for (size_t i = 0; i < s->step_count; i++) {
        highest = s->steps[i].slave > highest ? s->steps[i].slave : highest;
        highest = s->steps[i].fault.slave > highest ? s->steps[i].fault.slave : highest;
    }
    return highest;
}

/* --- setting ------------------------------------------------------------------------------------------------------ */

static bool set(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns, char *message)
{
    if (fault->slave > ect_chain_count(chain)) {
        snprintf(message, ECT_FAULT_MESSAGE, "there is no slave %u: the chain has %zu", fault->slave,
                 ect_chain_count(chain));
        return false;
    }
    if (fault->kind == ECT_FAULT_OFF) {
        s->set_count = 0;
        return true;
    }
    if (!ect_fault_is_of_frames(fault)) {
        ect_chain_fault(chain, fault, now_ns);
        return true;
    }
    if (s->set_count == ECT_SCENARIO_FAULTS) {
        snprintf(message, ECT_FAULT_MESSAGE, "%d faults are set already: 'off' ends them", ECT_SCENARIO_FAULTS);
        return false;
    }
    ECT_ASSERT(fault->kind < ECT_FAULT_OFF && s->set_count < ECT_SCENARIO_FAULTS);
    s->set[s->set_count].frames = 0;
    s->set[s->set_count++].fault = *fault;
    return true;
}

bool ect_scenario_set(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns, char *message)
{
    char text[ECT_FAULT_TEXT];
    if (!set(s, chain, fault, now_ns, message))
        return false;
    ect_fault_print(fault, text);
    if (s->done)
        s->done(s->observer, text);
    return true;
}

bool ect_scenario_show(const ect_scenario_t *s, size_t i, char *text)
{
    if (i >= s->set_count)
        return false;
    ect_fault_print(&s->set[i].fault, text);
    return true;
}

static bool is_due(const ect_scenario_t *s, const ect_chain_t *chain, const ect_scenario_step_t *step, uint64_t now_ns)
{
    switch (step->when) {
    case ECT_STEP_AT_TIME:
        return now_ns - s->start_ns >= step->value;
    case ECT_STEP_AT_FRAME:
        return s->frames >= step->value;
    default:
        return step->slave <= ect_chain_count(chain) && ect_chain_slave(chain, step->slave - 1u)->state == step->value;
    }
}

/* A step that cannot be done is over too: later it would be another step. */
static void take_step(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, uint64_t now_ns)
{
    char message[ECT_FAULT_MESSAGE], text[ECT_FAULT_TEXT];
    ECT_ASSERT(!step->done && s->steps_left > 0);
    step->done = true;
    s->steps_left--;
    if (ect_scenario_set(s, chain, &step->fault, now_ns, message) || !s->refused)
        return;
    ect_fault_print(&step->fault, text);
    s->refused(s->ctx, text, message);
}

uint64_t ect_scenario_tick(ect_scenario_t *s, ect_chain_t *chain, uint64_t now_ns)
{
    uint64_t next_ns = ect_wires_due(&s->wires);
    if (s->start_ns == 0)
        s->start_ns = now_ns;
    for (size_t i = 0; s->steps_left > 0 && i < s->step_count; i++) {
        ect_scenario_step_t *step = &s->steps[i];
        if (step->done)
            continue;
        if (is_due(s, chain, step, now_ns))
            take_step(s, chain, step, now_ns);
        else if (step->when == ECT_STEP_AT_TIME && s->start_ns + step->value < next_ns)
            next_ns = s->start_ns + step->value;
    }
    return next_ns;
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

/* Whether a fault concerns this frame. Each fault with a share takes a random number, so that none depends on others.
 */
static bool applies_to_frame(ect_scenario_t *s, size_t i)
{
    const ect_fault_t *fault = &s->set[i].fault;
    uint64_t frame = ++s->set[i].frames;
    switch (fault->when) {
    case ECT_FAULT_SHARE:
        return ect_random_next(&s->seed) % 100u < fault->number;
    case ECT_FAULT_EVERY:
        return frame % fault->number == 0;
    case ECT_FAULT_ONCE:
        return frame == fault->number;
    default:
        return true;
    }
}

static void drop(ect_scenario_t *s, ect_frame_effects_t *effects)
{
    if (ect_random_next(&s->seed) % 2 == 0)
        effects->lose_request = true;
    else
        effects->lose_reply = true;
}

static void apply_fault(ect_scenario_t *s, const ect_fault_t *fault, uint8_t *frame, size_t *length,
                        ect_frame_effects_t *effects)
{
    switch (fault->kind) {
    case ECT_FAULT_DROP:
        drop(s, effects);
        return;
    case ECT_FAULT_DELAY:
        effects->delay_us += (uint32_t)fault->amount;
        return;
    case ECT_FAULT_DUPLICATE:
        effects->twice = true;
        return;
    case ECT_FAULT_REORDER:
        effects->after_next = true;
        return;
    case ECT_FAULT_TRUNCATE:
        *length -= (size_t)fault->amount < *length ? (size_t)fault->amount : *length;
        return;
    case ECT_FAULT_CORRUPT:
        ect_frame_corrupt(&s->seed, frame, *length);
        return;
    default:
        effects->counter += fault->amount;
    }
}

ect_frame_effects_t ect_scenario_frame(ect_scenario_t *s, ect_chain_t *chain, uint8_t *frame, size_t *length,
                                       uint64_t now_ns)
{
    ect_frame_effects_t effects = {0};
    s->frames++;
    (void)ect_scenario_tick(s, chain, now_ns);
    ect_wires_begin(&s->wires, &s->seed, now_ns);
    size_t kept = 0;
    for (size_t i = 0; i < s->set_count; i++) {
        const ect_fault_t *fault = &s->set[i].fault;
        bool now = applies_to_frame(s, i);
        if (now && fault->slave != 0)
            ect_wires_add(&s->wires, fault);
        else if (now)
            apply_fault(s, fault, frame, length, &effects);
        if (!(now && fault->when == ECT_FAULT_ONCE))
            s->set[kept++] = s->set[i];
    }
    s->set_count = kept;
    if (!effects.lose_request) /* else it would happen to the next one */
        ect_wires_end(&s->wires, chain);
    return effects;
}

ect_wires_result_t ect_scenario_reply(const ect_scenario_t *s, const ect_frame_effects_t *effects, uint8_t *frame,
                                      size_t *length)
{
    *length -= s->wires.cut;
    ect_frame_count(frame, *length, effects->counter);
    return s->wires.result;
}
