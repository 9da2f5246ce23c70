/* SPDX-License-Identifier: MIT */
/* Encoders of ESI files: position, speed and preset in the units of the master, and the shaft as signals. */
#include "rack.h"
#include "sensor_of_file.h"

#define FILE_OF_TESTS "encoders.xml"
enum { OPERATING = 0x6000, UNITS = 0x6001, RANGE = 0x6002, PRESET = 0x6003, POSITION = 0x6004, SPEED = 0x6030 };
enum { SCALED = 4, REVERSED = 1, RANGE_ERROR = 0x06090030 };

static void open_encoder(const char *type)
{
    open_sensor(FILE_OF_TESTS, type);
}

static void at(const char *turns)
{
    set("encoder1.position", turns);
    wire_advance(&wire, MS);
}

static void expect(uint16_t index, uint8_t subindex, int64_t wanted)
{
    int64_t got = read_sdo(index, subindex);
    if (got != wanted)
        fail_msg("%04X:%u: expected %lld, got %lld", (unsigned int)index, (unsigned int)subindex, (long long)wanted,
                 (long long)got);
}

/* --- which files -------------------------------------------------------------------------------------------------- */

static void encoders_are_noted(void **state)
{
    static const struct {
        const char *type, *note;
    } rows[] = {
        {"ROTARY", "CiA 406: encoder 1 position preset speed; without behaviour: 6040 6041 6200 6504"},
        {"LINEAR", "CiA 406: linear encoder 1 position preset speed; linear encoder 2 position preset speed"},
        {"PLAIN", "CiA 406: encoder 1 position speed"},
        {"BLIND", ""},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        twin = make(FILE_OF_TESTS, rows[i].type, ECT_BEHAVIOUR_BY_FILE);
        assert_string_equal(note("CiA 406"), rows[i].note);
        if (i + 1 == COUNT(rows))
            assert_string_equal(note("ProfileNo"),
                                "ProfileNo is 406, but there is no 6004h, 6008h and 6020h: it has no behaviour");
        close_sensor(state);
    }
}

static void a_shell_stays(void **state)
{
    (void)state;
    twin = make(FILE_OF_TESTS, "ROTARY", ECT_BEHAVIOUR_NONE);
    assert_string_equal(note("CiA"), "");
}

static void on_request(void **state)
{
    (void)state;
    twin = make(FILE_OF_TESTS, "PLAIN", ECT_BEHAVIOUR_CIA406);
    assert_string_equal(note("CiA 406"), "CiA 406: encoder 1 position speed");
}

