/* SPDX-License-Identifier: MIT */
/* Selection of the records of an exchange (A 7.6): one for each assigned PDO, the oldest first. */
#include "devices/optoncdt2300/instance.h"
#include "wire/bytes.h"

/*
 * A single sample is the last record. Several samples are the first unread records, so that the master reads each
 * record once, even if it is early or late; with fewer unread records, or with three times as many, the last records.
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

/* Repeats the first record if there are fewer records than samples. */
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
