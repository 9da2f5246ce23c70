/* SPDX-License-Identifier: MIT */
#include "bus/sandbox.h"

int ect_sandbox_enter(bool children)
{
    (void)children;
    return 0;
}
