/* SPDX-License-Identifier: MIT */
/* Bus files: the words that a file stands for, and the line that refuses one. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "buses/bus_file.h"

enum { TEXT = 400, LINES = 2000 };

/* Options of a command, as `ectwin run` has them. */
static unsigned int find(void *ctx, const char *name)
{
    static const struct {
        const char *name;
        unsigned int bits;
    } known[] = {
        {"seed", ECT_BUS_OPTION_VALUE},
        {"busy-poll", ECT_BUS_OPTION_FLAG},
        {"fault", ECT_BUS_OPTION_VALUE},
        {"connect", ECT_BUS_OPTION_VALUE},
        {"panel", ECT_BUS_OPTION_VALUE},
        {"store", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_PATH | ECT_BUS_OPTION_OUTPUT},
        {"faults", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_PATH},
        {"eoe", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_SOCKET | ECT_BUS_OPTION_OUTPUT | ECT_BUS_OPTION_OF_TWIN},
        {"play", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_PATH | ECT_BUS_OPTION_OF_TWIN},
        {"set", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_OF_TWIN},
        {"module", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_OF_TWIN},
        {"alias", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_OF_TWIN},
        {"serial", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_OF_TWIN},
        {"behaviour", ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_OF_TWIN},
    };
    (void)ctx;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcmp(known[i].name, name) == 0)
            return known[i].bits;
    }
    return ECT_BUS_OPTION_NONE;
}

static const ect_bus_options_t options = {.find = find};

/* The words and the devices as one text. */
static void parse(const char *yaml, char result[LINES], char why[TEXT])
{
    ect_bus_file_t file;
    result[0] = why[0] = '\0';
    if (ect_bus_file_parse(&file, "/m/bus.yaml", yaml, strlen(yaml), &options, why, TEXT)) {
        for (size_t i = 0; i < file.count; i++) {
            strcat(result, file.words[i]);
            strcat(result, " ");
        }
        strcat(result, file.devices);
    }
    ect_bus_file_free(&file);
}

#define BUS(lines) "ectwin: 1\n" lines
#define ONE        "twins:\n- device: fzm1\n"
#define TWO                                                                                                            \
    "twins:\n- device: pmctendo-dd5\n  name: axis\n- device: fzm1\n  name: cam\n  count: 3\n- device: esi:d/e.xml#T\n"

