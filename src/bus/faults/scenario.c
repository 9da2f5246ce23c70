/* SPDX-License-Identifier: MIT */
#include "bus/faults/scenario.h"

#include <stdio.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "esc/route.h"
#include "seams/random.h"
#include "wire/assert.h"
#include "wire/bytes.h"

/* --- a script ----------------------------------------------------------------------------------------------------- */

static bool is_space(char c)
{
    return c == ' ' || c == '\t';
}

/* Removes comment, line end and surrounding spaces of a line. A line that is too long is truncated, and then refused as
 * invalid. */
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

/* "name TEXT" */
static bool read_name(ect_scenario_t *s, const char *text)
{
    if (strncmp(text, "name ", 5) != 0)
        return false;
    snprintf(s->name, sizeof s->name, "%.*s", (int)sizeof s->name - 1, text + 5);
    return true;
}

bool ect_scenario_read(ect_scenario_t *s, const char *line, char *message)
{
    char text[300];
    ect_scenario_step_t step = {.line = s->line};
    trim(line, text, sizeof text);
    if (*text == 0 || read_name(s, text))
        return true;
    if (!ect_step_read(text, s->names, &step.plan, message))
        return false;
    if (s->step_count == ECT_SCENARIO_STEPS) {
        snprintf(message, ECT_FAULT_MESSAGE, "a script has at most %d steps", ECT_SCENARIO_STEPS);
        return false;
    }
    snprintf(step.text, sizeof step.text, "%.*s", (int)sizeof step.text - 1, text);
    s->verdict.all += step.plan.action == ECT_ACTION_EXPECT;
    s->steps[s->step_count++] = step;
    s->steps_left++;
    return true;
}

uint16_t ect_scenario_highest_slave(const ect_scenario_t *s)
{
    uint16_t highest = 0;
    for (size_t i = 0; i < s->step_count; i++) {
        uint16_t its = ect_step_highest_slave(&s->steps[i].plan);
        highest = its > highest ? its : highest;
    }
    return highest;
}

/* Splits the next word "NAME=VALUE" into two parts in `room`. @return false: no further word */
static bool next_setting(const char **text, char room[ECT_STEP_ACTION], ect_setting_t *setting)
{
    size_t length = strcspn(*text, " ");
    if (length == 0)
        return false;
    snprintf(room, ECT_STEP_ACTION, "%.*s", (int)length, *text);
    *text += length + ((*text)[length] == ' ' ? 1 : 0);
    char *equals = strchr(room, '=');
    ECT_ASSERT(equals);
    *equals = 0;
    *setting = (ect_setting_t){.name = room, .value = equals + 1};
    return true;
}

static bool has_signal(const ect_chain_t *chain, const ect_step_t *plan, const char *name, ect_signal_ref_t *ref,
                       char *message)
{
    if (ect_chain_signal(chain, plan->slave - 1u, name, ref))
        return true;
    snprintf(message, ECT_STEP_MESSAGE,
             "slave %u has no signal '%.60s': 'ectwin list-signals -n %u' lists those of running twins", plan->slave,
             name, plan->slave);
    return false;
}

/* @return whether the signals of a step exist and take their values */
static bool check_signals(const ect_chain_t *chain, const ect_step_t *plan, char *message)
{
    char room[ECT_STEP_ACTION];
    const char *text = plan->text;
    ect_signal_ref_t ref;
    ect_setting_t setting;
    ect_condition_t condition;
    if (plan->action == ECT_ACTION_EXPECT)
        return ect_condition_read(text, &condition) && has_signal(chain, plan, condition.name, &ref, message);
    while (next_setting(&text, room, &setting)) {
        if (!has_signal(chain, plan, setting.name, &ref, message) || !ect_signal_check(&ref, setting.value, message))
            return false;
    }
    return true;
}

const ect_scenario_step_t *ect_scenario_check(const ect_scenario_t *s, const ect_chain_t *chain, char *message)
{
    _Static_assert((int)ECT_SIGNAL_MESSAGE <= (int)ECT_STEP_MESSAGE, "the room includes a message of a signal");
    for (size_t i = 0; i < s->step_count; i++) {
        const ect_step_t *plan = &s->steps[i].plan;
        if (ect_step_highest_slave(plan) > ect_chain_count(chain)) {
            snprintf(message, ECT_STEP_MESSAGE, "there is no slave %u: the chain has %zu", ect_step_highest_slave(plan),
                     ect_chain_count(chain));
            return &s->steps[i];
        }
        if (plan->action != ECT_ACTION_FAULT && !check_signals(chain, plan, message))
            return &s->steps[i];
    }
    return NULL;
}

