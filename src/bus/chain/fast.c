/* SPDX-License-Identifier: MIT */
/*
 * Each datagram passes all controllers that take part in it before the next datagram does. In the chips the entire
 * frame passes one controller after the other. The result is the same, because each controller processes the datagrams
 * in their order, each datagram passes the controllers in their order, and the frame is the only connection between
 * controllers. Writes to registers take effect when the frame has passed all controllers.
 */
#include "bus/chain/fast.h"

#include <stdlib.h>
#include <string.h>

#include "bus/chain/bits.h"
#include "esc/cyclic.h"
#include "esc/route.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { SOURCE = 6, LOCAL = 0x02, TIMES = 8 };

/* Half a line of cache, because each frame reads it. The routes are apart, because frames do not read most of them. */
typedef struct controller {
    ect_esc_t *esc;
    uint64_t frame;   /* number of the last frame in which the controller took part */
    uint64_t times;   /* recorded system times that the controller has taken */
    uint32_t routing; /* ect_esc_routing() at the time of its route */
} controller_t;

/* A system time for all controllers: controllers before the source get the master's value, those behind the source's.
 */
typedef struct time_update {
    uint64_t at_ns;
    size_t source; /* the controller whose time is read; reach: none */
    size_t reach;
    uint32_t before, behind;
} time_update_t;

/* A station address or alias. The table is sorted by address, then by position. */
typedef struct station {
    uint16_t address;
    uint16_t position;
} station_t;

/* Logical addresses of an FMMU. The table is sorted by first byte. */
typedef struct window {
    uint64_t first, end;
    uint64_t furthest; /* the greatest end of this window and all previous ones */
    uint16_t position;
    uint16_t direction;
} window_t;

/* The sum of the routes of all controllers that a frame reaches. */
typedef struct sums {
    uint16_t events;
    uint16_t al_status;
    bool al_status_new;
    bool marks_source;
    bool awaits_frame;
    bool guards_writes;
    unsigned int time_takers;
} sums_t;

struct ect_fast {
    size_t count;
    size_t reach;
    bool out;         /* the output of the last controller is open */
    bool unread;      /* ect_fast_set_unread() */
    bool passes_data; /* the inputs of a controller may be the outputs of another one: they share a logical address */
    bool line_known, sums_known, stations_known, windows_known;
    uint64_t version; /* of the tables of stations and windows, and of the set of controllers */
    uint64_t now_ns;
    uint64_t frame; /* number of frames taken */
    sums_t sums;
    uint64_t *chosen; /* one bit for each controller that takes part in the present datagram; zero between datagrams */
    uint64_t times;   /* system times recorded */
    uint64_t times_before; /* system times recorded before the present frame */
    uint64_t taken;        /* system times that all controllers have taken */
    time_update_t time_updates[TIMES];
    station_t *stations;
    size_t station_count;
    window_t *windows;
    size_t window_count;
    uint32_t *touched;
    size_t touched_count;
    ect_esc_route_t *routes; /* of the controllers */
    controller_t controllers[];
};

ect_fast_t *ect_fast_new(size_t count)
{
    ECT_ASSERT(count >= 1 && count <= UINT16_MAX);
    ect_fast_t *f = calloc(1, sizeof *f + count * sizeof f->controllers[0]);
    if (!f)
        return NULL;
    f->count = count;
    f->chosen = calloc(ect_bits_words(count), sizeof *f->chosen);
    f->stations = calloc(count, 2 * sizeof *f->stations);
    f->windows = calloc(count, ECT_ESC_MAX_FMMU * sizeof *f->windows);
    f->touched = calloc(count, sizeof *f->touched);
    f->routes = calloc(count, sizeof *f->routes);
    if (f->chosen && f->stations && f->windows && f->touched && f->routes)
        return f;
    ect_fast_free(f);
    return NULL;
}

void ect_fast_free(ect_fast_t *fast)
{
    if (!fast)
        return;
    free(fast->chosen);
    free(fast->stations);
    free(fast->windows);
    free(fast->touched);
    free(fast->routes);
    free(fast);
}

/* --- tables of the controllers' routes -----------------------------------------------------------------------------
 */

