/* SPDX-License-Identifier: MIT */
/* Save to unit, restart, scene groups (Q179 §3-2, §4-3), and power cuts. */
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "seams/record.h"

/* A manual save. @return whether all was saved */
static bool save(void)
{
    char message[ECT_SIGNAL_MESSAGE];
    long long before = signal_number(&s.w, "saves");
    (void)signal_try_set(&s.w, "save", "1", message);
    while (signal_number(&s.w, "saving") != 0)
        wire_advance(&s.w, MS / 10);
    return signal_number(&s.w, "saves") > before;
}

static void change_all(void)
{
    static const char *const changes[][2] = {
        {"scene", "100"},       {"output_control", "1"}, {"timeout", "77"},      {"output_period", "5000"},
        {"output_time", "123"}, {"exe_timeout", "100"},  {"output_repeat", "1"}, {"comment8", "hole 8"},
        {"data1", "1.25"},      {"data8", "-999999999"}, {"judgement2", "-1"},   {"expression3", "D1 - 2 * D2"},
        {"units", "8"},         {"output_unit", "7"},    {"output_format", "1"}};
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++)
        signal_set(&s.w, changes[i][0], changes[i][1]);
}

static void expect_text(const char *signal, const char *want)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(&s.w, signal, text);
    if (strcmp(text, want) != 0)
        fail_msg("%s: expected %s, got %s", signal, want, text);
}

static void expect_changed(bool changed)
{
    static const char *const rows[][3] = {
        {"output_control", "1", "0"}, {"timeout", "77", "100"},    {"output_period", "5000", "100"},
        {"output_time", "123", "50"}, {"exe_timeout", "100", "0"}, {"output_repeat", "1", "0"},
        {"comment8", "hole 8", ""},   {"scene", "100", "0"},       {"data1", "1.25", "0"},
        {"data8", "-999999999", "0"}, {"judgement2", "-1", "1"},   {"expression3", "D1 - 2 * D2", ""},
        {"units", "8", "4"},          {"output_unit", "7", "3"},   {"output_format", "1", "0"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_text(rows[i][0], rows[i][changed ? 1 : 2]);
}

static bool on_the_bus(void)
{
    uint8_t data[2] = {0};
    return wire_send(&s.w, BRD, 0, ECT_REG_AL_STATUS, data, 2) == 1;
}

static void saved(void **state)
{
    (void)state;
    change_all();
    (void)sensor_until(&s, FZM1_BUSY, 0);
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0);
    power_cycle();
    expect_changed(true);
    signal_set(&s.w, "scene", "0");
    expect_text("data1", "0");
}

static void forgotten(void **state)
{
    (void)state;
    change_all();
    power_cycle();
    expect_changed(false);
}

static void groups(void **state)
{
    (void)state;
    char value[16];
    for (int group = 0; group < 32; group += 5) {
        assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, group, 0, 0, NULL), 0);
        snprintf(value, sizeof value, "%d", group + 1);
        signal_set(&s.w, "data3", value);
        assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0);
    }
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, 4, 0, 0, NULL), 0);
    signal_set(&s.w, "data3", "4444");
    power_cycle();
    expect_text("scene_group", "30");
    for (int group = 0; group < 32; group++) {
        assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, group, 0, 0, NULL), 0);
        snprintf(value, sizeof value, "%d", group % 5 == 0 ? group + 1 : 0);
        expect_text("data3", value); /* group 4 was never saved */
    }
}

static void no_memory(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    (void)state;
    sensor_close(&s);
    sensor_open(&s);
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0xFFFFFFFF);
    assert_false(signal_try_set(&s.w, "save", "1", message));
    assert_non_null(strstr(message, "--store"));
}

/* The power fails after every byte: the previous save is intact, or the whole new one. */
static void power_cut(void **state)
{
    unsigned int kept = 0, renewed = 0;
    (void)state;
    signal_set(&s.w, "expression1", "D1");
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    for (uint32_t budget = 0; renewed < 50; budget++) {
        char was[ECT_SIGNAL_TEXT_ROOM], is[ECT_SIGNAL_TEXT_ROOM], value[16];
        signal_get(&s.w, "data1", was);
        snprintf(value, sizeof value, "%u", budget + 2);
        signal_set(&s.w, "data1", value);
        memory.budget = budget;
        bool done = save();
        memory.budget = UINT32_MAX;
        power_cycle();
        signal_get(&s.w, "data1", is);
        if (strcmp(is, done ? value : was) != 0)
            fail_msg("cut after %u bytes, save %s: expected %s, got %s", budget, done ? "done" : "failed",
                     done ? value : was, is);
        kept += !done;
        renewed += done;
    }
    assert_true(kept > 100);
}

