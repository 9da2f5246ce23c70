/* SPDX-License-Identifier: MIT */
/*
 * The process image. On the way to SAFEOP the assignment and the mapping are read from the dictionary and laid out as
 * runs: entries that lie side by side both in the image and in the instance become one copy. A cycle is then a few
 * copies and one PDI access a direction.
 */
#include <string.h>

#include "slave/internal.h"

enum { LARGEST_IMAGE_BITS = 1486 * 8, WIRE = 32 /* a mapping entry has at most 255 bits */ };

typedef struct layout {
    ect_slave_t *slave;
    uint16_t capacity; /* runs that are left */
    uint16_t count;
    ect_pdo_run_t *runs;
    uint32_t bits;
    uint16_t access; /* ECT_ACCESS_RXPDO or _TXPDO: what a mapped entry must allow */
} layout_t;

/* Bytes in memory that are already as on the wire. */
static bool is_plain(const ect_entry_t *entry, const uint8_t *data)
{
    bool one_byte = entry->bit_length <= 8 || entry->data_type == ECT_TYPE_OCTET_STRING ||
                    entry->data_type == ECT_TYPE_VISIBLE_STRING;
    return data != NULL && entry->bit_length % 8 == 0 && !ect_od_is_bits(entry) &&
           (one_byte || ect_host_is_little_endian());
}

static bool extend(layout_t *l, uint8_t *data, uint16_t bits)
{
    if (l->count == 0)
        return false;
    ect_pdo_run_t *last = &l->runs[l->count - 1];
    if (last->entry || last->first_bit + last->bits != (uint16_t)l->bits || last->data + last->bits / 8 != data)
        return false;
    last->bits = (uint16_t)(last->bits + bits);
    return true;
}

static bool add_entry(layout_t *l, const ect_entry_t *entry, uint16_t bits)
{
    uint8_t *data = ect_od_data(&l->slave->od, entry);
    bool plain = is_plain(entry, data) && l->bits % 8 == 0 && bits == entry->bit_length;
    if (plain && extend(l, data, bits))
        return true;
    if (l->count == l->capacity)
        return false;
    l->runs[l->count++] =
        (ect_pdo_run_t){.entry = plain ? NULL : entry, .data = data, .first_bit = (uint16_t)l->bits, .bits = bits};
    return true;
}

static bool add_mapping(layout_t *l, uint32_t mapping)
{
    uint16_t index = (uint16_t)(mapping >> 16);
    uint16_t bits = mapping & 0xFF;
    const ect_object_t *object;
    const ect_entry_t *entry;
    if (l->bits + bits > LARGEST_IMAGE_BITS)
        return false;
    if (index != 0) {
        if (ect_od_lookup(&l->slave->od, index, (uint8_t)(mapping >> 8), &object, &entry) != ECT_OK ||
            (entry->access & l->access) == 0 || bits > entry->bit_length || !add_entry(l, entry, bits))
            return false;
    }
    l->bits += bits;
    return true;
}

/* Hands each element of an assignment or mapping object to `add`. */
static bool for_each(layout_t *l, uint16_t index, bool (*add)(layout_t *l, uint32_t value))
{
    const ect_od_t *od = &l->slave->od;
    uint32_t count = 0;
    uint32_t value = 0;
    if (ect_od_number(od, index, 0, &count) != ECT_OK)
        return false;
    for (uint32_t i = 1; i <= count; i++) {
        if (ect_od_number(od, index, (uint8_t)i, &value) != ECT_OK || !add(l, value))
            return false;
    }
    return true;
}

static bool add_pdo(layout_t *l, uint32_t pdo)
{
    return for_each(l, (uint16_t)pdo, add_mapping);
}

/* A device without the assignment object has no process data in that direction. */
static bool lay_out(layout_t *l, uint16_t assignment)
{
    return !ect_od_find(&l->slave->od, assignment) || for_each(l, assignment, add_pdo);
}

