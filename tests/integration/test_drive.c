/* SPDX-License-Identifier: MIT */
/*
 * A drive of an ESI file under SOEM, as its users run it: mode by SDO, OP, enabled by status word, ten turns in csp, a
 * fault and its reset, a reference run, off.  usage: test_drive IFACE [TEST]
 */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <string.h>

#include "plant.h"
#include "soem.h"

enum { CONTROL = 0, MODE = 2, TARGET = 4, OUT = 14 };   /* 1600h of SERVO */
enum { STATUS = 0, SHOWN = 2, ACTUAL = 4, ERROR = 14 }; /* 1A00h */
enum { SOD = 0x40, READY = 0x21, SWITCHED_ON = 0x23, ENABLED = 0x27, FAULT = 0x08, PATIENCE = 20000 };
enum { HM = 6, CSP = 8, TURN = 1048576 };

static const char *iface;
static soem_t master;

static uint8 *out(void)
{
    return master.slaves[1].outputs;
}

static uint16 status(void)
{
    uint16 word;
    memcpy(&word, master.slaves[1].inputs + STATUS, sizeof word);
    return etohs(word);
}

static int32 position(void)
{
    int32 counts;
    memcpy(&counts, master.slaves[1].inputs + ACTUAL, sizeof counts);
    return etohl(counts);
}

static void set_target(int32 counts)
{
    int32 wire = htoel(counts);
    memcpy(out() + TARGET, &wire, sizeof wire);
}

static void set_control(uint16 word)
{
    uint16 wire = htoes(word);
    memcpy(out() + CONTROL, &wire, sizeof wire);
}

static unsigned int state(void)
{
    uint16 word = status();
    bool short_mask = (word & 0x48) != 0;
    return word & (short_mask ? 0x4Fu : 0x6Fu);
}

static void until(unsigned int wanted)
{
    for (unsigned int n = 0; n < PATIENCE && state() != wanted; n++)
        (void)soem_cycle(&master);
    if (state() != wanted)
        fail_msg("expected state %02X, the status word is %04X", wanted, status());
}

static void command(uint16 word, unsigned int wanted)
{
    set_control(word);
    until(wanted);
}

static void enable(void)
{
    set_target(position());
    command(0x06, READY);
    set_target(position());
    command(0x07, SWITCHED_ON);
    command(0x0F, ENABLED);
}

static void choose(int8 mode)
{
    out()[MODE] = (uint8)mode;
    for (unsigned int n = 0; n < PATIENCE && (int8)master.slaves[1].inputs[SHOWN] != mode; n++)
        (void)soem_cycle(&master);
    assert_int_equal((int8)master.slaves[1].inputs[SHOWN], mode);
}

static int start(void **state_)
{
    (void)state_;
    uint8 mode = CSP;
    soem_open(&master, iface, 1);
    plant_set_all("axis1.sto=0 axis1.power=1 axis1.jam=0 axis1.index_at=250000");
    assert_int_equal(soem_write(&master, 1, 0x6060, 0, false, &mode, 1), 0);
    soem_map(&master);
    assert_int_equal(master.slaves[1].Obytes, OUT);
    soem_operational(&master);
    choose(CSP);
    command(0x80, SOD);
    command(0x00, SOD);
    return 0;
}

static int stop(void **state_)
{
    (void)state_;
    soem_close(&master);
    return 0;
}

static void ten_turns(void **state_)
{
    (void)state_;
    enable();
    int32 first = position();
    for (int32 n = 1; n <= 2000; n++) {
        set_target(first + (int32)(n * 10LL * TURN / 2000));
        (void)soem_cycle(&master);
    }
    for (unsigned int n = 0; n < PATIENCE && abs(position() - first - 10 * TURN) > 20; n++)
        (void)soem_cycle(&master);
    if (abs(position() - first - 10 * TURN) > 20)
        fail_msg("expected %d, got %d, status word %04X", first + 10 * TURN, position(), status());
    assert_int_equal(state(), ENABLED);
    command(0x00, SOD);
}

static void fault_and_reset(void **state_)
{
    (void)state_;
    enable();
    plant_set("axis1.fault", "8977"); /* 2311h */
    until(FAULT);
    uint16 code;
    memcpy(&code, master.slaves[1].inputs + ERROR, sizeof code);
    assert_int_equal(etohs(code), 8977);
    command(0x8F, SOD);
    command(0x00, SOD);
    enable();
}

static void reference(void **state_)
{
    uint8 method = 34;
    (void)state_;
    assert_int_equal(soem_write(&master, 1, 0x6098, 0, false, &method, 1), 0);
    choose(HM);
    enable();
    set_control(0x1F);
    for (unsigned int n = 0; n < PATIENCE && (status() & 0x1400) != 0x1400; n++)
        (void)soem_cycle(&master);
    assert_int_equal(status() & 0x3400, 0x1400);
    assert_true(abs(position()) <= 1);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"DRV-604 DRV-613 csp: ten turns", ten_turns, start, stop, NULL},
        {"DRV-615 a fault, reset by 8Fh, enabled again", fault_and_reset, start, stop, NULL},
        {"DRV-618 a reference run to the index", reference, start, stop, NULL},
    };
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
