/* SPDX-License-Identifier: MIT */
/* Which frames get a plan, and which changes of the chain take it away. test_fast_chain compares the replies. */
#include "bus/kernel/plan.h"

#include <string.h>

#include "bus/kernel/pace.h"
#include "devices/eclink/eclink.h"
#include "esc/route.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { FMMU_OUT = 0, FMMU_IN = 1, OUTPUTS = 0x1200, INPUTS = 0x1300, MAILBOXES = 0x1400, SLAVES = 2 };

typedef struct rig {
    wire_t w;
    ect_planner_t planner;
} rig_t;

static ect_plan_table_t table;
static const uint8_t zeros[128];

static void open_rig(rig_t *r)
{
    const ect_device_t *const devices[SLAVES] = {&testdev, &testdev};
    memset(r, 0, sizeof *r);
    memset(&table, 0, sizeof table);
    wire_open(&r->w, devices, SLAVES);
    for (size_t i = 0; i < SLAVES; i++) {
        wire_go(&r->w, i, 8);
        wire_set_fmmu(&r->w, i, FMMU_OUT, (uint32_t)(0x100 + 6 * i), 3, 0, 7, OUTPUTS, 0, 2);
        wire_set_fmmu(&r->w, i, FMMU_IN, (uint32_t)(0x103 + 6 * i), 3, 0, 7, INPUTS, 0, 1);
        (void)wire_read16(&r->w, i, ECT_REG_AL_STATUS);
    }
    uint8_t status[2] = {0};
    (void)wire_send(&r->w, BRD, 0, ECT_REG_AL_STATUS, status, 2);
    r->planner.table = &table;
    r->w.manual_poll = true;
}

static void build_cyclic(rig_t *r)
{
    const uint8_t data[6 * SLAVES] = {1, 2, 3, 0, 0, 0, 4, 5, 6, 0, 0, 0};
    uint8_t time[8] = {0};
    wire_build(&r->w, LRW, 0x100, 0, data, sizeof data);
    wire_append(&r->w, BRD, 0, ECT_REG_AL_STATUS, time, 2);
    wire_append(&r->w, FRMW, WIRE_STATION, ECT_REG_DC_SYSTEM_TIME, time, 8);
}

/* @return whether the frame in the wire's buffer gets a plan */
static bool gets_plan(rig_t *r)
{
    ect_planner_void(&r->planner);
    memset(r->planner.samples, 0, sizeof r->planner.samples);
    memset(r->planner.known, 0, sizeof r->planner.known);
    ect_planner_see(&r->planner, r->w.frame, r->w.frame_length);
    return ect_planner_make(&r->planner, r->w.chain) == 1;
}

/* Any number of replies, equal to those of the chain when it gets the frames later. */
static void replies_ahead_of_the_chain(void **state)
{
    enum { AHEAD = 20 };
    uint8_t replies[AHEAD][200];
    static rig_t r;
    (void)state;
    open_rig(&r);
    build_cyclic(&r);
    assert_true(gets_plan(&r));
    uint64_t start_ns = r.w.now_ns;
    for (unsigned int i = 0; i < AHEAD; i++) {
        memcpy(replies[i], r.w.frame, r.w.frame_length);
        replies[i][17] = (uint8_t)i; /* the index is the master's */
        assert_true(ect_plan_reply(&table, replies[i], r.w.frame_length, start_ns + i * MS));
    }
    ect_planner_void(&r.planner);
    uint8_t frame[200];
    memcpy(frame, r.w.frame, sizeof frame);
    for (unsigned int i = 0; i < AHEAD; i++) {
        memcpy(r.w.frame, frame, sizeof frame);
        r.w.frame[17] = (uint8_t)i;
        r.w.now_ns = start_ns + i * MS;
        assert_true(wire_transmit(&r.w));
        assert_memory_equal(r.w.frame, replies[i], r.w.frame_length);
        assert_int_equal(wire_wkc(&r.w, 0), 3 * SLAVES);
        assert_int_equal(wire_wkc(&r.w, 1), SLAVES);
    }
    assert_false(ect_plan_reply(&table, frame, r.w.frame_length, r.w.now_ns));
    wire_close(&r.w);
}

/* The outputs of the second slave are those of the master, or the inputs of the first slave in the same frame. */
static void frames_with_a_reply(void **state)
{
    enum { FIRST = 16 + ECT_DATAGRAM_DATA, BYTES = 6 * SLAVES };
    static const uint8_t inputs[3] = {7, 8, 9};
    const struct {
        uint32_t logical; /* of the outputs of the second slave */
        uint8_t outputs[3];
        bool has_inputs; /* the frame, afterwards */
    } rows[] = {{0x106, {4, 5, 6}, false}, {0x103, {7, 8, 9}, true}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static rig_t r;
        uint8_t reply[200], outputs[3], request[BYTES];
        open_rig(&r);
        wire_set_fmmu(&r.w, 1, FMMU_OUT, rows[i].logical, 3, 0, 7, OUTPUTS, 0, 2);
        (void)ect_esc_pdi_write(ect_chain_esc(r.w.chain, 0), INPUTS, inputs, sizeof inputs);
        build_cyclic(&r);
        assert_true(gets_plan(&r));
        memcpy(reply, r.w.frame, r.w.frame_length);
        memcpy(request, r.w.frame + FIRST, BYTES);
        assert_true(ect_plan_reply(&table, reply, r.w.frame_length, r.w.now_ns));
        assert_memory_equal(reply + FIRST + 3, inputs, sizeof inputs);
        ect_planner_void(&r.planner);
        ect_chain_pass_replied(r.w.chain, r.w.frame, r.w.frame_length, r.w.now_ns);
        assert_memory_equal(r.w.frame + FIRST, rows[i].has_inputs ? reply + FIRST : request, BYTES);
        assert_memory_equal(r.w.frame, reply, FIRST);
        assert_memory_equal(r.w.frame + FIRST + BYTES, reply + FIRST + BYTES, r.w.frame_length - FIRST - BYTES);
        (void)ect_esc_pdi_read(ect_chain_esc(r.w.chain, 1), OUTPUTS, outputs, sizeof outputs);
        assert_memory_equal(outputs, rows[i].outputs, sizeof outputs);
        wire_close(&r.w);
    }
}