static void no_encoder(void **state)
{
    static const struct {
        const char *file, *type, *text;
    } rows[] = {
        {"digital.xml", "DO16", "DO16 has no position 6004h, 6008h or 6020h: it cannot be a CiA 406 encoder"},
        {FILE_OF_TESTS, "BLIND", "BLIND has no position 6004h, 6008h or 6020h: it cannot be a CiA 406 encoder"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char path[300];
        char text[300] = "";
        (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, rows[i].file);
        twin = ect_esi_twin_make(path, rows[i].type, NULL, 0, text, sizeof text);
        assert_non_null(twin);
        assert_false(ect_esi_twin_behave(twin, ECT_BEHAVIOUR_CIA406, text, sizeof text));
        assert_string_equal(text, rows[i].text);
        close_sensor(state);
    }
}

#define ENCODER(profile, objects)                                                                                      \
    ESI_DEVICE("<Profile>" profile DICTIONARY(objects) "</Profile>" ESI_MAILBOX_SMS                                    \
                                                       "<Mailbox><CoE/></Mailbox>" ESI_EEPROM)
#define DICTIONARY(objects)                                                                                            \
    "<Dictionary><DataTypes><DataType><Name>UDINT</Name><BitSize>32</BitSize></DataType></DataTypes><Objects>" objects \
    "</Objects></Dictionary>"
#define STEPS                                                                                                          \
    "<Dictionary><DataTypes><DataType><Name>USINT</Name><BitSize>8</BitSize></DataType><DataType><Name>UDINT</Name>"   \
    "<BitSize>32</BitSize></DataType><DataType><Name>DT6005</Name><BitSize>48</BitSize><SubItem><SubIdx>0</SubIdx>"    \
    "<Name>N</Name><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs></SubItem><SubItem><SubIdx>1</SubIdx>"    \
    "<Name>Step</Name><Type>UDINT</Type><BitSize>32</BitSize><BitOffs>16</BitOffs></SubItem></DataType></DataTypes>"   \
    "<Objects><Object><Index>#x6005</Index><Name>N</Name><Type>DT6005</Type><BitSize>48</BitSize></Object>"
#define LINEAR(objects)                                                                                                \
    ESI_DEVICE("<Profile>" STEPS objects "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS                           \
               "<Mailbox><CoE/></Mailbox>" ESI_EEPROM)
#define OBJECT(index) "<Object><Index>#x" index "</Index><Name>N</Name><Type>UDINT</Type><BitSize>32</BitSize></Object>"

#define TWELVE_OBJECTS                                                                                                 \
    OBJECT("6200")                                                                                                     \
    OBJECT("6201")                                                                                                     \
    OBJECT("6202")                                                                                                     \
    OBJECT("6203")                                                                                                     \
    OBJECT("6204")                                                                                                     \
    OBJECT("6205")                                                                                                     \
    OBJECT("6206") OBJECT("6207") OBJECT("6208") OBJECT("6209") OBJECT("620A") OBJECT("620B")

/* A file without ProfileNo needs a position and its resolution, and no control word of a drive. */
static void by_their_objects(void **state)
{
    static const struct {
        const char *what, *text, *note; /* NULL: none */
    } rows[] = {
        {"position, units", ENCODER("", OBJECT("6001") OBJECT("6004")), "CiA 406: encoder 1 position"},
        {"position, resolution", ENCODER("", OBJECT("6004") OBJECT("6501")), "CiA 406: encoder 1 position"},
        {"position, units, resolution", ENCODER("", OBJECT("6001") OBJECT("6004") OBJECT("6501")),
         "CiA 406: encoder 1 position"},
        {"wide position", ENCODER("", OBJECT("6001") OBJECT("6008")), "CiA 406: encoder 1 position"},
        {"wide position and preset", ENCODER("", OBJECT("6001") OBJECT("6008") OBJECT("6009")),
         "CiA 406: encoder 1 position preset"},
        {"position, step", LINEAR(OBJECT("6004")), "CiA 406: linear encoder 1 position"},
        {"position, step, units", LINEAR(OBJECT("6001") OBJECT("6004")), "CiA 406: encoder 1 position"},
        {"position, step, resolution", LINEAR(OBJECT("6004") OBJECT("6501")), "CiA 406: linear encoder 1 position"},
        {"step, resolution", LINEAR(OBJECT("6501")), NULL},
        {"position alone", ENCODER("", OBJECT("6004")), NULL},
        {"resolution alone", ENCODER("", OBJECT("6501")), NULL},
        {"a drive", ENCODER("", OBJECT("6004") OBJECT("6040") OBJECT("6501")), NULL},
        {"another profile", ENCODER("<ProfileNo>401</ProfileNo>", OBJECT("6001") OBJECT("6004")), NULL},
        {"the profile, position alone", ENCODER("<ProfileNo>406</ProfileNo>", OBJECT("6004")),
         "CiA 406: encoder 1 position"},
        {"twelve objects without behaviour", ENCODER("<ProfileNo>406</ProfileNo>", OBJECT("6004") TWELVE_OBJECTS),
         "CiA 406: encoder 1 position; without behaviour: 6200 6201 6202 6203 6204 6205 6206 6207 6208 6209 620A 620B"},
        {"thirteen objects without behaviour",
         ENCODER("<ProfileNo>406</ProfileNo>", OBJECT("6004") TWELVE_OBJECTS OBJECT("620C")),
         "CiA 406: encoder 1 position; without behaviour: 6200 6201 6202 6203 6204 6205 6206 6207 6208 6209 620A 620B "
         "and 1 more"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[300] = "";
        made_t m = make_text(rows[i].what, rows[i].text);
        assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_BY_FILE, text, sizeof text));
        const char *got = note_of(&m, "CiA 406");
        if ((got == NULL) != (rows[i].note == NULL) || (got != NULL && strcmp(got, rows[i].note) != 0))
            fail_msg("%s: expected the note %s, got %s", rows[i].what, rows[i].note != NULL ? rows[i].note : "none",
                     got != NULL ? got : "none");
        free_made(&m);
    }
}

static void no_encoder_with_modules(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        {RACK(DOWNLOAD, DICTIONARY(OBJECT("6001") OBJECT("6004"))),
         "RACK has modules that change: it cannot be a CiA 406 encoder"},
        {RACK(DOWNLOAD, ""), "RACK has no position 6004h, 6008h or 6020h: it cannot be a CiA 406 encoder"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[300] = "";
        made_t m = make_text("a rack", rows[i].text);
        assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_BY_FILE, text, sizeof text));
        assert_null(note_of(&m, "CiA 406"));
        assert_false(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_CIA406, text, sizeof text));
        assert_string_equal(text, rows[i].why);
        free_made(&m);
    }
}

