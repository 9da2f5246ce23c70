/* SPDX-License-Identifier: MIT */
/* ectwin: EtherCAT device twins on a network interface. */
#include "ectwin.h"

int main(int argc, char **argv)
{
    return ectwin_main(argc, argv, NULL, 0);
}
