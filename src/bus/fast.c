/* SPDX-License-Identifier: MIT */
/*
 * Datagram after datagram, each to those whom it concerns. That is not the order of the chip, where the whole frame
 * goes to one controller and then to the next; it comes to the same, because a controller sees the datagrams in their
 * order and a datagram the controllers in theirs, and nothing else passes from one to another. What would is not taken.
 */
#include "bus/fast.h"

#include <stdlib.h>
#include <string.h>

#include "esc/route.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { SOURCE = 6, LOCAL = 0x02, WORD = 64 };

typedef struct controller {
    ect_esc_t *esc;
    uint64_t frame;   /* the last one that it took part in */
    uint32_t routing; /* what its route is known of */
    ect_esc_route_t route;
} controller_t;

/* Ascending by address, then by position. */
typedef struct station {
    uint16_t address;
    uint16_t position;
} station_t;

/* Ascending by their first byte. */
typedef struct window {
    uint64_t first, end;
    uint64_t furthest; /* the greatest end of this one and all before it */
    uint16_t position;
    uint16_t direction;
} window_t;

/* What a frame takes along from all that it reaches. */
typedef struct sums {
    uint16_t events;
    uint16_t al_status;
    bool al_status_new;
    bool marks_source;
    bool writes_registers;
    bool awaits_frame;
} sums_t;

struct ect_fast {
    size_t count;
    size_t reach;
    bool out; /* the last port is open, too */
    bool line_known, sums_known, stations_known, windows_known;
    uint64_t now_ns;
    uint64_t frame; /* counts those that were taken */
    sums_t sums;
    uint64_t *clocks; /* a bit a controller: it is reached and has clocks */
    uint64_t *chosen; /* a bit a controller: it takes part in the present datagram; else zero */
    station_t *stations;
    size_t station_count;
    window_t *windows;
    size_t window_count;
    uint32_t *touched;
    size_t touched_count;
    controller_t controllers[];
};

static size_t words(size_t count)
{
    return (count + WORD - 1) / WORD;
}

ect_fast_t *ect_fast_new(size_t count)
{
    ect_fast_t *f = calloc(1, sizeof *f + count * sizeof f->controllers[0]);
    if (!f)
        return NULL;
    f->count = count;
    f->clocks = calloc(words(count), sizeof *f->clocks);
    f->chosen = calloc(words(count), sizeof *f->chosen);
    f->stations = calloc(count, 2 * sizeof *f->stations);
    f->windows = calloc(count, ECT_ESC_MAX_FMMU * sizeof *f->windows);
    f->touched = calloc(count, sizeof *f->touched);
    if (f->clocks && f->chosen && f->stations && f->windows && f->touched)
        return f;
    ect_fast_free(f);
    return NULL;
}

void ect_fast_free(ect_fast_t *fast)
{
    if (!fast)
        return;
    free(fast->clocks);
    free(fast->chosen);
    free(fast->stations);
    free(fast->windows);
    free(fast->touched);
    free(fast);
}

/* --- what is known of the controllers ----------------------------------------------------------------------------- */

static bool same_sums(const ect_esc_route_t *a, const ect_esc_route_t *b)
{
    return a->events == b->events && a->al_status == b->al_status && a->al_status_new == b->al_status_new &&
           a->marks_source == b->marks_source && a->writes_registers == b->writes_registers &&
           a->awaits_frame == b->awaits_frame;
}

static void read_route(ect_fast_t *f, controller_t *c)
{
    const ect_esc_route_t before = c->route;
    const ect_esc_route_t *now = &c->route;
    c->routing = ect_esc_routing(c->esc);
    ect_esc_route(c->esc, &c->route);
    f->line_known &= now->open == before.open && now->goes_astray == before.goes_astray;
    f->sums_known &= f->line_known && same_sums(now, &before);
    f->stations_known &= now->station == before.station && now->alias == before.alias;
    f->windows_known &= now->window_count == before.window_count &&
                        memcmp(now->windows, before.windows, now->window_count * sizeof now->windows[0]) == 0;
}