/* --- setting ------------------------------------------------------------------------------------------------------ */

static bool set_of_frames(ect_scenario_t *s, const ect_fault_t *fault, char *message)
{
    if (s->set_count == ECT_SCENARIO_FAULTS) {
        snprintf(message, ECT_FAULT_MESSAGE, "%d faults are set already: 'off' ends them", ECT_SCENARIO_FAULTS);
        return false;
    }
    ECT_ASSERT(fault->kind < ECT_FAULT_OFF && s->set_count < ECT_SCENARIO_FAULTS);
    s->set[s->set_count].frames = 0;
    s->set[s->set_count++].fault = *fault;
    return true;
}

static bool set(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns, char *message)
{
    if (fault->slave > ect_chain_count(chain)) {
        snprintf(message, ECT_FAULT_MESSAGE, "there is no slave %u: the chain has %zu", fault->slave,
                 ect_chain_count(chain));
        return false;
    }
    if (fault->kind == ECT_FAULT_OFF) {
        s->set_count = 0;
        ect_chain_fault_end(chain, 0);
        return true;
    }
    if (ect_fault_is_of_frames(fault))
        return set_of_frames(s, fault, message);
    ect_fault_t seeded = *fault;
    if (fault->when == ECT_FAULT_SHARE)
        seeded.seed = ect_random_next(&s->seed);
    const char *why = ect_chain_fault(chain, &seeded, now_ns);
    if (why)
        snprintf(message, ECT_FAULT_MESSAGE, "slave %u: %s", fault->slave, why);
    return !why;
}

static void note(const ect_scenario_t *s, const char *text)
{
    if (s->done)
        s->done(s->observer, text);
}

bool ect_scenario_set(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns, char *message)
{
    char text[ECT_FAULT_TEXT];
    if (!set(s, chain, fault, now_ns, message))
        return false;
    ect_fault_print_named(fault, ect_chain_names(chain), text);
    note(s, text);
    return true;
}

/* @return whether a step that is not over has set the fault */
static bool is_of_step(const ect_scenario_t *s, const ect_fault_t *fault)
{
    size_t step = fault->tag > 0 ? (fault->tag - 1u) / 2u : s->step_count;
    return step < s->step_count && s->steps[step].progress != ECT_STEP_OVER;
}

/* @return the i-th fault that is set; NULL: none */
static const ect_fault_t *fault_at(const ect_scenario_t *s, const ect_chain_t *chain, size_t i)
{
    return i < s->set_count ? &s->set[i].fault : ect_chain_fault_at(chain, i - s->set_count);
}

bool ect_scenario_left(const ect_scenario_t *s, const ect_chain_t *chain, size_t i, char *text)
{
    _Static_assert((int)ECT_FAULT_TEXT <= (int)ECT_STEP_LINE, "the room includes a fault");
    const ect_fault_t *fault;
    for (size_t n = 0; (fault = fault_at(s, chain, n)) != NULL; n++) {
        if (fault->kind == ECT_FAULT_COUNT || is_of_step(s, fault))
            continue;
        if (i-- == 0) {
            ect_fault_print_named(fault, ect_chain_names(chain), text);
            return true;
        }
    }
    for (size_t n = 0; n < s->step_count; n++) {
        if (s->steps[n].progress != ECT_STEP_OVER && i-- == 0) {
            memcpy(text, s->steps[n].text, ECT_STEP_LINE);
            return true;
        }
    }
    return false;
}

bool ect_scenario_show(const ect_scenario_t *s, const ect_chain_t *chain, size_t i, char *text)
{
    const ect_fault_t *fault = fault_at(s, chain, i);
    if (fault)
        ect_fault_print_named(fault, ect_chain_names(chain), text);
    return fault != NULL;
}

