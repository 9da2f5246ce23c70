/* SPDX-License-Identifier: MIT */
/* Runs the vectors of tests/vectors, each as a test.  usage: test_vectors [--pcap FILE] [VECTOR] */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "support/filedev.h"
#include "support/soedev.h"
#include "support/wire.h"

enum { MOST = 256, MAILBOX = 128, LINE = 1024, FRAME_TWINS = 3 };

typedef struct vector {
    char name[192];
    char file[300];
    long at; /* of its first line after the name */
} vector_t;

static vector_t vectors[MOST];
static struct CMUnitTest tests[MOST];
static size_t count;
static FILE *pcap;

/* --- pcap: the frames as they came back, in succession ------------------------------------------------------------ */

static void put32(uint32_t value)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    (void)fwrite(bytes, 1, 4, pcap);
}

static void open_pcap(const char *path)
{
    pcap = fopen(path, "wb");
    if (!pcap) {
        perror(path);
        exit(2);
    }
    put32(0xA1B2C3D4);
    put32(0x00040002); /* version 2.4 */
    put32(0);
    put32(0);
    put32(65535);
    put32(1); /* Ethernet */
}

static void record(const wire_t *w)
{
    if (!pcap)
        return;
    put32((uint32_t)(w->now_ns / 1000000000u));
    put32((uint32_t)(w->now_ns / 1000u % 1000000u));
    put32((uint32_t)w->frame_length);
    put32((uint32_t)w->frame_length);
    (void)fwrite(w->frame, 1, w->frame_length, pcap);
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

/* A frame as given, in one line or several. */
typedef struct given {
    bool sent; /* sent to the slaves; otherwise the expected frame */
    bool far;  /* at the other end of the chain */
    bool none; /* no frame returns */
    uint8_t bytes[2100];
    size_t length; /* 0: none is given */
} given_t;

/* Result of a sequence of frames. */
typedef struct talk {
    wire_t w;
    given_t given;
    ect_end_t out; /* the end at which the last one has returned */
    unsigned int exchanges;
    const char *name;
} talk_t;

static int digit(char c)
{
    static const char digits[] = "0123456789ABCDEF";
    const char *found = c != 0 ? strchr(digits, c) : NULL;
    return found ? (int)(found - digits) : -1;
}

/* Pairs of hexadecimal digits separated by spaces; *N behind a pair repeats it. */
static void add_bytes(given_t *g, const char *text)
{
    while (*text != 0) {
        if (*text == ' ') {
            text++;
            continue;
        }
        int high = digit(text[0]);
        int low = high < 0 ? -1 : digit(text[1]);
        unsigned long times = 1;
        if (low < 0)
            fail_msg("expected two hexadecimal digits, got '%s'", text);
        text += 2;
        if (*text == '*') {
            char *end;
            times = strtoul(text + 1, &end, 10);
            text = end;
        }
        assert_true(times > 0 && g->length + times <= sizeof g->bytes);
        memset(g->bytes + g->length, high << 4 | low, times);
        g->length += times;
    }
}

static void send_given(talk_t *t)
{
    memcpy(t->w.frame, t->given.bytes, t->given.length);
    t->w.frame_length = t->given.length;
    record(&t->w);
    ect_end_t in = t->given.far ? ECT_END_OUT : ECT_END_IN;
    ect_chain_set_link(t->w.chain, ECT_END_OUT, t->given.far);
    t->out = ect_chain_pass(t->w.chain, in, t->w.frame, t->w.frame_length, t->w.now_ns);
    wire_poll(&t->w);
}

static void expect_given(talk_t *t)
{
    ect_end_t want = t->given.none ? ECT_END_NONE : t->given.far ? ECT_END_OUT : ECT_END_IN;
    t->exchanges++;
    if (t->out != want)
        fail_msg("frame %u: expected it %s, got it %s; alone: test_vectors '%s'", t->exchanges,
                 want == ECT_END_NONE ? "lost" : "back", t->out == ECT_END_NONE ? "lost" : "back", t->name);
    if (want == ECT_END_NONE)
        return;
    record(&t->w);
    assert_int_equal(t->w.frame_length, t->given.length);
    for (size_t i = 0; i < t->given.length; i++) {
        if (t->w.frame[i] != t->given.bytes[i])
            fail_msg("frame %u, byte %zu: expected %02X, got %02X; alone: test_vectors '%s'", t->exchanges, i,
                     t->given.bytes[i], t->w.frame[i], t->name);
    }
}

/* The frame in the lines before. */
static void end_given(talk_t *t)
{
    if (t->given.length > 0 && t->given.sent)
        send_given(t);
    else if (t->given.length > 0 || t->given.none)
        expect_given(t);
    t->given = (given_t){0};
}

static void begin_given(talk_t *t, const char *line)
{
    const char *text = line + 3;
    t->given.sent = line[0] == '>';
    t->given.far = strncmp(text, "far ", 4) == 0;
    t->given.none = *text == '-';
    if (!t->given.none)
        add_bytes(&t->given, t->given.far ? text + 4 : text);
}

static void let_fail(talk_t *t, const char *text)
{
    ect_fault_t fault;
    char message[ECT_FAULT_MESSAGE];
    if (!ect_fault_parse(text, &fault, message))
        fail_msg("%s", message);
    ect_chain_fault(t->w.chain, &fault, t->w.now_ns);
}

/* Disconnects the input of a slave. */
static void cut(talk_t *t, unsigned long slave)
{
    const ect_setting_t pulled = {.name = "ecat.plug_in", .value = "0"};
    char message[ECT_SIGNAL_MESSAGE];
    assert_true(ect_settings_apply(t->w.chain, slave - 1, &pulled, 1, t->w.now_ns, message));
    wire_poll(&t->w);
}

static void follow_line(talk_t *t, const char *line)
{
    if (line[0] == ' ') {
        add_bytes(&t->given, line);
        return;
    }
    end_given(t);
    if (strncmp(line, ">> ", 3) == 0 || strncmp(line, "<< ", 3) == 0)
        begin_given(t, line);
    else if (strncmp(line, "fault ", 6) == 0)
        let_fail(t, line + 6);
    else if (strncmp(line, "cut ", 4) == 0)
        cut(t, strtoul(line + 4, NULL, 10));
    else if (line[0] != 0 && line[0] != '#' && strncmp(line, "ref ", 4) != 0)
        fail_msg("unknown line: %s", line);
}

static void run_frames(const vector_t *v)
{
    const ect_device_t *devices[FRAME_TWINS] = {&testdev, &testdev, &testdev};
    char line[LINE];
    static talk_t t;
    FILE *file = fopen(v->file, "r");
    assert_non_null(file);
    assert_int_equal(fseek(file, v->at, SEEK_SET), 0);
    memset(&t, 0, sizeof t);
    t.name = v->name;
    wire_open(&t.w, devices, FRAME_TWINS);
    while (fgets(line, sizeof line, file) && strncmp(line, "vector ", 7) != 0) {
        line[strcspn(line, "\n")] = 0;
        t.w.now_ns += MS;
        follow_line(&t, line);
    }
    end_given(&t);
    assert_true(t.exchanges > 0);
    (void)fclose(file);
    wire_close(&t.w);
}

/* --- one vector --------------------------------------------------------------------------------------------------- */

/* Bytes in hexadecimal up to the end of the line or a comment. */
static uint16_t parse(const char *text, uint8_t mail[MAILBOX])
{
    uint16_t length = 0;
    memset(mail, 0, MAILBOX);
    while (length < MAILBOX) {
        char *end;
        unsigned long value = strtoul(text, &end, 16);
        if (end == text)
            break;
        mail[length++] = (uint8_t)value;
        text = end;
    }
    return length;
}

static void send_mail(wire_t *w, const char *text)
{
    uint8_t mail[MAILBOX];
    (void)parse(text, mail);
    assert_int_equal(wire_write(w, 0, wire_device(w, 0)->sm[0].start, mail, MAILBOX), 1);
    record(w);
}

static void expect_mail(wire_t *w, const char *text, const char *name)
{
    uint8_t want[MAILBOX];
    uint8_t got[MAILBOX] = {0};
    bool full = (wire_read8(w, 0, ECT_REG_SM + 8 + ECT_SM_STATUS) & ECT_SM_STATUS_FULL) != 0;
    if (strncmp(text, " -", 2) == 0) {
        assert_false(full);
        return;
    }
    if (!full)
        fail_msg("%s: expected%s  got no reply", name, text);
    assert_int_equal(wire_read(w, 0, wire_device(w, 0)->sm[1].start, got, MAILBOX), 1);
    record(w);
    (void)parse(text, want);
    if (memcmp(want, got, MAILBOX) == 0)
        return;
    fprintf(stderr, "%s\nexpected%sgot     ", name, text);
    for (unsigned int i = 0; i < 6u + ect_load_le16(got) && i < MAILBOX; i++)
        fprintf(stderr, " %02X", got[i]);
    fail_msg("alone: test_vectors '%s'", name);
}

/* The device of a file of mails. */
static const ect_device_t *device_of(const vector_t *v)
{
    if (strncmp(v->name, "foe:", 4) == 0)
        return filedev();
    return strncmp(v->name, "soe:", 4) == 0 ? &soedev : &testdev;
}

static void run_vector(void **state)
{
    const vector_t *v = *state;
    if (strncmp(v->name, "frames", 6) == 0) {
        run_frames(v);
        return;
    }
    char line[LINE];
    FILE *file = fopen(v->file, "r");
    wire_t w;
    unsigned int exchanges = 0;
    assert_non_null(file);
    assert_int_equal(fseek(file, v->at, SEEK_SET), 0);
    wire_open_one(&w, device_of(v));
    wire_go(&w, 0, ECT_STATE_PREOP);
    while (fgets(line, sizeof line, file) && strncmp(line, "vector ", 7) != 0) {
        w.now_ns += MS;
        if (line[0] == '>')
            send_mail(&w, line + 1);
        else if (line[0] == '<')
            expect_mail(&w, line + 1, v->name);
        else if (strncmp(line, "state safeop", 12) == 0)
            wire_go(&w, 0, ECT_STATE_SAFEOP);
        exchanges += line[0] == '<';
    }
    assert_true(exchanges > 0);
    (void)fclose(file);
    wire_close(&w);
}

/* --- all vectors -------------------------------------------------------------------------------------------------- */

static void read_file(const char *path)
{
    char line[LINE];
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file)) {
        vector_t *v = &vectors[count];
        if (strncmp(line, "vector ", 7) != 0)
            continue;
        assert_true(count < MOST);
        const char *base = strrchr(path, '/') + 1;
        line[strcspn(line, "\n")] = 0;
        snprintf(v->name, sizeof v->name, "%.*s: %.120s", (int)(strlen(base) - 4), base, line + 7);
        snprintf(v->file, sizeof v->file, "%s", path);
        v->at = ftell(file);
        tests[count++] = (struct CMUnitTest){.name = v->name, .test_func = run_vector, .initial_state = v};
    }
    if (file)
        (void)fclose(file);
}

int main(int argc, char **argv)
{
    struct dirent **entries;
    if (argc > 2 && strcmp(argv[1], "--pcap") == 0) {
        open_pcap(argv[2]);
        argc -= 2;
        argv += 2;
    }
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    int found = scandir(VECTORS, &entries, NULL, alphasort);
    for (int i = 0; i < found; i++) {
        char path[300];
        snprintf(path, sizeof path, "%s/%.100s", VECTORS, entries[i]->d_name);
        if (strstr(path, ".txt"))
            read_file(path);
        free(entries[i]);
    }
    free(entries);
    int failed = count > 0 ? _cmocka_run_group_tests("vectors", tests, count, NULL, NULL) : 1;
    if (pcap)
        (void)fclose(pcap);
    return failed;
}
