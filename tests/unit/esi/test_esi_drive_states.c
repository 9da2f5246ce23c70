/* SPDX-License-Identifier: MIT */
/* State machine, stops, faults and AL states of a drive of an ESI file: tables over the objects. A turn has 10 000
 * counts. */
#include "drive_of_file.h"

enum { FAST = 50000 }; /* counts/s */

/* --- commands ----------------------------------------------------------------------------------------------------- */

/* From Switch on disabled to `state`. */
static void bring(unsigned int state)
{
    if (state == SOD)
        return;
    if (state == FAULT) {
        set("axis1.fault", "16912"); /* 4210h */
        cycles(1);
        until(0, FAULT);
        return;
    }
    command(0, SHUTDOWN, READY);
    if (state == READY)
        return;
    command(0, SWITCH_ON, SWITCHED_ON);
    if (state == SWITCHED_ON)
        return;
    command(0, ENABLE, ENABLED);
    if (state == STOPPING)
        command(0, 0x0B, STOPPING);
}

static void each_command(void **state)
{
    static const struct {
        const char *what;
        unsigned int from;
        uint16_t word;
        unsigned int to;
    } rows[] = {
        {"DRV-115 DRV-127 DRV-102 shutdown", SOD, 0x06, READY},
        {"DRV-124 shutdown with bit 7", SOD, 0x86, READY},
        {"DRV-142 switch on", SOD, 0x07, SOD},
        {"DRV-142 enable", SOD, 0x0F, SOD},
        {"DRV-144 quick stop", SOD, 0x02, SOD},
        {"DRV-116 DRV-128 DRV-103 switch on", READY, 0x07, SWITCHED_ON},
        {"DRV-117 enable", READY, 0x0F, ENABLED},
        {"DRV-118 DRV-132 disable voltage", READY, 0x00, SOD},
        {"DRV-118 disable voltage, whatever the other bits", READY, 0x0D, SOD},
        {"DRV-119 DRV-132 DRV-144 quick stop", READY, 0x02, SOD},
        {"shutdown again", READY, 0x06, READY},
        {"DRV-121 DRV-129 DRV-105 enable", SWITCHED_ON, 0x0F, ENABLED},
        {"DRV-131 shutdown", SWITCHED_ON, 0x06, READY},
        {"DRV-135 disable voltage", SWITCHED_ON, 0x00, SOD},
        {"DRV-135 DRV-144 quick stop", SWITCHED_ON, 0x02, SOD},
        {"DRV-120 DRV-130 disable operation", ENABLED, 0x07, SWITCHED_ON},
        {"DRV-133 shutdown", ENABLED, 0x06, READY},
        {"DRV-134 disable voltage", ENABLED, 0x00, SOD},
        {"DRV-119 DRV-136 DRV-106 quick stop, 605Ah 6", ENABLED, 0x0B, STOPPING},
        {"DRV-142 shutdown", STOPPING, 0x06, STOPPING},
        {"DRV-142 disable operation", STOPPING, 0x07, STOPPING},
        {"DRV-141 enable", STOPPING, 0x0F, ENABLED},
        {"DRV-137 disable voltage", STOPPING, 0x00, SOD},
        {"DRV-142 DRV-108 shutdown", FAULT, 0x06, FAULT},
        {"DRV-142 enable", FAULT, 0x0F, FAULT},
        {"DRV-144 quick stop", FAULT, 0x02, FAULT},
        {"DRV-122 DRV-140 fault reset", FAULT, 0x80, SOD},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(CSP, 10000);
        assert_int_equal(write_sdo(0x605A, 0, 6, 2), 0);
        bring(rows[i].from);
        put(CONTROL, rows[i].word);
        cycles(50);
        if (state_of(get(STATUS)) != rows[i].to)
            fail_msg("%s: expected %02X after %02X, status word is %04X", rows[i].what, rows[i].to, rows[i].from,
                     (unsigned int)get(STATUS));
        close_drive(state);
    }
}

static void supply(void **state)
{
    static const struct {
        const char *signal, *off, *on;
    } rows[] = {{"axis1.power", "0", "1"}, {"axis1.enable", "0", "1"}, {"axis1.sto", "1", "0"}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(CSP, 10000);
        set(rows[i].signal, rows[i].off);
        put(CONTROL, SHUTDOWN);
        cycles(5);
        if (state_of(get(STATUS)) != SOD)
            fail_msg("%s: status word is %04X", rows[i].signal, (unsigned int)get(STATUS));
        set(rows[i].signal, rows[i].on);
        cycles(2);
        assert_int_equal(state_of(get(STATUS)), READY);
        close_drive(state);
    }
}

