/* SPDX-License-Identifier: MIT */
#include <stddef.h>
#include <string.h>

/* A frame in memory. */
typedef struct frame {
    unsigned char *bytes;
    size_t length;
} frame_t;

static int load(const frame_t *frame, size_t at, void *to, size_t length)
{
    if (at + length > frame->length)
        return -1;
    memcpy(to, frame->bytes + at, length);
    return 0;
}

static int store(const frame_t *frame, size_t at, const void *from, size_t length)
{
    if (at + length > frame->length)
        return -1;
    memcpy(frame->bytes + at, from, length);
    return 0;
}

#define ECT_STEPS_FRAME const frame_t *
#define ECT_STEPS_LOAD  load
#define ECT_STEPS_STORE store

#include "bus/chain/bits.h"
#include "bus/chain/steady.h"
#include "bus/kernel/plan.h"
#include "bus/kernel/steps.h"
#include "esc/cyclic.h"
#include "esc/route.h"
#include "wire/assert.h"
#include "wire/registers.h"

/* A plan in the making. */
typedef struct maker {
    ect_planner_t *planner;
    ect_chain_t *chain;
    ect_chain_steady_t steady;
    ect_plan_t *plan;
    ect_plan_sample_t *sample;
    const uint8_t *frame;   /* of the sample */
    const ect_esc_t *clock; /* the reference clock of all plans; NULL: none yet */
    uint8_t command;        /* of the present datagram, */
    uint32_t logical;       /* its address, */
    uint16_t length;        /* the length of its data, */
    uint16_t at;            /* and its offset */
    uint32_t gain;          /* of its working counter */
    uint32_t image;         /* bytes in use */
} maker_t;

static bool add_step(maker_t *m, ect_plan_step_t step)
{
    if (m->plan->step_count >= ECT_PLAN_STEPS)
        return false;
    m->plan->steps[m->plan->step_count++] = step;
    return true;
}

/* @param image  place of an image of SyncManager `sm`; ECT_ESC_MAX_SM: none */
static void add_base(maker_t *m, size_t position, const ect_esc_t *esc, unsigned int sm, uint32_t image)
{
    ect_plan_sample_t *s = m->sample;
    if (s->base_count < ECT_PLAN_BASES) {
        s->bases[s->base_count] = (ect_plan_base_t){.esc = esc,
                                                    .routing = ect_esc_routing(esc),
                                                    .image = (uint16_t)image,
                                                    .position = (uint16_t)position,
                                                    .sm = (uint8_t)sm};
        if (m->planner->places && sm != ECT_ESC_MAX_SM)
            m->planner->places[position] =
                (ect_plan_place_t){.plan = (uint8_t)(s - m->planner->samples), .base = (uint8_t)s->base_count};
    }
    s->base_count++;
}

static bool copy_pieces(void *ctx, size_t position, const ect_esc_t *esc)
{
    maker_t *m = ctx;
    ect_esc_cyclic_t effect;
    if (!ect_esc_cyclic(esc, m->command, m->logical, m->length, &effect))
        return false;
    for (unsigned int i = 0; i < effect.piece_count; i++) {
        const ect_esc_piece_t *piece = &effect.pieces[i];
        ect_plan_step_t step = {.kind = ECT_PLAN_DO_COPY,
                                .at = (uint16_t)(m->at + piece->at),
                                .length = piece->length,
                                .value = (uint16_t)m->image};
        if (m->image + piece->length > ECT_PLAN_IMAGE - 2048u || !add_step(m, step))
            return false;
        memcpy(m->plan->image + m->image, piece->from, piece->length);
        add_base(m, position, esc, piece->sm, m->image);
        m->image += piece->length;
    }
    if (effect.piece_count == 0)
        add_base(m, position, esc, ECT_ESC_MAX_SM, 0);
    m->gain += effect.gain;
    return true;
}

static bool plan_logical(maker_t *m)
{
    return ect_chain_visit_mapped(m->chain, m->logical, m->length, ect_command_direction(m->command), copy_pieces, m);
}

static bool plan_status(maker_t *m, uint16_t address)
{
    m->gain = (uint32_t)m->steady.reach;
    return address == ECT_REG_AL_STATUS && m->length <= 2 && !m->steady.al_status_new &&
           add_step(m, (ect_plan_step_t){
                           .kind = ECT_PLAN_DO_OR, .at = m->at, .length = m->length, .value = m->steady.al_status});
}

