/* SPDX-License-Identifier: MIT */
/*
 * The process image. On the way to SAFEOP the assignment and the mapping are read from the dictionary and laid out as
 * runs: entries that are adjacent both in the image and in the instance become one copy. A cycle is then a few copies,
 * and one PDI access in each direction.
 */
#include <string.h>

#include "slave/internal.h"

enum { LARGEST_IMAGE_BITS = 1486 * 8, WIRE = 32 /* a mapping entry has at most 255 bits */ };

typedef struct layout {
    const ect_od_t *od;
    ect_pdo_run_t *runs; /* destination; NULL: runs are only counted */
    ect_pdo_run_t last;
    uint16_t capacity; /* elements of `runs` */
    uint16_t count;
    uint16_t access; /* ECT_ACCESS_RXPDO or _TXPDO: required of a mapped entry */
    uint32_t bits;
} layout_t;

/* Whether the bytes in memory equal those on the wire. */
static bool is_plain(const ect_entry_t *entry, const uint8_t *data)
{
    bool one_byte = entry->bit_length <= 8 || entry->data_type == ECT_TYPE_OCTET_STRING ||
                    entry->data_type == ECT_TYPE_VISIBLE_STRING;
    return data != NULL && entry->bit_length % 8 == 0 && !ect_od_is_bits(entry) &&
           (one_byte || ect_host_is_little_endian());
}

static bool extend(layout_t *l, const uint8_t *data, uint16_t bits)
{
    ect_pdo_run_t *last = &l->last;
    if (l->count == 0 || last->entry || last->first_bit + last->bits != (uint16_t)l->bits ||
        last->data + last->bits / 8 != data)
        return false;
    last->bits = (uint16_t)(last->bits + bits);
    return true;
}

static bool add_entry(layout_t *l, const ect_entry_t *entry, uint16_t bits)
{
    uint8_t *data = ect_od_data(l->od, entry);
    ECT_ASSERT(bits > 0 && bits <= entry->bit_length);
    bool plain = is_plain(entry, data) && l->bits % 8 == 0 && bits == entry->bit_length;
    if (!plain || !extend(l, data, bits)) {
        if (l->count == l->capacity)
            return false;
        l->count++;
        l->last =
            (ect_pdo_run_t){.entry = plain ? NULL : entry, .data = data, .first_bit = (uint16_t)l->bits, .bits = bits};
    }
    if (l->runs)
        l->runs[l->count - 1] = l->last;
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
        if (ect_od_lookup(l->od, index, (uint8_t)(mapping >> 8), &object, &entry) != ECT_OK ||
            (entry->access & l->access) == 0 || bits > entry->bit_length || !add_entry(l, entry, bits))
            return false;
    }
    l->bits += bits;
    return true;
}