/* A disk with a cache: after a power failure, data written but not yet safe exist or not, piece by piece. The power
 * fails at every step of a save, in several ways. */
static void power_cut_with_cache(void **state)
{
    unsigned int kept = 0, renewed = 0;
    (void)state;
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    memory.lazy = 3;
    for (uint32_t n = 0; n < 400; n++) {
        char was[ECT_SIGNAL_TEXT_ROOM], is[ECT_SIGNAL_TEXT_ROOM], value[16];
        long long saves = signal_number(&s.w, "saves");
        signal_get(&s.w, "data1", was);
        snprintf(value, sizeof value, "%u", n + 2);
        signal_set(&s.w, "data1", value);
        signal_set(&s.w, "save", "1");
        for (uint32_t step = 0; step < n % 40; step++)
            wire_advance(&s.w, MS / 4);
        bool done = signal_number(&s.w, "saves") > saves;
        sensor_close(&s);
        sensor_memory_cut(&memory, n * 2654435761u + 1);
        sensor_open_with(&s, &memory.storage);
        signal_get(&s.w, "data1", is);
        bool is_new = strcmp(is, value) == 0;
        if (done ? !is_new : !is_new && strcmp(is, was) != 0)
            fail_msg("cut %u, save %s: expected %s%s%s, got %s", n, done ? "done" : "under way", done ? "" : was,
                     done ? "" : " or ", value, is);
        kept += !is_new;
        renewed += is_new;
    }
    assert_true(kept > 50 && renewed > 50);
}

static void not_safe(void **state)
{
    (void)state;
    memory.lazy = 3;
    memory.unsafe = true;
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0xFFFFFFFF);
    expect_text("command_refused_cause", "the memory does not keep writes");
    memory.unsafe = false;
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0);
}

static void fill_group(int group)
{
    char number[24];
    snprintf(number, sizeof number, "%d", group);
    signal_set(&s.w, "scene_group", number);
    for (int scene = 0; scene < FZM1_SCENES; scene++) {
        snprintf(number, sizeof number, "%d", scene);
        signal_set(&s.w, "scene", number);
        snprintf(number, sizeof number, "%d.%d", group, scene);
        signal_set(&s.w, "data1", number);
    }
    (void)sensor_until(&s, FZM1_BUSY, 0);
}

/* Thirty-two full groups: no poll writes more than some scenes, FLG is set when the data are safe, and meanwhile the
 * sensor measures. */
static void in_steps(void **state)
{
    (void)state;
    for (int group = 0; group < FZM1_GROUPS; group++) {
        fill_group(group);
        assert_true(save());
    }
    memory.lazy = 5;
    sensor_prepare(&s, FZM1_SAVE, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    unsigned int polls = 0;
    uint32_t most = 0;
    signal_set(&s.w, "trigger", "1");
    for (; (sensor_read(&s) & FZM1_FLG) == 0 && polls < 10000; polls++) {
        memory.written = 0;
        wire_advance(&s.w, MS / 10);
        most = memory.written > most ? memory.written : most;
    }
    assert_true(polls > 100 && polls < 2000);
    assert_in_range(most, 100, 8 * 600);
    assert_false(sensor_memory_dirty(&memory)); /* acknowledged when it is safe */
    assert_int_equal(signal_number(&s.w, "measurements"), 1);
    memory.lazy = 0;
    power_cycle();
    for (int group = 0; group < FZM1_GROUPS; group += 31) {
        char want[16];
        assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, group, 0, 0, NULL), 0);
        assert_int_equal(sensor_command(&s, FZM1_SWITCH_SCENE, 127, 0, 0, NULL), 0);
        snprintf(want, sizeof want, "%d.127", group);
        expect_text("data1", want);
    }
}