static void a_file_stands_for_the_words_of_a_command_line(void **state)
{
    static const struct {
        const char *title, *yaml, *words;
    } rows[] = {
        {"one device", BUS(ONE), "fzm1"},
        {"several", BUS(TWO), "axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"an absolute path stays", BUS("twins:\n- device: sii:/x/y.bin\n"), "sii:/x/y.bin"},
        {"options of the bus come before those of twins", BUS(ONE "  alias: 5\nseed: 7\n"),
         "--seed=7 --alias=1:5 fzm1"},
        {"a flag", BUS("busy-poll: true\n" ONE), "--busy-poll fzm1"},
        {"a flag that is false", BUS("busy-poll: false\n" ONE), "fzm1"},
        {"a list repeats the option", BUS("fault: [drop 1%, hang slave 1]\n" ONE),
         "--fault=drop 1% --fault=hang slave 1 fzm1"},
        {"a path is relative to the file", BUS("store: s/t\n" ONE), "--store=/m/s/t fzm1"},
        {"a file that is read may be anywhere", BUS("faults: [../f, /f]\n" ONE), "--faults=/m/../f --faults=/f fzm1"},
        {"a path of a twin is relative to the file", BUS(ONE "  play: 'w.csv,loop'\n"), "--play=1:/m/w.csv,loop fzm1"},
        {"a path of the bus, behind a number or a name",
         BUS("play: [w.csv, '2:w.csv', 'cam3:d/w.csv,loop', 'other:w.csv', '4:/x.csv']\n" TWO),
         "--play=/m/w.csv --play=2:/m/w.csv --play=cam3:/m/d/w.csv,loop --play=/m/other:w.csv --play=4:/x.csv "
         "axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"a socket is relative to the file, behind a number or a name",
         BUS("eoe: ['unix:s', '2:unix:d/s', 'cam3:unix:..s', echo, '1:tap0']\n" TWO),
         "--eoe=unix:/m/s --eoe=2:unix:/m/d/s --eoe=cam3:unix:/m/..s --eoe=echo --eoe=1:tap0 "
         "axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"a socket of a twin is relative to the file", BUS(ONE "  eoe: unix:s\n"), "--eoe=1:unix:/m/s fzm1"},
        {"a network file is relative to the file", BUS("twins:\n- device: fzm1\n- device: eni:m.xml\n"),
         "fzm1,eni:/m/m.xml"},
        {"a device file is relative to the file", BUS("twins:\n- device: yaml:d/g.yaml\n"), "yaml:/m/d/g.yaml"},
        {"one slave of a network file is a device", BUS("twins:\n- device: eni:m.xml#2\n- device: fzm1\n"),
         "eni:/m/m.xml#2,fzm1"},
        {"alias and serial number count up",
         BUS("twins:\n- device: fzm1\n- {device: fzm1, count: 2, alias: 7, serial: 0x10}\n"),
         "--alias=2:7 --alias=3:8 --serial=2:16 --serial=3:17 fzm1,fzm1*2"},
        {"the lowest alias and the highest serial number",
         BUS("twins:\n- {device: fzm1, count: 2, alias: 0}\n- {device: fzm1, serial: 4294967295}\n"),
         "--alias=1:0 --alias=2:1 --serial=3:4294967295 fzm1*2,fzm1"},
        {"others are the same for all of a count", BUS("twins:\n- {device: fzm1, count: 2, behaviour: none}\n"),
         "--behaviour=1:none --behaviour=2:none fzm1*2"},
        {"a count of one", BUS("twins:\n- {device: fzm1, count: 1, name: cam}\npanel: cam\n"), "--panel=cam cam=fzm1"},
        {"signals and modules are those of each of a count",
         BUS("twins:\n- device: fzm1\n- {device: fzm1, count: 2, set: {a: 1}, module: {1: 0x120}}\n"),
         "--set=2:a=1 --set=3:a=1 --module=2:1=0x120 --module=3:1=0x120 fzm1,fzm1*2"},
        {"the first and the last of a count", BUS("panel: [cam1, cam3]\n" TWO),
         "--panel=cam1,cam3 axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"signals", BUS(ONE "  set: {a.b: 1.5, c: text}\n"), "--set=1:a.b=1.5 --set=1:c=text fzm1"},
        {"modules", BUS(ONE "  module: {1: 0x120, 2: 0x121}\n"), "--module=1:1=0x120 --module=1:2=0x121 fzm1"},
        {"names in connections of the bus", BUS("connect: ['axis.home=cam2.run,factor=2', 2.trigger=axis.x]\n" TWO),
         "--connect=axis.home=cam2.run,factor=2 --connect=2.trigger=axis.x "
         "axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"a number is the option's matter", BUS("connect: ['0.in=9.out']\n" ONE), "--connect=0.in=9.out fzm1"},
        {"names in connections of a twin", BUS(TWO "  connect: {in: axis.out}\n"),
         "--connect=5.in=axis.out axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"names in faults", BUS("fault: at 2s hang slave cam3 until 3s\n" TWO),
         "--fault=at 2s hang slave cam3 until 3s axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"twins of the panel", BUS("panel: cam2,axis,3\n" TWO),
         "--panel=cam2,axis,3 axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"twins of the panel, as a list", BUS("panel: [cam2, axis, 3]\n" TWO),
         "--panel=cam2,axis,3 axis=pmctendo-dd5,cam=fzm1*3,esi:/m/d/e.xml#T"},
        {"comments and quotes", BUS("# a bus\ntwins:\n- device: \"fzm1\" # one\n"), "fzm1"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char words[LINES], why[TEXT];
        print_message("%s\n", rows[i].title);
        parse(rows[i].yaml, words, why);
        assert_string_equal(why, "");
        assert_string_equal(words, rows[i].words);
    }
}

static void a_wrong_file_is_refused_with_its_line(void **state)
{
    static const struct {
        const char *yaml, *why;
    } rows[] = {
        {"", "/m/bus.yaml:1: not a bus file: it begins with 'ectwin: 1' and has 'twins:'"},
        {"- a\n", "/m/bus.yaml:1: not a bus file: it begins with 'ectwin: 1' and has 'twins:'"},
        {ONE, "/m/bus.yaml:1: 'ectwin: 1' is missing: the version of the format that this ectwin reads"},
        {"ectwin: 2\n" ONE, "/m/bus.yaml:1: 'ectwin: 1' is missing: the version of the format that this ectwin reads"},
        {"ectwin-device: 1\n", "/m/bus.yaml:1: a device, not a bus: write yaml:/m/bus.yaml"},
        {BUS(""), "/m/bus.yaml:1: 'twins:' with a list of '- device: DEVICE' is missing"},
        {BUS("twins: []\n"), "/m/bus.yaml:2: 'twins:' with a list of '- device: DEVICE' is missing"},
        {BUS("twins: [fzm1]\n"), "/m/bus.yaml:2: a twin is '- device: DEVICE', followed by its other keys"},
        {BUS("twins:\n- name: a\n"), "/m/bus.yaml:3: a twin without 'device'; 'ectwin list' lists the devices"},
        {BUS("twins:\n- device: fzm1,fzm1\n"),
         "/m/bus.yaml:3: 'device: fzm1,fzm1' names one device: write a further one as a separate '- device:', several "
         "equal ones as 'count'"},
        {BUS("colour: red\n" ONE),
         "/m/bus.yaml:2: 'colour' is no key of a bus: ectwin, twins, or a long option of 'ectwin run' without its --"},
        {BUS(ONE "  store: x\n"),
         "/m/bus.yaml:4: 'store' is no key of a twin: device, name, count, set, module, connect, or an option of "
         "'ectwin run' that takes N: for twin N"},
        {BUS(ONE "  name: 1a\n"),
         "/m/bus.yaml:4: 'name: 1a': a letter a to z first, then letters, digits, _ and -, at most 31"},
        {BUS("twins:\n- {device: a, name: x}\n- {device: a, name: x}\n"), "/m/bus.yaml:4: two twins have the name 'x'"},
        {BUS("twins:\n- {device: a, name: x2}\n- {device: a, name: x, count: 2}\n"),
         "/m/bus.yaml:4: two twins have the name 'x'"},
        {BUS("twins:\n- {device: a, name: x, count: 2}\n- {device: a, name: x2}\n"),
         "/m/bus.yaml:4: two twins have the name 'x2'"},
        {BUS("twins:\n- device: eni:m.xml\n- device: fzm1\n"),
         "/m/bus.yaml:4: 'device: eni:FILE' must be the last entry: its bus has any length"},
        {BUS("twins:\n- device: eni:m.xml\n  count: 2\n"),
         "/m/bus.yaml:3: 'count' is for one device; 'device: eni:FILE' is a bus"},
        {BUS(ONE "  count: 0\n"), "/m/bus.yaml:4: 'count' takes a number from 1 to 65535"},
        {BUS("twins:\n- {device: a, count: 65535}\n- device: b\n"), "/m/bus.yaml:4: more than 65535 twins"},
        {BUS("twins:\n- {device: a, count: 65535, set: {a: 1, b: 1, c: 1, d: 1, e: 1, f: 1, g: 1, h: 1, i: 1, j: 1, k: "
             "1, l: "
             "1, m: 1, n: 1, o: 1, p: 1, q: 1}}\n"),
         "/m/bus.yaml:1: more than 1048576 options of all twins together"},
        {BUS(ONE "  alias: seven\n"), "/m/bus.yaml:4: 'alias' takes a number, not 'seven'"},
        {BUS(ONE "  serial: 4294967296\n"), "/m/bus.yaml:4: 'serial' takes a number, not '4294967296'"},
        {BUS(ONE "  serial: -1\n"), "/m/bus.yaml:4: 'serial' takes a number, not '-1'"},
        {BUS(ONE "  alias: 1\n  alias: 2\n"), "/m/bus.yaml:5: 'alias' occurs twice"},
        {BUS("busy-poll: yes\n" ONE), "/m/bus.yaml:2: 'busy-poll' takes true or false"},
        {BUS("seed: {a: 1}\n" ONE), "/m/bus.yaml:2: 'seed' takes one value"},
        {BUS("connect: arm.x=1.y\n" ONE), "/m/bus.yaml:2: there is no twin with the name 'arm'"},
        {BUS("panel: 1,arm\n" ONE), "/m/bus.yaml:2: there is no twin with the name 'arm'"},
        {BUS("panel:\n- 1\n- arm\n" ONE), "/m/bus.yaml:4: there is no twin with the name 'arm'"},
        {BUS("panel: {a: b}\n" ONE), "/m/bus.yaml:2: 'panel' takes one value"},
        {BUS("connect: \"a\\n\\eb.x=1.y\"\n" ONE), "/m/bus.yaml:2: there is no twin with the name 'a??b'"},
        {BUS("fault: hang slave cam4\n" TWO), "/m/bus.yaml:2: there is no twin with the name 'cam4'"},
        {BUS(ONE "  set: [a]\n"), "/m/bus.yaml:4: set: 'key: value' lines are missing"},
        {BUS("store: /x\n" ONE),
         "/m/bus.yaml:2: 'store: /x' is written outside the folder of the bus file: take a path below that folder, or "
         "give --store on the command line"},
        {BUS("store: a/../../x\n" ONE),
         "/m/bus.yaml:2: 'store: a/../../x' is written outside the folder of the bus file: take a path below that "
         "folder, or give --store on the command line"},
        {BUS(ONE "  eoe: unix:..\n"),
         "/m/bus.yaml:4: 'eoe: unix:..' is written outside the folder of the bus file: take a path below that folder, "
         "or give --eoe on the command line"},
        {BUS("eoe: ['1:unix:/s']\n" ONE),
         "/m/bus.yaml:2: 'eoe: 1:unix:/s' is written outside the folder of the bus file: take a path below that "
         "folder, or give --eoe on the command line"},
        {BUS("twins:\n- device: bus.yaml\n"),
         "/m/bus.yaml:3: 'device: bus.yaml' is a file: write 'device: yaml:bus.yaml' for a device file; "
         "a bus file contains no other bus files: copy their twins"},
        {BUS("a: &x b\n" ONE), "/m/bus.yaml:2: an anchor of YAML: bus files have none"},
        {BUS("a: &x [b]\nc: *x\n" ONE), "/m/bus.yaml:2: an anchor of YAML: bus files have none"},
        {BUS("a: *x\n" ONE), "/m/bus.yaml:2: an alias of YAML: bus files have none"},
        {BUS("a: !!int 3\n" ONE), "/m/bus.yaml:2: a tag of YAML: bus files have none"},
        {BUS(ONE "---\n" ONE), "/m/bus.yaml:4: a second document: a bus file has one"},
        {BUS("a: [[[[[[[[[1]]]]]]]]]\n"), "/m/bus.yaml:2: lists within lists: a bus file has no such depth"},
        {BUS("a: \"b\n"), "/m/bus.yaml:3: no YAML: found unexpected end of stream"},
        {BUS("\ta: b\n"), "/m/bus.yaml:2: no YAML: found a tab character that violates indentation"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char words[LINES], why[TEXT];
        parse(rows[i].yaml, words, why);
        assert_string_equal(why, rows[i].why);
        assert_string_equal(words, "");
    }
}

static void each_word_and_each_twin_has_its_line(void **state)
{
    static const char yaml[] =
        BUS("seed: 7\nfault:\n- drop 1%\n- hang slave 1\ntwins:\n- device: fzm1\n  set:\n    a: 1\n"
            "    b: 2\n- name: cam\n  count: 2\n  device: fzm1\n  alias: 3\n");
    static const size_t lines[] = {2, 4, 5, 9, 10, 14, 14}, twin_lines[] = {7, 13, 13};
    ect_bus_file_t file;
    char why[TEXT];
    (void)state;
    assert_true(ect_bus_file_parse(&file, "bus.yaml", yaml, strlen(yaml), &options, why, TEXT));
    assert_int_equal(file.count, 7);
    assert_int_equal(file.twins, 3);
    assert_memory_equal(file.lines, lines, sizeof lines);
    assert_memory_equal(file.twin_lines, twin_lines, sizeof twin_lines);
    ect_bus_file_free(&file);
}

static void a_name_ends_in_yaml_or_yml(void **state)
{
    (void)state;
    assert_true(ect_bus_file_is("a/bus.yaml"));
    assert_true(ect_bus_file_is("BUS.YML"));
    assert_false(ect_bus_file_is("fzm1"));
    assert_false(ect_bus_file_is("esi:bus.yaml.xml"));
    assert_false(ect_bus_file_is("yaml:gauge.yaml"));
    assert_false(ect_bus_file_is("fzm1,yaml:gauge.yaml"));
}

static void a_file_that_cannot_be_read_is_a_line(void **state)
{
    ect_bus_file_t file;
    char why[TEXT];
    (void)state;
    assert_false(ect_bus_file_read(&file, "/nonexistent/bus.yaml", &options, why, sizeof why));
    assert_string_equal(why, "/nonexistent/bus.yaml: No such file or directory");
    ect_bus_file_free(&file);
    assert_false(ect_bus_file_read(&file, "/tmp", &options, why, sizeof why));
    assert_string_equal(why, "/tmp: not a file of at most 1048576 bytes");
    ect_bus_file_free(&file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_stands_for_the_words_of_a_command_line),
        cmocka_unit_test(a_wrong_file_is_refused_with_its_line),
        cmocka_unit_test(each_word_and_each_twin_has_its_line),
        cmocka_unit_test(a_name_ends_in_yaml_or_yml),
        cmocka_unit_test(a_file_that_cannot_be_read_is_a_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
