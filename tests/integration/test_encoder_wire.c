/* SPDX-License-Identifier: MIT */
/*
 * Encoders of an ESI file under SOEM: turned at a speed, set to zero by the preset, wired to each other.
 * usage: test_encoder_wire IFACE [TEST]
 */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <string.h>

#include "plant.h"
#include "soem.h"

enum { POSITION = 0, SPEED = 4, ALARMS = 6 }; /* 1A00h of ROTARY */
enum { PATIENCE = 20000, TURN = 1000, RANGE = 4096000 };

static const char *iface;
static soem_t master;

static uint32 position(void)
{
    uint32 counts;
    memcpy(&counts, master.slaves[1].inputs + POSITION, sizeof counts);
    return etohl(counts);
}

static int16 word(unsigned int offset)
{
    uint16 value;
    memcpy(&value, master.slaves[1].inputs + offset, sizeof value);
    return (int16)etohs(value);
}

static void until_position(uint32 from, uint32 to)
{
    for (unsigned int n = 0; n < PATIENCE && (position() < from || position() > to); n++)
        (void)soem_cycle(&master);
    if (position() < from || position() > to)
        fail_msg("expected %u to %u, got %u", (unsigned int)from, (unsigned int)to, (unsigned int)position());
}

static int start(void **state)
{
    (void)state;
    soem_open(&master, iface, 2);
    plant_set_all("encoder1.speed=0 encoder1.position=0 encoder1.alarms=0");
    soem_map(&master);
    assert_int_equal(master.slaves[1].Ibytes, 16);
    assert_int_equal(master.slaves[2].Ibytes, 8);
    soem_operational(&master);
    return 0;
}

static int stop(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

static void counts_up_and_down(void **state)
{
    (void)state;
    plant_set("encoder1.speed", "600");
    until_position(10 * TURN, 20 * TURN);
    assert_int_equal(word(SPEED), 10 * TURN);
    plant_set("encoder1.speed", "-600");
    until_position(RANGE - 20 * TURN, RANGE - 1);
    assert_int_equal(word(SPEED), -10 * TURN);
}

static void set_to_zero(void **state)
{
    uint32 preset = 0;
    (void)state;
    plant_set("encoder1.position", "7.5");
    until_position(7 * TURN + TURN / 2, 7 * TURN + TURN / 2);
    assert_int_equal(soem_write(&master, 1, 0x6003, 0, false, &preset, sizeof preset), 0);
    until_position(0, 0);
    plant_set("encoder1.position", "8.5");
    until_position(TURN, TURN);
}

static void alarm_is_reported(void **state)
{
    (void)state;
    plant_set("encoder1.alarms", "4096");
    for (unsigned int n = 0; n < PATIENCE && word(ALARMS) != 4096; n++)
        (void)soem_cycle(&master);
    assert_int_equal(word(ALARMS), 4096);
}

static void units_of_the_bus(void **state)
{
    uint32 units = 5, range = 50;
    (void)state;
    assert_int_equal(soem_write(&master, 1, 0x6001, 0, false, &units, sizeof units), 0);
    assert_int_equal(soem_write(&master, 1, 0x6002, 0, false, &range, sizeof range), 0);
    plant_set("encoder1.position", "11.2");
    until_position(6, 6);
    units = 70000;
    assert_int_equal(soem_write(&master, 1, 0x6001, 0, false, &units, sizeof units), 0x06090030);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a shaft that turns counts up and down, around its range", counts_up_and_down, start, stop, NULL},
        {"a preset sets the position", set_to_zero, start, stop, NULL},
        {"an alarm reaches the process data", alarm_is_reported, start, stop, NULL},
        {"units and range of the master", units_of_the_bus, start, stop, NULL},
    };
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