static bool same_sums(const ect_esc_route_t *a, const ect_esc_route_t *b)
{
    return a->events == b->events && a->al_status == b->al_status && a->al_status_new == b->al_status_new &&
           a->marks_source == b->marks_source && a->awaits_frame == b->awaits_frame &&
           a->guards_writes == b->guards_writes && a->takes_time == b->takes_time;
}

static void read_route(ect_fast_t *f, size_t position)
{
    controller_t *c = &f->controllers[position];
    ect_esc_route_t *now = &f->routes[position];
    const ect_esc_route_t before = *now;
    c->routing = ect_esc_routing(c->esc);
    ect_esc_route(c->esc, now);
    ECT_ASSERT(now->window_count <= ECT_ESC_MAX_FMMU);
    f->line_known &= now->open == before.open && now->leaves_line == before.leaves_line;
    f->sums_known &= f->line_known && same_sums(now, &before);
    f->stations_known &= now->station == before.station && now->alias == before.alias;
    f->windows_known &= now->window_count == before.window_count &&
                        memcmp(now->windows, before.windows, now->window_count * sizeof now->windows[0]) == 0;
}

void ect_fast_put(ect_fast_t *fast, size_t position, ect_esc_t *esc)
{
    ECT_ASSERT(position < fast->count && esc != NULL);
    controller_t *c = &fast->controllers[position];
    c->esc = esc;
    c->times = fast->times;
    fast->version++;
    read_route(fast, position);
}

void ect_fast_refresh(ect_fast_t *fast, size_t position)
{
    ECT_ASSERT(position < fast->count && fast->controllers[position].esc != NULL);
    const controller_t *c = &fast->controllers[position];
    if (c->routing != ect_esc_routing(c->esc))
        read_route(fast, position);
}

/* Finds the end of the line, the first closed port. A controller that may send frames another way rules out a line. */
static void update_line(ect_fast_t *f)
{
    size_t i = 0;
    bool line = !f->routes[0].leaves_line;
    while (line && f->routes[i].open && i + 1 < f->count)
        line = !f->routes[++i].leaves_line;
    f->reach = line ? i + 1 : 0;
    ECT_ASSERT(f->reach <= f->count);
    f->out = f->routes[i].open;
    f->line_known = true;
    f->sums_known = false;
}

size_t ect_fast_reach(ect_fast_t *fast)
{
    if (!fast->line_known)
        update_line(fast);
    return fast->reach;
}

static void update_sums(ect_fast_t *f)
{
    sums_t sums = {0};
    if (f->sums_known)
        return;
    for (size_t i = 0; i < f->reach; i++) {
        const ect_esc_route_t *route = &f->routes[i];
        sums.events |= route->events;
        sums.al_status |= route->al_status;
        sums.al_status_new |= route->al_status_new;
        sums.marks_source |= route->marks_source;
        sums.awaits_frame |= route->awaits_frame;
        sums.guards_writes |= route->guards_writes;
        sums.time_takers += route->takes_time;
    }
    ECT_ASSERT(f->line_known && sums.time_takers <= f->reach);
    f->sums = sums;
    f->sums_known = true;
}

static int by_address(const void *a, const void *b)
{
    const station_t *x = a;
    const station_t *y = b;
    return x->address != y->address ? x->address - y->address : x->position - y->position;
}

static void update_stations(ect_fast_t *f)
{
    size_t n = 0;
    if (f->stations_known)
        return;
    for (size_t i = 0; i < f->count; i++) {
        const ect_esc_route_t *route = &f->routes[i];
        f->stations[n++] = (station_t){.address = route->station, .position = (uint16_t)i};
        if (route->alias != route->station)
            f->stations[n++] = (station_t){.address = route->alias, .position = (uint16_t)i};
    }
    ECT_ASSERT(n >= f->count && n <= 2 * f->count);
    qsort(f->stations, n, sizeof *f->stations, by_address);
    f->station_count = n;
    f->stations_known = true;
    f->version++;
}

