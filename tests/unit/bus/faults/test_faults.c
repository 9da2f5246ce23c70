/* SPDX-License-Identifier: MIT */
/* Faults: their texts, their effects on frames and slaves, scripts, and runs repeated by a seed (bus/chain/fault.h,
 * bus/faults/scenario.h). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/faults/scenario.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { TWINS = 3, ADDRESS = 0x0F80 };

typedef struct rig {
    wire_t w;
    ect_scenario_t s;
    char message[ECT_FAULT_MESSAGE];
} rig_t;

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    const ect_device_t *devices[TWINS] = {&testdev, &testdev, &testdev};
    wire_open(&r->w, devices, TWINS);
    r->s.seed = 7;
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    ect_wires_clear(&r->s.wires);
    wire_close(&r->w);
    free(r);
    return 0;
}

static void round_trip(void **state)
{
    static const char *const texts[] = {"drop",
                                        "drop 5%",
                                        "drop wire 3",
                                        "drop frame 7 wire 2 back",
                                        "delay 5us every 3 wire 2",
                                        "duplicate wire 1 back",
                                        "reorder 7% wire 3",
                                        "truncate 4 wire 2 back",
                                        "corrupt frame 9 wire 2",
                                        "counter -3 wire 1",
                                        "damage 10% wire 1",
                                        "delay 3000us",
                                        "delay 1us every 10",
                                        "duplicate frame 100",
                                        "reorder every 7",
                                        "truncate 20 frame 3",
                                        "corrupt 1%",
                                        "counter -1 every 2",
                                        "counter 32767",
                                        "off",
                                        "hang slave 2",
                                        "resume slave 2",
                                        "reset slave 65535",
                                        "identity slave 1",
                                        "lose-event slave 3",
                                        "eeprom busy slave 1",
                                        "eeprom nack slave 1",
                                        "eeprom flip 15 slave 1",
                                        "eeprom ok slave 1",
                                        "clock -5000ns slave 2",
                                        "clock 0ns slave 1",
                                        "pdi-error slave 2",
                                        "to SAFEOP slave 2",
                                        "to PREOP 0x001B slave 2",
                                        "init slave 1",
                                        "init 0x002D slave 1",
                                        "al 0x001B slave 2",
                                        "al to SAFEOP 0x001B slave 2",
                                        "al refuse 0x001D slave 2",
                                        "al refuse to OP 0x001D slave 2",
                                        "al never slave 3",
                                        "al never to OP slave 3",
                                        "emergency 0x5530 slave 2",
                                        "emergency 0x5530 register 32 data 0102030405 slave 2",
                                        "abort 0x1C12:1 0x06040043 slave 2",
                                        "abort 0x1C12 upload 0x06040043 step 2 5% slave 2",
                                        "abort 0x1C12:1 download 0x08000020 3rd slave 2",
                                        "mail toggle slave 2",
                                        "mail counter every 3 slave 2",
                                        "mail type 50% slave 2",
                                        "mail length 11th slave 2",
                                        "mail late 50ms 1st slave 2",
                                        "mail late of 0x1018 50ms slave 2",
                                        "mail twice of 0x1018 slave 2",
                                        "mail lost of 0x1018:4 upload 22nd slave 2",
                                        "pdo-size -2 slave 1"};
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        char message[ECT_FAULT_MESSAGE] = "", text[ECT_FAULT_TEXT];
        ect_fault_t fault, again;
        if (!ect_fault_parse(texts[i], &fault, message))
            fail_msg("'%s' was refused: %s", texts[i], message);
        ect_fault_print(&fault, text);
        assert_string_equal(text, texts[i]);
        assert_true(ect_fault_parse(text, &again, message));
        assert_memory_equal(&fault, &again, sizeof fault);
    }
}

static void any_order(void **state)
{
    static const struct {
        const char *text, *same;
    } rows[] = {
        {"5% drop", "drop 5%"},
        {"slave 2 hang", "hang slave 2"},
        {"wire 3 back drop", "drop wire 3 back"},
        {"drop back wire 3 5%", "drop 5% wire 3 back"},
        {"every 10 wire 2 delay 3000us", "delay 3000us every 10 wire 2"},
        {"frame 3 truncate 20", "truncate 20 frame 3"},
        {"slave 1 eeprom flip 5", "eeprom flip 5 slave 1"},
        {"clock slave 2 -5000ns", "clock -5000ns slave 2"},
        {"slave 2 0x06040043 1C12h:1 abort", "abort 0x1C12:1 0x06040043 slave 2"},
        {"step 2 abort slave 2 0x06040043 3rd download 0x1C12:0x01",
         "abort 0x1C12:1 download 0x06040043 step 2 3rd slave 2"},
        {"slave 2 0x001B to SAFEOP al", "al to SAFEOP 0x001B slave 2"},
        {"0x001B slave 2 SAFEOP to", "to SAFEOP 0x001B slave 2"},
        {"of 1018h slave 2 mail late 3rd 50ms", "mail late of 0x1018 50ms 3rd slave 2"},
        {"data 0102030405 slave 2 register 1 emergency 0xFF00", "emergency 0xFF00 register 1 data 0102030405 slave 2"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_FAULT_MESSAGE] = "", text[ECT_FAULT_TEXT];
        ect_fault_t fault;
        if (!ect_fault_parse(rows[i].text, &fault, message))
            fail_msg("'%s' was refused: %s", rows[i].text, message);
        ect_fault_print(&fault, text);
        assert_string_equal(text, rows[i].same);
    }
}

static void refused(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        {"", "expected drop"},
        {"explode",
         "expected drop, damage, delay, duplicate, reorder, truncate, corrupt, counter, off, hang, resume, reset, "
         "identity, "
         "lose-event, eeprom, clock, pdi-error, to, init, emergency, al, abort, mail, pdo-size, not 'explode'"},
        {"drop 101%", "0 to 100"},
        {"drop -1%", "0 to 100"},
        {"drop 5", "nothing more"},
        {"drop every", "expected a whole number"},
        {"drop every 0", "1 to 1000000000"},
        {"drop wire", "1 to 65535"},
        {"drop wire 0", "1 to 65535"},
        {"drop slave 1", "nothing more"},
        {"drop back", "expected 'wire N'"},
        {"drop 5% every 3", "nothing more"},
        {"drop wire 1 wire 2", "nothing more"},
        {"drop back wire 1 back", "nothing more"},
        {"off 5%", "nothing more"},
        {"5%", "expected drop"},
        {"damage", "damage happens on a wire"},
        {"delay", "us"},
        {"delay 5ms", "us"},
        {"truncate 0", "1 to 1500"},
        {"corrupt wire 1 forth", "nothing more"},
        {"hang", "slave N"},
        {"hang slave 0", "1 to 65535"},
        {"hang slave 1 now", "nothing more"},
        {"hang of 0x1018 slave 1", "nothing more, not 'of'"},
        {"mail lost 0x1018 slave 1", "nothing more, not '0x1018'"},
        {"eeprom slave 1", "expected one of busy, nack, flip, ok after 'eeprom'"},
        {"mail slave 1", "expected one of toggle, counter, type, length, late, twice, lost after 'mail'"},
        {"al slave 1", "expected a code, as 0x001B"},
        {"al 27 slave 1", "nothing more"},
        {"al refuse slave 1", "expected a code, as 0x001B"},
        {"al 0x12345 slave 1", "nothing more"},
        {"al to RUN 0x001B slave 1", "after 'to'"},
        {"al 0x001B", "slave N"},
        {"to slave 1", "expected INIT, PREOP, BOOT or SAFEOP"},
        {"init", "slave N"},
        {"emergency slave 1", "expected a code"},
        {"emergency 0x5530 data 01 slave 1", "10 hexadecimal digits"},
        {"emergency 0x5530 register 256 slave 1", "0 to 255"},
        {"abort 0x06040043 slave 1", "expected an object, as 0x1C12:1"},
        {"abort 0x1C12 slave 1", "expected an abort code, as 0x06040043"},
        {"abort 0x1C12:256 0x06040043 slave 1", "nothing more"},
        {"abort 0x1C12 0x06040043 step 0 slave 1", "1 to 1000000"},
        {"abort 0x1C12 0x06040043 frame 3 slave 1", "nothing more"},
        {"mail late slave 1", "1 to 60000 ms"},
        {"mail lost 3th slave 1", "nothing more"},
        {"mail lost upload slave 1", "expected 'of' and an object"},
        {"mail lost of slave 1", "expected an object as 0x1018"},
        {"pdo-size slave 1", "-1024 to 1024"},
        {"eeprom flip 16 slave 1", "0 to 15"},
        {"clock 5 slave 1", "ns"},
        {"drop 1% wire 1 back and so on and on and on and on", "12 words"},
        {"drop                                                                                              ", "95"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_FAULT_MESSAGE] = "";
        ect_fault_t fault;
        if (ect_fault_parse(rows[i].text, &fault, message) || !strstr(message, rows[i].why))
            fail_msg("'%s': expected it refused with '...%s...', got '%s'", rows[i].text, rows[i].why, message);
    }
}

/* Each number at both ends of its range; `why` NULL: it is taken. */
static void ranges(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        {"drop 0%", NULL},
        {"drop 100%", NULL},
        {"drop every 1", NULL},
        {"drop every 1000000000", NULL},
        {"drop every 1000000001", "expected a whole number from 1 to 1000000000, not '1000000001'"},
        {"drop frame 1", NULL},
        {"drop frame 1000000000", NULL},
        {"drop 0.1%", "expected a whole number from 0 to 100 %, not '0.1%'"},
        {"drop frame 0", "expected a whole number from 1 to 1000000000, not '0'"},
        {"drop frame 1000000001", "expected a whole number from 1 to 1000000000, not '1000000001'"},
        {"drop frame 4294967297", "expected a whole number from 1 to 1000000000, not '4294967297'"},
        {"delay 1us", NULL},
        {"delay 10000000us", NULL},
        {"delay 0us", "expected a whole number from 1 to 10000000 us, not '0us'"},
        {"delay 10000001us", "expected a whole number from 1 to 10000000 us, not '10000001us'"},
        {"truncate 1", NULL},
        {"truncate 1500", NULL},
        {"truncate 1501", "expected a whole number from 1 to 1500, not '1501'"},
        {"counter -32768", NULL},
        {"counter -32769", "expected a whole number from -32768 to 32767, not '-32769'"},
        {"counter 32768", "expected a whole number from -32768 to 32767, not '32768'"},
        {"eeprom flip 0 slave 1", NULL},
        {"eeprom flip -1 slave 1", "expected a whole number from 0 to 15, not '-1'"},
        {"eeprom flip slave 1", "expected a whole number from 0 to 15, not ''"},
        {"clock -2147483648ns slave 1", NULL},
        {"clock 2147483647ns slave 1", NULL},
        {"clock 2147483648ns slave 1", "expected a whole number from -2147483648 to 2147483647 ns, not '2147483648ns'"},
        {"clock -2147483649ns slave 1",
         "expected a whole number from -2147483648 to 2147483647 ns, not '-2147483649ns'"},
        {"clock 1ns 2ns slave 1", "expected nothing more, not '2ns'"},
        {"drop wire 65535", NULL},
        {"drop wire 65536", "expected a whole number from 1 to 65535, not '65536'"},
        {"hang slave 65536", "expected a whole number from 1 to 65535, not '65536'"},
        {"hang 5% slave 1", "expected nothing more, not '5%'"},
        {"hang slave 1 back", "expected nothing more, not 'back'"},
        {"al 0x0001 slave 1", NULL},
        {"al 0xFFFF slave 1", NULL},
        {"al 0x0000 slave 1", "expected nothing more, not '0x0000'"},
        {"al 0x10000 slave 1", "expected nothing more, not '0x10000'"},
        {"al 0x slave 1", "expected nothing more, not '0x'"},
        {"al 0x1G slave 1", "expected nothing more, not '0x1G'"},
        {"al 0x001B 0x001B slave 1", "expected nothing more, not '0x001B'"},
        {"abort 0x1C12 0x00010000 slave 1", NULL},
        {"abort 0x1C12 0xFFFFFFFF slave 1", NULL},
        {"abort 0x1C12 0x0000FFFF slave 1", "expected nothing more, not '0x0000FFFF'"},
        {"abort 0x1C12 0x100000000 slave 1", "expected nothing more, not '0x100000000'"},
        {"abort 0x1C12:255 0x06040043 slave 1", NULL},
        {"abort 0x1C12:256 0x06040043 slave 1", "expected nothing more, not '0x1C12:256'"},
        {"abort 0x1C12 0x06040043 step 1 slave 1", NULL},
        {"abort 0x1C12 0x06040043 step 1000000 slave 1", NULL},
        {"abort 0x1C12 0x06040043 step 0 slave 1", "expected a whole number from 1 to 1000000, not '0'"},
        {"abort 0x1C12 0x06040043 step 1000001 slave 1", "expected a whole number from 1 to 1000000, not '1000001'"},
        {"emergency 0x5530 register 255 slave 1", NULL},
        {"emergency 0x5530 register 256 slave 1", "expected a whole number from 0 to 255, not '256'"},
        {"emergency 0x5530 data 00000000ff slave 1", NULL},
        {"emergency 0x5530 data 00000000f slave 1", "expected 10 hexadecimal digits after 'data', not '00000000f'"},
        {"emergency 0x5530 data 00000000fff slave 1", "expected 10 hexadecimal digits after 'data', not '00000000fff'"},
        {"emergency 0x5530 data 00000000fg slave 1", "expected 10 hexadecimal digits after 'data', not '00000000fg'"},
        {"emergency 0x5530 slave 1 data", "expected 10 hexadecimal digits after 'data', not ''"},
        {"mail late 1ms slave 1", NULL},
        {"mail late 60000ms slave 1", NULL},
        {"mail late 0ms slave 1", "expected a whole number from 1 to 60000 ms, not '0ms'"},
        {"mail late 60001ms slave 1", "expected a whole number from 1 to 60000 ms, not '60001ms'"},
        {"mail lost 1000000000th slave 1", NULL},
        {"mail lost 1000000001st slave 1", "expected nothing more, not '1000000001st'"},
        {"mail lost every 1000000000 slave 1", NULL},
        {"mail lost every 1000000001 slave 1", "expected a whole number from 1 to 1000000000, not '1000000001'"},
        {"mail lost 100% slave 1", NULL},
        {"pdo-size -1024 slave 1", NULL},
        {"pdo-size 1024 slave 1", NULL},
        {"pdo-size -1025 slave 1", "expected a whole number from -1024 to 1024, not '-1025'"},
        {"pdo-size 1025 slave 1", "expected a whole number from -1024 to 1024, not '1025'"},
        {"to BOOT slave 1", NULL},
        {"to BOOT PREOP slave 1", "expected nothing more, not 'PREOP'"},
        {"al never to slave 1", "expected INIT, PREOP, BOOT, SAFEOP or OP after 'to', not 'slave'"},
        {"eeprom slave 1", "expected one of busy, nack, flip, ok after 'eeprom', not 'slave'"},
        {"eeprom", "expected one of busy, nack, flip, ok after 'eeprom', not ''"},
        {"slave 1 mail 5% all",
         "expected one of toggle, counter, type, length, late, twice, lost after 'mail', not '5%'"},
        {"hang", "expected 'slave N', not ''"},
        {"damage back", "expected 'wire N': damage happens on a wire, not ''"},
        {"drop back", "expected 'wire N' with 'back', not 'back'"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_FAULT_MESSAGE] = "", text[ECT_FAULT_TEXT] = "";
        ect_fault_t fault;
        bool taken = ect_fault_parse(rows[i].text, &fault, message);
        if (taken != (rows[i].why == NULL) || strcmp(message, taken ? "" : rows[i].why) != 0)
            fail_msg("'%s': expected '%s', got '%s'", rows[i].text, rows[i].why ? rows[i].why : "", message);
        if (taken)
            ect_fault_print(&fault, text);
        assert_string_equal(text, taken ? rows[i].text : "");
    }
}

