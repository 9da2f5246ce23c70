/* SPDX-License-Identifier: MIT */
#include "bus/faults/script.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/words.h"
#include "text/number.h"

enum { NS_PER_S = 1000000000 };

_Static_assert((int)ECT_STEP_LINE >= (int)ECT_WORDS_ROOM, "the room exceeds a line");
static const ect_words_limits_t limits = {"a line", " \t", ECT_WORDS_ROOM - 1, ECT_WORDS_MOST};

static bool take_number(ect_words_t *w, uint64_t minimum, uint64_t maximum, uint64_t *value)
{
    const char *end = ect_words_next(w) ? ect_number_begins(ect_words_next(w), minimum, maximum, value) : NULL;
    if (!end || *end != 0)
        return false;
    w->at++;
    return true;
}

/* "2.5s", "200ms", "50us" */
static bool take_duration(ect_words_t *w, uint64_t *ns)
{
    static const struct {
        const char *name;
        double ns;
    } units[] = {{"s", 1e9}, {"ms", 1e6}, {"us", 1e3}};
    char *end = NULL;
    double number = ect_words_next(w) ? strtod(ect_words_next(w), &end) : 0;
    for (size_t i = 0; end && end != ect_words_next(w) && i < sizeof units / sizeof units[0]; i++) {
        double value = number * units[i].ns;
        if (strcmp(end, units[i].name) != 0 || !(value >= 0 && value < 1e9 * (double)NS_PER_S))
            continue;
        *ns = (uint64_t)(value + 0.5);
        w->at++;
        return true;
    }
    return false;
}

/* --- milestones --------------------------------------------------------------------------------------------------- */

/* "slave 1 in OP again": only the state is mandatory. */
static bool take_state(ect_words_t *w, ect_milestone_t *m)
{
    uint64_t slave = 0;
    if (ect_words_take(w, "slave")) {
        slave = ect_words_take_twin(w);
        if (slave == 0 && !take_number(w, 1, UINT16_MAX, &slave))
            return false;
    }
    (void)ect_words_take(w, "in");
    uint8_t state = ect_words_next(w) ? ect_fault_state(ect_words_next(w)) : 0;
    if (state == 0)
        return false;
    w->at++;
    *m = (ect_milestone_t){.kind = ECT_MILESTONE_STATE, .value = state, .slave = (uint16_t)slave};
    if (ect_words_take(w, "again"))
        m->kind = ECT_MILESTONE_AGAIN;
    return true;
}

/* "the 3rd upload of 0x1018" */
static bool take_transfer(ect_words_t *w, ect_milestone_t *m)
{
    *m = (ect_milestone_t){.kind = ECT_MILESTONE_SDO};
    if (!ect_words_take(w, "the") || !ect_words_next(w))
        return false;
    m->value = ect_fault_ordinal(ect_words_next(w));
    w->at++;
    ect_fault_transfer_t transfer = ect_words_next(w) ? ect_fault_transfer(ect_words_next(w)) : ECT_FAULT_ANY_TRANSFER;
    if (m->value == 0 || transfer == ECT_FAULT_ANY_TRANSFER)
        return false;
    w->at++;
    if (!ect_words_take(w, "of") || !ect_words_next(w) || !ect_fault_read_object(ect_words_next(w), &m->object))
        return false;
    m->object.transfer = transfer;
    w->at++;
    return true;
}

static bool take_point(ect_words_t *w, ect_milestone_t *m)
{
    *m = (ect_milestone_t){.kind = ECT_MILESTONE_FRAME};
    if (ect_words_take(w, "frame"))
        return take_number(w, 0, UINT64_MAX, &m->value);
    if (take_duration(w, &m->value)) {
        m->kind = ECT_MILESTONE_TIME;
        return true;
    }
    return ect_words_next(w) && strcmp(ect_words_next(w), "the") == 0 ? take_transfer(w, m) : take_state(w, m);
}

/* "10 cycles", "100ms" */
static bool take_span(ect_words_t *w, ect_milestone_t *m)
{
    *m = (ect_milestone_t){.kind = ECT_MILESTONE_CYCLES};
    if (take_number(w, 1, 1000000000, &m->value))
        return ect_words_take(w, "cycles") || ect_words_take(w, "cycle");
    m->kind = ECT_MILESTONE_DELAY;
    return take_duration(w, &m->value);
}

static bool add_when(ect_words_t *w, ect_step_t *step, const ect_milestone_t *m, const char *word)
{
    if (step->when_count == ECT_STEP_MILESTONES)
        return ect_words_wrong(w, "a line has at most 4 milestones", word);
    if (step->repeats)
        return ect_words_wrong(w, "'while' is the last milestone of a line: expected it at the end", word);
    step->when[step->when_count++] = *m;
    return true;
}