void ect_fast_put(ect_fast_t *fast, size_t position, ect_esc_t *esc)
{
    controller_t *c = &fast->controllers[position];
    c->esc = esc;
    read_route(fast, c);
    fast->line_known = fast->sums_known = false; /* whether it has clocks is not asked again */
}

void ect_fast_look(ect_fast_t *fast, size_t position)
{
    controller_t *c = &fast->controllers[position];
    if (c->routing != ect_esc_routing(c->esc))
        read_route(fast, c);
}

/* As far as one port after the other is open; none of those on the way may send a frame round in a circle. */
static void know_line(ect_fast_t *f)
{
    size_t i = 0;
    bool line = !f->controllers[0].route.goes_astray;
    while (line && f->controllers[i].route.open && i + 1 < f->count)
        line = !f->controllers[++i].route.goes_astray;
    f->reach = line ? i + 1 : 0;
    f->out = f->controllers[i].route.open;
    f->line_known = true;
    f->sums_known = false;
}

size_t ect_fast_reach(ect_fast_t *fast)
{
    if (!fast->line_known)
        know_line(fast);
    return fast->reach;
}

static void know_sums(ect_fast_t *f)
{
    sums_t sums = {0};
    if (f->sums_known)
        return;
    memset(f->clocks, 0, words(f->count) * sizeof *f->clocks);
    for (size_t i = 0; i < f->reach; i++) {
        const ect_esc_route_t *route = &f->controllers[i].route;
        sums.events |= route->events;
        sums.al_status |= route->al_status;
        sums.al_status_new |= route->al_status_new;
        sums.marks_source |= route->marks_source;
        sums.writes_registers |= route->writes_registers;
        sums.awaits_frame |= route->awaits_frame;
        f->clocks[i / WORD] |= (uint64_t)route->clock << (i % WORD);
    }
    f->sums = sums;
    f->sums_known = true;
}

static int by_address(const void *a, const void *b)
{
    const station_t *x = a;
    const station_t *y = b;
    return x->address != y->address ? x->address - y->address : x->position - y->position;
}

static void know_stations(ect_fast_t *f)
{
    size_t n = 0;
    if (f->stations_known)
        return;
    for (size_t i = 0; i < f->count; i++) {
        const ect_esc_route_t *route = &f->controllers[i].route;
        f->stations[n++] = (station_t){.address = route->station, .position = (uint16_t)i};
        if (route->alias != route->station)
            f->stations[n++] = (station_t){.address = route->alias, .position = (uint16_t)i};
    }
    qsort(f->stations, n, sizeof *f->stations, by_address);
    f->station_count = n;
    f->stations_known = true;
}