/* 95 characters and twelve words are taken, one more of either is not. */
static void longest_texts(void **state)
{
    char message[ECT_FAULT_MESSAGE], text[ECT_FAULT_TEXT + 1];
    ect_fault_t fault;
    (void)state;
    memset(text, ' ', sizeof text);
    text[ECT_FAULT_TEXT] = 0;
    memcpy(text, "drop", 4);
    assert_false(ect_fault_parse(text, &fault, message));
    assert_non_null(strstr(message, "a fault is at most 95 characters long"));
    text[ECT_FAULT_TEXT - 1] = 0;
    assert_true(ect_fault_parse(text, &fault, message));
    assert_false(ect_fault_parse("a b c d e f g h i j k l", &fault, message));
    assert_non_null(strstr(message, "expected drop, damage, delay,"));
    assert_false(ect_fault_parse("a b c d e f g h i j k l m", &fault, message));
    assert_non_null(strstr(message, "a fault has at most 12 words"));
    assert_true(ect_fault_parse("every 3 delay 7us wire 2 back", &fault, message));
    assert_true(ect_fault_parse("9% counter 7 wire 2 back  ", &fault, message));
}

static void objects(void **state)
{
    static const struct {
        const char *text;
        bool good;
        uint16_t index;
        int sub; /* -1: all entries */
    } rows[] = {{"0x1018", true, 0x1018, -1},
                {"1018h", true, 0x1018, -1},
                {"0x0", true, 0, -1},
                {"0h", true, 0, -1},
                {"0xFFFF", true, 0xFFFF, -1},
                {"ffffh", true, 0xFFFF, -1},
                {"0x1018:0", true, 0x1018, 0},
                {"1018h:255", true, 0x1018, 255},
                {"0x1018:0x10", true, 0x1018, 16},
                {"0x1018:010", true, 0x1018, 8},
                {"1018", false, 0, 0},
                {"0x", false, 0, 0},
                {"h", false, 0, 0},
                {"", false, 0, 0},
                {"0x10180", false, 0, 0},
                {"10180h", false, 0, 0},
                {"0x1018h", false, 0, 0},
                {"0x1018:", false, 0, 0},
                {"0x1018:256", false, 0, 0},
                {"0x1018:-1", false, 0, 0},
                {"0x1018: 1", false, 0, 0},
                {"0x1018:1x", false, 0, 0},
                {"0x1018 1", false, 0, 0},
                {"0x-1", false, 0, 0},
                {"0x 1", false, 0, 0},
                {"1018H", false, 0, 0},
                {"1018h1", false, 0, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_fault_object_t object = {0};
        const bool good = ect_fault_read_object(rows[i].text, &object);
        if (good != rows[i].good || object.named != good)
            fail_msg("'%s': expected %s", rows[i].text, rows[i].good ? "an object" : "a refusal");
        if (good && (object.index != rows[i].index || object.has_sub != (rows[i].sub >= 0) ||
                     object.sub != (rows[i].sub >= 0 ? rows[i].sub : 0)))
            fail_msg("'%s': got 0x%04X:%u, has a sub-index: %d", rows[i].text, object.index, object.sub,
                     object.has_sub);
    }
}

static void ordinals(void **state)
{
    static const struct {
        const char *text;
        uint32_t number; /* 0: none */
    } rows[] = {{"1st", 1},
                {"2nd", 2},
                {"3rd", 3},
                {"4th", 4},
                {"9th", 9},
                {"10th", 10},
                {"11th", 11},
                {"12th", 12},
                {"13th", 13},
                {"14th", 14},
                {"20th", 20},
                {"21st", 21},
                {"22nd", 22},
                {"23rd", 23},
                {"24th", 24},
                {"100th", 100},
                {"101st", 101},
                {"111th", 111},
                {"112th", 112},
                {"113th", 113},
                {"114th", 114},
                {"121st", 121},
                {"999999999th", 999999999},
                {"1000000000th", 1000000000},
                {"1000000001st", 0},
                {"4294967297th", 0},
                {"0th", 0},
                {"1th", 0},
                {"2st", 0},
                {"3nd", 0},
                {"4rd", 0},
                {"11st", 0},
                {"12nd", 0},
                {"13rd", 0},
                {"21th", 0},
                {"111st", 0},
                {"1", 0},
                {"st", 0},
                {"", 0},
                {"-1st", 0},
                {" 1st", 0},
                {"1 st", 0},
                {"1sts", 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint32_t number = ect_fault_ordinal(rows[i].text);
        if (number != rows[i].number)
            fail_msg("'%s': expected %u, got %u", rows[i].text, rows[i].number, number);
    }
}

/* The name of a twin is printed if there is room for it, and for the word that may follow; else its number. */
static void names_with_room(void **state)
{
    static const char *const faults[] = {"hang slave 2", "drop 5% wire 2 back",
                                         "abort 0x1C12:255 download 0x06040043 step 1000000 2nd slave 2",
                                         "abort 0x1C12:255 download 0x06040043 step 1000000 1000000000th slave 2"};
    unsigned int numbers = 0, named = 0;
    (void)state;
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        for (size_t length = 1; length < ECT_NAME_ROOM; length++) {
            char name[ECT_NAME_ROOM] = "", message[ECT_FAULT_MESSAGE], text[ECT_FAULT_TEXT], want[2 * ECT_FAULT_TEXT];
            ect_names_t *names = ect_names_new(2);
            ect_fault_t fault, again;
            memset(name, 'n', length);
            assert_true(names && ect_names_add(names, 1, name));
            assert_true(ect_fault_parse(faults[i], &fault, message));
            ect_fault_print_named(&fault, names, text);
            const char *place =
                strstr(faults[i], "slave 2") ? strstr(faults[i], "slave 2") : strstr(faults[i], "wire 2");
            const int words = (int)(strchr(place, ' ') - faults[i]);
            const bool fits = (size_t)words + length + sizeof " back" < ECT_FAULT_TEXT;
            snprintf(want, sizeof want, "%.*s %s%s", words, faults[i], fits ? name : "2", fault.back ? " back" : "");
            assert_string_equal(text, want);
            assert_true(ect_fault_parse_named(text, names, &again, message));
            assert_memory_equal(&fault, &again, sizeof fault);
            numbers += !fits;
            named += fits;
            ect_names_free(names);
        }
    }
    assert_true(numbers > 0 && named > 0);
}

/* Every n-th, the n-th, always, and a share of none and of all. */
static void counts_of_a_fault(void **state)
{
    static const struct {
        ect_fault_when_t when;
        uint32_t number;
        const char *applies; /* to the counts 1 to 8 */
    } rows[] = {{ECT_FAULT_ALWAYS, 0, "########"}, {ECT_FAULT_SHARE, 0, "........"}, {ECT_FAULT_SHARE, 100, "########"},
                {ECT_FAULT_EVERY, 1, "########"},  {ECT_FAULT_EVERY, 3, "..#..#.."}, {ECT_FAULT_ONCE, 1, "#......."},
                {ECT_FAULT_ONCE, 8, ".......#"},   {ECT_FAULT_ONCE, 9, "........"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_fault_t fault = {.when = rows[i].when, .number = rows[i].number};
        char got[9] = "";
        uint32_t seed = 1;
        for (uint64_t n = 1; n <= 8; n++)
            got[n - 1] = ect_fault_applies(&fault, n, &seed) ? '#' : '.';
        if (strcmp(got, rows[i].applies) != 0)
            fail_msg("row %zu: expected %s, got %s", i, rows[i].applies, got);
        assert_int_equal(seed != 1, rows[i].when == ECT_FAULT_SHARE);
    }
}

/* For the completion of a shell: the first words, as often as kinds have them. */
static void words(void **state)
{
    static const char *const want[ECT_FAULT_KINDS] = {
        "drop",  "damage",    "delay", "duplicate", "reorder",    "truncate", "corrupt", "counter", "off",
        "hang",  "resume",    "reset", "identity",  "lose-event", "eeprom",   "eeprom",  "eeprom",  "eeprom",
        "clock", "pdi-error", "to",    "init",      "emergency",  "al",       "al",      "al",      "abort",
        "mail",  "mail",      "mail",  "mail",      "mail",       "mail",     "mail",    "pdo-size"};
    (void)state;
    for (size_t i = 0; i < ECT_FAULT_KINDS; i++)
        assert_string_equal(ect_fault_word(i), want[i]);
    assert_null(ect_fault_word(ECT_FAULT_KINDS));
    assert_null(ect_fault_word(SIZE_MAX));
}

static void set(rig_t *r, const char *text)
{
    ect_fault_t fault;
    if (!ect_fault_parse(text, &fault, r->message) ||
        !ect_scenario_set(&r->s, r->w.chain, &fault, r->w.now_ns, r->message))
        fail_msg("'%s': %s", text, r->message);
    wire_poll(&r->w);
}

/* The effect on each of `frames` successive frames, one letter for each. */
static void apply_faults(rig_t *r, char *happened, size_t frames)
{
    for (size_t i = 0; i < frames; i++) {
        uint8_t sent[2100];
        wire_build(&r->w, BWR, 0, ADDRESS, "abcdefgh", 8);
        size_t before = r->w.frame_length, length = before;
        memcpy(sent, r->w.frame, length);
        ect_frame_effects_t fate = ect_scenario_frame(&r->s, r->w.chain, r->w.frame, &length, r->w.now_ns);
        happened[i] = fate.lose_request                       ? 'q'
                      : fate.lose_reply                       ? 'a'
                      : fate.twice                            ? '2'
                      : fate.after_next                       ? 'r'
                      : fate.delay_us != 0                    ? 'd'
                      : fate.counter != 0                     ? 'c'
                      : length != before                      ? 't'
                      : memcmp(sent, r->w.frame, before) != 0 ? 'x'
                                                              : '.';
        r->w.now_ns += MS;
    }
    happened[frames] = 0;
}

static void selected_frames(void **state)
{
    static const struct {
        const char *faults[2];
        const char *happens;
    } rows[] = {
        {{"duplicate"}, "22222222"},         {{"duplicate every 3"}, "..2..2.."},
        {{"duplicate frame 2"}, ".2......"}, {{"reorder frame 1"}, "r......."},
        {{"delay 5us every 4"}, "...d...d"}, {{"truncate 4 every 2"}, ".t.t.t.t"},
        {{"corrupt every 5"}, "....x..."},   {{"counter -1 frame 8"}, ".......c"},
        {{"drop 0%"}, "........"},           {{"reorder every 2", "duplicate every 3"}, ".r2r.2.r"},
        {{"duplicate", "off"}, "........"},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char happened[16];
        set(r, "off");
        for (size_t k = 0; k < 2 && rows[i].faults[k]; k++)
            set(r, rows[i].faults[k]);
        apply_faults(r, happened, 8);
        if (strcmp(happened, rows[i].happens) != 0)
            fail_msg("%s: expected %s, got %s", rows[i].faults[0], rows[i].happens, happened);
    }
}

static void same_seed_same_run(void **state)
{
    enum { FRAMES = 2000 };
    static char first[FRAMES + 1], second[FRAMES + 1];
    rig_t *r = *state;
    for (uint32_t seed = 1; seed <= 3; seed++) {
        char *const runs[] = {first, second};
        for (unsigned int run = 0; run < 2; run++) {
            memset(&r->s, 0, sizeof r->s);
            r->s.seed = seed;
            set(r, "drop 10%");
            set(r, "corrupt 5%");
            set(r, "duplicate 20%");
            apply_faults(r, runs[run], FRAMES);
        }
        assert_string_equal(first, second);
        unsigned int lost = 0;
        for (size_t i = 0; i < FRAMES; i++)
            lost += first[i] == 'q' || first[i] == 'a' ? 1 : 0;
        assert_in_range(lost, FRAMES / 10 * 7 / 10, FRAMES / 10 * 13 / 10);
    }
}

/* Each fault has random numbers of its own: of late frames the same share is lost as of others. */
static void shares(void **state)
{
    enum { FRAMES = 20000 };
    static const struct {
        const char *faults[2];
        unsigned int lost, late; /* of a hundred */
    } rows[] = {{{"drop 0%", "delay 1us 0%"}, 0, 0},
                {{"drop 100%"}, 100, 0},
                {{"delay 1us 100%"}, 0, 100},
                {{"drop 50%", "delay 1us 60%"}, 50, 60},
                {{"drop 5%", "delay 1us 5%"}, 5, 5}};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        unsigned int requests = 0, answers = 0, late = 0;
        set(r, "off");
        for (size_t k = 0; k < 2 && rows[i].faults[k]; k++)
            set(r, rows[i].faults[k]);
        for (unsigned int n = 0; n < FRAMES; n++) {
            uint8_t frame[60] = {0};
            size_t length = sizeof frame;
            ect_frame_effects_t fate = ect_scenario_frame(&r->s, r->w.chain, frame, &length, r->w.now_ns);
            requests += fate.lose_request;
            answers += fate.lose_reply;
            late += fate.delay_us != 0;
        }
        assert_in_range(requests, FRAMES / 200u * rows[i].lost * 9u / 10u, FRAMES / 200u * rows[i].lost * 11u / 10u);
        assert_in_range(answers, FRAMES / 200u * rows[i].lost * 9u / 10u, FRAMES / 200u * rows[i].lost * 11u / 10u);
        assert_in_range(late, FRAMES / 100u * rows[i].late * 9u / 10u, FRAMES / 100u * rows[i].late * 11u / 10u);
    }
}

static void shown(void **state)
{
    char text[ECT_FAULT_TEXT];
    rig_t *r = *state;
    ect_fault_t fault;
    set(r, "drop 5%");
    set(r, "duplicate frame 3");
    assert_true(ect_scenario_show(&r->s, r->w.chain, 1, text));
    assert_string_equal(text, "duplicate frame 3");
    assert_false(ect_scenario_show(&r->s, r->w.chain, 2, text));
    assert_true(ect_fault_parse("hang slave 4", &fault, r->message));
    assert_false(ect_scenario_set(&r->s, r->w.chain, &fault, 0, r->message));
    assert_non_null(strstr(r->message, "there is no slave 4"));
    for (unsigned int i = 2; i < ECT_SCENARIO_FAULTS; i++)
        set(r, "corrupt 1%");
    assert_true(ect_fault_parse("drop", &fault, r->message));
    assert_false(ect_scenario_set(&r->s, r->w.chain, &fault, 0, r->message));
    assert_non_null(strstr(r->message, "'off' ends them"));
}

/* A VLAN tag precedes the type; the counter moves with it. */
static void counters(void **state)
{
    enum { ADDRESSES = 12, TAG = 4 };
    uint8_t tagged[128] = {[ADDRESSES] = 0x81, 0x00};
    rig_t *r = *state;
    wire_build(&r->w, BRD, 0, 0, "ab", 2);
    ect_frame_count(r->w.frame, r->w.frame_length, -1);
    assert_int_equal(wire_wkc(&r->w, 0), 0xFFFF);
    ect_frame_count(r->w.frame, r->w.frame_length, 5);
    assert_int_equal(wire_wkc(&r->w, 0), 4);
    for (size_t length = 0; length < 30; length++)
        ect_frame_count(r->w.frame, length, 1); /* cut off before its counter */
    assert_int_equal(wire_wkc(&r->w, 0), 4);
    size_t behind = r->w.frame_length - ADDRESSES;
    memcpy(tagged, r->w.frame, ADDRESSES);
    memcpy(tagged + ADDRESSES + TAG, r->w.frame + ADDRESSES, behind);
    ect_frame_count(tagged, r->w.frame_length + TAG, 2);
    memcpy(r->w.frame + ADDRESSES, tagged + ADDRESSES + TAG, behind);
    assert_int_equal(wire_wkc(&r->w, 0), 6);
}

/* Whatever there is of it: one bit, and nothing beside it. */
static void corrupted(void **state)
{
    (void)state;
    for (size_t length = 0; length < 80; length++) {
        uint32_t seed = (uint32_t)length + 1;
        uint8_t *frame = calloc(1, length > 0 ? length : 1); /* of that size: every access beyond it is detected */
        unsigned int changed = 0;
        assert_non_null(frame);
        ect_frame_corrupt(&seed, frame, length);
        for (size_t i = 0; i < length; i++)
            changed += frame[i] != 0 && (frame[i] & (frame[i] - 1)) == 0 ? 1 : frame[i] == 0 ? 0 : 8;
        assert_int_equal(changed, length > 0);
        free(frame);
    }
}

/* In a frame of EtherCAT from its first data on, in another one everywhere. */
static void corrupted_at_any_bit(void **state)
{
    enum { DATA = 4, DRAWS = 20000, MOST = 14 + 2 + 10 + DATA + 2 };
    const uint8_t zeros[DATA] = {0};
    wire_t w = {0};
    uint32_t seed = 1;
    (void)state;
    wire_build(&w, BRD, 0, ECT_REG_AL_STATUS, zeros, DATA);
    assert_in_range(w.frame_length, MOST, sizeof w.frame);
    for (unsigned int ethercat = 0; ethercat < 2; ethercat++) {
        unsigned int inverted[MOST][8] = {{0}};
        if (ethercat == 0)
            w.frame[12] ^= 0xFF;
        for (unsigned int n = 0; n < DRAWS; n++) {
            uint8_t frame[MOST];
            memcpy(frame, w.frame, MOST);
            ect_frame_corrupt(&seed, frame, MOST);
            for (unsigned int bit = 0; bit < 8 * MOST; bit++)
                inverted[bit / 8][bit % 8] += (unsigned int)(frame[bit / 8] ^ w.frame[bit / 8]) >> bit % 8 & 1u;
        }
        const unsigned int from = ethercat != 0 ? MOST - DATA - 2 : 0, bits = 8 * (MOST - from);
        for (unsigned int bit = 0; bit < 8 * MOST; bit++) {
            const unsigned int times = inverted[bit / 8][bit % 8];
            if (bit / 8 < from ? times != 0 : times < DRAWS / bits / 2 || times > 2 * DRAWS / bits)
                fail_msg("bit %u of byte %u: %u times", bit % 8, bit / 8, times);
        }
        w.frame[12] = 0x88;
    }
}

/* --- slaves ------------------------------------------------------------------------------------------------------- */

static void hangs(void **state)
{
    rig_t *r = *state;
    wire_configure_mailbox(&r->w, 1);
    set(r, "hang slave 2");
    assert_int_equal(wire_al(&r->w, 1, 2, NULL), 1);
    wire_advance(&r->w, 150 * MS);
    wire_go(&r->w, 0, 2);                                  /* the others go on */
    assert_int_equal(wire_read8(&r->w, 1, 0x0110) & 2, 0); /* its watchdog shows it */
    assert_int_equal(wire_read8(&r->w, 1, 0x0443), 1);
    set(r, "resume slave 2");
    wire_poll(&r->w);
    assert_int_equal(wire_read8(&r->w, 1, 0x0130), 2);
    assert_int_equal(wire_read8(&r->w, 1, 0x0110) & 2, 2);
}

static void pdi_errors(void **state)
{
    rig_t *r = *state;
    set(r, "pdi-error slave 2");
    set(r, "pdi-error slave 2");
    assert_int_equal(wire_read16(&r->w, 1, 0x030D), 0x0102);
    assert_int_equal(wire_read16(&r->w, 0, 0x030D), 0);
}

/* A power cycle or reset ends the fault, and the PDI watchdog as well. */
static void hang_ends(void **state)
{
    static const char *const ends[] = {"reset slave 2", "identity slave 2", "the master's reset", "power"};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        set(r, "hang slave 2");
        if (i < 2)
            set(r, ends[i]);
        else if (i == 3)
            ect_chain_power_cycle(r->w.chain, r->w.now_ns);
        for (const char *letter = "RES"; i == 2 && *letter != 0; letter++)
            assert_int_equal(wire_send(&r->w, APWR, (uint16_t)-1, 0x0040, (uint8_t[1]){(uint8_t)*letter}, 1), 1);
        wire_poll(&r->w);
        wire_assign_stations(&r->w);
        wire_advance(&r->w, 300 * MS);
        if (wire_read8(&r->w, 1, 0x0443) != 0 || (wire_read8(&r->w, 1, 0x0110) & 2) == 0)
            fail_msg("%s: the PDI watchdog has expired", ends[i]);
        wire_configure_mailbox(&r->w, 1);
        if (wire_al(&r->w, 1, 2, NULL) != 2)
            fail_msg("%s: expected a slave that answers", ends[i]);
    }
}

