/* SPDX-License-Identifier: MIT */
#include "eni/bus.h"

#include <stdio.h>

#include "eni/internal.h"

/* @return the slave before `i` with a station address; `i`: none */
static size_t slave_at(const ect_eni_network_t *network, size_t i, uint16_t address)
{
    for (size_t k = i; k-- > 0;) {
        if (network->slaves[k].address == address)
            return k;
    }
    return i;
}

bool ect_eni_place(const ect_eni_t *eni, size_t i, ect_eni_place_t *place, char *text, size_t room)
{
    const ect_eni_network_t *network = ect_eni_network(eni);
    const ect_eni_previous_t *previous = &network->slaves[i].previous;
    ECT_ASSERT(i < network->slave_count);
    *place = (ect_eni_place_t){.port = 0};
    if (i == 0 || !previous->given)
        return true;
    place->up = previous->address != 0 ? slave_at(network, i, previous->address) : i - 1;
    place->port = previous->port;
    if (place->up == i)
        (void)snprintf(text, room, "%s:%d: PreviousPort has the PhysAddr %u, which no previous slave has",
                       ect_eni_file(eni), previous->line, previous->address);
    else if (place->port == 0)
        (void)snprintf(text, room, "%s:%d: PreviousPort has Port A, which leads to the master", ect_eni_file(eni),
                       previous->line);
    return place->up != i && place->port != 0;
}

bool ect_eni_is_of_boot(const ect_eni_command_t *command)
{
    return command->transitions != 0 && (command->transitions & ~(unsigned int)(ECT_ENI_IB | ECT_ENI_BI)) == 0;
}

uint16_t ect_eni_alias(const ect_eni_slave_t *slave)
{
    return slave->identification.given ? (uint16_t)slave->identification.value : 0;
}
