/* SPDX-License-Identifier: MIT */
#include "support/testdev.h"

#include "support/wire.h"

testdev_t *testdev_of(struct wire *w, size_t position)
{
    return ect_chain_slave(w->chain, position)->config.instance;
}
