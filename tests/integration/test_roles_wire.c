/* SPDX-License-Identifier: MIT */
/*
 * A chain of a terminal without a mailbox, a sensor without outputs, and another terminal, under SOEM.
 * usage: test_roles_wire IFACE [TEST]
 */
#include <string.h>

#include "soem.h"

enum { TERMINAL = 1, GAUGE = 2, LAST = 3, SLAVES = 3 };

static const char *iface;
static soem_t master;

static void sizes(void **state)
{
    (void)state;
    soem_open(&master, iface, SLAVES);
    soem_map(&master);
    for (int i = 1; i <= SLAVES; i += 2) {
        assert_string_equal(master.slaves[i].name, "8 digital outputs and inputs");
        assert_int_equal(master.slaves[i].mbx_proto, 0);
        assert_int_equal(master.slaves[i].Obits, 8);
        assert_int_equal(master.slaves[i].Ibits, 8 + 16);
    }
    assert_int_equal(master.slaves[GAUGE].mbx_proto, ECT_MBXPROT_COE);
    assert_int_equal(master.slaves[GAUGE].Obits, 0);
    assert_int_equal(master.slaves[GAUGE].Ibits, 64);
    soem_close(&master);
}

/* Outputs of a terminal return in its first inputs; the second count how often. */
static void terminals_exchange(void **state)
{
    (void)state;
    soem_open(&master, iface, SLAVES);
    soem_map(&master);
    soem_operational(&master);
    for (unsigned int n = 0; n < 256; n++) {
        master.slaves[TERMINAL].outputs[0] = (uint8)n;
        master.slaves[LAST].outputs[0] = (uint8)~n;
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
        osal_usleep(1000);
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
        uint8 first = master.slaves[TERMINAL].inputs[0], last = master.slaves[LAST].inputs[0];
        if (first != (uint8)n || last != (uint8)~n)
            fail_msg("outputs %02X and %02X: inputs %02X and %02X", n, (uint8)~n, first, last);
    }
    soem_close(&master);
}

/* The process data sent follow the choice in 21B0h, and SOEM maps them again. */
static void gauge_chooses(void **state)
{
    static const uint8 all[] = {1, 1, 1, 1};
    (void)state;
    soem_open(&master, iface, SLAVES);
    for (uint8 n = 1; n <= 4; n++)
        assert_int_equal(soem_write(&master, GAUGE, 0x21B0, n, false, &all[n - 1], 1), 0);
    soem_map(&master);
    assert_int_equal(master.slaves[GAUGE].Ibits, 128);
    soem_operational(&master);
    int32 values[4];
    for (unsigned int n = 0; n < 3; n++)
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
    memcpy(values, master.slaves[GAUGE].inputs, sizeof values);
    for (int i = 0; i < 4; i++)
        assert_int_equal(values[i] % (i + 1), 0);
    assert_true(values[0] > 0 && values[3] == 4 * values[0]);
    soem_close(&master);
}

static void watchdog_of_a_terminal(void **state)
{
    uint16 code;
    (void)state;
    soem_open(&master, iface, SLAVES);
    soem_map(&master);
    soem_operational(&master);
    soem_watchdog(&master, 100);
    soem_cycle(&master);
    assert_int_equal(soem_await(&master, TERMINAL, EC_STATE_SAFE_OP | EC_STATE_ERROR),
                     EC_STATE_SAFE_OP | EC_STATE_ERROR);
    assert_int_equal(soem_request(&master, TERMINAL, EC_STATE_SAFE_OP, &code) & 0x1F,
                     EC_STATE_SAFE_OP | EC_STATE_ERROR);
    assert_int_equal(code, 0x001B);
    soem_close(&master);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-061: SOEM finds roles and sizes, by SII alone and by CoE", sizes, NULL, NULL, NULL},
        {"CF-037: terminals without a mailbox exchange process data", terminals_exchange, NULL, NULL, NULL},
        {"OPT-006 OPT-009 OPT-010: a sensor without outputs sends the selected values", gauge_chooses, NULL, NULL,
         NULL},
        {"CF-042: a terminal without a mailbox has its watchdog", watchdog_of_a_terminal, NULL, NULL, NULL},
    };
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests_name("Roles over the wire", tests, NULL, NULL);
}