/* Lays both directions out. Returns 0 or the AL status code that says which one cannot be. */
uint16_t ect_pdo_configure(ect_slave_t *s)
{
    layout_t out = {
        .slave = s, .capacity = s->config.device->pdo_runs, .runs = s->config.runs, .access = ECT_ACCESS_RXPDO};
    if (!lay_out(&out, ECT_ASSIGN_OUTPUTS))
        return ECT_AL_OUTPUT_MAPPING;
    layout_t in = {.slave = s,
                   .capacity = (uint16_t)(out.capacity - out.count),
                   .runs = out.runs + out.count,
                   .access = ECT_ACCESS_TXPDO};
    if (!lay_out(&in, ECT_ASSIGN_INPUTS))
        return ECT_AL_INPUT_MAPPING;
    s->output_bytes = (uint16_t)((out.bits + 7) / 8);
    s->input_bytes = (uint16_t)((in.bits + 7) / 8);
    s->output_runs = out.count;
    s->input_runs = in.count;
    if (s->output_bytes > ect_sm_room(s->config.device, 2))
        return ECT_AL_OUTPUT_MAPPING;
    return s->input_bytes > ect_sm_room(s->config.device, 3) ? ECT_AL_INPUT_MAPPING : ECT_AL_NO_ERROR;
}

/* Between the image, at any bit, and the wire form of an entry. */
static void copy_bits(uint8_t *to, unsigned int to_bit, const uint8_t *from, unsigned int from_bit, unsigned int bits)
{
    for (unsigned int i = 0; i < bits; i++) {
        unsigned int from_mask = 1u << ((from_bit + i) % 8);
        unsigned int to_mask = 1u << ((to_bit + i) % 8);
        uint8_t *byte = &to[(to_bit + i) / 8];
        bool set = ((unsigned int)from[(from_bit + i) / 8] & from_mask) != 0;
        *byte = (uint8_t)(set ? *byte | to_mask : *byte & ~to_mask);
    }
}

/* Bytes of an entry's wire form that a run touches: numbers go whole, of longer entries what is mapped. */
static uint16_t wire_bytes(const ect_pdo_run_t *run)
{
    uint16_t whole = ect_od_bytes(run->entry);
    return whole <= WIRE ? whole : (uint16_t)((run->bits + 7) / 8);
}

static void unpack(ect_slave_t *s)
{
    const uint8_t *image = s->config.process_data;
    for (uint16_t i = 0; i < s->output_runs; i++) {
        const ect_pdo_run_t *run = &s->config.runs[i];
        uint8_t wire[WIRE];
        if (run->entry) {
            memset(wire, 0, sizeof wire); /* a number of which less is mapped is extended by zeros */
            copy_bits(wire, 0, image, run->first_bit, run->bits);
            (void)ect_od_write(&s->od, run->entry, 0, wire, wire_bytes(run));
        } else {
            memcpy(run->data, image + run->first_bit / 8, run->bits / 8u);
        }
    }
}

static void pack(ect_slave_t *s)
{
    uint8_t *image = s->config.process_data;
    memset(image, 0, s->input_bytes);
    for (uint16_t i = 0; i < s->input_runs; i++) {
        const ect_pdo_run_t *run = &s->config.runs[s->output_runs + i];
        uint8_t wire[WIRE];
        if (run->entry) {
            ect_od_read(&s->od, run->entry, 0, wire, wire_bytes(run));
            copy_bits(image, run->first_bit, wire, 0, run->bits);
        } else {
            memcpy(image + run->first_bit / 8, run->data, run->bits / 8u);
        }
    }
}

/* Takes what the master wrote. Not applied (SAFEOP), it is fetched all the same: the event goes, the buffer is free. */
void ect_pdo_outputs(ect_slave_t *s, bool apply)
{
    const ect_device_t *device = s->config.device;
    if (!ect_slave_read(s, device->sm[2].start, s->config.process_data, s->output_bytes))
        return;
    s->outputs_seen = true;
    if (!apply)
        return;
    unpack(s);
    if (device->outputs)
        device->outputs(s->config.instance, s->now_ns);
    ect_slave_wake(s); /* they may have set deadlines */
}

bool ect_pdo_inputs(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    if (s->input_bytes == 0)
        return true;
    if (device->inputs)
        device->inputs(s->config.instance, s->now_ns);
    pack(s);
    return ect_slave_write(s, device->sm[3].start, s->config.process_data, s->input_bytes);
}
