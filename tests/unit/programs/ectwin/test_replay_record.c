/* SPDX-License-Identifier: MIT */
/* `ectwin replay FILE` with the file of a --record, as printed. A line of a row is an item of the record:
 *
 *     5 BRD 0 0130 0000 = 0100#1       a request at 5 ms: command, ADP, ADO, data; and its reply: data and working
 * counter 5 BRD 0 0130 0000                a request 7 = 0100#1                       a reply to the last request, at 7
 * ms x1 5 BRD ...                     the same at the second interface RUN 0 5, TOUCH 0 5, ...          a local block:
 * kind, value, time in ms; then a text
 *
 * DATA~N: DATA, and bytes of 0 up to N. The record starts at 0 ms; its bus is one fzm1 unless a START is the first
 * line.
 */
#define _GNU_SOURCE
#include "command_lines.h"

#include "bus/capture/logged.h"
#include "bus/capture/pcapng.h"
#include "support/hex.h"
#include "support/wire.h"

enum { HEADS = 16, LINE = 600 };

#define ZERO_NS 1000000000u

typedef struct record {
    FILE *file;
    wire_t request;
    uint16_t length; /* of its data */
} record_t;

static void put(record_t *r, const uint8_t *block, size_t size)
{
    assert_int_equal(fwrite(block, 1, size, r->file), size);
}

static void put_packet(record_t *r, uint32_t interface, bool reply, uint64_t ms, const uint8_t *frame, size_t length)
{
    uint8_t block[ECT_PCAPNG_ROOM];
    const ect_pcapng_packet_t packet = {.interface = interface,
                                        .direction = reply ? ECT_PCAPNG_OUTBOUND : ECT_PCAPNG_INBOUND,
                                        .time_ns = ZERO_NS + ms * MS,
                                        .frame = frame,
                                        .captured = (uint32_t)length,
                                        .length = (uint32_t)length};
    put(r, block, ect_pcapng_packet(block, &packet));
}

/* "0100~4#1" @return the number of bytes; *counter changes if there is one */
static uint16_t take_bytes(const char *word, uint8_t *bytes, uint16_t *counter)
{
    char digits[LINE] = "";
    const size_t count = strcspn(word, "~# ");
    memcpy(digits, word, count);
    memset(bytes, 0, ECT_ESC_MAX_FRAME);
    uint16_t length = from_hex(digits, bytes);
    if (word[count] == '~')
        length = (uint16_t)strtoul(word + count + 1, NULL, 10);
    if (strchr(word, '#'))
        *counter = (uint16_t)strtoul(strchr(word, '#') + 1, NULL, 10);
    return length;
}

static uint8_t command_of(const char *word)
{
    static const char *const names[] = {"NOP", "APRD", "APWR", "APRW", "FPRD", "FPWR", "FPRW", "BRD"};
    for (uint8_t n = 0; n < sizeof names / sizeof names[0]; n++) {
        if (strcmp(word, names[n]) == 0)
            return n;
    }
    fail_msg("'%s' is no command", word);
    return 0;
}

static void put_reply(record_t *r, uint32_t interface, uint64_t ms, const char *data)
{
    wire_t reply = r->request;
    uint8_t bytes[ECT_ESC_MAX_FRAME];
    uint16_t counter = 0;
    const uint16_t length = take_bytes(data, bytes, &counter);
    assert_int_equal(length, r->length);
    reply.frame[6] |= 2;
    if (reply.frame[HEADS] < FPRD || reply.frame[HEADS] == BRD)
        reply.frame[HEADS + 2]++;
    memcpy(reply.frame + HEADS + 10, bytes, length);
    ect_store_le16(reply.frame + HEADS + 10 + length, counter);
    put_packet(r, interface, true, ms, reply.frame, reply.frame_length);
}