/* A manual save and commands: a command that concerns scenes waits for it, others do not; a restart aborts it.
 */
static void save_and_commands(void **state)
{
    (void)state;
    char message[ECT_SIGNAL_MESSAGE];
    memory.lazy = 50;
    signal_set(&s.w, "data1", "5");
    signal_set(&s.w, "save", "1");
    assert_false(signal_try_set(&s.w, "save", "1", message));
    assert_false(signal_try_set(&s.w, "scene_group", "1", message));
    assert_false(signal_try_set(&s.w, "edit.data1", "1", message));
    assert_int_equal(sensor_command(&s, FZM1_GET_SCENE, 0, 0, 0, NULL), 0);
    assert_int_equal(signal_number(&s.w, "saves"), 0);
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, 1, 0, 0, NULL), 0);
    assert_int_equal(signal_number(&s.w, "saves"), 1);
    signal_set(&s.w, "save", "1");
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0);
    assert_int_equal(signal_number(&s.w, "saves"), 3);
    assert_int_equal(sensor_command(&s, FZM1_SWITCH_GROUP, 0, 0, 0, NULL), 0);
    expect_text("data1", "5");
    signal_set(&s.w, "data1", "6");
    signal_set(&s.w, "save", "1");
    signal_set(&s.w, "restart", "1");
    memory.lazy = 5000; /* longer than the start takes */
    wire_advance(&s.w, 4000 * MS);
    assert_false(on_the_bus());
    wire_advance(&s.w, 7000 * MS);
    assert_true(on_the_bus());
    expect_text("scene_group", "0");
    expect_text("data1", "6");
}

static void spoilt(void **state)
{
    (void)state;
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    signal_set(&s.w, "data1", "2");
    assert_true(save());
    unsigned int newest = ect_load_le32(memory.bank[1] + 4) > ect_load_le32(memory.bank[0] + 4) ? 1 : 0;
    memory.bank[newest][40] ^= 0x40;
    power_cycle();
    expect_text("data1", "1");
    memory.bank[newest ^ 1][4] ^= 1;
    power_cycle();
    expect_text("data1", "0");
}

/* A memory that stops responding: a reported save is complete, and the previous save is kept. */
static void unreadable(void **state)
{
    char message[ECT_SIGNAL_MESSAGE], want[ECT_SIGNAL_TEXT_ROOM], value[16];
    unsigned int failed = 0, done = 0;
    (void)state;
    signal_set(&s.w, "scene_group", "7");
    signal_set(&s.w, "data1", "77");
    assert_true(save());
    signal_set(&s.w, "scene_group", "8");
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    for (uint32_t reads = 0; reads < 40; reads++) {
        signal_get(&s.w, "data1", want);
        snprintf(value, sizeof value, "%u", reads + 2);
        signal_set(&s.w, "data1", value);
        memory.reads = reads;
        bool saved = save();
        bool switched = signal_try_set(&s.w, "scene_group", "7", message);
        assert_true(switched || signal_number(&s.w, "scene_group") == 8);
        memory.reads = UINT32_MAX;
        assert_false(switched && signal_number(&s.w, "data1") != 77);
        failed += !saved;
        done += saved;
        power_cycle();
        expect_text("data1", saved ? value : want);
    }
    if (failed < 3 || done < 10)
        fail_msg("%u failed, %u done", failed, done);
    signal_set(&s.w, "scene_group", "7");
    expect_text("data1", "77");
}

static void power_cycle_with(uint32_t reads)
{
    sensor_close(&s);
    memory.reads = reads;
    sensor_open_with(&s, &memory.storage);
    memory.reads = UINT32_MAX;
}

static void unreadable_at_power_on(void **state)
{
    (void)state;
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    for (uint32_t reads = 0; reads < 60; reads++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        power_cycle_with(reads);
        signal_get(&s.w, "data1", text);
        if (strcmp(text, "0") != 0 && strcmp(text, "1") != 0)
            fail_msg("%u reads answered: data1 is %s", reads, text);
    }
}

static void seal(unsigned int bank)
{
    uint8_t *b = memory.bank[bank];
    uint32_t length = ect_load_le32(b + 8);
    uint32_t crc = ect_crc32(0xFFFFFFFF, b + ECT_RECORD_HEADER, length);
    ect_store_le32(b + 12, ect_record_check(crc, ect_load_le32(b + 4), length));
}

