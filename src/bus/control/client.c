/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/control/client.h"

#include <cjson/cJSON.h>
#include <fnmatch.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/fields.h"
#include "bus/control/change.h"
#include "bus/control/objects.h"
#include "bus/control/pdos.h"
#include "wire/assert.h"

bool ect_client_room(const ect_client_t *client)
{
    return client->deaf || ECT_CLIENT_ANSWER - client->unsent >= (ECT_CLIENT_LINES + 2) * ECT_LINE_ROOM;
}

bool ect_client_busy(const ect_client_t *client)
{
    return client->visit.op != ECT_VISIT_NONE || client->line > 0 ||
           (client->watch && ect_watch_pending(client->watch));
}

void ect_client_received(ect_client_t *client)
{
    const char *end = memchr(client->request, '\n', client->received);
    client->line = end ? (size_t)(end - client->request) + 1 : 0;
}

static void put(ect_client_t *client, const ect_line_t *line)
{
    if (client->deaf)
        return;
    ECT_ASSERT(line->length <= ECT_CLIENT_ANSWER - client->unsent);
    memcpy(client->answer + client->unsent, line->text, line->length);
    client->unsent += line->length;
}

void ect_client_result(ect_client_t *client, const char *message)
{
    ect_line_t line;
    ect_line_begin(&line);
    ect_line_plain(&line, "ok", message ? "false" : "true");
    if (message)
        ect_line_string(&line, "message", message);
    ect_line_end(&line);
    put(client, &line);
}

/* --- get, list, watch --------------------------------------------------------------------------------------------- */

static void describe_field(ect_line_t *line, const ect_signal_ref_t *ref)
{
    const ect_field_t *field = ect_signal_field(ref);
    char text[ECT_FIELD_TEXT];
    if (!field)
        return;
    ect_field_text(field, text);
    ect_line_string(line, "field", text);
}

static void describe(ect_client_t *client, const ect_signal_ref_t *ref, uint64_t now_ns)
{
    const ect_visit_t *v = &client->visit;
    ect_line_t line;
    ect_line_begin(&line);
    ect_watch_describe(&line, ref, v->slave, ref->value);
    if (v->op == ECT_VISIT_LIST) {
        char range[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_range(ref->signal, range);
        ect_line_string(&line, "access", ref->signal->access == ECT_SIGNAL_WRITE ? "rw" : "r");
        ect_line_string(&line, "range", range);
        ect_line_string(&line, "meaning", ref->signal->meaning);
        describe_field(&line, ref);
    } else if (v->op == ECT_VISIT_WATCH) {
        ect_line_time(&line, now_ns);
    }
    ect_line_end(&line);
    put(client, &line);
}

static void end_visit(ect_client_t *client, const char *message)
{
    client->visit.op = ECT_VISIT_NONE;
    ect_client_result(client, message);
}

static const char too_many[] =
    "too many signals are watched at every change, 4096 in all: name fewer, or leave 'every' out";

/* @return whether the search continues */
static bool watch_one(ect_client_t *client, const ect_signal_ref_t *ref)
{
    if (ect_watch_is_every(client->watch) && ect_watch_count(client->watch) >= client->every_room) {
        end_visit(client, too_many);
        return false;
    }
    if (ect_watch_add(client->watch, ref, client->visit.slave))
        return true;
    end_visit(client, "a connection watches at most 4096 signals: name fewer");
    return false;
}

/* Finds the next signal of the slave. */
static bool next_signal(ect_visit_t *v, const ect_chain_t *chain, ect_signal_ref_t *ref)
{
    if (!v->literal)
        return ect_chain_next_signal(chain, v->slave, &v->cursor, ref);
    bool first = v->cursor.device.group == 0;
    v->cursor.device.group = 1;
    return first && ect_chain_signal(chain, v->slave, v->pattern, ref);
}

static void end_search(ect_client_t *client, const ect_chain_t *chain)
{
    const ect_visit_t *v = &client->visit;
    char message[ECT_SIGNAL_MESSAGE];
    if (ect_chain_count(chain) == 1 || v->all)
        snprintf(message, sizeof message, "no signal matches '%.60s': 'ectwin list-signals' lists them", v->pattern);
    else
        snprintf(
            message, sizeof message,
            "no signal of slave %zu matches '%.60s': 'ectwin list-signals -n %zu' lists them; -n chooses one of %zu "
            "slaves",
            v->slave + 1, v->pattern, v->slave + 1, ect_chain_count(chain));
    end_visit(client, v->matched > 0 ? NULL : message);
}

/* A pattern for all slaves may contain the name of a twin: "camera?.judgement". */
static bool is_match(const ect_visit_t *v, const ect_signal_ref_t *ref)
{
    char name[ECT_NAME_ROOM + ECT_SIGNAL_NAME];
    if (fnmatch(v->pattern, ref->name, 0) == 0)
        return true;
    if (!v->all || !ref->twin)
        return false;
    (void)snprintf(name, sizeof name, "%s.%s", ref->twin, ref->name);
    return fnmatch(v->pattern, name, 0) == 0;
}

static void continue_visit(ect_client_t *client, const ect_chain_t *chain, uint64_t now_ns)
{
    ect_visit_t *v = &client->visit;
    unsigned int lines = 0;
    const unsigned int cost = v->all && ect_chain_names(chain) ? 2 : 1; /* comparisons for each name */
    for (unsigned int matches = 0; matches < ECT_CLIENT_MATCHES && lines < ECT_CLIENT_LINES; matches += cost) {
        ect_signal_ref_t ref;
        if (next_signal(v, chain, &ref)) {
            if (!v->literal && !is_match(v, &ref))
                continue;
            if (v->op == ECT_VISIT_WATCH && !watch_one(client, &ref))
                return;
            describe(client, &ref, now_ns);
            v->matched++;
            lines++;
        } else if (v->slave == v->last) {
            end_search(client, chain);
            return;
        } else {
            v->slave++;
            v->cursor = (ect_chain_cursor_t){0};
        }
    }
}

static const char *begin_watch(ect_client_t *client, const cJSON *request)
{
    if (!client->watch)
        client->watch = ect_watch_new();
    if (!client->watch)
        return "not enough memory";
    if (!cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(request, "every")))
        return NULL;
    if (ect_watch_count(client->watch) > client->every_room)
        return too_many;
    ect_watch_every(client->watch);
    return NULL;
}

