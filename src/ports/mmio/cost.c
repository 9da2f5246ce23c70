/* SPDX-License-Identifier: MIT */
#include "ports/mmio/cost.h"

#include "seams/pdi.h"

uint32_t ect_mmio_cost(uint16_t address, uint16_t length, unsigned int width)
{
    uint32_t accesses = 0;
    for (uint32_t done = 0; done < length; accesses++)
        done += ect_pdi_part(address + done, length - done, width);
    return accesses;
}