/* Ends the fault of a step: removes a lasting fault, or executes the opposite of a fault of a slave. */
static void end_fault(ect_scenario_t *s, ect_chain_t *chain, const ect_fault_t *fault, uint64_t now_ns)
{
    size_t kept = 0;
    for (size_t i = 0; i < s->set_count; i++) {
        if (s->set[i].fault.tag != fault->tag)
            s->set[kept++] = s->set[i];
    }
    s->set_count = kept;
    ect_chain_fault_end(chain, fault->tag);
    ect_fault_t opposite = {.kind = fault->kind == ECT_FAULT_HANG ? ECT_FAULT_RESUME : ECT_FAULT_EEPROM_OK,
                            .slave = fault->slave};
    if (!ect_fault_is_of_frames(fault) && !ect_fault_is_above_wire(fault))
        (void)ect_chain_fault(chain, &opposite, now_ns);
}

/* --- steps -------------------------------------------------------------------------------------------------------- */

/* The tags of a step: for its fault, and for the count of its milestone. */
static uint32_t tag_of(const ect_scenario_t *s, const ect_scenario_step_t *step, bool count)
{
    return 1u + 2u * (uint32_t)(step - s->steps) + count;
}

static void refuse(const ect_scenario_t *s, const ect_scenario_step_t *step, const char *why)
{
    char text[ECT_FAULT_TEXT];
    if (!s->refused)
        return;
    if (step->plan.action == ECT_ACTION_FAULT)
        ect_fault_print_named(&step->plan.fault, s->names, text);
    s->refused(s->ctx, step->plan.action == ECT_ACTION_FAULT ? text : step->text, why);
}

/* Starts to count the transfers of a milestone, for one slave or all. */
static void begin_count(const ect_scenario_t *s, ect_chain_t *chain, const ect_scenario_step_t *step,
                        const ect_milestone_t *m, uint64_t now_ns)
{
    ect_fault_t count = {.kind = ECT_FAULT_COUNT, .object = m->object, .tag = tag_of(s, step, true)};
    size_t last = m->slave != 0 ? m->slave : ect_chain_count(chain);
    for (size_t slave = m->slave != 0 ? m->slave : 1; slave <= last; slave++) {
        count.slave = (uint16_t)slave;
        const char *why = ect_chain_fault(chain, &count, now_ns);
        if (why)
            refuse(s, step, why);
    }
}

static bool is_in_state(const ect_chain_t *chain, const ect_milestone_t *m)
{
    return m->slave <= ect_chain_count(chain) && ect_chain_slave(chain, m->slave - 1u)->state == m->value;
}

/* @return whether the slave is in the state again, after another state */
static bool is_back(const ect_chain_t *chain, ect_scenario_step_t *step, const ect_milestone_t *m)
{
    bool in_state = is_in_state(chain, m);
    step->left |= !in_state;
    return in_state && step->left;
}

static bool is_reached(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, const ect_milestone_t *m,
                       uint64_t now_ns)
{
    if (!step->current && m->kind == ECT_MILESTONE_SDO)
        begin_count(s, chain, step, m, now_ns);
    step->current = true;
    switch (m->kind) {
    case ECT_MILESTONE_TIME:
        return now_ns - s->start_ns >= m->value;
    case ECT_MILESTONE_DELAY:
        return now_ns - step->base_ns >= m->value;
    case ECT_MILESTONE_FRAME:
        return s->frames >= m->value;
    case ECT_MILESTONE_CYCLES:
        return s->cycles - step->base_cycles >= m->value;
    case ECT_MILESTONE_STATE:
        return is_in_state(chain, m);
    case ECT_MILESTONE_AGAIN:
        return is_back(chain, step, m);
    case ECT_MILESTONE_LEFT:
        return !is_in_state(chain, m);
    case ECT_MILESTONE_SDO:
        return ect_chain_fault_seen(chain, tag_of(s, step, true)) >= m->value;
    default:
        return false;
    }
}

/* @return the time at which a milestone is reached; ECT_NEVER: not by time */
static uint64_t due_ns(const ect_scenario_t *s, const ect_scenario_step_t *step, const ect_milestone_t *m)
{
    return m->kind == ECT_MILESTONE_TIME    ? s->start_ns + m->value
           : m->kind == ECT_MILESTONE_DELAY ? step->base_ns + m->value
                                            : ECT_NEVER;
}

