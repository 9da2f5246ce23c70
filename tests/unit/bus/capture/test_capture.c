/* SPDX-License-Identifier: MIT */
/* A growing capture file (src/bus/capture): the bytes of its blocks, its limit, its lacks. */
#define _GNU_SOURCE
#include "bus/capture/capture.h"

#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "wire/bytes.h"

enum { BUFFER = 32768, FRAME = 60, FILE_ROOM = 1024 * 1024 };

typedef struct rig {
    char path[64];
    ect_capture_t *capture;
    uint8_t *bytes;
    size_t size;
    uint8_t frame[4000];
} rig_t;

/* A block of the file, or a packet of it. */
typedef struct block {
    uint32_t type, total;
    const uint8_t *body;
} block_t;

static int setup(void **state)
{
    rig_t *r = calloc(1, sizeof *r);
    r->bytes = malloc(FILE_ROOM);
    strcpy(r->path, "/tmp/test_capture-XXXXXX");
    close(mkstemp(r->path));
    for (size_t i = 0; i < sizeof r->frame; i++)
        r->frame[i] = (uint8_t)i;
    *state = r;
    return 0;
}

static int teardown(void **state)
{
    rig_t *r = *state;
    unlink(r->path);
    free(r->bytes);
    free(r);
    return 0;
}

static ect_capture_config_t config_of(const rig_t *r)
{
    return (ect_capture_config_t){.path = r->path, .buffer = BUFFER, .application = "test", .names = {"ecat0", NULL}};
}

static void begin(rig_t *r, const ect_capture_config_t *config)
{
    char message[ECT_CAPTURE_MESSAGE] = "";
    r->capture = ect_capture_open(config, message);
    if (!r->capture)
        fail_msg("%s", message);
}

static void read_back(rig_t *r)
{
    int fd = open(r->path, O_RDONLY);
    r->size = (size_t)read(fd, r->bytes, FILE_ROOM);
    close(fd);
}

static void end(rig_t *r, int expected)
{
    assert_int_equal(ect_capture_close(r->capture, NULL, 0, 0), expected);
    read_back(r);
}

static bool add(rig_t *r, uint64_t time_ns, size_t length)
{
    return ect_capture_frame(r->capture, 0, ECT_PCAPNG_INBOUND, time_ns, r->frame, length);
}

/* The n-th block of a type. Every block before it must be whole. @return false: there are not so many */
static bool find(const rig_t *r, uint32_t type, size_t n, block_t *block)
{
    size_t at = 0;
    while (at < r->size) {
        assert_true(r->size - at >= 12);
        *block = (block_t){ect_load_le32(r->bytes + at), ect_load_le32(r->bytes + at + 4), r->bytes + at + 8};
        assert_true(block->total >= 12 && block->total % 4 == 0 && block->total <= r->size - at);
        assert_int_equal(ect_load_le32(r->bytes + at + block->total - 4), block->total);
        if (block->type == type && n-- == 0)
            return true;
        at += block->total;
    }
    return false;
}

static size_t count(const rig_t *r, uint32_t type)
{
    block_t block;
    size_t n = 0;
    while (find(r, type, n, &block))
        n++;
    return n;
}

/* An option of a block whose options begin at `at`. @return NULL: not there */
static const uint8_t *option(const block_t *block, size_t at, uint16_t code, size_t *length)
{
    while (at + 4 <= block->total - 12) {
        *length = ect_load_le16(block->body + at + 2);
        if (ect_load_le16(block->body + at) == code)
            return block->body + at + 4;
        at += 4 + (*length + 3) / 4 * 4;
    }
    return NULL;
}

