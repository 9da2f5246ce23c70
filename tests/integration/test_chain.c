/* SPDX-License-Identifier: MIT */
/* A chain of eight base units, a master that is killed, and the next master.  usage: test_chain IFACE COUNT [TEST] */
#define _GNU_SOURCE
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "soem.h"

static const char *iface;
static int count;
static soem_t master;

static void all_in_op(void **state)
{
    (void)state;
    soem_open(&master, iface, count);
    soem_map(&master);
    soem_operational(&master);
    for (int i = 0; i < 500; i++)
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
    assert_int_equal(soem_expected_wkc(&master), 3 * count);
    soem_close(&master);
}

/* The position of a slave shows in its links: all have the port to the master, all but the last the next one. */
static void topology(void **state)
{
    (void)state;
    soem_open(&master, iface, count);
    for (int i = 1; i <= count; i++) {
        assert_int_equal(master.slaves[i].activeports, i < count ? 0x03 : 0x01);
        assert_int_equal(master.slaves[i].parent, i - 1);
    }
    soem_close(&master);
}

static void die_in_op(void)
{
    soem_open(&master, iface, count);
    soem_map(&master);
    soem_operational(&master);
    soem_watchdog(&master, 100);
    soem_cycle(&master);
    raise(SIGKILL);
}

/* A twin on a busy machine notices later that its watchdog has expired. */
static void read_past_op(ecx_portt *port, uint16 position, uint8 data[6])
{
    enum { TRIES = 30000 };
    for (int tries = 0; tries < TRIES; tries++) {
        assert_int_equal(ecx_APRD(port, position, ECT_REG_ALSTAT, 6, data, EC_TIMEOUTRET3), 1);
        if (data[0] != EC_STATE_OPERATIONAL)
            return;
        osal_usleep(1000);
    }
}

/* A reply on a busy machine may be that of an earlier cycle, before OP. */
static bool all_exchange(soem_t *m)
{
    return soem_cycle(m) == soem_expected_wkc(m);
}

static void master_dies(void **state)
{
    (void)state;
    pid_t child = fork();
    if (child == 0)
        die_in_op();
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status));

    /* The watchdog is 100 ms; then read the states as they are, without configuring anything. */
    osal_usleep(400000);
    uint8 data[6];
    ecx_portt *port = &master.port;
    assert_true(ecx_setupnic(port, iface, FALSE) > 0);
    for (int i = 0; i < count; i++) {
        read_past_op(port, (uint16)(0 - i), data);
        assert_int_equal(data[0], EC_STATE_SAFE_OP | EC_STATE_ERROR);
        assert_int_equal(data[4], 0x1B);
    }
    ecx_closenic(port);

    soem_open(&master, iface, count);
    soem_map(&master);
    soem_operational(&master);
    assert_true(soem_until(&master, all_exchange, 1000));
    soem_close(&master);
}

int main(int argc, char **argv)
{
    if (argc < 3)
        return 1;
    iface = argv[1];
    count = atoi(argv[2]);
    if (argc > 3)
        cmocka_set_test_filter(argv[3]);
    const struct CMUnitTest tests[] = {
        {"CF-032: a chain is in OP, every slave counts 3", all_in_op, NULL, NULL, NULL},
        {"CF-010: the links of each slave show its place in the chain", topology, NULL, NULL, NULL},
        {"CF-042 ECL-073: the master is killed in OP, each twin shows SAFEOP with 0x001B, the next master reaches OP",
         master_dies, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("chain", tests, NULL, NULL);
}