static void resets_and_identity(void **state)
{
    rig_t *r = *state;
    uint8_t command[6] = {0x00, 0x01, 0x0A};
    uint32_t product[2];
    for (unsigned int i = 0; i < 2; i++) {
        uint8_t word[4] = {0};
        assert_int_equal(wire_write(&r->w, 1, 0x0502, command, 6), 1);
        wire_advance(&r->w, MS);
        assert_int_equal(wire_read(&r->w, 1, 0x0508, word, 4), 1);
        product[i] = ect_load_le32(word);
        wire_go(&r->w, 1, 2);
        set(r, "identity slave 2");
        assert_int_equal(ect_chain_slave(r->w.chain, 1)->state, 1);
        wire_assign_stations(&r->w);
    }
    assert_int_equal(product[1], product[0] + 1);
    wire_go(&r->w, 1, 2);
    set(r, "reset slave 2");
    assert_int_equal(ect_chain_slave(r->w.chain, 1)->state, 1);
    wire_assign_stations(&r->w);
    wire_go(&r->w, 1, 2);
}

static void loses_an_event(void **state)
{
    rig_t *r = *state;
    wire_configure_mailbox(&r->w, 0);
    set(r, "lose-event slave 1");
    assert_int_equal(wire_write16(&r->w, 0, 0x0120, 2), 1);
    assert_int_equal(ect_esc_al_event(ect_chain_esc(r->w.chain, 0)) & ECT_EVENT_AL_CONTROL, 0);
    assert_int_equal(ect_chain_slave(r->w.chain, 0)->state, 1);
    wire_go(&r->w, 1, 2);
}

