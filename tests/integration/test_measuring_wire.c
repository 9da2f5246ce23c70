/* SPDX-License-Identifier: MIT */
/*
 * A measuring device of an ESI file under SOEM: values, a new scaling, zero and overload.
 * usage: test_measuring_wire IFACE [TEST]
 */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <string.h>

#include "plant.h"
#include "soem.h"

enum { PRESSURE = 0, STATUS_1 = 4 }; /* 1A00h of SCALED */
enum { PATIENCE = 20000 };

static const char *iface;
static soem_t master;

static int pressure(void)
{
    uint16 value;
    memcpy(&value, master.slaves[1].inputs + PRESSURE, sizeof value);
    return (int16)etohs(value);
}

static int status(void)
{
    return master.slaves[1].inputs[STATUS_1];
}

static void until(int (*input)(void), int wanted)
{
    for (unsigned int n = 0; n < PATIENCE && input() != wanted; n++)
        (void)soem_cycle(&master);
    assert_int_equal(input(), wanted);
}

static int start(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    plant_set_all("measure1.value=0 measure2.value=0 measure1.invalid=0");
    soem_map(&master);
    assert_int_equal(master.slaves[1].Ibytes, 10);
    soem_operational(&master);
    return 0;
}

static int stop(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

static void value_and_overload(void **state)
{
    (void)state;
    plant_set("measure1.value", "123.4");
    until(pressure, 1234);
    assert_int_equal(status(), 0);
    plant_set("measure1.value", "601");
    until(status, 2);
    until(pressure, 6010);
    plant_set("measure1.invalid", "1");
    until(status, 3);
}

static void scaled_and_zeroed(void **state)
{
    const int16 end = htoes(12000);
    uint32 zero = htoel(0x6F72657A), wrong = 0;
    (void)state;
    plant_set("measure1.value", "300");
    until(pressure, 3000);
    assert_int_equal(soem_write(&master, 1, 0x7123, 1, false, &end, sizeof end), 0);
    until(pressure, 6000);
    assert_int_equal(soem_write(&master, 1, 0x6125, 1, false, &wrong, sizeof wrong), 0x08000020);
    assert_int_equal(soem_write(&master, 1, 0x6125, 1, false, &zero, sizeof zero), 0);
    until(pressure, 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a value reaches the process data, and a value beyond the span the status", value_and_overload, start, stop,
         NULL},
        {"scaling and zero of the master", scaled_and_zeroed, start, stop, NULL},
    };
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