/* Sets the start of the next milestone. */
static void pass(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, const ect_milestone_t *m,
                 uint64_t now_ns)
{
    if (m->kind == ECT_MILESTONE_SDO)
        ect_chain_fault_end(chain, tag_of(s, step, true));
    step->current = step->left = false;
    step->base_ns = now_ns;
    step->base_cycles = s->cycles;
}

/* --- progress ----------------------------------------------------------------------------------------------------- */

static const char *verdict_word(const ect_scenario_t *s)
{
    if (s->verdict.failed > 0)
        return "failed";
    if (s->verdict.all > 0 && s->verdict.met == s->verdict.all)
        return "met";
    return s->steps_left > 0 ? "running" : "over";
}

/* @param step  the step that has begun or ended; NULL: none */
static void show_progress(ect_scenario_t *s, const ect_scenario_step_t *step)
{
    ect_progress_t *p = &s->progress;
    p->steps = (uint32_t)s->step_count;
    p->over = (uint32_t)(s->step_count - s->steps_left);
    p->expected = s->verdict.all;
    p->met = s->verdict.met;
    p->failed = s->verdict.failed;
    snprintf(p->verdict, sizeof p->verdict, "%s", verdict_word(s));
    if (!step)
        return;
    p->line = step->line;
    snprintf(p->step, sizeof p->step, "%.*s", (int)sizeof p->step - 1, step->text);
}

/* --- actions ------------------------------------------------------------------------------------------------------ */

static void step_over(ect_scenario_t *s, ect_scenario_step_t *step)
{
    ECT_ASSERT(step->progress != ECT_STEP_OVER && s->steps_left > 0);
    step->progress = ECT_STEP_OVER;
    s->steps_left--;
    s->acted = true; /* clients of a bus without traffic receive the change */
    show_progress(s, step);
}

static void judge(ect_scenario_t *s, ect_scenario_step_t *step, bool met, const char *why)
{
    char text[ECT_STEP_LINE + ECT_STEP_MESSAGE + 64];
    s->verdict.met += met;
    s->verdict.failed += !met;
    step->met = met;
    snprintf(step->why, sizeof step->why, "%s", met ? "" : why);
    step_over(s, step);
    (void)ect_scenario_print(step, text, sizeof text);
    note(s, text);
    if (s->judged)
        s->judged(s->ctx, step);
}

/* Sets signals; if the step has an end, the previous value is stored first. */
static void set_signals(const ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, uint64_t now_ns)
{
    enum { MOST = ECT_STEP_ACTION / 4 };
    char rooms[MOST][ECT_STEP_ACTION], message[ECT_SIGNAL_MESSAGE];
    ect_setting_t settings[MOST];
    ect_signal_ref_t ref;
    const char *text = step->plan.text;
    size_t count = 0, position = step->plan.slave - 1u;
    while (count < MOST && next_setting(&text, rooms[count], &settings[count]))
        count++;
    if (step->plan.until.kind != ECT_MILESTONE_NONE && ect_chain_signal(chain, position, settings[0].name, &ref))
        ect_signal_read(&ref, step->before);
    if (!ect_settings_apply(chain, position, settings, count, now_ns, message))
        refuse(s, step, message);
}

/* Restores the value at the end of SET: a step with an end has one signal. */
static void set_again(const ect_scenario_t *s, ect_chain_t *chain, const ect_scenario_step_t *step, uint64_t now_ns)
{
    char room[ECT_STEP_ACTION], message[ECT_SIGNAL_MESSAGE];
    const char *text = step->plan.text;
    ect_setting_t setting;
    bool named = next_setting(&text, room, &setting);
    ECT_ASSERT(named && *text == 0);
    setting.value = step->before;
    if (named && !ect_settings_apply(chain, step->plan.slave - 1u, &setting, 1, now_ns, message))
        refuse(s, step, message);
}