static void eeprom(void **state)
{
    rig_t *r = *state;
    uint8_t command[6] = {0x00, 0x01, 0x08}, good[4], bad[4];
    assert_int_equal(wire_write(&r->w, 0, 0x0502, command, 6), 1);
    wire_advance(&r->w, MS);
    assert_int_equal(wire_read(&r->w, 0, 0x0508, good, 4), 1);
    set(r, "eeprom flip 9 slave 1");
    assert_int_equal(wire_write(&r->w, 0, 0x0502, command, 6), 1);
    wire_advance(&r->w, MS);
    assert_int_equal(wire_read(&r->w, 0, 0x0508, bad, 4), 1);
    assert_int_equal(ect_load_le32(good) ^ ect_load_le32(bad), 0x02000200);
    set(r, "eeprom nack slave 1");
    assert_int_equal(wire_write(&r->w, 0, 0x0502, command, 6), 1);
    wire_advance(&r->w, MS);
    assert_int_equal(wire_read16(&r->w, 0, 0x0502) & 0xA000, 0x2000);
    set(r, "eeprom busy slave 1");
    assert_int_equal(wire_write(&r->w, 0, 0x0502, (uint8_t[2]){0, 0}, 2), 1);
    assert_int_equal(wire_write(&r->w, 0, 0x0502, command, 6), 1);
    wire_advance(&r->w, 1000 * MS);
    assert_int_equal(wire_read16(&r->w, 0, 0x0502) & 0x8000, 0x8000);
    set(r, "eeprom ok slave 1");
    assert_int_equal(wire_read16(&r->w, 0, 0x0502) & 0xA000, 0);
    assert_int_equal(wire_read(&r->w, 0, 0x0508, bad, 4), 1);
    assert_memory_equal(good, bad, 4);
}

