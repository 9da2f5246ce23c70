/* SPDX-License-Identifier: MIT */
/** @file Larger steps, shared by several sections. */
#ifndef ECTWIN_CONFORM_BEYOND_H
#define ECTWIN_CONFORM_BEYOND_H

#include "steps/case.h"

/**
 * Sends malformed mails, frames and requests without lasting effects. After each round a standard start-up must
 * succeed. With `rounds` 0, the last round may be shorter.
 * @param rounds  0: for the seconds of --fuzz
 * @param each    number of mails, frames and requests in a round
 * @return number of mails, frames and requests sent
 */
unsigned long cf_fuzz_rounds(cf_t *c, unsigned int rounds, unsigned int each);

/**
 * Takes the slave to OP as a master does, and assigns the EEPROM to the slave, so no malformed request writes it.
 * @return vendor id, 0 without CoE
 */
uint64_t cf_start_up(cf_t *c);

/**
 * Sends each datagram command, header field and length once, in a fixed order, with a start-up after each kind.
 * @return number of mails, frames and requests
 */
unsigned long cf_sweep(cf_t *c);

/** CF-085: Ethernet over EtherCAT. */
void cf_ethernet(cf_t *c);
/** CF-E01, CF-E05: IP parameters, complete and truncated. */
void cf_eoe_parameters(cf_t *c);
void cf_eoe_short_parameters(cf_t *c);
/** CF-E02: frames of each length, in both directions. */
void cf_eoe_lengths(cf_t *c);
/** CF-E03: fragments that do not belong together. */
void cf_eoe_wrong_fragments(cf_t *c);
/** CF-E04: time stamps, repeated mails, the counter 0. */
void cf_eoe_repeats(cf_t *c);
/** CF-E07: SDOs between fragments and frames. */
void cf_eoe_beside_sdo(cf_t *c);
/** CF-E08: INIT in the middle of a frame, and BOOT. */
void cf_eoe_restart(cf_t *c);
/** CF-E06: SOEM's and IgH's ways to set an address. */
void cf_eoe_masters(cf_t *c);
/** CF-E09: pings, and a master that fetches nothing for 10 s. */
void cf_eoe_pings(cf_t *c);
/** CF-E10: random fragments. */
void cf_eoe_random(cf_t *c);
/** CF-E11: EoE in the SII and in the ESI file. */
void cf_eoe_described(cf_t *c);
/** CF-E12: unknown types, ports and mails. */
void cf_eoe_unsupported(cf_t *c);
/** CF-A01: state, name and identity by AoE. */
void cf_ads_reads(cf_t *c);
/** CF-A02: unknown groups, objects, commands, and lengths. */
void cf_ads_refusals(cf_t *c);
/** CF-S01: SoE requests that no drive serves. */
void cf_soe_refusals(cf_t *c);
/** CF-S02: elements of each IDN. */
void cf_soe_elements(cf_t *c);
/** CF-S03: refused writes. */
void cf_soe_writes(cf_t *c);
/** CF-S04: drives of the SII, and those beyond. */
void cf_soe_drives(cf_t *c);
/** CF-S05: replies and writes in pieces. */
void cf_soe_pieces(cf_t *c);
/** CF-S06: process data by S-0-0016 and S-0-0024. */
void cf_soe_process_data(cf_t *c);

#endif
