/* SPDX-License-Identifier: MIT */
/*
 * The requirements of TS-0007, tested by SOEM on the wire and in real time; the test plays the operator through the
 * control socket.  usage: test_eclink IFACE map1|map3|map7|multiarm [TEST]
 *
 * The machine controller is the example's (examples/controller). Nothing here asserts wall-clock time: timeouts have to
 * come, and the unit's own PCI (125 ms) bounds them; tests/unit/devices/eclink checks their times to the millisecond.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bu_controller.h"
#include "lamps.h"
#include "plant.h"
#include "soem.h"

enum { PATIENCE = 20000 /* cycles of at least 1 ms that a change may take on a busy machine */ };

static const char *iface;
static soem_t master;
static bu_controller_t controller;
static bool hold_pco, hold_cao; /* the controller's program neglects its duty */
static const uint8 *in;
static uint8 *out;

static uint8 got[8][18]; /* commands that came: id, data */
static unsigned int got_count;

static void on_command(void *ctx, uint16_t ru, const uint8_t *command)
{
    (void)ctx;
    uint8 *slot = got[got_count++ % 8];
    slot[0] = (uint8)(ru >> 8);
    slot[1] = (uint8)ru;
    memcpy(slot + 2, command, 16);
}

/* One cycle of the machine: exchange, controller's program. */
static int cycle(void)
{
    uint8 kept[4] = {0};
    int wkc = soem_cycle(&master);
    if (controller.output_bytes > 0)
        memcpy(kept, out, sizeof kept);
    bu_controller_step(&controller, in, out, soem_now());
    if (hold_pco && controller.output_bytes > 0)
        out[0] = kept[0];
    if (hold_cao && controller.output_bytes > 0)
        out[3] = kept[3];
    return wkc;
}

/* Cycles until the condition holds; a failure prints it. */
#define AWAIT(condition)                                                                                               \
    do {                                                                                                               \
        int left = PATIENCE;                                                                                           \
        while (!(condition) && left-- > 0)                                                                             \
            cycle();                                                                                                   \
        if (left < 0)                                                                                                  \
            fail_msg("expected, in vain: %s   (BU state 0x%02X, EC-Link %u, message '%s')", #condition, in[22],        \
                     in[26], plant_get("bu.message"));                                                                 \
    } while (0)

/* Two updates of the input data: what was set before has come through. */
static void settle(void)
{
    for (int i = 0; i < 2; i++) {
        uint8 pci = in[0];
        AWAIT(in[0] != pci);
    }
}

static void to_op(void)
{
    soem_map(&master);
    in = master.slaves[1].inputs;
    out = master.slaves[1].outputs;
    controller.output_bytes = master.slaves[1].Obytes;
    bu_controller_start(&controller);
    soem_operational(&master);
}

static int open_master(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    controller = (bu_controller_t){.on_command = on_command};
    hold_pco = hold_cao = false;
    got_count = 0;
    return 0;
}

/* ... and the unit fresh from power-on, in order, with all remotes off. */
static int open_in_order(void **state)
{
    plant_set_all("bu.vlaps=3 bu.eg_link=0 bu.failed=0 bu.module_error=0 bu.report_passive=0 bu.restart=1");
    for (char ru = '1'; ru <= '4'; ru++) {
        static const char *const settings[] = {"g_link_lost=0", "stop=0",    "shock=0",   "failed=0",
                                               "disabled=0",    "c_link=-1", "g_link=-1", "on=0"};
        for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
            char setting[40];
            snprintf(setting, sizeof setting, "ru%c.%s", ru, settings[i]);
            plant_set_all(setting);
        }
    }
    open_master(state);
    to_op();
    AWAIT(in[22] == 0x10);
    return 0;
}