static void clock_jumps(void **state)
{
    rig_t *r = *state;
    uint64_t before = ect_esc_system_time(ect_chain_esc(r->w.chain, 2), r->w.now_ns);
    set(r, "clock 123456ns slave 3");
    assert_int_equal(ect_esc_system_time(ect_chain_esc(r->w.chain, 2), r->w.now_ns), before + 123456);
    set(r, "clock -123456ns slave 3");
    assert_int_equal(ect_esc_system_time(ect_chain_esc(r->w.chain, 2), r->w.now_ns), before);
}

/* --- wires -------------------------------------------------------------------------------------------------------- */

/* A frame there, and what comes back of it. @return its length; 0: nothing has come back */
static size_t pass(rig_t *r)
{
    size_t length = r->w.frame_length;
    ect_frame_effects_t fate = ect_scenario_frame(&r->s, r->w.chain, r->w.frame, &length, r->w.now_ns);
    bool back = !fate.lose_request && ect_chain_process(r->w.chain, r->w.frame, length, r->w.now_ns);
    ect_wires_result_t on_wires = ect_scenario_reply(&r->s, &fate, r->w.frame, &length);
    wire_poll(&r->w);
    assert_true(on_wires == ECT_WIRES_PASSED || !back);
    return back ? length : 0;
}

