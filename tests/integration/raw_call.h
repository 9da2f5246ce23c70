/* SPDX-License-Identifier: MIT */
/** @file
 * A system call of the program itself (x86-64). */
#ifndef RAW_CALL_H
#define RAW_CALL_H

/** @return the kernel's result: negative error numbers */
static inline long raw_call(long number, long a, long b, long c, long d, long e, long f)
{
    long result;
    register long r10 __asm__("r10") = d;
    register long r8 __asm__("r8") = e;
    register long r9 __asm__("r9") = f;
    __asm__ volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(a), "S"(b), "d"(c), "r"(r10), "r"(r8), "r"(r9)
                     : "rcx", "r11", "memory");
    return result;
}

#endif
