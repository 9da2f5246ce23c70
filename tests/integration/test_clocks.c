/* SPDX-License-Identifier: MIT */
/*
 * SOEM synchronises the clocks of a chain of twins whose oscillators are wrong: it measures the delays, sets the
 * offsets, and then sends the reference clock's time round, as in its cyclic operation.
 *
 * usage: test_clocks IFACE SLAVES [SECONDS]
 * With SECONDS: paced at 1 ms, and the differences as CSV on standard output.
 */
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "soem.h"

/* A reply that a busy machine delivers late is requested again. */
enum { TRIES = 20 };

enum { SAMPLES = 3000, ROUNDS = 10, DIFFERENCE = 0x092C, CYCLE_US = 1000, LOOK_EVERY = 100, MOST_NS = 1000 };

static const char *iface;
static int slaves;

/* Signed: greater than 0 is ahead. */
static int32_t difference(soem_t *m, int slave)
{
    uint32_t value = 0;
    uint8_t bytes[4] = {0};
    int answered = 0;
    for (int i = 0; i < TRIES && answered <= 0; i++)
        answered = ecx_FPRD(&m->port, m->slaves[slave].configadr, DIFFERENCE, 4, bytes, EC_TIMEOUTRET3);
    assert_true(answered > 0);
    for (unsigned int i = 0; i < 4; i++)
        value |= (uint32_t)bytes[i] << (8 * i);
    int32_t size = (int32_t)(value & 0x7FFFFFFF);
    return (value & 0x80000000) != 0 ? size : -size;
}

static void send_time(soem_t *m)
{
    int64 time = 0;
    uint16 reference = m->slaves[m->slaves[0].DCnext].configadr;
    int answered = 0;
    for (int i = 0; i < TRIES && answered <= 0; i++)
        answered = ecx_FRMW(&m->port, reference, ECT_REG_DCSYSTIME, sizeof time, &time, EC_TIMEOUTRET3);
    assert_true(answered > 0);
}

static void open_clocks(soem_t *m)
{
    soem_open(m, iface, slaves);
    assert_true(ecx_configdc(&m->context));
    for (int i = 1; i <= slaves; i++)
        assert_true(m->slaves[i].hasdc);
}

static void print_differences(soem_t *m, unsigned long sample)
{
    for (int i = 2; i <= slaves; i++)
        printf("%lu,%d,%d\n", sample, i, difference(m, i));
}

static int record(unsigned long seconds)
{
    static soem_t m;
    open_clocks(&m);
    puts("ms,slave,difference_ns");
    for (unsigned long sample = 0; sample < seconds * 1000; sample++) {
        send_time(&m);
        if (sample % LOOK_EVERY == 1)
            print_differences(&m, sample);
        osal_usleep(CYCLE_US);
    }
    soem_close(&m);
    return 0;
}

/* @return the slave that is too far away, 0: none */
static int too_far(soem_t *m, int32_t *difference_ns)
{
    for (int i = 2; i <= slaves; i++) {
        *difference_ns = difference(m, i);
        if (*difference_ns < -MOST_NS || *difference_ns > MOST_NS)
            return i;
    }
    return 0;
}

/* The samples come as fast as the machine can, so it is not known how much time the clocks have had. */
static void settles(void **state)
{
    static soem_t m;
    int32_t got = 0;
    int slave = 1;
    (void)state;
    open_clocks(&m);
    for (int round = 0; round < ROUNDS && slave != 0; round++) {
        for (int i = 0; i < SAMPLES; i++)
            send_time(&m);
        slave = too_far(&m, &got);
    }
    if (slave != 0)
        fail_msg("slave %d: after %d samples expected a difference of at most %d ns, got %d", slave, ROUNDS * SAMPLES,
                 MOST_NS, got);
    soem_close(&m);
}

/* SOEM takes the way there to be as long as the way back: each controller on the way brings half the difference. */
static void delays(void **state)
{
    static soem_t m;
    (void)state;
    open_clocks(&m);
    for (int i = 2; i <= slaves; i++) {
        int32_t hop = m.slaves[i].pdelay - m.slaves[i - 1].pdelay;
        if (hop < 750 || hop > 780) /* 320 + 400 + 50, less 10; clocks that differ by 200 ppm for 30 us */
            fail_msg("slave %d: expected a delay of 750 to 780 ns to the one before, got %d", i, hop);
    }
    soem_close(&m);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-087: SOEM measures the delays of a chain: chips and cables", delays, NULL, NULL, NULL},
        {"CF-088: SOEM brings clocks that differ by up to 200 ppm within 1 us", settles, NULL, NULL, NULL},
    };
    if (argc < 3)
        return 2;
    iface = argv[1];
    slaves = atoi(argv[2]);
    if (argc > 3)
        return record(strtoul(argv[3], NULL, 10));
    return cmocka_run_group_tests_name("SOEM and distributed clocks", tests, NULL, NULL);
}
