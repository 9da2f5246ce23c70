/* SPDX-License-Identifier: MIT */
/* A PMCtendo and a master that writes objects, for tests against CiA 402-2. */
#ifndef TESTS_PMCTENDO_PROFILE_BENCH_H
#define TESTS_PMCTENDO_PROFILE_BENCH_H

#include <math.h>

#include "support/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define TURN         PMC_TURN

static drive_t d;

static int teardown(void **state)
{
    (void)state;
    drive_close(&d);
    return 0;
}

static void put(uint16_t index, uint8_t subindex, int64_t value, size_t size)
{
    uint32_t abort = drive_write(&d, index, subindex, (uint32_t)value, size);
    if (abort != 0)
        fail_msg("%04Xh:%u = %lld: abort %08X", index, subindex, (long long)value, abort);
}

static void start(int8_t mode, uint16_t out)
{
    put(0x6060, 0, mode, 1);
    drive_operational(&d, out, 0x1B25);
    drive_enable(&d);
}

static double speed(void)
{
    return drive_instance(&d)->plant.machine.speed;
}

static void expect_near(const char *what, double want, double off, double got)
{
    if (fabs(got - want) > off)
        fail_msg("%s: expected %.0f +- %.0f, got %.0f", what, want, off, got);
}

#endif
