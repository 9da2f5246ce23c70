/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Twins with one deliberate defect, for trying those who look for defects (`--break CF-nnn`).
 *
 * A filter between the wire and the chain: it changes what a slave is asked or what it answers, datagram by datagram.
 * The chips and the stack know nothing of it, so the product carries no defect. The first twin of the chain has it.
 */
#ifndef ECTWIN_DEFECTS_H
#define ECTWIN_DEFECTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"

typedef struct defect_row defect_row_t;

/** The longest frame that it looks at; longer ones pass as they are. */
enum { DEFECT_FRAME = 1600 };

/** One defect at work; zero-initialise, then ::defect_choose. The members are private. */
typedef struct defect {
    const defect_row_t *row; /* NULL: none */
    uint8_t sent[DEFECT_FRAME];
    size_t length; /* of it; 0: passed as it is */
    uint32_t memory[4];
} defect_t;

/** @param id  "CF-016". @return whether there is a defect for that case */
bool defect_choose(defect_t *defect, const char *id);

/** Visits all defects: those of cases in the order of their ids, then those for tests of the runner. */
void defect_list(void (*visit)(void *ctx, const char *id, const char *what), void *ctx);

/** As ect_filter_t wants them; ctx is a ::defect_t. */
void defect_before(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);
void defect_after(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);

#endif
