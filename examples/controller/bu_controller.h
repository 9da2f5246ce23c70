/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The machine controller's side of TS-0007: the handling of a base unit's process data in a PLC program.
 *
 * A template to copy, without bus and clock: call ::bu_controller_step once in each cycle, between reading the inputs
 * and sending the outputs, with the present time. It updates the counters of chapter 10 and reports commands through a
 * callback.
 *
 *   10.1  CCI changed: take the command, then CAO := CCI. Id 0 is no remote: the base unit was restarted
 *   10.2  command to send: wait for CAI = CCO, write it, CCO := CCO + 1
 *   10.3  PCI does not change for 500 ms: bring the machine to a safe state
 *   10.4  write a block of periodic data, PCO := PCO + 1; at the latest every 500 ms, the base unit waits for 2000 ms
 */
#ifndef ECTWIN_BU_CONTROLLER_H
#define ECTWIN_BU_CONTROLLER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { BU_COMMAND_BYTES = 16, BU_INPUT_BYTES = 66 };

typedef struct bu_controller {
    /* set before the first step */
    size_t output_bytes; /**< 0, 24 or 228: determines the available parts of the protocol */
    void (*on_command)(void *ctx, uint16_t ru, const uint8_t command[BU_COMMAND_BYTES]);
    void *ctx;
    const uint8_t *periodic; /**< data for the remotes' screens, owned by the caller; NULL: none */
    uint16_t periodic_size;  /**< 0..51200 */

    /* CCO and CAO, which may be kept over a restart, so that no command is lost or executed twice */
    bool counters_known;
    uint8_t cco, cao;

    /* read only */
    bool safe; /**< the machine must be in its safe state */
    uint32_t sets_sent;

    /* private */
    uint8_t pci, pco, block;
    bool running;
    uint64_t pci_deadline_ns, pco_deadline_ns;
    bool to_send;
    uint16_t send_ru;
    uint8_t send_data[BU_COMMAND_BYTES];
} bu_controller_t;

/** Call it when the bus has reached OP (again): the next step takes the unit's counters. Known counters are kept. */
void bu_controller_start(bu_controller_t *c);

/** Executes one cycle: reads `in` (66 or 142 bytes), writes `out` (output_bytes). */
void bu_controller_step(bu_controller_t *c, const uint8_t *in, uint8_t *out, uint64_t now_ns);

/** Sends a command to a remote unit (0: all). @return false: the previous command is not yet acknowledged */
bool bu_controller_send(bu_controller_t *c, uint16_t ru, const uint8_t command[BU_COMMAND_BYTES]);

#endif
