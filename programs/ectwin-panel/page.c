/* SPDX-License-Identifier: MIT */
#include "page.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* --- messages of the page ----------------------------------------------------------------------------------------- */

static page_action_t greet(page_t *page, const cJSON *message, const char *token)
{
    const char *given = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(message, "token"));
    page->known = given && request_token_is_right(given, token);
    return page->known ? PAGE_DONE : PAGE_CLOSE;
}

static unsigned int number_of(const cJSON *message, const char *member)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(message, member);
    return cJSON_IsNumber(number) && number->valueint > 0 ? (unsigned int)number->valueint : 0;
}

static void open_bus(page_t *page, unsigned int bus)
{
    page->bus = bus;
    page->generation = 0; /* so its signals, changes and events begin again */
    page->counters = 0;
    page->faults = 0;
    page->troubles = 0;
}

/* @return whether a value is a list of positions of signals */
static bool take_trace(page_t *page, const cJSON *list)
{
    const cJSON *signal;
    page->tracing = page->tracing && page->traced.count > 0;
    memset(&page->traced, 0, sizeof page->traced);
    if (!cJSON_IsArray(list))
        return false;
    cJSON_ArrayForEach(signal, list)
    {
        if (!cJSON_IsNumber(signal) || signal->valueint < 0 || signal->valueint >= TABLE_SIGNALS ||
            page->traced.count == TRACE_SIGNALS)
            return false;
        trace_set_add(&page->traced, (size_t)signal->valueint);
    }
    return true;
}

static void refuse(page_t *page, double id, const char *reason)
{
    char text[256];
    snprintf(text, sizeof text, "{\"ok\":false,\"message\":\"%s\"}", reason);
    page_reply(page, id, text);
}

/* @return the position of a held signal; `holds`: the page does not hold it */
static size_t find_held(const page_t *page, unsigned int bus, const char *line)
{
    size_t i = 0;
    while (i < page->holds && (page->held[i].bus != bus || strcmp(page->held[i].line, line) != 0))
        i++;
    return i;
}

/* The request that releases a signal is the same for each value to which the page sets it. @return as write_release */
static const char *note_held(page_t *page, unsigned int bus, const char *line, bool rests)
{
    size_t place = find_held(page, bus, line);
    if (rests && place < page->holds) {
        page->held[place] = page->held[--page->holds];
    } else if (!rests && place == page->holds) {
        if (page->holds == PAGE_HELD)
            return "a page holds at most 16 signals: release one of them";
        page->held[place].bus = bus;
        snprintf(page->held[place].line, PAGE_HELD_LINE, "%s", line);
        page->holds++;
    }
    return NULL;
}

/* @return the reason of a refusal; NULL: the signal of the request is held, or released */
static const char *hold(page_t *page, unsigned int bus, const cJSON *request, const cJSON *rest)
{
    char line[PAGE_HELD_LINE];
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(request, "value");
    if (!cJSON_HasObjectItem(request, "name") || !value || cJSON_HasObjectItem(request, "at"))
        return "'rest' is for requests that set one signal at once";
    cJSON *release = cJSON_Duplicate(request, true);
    bool fits = release && cJSON_ReplaceItemInObjectCaseSensitive(release, "value", cJSON_Duplicate(rest, true)) &&
                cJSON_PrintPreallocated(release, line, sizeof line, false);
    cJSON_Delete(release);
    return fits ? note_held(page, bus, line, cJSON_Compare(value, rest, true)) : "too much for one request";
}

bool page_release(page_t *page, page_passed_t *passed)
{
    if (page->holds == 0)
        return false;
    page->holds--;
    passed->bus = page->held[page->holds].bus;
    passed->id = 0;
    snprintf(passed->line, sizeof passed->line, "%s", page->held[page->holds].line);
    return true;
}

static page_action_t pass_on(page_t *page, const cJSON *message, page_passed_t *passed)
{
    const cJSON *request = cJSON_GetObjectItemCaseSensitive(message, "request");
    const cJSON *id = cJSON_GetObjectItemCaseSensitive(message, "id");
    const cJSON *rest = cJSON_GetObjectItemCaseSensitive(message, "rest");
    if (!cJSON_IsNumber(id) || !cJSON_IsObject(request) || page->waiting == PAGE_REPLIES)
        return PAGE_CLOSE;
    const char *reason = request_refused(request, page->view);
    page->waiting++;
    passed->bus = number_of(message, "bus");
    passed->id = id->valuedouble;
    if (!reason && !cJSON_PrintPreallocated((cJSON *)request, passed->line, sizeof passed->line, false))
        reason = "too much for one request";
    if (!reason && rest)
        reason = hold(page, passed->bus, request, rest);
    if (!reason)
        return PAGE_PASS_ON;
    refuse(page, passed->id, reason);
    return PAGE_DONE;
}