static int by_first(const void *a, const void *b)
{
    const window_t *x = a;
    const window_t *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

static void update_windows(ect_fast_t *f)
{
    size_t n = 0;
    uint64_t furthest = 0, read_end = 0, written_end = 0;
    if (f->windows_known)
        return;
    f->passes_data = false;
    for (size_t i = 0; i < f->count; i++) {
        const ect_esc_route_t *route = &f->routes[i];
        for (unsigned int k = 0; k < route->window_count; k++) {
            const ect_esc_window_t *w = &route->windows[k];
            f->windows[n++] = (window_t){.first = w->first,
                                         .end = (uint64_t)w->first + w->length,
                                         .position = (uint16_t)i,
                                         .direction = w->direction};
        }
    }
    ECT_ASSERT(n <= f->count * ECT_ESC_MAX_FMMU);
    qsort(f->windows, n, sizeof *f->windows, by_first);
    for (size_t k = 0; k < n; k++) {
        window_t *w = &f->windows[k];
        const bool reads = (w->direction & ECT_PART_READ) != 0, writes = (w->direction & ECT_PART_WRITE) != 0;
        f->passes_data |= (reads && (writes || w->first < written_end)) || (writes && w->first < read_end);
        read_end = reads && w->end > read_end ? w->end : read_end;
        written_end = writes && w->end > written_end ? w->end : written_end;
        furthest = w->end > furthest ? w->end : furthest;
        w->furthest = furthest;
    }
    f->window_count = n;
    f->windows_known = true;
    f->version++;
}

/* --- the system time ---------------------------------------------------------------------------------------------- */

static uint32_t time_for(const time_update_t *t, size_t i)
{
    return i < t->source ? t->before : t->behind;
}

/* Delivers the times of earlier frames; due before any access to the controller. */
static void take_times(ect_fast_t *f, size_t i, uint64_t until)
{
    controller_t *c = &f->controllers[i];
    ECT_ASSERT(f->times - c->times <= TIMES);
    for (; c->times < until; c->times++) {
        const time_update_t *t = &f->time_updates[c->times % TIMES];
        if (f->routes[i].takes_time && i < t->reach && i != t->source)
            ect_esc_take_time(c->esc, time_for(t, i), t->at_ns);
    }
}

/* Delivers the times of the present frame, which take effect at its end, in the order of the datagrams. */
static void postpone_times(ect_fast_t *f, size_t i)
{
    controller_t *c = &f->controllers[i];
    ECT_ASSERT(c->times >= f->times_before && c->frame == f->frame);
    for (; c->times < f->times; c->times++) {
        const time_update_t *t = &f->time_updates[c->times % TIMES];
        if (f->routes[i].takes_time && i < t->reach && i != t->source)
            ect_esc_postpone_time(c->esc, time_for(t, i));
    }
}

void ect_fast_settle(ect_fast_t *fast)
{
    ECT_ASSERT(fast->times - fast->taken <= TIMES);
    fast->touched_count = 0;
    for (size_t i = 0; i < fast->count && fast->taken != fast->times; i++) {
        uint64_t due_ns = ect_esc_due(fast->controllers[i].esc);
        take_times(fast, i, fast->times);
        if (ect_esc_due(fast->controllers[i].esc) != due_ns)
            fast->touched[fast->touched_count++] = (uint32_t)i;
    }
    fast->taken = fast->times;
}

/* --- a datagram to a controller ----------------------------------------------------------------------------------- */

static unsigned int take_part(ect_fast_t *f, size_t i, uint8_t *d, unsigned int part)
{
    controller_t *c = &f->controllers[i];
    ECT_ASSERT(i < f->reach);
    take_times(f, i, f->times_before);
    if (c->frame != f->frame) {
        ECT_ASSERT(f->touched_count < f->count);
        c->frame = f->frame;
        f->touched[f->touched_count++] = (uint32_t)i;
        ect_esc_begin_of_frame(c->esc, f->now_ns);
    }
    postpone_times(f, i);
    unsigned int gain = ect_esc_datagram(c->esc, d, part | (f->unread && !f->passes_data ? ECT_PART_UNREAD : 0u));
    ect_fast_refresh(f, i);
    return gain;
}

static unsigned int to_position(ect_fast_t *f, uint8_t *d, unsigned int part)
{
    uint16_t position = (uint16_t)(0u - ect_load_le16(d + ECT_DATAGRAM_ADP));
    return position < f->reach ? take_part(f, position, d, part) : 0;
}

/* @return the first station whose address is not below this one */
static size_t first_station(const ect_fast_t *f, uint16_t address)
{
    ECT_ASSERT(f->stations_known);
    size_t low = 0;
    size_t high = f->station_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (f->stations[middle].address < address)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static unsigned int to_station(ect_fast_t *f, uint8_t *d, unsigned int part)
{
    uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADP);
    unsigned int gain = 0;
    update_stations(f);
    size_t end = first_station(f, address);
    size_t begin = end;
    while (end < f->station_count && f->stations[end].address == address && f->stations[end].position < f->reach)
        end++;
    for (size_t k = begin; k < end; k++)
        gain += take_part(f, f->stations[k].position, d, part);
    return gain;
}

/* Handles a broadcast read of AL status without side effects: the sum of all controllers is the reply. */
static bool is_known_status(const ect_fast_t *f, const uint8_t *d)
{
    return ect_load_le16(d + ECT_DATAGRAM_ADO) == ECT_REG_AL_STATUS && ect_datagram_length(d) <= 2 &&
           !f->sums.al_status_new;
}

static unsigned int to_all(ect_fast_t *f, uint8_t *d, unsigned int part)
{
    unsigned int gain = 0;
    if ((part & ECT_PART_READ) != 0 && is_known_status(f, d)) {
        for (unsigned int i = 0; i < ect_datagram_length(d); i++)
            d[ECT_DATAGRAM_DATA + i] |= (uint8_t)(f->sums.al_status >> (8 * i));
        return (unsigned int)f->reach;
    }
    for (size_t i = 0; i < f->reach; i++)
        gain += take_part(f, i, d, part);
    return gain;
}

static bool answers(const ect_fast_t *f, const uint8_t *d, size_t i)
{
    const ect_esc_route_t *route = &f->routes[i];
    uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADP);
    if (d[ECT_DATAGRAM_COMMAND] == ECT_ARMW)
        return i == (uint16_t)(0u - address);
    return address == route->station || address == route->alias;
}