/* --- bits of the status word -------------------------------------------------------------------------------------- */

static void quick_stop_bit(void **state)
{
    static const struct {
        unsigned int state;
        uint16_t word;
        bool bit;
    } rows[] = {{SOD, 0x00, false},    {SOD, 0x04, true},    {READY, 0x06, true},     {SWITCHED_ON, 0x07, true},
                {ENABLED, 0x0F, true}, {FAULT, 0x00, false}, {STOPPING, 0x0B, false}, {FAULT, 0x04, true}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(CSP, 10000);
        assert_int_equal(write_sdo(0x605A, 0, 6, 2), 0);
        bring(rows[i].state);
        put(CONTROL, rows[i].word);
        cycles(2);
        assert_int_equal(state_of(get(STATUS)), rows[i].state);
        assert_int_equal((get(STATUS) & 0x20) != 0, rows[i].bit);
        close_drive(state);
    }
}

static void warning(void **state)
{
    (void)state;
    servo(CSP, 10000);
    enable(0);
    set("axis1.warning", "1");
    cycles(1);
    assert_int_equal(get(STATUS) & 0x80, 0x80);
    assert_int_equal(state_of(get(STATUS)), ENABLED);
    assert_int_equal(get(0x603F), 0);
    set("axis1.warning", "0");
    cycles(1);
    assert_int_equal(get(STATUS) & 0x80, 0);
}

static void voltage(void **state)
{
    (void)state;
    servo(CSP, 10000);
    assert_int_equal(get(STATUS) & 0x10, 0x10);
    set("axis1.power", "0");
    cycles(1);
    assert_int_equal(get(STATUS) & 0x10, 0);
}

/* --- stops -------------------------------------------------------------------------------------------------------- */

/* At 50 000 counts/s in mode 3. The inertia is four times that of the motor, and 50 per mille of torque brake it at
 * 199 000 counts/s2, 6084h at 100 000 and 6085h at 500 000. */
static void turning(int8_t mode)
{
    servo(mode, 10000);
    set("axis1.load_inertia", "9");
    set("axis1.friction", "0");
    enable(0);
    put(0x60FF, FAST);
    put(CONTROL, ENABLE);
    cycles(1000);
    expect_near("cruising", FAST, 500, (double)get(0x606C));
}

static void stops(void **state)
{
    enum { COASTS = -1, RAISE = 0xFFFF, HALT = ENABLE | 0x100, LITTLE = 50 };
    static const struct {
        const char *what;
        uint16_t object;
        int64_t option;
        uint16_t word;     /* RAISE: a fault */
        unsigned int ends; /* in this state */
        int ms;            /* to a standstill */
        int64_t torque;    /* 6072h for the stop; 0: as it is */
    } rows[] = {
        {"DRV-146 605Ah 0: off", 0x605A, 0, 0x0B, SOD, COASTS, 0},
        {"DRV-146 605Ah 1: 6084h", 0x605A, 1, 0x0B, SOD, 500, 0},
        {"DRV-146 DRV-407 605Ah 2: 6085h", 0x605A, 2, 0x0B, SOD, 100, 0},
        {"DRV-146 DRV-150 605Ah 3: current limit", 0x605A, 3, 0x0B, SOD, 251, LITTLE},
        {"DRV-146 DRV-150 605Ah 4: voltage limit", 0x605A, 4, 0x0B, SOD, 251, LITTLE},
        {"DRV-146 605Ah 5: 6084h, stays", 0x605A, 5, 0x0B, STOPPING, 500, 0},
        {"DRV-146 605Ah 6: 6085h, stays", 0x605A, 6, 0x0B, STOPPING, 100, 0},
        {"DRV-146 605Ah 7: current limit, stays", 0x605A, 7, 0x0B, STOPPING, 251, LITTLE},
        {"DRV-146 605Ah 8: voltage limit, stays", 0x605A, 8, 0x0B, STOPPING, 251, LITTLE},
        {"DRV-147 605Bh 0: off", 0x605B, 0, 0x06, READY, COASTS, 0},
        {"DRV-147 605Bh 1: 6084h", 0x605B, 1, 0x06, READY, 500, 0},
        {"DRV-147 605Ch 0: off", 0x605C, 0, 0x07, SWITCHED_ON, COASTS, 0},
        {"DRV-147 605Ch 1: 6084h", 0x605C, 1, 0x07, SWITCHED_ON, 500, 0},
        {"DRV-148 605Dh 1: 6084h", 0x605D, 1, HALT, ENABLED, 500, 0},
        {"DRV-148 605Dh 2: 6085h", 0x605D, 2, HALT, ENABLED, 100, 0},
        {"DRV-148 605Dh 3: current limit", 0x605D, 3, HALT, ENABLED, 251, LITTLE},
        {"DRV-148 605Dh 4: voltage limit", 0x605D, 4, HALT, ENABLED, 251, LITTLE},
        {"DRV-149 605Eh 0: off", 0x605E, 0, RAISE, FAULT, COASTS, 0},
        {"DRV-149 605Eh 1: 6084h", 0x605E, 1, RAISE, FAULT, 500, 0},
        {"DRV-149 605Eh 2: 6085h", 0x605E, 2, RAISE, FAULT, 100, 0},
        {"DRV-149 605Eh 3: current limit", 0x605E, 3, RAISE, FAULT, 251, LITTLE},
        {"DRV-149 605Eh 4: voltage limit", 0x605E, 4, RAISE, FAULT, 251, LITTLE},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        turning(PV);
        assert_int_equal(write_sdo(rows[i].object, 0, rows[i].option, 2), 0);
        if (rows[i].torque != 0)
            assert_int_equal(write_sdo(0x6072, 0, rows[i].torque, 2), 0);
        if (rows[i].word == RAISE)
            set("axis1.fault", "16912");
        else
            put(CONTROL, rows[i].word);
        int ms = 0;
        do {
            cycles(1);
        } while (++ms < 1000 && get(0x606C) > FAST / 100);
        cycles(60);
        bool coasts = get(0x606C) == FAST || get(0x606C) > FAST * 9 / 10;
        int off = coasts ? COASTS : ms;
        if (state_of(get(STATUS)) != rows[i].ends || coasts != (rows[i].ms == COASTS) ||
            abs(off - rows[i].ms) > rows[i].ms / 10 + 5)
            fail_msg("%s: expected %02X after %d ms, got %04X after %d ms at %lld counts/s", rows[i].what, rows[i].ends,
                     rows[i].ms, (unsigned int)get(STATUS), off, (long long)get(0x606C));
        close_drive(state);
    }
}