page_action_t page_take(page_t *page, const char *text, size_t length, const char *token, page_passed_t *passed)
{
    page_action_t action = PAGE_CLOSE;
    cJSON *message = cJSON_ParseWithLength(text, length);
    if (!cJSON_IsObject(message)) {
        cJSON_Delete(message);
        return PAGE_CLOSE;
    }
    if (!page->known) {
        action = greet(page, message, token);
    } else if (cJSON_HasObjectItem(message, "open")) {
        open_bus(page, number_of(message, "open"));
        action = PAGE_LEAVE;
    } else if (cJSON_HasObjectItem(message, "trace")) {
        action = take_trace(page, cJSON_GetObjectItemCaseSensitive(message, "trace")) ? PAGE_DONE : PAGE_CLOSE;
    } else {
        action = pass_on(page, message, passed);
    }
    cJSON_Delete(message);
    return action;
}

void page_reply(page_t *page, double id, const char *text)
{
    static const char cut[] = "{\"ok\":false,\"message\":\"the reply is too long for this panel\"}";
    if (page->replies == PAGE_REPLIES)
        return;
    size_t last = (page->first + page->replies++) % PAGE_REPLIES;
    page->reply[last].id = id;
    snprintf(page->reply[last].text, PAGE_REPLY, "%s", strlen(text) < PAGE_REPLY ? text : cut);
}

/* --- messages to the page ----------------------------------------------------------------------------------------- */

typedef struct out {
    char *text;
    size_t used;
    bool full;
} out_t;

/* Appends a piece whole, or nothing and is full. Room for the end of a message stays. */
__attribute__((format(printf, 2, 3))) static void add(out_t *out, const char *format, ...)
{
    enum { END = 8 };
    va_list arguments;
    va_start(arguments, format);
    size_t room = PAGE_MESSAGE - END - out->used;
    int length = vsnprintf(out->text + out->used, room, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= room)
        out->full = true;
    else
        out->used += (size_t)length;
}

static size_t end(out_t *out, const char *text)
{
    memcpy(out->text + out->used, text, strlen(text));
    return out->used + strlen(text);
}

static size_t write_hello(page_t *page, out_t *out)
{
    page->greeted = true;
    add(out, "{\"event\":\"hello\",\"version\":\"%s\",\"view\":%s", ECTWIN_VERSION, page->view ? "true" : "false");
    return end(out, "}");
}

static size_t write_reply(page_t *page, out_t *out)
{
    add(out, "{\"event\":\"reply\",\"id\":%.15g,\"reply\":%s", page->reply[page->first].id,
        page->reply[page->first].text);
    page->first = (page->first + 1) % PAGE_REPLIES;
    page->replies--;
    page->waiting--;
    return end(out, "}");
}

/* A bus is listed when it has described itself. */
static size_t write_buses(page_t *page, const buses_t *buses, out_t *out)
{
    const char *comma = "";
    page->buses = buses->changes;
    add(out, "{\"event\":\"buses\",\"buses\":[");
    for (size_t i = 0; i < buses->count && !out->full; i++) {
        const bus_t *bus = buses->all[i];
        if (bus->about.version == 0)
            continue;
        add(out, "%s{\"bus\":%u,\"process\":%ld,\"about\":%s}", comma, bus->number, bus->process, bus->about.text);
        comma = ",";
    }
    return end(out, "]}");
}

static size_t write_signals(page_t *page, const bus_t *bus, out_t *out)
{
    const char *comma = "";
    if (page->generation != bus->generation) {
        page->generation = bus->generation;
        page->described = 0;
        page->next = 0;
        page->values = 0;
        page->events = 0;
        memset(page->changed, 0, sizeof page->changed);
        memset(&page->traced, 0, sizeof page->traced);
    }
    add(out, "{\"event\":\"signals\",\"bus\":%u,\"of\":%zu,\"from\":%zu,\"signals\":[", bus->number, bus->table.count,
        page->described);
    while (page->described < bus->table.count) {
        add(out, "%s%s", comma, bus->table.signals[page->described].text);
        if (out->full)
            break;
        comma = ",";
        page->described++;
    }
    return end(out, "]}");
}

static size_t write_values(page_t *page, const bus_t *bus, out_t *out)
{
    const char *comma = "";
    if (page->next == 0)
        page->passing = bus->table.changes;
    add(out, "{\"event\":\"values\",\"bus\":%u,\"values\":[", bus->number);
    for (; page->next < bus->table.count; page->next++) {
        const table_signal_t *signal = &bus->table.signals[page->next];
        if (signal->changed == page->changed[page->next])
            continue;
        add(out, "%s[%zu,%s]", comma, page->next, signal->value);
        if (out->full)
            return end(out, "]}");
        comma = ",";
        page->changed[page->next] = signal->changed;
    }
    page->next = 0;
    page->due = false;
    page->values = page->passing;
    return end(out, "]}");
}

