/* SPDX-License-Identifier: MIT */
/* The state machine of a drive as a pure function: the truth table, transcribed, over all inputs. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/cia402/state.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const char *const names[ECT_402_STATES] = {
    "not ready",         "switch on disabled", "ready",          "switched on",
    "operation enabled", "quick stop",         "fault reaction", "fault"};

/* --- control word ------------------------------------------------------------------------------------------------- */

/* The table of the manual, positive logic: 0, 1, or x for bits 3, 2, 1, 0. */
static const struct {
    const char *bits;
    ect_402_command_t command;
} truth[] = {
    {"xx0x", ECT_402_DISABLE_VOLTAGE},   {"x01x", ECT_402_QUICK_STOP_NOW},   {"x110", ECT_402_SHUTDOWN},
    {"0111", ECT_402_DISABLE_OPERATION}, {"1111", ECT_402_ENABLE_OPERATION},
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
            if (ect_402_command((uint16_t)control, true) != truth[i].command)
                fail_msg("control word %04X: expected command %d, got %d", control, (int)truth[i].command,
                         (int)ect_402_command((uint16_t)control, true));
        }
        if (rows != 1)
            fail_msg("control word %04X is in %u rows of the table", control, rows);
        assert_int_equal(ect_402_command((uint16_t)control, false), ECT_402_QUICK_STOP_NOW);
    }
}

/* --- transitions -------------------------------------------------------------------------------------------------- */

/* The next state by state and command, with supply, no fault, a standstill, and a rising edge of bit 3. */
static const struct {
    ect_402_state_t from;
    ect_402_state_t to[5]; /* disable voltage, quick stop, shutdown, disable operation / switch on, enable operation */
} plain[] = {
    {ECT_402_SWITCH_ON_DISABLED,
     {ECT_402_SWITCH_ON_DISABLED, ECT_402_SWITCH_ON_DISABLED, ECT_402_READY, ECT_402_SWITCH_ON_DISABLED,
      ECT_402_SWITCH_ON_DISABLED}},
    {ECT_402_READY,
     {ECT_402_SWITCH_ON_DISABLED, ECT_402_SWITCH_ON_DISABLED, ECT_402_READY, ECT_402_SWITCHED_ON, ECT_402_SWITCHED_ON}},
    {ECT_402_SWITCHED_ON,
     {ECT_402_SWITCH_ON_DISABLED, ECT_402_SWITCH_ON_DISABLED, ECT_402_READY, ECT_402_SWITCHED_ON,
      ECT_402_OPERATION_ENABLED}},
    {ECT_402_OPERATION_ENABLED,
     {ECT_402_SWITCH_ON_DISABLED, ECT_402_QUICK_STOP, ECT_402_READY, ECT_402_SWITCHED_ON, ECT_402_OPERATION_ENABLED}},
    {ECT_402_QUICK_STOP,
     {ECT_402_SWITCH_ON_DISABLED, ECT_402_SWITCH_ON_DISABLED, ECT_402_SWITCH_ON_DISABLED, ECT_402_SWITCH_ON_DISABLED,
      ECT_402_SWITCH_ON_DISABLED}},
};
static const uint16_t command_words[] = {0x00, 0x02, 0x06, 0x07, 0x0F};

static ect_402_inputs_t healthy(uint16_t control)
{
    return (ect_402_inputs_t){.control = control, .live = true, .supplied = true, .resettable = true, .standing = true};
}

static void expect(ect_402_state_t from, const ect_402_inputs_t *in, ect_402_state_t want, const char *when)
{
    ect_402_state_t got = ect_402_next(from, in, NULL);
    if (got != want)
        fail_msg("%s, control word %04X, %s: expected %s, got %s", names[from], in->control, when, names[want],
                 names[got]);
}

static void transitions(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(plain); i++) {
        for (size_t c = 0; c < COUNT(command_words); c++) {
            ect_402_inputs_t in = healthy(command_words[c]);
            in.rising = command_words[c];
            expect(plain[i].from, &in, plain[i].to[c], "standing");
        }
    }
    ect_402_inputs_t in = healthy(0);
    expect(ECT_402_NOT_READY, &in, ECT_402_SWITCH_ON_DISABLED, "by itself");
}