/* @return the reason of a refusal; NULL: begun */
static const char *begin(ect_client_t *client, const ect_chain_t *chain, size_t slave, const cJSON *request)
{
    const cJSON *json = cJSON_GetObjectItemCaseSensitive(request, "pattern");
    const char *pattern = json ? cJSON_GetStringValue(json) : "*";
    ect_visit_t *v = &client->visit;
    if (!pattern || strlen(pattern) >= sizeof v->pattern)
        return "\"pattern\" is a text of at most 127 characters";
    v->cursor = (ect_chain_cursor_t){0};
    v->matched = 0;
    v->slave = slave > 0 ? slave - 1 : 0;
    v->all = !ect_chain_resolve(chain, &v->slave, &pattern) && slave == 0;
    v->last = v->all ? ect_chain_count(chain) - 1 : v->slave;
    v->literal = strpbrk(pattern, "*?[\\") == NULL;
    strcpy(v->pattern, pattern);
    return v->op == ECT_VISIT_WATCH ? begin_watch(client, request) : NULL;
}

/* A request with an immediate reply. */
typedef struct call {
    ect_chain_t *chain;
    size_t slave; /* from 1 */
    const cJSON *request;
    uint64_t now_ns;
    char *message; /* ECT_SIGNAL_MESSAGE bytes, for a reason */
} call_t;

/* --- requests with a time ----------------------------------------------------------------------------------------- */

static bool is_planned(const char *op, const cJSON *request)
{
    return strcmp(op, "set") == 0 && cJSON_HasObjectItem(request, "at");
}

/* @return the reason of a refusal; NULL: done */
static const char *plan(ect_client_t *client, const call_t *call)
{
    const double most_s = 1e9;
    double at_s = cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(call->request, "at"));
    if (!client->stats || !client->plans)
        return "\"at\" needs a bus that runs";
    if (!(at_s >= 0 && at_s <= most_s))
        return "\"at\" is a time of the bus, in seconds since its start";
    uint64_t due_ns = client->stats->start_ns + (uint64_t)(at_s * 1e9 + 0.5);
    if (due_ns < call->now_ns) {
        snprintf(call->message, ECT_SIGNAL_MESSAGE, "%g s is over: the bus is at %.6f s", at_s,
                 (double)(call->now_ns - client->stats->start_ns) / 1e9);
        return call->message;
    }
    const char *why = ect_change_check(call->chain, call->slave, call->request, call->message);
    return why ? why : ect_plans_add(client->plans, due_ns, call->request);
}

