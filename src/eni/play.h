/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Plays a network file (ENI): a master that sends the commands of the file as they are written and compares each reply
 * with what the file expects. It decides nothing by itself, so a bus on which it reaches OP without a line is the bus
 * of the file.
 *
 *     ect_eni_player_t player = {.eni = eni, .wire = &wire};
 *     if (ect_eni_play(&player, ECT_ENI_OPERATIONAL))
 *         ... OP; ect_eni_play_cycle(&player) sends the cyclic frames once ...
 *
 * At each transition come the master's commands with `BeforeSlave`, those of the slaves in the order of the file, the
 * other ones of the master. CoE commands of a transition come before the commands of their slave, at the transition to
 * PREOP, where there is no mailbox yet, behind those of all slaves. Commands of the other mailbox protocols are not
 * sent. Output data are those of the file, zeros.
 *
 * Host only. Context: mainline. Clauses: ETG.2100.
 */
#ifndef ECT_ENI_PLAY_H
#define ECT_ENI_PLAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "eni/read.h"
#include "wire/linkage.h"

enum {
    ECT_ENI_FRAME = 1514,     /**< bytes of a frame without its check sum */
    ECT_ENI_PATIENCE = 60000, /**< milliseconds for which a command is repeated; a longer `Timeout` counts as this */
};

/** The way to the bus; the caller's. */
typedef struct ect_eni_wire {
    void *ctx;
    /** Sends a frame and waits for its reply, which replaces it. @return whether it came back */
    bool (*exchange)(void *ctx, uint8_t *frame, size_t length);
    /** Returns after `ns` nanoseconds. */
    void (*wait)(void *ctx, uint64_t ns);
    /** Takes a line, without its end: a reply that the file does not expect. */
    void (*report)(void *ctx, const char *line);
} ect_eni_wire_t;

/** The caller sets the first two members and zeroes the others. */
typedef struct ect_eni_player {
    const ect_eni_t *eni;
    const ect_eni_wire_t *wire;
    size_t reported;    /**< lines so far */
    unsigned int state; /**< reached: 0 or ECT_ENI_INIT, ECT_ENI_PREOP … */
    /* Private. */
    uint8_t index;    /* of the last datagram */
    uint64_t idle_ns; /* since the last cyclic frames */
    uint8_t frame[ECT_ENI_FRAME];
    uint8_t mail[ECT_ENI_DATA + 1];
    uint8_t mail_counters[ECT_ENI_SLAVES]; /* of the last mail to each slave, 1 to 7 */
} ect_eni_player_t;

ECT_C_BEGIN

/**
 * Goes up to a state, one transition after the other. Each transition sends all its commands, and one with a line is
 * the last.
 * @param state  ECT_ENI_PREOP, ECT_ENI_SAFEOP or ECT_ENI_OPERATIONAL; at least the present state
 * @return true: `state` is reached, and every reply was as the file expects
 */
bool ect_eni_play(ect_eni_player_t *player, unsigned int state);

/**
 * Sends the cyclic commands of the present state once and compares their working counters.
 * @return true: all were as the file expects
 */
bool ect_eni_play_cycle(ect_eni_player_t *player);

ECT_C_END

#endif