static void frames(void **state)
{
    rig_t *r = *state;
    block_t b;
    size_t length;
    ect_capture_config_t config = config_of(r);
    config.offset_ns = 1;
    begin(r, &config);
    ect_capture_comment(r->capture, "one");
    ect_capture_comment(r->capture, "two");
    assert_true(add(r, 0x123456789Aull, 61));
    assert_true(ect_capture_frame(r->capture, 1, ECT_PCAPNG_OUTBOUND, 5, r->frame, 3000));
    end(r, 0);
    assert_true(find(r, ECT_PCAPNG_SECTION, 0, &b));
    assert_int_equal(ect_load_le32(b.body), ECT_PCAPNG_MAGIC);
    assert_memory_equal(option(&b, 16, ECT_PCAPNG_APPLICATION, &length), "test", 4);
    assert_int_equal(count(r, ECT_PCAPNG_INTERFACE), 2);
    assert_true(find(r, ECT_PCAPNG_INTERFACE, 0, &b));
    assert_int_equal(ect_load_le32(b.body), 1); /* Ethernet, whole frames */
    assert_int_equal(ect_load_le32(b.body + 4), 0);
    assert_memory_equal(option(&b, 8, ECT_PCAPNG_NAME, &length), "ecat0", 5);
    assert_int_equal(*option(&b, 8, ECT_PCAPNG_RESOLUTION, &length), 9);
    assert_true(find(r, ECT_PCAPNG_PACKET, 0, &b));
    assert_int_equal(ect_load_le32(b.body), 0);
    assert_int_equal(ect_load_le32(b.body + 4), 0x12);
    assert_int_equal(ect_load_le32(b.body + 8), 0x3456789B);
    assert_int_equal(ect_load_le32(b.body + 12), 61);
    assert_int_equal(ect_load_le32(b.body + 16), 61);
    assert_memory_equal(b.body + 20, r->frame, 61);
    assert_int_equal(*option(&b, 84, ECT_PCAPNG_FLAGS, &length), 1);
    assert_memory_equal(option(&b, 84, ECT_PCAPNG_COMMENT, &length), "one\ntwo", 7);
    assert_int_equal(length, 7);
    assert_true(find(r, ECT_PCAPNG_PACKET, 1, &b));
    assert_int_equal(ect_load_le32(b.body), 1);
    assert_int_equal(ect_load_le32(b.body + 12), ECT_PCAPNG_FRAME_MOST);
    assert_int_equal(ect_load_le32(b.body + 16), 3000);
    assert_int_equal(*option(&b, 20 + ECT_PCAPNG_FRAME_MOST, ECT_PCAPNG_FLAGS, &length), 2);
    assert_null(option(&b, 20 + ECT_PCAPNG_FRAME_MOST, ECT_PCAPNG_COMMENT, &length));
}

static void long_comment(void **state)
{
    rig_t *r = *state;
    char line[700];
    block_t b;
    size_t length;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    memset(line, 'x', sizeof line - 1);
    line[sizeof line - 1] = 0;
    for (int i = 0; i < 3; i++)
        ect_capture_comment(r->capture, line);
    assert_true(add(r, 1, FRAME));
    end(r, 0);
    assert_true(find(r, ECT_PCAPNG_PACKET, 0, &b));
    assert_non_null(option(&b, 20 + FRAME, ECT_PCAPNG_COMMENT, &length));
    assert_int_equal(length, ECT_PCAPNG_COMMENT_MOST);
}

static void comment_at_the_end(void **state)
{
    rig_t *r = *state;
    block_t b;
    size_t length;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    ect_capture_comment(r->capture, "slave 1: INIT");
    end(r, 0);
    assert_true(find(r, ECT_PCAPNG_STATISTICS, 0, &b));
    assert_memory_equal(option(&b, 12, ECT_PCAPNG_COMMENT, &length), "slave 1: INIT", 13);
}

/* Nothing is written before a flush: a disk that takes no bytes. */
static void full_buffer(void **state)
{
    rig_t *r = *state;
    block_t b;
    size_t length;
    unsigned int kept = 0, dropped = 0;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    while (dropped < 3) {
        bool added = add(r, kept, FRAME);
        kept += added;
        dropped += !added;
    }
    assert_in_range(kept, BUFFER / 120, BUFFER / 80);
    assert_false(ect_capture_local(r->capture, r->frame, 1000));
    ect_capture_flush(r->capture);
    assert_true(add(r, kept, FRAME));
    end(r, 0);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), kept + 1);
    assert_true(find(r, ECT_PCAPNG_PACKET, kept, &b));
    assert_int_equal(ect_load_le64(option(&b, 20 + FRAME, ECT_PCAPNG_DROPPED, &length)), 3);
    assert_int_equal(length, 8);
    assert_true(find(r, ECT_PCAPNG_PACKET, kept - 1, &b));
    assert_null(option(&b, 20 + FRAME, ECT_PCAPNG_DROPPED, &length));
}