static int close_master(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

/* --- from power-on ------------------------------------------------------------------------------------------------ */

static void from_power_on(void **state)
{
    (void)state;
    assert_string_equal(plant_get("bu.message"), "EC: No Data");
    assert_int_equal(plant_number("bu.state"), 0x00);
    hold_pco = true;
    to_op();
    if (controller.output_bytes > 0)
        out[0] = 0;
    if (controller.output_bytes > 24) {
        AWAIT(in[26] == 5);
        assert_int_equal(in[22], 0x00);
        assert_int_equal(plant_number("bu.es_link"), 0);
        assert_string_equal(plant_get("bu.message"), "EC: Bad data");
        assert_string_equal(plant_get("bu.cause"), "PCO does not increment");
        hold_pco = false;
    }
    AWAIT(in[22] == 0x10 && in[26] == 1);
    assert_string_equal(plant_get("bu.message"), "");
    assert_int_equal(plant_number("bu.es_link"), 1);
    assert_int_equal(plant_number("bu.ec_link"), 1);
}

/* A fresh unit; the controller has kept CAO 7 from before. Nothing can be armed until the unit is in order. */
static void retained_cao(void **state)
{
    (void)state;
    plant_set_all("bu.restart=1 ru1.on=1");
    open_master(state);
    plant_refuses("ru1.armed", "1", "Initial");
    hold_cao = true;
    soem_map(&master);
    master.slaves[1].outputs[3] = 7;
    to_op();
    AWAIT(in[22] == 0x10);
    plant_set("ru1.armed", "1");
    AWAIT(in[22] == 0x11);
    for (int i = 0; i < 12; i++) { /* 24 updates are 3 s */
        settle();
        assert_int_equal(out[3], 7);
        assert_int_not_equal(in[26], 5); /* Bad data; a busy machine may lose OP */
    }
}

static void pci_wraps(void **state)
{
    (void)state;
    to_op();
    unsigned int wraps = 0, updates = 0;
    uint8 last = in[0];
    while (wraps == 0 && updates < 300) {
        AWAIT(in[0] != last);
        assert_in_range((uint8)(in[0] - last), 1, 16); /* a busy machine may miss some, but the value never decreases */
        wraps += in[0] < last;
        last = in[0];
        updates++;
    }
    assert_int_equal(wraps, 1);
}

/* --- supervision -------------------------------------------------------------------------------------------------- */

static void pco_does_not_change(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1");
    AWAIT(in[22] == 0x11);
    hold_pco = true;
    uint8 pci = in[0];
    AWAIT(in[26] == 5);
    assert_in_range((uint8)(in[0] - pci), 1, 18); /* 2000 ms are 16 updates */
    assert_int_equal(in[22], 0x02);
    assert_int_equal(plant_number("bu.es_link"), 0);
    assert_string_equal(plant_get("bu.message"), "EC: Bad data");
    hold_pco = false;
    AWAIT(in[22] == 0x11 && in[26] == 1);
    assert_int_equal(plant_number("bu.es_link"), 1);
}

static void cao_does_not_change(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1");
    AWAIT(in[22] == 0x11);
    hold_cao = true;
    uint8 cci = in[1];
    plant_set("ru1.command", "00112233445566778899aabbccddeeff");
    AWAIT(in[1] != cci);
    uint8 pci = in[0];
    AWAIT(in[26] == 5);
    assert_in_range((uint8)(in[0] - pci), 1, 18);
    assert_int_equal(in[22], 0x02);
    assert_int_equal(plant_number("bu.es_link"), 0);
    assert_string_equal(plant_get("bu.cause"), "CAO does not acknowledge a command");
    hold_cao = false;
    AWAIT(in[22] == 0x11 && in[26] == 1);
}

/* Input + Commands: PCO may stand still as long as it likes. */
static void pco_is_no_duty(void **state)
{
    (void)state;
    hold_pco = true;
    for (int i = 0; i < 20; i++)
        settle(); /* 40 updates are 5 s */
    assert_int_equal(in[26], 1);
    assert_int_equal(in[22], 0x10);
}

static void watchdog(void **state)
{
    (void)state;
    soem_watchdog(&master, 100);
    soem_cycle(&master);
    for (int tries = 0; tries < 100 && (master.slaves[1].state & EC_STATE_ERROR) == 0; tries++) {
        osal_usleep(50000);
        ecx_readstate(&master.context);
    }
    assert_int_equal(master.slaves[1].state, EC_STATE_SAFE_OP | EC_STATE_ERROR);
    assert_int_equal(master.slaves[1].ALstatuscode, 0x001B);
    AWAIT(in[22] == 0x02 && in[26] == 2);
    assert_string_equal(plant_get("bu.message"), "EC: No Data");
    soem_go(&master, 1, EC_STATE_SAFE_OP);
    bu_controller_start(&controller);
    soem_operational(&master);
    AWAIT(in[22] == 0x10 && in[26] == 1);
}

/* Input Only: the controller's program has ended, no reads follow, and the unit stays in OP. */
static void inputs_not_read(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1");
    AWAIT(in[22] == 0x11);
    for (int tries = 0; tries < 200 && plant_number("bu.ec_link") == 1; tries++)
        osal_usleep(50000);
    assert_string_equal(plant_get("bu.message"), "EC: No Data");
    assert_int_equal(plant_number("bu.state"), 0x02);
    assert_int_equal(plant_number("bu.es_link"), 0);
    long long pci = plant_number("bu.pci");
    for (int tries = 0; tries < 200 && plant_number("bu.pci") == pci; tries++)
        osal_usleep(10000); /* until the input data have it too */
    AWAIT(in[22] == 0x02 && in[26] == 2);
    AWAIT(in[22] == 0x11 && in[26] == 1);
    assert_string_equal(plant_get("bu.message"), "");
    ecx_readstate(&master.context);
    assert_int_equal(master.slaves[1].state, EC_STATE_OPERATIONAL);
}

/* The bus runs, the unit does not: only PCI shows it. */
static void frozen(void **state)
{
    (void)state;
    AWAIT(!controller.safe);
    plant_set("bu.frozen", "1");
    AWAIT(controller.safe);
    assert_int_equal(cycle(), soem_expected_wkc(&master));
    ecx_readstate(&master.context);
    assert_int_equal(master.slaves[1].state, EC_STATE_OPERATIONAL);
    plant_set("bu.frozen", "0");
    AWAIT(!controller.safe);
}

static void restart(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1 ru1.encoder=33");
    AWAIT(in[22] == 0x11);
    plant_set("ru1.command", "00112233445566778899aabbccddeeff");
    AWAIT(in[1] == 1 && got_count == 1);
    plant_set("bu.restart", "1");
    for (int i = 0; i < 100 && cycle() > 0; i++)
        ;
    assert_true(cycle() <= 0);
    ecx_close(&master.context);
    soem_open(&master, iface, 1);
    to_op();
    AWAIT(in[22] == 0x10 && in[24] == 1);
    assert_int_equal(in[1], 0);
    assert_int_equal(got_count, 1); /* CCI of 0 after 1 is no command */
    plant_set("ru1.armed", "1");
    AWAIT(in[22] == 0x11 && in[62] == 33);
}

static void write_input_length(uint16 length)
{
    uint16 station = master.slaves[1].configadr;
    uint8 off = 0, on = 1;
    ecx_FPWR(&master.port, station, ECT_REG_SM3 + 6, 1, &off, EC_TIMEOUTRET3);
    ecx_FPWRw(&master.port, station, ECT_REG_SM3 + 2, htoes(length), EC_TIMEOUTRET3);
    ecx_FPWR(&master.port, station, ECT_REG_SM3 + 6, 1, &on, EC_TIMEOUTRET3);
}

static void wrong_size(void **state)
{
    (void)state;
    uint16 code;
    soem_go(&master, 1, EC_STATE_PRE_OP);
    write_input_length(10);
    assert_int_equal(soem_request(&master, 1, EC_STATE_SAFE_OP, &code), EC_STATE_PRE_OP | EC_STATE_ERROR);
    assert_int_equal(code, 0x001E);
    assert_string_equal(plant_get("bu.message"), "EC: Cfg. Error");
    assert_int_equal(plant_number("bu.ec_link"), 3);
    soem_go(&master, 1, EC_STATE_PRE_OP);
    write_input_length((uint16)master.slaves[1].Ibytes);
    soem_go(&master, 1, EC_STATE_SAFE_OP);
    bu_controller_start(&controller);
    soem_operational(&master);
    AWAIT(*plant_get("bu.message") == 0);
    AWAIT(in[22] == 0x10);
}

static void module_error(void **state)
{
    (void)state;
    plant_set("bu.module_error", "1");
    AWAIT(in[26] == 4 && in[22] == 0x02);
    assert_string_equal(plant_get("bu.message"), "EC: Module Error");
    plant_set("bu.module_error", "0");
    AWAIT(in[26] == 1 && in[22] == 0x10);
    plant_set("bu.failed", "1");
    AWAIT(in[22] == 0x04);
    assert_int_equal(plant_number("bu.es_link"), 0);
    plant_set("bu.failed", "0");
    AWAIT(in[22] == 0x10);
}

static void disabled(void **state)
{
    (void)state;
    plant_set("bu.enabled", "0");
    int wkc = 0;
    for (int i = 0; i < 5; i++)
        wkc = soem_cycle(&master);
    assert_true(wkc <= 0);
    assert_string_equal(plant_get("bu.message"), "");
    assert_int_equal(plant_number("bu.ec_link"), 0);
    AWAIT(controller.safe); /* PCI has stopped */
    plant_set("bu.enabled", "1");
    ecx_close(&master.context);
    open_master(state);
    to_op();
    AWAIT(in[22] == 0x10 && !controller.safe);
}

/* --- remote units ------------------------------------------------------------------------------------------------- */

static void arming(void **state)
{
    (void)state;
    static const uint8 zero[38];
    plant_set_all("ru1.on=1 ru2.on=1 ru1.joystick1=77");
    AWAIT(in[24] == 2);
    assert_int_equal(in[22], 0x10);
    assert_memory_equal(in + 28, zero, 38);
    plant_set("bu.report_passive", "1");
    AWAIT(in[36] == 6);
    plant_set("ru1.armed", "1");
    AWAIT(in[22] == 0x11 && in[24] == 1);
    const uint8 id[] = {0, 1};
    assert_memory_equal(in + 28, id, 2);
    assert_int_equal(in[30], 3);
    assert_int_equal(in[36], 1);
    plant_refuses("ru3.armed", "1", "not switched on");
    plant_set("ru1.on", "0");
    AWAIT(in[22] == 0x03);
    plant_set("ru1.on", "1");
    settle();
    assert_int_equal(in[22], 0x03);
    plant_set("ru1.armed", "1");
    AWAIT(in[22] == 0x11);
    plant_set("ru1.armed", "0");
    AWAIT(in[22] == 0x10 && in[24] == 2);
}

static void one_only(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1 ru2.on=1");
    plant_refuses("ru2.armed", "1", "only one");
    AWAIT(in[22] == 0x11 && in[24] == 1);
}

static void three(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru2.on=1 ru3.on=1 ru4.on=1 ru2.armed=1 ru3.armed=1 ru1.armed=1 "
                  "ru1.encoder=11 ru2.encoder=22 ru3.encoder=33");
    plant_refuses("ru4.armed", "1", "three");
    AWAIT(in[29] == 2 && in[67] == 3 && in[105] == 1 && in[24] == 1);
    assert_int_equal(in[62], 22);
    assert_int_equal(in[100], 33);
    assert_int_equal(in[138], 11);
    plant_set("ru3.stop", "1");
    AWAIT(in[22] == 0x01 && in[68] == 4);
    plant_set_all("ru3.stop=0 ru2.armed=0");
    AWAIT(in[22] == 0x11 && in[29] == 3 && in[67] == 1 && in[105] == 0);
}

