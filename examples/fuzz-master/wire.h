/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The wire between a master and twins in one process, on a virtual clock. Records change the replies of a run.
 *
 * A record has 8 bytes, little-endian: kind, option, place (16 bits), offset (16 bits), value (16 bits).
 *
 *     kind         place                         effect
 *     0 EEPROM     word address                  the word reads as `value`; option: number of further words
 *     1 register   address                       the byte reads as `value`, or 16 bits with option 1, from read
 *                                                number `offset` on
 *     2 mail       number, 0xFFFF: all           `value` at `offset` of the mail; option bits 0 and 1: 1, 2, 4 or 8
 *                                                bytes; bit 2: added; bit 3: exchanged with exclusive or
 *     3 mail data  number                        the next (value & 31) * 8 bytes of the input from `offset` on
 *     4 frame      number of the reply           option 0 lost, 1 twice, 2 cut to `offset` bytes, 3 `value` at
 *                                                `offset`, 4 after the next one, 5 `value` is the working counter
 */
#ifndef FUZZ_MASTER_WIRE_H
#define FUZZ_MASTER_WIRE_H

#include <stddef.h>
#include <stdint.h>

/**
 * Begins a run: switches the twins off and on.
 * @param devices  as for `ectwin with`; a bus is built once for each pointer
 * @param records  must stay valid until ::wire_end
 */
void wire_begin(const char *devices, const uint8_t *records, size_t size);

/** Ends a run. @return the number of frames sent by the master */
unsigned int wire_end(void);

#endif