/* 0x06, 0x07, 0x0F, each as a word of its own; no word leads further than one state. */
static void whole_sequence(void **state)
{
    (void)state;
    for (unsigned int control = 0; control <= 0xFF; control++) {
        ect_402_inputs_t in = healthy((uint16_t)control);
        in.rising = (uint16_t)control;
        ect_402_state_t to = ect_402_next(ECT_402_SWITCH_ON_DISABLED, &in, NULL);
        assert_true(to == ECT_402_SWITCH_ON_DISABLED || (to == ECT_402_READY && (control & 7) == 6));
        to = ect_402_next(ECT_402_READY, &in, NULL);
        assert_true(to <= ECT_402_SWITCHED_ON);
        in.rising = 0;
        to = ect_402_next(ECT_402_SWITCHED_ON, &in, NULL); /* bit 3 was on already */
        assert_true(to <= ECT_402_SWITCHED_ON);
    }
}

/* The ramp first, then the transition: what bits 0 and 3 ask for waits for a standstill, bit 1 does not. */
static void ramps(void **state)
{
    static const struct {
        uint16_t control;
        ect_402_state_t to;
        ect_402_action_t meanwhile;
    } rows[] = {{0x0F, ECT_402_OPERATION_ENABLED, ECT_402_FOLLOW}, {0x07, ECT_402_OPERATION_ENABLED, ECT_402_RAMP},
                {0x0E, ECT_402_OPERATION_ENABLED, ECT_402_RAMP},   {0x10F, ECT_402_OPERATION_ENABLED, ECT_402_RAMP},
                {0x0B, ECT_402_QUICK_STOP, ECT_402_STOP},          {0x0D, ECT_402_SWITCH_ON_DISABLED, ECT_402_OFF}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        ect_402_inputs_t in = healthy(rows[i].control);
        in.standing = false;
        expect(ECT_402_OPERATION_ENABLED, &in, rows[i].to, "turning");
        assert_int_equal(ect_402_action(rows[i].to, &in), rows[i].meanwhile);
    }
    ect_402_inputs_t in = healthy(0x0F);
    in.standing = false;
    in.stays = true;
    expect(ECT_402_QUICK_STOP, &in, ECT_402_QUICK_STOP, "turning, option 6");
    in.standing = true;
    expect(ECT_402_QUICK_STOP, &in, ECT_402_OPERATION_ENABLED, "standing, option 6");
    in.live = false;
    expect(ECT_402_QUICK_STOP, &in, ECT_402_SWITCH_ON_DISABLED, "standing, option 6, out of OP");
}

static void supply(void **state)
{
    (void)state;
    for (unsigned int from = ECT_402_SWITCH_ON_DISABLED; from <= ECT_402_QUICK_STOP; from++) {
        for (unsigned int control = 0; control <= 0xFF; control++) {
            ect_402_inputs_t in = healthy((uint16_t)control);
            in.supplied = false;
            in.rising = (uint16_t)control;
            expect((ect_402_state_t)from, &in, ECT_402_SWITCH_ON_DISABLED, "without supply");
        }
    }
}

static void faults(void **state)
{
    (void)state;
    for (unsigned int from = ECT_402_NOT_READY; from <= ECT_402_QUICK_STOP; from++) {
        ect_402_inputs_t in = healthy(0x0F);
        in.fault = true;
        in.can_brake = true;
        expect((ect_402_state_t)from, &in, ECT_402_FAULT_REACTION, "with a fault");
    }
    ect_402_inputs_t in = healthy(0x0F);
    in.fault = true;
    in.can_brake = true;
    in.standing = false;
    expect(ECT_402_FAULT_REACTION, &in, ECT_402_FAULT_REACTION, "still turning");
    assert_int_equal(ect_402_action(ECT_402_FAULT_REACTION, &in), ECT_402_STOP);
    in.can_brake = false;
    expect(ECT_402_FAULT_REACTION, &in, ECT_402_FAULT, "out of control");
    assert_int_equal(ect_402_action(ECT_402_FAULT_REACTION, &in), ECT_402_OFF);
    for (unsigned int control = 0; control <= 0xFF; control++) {
        bool reset = false;
        in = healthy((uint16_t)control);
        in.fault = true;
        expect(ECT_402_FAULT, &in, ECT_402_FAULT, "no edge");
        in.rising = (uint16_t)control;
        ect_402_state_t to = ect_402_next(ECT_402_FAULT, &in, &reset);
        assert_int_equal(to, (control & ECT_402_RESET) != 0 ? ECT_402_SWITCH_ON_DISABLED : ECT_402_FAULT);
        assert_int_equal(reset, (control & ECT_402_RESET) != 0);
        in.resettable = false;
        expect(ECT_402_FAULT, &in, ECT_402_FAULT, "that needs a restart");
        in.resettable = true;
        in.live = false;
        expect(ECT_402_FAULT, &in, ECT_402_FAULT, "out of OP");
    }
}

