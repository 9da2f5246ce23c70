/* SPDX-License-Identifier: MIT */
/* A chip with a memory-mapped ESC, at the addresses of the CMake variables MMIO_... */
#include "board.h"

#include "clock.h"
#include "cpu.h"
#include "ports/mmio/mmio.h"

enum { ESC_BITS = 16 /* size of its address range */ };
_Static_assert((MMIO_ESC & ((1ull << ESC_BITS) - 1)) == 0,
               "MMIO_ESC: a multiple of 64 KB, the size of its region in the MPU");
_Static_assert(MMIO_CLOCK_HZ > 0 && MMIO_CLOCK_HZ <= UINT32_MAX, "MMIO_CLOCK_HZ: 1 to 4294967295");

static const ect_mmio_t esc = {.base = (volatile void *)MMIO_ESC, .width = MMIO_ESC_WIDTH};
static ect_pdi_t pdi;

void board_init(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    cpu_device_memory(MMIO_ESC, ESC_BITS);
    while (!ect_mmio_ready(&esc)) {
        /* waits until the ESC has loaded its EEPROM; without an ESC the firmware has no work */
    }
    pdi = ect_mmio_pdi(&esc);
}

uint64_t board_now_ns(void)
{
    return clock_ns(cpu_cycles(), MMIO_CLOCK_HZ);
}

const ect_pdi_t *board_pdi(void)
{
    return &pdi;
}

void board_turn(uint64_t until_ns)
{
    (void)until_ns; /* the ESC is polled continuously */
}

void board_reset(void)
{
    cpu_reset();
}

/* --- switches and lamps ------------------------------------------------------------------------------------------- */

uint16_t board_switches(void)
{
    return 0;
}

uint32_t board_serial(void)
{
    return 0;
}

static void light(uint32_t bit, bool lit)
{
    const uintptr_t lamps = MMIO_LAMPS;
    if (lamps != 0)
        REGISTER(lamps) = lit ? REGISTER(lamps) | bit : REGISTER(lamps) & ~bit;
}

static void light_run(void *ctx, bool lit)
{
    (void)ctx;
    light(1, lit);
}

static void light_err(void *ctx, bool lit)
{
    (void)ctx;
    light(2, lit);
}

const ect_leds_t *board_leds(void)
{
    static const ect_leds_t leds = {.run = light_run, .err = light_err};
    return &leds;
}
