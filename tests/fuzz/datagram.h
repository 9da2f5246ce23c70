/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A master's datagrams, for fuzz targets.
 */
#ifndef TESTS_FUZZ_DATAGRAM_H
#define TESTS_FUZZ_DATAGRAM_H

#include <string.h>

#include "bus/chain/chain.h"
#include "wire/bytes.h"

enum { FPRD = 4, FPWR = 5, FUZZ_FRAME = 1600 };

/* One datagram to station address 0, that of an unconfigured slave; then the devices run. `data` gets the reply's.
 * @return working counter */
static inline unsigned int fuzz_send(ect_chain_t *chain, uint64_t now_ns, uint8_t command, uint16_t address,
                                     uint8_t *data, uint16_t length)
{
    uint8_t frame[FUZZ_FRAME] = {0};
    frame[12] = 0x88;
    frame[13] = 0xA4;
    ect_store_le16(frame + 14, (uint16_t)(0x1000 | (length + 12)));
    frame[16] = command;
    ect_store_le16(frame + 20, address);
    ect_store_le16(frame + 22, length);
    memcpy(frame + 26, data, length);
    (void)ect_chain_process(chain, frame, 28u + length, now_ns);
    (void)ect_chain_poll(chain, now_ns);
    memcpy(data, frame + 26, length);
    return frame[26 + length];
}

#endif