/* 609Ah is 500 000 counts/s2, and a run searches at 50 000: 100 ms, which 6084h needs 500 for. */
static void homing_stops_on_609a(void **state)
{
    static const struct {
        const char *what;
        uint16_t word;
        unsigned int ends;
    } rows[] = {{"DRV-150 disable operation", 0x07, SWITCHED_ON},
                {"DRV-273 halt", START | 0x100, ENABLED},
                {"DRV-271 bit 4 back to 0", ENABLE, ENABLED}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(HM, 10000);
        assert_int_equal(write_sdo(0x6099, 1, FAST, 4), 0);
        assert_int_equal(write_sdo(0x6098, 0, 18, 1), 0);
        enable(0);
        put(CONTROL, START);
        cycles(300);
        expect_near(rows[i].what, FAST, 500, (double)get(0x606C));
        put(CONTROL, rows[i].word);
        cycles(115);
        expect_near(rows[i].what, 0, 600, (double)get(0x606C));
        until(0, rows[i].ends);
        close_drive(state);
    }
}

static void halt_by_mode(void **state)
{
    static const struct {
        const char *what;
        int8_t mode;
        uint16_t object;
        int64_t value, speed;
    } rows[] = {
        {"DRV-205 pv stops", PV, 0x60FF, FAST, 0},
        {"DRV-205 csv goes on", CSV, 0x60FF, FAST, FAST},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(rows[i].mode, 10000);
        enable(0);
        put(rows[i].object, rows[i].value);
        cycles(700);
        put(CONTROL, ENABLE | 0x100);
        cycles(700);
        expect_near(rows[i].what, (double)rows[i].speed, 500, (double)get(0x606C));
        close_drive(state);
    }
}

/* --- faults ------------------------------------------------------------------------------------------------------- */

