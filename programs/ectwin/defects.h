/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Twins with one deliberate defect, for tests of programs that find defects (`--break CF-nnn`).
 *
 * A filter between the wire and the chain changes requests and replies, datagram by datagram. Chip and stack are not
 * part of it, so the product carries no defect. The first twin of the chain has the defect.
 */
#ifndef ECTWIN_DEFECTS_H
#define ECTWIN_DEFECTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"

typedef struct defect_row defect_row_t;

/** Longest frame that is changed; longer frames pass unchanged. */
enum { DEFECT_FRAME = 1600 };

/** One defect at work; zero-initialise, then ::defect_choose. The members are private. */
typedef struct defect {
    const defect_row_t *row; /* NULL: none */
    uint8_t sent[DEFECT_FRAME];
    size_t length; /* of `sent`; 0: the frame passes unchanged */
    uint32_t memory[4];
} defect_t;

/** Selects a defect. @param id  "CF-016", "CF-087b". @return false: there is no such defect */
bool defect_choose(defect_t *defect, const char *id);

/** Visits all defects: those of cases in the order of their ids, then those for tests of the runner. */
void defect_list(void (*visit)(void *ctx, const char *id, const char *what), void *ctx);

/** Members of an ect_filter_t; ctx is a ::defect_t. */
void defect_before(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);
void defect_after(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length);

#endif
