/* SPDX-License-Identifier: MIT */
/* The clock of the boards without an operating system, from the counters of a processor. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "clock.h"

enum { WRAP = 1 << 24 };

static const uint32_t frequencies[] = {1000000,   8000000,   48000000,  64000000,   72000000,
                                       100000000, 144000000, 168000000, 180000000,  216000000,
                                       400000000, 480000000, 550000000, 1000000000, 1008000000};

static void seconds(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof frequencies / sizeof frequencies[0]; n++) {
        for (uint64_t s = 1; s < 1000000000; s *= 10) { /* up to three years */
            uint64_t error = s * 1000000000 - clock_ns(s * frequencies[n], frequencies[n]);
            if (error > s + 1)
                fail_msg("%u Hz: %llu s are %llu ns short", frequencies[n], (unsigned long long)s,
                         (unsigned long long)error);
        }
    }
}

static void never_back(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof frequencies / sizeof frequencies[0]; n++) {
        uint64_t before = 0;
        for (uint64_t cycles = UINT32_MAX - 5000u; cycles < UINT32_MAX + UINT64_C(5000); cycles++) {
            uint64_t now = clock_ns(cycles, frequencies[n]);
            assert_in_range(now - before, 0, before == 0 ? UINT64_MAX : 1000000000u / frequencies[n] + 1);
            before = now;
        }
    }
}

/* The counter after so many cycles, from `before` down. */
static uint32_t counter(uint32_t before, uint64_t cycles)
{
    return (uint32_t)((before - cycles) & (WRAP - 1));
}

static void wraps(void **state)
{
    static const uint32_t cycles[] = {0,        1,       1000,      WRAP - 1,  WRAP,        WRAP + 1,
                                      3 * WRAP, 1 << 27, 550000000, 550000001, 2147483648u, UINT32_MAX - WRAP};
    static const uint32_t befores[] = {0, 1, WRAP / 2, WRAP - 1};
    (void)state;
    for (size_t n = 0; n < sizeof cycles / sizeof cycles[0]; n++) {
        for (size_t b = 0; b < 4; b++) {
            uint32_t now = counter(befores[b], cycles[n]);
            assert_int_equal(clock_elapsed(befores[b], now, cycles[n]), cycles[n]);
            /* read some cycles sooner or later than the first counter */
            assert_int_equal(clock_elapsed(befores[b], now, cycles[n] + 100), cycles[n]);
            if (cycles[n] > 100)
                assert_int_equal(clock_elapsed(befores[b], now, cycles[n] - 100), cycles[n]);
        }
    }
}

static void alone(void **state)
{
    (void)state;
    assert_int_equal(clock_elapsed(5, counter(5, 100), 0), 100);
    assert_int_equal(clock_elapsed(5, counter(5, WRAP - 1), 0), WRAP - 1);
    assert_int_equal(clock_elapsed(WRAP - 1, counter(WRAP - 1, 1 << 20), 1 << 10), 1 << 20); /* asleep for most of it */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"cycles become nanoseconds at any frequency, over 10^-9 of error in years", seconds, NULL, NULL, NULL},
        {"the clock never decreases, and steps by a cycle, across 2^32 cycles", never_back, NULL, NULL, NULL},
        {"an erase of flash that lasts many wraps of SysTick loses no time where there is a cycle counter", wraps, NULL,
         NULL, NULL},
        {"without a cycle counter, or while it sleeps, SysTick alone counts", alone, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("firmware_clock", tests, NULL, NULL);
}
