/* SPDX-License-Identifier: MIT */
/* Measuring devices of ESI files: field values, scaling, offset, zero, spans and status, and the sensor as signals. */
#include "from_text.h"
#include "sensor_of_file.h"

#define FILE_OF_TESTS "sensors.xml"
enum { AUTOZERO = 0x6125, REAL = 0x6130, DIGITS = 0x6132, STATUS = 0x6150, FIELD = 0x7100, PROCESS = 0x7130 };
enum { PROCESS_1 = 0x7121, FIELD_2 = 0x7122, PROCESS_2 = 0x7123, OFFSET = 0x7124, ZERO = 0x6F72657A };
enum { RANGE_ERROR = 0x06090030, STORE_ERROR = 0x08000020 };

static void open_input(void)
{
    open_sensor(FILE_OF_TESTS, "SCALED");
}

static void expect(uint16_t index, uint8_t subindex, int64_t wanted)
{
    const int64_t got = (int16_t)read_sdo(index, subindex);
    if (got != wanted)
        fail_msg("%04X:%u: expected %lld, got %lld", (unsigned int)index, (unsigned int)subindex, (long long)wanted,
                 (long long)got);
}

static void expect_real(uint16_t index, uint8_t subindex, double wanted)
{
    const uint32_t bits = (uint32_t)read_sdo(index, subindex);
    float got;
    memcpy(&got, &bits, sizeof got);
    if (fabs((double)got - wanted) > 0.001)
        fail_msg("%04X:%u: expected %g, got %g", (unsigned int)index, (unsigned int)subindex, wanted, (double)got);
}

static void write_ok(uint16_t index, uint8_t subindex, int64_t value, size_t size)
{
    assert_int_equal(write_sdo(index, subindex, value, size), 0);
}

/* --- which files -------------------------------------------------------------------------------------------------- */

static void inputs_are_noted(void **state)
{
    static const struct {
        const char *type, *note;
    } rows[] = {
        {"SCALED", "CiA 404: input 1 scaling autozero status; input 2 scaling autozero status; without behaviour: "
                   "6110 6133 8130"},
        {"PRESSURE", "CiA 404: input 1; input 2"},
        {"SILENT", ""},
        {"ANALOG", ""},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        twin = make(FILE_OF_TESTS, rows[i].type, ECT_BEHAVIOUR_BY_FILE);
        assert_string_equal(note("CiA 404"), rows[i].note);
        if (strcmp(rows[i].type, "SILENT") == 0)
            assert_string_equal(note("ProfileNo"),
                                "ProfileNo is 404, but there is no 6130h, 7130h and 9130h: it has no behaviour");
        close_sensor(state);
    }
}