static void each_fault(void **state)
{
    static const struct {
        const char *what;
        uint16_t code;
        uint8_t error_register;
        bool brakes, restarts;
    } rows[] = {
        {"DRV-163 overcurrent", 0x2310, 0x03, false, false},
        {"DRV-164 short circuit", 0x2320, 0x03, false, false},
        {"DRV-164 short circuit of the motor", 0x2340, 0x03, false, false},
        {"DRV-165 load too high", 0x2350, 0x03, true, false},
        {"DRV-166 phase missing", 0x3130, 0x05, true, false},
        {"DRV-167 DC link above", 0x3210, 0x05, false, false},
        {"DRV-168 device too warm", 0x4210, 0x09, true, false},
        {"DRV-168 motor too warm", 0x4310, 0x09, true, false},
        {"DRV-169 24 V low", 0x5112, 0x01, false, false},
        {"DRV-170 safety input", 0xFF10, 0x21, false, false},
        {"DRV-171 memory", 0x5530, 0x01, false, true},
        {"DRV-171 firmware", 0x6100, 0x01, false, true},
        {"DRV-172 parameter", 0x6320, 0x01, false, false},
        {"DRV-173 motor blocked", 0x7121, 0x01, true, false},
        {"DRV-174 incremental sensor", 0x7305, 0x01, false, false},
        {"DRV-176 overspeed", 0x8400, 0x21, false, false},
        {"DRV-177 following error", 0x8611, 0x21, true, false},
        {"DRV-177 reference limit", 0x8612, 0x21, true, false},
        {"DRV-178 synchronisation", 0x8700, 0x21, true, false},
        {"DRV-179 position sensor", 0x7320, 0x01, false, false},
        {"DRV-179 resolver", 0x7303, 0x01, false, false},
        {"DRV-180 vendor's own", 0xFF7F, 0x21, true, false},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        turning(PV);
        signals("axis1.fault", rows[i].code);
        cycles(2);
        unsigned int now = state_of(get(STATUS));
        expect_emergency(rows[i].code, rows[i].error_register);
        if (now != (rows[i].brakes ? REACTING : FAULT) || get(0x603F) != rows[i].code)
            fail_msg("%s: status word %04X, error %04X", rows[i].what, (unsigned int)get(STATUS),
                     (unsigned int)get(0x603F));
        put(CONTROL, 0x00);
        cycles(200);
        expect_near(rows[i].what, rows[i].brakes ? 0 : FAST, 500, (double)get(0x606C));
        assert_int_equal(get(0x6077), 0);
        put(CONTROL, RESET);
        cycles(2);
        if (state_of(get(STATUS)) != (rows[i].restarts ? FAULT : SOD))
            fail_msg("%s: after a reset the status word is %04X", rows[i].what, (unsigned int)get(STATUS));
        close_drive(state);
    }
}

static void commands_while_reacting(void **state)
{
    (void)state;
    turning(PV);
    set("axis1.fault", "16912");
    cycles(2);
    put(CONTROL, 0x00);
    cycles(10);
    assert_int_equal(state_of(get(STATUS)), REACTING);
    put(CONTROL, RESET);
    cycles(10);
    assert_int_equal(state_of(get(STATUS)), REACTING);
    until(0, FAULT);
    cycles(10);
    assert_int_equal(state_of(get(STATUS)), FAULT);
}

static void second_fault(void **state)
{
    (void)state;
    turning(PV);
    set("axis1.fault", "16912"); /* 4210h */
    cycles(2);
    expect_emergency(0x4210, 0x09);
    set("axis1.fault", "9040"); /* 2350h */
    cycles(2);
    expect_emergency(0x2350, 0x03);
    assert_int_equal(get(0x603F), 0x2350);
}

/* The state that follows PREOP or SAFEOP, with the outputs of the test as the first ones. */
/* --- edges -------------------------------------------------------------------------------------------------------- */

static void first_word(void **state)
{
    (void)state;
    open_drive("SERVO");
    set("axis1.fault", "16912");
    put(CONTROL, RESET);
    next_state(SAFEOP);
    next_state(OP);
    cycles(5);
    assert_int_equal(state_of(get(STATUS)), FAULT);
    command(0, 0, FAULT);
    command(0, RESET, SOD);
}

static void held_reset(void **state)
{
    (void)state;
    servo(CSP, 10000);
    enable(0);
    put(CONTROL, ENABLE | RESET);
    cycles(5);
    assert_int_equal(state_of(get(STATUS)), ENABLED);
    set("axis1.fault", "16912");
    cycles(100);
    assert_int_equal(state_of(get(STATUS)), FAULT);
}

static void bit4_at_the_entry(void **state)
{
    static const struct {
        const char *what;
        int8_t mode;
    } rows[] = {{"DRV-145 DRV-271 homing", HM}, {"DRV-145 a set-point", PP}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(CSP, 10000);
        assert_int_equal(write_sdo(0x6098, 0, 34, 1), 0);
        enable(0);
        put(MODE, rows[i].mode);
        put(TARGET, 30000);
        put(CONTROL, START);
        cycles(200);
        expect_near(rows[i].what, 0, 1, (double)get(ACTUAL));
        put(CONTROL, ENABLE);
        cycles(1);
        put(CONTROL, START);
        cycles(200);
        assert_true(get(ACTUAL) > 100);
        close_drive(state);
    }
}

/* --- AL states ---------------------------------------------------------------------------------------------------- */