/* A frame with another reference clock would change the rate of the present one. */
static bool plan_time(maker_t *m, const uint8_t *d, uint16_t address)
{
    bool takes;
    uint64_t offset_ns;
    if (address != ECT_REG_DC_SYSTEM_TIME || m->length < 4 || m->length > 8)
        return false;
    const ect_esc_t *clock = ect_chain_time_source(m->chain, d, &takes);
    if (!clock || (m->clock && clock != m->clock) || !ect_esc_even_clock(clock, &offset_ns))
        return false;
    m->clock = m->sample->clock = clock;
    add_base(m, 0, clock, ECT_ESC_MAX_SM, 0);
    m->gain = m->steady.time_takers - (takes ? 1u : 0u) + 1u;
    return add_step(m,
                    (ect_plan_step_t){.kind = ECT_PLAN_DO_TIME, .at = m->at, .length = m->length, .wide = offset_ns});
}

static bool plan_command(maker_t *m, const uint8_t *d)
{
    uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADO);
    m->command = d[ECT_DATAGRAM_COMMAND];
    m->logical = ect_load_le32(d + ECT_DATAGRAM_ADP);
    m->length = ect_datagram_length(d);
    m->gain = 0;
    switch (m->command) {
    case ECT_NOP:
        return true;
    case ECT_LRD:
    case ECT_LWR:
    case ECT_LRW:
        return plan_logical(m);
    case ECT_BRD:
        return plan_status(m, address);
    case ECT_ARMW:
    case ECT_FRMW:
        return plan_time(m, d, address);
    default:
        return false;
    }
}

static bool plan_datagram(maker_t *m, uint8_t *d)
{
    const size_t at = (size_t)(d - m->frame);
    const ect_plan_step_t irq = {
        .kind = ECT_PLAN_DO_OR, .at = (uint16_t)(at + ECT_DATAGRAM_IRQ), .length = 2, .value = m->steady.events};
    m->at = (uint16_t)(at + ECT_DATAGRAM_DATA);
    if (ect_datagram_length(d) == 0 || (irq.value != 0 && !add_step(m, irq)) || !plan_command(m, d))
        return false;
    const ect_plan_step_t counter = {
        .kind = ECT_PLAN_DO_ADD, .at = (uint16_t)(m->at + m->length), .value = (uint16_t)m->gain};
    const ect_plan_step_t address = {
        .kind = ECT_PLAN_DO_ADD, .at = (uint16_t)(at + ECT_DATAGRAM_ADP), .value = (uint16_t)m->steady.reach};
    m->plan->shortest = counter.at + (uint32_t)ECT_DATAGRAM_COUNTER;
    return add_step(m, counter) && (!ect_command_counts(m->command) || add_step(m, address));
}

static bool plan_frame(maker_t *m, ect_plan_sample_t *sample)
{
    uint8_t *first = sample->frame + ECT_PLAN_FIRST;
    m->sample = sample;
    m->frame = sample->frame;
    m->image = 0;
    sample->base_count = 0;
    sample->clock = NULL;
    m->plan->source_bits = m->steady.marks_source ? 0x02 : 0;
    memcpy(m->plan->type, sample->frame + ECT_PLAN_TYPE, sizeof m->plan->type);
    for (const uint8_t *d = first; d; d = ect_datagram_after(d)) {
        const ect_plan_step_t header = {
            .kind = ECT_PLAN_DO_HEADER, .at = (uint16_t)(d - m->frame), .wide = ect_step_header(d)};
        if (!add_step(m, header))
            return false;
    }
    for (uint8_t *d = first; d; d = ect_datagram_next(d)) {
        if (!plan_datagram(m, d))
            return false;
    }
    return true;
}

/* --- the frames ----------------------------------------------------------------------------------------------------
 */

/* @return the datagram at the same place in another frame of the same length */
static const uint8_t *in_sample(const ect_plan_sample_t *sample, const uint8_t *frame, const uint8_t *d)
{
    return sample->frame + (d - frame);
}