/* Setting, offset, bytes on the wire. */
static void fields(void **state)
{
    static const struct {
        const char *setting;
        unsigned int offset, length;
        uint8 bytes[2];
    } rows[] = {
        {"ru1.id=4660", 28, 2, {0x12, 0x34}},
        {"bu.vlaps=2", 23, 1, {2}},
        {"bu.eg_link=1", 25, 1, {1}},
        {"ru1.disabled=1", 35, 1, {1}},
        {"ru1.disabled=1", 30, 1, {2}},
        {"ru1.disabled=2", 35, 1, {2}},
        {"ru1.disabled=2", 30, 1, {2}},
        {"ru1.disabled=3", 35, 1, {3}},
        {"ru1.disabled=0", 30, 1, {3}},
        {"ru1.battery=57", 31, 1, {57}},
        {"ru1.rssi=42", 32, 1, {42}},
        {"ru1.cable=1", 33, 1, {1}},
        {"ru1.docked=1", 34, 1, {1}},
        {"ru1.joystick1=-1000", 38, 2, {0xFC, 0x18}},
        {"ru1.joystick2=1000", 40, 2, {0x03, 0xE8}},
        {"ru1.joystick3=-1", 42, 2, {0xFF, 0xFF}},
        {"ru1.joystick4=258", 44, 2, {0x01, 0x02}},
        {"ru1.encoder=255", 62, 1, {255}},
        {"ru1.encoder=0", 62, 1, {0}},
        {"ru1.encoder_switch=1", 63, 1, {1}},
    };
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        plant_set_all(rows[i].setting);
        settle();
        if (memcmp(in + rows[i].offset, rows[i].bytes, rows[i].length) != 0)
            fail_msg("%s: expected %02X %02X at offset %u, got %02X %02X", rows[i].setting, rows[i].bytes[0],
                     rows[i].bytes[1], rows[i].offset, in[rows[i].offset], in[rows[i].offset + 1]);
    }
    assert_int_equal(in[27] | in[64] | in[65], 0);
    plant_refuses("ru1.joystick1", "1001", "1000");
    plant_refuses("ru1.battery", "101", "100");
    plant_set_all("ru1.id=1 ru1.cable=0");
}