static void act(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, uint64_t now_ns)
{
    char message[ECT_FAULT_MESSAGE];
    step->progress = ECT_STEP_ACTS;
    show_progress(s, step);
    if (step->plan.action == ECT_ACTION_SET) {
        note(s, step->text);
        set_signals(s, chain, step, now_ns);
    } else if (step->plan.action == ECT_ACTION_FAULT) {
        ect_fault_t fault = step->plan.fault;
        fault.tag = tag_of(s, step, false);
        if (!ect_scenario_set(s, chain, &fault, now_ns, message))
            refuse(s, step, message);
    } else {
        return;
    }
    s->acted = true;
}

static void undo(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, uint64_t now_ns)
{
    ect_fault_t fault = step->plan.fault;
    char text[ECT_STEP_LINE + 16];
    fault.tag = tag_of(s, step, false);
    s->acted = true;
    snprintf(text, sizeof text, "end of: %s", step->text);
    note(s, text);
    if (step->plan.action == ECT_ACTION_FAULT)
        end_fault(s, chain, &fault, now_ns);
    else
        set_again(s, chain, step, now_ns);
}

/* @return whether the condition of an expectation is fulfilled now. @param[out] why on false, a line with the reason */
static bool is_as_expected(const ect_chain_t *chain, const ect_step_t *plan, char *why)
{
    ect_condition_t condition;
    ect_signal_ref_t ref;
    char value[ECT_SIGNAL_TEXT_ROOM];
    if (!ect_condition_read(plan->text, &condition) || !has_signal(chain, plan, condition.name, &ref, why))
        return false;
    ect_signal_read(&ref, value);
    snprintf(why, ECT_STEP_MESSAGE, "%.60s is %.120s", condition.name, value);
    return ect_condition_met(&condition, value);
}

/* Judges an expectation. Without an end the verdict is immediate. An expectation for a time fails as soon as its
 * condition is false; an expectation within a time is met as soon as its condition is true. */
static void expect(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, uint64_t now_ns)
{
    char why[ECT_STEP_MESSAGE];
    const ect_step_t *plan = &step->plan;
    bool met = is_as_expected(chain, plan, why);
    bool ends = plan->until.kind == ECT_MILESTONE_NONE || is_reached(s, chain, step, &plan->until, now_ns);
    if (ends && plan->repeats)
        met = true; /* the condition was true throughout the state */
    if (ends || met != plan->holds)
        judge(s, step, met, met ? "" : why);
}

/* Ends an active step if its end is reached. */
static void go_on(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, uint64_t now_ns)
{
    const ect_step_t *plan = &step->plan;
    if (plan->action == ECT_ACTION_EXPECT) {
        expect(s, chain, step, now_ns);
        return;
    }
    if (plan->until.kind == ECT_MILESTONE_NONE) {
        step_over(s, step);
        return;
    }
    if (!is_reached(s, chain, step, &plan->until, now_ns))
        return;
    undo(s, chain, step, now_ns);
    pass(s, chain, step, &plan->until, now_ns);
    if (plan->repeats) {
        step->progress = ECT_STEP_WAITS;
        step->reached--;
    } else {
        step_over(s, step);
    }
}

/* Advances a step as far as possible. @return the time at which it continues; ECT_NEVER: not by time */
static uint64_t advance(ect_scenario_t *s, ect_chain_t *chain, ect_scenario_step_t *step, uint64_t now_ns)
{
    const ect_step_t *plan = &step->plan;
    while (step->progress == ECT_STEP_WAITS && step->reached < plan->when_count) {
        const ect_milestone_t *m = &plan->when[step->reached];
        if (!is_reached(s, chain, step, m, now_ns))
            return due_ns(s, step, m);
        pass(s, chain, step, m, now_ns);
        step->reached++;
    }
    if (step->progress == ECT_STEP_WAITS)
        act(s, chain, step, now_ns);
    go_on(s, chain, step, now_ns);
    return step->progress == ECT_STEP_ACTS ? due_ns(s, step, &plan->until) : ECT_NEVER;
}

static void begin(ect_scenario_t *s, uint64_t now_ns)
{
    s->start_ns = now_ns;
    for (size_t i = 0; i < s->step_count; i++)
        s->steps[i].base_ns = now_ns;
    show_progress(s, NULL);
}

/* Plays due rows of tables, one time after the other, so that devices and clients receive the values of each time even
 * after a late call. @return the time at which the next row is due */
