/* SPDX-License-Identifier: MIT */
/* `ectwin replay CAPTURE DEVICE`: the differences between a capture of a bus and twins, as printed.
 *
 * A line of a row is a frame, one millisecond after the frame before it:
 *
 *     FPRD 1001 0130 0000 & BRD 0 0130 0000    a request: command, ADP (with LRD, LWR, LRW the logical address), ADO
 * (0), data = 0100#1 & 0800#1                        its reply: data and working counter of each datagram =i5 0100#1 a
 * reply with another index =s01 0100#1, =sFE 0100#1                 a reply with this first byte of the source address,
 * in place of 02
 *     =-2 0100#1                               a reply without its last 2 bytes
 *     x FPRD 1001 0130 0000                    a frame of another protocol
 *     c FPRD 1001 0130 0000                    a frame that the capture has cut
 *     m FPRD 1001 0130 0000                    a frame that announces a byte more than it has
 *     +500                                     500 ms without a frame
 *
 * DATA~N: DATA, and bytes of 0 up to N.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "commands.h"
#include "replay_file.h"
#include "support/hex.h"
#include "support/wire.h"

enum { HEADS = 16, OUTPUT = 8192, LINE = 512, COUNTER = 2, MOST = 24 };

/* --- a capture ---------------------------------------------------------------------------------------------------- */

typedef struct capture {
    FILE *file;
    uint64_t us;
    uint8_t index;
    wire_t request;      /* the last request */
    size_t length[MOST]; /* bytes of its datagrams */
} capture_t;

static uint8_t command_of(const char *word)
{
    static const char *const names[] = {"NOP", "APRD", "APWR", "APRW", "FPRD", "FPWR", "FPRW", "BRD",
                                        "BWR", "BRW",  "LRD",  "LWR",  "LRW",  "ARMW", "FRMW"};
    uint8_t n = 0;
    while (n < sizeof names / sizeof names[0] && strcmp(word, names[n]) != 0)
        n++;
    assert_in_range(n, 0, FRMW);
    return n;
}

static void put32(FILE *file, uint32_t value)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    assert_int_equal(fwrite(bytes, 1, sizeof bytes, file), sizeof bytes);
}

static void put_frame(capture_t *c, const uint8_t *frame, size_t length, size_t cut)
{
    c->us += 1000;
    put32(c->file, (uint32_t)(c->us / 1000000));
    put32(c->file, (uint32_t)(c->us % 1000000));
    put32(c->file, (uint32_t)(length - cut));
    put32(c->file, (uint32_t)length);
    assert_int_equal(fwrite(frame, 1, length - cut, c->file), length - cut);
}

/* @return the number of bytes of "0100~4" */
static uint16_t bytes_of(const char *word, uint8_t bytes[ECT_ESC_MAX_FRAME])
{
    char digits[LINE] = "";
    const char *more = strchr(word, '~');
    memcpy(digits, word, more ? (size_t)(more - word) : strlen(word));
    memset(bytes, 0, ECT_ESC_MAX_FRAME);
    const uint16_t length = from_hex(digits, bytes);
    return more ? (uint16_t)strtoul(more + 1, NULL, 10) : length;
}

/* "FPRD 1001 0130 0000 & ..." */
static void build_request(capture_t *c, char *line)
{
    wire_t *w = &c->request;
    char *rest = line;
    size_t n = 0;
    for (char *one; (one = strsep(&rest, "&")) != NULL;) {
        uint8_t data[ECT_ESC_MAX_FRAME];
        char command[8] = "", digits[LINE] = "";
        unsigned int adp = 0, ado = 0;
        assert_true(sscanf(one, "%7s %x %x %511[0-9A-F~]", command, &adp, &ado, digits) >= 3);
        const uint8_t code = command_of(command);
        if (code >= LRD && code <= LRW)
            ado = adp >> 16;
        const uint16_t length = bytes_of(digits, data);
        assert_true(n < MOST);
        c->length[n] = length;
        if (n++ == 0)
            wire_build(w, code, (uint16_t)adp, (uint16_t)ado, data, length);
        else
            wire_append(w, code, (uint16_t)adp, (uint16_t)ado, data, length);
    }
    memset(w->frame, 0xFF, 6);
    memset(w->frame + 6, 0, 6);
    w->frame[HEADS + 1] = ++c->index;
}

static void put_request(capture_t *c, char *line)
{
    wire_t *w = &c->request;
    const char kind = *line;
    build_request(c, line + (kind == 'x' || kind == 'c' || kind == 'm'));
    if (kind == 'x')
        w->frame[12] = 0x08;
    if (kind == 'm')
        w->frame[HEADS + 6]++;
    put_frame(c, w->frame, w->frame_length, kind == 'c');
}