static void put_frames(record_t *r, uint32_t interface, const char *line)
{
    char command[8], digits[LINE];
    unsigned int ms, adp, ado;
    const char *reply = strstr(line, "= ");
    if (sscanf(line, "%u %7[A-Z] %x %x %599s", &ms, command, &adp, &ado, digits) == 5) {
        uint8_t bytes[ECT_ESC_MAX_FRAME];
        r->length = take_bytes(digits, bytes, &(uint16_t){0});
        wire_build(&r->request, command_of(command), (uint16_t)adp, (uint16_t)ado, bytes, r->length);
        put_packet(r, interface, false, ms, r->request.frame, r->request.frame_length);
    }
    if (reply)
        put_reply(r, interface, strtoul(line, NULL, 10), reply + 2);
}

static void put_local(record_t *r, const char *line)
{
    static const struct {
        const char *name;
        ect_logged_kind_t kind;
    } kinds[] = {{"START", ECT_LOGGED_START}, {"RUN", ECT_LOGGED_RUN},         {"CLOCK", ECT_LOGGED_CLOCK},
                 {"TOUCH", ECT_LOGGED_TOUCH}, {"REQUEST", ECT_LOGGED_REQUEST}, {"LINK", ECT_LOGGED_LINK},
                 {"POWER", ECT_LOGGED_POWER}, {"LOST", ECT_LOGGED_LOST},       {"FLUSH", ECT_LOGGED_FLUSH}};
    char name[8] = "", text[LINE] = "";
    unsigned int value = 0, ms = 0;
    uint8_t body[ECT_LOGGED_HEAD + LINE], block[ECT_PCAPNG_ROOM];
    assert_true(sscanf(line, "%7[A-Z] %u %u %599[^\n]", name, &value, &ms, text) >= 1);
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(kinds[i].name, name) != 0)
            continue;
        ect_logged_head(body, kinds[i].kind, value, ms > 0 ? ZERO_NS + ms * MS : 0);
        memcpy(body + ECT_LOGGED_HEAD, text, strlen(text));
        put(r, block, ect_pcapng_local(block, body, ECT_LOGGED_HEAD + strlen(text)));
        return;
    }
    fail_msg("'%s' is no item", line);
}

/* Times in the file are those of the bus, and the offset of the start. */
static void write_record(const char *lines)
{
    record_t r = {.file = fopen("r.pcapng", "wb")};
    uint8_t block[ECT_PCAPNG_ROOM];
    assert_non_null(r.file);
    put(&r, block, ect_pcapng_section(block, NULL));
    put(&r, block, ect_pcapng_interface(block, "in"));
    put(&r, block, ect_pcapng_interface(block, "out"));
    if (strncmp(lines, "START", 5) != 0)
        put_local(&r, "START 0 0 {\"words\":[\"fzm1\"],\"version\":\"" ECTWIN_VERSION "\",\"offset\":\"0\"}");
    char *copy = strdup(lines), *rest = copy;
    for (char *line; (line = strsep(&rest, "\n")) != NULL;) {
        if (*line >= 'A' && *line <= 'Z')
            put_local(&r, line);
        else
            put_frames(&r, *line == 'x' ? (uint32_t)(line[1] - '0') : 0, *line == 'x' ? line + 3 : line);
    }
    free(copy);
    fclose(r.file);
}

typedef struct row {
    const char *lines;
    int status;
    const char *text;
} row_t;

static void replay(const row_t *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        write_record(rows[i].lines);
        command_expect(&(command_line_t){.line = "replay r.pcapng", .status = rows[i].status, .text = rows[i].text},
                       NULL, 0);
        (void)unlink("r.pcapng");
    }
}

#define REPLAY(rows) replay(rows, sizeof(rows) / sizeof(rows)[0])
#define EQUAL(frames, replies, seconds)                                                                                \
    0, "r.pcapng: " #frames " frames and " #replies " replies in " seconds " s of the bus: all equal\n"
#define STATION "1 APWR 0 0010 0110 = 0110#1\n"

