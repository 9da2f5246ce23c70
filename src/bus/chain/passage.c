/* SPDX-License-Identifier: MIT */
#include "bus/chain/passage.h"

#include "esc/route.h"
#include "wire/assert.h"

/* Receives the frame at a port. @return false: the frame ends */
static bool arrive(ect_twin_t *twin, unsigned int port, ect_passage_t *p)
{
    twin->last_frame_ns = p->now_ns;
    if (port != 0 && !ect_esc_port_open(&twin->esc, port)) {
        (void)ect_esc_frame_at(&twin->esc, port); /* an automatic loop opens: the next frame may pass */
        return false;
    }
    if (p->c.damaged) {
        ect_esc_damaged(&twin->esc, port, p->c.noticed);
        p->c.noticed = true;
        return !ect_esc_circulates(&twin->esc);
    }
    return port != 0 || ect_esc_pass(&twin->esc, p->c.frame, p->c.length, p->now_ns) == ECT_FRAME_FORWARD;
}

/* Returns false when the frame reaches an unlinked port 0 a second time (the ESC destroys it), or a port without link.
 */
static bool depart(ect_twin_t *twin, unsigned int *port, const ect_passage_t *p)
{
    *port = ect_esc_next_port(&twin->esc, *port);
    if (*port == 0 && ect_esc_circulates(&twin->esc)) {
        if (ect_esc_pass(&twin->esc, p->c.frame, p->c.length, p->now_ns) != ECT_FRAME_FORWARD)
            return false;
        *port = ect_esc_next_port(&twin->esc, 0);
    }
    return twin->link[*port]; /* the master may force a loop open at a port without a wire */
}

/* Passes the frame to the guard. @return false: the frame ends on the wire */
static bool cross_wire(ect_passage_t *p, size_t wire, bool back)
{
    p->c.wire = wire;
    p->c.back = back;
    return !p->guard || p->guard(p->guard_ctx, &p->c);
}

/* Passes one controller and the next wire. @return false: the frame ends */
static bool through(ect_cabling_t *cabling, ect_topology_place_t *at, ect_passage_t *p)
{
    ect_twin_t *twin = &cabling->twins[at->slave];
    return arrive(twin, at->port, p) && depart(twin, &at->port, p) &&
           cross_wire(p, ect_cabling_wire(cabling, *at), at->port == 0);
}

static ect_end_t walk(ect_cabling_t *cabling, ect_topology_place_t at, ect_passage_t *passage)
{
    while (through(cabling, &at, passage)) {
        ect_topology_place_t far;
        ect_topology_end_t end = ect_cabling_across(cabling, at, &far);
        if (end == ECT_TOPOLOGY_SLAVE)
            at = far;
        else if (passage->c.damaged || end == ECT_TOPOLOGY_OPEN)
            return ECT_END_NONE;
        else
            return end == ECT_TOPOLOGY_MASTER ? ECT_END_IN : ECT_END_OUT;
    }
    return ECT_END_NONE;
}

/* Ends the frame in all controllers at the same time, because loops change when no port transmits the frame any more
 * (data sheet II §2.4.1). */
ect_end_t ect_passage_walk(ect_cabling_t *cabling, ect_topology_place_t at, ect_passage_t *passage)
{
    ECT_ASSERT(cabling->twins[at.slave].link[at.port]);
    ect_end_t end = walk(cabling, at, passage);
    for (size_t i = 0; i < cabling->count; i++)
        ect_esc_end_of_frame(&cabling->twins[i].esc);
    return end;
}

ect_end_t ect_passage_enter(ect_cabling_t *cabling, ect_end_t in, ect_passage_t *passage)
{
    ect_topology_place_t at = {in == ECT_END_IN ? 0 : cabling->count - 1, in == ECT_END_IN ? 0 : 1};
    bool arrives =
        cabling->twins[at.slave].link[at.port] && cross_wire(passage, ect_cabling_wire(cabling, at), in == ECT_END_OUT);
    return arrives ? ect_passage_walk(cabling, at, passage) : ECT_END_NONE; /* else the cable ends in a dead port */
}

/* Finds the other end of a frame's wire. @return whether a slave is there; else the frame leaves the chain */
static bool far_end(const ect_cabling_t *cabling, const ect_crossing_t *c, ect_topology_place_t *to)
{
    ECT_ASSERT(c->wire <= cabling->count);
    if (c->wire == cabling->count)
        *to = (ect_topology_place_t){cabling->count - 1, 1};
    else if (c->wire == 0 || !c->back)
        *to = (ect_topology_place_t){c->wire, 0};
    else
        *to = (ect_topology_place_t){cabling->nodes[c->wire].up, cabling->nodes[c->wire].up_port};
    return c->wire != (c->back ? 0 : cabling->count);
}

bool ect_passage_arrival(const ect_cabling_t *cabling, const ect_crossing_t *c, ect_topology_place_t *at,
                         ect_end_t *out)
{
    bool inside = far_end(cabling, c, at);
    bool link = cabling->twins[at->slave].link[at->port];
    *out = c->damaged || !link ? ECT_END_NONE : c->back ? ECT_END_IN : ECT_END_OUT;
    return inside && link;
}
