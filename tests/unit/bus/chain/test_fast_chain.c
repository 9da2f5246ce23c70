/* SPDX-License-Identifier: MIT */
/*
 * The fast path through a chain (fast.h) against the reference: each frame goes to one chain over the fast path, and to
 * the controllers of a second, equal chain one after the other, by ect_esc_pass, before it ends in all of them.
 * Replies, memories, states, lamps and results of the poll must be equal, under random actions of master, users and
 * time.
 *
 * Plans (bus/kernel/plan.h) are the third path: as long as only frames occur, they reply to frames of their layouts,
 * and these frames pass both chains later, which must give the same replies.
 *
 * test_fast_chain [ROUNDS [SEED [TEST]]]: ROUNDS rounds of FRAMES frames, each with a chain and a seed of its own; of
 * the tests those that TEST, a pattern, names.
 */
#include "bus/chain/chain.h"

#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/deadlines.h"
#include "bus/chain/fast.h"
#include "bus/chain/names.h"
#include "bus/chain/settings.h"
#include "bus/kernel/plan.h"
#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "esc/route.h"
#include "seams/random.h"
#include "slave/indicator.h"
#include "support/every.h"
#include "support/sensor.h"
#include "support/terminal.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { FRAMES = 2000, MOST = 70, ROOM = 1600, BETWEEN_LOOKS = 97, BETWEEN_DAMAGES = 7 };

enum { HELD = 16, STEPS = ECT_PLAN_DO_TIME + 1 };

/* Frames with a reply of a plan that have not passed the chains yet. */
typedef struct held {
    uint64_t now_ns;
    size_t length;
    unsigned int step_count; /* of the plan */
    uint8_t frame[ROOM], reply[ROOM];
} held_t;

static unsigned int rounds = 12;
static uint32_t first_seed = 1;

typedef struct rig {
    uint32_t random, seed;
    unsigned int frame_number, taken;
    size_t count;
    ect_chain_t *fast, *slow; /* the second one's frames take the path of the reference */
    uint8_t state[MOST];      /* the next address set by the master */
    bool link_in, link_out;
    bool damages; /* some frames have a bad check sum */
    bool plans;   /* plans reply while nothing else happens */
    bool asleep;
    size_t held_count;
    uint64_t planned[STEPS + 1]; /* executed steps of plans, by kind; then plans renewed */
    uint32_t layout;             /* of the frames of each cycle */
    ect_planner_t planner;
    uint64_t now_ns;
    uint8_t frame[ROOM];
    size_t length, last; /* of the frame; where its last datagram begins */
} rig_t;

static uint32_t below(rig_t *r, uint32_t limit)
{
    return (uint32_t)(((uint64_t)ect_random_next(&r->random) * limit) >> 32);
}