/* Each equipment, its least and largest value; one beyond them is refused. */
static void switches(void **state)
{
    static const struct {
        const char *fitted;
        int least, largest;
    } kinds[] = {{"1", 0, 1}, {"2", 0, 1}, {"3", -1, 1}, {"4", 0, 1000}, {"5", 0, 3}, {"6", 0, 3}};
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1");
    for (unsigned int i = 0; i < 6; i++) {
        unsigned int position = i < 5 ? i + 1 : 8; /* 1 to 5, and 8 */
        const int values[] = {kinds[i].largest, kinds[i].least};
        char name[24], text[16];
        snprintf(name, sizeof name, "ru1.fitted%u", position);
        plant_set(name, kinds[i].fitted);
        snprintf(name, sizeof name, "ru1.switch%u", position);
        for (unsigned int v = 0; v < 2; v++) {
            snprintf(text, sizeof text, "%d", values[v]);
            plant_set(name, text);
            settle();
            unsigned int at = 44 + 2 * position;
            assert_int_equal((int16)(in[at] << 8 | in[at + 1]), values[v]);
        }
        snprintf(text, sizeof text, "%d", kinds[i].largest + 1);
        plant_refuses(name, text, kinds[i].largest == 1000 ? "1000" : "");
    }
}

static void ru_states(void **state)
{
    static const struct {
        const char *signal;
        uint8 ru_state;
    } rows[] = {{"ru1.stop", 4}, {"ru1.shock", 4}, {"ru1.failed", 5}};
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1");
    AWAIT(in[22] == 0x11 && in[30] == 3);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        plant_set(rows[i].signal, "1");
        AWAIT(in[22] == 0x01 && in[30] == rows[i].ru_state);
        assert_int_equal(plant_number("bu.es_link"), 0);
        plant_set(rows[i].signal, "0");
        AWAIT(in[22] == 0x11 && in[30] == 3);
        assert_int_equal(plant_number("bu.es_link"), 1);
    }
}

