/* SPDX-License-Identifier: MIT */
/* A chain with two ends, and cut wires: the paths of frames, the ESCs that process them, the state of the ports
 * (chain.h). */
#include <stdio.h>
#include <string.h>

#include "support/testdev.h"
#include "support/wire.h"

enum { COUNT = 4, DL_STATUS_PORTS = 0x0111, DL_CONTROL_PORTS = 0x0101, LENGTH_HIGH = 16 + 7, CIRCULATING = 0x40 };

static void open_ring(wire_t *w)
{
    const ect_device_t *devices[COUNT] = {&testdev, &testdev, &testdev, &testdev};
    wire_open(w, devices, COUNT);
    ect_chain_set_link(w->chain, ECT_END_OUT, true);
}

/* A plug of a slave, by the signal that a user sets. */
static void plug(wire_t *w, size_t position, const char *name, uint8_t in)
{
    ect_signal_ref_t ref;
    assert_true(ect_chain_signal(w->chain, position, name, &ref));
    *ref.value = in;
    ect_chain_wake(w->chain, position);
    (void)ect_chain_poll(w->chain, w->now_ns);
}

/* A broadcast read: its working counter is the number of slaves that have processed it. */
static ect_end_t broadcast(wire_t *w, ect_end_t in)
{
    wire_build(w, BRD, 0, 0x0000, "", 1);
    return ect_chain_pass(w->chain, in, w->frame, w->frame_length, w->now_ns);
}

static void ways_of_frames(void **state)
{
    /* Wire n is in front of slave n (from 0): 0 is the master's first cable, 4 its second. -1: all are whole. */
    static const struct {
        int cut[2];
        struct {
            ect_end_t out;
            int processed;
            bool circulating;
        } from[ECT_ENDS];
    } cases[] = {
        {{-1, -1}, {{ECT_END_OUT, 4, false}, {ECT_END_IN, 0, false}}},
        {{0, -1}, {{ECT_END_NONE, 0, false}, {ECT_END_OUT, 4, true}}},
        {{1, -1}, {{ECT_END_IN, 1, false}, {ECT_END_OUT, 3, true}}},
        {{2, -1}, {{ECT_END_IN, 2, false}, {ECT_END_OUT, 2, true}}},
        {{3, -1}, {{ECT_END_IN, 3, false}, {ECT_END_OUT, 1, true}}},
        {{4, -1}, {{ECT_END_IN, 4, false}, {ECT_END_NONE, 0, false}}},
        {{1, 3}, {{ECT_END_IN, 1, false}, {ECT_END_OUT, 1, true}}},
        {{0, 4}, {{ECT_END_NONE, 0, false}, {ECT_END_NONE, 0, false}}},
    };
    (void)state;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        wire_t w;
        open_ring(&w);
        for (size_t n = 0; n < 2; n++) {
            int wire = cases[c].cut[n];
            if (wire >= 0)
                plug(&w, wire < COUNT ? (size_t)wire : COUNT - 1, wire < COUNT ? "ecat.plug_in" : "ecat.plug_out", 0);
        }
        for (unsigned int in = 0; in < ECT_ENDS; in++) {
            ect_end_t out = broadcast(&w, in);
            int processed = wire_wkc(&w, 0);
            bool circulating = (w.frame[LENGTH_HIGH] & CIRCULATING) != 0;
            if (out != cases[c].from[in].out || processed != cases[c].from[in].processed ||
                circulating != cases[c].from[in].circulating)
                fail_msg("wires %d and %d cut, from end %u: expected end %d, %d slaves, mark %d, got %d, %d, %d",
                         cases[c].cut[0], cases[c].cut[1], in, cases[c].from[in].out, cases[c].from[in].processed,
                         cases[c].from[in].circulating, out, processed, circulating);
        }
        wire_close(&w);
    }
}

