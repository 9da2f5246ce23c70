/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A small master for measurements, which has the descriptions of the twins and therefore reads none of their data.
 */
#ifndef TOOLS_BENCH_MASTER_H
#define TOOLS_BENCH_MASTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "seams/device.h"

enum { MASTER_FRAME = 1514, MASTER_STATION = 0x1001 };

/** A frame and its return. The caller sets `exchange` and `ctx`. */
typedef struct master {
    /** Sends frame[0..length) and overwrites it with the reply. @return false: no reply */
    bool (*exchange)(struct master *m);
    void *ctx;
    uint8_t frame[MASTER_FRAME];
    size_t length;
} master_t;

/** Builds a frame of one datagram, its data zero, 1..1486 bytes. */
void master_build(master_t *m, uint8_t command, uint16_t adp, uint16_t ado, uint16_t length);
uint8_t *master_data(master_t *m);
/** @return the working counter of the returned frame. */
unsigned int master_counter(const master_t *m);

/** Exchanges one datagram. @param data  replaced by that of the reply @return working counter; -1: no reply */
int master_send(master_t *m, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length);

/** Sets the station addresses of `count` twins, from MASTER_STATION on. @return false: a twin did not reply */
bool master_address(master_t *m, size_t count);

/**
 * Takes a twin to OP, with its process data from logical address *logical on and the watchdog off.
 * @param[in,out] logical   set to the address after its data
 * @param[in,out] expected  increased by its part of the working counter of an LRW
 * @return false: OP is not reached
 */
bool master_operate(master_t *m, const ect_device_t *device, size_t position, uint32_t *logical,
                    unsigned int *expected);

/** Reads 1018h:1 by SDO. @return false: failed */
bool master_sdo(master_t *m, const ect_device_t *device, size_t position);

#endif
