/* SPDX-License-Identifier: MIT */
/* Phase run-up of the PMCtendo (manual §4.2, §4.3, §4.7, §4.8): functions of each AL state, n17 and F28. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "devices/pmctendo/pmctendo.h"
#include "support/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP, ERR = 0x10 };
enum { MASK = 0x0204, N17 = 1 << 16 };

static drive_t d;

static int setup(void **state)
{
    (void)state;
    drive_open(&d);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    drive_close(&d);
    return 0;
}

static void expect_display(const char *when, const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&d.w, "display", text);
    if (strcmp(text, want) != 0)
        fail_msg("%s: expected %s on the display, got %s", when, want[0] ? want : "nothing",
                 text[0] ? text : "nothing");
}

static void registers(void **state)
{
    static const struct {
        uint16_t address;
        uint8_t bytes[8];
    } sms[] = {{0x0800, {0x00, 0x18, 16, 0, 0x26, 0, 1, 0}},
               {0x0808, {0x00, 0x1C, 16, 0, 0x22, 0, 1, 0}},
               {0x0810, {0x00, 0x11, 6, 0, 0x64, 0, 1, 0}},
               {0x0818, {0x40, 0x11, 6, 0, 0x20, 0, 1, 0}}};
    (void)state;
    drive_safeop(&d, 0x1701, 0x1B01);
    for (size_t i = 0; i < COUNT(sms); i++) {
        uint8_t bytes[8];
        assert_int_equal(wire_read(&d.w, 0, sms[i].address, bytes, sizeof bytes), 1);
        bytes[5] = sms[i].bytes[5]; /* the status */
        assert_memory_equal(bytes, sms[i].bytes, sizeof bytes);
    }
    assert_int_equal(wire_read16(&d.w, 0, 0x0120), SAFEOP);
    assert_int_equal(wire_read16(&d.w, 0, 0x0130), SAFEOP);
    assert_int_equal(wire_read16(&d.w, 0, 0x0134), 0);
    assert_int_equal(wire_al(&d.w, 0, 3, NULL), SAFEOP | ERR);
    assert_int_equal(wire_read16(&d.w, 0, 0x0130), SAFEOP | ERR);
    assert_int_not_equal(wire_read16(&d.w, 0, 0x0134), 0);
}

/* The events that interrupt the drive, by AL state: mailbox from PREOP on, process data from SAFEOP on. */
static void events(void **state)
{
    (void)state;
    assert_int_equal(wire_read8(&d.w, 0, MASK + 1), 0x01); /* Mail Out */
    drive_safeop(&d, 0x1701, 0x1B01);
    assert_int_equal(wire_read8(&d.w, 0, MASK + 1), 0x0D); /* and Pro Out, Pro In */
    assert_int_equal(wire_al(&d.w, 0, PREOP, NULL), PREOP);
    assert_int_equal(wire_read8(&d.w, 0, MASK + 1), 0x01);
    assert_int_equal(wire_al(&d.w, 0, INIT, NULL), INIT);
    assert_int_equal(wire_read8(&d.w, 0, MASK + 1), 0x00);
    assert_int_equal(wire_read8(&d.w, 0, MASK) & 0x01, 0x01); /* AL Control alone stays */
    uint8_t mail[16] = {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40};
    assert_int_equal(wire_write(&d.w, 0, 0x1800, mail, sizeof mail), 0);
}

/* --- n17, F28 ----------------------------------------------------------------------------------------------------- */

static void no_sync(void **state)
{
    (void)state;
    expect_display("PREOP", "n17");
    drive_safeop(&d, 0x1701, 0x1B01);
    expect_display("SAFEOP without cycles", "n17");
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_WARNING, ECT_402_STATUS_WARNING);
    drive_cycles(&d, 2);
    expect_display("SAFEOP with cycles", "");
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_WARNING, 0);
    assert_int_equal(wire_al(&d.w, 0, OP, NULL), OP);
    expect_display("OP", "");
    assert_int_equal(wire_al(&d.w, 0, PREOP, NULL), PREOP);
    expect_display("back in PREOP", "n17");
    assert_int_equal(wire_al(&d.w, 0, INIT, NULL), INIT);
    expect_display("INIT", "n17");
}

