/* SPDX-License-Identifier: MIT */
/*
 * Records the data that a master reads from an optoNCDT 2300 in virtual time, in the format of `ectwin watch --every`.
 * usage: optoncdt_record profile|vibration
 *
 * 10 kHz, ten records in an exchange, an exchange each millisecond: the drawing shows the data on the wire.
 */
#include <stdio.h>
#include <string.h>

#include "support/ranger.h"

enum { SAMPLES = 10, COUNTER = 0, TIME, DISTANCE_1, DISTANCE_2, VALUES };

static ranger_t r;
static int32_t printed[VALUES], begun;

static void print_change(const char *name, unsigned int which, int32_t value, int32_t time_us)
{
    if (printed[which] != value)
        printf("{\"name\":\"%s\",\"value\":\"%d\",\"time\":%.6f}\n", name, value, time_us / 1e6);
    printed[which] = value;
}

/* Prints the new records. */
static void exchange(void)
{
    ranger_wait(&r, 1 * MS);
    for (unsigned int n = 0; n < SAMPLES; n++) {
        int32_t counter = ranger_value(&r, VALUES * n + COUNTER);
        int32_t time_us = ranger_value(&r, VALUES * n + TIME) - begun;
        if (counter <= printed[COUNTER])
            continue;
        printed[COUNTER] = counter;
        print_change("distance1", DISTANCE_1, ranger_value(&r, VALUES * n + DISTANCE_1), time_us);
        print_change("distance2", DISTANCE_2, ranger_value(&r, VALUES * n + DISTANCE_2), time_us);
    }
}

static void set(const char *name, const char *value)
{
    signal_set(&r.w, name, value);
}

static void row(const char *mm, const char *present, unsigned int times)
{
    set("row1", mm);
    set("row_present", present);
    for (unsigned int n = 0; n < times; n++)
        set("row_add", "1");
}

/* A part on a belt: a step, a hole without a reflection, a slope, and its end. */
static unsigned int profile(void)
{
    char mm[16];
    row("14", "1", 8);
    row("8", "1", 12);
    row("14", "0", 5);
    row("8", "1", 6);
    for (unsigned int n = 1; n <= 16; n++) {
        snprintf(mm, sizeof mm, "%.3f", 8 + n * 0.25);
        row(mm, "1", 1);
    }
    row("14", "1", 8);
    set("row_time", "1000");
    set("surface1.noise", "0.02");
    set("surface1.source", "3");
    return 54;
}

/* A plate of glass that moves out of the measuring range: both of its surfaces are visible. */
static unsigned int vibration(void)
{
    set("surface1.distance", "15");
    set("surface2.distance", "17");
    set("surface2.present", "1");
    for (unsigned int n = 1; n <= 2; n++) {
        char name[32];
        snprintf(name, sizeof name, "surface%u.amplitude", n);
        set(name, "4");
        snprintf(name, sizeof name, "surface%u.period", n);
        set(name, "25000");
        snprintf(name, sizeof name, "surface%u.source", n);
        set(name, "2");
    }
    return 60;
}

int main(int argc, char **argv)
{
    bool is_profile = argc == 2 && strcmp(argv[1], "profile") == 0;
    if (!is_profile && (argc != 2 || strcmp(argv[1], "vibration") != 0)) {
        fprintf(stderr, "usage: optoncdt_record profile|vibration\n");
        return 1;
    }
    ranger_open(&r);
    ranger_expert(&r);
    ranger_write(&r, 0x2250, 1, 10000, 4);
    ranger_select(&r, 1 << OPTO_COUNTER | 1 << OPTO_TIMESTAMP | 1 << OPTO_DISTANCE_1 | 1 << OPTO_DISTANCE_2, SAMPLES);
    ranger_go(&r, ECT_STATE_OP);
    for (unsigned int n = 0; n < 20; n++) /* until the rhythm is stable */
        ranger_wait(&r, 1 * MS);
    unsigned int cycles = is_profile ? profile() : vibration();
    begun = ranger_value(&r, VALUES * (SAMPLES - 1) + TIME);
    printed[COUNTER] = ranger_value(&r, VALUES * (SAMPLES - 1) + COUNTER);
    while (cycles-- > 0)
        exchange();
    ranger_close(&r);
    return 0;
}