/* A page that is too late loses the oldest changes. */
static size_t write_changes(page_t *page, const bus_t *bus, out_t *out)
{
    const char *comma = "";
    const trace_t *trace = &bus->trace;
    if (!page->tracing)
        page->traces = trace->written;
    else if (trace->written - page->traces > TRACE_ROOM)
        page->traces = trace->written - TRACE_ROOM;
    page->tracing = true;
    add(out, "{\"event\":\"changes\",\"bus\":%u,\"changes\":[", bus->number);
    for (; page->traces != trace->written; page->traces++) {
        const trace_change_t *change = &trace->ring[page->traces % TRACE_ROOM];
        if (!trace_set_has(&page->traced, change->signal))
            continue;
        add(out, "%s[%u,%.6f,%.15g]", comma, change->signal, change->time_s, change->value);
        if (out->full)
            break;
        comma = ",";
    }
    return end(out, "]}");
}

static bool has_changes(const page_t *page, const bus_t *bus)
{
    return page->due && page->traced.count > 0 && (!page->tracing || page->traces != bus->trace.written);
}

static size_t write_stats(page_t *page, const bus_t *bus, out_t *out)
{
    page->counters = bus->counters.version;
    add(out, "{\"event\":\"stats\",\"bus\":%u,\"counters\":%s,\"answers\":%s", bus->number, bus->counters.text,
        bus->answers.text);
    return end(out, "}");
}

static size_t write_faults(page_t *page, const bus_t *bus, out_t *out)
{
    page->faults = bus->faults.version;
    add(out, "{\"event\":\"faults\",\"bus\":%u,\"faults\":%s", bus->number, bus->faults.text);
    return end(out, "}");
}

/* A page that is too late loses the oldest events. */
static size_t write_events(page_t *page, const bus_t *bus, out_t *out)
{
    const char *comma = "";
    if (bus->events - page->events > BUS_EVENTS)
        page->events = bus->events - BUS_EVENTS;
    add(out, "{\"event\":\"events\",\"bus\":%u,\"events\":[", bus->number);
    for (; page->events != bus->events; page->events++) {
        add(out, "%s%s", comma, bus->event[page->events % BUS_EVENTS]);
        if (out->full)
            break;
        comma = ",";
    }
    return end(out, "]}");
}

static size_t write_trouble(page_t *page, const bus_t *bus, out_t *out)
{
    char text[2 * BUS_TROUBLE] = "";
    const cJSON reason = {.type = cJSON_String, .valuestring = (char *)bus->trouble};
    page->troubles = bus->troubles;
    if (!cJSON_PrintPreallocated((cJSON *)&reason, text, sizeof text, false))
        snprintf(text, sizeof text, "\"the signals are not shown\"");
    add(out, "{\"event\":\"trouble\",\"bus\":%u,\"message\":%s", bus->number, text);
    return end(out, "}");
}

static bool lacks_signals(const page_t *page, const bus_t *bus)
{
    return page->generation != bus->generation || page->described < bus->table.count;
}

static bool lacks_values(const page_t *page, const bus_t *bus)
{
    return page->due && (page->values != bus->table.changes || page->next > 0);
}

/* The next message about the bus that the page shows. */
static size_t (*news_of(const page_t *page, const bus_t *bus))(page_t *, const bus_t *, out_t *)
{
    if (bus->troubles != page->troubles && bus->trouble[0] != 0)
        return write_trouble;
    if (bus->listed && lacks_signals(page, bus))
        return write_signals;
    if (bus->faults.version != page->faults)
        return write_faults;
    if (bus->listed && bus->events != page->events)
        return write_events;
    if (bus->counters.version != page->counters && bus->answers.version > 0)
        return write_stats;
    if (bus->listed && has_changes(page, bus))
        return write_changes;
    if (bus->listed && lacks_values(page, bus))
        return write_values;
    return NULL;
}

bool page_has_news(const page_t *page, const buses_t *buses)
{
    const bus_t *bus = bus_find(buses, page->bus);
    return page->known &&
           (!page->greeted || page->replies > 0 || page->buses != buses->changes || (bus && news_of(page, bus)));
}

size_t page_next(page_t *page, const buses_t *buses, char *message)
{
    out_t out = {.text = message};
    if (!page_has_news(page, buses))
        return 0;
    if (!page->greeted)
        return write_hello(page, &out);
    if (page->replies > 0)
        return write_reply(page, &out);
    if (page->buses != buses->changes)
        return write_buses(page, buses, &out);
    const bus_t *bus = bus_find(buses, page->bus);
    return news_of(page, bus)(page, bus, &out);
}
