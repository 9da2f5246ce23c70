/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A small master for measurements: it knows the descriptions of the twins, so it asks them nothing.
 */
#ifndef TOOLS_BENCH_MASTER_H
#define TOOLS_BENCH_MASTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "seams/device.h"

enum { MASTER_FRAME = 1514, MASTER_STATION = 0x1001 };

/** A frame that goes and comes back. The caller sets `exchange` and `ctx`. */
typedef struct master {
    /** Sends frame[0..length) and puts the answer there. @return false: none came */
    bool (*exchange)(struct master *m);
    void *ctx;
    uint8_t frame[MASTER_FRAME];
    size_t length;
} master_t;

/** Builds a frame of one datagram, its data zero, 1..1486 bytes. */
void master_build(master_t *m, uint8_t command, uint16_t adp, uint16_t ado, uint16_t length);
uint8_t *master_data(master_t *m);
/** Working counter of the frame that came back. */
unsigned int master_counter(const master_t *m);

/** One datagram there and back. @param data  changed as the twins change it @return working counter, -1 no answer */
int master_send(master_t *m, uint8_t command, uint16_t adp, uint16_t ado, void *data, uint16_t length);

/** Gives `count` twins their station addresses, MASTER_STATION on. @return false: one did not answer */
bool master_address(master_t *m, size_t count);

/**
 * Brings a twin to OP, its process data from logical address *logical on, the watchdog off.
 * @param[in,out] logical   becomes the address behind its data
 * @param[in,out] expected  grows by what it adds to the working counter of an LRW
 * @return false: it does not get there
 */
bool master_operate(master_t *m, const ect_device_t *device, size_t position, uint32_t *logical,
                    unsigned int *expected);

/** Reads 1018h:1 by SDO. @return false: it did not work */
bool master_sdo(master_t *m, const ect_device_t *device, size_t position);

#endif
