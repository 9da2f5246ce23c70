/* SPDX-License-Identifier: MIT */
/*
 * Boards whose times twins can have. tests/check/cycles.sh counts the instructions on a Cortex-M4 and compares the
 * counts with this file.
 */
#include <string.h>

#include "bus/chain/slow_config.h"
#include "ports/lan9252/cost.h"
#include "ports/mmio/cost.h"

/* SPI at 20 MHz, and 168 cycles of a processor at 168 MHz for chip select and driver call of each transfer, as in
 * docs/LAN9252.md. */
enum { SPI_BYTE_NS = 400, SPI_TRANSFER_NS = 1000 };

static uint64_t lan9252_bus_ns(uint16_t address, uint16_t length, bool write)
{
    ect_lan9252_cost_t cost = ect_lan9252_cost(address, length, write);
    return (uint64_t)cost.bytes * SPI_BYTE_NS + (uint64_t)cost.transfers * SPI_TRANSFER_NS;
}

static uint32_t lan9252_instructions(uint16_t address, uint16_t length, bool write)
{
    enum { ACCESS = 480, BYTE = 4 };
    return ACCESS + BYTE * ect_lan9252_cost(address, length, write).bytes;
}

/* As in ports/mmio/mmio.h. */
enum { BUS_WIDTH = 2, BUS_NS = 300 };

static uint64_t et1100_bus_ns(uint16_t address, uint16_t length, bool write)
{
    (void)write;
    return (uint64_t)ect_mmio_cost(address, length, BUS_WIDTH) * BUS_NS;
}

static uint32_t et1100_instructions(uint16_t address, uint16_t length, bool write)
{
    enum { ACCESS = 330, READ = 42, WRITE = 30 };
    return ACCESS + (write ? WRITE : READ) * ect_mmio_cost(address, length, BUS_WIDTH);
}

static const ect_board_t boards[] = {
    {"lan9252-spi", "LAN9252, SPI at 20 MHz, microcontroller at 168 MHz, no interrupt pin", &ect_fit_lan9252,
     lan9252_bus_ns, lan9252_instructions},
    {"et1100-mmio", "ET1100, bus of 16 bits with 300 ns an access, microcontroller at 168 MHz, no interrupt pin",
     &ect_fit_et1100, et1100_bus_ns, et1100_instructions},
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

uint32_t ect_board_cycle(const char *device)
{
    static const struct {
        const char *device;
        uint32_t instructions;
    } cycles[] = {{"fzm1", 430}, {"optoncdt2300", 33000}, {"pmctendo-dd5", 14700}};
    for (size_t i = 0; i < sizeof cycles / sizeof cycles[0]; i++) {
        if (strcmp(cycles[i].device, device) == 0)
            return cycles[i].instructions;
    }
    return 0;
}

/* 1.5 cycles of 168 MHz each. */
uint64_t ect_board_ns(uint64_t instructions)
{
    enum { HALF_CYCLES = 3, MHZ = 168 };
    return instructions * HALF_CYCLES * 1000 / ((uint64_t)2 * MHZ);
}

uint64_t ect_board_access_ns(const ect_board_t *board, uint16_t address, uint16_t length, bool write)
{
    return board->bus_ns(address, length, write) + ect_board_ns(board->instructions(address, length, write));
}
