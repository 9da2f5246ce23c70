/* SPDX-License-Identifier: MIT */
/* The state machine of the PMCtendo as a pure function: the manual's truth table, transcribed, over all its inputs. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "devices/pmctendo/ds402.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const char *const names[DS402_STATES] = {
    "not ready",         "switch on disabled", "ready",          "switched on",
    "operation enabled", "quick stop",         "fault reaction", "fault"};

/* --- control word ------------------------------------------------------------------------------------------------- */

/* The table of the manual, positive logic: 0, 1, or x for bits 3, 2, 1, 0. */
static const struct {
    const char *bits;
    ds402_command_t command;
} truth[] = {
    {"xx0x", DS402_DISABLE_VOLTAGE},   {"x01x", DS402_QUICK_STOP_NOW},   {"x110", DS402_SHUTDOWN},
    {"0111", DS402_DISABLE_OPERATION}, {"1111", DS402_ENABLE_OPERATION},
};

static bool fits(const char *bits, unsigned int control)
{
    for (unsigned int i = 0; i < 4; i++) {
        unsigned int bit = control >> (3 - i) & 1;
        if (bits[i] != 'x' && bit != (unsigned int)(bits[i] - '0'))
            return false;
    }
    return true;
}

static void control_words(void **state)
{
    (void)state;
    for (unsigned int control = 0; control <= 0xFFFF; control++) {
        unsigned int rows = 0;
        for (size_t i = 0; i < COUNT(truth); i++) {
            if (!fits(truth[i].bits, control))
                continue;
            rows++;
            if (ds402_command((uint16_t)control, true) != truth[i].command)
                fail_msg("control word %04X: expected command %d, got %d", control, (int)truth[i].command,
                         (int)ds402_command((uint16_t)control, true));
        }
        if (rows != 1)
            fail_msg("control word %04X is in %u rows of the table", control, rows);
        assert_int_equal(ds402_command((uint16_t)control, false), DS402_QUICK_STOP_NOW);
    }
}

/* --- transitions -------------------------------------------------------------------------------------------------- */

/* The next state by state and command, with supply, no fault, a standstill, and a rising edge of bit 3. */
static const struct {
    ds402_state_t from;
    ds402_state_t to[5]; /* disable voltage, quick stop, shutdown, disable operation / switch on, enable operation */
} plain[] = {
    {DS402_SWITCH_ON_DISABLED,
     {DS402_SWITCH_ON_DISABLED, DS402_SWITCH_ON_DISABLED, DS402_READY, DS402_SWITCH_ON_DISABLED,
      DS402_SWITCH_ON_DISABLED}},
    {DS402_READY,
     {DS402_SWITCH_ON_DISABLED, DS402_SWITCH_ON_DISABLED, DS402_READY, DS402_SWITCHED_ON, DS402_SWITCHED_ON}},
    {DS402_SWITCHED_ON,
     {DS402_SWITCH_ON_DISABLED, DS402_SWITCH_ON_DISABLED, DS402_READY, DS402_SWITCHED_ON, DS402_OPERATION_ENABLED}},
    {DS402_OPERATION_ENABLED,
     {DS402_SWITCH_ON_DISABLED, DS402_QUICK_STOP, DS402_READY, DS402_SWITCHED_ON, DS402_OPERATION_ENABLED}},
    {DS402_QUICK_STOP,
     {DS402_SWITCH_ON_DISABLED, DS402_SWITCH_ON_DISABLED, DS402_SWITCH_ON_DISABLED, DS402_SWITCH_ON_DISABLED,
      DS402_SWITCH_ON_DISABLED}},
};
static const uint16_t command_words[] = {0x00, 0x02, 0x06, 0x07, 0x0F};

static ds402_inputs_t healthy(uint16_t control)
{
    return (ds402_inputs_t){.control = control, .live = true, .supplied = true, .resettable = true, .standing = true};
}

static void expect(ds402_state_t from, const ds402_inputs_t *in, ds402_state_t want, const char *when)
{
    ds402_state_t got = ds402_next(from, in, NULL);
    if (got != want)
        fail_msg("%s, control word %04X, %s: expected %s, got %s", names[from], in->control, when, names[want],
                 names[got]);
}

