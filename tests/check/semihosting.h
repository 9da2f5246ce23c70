/* SPDX-License-Identifier: MIT */
/** @file Output and end of a program for a Cortex-M in QEMU. */
#ifndef CHECK_SEMIHOSTING_H
#define CHECK_SEMIHOSTING_H

#include <stdbool.h>
#include <stdint.h>

static inline void semihosting_call(uint32_t number, uintptr_t argument)
{
    register uint32_t r0 __asm__("r0") = number;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

/** Writes a text to QEMU's standard error. */
static inline void semihosting_write(const char *text)
{
    semihosting_call(4, (uintptr_t)text);
}

static inline _Noreturn void semihosting_end(bool clean)
{
    semihosting_call(0x18, clean ? 0x20026 : 0x20023);
    for (;;) {
    }
}

#endif
