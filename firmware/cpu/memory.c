/* SPDX-License-Identifier: MIT */
/* Initialises memory for C, then calls main. */
#include "cpu.h"

/* From flash.ld. */
extern uint32_t cpu_data_from[], cpu_data[], cpu_data_end[], cpu_bss[], cpu_bss_end[];

int main(void);

_Noreturn void cpu_start(void)
{
    const uint32_t *from = cpu_data_from;
    for (uint32_t *to = cpu_data; to < cpu_data_end; to++)
        *to = *from++;
    for (uint32_t *to = cpu_bss; to < cpu_bss_end; to++)
        *to = 0;
    (void)main();
    cpu_reset();
}