static bool one_in(rig_t *r, uint32_t n)
{
    return below(r, n) == 0;
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

static void begin_frame(rig_t *r)
{
    static const uint8_t header[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01};
    memcpy(r->frame, header, sizeof header);
    r->length = sizeof header;
    if (one_in(r, 32)) {
        memcpy(r->frame + r->length, "\x81\x00\x20\x01", 4);
        r->length += 4;
    }
    memcpy(r->frame + r->length, "\x88\xA4\x00\x10", 4);
    r->length += 4;
    r->last = 0;
}

static void add(rig_t *r, uint8_t command, uint16_t adp, uint16_t ado, const void *data, uint16_t length)
{
    if (r->length + length + 12u > 1514)
        return;
    if (r->last != 0)
        r->frame[r->last + 7] |= 0x80;
    uint8_t *d = r->frame + r->length;
    memset(d, 0, 12u + length);
    d[0] = command;
    d[1] = (uint8_t)below(r, 256);
    ect_store_le16(d + 2, adp);
    ect_store_le16(d + 4, ado);
    ect_store_le16(d + 6, length);
    if (data)
        memcpy(d + 10, data, length);
    r->last = r->length;
    r->length += 12u + length;
}

static uint16_t position(rig_t *r)
{
    return (uint16_t)(0 - below(r, (uint32_t)r->count + (one_in(r, 20) ? 2 : 0)));
}

/* Mostly the one that the master gives, which are not all different. */
static uint16_t station_of(const rig_t *r, size_t i)
{
    return (uint16_t)(0x1001 + (i == r->count / 2 && r->seed % 4 == 0 ? 0 : i));
}

static uint16_t station(rig_t *r)
{
    return one_in(r, 30) ? (uint16_t)below(r, 8) : station_of(r, below(r, (uint32_t)r->count));
}

static uint16_t some_address(rig_t *r)
{
    static const uint16_t registers[] = {
        0x0000, 0x0008, 0x0010, 0x0012, 0x0100, 0x0103, 0x0108, 0x0110, 0x0120, 0x0130, 0x0134, 0x0140, 0x0200,
        0x0204, 0x0210, 0x0220, 0x0300, 0x0310, 0x0400, 0x0420, 0x0440, 0x0442, 0x0500, 0x0502, 0x0504, 0x0508,
        0x0600, 0x0610, 0x0800, 0x0806, 0x080D, 0x0810, 0x0816, 0x0818, 0x0900, 0x0910, 0x0918, 0x0920, 0x092C,
        0x0930, 0x0980, 0x0981, 0x0990, 0x09A0, 0x0F00, 0x0F80, 0x0FFF, 0x1000, 0x1100, 0x1C00};
    uint16_t address = registers[below(r, sizeof registers / sizeof registers[0])];
    return one_in(r, 3) ? (uint16_t)(address + below(r, 40)) : one_in(r, 20) ? (uint16_t)below(r, 65536) : address;
}

static void add_anything(rig_t *r)
{
    uint8_t data[300];
    uint8_t command = (uint8_t)below(r, one_in(r, 40) ? 256 : 15);
    uint16_t length = (uint16_t)below(r, one_in(r, 4) ? 280 : 9);
    for (unsigned int i = 0; i < length; i++)
        data[i] = one_in(r, 2) ? 0 : (uint8_t)below(r, 256);
    if (command >= LRD && command <= LRW)
        add(r, command, (uint16_t)below(r, 1200), one_in(r, 30) ? 0xFFFF : 0, data, length);
    else if (command == FPRD || command == FPWR || command == FPRW || command == FRMW)
        add(r, command, station(r), some_address(r), data, length);
    else
        add(r, command, position(r), some_address(r), data, length);
    if (one_in(r, 8)) {
        uint8_t *d = r->frame + r->last;
        ect_store_le16(d + 8, (uint16_t)below(r, 65536));
        ect_store_le16(d + 10 + (ect_load_le16(d + 6) & 0x7FF), (uint16_t)below(r, 65536));
    }
}

/* --- actions of a correct master ------------------------------------------------------------------------ */

static const ect_device_t *device_of(const rig_t *r, size_t i)
{
    return ect_chain_slave(r->fast, i)->config.device;
}

static void set_sms(rig_t *r, size_t i, bool process)
{
    const ect_device_t *device = device_of(r, i);
    for (unsigned int n = 0; n < device->sm_count; n++) {
        uint8_t sm[8] = {0};
        uint16_t bytes = ect_device_sm_bytes(device, n);
        if (ect_device_sm_is_process(device, n) != process)
            continue;
        ect_store_le16(sm, device->sm[n].start);
        ect_store_le16(sm + 2, bytes);
        sm[4] = device->sm[n].control | (one_in(r, 10) ? 0x10 : 0);
        sm[6] = bytes > 0;
        add(r, FPWR, station_of(r, i), (uint16_t)(0x0800 + 8 * n), sm, sizeof sm);
    }
}

/* Process data of all are adjacent, and sometimes overlap. With plans, inputs of a slave sometimes become outputs of
 * the next one. */
static void set_fmmus(rig_t *r, size_t i)
{
    const ect_device_t *device = device_of(r, i);
    uint16_t end = 0;
    uint8_t n = 0;
    const bool shared = r->plans && one_in(r, 4); /* outputs and inputs have the same logical addresses */
    for (unsigned int sm = 0; sm < device->sm_count; sm++) {
        uint8_t fmmu[16] = {0};
        uint16_t bytes = ect_device_sm_bytes(device, sm);
        if (!ect_device_sm_is_process(device, sm) || bytes == 0)
            continue;
        bool bits = one_in(r, r->plans ? 60 : 6);
        uint32_t logical = r->plans && !one_in(r, 20) ? (uint32_t)(i * 300 + end) : (uint32_t)(i * 40 + below(r, 40));
        if (r->plans && i > 0 && device->sm[sm].type == ECT_SM_OUTPUTS && one_in(r, 6))
            logical = (uint32_t)((i - 1) * 300 + below(r, 100));
        end = (uint16_t)(end + (shared ? 0 : bytes));
        ect_store_le32(fmmu, logical);
        ect_store_le16(fmmu + 4, bytes);
        fmmu[6] = bits ? (uint8_t)below(r, 8) : 0;
        fmmu[7] = bits ? (uint8_t)below(r, 8) : 7;
        ect_store_le16(fmmu + 8, one_in(r, 20) ? some_address(r) : device->sm[sm].start);
        fmmu[11] = device->sm[sm].type == ECT_SM_OUTPUTS ? 2 : 1;
        fmmu[12] = 1;
        add(r, FPWR, station_of(r, i), (uint16_t)(0x0600 + 16 * n++), fmmu, sizeof fmmu);
    }
}

static void set_station(rig_t *r, size_t i)
{
    uint8_t bytes[2];
    ect_store_le16(bytes, station_of(r, i));
    add(r, APWR, (uint16_t)(0 - i), 0x0010, bytes, 2);
}

static void request_state(rig_t *r, size_t i)
{
    static const uint8_t next[] = {[1] = 2, [2] = 4, [4] = 8, [8] = 8};
    uint8_t bytes[2] = {r->state[i] | 0x10, 0};
    if (r->state[i] == 2)
        set_sms(r, i, false);
    if (r->state[i] == 4)
        set_sms(r, i, true);
    add(r, FPWR, station_of(r, i), 0x0120, bytes, 2);
    r->state[i] = one_in(r, 12) ? 1 : next[r->state[i]];
}

/* Closes or opens port 1 of a slave through an FMMU, perhaps in the frame that sets the FMMU up. The first datagram
 * shows which twins process the frame. */
static void close_by_fmmu(rig_t *r, size_t i)
{
    enum { LOGICAL = 0x4000 };
    const uint8_t fmmu[16] = {0x00, 0x40, 0, 0, 1, 0, 0, 7, 0x01, 0x01, 0, 2, 1};
    const uint8_t control = one_in(r, 2) ? 0x0C : 0x00;
    const uint8_t mark = (uint8_t)below(r, 256);
    add(r, BWR, 0, 0x0F80, &mark, 1);
    if (one_in(r, 2))
        add(r, FPWR, station_of(r, i), 0x0610, fmmu, sizeof fmmu);
    if (one_in(r, 2))
        add(r, one_in(r, 2) ? LWR : LRW, LOGICAL, 0, &control, 1);
}

static void add_sense(rig_t *r)
{
    size_t i = below(r, (uint32_t)r->count);
    uint8_t data[200] = {0};
    const uint8_t mask[] = {(uint8_t)below(r, 256), 0};
    for (unsigned int k = 0; k < 8; k++)
        data[k] = (uint8_t)below(r, 256);
    switch (below(r, 13)) {
    case 12:
        close_by_fmmu(r, i);
        return;
    case 0:
        set_station(r, i);
        return;
    case 1:
        set_fmmus(r, i);
        return;
    case 2:
    case 3:
        request_state(r, i);
        return;
    case 4:
        add(r, BRD, 0, 0x0130, NULL, (uint16_t)(1 + below(r, 3)));
        return;
    case 5:
        add(r, one_in(r, 2) ? FRMW : ARMW, one_in(r, 2) ? station(r) : position(r), 0x0910, data, 8);
        return;
    case 6:
        add(r, FPRD, station(r), 0x0130, NULL, 6);
        return;
    case 7:
        add(r, FPWR, station_of(r, i), 0x0200, mask, 2);
        return;
    case 8:
        add(r, FPWR, station_of(r, i), 0x0420, "\x20\x00", 2);
        return;
    default:
        add(r,
            one_in(r, 3)   ? LRD
            : one_in(r, 3) ? LWR
                           : LRW,
            (uint16_t)below(r, (uint32_t)(r->count * 40)), 0, data, (uint16_t)(1 + below(r, sizeof data)));
    }
}

static void spoil(rig_t *r)
{
    switch (below(r, 4)) {
    case 0:
        r->length = below(r, (uint32_t)r->length + 1);
        return;
    case 1:
        r->frame[below(r, (uint32_t)r->length)] = (uint8_t)below(r, 256);
        return;
    case 2:
        memmove(r->frame + 14 + 28, r->frame + 14, r->length - 14);
        memset(r->frame + 14, 0, 28);
        memcpy(r->frame + 12, "\x08\x00\x45", 3);
        r->frame[14 + 9] = 0x11;
        ect_store_be16(r->frame + 14 + 22, 0x88A4);
        r->length += 28;
        return;
    default:
        r->frame[r->last + 7] ^= (uint8_t)(1u << below(r, 8));
    }
}

static void build(rig_t *r)
{
    begin_frame(r);
    unsigned int count = one_in(r, 3) ? 1 + below(r, 6) : 1;
    bool sensible = !one_in(r, 4);
    while (count-- > 0) {
        if (sensible)
            add_sense(r);
        else
            add_anything(r);
    }
    if (one_in(r, 64))
        spoil(r);
}

/* --- both chains -------------------------------------------------------------------------------------------------- */

/* Back through the previous ones: a loop that was forced open without a wire loses the frame. */
static ect_end_t back_from(rig_t *r, size_t i)
{
    while (i-- > 0) {
        if (ect_esc_next_port(ect_chain_esc(r->slow, i), 1) != 0)
            return ECT_END_NONE;
    }
    return ECT_END_IN;
}

/* One controller after the other, as far as the line goes. */
static ect_end_t pass_each(rig_t *r, uint8_t *frame)
{
    if (!r->link_in)
        return ECT_END_NONE;
    for (size_t i = 0; i < r->count; i++) {
        ect_esc_t *esc = ect_chain_esc(r->slow, i);
        if (ect_esc_pass(esc, frame, r->length, r->now_ns) != ECT_FRAME_FORWARD)
            return ECT_END_NONE;
        unsigned int next = ect_esc_next_port(esc, 0);
        if (next == 0)
            return back_from(r, i);
        if (next != 1 || !ect_esc_port_open(esc, 1))
            return ECT_END_NONE;
    }
    return ECT_END_OUT;
}

static ect_end_t reference(rig_t *r, uint8_t *frame)
{
    ect_end_t end = pass_each(r, frame);
    for (size_t i = 0; i < r->count; i++)
        ect_esc_end_of_frame(ect_chain_esc(r->slow, i));
    return end;
}

static void differ(const rig_t *r, const char *what, size_t where, unsigned int fast, unsigned int slow)
{
    fail_msg("%s %zu: the fast way 0x%X, the reference 0x%X; frame %u of: test_fast_chain 1 %u", what, where, fast,
             slow, r->frame_number, r->seed);
}

/* A frame with a bad check sum takes the same path and is counted at each port, but never leaves. */
static void damage_each(rig_t *r)
{
    size_t i = 0;
    unsigned int next = 1;
    for (; r->link_in && i < r->count && next == 1; i++) {
        ect_esc_t *esc = ect_chain_esc(r->slow, i);
        ect_esc_damaged(esc, 0, i > 0);
        next = ect_esc_next_port(esc, 0);
        if (next != 0 && !ect_esc_port_open(esc, 1))
            return;
    }
    for (i -= next == 0; next == 0 && i-- > 0;) {
        ect_esc_damaged(ect_chain_esc(r->slow, i), 1, true);
        next = ect_esc_next_port(ect_chain_esc(r->slow, i), 1);
    }
}

static bool damage(void *ctx, ect_crossing_t *crossing)
{
    (void)ctx;
    crossing->damaged = true;
    return true;
}

static void send_damaged(rig_t *r)
{
    damage_each(r);
    for (size_t i = 0; i < r->count; i++)
        ect_esc_end_of_frame(ect_chain_esc(r->slow, i));
    ect_chain_guard(r->fast, damage, NULL);
    ect_end_t out = ect_chain_pass(r->fast, ECT_END_IN, r->frame, r->length, r->now_ns);
    if (out != ECT_END_NONE)
        differ(r, "end of a damaged frame", 0, out, ECT_END_NONE);
}

static void send(rig_t *r)
{
    uint8_t reply[ROOM];
    memcpy(reply, r->frame, r->length);
    ect_end_t want = reference(r, reply);
    ect_end_t out = ect_chain_pass(r->fast, ECT_END_IN, r->frame, r->length, r->now_ns);
    if (out != want)
        differ(r, "end", 0, out, want);
    for (size_t i = 0; out != ECT_END_NONE && i < r->length; i++) {
        if (reply[i] != r->frame[i])
            differ(r, "reply's byte", i, r->frame[i], reply[i]);
    }
}

static void same_signal(const rig_t *r, size_t i, const char *name)
{
    char fast[ECT_SIGNAL_TEXT_ROOM];
    char slow[ECT_SIGNAL_TEXT_ROOM];
    ect_signal_ref_t ref;
    assert_true(ect_chain_signal(r->fast, i, name, &ref));
    ect_signal_read(&ref, fast);
    assert_true(ect_chain_signal(r->slow, i, name, &ref));
    ect_signal_read(&ref, slow);
    if (strcmp(fast, slow) != 0)
        fail_msg("%s of slave %zu: the fast way '%s', the reference '%s'; frame %u of: test_fast_chain 1 %u", name, i,
                 fast, slow, r->frame_number, r->seed);
}

/* Controllers without an access for a long time are compared too: they must apply the recorded times first. */
static void compare(const rig_t *r)
{
    for (size_t i = 0; i < r->count; i++) {
        ect_esc_t *fast = ect_chain_esc(r->fast, i);
        ect_esc_t *slow = ect_chain_esc(r->slow, i);
        (void)ect_esc_tick(fast, r->now_ns);
        (void)ect_esc_tick(slow, r->now_ns);
        for (unsigned int n = 0; n < 2; n++) {
            if (ect_esc_sync_pin(fast, n) != ect_esc_sync_pin(slow, n))
                differ(r, "SYNC pin of slave", i << 16 | n, !ect_esc_sync_pin(slow, n), ect_esc_sync_pin(slow, n));
        }
        for (uint32_t at = 0; at < fast->memory_size; at++) {
            if (fast->memory[at] != slow->memory[at])
                differ(r, "address of slave", i << 16 | at, fast->memory[at], slow->memory[at]);
        }
        if (memcmp(fast->config.sii, slow->config.sii, fast->config.sii_size) != 0)
            differ(r, "EEPROM of slave", i, 0, 0);
        same_signal(r, i, "ecat.state");
        same_signal(r, i, "ecat.code");
    }
}

/* --- plans -------------------------------------------------------------------------------------------------------- */

static held_t held[HELD];
static ect_plan_table_t table;

/* The frame that a plan has replied to passes the first chain without the images that the plan has copied. */
static void pass_replied(rig_t *r, const held_t *h)
{
    uint8_t reply[ROOM], image[ROOM] = {0};
    const ect_plan_t *plan = ect_plan_find(&table, h->frame);
    for (unsigned int k = 0; k < h->step_count; k++) {
        if (plan->steps[k].kind == ECT_PLAN_DO_COPY)
            memset(image + plan->steps[k].at, 1, plan->steps[k].length);
    }
    memcpy(reply, h->frame, h->length);
    if (reference(r, reply) != ECT_END_IN)
        differ(r, "end", 0, ECT_END_IN, ECT_END_NONE);
    ect_chain_pass_replied(r->fast, r->frame, r->length, r->now_ns);
    for (size_t i = 0; i < h->length; i++) {
        if (reply[i] != h->reply[i])
            differ(r, "byte of a plan's reply (the first value is the chain's)", i, reply[i], h->reply[i]);
        if (image[i] == 0 && reply[i] != r->frame[i])
            differ(r, "byte of a frame that has its reply", i, r->frame[i], reply[i]);
    }
}

/* Before any other event the chains get the frames that plans have replied to. */
static void wake(rig_t *r)
{
    uint8_t frame[ROOM];
    const size_t length = r->length;
    const uint64_t now_ns = r->now_ns;
    r->asleep = false;
    if (!r->plans)
        return;
    ect_planner_void(&r->planner);
    memcpy(frame, r->frame, length);
    for (size_t k = 0; k < r->held_count; k++) {
        const held_t *h = &held[k];
        memcpy(r->frame, h->frame, h->length);
        r->length = h->length;
        r->now_ns = h->now_ns;
        pass_replied(r, h);
    }
    r->held_count = 0;
    memcpy(r->frame, frame, length);
    r->length = length;
    r->now_ns = now_ns;
}

/* A frame as a master sends it in each cycle: all process data, AL status, the system time. The layout lasts a while.
 */
static void build_cyclic(rig_t *r)
{
    static const uint8_t commands[] = {LRW, LRW, LRW, LRW, LRD, LRD, LWR, LWR};
    uint8_t data[1200];
    for (unsigned int i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)(r->random >> (i % 24));
    if (one_in(r, 16))
        r->layout = below(r, 256);
    begin_frame(r);
    if (r->frame[12] == 0x81)
        return;
    add(r, commands[r->layout % 8], 0, 0, data, (uint16_t)(r->count * 300));
    if ((r->layout & 8) != 0)
        add(r, BRD, 0, 0x0130, NULL, 1 + (r->layout >> 5) % 2);
    if ((r->layout & 0x50) == 0x10)
        add(r, FRMW, station_of(r, (r->layout & 0x80) != 0 ? r->count - 1 : 0), 0x0910, data, 8);
    if ((r->layout & 0xC0) == 0xC0)
        add(r, NOP, (uint16_t)(r->layout % 9), 0, data, 4);
    if (one_in(r, 4))
        ect_store_le16(r->frame + r->length - 2, (uint16_t)below(r, 65536));
}

/* @return whether a plan has replied to the frame */
static bool reply_asleep(rig_t *r)
{
    held_t *h = &held[r->held_count];
    if (!r->asleep || r->held_count == HELD || r->length > sizeof h->reply)
        return false;
    memcpy(h->frame, r->frame, r->length);
    memcpy(h->reply, r->frame, r->length);
    h->length = r->length;
    h->now_ns = r->now_ns;
    if (!ect_plan_reply(&table, h->reply, h->length, h->now_ns))
        return false;
    const ect_plan_t *plan = ect_plan_find(&table, h->frame);
    h->step_count = plan->step_count;
    for (unsigned int i = 0; i < plan->step_count; i++)
        r->planned[plan->steps[i].kind]++;
    r->held_count++;
    return true;
}

/* Plans that are renewed equal plans that are made. */
static void same_as_new_plans(rig_t *r)
{
    static ect_plan_table_t new_table;
    static ect_planner_t new;
    new.table = &new_table;
    memcpy(new.known, r->planner.known, sizeof new.known);
    for (unsigned int i = 0; i < ECT_PLANS; i++) {
        const ect_plan_sample_t *sample = &r->planner.samples[i];
        new.samples[i].length = sample->length;
        new.samples[i].step_count = new_table.plans[i].step_count = 0;
        memcpy(new.samples[i].frame, sample->frame, sample->length);
    }
    (void)ect_planner_make(&new, r->fast);
    for (unsigned int i = 0; i < ECT_PLANS; i++) {
        const ect_plan_t *a = &table.plans[i], *b = &new_table.plans[i];
        if (a->step_count != b->step_count)
            differ(r, "step count of a plan (the first value is that of a new plan)", i, b->step_count, a->step_count);
        for (unsigned int k = 0; k < a->step_count; k++) {
            const ect_plan_step_t *s = &a->steps[k];
            if (memcmp(s, &b->steps[k], sizeof *s) != 0)
                differ(r, "step of a plan", i, b->steps[k].kind, s->kind);
            if (s->kind == ECT_PLAN_DO_COPY && memcmp(a->image + s->value, b->image + s->value, s->length) != 0)
                differ(r, "image of a plan", i, b->image[s->value], a->image[s->value]);
        }
    }
}

static void sleep_on_plans(rig_t *r)
{
    r->asleep = ect_planner_make(&r->planner, r->fast) > 0;
    if (one_in(r, 4))
        same_as_new_plans(r);
}

/* The frame takes the same path as in the kernel: to a plan, else to the chains after all frames with a reply of a
 * plan. */
static void send_or_hold(rig_t *r)
{
    if (r->plans && reply_asleep(r))
        return;
    wake(r);
    if (r->plans)
        ect_planner_see(&r->planner, r->frame, r->length);
    send(r);
}

/* --- rounds ------------------------------------------------------------------------------------------------------- */

static void poll(rig_t *r)
{
    (void)ect_chain_poll(r->fast, r->now_ns);
    (void)ect_chain_poll(r->slow, r->now_ns);
    if (!one_in(r, 50))
        return;
    size_t i = below(r, (uint32_t)r->count);
    same_signal(r, i, "ecat.run");
    same_signal(r, i, "ecat.err");
}

static void set_both(rig_t *r, size_t i, const char *name, const char *value)
{
    char message[ECT_SIGNAL_MESSAGE];
    const ect_setting_t setting = {.name = name, .value = value};
    assert_true(ect_settings_apply(r->fast, i, &setting, 1, r->now_ns, message));
    assert_true(ect_settings_apply(r->slow, i, &setting, 1, r->now_ns, message));
}

/* Cables and power. A pulled plug is soon plugged in again. A slave whose port 0 is dead circulates frames, for which
 * the reference here is too simple: wires are cut at their beginning, and slaves behind them are not compared. */
static void disturb(rig_t *r)
{
    size_t i = below(r, (uint32_t)r->count);
    const char *enabled = one_in(r, 2) ? "0" : "1";
    switch (below(r, 5)) {
    case 0:
        set_both(r, i, "ecat.plug_out", "0");
        break;
    case 3:
        if (i > 0 && ect_chain_signal(r->fast, i, "bu.enabled", &(ect_signal_ref_t){0}))
            set_both(r, i, "bu.enabled", enabled);
        break;
    case 1:
        r->link_out = !r->link_out;
        ect_chain_set_link(r->fast, ECT_END_OUT, r->link_out);
        ect_chain_set_link(r->slow, ECT_END_OUT, r->link_out);
        break;
    case 2:
        if (one_in(r, 8)) {
            ect_chain_power_cycle(r->fast, r->now_ns);
            ect_chain_power_cycle(r->slow, r->now_ns);
        }
        break;
    default:
        for (i = 0; i < r->count; i++)
            set_both(r, i, "ecat.plug_out", "1");
    }
}

/* Plans cover neither a clock with a rate of its own nor a watchdog of the PDI, which supervises a stopped
 * microcontroller. Half of the time neither occurs. */
static void disturb_plans(rig_t *r)
{
    const size_t i = below(r, (uint32_t)r->count);
    const bool plain = one_in(r, 2);
    const ect_fault_t fault = {.kind = plain ? ECT_FAULT_RESUME : ECT_FAULT_HANG, .slave = (uint16_t)(i + 1)};
    if (one_in(r, 2)) {
        set_both(r, i, "ecat.drift", plain ? "0" : "90000");
        return;
    }
    assert_null(ect_chain_fault(r->fast, &fault, r->now_ns));
    assert_null(ect_chain_fault(r->slow, &fault, r->now_ns));
}

static void pass_time(rig_t *r)
{
    static const uint32_t steps[] = {0, 1, 1000, 20000, 500000, 1000000, 1000000, 5000000};
    r->now_ns += one_in(r, 100) ? 200 * MS : steps[below(r, sizeof steps / sizeof steps[0])];
}

static void slave_ran(void *planner, size_t position, uint64_t now_ns)
{
    (void)now_ns;
    ect_planner_ran(planner, position);
}

static void open_rig(rig_t *r, uint32_t seed, bool plans)
{
    static ect_twin_config_t twins[MOST];
    static ect_plan_place_t places[MOST];
    const ect_device_t *const kinds[] = {&ect_eclink_map7, &ect_fzm1, &ect_eclink_map1,
                                         &testdev,         &terminal, &ect_eclink_multiarm};
    memset(r, 0, sizeof *r);
    r->seed = seed;
    r->random = plans ? seed * 0x9E3779B1u : seed; /* the first numbers of small seeds are all small */
    r->plans = plans;
    memset(&table, 0, sizeof table);
    r->planner.table = &table;
    ect_planner_void(&r->planner);
    r->count = plans ? 1 + below(r, 4) : one_in(r, 6) ? 66 + below(r, 4) : 2 + below(r, 8);
    r->now_ns = 1000 * MS;
    r->link_in = true;
    for (size_t i = 0; i < r->count; i++) {
        const ect_device_t *device = kinds[below(r, sizeof kinds / sizeof kinds[0])];
        twins[i] = ect_twin_default(device, plant_of(device));
        twins[i].keep_source_mac = one_in(r, 2);
        twins[i].alias = (uint16_t)below(r, 8);
        r->state[i] = 1;
    }
    r->fast = ect_chain_new(twins, r->count, r->now_ns);
    r->slow = ect_chain_new(twins, r->count, r->now_ns);
    assert_non_null(r->fast);
    assert_non_null(r->slow);
    memset(places, 0, sizeof places);
    r->planner.places = places;
    if (plans)
        ect_chain_observe(r->fast, ECT_CHAIN_PLANS, slave_ran, &r->planner);
}

/* A frame of any kind; with plans mostly a frame of each cycle. */
static void next_frame(rig_t *r)
{
    pass_time(r);
    if (r->plans && !one_in(r, 8))
        build_cyclic(r);
    else
        build(r);
    if (r->damages && r->frame_number % BETWEEN_DAMAGES == 0) {
        wake(r);
        send_damaged(r);
    } else {
        send_or_hold(r);
    }
}

/* The other events: polls, cables, power. */
static void act(rig_t *r)
{
    if (r->asleep && !one_in(r, 4))
        return;
    wake(r);
    if (!one_in(r, 4))
        poll(r);
    if (one_in(r, 150))
        disturb(r);
    if (r->plans && one_in(r, 100))
        disturb_plans(r);
    if (r->frame_number % BETWEEN_LOOKS == 0)
        compare(r);
    if (r->plans)
        sleep_on_plans(r);
}

/* @param[in,out] planned  counts steps of plans by kind; NULL: without plans */
static void run_round(uint32_t seed, bool damages, uint64_t *planned)
{
    static rig_t r;
    open_rig(&r, seed, planned != NULL);
    r.damages = damages;
    for (size_t i = 0; i < r.count; i++) {
        begin_frame(&r);
        set_station(&r, i);
        send(&r);
    }
    while (r.frame_number++ < FRAMES) {
        next_frame(&r);
        act(&r);
    }
    wake(&r);
    compare(&r);
    ect_chain_free(r.fast);
    ect_chain_free(r.slow);
    r.planned[STEPS] = r.planner.renewed;
    for (unsigned int kind = 0; planned && kind <= STEPS; kind++)
        planned[kind] += r.planned[kind];
}

static void same_as_the_reference(void **state)
{
    (void)state;
    for (unsigned int round = 0; round < rounds; round++)
        run_round(first_seed + round, false, NULL);
}

static void with_bad_check_sums(void **state)
{
    (void)state;
    for (unsigned int round = 0; round < rounds; round++)
        run_round(first_seed + round, true, NULL);
}

/* Steps of each kind must have been executed, otherwise the test proves nothing. */
static void plans_reply_alike(void **state)
{
    uint64_t planned[STEPS + 1] = {0};
    (void)state;
    for (unsigned int round = 0; round < rounds; round++)
        run_round(first_seed + round, round % 4 == 3, planned);
    print_message("steps: %" PRIu64 " headers, %" PRIu64 " bits, %" PRIu64 " counters, %" PRIu64 " images, %" PRIu64
                  " times; %" PRIu64 " plans renewed\n",
                  planned[0], planned[1], planned[2], planned[3], planned[4], planned[STEPS]);
    for (unsigned int kind = 0; kind <= STEPS && rounds >= 12; kind++)
        assert_int_not_equal(planned[kind], 0);
}

/* Seeds that have found a fault. */
static void same_as_ever(void **state)
{
    static const uint32_t seeds[] = {439, 1272, 2697, 6969};
    (void)state;
    for (size_t i = 0; i < sizeof seeds / sizeof seeds[0]; i++)
        run_round(seeds[i], false, NULL);
}

/* A slave lets nothing through its port 1 for the second that such a setting lasts, and has a SYNC0 meanwhile. After
 * the second all twins process a frame, also without an address. */
static void loop_opens_in_time(void **state)
{
    static const struct {
        const char *title;
        uint32_t before_ns, cycle_ns; /* the first SYNC0: so long before the loop opens */
        bool polls;                   /* at the SYNC0, or at a frame then */
    } rows[] = {{"a frame comes, and no poll until the next one", 500 * MS, 0, false},
                {"SYNC0 has waked the slave just before", 1000, 1000, true}};
    ect_device_t device = testdev;
    const ect_device_t *devices[] = {&device, &device};
    const uint8_t closed[] = {0x03, 0x0C};
    uint8_t start[8], cycle[4], data = 0;
    wire_t w;
    (void)state;
    device.esc_config[3] = 0x08; /* SYNC0 is an AL event */
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_open(&w, devices, 2);
        w.manual_poll = true;
        uint64_t opens_ns = w.now_ns + 1000 * MS;
        uint64_t opens_at = ect_esc_system_time(ect_chain_esc(w.chain, 0), opens_ns);
        ect_store_le64(start, opens_at - rows[i].before_ns);
        ect_store_le32(cycle, rows[i].cycle_ns);
        assert_int_equal(wire_send(&w, BRD, 0, ECT_REG_AL_STATUS, &data, 1), 2); /* from now on it is known */
        assert_int_equal(wire_write(&w, 0, ECT_REG_DL_CONTROL, closed, 2), 1);
        assert_int_equal(wire_write(&w, 0, ECT_REG_DC_SYNC0_CYCLE, cycle, 4), 1);
        assert_int_equal(wire_write(&w, 0, ECT_REG_DC_START_TIME, start, 8), 1);
        assert_int_equal(wire_write8(&w, 0, ECT_REG_DC_ACTIVATION, 0x03), 1);
        wire_poll(&w);
        w.now_ns = opens_ns - rows[i].before_ns;
        if (rows[i].polls)
            wire_poll(&w);
        else
            assert_int_equal(wire_send(&w, BRD, 0, ECT_REG_AL_STATUS, &data, 1), 1);
        w.now_ns = opens_ns;
        int got = wire_send(&w, BRD, 0, ECT_REG_AL_STATUS, &data, 1);
        if (got != 2)
            fail_msg("%s: expected 2 slaves, got %d", rows[i].title, got);
        wire_close(&w);
    }
}