static void link_states(void **state)
{
    (void)state;
    static const struct {
        const char *eg_link;
        uint8 bu_state;
    } rows[] = {{"2", 0x02}, {"3", 0x02}, {"4", 0x02}, {"5", 0x02}, {"6", 0x10}, {"7", 0x10}, {"1", 0x10}, {"0", 0x10}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        plant_set("bu.eg_link", rows[i].eg_link);
        AWAIT(in[25] == (uint8)atoi(rows[i].eg_link) && in[22] == rows[i].bu_state);
    }
}

static void forced_links(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1");
    AWAIT(in[22] == 0x11);
    for (unsigned int value = 0; value <= 7; value++) {
        char text[2] = {(char)('0' + value), 0};
        plant_set("ru1.c_link", text);
        AWAIT(in[36] == value && in[22] == 0x11);
        plant_set("ru1.c_link", "-1");
        plant_set("ru1.g_link", text);
        AWAIT(in[37] == value && in[36] == 1 && in[22] == 0x11);
        plant_set("ru1.g_link", "-1");
    }
    AWAIT(in[37] == 1);
    plant_refuses("ru1.g_link", "8", "-1..7");
    plant_set("ru1.disabled", "1");
    plant_set("ru1.joystick1", "500"); /* passive while movements are disabled */
    settle();
    assert_int_equal(in[30], 2);
    assert_int_equal(in[38] | in[39], 0);
    plant_set("ru1.disabled", "0");
    AWAIT(in[38] == 0x01 && in[39] == 0xF4);
}