/* Whether each slave increments the ADP of a datagram. */
static bool is_incremented(uint8_t command)
{
    return (command >= APRD && command <= APRW) || (command >= BRD && command <= BRW) || command == ARMW;
}

/* "= 0100#1 & 0800#1" */
static void put_reply(capture_t *c, char *line)
{
    wire_t reply = c->request;
    size_t at = HEADS, cut = 0, n = 0;
    reply.frame[6] = 2;
    if (line[1] == 'i')
        reply.frame[HEADS + 1] = (uint8_t)strtoul(line + 2, NULL, 10);
    if (line[1] == 's')
        reply.frame[6] = (uint8_t)strtoul(line + 2, NULL, 16);
    if (line[1] == '-')
        cut = strtoul(line + 2, NULL, 10);
    char *rest = line + strcspn(line, " ");
    for (char *one; (one = strsep(&rest, "&")) != NULL;) {
        char *counter = strchr(one, '#');
        assert_non_null(counter);
        *counter++ = '\0';
        one += strspn(one, " ");
        one[strcspn(one, " ")] = '\0';
        uint8_t data[ECT_ESC_MAX_FRAME];
        const size_t length = bytes_of(one, data);
        assert_true(n < MOST && length <= c->length[n++] + 1);
        memcpy(reply.frame + at + 10, data, length);
        ect_store_le16(reply.frame + at + 10 + length, (uint16_t)strtoul(counter, NULL, 10));
        if (is_incremented(reply.frame[at]))
            reply.frame[at + 2]++;
        at += 10 + length + COUNTER;
    }
    put_frame(c, reply.frame, reply.frame_length - cut, 0);
}

static void write_capture(const char *path, const char *lines)
{
    capture_t c = {.file = fopen(path, "wb")};
    char *copy = strdup(lines), *rest = copy;
    assert_non_null(c.file);
    put32(c.file, 0xA1B2C3D4);
    put32(c.file, 4u << 16 | 2u);
    put32(c.file, 0);
    put32(c.file, 0);
    put32(c.file, 65535);
    put32(c.file, 1); /* Ethernet */
    for (char *line; (line = strsep(&rest, "\n")) != NULL;) {
        if (*line == '+')
            c.us += 1000 * strtoull(line + 1, NULL, 10);
        else if (*line == '=')
            put_reply(&c, line);
        else if (*line != '\0')
            put_request(&c, line);
    }
    free(copy);
    assert_int_equal(fclose(c.file), 0);
}

/* --- the command -------------------------------------------------------------------------------------------------- */

/* Runs the command. @return its exit status, and its output without the name of the file */
static int replay(const char *lines, const char *option, const char *devices, char output[OUTPUT])
{
    char path[] = "/tmp/ectwin-replay-XXXXXX", name[] = "ectwin replay", given[32], list[256];
    const int file = mkstemp(path), memory = memfd_create("output", MFD_CLOEXEC), before = dup(STDOUT_FILENO);
    assert_true(file >= 0 && memory >= 0 && before >= 0);
    close(file);
    write_capture(path, lines);
    snprintf(given, sizeof given, "%s", option);
    snprintf(list, sizeof list, "%s", devices);
    char *words[] = {name, path, list, *option ? given : NULL, NULL};
    fflush(stdout);
    assert_true(dup2(memory, STDOUT_FILENO) >= 0);
    const int status = command_replay(*option ? 4 : 3, words);
    fflush(stdout);
    assert_true(dup2(before, STDOUT_FILENO) >= 0);
    close(before);
    const ssize_t size = pread(memory, output, OUTPUT - 1, 0);
    assert_true(size >= 0);
    output[size] = '\0';
    close(memory);
    unlink(path);
    for (char *at; (at = strstr(output, path)) != NULL;)
        memmove(at, at + strlen(path), strlen(at + strlen(path)) + 1);
    return status;
}

typedef struct row {
    const char *lines, *output;
} row_t;

static void compare(const row_t *rows, size_t count, const char *option, const char *devices)
{
    for (size_t i = 0; i < count; i++) {
        char output[OUTPUT];
        const int status = replay(rows[i].lines, option, devices, output);
        if (strcmp(output, rows[i].output) != 0)
            print_error("row %zu:\n%s\n", i, rows[i].lines);
        assert_string_equal(output, rows[i].output);
        assert_int_equal(status, strstr(output, ": 0 differences") ? 0 : 1);
    }
}

#define COMPARE(rows, option, devices) compare(rows, sizeof(rows) / sizeof(rows)[0], option, devices)
#define STATION                        "APWR 0 0010 0110\n= 0110#1\n"
#define PREOP                                                                                                          \
    STATION "FPWR 1001 0800 0010800026000100\n= 0010800026000100#1\nFPWR 1001 0808 8010800022000100\n"                 \
            "= 8010800022000100#1\nFPWR 1001 0120 0200\n= 0200#1\n"
