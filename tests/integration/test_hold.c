/* SPDX-License-Identifier: MIT */
/* Any slaves in OP, with process data for SECONDS.  usage: test_hold IFACE SLAVES SECONDS */
#include <stdlib.h>

#include "soem.h"

static const char *iface;
static int slaves;
static unsigned int seconds;
static soem_t master;

static void hold(void **state)
{
    (void)state;
    uint64_t cycles = 0;
    soem_open(&master, iface, slaves);
    soem_map(&master);
    soem_operational(&master);
    for (uint64_t end = soem_now() + seconds * 1000000000ull; soem_now() < end; cycles++) {
        int wkc = soem_cycle(&master);
        if (wkc != soem_expected_wkc(&master))
            fail_msg("cycle %llu: working counter %d, expected %d", (unsigned long long)cycles, wkc,
                     soem_expected_wkc(&master));
    }
    ecx_readstate(&master.context);
    for (int i = 1; i <= slaves; i++)
        assert_int_equal(master.slaves[i].state, EC_STATE_OPERATIONAL);
    print_message("%llu cycles in %u s, none lost\n", (unsigned long long)cycles, seconds);
    soem_close(&master);
}

int main(int argc, char **argv)
{
    if (argc != 4)
        return 1;
    iface = argv[1];
    slaves = atoi(argv[2]);
    seconds = (unsigned int)atoi(argv[3]);
    const struct CMUnitTest tests[] = {
        {"CF-033 ECL-011: OP, and process data of every cycle for a given time", hold, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("hold", tests, NULL, NULL);
}
