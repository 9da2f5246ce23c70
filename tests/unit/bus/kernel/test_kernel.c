/* SPDX-License-Identifier: MIT */
/*
 * The program in the kernel against the chain: random frames go to the program without an interface
 * (BPF_PROG_TEST_RUN); the frames that it holds pass the chain later, which must give the same replies. Without the
 * right to load programs the test is skipped.
 *
 * test_kernel [FRAMES]
 */
#include "bus/kernel/kernel.h"

#include <stdlib.h>
#include <string.h>

#include "bus/net/packet.h"
#include "seams/random.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { SLAVES = 3, ROOM = 200, AHEAD = 40, OF_A_CHAIN = 200 };

typedef struct rig {
    wire_t w;
    ect_kernel_t *kernel;
    uint32_t random;
    unsigned int replied, left;
    uint8_t frames[AHEAD][ROOM], replies[AHEAD][ROOM];
    size_t lengths[AHEAD];
} rig_t;

static unsigned int frames = 4000;

static uint32_t below(rig_t *r, uint32_t limit)
{
    return (uint32_t)(((uint64_t)ect_random_next(&r->random) * limit) >> 32);
}

static void set_up(rig_t *r)
{
    const ect_device_t *const devices[SLAVES] = {&testdev, &testdev, &testdev};
    uint8_t status[2] = {0};
    r->w = (wire_t){0};
    wire_open(&r->w, devices, SLAVES);
    for (size_t i = 0; i < SLAVES; i++) {
        wire_go(&r->w, i, 8);
        wire_set_fmmu(&r->w, i, 0, (uint32_t)(0x100 + 6 * i), 3, 0, 7, 0x1200, 0, 2);
        wire_set_fmmu(&r->w, i, 1, (uint32_t)(0x103 + 6 * i), 3, 0, 7, 0x1300, 0, 1);
    }
    (void)wire_send(&r->w, BRD, 0, ECT_REG_AL_STATUS, status, 2);
    r->w.manual_poll = true;
    r->w.now_ns = ect_packet_now();
    wire_poll(&r->w);
}

static void build(rig_t *r)
{
    uint8_t data[6 * SLAVES], time[8] = {0};
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)below(r, 256);
    wire_build(&r->w, below(r, 8) == 0 ? LRD : LRW, 0x100, 0, data, (uint16_t)(6 * (1 + below(r, SLAVES))));
    if (below(r, 2) == 0)
        wire_append(&r->w, BRD, 0, ECT_REG_AL_STATUS, time, 2);
    if (below(r, 4) == 0)
        wire_append(&r->w, FRMW, WIRE_STATION, ECT_REG_DC_SYSTEM_TIME, time, 8);
    if (below(r, 20) == 0)
        wire_append(&r->w, FPRD, WIRE_STATION, ECT_REG_DL_STATUS, time, 2);
    r->w.frame[17] = (uint8_t)below(r, 256);
    if (below(r, 30) == 0)
        r->w.frame[12 + below(r, 12)] ^= (uint8_t)(1u << below(r, 8));
}

/* With the microcontroller its watchdog of the PDI starts, and ends. */
static void stop_microcontroller(rig_t *r, size_t i)
{
    const ect_fault_t fault = {.kind = below(r, 6) == 0 ? ECT_FAULT_HANG : ECT_FAULT_RESUME,
                               .slave = (uint16_t)(i + 1)};
    assert_null(ect_chain_fault(r->w.chain, &fault, r->w.now_ns));
}

/* Each change that a plan may rest on. */
static void change(rig_t *r)
{
    size_t i = below(r, SLAVES);
    switch (below(r, 8)) {
    case 0:
        (void)wire_write16(&r->w, i, ECT_REG_FMMU + 16, (uint16_t)(0x103 + 6 * i + below(r, 2)));
        return;
    case 1:
        (void)wire_write16(&r->w, i, ECT_REG_ECAT_EVENT_MASK, (uint16_t)below(r, 65536));
        return;
    case 2:
        (void)wire_write8(&r->w, i, ECT_REG_SM + 8 * 3 + ECT_SM_ACTIVATE, (uint8_t)below(r, 2));
        return;
    case 3:
        (void)wire_write16(&r->w, i, ECT_REG_AL_CONTROL, below(r, 2) == 0 ? 4 : 8);
        return;
    case 4: /* inputs at the addresses of outputs, or behind these */
        (void)wire_write16(&r->w, i, ECT_REG_FMMU + 16, (uint16_t)(0x100 + 6 * i + 3 * below(r, 2)));
        return;
    case 5:
        stop_microcontroller(r, i);
        return;
    default:
        wire_poll(&r->w);
    }
}

static void same_reply(rig_t *r, unsigned int n)
{
    const ect_held_t *held = ect_kernel_next(r->kernel);
    assert_non_null(held);
    assert_int_equal(held->length, r->lengths[n]);
    assert_memory_equal(held->frame, r->frames[n], held->length);
    memcpy(r->w.frame, held->frame, held->length);
    r->w.frame_length = held->length;
    assert_true(held->time_ns >= r->w.now_ns);
    r->w.now_ns = held->time_ns;
    assert_true(wire_transmit(&r->w));
    assert_memory_equal(r->w.frame, r->replies[n], held->length);
}

