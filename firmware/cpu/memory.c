/* SPDX-License-Identifier: MIT */
/* Memory as C expects it, and how deep the stack has been. */
#include "cpu.h"

/* From flash.ld. */
extern uint32_t cpu_stack_bottom[], cpu_stack_top[];
extern uint32_t cpu_data_from[], cpu_data[], cpu_data_end[], cpu_bss[], cpu_bss_end[];

#define STACK_UNUSED 0x57ACF111u

int main(void);

/* All below the present frame, but for some room for that itself. */
static void paint_stack(void)
{
    const uint32_t *here = (const uint32_t *)__builtin_frame_address(0) - 16;
    for (uint32_t *word = cpu_stack_bottom; word < here; word++)
        *word = STACK_UNUSED;
}

_Noreturn void cpu_start(void)
{
    paint_stack();
    const uint32_t *from = cpu_data_from;
    for (uint32_t *to = cpu_data; to < cpu_data_end; to++)
        *to = *from++;
    for (uint32_t *to = cpu_bss; to < cpu_bss_end; to++)
        *to = 0;
    (void)main();
    cpu_reset();
}

size_t cpu_stack_size(void)
{
    return (size_t)(cpu_stack_top - cpu_stack_bottom) * sizeof(uint32_t);
}

size_t cpu_stack_used(void)
{
    const uint32_t *word = cpu_stack_bottom;
    while (word < cpu_stack_top && *word == STACK_UNUSED)
        word++;
    return (size_t)(cpu_stack_top - word) * sizeof(uint32_t);
}