/* No packet follows that could count them, so the last block does. */
static void dropped_at_the_end(void **state)
{
    rig_t *r = *state;
    for (unsigned int dropped = 0; dropped < 3; dropped++) {
        const ect_capture_config_t config = config_of(r);
        block_t b;
        size_t length;
        char want[32];
        begin(r, &config);
        while (dropped > 0 && add(r, 1, FRAME))
            ;
        for (unsigned int n = 1; n < dropped; n++)
            assert_false(add(r, 1, FRAME));
        end(r, 0);
        assert_int_equal(count(r, ECT_PCAPNG_STATISTICS), dropped > 0);
        if (dropped == 0)
            continue;
        (void)snprintf(want, sizeof want, "%u frames were dropped", dropped);
        assert_true(find(r, ECT_PCAPNG_STATISTICS, 0, &b));
        const uint8_t *comment = option(&b, 12, ECT_PCAPNG_COMMENT, &length);
        assert_non_null(comment);
        assert_int_equal(length, strlen(want));
        assert_memory_equal(comment, want, length);
    }
}

/* Frames of several lengths, so that few places of the file are ends of blocks; `burst` of them between two flushes. */
static void limit_with(rig_t *r, uint64_t burst)
{
    block_t b;
    enum { COUNT = 5000 };
    ect_capture_config_t config = config_of(r);
    config.most = ECT_CAPTURE_SMALLEST;
    begin(r, &config);
    for (uint64_t i = 1; i <= COUNT; i++) {
        assert_true(add(r, i, FRAME + i * 7 % 50));
        if (i % burst == 0) {
            ect_capture_flush(r->capture);
            read_back(r);
            bool removed = count(r, ECT_PCAPNG_PACKET) < i;
            assert_in_range(r->size, removed ? ECT_CAPTURE_SMALLEST / 2 - 8192 : 1, ECT_CAPTURE_SMALLEST);
        }
    }
    end(r, 0);
    size_t kept = count(r, ECT_PCAPNG_PACKET);
    assert_in_range(r->size, ECT_CAPTURE_SMALLEST / 2 - 8192, ECT_CAPTURE_SMALLEST);
    assert_int_equal(count(r, ECT_PCAPNG_SECTION), 1);
    assert_int_equal(count(r, ECT_PCAPNG_INTERFACE), 2);
    for (size_t i = 0; i < kept; i++) { /* the newest ones, none of them missing */
        assert_true(find(r, ECT_PCAPNG_PACKET, i, &b));
        assert_int_equal(ect_load_le32(b.body + 8), COUNT - kept + 1 + i);
    }
    assert_true(find(r, ECT_PCAPNG_STATISTICS, 0, &b));
}

static void limit(void **state)
{
    limit_with(*state, 50);
}

/* More than the eighth of the limit that one write takes. */
static void limit_and_backlog(void **state)
{
    limit_with(*state, 250);
}

static void sections(void **state)
{
    rig_t *r = *state;
    ect_capture_config_t config = config_of(r);
    config.append = true;
    for (unsigned int i = 0; i < 3; i++) {
        begin(r, &config);
        assert_true(add(r, i, FRAME));
        end(r, 0);
    }
    assert_int_equal(count(r, ECT_PCAPNG_SECTION), 3);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), 3);
    config.append = false;
    begin(r, &config);
    end(r, 0);
    assert_int_equal(count(r, ECT_PCAPNG_SECTION), 1);
}

