/* SPDX-License-Identifier: MIT */
/* Runs the vectors of tests/vectors, each one a test.  usage: test_vectors [--pcap FILE] [VECTOR] */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/filedev.h"
#include "support/wire.h"

enum { MOST = 256, MAILBOX = 128, LINE = 1024 };

typedef struct vector {
    char name[192];
    char file[300];
    long at; /* of its first line after the name */
} vector_t;

static vector_t vectors[MOST];
static struct CMUnitTest tests[MOST];
static size_t count;
static FILE *pcap;

/* --- pcap: the frames as they came back, one after the other ------------------------------------------------------ */

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
    assert_int_equal(wire_write(w, 0, testdev.sm[0].start, mail, MAILBOX), 1);
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
        fail_msg("%s: expected%s  got no answer", name, text);
    assert_int_equal(wire_read(w, 0, testdev.sm[1].start, got, MAILBOX), 1);
    record(w);
    (void)parse(text, want);
    if (memcmp(want, got, MAILBOX) == 0)
        return;
    fprintf(stderr, "%s\nexpected%sgot     ", name, text);
    for (unsigned int i = 0; i < 6u + ect_load_le16(got) && i < MAILBOX; i++)
        fprintf(stderr, " %02X", got[i]);
    fail_msg("alone: test_vectors '%s'", name);
}

static void run_vector(void **state)
{
    const vector_t *v = *state;
    char line[LINE];
    FILE *file = fopen(v->file, "r");
    wire_t w;
    unsigned int exchanges = 0;
    assert_non_null(file);
    assert_int_equal(fseek(file, v->at, SEEK_SET), 0);
    wire_open_one(&w, strncmp(v->name, "foe:", 4) == 0 ? filedev() : &testdev);
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

/* --- all of them -------------------------------------------------------------------------------------------------- */

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
