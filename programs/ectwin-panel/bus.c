/* SPDX-License-Identifier: MIT */
#include "bus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct taking {
    buses_t *buses;
    bus_t *bus;
} taking_t;

bus_t *bus_find(const buses_t *buses, unsigned int number)
{
    for (size_t i = 0; i < buses->count; i++) {
        if (buses->all[i]->number == number)
            return buses->all[i];
    }
    return NULL;
}

static void put(bus_text_t *text, const char *content, size_t length)
{
    if (length >= sizeof text->text ||
        (text->version > 0 && text->length == length && memcmp(text->text, content, length) == 0))
        return;
    memcpy(text->text, content, length);
    text->text[length] = 0;
    text->length = length;
    text->version++;
}

void bus_connected(buses_t *buses, bus_t *bus, long process)
{
    bus_disconnected(buses, bus);
    bus->process = process;
    bus->generation++;
    bus_poll(bus, false);
}

/* A page has at most eight requests without a reply: one that never gets a reply takes a place for ever. */
static void refuse_waiting(const buses_t *buses, const bus_t *bus)
{
    const link_t *link = &bus->link;
    for (size_t i = 0; i < link->count; i++) {
        const link_request_t *request = &link->waiting[(link->first + i) % LINK_WAITING];
        if (request->kind == LINK_PAGE)
            buses->reply(buses->ctx, bus, request,
                         "{\"ok\":false,\"message\":\"the connection to the bus has ended\"}");
    }
}

void bus_disconnected(buses_t *buses, bus_t *bus)
{
    refuse_waiting(buses, bus);
    table_clear(&bus->table);
    memset(&bus->link, 0, sizeof bus->link);
    bus->next_faults.length = 0;
    bus->watched = false;
    bus->listed = false;
    bus->events = 0;
    bus->last_event = 0;
    bus->more_events = false;
    bus->lines = 0;
    bus->trouble[0] = 0;
    buses->changes++;
}

static void ask(bus_t *bus, link_kind_t kind, const char *text)
{
    const link_request_t request = {.kind = kind};
    (void)link_ask(&bus->link, text, &request);
}

static void ask_for_events(bus_t *bus)
{
    char text[64];
    snprintf(text, sizeof text, "{\"op\":\"events\",\"after\":%.0f}", bus->last_event);
    ask(bus, LINK_EVENTS, text);
}

void bus_poll(bus_t *bus, bool open)
{
    if (bus->link.count > 0) /* a slow twin gets no further request */
        return;
    ask(bus, LINK_ABOUT, "{\"op\":\"about\"}");
    if (!open)
        return;
    if (!bus->watched)
        ask(bus, LINK_LIST, "{\"op\":\"list\",\"slave\":0}");
    bus->watched = true;
    ask(bus, LINK_STATS, "{\"op\":\"stats\"}");
    ask(bus, LINK_FAULTS, "{\"op\":\"fault\"}");
    ask_for_events(bus);
}

static void take_about(buses_t *buses, bus_t *bus, const char *text, bool last)
{
    uint32_t before = bus->about.version;
    if (!last)
        put(&bus->about, text, strlen(text));
    buses->changes += bus->about.version != before;
}

static void end_list(bus_t *bus, const cJSON *line)
{
    if (cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(line, "ok")))
        ask(bus, LINK_WATCH, "{\"op\":\"watch\",\"slave\":0}");
    bus->listed = bus->trouble[0] == 0;
}

static void give_up(bus_t *bus, const char *reason)
{
    snprintf(bus->trouble, sizeof bus->trouble, "%s", reason);
    bus->troubles++;
}

static void take_list(bus_t *bus, const char *text, const cJSON *line, bool last)
{
    if (last)
        end_list(bus, line);
    else if (!table_add(&bus->table, text, line) && bus->trouble[0] == 0)
        give_up(bus, "this bus has more than 4096 signals: the panel shows none of them");
}