static void replaced(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1 ru2.on=1");
    AWAIT(in[22] == 0x11);
    plant_set("ru1.on", "0");
    AWAIT(in[22] == 0x03);
    assert_string_equal(plant_get("bu.cause"), "ru1: communication is lost; turn it on and rearm it");
    plant_set("ru2.armed", "1");
    AWAIT(in[22] == 0x11 && in[29] == 2);
    assert_string_equal(plant_get("bu.cause"), "");
    plant_refuses("ru3.id", "2", "unique");
}

/* --- commands and periodic data ----------------------------------------------------------------------------------- */

static const char *const texts[] = {"000102030405060708090a0b0c0d0e0f", "ffffffffffffffffffffffffffffffff",
                                    "0f0e0d0c0b0a09080706050403020100"};

static void commands_from_remotes(void)
{
    unsigned int before = got_count;
    plant_set("ru1.command", texts[0]);
    plant_set("ru2.command", texts[1]);
    plant_set("ru1.command", texts[2]);
    AWAIT(got_count == before + 3);
    settle();
    assert_int_equal(got_count, before + 3);
    for (unsigned int i = 0; i < 3; i++) {
        const uint8 *command = got[(before + i) % 8];
        char text[33];
        for (unsigned int b = 0; b < 16; b++)
            snprintf(text + 2 * b, 3, "%02x", command[2 + b]);
        assert_string_equal(text, texts[i]);
        assert_int_equal(command[0] << 8 | command[1], i == 1 ? 2 : 1);
    }
}

static void send(uint16_t ru, uint8 first)
{
    const uint8_t command[16] = {first};
    while (!bu_controller_send(&controller, ru, command))
        cycle();
}

static void commands_both_ways(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1 ru2.on=1");
    AWAIT(in[22] == 0x11);
    commands_from_remotes();
    long long count[3], want[3] = {2, 3, 0}; /* ru1, ru2, and ru3 that is off */
    static const char *const names[] = {"ru1.received_count", "ru2.received_count", "ru3.received_count"};
    for (int i = 0; i < 3; i++)
        count[i] = plant_number(names[i]);
    send(0, 0xA0);
    send(2, 0xA1);
    send(0, 0xA2);
    AWAIT(!controller.to_send && in[3] == out[1]); /* all are acknowledged in CAI */
    settle();
    for (int i = 0; i < 3; i++)
        assert_int_equal(plant_number(names[i]) - count[i], want[i]);
    assert_string_equal(plant_get("ru1.received"), "a2000000000000000000000000000000");
}

/* CAI acknowledges processed commands: counters show those that no remote has received. */
static void no_remote_receives(void **state)
{
    (void)state;
    plant_set("ru1.on", "0");
    plant_set("ru2.on", "0");
    long long unreached = plant_number("bu.commands_unreached"), unknown = plant_number("bu.commands_unknown");
    send(0, 0xB0); /* no remote is on */
    send(1, 0xB1); /* this one is off */
    send(99, 0xB2);
    AWAIT(!controller.to_send && in[3] == out[1]);
    assert_int_equal(plant_number("bu.commands_unreached") - unreached, 2);
    assert_int_equal(plant_number("bu.commands_unknown") - unknown, 1);
}

/* C-Link without signal: byte 36 and arming agree. */
static void no_signal(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1 ru1.rssi=0");
    AWAIT(in[22] == 0x11 && in[32] == 0 && in[36] == 2);
    plant_set("ru1.armed", "0");
    plant_refuses("ru1.armed", "1", "C-Link");
    plant_set("ru1.rssi", "100");
    plant_set("ru1.armed", "1");
    AWAIT(in[22] == 0x11 && in[36] == 1);
}

/* On fallback a remote's own commands go first: CAI waits, and none is lost. */
static void cai_waits(void **state)
{
    enum { COMMANDS = 30 };
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1 ru1.g_link_lost=1");
    AWAIT(in[37] == 7);
    for (unsigned int i = 0; i < 10; i++)
        plant_set("ru1.command", texts[i % 3]);
    for (unsigned int i = 1; i <= COMMANDS; i++)
        send(1, (uint8)i);
    AWAIT(!controller.to_send && in[3] == out[1]);
    AWAIT(plant_number("ru1.received_count") == COMMANDS);
    assert_int_equal(plant_number("bu.commands_lost"), 0);
    assert_string_equal(plant_get("ru1.received"), "1e000000000000000000000000000000");
    AWAIT(got_count == 10);
    send(256, 1); /* id 1 with its bytes in the wrong order */
    AWAIT(plant_number("bu.commands_unknown") == 1);
}

