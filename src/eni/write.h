/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Writes network files (ENI, ETG.2100) of devices, for masters that need one.
 *
 * The slaves have the station addresses 1001, 1002 …, their default PDOs, the start-up commands of their descriptions,
 * and the clocks and hot-connect groups of their parts. Each mailbox with a free FMMU has a bit in the logical memory
 * from 9000000h on. Outputs lie in the logical memory from 10000h on, inputs from 1000000h on; the data of each slave
 * begin at a byte. One LWR and one LRD exchange the data, or several if they exceed a datagram. The same devices in the
 * same order result in the same bytes.
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
 * @param[out] length   bytes of the file, without the terminator
 * @param[out] text, room  the reason of the failure, one line
 * @return the file (UTF-8), valid as long as the arena; NULL: too many slaves, or out of memory
 */
const char *ect_eni_write(ect_arena_t *arena, const ect_eni_part_t *parts, size_t count, uint32_t cycle_us,
                          size_t *length, char *text, size_t room);

ECT_C_END

#endif
