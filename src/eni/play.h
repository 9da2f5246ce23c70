/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Player of a network file (ENI): a master that sends the commands of the file unchanged and compares each reply with
 * the file. All decisions come from the file: a bus matches the file if the player reaches OP without a report.
 *
 *     ect_eni_player_t player = {.eni = eni, .wire = &wire};
 *     if (ect_eni_play(&player, ECT_ENI_OPERATIONAL))
 *         ... OP; ect_eni_play_cycle(&player) sends the cyclic frames once ...
 *
 * Each transition sends the commands of the master with `BeforeSlave`, the commands of the slaves in the order of the
 * file, and the other commands of the master. Mails of a slave, CoE before AoE, EoE and SoE, precede its other
 * commands, except at the transition to PREOP, which has no mailbox yet: there they follow the commands of all slaves.
 * Commands of FoE are not sent. A slave with mails and no other commands is brought to PREOP by the player, with the
 * mailbox of the file, and stays there. Output data are those of the file, zeros.
 * The start time of SYNC signals (0990h) is that of the file plus the slave's system time.
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
    ECT_ENI_FRAME = 1514,        /**< bytes of a frame without its check sum */
    ECT_ENI_MAX_TIMEOUT = 60000, /**< milliseconds for which a command is repeated; a longer `Timeout` counts as this */
};

/** The connection to the bus, provided by the caller. */
typedef struct ect_eni_wire {
    void *ctx;
    /** Sends a frame and overwrites it with the reply. @return false: no reply */
    bool (*exchange)(void *ctx, uint8_t *frame, size_t length);
    /** Returns after `ns` nanoseconds. */
    void (*wait)(void *ctx, uint64_t ns);
    /** Called with one line, without line end, for each reply that differs from the file. */
    void (*report)(void *ctx, const char *line);
} ect_eni_wire_t;

/** A player. The caller sets the first two members and zeroes the others. */
typedef struct ect_eni_player {
    const ect_eni_t *eni;
    const ect_eni_wire_t *wire;
    size_t reported;    /**< number of reports */
    unsigned int state; /**< present state: 0 or ECT_ENI_INIT, ECT_ENI_PREOP … */
    /* Private. */
    uint8_t index;    /* of the last datagram */
    uint64_t idle_ns; /* since the last cyclic frames */
    uint8_t frame[ECT_ENI_FRAME];
    uint8_t mail[ECT_ENI_DATA + 1];
    uint8_t mail_counters[ECT_ENI_SLAVES]; /* of the last mail to each slave, 1 to 7 */
} ect_eni_player_t;

ECT_C_BEGIN

/**
 * Runs the transitions up to a state. Each transition sends all its commands; the first transition with a report is the
 * last one.
 * @param state  ECT_ENI_PREOP, ECT_ENI_SAFEOP or ECT_ENI_OPERATIONAL; at least the present state
 * @return true: `state` is reached, and every reply matched the file
 */
bool ect_eni_play(ect_eni_player_t *player, unsigned int state);

/**
 * Sends the cyclic commands of the present state once and compares their working counters.
 * @return true: all working counters matched the file
 */
bool ect_eni_play_cycle(ect_eni_player_t *player);

ECT_C_END

#endif