/* SYNC0, its cycle, 60C2h: units and power of ten; whether the drive synchronises. */
static const struct {
    uint32_t sync0_ns;
    uint8_t units;
    int8_t power;
    bool good;
} cycles[] = {{1000000, 1, -3, true},   {2000000, 2, -3, true}, {2000000, 20, -4, true}, {250000, 25, -5, true},
              {500000, 5, -4, true},    {4000000, 4, -3, true}, {1000000, 2, -3, false}, {2000000, 1, -3, false},
              {1000000, 10, -3, false}, {300000, 3, -4, false}};

static void one_cycle_time(size_t i)
{
    drive_open(&d);
    d.dc_ns = cycles[i].sync0_ns;
    d.cycle_ns = cycles[i].sync0_ns;
    assert_int_equal(drive_write(&d, 0x60C2, 1, cycles[i].units, 1), 0);
    assert_int_equal(drive_write(&d, 0x60C2, 2, (uint8_t)cycles[i].power, 1), 0);
    drive_safeop(&d, 0x1701, 0x1B01);
    expect_display("SAFEOP without cycles", "n17");
    drive_cycles(&d, 10);
    bool found = (drive_instance(&d)->warnings & N17) == 0;
    if (found != cycles[i].good)
        fail_msg("SYNC0 %u ns, 60C2h %u x 10^%d: expected %s", cycles[i].sync0_ns, cycles[i].units, cycles[i].power,
                 cycles[i].good ? "no n17" : "n17");
    uint8_t al = wire_al(&d.w, 0, OP, NULL);
    assert_int_equal(al, cycles[i].good ? OP : SAFEOP);
    for (uint64_t end = d.w.now_ns + 2100 * MS; d.w.now_ns < end && !cycles[i].good;)
        drive_cycle(&d);
    assert_int_equal(wire_read8(&d.w, 0, ECT_REG_AL_STATUS), cycles[i].good ? OP : SAFEOP | ERR);
    assert_int_equal(wire_read16(&d.w, 0, ECT_REG_AL_STATUS_CODE), cycles[i].good ? 0 : 0x001A);
    expect_display("at the end", cycles[i].good ? "" : "F28");
    drive_expect(&d, cycles[i].good ? ECT_402_SWITCH_ON_DISABLED : ECT_402_FAULT, "at the end");
    drive_close(&d);
}

static void cycle_times(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(cycles); i++)
        one_cycle_time(i);
}

/* Frames with outputs every millisecond between the pulses of SYNC0, every four milliseconds. */
static void outputs_are_no_rhythm(void **state)
{
    enum { PULSE_MS = 4, FIRST_MS = PULSE_MS / 2, PULSES = 5 }; /* the first one, and four that follow it in time */
    (void)state;
    d.dc_ns = PULSE_MS * MS;
    assert_int_equal(drive_write(&d, 0x60C2, 1, PULSE_MS, 1), 0);
    assert_int_equal(drive_write(&d, 0x60C2, 2, (uint8_t)-3, 1), 0);
    drive_safeop(&d, 0x1701, 0x1B01);
    drive_cycles(&d, FIRST_MS + (PULSES - 1) * PULSE_MS - 1);
    expect_display("before the fifth pulse", "n17");
    drive_cycles(&d, 2);
    expect_display("after the fifth pulse", "");
}

/* 60C2h is 0.3 ms, no multiple of 250 us: without a clock the drive synchronises to any frames, with a tolerance to
 * none. */
static void tolerance_in_safeop(void **state)
{
    (void)state;
    assert_int_equal(drive_write(&d, 0x60C2, 1, 3, 1), 0);
    assert_int_equal(drive_write(&d, 0x60C2, 2, (uint8_t)-4, 1), 0);
    drive_safeop(&d, 0x1701, 0x1B01);
    drive_cycles(&d, 3);
    expect_display("any frames", "");
    signal_set(&d.w, "sync_tolerance", "1000");
    drive_cycles(&d, 2);
    expect_display("within 1000 ppm of 60C2h", "n17");
    signal_set(&d.w, "sync_tolerance", "0");
    drive_cycles(&d, 2);
    expect_display("any frames again", "");
}