/* --- position and speed ------------------------------------------------------------------------------------------- */

static void turns_at_a_speed(void **state)
{
    uint8_t in[16];
    (void)state;
    open_encoder("ROTARY");
    wire_go(&wire, 0, ECT_STATE_SAFEOP);
    set("encoder1.speed", "60");
    inputs_after(2500, in, sizeof in);
    assert_true(labs((long)ect_load_le32(in) - 2500) <= 2);
    assert_int_equal(ect_load_le16(in + 4), 1000);
    assert_true(fabs(signal_of("encoder1.position") - 2.5) < 0.002);
    set("encoder1.speed", "-120");
    inputs_after(1000, in, sizeof in);
    assert_true(labs((long)ect_load_le32(in) - 500) <= 4);
    assert_int_equal((int16_t)ect_load_le16(in + 4), -2000);
    set("encoder1.speed", "0");
    inputs_after(1, in, sizeof in);
    uint32_t rest = ect_load_le32(in);
    inputs_after(100, in, sizeof in);
    assert_int_equal(ect_load_le32(in), rest);
    assert_int_equal(ect_load_le16(in + 4), 0);
}

static void wraps_at_the_range(void **state)
{
    static const struct {
        const char *turns;
        int64_t scaled, raw, unscaled, wide;
    } rows[] = {
        {"0", 0, 0, 0, 0},
        {"1.5", 1500, 98304, 98304, 1500},
        {"-0.001", 4095999, 0xFFFFFFBE, 268435390, 4095999999},
        {"4096", 0, 268435456, 0, 4096000},
        {"-4096.25", 4095750, -268451840, 268419072, 4091903750},
    };
    (void)state;
    open_encoder("ROTARY");
    for (size_t i = 0; i < COUNT(rows); i++) {
        at(rows[i].turns);
        expect(POSITION, 0, rows[i].scaled);
        expect(0x6008, 0, rows[i].wide);
        expect(0x600C, 0, (int32_t)rows[i].raw);
        assert_true(signal_of("encoder1.counts") == (double)rows[i].scaled);
        assert_int_equal(write_sdo(OPERATING, 0, 0, 2), 0);
        expect(POSITION, 0, rows[i].unscaled);
        expect(0x6500, 0, 0);
        assert_int_equal(write_sdo(OPERATING, 0, SCALED, 2), 0);
        expect(0x6500, 0, SCALED);
    }
}

static void direction(void **state)
{
    (void)state;
    open_encoder("ROTARY");
    at("10.25");
    set("encoder1.speed", "6");
    wire_advance(&wire, MS);
    assert_int_equal(write_sdo(OPERATING, 0, SCALED | REVERSED, 2), 0);
    set("encoder1.position", "10.25");
    set("encoder1.speed", "0");
    wire_advance(&wire, MS);
    expect(POSITION, 0, 4096000 - 10250);
    set("encoder1.speed", "6");
    wire_advance(&wire, MS);
    expect(SPEED, 1, (uint16_t)-100);
}

static void a_preset(void **state)
{
    static const struct {
        int64_t operating, preset, after; /* after a tenth of a turn */
    } rows[] = {{SCALED, 5000, 5100}, {SCALED, 4095950, 50}, {SCALED | REVERSED, 5000, 4900}, {0, 5000, 11553}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        open_encoder("ROTARY");
        assert_int_equal(write_sdo(OPERATING, 0, rows[i].operating, 2), 0);
        at("7.5");
        assert_int_equal(write_sdo(PRESET, 0, rows[i].preset, 4), 0);
        expect(POSITION, 0, rows[i].preset);
        at("7.6");
        int64_t got = read_sdo(POSITION, 0);
        if (llabs(got - rows[i].after) > 1)
            fail_msg("preset %lld: expected %lld, got %lld", (long long)rows[i].preset, (long long)rows[i].after,
                     (long long)got);
        close_sensor(state);
    }
}

