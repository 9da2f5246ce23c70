/* SPDX-License-Identifier: MIT */
/*
 * Random control words, set values, modes, halts, faults, STO, supply, limit switches, changes of the AL state, lost
 * cycles, silent masters. The invariants are checked whenever an input has changed.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "seams/random.h"
#include "support/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
enum { SEEDS = 120, CYCLES = 1200 };

static drive_t d;
static uint32_t random_state;
static unsigned int seed;

static uint32_t draw(uint32_t below)
{
    return ect_random_next(&random_state) % below;
}

/* The state at the last check. */
static struct {
    ect_402_state_t state;
    double free_speed;    /* when set values ceased to count */
    uint64_t stopping_ns; /* start of the stop on the ramp, 0: no stop */
    uint64_t stop_limit_ns;
} seen;

static void refuse(const char *what)
{
    const pmctendo_t *u = drive_instance(&d);
    fail_msg("seed %u, %.3f s: %s: state %u (was %d), control word %04X, AL %02X, %.0f counts/s; run: %s", seed,
             (double)d.w.now_ns / 1e9, what, u->state_shown, (int)seen.state, u->axis.set.control,
             wire_read8(&d.w, 0, ECT_REG_AL_STATUS), u->plant.machine.speed, "test_pmctendo_random SEED");
}

/* The step of a state in the sequence. */
static unsigned int rank(ect_402_state_t state)
{
    static const unsigned int ranks[ECT_402_STATES] = {[ECT_402_READY] = 1,
                                                       [ECT_402_SWITCHED_ON] = 2,
                                                       [ECT_402_OPERATION_ENABLED] = 3,
                                                       [ECT_402_QUICK_STOP] = 3,
                                                       [ECT_402_FAULT_REACTION] = 3};
    return ranks[state];
}

static void judge_power(const pmctendo_t *u)
{
    bool may = rank(u->axis.state) >= 2;
    bool supplied = u->plant.power && u->plant.enable && !u->plant.sto;
    if (u->axis.torque_now != 0 && (!may || !supplied))
        refuse("torque without being enabled, or without supply");
    bool follow =
        u->axis.state == ECT_402_OPERATION_ENABLED && u->al == ECT_STATE_OP && (u->axis.set.control & 0x10F) == 0x0F;
    if (u->axis.action == ECT_402_FOLLOW && !follow)
        refuse("set values are followed outside Operation Enabled");
    if (u->outputs != 0 && u->al != ECT_STATE_OP)
        refuse("digital outputs are on outside OP");
}

/* Only set values accelerate the shaft: there is no load. */
static void judge_speed(const pmctendo_t *u)
{
    double speed = fabs(u->plant.machine.speed);
    if (u->axis.action == ECT_402_FOLLOW)
        seen.free_speed = speed;
    else if (speed > seen.free_speed + 3.0 * PMC_TURN) /* two steps with all the torque: 2.4 turns a second */
        refuse("it accelerates although no set value applies");
}

static void judge_stop(const pmctendo_t *u)
{
    bool stopping = u->axis.state == ECT_402_QUICK_STOP || u->axis.state == ECT_402_FAULT_REACTION;
    if (!stopping || ect_402_standing(&u->axis)) {
        seen.stopping_ns = 0;
        return;
    }
    if (seen.stopping_ns == 0) {
        double rate =
            u->axis.quick_option == 1 || u->axis.quick_option == 5 ? u->axis.deceleration : u->axis.quick_deceleration;
        seen.stopping_ns = d.w.now_ns;
        seen.stop_limit_ns = (uint64_t)(1.5e9 * fabs(u->plant.machine.speed) / rate) + 205 * MS;
    }
    if (d.w.now_ns - seen.stopping_ns > seen.stop_limit_ns)
        refuse("a stop does not end in its time");
}

static void judge(bool new_word, uint16_t before, uint16_t word)
{
    const pmctendo_t *u = drive_instance(&d);
    unsigned int up = rank(u->axis.state), was = rank(seen.state);
    bool edge = (word & 0x08) != 0 && (before & 0x08) == 0;
    bool reaction = u->axis.state == ECT_402_FAULT_REACTION || u->axis.state == ECT_402_QUICK_STOP;
    if (up > was && !reaction) {
        bool one_up = up == was + 1 && u->al == ECT_STATE_OP;
        bool ready = up == 1 && (u->axis.set.control & 7) == 6; /* its control word may have waited for the supply */
        bool higher = up >= 2 && new_word && (word & 7) == 7 && (up == 2 || edge);
        if (!one_up || !(ready || higher))
            refuse("a step of the sequence was omitted");
    }
    if (reaction && was < 2 && u->axis.action != ECT_402_OFF)
        refuse("power comes on with a fault");
    if (seen.state == ECT_402_FAULT && u->axis.state != ECT_402_FAULT && u->fault != 0)
        refuse("out of Fault while the fault still exists");
    seen.state = u->axis.state;
    judge_power(u);
    judge_speed(u);
    judge_stop(u);
}

static void pass(uint64_t ns)
{
    uint64_t end = d.w.now_ns + ns;
    while (d.w.now_ns < end) {
        uint64_t next = ect_chain_poll(d.w.chain, d.w.now_ns);
        next = next > d.w.now_ns + PMC_STEP_NS ? d.w.now_ns + PMC_STEP_NS : next;
        wire_advance(&d.w, (next < end ? next : end) - d.w.now_ns);
        judge(false, 0, 0);
    }
}