static void shorter_than_allowed(void **state)
{
    uint16_t code = 0;
    (void)state;
    uint8_t bytes[8] = {0};
    ect_store_le32(bytes, 125000);
    assert_int_equal(wire_write(&d.w, 0, ECT_REG_DC_SYNC0_CYCLE, bytes, 4), 1);
    assert_int_equal(wire_write8(&d.w, 0, ECT_REG_DC_ACTIVATION, 0x03), 1);
    wire_configure_process_data(&d.w, 0);
    assert_int_equal(wire_al(&d.w, 0, SAFEOP, &code), PREOP | ERR);
    assert_int_equal(code, 0x0036);
}

/* The rate of the master's own cycle is checked if the user requests it: 1000 ppm, as in the manual. */
static void tolerance(void **state)
{
    static const struct {
        uint64_t cycle_ns;
        bool good;
    } rows[] = {{1000000, true}, {1000900, true}, {999100, true}, {1001100, false}, {998900, false}, {2000000, false}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        drive_open(&d);
        d.cycle_ns = rows[i].cycle_ns;
        signal_set(&d.w, "sync_tolerance", "1000");
        signal_set(&d.w, "sync_patience", "10");
        drive_safeop(&d, 0x1701, 0x1B01);
        drive_cycles(&d, 40);
        if (((drive_instance(&d)->warnings & N17) == 0) != rows[i].good)
            fail_msg("a cycle of %llu ns: expected %s", (unsigned long long)rows[i].cycle_ns,
                     rows[i].good ? "no n17" : "n17");
        drive_close(&d);
    }
}

/* In OP: no outputs for 100 ms; none for sync_patience; SYNC0 switched off. The drive brakes and is in Fault, F28. */
static const struct {
    const char *what;
    bool dc;
    const char *patience;
    bool stop_sync0;
    unsigned int least_ms, within_ms;
    uint16_t code;
} losses[] = {{"the watchdog", false, "0", false, 99, 101, 0x001B},
              {"sync_patience", false, "20", false, 20, 22, 0x001A},
              {"outputs missing at SYNC0", true, "0", false, 1, 7, 0x001A},
              {"SYNC0 switched off", true, "0", true, 1, 7, 0x002C}};

static void one_loss(size_t i)
{
    drive_open(&d);
    d.dc_ns = losses[i].dc ? 1000000 : 0;
    signal_set(&d.w, "sync_patience", losses[i].patience);
    drive_operational(&d, 0x1702, 0x1B01);
    drive_enable(&d);
    drive_set(&d, 20 * PMC_TURN);
    drive_cycles(&d, 200);
    assert_true(drive_instance(&d)->plant.machine.speed > 19.0 * PMC_TURN);
    if (losses[i].stop_sync0)
        assert_int_equal(wire_write8(&d.w, 0, ECT_REG_DC_ACTIVATION, 0), 1);
    uint64_t from = d.w.now_ns;
    while (wire_read8(&d.w, 0, ECT_REG_AL_STATUS) == OP && d.w.now_ns - from < 1000 * MS) {
        if (losses[i].stop_sync0)
            assert_int_equal(wire_write(&d.w, 0, 0x1100, d.out, 6), 1);
        wire_advance(&d.w, MS);
    }
    uint16_t code = wire_read16(&d.w, 0, ECT_REG_AL_STATUS_CODE);
    if (d.w.now_ns - from < losses[i].least_ms * MS || d.w.now_ns - from > losses[i].within_ms * MS ||
        code != losses[i].code)
        fail_msg("%s: expected code %04X after %u to %u ms, got %04X after %llu ms", losses[i].what, losses[i].code,
                 losses[i].least_ms, losses[i].within_ms, code, (unsigned long long)((d.w.now_ns - from) / MS));
    assert_int_equal(wire_read8(&d.w, 0, ECT_REG_AL_STATUS), SAFEOP | ERR);
    expect_display(losses[i].what, "F28");
    drive_expect(&d, ECT_402_FAULT_REACTION, losses[i].what);
    wire_advance(&d.w, 80 * MS); /* 20 turns a second at 500 turns a second squared: 40 ms */
    drive_expect(&d, ECT_402_FAULT, losses[i].what);
    assert_int_equal(signal_number(&d.w, "powered"), 0);
    drive_close(&d);
}