static bool set_until(ect_words_t *w, ect_step_t *step, const ect_milestone_t *m, const char *word)
{
    if (step->until.kind != ECT_MILESTONE_NONE)
        return ect_words_wrong(w, "a line has one end: expected one of while, until, for and within", word);
    step->until = *m;
    return true;
}

/* "while in PREOP": begins in the state, and ends outside. */
static bool add_while(ect_words_t *w, ect_step_t *step, const ect_milestone_t *m, const char *word)
{
    ect_milestone_t left = *m;
    left.kind = ECT_MILESTONE_LEFT;
    if (!add_when(w, step, m, word) || !set_until(w, step, &left, word))
        return false;
    step->repeats = true;
    return true;
}

/* Reads a milestone, from its first word on. */
static bool read_milestone(ect_words_t *w, ect_step_t *step)
{
    ect_milestone_t m;
    const char *word = w->word[w->at++];
    const char *from = ect_words_next(w);
    switch (word[0]) {
    case 'a':
        if (word[1] == 't' ? take_point(w, &m) : take_span(w, &m))
            return add_when(w, step, &m, word);
        return ect_words_wrong(w,
                               word[1] == 't'
                                   ? "expected 'at 2.5s', 'at frame 100', 'at slave 1 OP' or 'at the 3rd upload of "
                                     "0x1018', then an action"
                                   : "expected 'after 100ms' or 'after 10 cycles'",
                               from);
    case 'u':
        if (take_point(w, &m))
            return set_until(w, step, &m, word);
        return ect_words_wrong(w, "expected 'until 5s', 'until slave 1 OP' or 'until OP again'", from);
    case 'w':
        if (word[1] == 'h')
            return take_state(w, &m) && m.kind == ECT_MILESTONE_STATE
                       ? add_while(w, step, &m, word)
                       : ect_words_wrong(w, "expected 'while in PREOP'", from);
        break;
    default:
        step->holds = true;
        break;
    }
    if (take_span(w, &m))
        return set_until(w, step, &m, word);
    return ect_words_wrong(w, step->holds ? "expected 'for 100ms' or 'for 10 cycles'" : "expected 'within 200ms'",
                           from);
}

static bool begins_milestone(const char *word)
{
    static const char *const firsts[] = {"at", "after", "while", "until", "for", "within"};
    for (size_t i = 0; i < sizeof firsts / sizeof firsts[0]; i++) {
        if (strcmp(word, firsts[i]) == 0)
            return true;
    }
    return false;
}

/* --- actions ------------------------------------------------------------------------------------------------------ */

bool ect_condition_read(const char *text, ect_condition_t *c)
{
    size_t length = strcspn(text, "=!<>");
    c->relation = text[length];
    if (length == 0 || length >= sizeof c->name || c->relation == 0 || (c->relation == '!' && text[length + 1] != '='))
        return false;
    snprintf(c->name, sizeof c->name, "%.*s", (int)length, text);
    c->value = text + length + (c->relation == '!' ? 2 : 1);
    char *end = NULL;
    (void)strtod(c->value, &end);
    return c->relation == '=' || c->relation == '!' || (end != c->value && *end == 0);
}

bool ect_condition_met(const ect_condition_t *c, const char *value)
{
    char *end, *value_end;
    double wanted = strtod(c->value, &end), is = strtod(value, &value_end);
    bool numbers = end != c->value && *end == 0 && value_end != value && *value_end == 0;
    if (c->relation == '<' || c->relation == '>')
        return numbers && (c->relation == '<' ? is < wanted : is > wanted);
    bool equal = numbers ? is >= wanted && is <= wanted : strcmp(c->value, value) == 0;
    return equal == (c->relation == '=');
}

/* "2:", "gripper:" or "gripper." before the name of a signal. */
static const char *read_slave(const ect_names_t *names, const char *text, uint16_t *slave)
{
    uint64_t number = 0;
    const char *end = ect_number_begins(text, 1, UINT16_MAX, &number);
    if (end && *end == ':') {
        *slave = (uint16_t)number;
        return end + 1;
    }
    size_t length = strcspn(text, ".:=!<>");
    number = text[length] == '.' || text[length] == ':' ? ect_names_find(names, text, length) : 0;
    if (number == 0)
        return text;
    *slave = (uint16_t)number;
    return text + length + 1;
}

static bool is_signal(const ect_step_t *step, const char *text)
{
    ect_condition_t condition;
    bool is_one = ect_condition_read(text, &condition);
    return is_one && (step->action == ECT_ACTION_EXPECT || condition.relation == '=');
}

/* Reads the number or the name of a twin. */
static bool is_twin(const ect_names_t *names, const char *word, uint16_t *slave)
{
    uint64_t number = ect_names_find(names, word, strlen(word));
    bool is_one = number != 0 || ect_number_begins(word, 1, UINT16_MAX, &number);
    *slave = is_one ? (uint16_t)number : *slave;
    return is_one;
}

static const char *signals_wanted(const ect_step_t *step)
{
    return step->action == ECT_ACTION_SET ? "expected 'set NAME=VALUE'"
                                          : "expected 'expect NAME=VALUE', with =, !=, < or >";
}

