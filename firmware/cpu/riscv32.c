/* SPDX-License-Identifier: MIT */
/* Interrupts are in direct mode: all call cpu_trap, which a board with interrupts defines. */
#include "cpu.h"

__asm(".option arch, +zicsr");

enum { MSTATUS_MIE = 8 };

__attribute__((weak)) void cpu_fault(void)
{
    for (;;) {
    }
}

__attribute__((weak, interrupt, aligned(4))) void cpu_trap(void)
{
    cpu_fault();
}

/* The first instructions of the image: disable interrupts, set the stack, the global pointer and the trap vector. */
__attribute__((section(".vectors.processor"), naked, used)) void cpu_entry(void)
{
    __asm volatile("csrci mstatus, 8\n\t"
                   ".option push\n\t"
                   ".option norelax\n\t"
                   "la gp, __global_pointer$\n\t"
                   ".option pop\n\t"
                   "la sp, cpu_stack_top\n\t"
                   "la t0, cpu_trap\n\t"
                   "csrw mtvec, t0\n\t"
                   "j cpu_start");
}

uint32_t cpu_interrupts_off(void)
{
    uint32_t before;
    __asm volatile("csrrci %0, mstatus, 8" : "=r"(before)::"memory");
    return before & MSTATUS_MIE;
}

void cpu_interrupts_restore(uint32_t before)
{
    __asm volatile("csrs mstatus, %0" ::"r"(before) : "memory");
}

void cpu_sleep(void)
{
    __asm volatile("wfi" ::: "memory");
}

uint64_t cpu_cycles(void)
{
    uint32_t high, low, again;
    do {
        __asm volatile("csrr %0, mcycleh" : "=r"(high));
        __asm volatile("csrr %0, mcycle" : "=r"(low));
        __asm volatile("csrr %0, mcycleh" : "=r"(again));
    } while (high != again);
    return (uint64_t)high << 32 | low;
}

void cpu_device_memory(uint32_t base, unsigned int bits)
{
    (void)base; /* physical memory attributes are the chip's */
    (void)bits;
}

/* Restarts the image with interrupts disabled, because RISC-V defines no common reset. */
_Noreturn void cpu_reset(void)
{
    __asm volatile("j cpu_entry" ::: "memory");
    __builtin_unreachable();
}