static void below_op(void **state)
{
    static const struct {
        uint16_t word;
        unsigned int state;
    } rows[] = {{0x0F, SOD}, {0x07, SOD},   {0x06, READY}, {0x07, READY}, {0x0F, READY},
                {0x02, SOD}, {0x06, READY}, {0x00, SOD},   {0x06, READY}};
    (void)state;
    open_drive("SERVO");
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(write_sdo(CONTROL, 0, rows[i].word, 2), 0);
        assert_int_equal(state_of(read_sdo(STATUS, 0)), rows[i].state);
        assert_int_equal(read_sdo(STATUS, 0) & 0x200, 0);
    }
    next_state(SAFEOP);
    assert_int_equal(state_of(read_sdo(STATUS, 0)), READY);
    put(CONTROL, SHUTDOWN);
    next_state(OP);
    assert_int_equal(state_of(get(STATUS)), READY);
    assert_int_equal(get(STATUS) & 0x200, 0x200);
    command(0, ENABLE, ENABLED);
}

static void ready_ends_with_the_mailbox(void **state)
{
    (void)state;
    open_drive("SERVO");
    assert_int_equal(write_sdo(CONTROL, 0, SHUTDOWN, 2), 0);
    (void)wire_al(&wire, 0, ECT_STATE_INIT, NULL);
    wire_go(&wire, 0, PREOP);
    assert_int_equal(state_of(read_sdo(STATUS, 0)), SOD);
}

static void settings_outlast_op(void **state)
{
    static const struct {
        uint16_t index;
        size_t size;
        int64_t value;
    } rows[] = {{0x6084, 4, 12345}, {0x605E, 2, 1}, {0x6065, 4, 54321}, {0x60E0, 2, 777}};
    (void)state;
    servo(CSP, 10000);
    for (size_t i = 0; i < COUNT(rows); i++)
        assert_int_equal(write_sdo(rows[i].index, 0, rows[i].value, rows[i].size), 0);
    cycles(5);
    (void)wire_al(&wire, 0, SAFEOP, NULL);
    for (size_t i = 0; i < COUNT(rows); i++) {
        if (read_sdo(rows[i].index, 0) != rows[i].value)
            fail_msg("%04X: expected %lld in SAFEOP, got %lld", rows[i].index, (long long)rows[i].value,
                     (long long)read_sdo(rows[i].index, 0));
    }
}

static void op_left(void **state)
{
    static const struct {
        const char *what;
        unsigned int before, after;
    } rows[] = {{"Ready", READY, SOD}, {"Switched on", SWITCHED_ON, SOD}, {"Fault", FAULT, FAULT}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(CSP, 10000);
        bring(rows[i].before);
        if (rows[i].before == FAULT)
            expect_emergency(0x4210, 0x09);
        (void)wire_al(&wire, 0, SAFEOP, NULL);
        if (state_of(read_sdo(STATUS, 0)) != rows[i].after)
            fail_msg("%s: status word %04X", rows[i].what, (unsigned int)read_sdo(STATUS, 0));
        put(CONTROL, rows[i].before == FAULT ? 0 : SWITCH_ON);
        next_state(OP);
        cycles(3);
        assert_int_equal(state_of(get(STATUS)), rows[i].after);
        close_drive(state);
    }
}

static void demand_at_the_entry(void **state)
{
    (void)state;
    servo(HM, 10000);
    enable(0);
    assert_int_equal(home(37, -4000), 5);
    assert_int_equal(get(ACTUAL), 4000);
    put(CONTROL, 0);
    cycles(2);
    (void)wire_al(&wire, 0, SAFEOP, NULL);
    put(MODE, CSP);
    put(TARGET, 0);
    next_state(OP);
    cycles(3);
    assert_int_equal(read_sdo(0x6062, 0), 4000);
    assert_int_equal(get(ACTUAL), 4000);
}

static void control_by_mailbox_in_op(void **state)
{
    (void)state;
    servo(CSP, 10000);
    assert_int_equal(write_sdo(CONTROL, 0, SHUTDOWN, 2), 0);
    assert_int_equal(state_of(read_sdo(STATUS, 0)), READY);
    cycles(1);
    assert_int_equal(state_of(get(STATUS)), SOD);
}

