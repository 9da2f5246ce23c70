/* SPDX-License-Identifier: MIT */
/* Signals of measuring devices: units of the profile's objects or of the entry, ranges of the dictionary. */
#include "sensor_of_file.h"

static void expect_range(const char *name, const char *wanted)
{
    ect_signal_ref_t ref;
    char text[ECT_SIGNAL_TEXT_ROOM];
    if (!ect_chain_signal(wire.chain, 0, name, &ref))
        fail_msg("there is no signal %s", name);
    ect_signal_range(ref.signal, text);
    if (strcmp(text, wanted) != 0)
        fail_msg("%s: expected %s, got %s", name, wanted, text);
}

static void units_and_ranges(void **state)
{
    static const struct {
        const char *type, *name, *range;
    } rows[] = {
        {"PRESSURE", "inputs.pressure", "any number bar"},
        {"PRESSURE", "inputs.pressure_16", "-32768..32767 mbar"},
        {"PRESSURE", "inputs.temperature_16", "-400..8500 10^-2 degC"},
        {"PRESSURE", "od.6130_02", "any number degC"},
        {"PRESSURE", "od.6131_01", "0..4294967295"},
        {"PRESSURE", "od.9148_01", "-2147483648..2147483647 mbar"},
        {"ANALOG", "inputs.voltage", "0..10000 mV"},
        {"ANALOG", "inputs.number", "-32768..32767"},
        {"ANALOG", "inputs.current", "-32768..32767 mA"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        open_sensor("sensors.xml", rows[i].type);
        expect_range(rows[i].name, rows[i].range);
        close_sensor(state);
    }
}

static void other_profiles(void **state)
{
    (void)state;
    open_sensor("encoders.xml", "ROTARY");
    expect_range("od.6002_00", "0..4294967295");
}

static void values_arrive(void **state)
{
    uint8_t in[8];
    (void)state;
    open_shell("sensors.xml", "PRESSURE");
    wire_go(&wire, 0, ECT_STATE_SAFEOP);
    set("inputs.pressure_16", "1250");
    assert_false(try_set("inputs.temperature_16", "8501"));
    inputs_after(1, in, sizeof in);
    assert_int_equal(ect_load_le16(in + 4), 1250);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"signals have the units of 6131h, 6132h, 6430h or the entry, and the limits of the entry", units_and_ranges,
         NULL, close_sensor, NULL},
        {"objects of other profiles have no unit", other_profiles, NULL, close_sensor, NULL},
        {"a value in the unit of its signal reaches the process data", values_arrive, NULL, close_sensor, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