static void sync_lost(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(losses); i++)
        one_loss(i);
}

/* The emergency of a fault: error code, error register, the number on the display. */
static void expect_emergency(uint16_t code, uint8_t error_register, uint8_t number)
{
    uint8_t mail[16] = {0};
    assert_int_equal(wire_mail_receive(&d.w, 0, mail, sizeof mail), 10);
    const uint8_t *e = mail + 6;
    if (ect_load_le16(e) >> 12 != 1 || ect_load_le16(e + 2) != code || e[4] != error_register || e[5] != number)
        fail_msg("F%02u: expected the emergency %04X %02X %02X, got service %u, %04X %02X %02X", number, code,
                 error_register, number, ect_load_le16(e) >> 12, ect_load_le16(e + 2), e[4], e[5]);
}

/* Each sends an emergency and ends in Fault; PREOP to SAFEOP clears those that need no restart. */
static void faults(void **state)
{
    static const struct {
        const char *fault;
        uint16_t code;
        uint8_t error_register;
        bool stays;
    } rows[] = {{"1", 0x4210, 0x09, false},  {"2", 0x3210, 0x05, false},  {"3", 0x8611, 0x21, false},
                {"4", 0x7305, 0x21, true},   {"5", 0x3220, 0x05, false},  {"6", 0x4310, 0x09, false},
                {"8", 0x8480, 0x21, false},  {"9", 0x5530, 0x01, true},   {"14", 0x5400, 0x03, true},
                {"15", 0x2310, 0x03, false}, {"16", 0x3130, 0x05, false}, {"27", 0xFF1B, 0x21, false},
                {"28", 0x8700, 0x11, false}, {"30", 0xFF1E, 0x21, false}, {"32", 0x6100, 0x01, true}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint8_t number = (uint8_t)atoi(rows[i].fault);
        drive_open(&d);
        char display[8];
        snprintf(display, sizeof display, "F%02u", number);
        signal_set(&d.w, "provoke", rows[i].fault);
        expect_display("provoked", display);
        expect_emergency(rows[i].code, rows[i].error_register, number);
        assert_int_equal(drive_read(&d, 0x603F, 0), rows[i].code);
        assert_int_equal(drive_read(&d, 0x2000, 1), number);
        assert_int_equal(drive_read(&d, 0x1001, 0), rows[i].error_register);
        drive_safeop(&d, 0x1701, 0x1B01);
        drive_expect(&d, rows[i].stays ? ECT_402_FAULT : ECT_402_SWITCH_ON_DISABLED, rows[i].fault);
        if (!rows[i].stays) {
            expect_emergency(0, 0, 0);
            assert_int_equal(drive_read(&d, 0x603F, 0), 0);
        }
        drive_close(&d);
    }
    char message[ECT_SIGNAL_MESSAGE];
    drive_open(&d);
    assert_false(signal_try_set(&d.w, "provoke", "7", message));
    drive_close(&d);
}

/* The signal alone: no tick, no exchange follows it. */
static void write_alone(const char *name, const char *value)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    ect_signal_ref_t ref;
    signal_find(&d.w, name, &ref);
    if (!ect_signal_write(&ref, value, d.w.now_ns, message))
        fail_msg("%s := %s: %s", name, value, message);
}

static void faults_at_once(void **state)
{
    static const struct {
        const char *signal, *value, *display, *shown;
    } rows[] = {{"provoke", "28", "F28", "fault reaction active"},
                {"sto", "1", "F27", "fault"},
                {"power", "0", "F05", "fault"},
                {"enable", "0", "", "switch on disabled"}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        drive_open(&d);
        drive_operational(&d, 0x1702, 0x1B01);
        drive_enable(&d);
        drive_set(&d, 20 * PMC_TURN);
        drive_cycles(&d, 100);
        write_alone(rows[i].signal, rows[i].value);
        signal_get(&d.w, "state", text);
        if (strcmp(text, rows[i].shown) != 0)
            fail_msg("%s := %s: expected state '%s', got '%s'", rows[i].signal, rows[i].value, rows[i].shown, text);
        expect_display(rows[i].signal, rows[i].display);
        drive_close(&d);
    }
}

/* --- what is open, what locked ------------------------------------------------------------------------------------ */

