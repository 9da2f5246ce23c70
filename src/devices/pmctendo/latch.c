/* SPDX-License-Identifier: MIT */
/* Latch control and status word (manual §4.9): arm, catch an edge, read the value, independent of the cycle. */
#include "devices/pmctendo/instance.h"

enum { ALL = (1 << PMC_LATCHES) - 1, CODE_SHIFT = 8, CODE_MASK = 0x0F, INPUT_SHIFT = 15 };

/* The edge of each latch. Its position is the bit in both words; its read code is one more. */
static const struct {
    uint8_t line;
    bool rising;
    uint8_t shown; /* in latch position 1 or 2 */
} latches[PMC_LATCHES] = {
    {PMC_LATCH1, true, 0},  {PMC_LATCH1, false, 0},   {PMC_LATCH2, true, 1},
    {PMC_LATCH2, false, 1}, {ECT_402_INDEX, true, 0},
};

static uint16_t inputs(const pmctendo_t *u)
{
    unsigned int bits = 0;
    for (unsigned int line = 0; line < ECT_402_INPUTS; line++)
        bits |= (unsigned int)u->axis.level[line] << (INPUT_SHIFT - line);
    return (uint16_t)bits;
}

/* Copies the value selected by the control word, if a value is available. @return its acknowledge code */
static uint16_t answer(pmctendo_t *u)
{
    unsigned int code = u->latch_control >> CODE_SHIFT & CODE_MASK;
    if (code == 0 || code > PMC_LATCHES || (u->latch.valid & 1u << (code - 1)) == 0)
        return 0;
    u->latch_position[latches[code - 1].shown] = u->latch.value[code - 1];
    return (uint16_t)(code << CODE_SHIFT);
}

static void show(pmctendo_t *u)
{
    u->latch_status = (uint16_t)(u->latch.valid | answer(u) | inputs(u));
}

/* Arms a latch at the rising edge of its enable bit; the latched value is kept until the bit falls. */
void pmc_latch_control(pmctendo_t *u)
{
    pmc_latch_t *l = &u->latch;
    uint8_t enabled = u->latch_control & ALL;
    l->valid &= enabled;
    l->armed = enabled & (uint8_t)~l->valid;
    show(u);
}

void pmc_latch_edge(pmctendo_t *u, const ect_402_edge_t *edge)
{
    for (unsigned int i = 0; i < PMC_LATCHES; i++) {
        if (latches[i].line != edge->line || latches[i].rising != edge->rising || (u->latch.armed & 1u << i) == 0)
            continue;
        u->latch.value[i] = ect_402_counts(ect_402_user(&u->axis, edge->position));
        u->latch.valid |= (uint8_t)(1u << i);
        u->latch.armed &= (uint8_t)~(1u << i);
    }
    show(u);
}
