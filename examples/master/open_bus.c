/* SPDX-License-Identifier: MIT */
#include "open_bus.h"

#include <net/if.h>
#include <stdio.h>

#include "ethercat.h"

bool open_bus(const char *program, const char *iface)
{
    if (if_nametoindex(iface) == 0)
        fprintf(stderr, "%s: there is no network interface '%s': 'ip -br link' lists those there are\n", program,
                iface);
    else if (ec_init(iface))
        return true;
    else
        fprintf(
            stderr,
            "%s: cannot open '%s' as an EtherCAT master's: that needs CAP_NET_RAW (sudo, or run it by 'ectwin with') "
            "and an Ethernet interface\n",
            program, iface);
    return false;
}