/* The pace: the frames that the devices must process first. */
static void pace(void **state)
{
    const struct {
        uint64_t after_ns;
        bool reacting, close;
    } rows[] = {{ECT_PACE_CLOSE_NS, true, false},
                {ECT_PACE_CLOSE_NS - 1, true, true},
                {ECT_PACE_CLOSE_NS - 1, false, false},
                {0, true, true},
                {250000, true, false}};
    uint64_t last_ns = 0, now_ns = MS;
    (void)state;
    assert_false(ect_pace_is_close(&last_ns, now_ns, true));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        now_ns += rows[i].after_ns;
        assert_int_equal(ect_pace_is_close(&last_ns, now_ns, rows[i].reacting), rows[i].close);
        assert_int_equal(last_ns, now_ns);
    }
}

/* @return whether the outputs of the wire's frame count as changed */
static bool changes(rig_t *r)
{
    r->planner.outputs_changed = false;
    ect_planner_see(&r->planner, r->w.frame, r->w.frame_length);
    return r->planner.outputs_changed;
}

static void changed_outputs(void **state)
{
    static rig_t r;
    (void)state;
    open_rig(&r);
    build_cyclic(&r);
    assert_false(changes(&r)); /* the first one */
    assert_false(changes(&r));
    r.w.frame[17]++; /* the index */
    assert_false(changes(&r));
    wire_datagram(&r.w, 2)[10]++; /* the time that FRMW carries */
    assert_false(changes(&r));
    wire_datagram(&r.w, 0)[10]++;
    assert_true(changes(&r));
    assert_false(changes(&r));
    wire_close(&r.w);
}

/* --- frames without a plan ---------------------------------------------------------------------------------------- */

static void no_change(rig_t *r)
{
    (void)r;
}

static void a_mailbox(rig_t *r)
{
    wire_build(&r->w, FPRD, WIRE_STATION, 0x1080, zeros, 128);
}

static void a_register(rig_t *r)
{
    wire_build(&r->w, BRD, 0, ECT_REG_DL_STATUS, zeros, 2);
}

static void long_status(rig_t *r)
{
    wire_build(&r->w, BRD, 0, ECT_REG_AL_STATUS, zeros, 4);
}

static void half_an_image(rig_t *r)
{
    const uint8_t data[2] = {0};
    wire_build(&r->w, LRW, 0x100, 0, data, sizeof data);
}

static void nothing_in_it(rig_t *r)
{
    wire_build(&r->w, NOP, 0, 0, zeros, 0);
}

static void no_clock(rig_t *r)
{
    const uint8_t data[8] = {0};
    wire_build(&r->w, FRMW, 0x5555, ECT_REG_DC_SYSTEM_TIME, data, sizeof data);
}

static void build_time(rig_t *r, uint16_t length)
{
    wire_build(&r->w, FRMW, WIRE_STATION, ECT_REG_DC_SYSTEM_TIME, zeros, length);
}

static void three_bytes_of_time(rig_t *r)
{
    build_time(r, 3);
}

static void four_bytes_of_time(rig_t *r)
{
    build_time(r, 4);
}

static void all_bytes_of_time(rig_t *r)
{
    build_time(r, 8);
}

static void more_than_time(rig_t *r)
{
    build_time(r, 9);
}

static void two_clocks(rig_t *r)
{
    const uint8_t data[8] = {0};
    wire_build(&r->w, FRMW, WIRE_STATION, ECT_REG_DC_SYSTEM_TIME, data, sizeof data);
    wire_append(&r->w, FRMW, WIRE_STATION + 1, ECT_REG_DC_SYSTEM_TIME, data, sizeof data);
}

static void too_many(rig_t *r)
{
    const uint8_t data[1] = {0};
    wire_build(&r->w, NOP, 0, 0, data, sizeof data);
    for (unsigned int i = 0; i < ECT_PLAN_STEPS; i++)
        wire_append(&r->w, NOP, 0, 0, data, sizeof data);
}

static void many_counters(rig_t *r)
{
    const uint8_t data[2] = {0};
    wire_build(&r->w, BRD, 0, ECT_REG_AL_STATUS, data, 2);
    for (unsigned int i = 0; i < ECT_PLAN_STEPS / 3; i++)
        wire_append(&r->w, BRD, 0, ECT_REG_AL_STATUS, data, 2);
}

static void a_tag(rig_t *r)
{
    build_cyclic(r);
    memmove(r->w.frame + 16, r->w.frame + 12, r->w.frame_length - 12);
    memcpy(r->w.frame + 12, "\x81\x00\x00\x01", 4);
    r->w.frame_length += 4;
}

static void too_long(rig_t *r)
{
    build_cyclic(r);
    r->w.frame_length = ECT_PLAN_FRAME + 1;
}

