/* SPDX-License-Identifier: MIT */
/* A Cortex-M4 at 100 MHz with the window of the ESC at 0x60000000; the addresses are fictitious, except those of
 * SysTick and SCB. */
#include "board.h"

enum { NS_PER_TICK = 10, SYSTICK_RELOAD = 0xFFFFFF };

#define REGISTER(address) (*(volatile uint32_t *)(uintptr_t)(address))

#define SYSTICK_VALUE REGISTER(0xE000E018)
#define SCB_AIRCR     REGISTER(0xE000ED0C)
#define WINDOW(n)     REGISTER(0x60000000 + 4 * (n))
#define ADC_VALUE     REGISTER(0x40012000)
#define PWM_DUTY      REGISTER(0x40010000)
#define WATCHDOG_KEY  REGISTER(0x40003000)

static uint32_t load(void *ctx, unsigned int reg)
{
    (void)ctx;
    return WINDOW(reg);
}

static void store(void *ctx, unsigned int reg, uint32_t value)
{
    (void)ctx;
    WINDOW(reg) = value;
}

const ect_window_t board_window = {.load = load, .store = store, .patience = 20};

/* SysTick counts down and wraps every 168 ms, so the main loop must call this function more often. */
uint64_t board_now_ns(void)
{
    static uint64_t ticks;
    static uint32_t last = SYSTICK_RELOAD;
    uint32_t value = SYSTICK_VALUE;
    ticks += (last - value) & SYSTICK_RELOAD;
    last = value;
    return ticks * NS_PER_TICK;
}

int16_t board_temperature(void)
{
    return (int16_t)ADC_VALUE;
}

void board_heat(uint8_t percent)
{
    PWM_DUTY = percent;
}

void board_alive(void)
{
    WATCHDOG_KEY = 0xAAAA;
}

void board_reset(void)
{
    SCB_AIRCR = 0x05FA0004;
}
