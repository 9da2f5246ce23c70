/* SPDX-License-Identifier: MIT */
/* A FZM1 with a memory, for each test. */
#ifndef TESTS_FZM1_BENCH_H
#define TESTS_FZM1_BENCH_H

#include "support/sensor.h"

static sensor_t s;
static sensor_memory_t memory;

static int setup(void **state)
{
    (void)state;
    sensor_memory_open(&memory);
    sensor_open_with(&s, &memory.storage);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    sensor_close(&s);
    sensor_memory_close(&memory);
    return 0;
}

__attribute__((unused)) static void power_cycle(void)
{
    sensor_close(&s);
    sensor_open_with(&s, &memory.storage);
}

#endif
