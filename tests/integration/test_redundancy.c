/* SPDX-License-Identifier: MIT */
/*
 * Cable redundancy: SOEM with an interface at either end of a chain of four.  usage: test_redundancy IFACE IFACE2
 * [TEST]
 */
#define _GNU_SOURCE
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "plant.h"
#include "soem.h"

enum { SLAVES = 4, CYCLES = 200, DL_STATUS = 0x0110 };

static const char *iface;
static const char *second;
static soem_t master;

/* Every slave takes part in so many successive cycles, and none has left OP. */
static void assert_whole(const char *when)
{
    int expected = soem_expected_wkc(&master);
    assert_int_equal(expected, 3 * SLAVES);
    for (int i = 0; i < CYCLES; i++) {
        int wkc = soem_cycle(&master);
        if (wkc != expected)
            fail_msg("%s, cycle %d: expected working counter %d, got %d", when, i, expected, wkc);
    }
    assert_int_equal(ecx_readstate(&master.context), EC_STATE_OPERATIONAL);
}

/* A slave shows the state of its ports in DL status, bit 8 on (data sheet: 01 closed, 10 open). */
static void assert_ports(int slave, unsigned int expected)
{
    uint16 status = 0;
    assert_int_equal(
        ecx_FPRD(&master.port, master.slaves[slave].configadr, DL_STATUS, sizeof status, &status, EC_TIMEOUTRET3), 1);
    if (etohs(status) >> 8 != expected)
        fail_msg("slave %d: expected 0x0111 to be 0x%02X, got 0x%02X", slave, expected, etohs(status) >> 8);
}

/* The twin checks its plugs within a poll; a few cycles later all is settled. Frames under way may be lost. */
static void settle(void)
{
    for (int i = 0; i < 20; i++)
        soem_cycle(&master);
}

static void set_up(const char *name, bool up)
{
    struct ifreq request = {0};
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
    assert_int_equal(ioctl(fd, SIOCGIFFLAGS, &request), 0);
    request.ifr_flags = (short)(up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
    assert_int_equal(ioctl(fd, SIOCSIFFLAGS, &request), 0);
    close(fd);
}

/*
 * SOEM sends a frame that has returned on half the path, or not at all (here within 50 ms, shorter than the watchdog),
 * by the other cable, with a timeout of 10 ms: on a busy machine a cycle is lost occasionally.
 */
static void assert_whole_in_halves(const char *when)
{
    int complete = 0;
    for (int i = 0; i < CYCLES; i++) {
        ecx_send_processdata(&master.context);
        complete += ecx_receive_processdata(&master.context, 10000) == soem_expected_wkc(&master) ? 1 : 0;
    }
    if (complete < CYCLES / 2)
        fail_msg("%s: of %d cycles only %d were complete", when, CYCLES, complete);
    assert_int_equal(ecx_readstate(&master.context), EC_STATE_OPERATIONAL);
}

static int reach_op(void **state)
{
    (void)state;
    soem_open_redundant(&master, iface, second, SLAVES);
    soem_map(&master);
    soem_operational(&master);
    soem_patience(5);
    return 0;
}

static int leave(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

static void whole_ring(void **state)
{
    (void)state;
    assert_whole("all wires whole");
    for (int slave = 1; slave <= SLAVES; slave++)
        assert_ports(slave, 0x5A);
}

static void cut_anywhere(void **state)
{
    (void)state;
    for (unsigned int before = 1; before < SLAVES; before++) {
        char when[40];
        plant_set_of(before, "ecat.plug_out", "0");
        settle();
        snprintf(when, sizeof when, "cut between %u and %u", before, before + 1);
        assert_whole_in_halves(when);
        assert_ports((int)before, 0x56);
        assert_ports((int)before + 1, 0x59);
        plant_set_of(before, "ecat.plug_out", "1");
        settle();
        assert_whole("mended");
    }
}

static void plug_of_the_next(void **state)
{
    (void)state;
    plant_set_of(3, "ecat.plug_in", "0");
    settle();
    assert_whole_in_halves("plug pulled at the input of slave 3");
    plant_set_of(3, "ecat.plug_in", "1");
    settle();
    assert_whole("plugged in again");
}

static void cables_of_the_master(void **state)
{
    (void)state;
    const struct {
        const char *iface;
        int slave;
        unsigned int ports;
    } cables[] = {{iface, 1, 0x59}, {second, SLAVES, 0x56}};
    for (size_t i = 0; i < 2; i++) {
        set_up(cables[i].iface, false);
        assert_whole_in_halves(i == 0 ? "first cable pulled" : "second cable pulled");
        assert_ports(cables[i].slave, cables[i].ports);
        set_up(cables[i].iface, true);
        assert_whole_in_halves("cable in again"); /* its first frames may still find it out */
        assert_whole("both cables in");
    }
}

int main(int argc, char **argv)
{
    if (argc < 3)
        return 1;
    iface = argv[1];
    second = argv[2];
    if (argc > 3)
        cmocka_set_test_filter(argv[3]);
    const struct CMUnitTest tests[] = {
        {"CF-010: a ring of four is in OP, every slave shows two open ports", whole_ring, NULL, NULL, NULL},
        {"CF-010: with a wire cut anywhere all four stay in OP, and when it is whole again", cut_anywhere, NULL, NULL,
         NULL},
        {"CF-010: the plug at the other end of a wire cuts it as well", plug_of_the_next, NULL, NULL, NULL},
        {"CF-010: without one of the master's cables all four stay in OP", cables_of_the_master, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("redundancy", tests, reach_op, leave);
}