#define UPLOAD       "FPWR 1001 1000 0A00000000130020400010~128\n= ~128#1\n" /* 1000:00 */
#define TWO_STATIONS STATION "APWR FFFF 0010 0210\n= 0210#1\n"

/* --- rows --------------------------------------------------------------------------------------------------------- */

static void a_working_counter_that_differs_is_printed_with_the_addressed_slaves(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {"BRD 0 0130 0000\n= 0100#2", ": 1 frames and 1 replies in 0.000 s of the bus: 0 differences\n"},
        {"BRD 0 0130 0000 & BRD 0 0130 0000\n= 0100#2 & 0100#3",
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 3, twin 2\n"
         ": 1 frames and 1 replies in 0.000 s of the bus: 1 differences\n"},
        {"BRD 0 0130 0000 & BRD 0 0130 0000 & BRD 0 0130 0000\n= 0100#2 & 0100#3 & 0100#1",
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 3, twin 2\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 1, twin 2\n"
         ": 1 frames and 1 replies in 0.000 s of the bus: 2 differences\n"},
        {"BRD 0 0130 0000\n= 0100#256",
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 256, twin 2\n"
         ": 1 frames and 1 replies in 0.000 s of the bus: 1 differences\n"},
        {TWO_STATIONS "FPRD 1001 0600 00\n= 00#2\nFPRD 1002 0600 00\n= 00#2\nFPRD 1003 0600 00\n= 00#2",
         "  frame 6, FPRD 1001:0600 FMMU0, slave 1: working counter: bus 2, twin 1\n"
         "  frame 8, FPRD 1002:0600 FMMU0, slave 2: working counter: bus 2, twin 1\n"
         "  frame 10, FPRD 1003:0600 FMMU0, no slave: working counter: bus 2, twin 0\n"
         ": 5 frames and 5 replies in 0.008 s of the bus: 3 differences\n"},
        {"APRD 0 0600 00\n= 00#2\nAPRD FFFF 0600 00\n= 00#2\nAPRD 1 0600 00\n= 00#2",
         "  frame 2, APRD 0000:0600 FMMU0, slave 1: working counter: bus 2, twin 1\n"
         "  frame 4, APRD FFFF:0600 FMMU0, slave 2: working counter: bus 2, twin 1\n"
         "  frame 6, APRD 0001:0600 FMMU0, no slave: working counter: bus 2, twin 0\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 3 differences\n"},
        {"APWR 0 0600 00\n= 00#2\nAPWR FFFF 0600 00\n= 00#2\nAPRW FFFF 0600 00\n= 00#2\nARMW FFFF 0910 00000000\n= "
         "00000000#0",
         "  frame 2, APWR 0000:0600 FMMU0, slave 1: working counter: bus 2, twin 1\n"
         "  frame 4, APWR FFFF:0600 FMMU0, slave 2: working counter: bus 2, twin 1\n"
         "  frame 6, APRW FFFF:0600 FMMU0, slave 2: working counter: bus 2, twin 3\n"
         "  frame 8, ARMW FFFF:0910 distributed clocks, slave 2: working counter: bus 0, twin 2\n"
         ": 4 frames and 4 replies in 0.006 s of the bus: 4 differences\n"},
        {TWO_STATIONS "FPWR 1001 0600 00\n= 00#2\nFPRW 1002 0600 00\n= 00#2\nFRMW 1002 0910 00000000\n= 00000000#0",
         "  frame 6, FPWR 1001:0600 FMMU0, slave 1: working counter: bus 2, twin 1\n"
         "  frame 8, FPRW 1002:0600 FMMU0, slave 2: working counter: bus 2, twin 3\n"
         "  frame 10, FRMW 1002:0910 distributed clocks, slave 2: working counter: bus 0, twin 2\n"
         ": 5 frames and 5 replies in 0.008 s of the bus: 3 differences\n"},
        {"BRW 0 0600 00\n= 00#0\nBWR 0 0600 00\n= 00#0\nNOP 0 0600 00\n= 00#1",
         "  frame 2, BRW 0000:0600 FMMU0, all slaves: working counter: bus 0, twin 6\n"
         "  frame 4, BWR 0000:0600 FMMU0, all slaves: working counter: bus 0, twin 2\n"
         "  frame 6, NOP 0000:0600 FMMU0, no slave: working counter: bus 1, twin 0\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 3 differences\n"},
        {"LRD 10000 0 0000\n= 0000#1\nLWR 10000 0 0000\n= 0000#1\nLRW 10000 0 0000\n= 0000#1",
         "  frame 2, LRD logical 0x00010000, no slave: working counter: bus 1, twin 0\n"
         "  frame 4, LWR logical 0x00010000, no slave: working counter: bus 1, twin 0\n"
         "  frame 6, LRW logical 0x00010000, no slave: working counter: bus 1, twin 0\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 3 differences\n"},
    };
    COMPARE(rows, "", "fzm1,fzm1");
}