static void cycle_time(void **state)
{
    static const struct {
        uint8_t subindex;
        int64_t value;
        uint32_t abort;
    } rows[] = {{1, 0, 0x06090030},  {1, 2, 0},  {2, 1, 0x06090030}, {2, -7, 0x06090030},
                {2, -6, 0x06090030}, {2, -3, 0}, {1, 250, 0},        {2, -6, 0},
                {1, 25, 0},          {2, -5, 0}, {2, -6, 0x06090030}};
    (void)state;
    open_drive("SERVO");
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint32_t abort = write_sdo(0x60C2, rows[i].subindex, rows[i].value, 1);
        if (abort != rows[i].abort)
            fail_msg("row %zu: expected %08X, got %08X", i, (unsigned int)rows[i].abort, (unsigned int)abort);
    }
    wire_go(&wire, 0, SAFEOP);
    assert_int_equal(write_sdo(0x60C2, 1, 1, 1), 0x08000022);
    operational();
    assert_int_equal(write_sdo(0x60C2, 2, -3, 1), 0x08000022);
    wire_go(&wire, 0, PREOP);
    assert_int_equal(write_sdo(0x60C2, 1, 1, 1), 0);
}

/* --- mapping ------------------------------------------------------------------------------------------------------ */

/* KickCAT maps a PDO while it is assigned, and assigns it after that. */
static void mapped_while_assigned(void **state)
{
    static const uint32_t outputs[] = {0x60400010, 0x60600008, 0x00000008, 0x607A0020, 0x60FF0020, 0x60710010};
    static const uint32_t inputs[] = {0x60410010, 0x60610008, 0x00000008, 0x60640020,
                                      0x606C0020, 0x60770010, 0x603F0010};
    static const struct {
        uint16_t pdo, assignment;
        const uint32_t *entries;
        uint8_t count;
    } rows[] = {{0x1600, 0x1C12, outputs, COUNT(outputs)}, {0x1A00, 0x1C13, inputs, COUNT(inputs)}};
    (void)state;
    open_drive("SERVO");
    assert_int_equal(write_sdo(MODE, 0, CSP, 1), 0);
    for (size_t i = 0; i < COUNT(rows); i++) {
        map(rows[i].pdo, 0, 0, 0);
        for (uint8_t e = 0; e < rows[i].count; e++)
            map(rows[i].pdo, (uint8_t)(e + 1), rows[i].entries[e], 0);
        map(rows[i].pdo, 0, rows[i].count, 0);
        assert_int_equal(write_sdo(rows[i].assignment, 0, 0, 1), 0);
        assert_int_equal(write_sdo(rows[i].assignment, 1, rows[i].pdo, 2), 0);
        assert_int_equal(write_sdo(rows[i].assignment, 0, 1, 1), 0);
    }
    put(MODE, CSP);
    next_state(SAFEOP);
    next_state(OP);
    enable(0);
    put(TARGET, 1000);
    cycles(300);
    expect_near("position", 1000, 2, (double)get(ACTUAL));
}

static void refused_mappings(void **state)
{
    static const struct {
        const char *what;
        uint32_t entry, abort;
    } rows[] = {{"an object of 8 bits in 16", 0x60600010, 0x06040041},
                {"an actual value as output", 0x60410010, 0x06040041},
                {"an object that may not be mapped", 0x60C20108, 0x06040041},
                {"padding of a bit", 0x00000001, 0},
                {"padding of 32 bits", 0x00000020, 0}};
    (void)state;
    open_drive("SERVO");
    map(0x1600, 0, 0, 0);
    for (size_t i = 0; i < COUNT(rows); i++)
        map(0x1600, 1, rows[i].entry, rows[i].abort);
}

/* Each SM of the process data, a byte longer than the mapping. */
static void lengths_that_do_not_fit(void **state)
{
    static const struct {
        unsigned int sm;
        uint16_t start;
        uint8_t control;
        uint16_t code;
    } rows[] = {{2, 0x1800, 0x64, 0x001D}, {3, 0x1C00, 0x20, 0x001E}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16_t code = 0;
        open_drive("SERVO");
        wire_configure_process_data(&wire, 0);
        wire_set_sm(&wire, 0, rows[i].sm, rows[i].start, (uint16_t)(size_of(rows[i].sm) + 1), rows[i].control);
        assert_int_equal(wire_al(&wire, 0, SAFEOP, &code) & 0x0F, PREOP);
        assert_int_equal(code, rows[i].code);
        (void)wire_al(&wire, 0, PREOP | 0x10, NULL);
        next_state(SAFEOP);
        close_drive(state);
    }
}

static void free_and_fixed(void **state)
{
    static const struct {
        const char *type;
        uint32_t abort;
    } rows[] = {{"SERVO", 0}, {"SMALL", 0x06010002}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        open_drive(rows[i].type);
        map(0x1600, 0, 0, rows[i].abort);
        map(0x1A00, 0, 0, rows[i].abort);
        close_drive(state);
    }
}