/* No state of the bus and no control word below OP causes motion, and in OP only the whole sequence does. */
static void no_motion_without_enable(void **state)
{
    static const uint16_t words[] = {0x06, 0x07, 0x0F, 0x1F, 0x80F, 0xFFFF};
    (void)state;
    drive_safeop(&d, 0x1701, 0x1B01);
    drive_set(&d, 1000000);
    for (size_t i = 0; i < COUNT(words); i++) {
        drive_control(&d, words[i]);
        drive_cycles(&d, 50);
        drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "SAFEOP");
    }
    assert_int_equal(wire_al(&d.w, 0, OP, NULL), OP);
    for (unsigned int control = 0x07; control <= 0xFF; control += 0x08) { /* all that begin in the middle */
        drive_control(&d, (uint16_t)control);
        drive_cycles(&d, 3);
        drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "OP");
    }
    assert_int_equal(drive_position(&d), 0);
    assert_true(drive_instance(&d)->plant.machine.speed == 0 && drive_instance(&d)->axis.torque_now == 0);
}

/* Actual values from SAFEOP on, set values in OP; leaving OP locks them and stops the shaft. */
static void locks(void **state)
{
    (void)state;
    signal_set(&d.w, "di1", "1");
    assert_int_equal(drive_read(&d, 0x6041, 0), 0); /* PREOP: no status word yet */
    drive_safeop(&d, 0x1702, 0x1B26);
    drive_cycle(&d);
    assert_true((drive_status(&d) & 0x4F) == 0x40);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_REMOTE, 0);
    assert_int_equal(wire_al(&d.w, 0, OP, NULL), OP);
    drive_cycle(&d);
    assert_int_equal(drive_status(&d) & ECT_402_STATUS_REMOTE, ECT_402_STATUS_REMOTE);
    drive_enable(&d);
    drive_set(&d, 10 * PMC_TURN);
    drive_cycles(&d, 100);
    assert_int_equal(wire_al(&d.w, 0, SAFEOP, NULL), SAFEOP);
    drive_expect(&d, ECT_402_QUICK_STOP, "OP to SAFEOP");
    drive_cycles(&d, 60); /* set values continue: the speed of 10 turns per second is 0 after 20 ms */
    drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "SAFEOP");
    int32_t position = drive_position(&d);
    assert_true(position > PMC_TURN / 2);
    drive_cycles(&d, 50);
    assert_int_equal(drive_position(&d), position);
    assert_int_equal(wire_al(&d.w, 0, PREOP, NULL), PREOP);
    assert_int_equal((int32_t)drive_read(&d, 0x6064, 0), position); /* frozen */
    assert_int_equal(wire_al(&d.w, 0, SAFEOP, NULL), SAFEOP);
    drive_cycle(&d);
    assert_int_equal(wire_al(&d.w, 0, OP, NULL), OP);
    drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "OP again"); /* the control word is 0Fh all the time */
    drive_cycles(&d, 10);
    drive_expect(&d, ECT_402_SWITCH_ON_DISABLED, "OP again");
}

/* --- by the manual's codes ---------------------------------------------------------------------------------------- */

static void al_codes(void **state)
{
    static const struct {
        uint8_t from;
        uint8_t request;
        uint16_t standard, manual;
    } rows[] = {{INIT, SAFEOP, 0x0011, 0x0011}, {INIT, OP, 0x0011, 0x0011},     {INIT, 3, 0x0013, 0x0011},
                {PREOP, OP, 0x0011, 0x0011},    {PREOP, 3, 0x0011, 0x0011},     {PREOP, 9, 0x0012, 0x0011},
                {SAFEOP, 3, 0x0011, 0x0011},    {PREOP, SAFEOP, 0x001D, 0x0017}};
    (void)state;
    for (size_t i = 0; i < 2 * COUNT(rows); i++) {
        uint16_t code = 0;
        bool manual = i % 2 == 1;
        drive_open(&d);
        signal_set(&d.w, "quirk_pilz_codes", manual ? "1" : "0");
        if (rows[i / 2].from == SAFEOP)
            drive_safeop(&d, 0x1701, 0x1B01);
        else if (rows[i / 2].from == INIT)
            assert_int_equal(wire_al(&d.w, 0, INIT, NULL), INIT);
        uint8_t al = wire_al(&d.w, 0, rows[i / 2].request, &code);
        uint16_t want = manual ? rows[i / 2].manual : rows[i / 2].standard;
        if (al != (rows[i / 2].from | ERR) || code != want)
            fail_msg("from %u to %u: expected code %04X, got AL status %02X code %04X", rows[i / 2].from,
                     rows[i / 2].request, want, al, code);
        drive_close(&d);
    }
}