/* Only slave 0 takes part, with its SyncManager of outputs alone. */
static void outputs_of_one(rig_t *r)
{
    wire_build(&r->w, LWR, 0x100, 0, zeros, 3);
}

/* Only the FMMU of inputs maps these addresses, so that no slave takes part. */
static void write_to_inputs(rig_t *r)
{
    wire_build(&r->w, LWR, 0x109, 0, zeros, 3);
}

static void read_of_outputs(rig_t *r)
{
    wire_build(&r->w, LRD, 0x106, 0, zeros, 3);
}

/* --- changes ------------------------------------------------------------------------------------------------------ */

static void fmmu_moves(rig_t *r)
{
    wire_set_fmmu(&r->w, 1, FMMU_IN, 0x109, 3, 0, 7, INPUTS + 1, 0, 1);
}

static void fmmu_of_bits(rig_t *r)
{
    wire_set_fmmu(&r->w, 1, FMMU_IN, 0x109, 3, 1, 7, INPUTS, 0, 1);
}

static void fmmu_reads_outputs(rig_t *r)
{
    wire_set_fmmu(&r->w, 1, FMMU_IN, 0x109, 3, 0, 7, OUTPUTS, 0, 1);
}

/* As masters map that save bytes of the frame: the inputs replace the outputs. */
static void fmmus_share_addresses(rig_t *r)
{
    wire_set_fmmu(&r->w, 0, FMMU_IN, 0x100, 3, 0, 7, INPUTS, 0, 1);
    wire_set_fmmu(&r->w, 1, FMMU_IN, 0x106, 3, 0, 7, INPUTS, 0, 1);
}

static void sm_is_off(rig_t *r)
{
    wire_set_sm(&r->w, 0, 3, INPUTS, 0, 0x20);
}

static void sm_restarts(rig_t *r)
{
    wire_set_sm(&r->w, 0, 3, INPUTS, 0, 0x20);
    wire_set_sm(&r->w, 0, 3, INPUTS, 3, 0x20); /* its slave has written nothing yet */
}

static void sm_has_events(rig_t *r)
{
    wire_set_sm(&r->w, 0, 2, OUTPUTS, 0, 0x74);
    wire_set_sm(&r->w, 0, 2, OUTPUTS, 3, 0x74);
}

static void output_fmmu_of_bits(rig_t *r)
{
    wire_set_fmmu(&r->w, 1, FMMU_OUT, 0x106, 3, 1, 7, OUTPUTS, 0, 2);
}

static void inactive_fmmu_of_bits(rig_t *r)
{
    output_fmmu_of_bits(r);
    (void)wire_write8(&r->w, 1, ECT_REG_FMMU + ECT_FMMU_SIZE * FMMU_OUT + ECT_FMMU_ACTIVATE, 0);
}

/* Two more FMMUs of inputs: the second one maps other addresses, the first one those of the frame. */
static void two_more_fmmus(rig_t *r)
{
    wire_set_fmmu(&r->w, 1, 2, 0x109, 3, 0, 7, INPUTS, 0, 1);
    wire_set_fmmu(&r->w, 1, 3, 0x200, 3, 0, 7, INPUTS, 0, 1);
}

static void one_of_two_more_fmmus(rig_t *r)
{
    two_more_fmmus(r);
    (void)wire_write8(&r->w, 1, ECT_REG_FMMU + ECT_FMMU_SIZE * 2 + ECT_FMMU_ACTIVATE, 0);
}

static void sm_reaches_into_another(rig_t *r)
{
    wire_set_sm(&r->w, 0, 2, OUTPUTS, 0, 0x64);
    wire_set_sm(&r->w, 0, 2, INPUTS - 6, 0, 0x64);
    wire_set_sm(&r->w, 0, 2, INPUTS - 6, 3, 0x64);
    wire_set_fmmu(&r->w, 0, FMMU_OUT, 0x100, 3, 0, 7, INPUTS - 6, 0, 2);
}

/* Moves the outputs of the first slave, whose three buffers occupy three times their length. */
static void outputs_at(rig_t *r, uint32_t start, uint16_t length, uint8_t control)
{
    wire_set_sm(&r->w, 0, 2, OUTPUTS, 0, control);
    wire_set_sm(&r->w, 0, 2, (uint16_t)start, 0, control);
    wire_set_sm(&r->w, 0, 2, (uint16_t)start, length, control);
    wire_set_fmmu(&r->w, 0, FMMU_OUT, 0x100, length, 0, 7, (uint16_t)start, 0, 2);
}

static void outputs_before_inputs(rig_t *r)
{
    outputs_at(r, INPUTS - 9, 3, 0x64);
}

static void outputs_reach_inputs(rig_t *r)
{
    outputs_at(r, INPUTS - 8, 3, 0x64);
}

static void outputs_behind_inputs(rig_t *r)
{
    outputs_at(r, INPUTS + 9, 3, 0x64);
}

static void inputs_reach_outputs(rig_t *r)
{
    outputs_at(r, INPUTS + 8, 3, 0x64);
}

static void outputs_end_with_the_memory(rig_t *r)
{
    outputs_at(r, ect_chain_esc(r->w.chain, 0)->memory_size - 9, 3, 0x64);
}

static void outputs_end_behind_the_memory(rig_t *r)
{
    outputs_at(r, ect_chain_esc(r->w.chain, 0)->memory_size - 8, 3, 0x64);
}

static void outputs_of_two_bytes(rig_t *r)
{
    outputs_at(r, OUTPUTS, 2, 0x64);
}

static void outputs_of_one_byte(rig_t *r)
{
    outputs_at(r, OUTPUTS, 1, 0x64);
}

