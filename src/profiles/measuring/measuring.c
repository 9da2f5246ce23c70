/* SPDX-License-Identifier: MIT */
/* A measuring input of CiA 404: the physical value of its sensor, as field value and as process value. */
#include "profiles/measuring/measuring.h"

enum { FIRST_OBJECT = 0x6000, AUTOZERO = 0x6125, DIGITS = 0x6132, STATUS = 0x6150, MOST_DIGITS = 9 };

typedef enum kind { FIELD, PROCESS } kind_t;

static const struct {
    uint16_t index;
    kind_t kind;
} rows[ECT_MEASURING_QUANTITY_COUNT] = {
#define ROW(name, index, kind) {index, kind},
    ECT_MEASURING_QUANTITIES(ROW)
#undef ROW
};

static const uint16_t formats[ECT_MEASURING_FORMATS] = {FIRST_OBJECT, 0x9000, 0x7000};

/* --- links -------------------------------------------------------------------------------------------------------- */

static bool has(const ect_measuring_links_t *links, ect_measuring_quantity_t q)
{
    const ect_link_t *link = links->quantity[q];
    return link[ECT_MEASURING_REAL].bytes + link[ECT_MEASURING_INT32].bytes + link[ECT_MEASURING_INT16].bytes != 0;
}

bool ect_measuring_links_find(const ect_od_t *od, unsigned int number, ect_measuring_links_t *links)
{
    for (unsigned int q = 0; q < ECT_MEASURING_QUANTITY_COUNT; q++) {
        for (unsigned int f = 0; f < ECT_MEASURING_FORMATS; f++)
            links->quantity[q][f] = ect_link_to_element(od, (uint16_t)(formats[f] + rows[q].index), number);
    }
    links->autozero = ect_link_to_element(od, AUTOZERO, number);
    links->digits = ect_link_to_element(od, DIGITS, number);
    links->status = ect_link_to_element(od, STATUS, number);
    return has(links, ECT_MEASURING_PROCESS);
}

/* @return whether the index is that of a quantity. @param[out] q, f  quantity and format */
static bool quantity_of(uint16_t index, unsigned int *q, unsigned int *f)
{
    for (*q = 0; *q < ECT_MEASURING_QUANTITY_COUNT; (*q)++) {
        for (*f = 0; *f < ECT_MEASURING_FORMATS; (*f)++) {
            if (formats[*f] + rows[*q].index == index)
                return true;
        }
    }
    return false;
}

/* 6131h determines the unit of the signals. */
bool ect_measuring_knows(uint16_t index)
{
    unsigned int q, f;
    return index == AUTOZERO || index == DIGITS - 1 || index == DIGITS || index == STATUS || quantity_of(index, &q, &f);
}

bool ect_measuring_scales(const ect_measuring_links_t *links)
{
    return has(links, ECT_MEASURING_FIELD_1) && has(links, ECT_MEASURING_PROCESS_1) &&
           has(links, ECT_MEASURING_FIELD_2) && has(links, ECT_MEASURING_PROCESS_2);
}

static bool is_at(const ect_link_t *link, uint32_t offset)
{
    return link->bytes != 0 && link->offset == offset;
}

bool ect_measuring_writes(const ect_measuring_links_t *links, uint32_t offset)
{
    for (unsigned int f = 0; f < ECT_MEASURING_FORMATS; f++) {
        if (is_at(&links->quantity[ECT_MEASURING_FIELD][f], offset) ||
            is_at(&links->quantity[ECT_MEASURING_PROCESS][f], offset))
            return true;
    }
    return is_at(&links->status, offset);
}

const ect_link_t *ect_measuring_link(const ect_measuring_links_t *links, unsigned int number, uint16_t index,
                                     uint8_t subindex)
{
    unsigned int q, f;
    const ect_link_t *link = NULL;
    if (subindex != number + 1 && (subindex != 0 || number != 0))
        return NULL;
    if (index == AUTOZERO)
        link = &links->autozero;
    else if (index == DIGITS)
        link = &links->digits;
    else if (quantity_of(index, &q, &f))
        link = &links->quantity[q][f];
    return link != NULL && link->bytes != 0 ? link : NULL;
}

/* --- quantities --------------------------------------------------------------------------------------------------- */

/* An integer with decimal digits counts fractions of the unit. */
static double parts(const ect_measuring_t *m, unsigned int q, unsigned int f)
{
    int64_t digits = ect_link_load(m->instance, &m->links->digits);
    double number = 1;
    if (f == ECT_MEASURING_REAL || rows[q].kind == FIELD)
        return number;
    for (int64_t i = 0; i < digits && i < MOST_DIGITS; i++)
        number *= 10;
    return number;
}

/* Selects the format that has the value: the most precise one with a default in the file, else the most precise one. */
static unsigned int format_of(const ect_measuring_t *m, unsigned int q)
{
    const ect_link_t *link = m->links->quantity[q];
    unsigned int any = ECT_MEASURING_REAL;
    for (unsigned int f = ECT_MEASURING_FORMATS; f-- > 0;)
        any = link[f].bytes != 0 ? f : any;
    for (unsigned int f = any; f < ECT_MEASURING_FORMATS; f++) {
        if (link[f].bytes != 0 && link[f].given)
            return f;
    }
    return any;
}

static double load_format(const ect_measuring_t *m, unsigned int q, unsigned int f)
{
    return ect_link_load_real(m->instance, &m->links->quantity[q][f]) / parts(m, q, f);
}

