/* SPDX-License-Identifier: MIT */
/*
 * Records the handshakes of an FZM1 in virtual time, as `ectwin watch --every` would.  usage: fzm1_record NAME
 * NAME: step images command scene handshaking period
 */
#include <stdio.h>
#include <string.h>

#include "support/sensor.h"

static const char *const signals[] = {"exe", "flg", "step", "ready", "busy", "dsa", "gate", "output1"};
enum { SIGNALS = sizeof signals / sizeof signals[0] };

static sensor_t s;
static uint64_t start_ns;
static char printed[SIGNALS][ECT_SIGNAL_TEXT_ROOM];

static void print_changes(void)
{
    for (unsigned int i = 0; i < SIGNALS; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        signal_get(&s.w, signals[i], text);
        if (strcmp(text, printed[i]) == 0)
            continue;
        snprintf(printed[i], sizeof printed[i], "%s", text);
        printf("{\"name\":\"%s\",\"value\":\"%s\",\"time\":%.6f}\n", signals[i], text,
               (double)(s.w.now_ns - start_ns) / 1e9);
    }
}

/* To `ms` after the start, printing each change on the way. */
static void to(unsigned int ms)
{
    uint64_t end = start_ns + ms * MS;
    while (s.w.now_ns < end) {
        uint64_t next = ect_chain_poll(s.w.chain, s.w.now_ns);
        wire_advance(&s.w, (next < end ? next : end) - s.w.now_ns);
        print_changes();
    }
}

static void set(unsigned int ms, uint32_t mask, bool on)
{
    to(ms);
    sensor_set(&s, mask, on);
    print_changes();
}

static void step_at(unsigned int ms, const char *value)
{
    to(ms);
    signal_set(&s.w, "data1", value);
    set(ms, FZM1_STEP, true);
    set(ms + 1, FZM1_STEP, false);
}

static void record_step(void)
{
    set(2, FZM1_STEP, true);
    set(4, FZM1_STEP, false);
    to(32);
}

static void record_images(void)
{
    step_at(2, "0");
    step_at(8, "0");
    step_at(14, "0");
    to(72);
}

static void record_command(void)
{
    sensor_prepare(&s, FZM1_GET_SCENE, 0, 0, 0);
    set(2, FZM1_EXE, true);
    set(5, FZM1_EXE, false);
    to(7);
}

static void record_scene(void)
{
    signal_set(&s.w, "switch_time", "20000");
    sensor_prepare(&s, FZM1_SWITCH_SCENE, 1, 0, 0);
    set(2, FZM1_EXE, true);
    set(25, FZM1_EXE, false);
    to(28);
}

static void record_handshaking(void)
{
    signal_set(&s.w, "output_control", "1");
    step_at(2, "11");
    step_at(8, "22");
    set(35, FZM1_DSA, true);
    set(38, FZM1_DSA, false);
    set(41, FZM1_DSA, true);
    set(54, FZM1_DSA, false);
    to(58);
}

static void record_period(void)
{
    signal_set(&s.w, "processing", "3000");
    step_at(2, "11");
    step_at(8, "22");
    step_at(14, "33");
    to(40);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*record)(void);
    } records[] = {{"step", record_step},   {"images", record_images},           {"command", record_command},
                   {"scene", record_scene}, {"handshaking", record_handshaking}, {"period", record_period}};
    for (size_t i = 0; argc == 2 && i < sizeof records / sizeof records[0]; i++) {
        if (strcmp(records[i].name, argv[1]) != 0)
            continue;
        sensor_open(&s);
        start_ns = s.w.now_ns;
        print_changes();
        records[i].record();
        sensor_close(&s);
        return 0;
    }
    fprintf(stderr, "usage: fzm1_record step|images|command|scene|handshaking|period\n");
    return 1;
}