static void outputs_by_mailbox(rig_t *r)
{
    outputs_at(r, OUTPUTS, 3, 0x66);
}

static void outputs_are_inputs(rig_t *r)
{
    outputs_at(r, OUTPUTS, 3, 0x60);
}

/* The mailboxes of the second slave, which take no part in the frame, occupy 128 bytes each. */
static void mailboxes_at(rig_t *r, uint16_t first, uint16_t second)
{
    wire_set_sm(&r->w, 1, 0, first, 0, 0x26);
    wire_set_sm(&r->w, 1, 1, second, 0, 0x22);
    wire_set_sm(&r->w, 1, 0, first, 128, 0x26);
    wire_set_sm(&r->w, 1, 1, second, 128, 0x22);
}

static void mailboxes_adjoin(rig_t *r)
{
    mailboxes_at(r, MAILBOXES, MAILBOXES + 128);
}

static void mailboxes_adjoin_in_turn(rig_t *r)
{
    mailboxes_at(r, MAILBOXES + 128, MAILBOXES);
}

static void mailboxes_share_a_byte(rig_t *r)
{
    mailboxes_at(r, MAILBOXES, MAILBOXES + 127);
}

static void mailboxes_share_a_byte_in_turn(rig_t *r)
{
    mailboxes_at(r, MAILBOXES + 127, MAILBOXES);
}

static void sm_is_locked(rig_t *r)
{
    const uint8_t locked = 1;
    (void)ect_esc_pdi_write(ect_chain_esc(r->w.chain, 0), ECT_REG_SM + 8 * 2 + ECT_SM_PDI_CONTROL, &locked, 1);
}

static void status_is_new(rig_t *r)
{
    (void)wire_write16(&r->w, 0, ECT_REG_AL_CONTROL, 4);
    wire_poll(&r->w);
}

static void clock_is_trimmed(rig_t *r)
{
    ect_esc_set_drift(ect_chain_esc(r->w.chain, 0), 5000);
}

static void cable_is_out(rig_t *r)
{
    ect_chain_set_link(r->w.chain, ECT_END_IN, false);
}

/* A slave takes the address of the reference clock. */
static void address_is_taken(rig_t *r)
{
    (void)wire_write16(&r->w, 1, ECT_REG_STATION_ADDRESS, WIRE_STATION);
}

/* Two windows over the outputs of the frame: the first to begin is the last to end. */
static void windows_overlap(rig_t *r)
{
    wire_set_fmmu(&r->w, 0, FMMU_OUT, 0xF0, 0x40, 0, 7, OUTPUTS, 0, 2);
    wire_set_fmmu(&r->w, 1, FMMU_OUT, 0xF8, 3, 0, 7, OUTPUTS, 0, 2);
}

/* Frames turn back at the first slave: a reply has nothing of the second. */
static void second_is_cut_off(rig_t *r)
{
    (void)wire_write8(&r->w, 0, ECT_REG_DL_CONTROL + 1, 0x0C); /* port 1 is closed */
}

static void goes_through(rig_t *r)
{
    ect_chain_set_link(r->w.chain, ECT_END_OUT, true);
    (void)wire_write8(&r->w, SLAVES - 1, ECT_REG_DL_CONTROL + 1, 0x08); /* port 1 is open */
}

static void loop_for_a_second(rig_t *r)
{
    const uint8_t closed[] = {0x03, 0x0C};
    (void)wire_write(&r->w, 1, ECT_REG_DL_CONTROL, closed, 2);
}

static void pdi_is_watched(rig_t *r)
{
    ect_esc_watch_pdi(ect_chain_esc(r->w.chain, 1), true);
}

static void writes_are_protected(rig_t *r)
{
    (void)wire_write8(&r->w, 1, ECT_REG_WRITE_PROTECTION, 1);
}

static bool let_pass(void *ctx, ect_crossing_t *crossing)
{
    (void)ctx;
    (void)crossing;
    return true;
}

static void a_fault_waits(rig_t *r)
{
    ect_chain_guard(r->w.chain, let_pass, NULL);
}

static void new_inputs(rig_t *r)
{
    const uint8_t inputs[3] = {0xA5, 0x5A, 0x77};
    (void)ect_esc_pdi_write(ect_chain_esc(r->w.chain, 1), INPUTS, inputs, sizeof inputs);
}

static void clock_is_set(rig_t *r)
{
    (void)wire_write16(&r->w, 0, ECT_REG_DC_OFFSET, 12345);
}

static void sm_restarts_and_runs(rig_t *r)
{
    const uint8_t inputs[3] = {1, 2, 3};
    sm_restarts(r);
    (void)ect_esc_pdi_write(ect_chain_esc(r->w.chain, 0), INPUTS, inputs, sizeof inputs);
}

static void status_is_another(rig_t *r)
{
    uint8_t status[2] = {0};
    status_is_new(r);
    (void)wire_send(&r->w, BRD, 0, ECT_REG_AL_STATUS, status, 2);
}

static void address_is_gone(rig_t *r)
{
    (void)wire_write16(&r->w, 0, ECT_REG_STATION_ADDRESS, 0x3333);
}

static void fault(rig_t *r, const char *text)
{
    char message[ECT_FAULT_MESSAGE];
    ect_fault_t parsed;
    if (!ect_fault_parse(text, &parsed, message))
        fail_msg("%s", message);
    assert_null(ect_chain_fault(r->w.chain, &parsed, r->w.now_ns));
}

static void pdi_access_fails(rig_t *r)
{
    fault(r, "pdi-error slave 2");
}

