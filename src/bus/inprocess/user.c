/* SPDX-License-Identifier: MIT */
/* Copies that a fault ends. The handler recognises a fault by the place of the instruction, as kernels do: neither a
 * signal handler of the program during a copy, nor its longjmp(), can leave a wrong state. */
#define _GNU_SOURCE
#include "bus/inprocess/user.h"

#include <signal.h>
#include <stdint.h>
#include <ucontext.h>

#include "bus/inprocess/actions.h"

/* A function without a stack frame, so that the handler can continue at the label ect_user_failed, which returns 1. It
 * copies pieces of 64 or 16 bytes, then those that the low bits of the length state. @return 0 */
int ect_user_copy(void *to, const void *from, size_t length);
extern const char ect_user_failed[];

#if defined __x86_64__
#define PLACE(context) ((context)->uc_mcontext.gregs[REG_RIP])
__asm__(".text\n"
        ".globl ect_user_copy, ect_user_failed\n"
        ".hidden ect_user_copy, ect_user_failed\n"
        ".type ect_user_copy, @function\n"
        ".balign 16\n"
        "ect_user_copy:\n"
        "    sub $64, %rdx\n"
        "    jb 2f\n"
        "1:  movups (%rsi), %xmm0\n"
        "    movups 16(%rsi), %xmm1\n"
        "    movups 32(%rsi), %xmm2\n"
        "    movups 48(%rsi), %xmm3\n"
        "    movups %xmm0, (%rdi)\n"
        "    movups %xmm1, 16(%rdi)\n"
        "    movups %xmm2, 32(%rdi)\n"
        "    movups %xmm3, 48(%rdi)\n"
        "    add $64, %rsi\n"
        "    add $64, %rdi\n"
        "    sub $64, %rdx\n"
        "    jae 1b\n"
        "2:  add $48, %rdx\n"
        "    jnc 4f\n"
        "3:  movups (%rsi), %xmm0\n"
        "    movups %xmm0, (%rdi)\n"
        "    add $16, %rsi\n"
        "    add $16, %rdi\n"
        "    sub $16, %rdx\n"
        "    jae 3b\n"
        "4:  test $8, %dl\n"
        "    jz 5f\n"
        "    mov (%rsi), %rax\n"
        "    mov %rax, (%rdi)\n"
        "    add $8, %rsi\n"
        "    add $8, %rdi\n"
        "5:  test $4, %dl\n"
        "    jz 6f\n"
        "    mov (%rsi), %eax\n"
        "    mov %eax, (%rdi)\n"
        "    add $4, %rsi\n"
        "    add $4, %rdi\n"
        "6:  test $2, %dl\n"
        "    jz 7f\n"
        "    movzwl (%rsi), %eax\n"
        "    mov %ax, (%rdi)\n"
        "    add $2, %rsi\n"
        "    add $2, %rdi\n"
        "7:  test $1, %dl\n"
        "    jz 8f\n"
        "    movzbl (%rsi), %eax\n"
        "    mov %al, (%rdi)\n"
        "8:  xor %eax, %eax\n"
        "    ret\n"
        "ect_user_failed:\n"
        "    mov $1, %eax\n"
        "    ret\n"
        ".size ect_user_copy, . - ect_user_copy\n");
#else
#define PLACE(context) ((context)->uc_mcontext.pc)
__asm__(".text\n"
        ".globl ect_user_copy, ect_user_failed\n"
        ".hidden ect_user_copy, ect_user_failed\n"
        ".type ect_user_copy, %function\n"
        ".balign 16\n"
        "ect_user_copy:\n"
        "1:  subs x2, x2, #16\n"
        "    b.lo 2f\n"
        "    ldp x3, x4, [x1], #16\n"
        "    stp x3, x4, [x0], #16\n"
        "    b 1b\n"
        "2:  tbz x2, #3, 3f\n"
        "    ldr x3, [x1], #8\n"
        "    str x3, [x0], #8\n"
        "3:  tbz x2, #2, 4f\n"
        "    ldr w3, [x1], #4\n"
        "    str w3, [x0], #4\n"
        "4:  tbz x2, #1, 5f\n"
        "    ldrh w3, [x1], #2\n"
        "    strh w3, [x0], #2\n"
        "5:  tbz x2, #0, 6f\n"
        "    ldrb w3, [x1]\n"
        "    strb w3, [x0]\n"
        "6:  mov w0, #0\n"
        "    ret\n"
        "ect_user_failed:\n"
        "    mov w0, #1\n"
        "    ret\n"
        ".size ect_user_copy, . - ect_user_copy\n");
#endif

/* Not instrumented: the handler may run on any stack. */
__attribute__((no_sanitize("address"))) static void on_fault(int number, siginfo_t *info, void *context)
{
    ucontext_t *at = context;
    uintptr_t place = (uintptr_t)PLACE(at);
    bool of_kernel = info->si_code > 0; /* not sent by kill() */
    if (of_kernel && place >= (uintptr_t)&ect_user_copy && place < (uintptr_t)ect_user_failed)
        PLACE(at) = (__typeof__(PLACE(at)))(uintptr_t)ect_user_failed;
    else
        ect_action_run(number, info, context);
}

__attribute__((constructor)) static void begin(void)
{
    (void)ect_action_take(SIGSEGV, on_fault, ECT_AS_PROGRAM);
    (void)ect_action_take(SIGBUS, on_fault, ECT_AS_PROGRAM);
}

bool ect_user_read(void *to, const void *from, size_t length)
{
    return ect_user_copy(to, from, length) == 0;
}

bool ect_user_write(void *to, const void *from, size_t length)
{
    return ect_user_copy(to, from, length) == 0;
}
