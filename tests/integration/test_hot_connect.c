/* SPDX-License-Identifier: MIT */
/*
 * A hot-connect group leaves a bus in OP and joins it again, named by its alias; a master finds it by alias and device
 * id.
 *
 * usage: test_hot_connect IFACE ECTWIN      with twins wired as in tests/integration/CMakeLists.txt
 */
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <stdlib.h>

#include "soem.h"

/* As wired: the group, 2 and 3, behind port 3 of 1; 4 behind port 1 of 1. */
enum { TWINS = 4, STAY = 2, ALIAS = 17, LONG_MS = 120000 };
enum {
    STATION_ALIAS = 0x0012,
    AL_CONTROL = 0x0120,
    AL_STATUS = 0x0130,
    AL_CODE = 0x0134,
    ID_REQUEST = 0x20,
    ACK = 0x10
};

static const char *iface, *ectwin;

static int command(const char *what)
{
    char line[512];
    snprintf(line, sizeof line, "'%s' %s", ectwin, what);
    return system(line);
}

static bool is_left(soem_t *m)
{
    return soem_cycle(m) == soem_expected_wkc(m) / TWINS * STAY;
}

/* A slave that has lost the master for longer than its watchdog is brought back to OP. */
static bool is_whole(soem_t *m)
{
    if (soem_cycle(m) == soem_expected_wkc(m))
        return true;
    for (uint16 slave = 2; slave <= 3; slave++) {
        m->slaves[slave].state = EC_STATE_OPERATIONAL | ACK;
        (void)ecx_writestate(&m->context, slave);
    }
    return false;
}

static uint16 state_of(soem_t *m, int slave)
{
    uint16 status = 0;
    assert_int_equal(ecx_FPRD(&m->port, m->slaves[slave].configadr, AL_STATUS, sizeof status, &status, EC_TIMEOUTSAFE),
                     1);
    return etohs(status);
}

static void leaves_and_joins(void **state)
{
    static soem_t m;
    (void)state;
    soem_open(&m, iface, TWINS);
    soem_map(&m);
    soem_operational(&m);
    for (unsigned int round = 0; round < 2; round++) {
        assert_int_equal(command("unplug alias:17"), 0);
        assert_true(soem_until(&m, is_left, LONG_MS));
        assert_int_equal(state_of(&m, 1), EC_STATE_OPERATIONAL);
        assert_int_equal(state_of(&m, 4), EC_STATE_OPERATIONAL);
        assert_int_equal(command("plug alias:17"), 0);
        assert_true(soem_until(&m, is_whole, LONG_MS));
        assert_int_equal(state_of(&m, 2), EC_STATE_OPERATIONAL);
        assert_int_equal(state_of(&m, 3), EC_STATE_OPERATIONAL);
    }
    soem_close(&m);
}

/* ec_slavet::aliasadr is that of another slave where that one still had the address from before the group joined. */
static int find(soem_t *m)
{
    int found = 0;
    for (int slave = m->slave_count; slave >= 1; slave--) {
        if (etohs(ecx_FPRDw(&m->port, m->slaves[slave].configadr, STATION_ALIAS, EC_TIMEOUTSAFE)) == ALIAS)
            found = slave;
    }
    return found;
}

static uint16 device_id(soem_t *m, int slave)
{
    const uint16 address = m->slaves[slave].configadr;
    uint16 request = htoes(EC_STATE_PRE_OP | ID_REQUEST), status = 0, id = 0;
    assert_int_equal(ecx_FPWR(&m->port, address, AL_CONTROL, sizeof request, &request, EC_TIMEOUTSAFE), 1);
    for (unsigned int i = 0; i < 100000 && (etohs(status) & ID_REQUEST) == 0; i++)
        status = htoes(state_of(m, slave));
    assert_int_equal(ecx_FPRD(&m->port, address, AL_CODE, sizeof id, &id, EC_TIMEOUTSAFE), 1);
    return etohs(id);
}

static void is_found(void **state)
{
    static soem_t m;
    (void)state;
    assert_int_equal(command("unplug alias:17"), 0);
    soem_open(&m, iface, STAY);
    assert_int_equal(find(&m), 0);
    soem_close(&m);
    assert_int_equal(command("plug alias:17"), 0);
    soem_open(&m, iface, TWINS);
    assert_int_equal(find(&m), 2);
    assert_int_equal(device_id(&m, 2), ALIAS);
    soem_close(&m);
}

static void is_refused(void **state)
{
    static soem_t m;
    (void)state;
    assert_int_not_equal(command("unplug alias:99 2>/dev/null"), 0);
    assert_int_not_equal(command("unplug alias:x 2>/dev/null"), 0);
    soem_open(&m, iface, TWINS);
    soem_close(&m);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"ENI-021: a hot-connect group leaves and joins by its alias; all other slaves stay in OP", leaves_and_joins,
         NULL, NULL, NULL},
        {"ENI-021: SOEM finds the group by alias and device id after it has joined", is_found, NULL, NULL, NULL},
        {"ENI-021: an alias that no slave has is refused, and no plug is pulled", is_refused, NULL, NULL, NULL},
    };
    if (argc < 3)
        return 2;
    iface = argv[1];
    ectwin = argv[2];
    return cmocka_run_group_tests_name("SOEM and a hot-connect group", tests, NULL, NULL);
}