/* Writes to all slaves. @return as pass */
static size_t write_all(rig_t *r, uint8_t value)
{
    wire_build(&r->w, BWR, 0, ADDRESS, &value, 1);
    return pass(r);
}

static void expect_bytes(const rig_t *r, const char *what, const uint8_t want[TWINS])
{
    for (size_t i = 0; i < TWINS; i++) {
        uint8_t got = ect_chain_esc(r->w.chain, i)->memory[ADDRESS];
        if (got != want[i])
            fail_msg("%s: slave %zu: expected 0x%02X, got 0x%02X", what, i + 1, want[i], got);
    }
}

/* The next frame that was kept goes on. @return its working counter; -1: it is lost on its way */
static int release(rig_t *r)
{
    ect_kept_t *kept = ect_wires_release(&r->s.wires, r->w.chain, r->w.now_ns);
    assert_non_null(kept);
    const uint8_t *d = kept->frame + 16;
    int counter = kept->end == ECT_END_IN ? ect_load_le16(d + 10 + ect_load_le16(d + 6)) : -1;
    free(kept);
    wire_poll(&r->w);
    return counter;
}

static void on_wires(void **state)
{
    rig_t *r = *state;
    set(r, "damage frame 2 wire 3");
    assert_int_not_equal(write_all(r, 1), 0);
    assert_int_equal(write_all(r, 2), 0);
    assert_int_equal(r->s.wires.result, ECT_WIRES_PASSED);
    assert_int_equal(ect_chain_esc(r->w.chain, 2)->memory[0x0300], 1);
    expect_bytes(r, "damaged before the third", (uint8_t[]){2, 2, 1});
    set(r, "drop frame 1 wire 2 back");
    assert_int_equal(write_all(r, 3), 0);
    assert_int_equal(r->s.wires.result, ECT_WIRES_LOST);
    assert_int_equal(ect_chain_esc(r->w.chain, 0)->memory[0x0300], 0);
    expect_bytes(r, "lost behind the second", (uint8_t[]){3, 3, 3});
}

static void changed_on_wires(void **state)
{
    rig_t *r = *state;
    set(r, "corrupt frame 1 wire 2");
    assert_int_not_equal(write_all(r, 0), 0);
    uint8_t other = ect_chain_esc(r->w.chain, 1)->memory[ADDRESS];
    if (other == 0) /* it was the working counter */
        assert_int_not_equal(wire_wkc(&r->w, 0), 3);
    expect_bytes(r, "a bit is another one before the second", (uint8_t[]){0, other, other});
    set(r, "truncate 2 frame 1 wire 3");
    assert_int_equal(write_all(r, 0x11), 0);
    expect_bytes(r, "cut before the third", (uint8_t[]){0x11, 0x11, other});
    assert_int_equal(ect_chain_esc(r->w.chain, 2)->memory[0x0300], 1);
    set(r, "truncate 2 frame 1 wire 3 back");
    assert_int_equal(write_all(r, 0x22), r->w.frame_length - 2);
    expect_bytes(r, "cut behind the third", (uint8_t[]){0x22, 0x22, 0x22});
    set(r, "truncate 1500 frame 1 wire 1 back");
    assert_int_equal(write_all(r, 0x22), 0);
    assert_int_not_equal(write_all(r, 0x22), 0);
    set(r, "counter -2 frame 1 wire 2");
    set(r, "counter 5 frame 1 wire 2 back"); /* both, and each once */
    assert_int_not_equal(write_all(r, 0x33), 0);
    assert_int_equal(wire_wkc(&r->w, 0), 6);
    assert_int_not_equal(write_all(r, 0x33), 0);
    assert_int_equal(wire_wkc(&r->w, 0), 3);
}

static void late_on_a_wire(void **state)
{
    rig_t *r = *state;
    set(r, "delay 3000us frame 1 wire 2");
    assert_int_equal(write_all(r, 1), 0);
    assert_int_equal(r->s.wires.result, ECT_WIRES_KEEP);
    expect_bytes(r, "late before the second", (uint8_t[]){1, 0, 0});
    uint64_t due_ns = r->w.now_ns + 3 * MS;
    assert_int_equal(ect_wires_due(&r->s.wires), due_ns);
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, r->w.now_ns), due_ns);
    r->w.now_ns += MS;
    assert_null(ect_wires_release(&r->s.wires, r->w.chain, r->w.now_ns));
    assert_int_equal(write_all(r, 2), 0); /* it does not overtake the first one */
    r->w.now_ns = due_ns;
    assert_int_equal(release(r), 3);
    expect_bytes(r, "the first one has come", (uint8_t[]){2, 1, 1});
    assert_int_equal(release(r), 3);
    expect_bytes(r, "the second one has come", (uint8_t[]){2, 2, 2});
    assert_int_equal(ect_wires_due(&r->s.wires), ECT_NEVER);
    assert_int_not_equal(write_all(r, 3), 0);
}

/* Each row: frames that write their number to all slaves, the first one late; then the bytes of the slaves. */
static void late_in_one_direction(void **state)
{
    static const struct {
        const char *fault;
        uint8_t first[TWINS], second[TWINS];
    } rows[] = {
        {"delay 3000us frame 1 wire 1", {0, 0, 0}, {0, 0, 0}},
        {"delay 3000us frame 1 wire 2", {1, 0, 0}, {2, 0, 0}},
        {"delay 3000us frame 1 wire 3", {1, 1, 0}, {2, 2, 0}},
        {"delay 3000us frame 1 wire 3 back", {1, 1, 1}, {2, 2, 2}},
        {"delay 3000us frame 1 wire 2 back", {1, 1, 1}, {2, 2, 2}},
        {"delay 3000us frame 1 wire 1 back", {1, 1, 1}, {2, 2, 2}},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        (void)teardown(state);
        (void)setup(state);
        rig_t *r = *state;
        set(r, rows[i].fault);
        assert_int_equal(write_all(r, 1), 0);
        expect_bytes(r, rows[i].fault, rows[i].first);
        assert_int_equal(write_all(r, 2), 0); /* it waits on the same wire, in the same direction */
        assert_int_equal(r->s.wires.result, ECT_WIRES_KEEP);
        assert_int_equal(r->s.wires.kept_count, 2);
        expect_bytes(r, rows[i].fault, rows[i].second);
        r->w.now_ns += 3 * MS;
        assert_int_equal(release(r), 3);
        assert_int_equal(release(r), 3);
        expect_bytes(r, rows[i].fault, (uint8_t[]){2, 2, 2});
        assert_int_not_equal(write_all(r, 3), 0);
    }
}

