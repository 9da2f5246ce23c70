/* SPDX-License-Identifier: MIT */
#include "clock.h"
#include "cpu.h"

extern uint32_t cpu_stack_top[]; /* from flash.ld */

#define NVIC_ENABLE(n) REGISTER(0xE000E100 + 4 * (n))
#define SCB_VTOR       REGISTER(0xE000ED08)
#define SCB_AIRCR      REGISTER(0xE000ED0C)
#define SYSTEM_RESET   0x05FA0004u

#define MPU_TYPE       REGISTER(0xE000ED90)
#define MPU_CONTROL    REGISTER(0xE000ED94)
#define MPU_REGION     REGISTER(0xE000ED98)
#define MPU_BASE       REGISTER(0xE000ED9C)
#define MPU_ATTRIBUTES REGISTER(0xE000EDA0)
#define MPU_ON         5u          /* and the default map for privileged code outside the regions */
#define MPU_DEVICE     0x13050001u /* no code, full access, TEX 0 S 1 C 0 B 1, enabled */

#define DEBUG_CONTROL REGISTER(0xE000EDFC)
#define DWT_CONTROL   REGISTER(0xE0001000)
#define DWT_CYCLES    REGISTER(0xE0001004)
#define DWT_LOCK      REGISTER(0xE0001FB0) /* of a Cortex-M7 */
#define TRACE_ON      0x01000000u
#define UNLOCK        0xC5ACCE55u

/* A counter of 32 bits; 0 on a processor without this counter. */
#if __ARM_ARCH >= 7
static void count_cycles(void)
{
    DEBUG_CONTROL |= TRACE_ON;
    DWT_LOCK = UNLOCK;
    DWT_CYCLES = 0;
    DWT_CONTROL |= 1;
}

static uint32_t counted_cycles(void)
{
    return DWT_CYCLES;
}
#else
static void count_cycles(void)
{
}

static uint32_t counted_cycles(void)
{
    return 0;
}
#endif

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

/* The first word is the initial stack pointer, the second the entry point; the others are the vectors of exceptions. */
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
    static uint32_t last = CPU_SYSTICK_LONGEST, last_counted;
    if (CPU_SYSTICK_CONTROL == 0) {
        CPU_SYSTICK_RELOAD = CPU_SYSTICK_LONGEST;
        CPU_SYSTICK_VALUE = 0;
        CPU_SYSTICK_CONTROL = CPU_SYSTICK_COUNTS;
        count_cycles();
    }
    uint32_t counted = counted_cycles();
    uint32_t value = CPU_SYSTICK_VALUE;
    cycles += clock_elapsed(last, value, counted - last_counted);
    last = value;
    last_counted = counted;
    return cycles;
}

void cpu_device_memory(uint32_t base, unsigned int bits)
{
    uint32_t regions = MPU_TYPE >> 8 & 0xFF;
    if (regions == 0)
        return;
    __asm volatile("dmb" ::: "memory");
    MPU_REGION = regions - 1;
    MPU_BASE = base;
    MPU_ATTRIBUTES = MPU_DEVICE | (bits - 1) << 1;
    MPU_CONTROL = MPU_ON;
    __asm volatile("dsb\n\tisb" ::: "memory");
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
