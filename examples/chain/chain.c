/* SPDX-License-Identifier: MIT */
/* Twins in this process: frames, signals, a fault and ten minutes of bus time, without a network and without a clock.
 * usage: chain [OPTION...] DEVICE[,DEVICE...]    options as those of `ectwin with` */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "bus/library.h"

#define SECOND_NS 1000000000u

enum { BRD = 7, AL_STATUS = 0x0130, LENGTH = 60, COUNTER_AT = 28, DATA_AT = 26 };

/* An Ethernet frame with one datagram: a broadcast read of the AL status. */
static void make_frame(uint8_t frame[LENGTH])
{
    static const uint8_t head[] = {
        0xFF,
        0xFF,
        0xFF,
        0xFF,
        0xFF,
        0xFF,
        0x02,
        0,
        0,
        0,
        0,
        1,
        0x88,
        0xA4, /* to all, from 02:00:00:00:00:01 */
        14,
        0x10, /* a datagram of 14 bytes */
        BRD,
        0,
        0,
        0,
        AL_STATUS & 0xFF,
        AL_STATUS >> 8,
        2,
        0,
        0,
        0 /* which reads 2 bytes */
    };
    memset(frame, 0, LENGTH);
    memcpy(frame, head, sizeof head);
}

/* @return the working counter of the reply; -1: no reply */
static int ask(ectwin_bus_t *bus, uint64_t now_ns, uint8_t *state)
{
    uint8_t frame[LENGTH];
    unsigned int end;
    make_frame(frame);
    ectwin_bus_frame(bus, 0, frame, sizeof frame, now_ns);
    if (ectwin_bus_reply(bus, &end, frame, sizeof frame) == 0)
        return -1;
    *state = frame[DATA_AT];
    return frame[COUNTER_AT] | frame[COUNTER_AT + 1] << 8;
}

static int lost_frames(ectwin_bus_t *bus, uint64_t *now_ns)
{
    int lost = 0;
    uint8_t state;
    for (int i = 0; i < 10; i++) {
        *now_ns += SECOND_NS;
        lost += ask(bus, *now_ns, &state) < 0;
    }
    return lost;
}

int main(int argc, char *argv[])
{
    char text[ECTWIN_MESSAGE];
    uint64_t now_ns = 0;
    uint8_t state = 0;
    ectwin_bus_t *bus = ectwin_bus_open(argc - 1, (const char *const *)argv + 1, now_ns, text);
    if (!bus) {
        fprintf(stderr, "chain: %s\n", text);
        return 1;
    }
    int counter = ask(bus, now_ns, &state);
    printf("%d of %zu slaves reply, AL status %u\n", counter, ectwin_bus_slaves(bus), state);

    if (ectwin_bus_get(bus, 1, "ecat.state", text, sizeof text) == 0)
        printf("ecat.state = %s\n", text);
    if (ectwin_bus_set(bus, 1, "nosuch", "1", now_ns, text, sizeof text) != 0)
        printf("refused: %s\n", text);

    if (ectwin_bus_fault(bus, "drop every 2", now_ns, text, sizeof text) == 0)
        printf("of 10 frames %d are lost\n", lost_frames(bus, &now_ns));

    uint64_t end_ns = now_ns + 600ull * SECOND_NS;
    unsigned int runs = 0;
    for (uint64_t next_ns = ectwin_bus_run(bus, now_ns); next_ns < end_ns; runs++)
        next_ns = ectwin_bus_run(bus, next_ns);
    printf("%u runs of the devices in 600 s of bus time\n", runs);
    ectwin_bus_close(bus);
    return 0;
}