static void thread(void **state)
{
    rig_t *r = *state;
    enum { COUNT = 20000 };
    unsigned int kept = 0;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    assert_true(ect_capture_start(r->capture));
    for (unsigned int i = 0; i < COUNT / 10; i++) {
        kept += add(r, i, FRAME);
        ect_capture_flush(r->capture);
    }
    end(r, 0);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), kept);
}

static off_t size_of(const rig_t *r)
{
    struct stat info;
    assert_int_equal(stat(r->path, &info), 0);
    return info.st_size;
}

/* The thread sleeps between two packets: each flush wakes it. */
static void flush_wakes_the_thread(void **state)
{
    enum { PACKETS = 20, MOST_WAITS = 60000, PAUSE_US = 1000 };
    rig_t *r = *state;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    assert_true(ect_capture_start(r->capture));
    for (unsigned int i = 0; i < PACKETS; i++) {
        const off_t before = size_of(r);
        unsigned int waits = 0;
        assert_true(add(r, i, FRAME));
        ect_capture_flush(r->capture);
        while (size_of(r) == before && waits++ < MOST_WAITS)
            usleep(PAUSE_US);
        assert_true(size_of(r) > before);
    }
    end(r, 0);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), PACKETS);
}

/* Readable and writable as the user's mask has it, and never a program. */
static void rights_of_the_file(void **state)
{
    rig_t *r = *state;
    struct stat info;
    const ect_capture_config_t config = config_of(r);
    const mode_t mask = umask(0);
    unlink(r->path);
    begin(r, &config);
    (void)umask(mask);
    end(r, 0);
    assert_int_equal(stat(r->path, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0666);
}

static void idle_thread_ends(void **state)
{
    rig_t *r = *state;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    assert_true(ect_capture_start(r->capture));
    end(r, 0);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), 0);
}

/* A file that must not grow: a full disk. */
static void failed_write(void **state)
{
    rig_t *r = *state;
    struct rlimit before, small;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 2048;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    for (unsigned int i = 0; i < 100; i++)
        (void)add(r, i, FRAME);
    ect_capture_flush(r->capture);
    bool added = add(r, 1, FRAME);
    int failed = ect_capture_close(r->capture, NULL, 0, 0);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(failed, EFBIG);
    assert_false(added);
    read_back(r);
    assert_int_equal(count(r, ECT_PCAPNG_INTERFACE), 2); /* and whole blocks only */
}

/* Another process shortens the file, whose newer half cannot be moved then. */
static void shortened(void **state)
{
    rig_t *r = *state;
    enum { COUNT = 5000 };
    ect_capture_config_t config = config_of(r);
    config.most = ECT_CAPTURE_SMALLEST;
    begin(r, &config);
    unsigned int added = 0;
    for (unsigned int i = 0; i < COUNT; i++) {
        added += add(r, i, FRAME);
        if (i % 50 == 0) {
            assert_int_equal(truncate(r->path, 100), 0);
            errno = ENOENT; /* of an earlier call */
            ect_capture_flush(r->capture);
        }
    }
    assert_in_range(added, 1, COUNT - 1);
    assert_int_equal(ect_capture_close(r->capture, NULL, 0, 0), EIO);
}

static void heads_refused(void **state)
{
    rig_t *r = *state;
    struct rlimit before, small;
    char message[ECT_CAPTURE_MESSAGE] = "", expected[ECT_CAPTURE_MESSAGE];
    const ect_capture_config_t config = config_of(r);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 20;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    ect_capture_t *c = ect_capture_open(&config, message);
    const int reason = errno;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    (void)snprintf(expected, sizeof expected, "cannot write '%s': File too large", r->path);
    assert_null(c);
    assert_int_equal(reason, EFBIG);
    assert_string_equal(message, expected);
}