static void equal_replies(void **state)
{
    static const row_t rows[] = {
        {"1 BRD 0 0130 0000 = 0100#1", EQUAL(1, 1, "0.000")},
        {"1 BRD 0 0130 0000 = 0100#1\n6 BRD 0 0130 0000 = 0100#1\n1506 BRD 0 0130 0000 = 0100#1", EQUAL(3, 3, "1.505")},
        {"6 BRD 0 0130 0000 = 0100#1\n1 BRD 0 0130 0000 = 0100#1\n8 BRD 0 0130 0000 = 0100#1", EQUAL(3, 3, "0.002")},
        {STATION "2 FPRD 1001 0010 0000 = 0110#1\n3 FPRD 1002 0010 0000 = 0000#0", EQUAL(3, 3, "0.002")},
    };
    (void)state;
    REPLAY(rows);
}

static void differences(void **state)
{
    static const row_t rows[] = {
        {"1 BRD 0 0130 0000 = 0200#1", 1,
         "r.pcapng: frame 2, 0.000000000 s after the first: the reply differs\n  datagram 1 of 1, all slaves\n  "
         "request  BRD 0000:0130 AL status, 2 bytes\n  expected BRD 0001:0130 AL status, 2 bytes, WKC 1: 02 00 | "
         "PREOP\n  got      BRD 0001:0130 AL status, 2 bytes, WKC 1: 01 00 | INIT\n"},
        {"1 BRD 0 0130 0000 = 0100#1\n6 BRD 0 0130 0000 = 0100#2", 1,
         "r.pcapng: frame 4, 0.005000000 s after the first: the reply differs\n  datagram 1 of 1, all slaves\n  "
         "request  BRD 0000:0130 AL status, 2 bytes\n  expected BRD 0001:0130 AL status, 2 bytes, WKC 2: 01 00 | "
         "INIT\n  got      BRD 0001:0130 AL status, 2 bytes, WKC 1: 01 00 | INIT\n"},
        {STATION "2 FPRD 1001 0130 0000 = 0200#1", 1,
         "r.pcapng: frame 4, 0.001000000 s after the first: the reply differs\n  datagram 1 of 1, slave 1\n  request  "
         "FPRD 1001:0130 AL status, 2 bytes\n  expected FPRD 1001:0130 AL status, 2 bytes, WKC 1: 02 00 | PREOP\n  got "
         "     FPRD 1001:0130 AL status, 2 bytes, WKC 1: 01 00 | INIT\n"},
        {STATION "2 FPRD 1002 0130 0000 = 0000#1", 1,
         "r.pcapng: frame 4, 0.001000000 s after the first: the reply differs\n  datagram 1 of 1, no slave\n  request  "
         "FPRD 1002:0130 AL status, 2 bytes\n  expected FPRD 1002:0130 AL status, 2 bytes, WKC 1: 00 00 | state 0\n  "
         "got      FPRD 1002:0130 AL status, 2 bytes, WKC 0\n"},
        {"1 BRD 0 0130 0000\n2 BRD 0 0132 0000 = 0100#1", 1,
         "r.pcapng: frame 1, 0.000000000 s after the first: a reply of the twins is not in the record\n  got 30 bytes: "
         "BRD 0001:0130 AL status, 2 bytes, WKC 1: 01 00 | INIT\n"},
        {"1 BRD 0 0130 0000 = 0100#1\n3 = 0100#1", 1,
         "r.pcapng: frame 3, 0.002000000 s after the first: the twins do not reply\n  expected 30 bytes: BRD 0001:0130 "
         "AL status, 2 bytes, WKC 1: 01 00 | INIT\n"},
        {"1 BRD 0 0130 0000 = 0100#1\n2 BRD 0 0130 0000", EQUAL(2, 1, "0.001")},
        {STATION "2 FPWR 1001 0800 0010800026000100 = 0010800026000100#1\n3 FPWR 1001 0808 8010800022000100 = "
                 "8010800022000100#1\n4 FPWR 1001 0120 0200 = 0200#1\nRUN 0 4\n"
                 "5 FPWR 1001 1000 0A00000000130020400010~128 = 0A00000000130020400010~128#0",
         1,
         "r.pcapng: frame 10, 0.004000000 s after the first: the reply differs\n  datagram 1 of 1, slave 1\n  request  "
         "FPWR 1001:1000 mailbox out, 128 bytes | mail of 10 bytes, counter 1: CoE SDO request upload 1000h:00 | 0A 00 "
         "00 00 00 13 00 20 40 00 10 00 00 00 00 00\n  expected FPWR 1001:1000 mailbox out, 128 bytes, WKC 0\n  got    "
         "  FPWR 1001:1000 mailbox out, 128 bytes, WKC 1\n"},
    };
    (void)state;
    REPLAY(rows);
}