static const uint8 screen[450] = {1, 2, 3};

static void periodic_data(void **state)
{
    (void)state;
    plant_set_all("ru1.on=1 ru1.armed=1 ru2.on=1");
    long long sets = plant_number("bu.periodic_sets"), errors = plant_number("bu.periodic_errors");
    long long shown = plant_number("ru2.periodic_count");
    controller.periodic = screen;
    controller.periodic_size = sizeof screen;
    out[2] = 0x55; /* PAO and the spare bytes have no effect */
    out[22] = out[23] = out[27] = 0xAA;
    AWAIT(controller.sets_sent >= 2);
    AWAIT(plant_number("bu.periodic_sets") > sets);
    AWAIT(plant_number("ru2.periodic_count") > shown);
    assert_int_equal(plant_number("bu.periodic_size"), 450);
    assert_int_equal(plant_number("bu.periodic_errors"), errors);
    assert_int_equal(plant_number("bu.periodic_skipped"), 0);
    assert_int_equal(plant_number("bu.pco_jumps"), 0);
    controller.pco += 4;
    AWAIT(plant_number("bu.pco_jumps") > 0);
    controller.periodic_size = 0; /* an impossible set: 51201 bytes */
    settle();
    out[24] = 0xC8;
    out[25] = 0x01;
    sets = plant_number("bu.periodic_sets");
    AWAIT(plant_number("bu.periodic_errors") > errors);
    assert_int_equal(plant_number("bu.periodic_sets"), sets);
    assert_int_equal(in[22], 0x11);
}

static void fallback(void **state)
{
    (void)state;
    plant_set_all("bu.vlaps=1 ru1.on=1 ru1.armed=1 ru2.on=1 ru1.g_link_lost=1");
    AWAIT(in[22] == 0x11 && in[37] == 7);
    commands_from_remotes();
    long long count = plant_number("ru1.received_count"), shown = plant_number("ru1.periodic_count");
    send(1, 0xB0);
    controller.periodic = screen;
    controller.periodic_size = sizeof screen;
    AWAIT(plant_number("ru1.received_count") == count + 1);
    AWAIT(plant_number("ru1.periodic_count") > shown);
    plant_set("ru2.g_link_lost", "1"); /* the armed one has the only VLAP */
    AWAIT(in[24] == 0);
    plant_set("bu.vlaps", "0");
    AWAIT(in[22] == 0x03);
    plant_refuses("ru1.armed", "1", "VLAP");
}

static void lamps(void **state)
{
    (void)state;
    lamps_follow(&master);
}

/* ------------------------------------------------------------------------------------------------------------------ */

#define POWER_ON(title, function) {title, function, open_master, close_master, NULL}
#define TEST(title, function)     {title, function, open_in_order, close_master, NULL}