static void event_is_lost(rig_t *r)
{
    fault(r, "lose-event slave 2");
}

static void eeprom_is_busy(rig_t *r)
{
    fault(r, "eeprom busy slave 2");
}

static void slave_restarts(rig_t *r)
{
    ect_chain_power_cycle(r->w.chain, r->w.now_ns);
}

/* Equal to the plans of a planner that has just got the same frames. */
static void same_as_made(rig_t *r, const char *title)
{
    static ect_plan_table_t made_table;
    static ect_planner_t made;
    made = (ect_planner_t){.table = &made_table};
    memset(&made_table, 0, sizeof made_table);
    for (unsigned int i = 0; i < ECT_PLANS; i++) {
        if (r->planner.samples[i].length > 0)
            ect_planner_see(&made, r->planner.samples[i].frame, r->planner.samples[i].length);
    }
    (void)ect_planner_make(&made, r->w.chain);
    for (unsigned int i = 0; i < ECT_PLANS; i++) {
        const ect_plan_t *a = &table.plans[i], *b = &made_table.plans[i];
        if (a->step_count != b->step_count || memcmp(a->steps, b->steps, a->step_count * sizeof a->steps[0]) != 0)
            fail_msg("%s: other steps", title);
        for (unsigned int k = 0; k < a->step_count; k++) {
            const ect_plan_step_t *s = &a->steps[k];
            if (s->kind == ECT_PLAN_DO_COPY && memcmp(a->image + s->value, b->image + s->value, s->length) != 0)
                fail_msg("%s: another image", title);
        }
    }
}

/* The image of a slave that has run is in its plan before the plan is renewed. The other slave's image is copied then,
 * as are all images of a plan that is made again. */
