/* SPDX-License-Identifier: MIT */
/* Deadlines (deadlines.h): the earliest of many, for any values in any order. */
#include "bus/chain/deadlines.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "seams/random.h"

enum { MEMBERS = 37, STEPS = 20000 };

static void no_deadline(void **state)
{
    size_t member = 99;
    (void)state;
    ect_deadlines_t *d = ect_deadlines_new(1);
    assert_non_null(d);
    assert_true(ect_deadlines_first(d, &member) == UINT64_MAX);
    assert_int_equal(member, 0);
    ect_deadlines_set(d, 0, 5);
    assert_true(ect_deadlines_of(d, 0) == 5);
    assert_true(ect_deadlines_first(d, &member) == 5);
    ect_deadlines_free(d);
    ect_deadlines_free(NULL);
}

/* Few different times, so that many are equal; now and then never. */
static void same_as_a_search(void **state)
{
    uint64_t times[MEMBERS];
    uint32_t seed = 1;
    (void)state;
    ect_deadlines_t *d = ect_deadlines_new(MEMBERS);
    assert_non_null(d);
    for (size_t i = 0; i < MEMBERS; i++)
        times[i] = UINT64_MAX;
    for (unsigned int step = 0; step < STEPS; step++) {
        size_t member = ect_random_next(&seed) % MEMBERS;
        uint32_t deadline = ect_random_next(&seed) % 64;
        uint64_t want = UINT64_MAX;
        times[member] = deadline == 0 ? UINT64_MAX : deadline;
        ect_deadlines_set(d, member, times[member]);
        for (size_t i = 0; i < MEMBERS; i++)
            want = times[i] < want ? times[i] : want;
        uint64_t first = ect_deadlines_first(d, &member);
        if (first != want || times[member] != want || ect_deadlines_of(d, member) != want)
            fail_msg("step %u: first %llu of member %zu, expected %llu", step, (unsigned long long)first, member,
                     (unsigned long long)want);
    }
    ect_deadlines_free(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"one member, none wants to run", no_deadline, NULL, NULL, NULL},
        {"the first of many equals the result of a search, after each of 20000 changes", same_as_a_search, NULL, NULL,
         NULL},
    };
    return cmocka_run_group_tests_name("deadlines", tests, NULL, NULL);
}