static void on_request(void **state)
{
    char path[300], text[300] = "";
    (void)state;
    twin = make(FILE_OF_TESTS, "SCALED", ECT_BEHAVIOUR_NONE);
    assert_string_equal(note("CiA"), "");
    close_sensor(state);
    (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, FILE_OF_TESTS);
    twin = ect_esi_twin_make(path, "ANALOG", NULL, 0, text, sizeof text);
    assert_non_null(twin);
    assert_false(ect_esi_twin_behave(twin, ECT_BEHAVIOUR_CIA404, text, sizeof text));
    assert_string_equal(text,
                        "ANALOG has no process value 6130h, 7130h or 9130h: it cannot be a CiA 404 measuring device");
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static void a_value_is_scaled(void **state)
{
    static const struct {
        const char *bar;
        int64_t field, process;
        double real;
    } rows[] = {
        {"0", 4000, 0, 0},           {"300", 12000, 3000, 300},   {"600", 20000, 6000, 600},
        {"12.34", 4329, 123, 12.34}, {"-100", 1333, -1000, -100}, {"1000000", INT16_MAX, INT16_MAX, 1000000},
    };
    (void)state;
    open_input();
    for (size_t i = 0; i < COUNT(rows); i++) {
        set("measure1.value", rows[i].bar);
        expect(FIELD, 1, rows[i].field);
        expect(PROCESS, 1, rows[i].process);
        expect_real(REAL, 1, rows[i].real);
        assert_true(fabs(signal_of("measure1.process") - rows[i].real) < 1e-6);
    }
    set("measure2.value", "25");
    expect(FIELD, 2, 1500);
    expect(PROCESS, 2, 2500);
}

static void a_master_scales_anew(void **state)
{
    (void)state;
    open_input();
    set("measure1.value", "300");
    write_ok(PROCESS_2, 1, 12000, 2);
    expect(FIELD, 1, 12000);
    expect(PROCESS, 1, 6000);
    write_ok(PROCESS_1, 1, 1000, 2);
    expect(PROCESS, 1, 6500);
    write_ok(OFFSET, 1, -500, 2);
    expect(PROCESS, 1, 6000);
    set("measure1.value", "0");
    expect(PROCESS, 1, 500);
}

static void points_of_one_field_value(void **state)
{
    (void)state;
    open_input();
    set("measure1.value", "300");
    write_ok(FIELD_2, 1, 4000, 2);
    expect(PROCESS, 1, INT16_MAX);
    expect_real(REAL, 1, 12000);
}

static void formats_agree(void **state)
{
    (void)state;
    open_input();
    assert_int_equal(read_sdo(0x9123, 1), 6000);
    write_ok(0x9123, 1, 3000, 4);
    expect(PROCESS_2, 1, 3000);
    set("measure1.value", "600");
    expect(PROCESS, 1, 3000);
    set("od.7123_01", "1500");
    assert_int_equal(read_sdo(0x9123, 1), 1500);
    expect(PROCESS, 1, 1500);
}

static void decimal_digits(void **state)
{
    (void)state;
    open_input();
    set("measure1.value", "300");
    write_ok(DIGITS, 1, 2, 1); /* 6000 are now 60.00 bar */
    expect(PROCESS_2, 1, 6000);
    expect(PROCESS, 1, 3000);
    expect_real(REAL, 1, 30);
    write_ok(DIGITS, 1, 9, 1);
    assert_int_equal(write_sdo(DIGITS, 1, 10, 1), RANGE_ERROR);
}

static void autozero(void **state)
{
    (void)state;
    open_input();
    set("measure1.value", "12");
    write_ok(OFFSET, 1, 50, 2);
    expect(PROCESS, 1, 170);
    assert_int_equal(write_sdo(AUTOZERO, 1, ZERO + 1, 4), STORE_ERROR);
    expect(PROCESS, 1, 170);
    write_ok(AUTOZERO, 1, ZERO, 4);
    expect(OFFSET, 1, -120);
    expect(PROCESS, 1, 0);
    set("measure1.value", "13");
    expect(PROCESS, 1, 10);
    expect(OFFSET, 2, 0);
}

static void other_objects(void **state)
{
    static const struct {
        uint16_t index;
        int64_t value;
        size_t size;
    } rows[] = {{0x6110, 50, 2}, {0x6133, 0x7FC00000, 4}};
    (void)state;
    open_input();
    set("measure1.value", "300");
    for (size_t i = 0; i < COUNT(rows); i++) {
        write_ok(rows[i].index, 1, rows[i].value, rows[i].size);
        if (read_sdo(rows[i].index, 1) != rows[i].value)
            fail_msg("%04X: expected %lld, got %lld", (unsigned int)rows[i].index, (long long)rows[i].value,
                     (long long)read_sdo(rows[i].index, 1));
        expect(PROCESS, 1, 3000);
    }
}

static void status(void **state)
{
    static const struct {
        const char *value, *invalid;
        int64_t status;
    } rows[] = {{"600", "0", 0}, {"600.1", "0", 2}, {"-0.1", "0", 4}, {"0", "0", 0},
                {"700", "1", 1}, {"700", "0", 2},   {"300", "1", 3},  {"300", "0", 0}};
    (void)state;
    open_input();
    for (size_t i = 0; i < COUNT(rows); i++) {
        set("measure1.invalid", rows[i].invalid);
        set("measure1.value", rows[i].value);
        if (read_sdo(STATUS, 1) != rows[i].status)
            fail_msg("row %zu: expected %d, got %d", i, (int)rows[i].status, (int)read_sdo(STATUS, 1));
    }
    set("measure1.invalid", "1");
    set("measure1.value", "500");
    expect(PROCESS, 1, 3000);
}

static void without_scaling(void **state)
{
    uint8_t in[8];
    (void)state;
    open_sensor(FILE_OF_TESTS, "PRESSURE");
    wire_go(&wire, 0, ECT_STATE_SAFEOP);
    set("measure1.value", "1.25");
    set("measure2.value", "-3.5");
    inputs_after(1, in, sizeof in);
    assert_int_equal(ect_load_le16(in + 4), 1250);
    assert_int_equal((int16_t)ect_load_le16(in + 6), -350);
    assert_int_equal(ect_load_le32(in), 0x3FA00000); /* 1.25 */
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static void expect_unit(const char *name, const char *wanted)
{
    ect_signal_ref_t ref;
    assert_true(ect_chain_signal(wire.chain, 0, name, &ref));
    assert_string_equal(ref.signal->unit, wanted);
}

static void signals(void **state)
{
    (void)state;
    open_input();
    expect_unit("measure1.value", "bar");
    expect_unit("measure2.value", "degC");
    expect_unit("measure2.process", "degC");
    assert_false(try_set("inputs.pressure", "5"));
    assert_false(try_set("inputs.status_1", "1"));
    assert_false(try_set("measure1.process", "5"));
    assert_false(try_set("measure1.value", "1000000000001"));
    assert_true(try_set("od.7124_01", "10"));
    expect(PROCESS, 1, 10);
}

/* A single 6131h is the unit of the first input. */
static void single_unit(void **state)
{
#define VALUE(index, name, type, rest)                                                                                 \
    "<Object><Index>" index "</Index><Name>" name "</Name><Type>" type "</Type><BitSize>32</BitSize>" rest "</Object>"
#define SINGLE                                                                                                         \
    ESI_DEVICE("<Profile><ProfileNo>404</ProfileNo><Dictionary><DataTypes><DataType><Name>REAL</Name><BitSize>32"      \
               "</BitSize></DataType><DataType><Name>UDINT</Name><BitSize>32</BitSize></DataType></"                   \
               "DataTypes><Objects>" VALUE("#x6130", "Value", "REAL", "") VALUE(                                       \
                   "#x6131", "Unit", "UDINT",                                                                          \
                   "<Info><DefaultData>00004E00</DefaultData></Info>") "</Objects></Dictionary></"                     \
                                                                       "Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS      \
                                                                       "<Mailbox><CoE/></Mailbox>" ESI_EEPROM)
    char why[200] = "";
    const char *unit = NULL;
    (void)state;
    made_t m = make_text("a single unit", SINGLE);
    assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why));
    const ect_plant_t *plant = ect_esi_twin_product(m.twin)->plant;
    for (size_t i = 0; i < plant->signal_group_count; i++) {
        if (strcmp(plant->signal_groups[i].prefix, "measure1") == 0)
            unit = plant->signal_groups[i].signals[0].unit;
    }
    assert_non_null(unit);
    assert_string_equal(unit, "bar");
    free_made(&m);
}

static void value_outlasts_power(void **state)
{
    (void)state;
    open_input();
    set("measure1.value", "150");
    write_ok(OFFSET, 1, 10, 2);
    expect(PROCESS, 1, 1510);
    ect_chain_power_cycle(wire.chain, wire.now_ns);
    wire_assign_stations(&wire);
    wire_go(&wire, 0, ECT_STATE_PREOP);
    expect(PROCESS, 1, 1500);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"the line at start names inputs, their functions, and objects without behaviour", inputs_are_noted, NULL,
         close_sensor, NULL},
        {"--behaviour none leaves a shell, cia404 refuses a file without a process value", on_request, NULL,
         close_sensor, NULL},
        {"a physical value becomes field value and process value by the points of 7120h to 7123h", a_value_is_scaled,
         NULL, close_sensor, NULL},
        {"points and offset of a master scale the same field value to another process value", a_master_scales_anew,
         NULL, close_sensor, NULL},
        {"two points with the same field value scale nothing", points_of_one_field_value, NULL, close_sensor, NULL},
        {"entries of a quantity in several formats agree", formats_agree, NULL, close_sensor, NULL},
        {"6132h shifts integers, at most 9 places", decimal_digits, NULL, close_sensor, NULL},
        {"the signature in 6125h makes the process value 0 by the offset, any other value is refused", autozero, NULL,
         close_sensor, NULL},
        {"an object without behaviour keeps the values of a master, and changes no other value", other_objects, NULL,
         close_sensor, NULL},
        {"6150h has overload beyond the span, and a value that is not valid", status, NULL, close_sensor, NULL},
        {"without scaling the process value is the physical value, in all formats", without_scaling, NULL, close_sensor,
         NULL},
        {"signals have the unit of their input, and those that the input writes are read-only", signals, NULL,
         close_sensor, NULL},
        {"a single 6131h is the unit of a single input", single_unit, NULL, NULL, NULL},
        {"the physical value outlasts a power cycle, the offset does not", value_outlasts_power, NULL, close_sensor,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