static void offset_of_a_preset(void **state)
{
    (void)state;
    open_encoder("ROTARY");
    at("7.5");
    assert_int_equal(write_sdo(PRESET, 0, 5000, 4), 0);
    expect(0x6509, 0, -2500);
    assert_int_equal(write_sdo(0x6009, 0, 4000000000, 8), 0);
    expect(0x6008, 0, 4000000000);
}

static void units_change(void **state)
{
    (void)state;
    open_encoder("ROTARY");
    at("2.5");
    assert_int_equal(write_sdo(UNITS, 0, 3600, 4), 0);
    assert_int_equal(write_sdo(RANGE, 0, 7200, 4), 0);
    expect(POSITION, 0, 1800);
}

static void refused_settings(void **state)
{
    static const struct {
        const char *type;
        uint16_t index;
        uint8_t subindex;
        int64_t value;
        size_t size;
        uint32_t abort;
    } rows[] = {
        {"ROTARY", UNITS, 0, 0, 4, RANGE_ERROR},
        {"ROTARY", UNITS, 0, 65536, 4, 0},
        {"ROTARY", UNITS, 0, 65537, 4, RANGE_ERROR},
        {"ROTARY", RANGE, 0, 0, 4, RANGE_ERROR},
        {"ROTARY", 0x600A, 0, 0, 8, RANGE_ERROR},
        {"ROTARY", PRESET, 0, 4095999, 4, 0},
        {"ROTARY", PRESET, 0, 4096000, 4, RANGE_ERROR},
        {"ROTARY", 0x6031, 3, 0, 2, RANGE_ERROR},
        {"ROTARY", 0x6031, 2, 0, 2, 0},
        {"ROTARY", 0x6200, 0, 5, 2, 0},
        {"LINEAR", 0x6010, 2, -5, 4, 0},
        {"LINEAR", 0x6005, 1, 0, 4, RANGE_ERROR},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        open_encoder(rows[i].type);
        uint32_t abort = write_sdo(rows[i].index, rows[i].subindex, rows[i].value, rows[i].size);
        if (abort != rows[i].abort)
            fail_msg("%04X:%u = %lld: expected %08X, got %08X", (unsigned int)rows[i].index,
                     (unsigned int)rows[i].subindex, (long long)rows[i].value, (unsigned int)rows[i].abort,
                     (unsigned int)abort);
        close_sensor(state);
    }
}

static void units_of_speed(void **state)
{
    static const struct {
        const char *unit;
        int64_t multiplier, divisor, speed;
    } rows[] = {{"0", 1, 1, 10000}, {"0", 1, 10, 1000}, {"0", 2, 1, 20000}, {"0", 9, 1, 32767},
                {"1", 1, 1, 600},   {"2", 1, 1, 6000},  {"1", 3, 2, 900}};
    (void)state;
    open_encoder("ROTARY");
    set("encoder1.speed", "600");
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(write_sdo(0x6031, 3, rows[i].multiplier, 2), 0);
        assert_int_equal(write_sdo(0x6031, 4, rows[i].divisor, 2), 0);
        set("encoder1.velocity_unit", rows[i].unit);
        wire_advance(&wire, MS);
        expect(SPEED, 1, rows[i].speed);
    }
    assert_true(signal_of("encoder1.velocity") == 900);
}

static void diagnosis(void **state)
{
    (void)state;
    open_encoder("ROTARY");
    set("encoder1.alarms", "4097");
    set("encoder1.warnings", "2");
    wire_advance(&wire, MS);
    expect(0x6503, 0, 4097);
    expect(0x6505, 0, 2);
}

static void two_carriages(void **state)
{
    (void)state;
    open_encoder("LINEAR"); /* a unit is 1 um, a unit of speed 0.1 mm/s */
    set("encoder1.position", "-12.5");
    set("encoder2.position", "3");
    set("encoder2.speed", "20");
    wire_advance(&wire, 100 * MS);
    expect(0x6020, 1, -12500);
    assert_true(llabs(read_sdo(0x6020, 2) - 5000) <= 30);
    expect(SPEED, 1, 0);
    expect(SPEED, 2, 200);
    set("encoder2.speed", "0");
    set("encoder2.position", "5");
    assert_int_equal(write_sdo(0x6010, 2, -40, 4), 0);
    expect(0x6020, 2, -40);
    expect(0x650C, 2, -5040);
    expect(0x6020, 1, -12500);
    set("encoder2.position", "4");
    wire_advance(&wire, MS);
    expect(0x6020, 2, -1040);
}

