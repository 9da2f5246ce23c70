/* SPDX-License-Identifier: MIT */
/* A growing capture file (src/bus/capture): the bytes of its blocks, its limit, its lacks. */
#define _GNU_SOURCE
#include "bus/capture/capture.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
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

enum { BUFFER = 32768, FRAME = 60, FILE_ROOM = 2 * 1024 * 1024 };

typedef struct rig {
    char path[64];
    ect_capture_t *capture;
    uint8_t *bytes;
    size_t size;
    uint8_t frame[4000];
} rig_t;

/* Calls of the operating system that fail or do less than they could. */
static struct {
    size_t piece;         /* most bytes of a write; 0: all */
    unsigned int signals; /* writes before the one that a signal interrupts, and between two of these; 0: none */
    unsigned int writes;
    off_t refused;       /* a write to this offset fails with EIO ... */
    bool refuses, stops; /* ... if `refuses`; each write takes 0 bytes */
    bool calloc_fails, malloc_fails, thread_fails;
} os;

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
ssize_t __real_pwrite(int fd, const void *bytes, size_t length, off_t at);
ssize_t __wrap_pwrite(int fd, const void *bytes, size_t length, off_t at);
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument);

void *__wrap_calloc(size_t count, size_t size)
{
    return os.calloc_fails ? NULL : __real_calloc(count, size);
}

void *__wrap_malloc(size_t size)
{
    return os.malloc_fails ? NULL : __real_malloc(size);
}

ssize_t __wrap_pwrite(int fd, const void *bytes, size_t length, off_t at)
{
    os.writes++;
    if (os.stops)
        return 0;
    if (os.refuses && at == os.refused) {
        errno = EIO;
        return -1;
    }
    if (os.signals > 0 && os.writes % os.signals == 0) {
        errno = EINTR;
        return -1;
    }
    return __real_pwrite(fd, bytes, os.piece > 0 && length > os.piece ? os.piece : length, at);
}

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument)
{
    return os.thread_fails ? EAGAIN : __real_pthread_create(thread, attributes, start, argument);
}

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
    memset(&os, 0, sizeof os);
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

/* The next block, which must be whole. @return false: the file ends */
static bool next(const rig_t *r, size_t *at, block_t *block)
{
    if (*at == r->size)
        return false;
    assert_true(r->size - *at >= 12);
    *block = (block_t){ect_load_le32(r->bytes + *at), ect_load_le32(r->bytes + *at + 4), r->bytes + *at + 8};
    assert_true(block->total >= 12 && block->total % 4 == 0 && block->total <= r->size - *at);
    assert_int_equal(ect_load_le32(r->bytes + *at + block->total - 4), block->total);
    *at += block->total;
    return true;
}

/* The n-th block of a type. @return false: there are not so many */
static bool find(const rig_t *r, uint32_t type, size_t n, block_t *block)
{
    size_t at = 0;
    while (next(r, &at, block)) {
        if (block->type == type && n-- == 0)
            return true;
    }
    return false;
}