/* Finds the controller read by a read-multiple-write; reach: none. @return false: several controllers */
static bool find_source(ect_fast_t *f, const uint8_t *d, size_t *source)
{
    uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADP);
    *source = (uint16_t)(0u - address);
    if (d[ECT_DATAGRAM_COMMAND] == ECT_FRMW) {
        update_stations(f);
        size_t k = first_station(f, address);
        bool found = k < f->station_count && f->stations[k].address == address;
        *source = found ? f->stations[k].position : f->reach;
        if (found && k + 1 < f->station_count && f->stations[k + 1].address == address)
            return false;
    }
    *source = *source < f->reach ? *source : f->reach;
    return true;
}

/* @return whether the datagram writes the entire system time, no controller protects it, and it can be recorded */
static bool is_time_update(const ect_fast_t *f, const uint8_t *d)
{
    unsigned int length = ect_datagram_length(d);
    return ect_load_le16(d + ECT_DATAGRAM_ADO) == ECT_REG_DC_SYSTEM_TIME && length >= 4 && length <= 8 &&
           !f->sums.guards_writes && f->times - f->taken < TIMES;
}

/* Accesses the source only. The other controllers are counted, and take the time at their next access. */
static unsigned int record_time(ect_fast_t *f, uint8_t *d, size_t source)
{
    const uint8_t *time = d + ECT_DATAGRAM_DATA;
    ECT_ASSERT(f->times - f->taken < TIMES && source <= f->reach);
    unsigned int gain = f->sums.time_takers;
    time_update_t update = {.at_ns = f->now_ns, .source = source, .reach = f->reach, .before = ect_load_le32(time)};
    if (source < f->reach) {
        ECT_ASSERT(gain >= f->routes[source].takes_time);
        gain -= f->routes[source].takes_time;
        gain += take_part(f, source, d, ECT_PART_READ);
    }
    update.behind = ect_load_le32(time);
    f->time_updates[f->times++ % TIMES] = update;
    return gain;
}

/* Executes a read-multiple-write: one controller reads, all others write. */
static unsigned int to_one_and_all(ect_fast_t *f, uint8_t *d)
{
    unsigned int gain = 0;
    size_t source;
    if (is_time_update(f, d) && find_source(f, d, &source))
        return record_time(f, d, source);
    for (size_t i = 0; i < f->reach; i++)
        gain += take_part(f, i, d, answers(f, d, i) ? ECT_PART_READ : ECT_PART_WRITE);
    return gain;
}

