/* SPDX-License-Identifier: MIT */
#include "mps2.h"

#include "cpu.h"

enum { CLOCK_HZ = 25000000, NS_PER_TICK = 40, BAUD = 115200 };

#define UART_DATA     REGISTER(0x40004000)
#define UART_STATE    REGISTER(0x40004004)
#define UART_CONTROL  REGISTER(0x40004008)
#define UART_DIVIDER  REGISTER(0x40004010)
#define UART_FULL     1u
#define UART_SEND     1u
#define FPGA_LEDS     REGISTER(0x40028000)
#define FPGA_COUNTER  REGISTER(0x40028018)
#define FPGA_PRESCALE REGISTER(0x4002801C)

/* Limit of state reads of a serial line for each character, so that a stuck line does not stop the firmware.
 */
enum { PATIENCE = 1000000 };

void mps2_init(void)
{
    FPGA_PRESCALE = 0; /* counts at 25 MHz */
    UART_DIVIDER = CLOCK_HZ / BAUD;
    UART_CONTROL = UART_SEND;
}

uint64_t mps2_now_ns(void)
{
    static uint64_t ticks;
    uint32_t before = cpu_interrupts_off();
    ticks += (uint32_t)(FPGA_COUNTER - (uint32_t)ticks);
    uint64_t now = ticks;
    cpu_interrupts_restore(before);
    return now * NS_PER_TICK;
}

void mps2_alarm(uint64_t at_ns)
{
    uint64_t now = mps2_now_ns();
    uint64_t ticks = at_ns > now ? (at_ns - now) / NS_PER_TICK : 0;
    if (ticks > CPU_SYSTICK_LONGEST)
        ticks = CPU_SYSTICK_LONGEST;
    CPU_SYSTICK_RELOAD = ticks < 1 ? 1 : (uint32_t)ticks; /* 0 would stop the timer */
    CPU_SYSTICK_VALUE = 0;
    CPU_SYSTICK_CONTROL = CPU_SYSTICK_ALARMS;
}

void mps2_led(unsigned int number, bool lit)
{
    uint32_t others = FPGA_LEDS & ~(1u << number);
    FPGA_LEDS = others | (lit ? 1u << number : 0u);
}

void mps2_print(const char *text)
{
    for (; *text != '\0'; text++) {
        for (unsigned int n = 0; n < PATIENCE && (UART_STATE & UART_FULL) != 0; n++) {
        }
        UART_DATA = (uint8_t)*text;
    }
}