/* A record with a correct check value and wrong content: each byte of the system data and of a scene. */
static void nonsense(void **state)
{
    static const uint8_t values[] = {0x00, 0x01, 0x7F, 0x80, 0xFF};
    (void)state;
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    unsigned int bank = ect_load_le32(memory.bank[0]) == 0x314D5A46 ? 0 : 1;
    for (unsigned int at = 16; at < 16 + ect_load_le32(memory.bank[bank] + 8); at++) {
        uint8_t before = memory.bank[bank][at];
        for (size_t v = 0; v < sizeof values; v++) {
            int32_t data;
            if (at == 16 + 1)
                continue; /* fieldbus OFF is a setting too */
            memory.bank[bank][at] = values[v];
            seal(bank);
            power_cycle();
            for (int unit = 0; unit < 9; unit++)
                (void)sensor_command(&s, FZM1_GET_UNIT_DATA, unit, 0, 0, &data);
            sensor_step(&s);
            (void)sensor_until(&s, FZM1_BUSY, 0);
            sensor_wait(&s, 100 * MS);
        }
        memory.bank[bank][at] = before;
    }
}

/* A record of another layout, as written by another version: ignored and replaced. */
static void other_layout(void **state)
{
    (void)state;
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    unsigned int bank = ect_load_le32(memory.bank[0]) == 0x314D5A46 ? 0 : 1;
    memory.bank[bank][16]++;
    seal(bank);
    power_cycle();
    expect_text("data1", "0");
    signal_set(&s.w, "data1", "5");
    assert_true(save());
    power_cycle();
    expect_text("data1", "5");
}

/* Invalid numbers, or numbers beyond the limits, in a record: the scene has factory settings, its neighbour the saved
 * values. */
static void no_numbers(void **state)
{
    static const uint64_t bits[] = {0x7FF8000000000000, 0xFFF8000000000000, 0x7FF0000000000000, 0xFFF0000000000000,
                                    0x41CDCD6500000000 /* 1e9 */};
    (void)state;
    signal_set(&s.w, "data1", "1");
    signal_set(&s.w, "scene", "1");
    signal_set(&s.w, "data1", "2");
    assert_true(save());
    unsigned int bank = ect_load_le32(memory.bank[0]) == 0x314D5A46 ? 0 : 1;
    uint8_t *first = memory.bank[bank] + ECT_RECORD_HEADER + 14 + 4; /* system data, the entry's header */
    assert_int_equal(ect_load_le64(first), 0x3FF0000000000000);
    for (size_t i = 0; i < sizeof bits / sizeof bits[0]; i++) {
        ect_store_le64(first, bits[i]);
        seal(bank);
        power_cycle();
        expect_text("data1", "2");
        signal_set(&s.w, "scene", "0");
        expect_text("data1", "0");
    }
}

/* Truncated with a correct check value: the existing part is used. */
static void cut_short(void **state)
{
    (void)state;
    signal_set(&s.w, "data1", "1");
    assert_true(save());
    unsigned int bank = ect_load_le32(memory.bank[0]) == 0x314D5A46 ? 0 : 1;
    uint32_t length = ect_load_le32(memory.bank[bank] + 8);
    for (uint32_t cut = 1; cut <= length; cut++) {
        ect_store_le32(memory.bank[bank] + 8, length - cut);
        seal(bank);
        power_cycle();
        expect_text("data1", "0");
    }
}

/* System data with one value changed: all of it is used, or none. The defaults that differ from the record show which.
 */