/* The next event of an encoder that turns is within 1 ms. */
static void next_event(void **state)
{
    (void)state;
    open_encoder("LINEAR");
    assert_true(ect_chain_poll(wire.chain, wire.now_ns) > wire.now_ns + MS);
    set("encoder2.speed", "20");
    assert_true(ect_chain_poll(wire.chain, wire.now_ns) <= wire.now_ns + MS);
    set("encoder2.speed", "0");
    set("encoder1.speed", "-20");
    assert_true(ect_chain_poll(wire.chain, wire.now_ns) <= wire.now_ns + MS);
}

static void without_settings(void **state)
{
    (void)state;
    open_encoder("PLAIN");
    at("-0.5");
    expect(POSITION, 0, -32768); /* 65536 units a turn, of 32 bits */
    set("encoder1.resolution", "1000");
    wire_advance(&wire, MS);
    expect(POSITION, 0, -500);
    set("encoder1.speed", "60");
    wire_advance(&wire, MS);
    expect(SPEED, 0, 1000);
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static void signals_of_the_file_are_locked(void **state)
{
    (void)state;
    open_encoder("ROTARY");
    assert_false(try_set("inputs.position_value", "5"));
    assert_true(try_set("od.6003_00", "5"));
    set("encoder1.position", "1");
    wire_advance(&wire, MS);
    assert_true(signal_of("inputs.position_value") == 1000);
    assert_false(try_set("encoder1.position", "536870913"));
    assert_true(try_set("encoder1.position", "536870912"));
}

static void position_outlasts_power(void **state)
{
    (void)state;
    open_encoder("ROTARY");
    at("2.5");
    assert_int_equal(write_sdo(PRESET, 0, 0, 4), 0);
    expect(POSITION, 0, 0);
    ect_chain_power_cycle(wire.chain, wire.now_ns);
    wire_assign_stations(&wire);
    wire_go(&wire, 0, ECT_STATE_PREOP);
    expect(POSITION, 0, 2500);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"the line at start names encoders, their functions, and objects without behaviour", encoders_are_noted, NULL,
         close_sensor, NULL},
        {"--behaviour none leaves a shell", a_shell_stays, NULL, close_sensor, NULL},
        {"--behaviour cia406 makes an encoder", on_request, NULL, close_sensor, NULL},
        {"--behaviour cia406 refuses a file without a position", no_encoder, NULL, close_sensor, NULL},
        {"a file without ProfileNo is an encoder by its objects", by_their_objects, NULL, NULL, NULL},
        {"--behaviour cia406 refuses a device whose modules change", no_encoder_with_modules, NULL, NULL, NULL},
        {"a shaft that turns counts, with its speed in 6030h", turns_at_a_speed, NULL, close_sensor, NULL},
        {"positions wrap at 6002h, 600Ah, or the turns of the sensor", wraps_at_the_range, NULL, close_sensor, NULL},
        {"6000h bit 0 turns the direction", direction, NULL, close_sensor, NULL},
        {"6003h sets the position", a_preset, NULL, close_sensor, NULL},
        {"6509h and 6009h of a preset", offset_of_a_preset, NULL, close_sensor, NULL},
        {"6001h and 6002h change units and range", units_change, NULL, close_sensor, NULL},
        {"settings out of range are refused", refused_settings, NULL, close_sensor, NULL},
        {"6031h and the unit of speed", units_of_speed, NULL, close_sensor, NULL},
        {"alarms and warnings reach 6503h and 6505h", diagnosis, NULL, close_sensor, NULL},
        {"two carriages of a linear encoder, in steps of 6005h", two_carriages, NULL, close_sensor, NULL},
        {"an encoder that turns has its next event within 1 ms", next_event, NULL, close_sensor, NULL},
        {"an encoder without settings and ProfileNo", without_settings, NULL, close_sensor, NULL},
        {"signals of actual values are read-only", signals_of_the_file_are_locked, NULL, close_sensor, NULL},
        {"the shaft outlasts a power cycle, a preset does not", position_outlasts_power, NULL, close_sensor, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