/* Both ends of the chain; a cable is in the input at the start. */
static void cables(void **state)
{
    static const row_t rows[] = {
        {"LINK 0 0\n1 BRD 0 0130 0000\n2 BRD 0 0130 0000", EQUAL(2, 0, "0.001")},
        {"LINK 0 0\nLINK 256 0\n1 BRD 0 0130 0000 = 0100#1", EQUAL(1, 1, "0.000")},
        {"LINK 257 0\n1 BRD 0 0130 0000\nx1 2 = 0100#1", EQUAL(1, 1, "0.000")},
        {"LINK 2 0\n1 BRD 0 0130 0000 = 0100#1", EQUAL(1, 1, "0.000")},
        {"x2 1 BRD 0 0130 0000", 2,
         "ectwin replay: 'r.pcapng': a packet of interface 2, which the file does not describe, at byte 188\n"},
    };
    (void)state;
    REPLAY(rows);
}

static void local_blocks(void **state)
{
    static const row_t rows[] = {
        /* a power cycle clears the station address */
        {STATION "TOUCH 0 2\nPOWER\n3 FPRD 1001 0010 0000 = 0000#0", EQUAL(2, 2, "0.002")},
        {"TOUCH 0 1\nREQUEST 0 0 {\"op\":\"fault\",\"fault\":\"drop 100%\"}\n2 BRD 0 0130 0000\n3 BRD 0 0130 0000",
         EQUAL(2, 0, "0.001")},
        {"1 BRD 0 0130 0000 = 0100#1\nLOST 0 0", 0,
         "r.pcapng: the record ends early: its disk was too slow\nr.pcapng: 1 frames and 1 replies in 0.000 s of the "
         "bus: all equal\n"},
        {"1 BRD 0 0130 0000 = 0100#1\nFLUSH 0 0\nRUN 1 2\nRUN 0 3\nCLOCK 0 3", EQUAL(1, 1, "0.000")},
        {"1 BRD 0 0130 0000 = 0100#1\nFLUSH 0 0\nCLOCK 0 1", 2,
         "ectwin replay: 'r.pcapng': a clock reading or a start in the wrong place\n"},
        {"1 BRD 0 0130 0000 = 0100#1\nREQUEST 0 0 {\"op\":\"get\"}", 2,
         "ectwin replay: 'r.pcapng': an invalid request: {\"op\":\"get\"}\n"},
        {"1 BRD 0 0130 0000 = 0100#1\nREQUEST 0 0 "
         "{\"op\":\"a_text_of_more_than_sixty_characters_that_is_cut_at_this_end\"}",
         2,
         "ectwin replay: 'r.pcapng': an invalid request: "
         "{\"op\":\"a_text_of_more_than_sixty_characters_that_is_cut_at_t\n"},
        /* a step of a script at its time */
        {"TOUCH 0 1\nREQUEST 0 0 {\"op\":\"fault\",\"fault\":\"delay 5000us\"}\nRUN 0 1\n2 BRD 0 0130 0000\nRUN 0 6\n"
         "RUN 0 7\n7 = 0100#1",
         EQUAL(1, 1, "0.000")},
    };
    (void)state;
    REPLAY(rows);
}

