/* SPDX-License-Identifier: MIT */
/* On a Cortex-M7: the window of an ESC is device memory, and a fault of the processor ends in board_fault. */
#include "cpu.h"
#include "board.h"
#include "semihosting.h"

#define MPU_TYPE       REGISTER(0xE000ED90)
#define MPU_CONTROL    REGISTER(0xE000ED94)
#define MPU_REGION     REGISTER(0xE000ED98)
#define MPU_BASE       REGISTER(0xE000ED9C)
#define MPU_ATTRIBUTES REGISTER(0xE000EDA0)

enum {
    WINDOW = 0x60000000,
    WINDOW_BITS = 16,
    WRITE_TEXT = 4,
    END = 0x18,
    CLEAN = 0x20026,
    FAILED = 0x20023,
    NOWHERE = 0x55550000
};

static _Noreturn void end(const char *text, bool clean)
{
    semihosting_write(text);
    semihosting_end(clean);
}

/* ARMv7-M ARM, B3.5: no execution, full access, TEX 0 C 0 B 1 (shareable device), the size, enabled. */
static void expect_device_memory(void)
{
    if ((MPU_TYPE >> 8 & 0xFF) == 0)
        end("this processor has no MPU\n", false);
    if (MPU_CONTROL != 5)
        end("the MPU is off, or has no default map behind it\n", false);
    MPU_REGION = (MPU_TYPE >> 8 & 0xFF) - 1;
    if ((MPU_BASE & ~0x1Fu) != WINDOW)
        end("the last region is elsewhere\n", false);
    uint32_t attributes = MPU_ATTRIBUTES;
    if ((attributes & 1) == 0 || (attributes >> 1 & 0x1F) != WINDOW_BITS - 1)
        end("the region is off, or has another size\n", false);
    if ((attributes >> 28 & 1) != 1 || (attributes >> 24 & 7) != 3 || (attributes >> 19 & 7) != 0 ||
        (attributes >> 16 & 3) != 1)
        end("the region is no device memory\n", false);
}

_Noreturn void board_fault(void)
{
    end("a fault ended in board_fault\n", true);
}

int main(void)
{
    cpu_device_memory(WINDOW, WINDOW_BITS);
    expect_device_memory();
    uint64_t before = cpu_cycles();
    if (cpu_cycles() < before)
        end("the clock goes back\n", false);
    REGISTER(NOWHERE) = 1;
    end("a write to nowhere is no fault\n", false);
}