static int by_first(const void *a, const void *b)
{
    const window_t *x = a;
    const window_t *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

static void know_windows(ect_fast_t *f)
{
    size_t n = 0;
    uint64_t furthest = 0;
    if (f->windows_known)
        return;
    for (size_t i = 0; i < f->count; i++) {
        const ect_esc_route_t *route = &f->controllers[i].route;
        for (unsigned int k = 0; k < route->window_count; k++) {
            const ect_esc_window_t *w = &route->windows[k];
            f->windows[n++] = (window_t){.first = w->first,
                                         .end = (uint64_t)w->first + w->length,
                                         .position = (uint16_t)i,
                                         .direction = w->direction};
        }
    }
    qsort(f->windows, n, sizeof *f->windows, by_first);
    for (size_t k = 0; k < n; k++) {
        furthest = f->windows[k].end > furthest ? f->windows[k].end : furthest;
        f->windows[k].furthest = furthest;
    }
    f->window_count = n;
    f->windows_known = true;
}

/* --- a datagram to a controller ----------------------------------------------------------------------------------- */

static unsigned int take_part(ect_fast_t *f, size_t i, uint8_t *d, unsigned int part)
{
    controller_t *c = &f->controllers[i];
    if (c->frame != f->frame) {
        c->frame = f->frame;
        f->touched[f->touched_count++] = (uint32_t)i;
        ect_esc_begin_of_frame(c->esc, f->now_ns);
    }
    unsigned int gain = ect_esc_datagram(c->esc, d, part);
    ect_fast_look(f, i);
    return gain;
}

static unsigned int to_position(ect_fast_t *f, uint8_t *d, unsigned int part)
{
    uint16_t position = (uint16_t)(0u - ect_load_le16(d + ECT_DATAGRAM_ADP));
    return position < f->reach ? take_part(f, position, d, part) : 0;
}

/* Of those with that address, or one above it, the first. */
static size_t first_station(const ect_fast_t *f, uint16_t address)
{
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
    know_stations(f);
    size_t end = first_station(f, address);
    size_t begin = end;
    while (end < f->station_count && f->stations[end].address == address && f->stations[end].position < f->reach)
        end++;
    for (size_t k = begin; k < end; k++)
        gain += take_part(f, f->stations[k].position, d, part);
    return gain;
}

/* What all together answer, as long as reading it changes nothing. */
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

static bool is_time(const uint8_t *d)
{
    unsigned int first = ect_load_le16(d + ECT_DATAGRAM_ADO);
    return first >= ECT_REG_DC_SYSTEM_TIME && first + ect_datagram_length(d) <= ECT_REG_DC_SYSTEM_TIME + 8;
}

static bool answers(const ect_fast_t *f, const uint8_t *d, size_t i)
{
    const ect_esc_route_t *route = &f->controllers[i].route;
    uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADP);
    if (d[ECT_DATAGRAM_COMMAND] == ECT_ARMW)
        return i == (uint16_t)(0u - address);
    return address == route->station || address == route->alias;
}

/* Who is addressed in a read-multiple-write. */
static void choose_source(ect_fast_t *f, const uint8_t *d)
{
    uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADP);
    uint16_t position = (uint16_t)(0u - address);
    if (d[ECT_DATAGRAM_COMMAND] == ECT_ARMW) {
        if (position < f->reach)
            f->chosen[position / WORD] |= 1ull << (position % WORD);
        return;
    }
    know_stations(f);
    for (size_t k = first_station(f, address); k < f->station_count && f->stations[k].address == address; k++) {
        position = f->stations[k].position;
        if (position < f->reach)
            f->chosen[position / WORD] |= 1ull << (position % WORD);
    }
}

/* One reads, all others write. The time goes only to those who have a use for it. */
static unsigned int to_one_and_all(ect_fast_t *f, uint8_t *d)
{
    unsigned int gain = 0;
    if (!is_time(d)) {
        for (size_t i = 0; i < f->reach; i++)
            gain += take_part(f, i, d, answers(f, d, i) ? ECT_PART_READ : ECT_PART_WRITE);
        return gain;
    }
    choose_source(f, d);
    for (size_t w = 0; w < words(f->reach); w++) {
        uint64_t sources = f->chosen[w];
        f->chosen[w] = 0;
        for (uint64_t left = sources | f->clocks[w]; left != 0; left &= left - 1) {
            unsigned int bit = (unsigned int)__builtin_ctzll(left);
            unsigned int part = (sources >> bit & 1u) != 0 ? ECT_PART_READ : ECT_PART_WRITE;
            gain += take_part(f, w * WORD + bit, d, part);
        }
    }
    return gain;
}