static void exchange(void)
{
    uint16_t before = drive_instance(&d)->axis.set.control;
    bool known = drive_instance(&d)->control_known;
    if (wire_write(&d.w, 0, 0x1100, d.out, d.to.bytes) != 1)
        return; /* below SAFEOP */
    judge(known, before, drive_controlled(&d));
}

/* Mostly words of the sequence, sometimes any word. */
static void next_outputs(void)
{
    static const uint16_t words[] = {0x06, 0x07, 0x0F, 0x0F, 0x0F, 0x0B, 0x0D, 0x80, 0x10F, 0x80F, 0x1F, 0x00};
    if (draw(6) == 0)
        drive_control(&d, draw(8) == 0 ? (uint16_t)draw(0x10000) : words[draw(COUNT(words))]);
    else if (draw(4) == 0) { /* on the way up */
        static const uint16_t way[] = {0x06, 0x07, 0x0F};
        unsigned int r = rank(drive_instance(&d)->axis.state);
        drive_control(&d, drive_instance(&d)->axis.state == ECT_402_FAULT ? 0x80 : way[r < 3 ? r : 2]);
    }
    if (d.to.pdo == PMC_PDO_SPEED && draw(10) == 0)
        drive_set(&d, (int32_t)draw(40 * PMC_TURN) - 20 * PMC_TURN);
    else if (d.to.pdo == PMC_PDO_TORQUE && draw(10) == 0)
        drive_set(&d, (int32_t)draw(1000) - 500);
    else if (d.to.pdo == PMC_PDO_POSITION_FULL)
        drive_set(&d, drive_instance(&d)->position + (int32_t)draw(40000) - 20000);
    if (d.to.outputs != DRIVE_NOWHERE)
        ect_store_le16(d.out + d.to.outputs, (uint16_t)draw(4));
}

static void operator(void)
{
    static const char *const switches[] = {"sto", "power", "enable", "di3", "di4"};
    static const char *const faults[] = {"1", "3", "8", "15", "28", "30"};
    if (draw(150) == 0)
        signal_set(&d.w, "provoke", faults[draw(COUNT(faults))]);
    if (draw(100) == 0)
        signal_set(&d.w, switches[draw(COUNT(switches))], draw(2) ? "1" : "0");
    if (draw(60) == 0) { /* all is well again */
        signal_set(&d.w, "sto", "0");
        for (size_t i = 1; i < COUNT(switches); i++)
            signal_set(&d.w, switches[i], "1");
    }
    judge(false, 0, 0);
}

static void change_al(void)
{
    static const uint8_t states[] = {ECT_STATE_SAFEOP, ECT_STATE_OP, ECT_STATE_OP, ECT_STATE_PREOP};
    uint8_t now = wire_read8(&d.w, 0, ECT_REG_AL_STATUS);
    uint8_t to = states[draw(COUNT(states))];
    if (draw(40) != 0 && now == ECT_STATE_OP)
        return;
    if ((now & 0x0F) == ECT_STATE_PREOP)
        to = ECT_STATE_SAFEOP;
    (void)wire_al(&d.w, 0, to | 0x10, NULL);
    judge(false, 0, 0);
}

/* Longer than the watchdog and every ramp. */
static void fall_silent(void)
{
    bool op = wire_read8(&d.w, 0, ECT_REG_AL_STATUS) == ECT_STATE_OP;
    const pmctendo_t *u = drive_instance(&d);
    pass(1200 * MS);
    if (wire_read8(&d.w, 0, ECT_REG_AL_STATUS) == ECT_STATE_OP)
        refuse("OP without a master");
    if (u->axis.torque_now != 0 || u->outputs != 0 || u->axis.action != ECT_402_OFF)
        refuse("torque or outputs without a master");
    if (op && u->axis.state != ECT_402_FAULT)
        refuse("no fault although the master has stopped");
}

static void session(unsigned int number)
{
    static const uint16_t pdos[] = {PMC_PDO_SPEED, PMC_PDO_TORQUE, PMC_PDO_POSITION_FULL};
    static const int16_t options[] = {0, 1, 2, 5, 6};
    char inertia[16];
    seed = number;
    random_state = 2463534242u + number * 7919;
    drive_open(&d);
    snprintf(inertia, sizeof inertia, "%u", draw(10));
    signal_set(&d.w, "load_inertia", inertia);
    assert_int_equal(drive_write(&d, 0x605A, 0, (uint16_t)options[draw(COUNT(options))], 2), 0);
    seen.state = drive_instance(&d)->axis.state;
    seen.free_speed = 0;
    seen.stopping_ns = 0;
    drive_operational(&d, pdos[number % COUNT(pdos)], 0x1B25);
    for (unsigned int n = 0; n < CYCLES; n++) {
        next_outputs();
        if (draw(20) != 0) /* else this cycle is lost */
            exchange();
        operator();
        change_al();
        pass(draw(3) == 0 ? 250000 + draw(3000000) : MS);
        if (draw(300) == 0)
            fall_silent();
    }
    fall_silent();
    drive_close(&d);
}

static unsigned int first, last = SEEDS;

static void at_random(void **state)
{
    (void)state;
    for (unsigned int number = first; number < last; number++)
        session(number);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"PLZ-019 PLZ-020 PLZ-021 PLZ-022 PLZ-031: random runs: enabled only by the whole sequence, set values only in "
         "Operation Enabled, stops end in their time, everything is off after the watchdog",
         at_random, NULL, NULL, NULL},
    };
    if (argc > 1) {
        first = (unsigned int)strtoul(argv[1], NULL, 10);
        last = first + 1;
    }
    return cmocka_run_group_tests_name("PMCtendo at random", tests, NULL, NULL);
}
