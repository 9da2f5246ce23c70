/* SPDX-License-Identifier: MIT */
/* Requests to the object dictionary of a twin (bus/control/objects.h), without and with a socket. */
#include "bus/control/objects.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/control_bench.h"
#include "support/terminal.h"
#include "support/testdev.h"
#include "wire/registers.h"

typedef struct row {
    const char *request, *want;
} row_t;

/* Executes a request. @return the line, or the reason of a refusal */
static const char *answer(wire_t *w, const char *text, bool write)
{
    static ect_line_t line;
    static char message[ECT_SIGNAL_MESSAGE];
    cJSON *request = cJSON_Parse(text);
    assert_non_null(request);
    const char *why =
        write ? ect_object_write(w->chain, 1, request, message) : ect_object_read(w->chain, 1, request, &line, message);
    cJSON_Delete(request);
    if (why)
        return why;
    line.text[write ? 0 : line.length - 1] = 0;
    return line.text;
}

static testdev_t *open_device(wire_t *w)
{
    wire_open_one(w, &testdev);
    wire_configure_mailbox(w, 0);
    wire_go(w, 0, ECT_STATE_PREOP);
    return ect_chain_slave(w->chain, 0)->config.instance;
}

/* Each row writes an entry, then reads the entry. */
static void written_values(void **state)
{
    static const struct {
        const char *write, *read, *want;
    } rows[] = {
        {"{\"index\":8192,\"value\":7}", "{\"index\":8192}",
         "{\"slave\":1,\"index\":8192,\"sub\":0,\"size\":4,\"data\":\"07000000\",\"value\":7}"},
        {"{\"index\":8192,\"value\":\"0xFFFFFFFF\"}", "{\"index\":8192}",
         "{\"slave\":1,\"index\":8192,\"sub\":0,\"size\":4,\"data\":\"ffffffff\",\"value\":4294967295}"},
        {"{\"index\":8192,\"data\":\"0a0B0c0D\"}", "{\"index\":8192}",
         "{\"slave\":1,\"index\":8192,\"sub\":0,\"size\":4,\"data\":\"0a0b0c0d\",\"value\":218893066}"},
        {"{\"index\":8193,\"value\":\"a \\\"text\\\"\"}", "{\"index\":8193}",
         "{\"slave\":1,\"index\":8193,\"sub\":0,\"size\":8,\"data\":\"6120227465787422\",\"value\":\"a "
         "\\\"text\\\"\"}"},
        {"{\"index\":8197,\"value\":-100}", "{\"index\":8197}",
         "{\"slave\":1,\"index\":8197,\"sub\":0,\"size\":2,\"data\":\"9cff\",\"value\":-100}"},
        {"{\"index\":8198,\"sub\":2,\"value\":5}", "{\"index\":8198,\"sub\":2}",
         "{\"slave\":1,\"index\":8198,\"sub\":2,\"size\":1,\"data\":\"05\",\"value\":5}"},
        {"{\"index\":8199,\"sub\":4,\"value\":65535}", "{\"index\":8199,\"sub\":4}",
         "{\"slave\":1,\"index\":8199,\"sub\":4,\"size\":2,\"data\":\"ffff\",\"value\":65535}"},
        {"{\"index\":8201,\"value\":\"18446744073709551615\"}", "{\"index\":8201}",
         "{\"slave\":1,\"index\":8201,\"sub\":0,\"size\":8,\"data\":\"ffffffffffffffff\",\"value\":"
         "18446744073709551615}"},
    };
    wire_t w;
    (void)state;
    const testdev_t *device = open_device(&w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        unsigned int written = device->written;
        assert_string_equal(answer(&w, rows[i].write, true), "");
        assert_int_equal(device->written, written + 1); /* the device was called, as for a master */
        assert_string_equal(answer(&w, rows[i].read, false), rows[i].want);
    }
    wire_close(&w);
}