/* A SYNC0 every 300 us, from 500 us on. */
static void begin_pulses(wire_t *w, size_t position)
{
    uint8_t start[8], cycle[4];
    ect_store_le64(start, ect_esc_system_time(ect_chain_esc(w->chain, position), w->now_ns) + 500000);
    ect_store_le32(cycle, 300000);
    assert_int_equal(wire_write(w, position, ECT_REG_DC_SYNC0_CYCLE, cycle, 4), 1);
    assert_int_equal(wire_write(w, position, ECT_REG_DC_START_TIME, start, 8), 1);
    assert_int_equal(wire_write8(w, position, ECT_REG_DC_ACTIVATION, 0x03), 1);
}

/* One of two equal chains is polled after each frame, the other never: recorded times wait, whatever their source. */
static void wait_for_times(bool pulses)
{
    enum { SLAVES = 3, TOLD = 20 };
    static const uint16_t compared_registers[] = {ECT_REG_DC_SYSTEM_TIME, ECT_REG_DC_DIFFERENCE,
                                                  ECT_REG_DC_SPEED_DIFFERENCE};
    ect_device_t device = testdev;
    ect_twin_config_t twins[SLAVES];
    wire_t w[2];
    device.esc_config[3] = 0x08; /* SYNC0 is an AL event */
    for (size_t i = 0; i < SLAVES; i++) {
        twins[i] = ect_twin_default(&device, NULL);
        twins[i].drift_ppb = (int32_t)i * 50000;
    }
    for (unsigned int k = 0; k < 2; k++) {
        wire_open_twins(&w[k], twins, SLAVES);
        w[k].manual_poll = true;
        for (size_t i = 0; pulses && i < SLAVES; i++)
            begin_pulses(&w[k], i);
    }
    for (unsigned int n = 0; n < TOLD; n++) {
        uint16_t source = (uint16_t)(n % (SLAVES + 1)); /* the last one: no slave */
        uint8_t command = n % 2 == 0 ? FRMW : ARMW;
        uint16_t address = command == FRMW ? (uint16_t)(WIRE_STATION + source) : (uint16_t)(0 - source);
        for (unsigned int k = 0; k < 2; k++) {
            uint8_t time[8] = {(uint8_t)(100 + n)};
            w[k].now_ns += 1 * MS;
            assert_int_equal(wire_send(&w[k], command, address, ECT_REG_DC_SYSTEM_TIME, time, 8), SLAVES);
        }
        wire_poll(&w[0]);
    }
    for (size_t i = 0; i < SLAVES; i++) {
        for (size_t r = 0; r < sizeof compared_registers / sizeof compared_registers[0]; r++) {
            uint8_t polled[4], waited[4];
            assert_int_equal(wire_read(&w[0], i, compared_registers[r], polled, 4), 1);
            assert_int_equal(wire_read(&w[1], i, compared_registers[r], waited, 4), 1);
            if (memcmp(polled, waited, 4) != 0)
                fail_msg("0x%04X of slave %zu: polled 0x%X, not polled 0x%X", compared_registers[r], i,
                         ect_load_le32(polled), ect_load_le32(waited));
        }
    }
    wire_close(&w[0]);
    wire_close(&w[1]);
}