/* Frames on other wires are due at times of their own: the earliest is next. */
static void late_on_two_wires(void **state)
{
    rig_t *r = *state;
    const uint64_t begin_ns = r->w.now_ns;
    set(r, "delay 5000us frame 1 wire 3");
    set(r, "delay 2000us frame 2 wire 2");
    assert_int_equal(write_all(r, 1), 0);
    assert_true(ect_wires_due(&r->s.wires) == begin_ns + 5 * MS);
    assert_int_equal(write_all(r, 2), 0);
    assert_true(ect_wires_due(&r->s.wires) == begin_ns + 2 * MS);
    expect_bytes(r, "both are late", (uint8_t[]){2, 1, 0});
    r->w.now_ns = begin_ns + 2 * MS;
    assert_int_equal(release(r), 3);
    expect_bytes(r, "the second one has come", (uint8_t[]){2, 2, 2});
    assert_true(ect_wires_due(&r->s.wires) == begin_ns + 5 * MS);
    r->w.now_ns = begin_ns + 5 * MS;
    assert_int_equal(release(r), 3);
    expect_bytes(r, "the first one has come", (uint8_t[]){2, 2, 1});
}

static void truncated_twice(void **state)
{
    rig_t *r = *state;
    set(r, "truncate 2 frame 1 wire 3 back");
    set(r, "truncate 3 frame 1 wire 2 back");
    const size_t truncated = write_all(r, 1);
    assert_int_equal(truncated, r->w.frame_length - 5);
    assert_int_equal(r->s.wires.cut, 5);
    const size_t whole = write_all(r, 2);
    assert_int_equal(whole, r->w.frame_length);
    assert_int_equal(r->s.wires.cut, 0);
}

/* The next frame is not behind the copy of a frame: nothing delays it. */
static void twice_without_a_delay(void **state)
{
    rig_t *r = *state;
    set(r, "duplicate frame 1 wire 2");
    assert_int_not_equal(write_all(r, 1), 0);
    assert_int_not_equal(write_all(r, 2), 0);
    assert_int_equal(r->s.wires.kept_count, 1);
    expect_bytes(r, "the next frame", (uint8_t[]){2, 2, 2});
    assert_int_equal(release(r), 3);
    expect_bytes(r, "the copy of the first frame", (uint8_t[]){2, 1, 1});
}

static void most_faults_of_a_frame(void **state)
{
    ect_wires_t wires = {0};
    const ect_fault_t fault = {.kind = ECT_FAULT_DROP, .slave = 1};
    uint32_t seed = 1;
    (void)state;
    ect_wires_begin(&wires, &seed, 0);
    for (size_t n = 1; n <= ECT_WIRES_FAULTS + 1u; n++) {
        ect_wires_add(&wires, &fault);
        assert_int_equal(wires.fault_count, n < ECT_WIRES_FAULTS ? n : ECT_WIRES_FAULTS);
    }
    assert_null(wires.kept);
}

static void twice_on_a_wire(void **state)
{
    rig_t *r = *state;
    set(r, "duplicate frame 1 wire 2");
    wire_build(&r->w, BWR, 0, 0x0120, "\x11\x00", 2);
    r->w.poll = NULL;
    size_t length = r->w.frame_length;
    (void)ect_scenario_frame(&r->s, r->w.chain, r->w.frame, &length, r->w.now_ns);
    assert_true(ect_chain_process(r->w.chain, r->w.frame, length, r->w.now_ns));
    assert_int_equal(wire_wkc(&r->w, 0), 3);
    assert_int_equal(ect_wires_due(&r->s.wires), 0);
    assert_int_equal(release(r), 1); /* the slaves behind have not read the first request yet */
}

static void behind_the_next_on_a_wire(void **state)
{
    rig_t *r = *state;
    set(r, "reorder frame 1 wire 3");
    uint64_t begin_ns = r->w.now_ns;
    assert_int_equal(write_all(r, 1), 0);
    assert_int_equal(ect_wires_due(&r->s.wires), begin_ns + 10 * MS);
    assert_null(ect_wires_release(&r->s.wires, r->w.chain, begin_ns + 10 * MS - 1));
    assert_int_not_equal(write_all(r, 2), 0);
    expect_bytes(r, "the second one is first", (uint8_t[]){2, 2, 2});
    assert_int_equal(release(r), 3);
    expect_bytes(r, "then the first", (uint8_t[]){2, 2, 1});
}

static void behind_none_on_a_wire(void **state)
{
    rig_t *r = *state;
    set(r, "reorder frame 1 wire 3");
    assert_int_equal(write_all(r, 1), 0);
    r->w.now_ns += 10 * MS;
    assert_int_equal(release(r), 3);
    expect_bytes(r, "the slave behind has it as well", (uint8_t[]){1, 1, 1});
}

static void kept_at_most(void **state)
{
    rig_t *r = *state;
    set(r, "delay 1us wire 1");
    for (unsigned int i = 0; i <= ECT_WIRES_KEPT; i++)
        assert_int_equal(write_all(r, 1), 0);
    assert_int_equal(r->s.wires.kept_count, ECT_WIRES_KEPT);
    assert_int_equal(r->s.wires.result, ECT_WIRES_LOST); /* there is no room for the last one */
    ect_wires_clear(&r->s.wires);
    assert_int_equal(ect_wires_due(&r->s.wires), ECT_NEVER);
}

/* --- scripts ------------------------------------------------------------------------------------------------------ */

static void read_line(rig_t *r, const char *line)
{
    if (!ect_scenario_read(&r->s, line, r->message))
        fail_msg("'%s' was refused: %s", line, r->message);
}

static void script(void **state)
{
    rig_t *r = *state;
    char happened[16];
    read_line(r, "# a comment");
    read_line(r, "   ");
    read_line(r, " \t duplicate every 2   # from the beginning\n");
    assert_int_equal(r->s.step_count, 1);
    assert_string_equal(r->s.steps[0].text, "duplicate every 2");
    read_line(r, "at frame 5 off\r\n");
    read_line(r, "at 0.0065s reorder");
    read_line(r, "at slave 2 PREOP counter 3");
    apply_faults(r, happened, 9); /* a frame each millisecond: the seventh comes at 6 ms */
    assert_string_equal(happened, ".2.2...rr");
    wire_go(&r->w, 1, 2);
    set(r, "off");
    apply_faults(r, happened, 2);
    assert_string_equal(happened, "cc");
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, r->w.now_ns), ECT_NEVER);
}

static void record_refused(void *ctx, const char *fault, const char *why)
{
    rig_t *r = ctx;
    snprintf(r->message, sizeof r->message, "%s: %s", fault, why);
}

/* A full table, or a slave that does not exist: reported once. */
static void script_reported(void **state)
{
    rig_t *r = *state;
    for (unsigned int i = 0; i < ECT_SCENARIO_FAULTS; i++)
        read_line(r, "corrupt 0%");
    read_line(r, "at 1s duplicate");
    read_line(r, "at 2s hang slave 4");
    r->s.refused = record_refused;
    r->s.ctx = r;
    uint64_t begin = r->w.now_ns;
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, begin), begin + 1000 * MS);
    assert_string_equal(r->message, "");
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, begin + 1000 * MS), begin + 2000 * MS);
    assert_string_equal(r->message, "duplicate: 8 faults are set already: 'off' ends them");
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, begin + 2000 * MS), ECT_NEVER);
    assert_string_equal(r->message, "hang slave 4: there is no slave 4: the chain has 3");
    r->message[0] = 0;
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, begin + 3000 * MS), ECT_NEVER);
    assert_string_equal(r->message, "");
}

