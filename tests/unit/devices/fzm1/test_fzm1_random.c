/* SPDX-License-Identifier: MIT */
/*
 * A PLC with random actions: edges at any time, cycles from 250 us to 50 ms, cycles that are lost. Between
 * its cycles the test checks the sensor at each change.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/sensor.h"

enum { SEEDS = 300, CYCLES = 1500 };

static sensor_t s;
static uint32_t state_of_generator;

static uint32_t draw(uint32_t below)
{
    state_of_generator ^= state_of_generator << 13;
    state_of_generator ^= state_of_generator >> 17;
    state_of_generator ^= state_of_generator << 5;
    return state_of_generator % below;
}

/* The signals before, against which impossible changes are found. */
typedef struct watch {
    uint32_t control;
    int32_t output[FZM1_DATA];
    uint32_t response[3];
    uint32_t exe; /* level that the sensor has read */
} watch_t;

static watch_t seen;
static unsigned int seed, accepted;

static void refuse(const char *what)
{
    fail_msg("seed %u: %s (control signals were %05X, are %05X)", seed, what, seen.control, sensor_read(&s));
}

static watch_t observe(void)
{
    watch_t now = {.control = sensor_read(&s), .exe = sensor_instance(&s)->levels & FZM1_EXE};
    memcpy(now.response, s.in + 4, sizeof now.response);
    memcpy(now.output, s.in + 16, sizeof now.output);
    return now;
}

static void judge(void)
{
    watch_t now = observe();
    uint32_t rising = now.control & ~seen.control;
    bool gate_kept = (now.control & seen.control & FZM1_GATE) != 0;
    if (gate_kept && memcmp(now.output, seen.output, sizeof now.output) != 0)
        refuse("data changed while GATE was on");
    if ((now.control & seen.control & FZM1_FLG) != 0 && memcmp(now.response, seen.response, sizeof now.response) != 0)
        refuse("the response changed while FLG was on");
    if ((rising & FZM1_FLG) != 0 && now.response[0] != sensor_instance(&s)->code)
        refuse("FLG without the response to the command");
    if ((now.control & FZM1_FLG) != 0 && now.exe == 0)
        refuse("FLG without EXE");
    if ((now.control & (FZM1_READY | FZM1_BUSY)) == 0)
        refuse("neither READY nor BUSY");
    if ((now.control & FZM1_RUN) == 0)
        refuse("RUN went off");
    seen = now;
}

/* Advances the time and checks each event in it. */
static void pass(uint64_t ns)
{
    uint64_t end = s.w.now_ns + ns;
    while (s.w.now_ns < end) {
        uint64_t next = ect_chain_poll(s.w.chain, s.w.now_ns);
        wire_advance(&s.w, (next < end ? next : end) - s.w.now_ns);
        judge();
    }
}

static void next_outputs(void)
{
    static const uint32_t codes[] = {FZM1_CLEAR,        FZM1_GET_SCENE,     FZM1_GET_GROUP,
                                     FZM1_SWITCH_SCENE, FZM1_GET_UNIT_DATA, FZM1_SET_UNIT_DATA,
                                     FZM1_SWITCH_GROUP, 0x12345678,         FZM1_SAVE};
    uint32_t levels = ect_load_le32(s.out);
    static const uint32_t signals[] = {FZM1_EXE, FZM1_STEP, FZM1_DSA};
    for (unsigned int i = 0; i < 3; i++)
        levels ^= draw(3) == 0 ? signals[i] : 0;
    if (draw(4) == 0)
        sensor_prepare(&s, codes[draw(sizeof codes / sizeof codes[0])], (int32_t)draw(5), (int32_t)draw(14),
                       (int32_t)draw(2) * 1000);
    ect_store_le32(s.out, levels);
}

/* A STEP is accepted if it rises while the sensor shows READY and no command clears READY at that moment. */
static void exchange(void)
{
    fzm1_t *u = sensor_instance(&s);
    uint64_t image_before = u->image_due_ns;
    assert_int_equal(wire_write(&s.w, 0, 0x1100, s.out, sizeof s.out), 1);
    accepted += image_before == ECT_NEVER && u->image_due_ns != ECT_NEVER;
    judge();
}

static void session(unsigned int number)
{
    char text[16];
    seed = number;
    state_of_generator = 2463534242u + number * 7919;
    accepted = 0;
    sensor_open(&s);
    memset(&seen, 0, sizeof seen);
    signal_set(&s.w, "output_control", number % 2 ? "1" : "0");
    signal_set(&s.w, "timeout", "5");
    snprintf(text, sizeof text, "%u", 100 + draw(20000));
    signal_set(&s.w, "image_input", text);
    snprintf(text, sizeof text, "%u", 100 + draw(60000));
    signal_set(&s.w, "processing", text);
    snprintf(text, sizeof text, "%u", draw(3) * 700);
    signal_set(&s.w, "command_time", text);
    snprintf(text, sizeof text, "%u", draw(3));
    signal_set(&s.w, "camera", text);
    signal_set(&s.w, "source1", "1");
    uint64_t cycle = 250000 + draw(8) * draw(8) * 1000000ull;
    for (unsigned int n = 0; n < CYCLES; n++) {
        next_outputs();
        if (draw(20) != 0) /* else this cycle is lost */
            exchange();
        pass(cycle);
    }
    memset(s.out, 0, sizeof s.out); /* without inputs all work ends */
    exchange();
    pass(200000 * MS);
    if ((sensor_read(&s) & (FZM1_READY | FZM1_BUSY)) != FZM1_READY)
        refuse("READY is stuck");
    long long measured = signal_number(&s.w, "measurements");
    long long shown = signal_number(&s.w, "outputs") + signal_number(&s.w, "discarded") + signal_number(&s.w, "lost");
    if (measured != accepted || shown != accepted)
        fail_msg("seed %u: %u STEPs accepted, %lld measured, %lld output, given up or lost", seed, accepted, measured,
                 shown);
    sensor_close(&s);
}

static void random_plc(void **state)
{
    (void)state;
    for (unsigned int number = 0; number < SEEDS; number++)
        session(number);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"FZM-063 FZM-070 FZM-071 FZM-073 FZM-075: a random PLC: no undefined combination, each accepted STEP is "
         "one "
         "result",
         random_plc, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 random PLC", tests, NULL, NULL);
}