static void times_wait(void **state)
{
    (void)state;
    wait_for_times(false);
}

/* An ESC that is due gets the times of earlier frames first. */
static void times_before_pulses(void **state)
{
    (void)state;
    wait_for_times(true);
}

/* A time that is recorded postpones the SYNC0 of a slave that is ahead. A frame at the former instant of the SYNC0
 * finds it pending, whether the slave was polled since or not. */
static void times_move_a_pulse(void **state)
{
    enum { DRIFT_PPB = 100000, FRAMES_BEFORE = 20 };
    ect_device_t device = testdev;
    unsigned int moved = 0;
    uint8_t polled[8], waited[8];
    (void)state;
    device.esc_config[3] = 0x08; /* SYNC0 is an AL event */
    for (unsigned int n = 0; n < FRAMES_BEFORE; n++) {
        ect_twin_config_t twins[] = {ect_twin_default(&device, NULL), ect_twin_default(&device, NULL)};
        uint64_t due_ns = 0;
        wire_t w[2];
        twins[1].drift_ppb = DRIFT_PPB;
        for (unsigned int k = 0; k < 2; k++) {
            uint8_t time[8] = {0}, data = 0;
            wire_open_twins(&w[k], twins, 2);
            w[k].manual_poll = true;
            for (unsigned int frame = 0; frame < n; frame++) {
                w[k].now_ns += 1 * MS;
                assert_int_equal(wire_send(&w[k], FRMW, WIRE_STATION, ECT_REG_DC_SYSTEM_TIME, time, 8), 2);
            }
            begin_pulses(&w[k], 1);
            wire_poll(&w[k]);
            due_ns = ect_esc_due(ect_chain_esc(w[k].chain, 1));
            w[k].now_ns += 100000;
            assert_int_equal(wire_send(&w[k], FRMW, WIRE_STATION, ECT_REG_DC_SYSTEM_TIME, time, 8), 2);
            if (k == 0) {
                wire_poll(&w[k]);
                moved += ect_esc_due(ect_chain_esc(w[k].chain, 1)) > due_ns;
            }
            w[k].now_ns = due_ns;
            assert_int_equal(wire_send(&w[k], BRD, 0, ECT_REG_AL_STATUS, &data, 1), 2);
        }
        assert_int_equal(wire_read(&w[0], 1, ECT_REG_DC_START_TIME, polled, 8), 1);
        assert_int_equal(wire_read(&w[1], 1, ECT_REG_DC_START_TIME, waited, 8), 1);
        if (memcmp(polled, waited, 8) != 0)
            fail_msg("after %u times: the next SYNC0 is at %" PRIu64 " if polled, else at %" PRIu64, n,
                     ect_load_le64(polled), ect_load_le64(waited));
        wire_close(&w[0]);
        wire_close(&w[1]);
    }
    assert_true(moved > 0);
}