static void take_watch(bus_t *bus, const cJSON *line)
{
    const char *message = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "message"));
    if (!cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(line, "ok")))
        give_up(bus, message ? message : "the twin does not report its signals");
}

static void take_stats(bus_t *bus, const char *text, const cJSON *line, bool last)
{
    if (!last)
        put(cJSON_HasObjectItem(line, "answers") ? &bus->answers : &bus->counters, text, strlen(text));
}

/* The faults become one array; those that do not fit are left out. */
static void take_fault(bus_t *bus, const cJSON *line, bool last)
{
    bus_text_t *next = &bus->next_faults;
    if (next->length == 0)
        next->text[next->length++] = '[';
    if (last) {
        next->text[next->length++] = ']';
        put(&bus->faults, next->text, next->length);
        next->length = 0;
        return;
    }
    char *fault = cJSON_PrintUnformatted(cJSON_GetObjectItemCaseSensitive(line, "fault"));
    size_t length = fault ? strlen(fault) : 0;
    if (length > 0 && next->length + length + 2 < sizeof next->text) {
        if (next->length > 1)
            next->text[next->length++] = ',';
        memcpy(next->text + next->length, fault, length);
        next->length += length;
    }
    cJSON_free(fault);
}

/* A reply has a few events only; requests follow until a reply has none. */
static void take_event(bus_t *bus, const char *text, const cJSON *line, bool last)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(line, "number");
    if (last) {
        if (bus->more_events)
            ask_for_events(bus);
        bus->more_events = false;
    } else if (cJSON_IsNumber(number) && number->valuedouble > bus->last_event) {
        if (strlen(text) < BUS_EVENT)
            strcpy(bus->event[bus->events++ % BUS_EVENTS], text);
        bus->last_event = number->valuedouble;
        bus->more_events = true;
    }
}

/* A line that does not fit is left out with all that follow: the reply is refused as a whole. */
static void take_page(const taking_t *taking, const link_request_t *request, const char *text, bool last)
{
    static const char too_long[] = "{\"ok\":false,\"message\":\"the reply is too long for this panel\"}";
    char whole[BUS_LINES + 32];
    bus_t *bus = taking->bus;
    size_t length = strlen(text);
    if (!last) {
        if (bus->lines + length + 1 < sizeof bus->line)
            snprintf(bus->line + bus->lines, sizeof bus->line - bus->lines, "%s%s", bus->lines > 0 ? "," : "", text);
        bus->lines += length + (bus->lines > 0);
        return;
    }
    snprintf(whole, sizeof whole, "{\"ok\":true,\"lines\":[%s]}", bus->line);
    const char *reply = bus->lines == 0 ? text : bus->lines + 1 < sizeof bus->line ? whole : too_long;
    bus->lines = 0;
    taking->buses->reply(taking->buses->ctx, bus, request, reply);
}

static void take(void *ctx, const link_request_t *request, const char *text, const cJSON *line, bool last)
{
    const taking_t *taking = ctx;
    bus_t *bus = taking->bus;
    switch (request->kind) {
    case LINK_CHANGE:
        (void)table_change(&bus->table, text, line);
        return;
    case LINK_ABOUT:
        take_about(taking->buses, bus, text, last);
        return;
    case LINK_LIST:
        take_list(bus, text, line, last);
        return;
    case LINK_WATCH:
        take_watch(bus, line);
        return;
    case LINK_STATS:
        take_stats(bus, text, line, last);
        return;
    case LINK_FAULTS:
        take_fault(bus, line, last);
        return;
    case LINK_EVENTS:
        take_event(bus, text, line, last);
        return;
    case LINK_PAGE:
        take_page(taking, request, text, last);
        return;
    case LINK_RELEASE:
        return;
    }
}

bool bus_take(buses_t *buses, bus_t *bus, const char *bytes, size_t length)
{
    taking_t taking = {.buses = buses, .bus = bus};
    return link_take(&bus->link, bytes, length, take, &taking);
}