/* Windows that begin before `end`. */
static size_t windows_before(const ect_fast_t *f, uint64_t end)
{
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

static unsigned int to_windows(ect_fast_t *f, uint8_t *d, unsigned int direction)
{
    uint64_t first = ect_load_le32(d + ECT_DATAGRAM_ADP);
    size_t low = words(f->reach);
    size_t high = 0;
    unsigned int gain = 0;
    know_windows(f);
    for (size_t k = windows_before(f, first + ect_datagram_length(d)); k > 0 && f->windows[k - 1].furthest > first;
         k--) {
        const window_t *w = &f->windows[k - 1];
        size_t word = w->position / WORD;
        if (w->end <= first || (w->direction & direction) == 0 || w->position >= f->reach)
            continue;
        f->chosen[word] |= 1ull << (w->position % WORD);
        low = word < low ? word : low;
        high = word + 1 > high ? word + 1 : high;
    }
    for (; low < high; low++) {
        uint64_t left = f->chosen[low];
        f->chosen[low] = 0;
        for (; left != 0; left &= left - 1)
            gain += take_part(f, low * WORD + (unsigned int)__builtin_ctzll(left), d, 0);
    }
    return gain;
}

/* --- a frame ------------------------------------------------------------------------------------------------------ */

static unsigned int lead(ect_fast_t *f, uint8_t *d)
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
        return to_windows(f, d, ECT_PART_READ);
    case ECT_LWR:
        return to_windows(f, d, ECT_PART_WRITE);
    case ECT_LRW:
        return to_windows(f, d, ECT_PART_READ | ECT_PART_WRITE);
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

/* The header passes before the data: an event that this datagram clears is still in it. */
static void pass_datagram(ect_fast_t *f, uint8_t *d)
{
    know_sums(f);
    ect_store_le16(d + ECT_DATAGRAM_IRQ, (uint16_t)(ect_load_le16(d + ECT_DATAGRAM_IRQ) | f->sums.events));
    add(d + ECT_DATAGRAM_DATA + ect_datagram_length(d), lead(f, d));
    if (ect_command_counts(d[ECT_DATAGRAM_COMMAND]))
        add(d + ECT_DATAGRAM_ADP, f->reach);
}

static bool overlaps(const uint8_t *d, unsigned int first, unsigned int end)
{
    unsigned int address = ect_load_le16(d + ECT_DATAGRAM_ADO);
    return address < end && address + ect_datagram_length(d) > first;
}

static bool writes(uint8_t command)
{
    return command == ECT_APWR || command == ECT_FPWR || command == ECT_BWR || command == ECT_ARMW ||
           command == ECT_FRMW;
}

/* Station addresses may be written, what stands around them may change the way of the frame itself. */
static bool may_close_port(const uint8_t *d)
{
    return overlaps(d, 0, ECT_REG_STATION_ADDRESS) || overlaps(d, ECT_REG_STATION_ALIAS + 2, ECT_REG_DL_STATUS);
}

static bool is_taken(const ect_fast_t *f, uint8_t *d)
{
    bool fmmu = false;
    bool logical = false;
    for (; d; d = ect_datagram_next(d)) {
        uint8_t command = d[ECT_DATAGRAM_COMMAND];
        bool writes_logical = command == ECT_LWR || command == ECT_LRW;
        bool plain = command != ECT_APRW && command != ECT_FPRW && command != ECT_BRW &&
                     !(writes(command) && may_close_port(d)) && !(writes_logical && f->sums.writes_registers);
        if (!plain)
            return false;
        logical |= writes_logical || command == ECT_LRD;
        fmmu |= writes(command) && overlaps(d, ECT_REG_FMMU, ECT_REG_SM);
    }
    return !(fmmu && logical);
}

ect_fast_result_t ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns)
{
    size_t at = ect_frame_datagrams(frame, length);
    if (at == 0 || ect_fast_reach(fast) == 0)
        return ECT_FAST_NOT_TAKEN;
    know_sums(fast);
    if (fast->sums.awaits_frame || !is_taken(fast, frame + at))
        return ECT_FAST_NOT_TAKEN;
    fast->now_ns = now_ns;
    fast->frame++;
    fast->touched_count = 0;
    if (fast->sums.marks_source)
        frame[SOURCE] |= LOCAL;
    for (uint8_t *d = frame + at; d; d = ect_datagram_next(d))
        pass_datagram(fast, d);
    for (size_t i = 0; i < fast->touched_count; i++)
        ect_esc_end_of_frame(fast->controllers[fast->touched[i]].esc);
    return fast->out ? ECT_FAST_OUT : ECT_FAST_BACK;
}

const uint32_t *ect_fast_touched(const ect_fast_t *fast, size_t *count)
{
    *count = fast->touched_count;
    return fast->touched;
}