static void a_reply_belongs_to_the_request_before_it(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {"x BRD 0 0130 0000\n= 0100#9", ": 0 frames and 0 replies in 0.000 s of the bus: 0 differences\n"},
        {"c BRD 0 0130 0000\n= 0100#9", ": 1 frames and 0 replies in 0.000 s of the bus: 0 differences\n"},
        {"BRD 0 0130 0000\n=i7 0100#9", ": 2 frames and 0 replies in 0.001 s of the bus: 0 differences\n"},
        {"BRD 0 0130 0000\n=s01 0100#9", ": 2 frames and 0 replies in 0.001 s of the bus: 0 differences\n"},
        {"BRD 0 0130 0000\n=sFE 0100#9",
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 9, twin 1\n"
         ": 1 frames and 1 replies in 0.000 s of the bus: 1 differences\n"},
        {"BRD 0 0130 0000\n=-1 0100#9", ": 2 frames and 0 replies in 0.001 s of the bus: 0 differences\n"},
        {"BRD 0 0130 0000\n= 0100#1\n= 0100#9", ": 2 frames and 1 replies in 0.002 s of the bus: 0 differences\n"},
        {"BRD 0 0130 0000\n+1500\nBRD 0 0130 0000\n= 0100#1",
         ": 2 frames and 1 replies in 1.501 s of the bus: 0 differences\n"},
        {"BRD 0 0130 0000\nBRD 0 0132 0000\n= 0100#9",
         "  frame 3, BRD 0000:0132 AL status, all slaves: working counter: bus 9, twin 1\n"
         ": 2 frames and 1 replies in 0.001 s of the bus: 1 differences\n"},
        {"BRD 0 1000 ~1972\n= ~1972#9", "  frame 2, BRD 0000:1000, all slaves: working counter: bus 9, twin 1\n"
                                        ": 1 frames and 1 replies in 0.000 s of the bus: 1 differences\n"},
        {"BRD 0 1000 ~1973\n= ~1973#9", ": 0 frames and 0 replies in 0.000 s of the bus: 0 differences\n"},
        {"m BRD 0 0130 0000\n= 010000#9", "  frame 2, BRD 0000:0130 AL status, all slaves: replies: bus 1, twin 0\n"
                                          ": 1 frames and 1 replies in 0.000 s of the bus: 1 differences\n"},
    };
    COMPARE(rows, "", "fzm1");
}

static void al_states_are_compared_in_the_order_of_their_reads(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {STATION "FPRD 1001 0130 00\n= 01#1\nFPRD 1001 0130 0000\n= 1100#1\nFPRD 1001 0130 00\n= 02#0",
         "  frame 8, FPRD 1001:0130 AL status, slave 1: working counter: bus 0, twin 1\n"
         "  frame 6, slave 1, AL state 2: bus INIT + error, twin nothing more\n"
         ": 4 frames and 4 replies in 0.006 s of the bus: 2 differences\n"},
        {STATION "FPRD 1001 0130 00\n= 01#1\nFPRD 1001 0130 00\n= 02#1",
         "  frame 6, slave 1, AL state 2: bus PREOP, twin nothing more\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 1 differences\n"},
        {STATION "FPRD 1001 0130 00\n= 01#1\nFPWR 1001 0120 0300\n= 0300#1\nFPRD 1001 0130 00\n= 01#1",
         "  frame 8, slave 1, AL state 2: bus nothing more, twin INIT + error\n"
         ": 4 frames and 4 replies in 0.006 s of the bus: 1 differences\n"},
        {STATION "FPRD 1001 0130 00\n= 01#1\nFPWR 1001 0120 0300\n= 0300#1\nFPRD 1001 0130 00\n= 13#1",
         "  frame 8, slave 1, AL state 2: bus BOOT + error, twin INIT + error\n"
         ": 4 frames and 4 replies in 0.006 s of the bus: 1 differences\n"},
        {STATION "FPRD 1001 0130 00\n= 01#1\nAPRD 0 0130 00\n= 01#1\nFPRD 1001 0130 00\n= 04#1",
         "  frame 8, slave 1, AL state 2: bus SAFEOP, twin nothing more\n"
         ": 4 frames and 4 replies in 0.006 s of the bus: 1 differences\n"},
        {STATION "FPRD 1001 0130 00\n= 01#1\nFPRD 1001 0130 00\n= 00#1",
         "  frame 6, slave 1, AL state 2: bus state 0, twin nothing more\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 1 differences\n"},
        {STATION "FPRD 1001 0130 00\n= 00#1", "  frame 4, slave 1, AL state 1: bus state 0, twin INIT\n"
                                              ": 2 frames and 2 replies in 0.002 s of the bus: 1 differences\n"},
        {STATION "FPRD 1001 0130 ~0\n= ~0#1\nBRD 0 0130 00\n= 04#1",
         "  frame 4, FPRD 1001:0130 AL status, slave 1: working counter: bus 1, twin 0\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 1 differences\n"},
    };
    COMPARE(rows, "", "fzm1");
}

