/* SPDX-License-Identifier: MIT */
#include "cpu.h"

extern uint32_t cpu_stack_top[]; /* from flash.ld */

#define NVIC_ENABLE(n) REGISTER(0xE000E100 + 4 * (n))
#define SCB_VTOR       REGISTER(0xE000ED08)
#define SCB_AIRCR      REGISTER(0xE000ED0C)
#define SYSTEM_RESET   0x05FA0004u

__attribute__((weak)) void cpu_fault(void)
{
    for (;;) {
    }
}

__attribute__((weak)) void cpu_systick(void)
{
    cpu_fault();
}

typedef union vector {
    uint32_t *stack;
    cpu_handler_t handler;
} vector_t;

/* The processor takes its stack from the first word and goes to where the second one points; the others are its
 * exceptions. */
__attribute__((section(".vectors.processor"), used)) static const vector_t vectors[16] = {
    [0] = {.stack = cpu_stack_top}, [1] = {.handler = cpu_start},    [2] = {.handler = cpu_fault},
    [3] = {.handler = cpu_fault},   [4] = {.handler = cpu_fault},    [5] = {.handler = cpu_fault},
    [6] = {.handler = cpu_fault},   [11] = {.handler = cpu_fault},   [12] = {.handler = cpu_fault},
    [14] = {.handler = cpu_fault},  [15] = {.handler = cpu_systick},
};

uint32_t cpu_interrupts_off(void)
{
    uint32_t before;
    __asm volatile("mrs %0, primask\n\tcpsid i" : "=r"(before)::"memory");
    return before;
}

void cpu_interrupts_restore(uint32_t before)
{
    __asm volatile("msr primask, %0" ::"r"(before) : "memory");
}

void cpu_sleep(void)
{
    __asm volatile("dsb\n\twfi" ::: "memory");
}

uint64_t cpu_cycles(void)
{
    static uint64_t cycles;
    static uint32_t last = CPU_SYSTICK_LONGEST;
    if (CPU_SYSTICK_CONTROL == 0) {
        CPU_SYSTICK_RELOAD = CPU_SYSTICK_LONGEST;
        CPU_SYSTICK_VALUE = 0;
        CPU_SYSTICK_CONTROL = CPU_SYSTICK_COUNTS;
    }
    uint32_t value = CPU_SYSTICK_VALUE; /* counts down */
    cycles += (last - value) & CPU_SYSTICK_LONGEST;
    last = value;
    return cycles;
}

void cpu_interrupt_enable(unsigned int number)
{
    NVIC_ENABLE(number / 32) = UINT32_C(1) << (number % 32);
}

_Noreturn void cpu_run(uint32_t at)
{
    const uint32_t *first = (const uint32_t *)(uintptr_t)at;
    SCB_VTOR = at;
    __asm volatile("msr msp, %0\n\tbx %1" ::"r"(first[0]), "r"(first[1]) : "memory");
    __builtin_unreachable();
}

_Noreturn void cpu_reset(void)
{
    __asm volatile("dsb" ::: "memory");
    SCB_AIRCR = SYSTEM_RESET;
    for (;;) {
    }
}