static void system_limits(void **state)
{
    static const struct {
        const char *what;
        uint8_t at, bytes; /* of the record */
        uint16_t value;
        bool good;
    } rows[] = {
        {"as it is", 1, 1, 1, true},
        {"fieldbus 2", 1, 1, 2, false},
        {"output control 1", 2, 1, 1, true},
        {"output control 2", 2, 1, 2, false},
        {"output repeat 1", 3, 1, 1, true},
        {"output repeat 2", 3, 1, 2, false},
        {"output period 20", 4, 2, 20, true},
        {"output period 19", 4, 2, 19, false},
        {"output period 50000", 4, 2, 50000, true},
        {"output period 50001", 4, 2, 50001, false},
        {"output time 10", 6, 2, 10, true},
        {"output time 9", 6, 2, 9, false},
        {"output time 99, of 100", 6, 2, 99, true},
        {"output time 100, of 100", 6, 2, 100, false},
        {"timeout 5", 8, 2, 5, true},
        {"timeout 4", 8, 2, 4, false},
        {"timeout 1200", 8, 2, 1200, true},
        {"timeout 1201", 8, 2, 1201, false},
        {"EXE timeout 0", 10, 2, 0, true},
        {"EXE timeout 1200", 10, 2, 1200, true},
        {"EXE timeout 1201", 10, 2, 1201, false},
        {"scene group 31", 12, 1, 31, true},
        {"scene group 32", 12, 1, 32, false},
        {"scene 127", 13, 1, 127, true},
        {"scene 128", 13, 1, 128, false},
    };
    uint8_t kept[14];
    (void)state;
    signal_set(&s.w, "exe_timeout", "77");
    signal_set(&s.w, "output_time", "19");
    assert_true(save());
    unsigned int bank = ect_load_le32(memory.bank[0]) == 0x314D5A46 ? 0 : 1;
    uint8_t *system = memory.bank[bank] + ECT_RECORD_HEADER;
    memcpy(kept, system, sizeof kept);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        memcpy(system, kept, sizeof kept);
        if (rows[i].bytes == 1)
            system[rows[i].at] = (uint8_t)rows[i].value;
        else
            ect_store_le16(system + rows[i].at, rows[i].value);
        seal(bank);
        power_cycle();
        bool of_record =
            rows[i].at == 6 ? signal_number(&s.w, "exe_timeout") == 77 : signal_number(&s.w, "output_time") == 19;
        if (of_record != rows[i].good)
            fail_msg("%s: expected that the record is %s", rows[i].what, rows[i].good ? "used" : "not used");
    }
}

static void no_room(void **state)
{
    (void)state;
    memory.storage.bank_size = 60;
    signal_set(&s.w, "data1", "1");
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0xFFFFFFFF);
    expect_text("save_failed_cause", "the memory does not respond, or has no space for all scenes");
    assert_int_equal(signal_number(&s.w, "saves_failed"), 1);
}

/* --- restart ------------------------------------------------------------------------------------------------------ */

static void restart(void **state)
{
    (void)state;
    signal_set(&s.w, "output_control", "1");
    signal_set(&s.w, "data1", "1");
    assert_int_equal(sensor_command(&s, FZM1_SAVE, 0, 0, 0, NULL), 0);
    signal_set(&s.w, "data1", "2");
    sensor_step(&s);
    (void)sensor_until(&s, FZM1_BUSY, 0);
    sensor_prepare(&s, FZM1_RESTART, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 1 * MS);
    sensor_expect(&s, "restarting: no response, all signals off", 0xFFFFFFFF, 0);
    sensor_wait(&s, 20 * MS - 1);
    assert_true(on_the_bus());
    wire_advance(&s.w, 1);
    assert_false(on_the_bus());
    wire_advance(&s.w, 3000 * MS - 1);
    assert_false(on_the_bus());
    wire_advance(&s.w, 2 * MS);
    assert_true(on_the_bus());
    uint8_t state_byte[2] = {0};
    assert_int_equal(wire_send(&s.w, APRD, 0, ECT_REG_AL_STATUS, state_byte, 2), 1);
    assert_int_equal(state_byte[0], ECT_STATE_INIT);
    uint8_t station[2] = {0xFF, 0xFF};
    assert_int_equal(wire_send(&s.w, APRD, 0, ECT_REG_STATION_ADDRESS, station, 2), 1);
    assert_int_equal(ect_load_le16(station), 0);
    wire_assign_stations(&s.w);
    sensor_operational(&s);
    sensor_expect(&s, "started", 0xFFFFFFFF, FZM1_READY | FZM1_RUN);
    assert_int_equal(ect_load_le32(s.in + 4), 0); /* no echo of anything */
    expect_text("data1", "1");
    expect_text("output_control", "1");
    expect_text("measurements", "0");
}

