/* SPDX-License-Identifier: MIT */
#include "bus/net/sandbox.h"

int ect_sandbox_enter(bool children, bool files)
{
    (void)children;
    (void)files;
    return 0;
}