static void expect_lamp(const wire_t *w, size_t position, const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    ect_signal_ref_t ref;
    assert_true(ect_chain_signal(w->chain, position, "ecat.link_in", &ref));
    ect_signal_read(&ref, text);
    assert_string_equal(text, want);
}

/* The time of the last frame of each is known, although it is recorded once for all. */
static void lamps_within_reach(void **state)
{
    const ect_device_t *devices[] = {&testdev, &testdev, &testdev};
    const ect_setting_t cut = {.name = "ecat.plug_out", .value = "0"};
    char message[ECT_SIGNAL_MESSAGE];
    uint8_t data = 0;
    wire_t w;
    (void)state;
    wire_open(&w, devices, 3);
    w.now_ns += 500 * MS;
    assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 3);
    for (size_t i = 0; i < 3; i++)
        expect_lamp(&w, i, "flickering");
    assert_true(ect_settings_apply(w.chain, 1, &cut, 1, w.now_ns, message));
    wire_poll(&w);
    w.now_ns += ECT_INDICATOR_TRAFFIC_NS - 1;
    assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 2);
    expect_lamp(&w, 1, "flickering");
    expect_lamp(&w, 2, "off"); /* its plug is alone */
    const ect_setting_t mended = {.name = "ecat.plug_out", .value = "1"};
    assert_true(ect_settings_apply(w.chain, 1, &mended, 1, w.now_ns, message));
    wire_poll(&w);
    expect_lamp(&w, 2, "flickering"); /* the frame before the cut is recent */
    w.now_ns += 1;
    wire_poll(&w);
    expect_lamp(&w, 1, "flickering");
    expect_lamp(&w, 2, "on");
    wire_close(&w);
}

