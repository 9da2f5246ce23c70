/* SPDX-License-Identifier: MIT */
/* Processors whose kernel has no dispatch of system calls: calls that pass the C library are not seen. */
#include "bus/inprocess/raw.h"

bool ect_raw_is_on(void)
{
    return false;
}

void ect_raw_look(void)
{
}

void ect_raw_thread(void)
{
}