static void script_times(void **state)
{
    rig_t *r = *state;
    read_line(r, "at 2s hang slave 1");
    read_line(r, "at 1s reset slave 1");
    uint64_t begin = r->w.now_ns;
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, begin), begin + 1000 * MS);
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, begin + 1000 * MS), begin + 2000 * MS);
    assert_int_equal(ect_scenario_tick(&r->s, r->w.chain, begin + 2000 * MS), ECT_NEVER);
}

static void script_refused(void **state)
{
    static const char *const lines[] = {"at",         "at 5 drop",       "at -1s drop",        "at frame drop",
                                        "at frame 5", "at slave 1 drop", "at slave 0 OP drop", "at slave 1 RUN drop",
                                        "at 1s",      "at 1s explode",   "at noon drop"};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        r->message[0] = 0;
        if (ect_scenario_read(&r->s, lines[i], r->message) || r->message[0] == 0)
            fail_msg("'%s': expected it refused with a message", lines[i]);
    }
    for (unsigned int i = 0; i < ECT_SCENARIO_STEPS; i++)
        read_line(r, "at 1s off");
    assert_false(ect_scenario_read(&r->s, "at 1s off", r->message));
}

/* A script at its limits: the last step that has room, the refusal of the next one, and of values out of range. */
static void script_limits(void **state)
{
    static const struct {
        const char *line;
        bool good;
    } rows[] = {
        {"at 0s drop", true},
        {"at 999999999s drop", true},
        {"at 1000000000s drop", false},
        {"at -1s drop", false},
        {"at nans drop", false},
        {"at frame 0 drop", true},
        {"at frame 18446744073709551615 drop", true},
        {"at frame 18446744073709551616 drop", false},
        {"at slave 65535 BOOT drop", true},
        {"at slave 65536 BOOT drop", false},
        {"at slave 1 PRE drop", false},
        {"at slave 1 PREOP drop", true},
        {"\t at 1s drop \t# a comment", true},
        {"# a comment", true},
        {" \t\r\n", true},
    };
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (ect_scenario_read(&r->s, rows[i].line, r->message) != rows[i].good)
            fail_msg("'%s': expected %s", rows[i].line, rows[i].good ? "a step" : "a refusal");
    }
    assert_int_equal(ect_scenario_highest_slave(&r->s), 65535);
    while (r->s.step_count < ECT_SCENARIO_STEPS)
        read_line(r, "at 1s off");
    assert_int_equal(r->s.steps_left, ECT_SCENARIO_STEPS);
    assert_int_equal(ect_scenario_highest_slave(&r->s), 65535);
    assert_false(ect_scenario_read(&r->s, "at 1s off", r->message));
    assert_string_equal(r->message, "a script has at most 256 steps");
    assert_int_equal(r->s.steps_left, ECT_SCENARIO_STEPS);
    assert_int_equal(r->s.step_count, ECT_SCENARIO_STEPS);
    assert_true(ect_scenario_read(&r->s, "# still a comment", r->message));
}

/* A slave of a condition counts as well as the slave of a fault. */
static void highest_slaves(void **state)
{
    static const struct {
        const char *line;
        uint16_t highest;
    } rows[] = {{"drop", 0},
                {"at slave 2 OP drop", 2},
                {"at slave 1 OP hang slave 3", 3},
                {"drop wire 2", 2},
                {"at slave 4 OP hang slave 1", 4},
                {"at slave 5 OP at slave 4 PREOP hang slave 1", 5},
                {"at slave 4 OP at slave 5 PREOP hang slave 1", 5},
                {"hang slave 1 until slave 4 OP", 4},
                {"hang slave 1 until slave 4 OP again", 4},
                {"hang slave 1 while slave 4 OP", 4},
                {"hang slave 2 until slave 1 OP", 2},
                {"hang slave 2 for 5s", 2},
                {"set 3:a=1", 3},
                {"set 3:a=1 until slave 4 OP", 4},
                {"expect 3:a=1 within 5 cycles", 3}};
    rig_t *r = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        r->s = (ect_scenario_t){.seed = 1};
        assert_int_equal(ect_scenario_highest_slave(&r->s), 0);
        read_line(r, rows[i].line);
        assert_int_equal(ect_scenario_highest_slave(&r->s), rows[i].highest);
    }
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a fault that is written reads back as the same", round_trip, NULL, NULL, NULL},
        {"the words of a fault may have any order", any_order, NULL, NULL, NULL},
        {"a text that is no fault is refused with the expected words", refused, NULL, NULL, NULL},
        {"numbers of a fault are taken within their ranges, and refused outside with the range", ranges, NULL, NULL,
         NULL},
        {"a fault of 95 characters and one of twelve words are read, a longer one is refused", longest_texts, NULL,
         NULL, NULL},
        {"each kind of fault has its first word", words, NULL, NULL, NULL},
        {"an object has an index of one to four digits, and perhaps a sub-index up to 255", objects, NULL, NULL, NULL},
        {"an ordinal is a number with the end of that number", ordinals, NULL, NULL, NULL},
        {"a fault is printed with the name of its twin, or with its number if the room ends", names_with_room, NULL,
         NULL, NULL},
        {"a fault applies to each, to every n-th, to the n-th, or to a share", counts_of_a_fault, NULL, NULL, NULL},
        TEST("faults of frames concern the frames that they name", selected_frames),
        TEST("the same seed makes the same run, of about the given share", same_seed_same_run),
        TEST("frames are lost and late in the given shares, half of the lost ones on their way back", shares),
        TEST("the faults that are set are shown; too many, and slaves that there are not, are refused", shown),
        TEST("the working counter of the first datagram is changed, where there is one", counters),
        TEST("an invalid access of the PDI counts in the slave of the fault alone", pdi_errors),
        TEST("CF-053: a slave that hangs replies to no request, its PDI watchdog expires, and it continues later",
             hangs),
        TEST("CF-012 CF-053: a slave that hangs is set going by a reset, by the master's too, and its watchdog rests",
             hang_ends),
        TEST("CF-096: a slave that is reset or replaced begins in INIT, with another product code",
             resets_and_identity),
        TEST("a request to AL control whose event is lost is not detected", loses_an_event),
        TEST("CF-055: an EEPROM that is busy, does not reply, or has a wrong bit", eeprom),
        TEST("CF-088: a clock jumps, and back", clock_jumps),
        TEST("a frame that is corrupted has one bit changed", corrupted),
        TEST("each bit from the first data on is as likely to be corrupted, and none before", corrupted_at_any_bit),
        TEST("CF-011: frames that are lost and damaged on a wire", on_wires),
        TEST("CF-011: frames that are changed, truncated or miscounted on a wire: the slaves behind it receive them so",
             changed_on_wires),
        TEST("a frame that is late on a wire: those behind wait for it, and no other one overtakes it", late_on_a_wire),
        TEST("a frame waits for a late one on the same wire in the same direction alone", late_in_one_direction),
        TEST("the earliest of the late frames on wires continues first", late_on_two_wires),
        TEST("a frame is truncated on two wires", truncated_twice),
        TEST("no frame waits for the copy of a frame that comes twice", twice_without_a_delay),
        TEST("faults of wires beyond the limit of a frame are ignored", most_faults_of_a_frame),
        TEST("CF-041: a frame that comes twice over a wire is executed twice behind it", twice_on_a_wire),
        TEST("frames that change their order on a wire", behind_the_next_on_a_wire),
        TEST("a frame that waits on a wire for the next one continues after 10 ms", behind_none_on_a_wire),
        TEST("Frames beyond the limit of kept frames on wires are lost", kept_at_most),
        TEST("a script sets faults at a time, at a frame, in a state", script),
        TEST("a script returns its next deadline", script_times),
        TEST("a fault of a script that cannot be set at its time is reported", script_reported),
        TEST("a line that makes no sense is refused", script_refused),
        TEST("a script at its limits: times, frames, slaves, 256 steps and the refusal of the next one", script_limits),
        TEST("the highest slave of a script is that of a condition or of a fault", highest_slaves),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Faults", tests, NULL, NULL);
}