static void pdos_of_axes(void **state)
{
    static const struct {
        uint16_t assignment, pdo;
        uint8_t place;
        uint32_t first;
    } rows[] = {{0x1C12, 0x1600, 1, 0x60400010},
                {0x1C12, 0x1610, 2, 0x68400010},
                {0x1C13, 0x1A00, 1, 0x60410010},
                {0x1C13, 0x1A10, 2, 0x68410010}};
    (void)state;
    open_drive("DUAL");
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(read_sdo(rows[i].assignment, rows[i].place), rows[i].pdo);
        assert_int_equal(read_sdo(rows[i].pdo, 1), rows[i].first);
    }
}

static void device_types(void **state)
{
    static const char *const types[] = {"SERVO", "SMALL", "SPEED", "DUAL", "WIDE", "SCREW", "CYCLIC"};
    for (size_t i = 0; i < COUNT(types); i++) {
        open_drive(types[i]);
        if (read_sdo(0x1000, 0) != 0x00020192)
            fail_msg("%s: device type %08X", types[i], (unsigned int)read_sdo(0x1000, 0));
        close_drive(state);
    }
}

static void mapped_objects_by_mailbox(void **state)
{
    (void)state;
    servo(CSP, 10000);
    enable(0);
    put(TARGET, 500);
    cycles(1);
    put(TARGET, 900); /* not sent */
    assert_int_equal(read_sdo(TARGET, 0), 500);
    assert_int_equal(read_sdo(CONTROL, 0), ENABLE);
}

/* Objects are those of the drive in each AL state with a mailbox; no process data needs to be exchanged. */
static void objects_below_op(void **state)
{
    static const uint8_t states[] = {PREOP, SAFEOP};
    for (size_t i = 0; i < COUNT(states); i++) {
        open_drive("SERVO");
        if (states[i] == SAFEOP)
            next_state(SAFEOP);
        assert_int_equal(state_of(read_sdo(STATUS, 0) & 0xFFFF), SOD);
        set("axis1.fault", "16912");
        wire_advance(&wire, MS);
        expect_emergency(16912, 0x09);
        assert_int_equal(read_sdo(0x603F, 0), 16912);
        assert_int_equal(state_of(read_sdo(STATUS, 0) & 0xFFFF), FAULT);
        set("axis1.fault", "0");
        assert_int_equal(write_sdo(CONTROL, 0, 0, 2), 0); /* the first word has no edge */
        assert_int_equal(write_sdo(CONTROL, 0, RESET, 2), 0);
        wire_advance(&wire, MS);
        expect_emergency(0, 0);
        assert_int_equal(read_sdo(0x603F, 0), 0);
        assert_int_equal(state_of(read_sdo(STATUS, 0) & 0xFFFF), SOD);
        close_drive(state);
    }
}

#define WORD(index)                                                                                                    \
    "<Object><Index>#x" index "</Index><Name>V</Name><Type>UINT</Type><BitSize>16</BitSize><Flags><Access>rw</Access>" \
    "<PdoMapping>RT</PdoMapping></Flags></Object>"

/* Entries without meaning for a drive, wherever they are in the instance. */
static void other_signals(void **state)
{
    enum { ENTRIES = 3000 };
    static char text[ENTRIES * 150];
    char why[300] = "", name[40];
    size_t used = (size_t)snprintf(
        text, sizeof text, "%s",
        "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device Physics='YY'><Type ProductCode='1' "
        "RevisionNo='1'>D</Type><Profile><ProfileNo>402</ProfileNo><Dictionary><DataTypes><DataType><Name>UINT</Name>"
        "<BitSize>16</BitSize></DataType></DataTypes><Objects>" WORD("603F") WORD("6040") WORD("6041"));
    for (unsigned int i = 0; i < ENTRIES; i++)
        used += (size_t)snprintf(
            text + used, sizeof text - used,
            "<Object><Index>#x%04X</Index><Name>V</Name><Type>UINT</Type><BitSize>16</BitSize></Object>", 0x2000 + i);
    used += (size_t)snprintf(text + used, sizeof text - used, "%s",
                             "</Objects></Dictionary></Profile><Sm DefaultSize='128' StartAddress='#x1000' "
                             "ControlByte='#x26' Enable='1'>MBoxOut</Sm><Sm DefaultSize='128' StartAddress='#x1080' "
                             "ControlByte='#x22' Enable='1'>MBoxIn</Sm><Mailbox><CoE/></Mailbox></Device></Devices>"
                             "</Descriptions></EtherCATInfo>");
    (void)state;
    twin = ect_esi_twin_take(ect_esi_parse("t.xml", text, used, why, sizeof why), "", NULL, 0, why, sizeof why);
    if (twin == NULL || !ect_esi_twin_behave(twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why))
        fail_msg("expected a twin, got: %s", why);
    open_twin();
    for (unsigned int i = 0; i < ENTRIES; i++) {
        (void)snprintf(name, sizeof name, "od.%04x_00", 0x2000 + i);
        set(name, "4660");
    }
    assert_int_equal(read_sdo(0x603F, 0), 0);
    set("axis1.fault", "16912");
    assert_int_equal(signal_of("axis1.error_code"), 16912);
}

