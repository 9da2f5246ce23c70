/* SPDX-License-Identifier: MIT */
/*
 * Frames into a chain of two twins. The input is a row of frames: a length byte pair, a byte of milliseconds that pass
 * before it, and the frame's bytes; where those are missing the frame is short.
 */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain.h"
#include "devices/eclink/eclink.h"
#include "support/testdev.h"
#include "wire/bytes.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(const ect_slave_t *slave)
{
    uint8_t state = slave->state;
    assert(state == 1 || state == 2 || state == 4 || state == 8);
    assert(slave->error == (slave->code != 0));
    assert(slave->outputs_live == (state == 8));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const ect_twin_config_t twins[] = {ect_twin_default(&ect_eclink_map7, &ect_eclink_plant),
                                       ect_twin_default(&testdev, NULL)};
    uint64_t now_ns = 1;
    ect_chain_t *chain = ect_chain_new(twins, 2, now_ns);
    while (chain && size >= 3) {
        size_t length = ect_load_le16(data) % 2100u;
        now_ns += data[2] * 1000000ull;
        data += 3;
        size -= 3;
        size_t there = length < size ? length : size;
        uint8_t *frame = malloc(there > 0 ? there : 1); /* of exactly that size: any step beyond it is seen */
        if (!frame)
            break;
        memcpy(frame, data, there);
        (void)ect_chain_process(chain, frame, there, now_ns);
        (void)ect_chain_poll(chain, now_ns);
        check(ect_chain_slave(chain, 0));
        check(ect_chain_slave(chain, 1));
        free(frame);
        data += there;
        size -= there;
    }
    ect_chain_free(chain);
    return 0;
}