/* Each PDO of the manual: only its own length is accepted. */
static void fixed_pdos(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t bytes;
    } rows[] = {{0x1701, 6},  {0x1702, 6}, {0x1704, 4},  {0x1720, 12}, {0x1721, 8},
                {0x1722, 14}, {0x1B01, 6}, {0x1B25, 32}, {0x1B26, 16}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        bool out = rows[i].index < 0x1A00;
        for (int off = -1; off <= 1; off++) {
            uint16_t code = 0;
            drive_open(&d);
            assert_int_equal(drive_write(&d, out ? 0x1C12 : 0x1C13, 0, 0, 1), 0);
            assert_int_equal(drive_write(&d, out ? 0x1C12 : 0x1C13, 1, rows[i].index, 2), 0);
            assert_int_equal(drive_write(&d, out ? 0x1C12 : 0x1C13, 0, 1, 1), 0);
            wire_configure_process_data(&d.w, 0);
            wire_set_sm(&d.w, 0, out ? 2 : 3, out ? 0x1100 : 0x1140, (uint16_t)(rows[i].bytes + off),
                        out ? 0x64 : 0x20);
            uint8_t al = wire_al(&d.w, 0, SAFEOP, &code);
            if ((al == SAFEOP) != (off == 0))
                fail_msg("%04X with %d bytes: AL status %02X code %04X", rows[i].index, rows[i].bytes + off, al, code);
            drive_close(&d);
        }
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"PLZ-015 PLZ-016: AL Control, AL Status, AL Status Code and SyncManagers at their addresses", registers, setup,
         teardown, NULL},
        {"PLZ-013 PLZ-018: interrupt enable opens mailbox and process data with the states, and disables all except AL "
         "control",
         events, setup, teardown, NULL},
        {"PLZ-017 PLZ-020: n17 until the drive is synchronised, and again below SAFEOP", no_sync, setup, teardown,
         NULL},
        {"PLZ-017 PLZ-025: SYNC0 at 60C2h's cycle, 0.25 ms and more: OP; at another one n17, then F28 and 001Ah",
         cycle_times, NULL, NULL, NULL},
        {"PLZ-017: with SYNC0, frames with outputs do not contribute to the synchronisation that ends n17",
         outputs_are_no_rhythm, setup, teardown, NULL},
        {"PLZ-017: sync_tolerance set in SAFEOP ends a synchronisation that 60C2h does not allow", tolerance_in_safeop,
         setup, teardown, NULL},
        {"PLZ-025 DRV-160: a SYNC0 below 0.25 ms is refused", shorter_than_allowed, setup, teardown, NULL},
        {"PLZ-017: sync_tolerance: the master's frames within 1000 ppm", tolerance, NULL, NULL, NULL},
        {"PLZ-017 PLZ-020: a loss of synchronisation in OP: F28, the drive brakes and is off", sync_lost, NULL, NULL,
         NULL},
        {"PLZ-020: every fault shows its number and sends an emergency; PREOP to SAFEOP clears those that need no "
         "restart",
         faults, NULL, NULL, NULL},
        {"PLZ-017 PLZ-020: state and display show a signal's fault before the next tick", faults_at_once, NULL, NULL,
         NULL},
        {"PLZ-031 PLZ-021: no motion without the whole sequence in OP", no_motion_without_enable, setup, teardown,
         NULL},
        {"PLZ-019 PLZ-020: set values apply only in OP; SAFEOP stops and holds the shaft", locks, setup, teardown,
         NULL},
        {"PLZ-015: AL status codes of the standard; those of the manual with quirk_pilz_codes", al_codes, NULL, NULL,
         NULL},
        {"PLZ-029: each fixed PDO with its length and no other", fixed_pdos, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("PMCtendo states", tests, NULL, NULL);
}