static void restart_by_hand(void **state)
{
    (void)state;
    signal_set(&s.w, "camera", "2");
    signal_set(&s.w, "start_time", "100");
    signal_set(&s.w, "source1", "3");
    signal_set(&s.w, "data1", "9");
    signal_set(&s.w, "restart", "1");
    wire_advance(&s.w, 122 * MS);
    wire_assign_stations(&s.w);
    sensor_operational(&s);
    expect_text("camera", "2"); /* the plant is as it was */
    expect_text("source1", "3");
    expect_text("data1", "0"); /* unsaved data are not */
}

static void restart_while_continuous(void **state)
{
    (void)state;
    assert_int_equal(sensor_command(&s, FZM1_START_CONTINUOUS, 0, 0, 0, NULL), 0);
    sensor_wait(&s, 100 * MS);
    sensor_prepare(&s, FZM1_RESTART, 0, 0, 0);
    sensor_set(&s, FZM1_EXE, true);
    sensor_wait(&s, 2 * MS);
    sensor_expect(&s, "restarting", 0xFFFFFFFF, 0);
    wire_advance(&s.w, 4000 * MS);
    wire_assign_stations(&s.w);
    sensor_operational(&s);
    sensor_wait(&s, 1000 * MS);
    expect_text("measurements", "0");
}

static void fieldbus(void **state)
{
    (void)state;
    signal_set(&s.w, "fieldbus", "0");
    assert_true(on_the_bus()); /* not at once ... */
    signal_set(&s.w, "restart", "1");
    wire_advance(&s.w, 4000 * MS);
    assert_true(on_the_bus()); /* ... and not without Save */
    signal_set(&s.w, "fieldbus", "0");
    assert_true(save());
    signal_set(&s.w, "restart", "1");
    wire_advance(&s.w, 4000 * MS);
    assert_false(on_the_bus());
    signal_set(&s.w, "fieldbus", "1");
    assert_true(save());
    wire_advance(&s.w, 4000 * MS);
    assert_false(on_the_bus());
    signal_set(&s.w, "restart", "1");
    wire_advance(&s.w, 4000 * MS);
    assert_true(on_the_bus());
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("FZM-056: Save keeps system data and the current scene group over power-off", saved),
        TEST("FZM-056: without Save power-off forgets", forgotten),
        TEST("FZM-056 FZM-058: each saved scene group is kept, the others have factory settings", groups),
        TEST("FZM-056: without memory Save answers -1", no_memory),
        TEST("FZM-056: the power may be cut at any byte of a Save", power_cut),
        TEST("FZM-056: a damaged record is not used", spoilt),
        TEST("FZM-056: a memory that stops responding: a reported save is complete, and the previous save is kept",
             unreadable),
        TEST("FZM-056: a memory that does not respond at power-on: factory settings, or the saved ones",
             unreadable_at_power_on),
        TEST("FZM-056: a record with invalid content has no effect on other data", nonsense),
        TEST("FZM-056: a record of another layout is not used, and is replaced", other_layout),
        TEST("FZM-034 FZM-056: a record with values that are no numbers", no_numbers),
        TEST("FZM-056: system data at the limits of each setting, and beyond them", system_limits),
        TEST("FZM-056: a truncated record has no effect on other data", cut_short),
        TEST("FZM-056: a memory without space: -1 and the cause", no_room),
        TEST("FZM-056: a disk with a cache: the power may fail at any step of a Save, and acknowledged data are safe",
             power_cut_with_cache),
        TEST("FZM-051 FZM-056: a memory that does not keep writes: -1 and the cause", not_safe),
        TEST("FZM-043 FZM-056 FZM-069: Save of 32 groups delays no other work, and FLG is set when the data are safe",
             in_steps),
        TEST("FZM-052 FZM-056 FZM-058: a manual save, and commands meanwhile", save_and_commands),
        TEST("FZM-052 FZM-077: Restart: no response, signals off, off the bus, INIT, saved settings", restart),
        TEST("FZM-077: a manual restart; switches and cameras are unchanged", restart_by_hand),
        TEST("FZM-052: Restart ends a continuous measurement", restart_while_continuous),
        TEST("FZM-024 FZM-077: the fieldbus setting is active when it was saved and the controller restarted",
             fieldbus),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("FZM1 save and restart", tests, NULL, NULL);
}