static void either_plug(void **state)
{
    wire_t w;
    (void)state;
    open_ring(&w);
    for (int side = 0; side < 2; side++) {
        size_t position = side == 0 ? 1 : 2;
        const char *name = side == 0 ? "ecat.plug_out" : "ecat.plug_in";
        plug(&w, position, name, 0);
        assert_int_equal(ect_chain_esc(w.chain, 1)->memory[DL_STATUS_PORTS], 0x56);
        assert_int_equal(ect_chain_esc(w.chain, 2)->memory[DL_STATUS_PORTS], 0x59);
        assert_int_equal(broadcast(&w, ECT_END_IN), ECT_END_IN);
        assert_int_equal(wire_wkc(&w, 0), 2);
        plug(&w, position, name, 1);
        assert_int_equal(ect_chain_esc(w.chain, 1)->memory[DL_STATUS_PORTS], 0x5A);
        assert_int_equal(ect_chain_esc(w.chain, 2)->memory[DL_STATUS_PORTS], 0x5A);
        assert_int_equal(broadcast(&w, ECT_END_IN), ECT_END_OUT);
        assert_int_equal(wire_wkc(&w, 0), 4);
    }
    wire_close(&w);
}

/* A chain whose wire is reconnected replies like a chain that was never cut, and a cut chain stays cut. */
static void over_a_power_cycle(void **state)
{
    wire_t w;
    (void)state;
    open_ring(&w);
    plug(&w, 2, "ecat.plug_in", 0);
    ect_chain_power_cycle(w.chain, w.now_ns);
    assert_int_equal(broadcast(&w, ECT_END_OUT), ECT_END_OUT);
    assert_int_equal(wire_wkc(&w, 0), 2);
    assert_int_equal(ect_chain_esc(w.chain, 2)->memory[DL_STATUS_PORTS], 0x59);
    wire_close(&w);
}

static uint32_t receive_time(wire_t *w, size_t position, unsigned int port)
{
    return ect_load_le32(ect_chain_esc(w->chain, position)->memory + ECT_REG_DC_RECEIVE_TIME + 4 * port);
}

/* From the far end to the cut, where the frame turns and passes the processing unit, and back through the others. */
static void times_from_the_far_end(void **state)
{
    enum { CUT = 1, WIRE_NS = 405 };
    const ect_esc_personality_t *chip = ect_esc_personality("et1100");
    const uint8_t any[4] = {0};
    wire_t w;
    (void)state;
    open_ring(&w);
    plug(&w, CUT, "ecat.plug_in", 0);
    wire_build(&w, BWR, 0, ECT_REG_DC_RECEIVE_TIME, any, sizeof any);
    assert_int_equal(ect_chain_pass(w.chain, ECT_END_OUT, w.frame, w.frame_length, w.now_ns), ECT_END_OUT);
    assert_int_equal(wire_wkc(&w, 0), COUNT - CUT);
    for (size_t i = COUNT - 1; i > CUT; i--)
        assert_int_equal(receive_time(&w, i - 1, 1) - receive_time(&w, i, 1), chip->forwarding_ns + WIRE_NS);
    assert_int_equal(receive_time(&w, CUT + 1, 0) - receive_time(&w, CUT, 1),
                     chip->forwarding_ns + chip->processing_ns + WIRE_NS);
    for (size_t i = CUT + 1; i + 1 < COUNT; i++)
        assert_int_equal(receive_time(&w, i + 1, 0) - receive_time(&w, i, 0), chip->processing_ns + WIRE_NS);
    wire_close(&w);
}

static void second_time(void **state)
{
    wire_t w;
    (void)state;
    open_ring(&w);
    plug(&w, 2, "ecat.plug_in", 0);
    wire_build(&w, BRD, 0, 0x0000, "", 1);
    w.frame[LENGTH_HIGH] |= CIRCULATING;
    assert_int_equal(ect_chain_pass(w.chain, ECT_END_OUT, w.frame, w.frame_length, w.now_ns), ECT_END_NONE);
    assert_int_equal(wire_wkc(&w, 0), 0);
    /* Slaves with link at port 0 ignore the mark. */
    wire_build(&w, BRD, 0, 0x0000, "", 1);
    w.frame[LENGTH_HIGH] |= CIRCULATING;
    assert_int_equal(ect_chain_pass(w.chain, ECT_END_IN, w.frame, w.frame_length, w.now_ns), ECT_END_IN);
    assert_int_equal(wire_wkc(&w, 0), 2);
    wire_close(&w);
}