static size_t count(const rig_t *r, uint32_t type)
{
    block_t block;
    size_t n = 0, at = 0;
    while (next(r, &at, &block))
        n += block.type == type;
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
    assert_memory_equal(b.body + 4, "\1\0\0\0\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF", 12); /* version 1.0, any length */
    assert_memory_equal(option(&b, 16, ECT_PCAPNG_APPLICATION, &length), "test", 4);
    assert_int_equal(length, 4);
    assert_int_equal(count(r, ECT_PCAPNG_INTERFACE), 2);
    assert_true(find(r, ECT_PCAPNG_INTERFACE, 0, &b));
    assert_int_equal(ect_load_le32(b.body), 1); /* Ethernet, whole frames */
    assert_int_equal(ect_load_le32(b.body + 4), 0);
    assert_memory_equal(option(&b, 8, ECT_PCAPNG_NAME, &length), "ecat0", 5);
    assert_int_equal(*option(&b, 8, ECT_PCAPNG_RESOLUTION, &length), 9);
    assert_int_equal(length, 1);
    assert_true(find(r, ECT_PCAPNG_PACKET, 0, &b));
    assert_int_equal(ect_load_le32(b.body), 0);
    assert_int_equal(ect_load_le32(b.body + 4), 0x12);
    assert_int_equal(ect_load_le32(b.body + 8), 0x3456789B);
    assert_int_equal(ect_load_le32(b.body + 12), 61);
    assert_int_equal(ect_load_le32(b.body + 16), 61);
    assert_memory_equal(b.body + 20, r->frame, 61);
    assert_int_equal(*option(&b, 84, ECT_PCAPNG_FLAGS, &length), 1);
    assert_int_equal(length, 4);
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
    const uint8_t *comment = option(&b, 20 + FRAME, ECT_PCAPNG_COMMENT, &length);
    assert_non_null(comment);
    assert_int_equal(length, ECT_PCAPNG_COMMENT_MOST);
    for (size_t i = 0; i < length; i++) /* the third line has no room */
        assert_int_equal(comment[i], i == sizeof line - 1 ? '\n' : 'x');
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

/* 16 blocks of 2048 bytes. */
static void exactly_full(void **state)
{
    rig_t *r = *state;
    const ect_capture_config_t config = config_of(r);
    begin(r, &config);
    for (unsigned int i = 0; i < BUFFER / 2048; i++)
        assert_true(add(r, i, 2048 - 44));
    assert_false(ect_capture_local(r->capture, r->frame, 0));
    ect_capture_flush(r->capture);
    for (unsigned int i = 0; i < BUFFER / 2048; i++)
        assert_true(add(r, i, 2048 - 44));
    end(r, 0);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), 2 * BUFFER / 2048);
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

/* A packet with a block of `length` bytes; a frame has 44 bytes of its block around it. */
static void add_block(rig_t *r, uint64_t time_ns, size_t length)
{
    assert_true(add(r, time_ns, length - 44));
}

typedef struct half {
    const char *what;
    uint64_t most;
    size_t first;  /* length of the first packet with the blocks before it */
    size_t single; /* packets written one by one after it */
    size_t burst;  /* packets of one flush after them */
    size_t last;   /* length of the last one of these */
    uint64_t kept; /* number of the first packet that stays when the limit is exceeded */
} half_t;

/* Adds packets after one of an earlier capture until the limit has removed some, and checks which ones stay. */
static void removes_half(rig_t *r, const half_t *row)
{
    enum { BLOCK = 2048 };
    ect_capture_config_t config = config_of(r);
    uint64_t number = 0;
    block_t b;
    begin(r, &config);
    assert_true(add(r, 0, FRAME));
    end(r, 0);
    const size_t section = r->size;
    config.append = true;
    config.most = row->most;
    config.buffer = 131072;
    begin(r, &config);
    read_back(r);
    add_block(r, ++number, row->first - (r->size - section));
    for (size_t i = 0; i < row->single; i++) {
        ect_capture_flush(r->capture);
        add_block(r, ++number, BLOCK);
    }
    ect_capture_flush(r->capture);
    for (size_t i = 1; i <= row->burst; i++)
        add_block(r, ++number, i == row->burst ? row->last : BLOCK);
    ect_capture_flush(r->capture);
    read_back(r);
    size_t longest = 0;
    while (count(r, ECT_PCAPNG_PACKET) == number + 1) {
        longest = r->size - section;
        add_block(r, ++number, BLOCK);
        ect_capture_flush(r->capture);
        read_back(r);
    }
    end(r, 0);
    assert_true(find(r, ECT_PCAPNG_PACKET, 1, &b));
    if (ect_load_le32(b.body + 8) != row->kept || longest > row->most || longest + BLOCK <= row->most)
        fail_msg("%s: expected packets from %u on after at most %u bytes, got %u after %zu", row->what,
                 (unsigned int)row->kept, (unsigned int)row->most, (unsigned int)ect_load_le32(b.body + 8), longest);
    assert_true(find(r, ECT_PCAPNG_PACKET, 0, &b)); /* that of the earlier capture */
    assert_int_equal(ect_load_le32(b.body + 8), 0);
}

/* A flush is written in pieces of whole blocks, of an eighth of the limit or 64 KiB at most. The older half ends with
 * the first piece that reaches the middle. */