/* Several signals in a line are permitted only in a 'set' without an end. */
static bool check_count(ect_words_t *w, const ect_step_t *step, size_t count)
{
    if (count == 0)
        return ect_words_wrong(
            w, step->action == ECT_ACTION_SET ? "expected 'set NAME=VALUE'" : "expected 'expect NAME=VALUE'", NULL);
    return count == 1 || (step->action == ECT_ACTION_SET && step->until.kind == ECT_MILESTONE_NONE) ||
           ect_words_wrong(w, "expected one signal, on a line with 'expect' or with an end",
                           strchr(step->text, ' ') + 1);
}

static bool read_signals(ect_words_t *w, const char *const *word, ect_step_t *step)
{
    size_t used = 0, count = 0;
    step->slave = 1;
    for (; *word; word++) {
        if (strcmp(*word, "slave") == 0 && word[1] && is_twin(w->names, word[1], &step->slave)) {
            word++;
            continue;
        }
        uint16_t slave = step->slave;
        const char *signal = read_slave(w->names, *word, &slave);
        if (count > 0 && slave != step->slave)
            return ect_words_wrong(w, "all signals of a line belong to one slave: write a line for each slave", *word);
        step->slave = slave;
        if (!is_signal(step, signal))
            return ect_words_wrong(w, signals_wanted(step), *word);
        used += (size_t)snprintf(step->text + used, sizeof step->text - used, "%s%s", count > 0 ? " " : "", signal);
        count++;
        if (used >= sizeof step->text)
            return ect_words_wrong(w, "the signals of a line have at most 127 characters", signal);
    }
    return check_count(w, step, count);
}

/* @return whether the step has an effect that its end can revert */
static bool can_end(const ect_fault_t *fault)
{
    return ect_fault_is_of_frames(fault) || ect_fault_is_above_wire(fault) || fault->kind == ECT_FAULT_HANG ||
           (fault->kind >= ECT_FAULT_EEPROM_BUSY && fault->kind <= ECT_FAULT_EEPROM_FLIP);
}

static bool read_fault(ect_words_t *w, const char *const *word, ect_step_t *step)
{
    char text[ECT_WORDS_ROOM];
    size_t used = 0;
    text[0] = 0;
    for (; *word; word++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", used > 0 ? " " : "", *word);
    if (!ect_fault_parse_named(text, w->names, &step->fault, w->message))
        return false;
    return step->until.kind == ECT_MILESTONE_NONE || can_end(&step->fault) ||
           ect_words_wrong(w, "'while', 'until' and 'for' need a fault that lasts", text);
}

/* Collects the words that belong to no milestone. */
static bool read_action(ect_words_t *w, const char *const *word, ect_step_t *step)
{
    bool expects = *word && strcmp(*word, "expect") == 0;
    if (*word && (expects || strcmp(*word, "set") == 0)) {
        step->action = expects ? ECT_ACTION_EXPECT : ECT_ACTION_SET;
        return read_signals(w, word + 1, step);
    }
    return read_fault(w, word, step);
}

/* @return the slave named by an action; 0: none */
static uint16_t slave_of(const ect_step_t *step)
{
    if (step->action != ECT_ACTION_FAULT)
        return step->slave;
    return ect_fault_is_of_frames(&step->fault) ? 0 : step->fault.slave;
}

static void default_slave(ect_milestone_t *m, uint16_t slave)
{
    bool of_state = m->kind >= ECT_MILESTONE_STATE && m->kind <= ECT_MILESTONE_LEFT;
    if (m->slave == 0)
        m->slave = slave == 0 && of_state ? 1 : slave;
}

bool ect_step_read(const char *line, const ect_names_t *names, ect_step_t *step, char *message)
{
    ect_words_t w = {.message = message, .names = names};
    const char *action[ECT_WORDS_MOST + 1] = {NULL};
    size_t count = 0;
    *step = (ect_step_t){0};
    if (!ect_words_cut(&w, &limits, line))
        return false;
    while (ect_words_next(&w)) {
        if (!begins_milestone(ect_words_next(&w)))
            action[count++] = w.word[w.at++];
        else if (!read_milestone(&w, step))
            return false;
    }
    if (!read_action(&w, action, step))
        return false;
    step->holds |= step->repeats;
    for (size_t i = 0; i < step->when_count; i++)
        default_slave(&step->when[i], slave_of(step));
    default_slave(&step->until, slave_of(step));
    return true;
}

uint16_t ect_step_highest_slave(const ect_step_t *step)
{
    uint16_t highest = step->action == ECT_ACTION_FAULT ? step->fault.slave : step->slave;
    for (size_t i = 0; i < step->when_count; i++)
        highest = step->when[i].slave > highest ? step->when[i].slave : highest;
    return step->until.slave > highest ? step->until.slave : highest;
}
