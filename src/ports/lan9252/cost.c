/* SPDX-License-Identifier: MIT */
#include "ports/lan9252/cost.h"

#include "seams/pdi.h"

/* A transfer of one or two words, and the words of a FIFO. */
enum { HEAD = 3, WORD = 4, ONE = HEAD + WORD, TWO = HEAD + 2 * WORD, FIFO_WORDS = 16 };

static void add(ect_lan9252_cost_t *cost, uint32_t transfers, uint32_t bytes)
{
    cost->transfers += transfers;
    cost->bytes += bytes;
}

/* Command, status, data; a write sends its data with the command. */
static void add_register(ect_lan9252_cost_t *cost, bool write)
{
    if (write)
        add(cost, 2, TWO + ONE);
    else
        add(cost, 3, ONE + ONE + ONE);
}

/* Command; status and data for each filling of the FIFO; at the end of a write the status again. */
static void add_ram(ect_lan9252_cost_t *cost, uint16_t address, uint32_t length, bool write)
{
    uint32_t words = (address % WORD + length + WORD - 1) / WORD;
    uint32_t fillings = (words + FIFO_WORDS - 1) / FIFO_WORDS;
    add(cost, 1 + 2 * fillings, TWO + (ONE + HEAD) * fillings + WORD * words);
    if (write)
        add(cost, 1, ONE);
}

ect_lan9252_cost_t ect_lan9252_cost(uint16_t address, uint16_t length, bool write)
{
    ect_lan9252_cost_t cost = {0, 0};
    for (uint32_t done = 0; done < length;) {
        uint16_t at = (uint16_t)(address + done);
        uint32_t left = length - done;
        if (at >= ECT_RAM) {
            add_ram(&cost, at, left, write);
            return cost;
        }
        add_register(&cost, write);
        done += ect_pdi_part(at, left, WORD);
    }
    return cost;
}
