/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The turn: one atomic word that states whether the kernel or the program may use the plans of a chain, and how many
 * frames the kernel has left to the program.
 *
 * The program owns the chain whenever its loop runs, and gives the turn away before it sleeps. The kernel takes the
 * turn for one frame at a time. A frame that arrives while the turn is taken, or has no plan, goes to the program, and
 * so do all later frames until the program has received each of them: frames never overtake. Neither side waits for the
 * other, except the program for the kernel's present frame (about a microsecond, in which the kernel is not preempted).
 *
 * Either side may be stopped at any instruction: plans, images and held frames have one user at a time, so none is torn
 * or lost; frames that arrive meanwhile wait for the program.
 *
 * Freestanding, for user space and BPF.
 */
#ifndef ECT_BUS_KERNEL_TURN_H
#define ECT_BUS_KERNEL_TURN_H

#include <stdbool.h>
#include <stdint.h>

/** The turn, in the lowest bits of the word. Above are the frames left to the program, modulo 2^62. */
enum { ECT_TURN_FREE = 0, ECT_TURN_KERNEL = 1, ECT_TURN_PROGRAM = 2, ECT_TURN_MASK = 3, ECT_TURN_FRAME = 4 };

/**
 * The word, and the number of frames received by the program when it gave the turn away. The turn is free only while
 * this number equals the frames left to the program.
 */
typedef struct ect_turn {
    uint64_t word;
    uint64_t got;
} ect_turn_t;

static inline uint64_t ect_turn_load(const uint64_t *from)
{
    return *(const volatile uint64_t *)from;
}

/* @return whether the turn is free, and no frame is on its way to the program. */
static inline bool ect_turn_is_free(const ect_turn_t *turn, uint64_t word)
{
    return (word & ECT_TURN_MASK) == ECT_TURN_FREE && word >> 2 == ect_turn_load(&turn->got);
}

/**
 * Called by the kernel for a frame. @return whether the kernel has the turn; else the frame counts as left to the
 * program
 */
static inline bool ect_turn_begin(ect_turn_t *turn)
{
    uint64_t old = ect_turn_load(&turn->word);
    if (ect_turn_is_free(turn, old) && __sync_val_compare_and_swap(&turn->word, old, old + ECT_TURN_KERNEL) == old)
        return true;
    (void)__sync_fetch_and_add(&turn->word, ECT_TURN_FRAME);
    return false;
}

/** Called by the kernel after a frame. @param left  the frame is left to the program, which then has the turn */
static inline void ect_turn_end(ect_turn_t *turn, bool left)
{
    uint64_t given = left ? ECT_TURN_FRAME + ECT_TURN_PROGRAM - ECT_TURN_KERNEL : (uint64_t)-ECT_TURN_KERNEL;
    (void)__sync_fetch_and_add(&turn->word, given);
}

/** Called by the program, which has the turn afterwards. */
static inline void ect_turn_take(ect_turn_t *turn)
{
    for (;;) {
        uint64_t old = ect_turn_load(&turn->word);
        if ((old & ECT_TURN_MASK) == ECT_TURN_PROGRAM)
            break;
        if ((old & ECT_TURN_MASK) == ECT_TURN_FREE &&
            __sync_val_compare_and_swap(&turn->word, old, old + ECT_TURN_PROGRAM) == old)
            break;
    }
    __sync_synchronize();
}

/**
 * Called by the program, with the turn. @param got frames received by the program so far. @return false: further frames
 * are on their way
 */
static inline bool ect_turn_give(ect_turn_t *turn, uint64_t got)
{
    uint64_t mine = got << 2 | ECT_TURN_PROGRAM;
    *(volatile uint64_t *)&turn->got = got;
    __sync_synchronize();
    return __sync_val_compare_and_swap(&turn->word, mine, mine - ECT_TURN_PROGRAM) == mine;
}

/** @return the frames left to the program so far. */
static inline uint64_t ect_turn_left(const ect_turn_t *turn)
{
    return ect_turn_load(&turn->word) >> 2;
}

#endif
