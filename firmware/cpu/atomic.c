/* SPDX-License-Identifier: MIT */
/* Functions that the compiler calls on a processor without an atomic instruction (Cortex-M0+; bytes on RISC-V). With
 * one processor, code without interrupts is atomic. */
#include "cpu.h"

/* Names and types are defined by the compiler. */
uint8_t __atomic_fetch_and_1(volatile void *at, uint8_t value, int order);
uint8_t __atomic_fetch_or_1(volatile void *at, uint8_t value, int order);
unsigned int __atomic_fetch_sub_4(volatile void *at, unsigned int value, int order);

uint8_t __atomic_fetch_and_1(volatile void *at, uint8_t value, int order)
{
    volatile uint8_t *byte = at;
    (void)order;
    uint32_t interrupts = cpu_interrupts_off();
    uint8_t before = *byte;
    *byte = before & value;
    cpu_interrupts_restore(interrupts);
    return before;
}

uint8_t __atomic_fetch_or_1(volatile void *at, uint8_t value, int order)
{
    volatile uint8_t *byte = at;
    (void)order;
    uint32_t interrupts = cpu_interrupts_off();
    uint8_t before = *byte;
    *byte = before | value;
    cpu_interrupts_restore(interrupts);
    return before;
}

unsigned int __atomic_fetch_sub_4(volatile void *at, unsigned int value, int order)
{
    volatile unsigned int *word = at;
    (void)order;
    uint32_t interrupts = cpu_interrupts_off();
    unsigned int before = *word;
    *word = before - value;
    cpu_interrupts_restore(interrupts);
    return before;
}