/* A PDI may set all 16 bits; the second read is the one that the sum replies to. */
static void status_of_all(void **state)
{
    static const ect_device_t *const devices[] = {&testdev, &testdev};
    static const uint8_t status[2][2] = {{0x02, 0x12}, {0x14, 0x80}}, want[] = {0x16, 0x92, 0};
    wire_t w;
    (void)state;
    wire_open(&w, devices, 2);
    for (size_t i = 0; i < 2; i++)
        assert_int_equal(ect_esc_pdi_write(ect_chain_esc(w.chain, i), ECT_REG_AL_STATUS, status[i], 2), 0);
    wire_poll(&w);
    for (uint16_t length = 1; length <= sizeof want; length++) {
        for (unsigned int n = 0; n < 2; n++) {
            uint8_t data[sizeof want] = {0};
            assert_int_equal(wire_send(&w, BRD, 0, ECT_REG_AL_STATUS, data, length), 2);
            assert_memory_equal(data, want, length);
        }
    }
    wire_close(&w);
}

static bool let_pass(void *ctx, ect_crossing_t *crossing)
{
    (void)ctx;
    (void)crossing;
    return true;
}

/* Times that a frame writes take effect at its end, in the order of the datagrams. One of two equal chains has a guard,
 * so its frames go the way of the reference. */
static void compare_times(uint16_t length, uint64_t start_ns)
{
    enum { SLAVES = 3, MOST_OF_A_FRAME = 3 };
    static const ect_device_t *const devices[SLAVES] = {&testdev, &testdev, &testdev};
    typedef struct part {
        uint8_t command;
        uint16_t slave, register_address;
    } part_t;
    static const part_t frames[][MOST_OF_A_FRAME] = {
        {{FRMW, 0, ECT_REG_DC_SYSTEM_TIME}, {FPWR, 1, ECT_REG_DC_SYSTEM_TIME}},
        {{FPWR, 1, ECT_REG_DC_SYSTEM_TIME}, {FRMW, 0, ECT_REG_DC_SYSTEM_TIME}},
        {{FRMW, 0, ECT_REG_DC_SYSTEM_TIME}, {FPWR, 0, ECT_REG_DC_SYSTEM_TIME}},
        {{FRMW, 2, ECT_REG_DC_SYSTEM_TIME}, {FPRD, 1, ECT_REG_DC_DIFFERENCE}},
        {{FRMW, 1, ECT_REG_DC_SYSTEM_TIME}, {FRMW, 2, ECT_REG_DC_SYSTEM_TIME}, {FPRD, 0, ECT_REG_DC_DIFFERENCE}},
        {{FRMW, 1, ECT_REG_DC_SYSTEM_TIME}, {FPWR, 2, ECT_REG_DC_SYSTEM_TIME}, {FRMW, 0, ECT_REG_DC_SYSTEM_TIME}},
        {{FPRD, 1, ECT_REG_DC_DIFFERENCE}, {FRMW, 0, ECT_REG_DC_SYSTEM_TIME}, {FPWR, 1, ECT_REG_DC_SYSTEM_TIME}},
    };
    for (size_t f = 0; f < sizeof frames / sizeof frames[0]; f++) {
        wire_t w[2];
        for (unsigned int k = 0; k < 2; k++) {
            wire_open(&w[k], devices, SLAVES);
            w[k].manual_poll = true;
            w[k].now_ns += start_ns;
            for (size_t i = 0; i < SLAVES; i++)
                ect_esc_set_drift(ect_chain_esc(w[k].chain, i), (int32_t)i * 50000);
            for (uint8_t n = 0; n < 3; n++) {
                w[k].now_ns += 1 * MS;
                for (unsigned int d = 0; d < MOST_OF_A_FRAME && frames[f][d].command != NOP; d++) {
                    const uint8_t time[8] = {(uint8_t)(100 * (d + 1)), n};
                    (d == 0 ? wire_build : wire_append)(&w[k], frames[f][d].command,
                                                        (uint16_t)(WIRE_STATION + frames[f][d].slave),
                                                        frames[f][d].register_address, time, length);
                }
                if (k == 1)
                    ect_chain_guard(w[k].chain, let_pass, NULL);
                assert_true(wire_transmit(&w[k]));
            }
        }
        assert_memory_equal(w[0].frame, w[1].frame, w[1].frame_length);
        for (size_t i = 0; i < SLAVES; i++) {
            const uint8_t *fast = ect_chain_esc(w[0].chain, i)->memory + ECT_REG_DC_SYSTEM_TIME;
            const uint8_t *slow = ect_chain_esc(w[1].chain, i)->memory + ECT_REG_DC_SYSTEM_TIME;
            for (unsigned int at = 0; at < 0x40; at++) {
                if (fast[at] != slow[at])
                    fail_msg("frame %zu of %u bytes: 0x%04X of slave %zu: the fast way 0x%02X, the reference 0x%02X", f,
                             length, ECT_REG_DC_SYSTEM_TIME + at, i, fast[at], slow[at]);
            }
        }
        wire_close(&w[0]);
        wire_close(&w[1]);
    }
}