static void devices_run_between_frames_as_long_as_on_the_bus(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {STATION "FPWR 1001 0120 0300\n= 0300#1\nFPRD 1001 0130 00\n= 01#1\n+95\nFPRD 1001 0130 00\n= 01#1\n",
         ": 4 frames and 4 replies in 0.101 s of the bus: 0 differences\n"},
        {STATION "FPWR 1001 0120 0300\n= 0300#1\nFPRD 1001 0130 00\n= 01#1\n+97\nFPRD 1001 0130 00\n= 01#1\n",
         "  frame 8, slave 1, AL state 2: bus nothing more, twin INIT + error\n"
         ": 4 frames and 4 replies in 0.103 s of the bus: 1 differences\n"},
        {STATION "FPWR 1001 0120 0300\n= 0300#1\nFPRD 1001 0130 00\n= 01#1\n+200\nFPRD 1001 0130 00\n= 11#1\n",
         ": 4 frames and 4 replies in 0.206 s of the bus: 0 differences\n"},
    };
    COMPARE(rows, "--al-delay=100", "fzm1");
}

static void mails_are_compared_by_header_and_service(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {PREOP "FPRD 1001 0130 00\n= 02#1\nFPRD 1001 080D 00\n= 08#1\nFPRD 1001 080C 00\n= 08#0",
         "  frame 14, FPRD 1001:080C SM1, slave 1: working counter: bus 0, twin 1\n"
         ": 7 frames and 7 replies in 0.012 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A00000000130030430010~128#1",
         ": 6 frames and 6 replies in 0.010 s of the bus: 0 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0BFF0000003300304300100005~128#1",
         ": 6 frames and 6 replies in 0.010 s of the bus: 0 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= ~128#0\nFPRD 1001 1080 ~128\n= 0A00000000130030430010~128#1",
         ": 7 frames and 7 replies in 0.012 s of the bus: 0 differences\n"},
        {PREOP UPLOAD
         "FPRD 1001 1080 ~128\n= 0A00000000130030430010~128#1\nFPRD 1001 1080 ~128\n= 0A00000000130030430010~128#1",
         "  frame 14, slave 1, mail 2: bus CoE service 3, 1000h:00, command 0x43, twin nothing more\n"
         ": 7 frames and 7 replies in 0.012 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A00000000130030430110~128#1",
         "  frame 12, slave 1, mail 1: bus CoE service 3, 1001h:00, command 0x43, twin CoE service 3, 1000h:00, "
         "command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A0000000013002043001005~128#1",
         "  frame 12, slave 1, mail 1: bus CoE service 2, 1000h:05, command 0x43, twin CoE service 3, 1000h:00, "
         "command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A00000000100030430010~128#1",
         "  frame 12, slave 1, mail 1: bus error mail, twin CoE service 3, 1000h:00, command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A00000000010030430010~128#1",
         "  frame 12, slave 1, mail 1: bus AoE mail, twin CoE service 3, 1000h:00, command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A00000000020030430010~128#1",
         "  frame 12, slave 1, mail 1: bus EoE mail, twin CoE service 3, 1000h:00, command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A00000000040030430010~128#1",
         "  frame 12, slave 1, mail 1: bus FoE mail, twin CoE service 3, 1000h:00, command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A00000000050030430010~128#1",
         "  frame 12, slave 1, mail 1: bus SoE mail, twin CoE service 3, 1000h:00, command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP UPLOAD "FPRD 1001 1080 ~128\n= 0A000000000F0030430010~128#1",
         "  frame 12, slave 1, mail 1: bus unknown mail, twin CoE service 3, 1000h:00, command 0x43\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP "FPRD 1001 1080 ~7\n= 00000000000301#1",
         "  frame 10, slave 1, mail 1: bus CoE service 0, 0000h:00, command 0x00, twin nothing more\n"
         ": 5 frames and 5 replies in 0.008 s of the bus: 1 differences\n"},
        {PREOP "FPWR 1001 080E 00\n= 00#1\nFPRD 1001 1080 ~7\n= ~7#0",
         "  frame 12, slave 1, mail 1: bus nothing more, twin error mail\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
        {PREOP "FPRD 1001 1080 ~6\n= 000000000003#1",
         "  frame 10, FPRD 1001:1080, slave 1: working counter: bus 1, twin 0\n"
         ": 5 frames and 5 replies in 0.008 s of the bus: 1 differences\n"},
        {PREOP "FPRD 1001 1081 ~7\n= 00000000000301#1",
         "  frame 10, FPRD 1001:1081, slave 1: working counter: bus 1, twin 0\n"
         ": 5 frames and 5 replies in 0.008 s of the bus: 1 differences\n"},
        {PREOP "FPRD 1001 1080 ~13\n= 0000000000030030430110~13#1\nFPRD 1001 1080 ~13\n= 000000000003003043011001FF#1",
         "  frame 10, slave 1, mail 1: bus CoE service 3, 1001h:00, command 0x43, twin nothing more\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 1 differences\n"},
    };
    COMPARE(rows, "", "fzm1");
}

