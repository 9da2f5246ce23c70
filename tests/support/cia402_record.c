/* SPDX-License-Identifier: MIT */
/*
 * Records the SERVO of tests/esi/drives.xml in virtual time, as `ectwin watch --every` would.  usage: cia402_record
 * NAME NAME: pp hm quick_stop. A turn has 10 000 increments; curves have a value each 4 ms.
 */
#include <stdio.h>
#include <string.h>

#include "../unit/esi/drive_of_file.h"

enum { TURN = 10000, CURVE_MS = 4, SIGNALS = 16, IMMEDIATE = 0x20, QUICK = 0x02 };
enum { HOME_AT = -12000, HOME_WIDTH = 6000 };

static struct {
    const char *name;
    int64_t value;
} printed[SIGNALS];
static uint64_t start_ns;

static void print(const char *name, int64_t value)
{
    unsigned int i = 0;
    while (printed[i].name != NULL && strcmp(printed[i].name, name) != 0)
        i++;
    assert_true(i < SIGNALS);
    if (printed[i].name != NULL && printed[i].value == value)
        return;
    printed[i].name = name;
    printed[i].value = value;
    printf("{\"name\":\"%s\",\"value\":\"%lld\",\"time\":%.6f}\n", name, (long long)value,
           (double)(wire.now_ns - start_ns) / 1e9);
}

static void print_levels(uint16_t control)
{
    const uint16_t status = (uint16_t)get(STATUS);
    print("bit 4", (control & 0x10) != 0);
    print("bit 5", (control & 0x20) != 0);
    print("bit 2", (control & 0x04) != 0);
    print("bit 10", (status & 0x400) != 0);
    print("bit 12", (status & 0x1000) != 0);
    print("enabled", state_of(status) == ENABLED);
    print("stopping", state_of(status) == STOPPING);
    const double at = signal_of("axis1.machine_position");
    print("switch", at >= HOME_AT && at <= HOME_AT + HOME_WIDTH);
}

static void to(unsigned int ms, uint16_t control, int32_t target)
{
    const uint64_t end = start_ns + ms * MS;
    put(CONTROL, control);
    put(TARGET, target);
    while (wire.now_ns < end) {
        cycles(1);
        print_levels(control);
        if ((wire.now_ns - start_ns) / MS % CURVE_MS != 0)
            continue;
        print("target", target);
        print("position", get(ACTUAL));
        print("speed", get(0x606C));
        print("torque", get(0x6077));
    }
}

static void begin(int8_t mode)
{
    servo(mode, TURN);
    signals("axis1.home_at", HOME_AT);
    signals("axis1.home_width", HOME_WIDTH);
    enable(0);
}

/* Times of the chart count from here. */
static void zero(void)
{
    start_ns = wire.now_ns;
    print("zero", 0);
    print("zero", 1);
}

/* Two set-points one after the other, and a third one that changes the motion at once. */
static void profile_position(void)
{
    begin(PP);
    zero();
    to(20, ENABLE, 0);
    to(40, START, 20000);
    to(200, ENABLE, 20000);
    to(220, START, 40000);
    to(1200, ENABLE, 40000);
    to(1220, START | IMMEDIATE, 10000);
    to(2600, ENABLE, 10000);
}

/* Method 21: the home switch is left, then its edge is found at the speed of 6099h:2. */
static void homing(void)
{
    begin(HM);
    assert_int_equal(write_sdo(0x6098, 0, 21, 1), 0);
    zero();
    to(20, ENABLE, 0);
    to(700, START, 0);
    to(800, ENABLE, 0);
}

/* 605Ah 5: brakes on 6084h and stays in Quick stop active, until 0Fh. 605Ah 2: brakes on 6085h, then Switch on
 * disabled. */
static void quick_stop(void)
{
    begin(PV);
    assert_int_equal(write_sdo(0x605A, 0, 5, 2), 0);
    zero();
    put(0x60FF, 40000);
    to(500, ENABLE, 0);
    to(1100, QUICK, 0);
    to(1700, ENABLE, 0);
    assert_int_equal(write_sdo(0x605A, 0, 2, 2), 0);
    to(2000, QUICK, 0);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        void (*run)(void);
    } rows[] = {{"pp", profile_position}, {"hm", homing}, {"quick_stop", quick_stop}};
    for (size_t i = 0; argc == 2 && i < COUNT(rows); i++) {
        if (strcmp(rows[i].name, argv[1]) != 0)
            continue;
        rows[i].run();
        return close_drive(NULL);
    }
    (void)fprintf(stderr, "usage: cia402_record pp|hm|quick_stop\n");
    return 1;
}