static void halves(void **state)
{
    static const half_t rows[] = {
        {"the middle is reached exactly", 65536, 2048, 15, 0, 0, 17},
        {"the middle is not reached", 65536, 2044, 15, 0, 0, 18},
        {"a piece of an eighth", 65536, 2048, 14, 4, 2048, 20},
        {"a full piece and another one", 65536, 2048, 14, 5, 2048, 20},
        {"more than an eighth", 65536, 2048, 14, 4, 2052, 19},
        {"a limit of 80 KiB", 81920, 2048, 18, 5, 2048, 25},
        {"more than 10 KiB", 81920, 2048, 18, 5, 2052, 24},
        {"a piece of 64 KiB", 1048576, 2048, 254, 32, 2048, 288},
        {"more than 64 KiB", 1048576, 2048, 254, 32, 2052, 287},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        removes_half(*state, &rows[i]);
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

/* In place of a thread, a flush writes. */
static void no_thread(void **state)
{
    rig_t *r = *state;
    const ect_capture_config_t config = config_of(r);
    sigset_t before, after;
    begin(r, &config);
    sigemptyset(&before);
    sigaddset(&before, SIGUSR2);
    assert_int_equal(pthread_sigmask(SIG_SETMASK, &before, NULL), 0);
    os.thread_fails = true;
    assert_false(ect_capture_start(r->capture));
    assert_int_equal(pthread_sigmask(SIG_SETMASK, NULL, &after), 0);
    assert_true(sigismember(&after, SIGUSR2) && !sigismember(&after, SIGUSR1));
    sigemptyset(&before);
    assert_int_equal(pthread_sigmask(SIG_SETMASK, &before, NULL), 0);
    assert_true(add(r, 1, FRAME));
    ect_capture_flush(r->capture);
    read_back(r);
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), 1);
    end(r, 0);
}