/* --- data --------------------------------------------------------------------------------------------------------- */

/* @return the reason of a refusal; NULL: *offset is within the data */
static const char *read_offset(const cJSON *request, size_t size, size_t *offset)
{
    const cJSON *json = cJSON_GetObjectItemCaseSensitive(request, "offset");
    double value = json ? json->valuedouble : 0;
    if ((json && !cJSON_IsNumber(json)) || !(value >= 0 && value <= (double)size))
        return "\"offset\" is a number from 0 to the size of the data";
    *offset = (size_t)value;
    return NULL;
}

enum { PIECE = 400 };

/* Writes the member "data", at most PIECE bytes. */
static void put_hex(ect_line_t *line, const uint8_t *bytes, size_t length)
{
    static const char digits[] = "0123456789abcdef";
    char hex[2 * PIECE + 1] = "";
    for (size_t i = 0; i < PIECE && i < length; i++) {
        hex[2 * i] = digits[bytes[i] >> 4];
        hex[2 * i + 1] = digits[bytes[i] & 15];
    }
    ect_line_string(line, "data", hex);
}

/* Writes the members "size", "offset" and "data", a piece of the bytes from `at` on. */
static void put_bytes(ect_line_t *line, const uint8_t *bytes, size_t size, size_t at)
{
    ect_line_number(line, "size", size);
    ect_line_number(line, "offset", at);
    put_hex(line, bytes + at, size - at);
}

/* Replies with a piece of the command line. @return the reason of a refusal; NULL: done */
static const char *reply_words(ect_client_t *client, const call_t *call)
{
    size_t at;
    if (!client->about || !client->about->words)
        return "this chain has no command line";
    const char *why = read_offset(call->request, client->about->words_length, &at);
    if (why)
        return why;
    ect_line_t line;
    ect_line_begin(&line);
    put_bytes(&line, (const uint8_t *)client->about->words, client->about->words_length, at);
    ect_line_end(&line);
    put(client, &line);
    return NULL;
}

/* Replies with a piece of data too large for a signal; pieces with the same serial belong together. @return the reason
 * of a refusal; NULL: done */
static const char *reply_piece(ect_client_t *client, const call_t *call)
{
    ect_bulk_t bulk = ect_chain_bulk(call->chain, call->slave - 1);
    size_t at;
    if (!bulk.data)
        return "this slave has no data for this request; a base unit with periodic data has";
    const char *why = read_offset(call->request, bulk.size, &at);
    if (why)
        return why;
    ect_line_t line;
    ect_line_begin(&line);
    ect_line_number(&line, "slave", call->slave);
    ect_line_number(&line, "serial", bulk.serial);
    put_bytes(&line, bulk.data, bulk.size, at);
    ect_line_end(&line);
    put(client, &line);
    return NULL;
}

/* --- stats -------------------------------------------------------------------------------------------------------- */

/* Writes the progress of the scenario, if there is one. */
static void put_scenario(ect_line_t *line, const ect_scenario_t *scenario)
{
    if (!scenario || scenario->step_count == 0)
        return;
    ect_line_number(line, "steps", scenario->step_count);
    ect_line_number(line, "steps_over", scenario->step_count - scenario->steps_left);
    ect_line_number(line, "expected", scenario->verdict.all);
    ect_line_number(line, "met", scenario->verdict.met);
    ect_line_number(line, "failed", scenario->verdict.failed);
}

/* Writes the way of the replies in the kernel, if it replies. */
static void put_kernel(ect_line_t *line, const ect_stats_t *s)
{
    if (!s->hook)
        return;
    ect_line_string(line, "hook", s->hook);
    ect_line_number(line, "plans", s->plans);
    ect_line_number(line, "kernel_p50_us", ect_stats_quantile_us(s->kernel_answers, 500));
    ect_line_number(line, "kernel_p99_us", ect_stats_quantile_us(s->kernel_answers, 990));
    ect_line_number(line, "kernel_longest_us", s->longest_kernel_ns / 1000);
}

