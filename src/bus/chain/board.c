/* SPDX-License-Identifier: MIT */
/* Boards whose times twins can take. */
#include <string.h>

#include "bus/chain/slow_config.h"
#include "ports/lan9252/cost.h"

/* SPI at 20 MHz, and 168 cycles of a processor at 168 MHz for chip select and driver call of each transfer, as in
 * docs/LAN9252.md. */
enum { SPI_BYTE_NS = 400, SPI_TRANSFER_NS = 1000 };

static uint64_t lan9252_ns(uint16_t address, uint16_t length, bool write)
{
    ect_lan9252_cost_t cost = ect_lan9252_cost(address, length, write);
    return (uint64_t)cost.bytes * SPI_BYTE_NS + (uint64_t)cost.transfers * SPI_TRANSFER_NS;
}

static const ect_board_t boards[] = {
    {"lan9252-spi", "LAN9252, SPI at 20 MHz, microcontroller at 168 MHz, no interrupt pin", lan9252_ns},
};

const ect_board_t *ect_board_at(size_t index)
{
    return index < sizeof boards / sizeof boards[0] ? &boards[index] : NULL;
}

const ect_board_t *ect_board(const char *name)
{
    for (size_t i = 0; ect_board_at(i); i++) {
        if (strcmp(ect_board_at(i)->name, name) == 0)
            return ect_board_at(i);
    }
    return NULL;
}