static void eeprom_data_of_one_slave_are_compared(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {STATION "FPRD 1001 0508 00000000\n= 01000000#1\nFPRD 1001 0508 00000000\n= 00000002#1",
         "  frame 4, FPRD 1001:0508 SII, slave 1: byte 0 of the EEPROM data: bus 1, twin 0\n"
         "  frame 6, FPRD 1001:0508 SII, slave 1: byte 3 of the EEPROM data: bus 2, twin 0\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 2 differences\n"},
        {STATION "FPRD 1001 0508 00000000\n= 00000000#1\nFPRD 1001 0508 00000000\n= 01000000#2",
         "  frame 6, FPRD 1001:0508 SII, slave 1: working counter: bus 2, twin 1\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 1 differences\n"},
        {STATION "FPRD 1001 0509 00\n= 01#1\nFPRD 1002 0508 00\n= 01#0\nBRD 0 0508 00\n= 01#1",
         ": 4 frames and 4 replies in 0.006 s of the bus: 0 differences\n"},
    };
    COMPARE(rows, "", "fzm1");
}

static void eeprom_data_that_no_slave_has_read_are_not_compared(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {"APWR 0 0010 0110\n= 0110#0\nFPRD 1001 0508 00000000\n= 01000000#0",
         ": 2 frames and 2 replies in 0.002 s of the bus: 0 differences\n"},
    };
    COMPARE(rows, "--fault=counter -1", "fzm1");
}

#define FMMU                                                                                                           \
    STATION "FPWR 1001 0600 00000100020000070018000101000000\n= ~16#1\n"                                               \
            "FPWR 1001 1800 1234\n= 1234#1\n"

static void with_data_process_data_are_compared(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {FMMU "LRD 10000 0 0000\n= 1234#1\nLRD 10000 0 ~3\n= 123400#1\nLRD 10001 0 00\n= 34#1",
         ": 6 frames and 6 replies in 0.010 s of the bus: 0 differences\n"},
        {FMMU
         "LRD 10000 0 0000\n= 1334#1\nLRD 10000 0 ~3\n= 123401#1\nLRD 10001 0 00\n= 35#1\nLRW 10000 0 0000\n= 1235#1",
         "  frame 8, LRD logical 0x00010000, slave 1 by FMMU: byte 0 of the process data: bus 19, twin 18\n"
         "  frame 10, LRD logical 0x00010000, slave 1 by FMMU: byte 2 of the process data: bus 1, twin 0\n"
         "  frame 12, LRD logical 0x00010001, slave 1 by FMMU: byte 0 of the process data: bus 53, twin 52\n"
         "  frame 14, LRW logical 0x00010000, slave 1 by FMMU: byte 1 of the process data: bus 53, twin 52\n"
         ": 7 frames and 7 replies in 0.012 s of the bus: 4 differences\n"},
        {FMMU "LRD 0FFFF 0 00\n= 01#1\nLRD 10000 0 00\n= 12#0\nLRD 10002 0 00\n= 01#1\nLWR 10000 0 0000\n= 0000#1",
         "  frame 8, LRD logical 0x0000FFFF, no slave: working counter: bus 1, twin 0\n"
         "  frame 10, LRD logical 0x00010000, slave 1 by FMMU: working counter: bus 0, twin 1\n"
         "  frame 12, LRD logical 0x00010002, no slave: working counter: bus 1, twin 0\n"
         "  frame 14, LWR logical 0x00010000, slave 1 by FMMU: working counter: bus 1, twin 0\n"
         ": 7 frames and 7 replies in 0.012 s of the bus: 4 differences\n"},
        {FMMU "LRD FFFFFFFF 0 0000\n= 0100#0\nLRD 0FFFF 0 0000\n= 0012#2\nFPRD 1001 1800 0000\n= 1235#1",
         "  frame 8, LRD logical 0xFFFFFFFF, no slave: byte 0 of the process data: bus 1, twin 0\n"
         "  frame 10, LRD logical 0x0000FFFF, slave 1 by FMMU: working counter: bus 2, twin 1\n"
         ": 6 frames and 6 replies in 0.010 s of the bus: 2 differences\n"},
    };
    COMPARE(rows, "--data", "fzm1");
}