static void put_counters(ect_client_t *client, uint64_t now_ns)
{
    const ect_stats_t *s = client->stats;
    const struct {
        const char *name;
        uint64_t value;
    } counters[] = {
        {"frames", s->frames},
        {"answered", s->answered},
        {"in_kernel", s->in_kernel},
        {"unanswered", s->unanswered},
        {"queue_lost", s->queue_lost},
        {"stale", s->stale},
        {"circling", s->circling},
        {"dropped", s->dropped},
        {"delayed", s->delayed},
        {"captured", s->captured},
        {"uncaptured", s->uncaptured},
        {"p50_us", ect_stats_quantile_us(s->answers, 500)},
        {"p99_us", ect_stats_quantile_us(s->answers, 990)},
        {"longest_us", s->longest_answer_ns / 1000},
        {"polls", s->polls},
        {"late_polls", s->late_polls},
        {"latest_poll_us", s->latest_poll_ns / 1000},
    };
    ect_line_t line;
    ect_line_begin(&line);
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++)
        ect_line_number(&line, counters[i].name, counters[i].value);
    put_kernel(&line, s);
    put_scenario(&line, client->scenario);
    ect_line_time(&line, now_ns - s->start_ns);
    ect_line_end(&line);
    put(client, &line);
}

static void put_counts(ect_line_t *line, const char *key, const uint64_t counts[ECT_STATS_STEPS])
{
    char list[24 * ECT_STATS_STEPS] = "";
    size_t used = 0;
    for (size_t step = 0; step < ECT_STATS_STEPS; step++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%" PRIu64, step > 0 ? "," : "[", counts[step]);
    snprintf(list + used, sizeof list - used, "]");
    ect_line_plain(line, key, list);
}

static void put_histogram(ect_client_t *client)
{
    char list[24 * ECT_STATS_STEPS] = "";
    size_t used = 0;
    ect_line_t line;
    ect_line_begin(&line);
    put_counts(&line, "answers", client->stats->answers);
    if (client->stats->hook)
        put_counts(&line, "kernel_answers", client->stats->kernel_answers);
    for (size_t step = 0; step + 1 < ECT_STATS_STEPS; step++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%" PRIu32, step > 0 ? "," : "[",
                                 ect_stats_edge_us(step));
    snprintf(list + used, sizeof list - used, "]");
    ect_line_plain(&line, "edges_us", list);
    ect_line_end(&line);
    put(client, &line);
}

/* @return the reason of a refusal; NULL: done */
static const char *reply_stats(ect_client_t *client, const call_t *call)
{
    if (!client->stats)
        return "nothing is counted here";
    put_counters(client, call->now_ns);
    put_histogram(client);
    ect_line_t line;
    for (size_t i = 0; client->outsides && ect_outside_count(client->outsides, i, &line); i++)
        put(client, &line);
    return NULL;
}

static void put_text(ect_line_t *line, const char *key, const char *value)
{
    if (value)
        ect_line_string(line, key, value);
}

/* Writes lowest and highest AL state (0: disconnected), and the number of slaves with an AL status code. */
static void put_states(ect_line_t *line, const ect_chain_t *chain)
{
    uint64_t lowest = UINT64_MAX, highest = 0, errors = 0;
    for (size_t i = 0; i < ect_chain_count(chain); i++) {
        const ect_slave_t *slave = ect_chain_slave(chain, i);
        uint64_t state = slave->off_bus ? 0 : slave->state;
        lowest = state < lowest ? state : lowest;
        highest = state > highest ? state : highest;
        errors += !slave->off_bus && slave->code != 0;
    }
    ect_line_number(line, "lowest", lowest);
    ect_line_number(line, "highest", highest);
    ect_line_number(line, "errors", errors);
}

/* @return the reason of a refusal; NULL: done */
static const char *reply_about(ect_client_t *client, const call_t *call)
{
    ect_line_t line;
    if (!client->about)
        return "this chain has no description";
    ect_line_begin(&line);
    put_text(&line, "name", client->about->name);
    put_text(&line, "devices", client->about->devices);
    put_text(&line, "panel", client->about->panel);
    put_text(&line, "iface", client->about->ifaces[ECT_END_IN]);
    put_text(&line, "iface2", client->about->ifaces[ECT_END_OUT]);
    ect_line_number(&line, "slaves", ect_chain_count(call->chain));
    put_states(&line, call->chain);
    ect_line_end(&line);
    put(client, &line);
    return NULL;
}

static bool is_visit(ect_visit_t *v, const char *op)
{
    static const char *const names[] = {
        [ECT_VISIT_GET] = "get", [ECT_VISIT_LIST] = "list", [ECT_VISIT_WATCH] = "watch"};
    for (unsigned int i = ECT_VISIT_GET; i <= ECT_VISIT_WATCH; i++) {
        if (strcmp(op, names[i]) == 0)
            v->op = i;
    }
    return v->op != ECT_VISIT_NONE;
}

/* Lists the active faults, at most as many as fit in a step. @return the reason of a refusal; NULL: done */
static const char *list_faults(ect_client_t *client, const call_t *call)
{
    /* The room of a step is for lines of maximum length; lines of faults are shorter. */
    enum { FAULTS = ECT_CLIENT_LINES * ECT_LINE_ROOM / (ECT_FAULT_TEXT + 32) };
    _Static_assert((int)ECT_SCENARIO_FAULTS <= (int)FAULTS, "one step lists all of them");
    char room[ECT_FAULT_TEXT];
    if (!client->scenario)
        return "no faults can be set here";
    for (size_t i = 0; i < FAULTS && ect_scenario_show(client->scenario, call->chain, i, room); i++) {
        ect_line_t line;
        ect_line_begin(&line);
        ect_line_string(&line, "fault", room);
        ect_line_end(&line);
        put(client, &line);
    }
    return NULL;
}

/* Lists the faults as lines of a script, from a number on. @return the reason of a refusal; NULL: done */
static const char *list_script(ect_client_t *client, const call_t *call)
{
    size_t at = 0;
    char text[ECT_STEP_LINE];
    if (!client->scenario)
        return "no faults can be set here";
    const char *why = read_offset(call->request, SIZE_MAX / 2, &at);
    for (size_t i = 0; !why && i < ECT_CLIENT_LINES && ect_scenario_left(client->scenario, call->chain, at + i, text);
         i++) {
        ect_line_t line;
        ect_line_begin(&line);
        ect_line_string(&line, "line", text);
        ect_line_end(&line);
        put(client, &line);
    }
    return why;
}

/* @return the reason of a refusal; NULL: done */
static const char *list_events(ect_client_t *client, const call_t *call)
{
    const cJSON *json = cJSON_GetObjectItemCaseSensitive(call->request, "after");
    const double after = json ? json->valuedouble : 0;
    if (!client->events_of_chain)
        return "no events are recorded here";
    if ((json && !cJSON_IsNumber(json)) || !(after >= 0 && after < 1e15))
        return "\"after\" is the number of an event, 0 for the first one";
    uint64_t number = (uint64_t)after;
    ect_line_t line;
    for (size_t i = 0; i < ECT_CLIENT_LINES && ect_events_next(client->events_of_chain, call->chain, &number,
                                                               client->stats ? client->stats->start_ns : 0, &line);
         i++)
        put(client, &line);
    return NULL;
}

/* @return the reason of a refusal; NULL: done */
static const char *list_objects(ect_client_t *client, const call_t *call)
{
    ect_object_place_t place;
    ect_line_t line;
    const char *why = ect_object_place(call->request, &place);
    const ect_slave_t *stack = why ? NULL : ect_chain_sdo(call->chain, call->slave - 1, &why);
    if (!stack) {
        snprintf(call->message, ECT_SIGNAL_MESSAGE, "slave %zu: %s", call->slave, why);
        return call->message;
    }
    for (size_t i = 0; i < ECT_CLIENT_LINES; i++) {
        if (!ect_objects_next(ect_slave_dictionary(stack), call->slave, &place, &line))
            break;
        put(client, &line);
    }
    return NULL;
}

/* @return the reason of a refusal; NULL: done */
static const char *read_object(ect_client_t *client, const call_t *call)
{
    ect_line_t line;
    const char *why = ect_object_read(call->chain, call->slave, call->request, &line, call->message);
    if (!why)
        put(client, &line);
    return why;
}

/* @return the reason of a refusal; NULL: done */
static const char *list_pdos(ect_client_t *client, const call_t *call)
{
    uint32_t place;
    ect_line_t line;
    const char *why = ect_pdos_place(call->request, &place);
    const ect_slave_t *slave = ect_chain_slave(call->chain, call->slave - 1);
    for (size_t i = 0; !why && i < ECT_CLIENT_LINES && ect_pdos_next(slave, call->slave, &place, &line); i++)
        put(client, &line);
    return why;
}

static const char *list_wires(ect_client_t *client, const call_t *call)
{
    const size_t end = ect_chain_count(call->chain);
    for (size_t i = call->slave - 1; i < end && i + 1 < call->slave + ECT_CLIENT_LINES; i++) {
        unsigned int port;
        ect_line_t line;
        const size_t up = ect_chain_wire(call->chain, i, &port);
        ect_line_begin(&line);
        ect_line_number(&line, "slave", i + 1);
        ect_line_number(&line, "up", up);
        ect_line_number(&line, "port", port);
        ect_line_end(&line);
        put(client, &line);
    }
    return NULL;
}

/* @return the reason of a refusal; NULL: done */
static const char *list_counters(ect_client_t *client, const call_t *call)
{
    enum { SECONDS = 5 };
    ect_datagrams_t *datagrams = client->datagrams;
    _Static_assert((int)ECT_DATAGRAMS <= (int)ECT_CLIENT_LINES, "one step lists all of them");
    if (!datagrams)
        return "no working counters are counted here";
    ect_datagrams_want(datagrams, call->now_ns, call->now_ns + SECONDS * 1000000000ull);
    for (size_t i = 0; i < datagrams->count; i++) {
        const ect_datagram_t *one = &datagrams->all[i];
        ect_line_t line;
        ect_line_begin(&line);
        ect_line_string(&line, "command", ect_datagrams_name(one->command));
        ect_line_number(&line, "address", one->address);
        ect_line_number(&line, "length", one->length);
        ect_line_number(&line, "counter", one->counter);
        ect_line_number(&line, "highest", one->highest);
        ect_line_number(&line, "replies", one->replies);
        ect_line_number(&line, "lower", one->lower);
        ect_line_time(&line, call->now_ns > one->seen_ns ? call->now_ns - one->seen_ns : 0);
        ect_line_end(&line);
        put(client, &line);
    }
    return NULL;
}

/* --- plants ------------------------------------------------------------------------------------------------------- */

void ect_client_send_step(ect_client_t *client, const ect_outside_t *plant, uint64_t now_ns)
{
    const uint64_t elapsed_ns = now_ns - (client->stats ? client->stats->start_ns : 0);
    ect_line_t line;
    for (unsigned int i = 0; ect_outside_line(plant, i, elapsed_ns, &line); i++)
        put(client, &line);
}

/* @return the reason of a refusal; NULL: done */
static const char *request_plant(ect_client_t *client, const call_t *call)
{
    return client->outsides ? ect_outside_request(client->outsides, client, call->chain, call->slave, call->request,
                                                  call->now_ns, call->message)
                            : "no plants are served here";
}

/* Observers get the equivalent requests `set`. */
static void tell_step(const ect_client_t *client, const ect_outside_t *plant, const cJSON *request)
{
    size_t position = 0;
    cJSON *set;
    while (client->observer && client->observer->changes && (set = ect_outside_as_set(plant, request, &position))) {
        char *text = cJSON_PrintUnformatted(set);
        if (text)
            client->observer->changes(client->observer->ctx, text, strlen(text));
        cJSON_free(text);
        cJSON_Delete(set);
    }
}

/* @return the reason of a refusal; NULL: done */
static const char *step_plant(ect_client_t *client, const call_t *call)
{
    ect_outside_t *plant = client->outsides ? ect_outside_of(client->outsides, client) : NULL;
    if (!plant)
        return "this connection has no plant: begin with {\"op\":\"plant\",...}";
    tell_step(client, plant, call->request);
    return ect_outside_reply(plant, call->chain, call->request, call->now_ns, call->message);
}

static const char *list_waves(ect_client_t *client, const call_t *call)
{
    _Static_assert((int)ECT_WAVES <= (int)ECT_CLIENT_LINES, "one step lists all of them");
    if (!client->scenario)
        return "no waves can be set here";
    for (size_t i = 0; i < client->scenario->waves.count; i++) {
        const ect_wave_t *wave = &client->scenario->waves.all[i];
        const double values[] = {wave->low, wave->high, (double)wave->period_ns / 1e9};
        static const char *const keys[] = {"low", "high", "period"};
        char text[32];
        ect_line_t line;
        ect_line_begin(&line);
        ect_line_number(&line, "slave", wave->position + 1);
        put_text(&line, "twin", ect_names_at(ect_chain_names(call->chain), wave->position));
        ect_line_string(&line, "name", wave->name);
        ect_line_string(&line, "shape", ect_wave_shape_name(wave->shape));
        for (size_t k = 0; k < 3; k++) {
            snprintf(text, sizeof text, "%.12g", values[k]);
            ect_line_plain(&line, keys[k], text);
        }
        ect_line_end(&line);
        put(client, &line);
    }
    return NULL;
}

/* --- the newest frames -------------------------------------------------------------------------------------------- */

/* Begins or ends a capture. The time of the client, in seconds since 1970, is that of its frames. */
static const char *switch_capture(ect_client_t *client, const call_t *call, bool on)
{
    static const char *const none[2];
    const cJSON *json = cJSON_GetObjectItemCaseSensitive(call->request, "time");
    const double time_s = cJSON_IsNumber(json) ? json->valuedouble : 0;
    const bool known = time_s >= 0 && time_s < 1e10 && (uint64_t)(time_s * 1e9) > call->now_ns;
    const uint64_t offset_ns = known ? (uint64_t)(time_s * 1e9) - call->now_ns : 0;
    if (!on)
        ect_recent_stop(client->recent);
    else if (!ect_recent_start(client->recent, client->about ? client->about->ifaces : none, offset_ns))
        return "not enough memory for a capture of 4 MiB";
    return NULL;
}

/* Replies with pieces of the last capture. @return the reason of a refusal; NULL: done */
static const char *read_capture(ect_client_t *client, const call_t *call)
{
    const ect_recent_t *recent = client->recent;
    size_t at;
    if (recent->on)
        return "the capture runs: {\"op\":\"capture\",\"on\":false} ends it";
    if (ect_recent_size(recent) == 0)
        return "there is no capture: {\"op\":\"capture\",\"on\":true} begins one";
    const char *why = read_offset(call->request, ect_recent_size(recent), &at);
    for (size_t i = 0; !why && i < ECT_CLIENT_LINES && at < ect_recent_size(recent); i++) {
        uint8_t bytes[PIECE];
        ect_line_t line;
        const size_t rest = ect_recent_size(recent) - at, length = rest < PIECE ? rest : (size_t)PIECE;
        ect_recent_read(recent, at, bytes, length);
        ect_line_begin(&line);
        ect_line_number(&line, "serial", recent->serial);
        ect_line_number(&line, "size", ect_recent_size(recent));
        ect_line_number(&line, "offset", at);
        put_hex(&line, bytes, length);
        ect_line_end(&line);
        put(client, &line);
        at += length;
    }
    return why;
}

static const char *capture(ect_client_t *client, const call_t *call)
{
    const cJSON *on = cJSON_GetObjectItemCaseSensitive(call->request, "on");
    return cJSON_IsBool(on) ? switch_capture(client, call, cJSON_IsTrue(on)) : read_capture(client, call);
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

/* @return the reason of a refusal; NULL: done */
static const char *change(ect_client_t *client, const call_t *call)
{
    if (is_planned(ect_change_op(call->request), call->request))
        return plan(client, call);
    return ect_change_apply(call->chain, client->scenario, call->request, call->now_ns, call->message);
}

/* Without a fault the request lists them. */
static const char *fault(ect_client_t *client, const call_t *call)
{
    return cJSON_GetObjectItemCaseSensitive(call->request, "fault") ? change(client, call) : list_faults(client, call);
}

/* Requests with an immediate reply. Each function returns the reason of a refusal; NULL: done. */
static const struct {
    const char *op;
    const char *(*reply)(ect_client_t *client, const call_t *call);
} replies[] = {
    {"set", change},           {"data", reply_piece},       {"stats", reply_stats},   {"fault", fault},
    {"about", reply_about},    {"words", reply_words},      {"script", list_script},  {"events", list_events},
    {"objects", list_objects}, {"read", read_object},       {"write", change},        {"pdos", list_pdos},
    {"wires", list_wires},     {"counters", list_counters}, {"plant", request_plant}, {"step", step_plant},
    {"wave", change},          {"waves", list_waves},       {"capture", capture},
};

enum { REPLIES = sizeof replies / sizeof replies[0] };

/* @return position in `replies`; REPLIES: none */
static size_t find_reply(const char *op)
{
    size_t i = 0;
    while (i < REPLIES && strcmp(op, replies[i].op) != 0)
        i++;
    return i;
}

static void tell_observer(const ect_client_t *client, const char *op, const cJSON *request)
{
    if (client->observer && client->observer->changes && ect_change_is(op) && !is_planned(op, request))
        client->observer->changes(client->observer->ctx, client->request, client->line - 1);
}

static void serve(ect_client_t *client, ect_chain_t *chain, const cJSON *request, uint64_t now_ns)
{
    char message[ECT_SIGNAL_MESSAGE];
    const char *op = ect_change_op(request);
    long slave = ect_change_slave(request, chain);
    bool visit = is_visit(&client->visit, op);
    const size_t reply = find_reply(op);
    const char *why;
    tell_observer(client, op, request);
    if (!visit && reply == REPLIES)
        why = "a request is a line "
              "{\"op\":\"get|list|set|watch|data|stats|fault|about|words|script|events|objects|read|write|pdos|wires|"
              "counters|plant|step|wave|waves|capture\",...}";
    else if (slave < 0 || (!visit && slave == 0))
        why = "there is no such slave in this chain";
    else if (visit)
        why = begin(client, chain, (size_t)slave, request);
    else
        why = replies[reply].reply(
            client,
            &(call_t){
                .chain = chain, .slave = (size_t)slave, .request = request, .now_ns = now_ns, .message = message});
    const bool silent = !why && strcmp(op, "step") == 0; /* the next step follows */
    if ((!visit || why) && !silent)
        end_visit(client, why);
}

/* @return whether the request was served; after the end of the connection only requests that change the chain are */
static bool serve_line(ect_client_t *client, ect_chain_t *chain, uint64_t now_ns)
{
    bool served = true;
    if (memchr(client->request, 0, client->line)) {
        ect_client_result(client, "a request is text: it has no zero byte in it");
    } else {
        cJSON *request = cJSON_ParseWithLength(client->request, client->line);
        served = !client->deaf || ect_change_is(ect_change_op(request));
        if (served)
            serve(client, chain, request, now_ns);
        cJSON_Delete(request);
    }
    ECT_ASSERT(client->line > 0 && client->line <= client->received);
    client->received -= client->line;
    memmove(client->request, client->request + client->line, client->received);
    ect_client_received(client);
    return served;
}

static void serve_lines(ect_client_t *client, ect_chain_t *chain, uint64_t now_ns)
{
    unsigned int most = client->deaf ? ECT_CLIENT_SKIPS : 1;
    for (unsigned int i = 0; i < most && client->line > 0; i++) {
        if (serve_line(client, chain, now_ns))
            return;
    }
}

void ect_client_end_of_input(ect_client_t *client)
{
    client->deaf = true;
    client->unsent = 0;
    client->visit.op = ECT_VISIT_NONE;
    ect_watch_free(client->watch);
    client->watch = NULL;
}

void ect_client_show_lamps(const ect_client_t *client, const ect_chain_t *chain)
{
    const size_t *slaves;
    size_t count = ect_watch_lamps(client->watch, &slaves);
    for (size_t i = 0; i < count; i++)
        ect_chain_show_lamps(chain, slaves[i]);
}

static void write_changes(ect_client_t *client, const ect_chain_t *chain, uint64_t now_ns)
{
    unsigned int budget = ECT_CLIENT_COMPARES;
    ect_line_t line;
    if (!ect_watch_is_every(client->watch))
        ect_client_show_lamps(client, chain);
    for (unsigned int i = 0; i < ECT_CLIENT_LINES && ect_watch_next(client->watch, &budget, now_ns, &line); i++)
        put(client, &line);
}

void ect_client_step(ect_client_t *client, ect_chain_t *chain, size_t every_room, uint64_t now_ns)
{
    ECT_ASSERT(ect_client_room(client));
    client->every_room = every_room;
    if (client->visit.op == ECT_VISIT_NONE && client->line > 0)
        serve_lines(client, chain, now_ns);
    if (client->visit.op != ECT_VISIT_NONE)
        continue_visit(client, chain, now_ns);
    else if (client->watch)
        write_changes(client, chain, now_ns);
    if (client->watch && ect_watch_lost(client->watch) && !client->closing) {
        ect_client_result(client, "changes were lost: they were not read in time");
        client->closing = true;
    }
}