static bool may_have_plan(const uint8_t *d)
{
    const uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADO);
    switch (d[ECT_DATAGRAM_COMMAND]) {
    case ECT_NOP:
    case ECT_LRD:
    case ECT_LWR:
    case ECT_LRW:
        return true;
    case ECT_BRD:
        return address == ECT_REG_AL_STATUS;
    case ECT_ARMW:
    case ECT_FRMW:
        return address == ECT_REG_DC_SYSTEM_TIME;
    default:
        return false;
    }
}

/* @return the first datagram of a frame that may have a plan; NULL: it may not */
static const uint8_t *first_datagram(const uint8_t *frame, size_t length)
{
    if (length > ECT_PLAN_FRAME || ect_frame_datagrams(frame, length) != ECT_PLAN_FIRST)
        return NULL;
    for (const uint8_t *d = frame + ECT_PLAN_FIRST; d; d = ect_datagram_after(d)) {
        if (!may_have_plan(d))
            return NULL;
    }
    return frame + ECT_PLAN_FIRST;
}

static bool same_layout(const ect_plan_sample_t *sample, const uint8_t *frame, size_t length)
{
    if (sample->length != length || memcmp(sample->frame + ECT_PLAN_TYPE, frame + ECT_PLAN_TYPE, 4) != 0)
        return false;
    for (const uint8_t *d = frame + ECT_PLAN_FIRST; d; d = ect_datagram_after(d)) {
        if (ect_step_header(d) != ect_step_header(in_sample(sample, frame, d)))
            return false;
    }
    return true;
}

/* @return whether the outputs of a datagram differ from the sample's, which has the same layout */
static bool outputs_differ(const ect_plan_sample_t *sample, const uint8_t *frame)
{
    for (const uint8_t *d = frame + ECT_PLAN_FIRST; d; d = ect_datagram_after(d)) {
        const uint8_t *data = d + ECT_DATAGRAM_DATA;
        bool writes = (ect_command_direction(d[ECT_DATAGRAM_COMMAND]) & ECT_PART_WRITE) != 0;
        if (writes && memcmp(data, in_sample(sample, frame, data), ect_datagram_length(d)) != 0)
            return true;
    }
    return false;
}

/* @return the place of a key, or a place for it: an unused one, else the first permitted one. Places are never freed,
 * so a search ends at the first unused place. */
static uint32_t place_for(const ect_plan_table_t *table, uint64_t key)
{
    const uint32_t first = ect_plan_place(key);
    for (uint32_t i = 0; i < ECT_PLAN_PROBES; i++) {
        const uint32_t place = (first + i) % ECT_PLANS;
        if (table->plans[place].key == key || table->plans[place].key == 0)
            return place;
    }
    return first;
}

void ect_planner_see(ect_planner_t *planner, const uint8_t *frame, size_t length)
{
    if (!first_datagram(frame, length))
        return;
    const uint64_t key = ect_plan_key(frame);
    const uint32_t place = place_for(planner->table, key);
    ect_plan_sample_t *sample = &planner->samples[place];
    if (!same_layout(sample, frame, length)) {
        sample->step_count = planner->table->plans[place].step_count = 0;
        planner->table->plans[place].key = key;
    } else if (outputs_differ(sample, frame)) {
        planner->outputs_changed = true;
    } else {
        return; /* a plan depends on no other data */
    }
    ect_bits_add(planner->known, place);
    sample->length = (uint16_t)length;
    memcpy(sample->frame, frame, length);
}

/* --- the plans -----------------------------------------------------------------------------------------------------
 */

void ect_planner_void(ect_planner_t *planner)
{
    for (size_t word = 0; word < ect_bits_words(ECT_PLANS); word++) {
        for (uint64_t left = planner->known[word]; left != 0;)
            planner->table->plans[ect_bits_take(word, &left)].step_count = 0;
    }
}

/* @return whether the part of the ESC in the frame is unchanged, except the image */
static bool is_unchanged(const ect_plan_base_t *base)
{
    return ect_esc_routing(base->esc) == base->routing;
}

/* Copies the newest image. @return false: none yet */
static bool copy_image(const ect_plan_base_t *base, ect_plan_t *plan)
{
    if (base->sm == ECT_ESC_MAX_SM)
        return true;
    const uint8_t *from = ect_esc_newest_image(base->esc, base->sm);
    if (from)
        memcpy(plan->image + base->image, from, base->esc->sm[base->sm].length);
    return from != NULL;
}

