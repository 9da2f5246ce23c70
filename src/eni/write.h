/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Writes network files (ENI, ETG.2100) of devices, for masters that need one.
 *
 * The slaves have the station addresses 1001, 1002 …, their default PDOs, no synchronisation by clocks, and the
 * start-up commands that their descriptions have. Outputs lie in the logical memory from 10000h on, inputs from
 * 1000000h on, each slave at a byte of its own; one LWR and one LRD, or several where a datagram is full, exchange
 * them. The same devices in the same order give the same bytes.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ENI_WRITE_H
#define ECT_ENI_WRITE_H

#include <stddef.h>
#include <stdint.h>

#include "eni/part.h"
#include "esi/arena.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * Writes a file.
 * @param parts, count  1 to 64535, in bus order
 * @param cycle_us      cycle of the process data, microseconds
 * @param[out] length   bytes of the file, without the zero behind them
 * @param[out] text, room  the reason of the failure, one line
 * @return the file (UTF-8), as long as the arena; NULL: too many slaves, or no memory left
 */
const char *ect_eni_write(ect_arena_t *arena, const ect_eni_part_t *parts, size_t count, uint32_t cycle_us,
                          size_t *length, char *text, size_t room);

ECT_C_END

#endif
