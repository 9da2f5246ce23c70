/* SPDX-License-Identifier: MIT */
/* Which records an exchange holds (A 7.6): as many as PDOs are assigned, the oldest first. */
#include "devices/optoncdt2300/instance.h"
#include "wire/bytes.h"

/*
 * One: the last one. Several: those that follow what the master has, so that it gets each of them once, though it may
 * come a little early or late. When there are not as many, or it is so late that three times as many wait: the last
 * ones.
 */
void opto_inputs(void *instance, uint64_t now_ns)
{
    opto_t *u = instance;
    opto_advance(u, now_ns);
    uint64_t waiting = u->taken - u->sent;
    bool in_turn = u->assigned > 1 && waiting >= u->assigned && waiting < 3u * u->assigned;
    u->shown = in_turn ? u->sent + u->assigned : u->taken;
}

void opto_inputs_read(void *instance, uint64_t now_ns)
{
    opto_t *u = instance;
    (void)now_ns;
    u->sent = u->shown;
}

/* While there are fewer records than samples the first one stands there several times. */
void opto_inputs_packed(void *instance, unsigned int sm, uint8_t *image, uint16_t size)
{
    opto_t *u = instance;
    const uint8_t *end = image + size;
    (void)sm;
    for (uint64_t age = u->assigned; age > 0 && image < end; age--) {
        const int32_t *values = opto_kept(u, u->shown > age ? u->shown - age : 0);
        for (unsigned int n = 0; n < u->mapped; n++, image += sizeof *values)
            ect_store_le32(image, (uint32_t)values[n]);
    }
}