/* A signal to the process waits for the caller, which blocks it. */
static void signals(void **state)
{
    rig_t *r = *state;
    const ect_capture_config_t config = config_of(r);
    const struct timespec now = {0};
    sigset_t mask, one, pending;
    begin(r, &config);
    assert_true(ect_capture_start(r->capture));
    assert_int_equal(pthread_sigmask(SIG_SETMASK, NULL, &mask), 0);
    assert_false(sigismember(&mask, SIGUSR1));
    sigemptyset(&one);
    sigaddset(&one, SIGUSR1);
    assert_int_equal(pthread_sigmask(SIG_BLOCK, &one, NULL), 0);
    assert_int_equal(kill(getpid(), SIGUSR1), 0); /* would end the process in a thread that takes it */
    end(r, 0);
    assert_int_equal(sigpending(&pending), 0);
    assert_true(sigismember(&pending, SIGUSR1));
    assert_int_equal(sigtimedwait(&one, NULL, &now), SIGUSR1);
    assert_int_equal(pthread_sigmask(SIG_SETMASK, &mask, NULL), 0);
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

/* Numbers of all packets: each is there, in order. */
static void expect_packets(const rig_t *r, uint32_t first, size_t wanted)
{
    block_t b;
    assert_int_equal(count(r, ECT_PCAPNG_PACKET), wanted);
    for (size_t i = 0; i < wanted; i++) {
        assert_true(find(r, ECT_PCAPNG_PACKET, i, &b));
        assert_int_equal(ect_load_le32(b.body + 8), first + i);
        assert_memory_equal(b.body + 20, r->frame, FRAME);
    }
}

/* The writes that move the newer half over the older one are among them. */
static void short_writes(void **state)
{
    enum { FILL = ECT_CAPTURE_SMALLEST / 104, KEPT = FILL - 11, ALL = FILL + 10 }; /* a byte is left behind three */
    rig_t *r = *state;
    block_t b;
    ect_capture_config_t config = config_of(r);
    config.most = ECT_CAPTURE_SMALLEST;
    os.piece = 3;
    os.signals = 3;
    begin(r, &config);
    for (unsigned int i = 0; i < KEPT; i++) {
        assert_true(add(r, i, FRAME));
        if (i % 8 == 0)
            ect_capture_flush(r->capture);
    }
    ect_capture_flush(r->capture);
    read_back(r);
    expect_packets(r, 0, KEPT);
    for (unsigned int i = KEPT; i < ALL; i++)
        assert_true(add(r, i, FRAME));
    end(r, 0);
    assert_true(find(r, ECT_PCAPNG_PACKET, 0, &b));
    const uint32_t first = ect_load_le32(b.body + 8);
    assert_in_range(first, FILL / 2 - 100, FILL / 2 + 100);
    expect_packets(r, first, ALL - first);
}

/* The first write of the newer half over the older one fails; or each write takes no bytes. */
static void refused_writes(void **state)
{
    rig_t *r = *state;
    for (int i = 0; i < 2; i++) {
        ect_capture_config_t config = config_of(r);
        config.most = ECT_CAPTURE_SMALLEST;
        begin(r, &config);
        os.refused = size_of(r);
        bool added = true;
        for (unsigned int n = 0; n < 5000 && added; n++) {
            added = add(r, n, FRAME);
            ect_capture_flush(r->capture);
            os.refuses = i == 0;
            os.stops = i != 0;
        }
        os.refuses = os.stops = false;
        assert_false(added);
        end(r, EIO);
        assert_true(r->size <= ECT_CAPTURE_SMALLEST);
        if (i != 0)
            expect_packets(r, 0, 1);
    }
}

static void no_memory(void **state)
{
    rig_t *r = *state;
    const int input = fcntl(STDIN_FILENO, F_GETFD);
    const ect_capture_config_t config = config_of(r);
    for (int i = 0; i < 2; i++) {
        char message[ECT_CAPTURE_MESSAGE] = "", expected[ECT_CAPTURE_MESSAGE];
        os.calloc_fails = i == 0;
        os.malloc_fails = i != 0;
        ect_capture_t *c = ect_capture_open(&config, message);
        os.calloc_fails = os.malloc_fails = false;
        (void)snprintf(expected, sizeof expected, "cannot write '%s': not enough memory", r->path);
        assert_null(c);
        assert_string_equal(message, expected);
        assert_int_equal(fcntl(STDIN_FILENO, F_GETFD), input); /* no file was opened, and none is closed */
    }
    begin(r, &config);
    os.malloc_fails = true;
    const bool large = ect_capture_local(r->capture, r->frame, 1000),
               small = ect_capture_local(r->capture, r->frame, 5);
    os.malloc_fails = false;
    end(r, 0);
    assert_false(large);
    assert_true(small);
    assert_int_equal(count(r, ECT_PCAPNG_LOCAL), 1);
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
        int reason;
    } wrong[] = {
        {"/no/such/file", "cannot write '/no/such/file': No such file or directory", ENOENT},
        {"/dev/null", "cannot write '/dev/null': it is not a regular file", EINVAL},
        {"/tmp", "cannot write '/tmp': Is a directory", EISDIR},
    };
    char message[ECT_CAPTURE_MESSAGE];
    ect_capture_config_t config = config_of(r);
    const int before = open("/dev/null", O_RDONLY);
    close(before);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        config.path = wrong[i].path;
        ect_capture_t *c = ect_capture_open(&config, message);
        const int reason = errno;
        assert_null(c);
        assert_int_equal(reason, wrong[i].reason);
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

/* The standard input is closed, as a service may have it: the file gets descriptor 0. */
static void descriptor_0(void **state)
{
    rig_t *r = *state;
    char message[ECT_CAPTURE_MESSAGE] = "";
    ect_capture_config_t config = config_of(r);
    const int input = dup(STDIN_FILENO);
    (void)close(STDIN_FILENO);
    ect_capture_t *c = ect_capture_open(&config, message);
    const int flags = fcntl(STDIN_FILENO, F_GETFD);
    const int failed = c ? ect_capture_close(c, NULL, 0, 0) : -1;
    config.path = "/dev/null";
    ect_capture_t *wrong = ect_capture_open(&config, message);
    const int left = fcntl(STDIN_FILENO, F_GETFD);
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        (void)close(input);
    }
    assert_non_null(c);
    assert_int_equal(failed, 0);
    assert_int_equal(flags, FD_CLOEXEC); /* no program that the twin starts keeps the file open */
    assert_null(wrong);
    assert_int_equal(left, -1);
}

/* A letter for each run of blocks of one type. */
static const char *order_of(const rig_t *r)
{
    static char order[16];
    size_t at = 0, length = 0;
    block_t b;
    while (next(r, &at, &b)) {
        const char letter = b.type == ECT_PCAPNG_SECTION      ? 'S'
                            : b.type == ECT_PCAPNG_INTERFACE  ? 'I'
                            : b.type == ECT_PCAPNG_PACKET     ? 'P'
                            : b.type == ECT_PCAPNG_LOCAL      ? 'L'
                            : b.type == ECT_PCAPNG_STATISTICS ? 'T'
                                                              : '?';
        assert_true(length + 1 < sizeof order);
        if (length == 0 || order[length - 1] != letter)
            order[length++] = letter;
    }
    order[length] = '\0';
    return order;
}

