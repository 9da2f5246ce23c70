/* SPDX-License-Identifier: MIT */
/* A fault of the processor, on a board without an operating system. */
#include "board.h"
#include "cpu.h"

void cpu_fault(void)
{
    board_fault();
}