static uint64_t play_tables(ect_scenario_t *s, ect_chain_t *chain, uint64_t now_ns)
{
    uint64_t next_ns = ECT_NEVER;
    char message[ECT_SIGNAL_MESSAGE];
    for (ect_table_t *table = s->tables; table; table = table->next) {
        uint64_t due_at_ns = ect_table_due(table);
        while (due_at_ns <= now_ns - s->start_ns && ect_table_due(table) == due_at_ns) {
            s->acted = true;
            if (!ect_table_play(table, chain, now_ns, message) && s->refused)
                s->refused(s->ctx, "row of a table", message);
        }
        if (ect_table_due(table) != ECT_NEVER)
            next_ns = ect_earlier(next_ns, s->start_ns + ect_table_due(table));
    }
    s->tables_over = next_ns == ECT_NEVER;
    return next_ns;
}

uint64_t ect_scenario_tick(ect_scenario_t *s, ect_chain_t *chain, uint64_t now_ns)
{
    uint64_t next_ns = ect_wires_due(&s->wires);
    if (s->start_ns == 0)
        begin(s, now_ns);
    next_ns = ect_earlier(next_ns, play_tables(s, chain, now_ns));
    next_ns = ect_earlier(next_ns, ect_waves_run(&s->waves, chain, now_ns, &s->acted, s->refused, s->ctx));
    for (size_t i = 0; s->steps_left > 0 && i < s->step_count; i++) {
        if (s->steps[i].progress == ECT_STEP_OVER)
            continue;
        next_ns = ect_earlier(next_ns, advance(s, chain, &s->steps[i], now_ns));
    }
    return next_ns;
}

int ect_scenario_print(const ect_scenario_step_t *step, char *text, size_t room)
{
    char line[32] = "";
    if (step->line != 0)
        snprintf(line, sizeof line, "line %u: ", step->line);
    return snprintf(text, room, "%s'%s' %s%s", line, step->text, step->met ? "is met" : "has failed: ", step->why);
}

int ect_scenario_print_verdict(const ect_scenario_t *s, char *text, size_t room)
{
    const ect_verdict_t *v = &s->verdict;
    bool named = s->name[0] != 0;
    return snprintf(text, room, "%s%s%s%u of %u expectations are met", named ? "'" : "", s->name, named ? "': " : "",
                    v->met, v->all);
}

ect_verdict_t ect_scenario_end(ect_scenario_t *s)
{
    for (size_t i = 0; i < s->step_count; i++) {
        ect_scenario_step_t *step = &s->steps[i];
        if (step->plan.action == ECT_ACTION_EXPECT && step->progress != ECT_STEP_OVER)
            judge(s, step, false,
                  step->progress == ECT_STEP_ACTS ? "the run ended before" : "the run ended before its milestone");
    }
    return s->verdict;
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

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

/* @return whether the frame contains a logical datagram */
static bool has_process_data(uint8_t *frame, size_t length)
{
    size_t at = ect_frame_datagrams(frame, length);
    for (uint8_t *d = at != 0 ? frame + at : NULL; d; d = ect_datagram_next(d)) {
        if (ect_command_direction(d[ECT_DATAGRAM_COMMAND]) != 0)
            return true;
    }
    return false;
}

ect_frame_effects_t ect_scenario_frame(ect_scenario_t *s, ect_chain_t *chain, uint8_t *frame, size_t *length,
                                       uint64_t now_ns)
{
    ect_frame_effects_t effects = {0};
    s->frames++;
    s->cycles += has_process_data(frame, *length);
    (void)ect_scenario_tick(s, chain, now_ns);
    ect_wires_begin(&s->wires, &s->seed, now_ns);
    size_t kept = 0;
    for (size_t i = 0; i < s->set_count; i++) {
        const ect_fault_t *fault = &s->set[i].fault;
        bool now = ect_fault_applies(fault, ++s->set[i].frames, &s->seed);
        if (now && fault->slave != 0)
            ect_wires_add(&s->wires, fault);
        else if (now)
            apply_fault(s, fault, frame, length, &effects);
        if (!(now && fault->when == ECT_FAULT_ONCE))
            s->set[kept++] = s->set[i];
    }
    s->set_count = kept;
    if (!effects.lose_request) /* else the effect would apply to the next frame */
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