static void starts(void **state)
{
    static const row_t rows[] = {
        {"START 0 0 {\"words\":[\"fzm1\"],\"version\":\"0.0.9\",\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1", 0,
         "r.pcapng: recorded by ectwin 0.0.9, replayed by ectwin 0.2.0\nr.pcapng: 1 frames and 1 replies in 0.000 s of "
         "the bus: all equal\n"},
        /* times of the file less the offset are times of the bus */
        {"START 0 0 {\"words\":[\"--fault\",\"at 0.005s drop 100%\",\"fzm1\"],\"version\":\"" ECTWIN_VERSION
         "\",\"offset\":\"1000000000\"}\n4 BRD 0 0130 0000 = 0100#1\nRUN 0 6\n6 BRD 0 0130 0000",
         EQUAL(2, 1, "0.002")},
        {"START 0 0 {\"words\":[\"fzm1\"],\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1", 2,
         "ectwin replay: 'r.pcapng': an invalid start\n"},
        {"START 0 0 {\"words\":[\"fzm1\"],\"version\":\"1\"}\n1 BRD 0 0130 0000 = 0100#1", 2,
         "ectwin replay: 'r.pcapng': an invalid start\n"},
        {"START 0 0 {\"version\":\"1\",\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1", 2,
         "ectwin replay: 'r.pcapng': an invalid start\n"},
        {"START 0 0 {\"words\":\"fzm1\",\"version\":\"1\",\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1", 2,
         "ectwin replay: 'r.pcapng': an invalid start\n"},
        {"START 0 0 {\"words\":[],\"version\":\"1\",\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1", 2,
         "ectwin replay: 'r.pcapng': an invalid start\n"},
        /* options of `ectwin run` and of `ectwin with` have no effect */
        {"START 0 0 {\"words\":[\"-i\",\"a\",\"fzm1\",\"-o\",\"b\"],\"version\":\"" ECTWIN_VERSION
         "\",\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1",
         EQUAL(1, 1, "0.000")},
        {"START 0 0 {\"words\":[\"--output\",\"b\",\"--in-process\",\"fzm1\"],\"version\":\"" ECTWIN_VERSION
         "\",\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1",
         EQUAL(1, 1, "0.000")},
        /* one line about wrong words, without that about the usage */
        {"START 0 0 {\"words\":[\"--set\",\"data1\",\"fzm1\"],\"version\":\"" ECTWIN_VERSION "\",\"offset\":\"0\"}", 2,
         "ectwin replay: --set takes NAME=VALUE, not 'data1'\n"},
        {"START 0 0 {\"words\":[\"--set\",\"a\\nb\\nc\",\"fzm1\"],\"version\":\"" ECTWIN_VERSION "\",\"offset\":\"0\"}",
         2, "ectwin replay: --set takes NAME=VALUE, not 'a\n"},
        {"START 0 0 {\"words\":[\"--nosuch\",\"fzm1\"],\"version\":\"" ECTWIN_VERSION "\",\"offset\":\"0\"}", 2,
         "ectwin replay: unrecognized option '--nosuch'\n"},
        {"START 0 0 {\"words\":[\"fzm1\",7],\"version\":\"1\",\"offset\":\"0\"}\n1 BRD 0 0130 0000 = 0100#1", 2,
         "ectwin replay: 'r.pcapng': an invalid start\n"},
    };
    (void)state;
    REPLAY(rows);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("replies that equal those of the record are counted, and the time of the bus", equal_replies),
        TEST("the first difference is printed: frame, time, datagram, slave, both replies", differences),
        TEST("frames enter at the end of their interface, if it has a cable", cables),
        TEST("changes, times and clock readings of the record come again", local_blocks),
        TEST("a start has words, version and offset", starts),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Replay of a record", tests, commands_begin, commands_end);
}
