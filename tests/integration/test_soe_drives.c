/* SPDX-License-Identifier: MIT */
/*
 * SoE drives of tests/esi/soe.xml under SOEM: its own mapping by S-0-0024 and S-0-0016, its reads and writes, OP.
 * usage: test_soe_drives IFACE [TEST]; the chain is TWO, SPEED.
 */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <string.h>

#include "soem.h"

enum { TWO = 1, SPEED = 2, OPERATION_MODE = 32, TELEGRAM_TYPE = 15, CYCLE_TIME = 1, MDT_LIST = 24, NOTHING = 999 };

static const char *iface;
static soem_t master;

static int start(void **state)
{
    (void)state;
    soem_open(&master, iface, 2);
    soem_map(&master);
    return 0;
}

static int stop(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

static int read_idn(uint16 slave, uint8 drive, uint16 idn, void *data, int size)
{
    int wkc = ecx_SoEread(&master.context, slave, drive, EC_SOE_VALUE_B, idn, &size, data, EC_TIMEOUTRXM * 20);
    return wkc > 0 ? size : -1;
}

static int write_idn(uint16 slave, uint8 drive, uint16 idn, void *data, int size)
{
    return ecx_SoEwrite(&master.context, slave, drive, EC_SOE_VALUE_B, idn, size, data, EC_TIMEOUTRXM * 20);
}

static uint16 error_of(void)
{
    ec_errort error = {0};
    uint16 code = 0;
    while (ecx_poperror(&master.context, &error))
        code = error.Etype == EC_ERR_TYPE_SOE_ERROR ? (uint16)error.ErrorCode : code;
    return code;
}

static void sizes(void **state)
{
    (void)state;
    assert_int_equal(master.slaves[TWO].Obytes, 12);
    assert_int_equal(master.slaves[TWO].Ibytes, 20);
    assert_int_equal(master.slaves[SPEED].Obytes, 6);
    assert_int_equal(master.slaves[SPEED].Ibytes, 6);
    soem_operational(&master);
    for (unsigned int n = 0; n < 10; n++)
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
}

static void reads(void **state)
{
    ec_SoElistt list;
    uint16 value = 0;
    (void)state;
    assert_int_equal(read_idn(TWO, 1, OPERATION_MODE, &value, sizeof value), 2);
    assert_int_equal(etohs(value), 11);
    assert_int_equal(read_idn(SPEED, 0, TELEGRAM_TYPE, &value, sizeof value), 2);
    assert_int_equal(etohs(value), 7);
    memset(&list, 0, sizeof list);
    assert_int_equal(read_idn(TWO, 1, MDT_LIST, &list, sizeof list), 6);
    assert_int_equal(etohs(list.currentlength), 2);
    assert_int_equal(read_idn(TWO, 0, NOTHING, &value, sizeof value), -1);
    assert_int_equal(error_of(), 0x1001);
}

static void writes(void **state)
{
    uint16 value = htoes(1000);
    (void)state;
    soem_go(&master, 0, EC_STATE_PRE_OP);
    assert_true(write_idn(SPEED, 0, CYCLE_TIME, &value, sizeof value) > 0);
    value = 0;
    assert_int_equal(read_idn(SPEED, 0, CYCLE_TIME, &value, sizeof value), 2);
    assert_int_equal(etohs(value), 1000);
    value = htoes(100);
    assert_true(write_idn(SPEED, 0, CYCLE_TIME, &value, sizeof value) <= 0);
    assert_int_equal(read_idn(SPEED, 0, CYCLE_TIME, &value, sizeof value), 2);
    assert_int_equal(etohs(value), 1000);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"SOE-037: SOEM maps the telegrams by their lists, with the file's lengths, and goes to OP", sizes, start, stop,
         NULL},
        {"SOE-002 SOE-005 SOE-008: SOEM reads numbers and lists of each drive", reads, start, stop, NULL},
        {"SOE-011: SOEM writes a number; one below the minimum is refused", writes, start, stop, NULL},
    };
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