static void transitions(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(plain); i++) {
        for (size_t c = 0; c < COUNT(command_words); c++) {
            ds402_inputs_t in = healthy(command_words[c]);
            in.rising = command_words[c];
            expect(plain[i].from, &in, plain[i].to[c], "standing");
        }
    }
    ds402_inputs_t in = healthy(0);
    expect(DS402_NOT_READY, &in, DS402_SWITCH_ON_DISABLED, "by itself");
}

/* 0x06, 0x07, 0x0F, each as a word of its own; no word leads further than one state. */
static void whole_sequence(void **state)
{
    (void)state;
    for (unsigned int control = 0; control <= 0xFF; control++) {
        ds402_inputs_t in = healthy((uint16_t)control);
        in.rising = (uint16_t)control;
        ds402_state_t to = ds402_next(DS402_SWITCH_ON_DISABLED, &in, NULL);
        assert_true(to == DS402_SWITCH_ON_DISABLED || (to == DS402_READY && (control & 7) == 6));
        to = ds402_next(DS402_READY, &in, NULL);
        assert_true(to <= DS402_SWITCHED_ON);
        in.rising = 0;
        to = ds402_next(DS402_SWITCHED_ON, &in, NULL); /* bit 3 was on already */
        assert_true(to <= DS402_SWITCHED_ON);
    }
}

/* The ramp first, then the transition: what bits 0 and 3 ask for waits for a standstill, bit 1 does not. */
static void ramps(void **state)
{
    static const struct {
        uint16_t control;
        ds402_state_t to;
        ds402_action_t meanwhile;
    } rows[] = {{0x0F, DS402_OPERATION_ENABLED, DS402_FOLLOW}, {0x07, DS402_OPERATION_ENABLED, DS402_RAMP},
                {0x0E, DS402_OPERATION_ENABLED, DS402_RAMP},   {0x10F, DS402_OPERATION_ENABLED, DS402_RAMP},
                {0x0B, DS402_QUICK_STOP, DS402_STOP},          {0x0D, DS402_SWITCH_ON_DISABLED, DS402_OFF}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ds402_inputs_t in = healthy(rows[i].control);
        in.standing = false;
        expect(DS402_OPERATION_ENABLED, &in, rows[i].to, "turning");
        assert_int_equal(ds402_action(rows[i].to, &in), rows[i].meanwhile);
    }
    ds402_inputs_t in = healthy(0x0F);
    in.standing = false;
    in.stays = true;
    expect(DS402_QUICK_STOP, &in, DS402_QUICK_STOP, "turning, option 6");
    in.standing = true;
    expect(DS402_QUICK_STOP, &in, DS402_OPERATION_ENABLED, "standing, option 6");
    in.live = false;
    expect(DS402_QUICK_STOP, &in, DS402_SWITCH_ON_DISABLED, "standing, option 6, out of OP");
}

static void supply(void **state)
{
    (void)state;
    for (unsigned int from = DS402_SWITCH_ON_DISABLED; from <= DS402_QUICK_STOP; from++) {
        for (unsigned int control = 0; control <= 0xFF; control++) {
            ds402_inputs_t in = healthy((uint16_t)control);
            in.supplied = false;
            in.rising = (uint16_t)control;
            expect((ds402_state_t)from, &in, DS402_SWITCH_ON_DISABLED, "without supply");
        }
    }
}

static void faults(void **state)
{
    (void)state;
    for (unsigned int from = DS402_NOT_READY; from <= DS402_QUICK_STOP; from++) {
        ds402_inputs_t in = healthy(0x0F);
        in.fault = true;
        in.can_brake = true;
        expect((ds402_state_t)from, &in, DS402_FAULT_REACTION, "with a fault");
    }
    ds402_inputs_t in = healthy(0x0F);
    in.fault = true;
    in.can_brake = true;
    in.standing = false;
    expect(DS402_FAULT_REACTION, &in, DS402_FAULT_REACTION, "still turning");
    assert_int_equal(ds402_action(DS402_FAULT_REACTION, &in), DS402_STOP);
    in.can_brake = false;
    expect(DS402_FAULT_REACTION, &in, DS402_FAULT, "out of control");
    assert_int_equal(ds402_action(DS402_FAULT_REACTION, &in), DS402_OFF);
    for (unsigned int control = 0; control <= 0xFF; control++) {
        bool reset = false;
        in = healthy((uint16_t)control);
        in.fault = true;
        expect(DS402_FAULT, &in, DS402_FAULT, "no edge");
        in.rising = (uint16_t)control;
        ds402_state_t to = ds402_next(DS402_FAULT, &in, &reset);
        assert_int_equal(to, (control & DS402_RESET) != 0 ? DS402_SWITCH_ON_DISABLED : DS402_FAULT);
        assert_int_equal(reset, (control & DS402_RESET) != 0);
        in.resettable = false;
        expect(DS402_FAULT, &in, DS402_FAULT, "that needs a restart");
        in.resettable = true;
        in.live = false;
        expect(DS402_FAULT, &in, DS402_FAULT, "out of OP");
    }
}