/* The first of each mode must be the first after power-on. */
static const struct CMUnitTest map1_tests[] = {
    POWER_ON("ECL-018 ECL-058: Input Only is in order as soon as data flow, without any duty", from_power_on),
    POWER_ON("ECL-020 ECL-021: PCI counts from 255 to 0", pci_wraps),
    TEST("ECL-018 ECL-029 ECL-066: inputs that no master reads for 2000 ms: No Data, ES-Link open, and back",
         inputs_not_read),
    TEST("ECL-002 ECL-022 ECL-069: Disabled: no slave replies, and the controller enters its safe state", disabled),
};
static const struct CMUnitTest map3_tests[] = {
    POWER_ON("ECL-018 ECL-058: Input + Commands is in order without PCO", from_power_on),
    TEST("ECL-058: Input + Commands never watches PCO", pco_is_no_duty),
    TEST("ECL-023 ECL-055 ECL-060: commands go both ways with 24 bytes of outputs", commands_both_ways),
    TEST("ECL-056 ECL-058: a command that CAO does not acknowledge is an error here too", cao_does_not_change),
};
static const struct CMUnitTest map7_tests[] = {
    POWER_ON(
        "ECL-018 ECL-019 ECL-029 ECL-066 ECL-067 ECL-068 ECL-069: Initial and Bad data until PCO counts, then in order",
        from_power_on),
    POWER_ON("ECL-028 ECL-056 ECL-068: a retained CAO is no error; nothing is armed while Initial", retained_cao),
    TEST("ECL-020 ECL-022: PCI stands still in OP: the controller goes to its safe state", frozen),
    TEST("ECL-028 ECL-068: power is cycled: Initial, counters 0, nothing armed", restart),
    TEST("ECL-033 ECL-034 ECL-038 ECL-043 ECL-065: every C-Link and G-Link status; joysticks passive when tilted",
         forced_links),
    TEST("ECL-028 ECL-048: a lost remote is replaced by another", replaced),
    TEST("ECL-025 ECL-051: CAI acknowledges commands that no remote receives; counters name them", no_remote_receives),
    TEST("ECL-033 ECL-042: an armed remote without signal has no C-Link, and is not armed again", no_signal),
    TEST("ECL-025 ECL-050 ECL-063: on fallback CAI waits for room, and every command arrives", cai_waits),
    TEST("ECL-029 ECL-049 ECL-057 ECL-067: PCO stands still: Bad data, ES-Link open, and back", pco_does_not_change),
    TEST("ECL-029 ECL-056 ECL-067: CAO stands still: Bad data, ES-Link open, and back", cao_does_not_change),
    POWER_ON("ECL-014 ECL-015 ECL-016: RUN, ERROR and Link/Activity lamps by state, error and traffic", lamps),
    TEST("ECL-066 ECL-073: outputs stop: watchdog, External link error, No Data, and back", watchdog),
    TEST("ECL-066 ECL-072: a SyncManager of another size: Cfg. Error, and back", wrong_size),
    TEST("ECL-028 ECL-029 ECL-066: Module Error and Failed, and back", module_error),
    TEST(
        "ECL-028 ECL-030 ECL-032 ECL-033 ECL-034 ECL-036 ECL-061: unarmed all is 0; armed, lost, Blocked until rearmed",
        arming),
    TEST("ECL-048: without MultiArm one remote can be armed", one_only),
    TEST("ECL-003 ECL-013 ECL-031 ECL-035 ECL-038 ECL-041 ECL-042 ECL-043 ECL-046: fields at their offsets, big-endian",
         fields),
    TEST("ECL-044 ECL-045: the six kinds of switches, at positions up to the eighth", switches),
    TEST("ECL-028 ECL-037 ECL-039 ECL-040: stop switch, shock and failure of an armed remote", ru_states),
    TEST("ECL-028 ECL-033: EG-Link status", link_states),
    TEST("ECL-023 ECL-025 ECL-026 ECL-027 ECL-050 ECL-051 ECL-060: commands both ways, once and in order",
         commands_both_ways),
    TEST(
        "ECL-024 ECL-049 ECL-052 ECL-053 ECL-054 ECL-059 ECL-062: sets of three blocks arrive, impossible sizes do not",
        periodic_data),
    TEST("ECL-064 ECL-065: on fallback all still passes; without a VLAP the remote is lost", fallback),
};
static const struct CMUnitTest multiarm_tests[] = {
    POWER_ON("ECL-018 ECL-019 ECL-066 ECL-067 ECL-068: Initial and Bad data until PCO counts, then in order",
             from_power_on),
    TEST("ECL-028 ECL-047 ECL-048: three armed, each in its block, in the order of arming", three),
    TEST("ECL-023 ECL-051 ECL-060: commands both ways", commands_both_ways),
};

int main(int argc, char **argv)
{
    if (argc < 3)
        return 1;
    iface = argv[1];
    const char *mode = argv[2];
    if (argc > 3)
        cmocka_set_test_filter(argv[3]);
    if (strcmp(mode, "map1") == 0)
        return cmocka_run_group_tests_name(mode, map1_tests, NULL, NULL);
    if (strcmp(mode, "map3") == 0)
        return cmocka_run_group_tests_name(mode, map3_tests, NULL, NULL);
    if (strcmp(mode, "map7") == 0)
        return cmocka_run_group_tests_name(mode, map7_tests, NULL, NULL);
    return cmocka_run_group_tests_name(mode, multiarm_tests, NULL, NULL);
}