/* The four bytes of a time, fewer, or some of those behind them; after 20 ms each of the four counts. */
static void times_within_a_frame(void **state)
{
    (void)state;
    for (uint16_t length = 1; length <= 8; length++) {
        compare_times(length, 0);
        compare_times(length, 20 * MS);
    }
}

/* The alias is the highest address, so that the last place of the table of stations is free without it. */
static void an_alias_that_is_switched_off(void **state)
{
    enum { ALIAS = 0x5000, ENABLE = ECT_REG_DL_CONTROL + 3 };
    ect_twin_config_t twins[] = {ect_twin_default(&testdev, NULL), ect_twin_default(&testdev, NULL)};
    wire_t w;
    (void)state;
    twins[1].alias = ALIAS;
    wire_open_twins(&w, twins, 2);
    for (unsigned int n = 0; n < 4; n++) {
        const bool on = n % 2 == 0;
        uint8_t type = 0, time[8] = {100};
        assert_int_equal(wire_write8(&w, 1, ENABLE, on), 1);
        assert_int_equal(wire_send(&w, FPRD, ALIAS, ECT_REG_TYPE, &type, 1), on);
        assert_int_equal(type != 0, on);
        assert_int_equal(wire_send(&w, FRMW, ALIAS, ECT_REG_DC_SYSTEM_TIME, time, 8), 2);
        assert_int_equal(ect_load_le64(time) != 100, on); /* read from the slave */
    }
    wire_close(&w);
}

/* Each FMMU of each slave maps two bytes of its own: a frame with all of them gets the replies of all. */
static void all_fmmus(void **state)
{
    enum { SLAVES = 3, FMMUS = ECT_ESC_MAX_FMMU, BYTES = 2 * SLAVES * FMMUS, PHYSICAL = 0x1100 };
    static const ect_device_t *const devices[SLAVES] = {&testdev, &testdev, &testdev};
    uint8_t image[BYTES], want[BYTES];
    wire_t w;
    (void)state;
    wire_open(&w, devices, SLAVES);
    for (size_t i = 0; i < SLAVES; i++) {
        for (uint16_t n = 0; n < FMMUS; n++) {
            const size_t at = 2 * (i * FMMUS + n);
            uint8_t *memory = ect_chain_esc(w.chain, i)->memory + PHYSICAL + 2 * n;
            memory[0] = want[at] = (uint8_t)(at + 1);
            memory[1] = want[at + 1] = (uint8_t)(0x80 | at);
            wire_set_fmmu(&w, i, n, (uint32_t)(0x10000 + at), 2, 0, 7, (uint16_t)(PHYSICAL + 2 * n), 0, 1);
        }
    }
    for (unsigned int reads = 0; reads < 2; reads++) {
        memset(image, 0, sizeof image);
        assert_int_equal(wire_logical(&w, LRD, 0x10000, image, BYTES), SLAVES);
        assert_memory_equal(image, want, BYTES);
        wire_set_fmmu(&w, 0, 0, 0x10000, 2, 0, 7, PHYSICAL, 0, 1); /* the tables are made again */
    }
    wire_close(&w);
}

/* The ESCs that were visited, in their order. */
typedef struct visits {
    const wire_t *w;
    size_t positions[8];
    size_t count, most;
} visits_t;

static bool note_visit(void *ctx, size_t position, const ect_esc_t *esc)
{
    visits_t *visits = ctx;
    assert_ptr_equal(ect_chain_esc(visits->w->chain, position), esc);
    assert_in_range(visits->count, 0, 7);
    visits->positions[visits->count++] = position;
    return visits->count < visits->most;
}

/* Each of some slaves of a long line maps a byte for reading, and the last one a byte for writing. */
static void visited_in_order(void **state)
{
    enum { SLAVES = 140, MAPPED = 6 };
    static const size_t positions[MAPPED] = {0, 63, 64, 100, 127, 139};
    static ect_twin_config_t twins[SLAVES];
    wire_t w;
    (void)state;
    for (size_t i = 0; i < SLAVES; i++)
        twins[i] = ect_twin_default(&testdev, NULL);
    wire_open_twins(&w, twins, SLAVES);
    for (size_t k = 0; k < MAPPED; k++)
        wire_set_fmmu(&w, positions[k], 0, (uint32_t)(0x10000 + k), 1, 0, 7, 0x1100, 0, k < MAPPED - 1 ? 1 : 2);
    for (size_t first = 0; first < MAPPED; first++) {
        for (size_t length = 1; first + length <= MAPPED; length++) {
            for (unsigned int direction = ECT_PART_READ; direction <= (ECT_PART_READ | ECT_PART_WRITE); direction++) {
                visits_t visits = {.w = &w, .most = MAPPED + 1};
                size_t want = 0;
                assert_true(ect_chain_visit_mapped(w.chain, (uint32_t)(0x10000 + first), (uint16_t)length, direction,
                                                   note_visit, &visits));
                for (size_t k = first; k < first + length; k++) {
                    if ((direction & (k < MAPPED - 1 ? ECT_PART_READ : ECT_PART_WRITE)) == 0)
                        continue;
                    assert_int_equal(visits.positions[want], positions[k]);
                    want++;
                }
                assert_int_equal(visits.count, want);
            }
        }
    }
    visits_t few = {.w = &w, .most = 2}; /* ends the visits */
    assert_false(ect_chain_visit_mapped(w.chain, 0x10000, MAPPED, ECT_PART_READ, note_visit, &few));
    assert_int_equal(few.count, 2);
    wire_close(&w);
}

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);

static unsigned int callocs_left = UINT_MAX;
static bool one_fails; /* else all that follow fail too */

void *__wrap_calloc(size_t count, size_t size)
{
    if (callocs_left == 0) {
        callocs_left = one_fails ? UINT_MAX : 0;
        return NULL;
    }
    callocs_left--;
    return __real_calloc(count, size);
}

/* An allocation of any of its blocks fails, alone or with all later ones: no memory is leaked, which a sanitizer
 * checks. */
static void each_block_fails(void)
{
    unsigned int failed = 0;
    ect_fast_t *fast = NULL;
    for (unsigned int left = 0; !fast; left++) {
        callocs_left = left;
        fast = ect_fast_new(3);
        callocs_left = UINT_MAX;
        failed += fast == NULL;
    }
    assert_int_equal(failed, 6);
    ect_fast_free(fast);
    ect_fast_free(NULL);
    ect_deadlines_t *deadlines = NULL;
    for (unsigned int left = 0; !deadlines; left++) {
        callocs_left = left;
        deadlines = ect_deadlines_new(3);
        callocs_left = UINT_MAX;
    }
    ect_deadlines_free(deadlines);
    ect_names_t *names = NULL;
    for (unsigned int left = 0; !names; left++) {
        callocs_left = left;
        names = ect_names_new(3);
        callocs_left = UINT_MAX;
    }
    ect_names_free(names);
}

static void memory_runs_out(void **state)
{
    (void)state;
    each_block_fails();
    one_fails = true;
    each_block_fails();
    one_fails = false;
}

/* The same of a chain with all that its twins can have. Without memory for the delays the chain has none. */
static void chain_without_memory(void **state)
{
    const ect_device_t *device = &ect_eclink_map1;
    ect_twin_config_t twins[2] = {ect_twin_default(&testdev, NULL), ect_twin_default(device, plant_of(device))};
    ect_chain_t *chain = NULL;
    unsigned int left = 0;
    (void)state;
    twins[0].slow.receive_ns = 10;
    for (; !chain; left++) {
        callocs_left = left;
        chain = ect_chain_new(twins, 2, 0);
        callocs_left = UINT_MAX;
    }
    assert_in_range(left, 20, 100);
    ect_chain_free(chain);
    for (; left > 0; left--) {
        callocs_left = left - 1;
        const size_t wrong = ect_chain_check_wires(twins, 2);
        callocs_left = UINT_MAX;
        assert_int_equal(wrong, 2); /* not checked */
    }
}

