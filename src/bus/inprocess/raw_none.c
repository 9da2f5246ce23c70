/* SPDX-License-Identifier: MIT */
/* For processors without Syscall User Dispatch: direct system calls are not intercepted. */
#include "bus/inprocess/raw.h"

bool ect_raw_is_on(void)
{
    return false;
}

void ect_raw_scan(void)
{
}

void ect_raw_thread(void)
{
}