static void image_of_a_run(void **state)
{
    enum { FIRST_IMAGE = 0, SECOND_IMAGE = 3 };
    static const uint8_t first[3] = {0x11, 0x22, 0x33}, second[3] = {0x44, 0x55, 0x66};
    ect_plan_place_t places[SLAVES] = {{0}};
    static const struct {
        void (*change)(rig_t *r);
        bool renewed;
    } rows[] = {{no_change, true}, {status_is_another, false}, {second_is_cut_off, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static rig_t r;
        open_rig(&r);
        r.planner.places = places;
        build_cyclic(&r);
        assert_true(gets_plan(&r));
        const ect_plan_t *plan = ect_plan_find(&table, r.w.frame);
        ect_planner_void(&r.planner);
        (void)ect_esc_pdi_write(ect_chain_esc(r.w.chain, 0), INPUTS, first, sizeof first);
        (void)ect_esc_pdi_write(ect_chain_esc(r.w.chain, 1), INPUTS, second, sizeof second);
        ect_planner_ran(&r.planner, 0);
        assert_memory_equal(plan->image + FIRST_IMAGE, first, sizeof first);
        assert_memory_not_equal(plan->image + SECOND_IMAGE, second, sizeof second);
        rows[i].change(&r);
        const uint64_t before = r.planner.renewed;
        assert_int_equal(ect_planner_make(&r.planner, r.w.chain), 1);
        assert_int_equal(r.planner.renewed > before, rows[i].renewed);
        same_as_made(&r, "after a run");
        ect_planner_void(&r.planner);
        (void)ect_esc_pdi_write(ect_chain_esc(r.w.chain, 0), INPUTS, second, sizeof second);
        assert_int_equal(ect_planner_make(&r.planner, r.w.chain), 1); /* copied without a further run */
        same_as_made(&r, "without a run");
        r.planner.places = NULL;
        wire_close(&r.w);
    }
}

static void no_plan(void **state)
{
    static const struct {
        const char *title;
        void (*frame)(rig_t *r);
        void (*change)(rig_t *r);
        bool plan;
    } rows[] = {
        {"process data, AL status, system time", build_cyclic, no_change, true},
        {"a mailbox", a_mailbox, no_change, false},
        {"another register", a_register, no_change, false},
        {"AL status and its code", long_status, no_change, false},
        {"a part of an image", half_an_image, no_change, false},
        {"a datagram without data", nothing_in_it, no_change, false},
        {"the time of no slave", no_clock, no_change, false},
        {"three bytes of the time", three_bytes_of_time, no_change, false},
        {"four bytes of the time", four_bytes_of_time, no_change, true},
        {"eight bytes of the time", all_bytes_of_time, no_change, true},
        {"nine bytes from the time on", more_than_time, no_change, false},
        {"the times of two clocks", two_clocks, no_change, false},
        {"more datagrams than steps", too_many, no_change, false},
        {"more counters than steps", many_counters, no_change, false},
        {"a tag", a_tag, no_change, false},
        {"a frame longer than Ethernet's", too_long, no_change, false},
        {"an FMMU maps other bytes", build_cyclic, fmmu_moves, false},
        {"an FMMU maps bits", build_cyclic, fmmu_of_bits, false},
        {"an FMMU reads outputs", build_cyclic, fmmu_reads_outputs, false},
        {"outputs and inputs have the same logical addresses", build_cyclic, fmmus_share_addresses, true},
        {"an FMMU of inputs maps bits, and the frame writes", write_to_inputs, fmmu_of_bits, true},
        {"an FMMU of outputs maps bits, and the frame reads", read_of_outputs, output_fmmu_of_bits, true},
        {"an FMMU that is not active maps bits", build_cyclic, inactive_fmmu_of_bits, true},
        {"two FMMUs of inputs have the same logical addresses", build_cyclic, two_more_fmmus, false},
        {"one of them is not active, a third one has others", build_cyclic, one_of_two_more_fmmus, true},
        {"a SyncManager is off", build_cyclic, sm_is_off, false},
        {"a SyncManager has no image yet", build_cyclic, sm_restarts, false},
        {"a SyncManager has ECAT events", build_cyclic, sm_has_events, false},
        {"buffers of two SyncManagers overlap", build_cyclic, sm_reaches_into_another, false},
        {"buffers end before those of another", build_cyclic, outputs_before_inputs, true},
        {"buffers end with the first byte of another", build_cyclic, outputs_reach_inputs, false},
        {"buffers begin behind those of another", build_cyclic, outputs_behind_inputs, true},
        {"buffers begin with the last byte of another", build_cyclic, inputs_reach_outputs, false},
        {"buffers end with the memory", build_cyclic, outputs_end_with_the_memory, true},
        {"buffers end behind the memory", build_cyclic, outputs_end_behind_the_memory, false},
        {"outputs of two bytes", build_cyclic, outputs_of_two_bytes, true},
        {"outputs of one byte", build_cyclic, outputs_of_one_byte, false},
        {"outputs in a mailbox", build_cyclic, outputs_by_mailbox, false},
        {"outputs in a SyncManager of inputs", build_cyclic, outputs_are_inputs, false},
        {"a mailbox begins behind the other one", build_cyclic, mailboxes_adjoin, true},
        {"a mailbox ends before the other one", build_cyclic, mailboxes_adjoin_in_turn, true},
        {"a mailbox begins with the last byte of the other one", build_cyclic, mailboxes_share_a_byte, false},
        {"a mailbox ends with the first byte of the other one", build_cyclic, mailboxes_share_a_byte_in_turn, false},
        {"the slave has locked a SyncManager", build_cyclic, sm_is_locked, false},
        {"an AL status is new", build_cyclic, status_is_new, false},
        {"the reference clock is fast", build_cyclic, clock_is_trimmed, false},
        {"the address of the clock occurs twice", build_cyclic, address_is_taken, false},
        {"the second slave is cut off", build_cyclic, second_is_cut_off, true},
        {"FMMUs overlap", build_cyclic, windows_overlap, false},
        {"no cable is plugged in", build_cyclic, cable_is_out, false},
        {"frames leave at the other end", build_cyclic, goes_through, false},
        {"a loop is closed for a second", build_cyclic, loop_for_a_second, false},
        {"the watchdog of the PDI runs", build_cyclic, pdi_is_watched, false},
        {"writes are protected", build_cyclic, writes_are_protected, false},
        {"a fault waits for the next frame", build_cyclic, a_fault_waits, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static rig_t r;
        open_rig(&r);
        rows[i].change(&r);
        rows[i].frame(&r);
        bool got = gets_plan(&r);
        if (got != rows[i].plan)
            fail_msg("%s: expected %s", rows[i].title, rows[i].plan ? "a plan" : "none");
        wire_close(&r.w);
    }
}

/* A change between two sleeps: plans that are renewed, or made again, equal plans that are made. */
static void renewed_plans(void **state)
{
    static const struct {
        const char *title;
        void (*change)(rig_t *r);
        bool plan, renewed;
        void (*frame)(rig_t *r); /* NULL: process data, AL status, system time */
    } rows[] = {
        {"nothing", no_change, true, true, NULL},
        {"other inputs", new_inputs, true, true, NULL},
        {"an offset of the clock", clock_is_set, true, true, NULL},
        {"an FMMU maps other bytes", fmmu_moves, false, false, NULL},
        {"an FMMU is of other addresses", fmmus_share_addresses, true, false, NULL},
        {"a SyncManager is off", sm_is_off, false, false, NULL},
        {"a SyncManager has restarted with other flags", sm_has_events, false, false, NULL},
        {"a SyncManager has no image yet", sm_restarts, false, false, NULL},
        {"a SyncManager has its first image again", sm_restarts_and_runs, true, false, NULL},
        {"the slave has locked a SyncManager", sm_is_locked, false, false, NULL},
        {"an AL status is new", status_is_new, false, false, NULL},
        {"an AL status is another", status_is_another, true, false, NULL},
        {"the reference clock is fast", clock_is_trimmed, false, false, NULL},
        {"the address of the clock occurs twice", address_is_taken, false, false, NULL},
        {"the clock has another address", address_is_gone, false, false, NULL},
        {"the second slave is cut off", second_is_cut_off, true, false, NULL},
        {"writes are protected", writes_are_protected, false, false, NULL},
        {"an access of the PDI has failed", pdi_access_fails, true, true, NULL},
        {"an event will be lost", event_is_lost, true, true, NULL},
        {"an EEPROM is busy", eeprom_is_busy, true, true, NULL},
        {"a slave has lost its power for a moment", slave_restarts, false, false, NULL},
        {"nothing, with outputs alone", no_change, true, true, outputs_of_one},
        {"another slave has other inputs", new_inputs, true, true, outputs_of_one},
        {"the slave has locked a SyncManager of outputs alone", sm_is_locked, false, false, outputs_of_one},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static rig_t r;
        open_rig(&r);
        (rows[i].frame ? rows[i].frame : build_cyclic)(&r);
        assert_true(gets_plan(&r));
        ect_planner_void(&r.planner);
        rows[i].change(&r);
        const uint64_t before = r.planner.renewed;
        bool got = ect_planner_make(&r.planner, r.w.chain) == 1;
        if (got != rows[i].plan || (r.planner.renewed > before) != rows[i].renewed)
            fail_msg("%s: expected %s, %s", rows[i].title, rows[i].plan ? "a plan" : "none",
                     rows[i].renewed ? "renewed" : "made");
        same_as_made(&r, rows[i].title);
        const uint64_t first = r.planner.renewed;
        (void)ect_planner_make(&r.planner, r.w.chain);
        if ((r.planner.renewed > first) != rows[i].plan)
            fail_msg("%s: expected that a plan without a further change is renewed", rows[i].title);
        same_as_made(&r, rows[i].title);
        wire_close(&r.w);
    }
}

/* A plan for each layout, as with a thousand twins, at addresses of equal distance. */
static void many_layouts(void **state)
{
    enum { LAYOUTS = 46, APART = 1486 };
    const uint8_t data[6] = {0};
    static rig_t r;
    (void)state;
    open_rig(&r);
    for (unsigned int i = 0; i < LAYOUTS; i++) {
        wire_build(&r.w, LRW, (uint16_t)(i * APART + 0x1000), (uint16_t)((i * APART + 0x1000) >> 16), data,
                   sizeof data);
        ect_planner_see(&r.planner, r.w.frame, r.w.frame_length);
    }
    assert_int_equal(ect_planner_make(&r.planner, r.w.chain), LAYOUTS);
    assert_int_equal(ect_planner_make(&r.planner, r.w.chain), LAYOUTS);
    assert_int_equal(r.planner.made, LAYOUTS);
    assert_int_equal(r.planner.renewed, LAYOUTS);
    for (unsigned int i = 0; i < 3 * ECT_PLANS; i++) { /* more than there are places */
        wire_build(&r.w, LRW, (uint16_t)(i * APART), (uint16_t)((i * APART) >> 16), data, sizeof data);
        ect_planner_see(&r.planner, r.w.frame, r.w.frame_length);
    }
    assert_in_range(ect_planner_make(&r.planner, r.w.chain), ECT_PLANS / 2, ECT_PLANS);
    assert_true(ect_plan_reply(&table, r.w.frame, r.w.frame_length, r.w.now_ns));
    wire_close(&r.w);
}

/* Layouts with the last first place of all: the search goes on at place 0. Beyond ECT_PLAN_PROBES of them, a new layout
 * replaces the one in the first place. */
static void layouts_with_one_place(void **state)
{
    enum { LAYOUTS = ECT_PLAN_PROBES + 1 };
    static uint8_t frames[LAYOUTS][64];
    static rig_t r;
    unsigned int count = 0;
    (void)state;
    open_rig(&r);
    for (unsigned int address = 0x10000; count < LAYOUTS; address++) {
        wire_build(&r.w, LRW, (uint16_t)address, (uint16_t)(address >> 16), zeros, 6);
        if (ect_plan_place(ect_plan_key(r.w.frame)) == ECT_PLANS - 1)
            memcpy(frames[count++], r.w.frame, r.w.frame_length);
    }
    for (unsigned int n = 0; n < LAYOUTS; n++) {
        const unsigned int plans = n < ECT_PLAN_PROBES ? n + 1 : ECT_PLAN_PROBES;
        ect_planner_see(&r.planner, frames[n], r.w.frame_length);
        assert_int_equal(ect_planner_make(&r.planner, r.w.chain), plans);
        const ect_plan_t *plan = ect_plan_find(&table, frames[n]);
        assert_ptr_equal(plan, &table.plans[(ECT_PLANS - 1 + n % ECT_PLAN_PROBES) % ECT_PLANS]);
        for (unsigned int k = 0; k < n; k++)
            assert_int_equal(ect_plan_find(&table, frames[k]) != NULL, k > 0 || n < ECT_PLAN_PROBES);
    }
    wire_close(&r.w);
}

/* The key of a plan covers the first datagram only. */
static void frames_without_a_plan_that_have_its_key(void **state)
{
    static const struct {
        const char *title;
        uint8_t command;
        uint16_t ado;
        bool none; /* the plan remains that of the first frame */
    } rows[] = {
        {"a register of one slave", FPRD, ECT_REG_AL_STATUS, true},
        {"another register of all", BRD, ECT_REG_DL_STATUS, true},
        {"another register of the clock, to all", FRMW, ECT_REG_DC_OFFSET, true},
        {"a register that all write", BWR, ECT_REG_AL_CONTROL, true},
        {"AL status", BRD, ECT_REG_AL_STATUS, false},
        {"the system time", FRMW, ECT_REG_DC_SYSTEM_TIME, false},
        {"the system time by position", ARMW, ECT_REG_DC_SYSTEM_TIME, false},
        {"no operation", NOP, 0, false},
        {"a read of logical addresses", LRD, 0, false},
        {"a write to logical addresses", LWR, 0, false},
    };
    static rig_t r;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t first[200];
        open_rig(&r);
        build_cyclic(&r);
        assert_true(gets_plan(&r));
        const size_t length = r.w.frame_length;
        memcpy(first, r.w.frame, length);
        wire_build(&r.w, LRW, 0x100, 0, zeros, 6 * SLAVES);
        wire_append(&r.w, rows[i].command, 0, rows[i].ado, zeros, 8);
        ect_planner_see(&r.planner, r.w.frame, r.w.frame_length);
        (void)ect_planner_make(&r.planner, r.w.chain);
        if (ect_plan_reply(&table, first, length, r.w.now_ns) != rows[i].none)
            fail_msg("%s: expected that it %s the plan", rows[i].title, rows[i].none ? "leaves" : "replaces");
        wire_close(&r.w);
    }
}

/* The layout before, with the same key, had the time of a clock. */
static void no_clock_is_left_over(void **state)
{
    static rig_t r;
    (void)state;
    open_rig(&r);
    build_cyclic(&r);
    assert_true(gets_plan(&r));
    wire_build(&r.w, LRW, 0x100, 0, zeros, 6 * SLAVES);
    wire_append(&r.w, BRD, 0, ECT_REG_AL_STATUS, zeros, 2);
    ect_planner_see(&r.planner, r.w.frame, r.w.frame_length);
    assert_int_equal(ect_planner_make(&r.planner, r.w.chain), 1);
    clock_is_trimmed(&r);
    const uint64_t renewed = r.planner.renewed;
    assert_int_equal(ect_planner_make(&r.planner, r.w.chain), 1);
    assert_int_equal(r.planner.renewed, renewed + 1);
    wire_close(&r.w);
}

/* A plan refers to at most ECT_PLAN_BASES ESCs; with more it is not renewed. */
static void plans_of_many(void **state)
{
    enum { MOST = ECT_PLAN_BASES + 1 };
    static ect_twin_config_t twins[MOST];
    static rig_t r;
    (void)state;
    for (unsigned int n = 0; n < MOST; n++)
        twins[n] = ect_twin_default(&testdev, NULL);
    memset(&r, 0, sizeof r);
    memset(&table, 0, sizeof table);
    wire_open_twins(&r.w, twins, MOST);
    for (size_t i = 0; i < MOST; i++) {
        wire_go(&r.w, i, 8);
        wire_set_fmmu(&r.w, i, FMMU_OUT, (uint32_t)(0x100 + 3 * i), 3, 0, 7, OUTPUTS, 0, 2);
    }
    r.planner.table = &table;
    r.w.manual_poll = true;
    for (unsigned int count = MOST - 2; count <= MOST; count++) {
        static const uint8_t outputs[3 * MOST];
        wire_build(&r.w, LWR, 0x100, 0, outputs, (uint16_t)(3 * count));
        assert_true(gets_plan(&r));
        const uint64_t made = r.planner.made, renewed = r.planner.renewed;
        assert_int_equal(ect_planner_make(&r.planner, r.w.chain), 1);
        assert_int_equal(r.planner.renewed - renewed, count <= ECT_PLAN_BASES);
        assert_int_equal(r.planner.made - made, count > ECT_PLAN_BASES);
        same_as_made(&r, "many slaves");
    }
    wire_close(&r.w);
}

/* A frame gets a reply only if it has the layout of the plan. */
static void other_layouts(void **state)
{
    static const struct {
        const char *title;
        unsigned int at;
        bool same;
    } rows[] = {{"destination", 0, true},    {"EtherType", 12, false},     {"kind of EtherCAT frame", 15, false},
                {"command", 16, false},      {"index", 17, true},          {"address", 18, false},
                {"high address", 20, false}, {"length", 22, false},        {"ECAT events", 24, true},
                {"data", 26, true},          {"second command", 40, false}};
    static rig_t r;
    (void)state;
    open_rig(&r);
    build_cyclic(&r);
    assert_true(gets_plan(&r));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[200];
        memcpy(frame, r.w.frame, r.w.frame_length);
        frame[rows[i].at] ^= 0x20;
        if (ect_plan_reply(&table, frame, r.w.frame_length, r.w.now_ns) != rows[i].same)
            fail_msg("another %s: expected %s", rows[i].title, rows[i].same ? "a reply" : "none");
    }
    uint8_t frame[200];
    memcpy(frame, r.w.frame, r.w.frame_length);
    assert_false(ect_plan_reply(&table, frame, r.w.frame_length - 1, r.w.now_ns));
    assert_false(ect_plan_reply(&table, frame, ECT_PLAN_HEAD - 1, r.w.now_ns));
    assert_memory_equal(frame, r.w.frame, r.w.frame_length);
    wire_close(&r.w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"FZM-075: frames closer than those of any cycle, while outputs change", pace, NULL, NULL, NULL},
        {"FZM-075: outputs that differ from those of the frame before count as changed, no other bytes",
         changed_outputs, NULL, NULL, NULL},
        {"CF-002: a plan gives the replies of the chain, which gets the frames later", replies_ahead_of_the_chain, NULL,
         NULL, NULL},
        {"CF-002: a frame that has its reply takes effect without images, unless outputs are inputs of another slave",
         frames_with_a_reply, NULL, NULL, NULL},
        {"frames and changes of a chain without a plan", no_plan, NULL, NULL, NULL},
        {"the image of a slave that has run is copied into its plan at once", image_of_a_run, NULL, NULL, NULL},
        {"plans that are renewed after a change equal plans that are made", renewed_plans, NULL, NULL, NULL},
        {"a thousand twins: a plan for each of 46 layouts, and new layouts when places are short", many_layouts, NULL,
         NULL, NULL},
        {"16 layouts have plans in successive places, and a further one replaces the first", layouts_with_one_place,
         NULL, NULL, NULL},
        {"a frame that may not have a plan leaves the plan with the same key", frames_without_a_plan_that_have_its_key,
         NULL, NULL, NULL},
        {"a plan without a time is renewed whatever the clock of an earlier layout does", no_clock_is_left_over, NULL,
         NULL, NULL},
        {"a plan of at most 128 ESCs is renewed", plans_of_many, NULL, NULL, NULL},
        {"a plan replies to frames of its layout only", other_layouts, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("plans", tests, NULL, NULL);
}