/* With by_level no edge of bit 3 is needed: 0Fh leads from Ready to Operation Enabled in two transitions. */
static void level(void **state)
{
    (void)state;
    for (unsigned int from = ECT_402_NOT_READY; from < ECT_402_STATES; from++) {
        ect_402_inputs_t in = healthy(0x0F);
        ect_402_state_t plain_next = ect_402_next((ect_402_state_t)from, &in, NULL);
        in.by_level = true;
        ect_402_state_t next = ect_402_next((ect_402_state_t)from, &in, NULL);
        assert_int_equal(next, from == ECT_402_SWITCHED_ON ? ECT_402_OPERATION_ENABLED : plain_next);
        in.live = false;
        assert_int_not_equal(ect_402_next((ect_402_state_t)from, &in, NULL), ECT_402_OPERATION_ENABLED);
    }
}

/* 605Ch 0: only Switched On changes. */
static void coasting(void **state)
{
    (void)state;
    for (unsigned int s = 0; s < ECT_402_STATES; s++) {
        ect_402_inputs_t in = healthy(0x07);
        ect_402_action_t before = ect_402_action((ect_402_state_t)s, &in);
        in.coasts = true;
        ect_402_action_t action = ect_402_action((ect_402_state_t)s, &in);
        assert_int_equal(action, s == ECT_402_SWITCHED_ON ? ECT_402_OFF : before);
    }
}

/* Torque only in these states; set values only in one, and only with the command for it. */
static void actions(void **state)
{
    (void)state;
    for (unsigned int s = 0; s < ECT_402_STATES; s++) {
        for (unsigned int control = 0; control <= 0x1FF; control++) {
            for (unsigned int more = 0; more < 4; more++) {
                ect_402_inputs_t in = healthy((uint16_t)control);
                in.live = (more & 1) != 0;
                in.can_brake = (more & 2) != 0;
                ect_402_action_t action = ect_402_action((ect_402_state_t)s, &in);
                bool torque = s == ECT_402_SWITCHED_ON || s == ECT_402_OPERATION_ENABLED || s == ECT_402_QUICK_STOP ||
                              (s == ECT_402_FAULT_REACTION && in.can_brake);
                bool follow = s == ECT_402_OPERATION_ENABLED && in.live && (control & 0x10F) == 0x0F;
                assert_int_equal(action != ECT_402_OFF, torque);
                assert_int_equal(action == ECT_402_FOLLOW, follow);
            }
        }
    }
}

static void status_words(void **state)
{
    static const struct {
        uint16_t mask, value; /* bits 6, 5, 3, 2, 1, 0 */
    } coding[ECT_402_STATES] = {
        [ECT_402_NOT_READY] = {0x4F, 0x00},
        [ECT_402_SWITCH_ON_DISABLED] = {0x4F, 0x40},
        [ECT_402_READY] = {0x6F, 0x21},
        [ECT_402_SWITCHED_ON] = {0x6F, 0x23},
        [ECT_402_OPERATION_ENABLED] = {0x6F, 0x27},
        [ECT_402_QUICK_STOP] = {0x6F, 0x07},
        [ECT_402_FAULT_REACTION] = {0x4F, 0x0F},
        [ECT_402_FAULT] = {0x4F, 0x08},
    };
    (void)state;
    for (unsigned int s = 0; s < ECT_402_STATES; s++) {
        for (unsigned int control = 0; control <= 0xFF; control++) {
            ect_402_inputs_t in = healthy((uint16_t)control);
            uint16_t status = ect_402_status((ect_402_state_t)s, &in);
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
        {"PLZ-021 PLZ-022 DRV-126: each command leads from each state to the state in the table", transitions, NULL,
         NULL, NULL},
        {"PLZ-021: no single word enables: Ready to Switch On, Switched On, and an edge of bit 3", whole_sequence, NULL,
         NULL, NULL},
        {"PLZ-022 PLZ-023: bits 0, 2 and 3 falling brake first, bit 1 does not", ramps, NULL, NULL, NULL},
        {"PLZ-021: without DC link, enable or with STO nothing is switched on", supply, NULL, NULL, NULL},
        {"PLZ-022: a fault leads to Fault from everywhere, an edge of bit 7 out of it", faults, NULL, NULL, NULL},
        {"PLZ-031: torque in the enabled states alone, set values in Operation Enabled alone", actions, NULL, NULL,
         NULL},
        {"DRV-117 DRV-123: by its level, bit 3 enables from Switched On alone", level, NULL, NULL, NULL},
        {"DRV-147: 605Ch 0 takes the torque in Switched On alone", coasting, NULL, NULL, NULL},
        {"PLZ-024 DRV-101: the status word codes the state as CiA 402 does", status_words, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("CiA 402 state machine", tests, NULL, NULL);
}