static void every_datagram_is_marked(void **state)
{
    wire_t w;
    (void)state;
    open_ring(&w);
    plug(&w, 3, "ecat.plug_in", 0);
    wire_build(&w, BRD, 0, 0x0000, "", 1);
    wire_append(&w, BRD, 0, 0x0000, "ab", 2);
    wire_append(&w, NOP, 0, 0x0000, "abc", 3);
    assert_int_equal(ect_chain_pass(w.chain, ECT_END_OUT, w.frame, w.frame_length, w.now_ns), ECT_END_OUT);
    for (unsigned int n = 0; n < 3; n++) {
        assert_int_equal(wire_datagram(&w, n)[7] & CIRCULATING, CIRCULATING);
        assert_int_equal(wire_wkc(&w, n), n < 2 ? 1 : 0);
    }
    wire_close(&w);
}

/* A loop changes after the frame has left: the frame that closes the last exit is the last to return. */
static void frame_leaves_before_the_loop_closes(void **state)
{
    const uint8_t closed = 0x0C; /* loop of port 1 */
    wire_t w;
    (void)state;
    open_ring(&w);
    plug(&w, 3, "ecat.plug_in", 0);
    wire_build(&w, BWR, 0, DL_CONTROL_PORTS, &closed, 1);
    assert_int_equal(ect_chain_pass(w.chain, ECT_END_OUT, w.frame, w.frame_length, w.now_ns), ECT_END_OUT);
    assert_int_equal(wire_wkc(&w, 0), 1);
    assert_int_equal(broadcast(&w, ECT_END_OUT), ECT_END_NONE);
    assert_int_equal(wire_wkc(&w, 0), 0);
    wire_close(&w);
}

/* Closed by the master, the loop of port 1 also blocks frames from behind. */
static void loop_closed_by_the_master(void **state)
{
    const uint8_t closed = 0x0C;
    wire_t w;
    (void)state;
    open_ring(&w);
    wire_build(&w, APWR, 0xFFFF, DL_CONTROL_PORTS, &closed, 1);
    (void)ect_chain_pass(w.chain, ECT_END_IN, w.frame, w.frame_length, w.now_ns);
    assert_int_equal(broadcast(&w, ECT_END_IN), ECT_END_IN);
    assert_int_equal(wire_wkc(&w, 0), 2);
    assert_int_equal(broadcast(&w, ECT_END_OUT), ECT_END_NONE);
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-010: frames from both ends, with every wire whole and cut: the ESCs that process them, and their exits",
         ways_of_frames, NULL, NULL, NULL},
        {"CF-010: the plug at either end of a wire cuts it, both slaves show this, and the wire can be restored",
         either_plug, NULL, NULL, NULL},
        {"CF-010: a cut outlasts a power cycle", over_a_power_cycle, NULL, NULL, NULL},
        {"CF-087 CF-096: receive times of a frame from the far end, which turns at a cut", times_from_the_far_end, NULL,
         NULL, NULL},
        {"CF-010: a circulating frame is destroyed where port 0 has no link, and nowhere else", second_time, NULL, NULL,
         NULL},
        {"CF-010: each datagram is marked as circulating", every_datagram_is_marked, NULL, NULL, NULL},
        {"CF-010: a frame that closes the last exit leaves before the exit closes", frame_leaves_before_the_loop_closes,
         NULL, NULL, NULL},
        {"CF-010: a loop that the master closed blocks frames from behind", loop_closed_by_the_master, NULL, NULL,
         NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Ring", tests, NULL, NULL);
}