/* Frames at a distance that leaves the pace of the devices out (bus/kernel/pace.h). */
static bool try_frame(rig_t *r, uint8_t *frame, size_t length)
{
    static uint64_t next_ns;
    while (ect_packet_now() < next_ns) {
    }
    bool replied = ect_kernel_try(r->kernel, frame, length);
    next_ns = ect_packet_now() + ECT_PACE_CLOSE_NS;
    return replied;
}

/* Frames until one is left to the process, or AHEAD have got their replies. @return their number */
static unsigned int run_ahead(rig_t *r, bool *left)
{
    unsigned int n = 0;
    *left = false;
    while (n < AHEAD && !*left) {
        build(r);
        memcpy(r->frames[n], r->w.frame, r->w.frame_length);
        memcpy(r->replies[n], r->w.frame, r->w.frame_length);
        r->lengths[n] = r->w.frame_length;
        if (try_frame(r, r->replies[n], r->lengths[n]))
            n++;
        else
            *left = true;
    }
    return n;
}

static bool is_ethercat(const uint8_t *frame)
{
    return frame[12] == 0x88 && frame[13] == 0xA4;
}

static void sleep_once(rig_t *r)
{
    bool left;
    ect_kernel_give(r->kernel, r->w.chain, ect_packet_now());
    unsigned int n = run_ahead(r, &left);
    uint8_t frame[ROOM];
    size_t length = r->w.frame_length;
    memcpy(frame, r->w.frame, length);
    ect_kernel_take(r->kernel);
    for (unsigned int i = 0; i < n; i++)
        same_reply(r, i);
    assert_null(ect_kernel_next(r->kernel));
    r->replied += n;
    r->w.now_ns = ect_packet_now();
    if (!left)
        return;
    r->left++;
    if (is_ethercat(frame))
        ect_kernel_got(r->kernel);
    ect_kernel_see(r->kernel, frame, length);
    memcpy(r->w.frame, frame, length);
    r->w.frame_length = length;
    (void)wire_transmit(&r->w);
}

static void same_as_the_chain(void **state)
{
    static rig_t r;
    char message[ECT_KERNEL_MESSAGE];
    (void)state;
    r.kernel = ect_kernel_load(message);
    if (!r.kernel) {
        print_message("%s\n", message);
        skip();
    }
    r.random = 1;
    for (unsigned int chains = 0; r.replied + r.left < frames; chains++) {
        if (!r.kernel)
            r.kernel = ect_kernel_load(message);
        assert_non_null(r.kernel);
        set_up(&r);
        while (r.replied + r.left < frames && r.replied + r.left < (chains + 1) * OF_A_CHAIN) {
            sleep_once(&r);
            if (below(&r, 16) == 0)
                change(&r);
        }
        ect_kernel_close(r.kernel);
        wire_close(&r.w);
        r.kernel = NULL;
    }
    print_message("%u replies in the kernel, %u frames left to the process\n", r.replied, r.left);
    assert_in_range(r.replied, frames / 10, frames + AHEAD);
}

/* How many of ten equal frames, one right behind the other, get their replies. */
static unsigned int ten_in_a_row(rig_t *r, bool new_outputs)
{
    uint8_t data[6] = {0};
    unsigned int replied = 0;
    if (new_outputs)
        data[0] = 1;
    wire_build(&r->w, LRW, 0x100, 0, data, sizeof data);
    ect_kernel_see(r->kernel, r->w.frame, r->w.frame_length);
    ect_kernel_give(r->kernel, r->w.chain, ect_packet_now());
    for (unsigned int i = 0; i < 10; i++) {
        uint8_t frame[ROOM];
        memcpy(frame, r->w.frame, r->w.frame_length);
        bool done = ect_kernel_try(r->kernel, frame, r->w.frame_length);
        if (!done)
            ect_kernel_got(r->kernel);
        replied += done;
    }
    ect_kernel_take(r->kernel);
    while (ect_kernel_next(r->kernel)) {
    }
    return replied;
}

/* A machine that stands still for a moment makes frames less close, so the smallest of many counts. */
static void reacting_devices(void **state)
{
    static rig_t r;
    char message[ECT_KERNEL_MESSAGE];
    unsigned int least = 10;
    (void)state;
    r.kernel = ect_kernel_load(message);
    if (!r.kernel) {
        print_message("%s\n", message);
        skip();
    }
    r.random = 1;
    set_up(&r);
    (void)ten_in_a_row(&r, false);
    for (unsigned int i = 0; i < 1000 && least > 1; i++) {
        unsigned int replied = ten_in_a_row(&r, i % 2 == 0);
        least = replied < least ? replied : least;
    }
    assert_in_range(least, 0, 1);
    ect_kernel_close(r.kernel);
    wire_close(&r.w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-002 CF-010 CF-028: the kernel gives the replies of the chain", same_as_the_chain, NULL, NULL, NULL},
        {"FZM-075: while outputs change, frames without a pause between them are left to the process", reacting_devices,
         NULL, NULL, NULL},
    };
    if (argc > 1)
        frames = (unsigned int)strtoul(argv[1], NULL, 10);
    return cmocka_run_group_tests_name("replies in the kernel", tests, NULL, NULL);
}