/* Torque only in these states; set values only in one, and only with the command for it. */
static void actions(void **state)
{
    (void)state;
    for (unsigned int s = 0; s < DS402_STATES; s++) {
        for (unsigned int control = 0; control <= 0x1FF; control++) {
            for (unsigned int more = 0; more < 4; more++) {
                ds402_inputs_t in = healthy((uint16_t)control);
                in.live = (more & 1) != 0;
                in.can_brake = (more & 2) != 0;
                ds402_action_t action = ds402_action((ds402_state_t)s, &in);
                bool torque = s == DS402_SWITCHED_ON || s == DS402_OPERATION_ENABLED || s == DS402_QUICK_STOP ||
                              (s == DS402_FAULT_REACTION && in.can_brake);
                bool follow = s == DS402_OPERATION_ENABLED && in.live && (control & 0x10F) == 0x0F;
                assert_int_equal(action != DS402_OFF, torque);
                assert_int_equal(action == DS402_FOLLOW, follow);
            }
        }
    }
}

static void status_words(void **state)
{
    static const struct {
        uint16_t mask, value; /* bits 6, 5, 3, 2, 1, 0 */
    } coding[DS402_STATES] = {
        [DS402_NOT_READY] = {0x4F, 0x00},
        [DS402_SWITCH_ON_DISABLED] = {0x4F, 0x40},
        [DS402_READY] = {0x6F, 0x21},
        [DS402_SWITCHED_ON] = {0x6F, 0x23},
        [DS402_OPERATION_ENABLED] = {0x6F, 0x27},
        [DS402_QUICK_STOP] = {0x6F, 0x07},
        [DS402_FAULT_REACTION] = {0x4F, 0x0F},
        [DS402_FAULT] = {0x4F, 0x08},
    };
    (void)state;
    for (unsigned int s = 0; s < DS402_STATES; s++) {
        for (unsigned int control = 0; control <= 0xFF; control++) {
            ds402_inputs_t in = healthy((uint16_t)control);
            uint16_t status = ds402_status((ds402_state_t)s, &in);
            if ((status & coding[s].mask) != coding[s].value || (status & ~0x6Fu) != 0)
                fail_msg("%s: expected status %02X of %02X and nothing else, got %04X", names[s], coding[s].value,
                         coding[s].mask, status);
        }
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"PLZ-022: every control word stands for the command of the truth table: bit 1 before 2 before 0 before 3",
         control_words, NULL, NULL, NULL},
        {"PLZ-021 PLZ-022: each command leads from each state to the one of the table", transitions, NULL, NULL, NULL},
        {"PLZ-021: no single word enables: Ready to Switch On, Switched On, and an edge of bit 3", whole_sequence, NULL,
         NULL, NULL},
        {"PLZ-022 PLZ-023: bits 0, 2 and 3 falling brake first, bit 1 does not", ramps, NULL, NULL, NULL},
        {"PLZ-021: without DC link, enable or with STO nothing is switched on", supply, NULL, NULL, NULL},
        {"PLZ-022: a fault leads to Fault from everywhere, an edge of bit 7 out of it", faults, NULL, NULL, NULL},
        {"PLZ-031: torque in the enabled states alone, set values in Operation Enabled alone", actions, NULL, NULL,
         NULL},
        {"PLZ-024: the status word codes the state as CiA 402 does", status_words, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo state machine", tests, NULL, NULL);
}