/* @return the number of windows that begin before `end` */
static size_t windows_before(const ect_fast_t *f, uint64_t end)
{
    ECT_ASSERT(f->windows_known);
    size_t low = 0;
    size_t high = f->window_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (f->windows[middle].first < end)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The words of `chosen` with a bit. */
typedef struct chosen {
    size_t low, high;
} chosen_t;

static inline chosen_t choose(ect_fast_t *f, uint64_t first, unsigned int length, unsigned int direction)
{
    chosen_t c = {.low = ect_bits_words(f->reach)};
    update_windows(f);
    for (size_t k = windows_before(f, first + length); k > 0 && f->windows[k - 1].furthest > first; k--) {
        const window_t *w = &f->windows[k - 1];
        size_t word = w->position / ECT_BITS_WORD;
        if (w->end <= first || (w->direction & direction) == 0 || w->position >= f->reach)
            continue;
        ect_bits_add(f->chosen, w->position);
        c.low = word < c.low ? word : c.low;
        c.high = word + 1 > c.high ? word + 1 : c.high;
    }
    return c;
}

static unsigned int to_windows(ect_fast_t *f, uint8_t *d, unsigned int direction)
{
    unsigned int gain = 0;
    for (chosen_t c = choose(f, ect_load_le32(d + ECT_DATAGRAM_ADP), ect_datagram_length(d), direction); c.low < c.high;
         c.low++) {
        ECT_ASSERT(c.low < ect_bits_words(f->reach));
        uint64_t left = f->chosen[c.low];
        f->chosen[c.low] = 0;
        while (left != 0)
            gain += take_part(f, ect_bits_take(c.low, &left), d, 0);
    }
    return gain;
}

/* @return whether a controller in `set` takes part in a datagram with a logical address */
static bool meets_logical(ect_fast_t *f, const uint8_t *d, unsigned int direction, const uint64_t *set)
{
    uint64_t met = 0;
    for (chosen_t c = choose(f, ect_load_le32(d + ECT_DATAGRAM_ADP), ect_datagram_length(d), direction); c.low < c.high;
         c.low++) {
        met |= f->chosen[c.low] & set[c.low];
        f->chosen[c.low] = 0;
    }
    return met != 0;
}

bool ect_fast_meets(ect_fast_t *fast, const uint8_t *frame, size_t length, const uint64_t *set)
{
    const size_t at = ect_frame_datagrams(frame, length);
    if (at == 0 || ect_fast_reach(fast) == 0)
        return true;
    update_sums(fast);
    for (const uint8_t *d = frame + at; d; d = ect_datagram_after(d)) {
        const uint8_t command = d[ECT_DATAGRAM_COMMAND];
        const unsigned int direction = ect_command_direction(command);
        if (direction != 0 ? meets_logical(fast, d, direction, set) : command != ECT_BRD || !is_known_status(fast, d))
            return true;
    }
    return false;
}

/* --- a frame ------------------------------------------------------------------------------------------------------ */

static unsigned int dispatch(ect_fast_t *f, uint8_t *d)
{
    if (ect_datagram_length(d) == 0)
        return 0;
    switch (d[ECT_DATAGRAM_COMMAND]) {
    case ECT_APRD:
        return to_position(f, d, ECT_PART_READ);
    case ECT_APWR:
        return to_position(f, d, ECT_PART_WRITE);
    case ECT_FPRD:
        return to_station(f, d, ECT_PART_READ);
    case ECT_FPWR:
        return to_station(f, d, ECT_PART_WRITE);
    case ECT_BRD:
        return to_all(f, d, ECT_PART_READ | ECT_PART_OR);
    case ECT_BWR:
        return to_all(f, d, ECT_PART_WRITE | ECT_PART_OR);
    case ECT_LRD:
    case ECT_LWR:
    case ECT_LRW:
        return to_windows(f, d, ect_command_direction(d[ECT_DATAGRAM_COMMAND]));
    case ECT_ARMW:
    case ECT_FRMW:
        return to_one_and_all(f, d);
    default:
        return 0;
    }
}

static void add(uint8_t *to, size_t value)
{
    ect_store_le16(to, (uint16_t)(ect_load_le16(to) + value));
}

/* Fills in the header, which passes before the data: an event cleared by this datagram is still set in it. */
static void pass_datagram(ect_fast_t *f, uint8_t *d)
{
    update_sums(f);
    ect_store_le16(d + ECT_DATAGRAM_IRQ, (uint16_t)(ect_load_le16(d + ECT_DATAGRAM_IRQ) | f->sums.events));
    add(d + ECT_DATAGRAM_DATA + ect_datagram_length(d), dispatch(f, d));
    if (ect_command_counts(d[ECT_DATAGRAM_COMMAND]))
        add(d + ECT_DATAGRAM_ADP, f->reach);
}

static bool reads_and_writes(uint8_t command)
{
    return command == ECT_APRW || command == ECT_FPRW || command == ECT_BRW;
}

static bool is_taken(uint8_t *d)
{
    for (; d; d = ect_datagram_next(d)) {
        if (reads_and_writes(d[ECT_DATAGRAM_COMMAND]))
            return false;
    }
    return true;
}

ect_fast_result_t ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns)
{
    size_t at = ect_frame_datagrams(frame, length);
    if (at == 0 || ect_fast_reach(fast) == 0)
        return ECT_FAST_NOT_TAKEN;
    update_sums(fast);
    if (fast->sums.awaits_frame || !is_taken(frame + at))
        return ECT_FAST_NOT_TAKEN;
    fast->now_ns = now_ns;
    fast->frame++;
    fast->times_before = fast->times;
    fast->touched_count = 0;
    if (fast->sums.marks_source)
        frame[SOURCE] |= LOCAL;
    for (uint8_t *d = frame + at; d; d = ect_datagram_next(d))
        pass_datagram(fast, d);
    bool out = fast->out;
    for (size_t i = 0; i < fast->touched_count; i++) {
        ect_esc_end_of_frame(fast->controllers[fast->touched[i]].esc);
        ect_fast_refresh(fast, fast->touched[i]);
    }
    return out ? ECT_FAST_OUT : ECT_FAST_BACK;
}

