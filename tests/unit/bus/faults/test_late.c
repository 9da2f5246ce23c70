/* SPDX-License-Identifier: MIT */
/* Frames that are sent late (src/bus/faults/late.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "bus/faults/late.h"

#define MS 1000000ull

static void assert_leaves(ect_late_t *late, uint64_t due_ns, uint8_t content)
{
    assert_true(ect_late_due(late) == due_ns);
    assert_null(ect_late_take(late, due_ns - 1));
    ect_late_frame_t *frame = ect_late_take(late, due_ns);
    assert_non_null(frame);
    assert_int_equal(frame->length, 60u + content);
    assert_int_equal(frame->frame[0], content);
    free(frame);
}

static void late_answers(void **state)
{
    /* When each is added, how late it is to be, and when it leaves: its own time, or when those before it have left. */
    static const struct {
        uint64_t came_ns, late_ns, leaves_ns;
    } frames[] = {
        {0, 3 * MS, 3 * MS},      {1 * MS, 3 * MS, 4 * MS}, {2 * MS, 0, 4 * MS},
        {2 * MS, 3 * MS, 5 * MS}, {9 * MS, 0, 9 * MS},
    };
    enum { COUNT = sizeof frames / sizeof frames[0] };
    ect_late_t late = {0};
    uint8_t content[128] = {0};
    (void)state;
    assert_true(ect_late_due(&late) == UINT64_MAX);
    for (uint8_t i = 0; i < COUNT; i++) {
        content[0] = i;
        assert_true(ect_late_add(&late, content, 60u + i, frames[i].came_ns + frames[i].late_ns));
    }
    for (uint8_t i = 0; i < COUNT; i++)
        assert_leaves(&late, frames[i].leaves_ns, i);
    assert_true(ect_late_due(&late) == UINT64_MAX);
    assert_null(ect_late_take(&late, UINT64_MAX));
    content[0] = 7; /* a frame that has left delays no other */
    assert_true(ect_late_add(&late, content, 67, 1 * MS));
    assert_leaves(&late, 1 * MS, 7);
}

static void most_late_answers(void **state)
{
    ect_late_t late = {0};
    (void)state;
    for (unsigned int i = 0; i < ECT_LATE_MOST; i++)
        assert_true(ect_late_add(&late, (const uint8_t *)"x", 1, 5));
    assert_false(ect_late_add(&late, (const uint8_t *)"x", 1, 5));
    ect_late_clear(&late);
    assert_true(ect_late_due(&late) == UINT64_MAX);
    assert_true(ect_late_add(&late, (const uint8_t *)"x", 1, 5));
    ect_late_clear(&late);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"each late reply is sent at its own time, and none overtakes another", late_answers, NULL, NULL, NULL},
        {"late replies beyond the limit are lost", most_late_answers, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Late frames", tests, NULL, NULL);
}
