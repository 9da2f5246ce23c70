/* SPDX-License-Identifier: MIT */
/* The surroundings of each product when it is switched on, as its manual in docs/devices describes them. */
#include <string.h>

#include "bus/chain/catalogue.h"
#include "support/signals.h"
#include "support/wire.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

typedef struct row {
    const char *signal, *value;
} row_t;

static void expect_all(const char *name, const row_t *rows, size_t count)
{
    const ect_product_t *product = ect_catalogue_find(name);
    ect_twin_config_t twin = ect_twin_default(product->device, product->plant);
    unsigned int wrong = 0;
    wire_t w;
    memset(&w, 0, sizeof w);
    wire_open_twins(&w, &twin, 1);
    for (size_t i = 0; i < count; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        signal_get(&w, rows[i].signal, text);
        if (strcmp(text, rows[i].value) != 0) {
            print_error("%s: expected %s = %s, got %s\n", name, rows[i].signal, rows[i].value, text);
            wrong++;
        }
    }
    wire_close(&w);
    assert_int_equal(wrong, 0);
}

static void sensor(void **state)
{
    static const row_t rows[] = {
        {"laser", "1"},
        {"range", "20"},
        {"exposure", "50"},
        {"temperature", "25"},
        {"seed", "1"},
        {"laser_power", "0"},
        {"default_user", "0"},
        {"user", "0"},
        {"row1", "0"},
        {"row2", "0"},
        {"row_present", "1"},
        {"row_time", "1000"},
        {"rows", "0"},
        {"surface1.present", "1"},
        {"surface1.distance", "10"},
        {"surface1.source", "0"},
        {"surface1.amplitude", "1"},
        {"surface1.period", "1000000"},
        {"surface1.noise", "0"},
        {"surface1.intensity", "50"},
        {"surface1.fault", "0"},
        {"surface2.present", "0"},
        {"surface2.distance", "12"},
        {"surface2.source", "0"},
        {"surface2.amplitude", "1"},
        {"surface2.period", "1000000"},
        {"surface2.noise", "0"},
        {"surface2.intensity", "50"},
        {"surface2.fault", "0"},
    };
    (void)state;
    expect_all("optoncdt2300", rows, COUNT(rows));
}

static void camera(void **state)
{
    static const row_t rows[] = {
        {"scene", "0"},
        {"scene_group", "0"},
        {"judgement", "0"},
        {"run", "1"},
        {"err", "0"},
        {"camera", "0"},
        {"node_address", "0"},
        {"fieldbus", "1"},
        {"output_control", "0"},
        {"output_period", "100"},
        {"output_time", "50"},
        {"output_repeat", "0"},
        {"timeout", "100"},
        {"exe_timeout", "0"},
        {"data1", "0"},
        {"data8", "0"},
        {"units", "4"},
        {"output_unit", "3"},
        {"judgement0", "1"},
        {"judgement7", "1"},
        {"output_format", "0"},
        {"expression1", ""},
        {"expression8", ""},
        {"comment1", ""},
        {"comment8", ""},
        {"source1", "0"},
        {"amplitude1", "1"},
        {"amplitude8", "1"},
        {"period1", "100"},
        {"period8", "100"},
        {"seed", "1"},
        {"row1", "0"},
        {"row8", "0"},
        {"row_scene", "-1"},
        {"row_judgement", "0"},
        {"row_image_input", "0"},
        {"row_processing", "0"},
        {"rows", "0"},
    };
    (void)state;
    expect_all("fzm1", rows, COUNT(rows));
}

static void drive(void **state)
{
    static const row_t rows[] = {
        {"power", "1"},
        {"enable", "1"},
        {"sto", "0"},
        {"di1", "0"},
        {"di2", "0"},
        {"di3", "1"},
        {"di4", "1"},
        {"load", "0"},
        {"load_inertia", "0"},
        {"friction", "0.05"},
        {"brake", "9"},
        {"brake_delay", "30"},
        {"analog", "0"},
        {"feedback2", "0"},
        {"probe_at", "0"},
        {"probe_width", "0"},
        {"home_at", "0"},
        {"home_width", "0"},
        {"stop_positive", "2147483647"},
        {"stop_negative", "-2147483648"},
        {"stop_positive_fitted", "0"},
        {"stop_negative_fitted", "0"},
        {"index_at", "0"},
        {"sync_patience", "0"},
        {"sync_timeout", "2000"},
        {"sync_tolerance", "0"},
        {"status_bits", "0"},
        {"quirk_pilz_reply", "0"},
        {"quirk_pilz_codes", "0"},
        {"fault", "0"},
        {"powered", "0"},
        {"homed", "0"},
        {"turns", "0"},
        {"do1", "0"},
        {"do2", "0"},
        {"saves", "0"},
    };
    (void)state;
    expect_all("pmctendo-dd5", rows, COUNT(rows));
}

static void base_unit(void **state)
{
    static const row_t rows[] = {
        {"bu.enabled", "1"},
        {"bu.vlaps", "3"},
        {"bu.eg_link", "0"},
        {"bu.failed", "0"},
        {"bu.module_error", "0"},
        {"bu.report_passive", "0"},
        {"bu.lock_errors", "0"},
        {"bu.command_lifetime", "0"},
        {"bu.frozen", "0"},
        {"bu.armed", "0"},
        {"bu.unarmed", "0"},
        {"bu.overflows", "0"},
        {"bu.cci", "0"},
        {"ru1.on", "0"},
        {"ru1.armed", "0"},
        {"ru1.stop", "0"},
        {"ru1.shock", "0"},
        {"ru1.failed", "0"},
        {"ru1.disabled", "0"},
        {"ru1.battery", "100"},
        {"ru1.rssi", "100"},
        {"ru1.cable", "0"},
        {"ru1.docked", "0"},
        {"ru1.g_link_lost", "0"},
        {"ru1.joystick1", "0"},
        {"ru1.joystick4", "0"},
        {"ru1.switch1", "0"},
        {"ru1.switch8", "0"},
        {"ru1.encoder", "0"},
        {"ru1.encoder_switch", "0"},
        {"ru1.c_link", "0"},
        {"ru1.g_link", "0"},
        {"ru1.received_count", "0"},
        {"ru1.id", "1"},
        {"ru2.id", "2"},
        {"ru1.fitted1", "1"},
        {"ru1.fitted8", "0"},
    };
    (void)state;
    expect_all("vr-bu-ect-map3", rows, COUNT(rows));
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"The optoNCDT 2300 before a target at 10 mm", sensor, NULL, NULL, NULL},
        {"FZM-034 FZM-056: the FZM1 as from the factory", camera, NULL, NULL, NULL},
        {"The PMCtendo with power, enabled, without limit switches", drive, NULL, NULL, NULL},
        {"ECL-023: the base unit without remotes", base_unit, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("surroundings at power-on", tests, NULL, NULL);
}