/* Reads the clock again, because its rate or offset may have changed. */
static bool renew_time(maker_t *m, const ect_plan_sample_t *sample)
{
    uint64_t offset_ns;
    if (!sample->clock)
        return true;
    if ((m->clock && m->clock != sample->clock) || !ect_esc_even_clock(sample->clock, &offset_ns))
        return false;
    m->clock = sample->clock;
    for (unsigned int i = 0; i < sample->step_count; i++) {
        if (m->plan->steps[i].kind == ECT_PLAN_DO_TIME)
            m->plan->steps[i].wide = offset_ns;
    }
    return true;
}

/* @return false: the plan must be made again */
static bool renew(maker_t *m, ect_plan_sample_t *sample)
{
    if (sample->step_count == 0 || sample->base_count > ECT_PLAN_BASES)
        return false;
    for (unsigned int i = 0; i < sample->base_count; i++) {
        ect_plan_base_t *base = &sample->bases[i];
        const bool copied = base->copied;
        base->copied = false;
        if (!is_unchanged(base) || (!copied && !copy_image(base, m->plan)))
            return false;
    }
    if (!renew_time(m, sample))
        return false;
    m->plan->step_count = sample->step_count;
    return true;
}

static bool make(maker_t *m, ect_plan_sample_t *sample)
{
    const ect_esc_t *clock = m->clock;
    const bool done = plan_frame(m, sample);
    if (!done) {
        m->plan->step_count = 0;
        m->clock = clock;
    }
    sample->step_count = m->plan->step_count;
    return done;
}

/* @param same  the state of the line has not changed. @return whether there is a plan */
static bool update(maker_t *m, size_t place, bool same)
{
    ect_planner_t *planner = m->planner;
    ect_plan_sample_t *sample = &planner->samples[place];
    m->plan = &planner->table->plans[place];
    if (!same)
        sample->step_count = 0;
    if (renew(m, sample)) {
        planner->renewed++;
        return true;
    }
    const bool done = make(m, sample);
    planner->made += done;
    return done;
}

static bool same_steady(const ect_chain_steady_t *a, const ect_chain_steady_t *b)
{
    return a->version == b->version && a->reach == b->reach && a->time_takers == b->time_takers &&
           a->events == b->events && a->al_status == b->al_status && a->al_status_new == b->al_status_new &&
           a->marks_source == b->marks_source;
}

unsigned int ect_planner_make(ect_planner_t *planner, ect_chain_t *chain)
{
    maker_t m = {.planner = planner, .chain = chain};
    ect_planner_void(planner);
    if (!ect_chain_steady(chain, &m.steady))
        return 0;
    const bool same = same_steady(&m.steady, &planner->steady);
    planner->steady = m.steady;
    unsigned int plans = 0;
    for (size_t word = 0; word < ect_bits_words(ECT_PLANS); word++) {
        for (uint64_t left = planner->known[word]; left != 0;)
            plans += update(&m, ect_bits_take(word, &left), same);
    }
    return plans;
}

void ect_planner_ran(ect_planner_t *planner, size_t position)
{
    const ect_plan_place_t at = planner->places[position];
    ect_plan_sample_t *sample = &planner->samples[at.plan];
    ect_plan_base_t *base = &sample->bases[at.base];
    if (at.base < sample->base_count && base->position == position && sample->step_count != 0)
        base->copied = is_unchanged(base) && copy_image(base, &planner->table->plans[at.plan]);
}

const ect_plan_t *ect_plan_find(const ect_plan_table_t *table, const uint8_t *head)
{
    const uint64_t key = ect_plan_key(head);
    const ect_plan_t *plan = &table->plans[place_for(table, key)];
    return plan->key == key ? plan : NULL;
}

bool ect_plan_reply(const ect_plan_table_t *table, uint8_t *frame, size_t length, uint64_t now_ns)
{
    const frame_t bytes = {.bytes = frame, .length = length};
    if (length < ECT_PLAN_HEAD || length > ECT_PLAN_FRAME)
        return false;
    const ect_plan_t *plan = ect_plan_find(table, frame);
    uint8_t head[ECT_PLAN_HEAD];
    memcpy(head, frame, sizeof head);
    if (!plan || !ect_steps_match(plan, &bytes, (uint32_t)length, head))
        return false;
    bool done = ect_steps_run(plan, &bytes, head, now_ns);
    ECT_ASSERT(done);
    return done;
}