static void the_first_8_slaves_of_a_datagram_are_named(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {"FPRD 0000 0600 00\n= 00#1\nBRD 0 0600 00\n= 00#1\nAPRD FFF8 0600 00\n= 00#2",
         "  frame 2, FPRD 0000:0600 FMMU0, slave 1, 2, 3, 4, 5, 6, 7, 8: working counter: bus 1, twin 9\n"
         "  frame 4, BRD 0000:0600 FMMU0, all slaves: working counter: bus 1, twin 9\n"
         "  frame 6, APRD FFF8:0600 FMMU0, slave 9: working counter: bus 2, twin 1\n"
         ": 3 frames and 3 replies in 0.004 s of the bus: 3 differences\n"},
        {"BWR 0 0600 00000100020000070018000101000000\n= ~16#9\nLRD 10001 0 00\n= 00#1",
         "  frame 4, LRD logical 0x00010001, slave 1, 2, 3, 4, 5, 6, 7, 8 by FMMU: working counter: bus 1, twin 9\n"
         ": 2 frames and 2 replies in 0.002 s of the bus: 1 differences\n"},
    };
    COMPARE(rows, "", "fzm1*9");
}

static void a_slave_is_named_by_station_address_and_alias(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {STATION
         "APWR 0 0103 01\n= 01#1\nFPRD 0011 0600 00\n= 00#2\nFPRD 1001 0600 00\n= 00#2\nFPRD 0012 0600 00\n= 00#2",
         "  frame 6, FPRD 0011:0600 FMMU0, slave 1: working counter: bus 2, twin 1\n"
         "  frame 8, FPRD 1001:0600 FMMU0, slave 1: working counter: bus 2, twin 1\n"
         "  frame 10, FPRD 0012:0600 FMMU0, no slave: working counter: bus 2, twin 0\n"
         ": 5 frames and 5 replies in 0.008 s of the bus: 3 differences\n"},
        {STATION "FPRD 0011 0600 00\n= 00#2",
         "  frame 4, FPRD 0011:0600 FMMU0, no slave: working counter: bus 2, twin 0\n"
         ": 2 frames and 2 replies in 0.002 s of the bus: 1 differences\n"},
    };
    COMPARE(rows, "--alias=17", "fzm1");
}

#define FIVE(text) text text text text text

static void the_first_20_differences_are_printed(void **state)
{
    (void)state;
    static const row_t rows[] = {
        {"BRD 0 0130 00" FIVE(" & BRD 0 0130 00") FIVE(" & BRD 0 0130 00") FIVE(" & BRD 0 0130 00")
             FIVE(" & BRD 0 0130 00") "\n= 01#2" FIVE(" & 01#3") FIVE(" & 01#4") FIVE(" & 01#5") FIVE(" & 01#6"),
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 2, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 3, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 3, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 3, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 3, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 3, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 4, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 4, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 4, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 4, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 4, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 5, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 5, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 5, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 5, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 5, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 6, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 6, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 6, twin 1\n"
         "  frame 2, BRD 0000:0130 AL status, all slaves: working counter: bus 6, twin 1\n"
         ": 1 frames and 1 replies in 0.000 s of the bus: 21 differences\n"},
    };
    COMPARE(rows, "", "fzm1");
}

/* BOOT is refused, and the error is acknowledged: two states */
static void the_first_64_states_of_a_slave_are_compared(void **state)
{
    static const char refused[] = "FPWR 1001 0120 0300\n= 0300#1\nFPRD 1001 0130 00\n= 11#1\n"
                                  "FPWR 1001 0120 1100\n= 1100#1\nFPRD 1001 0130 00\n= 01#1\n";
    static const char last[] = "FPRD 1001 0130 00\n= 02#1\n";
    enum { PAIRS = 32 };
    char lines[PAIRS * sizeof refused + 100] = STATION, output[OUTPUT];
    (void)state;
    for (int i = 0; i < PAIRS - 1; i++)
        strcat(lines, refused);
    strcat(lines, "FPRD 1001 0130 00\n= 01#1\nFPWR 1001 0120 0300\n= 0300#1\nFPRD 1001 0130 00\n= 11#1\n");
    const size_t length = strlen(lines);
    strcat(lines, last);
    assert_int_equal(replay(lines, "", "fzm1", output), 1);
    assert_non_null(strstr(output, "slave 1, AL state 64: bus PREOP, twin nothing more\n"));
    lines[length] = '\0';
    strcat(lines, "FPWR 1001 0120 1100\n= 1100#1\nFPRD 1001 0130 00\n= 01#1\n");
    strcat(lines, last);
    assert_int_equal(replay(lines, "", "fzm1", output), 0);
}