/* A number has a value if the type has this number of bytes; JSON has neither inf nor nan. */
static void values_of_each_type(void **state)
{
    static const struct {
        uint16_t type;
        const char *name;
        size_t size;
        const char *bytes, *want;
    } rows[] = {
        {ECT_TYPE_BOOLEAN, "BOOLEAN", 1, "\x01", "{\"data\":\"01\",\"value\":1}\n"},
        {ECT_TYPE_INTEGER8, "INTEGER8", 1, "\x80", "{\"data\":\"80\",\"value\":-128}\n"},
        {ECT_TYPE_INTEGER16, "INTEGER16", 2, "\xFE\xFF", "{\"data\":\"feff\",\"value\":-2}\n"},
        {ECT_TYPE_INTEGER32, "INTEGER32", 4, "\x00\x00\x00\x80", "{\"data\":\"00000080\",\"value\":-2147483648}\n"},
        {ECT_TYPE_INTEGER64, "INTEGER64", 8, "\x00\x00\x00\x00\x00\x00\x00\x80",
         "{\"data\":\"0000000000000080\",\"value\":-9223372036854775808}\n"},
        {ECT_TYPE_UNSIGNED8, "UNSIGNED8", 1, "\x80", "{\"data\":\"80\",\"value\":128}\n"},
        {ECT_TYPE_UNSIGNED16, "UNSIGNED16", 2, "\x34\x12", "{\"data\":\"3412\",\"value\":4660}\n"},
        {ECT_TYPE_UNSIGNED32, "UNSIGNED32", 4, "\xFF\xFF\xFF\xFF", "{\"data\":\"ffffffff\",\"value\":4294967295}\n"},
        {ECT_TYPE_UNSIGNED64, "UNSIGNED64", 8, "\x01\x00\x00\x00\x00\x00\x00\x80",
         "{\"data\":\"0100000000000080\",\"value\":9223372036854775809}\n"},
        {ECT_TYPE_REAL32, "REAL32", 4, "\xCD\xCC\xCC\x3D", "{\"data\":\"cdcccc3d\",\"value\":0.100000001}\n"},
        {ECT_TYPE_REAL32, "REAL32", 4, "\x00\x00\x80\xFF", "{\"data\":\"000080ff\",\"value\":null}\n"},
        {ECT_TYPE_REAL64, "REAL64", 8, "\x9A\x99\x99\x99\x99\x99\xB9\x3F",
         "{\"data\":\"9a9999999999b93f\",\"value\":0.10000000000000001}\n"},
        {ECT_TYPE_BITARR8, "BITARR8", 1, "\xFF", "{\"data\":\"ff\",\"value\":255}\n"},
        {ECT_TYPE_BITARR16, "BITARR16", 2, "\xFF\xFF", "{\"data\":\"ffff\",\"value\":65535}\n"},
        {ECT_TYPE_BITARR32, "BITARR32", 4, "\x01\x00\x00\x00", "{\"data\":\"01000000\",\"value\":1}\n"},
        {ECT_TYPE_BIT1, "BIT", 1, "\x01", "{\"data\":\"01\",\"value\":1}\n"},
        {ECT_TYPE_BIT8, "BIT", 1, "\x81", "{\"data\":\"81\",\"value\":129}\n"},
        {ECT_TYPE_BIT8 + 1, "OTHER", 1, "\x01", "{\"data\":\"01\"}\n"},
        {ECT_TYPE_VISIBLE_STRING, "VISIBLE_STRING", 2, "ab\0", "{\"data\":\"6162\",\"value\":\"ab\"}\n"},
        {ECT_TYPE_OCTET_STRING, "OCTET_STRING", 2, "ab\0", "{\"data\":\"6162\"}\n"},
        {ECT_TYPE_UNSIGNED32, "UNSIGNED32", 3, "\x01\x02\x03", "{\"data\":\"010203\"}\n"},
        {ECT_TYPE_UNSIGNED8, "UNSIGNED8", 0, "", "{\"data\":\"\"}\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_line_t line;
        ect_line_begin(&line);
        ect_object_put_value(&line, rows[i].type, (const uint8_t *)rows[i].bytes, rows[i].size);
        ect_line_end(&line);
        if (line.length != strlen(rows[i].want) || memcmp(line.text, rows[i].want, line.length) != 0)
            fail_msg("%s: expected %s, got %.*s", rows[i].name, rows[i].want, (int)line.length, line.text);
        assert_string_equal(ect_object_type(rows[i].type), rows[i].name);
    }
}

static void long_values(void **state)
{
    wire_t w;
    (void)state;
    testdev_t *device = open_device(&w);
    memset(device->octets, 0xA5, sizeof device->octets);
    const char *line = answer(&w, "{\"index\":8194}", false);
    assert_int_equal(strncmp(line, "{\"slave\":1,\"index\":8194,\"sub\":0,\"size\":1000,\"data\":\"a5a5", 54), 0);
    assert_int_equal(count_of(line, "a5"), 200);
    wire_close(&w);
}

static void refused_reads(void **state)
{
    static const row_t rows[] = {
        {"{\"index\":8195}", "2003h:0: SDO abort 0x06010001: the object is write-only"},
        {"{\"index\":4660}", "1234h:0: SDO abort 0x06020000: the object does not exist"},
        {"{\"index\":8198,\"sub\":99}", "2006h:99: SDO abort 0x06090011: the sub-index does not exist"},
        {"{}", "a request to an object has {\"index\":...,\"sub\":...}"},
        {"{\"index\":65536}", "\"index\" is a number from 0 to 65535"},
        {"{\"index\":\"1\"}", "\"index\" is a number from 0 to 65535"},
        {"{\"index\":1.5}", "\"index\" is a number from 0 to 65535"},
        {"{\"index\":1,\"sub\":256}", "\"sub\" is a number from 0 to 255"},
        {"{\"index\":1,\"sub\":-1}", "\"sub\" is a number from 0 to 255"},
    };
    wire_t w;
    (void)state;
    (void)open_device(&w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_string_equal(answer(&w, rows[i].request, false), rows[i].want);
    wire_go(&w, 0, ECT_STATE_INIT);
    assert_string_equal(answer(&w, "{\"index\":8192}", false), "2000h:0: SDO abort 0x08000022: not in this AL state");
    wire_close(&w);
}

static void refused_writes(void **state)
{
    static const row_t rows[] = {
        {"{\"index\":8197,\"value\":201}", "2005h:0: SDO abort 0x06090031: the value is too high"},
        {"{\"index\":8197,\"value\":-101}", "2005h:0: SDO abort 0x06090032: the value is too low"},
        {"{\"index\":8198,\"sub\":5,\"value\":1}", "2006h:5: SDO abort 0x06010002: the object is read-only"},
        {"{\"index\":8192,\"data\":\"00\"}", "2000h:0: SDO abort 0x06070013: the value is too short"},
        {"{\"index\":8192,\"data\":\"0000000000\"}", "2000h:0: SDO abort 0x06070012: the value is too long"},
        {"{\"index\":4660,\"value\":1}", "1234h:0: SDO abort 0x06020000: the object does not exist"},
        {"{\"index\":8192,\"value\":4294967296}",
         "'4294967296' is no value of type UNSIGNED32: \"data\" takes its bytes"},
        {"{\"index\":8192,\"value\":-1}", "'-1' is no value of type UNSIGNED32: \"data\" takes its bytes"},
        {"{\"index\":8192,\"value\":1.5}", "'1.5' is no value of type UNSIGNED32: \"data\" takes its bytes"},
        {"{\"index\":8197,\"value\":-32769}", "'-32769' is no value of type INTEGER16: \"data\" takes its bytes"},
        {"{\"index\":8194,\"value\":\"a\"}", "'a' is no value of type OCTET_STRING: \"data\" takes its bytes"},
        {"{\"index\":8192,\"data\":\"0\"}", "\"data\" is at most 200 bytes, each of two hexadecimal digits"},
        {"{\"index\":8192,\"data\":\"0g\"}", "\"data\" is at most 200 bytes, each of two hexadecimal digits"},
        {"{\"index\":8192}", "\"write\" takes \"value\", a number or a text of at most 200 characters, or \"data\""},
        {"{\"index\":8192,\"value\":true}",
         "\"write\" takes \"value\", a number or a text of at most 200 characters, or \"data\""},
        {"{\"value\":1}", "a request to an object has {\"index\":...,\"sub\":...}"},
    };
    wire_t w;
    (void)state;
    testdev_t *device = open_device(&w);
    device->u32 = 99;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_string_equal(answer(&w, rows[i].request, true), rows[i].want);
    assert_int_equal(device->u32, 99);
    device->write_answer = 0x06090030;
    assert_string_equal(answer(&w, "{\"index\":8192,\"value\":1}", true),
                        "2000h:0: SDO abort 0x06090030: the value is out of range");
    device->write_answer = 0x12345678;
    assert_string_equal(answer(&w, "{\"index\":8192,\"value\":1}", true), "2000h:0: SDO abort 0x12345678");
    wire_close(&w);
}

/* The master's upload of 1000 bytes requires several mails. */
static void a_transfer_of_the_master(void **state)
{
    static const uint8_t begin[] = {0x00, 0x20, 0x40, 0x02, 0x20, 0, 0, 0, 0, 0};
    static const uint8_t abort[] = {0x00, 0x20, 0x80, 0x02, 0x20, 0, 0, 0, 0, 8};
    uint8_t reply[256];
    wire_t w;
    (void)state;
    (void)open_device(&w);
    assert_true(wire_coe(&w, 0, begin, sizeof begin, reply, sizeof reply) > 0);
    assert_string_equal(answer(&w, "{\"index\":8192}", false), "slave 1: a master transfers an object: try again");
    assert_string_equal(answer(&w, "{\"index\":8192,\"value\":1}", true),
                        "slave 1: a master transfers an object: try again");
    (void)wire_coe(&w, 0, abort, sizeof abort, reply, sizeof reply);
    assert_string_equal(answer(&w, "{\"index\":8192,\"value\":1}", true), "");
    wire_close(&w);
}

static void by_the_socket(void **state)
{
    static const row_t rows[] = {
        {"{\"op\":\"objects\",\"index\":4120,\"sub\":4}\n",
         "{\"slave\":1,\"index\":4120,\"sub\":4,\"object\":\"Identity\",\"name\":\"Serial number\",\"type\":"
         "\"UNSIGNED32\",\"bits\":32,\"access\":\"ro\"}\n"},
        {"{\"op\":\"objects\",\"index\":24688}\n", "\"index\":24689,\"sub\":0"},
        {"{\"op\":\"objects\",\"index\":65535}\n", OK},
        {"{\"op\":\"objects\",\"index\":-1}\n", "slave 1: \\\"index\\\" is a number from 0 to 65535"},
        {"{\"op\":\"write\",\"slave\":2,\"index\":24705,\"value\":123}\n", OK},
        {"{\"op\":\"read\",\"slave\":2,\"index\":24705}\n", "\"data\":\"7b000000\",\"value\":123}\n" OK},
        {"{\"op\":\"write\",\"slave\":2,\"index\":4096,\"value\":1}\n",
         "{\"ok\":false,\"message\":\"1000h:0: SDO abort 0x06010002: the object is read-only\"}\n"},
        {"{\"op\":\"write\",\"slave\":3,\"index\":4096,\"value\":1}\n", "there is no such slave in this chain"},
        {"{\"op\":\"read\",\"slave\":0,\"index\":4096}\n", "there is no such slave in this chain"},
        {"{\"op\":\"fault\",\"fault\":\"hang slave 2\"}\n", OK},
        {"{\"op\":\"read\",\"slave\":2,\"index\":4096}\n", "slave 2: its microcontroller hangs: 'resume' continues it"},
    };
    static ect_scenario_t scenario;
    static const ect_stats_t stats;
    bench_t b;
    (void)state;
    open_bench(&b, "pmctendo-dd5", 2);
    ect_control_show(b.control, &stats, &scenario);
    wire_configure_mailbox(&b.wire, 1);
    wire_go(&b.wire, 1, ECT_STATE_PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_part(&b, rows[i].request, rows[i].want);
    close_bench(&b);
}

/* All entries of all objects, without a socket. */
static void the_whole_list(void **state)
{
    ect_object_place_t place = {0};
    ect_line_t line;
    wire_t w;
    (void)state;
    (void)open_device(&w);
    const ect_od_t *od = ect_slave_dictionary(ect_chain_slave(w.chain, 0));
    for (size_t i = 0; i < od->count; i++) {
        for (const ect_entry_t *e = od->objects[i].entries; e; e = ect_od_next(&od->objects[i], e)) {
            assert_true(ect_objects_next(od, 1, &place, &line));
            assert_int_equal(place.index, od->objects[i].index);
            assert_int_equal(place.subindex, e->subindex + 1u);
        }
    }
    assert_false(ect_objects_next(od, 1, &place, &line));
    wire_close(&w);
}

static void no_dictionary(void **state)
{
    const char *why;
    wire_t w;
    (void)state;
    wire_open_one(&w, &terminal);
    assert_null(ect_chain_sdo(w.chain, 0, &why));
    assert_string_equal(why, "its device has no object dictionary");
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A written value of each type is read back", written_values, NULL, NULL, NULL},
        {"The bytes of each type are written as a value of the type", values_of_each_type, NULL, NULL, NULL},
        {"A reply contains the first part of a long value, and its size", long_values, NULL, NULL, NULL},
        {"A refused read has the text of its abort code", refused_reads, NULL, NULL, NULL},
        {"A refused write has the text of its abort code, and changes no value", refused_writes, NULL, NULL, NULL},
        {"During a transfer of the master, read and write are refused", a_transfer_of_the_master, NULL, NULL, NULL},
        {"The list contains each entry once, in order", the_whole_list, NULL, NULL, NULL},
        {"A device without SDO has no dictionary", no_dictionary, NULL, NULL, NULL},
        {"The control socket lists, reads and writes objects", by_the_socket, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket: objects", tests, NULL, NULL);
}