static double load(const ect_measuring_t *m, ect_measuring_quantity_t q)
{
    return load_format(m, q, format_of(m, q));
}

/* @param except  a format that already has the value; ECT_MEASURING_FORMATS: none */
static void store_formats(const ect_measuring_t *m, unsigned int q, double value, unsigned int except)
{
    for (unsigned int f = 0; f < ECT_MEASURING_FORMATS; f++) {
        if (f != except)
            ect_link_store_real(m->instance, &m->links->quantity[q][f], value * parts(m, q, f));
    }
}

static void agree(const ect_measuring_t *m)
{
    for (unsigned int q = 0; q < ECT_MEASURING_QUANTITY_COUNT; q++)
        store_formats(m, q, load(m, (ect_measuring_quantity_t)q), format_of(m, q));
}

/* --- scaling ------------------------------------------------------------------------------------------------------ */

static ect_measuring_line_t line_of(const ect_measuring_t *m)
{
    return (ect_measuring_line_t){.field = {load(m, ECT_MEASURING_FIELD_1), load(m, ECT_MEASURING_FIELD_2)},
                                  .process = {load(m, ECT_MEASURING_PROCESS_1), load(m, ECT_MEASURING_PROCESS_2)}};
}

/* @return the value at `x` of the line through two points; two points with the same x do not scale */
static double through(const double *from, const double *to, double x)
{
    const double width = from[1] - from[0];
    return width > 0 || width < 0 ? to[0] + (x - from[0]) * (to[1] - to[0]) / width : x;
}

static double process_of(const ect_measuring_t *m)
{
    const ect_measuring_line_t line = line_of(m);
    return through(line.field, line.process, m->field) + load(m, ECT_MEASURING_OFFSET);
}

static uint8_t status_of(const ect_measuring_t *m)
{
    const double start = load(m, ECT_MEASURING_SPAN_START);
    const double end = load(m, ECT_MEASURING_SPAN_END);
    const uint8_t invalid = m->sensor->invalid != 0 ? ECT_MEASURING_INVALID : 0;
    if (!(start < end))
        return invalid;
    if (m->process > end)
        return invalid | ECT_MEASURING_ABOVE;
    return m->process < start ? invalid | ECT_MEASURING_BELOW : invalid;
}

void ect_measuring_update(ect_measuring_t *m)
{
    if (m->sensor->invalid == 0)
        m->field = through(m->line.process, m->line.field, m->sensor->value);
    m->process = process_of(m);
    store_formats(m, ECT_MEASURING_FIELD, m->field, ECT_MEASURING_FORMATS);
    store_formats(m, ECT_MEASURING_PROCESS, m->process, ECT_MEASURING_FORMATS);
    ect_link_store(m->instance, &m->links->status, status_of(m));
}

void ect_measuring_init(ect_measuring_t *m, const ect_measuring_links_t *links, const ect_measuring_sensor_t *sensor,
                        void *instance)
{
    m->links = links;
    m->sensor = sensor;
    m->instance = instance;
    agree(m);
    m->line = line_of(m);
    ect_measuring_update(m);
}

/* --- writes of a master and of a user ----------------------------------------------------------------------------- */

ect_reason_t ect_measuring_check(const ect_measuring_links_t *links, const ect_link_t *link, int64_t wanted)
{
    if (link == &links->autozero)
        return (uint64_t)wanted == ECT_MEASURING_ZERO ? ECT_OK : ECT_REASON_STORE;
    if (link == &links->digits)
        return wanted >= 0 && wanted <= MOST_DIGITS ? ECT_OK : ECT_REASON_RANGE;
    return ECT_OK;
}

void ect_measuring_written(ect_measuring_t *m, uint32_t offset)
{
    for (unsigned int q = 0; q < ECT_MEASURING_QUANTITY_COUNT; q++) {
        for (unsigned int f = 0; f < ECT_MEASURING_FORMATS; f++) {
            if (is_at(&m->links->quantity[q][f], offset))
                store_formats(m, q, load_format(m, q, f), f);
        }
    }
    if (is_at(&m->links->digits, offset))
        agree(m);
    ect_measuring_update(m);
    if (!is_at(&m->links->autozero, offset))
        return;
    store_formats(m, ECT_MEASURING_OFFSET, load(m, ECT_MEASURING_OFFSET) - m->process, ECT_MEASURING_FORMATS);
    ect_measuring_update(m);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

#define LARGEST INT64_C(1000000000000)
const ect_signal_t ect_measuring_signals[ECT_MEASURING_SIGNALS] = {
    ECT_SIGNAL(ect_measuring_t, process, "process", REAL, READ, INT64_MIN, INT64_MAX, NULL,
               "process value as the master reads it: 6130h, 7130h or 9130h"),
    ECT_SIGNAL(ect_measuring_t, field, "field", REAL, READ, INT64_MIN, INT64_MAX, NULL,
               "field value: 6100h, 7100h or 9100h"),
};

const ect_signal_t ect_measuring_sensor_signals[ECT_MEASURING_SENSOR_SIGNALS] = {
    ECT_SIGNAL(ect_measuring_sensor_t, value, "value", REAL, WRITE, -LARGEST, LARGEST, NULL,
               "physical value at the sensor"),
    ECT_SIGNAL(ect_measuring_sensor_t, invalid, "invalid", BOOL, WRITE, 0, 1, NULL,
               "the sensor fails: bit 0 of 6150h, and the process value stays"),
};