void ect_fast_set_unread(ect_fast_t *fast, bool unread)
{
    fast->unread = unread;
}

const uint32_t *ect_fast_touched(const ect_fast_t *fast, size_t *count)
{
    *count = fast->touched_count;
    return fast->touched;
}

/* --- replies in advance ------------------------------------------------------------------------------------------- */

bool ect_fast_steady(ect_fast_t *fast, ect_chain_steady_t *steady)
{
    if (ect_fast_reach(fast) == 0 || fast->out)
        return false;
    update_sums(fast);
    update_stations(fast);
    update_windows(fast);
    const sums_t *sums = &fast->sums;
    if (sums->awaits_frame || sums->guards_writes)
        return false;
    for (size_t i = 0; i < fast->reach; i++) {
        if (!ect_esc_steady(fast->controllers[i].esc))
            return false;
    }
    *steady = (ect_chain_steady_t){.reach = fast->reach,
                                   .time_takers = (unsigned int)sums->time_takers,
                                   .events = sums->events,
                                   .al_status = sums->al_status,
                                   .al_status_new = sums->al_status_new,
                                   .marks_source = sums->marks_source,
                                   .version = fast->version};
    return true;
}

bool ect_fast_visit_mapped(ect_fast_t *fast, uint32_t first, uint16_t length, unsigned int direction,
                           ect_chain_visit_t visit, void *ctx)
{
    bool going = true;
    for (chosen_t c = choose(fast, first, length, direction); c.low < c.high; c.low++) {
        uint64_t left = fast->chosen[c.low];
        fast->chosen[c.low] = 0;
        while (left != 0) {
            size_t i = ect_bits_take(c.low, &left);
            going = going && visit(ctx, i, fast->controllers[i].esc);
        }
    }
    return going;
}

const ect_esc_t *ect_fast_time_source(ect_fast_t *fast, const uint8_t *datagram, bool *takes)
{
    size_t source;
    if (!find_source(fast, datagram, &source) || source >= fast->reach)
        return NULL;
    *takes = fast->routes[source].takes_time;
    return fast->controllers[source].esc;
}
