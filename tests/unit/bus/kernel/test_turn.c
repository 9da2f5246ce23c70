/* SPDX-License-Identifier: MIT */
/* The turn between the kernel and the program: no frame overtakes another one, and none is lost, in any order of their
 * steps. Two threads take the places of both. */
#include "bus/kernel/turn.h"

#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { FRAMES = 20000, HELD = 8, NO_PLAN = 13 };

/* The socket is a list in which a frame appears some time after the kernel has left it. */
typedef struct rig {
    ect_turn_t turn;
    unsigned int held_count; /* no atomic: it has one owner at a time */
    unsigned int held[HELD];
    unsigned int socket[FRAMES];
    unsigned int arrived; /* frames in the socket, atomic */
    unsigned int got;     /* by the program */
    unsigned int expected;
    unsigned int replied; /* frames that were held */
} rig_t;

static rig_t rig;

static void *kernel(void *unused)
{
    (void)unused;
    for (unsigned int frame = 0; frame < FRAMES; frame++) {
        bool begun = ect_turn_begin(&rig.turn);
        bool left = !begun || rig.held_count == HELD || frame % NO_PLAN == 0;
        if (begun && !left)
            rig.held[rig.held_count++] = frame;
        if (begun)
            ect_turn_end(&rig.turn, left);
        if (left) {
            sched_yield();
            rig.socket[rig.arrived] = frame;
            __sync_fetch_and_add(&rig.arrived, 1);
        }
    }
    return NULL;
}

static void expect(unsigned int frame)
{
    assert_int_equal(frame, rig.expected);
    rig.expected++;
}

static void *program(void *unused)
{
    (void)unused;
    ect_turn_take(&rig.turn);
    while (rig.expected < FRAMES) {
        if (ect_turn_give(&rig.turn, rig.got)) {
            sched_yield();
            ect_turn_take(&rig.turn);
        }
        for (unsigned int i = 0; i < rig.held_count; i++)
            expect(rig.held[i]);
        rig.replied += rig.held_count;
        rig.held_count = 0;
        while (rig.got < __sync_fetch_and_add(&rig.arrived, 0))
            expect(rig.socket[rig.got++]);
    }
    return NULL;
}

static void in_order(void **state)
{
    pthread_t other;
    (void)state;
    memset(&rig, 0, sizeof rig);
    rig.turn.word = ECT_TURN_PROGRAM;
    assert_int_equal(pthread_create(&other, NULL, kernel, NULL), 0);
    (void)program(NULL);
    assert_int_equal(pthread_join(other, NULL), 0);
    assert_int_equal(rig.expected, FRAMES);
    assert_int_equal(rig.replied + rig.got, FRAMES);
    assert_int_equal(ect_turn_left(&rig.turn), rig.got);
}

/* One step after the other, where a thread would be stopped. */
static void step_by_step(void **state)
{
    ect_turn_t turn = {0};
    (void)state;
    assert_true(ect_turn_begin(&turn));
    assert_false(ect_turn_begin(&turn)); /* another processor, at the same moment */
    ect_turn_end(&turn, false);
    assert_false(ect_turn_begin(&turn)); /* behind a frame on its way to the program */
    ect_turn_take(&turn);
    assert_int_equal(ect_turn_left(&turn), 2);
    assert_false(ect_turn_give(&turn, 1)); /* the second one is still on its way */
    assert_false(ect_turn_begin(&turn));
    assert_true(ect_turn_give(&turn, 3));
    assert_true(ect_turn_begin(&turn));
    ect_turn_end(&turn, true); /* there was no plan */
    assert_false(ect_turn_begin(&turn));
    ect_turn_take(&turn);
    ect_turn_take(&turn); /* no effect */
    assert_int_equal(ect_turn_left(&turn), 5);
    assert_true(ect_turn_give(&turn, 5));
    assert_true(ect_turn_begin(&turn));
    ect_turn_end(&turn, false);
    ect_turn_take(&turn);
    assert_false(ect_turn_begin(&turn));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"the turn, one step after the other", step_by_step, NULL, NULL, NULL},
        {"no frame overtakes another one, and none is lost", in_order, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("the turn", tests, NULL, NULL);
}