/* The buffer is full before. */
static void last_data(void **state)
{
    rig_t *r = *state;
    for (size_t length = 0; length <= 2; length++) {
        ect_capture_config_t config = config_of(r);
        block_t b;
        config.offset_ns = 1;
        begin(r, &config);
        while (add(r, 1, FRAME))
            ;
        ect_capture_comment(r->capture, "end");
        assert_int_equal(ect_capture_close(r->capture, r->frame, length, 0x1000000FEull), 0);
        read_back(r);
        assert_string_equal(order_of(r), length > 0 ? "SIPLT" : "SIPT");
        assert_true(find(r, ECT_PCAPNG_STATISTICS, 0, &b));
        assert_int_equal(ect_load_le32(b.body + 4), 1);
        assert_int_equal(ect_load_le32(b.body + 8), 0xFF);
    }
}

/* First before the middle of the file is reached, then behind it. */
static void large_data(void **state)
{
    enum { LARGE = ECT_CAPTURE_SMALLEST / 2 + 6000 };
    rig_t *r = *state;
    block_t b;
    ect_capture_config_t config = config_of(r);
    uint8_t *data = calloc(1, LARGE);
    config.most = ECT_CAPTURE_SMALLEST;
    config.buffer = ECT_CAPTURE_SMALLEST;
    begin(r, &config);
    for (unsigned int i = 0; i < 14; i++)
        assert_true(add(r, i, 2000));
    ect_capture_flush(r->capture);
    data[LARGE - 1] = 1;
    for (unsigned int i = 0; i < 2; i++) {
        assert_true(ect_capture_local(r->capture, data, LARGE));
        ect_capture_flush(r->capture);
        read_back(r);
        assert_true(find(r, ECT_PCAPNG_LOCAL, 0, &b));
        assert_int_equal(b.body[LARGE - 1], 1);
        assert_string_equal(order_of(r), "SIL");
        assert_int_equal(count(r, ECT_PCAPNG_LOCAL), 1);
    }
    free(data);
    end(r, 0);
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
    memset(text, 0x80, sizeof text - 1); /* no character begins */
    text[sizeof text - 1] = 0;
    (void)ect_pcapng_statistics(block, 0, text);
    assert_int_equal(ect_load_le16(block + 22), 0);
    assert_int_equal(ect_pcapng_section(block, NULL), 28);
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
        CASE("a buffer is full when no byte is left", exactly_full),
        CASE("at the limit the older half goes; heads and newest frames stay", limit),
        CASE("a backlog is written in pieces that the limit takes", limit_and_backlog),
        CASE("the half that goes consists of whole pieces, in the last section alone", halves),
        CASE("with append each capture is a section of its own; without it the file is emptied", sections),
        CASE("a thread writes what is added, all of it", thread),
        CASE("without a thread each flush writes", no_thread),
        CASE("the thread takes no signals", signals),
        CASE("each flush wakes the thread", flush_wakes_the_thread),
        CASE("the file has the rights of the mask, and is no program", rights_of_the_file),
        CASE("a thread that has nothing to do ends", idle_thread_ends),
        CASE("frames that were dropped at the end are counted by the last block, which is there for that",
             dropped_at_the_end),
        CASE("writes of a few bytes, and writes that a signal interrupts, are continued", short_writes),
        CASE("a file that takes no bytes ends with an error", refused_writes),
        CASE("without memory no capture is opened, and no large data are added", no_memory),
        CASE("after a failed write frames are dropped, and the end reports the reason", failed_write),
        CASE("a file that another process shortens ends with an error", shortened),
        CASE("a file without room for its heads is refused with one line", heads_refused),
        CASE("a file that cannot be written gives one line", refused),
        CASE("a second capture does not touch the file of the first", taken),
        CASE("a capture may have descriptor 0", descriptor_0),
        CASE("the last data are behind the packets and before the comment", last_data),
        CASE("data of more than half the limit leave no packet", large_data),
        CASE("local data are blocks between the frames", local_data),
        CASE("a text is cut between characters", cut_text),
    };
    (void)signal(SIGXFSZ, SIG_IGN);
    return cmocka_run_group_tests_name("capture", tests, NULL, NULL);
}