static void refused(void **state)
{
    rig_t *r = *state;
    const struct {
        const char *path, *message;
    } wrong[] = {
        {"/no/such/file", "cannot write '/no/such/file': No such file or directory"},
        {"/dev/null", "cannot write '/dev/null': it is not a regular file"},
        {"/tmp", "cannot write '/tmp': Is a directory"},
    };
    char message[ECT_CAPTURE_MESSAGE];
    ect_capture_config_t config = config_of(r);
    const int before = open("/dev/null", O_RDONLY);
    close(before);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        config.path = wrong[i].path;
        assert_null(ect_capture_open(&config, message));
        assert_string_equal(message, wrong[i].message);
    }
    const int after = open("/dev/null", O_RDONLY);
    close(after);
    assert_int_equal(after, before); /* no descriptor is left open */
}

static void taken(void **state)
{
    rig_t *r = *state;
    char message[ECT_CAPTURE_MESSAGE];
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    assert_true(add(r, 1, FRAME));
    ect_capture_flush(r->capture);
    assert_null(ect_capture_open(&config, message));
    assert_int_equal(errno, EWOULDBLOCK);
    assert_non_null(strstr(message, "another capture writes to it; give this one another name"));
    end(r, 0);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), 1);
}

static void local_data(void **state)
{
    rig_t *r = *state;
    block_t b;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    assert_true(ect_capture_local(r->capture, r->frame, 5));
    assert_true(ect_capture_local(r->capture, r->frame, 2000));
    end(r, 0);
    assert_true(find(r, ECT_PCAPNG_LOCAL, 0, &b));
    assert_int_equal(b.total, 20);
    assert_memory_equal(b.body, "\0\1\2\3\4\0\0", 8);
    assert_true(find(r, ECT_PCAPNG_LOCAL, 1, &b));
    assert_memory_equal(b.body, r->frame, 2000);
}

static void cut_text(void **state)
{
    char text[ECT_PCAPNG_COMMENT_MOST + 3];
    uint8_t block[ECT_PCAPNG_ROOM];
    (void)state;
    memset(text, 'x', sizeof text);
    strcpy(text + ECT_PCAPNG_COMMENT_MOST - 1, "\xC3\xA4");
    (void)ect_pcapng_statistics(block, 0, text);
    assert_int_equal(ect_load_le16(block + 22), ECT_PCAPNG_COMMENT_MOST - 1); /* not half of a character */
    (void)ect_pcapng_statistics(block, 0x8123456789ABCDEF, "x");
    assert_int_equal(ect_load_le32(block + 8), 0); /* the interface */
    assert_true(ect_load_le32(block + 12) == 0x81234567 && ect_load_le32(block + 16) == 0x89ABCDEF);
}

int main(void)
{
#define CASE(title, f) {title, f, setup, teardown, NULL}
    const struct CMUnitTest tests[] = {
        CASE("frames have interface, direction, time, bytes and comments; a long frame is cut and keeps its length",
             frames),
        CASE("a comment that grows too long is cut", long_comment),
        CASE("a comment after the last frame ends the section", comment_at_the_end),
        CASE("a full buffer drops frames, and the next frame has their number", full_buffer),
        CASE("at the limit the older half goes; heads and newest frames stay", limit),
        CASE("a backlog is written in pieces that the limit takes", limit_and_backlog),
        CASE("with append each capture is a section of its own; without it the file is emptied", sections),
        CASE("a thread writes what is added, all of it", thread),
        CASE("each flush wakes the thread", flush_wakes_the_thread),
        CASE("the file has the rights of the mask, and is no program", rights_of_the_file),
        CASE("a thread that has nothing to do ends", idle_thread_ends),
        CASE("frames that were dropped at the end are counted by the last block, which is there for that",
             dropped_at_the_end),
        CASE("after a failed write frames are dropped, and the end reports the reason", failed_write),
        CASE("a file that another process shortens ends with an error", shortened),
        CASE("a file without room for its heads is refused with one line", heads_refused),
        CASE("a file that cannot be written gives one line", refused),
        CASE("a second capture does not touch the file of the first", taken),
        CASE("local data are blocks between the frames", local_data),
        CASE("a text is cut between characters", cut_text),
    };
    (void)signal(SIGXFSZ, SIG_IGN);
    return cmocka_run_group_tests_name("capture", tests, NULL, NULL);
}