/* --- two frames ----------------------------------------------------------------------------------------------------
 */

/* Datagrams BRD 0:0130 with 2 bytes of data, 14 bytes each, from byte 16 on. */
static void the_first_datagram_that_differs_is_found(void **state)
{
    (void)state;
    enum { SIZE = 14, DATAGRAMS = 3 };
    static const struct {
        size_t changed, expected_length, got_length; /* byte that differs; 0: none */
        replay_difference_t want;
    } rows[] = {
        {0, 58, 58, {0}},
        {15, 58, 58, {0}},
        {16, 58, 58, {.number = 1, .count = 3, .at = 16, .length = 2}},
        {29, 58, 58, {.number = 1, .count = 3, .at = 16, .length = 2}},
        {30, 58, 58, {.number = 2, .count = 3, .at = 30, .length = 2}},
        {57, 58, 58, {.number = 3, .count = 3, .at = 44, .length = 2}},
        {57, 58, 57, {0}},
        {57, 57, 58, {0}},
        {40, 57, 58, {.number = 2, .count = 2, .at = 30, .length = 2}},
        {40, 58, 57, {.number = 2, .count = 3, .at = 30, .length = 2}},
        {58, 59, 59, {0}},
        {0, 58, 44, {0}},
        {0, 58, 15, {0}},
        {0, 15, 58, {0}},
        {16, 58, 16, {0}},
        {17, 40, 40, {.number = 1, .count = 1, .at = 16, .length = 2}},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_t one = {0}, other;
        wire_build(&one, BRD, 0, 0x0130, "\1\2", 2);
        for (int n = 1; n < DATAGRAMS; n++)
            wire_append(&one, BRD, 0, 0x0130, "\1\2", 2);
        assert_int_equal(one.frame_length, HEADS + DATAGRAMS * SIZE);
        memset(one.frame + one.frame_length, 0, sizeof one.frame - one.frame_length);
        other = one;
        other.frame[rows[i].changed] ^= rows[i].changed != 0 ? 0x20 : 0;
        const replay_difference_t got =
            replay_compare(one.frame, rows[i].expected_length, other.frame, rows[i].got_length);
        if (got.at != rows[i].want.at)
            print_error("row %zu\n", i);
        assert_int_equal(got.at, rows[i].want.at);
        assert_int_equal(got.number, rows[i].want.number);
        assert_int_equal(got.count, rows[i].want.count);
        assert_int_equal(got.length, rows[i].want.length);
    }
}

static void a_datagram_is_found_if_the_frame_holds_all_of_it(void **state)
{
    (void)state;
    wire_t w = {0};
    wire_build(&w, BRD, 0, 0x0130, "\1\2", 2);
    static const struct {
        size_t length, at, want;
    } rows[] = {{30, 16, 14}, {29, 16, 0}, {31, 16, 14}, {26, 16, 0},
                {25, 16, 0},  {16, 16, 0}, {15, 16, 0},  {30, 31, 0}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_int_equal(replay_datagram(w.frame, rows[i].length, rows[i].at), rows[i].want);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_working_counter_that_differs_is_printed_with_the_addressed_slaves),
        cmocka_unit_test(a_reply_belongs_to_the_request_before_it),
        cmocka_unit_test(al_states_are_compared_in_the_order_of_their_reads),
        cmocka_unit_test(devices_run_between_frames_as_long_as_on_the_bus),
        cmocka_unit_test(mails_are_compared_by_header_and_service),
        cmocka_unit_test(eeprom_data_of_one_slave_are_compared),
        cmocka_unit_test(eeprom_data_that_no_slave_has_read_are_not_compared),
        cmocka_unit_test(with_data_process_data_are_compared),
        cmocka_unit_test(the_first_8_slaves_of_a_datagram_are_named),
        cmocka_unit_test(a_slave_is_named_by_station_address_and_alias),
        cmocka_unit_test(the_first_20_differences_are_printed),
        cmocka_unit_test(the_first_64_states_of_a_slave_are_compared),
        cmocka_unit_test(the_first_datagram_that_differs_is_found),
        cmocka_unit_test(a_datagram_is_found_if_the_frame_holds_all_of_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