/* The shaft of a drive that has left OP runs down; objects follow it without process data. */
static void rundown_in_preop(void **state)
{
    enum { SPEED = 0x606C };
    (void)state;
    servo(PV, 10000);
    enable(0);
    put(0x60FF, 20000);
    cycles(500);
    assert_true(get(SPEED) > 19000);
    wire_go(&wire, 0, PREOP);
    expect_emergency(0x7500, 0x11); /* communication */
    const int64_t position = read_sdo(ACTUAL, 0);
    for (unsigned int n = 0; n < 100 && read_sdo(SPEED, 0) != 0; n++)
        wire_advance(&wire, 100 * MS);
    assert_int_equal(read_sdo(SPEED, 0), 0);
    assert_true(read_sdo(ACTUAL, 0) > position + 100);
}

int main(void)
{
#define TEST(title, function) {title, function, NULL, close_drive, NULL}
    const struct CMUnitTest tests[] = {
        TEST("DRV-102 DRV-103 DRV-105 DRV-106 DRV-108 DRV-115..122 DRV-127..137 DRV-141 DRV-142 DRV-144 DRV-124 each "
             "command from each state",
             each_command),
        TEST("DRV-127 no supply, no enable input, STO: Shutdown waits", supply),
        TEST("DRV-110 bit 5 by state and bit 2 of the control word", quick_stop_bit),
        TEST("DRV-111 a warning is a bit and changes nothing", warning),
        TEST("DRV-109 DRV-512 bit 4 is the DC link", voltage),
        TEST("DRV-146..150 DRV-407 each option code's ramp, time and state", stops),
        TEST("DRV-150 DRV-271 DRV-273 homing stops on 609Ah", homing_stops_on_609a),
        TEST("DRV-205 halt acts in profiled modes", halt_by_mode),
        TEST("DRV-163..174 DRV-176..180 DRV-151 DRV-162 DRV-139 each fault's reaction, register and reset", each_fault),
        TEST("DRV-107 DRV-142 no command acts in Fault reaction active", commands_while_reacting),
        TEST("DRV-161 a second fault sends an emergency, and 603Fh is its code", second_fault),
        TEST("DRV-145 a bit 7 in the first control word is no edge", first_word),
        TEST("DRV-143 a bit 7 that stays does not reset a later fault", held_reset),
        TEST("DRV-145 DRV-271 a bit 4 that rises with its mode starts nothing", bit4_at_the_entry),
        TEST("DRV-153 DRV-154 DRV-112 DRV-514 a control word by SDO below OP leads to Ready at most", below_op),
        TEST("DRV-154 INIT ends commands of the mailbox", ready_ends_with_the_mailbox),
        TEST("DRV-149 DRV-155 settings by SDO outlast the end of OP", settings_outlast_op),
        TEST("DRV-157 OP left without torque", op_left),
        TEST("DRV-158 the demand begins at the shaft", demand_at_the_entry),
        TEST("DRV-154 DRV-513 a control word by SDO holds until the next frame", control_by_mailbox_in_op),
        TEST("DRV-601 DRV-602 DRV-092..094 a PDO mapped while it is assigned", mapped_while_assigned),
        TEST("DRV-095 DRV-093 entries that cannot be mapped, and padding", refused_mappings),
        TEST("DRV-160 SAFEOP is refused for lengths that the mapping does not have", lengths_that_do_not_fit),
        TEST("DRV-527 PDOs that are free, and fixed ones", free_and_fixed),
        TEST("DRV-091 1610h and 1A10h are those of the second axis", pdos_of_axes),
        TEST("DRV-001 1000h of each shape of file: servo, CiA 402", device_types),
        TEST("DRV-099 a mapped object by SDO is the value taken last", mapped_objects_by_mailbox),
        TEST("DRV-099 a fault of a signal is in the objects below OP", objects_below_op),
        TEST("a signal of another entry than the drive's causes no fault", other_signals),
        TEST("DRV-099 DRV-157 the objects of a shaft that runs down in PREOP", rundown_in_preop),
        TEST("DRV-263 DRV-065 60C2h: range, whole steps, not in SAFEOP and OP", cycle_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