/* Passes each element of an assignment or mapping object to `add`. */
static bool for_each(layout_t *l, uint16_t index, bool (*add)(layout_t *l, uint32_t value))
{
    const ect_od_t *od = l->od;
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

/* A SyncManager without the assignment object has no process data. */
static bool lay_out(layout_t *l, const ect_device_t *device, unsigned int sm)
{
    uint16_t assignment = (uint16_t)(ECT_OD_ASSIGNMENT + sm);
    l->access = device->sm[sm].type == ECT_SM_OUTPUTS ? ECT_ACCESS_RXPDO : ECT_ACCESS_TXPDO;
    if (!l->runs) /* counting does not check access */
        l->access = ECT_ACCESS_WIRE;
    return !ect_od_find(l->od, assignment) || for_each(l, assignment, add_pdo);
}

uint16_t ect_pdo_count_runs(const ect_device_t *device, unsigned int sm)
{
    const ect_od_t od = ect_device_od(device, NULL);
    layout_t l = {.od = &od, .capacity = UINT16_MAX};
    (void)lay_out(&l, device, sm);
    return l.count;
}

static bool configure_sm(ect_slave_t *s, unsigned int sm, uint16_t first_run)
{
    const ect_device_t *device = s->config.device;
    layout_t l = {.od = &s->od, .capacity = (uint16_t)(s->config.run_count - first_run)};
    if (!s->config.exchange_is_callers && s->config.runs) /* NULL: a slave without process data */
        l.runs = s->config.runs + first_run;
    if (!lay_out(&l, device, sm))
        return false;
    uint16_t longest = device->sm[sm].maximum != 0 ? device->sm[sm].maximum : s->config.process_size;
    ect_sm_image_t *image = &s->image[sm];
    ECT_ASSERT(l.count <= l.capacity && l.bits <= LARGEST_IMAGE_BITS);
    *image = (ect_sm_image_t){.bytes = (uint16_t)((l.bits + 7) / 8), .first_run = first_run, .runs = l.count};
    uint8_t *which = device->sm[sm].type == ECT_SM_OUTPUTS ? &s->outputs : &s->inputs;
    if (image->bytes > 0 && l.runs) /* the stack ignores data that the caller moves */
        *which = (uint8_t)(*which | 1u << sm);
    if ((device->sm[sm].control & ECT_SM_CONTROL_AL_EVENT) == 0)
        s->outputs_silent = (uint8_t)(s->outputs_silent | (s->outputs & 1u << sm));
    ECT_ASSERT(longest <= s->config.process_size);
    return image->bytes <= longest;
}

/* Lays out all process data. @return 0, or the AL status code of the direction that is impossible */
uint16_t ect_pdo_configure(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    uint16_t runs = 0;
    s->outputs = s->outputs_silent = s->inputs = 0;
    for (unsigned int sm = 0; sm < device->sm_count; sm++) {
        if (!ect_device_sm_is_process(device, sm))
            continue;
        if (!configure_sm(s, sm, runs))
            return device->sm[sm].type == ECT_SM_OUTPUTS ? ECT_AL_OUTPUT_MAPPING : ECT_AL_INPUT_MAPPING;
        runs = (uint16_t)(runs + s->image[sm].runs);
    }
    return ECT_AL_NO_ERROR;
}

/* Bytes of an entry's wire form that a run accesses: whole numbers, and the mapped part of longer entries. */
static uint16_t wire_bytes(const ect_pdo_run_t *run)
{
    uint16_t whole = ect_od_bytes(run->entry);
    ECT_ASSERT((run->bits + 7) / 8 <= WIRE);
    return whole <= WIRE ? whole : (uint16_t)((run->bits + 7) / 8);
}

static void unpack(ect_slave_t *s, const ect_sm_image_t *of)
{
    const uint8_t *image = s->config.process_data;
    const ect_pdo_run_t *run = s->config.runs + of->first_run;
    ECT_ASSERT(of->bytes <= s->config.process_size && of->first_run + of->runs <= s->config.run_count);
    for (const ect_pdo_run_t *end = run + of->runs; run < end; run++) {
        uint8_t wire[WIRE];
        if (run->entry) {
            memset(wire, 0, sizeof wire); /* a number that is mapped in part is extended by zeros */
            ect_copy_bits(wire, 0, image, run->first_bit, run->bits);
            (void)ect_od_write(&s->od, run->entry, 0, wire, wire_bytes(run));
        } else {
            memcpy(run->data, image + run->first_bit / 8, run->bits / 8u);
        }
    }
}

static void pack(ect_slave_t *s, const ect_sm_image_t *of)
{
    uint8_t *image = s->config.process_data;
    const ect_pdo_run_t *run = s->config.runs + of->first_run;
    ECT_ASSERT(of->bytes <= s->config.process_size && of->first_run + of->runs <= s->config.run_count);
    memset(image, 0, of->bytes);
    for (const ect_pdo_run_t *end = run + of->runs; run < end; run++) {
        uint8_t wire[WIRE];
        if (run->entry) {
            ect_od_read(&s->od, run->entry, 0, wire, wire_bytes(run));
            ect_copy_bits(image, run->first_bit, wire, 0, run->bits);
        } else {
            memcpy(image + run->first_bit / 8, run->data, run->bits / 8u);
        }
    }
}

/* The status of a SyncManager without an event shows whether it was written and not read since. */
unsigned int ect_pdo_written(ect_slave_t *s)
{
    unsigned int sms = 0;
    for (unsigned int sm = 0; s->outputs_silent >> sm != 0; sm++) {
        uint8_t status = 0;
        if ((s->outputs_silent & 1u << sm) == 0)
            continue;
        uint16_t address = (uint16_t)(ECT_REG_SM + ECT_SM_SIZE * sm + ECT_SM_STATUS);
        if (ect_slave_read(s, address, &status, 1) && (status & ECT_SM_STATUS_WRITTEN) != 0)
            sms |= 1u << sm;
    }
    return sms;
}

/* In SAFEOP outputs are fetched but not applied: this clears the event and frees the buffer. */
void ect_pdo_outputs(ect_slave_t *s, unsigned int sms, bool apply)
{
    const ect_device_t *device = s->config.device;
    ECT_ASSERT(sms != 0 && (sms & ~(unsigned int)s->outputs) == 0);
    for (unsigned int sm = 0; sms >> sm != 0; sm++) {
        if ((sms & 1u << sm) == 0)
            continue;
        if (!ect_slave_read(s, device->sm[sm].start, s->config.process_data, s->image[sm].bytes))
            return;
        s->outputs_seen = (uint8_t)(s->outputs_seen | 1u << sm);
        if (apply)
            unpack(s, &s->image[sm]);
    }
    if (!apply)
        return;
    if (device->outputs)
        device->outputs(s->config.instance, s->now_ns);
    ect_slave_wake(s); /* the device may have set deadlines */
}

bool ect_pdo_inputs(ect_slave_t *s)
{
    const ect_device_t *device = s->config.device;
    if (s->inputs == 0)
        return true;
    if (device->inputs)
        device->inputs(s->config.instance, s->now_ns);
    for (unsigned int sm = 0; s->inputs >> sm != 0; sm++) {
        if ((s->inputs & 1u << sm) == 0)
            continue;
        pack(s, &s->image[sm]);
        if (device->inputs_packed)
            device->inputs_packed(s->config.instance, sm, s->config.process_data, s->image[sm].bytes);
        if (!ect_slave_write(s, device->sm[sm].start, s->config.process_data, s->image[sm].bytes))
            return false;
    }
    return true;
}
