/* SPDX-License-Identifier: MIT */
/* Touch probes: 60B8h arms, an edge stores the position at its place. Probe 1 is the probe input, probe 2 the home
 * switch. */
#include "profiles/cia402/drive.h"

enum { ON = 0x01, CONTINUOUS = 0x02, SOURCE_SHIFT = 2, SOURCE_MASK = 3, EDGE_SHIFT = 4, PROBE_SHIFT = 8 };
enum { BY_INPUT, BY_INDEX, BY_60D0 };
enum { INPUT_1 = 1, INPUT_2 = 2, ZERO_PULSE = 5 };
enum { NO_LINE = 0xFF };

int32_t ect_402_drive_position(const ect_402_drive_t *d, double machine)
{
    bool turned = (d->value[ECT_402_V_POLARITY] & 0x80) != 0;
    double user = ect_402_user(&d->axis, machine);
    double count = ect_402_counts(turned ? -user : user);
    return ect_402_counts(ect_402_folded(&d->axis, count));
}

static uint8_t line_of(const ect_402_drive_t *d, unsigned int n)
{
    static const uint8_t inputs[ECT_402_PROBES] = {ECT_402_PROBE, ECT_402_HOME};
    switch (d->probe[n].function >> SOURCE_SHIFT & SOURCE_MASK) {
    case BY_INPUT:
        return inputs[n];
    case BY_INDEX:
        return ECT_402_INDEX;
    case BY_60D0:
        break;
    default:
        return NO_LINE;
    }
    switch (d->value[n == 0 ? ECT_402_V_PROBE_SOURCE_1 : ECT_402_V_PROBE_SOURCE_2]) {
    case INPUT_1:
        return inputs[0];
    case INPUT_2:
        return inputs[1];
    case ZERO_PULSE:
        return ECT_402_INDEX;
    default:
        return NO_LINE;
    }
}

/* Arms a probe at a rising edge of bit 0 or of the bit of an edge. */
static void control(ect_402_probe_t *p, uint16_t function)
{
    uint16_t rising = function & (uint16_t)~p->function;
    for (unsigned int e = 0; e < 2; e++) {
        uint16_t edge = (uint16_t)(1u << (EDGE_SHIFT + e));
        bool wanted = (function & ON) != 0 && (function & edge) != 0;
        if (!wanted)
            p->armed[e] = false;
        else if ((rising & (ON | edge)) != 0)
            p->armed[e] = true;
        if ((function & ON) == 0)
            p->stored[e] = p->toggle[e] = false;
    }
    p->function = function;
}

void ect_402_drive_probe_control(ect_402_drive_t *d)
{
    for (unsigned int n = 0; n < ECT_402_PROBES; n++) {
        uint16_t function = (uint16_t)d->value[ECT_402_V_PROBE] >> (n * PROBE_SHIFT) & 0xFF;
        if (function != d->probe[n].function)
            control(&d->probe[n], function);
    }
}

static void store(const ect_402_drive_t *d, ect_402_probe_t *p, const ect_402_edge_t *edge)
{
    unsigned int e = edge->rising ? 0 : 1;
    if (!p->armed[e])
        return;
    p->value[e] = ect_402_drive_position(d, edge->position);
    p->stored[e] = true;
    p->edges[e]++;
    if ((p->function & CONTINUOUS) == 0)
        p->armed[e] = false;
    else
        p->toggle[e] = !p->toggle[e];
}

void ect_402_drive_probe_edges(ect_402_drive_t *d)
{
    for (unsigned int n = 0; n < ECT_402_PROBES; n++) {
        uint8_t line = line_of(d, n);
        for (unsigned int i = 0; i < d->axis.edges; i++) {
            if (d->axis.edge[i].line == line)
                store(d, &d->probe[n], &d->axis.edge[i]);
        }
    }
}

static unsigned int status_of(const ect_402_probe_t *p)
{
    return (p->function & ON) | (p->stored[0] ? 0x02u : 0u) | (p->stored[1] ? 0x04u : 0u) |
           (p->toggle[0] ? 0x40u : 0u) | (p->toggle[1] ? 0x80u : 0u);
}

void ect_402_drive_probe_publish(const ect_402_drive_t *d)
{
    static const uint8_t values[ECT_402_PROBES][2] = {{ECT_402_V_PROBE_1_POSITIVE, ECT_402_V_PROBE_1_NEGATIVE},
                                                      {ECT_402_V_PROBE_2_POSITIVE, ECT_402_V_PROBE_2_NEGATIVE}};
    static const uint8_t counts[ECT_402_PROBES][2] = {{ECT_402_V_PROBE_1_POSITIVES, ECT_402_V_PROBE_1_NEGATIVES},
                                                      {ECT_402_V_PROBE_2_POSITIVES, ECT_402_V_PROBE_2_NEGATIVES}};
    unsigned int status = 0;
    if (d->links[ECT_402_V_PROBE].bytes == 0)
        return;
    for (unsigned int n = 0; n < ECT_402_PROBES; n++) {
        status |= status_of(&d->probe[n]) << (n * PROBE_SHIFT);
        for (unsigned int e = 0; e < 2; e++) {
            ect_402_store(d->instance, &d->links[values[n][e]], d->probe[n].value[e]);
            ect_402_store(d->instance, &d->links[counts[n][e]], d->probe[n].edges[e]);
        }
    }
    ect_402_store(d->instance, &d->links[ECT_402_V_PROBE_STATUS], status);
}
