/* SPDX-License-Identifier: MIT */
#include "lamps.h"

#include <string.h>

#include "plant.h"

static void expect_lamps(const char *run, const char *err)
{
    assert_string_equal(plant_get("ecat.run"), run);
    assert_string_equal(plant_get("ecat.err"), err);
    assert_string_equal(plant_get("ecat.link_out"), "off");
}

void lamps_follow(soem_t *m)
{
    uint16 code;
    soem_go(m, 1, EC_STATE_INIT);
    expect_lamps("off", "off");
    soem_go(m, 1, EC_STATE_PRE_OP);
    expect_lamps("blinking", "off");
    (void)soem_request(m, 1, EC_STATE_OPERATIONAL, &code);
    expect_lamps("blinking", "blinking");
    soem_go(m, 1, EC_STATE_PRE_OP);
    soem_map(m);
    expect_lamps("single flash", "off");
    soem_operational(m);
    expect_lamps("on", "off");
    bool flickers = false;
    for (int tries = 0; tries < 100 && !flickers; tries++) {
        soem_cycle(m);
        flickers = strcmp(plant_get("ecat.link_in"), "flickering") == 0;
    }
    assert_true(flickers);
    soem_watchdog(m, 100);
    soem_cycle(m);
    for (int tries = 0; tries < 100 && plant_number("ecat.code") == 0; tries++)
        osal_usleep(50000); /* no frames: the watchdog */
    expect_lamps("single flash", "double flash");
    osal_usleep(200000);
    assert_string_equal(plant_get("ecat.link_in"), "on");
    assert_int_equal(plant_number("ecat.code"), 0x001B);
}