/* A call for which there is no memory is refused, and changes nothing. */
static void calls_without_memory(void **state)
{
    const ect_device_t *devices[] = {&testdev, &testdev};
    const ect_fault_t fault = {.kind = ECT_FAULT_MAIL_LOST, .slave = 1};
    const ect_setting_t settings[] = {{"ecat.latch0", "1"}, {"ecat.latch1", "1"}};
    const char *const values[] = {"1", "1"};
    char message[ECT_SIGNAL_MESSAGE], text[ECT_SIGNAL_TEXT_ROOM];
    ect_setting_place_t places[2];
    ect_connection_t connection = {.from = 0, .to = 1, .factor = 1, .delay_ns = MS};
    uint8_t data = 0;
    wire_t w;
    (void)state;
    wire_open(&w, devices, 2);
    assert_true(ect_chain_signal(w.chain, 0, "ecat.latch0", &connection.source));
    assert_true(ect_chain_signal(w.chain, 1, "ecat.latch1", &connection.target));
    for (size_t i = 0; i < 2; i++)
        assert_true(ect_settings_find(w.chain, 0, settings[i].name, &places[i], message));
    callocs_left = 0;
    const char *why = ect_chain_fault(w.chain, &fault, w.now_ns);
    callocs_left = UINT_MAX;
    assert_string_equal(why, "there is not enough memory");
    assert_null(ect_chain_fault_at(w.chain, 0));
    for (unsigned int left = 0; left < 2; left++) { /* the steps, and the state of the twin */
        callocs_left = left;
        const bool applied = ect_settings_apply(w.chain, 0, settings, 2, w.now_ns, message);
        callocs_left = UINT_MAX;
        assert_false(applied);
        assert_string_equal(message, "not enough memory");
        callocs_left = left;
        const bool written = ect_settings_write(w.chain, places, values, 2, w.now_ns, message);
        callocs_left = UINT_MAX;
        assert_false(written);
        assert_string_equal(message, "not enough memory");
        callocs_left = left;
        const bool connected = ect_chain_connect(w.chain, &connection, 1);
        callocs_left = UINT_MAX;
        assert_false(connected);
    }
    for (size_t i = 0; i < 2; i++) {
        ect_signal_read(&places[i].ref, text);
        assert_string_equal(text, "0");
    }
    assert_true(ect_settings_apply(w.chain, 0, settings, 2, w.now_ns, message));
    assert_true(ect_chain_connect(w.chain, &connection, 1));
    callocs_left = 0; /* of the delays: a link is cut nevertheless */
    ect_chain_set_link(w.chain, ECT_END_IN, false);
    callocs_left = UINT_MAX;
    assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), NO_REPLY);
    ect_chain_set_link(w.chain, ECT_END_IN, true);
    assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 2);
    wire_close(&w);
}

static void pull_a_plug(wire_t *w)
{
    const ect_setting_t pulled = {.name = "ecat.plug_out", .value = "0"};
    char message[ECT_SIGNAL_MESSAGE];
    assert_true(ect_settings_apply(w->chain, 0, &pulled, 1, w->now_ns, message));
}

static void cut_the_first(wire_t *w)
{
    ect_chain_set_link(w->chain, ECT_END_IN, false);
}

static void close_a_ring(wire_t *w)
{
    ect_chain_set_link(w->chain, ECT_END_OUT, true);
}

static void set_a_guard(wire_t *w)
{
    ect_chain_guard(w->chain, let_pass, NULL);
}

static void enable_a_write(wire_t *w)
{
    assert_int_equal(wire_write8(w, 1, 0x0020, 1), 1); /* for the next frame */
}

static void protect(wire_t *w)
{
    assert_int_equal(wire_write8(w, 1, 0x0021, 1), 1);
}

static void circulate(wire_t *w)
{
    const ect_setting_t pulled = {.name = "ecat.plug_in", .value = "0"};
    char message[ECT_SIGNAL_MESSAGE];
    assert_true(ect_settings_apply(w->chain, 0, &pulled, 1, w->now_ns, message));
    wire_poll(w);
}

/* Replies in advance are those of frames on the fast path; a plug that was pulled takes effect at the next poll. */
static void steady_chains(void **state)
{
    static const struct {
        const char *title;
        void (*happens)(wire_t *w);
        bool after_a_poll;
    } rows[] = {{"a plug is pulled", pull_a_plug, true},
                {"no cable at the input", cut_the_first, false},
                {"a cable at the output", close_a_ring, false},
                {"a guard", set_a_guard, false},
                {"a write is enabled for the next frame", enable_a_write, false},
                {"writes are protected", protect, false},
                {"no link at port 0", circulate, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_device_t *devices[] = {&testdev, &testdev};
        ect_chain_steady_t steady = {0};
        wire_t w;
        wire_open(&w, devices, 2);
        w.manual_poll = true;
        wire_poll(&w);
        assert_true(ect_chain_steady(w.chain, &steady));
        assert_int_equal(steady.reach, 2);
        rows[i].happens(&w);
        if (ect_chain_steady(w.chain, &steady))
            fail_msg("%s: expected no replies in advance", rows[i].title);
        wire_poll(&w);
        if (ect_chain_steady(w.chain, &steady) != rows[i].after_a_poll)
            fail_msg("%s: expected replies in advance after a poll: %d", rows[i].title, rows[i].after_a_poll);
        wire_close(&w);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-002 CF-010 CF-028: replies, memories and states are those of one controller after the other",
         same_as_the_reference, NULL, NULL, NULL},
        {"CF-002: the same with frames with a bad check sum in between", with_bad_check_sums, NULL, NULL, NULL},
        {"CF-002 CF-010 CF-089: the same in cases that once differed", same_as_ever, NULL, NULL, NULL},
        {"CF-002 CF-010 CF-028: plans give these replies, for any number of frames before they pass the chain",
         plans_reply_alike, NULL, NULL, NULL},
        {"CF-010: a loop that was closed for a time is open for the first frame after it", loop_opens_in_time, NULL,
         NULL, NULL},
        {"CF-088: a recorded system time is applied before any access, also when more are sent than are kept",
         times_wait, NULL, NULL, NULL},
        {"CF-088 CF-089: a recorded system time moves the next SYNC0", times_move_a_pulse, NULL, NULL, NULL},
        {"CF-088 CF-089: a recorded system time is applied before a pulse of SYNC0", times_before_pulses, NULL, NULL,
         NULL},
        {"CF-002: a broadcast read of AL status gets all bits of all slaves, in one byte or two", status_of_all, NULL,
         NULL, NULL},
        {"CF-004: a station alias that is switched off gets no reply and no system time", an_alias_that_is_switched_off,
         NULL, NULL, NULL},
        {"slaves that map a logical address are visited in the order of the wire", visited_in_order, NULL, NULL, NULL},
        {"CF-028: a frame with all FMMUs of all slaves", all_fmmus, NULL, NULL, NULL},
        {"a line without memory is refused, and allocates none", memory_runs_out, NULL, NULL, NULL},
        {"a chain without memory is refused, and allocates none", chain_without_memory, NULL, NULL, NULL},
        {"a call without memory is refused, and changes nothing", calls_without_memory, NULL, NULL, NULL},
        {"replies in advance need a line, no guard, and no frame with an effect of its own", steady_chains, NULL, NULL,
         NULL},
        {"CF-088: system times of one frame take effect at its end, in the order of its datagrams",
         times_within_a_frame, NULL, NULL, NULL},
        {"link lamps flicker at the slaves that frames reach", lamps_within_reach, NULL, NULL, NULL},
    };
    if (argc > 1)
        rounds = (unsigned int)strtoul(argv[1], NULL, 10);
    if (argc > 2)
        first_seed = (uint32_t)strtoul(argv[2], NULL, 10);
    if (argc > 3)
        cmocka_set_test_filter(argv[3]);
    return cmocka_run_group_tests_name("the fast way", tests, NULL, NULL);
}
