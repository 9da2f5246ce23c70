/* SPDX-License-Identifier: MIT */
/* A device consists of a few functions over a structure, so the tests need no bus, and time is a number. */
#undef NDEBUG
#include <assert.h>

#include "heater.h"

static unsigned int emergencies;
static uint16_t last_emergency;

static void emergency(void *ctx, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    (void)ctx;
    (void)error_register;
    (void)data;
    last_emergency = code;
    emergencies++;
}

int main(void)
{
    const ect_host_t host = {.emergency = emergency};
    heater_t h = {.highest = 2000, .sensed = 215};
    heater.init(&h, &host, 0);

    h.set_point = 800;
    (void)heater.tick(&h, 1);
    assert(h.temperature == 215 && h.power == 0); /* not in OP */

    heater.outputs(&h, 2);
    (void)heater.tick(&h, 3);
    assert(h.power == 100);
    h.sensed = 770;
    (void)heater.tick(&h, 4);
    assert(h.power == 30);

    h.broken = 1;
    (void)heater.tick(&h, 5);
    (void)heater.tick(&h, 6);
    assert(h.temperature == INT16_MAX && h.power == 0);
    assert(emergencies == 1 && last_emergency == 0x4000);

    h.broken = 0;
    heater.safe_outputs(&h, 7);
    (void)heater.tick(&h, 8);
    assert(h.temperature == 770 && h.power == 0);
    assert(emergencies == 2 && last_emergency == 0x0000);
    return 0;
}
